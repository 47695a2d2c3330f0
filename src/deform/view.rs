//! What evaluation needs of an instance: its damage, its limits, and when each block changed.

use super::kernel::{MOST_STEPS, TURN_STEP};
use crate::damage::carried::Lookup;
use crate::damage::changes::Changes;
use crate::damage::dent::{Dent, Part};
use crate::damage::list::Damage;
use crate::example::options::Combine;
use crate::example::set::ExampleSet;
use crate::mesh::Mesh;
use crate::mesh::limits::BlockLimits;
use glam::Vec3;

/// One instance's damage, for any of the set's meshes.
#[derive(Clone, Copy)]
pub(crate) struct DamageView<'a> {
    pub set: &'a ExampleSet,
    pub damage: &'a Damage,
    /// No vertex moves further than this, m.
    pub depth_limit: f32,
    /// Scaled displacements no longer than this are left out, m.
    pub threshold: f32,
    /// No vertex is wrong by more than this, m; 0 if nothing is left out.
    pub tolerance: f32,
    /// Whether whole steps are too few for the sums of carried examples ([`too_many_steps`]). They are then summed in f32.
    pub wide: bool,
    pub changes: &'a Changes,
    /// Displaced vertices of the base mesh, if the rule stores these instead of marks.
    pub vertices: Option<DisplacedVertices<'a>>,
}

/// Vertices displaced by a rule.
#[derive(Clone, Copy)]
pub(crate) struct DisplacedVertices<'a> {
    /// m.
    pub positions: &'a [Vec3],
    /// Not of unit length; empty if the mesh has none.
    pub normals: &'a [Vec3],
}

impl DamageView<'_> {
    /// The step of displacements of carried examples, m: a power of two, about 2^-26 of the body's size.
    pub(crate) fn step(&self) -> f32 {
        step(self.set)
    }

    /// Whether the sum of dents is no longer than the longest of them.
    pub(crate) fn keeps_deepest(&self) -> bool {
        self.set.options().combine == Combine::Deepest
    }

    /// The limits of a block's own vertices, if dents whose lengths sum to `longest` (m) may reach them.
    pub(crate) fn own_limits(mesh: &Mesh, block: usize, longest: f32) -> Option<BlockLimits<'_>> {
        let least = *mesh.limits().least().get(block)?;
        may_reach(longest, least).then(|| mesh.limits().block(block))
    }

    /// The depth limit, m, if dents whose lengths sum to `longest` (m) may reach it.
    pub(crate) fn limit(&self, longest: f32) -> Option<f32> {
        Some(self.depth_limit).filter(|limit| may_reach(longest, *limit))
    }
}

/// Whether dents whose lengths sum to `longest` may reach the limit; both m. The factor exceeds any error of rounding.
pub(crate) fn may_reach(longest: f32, limit: f32) -> bool {
    longest * 1.00001 > limit
}

fn step(set: &ExampleSet) -> f32 {
    // The greatest power of two that is not above it.
    let power = f32::from_bits(set.mesh().bounds().diagonal().to_bits() & 0x7F80_0000);
    (power * 2.0_f32.powi(-26)).clamp(2.0_f32.powi(-100), 2.0_f32.powi(100))
}

/// Whether 32 bits may not hold the sum of what carried examples contribute, in whole steps. It takes thousands of hits at
/// one place.
pub(crate) fn too_many_steps(set: &ExampleSet, dents: &[Dent]) -> bool {
    let (mut moved, mut turned) = (0.0, 0.0);
    for dent in dents {
        for part in &dent.parts {
            let Part::Carried(carried) = part else { continue };
            let steps = |of: fn(&Lookup) -> f32, step: f32| {
                let length: f32 = carried.lookups.iter().map(of).sum();
                f64::from((length * dent.strength.abs() / step).min(MOST_STEPS)) + 1.0
            };
            moved += steps(|lookup| lookup.longest, step(set));
            turned += steps(|lookup| lookup.steepest, TURN_STEP);
        }
    }
    moved.max(turned) >= f64::from(1u32 << 31)
}
