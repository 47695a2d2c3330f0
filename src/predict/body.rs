//! What a predictor learns from, and the points where it predicts.

use super::Blow;
use super::stamp::{Frames, Places};
use crate::base::math::Aabb;
use crate::basis::field::GROUP;
use crate::mesh::mirror::Mirror;
use glam::Vec3;

/// The body at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// The number of points.
    pub(super) count: usize,
    pub(super) places: Vec<Places>,
    /// Coordinate planes in which the body is symmetric. Examples then also count mirrored, unless they contradict it.
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
    pub fn new(points: &[Vec3], normals: &[Vec3], held: &[f32], mirror: Mirror, centre: Vec3) -> Self {
        let diagonal = f64::from(Aabb::of(points).diagonal()).max(1e-9);
        let places = Places::of(points, normals, held);
        Self { count: points.len(), places, mirror, centre, diagonal, frames: Frames::of(normals) }
    }

    /// Where displacements are given and wanted, m.
    pub(super) fn points(&self) -> impl Iterator<Item = Vec3> {
        let all = self.places.iter().flat_map(|p| (0..GROUP).map(|i| Vec3::from(p.points.map(|along| along[i]))));
        all.take(self.count)
    }

    /// The index of the point nearest to `place`; the first of equally near ones.
    pub(super) fn nearest(&self, place: Vec3) -> usize {
        let mut best = (f32::INFINITY, 0);
        for (i, p) in self.points().enumerate() {
            let d = (p - place).length_squared();
            if d < best.0 {
                best = (d, i);
            }
        }
        best.1
    }

    /// For each point the point nearest to its mirror image.
    pub(super) fn partners(&self, mirror: Mirror) -> Vec<u32> {
        self.points().map(|p| self.nearest(mirror.point(p, self.centre)) as u32).collect()
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
