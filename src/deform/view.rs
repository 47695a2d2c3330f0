//! What evaluation needs of an instance: where its nodes are, its limits, and when each block changed.

use crate::damage::changes::Changes;
use crate::example::set::ExampleSet;
use glam::Vec3;

/// One instance's damage, for any of the set's meshes.
#[derive(Clone, Copy)]
pub(crate) struct DamageView<'a> {
    pub set: &'a ExampleSet,
    /// No vertex moves further than this, m.
    pub depth_limit: f32,
    /// Errors of this length are not seen, m; 0 if that is not known.
    pub unseen: f32,
    pub changes: &'a Changes,
    pub shape: Shape<'a>,
}

/// What moves vertices.
#[derive(Clone, Copy)]
pub(crate) enum Shape<'a> {
    /// All meshes follow the set's nodes.
    Nodes(NodeView<'a>),
    /// A classic rule displaces the vertices of the base mesh.
    Vertices(DisplacedVertices<'a>),
}

/// The displacement of a node in steps. The fourth number is its length, rounded up, as 16 bits without a sign.
pub(crate) type NodeSteps = [i16; 4];

/// Displacements of nodes.
#[derive(Clone, Copy)]
pub(crate) struct NodeView<'a> {
    /// Empty if none was ever displaced.
    pub steps: &'a [NodeSteps],
    /// m.
    pub step: f32,
    /// The longest displacement, in steps; 0 if no node is displaced.
    pub farthest: u16,
}

/// Vertices displaced by a rule.
#[derive(Clone, Copy)]
pub(crate) struct DisplacedVertices<'a> {
    /// m.
    pub positions: &'a [Vec3],
    /// Not of unit length; empty if the mesh has none.
    pub normals: &'a [Vec3],
}

/// Whether displacements as long as `longest` may reach the limit; both m. The factor exceeds any error of rounding.
pub(crate) fn may_reach(longest: f32, limit: f32) -> bool {
    longest * 1.00001 > limit
}
