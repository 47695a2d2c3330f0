//! Sums of carried examples, kept for an output whose instance is being hit.
//!
//! A hit changes its own dent and those near it, a few of many. Contributions of carried examples are whole steps
//! ([`super::kernel::CarriedSums`]), so those of the dents before the hit can be taken away from the sums at each vertex, and
//! those of the dents after it added. The vertices have the same bits as if all dents were summed anew.

use super::kernel::CarriedSums;
use super::memory::Scattered;
use super::view::DamageView;
use crate::base::error::reserve;
use crate::damage::dent::{Dent, Reach};
use crate::damage::list::Damage;
use crate::mesh::vertex_blocks::BLOCK;

/// Fewer dents are summed anew as fast.
const LEAST_DENTS: usize = 8;
/// After this many calls in a row without a change, the memory is given back.
const IDLE_CALLS: u32 = 256;

/// The sums of a block, if it was written since they are kept.
#[derive(Debug, Clone)]
pub(crate) struct BlockSums {
    pub known: bool,
    pub sums: CarriedSums,
}

impl BlockSums {
    pub(crate) const UNKNOWN: BlockSums = BlockSums { known: false, sums: [[0; BLOCK]; 6] };
}

/// The sums at all vertices of an output.
#[derive(Debug, Clone)]
pub(super) struct KeptSums {
    instance: u64,
    lod: usize,
    normals: bool,
    threshold: f32,
    coarse: f32,
    /// The damage that the sums show.
    shown: Damage,
    blocks: Vec<BlockSums>,
    idle: u32,
}

/// A dent that changed, with the sign of its contribution to the sums.
pub(crate) struct ChangedDent<'a> {
    pub dent: &'a Dent,
    pub reach: Reach,
    pub sign: f32,
}

/// What brings an output's sums up to date.
pub(super) struct Update<'a> {
    pub dents: Vec<ChangedDent<'a>>,
    pub blocks: Scattered<'a, BlockSums>,
}

impl KeptSums {
    /// The sums to use for an output that is about to be written: those that it has, new ones, or none if they do not pay or
    /// there is no memory for them.
    pub(super) fn renewed(
        old: Option<Box<Self>>,
        view: &DamageView<'_>,
        lod: usize,
        normals: bool,
    ) -> Option<Box<Self>> {
        let dents = view.damage.dents();
        let direct = view.vertices.is_none() && view.nodes.is_none();
        let pays = dents.len() >= LEAST_DENTS && direct && dents.iter().any(|dent| dent.lookups() > 0);
        if !pays {
            return None;
        }
        let instance = view.changes.instance;
        let fits = |kept: &Self| {
            (kept.instance, kept.lod, kept.normals) == (instance, lod, normals)
                && (kept.threshold, kept.coarse) == (view.threshold, view.coarse)
        };
        if let Some(kept) = old.filter(|kept| fits(kept)) {
            return Some(kept);
        }
        let count = view.changes.blocks[lod].len();
        let mut blocks = reserve(count, "kept sums").ok()?;
        blocks.resize(count, BlockSums::UNKNOWN);
        let (shown, threshold, coarse) = (Damage::default(), view.threshold, view.coarse);
        Some(Box::new(KeptSums { instance, lod, normals, threshold, coarse, shown, blocks, idle: 0 }))
    }

    /// What leads from the damage that the sums show to another.
    pub(super) fn update<'a>(&'a mut self, to: &'a Damage) -> Update<'a> {
        let mut dents = Vec::new();
        let mut add = |dent: &'a Dent, sign| {
            if dent.lookups() > 0 {
                dents.push(ChangedDent { dent, reach: dent.reach(), sign });
            }
        };
        self.shown.changed(to, |from, to| {
            from.into_iter().for_each(|dent| add(dent, -1.0));
            to.into_iter().for_each(|dent| add(dent, 1.0));
        });
        Update { dents, blocks: Scattered::new(&mut self.blocks) }
    }

    /// Records that the blocks that changed were written.
    pub(super) fn shows(&mut self, damage: &Damage) {
        self.shown = damage.clone();
        self.idle = 0;
    }

    /// Records a call without a change. Returns whether the sums should be kept on.
    pub(super) fn rests(&mut self) -> bool {
        self.idle += 1;
        self.idle < IDLE_CALLS
    }
}
