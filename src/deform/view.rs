//! What evaluation needs of an instance: its damage, its limits, and when each block changed.

use super::kernel::TURN_STEP;
use crate::damage::changes::Changes;
use crate::damage::dent::{Dent, Part};
use crate::damage::list::Damage;
use crate::example::set::ExampleSet;
use crate::mesh::Mesh;
use crate::mesh::limits::BlockLimits;
use crate::mesh::rim::WindowBlock;
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
    /// Factor of the steps that carried examples are summed in ([`coarseness`]).
    pub coarse: f32,
    pub changes: &'a Changes,
    /// Displaced vertices of the base mesh, if the rule stores these instead of marks.
    pub vertices: Option<DisplacedVertices<'a>>,
    /// Displacements of the set's nodes. Meshes with rows follow them.
    pub nodes: Option<NodeView<'a>>,
}

/// The displacement of a node in steps; the fourth number is 0.
pub(crate) type NodeSteps = [i16; 4];

/// Displacements of nodes.
#[derive(Clone, Copy)]
pub(crate) struct NodeView<'a> {
    pub steps: &'a [NodeSteps],
    /// m.
    pub step: f32,
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
    /// The step of displacements of carried examples, m: a power of two, about 2^-26 of the body's size if few dents overlap.
    pub(crate) fn step(&self) -> f32 {
        step(self.set) * self.coarse
    }

    /// The step of their changes of normals, a power of two.
    pub(crate) fn turn_step(&self) -> f32 {
        TURN_STEP * self.coarse
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

/// The factor by which steps must be coarser so that 32 bits hold the sum of what carried examples contribute: 1, unless there
/// were thousands of hits at one place, or a power of two.
pub(crate) fn coarseness(set: &ExampleSet, dents: &[Dent]) -> f32 {
    /// What 32 bits hold, with room for rounding each contribution.
    const MOST: f64 = ((1u32 << 31) - (1 << 20)) as f64;
    let step = f64::from(step(set));
    // Near held rims the normal also turns with the slope of the window.
    let held = set.rim().vertices() > 0;
    let slope = if held { WindowBlock::steepest(set.mesh().bounds().diagonal()) } else { 0.0 };
    let (mut moved, mut turned) = (0.0, 0.0);
    for dent in dents {
        for part in &dent.parts {
            let Part::Carried(carried) = part else { continue };
            for lookup in &carried.lookups {
                let strength = f64::from(dent.strength.abs());
                let (longest, steepest) = (f64::from(lookup.longest), f64::from(lookup.steepest));
                moved += longest * strength / step;
                turned += (steepest + longest * f64::from(slope)) * strength / f64::from(TURN_STEP);
            }
        }
    }
    // Steps stay finite. No body needs more.
    let limit = 2.0_f64.powi(90).min(2.0_f64.powi(120) / step);
    let mut coarse = 1.0;
    while moved.max(turned) > MOST * coarse && coarse < limit {
        coarse *= 2.0;
    }
    coarse as f32
}
