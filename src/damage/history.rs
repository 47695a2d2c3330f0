//! Revisions of marks, and what changed since an earlier one.
//!
//! A revision is a hash of the marks. So equal marks have equal revisions on every machine, whatever led to them, and
//! whoever gets a change can tell whether it fits.

use super::list::walk;
use super::mark::Mark;
use std::collections::VecDeque;
use twox_hash::XxHash3_64;

/// The most changed marks that are remembered. Older changes are forgotten.
const LIMIT: usize = 256;

/// The revision of sorted marks; 0 without marks.
pub(crate) fn revision(marks: &[Mark]) -> u64 {
    if marks.is_empty() { 0 } else { XxHash3_64::oneshot(bytemuck::cast_slice(marks)).max(1) }
}

/// The last changes of an instance's marks.
#[derive(Debug, Clone, Default)]
pub(crate) struct History {
    /// The marks after the last change.
    now: Vec<Mark>,
    /// The latest change at the end.
    steps: VecDeque<Step>,
    /// Number of marks in `steps`.
    entries: usize,
}

/// A change of the marks.
#[derive(Debug, Clone)]
struct Step {
    /// The revision before.
    from: u64,
    /// The marks that changed; their energies have no meaning.
    changed: Vec<Mark>,
}

impl History {
    /// Begins with these marks.
    pub(crate) fn new(marks: &[Mark]) -> Self {
        History { now: marks.to_vec(), ..History::default() }
    }

    /// Remembers what changed since the last call.
    pub(crate) fn record(&mut self, marks: &[Mark]) {
        let changed = differences(&self.now, marks);
        if changed.is_empty() {
            return;
        }
        self.entries += changed.len();
        self.steps.push_back(Step { from: revision(&self.now), changed });
        self.now.clear();
        self.now.extend_from_slice(marks);
        while self.entries > LIMIT {
            self.entries -= self.steps.pop_front().map_or(self.entries, |step| step.changed.len());
        }
    }

    /// The marks that changed since a revision, sorted, with their present energy; 0 for those that are gone. `None` if
    /// the revision is not remembered.
    pub(crate) fn since(&self, from: u64) -> Option<Vec<Mark>> {
        if from == revision(&self.now) {
            return Some(Vec::new());
        }
        let first = self.steps.iter().rposition(|step| step.from == from)?;
        let mut changed: Vec<Mark> = self.steps.range(first..).flat_map(|step| &step.changed).copied().collect();
        changed.sort_unstable_by_key(Mark::key);
        changed.dedup_by_key(|mark| mark.key());
        for mark in &mut changed {
            let at = self.now.binary_search_by_key(&mark.key(), Mark::key);
            mark.energy = at.map_or(0, |at| self.now[at].energy);
        }
        Some(changed)
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        (self.now.len() + self.entries) * size_of::<Mark>() + self.steps.len() * size_of::<Step>()
    }
}

/// The marks that are in only one of two sorted lists, or have another energy there.
fn differences(a: &[Mark], b: &[Mark]) -> Vec<Mark> {
    let mut found = Vec::new();
    walk(a, b, |i, j| {
        let (a, b) = (i.map(|i| a[i]), j.map(|j| b[j]));
        if a != b {
            found.extend(b.or(a));
        }
    });
    found
}

/// Applies changes, sorted, to sorted marks.
pub(crate) fn applied(marks: &[Mark], changes: &[Mark]) -> Vec<Mark> {
    let mut all = Vec::with_capacity(marks.len() + changes.len());
    walk(marks, changes, |i, j| all.extend(j.map(|j| changes[j]).or(i.map(|i| marks[i]))));
    all.retain(|mark| mark.energy > 0);
    all
}
