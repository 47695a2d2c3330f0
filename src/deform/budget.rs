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
    /// How much waiting for it would be seen. `None` if its memory does not hold the instance at all: it cannot wait.
    importance: Option<f64>,
}

impl Due {
    /// `None` for an output that is up to date.
    pub(crate) fn new(output: usize, tracker: &Tracker, view: &DamageView<'_>, lod: usize) -> Option<Self> {
        let count = view.set.lods().nth(lod).map_or(0, MeshLod::vertex_count);
        let vertices = tracker.dirty(view.changes, lod).map(|block| block_range(block, count).len() as u64).sum();
        // The area on the screen grows with the vertices and falls with the square of the distance, as does the inverse
        // square of a length that is some share of a pixel. Waiting makes up for distance.
        let near = (f64::from(tracker.calls_waited) + 1.0) / f64::from(view.unseen.max(EXACT));
        let importance = vertices as f64 * near * near;
        let holds = tracker.since(view.changes, lod).is_some();
        (vertices > 0).then_some(Due { output, vertices, importance: holds.then_some(importance) })
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
    let written = within(budget, &mut due);
    let mut waiting = due.split_off(written);
    waiting.sort_unstable_by_key(|d| d.output);
    waiting
}

/// Sorts the outputs by importance, those that cannot wait first, and returns how many of them are written.
fn within(budget: u64, due: &mut [Due]) -> usize {
    let first = |d: &Due| d.importance.unwrap_or(f64::INFINITY);
    due.sort_by(|a, b| first(b).total_cmp(&first(a)));
    let mut all = 0u64;
    let written = due.iter().take_while(|d| {
        all += d.vertices;
        d.importance.is_none() || all <= budget
    });
    written.count().max(1).min(due.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn due(output: usize, vertices: u64, importance: Option<f64>) -> Due {
        Due { output, vertices, importance }
    }

    fn order(budget: u64, mut all: Vec<Due>) -> Vec<usize> {
        let count = within(budget, &mut all);
        all[..count].iter().map(|d| d.output).collect()
    }

    #[test]
    fn the_most_important_are_written_and_what_holds_nothing_never_waits() {
        let all = || vec![due(0, 300, Some(1.0)), due(1, 300, Some(3.0)), due(2, 900, None), due(3, 200, Some(2.0))];
        assert_eq!(order(0, all()), [2]);
        assert_eq!(order(1199, all()), [2]);
        assert_eq!(order(1200, all()), [2, 1]);
        assert_eq!(order(u64::MAX, all()), [2, 1, 3, 0]);
        assert_eq!(order(1, vec![due(0, 300, Some(1.0)), due(1, 300, Some(1.0))]), [0]);
        assert!(order(1, Vec::new()).is_empty());
    }
}
