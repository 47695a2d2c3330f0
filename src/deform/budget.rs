//! The vertex budget: which outputs a call writes when it may not write all of them.
//!
//! An output is written whole or not at all, so no body ever shows half of a dent. What waits is written by later calls,
//! with the bits that it would have had: vertices depend on marks alone, not on when they are written.

use super::tracker::Tracker;
use super::view::DamageView;
use crate::example::mesh_lod::MeshLod;
use crate::mesh::vertex_blocks::block_range;

/// Counts as the error that is not seen where that is not known, m.
const EXACT: f32 = 1.0 / 4096.0;

/// An output that has something to write.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Due {
    /// The caller's index of it.
    pub output: usize,
    /// Vertices to write.
    pub vertices: u64,
    /// How much waiting for it would be seen. Infinite if its memory does not hold the instance at all: it cannot wait.
    importance: f64,
}

impl Due {
    /// `None` for an output that is up to date.
    pub(crate) fn new(output: usize, tracker: &Tracker, view: &DamageView<'_>, lod: usize) -> Option<Self> {
        let count = view.set.lods().nth(lod).map_or(0, MeshLod::vertex_count);
        let vertices = tracker.dirty(view.changes, lod).map(|block| block_range(block, count).len() as u64).sum();
        // The area on the screen grows with the vertices and falls with the square of the distance, as does the inverse
        // square of a length that is some share of a pixel. Waiting makes up for distance.
        let near = (f64::from(tracker.calls_waited) + 1.0) / f64::from(view.unseen.max(EXACT));
        let holds = tracker.since(view.changes, lod).is_some();
        let importance = if holds { vertices as f64 * near * near } else { f64::INFINITY };
        (vertices > 0).then_some(Due { output, vertices, importance })
    }
}

/// The outputs that wait, by index. Those that do not are the most important ones with no more than `budget` vertices in
/// all, at least one, and all that cannot wait. Among equals the first are written.
pub(crate) fn waiting<'a>(
    budget: u64,
    outputs: impl Iterator<Item = (&'a Tracker, &'a DamageView<'a>, usize)>,
) -> Vec<Due> {
    if budget == u64::MAX {
        return Vec::new();
    }
    let due = outputs.enumerate().filter_map(|(output, (tracker, view, lod))| Due::new(output, tracker, view, lod));
    let mut due: Vec<Due> = due.collect();
    due.sort_by(|a, b| b.importance.total_cmp(&a.importance));
    let mut all = 0u64;
    let fits = |d: &&Due| {
        all += d.vertices;
        d.importance == f64::INFINITY || all <= budget
    };
    let written = due.iter().take_while(fits).count().max(1).min(due.len());
    let mut waiting = due.split_off(written);
    waiting.sort_unstable_by_key(|d| d.output);
    waiting
}
