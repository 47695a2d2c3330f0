//! What evaluation sees of an instance: its damage, its limits, and when which block changed.

use super::kernel::Lengths;
use crate::damage::changes::Changes;
use crate::damage::list::Damage;
use crate::example::options::Combine;
use crate::example::set::ExampleSet;
use glam::Vec3;

/// One instance's damage, to be shown on any of the set's meshes.
#[derive(Clone, Copy)]
pub(crate) struct DamageView<'a> {
    pub set: &'a ExampleSet,
    pub damage: &'a Damage,
    /// No vertex moves further than this, m.
    pub depth_limit: f32,
    /// Displacements no longer than this, as scaled, are left out, m.
    pub threshold: f32,
    pub changes: &'a Changes,
    /// Displaced vertices of the base mesh, for a rule that keeps them instead of marks.
    pub vertices: Option<DisplacedVertices<'a>>,
}

/// Vertices as a rule has displaced them.
#[derive(Clone, Copy)]
pub(crate) struct DisplacedVertices<'a> {
    /// m.
    pub positions: &'a [Vec3],
    /// Not of unit length; empty where the mesh has none.
    pub normals: &'a [Vec3],
}

impl DamageView<'_> {
    /// How lengths of dents combine.
    pub(crate) fn lengths(&self) -> Lengths {
        match self.set.options().combine {
            Combine::Sum => Lengths::Free,
            Combine::Energies => Lengths::Squares,
            Combine::Deepest => Lengths::Longest,
        }
    }

    /// The depth limit, m, where dents of this summed length (m) may reach it.
    pub(crate) fn limit(&self, longest: f32) -> Option<f32> {
        Some(self.depth_limit).filter(|limit| may_reach(longest, *limit))
    }
}

/// Whether dents of this summed length may reach the limit, m: rounding never takes a length over it by more.
pub(crate) fn may_reach(longest: f32, limit: f32) -> bool {
    longest * 1.00001 > limit
}
