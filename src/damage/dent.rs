//! A dent: a mark placed on the body. A pure function of the marks and the set.
//!
//! Hits on a dented place deepen it less. `n` hits of depth `T` at one place leave a dent `T n^(1/p)` deep. So the energy of
//! a mark, in hits of another mark's depth, goes with the depth to the power `p`. For marks `m` and `j` with contacts `c`,
//! depths `T`, energies `n` and fields `u` of one hit alone:
//!
//! ```text
//! o_mj     = clamp((max(|u_j(c_m)| / |u_j(c_j)|, |u_m(c_j)| / |u_m(c_m)|) - 0.3) / 0.7, 0, 1)     o_mm = 1
//! E_m      = sum over j of o_mj n_j (T_j / T_m)^p               all energy near the contact, in hits of m's depth
//! strength = n_m / E_m * E_m^(1/p)
//! ```
//!
//! The field that is shown is that of one hit with the energy `n_m`, rounded to a power of 2 (8 at most), scaled to the depth
//! `T`: so what is hit again and again at one place gets wider as it gets deeper. Energies of other marks do not widen a dent:
//! their own dents lie there.
//!
//! Terms of other marks are rounded down to whole units of energy. So `E_m` is a sum of integers: hits can be added and
//! taken away one by one, and the sum does not depend on their order.

use super::energy::{energy_factor, energy_root, strength_alone};
use super::mark::Mark;
use super::told::predicted;
use crate::basis::field::NodeField;
use crate::example::set::ExampleSet;
use glam::Vec3;
use std::sync::Arc;

/// Below this share of its depth, a dent does not count as overlapping.
const FLOOR: f64 = 0.3;
/// The greatest level of energy for which a dent is predicted ([`Mark::harder`]): 8 hits.
const WIDEST: u16 = 3;

/// The nodes that a mark moves, and what it knows of the marks near it.
#[derive(Debug, Clone)]
pub(crate) struct Dent {
    /// Factor for the field. Repeated hits and hits nearby change it.
    pub strength: f32,
    /// The strength if there were no other mark.
    pub alone: f32,
    contact: u32,
    /// Of the contact, m.
    position: Vec3,
    /// What one hit moves.
    one: Moves,
    /// What all energy of the mark moves, for a strength of 1.
    shown: Moves,
    /// Of that energy ([`Mark::harder`]).
    level: u16,
    /// Depth to the power by which energies grow.
    power: f64,
    /// How far one hit moves the contact, m.
    depth: f32,
    /// Squared distance from the contact beyond which one hit moves nothing that counts as an overlap, m².
    reach_square: f32,
    /// Energy that other marks have here, in units of [`Mark::energy`] with hits of this mark's depth.
    others: u128,
}

/// A field, and the factor with which it has the mark's depth at its contact.
#[derive(Debug, Clone)]
struct Moves {
    field: Arc<NodeField>,
    scale: f32,
}

impl Dent {
    /// The dent of a mark, which must be valid. It knows of no other mark near it; [`Dent::settle`] sets its strength.
    pub(crate) fn new(set: &ExampleSet, mark: &Mark) -> Self {
        let position = set.mesh().positions()[mark.contact as usize];
        let found = predicted(set, mark);
        let one = Moves { field: found.predicted.field, scale: found.scale };
        let nodes = set.nodes().lod.mesh.positions();
        // Dents overlap where they move a contact by a third of their depth. A tenth of it leaves room for vertices between nodes.
        let reach_square = one.field.reach_square(0.1, nodes, position);
        let mut dent = Dent {
            strength: 1.0,
            alone: 1.0,
            contact: mark.contact,
            position,
            shown: one.clone(),
            level: 0,
            power: energy_factor(mark.depth.into()),
            depth: 0.0,
            reach_square,
            others: 0,
            one,
        };
        dent.depth = dent.one_at(set, mark.contact);
        dent
    }

    /// The nodes that the dent moves, and what their displacements are multiplied by.
    pub(crate) fn field(&self) -> (&Arc<NodeField>, f32) {
        (&self.shown.field, self.shown.scale * self.strength)
    }

    /// How far one hit moves the base vertex `v`, m.
    fn one_at(&self, set: &ExampleSet, v: u32) -> f32 {
        (self.one.field.at_vertex(&set.base_lod().rows, v) * self.one.scale).length()
    }

    /// How far two dents act on the same place, 0 to 1.
    pub(crate) fn overlap(&self, set: &ExampleSet, other: &Dent) -> f64 {
        let apart = (self.position - other.position).length_squared();
        let share = |of: &Dent, at: &Dent| {
            let near = of.depth > 0.0 && apart <= of.reach_square;
            if near { f64::from(of.one_at(set, at.contact)) / f64::from(of.depth) } else { 0.0 }
        };
        ((share(self, other).max(share(other, self)) - FLOOR) / (1.0 - FLOOR)).clamp(0.0, 1.0)
    }

    /// Adds to the energy that other marks have here the difference that a change of `other`'s energy makes.
    pub(crate) fn change(&mut self, other: &Dent, overlap: f64, before: u64, after: u64) {
        let factor = overlap * (other.power / self.power);
        // `as` saturates, and u64 as f64 rounds to nearest. Both are the same on every platform.
        let given = |energy: u64| u128::from((energy as f64 * factor) as u64);
        self.others = self.others + given(after) - given(before);
    }

    /// Sets the strength, and the width: that of one hit with the energy of the mark.
    pub(crate) fn settle(&mut self, set: &ExampleSet, mark: &Mark) {
        self.alone = strength_alone(mark.energy);
        let all = u128::from(mark.energy) + self.others;
        self.strength = (mark.energy as f64 / all as f64 * energy_root(all as f64 / Mark::ONE as f64)) as f32;
        let hits = mark.energy as f64 / Mark::ONE as f64;
        let level = (libm::round(libm::log2(hits.max(1.0))) as u16).min(WIDEST);
        if self.level == level {
            return;
        }
        self.level = level;
        self.shown = self.one.clone();
        if level > 0 {
            let (harder, deeper) = mark.harder(level);
            let found = predicted(set, &harder);
            if found.scale > 0.0 {
                self.shown = Moves { field: found.predicted.field, scale: found.scale / deeper };
            }
        }
    }

    /// Memory that the dent holds, bytes.
    pub(crate) fn memory_bytes(&self) -> usize {
        let is_one = Arc::ptr_eq(&self.shown.field, &self.one.field);
        let shown = if is_one { 0 } else { self.shown.field.bytes() };
        size_of::<Self>() + self.one.field.bytes() + shown
    }
}
