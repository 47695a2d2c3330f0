//! Damage: a short, sorted list of marks. It is the only state of an instance with the default rule.

use super::dent::Dent;
use super::energy::{energy_factor, is_gone, strength_alone};
use super::mark::Mark;
use crate::example::set::ExampleSet;
use std::cmp::Ordering;
use twox_hash::XxHash3_64;

/// The sorted marks of one instance and their dents.
#[derive(Debug, Clone, Default)]
pub(crate) struct Damage {
    marks: Vec<Mark>,
    dents: Vec<Dent>,
}

impl Damage {
    pub(crate) fn marks(&self) -> &[Mark] {
        &self.marks
    }

    /// A hash of the marks, so that equal marks have equal revisions on every machine; 0 without marks.
    pub(crate) fn revision(&self) -> u64 {
        if self.marks.is_empty() { 0 } else { XxHash3_64::oneshot(bytemuck::cast_slice(&self.marks)).max(1) }
    }

    pub(crate) fn dents(&self) -> &[Dent] {
        &self.dents
    }

    /// Adds new marks. They are sorted first, so the result does not depend on their order. If a mark with the same
    /// contact, depth and pairs exists, it takes the new mark's energy. Above `capacity` the weakest mark (smallest
    /// strength alone times depth) is removed. Its energy, converted by the ratio of depths, goes to the mark with the
    /// nearest contact. Ties go to the first mark in order.
    pub(crate) fn add(&mut self, set: &ExampleSet, mut new: Vec<Mark>, capacity: usize) {
        if new.is_empty() {
            return;
        }
        new.sort_unstable_by(|a, b| a.key().cmp(&b.key()).then(a.energy.cmp(&b.energy)));
        let mut marks = Vec::with_capacity(self.marks.len() + new.len());
        marks.extend(self.marks.iter().copied().zip(self.dents.iter().map(|dent| dent.alone)));
        let mut list = Merging { set, marks };
        for mark in new {
            list.add(mark);
            if list.marks.len() > capacity {
                list.merge_weakest();
            }
        }
        self.become_marks(set, list.marks.into_iter().map(|(mark, _)| mark).collect());
    }

    /// Replaces the marks by others, sorted. Reuses the dents of those that stay.
    fn become_marks(&mut self, set: &ExampleSet, marks: Vec<Mark>) {
        let before = std::mem::take(self);
        let mut entries: Vec<Entry> = Vec::with_capacity(before.marks.len() + marks.len());
        walk(&before.marks, &marks, |mark, old, new| {
            entries.push(Entry {
                dent: old.map_or_else(|| Dent::new(set, mark), |at| before.dents[at].clone()),
                before: old.map_or(0, |at| before.marks[at].energy),
                after: new.map_or(0, |at| marks[at].energy),
            });
        });
        update_nearby(set, &mut entries);
        self.dents = entries.into_iter().filter(|e| e.after > 0).map(|e| e.dent).collect();
        self.dents.iter_mut().zip(&marks).for_each(|(dent, mark)| dent.settle(set, mark));
        self.marks = marks;
    }

    /// Replaces all marks by others, which must be valid.
    pub(crate) fn replace(&mut self, set: &ExampleSet, marks: Vec<Mark>, capacity: usize) {
        *self = Damage::default();
        self.add(set, marks, capacity);
    }

    /// Multiplies the strength that each dent has alone by `keep` of its mark, 0 to 1. Removes marks whose strength alone
    /// falls below a ten-thousandth. Marks that keep 1 do not change.
    pub(crate) fn scale(&mut self, set: &ExampleSet, keep: impl Fn(&Mark) -> f64) {
        let scaled = |m: &Mark| {
            let keep = keep(m);
            let energy = (m.energy as f64 * energy_factor(keep)) as u64;
            if keep >= 1.0 { Some(*m) } else { (!is_gone(energy)).then_some(Mark { energy, ..*m }) }
        };
        let marks = self.marks.iter().filter_map(scaled).collect();
        self.become_marks(set, marks);
    }

    /// Calls `f` for every mark that is in this list or the other, in order, with how strongly each shows its dent.
    pub(crate) fn compare(&self, other: &Damage, mut f: impl FnMut(&Mark, f32, f32)) {
        let strength = |list: &Damage, at: Option<usize>| at.map_or(0.0, |at| list.dents[at].strength);
        walk(&self.marks, &other.marks, |mark, a, b| f(mark, strength(self, a), strength(other, b)));
    }

    /// These dents, with other strengths for some of them, or others beside them. `others` are sorted by mark.
    pub(crate) fn shown_as(&self, set: &ExampleSet, others: &[(Mark, f32)]) -> Damage {
        let marks: Vec<Mark> = others.iter().map(|(mark, _)| *mark).collect();
        let mut all = Damage::default();
        walk(&marks, &self.marks, |mark, other, own| {
            let strength = other.map(|at| others[at].1);
            if strength == Some(0.0) {
                return;
            }
            let alone = || {
                let mut dent = Dent::new(set, mark);
                dent.settle(set, mark);
                dent
            };
            let mut dent = own.map_or_else(alone, |own| self.dents[own].clone());
            dent.strength = strength.unwrap_or(dent.strength);
            all.dents.push(dent);
            all.marks.push(*mark);
        });
        all
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.marks.len() * size_of::<Mark>() + self.dents.iter().map(Dent::memory_bytes).sum::<usize>()
    }
}

/// A dent while the marks change. The energies of its mark are 0 where the mark is not in the list.
struct Entry {
    dent: Dent,
    before: u64,
    after: u64,
}

impl Entry {
    fn has_changed(&self) -> bool {
        self.before != self.after
    }
}

/// Calls `f` for every mark that is in either sorted list, in order, with its index in each. A mark in both is that of `b`.
pub(crate) fn walk(a: &[Mark], b: &[Mark], mut f: impl FnMut(&Mark, Option<usize>, Option<usize>)) {
    let (mut i, mut j) = (0, 0);
    while i < a.len() || j < b.len() {
        let order = match (a.get(i), b.get(j)) {
            (Some(x), Some(y)) => x.key().cmp(&y.key()),
            (Some(_), None) => Ordering::Less,
            (None, _) => Ordering::Greater,
        };
        let mark = if order.is_ge() { &b[j] } else { &a[i] };
        f(mark, order.is_le().then_some(i), order.is_ge().then_some(j));
        i += usize::from(order.is_le());
        j += usize::from(order.is_ge());
    }
}

/// Updates what each dent knows of the marks near it. Takes two look-ups for each pair of a changed mark and another.
fn update_nearby(set: &ExampleSet, entries: &mut [Entry]) {
    for i in 0..entries.len() {
        if !entries[i].has_changed() {
            continue;
        }
        for j in 0..entries.len() {
            // A pair of two changed marks comes once.
            if j == i || j < i && entries[j].has_changed() {
                continue;
            }
            let overlap = entries[i].dent.overlap(set, &entries[j].dent);
            if overlap > 0.0 {
                let Ok([a, b]) = entries.get_disjoint_mut([i, j]) else { continue };
                // A new dent knows nothing of the others yet.
                a.dent.change(&b.dent, overlap, if a.before > 0 { b.before } else { 0 }, b.after);
                b.dent.change(&a.dent, overlap, if b.before > 0 { a.before } else { 0 }, a.after);
            }
        }
    }
}

/// The marks while new ones are added. Dents are made later, when it is known which marks stay.
struct Merging<'a> {
    set: &'a ExampleSet,
    /// Each with the strength that it would have alone.
    marks: Vec<(Mark, f32)>,
}

impl Merging<'_> {
    fn add(&mut self, mark: Mark) {
        match self.marks.binary_search_by(|(m, _)| m.key().cmp(&mark.key())) {
            Ok(at) => self.add_energy(at, mark.energy),
            Err(at) => self.marks.insert(at, (mark, strength_alone(mark.energy))),
        }
    }

    fn add_energy(&mut self, at: usize, energy: u64) {
        let (mark, strength) = &mut self.marks[at];
        mark.energy = mark.energy.saturating_add(energy);
        *strength = strength_alone(mark.energy);
    }

    fn merge_weakest(&mut self) {
        let size = |i: usize| self.marks[i].1 * self.marks[i].0.depth;
        let weakest = (0..self.marks.len()).fold(0, |best, i| if size(i) < size(best) { i } else { best });
        let (gone, _) = self.marks.remove(weakest);
        let positions = self.set.mesh().positions();
        let distance = |i: usize| {
            (positions[self.marks[i].0.contact as usize] - positions[gone.contact as usize]).length_squared()
        };
        let heir = (0..self.marks.len()).reduce(|best, i| if distance(i) < distance(best) { i } else { best });
        if let Some(heir) = heir {
            let ratio = f64::from(gone.depth) / f64::from(self.marks[heir].0.depth);
            // `as` saturates, and u64 as f64 rounds to nearest. Both are the same on every platform.
            self.add_energy(heir, (gone.energy as f64 * energy_factor(ratio)) as u64);
        }
    }
}
