//! What selection can choose from: every example, and its mirror images where the body has mirror planes.

use super::example::Example;
use crate::base::math::turn_tangent;
use crate::mesh::Mesh;
use crate::mesh::mirror::{self, Mirror};
use glam::Vec3;
use rstar::{RTree, primitives::GeomWithData};

/// Two candidates are one when they differ by no more than this in place (share of the diagonal), logarithm of depth, and lean.
const SAME: (f32, f32, f32) = (0.01, 0.02, 0.01);
/// Two examples are copies of each other when they differ by no more than this in logarithm of depth and in lean.
const COPY: (f32, f32) = (1e-3, 2e-3);

/// An example, or its mirror image, at its own contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate {
    pub example: u32,
    pub mirror: Mirror,
    pub point: Vec3,
    pub normal: Vec3,
    /// Unit displacement of the contact.
    pub direction: Vec3,
    /// The tangential part of `direction`.
    pub lean: Vec3,
    pub log_depth: f32,
}

impl Candidate {
    fn new(e: &Example, example: usize, mirror: Mirror, centre: Vec3) -> Self {
        let normal = mirror.direction(e.contact_normal().unwrap_or(Vec3::Z));
        let direction = mirror.direction(e.contact_displacement() / e.depth());
        Candidate {
            example: example as u32,
            mirror,
            point: mirror.point(e.contact_point(), centre),
            normal,
            direction,
            lean: direction - normal * normal.dot(direction),
            log_depth: e.log_depth(),
        }
    }

    fn same(&self, other: &Candidate, diagonal: f32) -> bool {
        (self.point - other.point).length() <= SAME.0 * diagonal
            && (self.log_depth - other.log_depth).abs() <= SAME.1
            && (self.lean - other.lean).length() <= SAME.2
    }
}

/// All candidates of a set, ordered by example and then by mirror. A mirror image that repeats another candidate is left out.
#[derive(Debug, Default)]
pub(crate) struct Candidates {
    all: Vec<Candidate>,
    /// Length of the longest lean of any candidate.
    pub max_lean: f32,
    pub diagonal: f32,
    planes: Mirror,
    centre: Vec3,
}

impl Candidates {
    pub(crate) fn new(mesh: &Mesh, examples: &[Example], planes: Mirror) -> Self {
        let (centre, diagonal) = (mirror::centre(&mesh.bounds()), mesh.bounds().diagonal());
        let usable = || examples.iter().enumerate().filter(|(_, e)| !e.is_empty());
        let mut all: Vec<Candidate> = usable().map(|(i, e)| Candidate::new(e, i, Mirror::NONE, centre)).collect();
        let mut kept: RTree<GeomWithData<[f32; 3], Candidate>> = RTree::new();
        all.iter().for_each(|c| kept.insert(GeomWithData::new(c.point.to_array(), *c)));
        let near = (SAME.0 * diagonal).powi(2);
        for (i, e) in usable().filter(|(_, e)| e.stamp().is_some()) {
            for m in planes.choices().filter(|m| *m != Mirror::NONE) {
                let image = Candidate::new(e, i, m, centre);
                let at = image.point.to_array();
                if !kept.locate_within_distance(at, near).any(|k| k.data.same(&image, diagonal)) {
                    kept.insert(GeomWithData::new(at, image));
                    all.push(image);
                }
            }
        }
        all.sort_by_key(|c| (c.example, c.mirror));
        let max_lean = all.iter().map(|c| c.lean.length()).fold(0.0, f32::max);
        Candidates { all, max_lean, diagonal, planes, centre }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Candidate> {
        self.all.iter()
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.all[..])
    }

    /// Whether `b` repeats `a`, moved or mirrored. Leaving one of two copies out and keeping the other teaches nothing.
    pub(crate) fn are_copies(&self, a: &Example, b: &Example) -> bool {
        if a.is_empty() || b.is_empty() {
            return false;
        }
        let own = Candidate::new(a, 0, Mirror::NONE, self.centre);
        self.planes.choices().any(|m| {
            let image = Candidate::new(b, 0, m, self.centre);
            let lean = turn_tangent(image.lean, image.normal, own.normal);
            (image.log_depth - own.log_depth).abs() <= COPY.0 && (lean - own.lean).length() <= COPY.1
        })
    }
}
