//! Which blocks changed when.

use super::dent::Dent;
use crate::example::set::ExampleSet;

/// When each block last changed.
#[derive(Debug)]
pub(crate) struct Changes {
    /// Of this instance alone, so that an output notices when it is given another.
    pub instance: u64,
    /// Grows with each change.
    pub epoch: u64,
    /// Of each level of detail the epoch of the last change of each block; 0 for a block at rest since the beginning.
    pub blocks: Vec<Vec<u64>>,
}

/// Notes blocks as changed, at an epoch of its own.
pub(crate) struct ChangeRecorder<'a> {
    set: &'a ExampleSet,
    pub changes: &'a mut Changes,
    /// Displacements no longer than this do not show, m.
    threshold: f32,
}

impl<'a> ChangeRecorder<'a> {
    pub(crate) fn new(set: &'a ExampleSet, changes: &'a mut Changes, threshold: f32) -> Self {
        changes.epoch += 1;
        ChangeRecorder { set, changes, threshold }
    }

    pub(crate) fn dent(&mut self, d: &Dent) {
        for (lod, blocks) in self.set.lods().zip(&mut self.changes.blocks) {
            d.blocks(self.set, lod, self.threshold, |b| blocks[b] = self.changes.epoch);
        }
    }

    /// All that an anchored example moves.
    pub(crate) fn example(&mut self, example: usize) {
        for (lod, blocks) in self.set.lods().zip(&mut self.changes.blocks) {
            lod.anchored[example].blocks().for_each(|b| blocks[b as usize] = self.changes.epoch);
        }
    }

    pub(crate) fn everything(&mut self) {
        self.changes.blocks.iter_mut().for_each(|b| b.fill(self.changes.epoch));
    }
}
