//! Records when each block last changed.

use crate::example::set::ExampleSet;

/// When each block last changed.
#[derive(Debug)]
pub(crate) struct Changes {
    /// Unique to the instance, so that an output detects when it is used with another one.
    pub instance: u64,
    /// Increases with each change.
    pub epoch: u64,
    /// For each mesh of the set, the epoch of each block's last change. 0 if the block never changed.
    pub blocks: Vec<Vec<u64>>,
}

impl Changes {
    /// Marks the blocks with vertices that follow some nodes of a group, at the last epoch. `nodes` has a bit for each.
    pub(crate) fn nodes(&mut self, set: &ExampleSet, group: usize, nodes: u32) {
        for (mesh, blocks) in set.nodes().followers.iter().zip(&mut self.blocks) {
            let changed = mesh.of(group).iter().filter(|(_, followed)| followed & nodes != 0);
            changed.for_each(|(b, _)| blocks[*b as usize] = self.epoch);
        }
    }

    /// Marks all blocks of the base mesh that an example moves where it was made, at the last epoch.
    pub(crate) fn example(&mut self, set: &ExampleSet, example: usize) {
        if let Some(blocks) = self.blocks.first_mut() {
            set.base_lod().anchored[example].blocks().for_each(|b| blocks[b as usize] = self.epoch);
        }
    }

    /// Marks all blocks, at a new epoch.
    pub(crate) fn everything(&mut self) {
        self.epoch += 1;
        self.blocks.iter_mut().for_each(|b| b.fill(self.epoch));
    }
}
