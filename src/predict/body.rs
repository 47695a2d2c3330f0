//! What a predictor learns from, and the points where it predicts.

use super::Blow;
use super::stamp::Frames;
use crate::base::math::Aabb;
use crate::mesh::mirror::Mirror;
use glam::Vec3;

/// The body at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Where displacements are given and wanted, m.
    pub points: Vec<Vec3>,
    /// Unit normals of the points, out of the body; zero where there is none.
    pub(super) normals: Vec<Vec3>,
    /// How much of what is carried to each point it takes: 1, and less towards held rims. Empty: 1 everywhere.
    pub(super) held: Vec<f32>,
    /// Coordinate planes in which the body is symmetric. Examples then also count mirrored, if they agree with it.
    pub(super) mirror: Mirror,
    /// A point of those planes, m.
    pub(super) centre: Vec3,
    /// Of the points' bounds, m.
    pub(super) diagonal: f64,
    pub(super) frames: Frames,
}

impl Body {
    /// A body of points with as many unit normals, the shares that points take of what is carried to them (none: all of it), and its planes
    /// of symmetry through `centre`.
    pub fn new(points: Vec<Vec3>, normals: Vec<Vec3>, held: Vec<f32>, mirror: Mirror, centre: Vec3) -> Self {
        let diagonal = f64::from(Aabb::of(&points).diagonal()).max(1e-9);
        let frames = Frames::of(&normals);
        Self { points, normals, held, mirror, centre, diagonal, frames }
    }

    /// The share that a point takes of what is carried to it.
    pub(super) fn held(&self, point: usize) -> f32 {
        self.held.get(point).copied().unwrap_or(1.0)
    }

    /// The index of the point nearest to `place`; the first of equally near ones.
    pub(super) fn nearest(&self, place: Vec3) -> usize {
        let mut best = (f32::INFINITY, 0);
        for (i, p) in self.points.iter().enumerate() {
            let d = (*p - place).length_squared();
            if d < best.0 {
                best = (d, i);
            }
        }
        best.1
    }

    /// For each point the point nearest to its mirror image.
    pub(super) fn partners(&self, mirror: Mirror) -> Vec<u32> {
        self.points.iter().map(|p| self.nearest(mirror.point(*p, self.centre)) as u32).collect()
    }
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
    /// Displacement of the contact, m.
    pub moved: Vec3,
    /// Samples of one source are copies of one simulation. They are left out together when the set learns from its own
    /// errors.
    pub source: u32,
}
