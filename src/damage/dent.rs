//! A dent: a mark placed on the body. A pure function of the marks and the set.

use super::mark::Mark;
use super::told::predicted;
use crate::basis::field::NodeField;
use crate::example::set::ExampleSet;
use glam::Vec3;
use std::sync::Arc;

/// The nodes that a mark moves.
#[derive(Debug, Clone)]
pub(crate) struct Dent {
    /// Factor for the field. Repeated hits and hits nearby change it.
    pub strength: f32,
    /// The strength if there were no other mark.
    pub alone: f32,
    pub contact: Vec3,
    /// What one hit moves.
    one: Moves,
    /// What all energy of the mark moves, for a strength of 1.
    shown: Moves,
    /// Of that energy ([`Mark::harder`]).
    level: u16,
    pub nearby: Nearby,
}

/// A field, and the factor with which it has the mark's depth at its contact.
#[derive(Debug, Clone)]
struct Moves {
    field: Arc<NodeField>,
    scale: f32,
}

/// What a dent needs to know of itself and of the marks near it ([`super::overlap`]).
#[derive(Debug, Clone, Default)]
pub(crate) struct Nearby {
    pub contact: u32,
    /// Depth to the power by which energies grow.
    pub power: f64,
    /// How far one hit moves the contact, m.
    pub depth: f32,
    /// Squared distance from the contact beyond which one hit moves nothing, m².
    pub reach_square: f32,
    /// Energy that other marks have here, in units of [`Mark::energy`] with hits of this mark's depth.
    pub others: u128,
}

impl Dent {
    /// The dent of one hit of a mark, which must be valid.
    pub(crate) fn of_one_hit(set: &ExampleSet, mark: &Mark) -> Self {
        let contact = set.mesh().positions()[mark.contact as usize];
        let found = predicted(set, mark);
        let one = Moves { field: found.predicted.field, scale: found.scale };
        Dent { strength: 1.0, alone: 1.0, contact, shown: one.clone(), one, level: 0, nearby: Nearby::default() }
    }

    /// Shows the dent as wide as that of one hit with the energy of the level.
    pub(crate) fn widen(&mut self, set: &ExampleSet, mark: &Mark, level: u16) {
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

    /// The nodes that the dent moves, and what their displacements are multiplied by.
    pub(crate) fn field(&self) -> (&Arc<NodeField>, f32) {
        (&self.shown.field, self.shown.scale * self.strength)
    }

    /// Displacement of the base vertex `v` by the mark's hit alone, m.
    pub(crate) fn alone_at(&self, set: &ExampleSet, v: u32) -> Vec3 {
        self.one.field.at_vertex(&set.base_lod().rows, v) * self.one.scale
    }

    /// Squared distance from the contact beyond which a hit alone moves nothing that counts as an overlap, m².
    pub(crate) fn own_reach_square(&self, set: &ExampleSet) -> f32 {
        let nodes = &set.nodes().lod;
        // Dents overlap where they move a contact by a third of their depth. A tenth of it leaves room for vertices between nodes.
        let far = self.one.field.moved_most(0.1);
        far.map(|n| nodes.mesh.positions()[n as usize].distance_squared(self.contact)).fold(0.0, f32::max)
    }

    /// Memory that the dent holds, bytes.
    pub(crate) fn memory_bytes(&self) -> usize {
        let is_one = Arc::ptr_eq(&self.shown.field, &self.one.field);
        let shown = if is_one { 0 } else { self.shown.field.bytes() };
        size_of::<Self>() + self.one.field.bytes() + shown
    }
}
