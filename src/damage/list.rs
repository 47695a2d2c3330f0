//! Damage: a short, sorted list of marks. It is the only state of an instance with the default rule.

use super::dent::Dent;
use super::energy::{energy_factor, is_gone, strength_alone};
use super::mark::Mark;
use super::overlap::{change, dent_alone, overlap, settle};
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
        let most = self.marks.len() + new.len();
        let (mut marks, mut strengths) = (Vec::with_capacity(most), Vec::with_capacity(most));
        marks.extend_from_slice(&self.marks);
        strengths.extend(self.dents.iter().map(|d| d.alone));
        let mut list = Merging { set, marks, strengths };
        for mark in new {
            list.add(mark);
            if list.marks.len() > capacity {
                list.merge_weakest();
            }
        }
        self.become_marks(set, list.marks);
    }

    /// Replaces the marks by others, sorted. Reuses the dents of those that stay.
    fn become_marks(&mut self, set: &ExampleSet, marks: Vec<Mark>) {
        let before = std::mem::take(self);
        let mut entries: Vec<Entry> = Vec::with_capacity(before.marks.len() + marks.len());
        walk(&before.marks, &marks, |old, new| {
            let energy = |marks: &[Mark], at: Option<usize>| at.map_or(0, |at| marks[at].energy);
            let dent = match (old, new) {
                (Some(old), _) => before.dents[old].clone(),
                (None, new) => dent_alone(set, &marks[new.unwrap_or(0)]),
            };
            entries.push(Entry { dent, before: energy(&before.marks, old), after: energy(&marks, new) });
        });
        update_nearby(set, &mut entries);
        self.dents = entries.into_iter().filter(|e| e.after > 0).map(|e| e.dent).collect();
        self.dents.iter_mut().zip(&marks).for_each(|(dent, mark)| settle(set, mark, dent));
        self.marks = marks;
    }

    /// Replaces all marks, which must be valid.
    pub(crate) fn replace(&mut self, set: &ExampleSet, marks: Vec<Mark>, capacity: usize) {
        self.clear();
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

    pub(crate) fn clear(&mut self) {
        self.marks.clear();
        self.dents.clear();
    }

    /// Calls `f` for every mark that is in this list or the other, in order, with how strongly each shows its dent.
    pub(crate) fn compare(&self, other: &Damage, mut f: impl FnMut(&Mark, f32, f32)) {
        walk(&self.marks, &other.marks, |a, b| {
            let strength = |list: &Damage, at: Option<usize>| at.map_or(0.0, |at| list.dents[at].strength);
            if let Some(mark) = b.map(|b| other.marks[b]).or(a.map(|a| self.marks[a])) {
                f(&mark, strength(self, a), strength(other, b));
            }
        });
    }

    /// These dents, with other strengths for some of them, or others beside them. `others` are sorted by mark.
    pub(crate) fn shown_as(&self, set: &ExampleSet, others: &[(Mark, f32)]) -> Damage {
        let marks: Vec<Mark> = others.iter().map(|(mark, _)| *mark).collect();
        let mut all = Damage::default();
        walk(&self.marks, &marks, |own, other| {
            let mark = own.map_or_else(|| marks[other.unwrap_or(0)], |own| self.marks[own]);
            let alone = || {
                let mut dent = dent_alone(set, &mark);
                settle(set, &mark, &mut dent);
                dent
            };
            let mut dent = own.map_or_else(alone, |own| self.dents[own].clone());
            if let Some(other) = other {
                dent.strength = others[other].1;
                if dent.strength == 0.0 {
                    return;
                }
            }
            all.marks.push(mark);
            all.dents.push(dent);
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

/// Calls `f` for every mark that is in either sorted list, in order, with its index in each.
fn walk(a: &[Mark], b: &[Mark], mut f: impl FnMut(Option<usize>, Option<usize>)) {
    let (mut i, mut j) = (0, 0);
    while i < a.len() || j < b.len() {
        let order = match (a.get(i), b.get(j)) {
            (Some(x), Some(y)) => x.key().cmp(&y.key()),
            (Some(_), None) => Ordering::Less,
            (None, _) => Ordering::Greater,
        };
        f(order.is_le().then_some(i), order.is_ge().then_some(j));
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
            let overlap = overlap(set, &entries[i].dent, &entries[j].dent);
            if overlap > 0.0 {
                let Ok([a, b]) = entries.get_disjoint_mut([i, j]) else { continue };
                // A new dent knows nothing of the others yet.
                change(&mut a.dent, &b.dent, overlap, if a.before > 0 { b.before } else { 0 }, b.after);
                change(&mut b.dent, &a.dent, overlap, if b.before > 0 { a.before } else { 0 }, a.after);
            }
        }
    }
}

/// The marks while new ones are added. Dents are made later, when it is known which marks stay.
struct Merging<'a> {
    set: &'a ExampleSet,
    marks: Vec<Mark>,
    /// One per mark, as if it were alone.
    strengths: Vec<f32>,
}

impl Merging<'_> {
    fn add(&mut self, mark: Mark) {
        match self.marks.binary_search_by(|m| m.key().cmp(&mark.key())) {
            Ok(at) => self.add_energy(at, mark.energy),
            Err(at) => {
                self.marks.insert(at, mark);
                self.strengths.insert(at, strength_alone(mark.energy));
            }
        }
    }

    fn add_energy(&mut self, at: usize, energy: u64) {
        self.marks[at].energy = self.marks[at].energy.saturating_add(energy);
        self.strengths[at] = strength_alone(self.marks[at].energy);
    }

    fn merge_weakest(&mut self) {
        let size = |i: usize| self.strengths[i] * self.marks[i].depth;
        let weakest = (0..self.marks.len()).fold(0, |best, i| if size(i) < size(best) { i } else { best });
        let positions = self.set.mesh().positions();
        let contact = |i: usize| positions[self.marks[i].contact as usize];
        let from = contact(weakest);
        let distance = |i: usize| (contact(i) - from).length_squared();
        let others = (0..self.marks.len()).filter(|i| *i != weakest);
        let Some(heir) = others.reduce(|best, i| if distance(i) < distance(best) { i } else { best }) else { return };
        let ratio = f64::from(self.marks[weakest].depth) / f64::from(self.marks[heir].depth);
        // `as` saturates, and u64 as f64 rounds to nearest. Both are the same on every platform.
        let given = (self.marks[weakest].energy as f64 * energy_factor(ratio)) as u64;
        self.add_energy(heir, given);
        self.marks.remove(weakest);
        self.strengths.remove(weakest);
    }
}
