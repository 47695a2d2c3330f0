//! Damage: a short, sorted list of marks. It is the only state of an instance with the default rule.

use super::dent::{Dent, Reach, strength};
use super::mark::Mark;
use crate::base::error::{Error, reserve};
use crate::base::math::Aabb;
use crate::example::options::Combine;
use crate::example::set::ExampleSet;
use std::cmp::Ordering;

/// Called with every dent that a change of the damage adds, alters or removes.
type Changed<'a> = &'a mut dyn FnMut(&Dent);

/// The sorted marks of one instance and their dents.
#[derive(Debug, Clone, Default)]
pub(crate) struct Damage {
    marks: Vec<Mark>,
    dents: Vec<Dent>,
    /// One per dent, in an array of their own because every evaluated block reads all of them.
    reaches: Vec<Reach>,
}

impl Damage {
    pub(crate) fn marks(&self) -> &[Mark] {
        &self.marks
    }

    pub(crate) fn dents(&self) -> &[Dent] {
        &self.dents
    }

    /// The dents that may move vertices in a box, in order.
    pub(crate) fn near<'a>(&'a self, bounds: &'a Aabb) -> impl Iterator<Item = &'a Dent> {
        let near = self.reaches.iter().zip(&self.dents).filter(|(r, _)| bounds.distance_squared(r.contact) <= r.square);
        near.map(|(_, dent)| dent)
    }

    /// Adds new marks. They are sorted first, so the result does not depend on their order. If a mark with the same
    /// contact, depth and pairs exists, it takes the new mark's energy. Above `capacity` the weakest mark (smallest
    /// `strength * depth`) is removed. Its energy, converted by the ratio of depths, goes to the mark with the nearest
    /// contact. Ties go to the first mark in order.
    pub(crate) fn add(&mut self, set: &ExampleSet, mut new: Vec<Mark>, capacity: usize, changed: Changed<'_>) {
        if new.is_empty() {
            return;
        }
        new.sort_unstable_by(|a, b| a.key().cmp(&b.key()).then(a.energy.cmp(&b.energy)));
        let mut list =
            Merging { set, marks: self.marks.clone(), strengths: self.dents.iter().map(|d| d.strength).collect() };
        for mark in new {
            list.add(mark);
            if list.marks.len() > capacity {
                list.merge_weakest();
            }
        }
        let before = std::mem::replace(self, Self::with_dents_of(self, set, list.marks));
        self.differences(&before, changed);
    }

    /// Makes the damage of sorted `marks`. Reuses the dents that `old` has.
    fn with_dents_of(old: &Damage, set: &ExampleSet, marks: Vec<Mark>) -> Self {
        let mut at = 0;
        let dent = |mark: &Mark| {
            at += old.marks[at..].iter().take_while(|m| m.key() < mark.key()).count();
            match old.marks.get(at) {
                Some(same) if same.key() == mark.key() => {
                    Dent { strength: strength(mark.energy, set.options().combine), ..old.dents[at].clone() }
                }
                _ => Dent::new(set, mark),
            }
        };
        let dents: Vec<Dent> = marks.iter().map(dent).collect();
        Damage { reaches: dents.iter().map(Dent::reach).collect(), dents, marks }
    }

    /// Replaces all marks. On an error nothing changes.
    pub(crate) fn replace(
        &mut self,
        set: &ExampleSet,
        marks: &[Mark],
        capacity: usize,
        changed: Changed<'_>,
    ) -> Result<(), Error> {
        marks.iter().enumerate().try_for_each(|(i, m)| m.check(set, i))?;
        let mut copy = reserve(marks.len(), "marks")?;
        copy.extend_from_slice(marks);
        self.clear(changed);
        self.add(set, copy, capacity, changed);
        Ok(())
    }

    /// Multiplies the strength of every dent by `keep`. Removes dents whose strength falls below a ten-thousandth.
    pub(crate) fn scale(&mut self, set: &ExampleSet, keep: f32, changed: Changed<'_>) {
        let keep = f64::from(keep);
        let factor = if set.options().combine == Combine::Energies { keep * keep } else { keep };
        for i in 0..self.marks.len() {
            changed(&self.dents[i]);
            let energy = (self.marks[i].energy as f64 * factor) as u64;
            self.marks[i].energy = energy;
            self.dents[i].strength = strength(energy, set.options().combine);
        }
        let gone = |d: &Dent| d.strength < 1e-4;
        let keep: Vec<bool> = self.dents.iter().map(|d| !gone(d)).collect();
        let mut k = keep.iter();
        self.marks.retain(|_| *k.next().unwrap_or(&true));
        self.dents.retain(|d| !gone(d));
        self.reaches = self.dents.iter().map(Dent::reach).collect();
    }

    pub(crate) fn clear(&mut self, changed: Changed<'_>) {
        self.dents.iter().for_each(changed);
        self.marks.clear();
        self.dents.clear();
        self.reaches.clear();
    }

    /// Calls `changed` with every dent that is in only one of the two lists, and with both versions of a dent whose
    /// energy differs.
    pub(crate) fn differences(&self, other: &Damage, changed: Changed<'_>) {
        let (mut a, mut b) = (0, 0);
        while a < self.marks.len() || b < other.marks.len() {
            let order = match (self.marks.get(a), other.marks.get(b)) {
                (Some(x), Some(y)) => x.key().cmp(&y.key()),
                (Some(_), None) => Ordering::Less,
                (None, _) => Ordering::Greater,
            };
            match order {
                Ordering::Less => changed(&self.dents[a]),
                Ordering::Greater => changed(&other.dents[b]),
                Ordering::Equal if self.marks[a].energy != other.marks[b].energy => {
                    changed(&self.dents[a]);
                    changed(&other.dents[b]);
                }
                Ordering::Equal => {}
            }
            a += usize::from(order.is_le());
            b += usize::from(order.is_ge());
        }
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.marks.len() * (size_of::<Mark>() + size_of::<Dent>() + size_of::<Reach>())
    }

    pub(crate) fn touch_all(&self, changed: Changed<'_>) {
        self.dents.iter().for_each(changed);
    }
}

/// The marks while new ones are added. Dents are made later, when it is known which marks stay.
struct Merging<'a> {
    set: &'a ExampleSet,
    marks: Vec<Mark>,
    /// One per mark.
    strengths: Vec<f32>,
}

impl Merging<'_> {
    fn add(&mut self, mark: Mark) {
        match self.marks.binary_search_by(|m| m.key().cmp(&mark.key())) {
            Ok(at) => self.add_energy(at, mark.energy),
            Err(at) => {
                self.marks.insert(at, mark);
                self.strengths.insert(at, strength(mark.energy, self.set.options().combine));
            }
        }
    }

    fn add_energy(&mut self, at: usize, energy: u64) {
        let combine = self.set.options().combine;
        self.marks[at].energy = combined(self.marks[at].energy, energy, combine);
        self.strengths[at] = strength(self.marks[at].energy, combine);
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
        let combine = self.set.options().combine;
        let ratio = f64::from(self.marks[weakest].depth) / f64::from(self.marks[heir].depth);
        let power = if combine == Combine::Energies { ratio * ratio } else { ratio };
        // `as` saturates, and u64 as f64 rounds to nearest. Both are the same on every platform.
        let given = (self.marks[weakest].energy as f64 * power) as u64;
        self.add_energy(heir, given);
        self.marks.remove(weakest);
        self.strengths.remove(weakest);
    }
}

fn combined(a: u64, b: u64, combine: Combine) -> u64 {
    match combine {
        Combine::Sum | Combine::Energies => a.saturating_add(b),
        Combine::Deepest => a.max(b),
    }
}
