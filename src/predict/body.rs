//! What a predictor learns from.

use super::Blow;
use crate::mesh::mirror::Mirror;
use glam::Vec3;

/// The body at rest. Points are where displacements are given and wanted.
#[derive(Debug, Clone, Copy)]
pub struct Body<'a> {
    /// Positions, m.
    pub points: &'a [Vec3],
    /// Unit normals, out of the body; zero where there is none. As many as points.
    pub normals: &'a [Vec3],
    /// Coordinate planes in which the body is symmetric. Examples then also count mirrored, if they agree with it.
    pub mirror: Mirror,
    /// A point of those planes, m.
    pub centre: Vec3,
    /// How much of what is carried to each point it takes: 1, and less towards held rims. Empty: 1 everywhere.
    pub held: &'a [f32],
}

/// One example: a hit and the field that it left.
#[derive(Debug, Clone, Copy)]
pub struct Sample<'a> {
    /// Where the body was hit, m.
    pub contact: Vec3,
    /// Unit normal of the body there, out of it.
    pub normal: Vec3,
    /// What is known of the blow.
    pub blow: Option<Blow>,
    /// Displacement of each point, m.
    pub field: &'a [Vec3],
    /// Displacement of the contact, m. `None`: that of the nearest point.
    pub moved: Option<Vec3>,
    /// Samples of one source are copies of one simulation. They are left out together when the set learns from its own
    /// errors.
    pub source: u32,
}

/// The share that a point takes of what is carried to it.
pub(super) fn held(shares: &[f32], point: usize) -> f32 {
    shares.get(point).copied().unwrap_or(1.0)
}
