//! What one output already holds, so that only changed blocks are written.

use crate::base::math::Aabb;
use crate::damage::changes::Changes;
use crate::mesh::vertex_blocks::block_range;
use std::ops::Range;

/// Records which blocks of which instance one output's memory holds, and as of which epoch. Keep one tracker for each
/// piece of memory, such as each buffer of a ring of three. If anything else writes to the memory, call
/// [`Tracker::invalidate`].
#[derive(Debug, Clone, Default)]
pub struct Tracker {
    /// Instance and epoch written last; instance 0 is none.
    instance: u64,
    lod: usize,
    epoch: u64,
    block_bounds: Vec<Aabb>,
    changed: Vec<Range<u32>>,
    /// Around the vertices of `changed`, before and after the last write.
    changed_bounds: Option<Aabb>,
    bounds: Option<Aabb>,
    /// Calls in a row that had to leave it out.
    pub(crate) calls_waited: u32,
}

impl Tracker {
    /// A tracker for memory that holds nothing yet: the first deform writes every vertex.
    pub fn new() -> Self {
        Self::default()
    }

    /// Forgets what the memory holds: the next deform writes every vertex.
    pub fn invalidate(&mut self) {
        self.instance = 0;
    }

    /// The vertices that the last deform wrote, as increasing ranges with gaps between them.
    pub fn changed(&self) -> &[Range<u32>] {
        &self.changed
    }

    /// A box around the vertices of [`Tracker::changed`], as they were before the last deform and as they are now, m: what
    /// partial refits of bounding volume hierarchies take. `None` if the last deform wrote nothing.
    pub fn changed_bounds(&self) -> Option<Aabb> {
        self.changed_bounds.filter(|_| !self.changed.is_empty())
    }

    /// The triangles with a vertex of [`Tracker::changed`], as increasing ranges with gaps between them. `triangles` are
    /// those of the mesh that was written. The time is linear in their number.
    pub fn changed_triangles(&self, triangles: &[[u32; 3]]) -> Vec<Range<u32>> {
        let written = |v: &u32| {
            let at = self.changed.partition_point(|r| r.end <= *v);
            self.changed.get(at).is_some_and(|r| r.start <= *v)
        };
        let mut found = Vec::new();
        for (i, _) in triangles.iter().enumerate().filter(|(_, t)| t.iter().any(written)) {
            add(&mut found, i..i + 1);
        }
        found
    }

    /// Bounds of all vertices as of the last deform, m; `None` before the first.
    pub fn bounds(&self) -> Option<Aabb> {
        self.bounds
    }

    /// The blocks of a level of detail that must be written, in increasing order.
    pub(crate) fn dirty<'a>(&self, changes: &'a Changes, lod: usize) -> impl Iterator<Item = usize> + 'a {
        let since = self.since(changes, lod);
        let blocks = if since == Some(changes.epoch) { &[][..] } else { &changes.blocks[lod][..] };
        blocks.iter().enumerate().filter(move |(_, at)| since.is_none_or(|s| **at > s)).map(|(b, _)| b)
    }

    /// The epoch of the memory's contents, if it holds this instance's level of detail.
    pub(crate) fn since(&self, changes: &Changes, lod: usize) -> Option<u64> {
        (self.instance == changes.instance && self.lod == lod).then_some(self.epoch)
    }

    /// Records that these blocks (second of each pair; increasing) were written, and their bounds.
    pub(crate) fn written(
        &mut self,
        (changes, lod, vertices): (&Changes, usize, usize),
        blocks: &[(u32, u32)],
        bounds: &[Aabb],
    ) {
        self.changed.clear();
        if !blocks.is_empty() {
            self.block_bounds.resize(changes.blocks[lod].len(), Aabb::EMPTY);
            let mut around = Aabb::EMPTY;
            for ((_, b), bound) in blocks.iter().zip(bounds) {
                let before = std::mem::replace(&mut self.block_bounds[*b as usize], *bound);
                around.union(&before);
                around.union(bound);
                add(&mut self.changed, block_range(*b as usize, vertices));
            }
            let mut all = Aabb::EMPTY;
            self.block_bounds.iter().for_each(|b| all.union(b));
            self.bounds = Some(all);
            self.changed_bounds = Some(around);
        }
        self.holds(changes, lod);
    }

    /// Records that nothing was written.
    pub(crate) fn unchanged(&mut self) {
        self.changed.clear();
    }

    /// Records that there was no time to write it.
    pub(crate) fn waits(&mut self) {
        self.changed.clear();
        self.calls_waited = self.calls_waited.saturating_add(1);
    }

    /// Records that these dirty blocks will be written elsewhere than on the CPU, and that `bounds` will hold all
    /// vertices. Returns the number of vertices written.
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
        self.calls_waited = 0;
        self.instance = changes.instance;
        self.lod = lod;
        self.epoch = changes.epoch;
    }
}

/// Adds a range, which must begin at or after the end of the last one. Ranges that touch are merged.
fn add(ranges: &mut Vec<Range<u32>>, r: Range<usize>) {
    match ranges.last_mut() {
        Some(last) if last.end == r.start as u32 => last.end = r.end as u32,
        _ => ranges.push(r.start as u32..r.end as u32),
    }
}
