//! What one output holds already, so that only what changed is written.

use crate::base::math::Aabb;
use crate::damage::changes::Changes;
use crate::mesh::vertex_blocks::block_range;
use std::ops::Range;

/// The memory of one output: which blocks of which instance it holds, as of when. Keep one for each piece of memory (each
/// of a ring of three, say); whoever else writes there must say so with [`Tracker::invalidate`].
#[derive(Debug, Clone, Default)]
pub struct Tracker {
    /// Instance and epoch written last; instance 0 is none.
    instance: u64,
    lod: usize,
    epoch: u64,
    block_bounds: Vec<Aabb>,
    changed: Vec<Range<u32>>,
    bounds: Option<Aabb>,
}

impl Tracker {
    /// Of memory that holds nothing yet: the first deform writes every vertex.
    pub fn new() -> Self {
        Self::default()
    }

    /// Forgets: the next deform writes every vertex.
    pub fn invalidate(&mut self) {
        self.instance = 0;
    }

    /// Vertices that the last deform wrote: ranges, increasing, apart from each other.
    pub fn changed(&self) -> &[Range<u32>] {
        &self.changed
    }

    /// Bounds of all vertices as of the last deform, m; `None` before the first.
    pub fn bounds(&self) -> Option<Aabb> {
        self.bounds
    }

    /// Blocks of a level of detail that must be written, increasing.
    pub(crate) fn dirty<'a>(&self, changes: &'a Changes, lod: usize) -> impl Iterator<Item = usize> + 'a {
        let since = self.since(changes, lod);
        let blocks = if since == Some(changes.epoch) { &[][..] } else { &changes.blocks[lod][..] };
        blocks.iter().enumerate().filter(move |(_, at)| since.is_none_or(|s| **at > s)).map(|(b, _)| b)
    }

    /// The epoch as of which it holds this instance's level of detail, if it holds that.
    pub(crate) fn since(&self, changes: &Changes, lod: usize) -> Option<u64> {
        (self.instance == changes.instance && self.lod == lod).then_some(self.epoch)
    }

    /// Notes that these blocks (second of each pair; increasing) were written and have these bounds.
    pub(crate) fn written(
        &mut self,
        (changes, lod, vertices): (&Changes, usize, usize),
        blocks: &[(u32, u32)],
        bounds: &[Aabb],
    ) {
        self.changed.clear();
        if !blocks.is_empty() {
            self.block_bounds.resize(changes.blocks[lod].len(), Aabb::EMPTY);
            for ((_, b), bound) in blocks.iter().zip(bounds) {
                self.block_bounds[*b as usize] = *bound;
                add(&mut self.changed, block_range(*b as usize, vertices));
            }
            let mut all = Aabb::EMPTY;
            self.block_bounds.iter().for_each(|b| all.union(b));
            self.bounds = Some(all);
        }
        self.holds(changes, lod);
    }

    /// Notes that nothing is written.
    #[cfg(feature = "gpu")]
    pub(crate) fn unchanged(&mut self) {
        self.changed.clear();
    }

    /// Notes that these blocks, the dirty ones, will be written elsewhere than on the CPU, and that all vertices then lie in a box.
    /// Answers how many vertices are written.
    #[cfg(feature = "gpu")]
    pub(crate) fn recorded(
        &mut self,
        (changes, lod, vertices): (&Changes, usize, usize),
        blocks: impl Iterator<Item = usize>,
        bounds: Aabb,
    ) -> u64 {
        self.changed.clear();
        blocks.for_each(|b| add(&mut self.changed, block_range(b, vertices)));
        self.bounds = Some(bounds);
        self.holds(changes, lod);
        self.changed.iter().map(|r| u64::from(r.end - r.start)).sum()
    }

    fn holds(&mut self, changes: &Changes, lod: usize) {
        self.instance = changes.instance;
        self.lod = lod;
        self.epoch = changes.epoch;
    }
}

/// Adds a range that begins where the last one ends, or later.
fn add(ranges: &mut Vec<Range<u32>>, r: Range<usize>) {
    match ranges.last_mut() {
        Some(last) if last.end == r.start as u32 => last.end = r.end as u32,
        _ => ranges.push(r.start as u32..r.end as u32),
    }
}
