//! Records when each block last changed.

use super::dent::Dent;
use crate::example::set::ExampleSet;

/// When each block last changed.
#[derive(Debug)]
pub(crate) struct Changes {
    /// Unique to the instance, so that an output detects when it is used with another one.
    pub instance: u64,
    /// Increases with each change.
    pub epoch: u64,
    /// Factor of the steps that dents are summed in: see `DamageView::coarse`. When it changes, every block does.
    pub coarse: f32,
    /// Whether meshes with rows follow the set's nodes.
    pub follows: bool,
    /// For each level of detail, and last the nodes, the epoch of each block's last change. 0 if the block never changed.
    pub blocks: Vec<Vec<u64>>,
}

/// Marks blocks as changed, at a new epoch.
pub(crate) struct ChangeRecorder<'a> {
    set: &'a ExampleSet,
    pub changes: &'a mut Changes,
    /// Displacements no longer than this are not shown, m.
    threshold: f32,
}

impl<'a> ChangeRecorder<'a> {
    pub(crate) fn new(set: &'a ExampleSet, changes: &'a mut Changes, threshold: f32) -> Self {
        changes.epoch += 1;
        Self::at(set, changes, threshold)
    }

    /// The same at the last epoch.
    pub(crate) fn at(set: &'a ExampleSet, changes: &'a mut Changes, threshold: f32) -> Self {
        ChangeRecorder { set, changes, threshold }
    }

    pub(crate) fn dent(&mut self, d: &Dent) {
        for (lod, blocks) in self.set.marked().zip(&mut self.changes.blocks) {
            // Where vertices follow nodes, the nodes that changed mark them.
            if lod.rows.is_some() && self.changes.follows {
                continue;
            }
            d.mark_blocks(lod, self.threshold, blocks, self.changes.epoch);
        }
    }

    /// Marks all blocks that an anchored example moves.
    pub(crate) fn example(&mut self, example: usize) {
        for (lod, blocks) in self.set.marked().zip(&mut self.changes.blocks) {
            lod.anchored[example].blocks().for_each(|b| blocks[b as usize] = self.changes.epoch);
        }
    }

    /// Marks the blocks with vertices that follow these nodes.
    pub(crate) fn nodes(&mut self, nodes: &[u32]) {
        let followers = self.set.nodes().map_or(&[][..], |all| all.followers());
        for (mesh, blocks) in followers.iter().zip(&mut self.changes.blocks) {
            for node in nodes {
                mesh.of(*node).iter().for_each(|b| blocks[*b as usize] = self.changes.epoch);
            }
        }
    }

    pub(crate) fn everything(&mut self) {
        self.changes.blocks.iter_mut().for_each(|b| b.fill(self.changes.epoch));
    }
}
