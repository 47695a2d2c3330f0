//! A hit as a point in the space that examples are compared in: place, depth and lean ([`super::kriging`]).

use super::kriging::Axes;
use crate::base::math::turn_tangent;
use crate::example::candidates::Candidate;
use crate::example::example::Example;
use crate::example::set::ExampleSet;
use crate::mesh::mirror::Mirror;
use glam::Vec3;

/// Axis width over the natural logarithm of the ratio of depths.
const SIZE_WIDTH: f32 = 2.4;
/// Axis width over the lean: the tangential part of a unit displacement.
const LEAN_WIDTH: f32 = 0.05;
/// Place axes of anchored examples, as a share of the diagonal: an anchored example says little about other places.
const ANCHORED_WIDTH: f32 = 0.15;
/// An anchored example reaches a vertex that it displaces by at least this share of its own contact's displacement.
const REACH: f32 = 0.1;
/// A target that leans less than this (a tenth of a degree) is taken as along the normal, with unknown lean.
const UPRIGHT: f32 = 0.002;
/// A target that leans more than the most leaning example by this factor is not what a dent's contact does.
const BEYOND: f32 = 3.0;
/// An example shallower than this share of the depth limit answers no hit.
const NEGLIGIBLE: f32 = 1e-6;

/// A hit on a vertex that asks for a displacement, as examples are measured against it.
pub(crate) struct HitQuery<'a> {
    examples: &'a [Example],
    contact: u32,
    pub point: Vec3,
    pub size: f32,
    normal: Option<Vec3>,
    direction: Vec3,
    /// `None` where it is not known.
    lean: Option<Vec3>,
    log_size: f32,
    /// Widths of the place axes, m.
    carried_width: f32,
    anchored_width: f32,
    negligible: f32,
}

impl<'a> HitQuery<'a> {
    /// A hit on vertex `contact` that asks for `size` (m) along the unit vector `direction`. `place_width` is the width of the
    /// place axes as a share of the diagonal.
    pub(crate) fn new(set: &'a ExampleSet, contact: u32, direction: Vec3, size: f32, place_width: f32) -> Self {
        let (mesh, candidates) = (set.mesh(), set.candidates());
        let normal = mesh.contact_normal(contact);
        let lean = normal.map_or(Vec3::ZERO, |n| direction - n * n.dot(direction));
        // The direction of an impulse, or a displacement made up along the normal, does not tell how a dent leans.
        let length = lean.length();
        let cut = if length > candidates.max_lean { lean * (candidates.max_lean / length) } else { lean };
        let lean = (UPRIGHT..=BEYOND * candidates.max_lean).contains(&length).then_some(cut);
        let width = |share: f32| (share * candidates.diagonal).max(f32::MIN_POSITIVE);
        HitQuery {
            examples: set.examples(),
            contact,
            point: mesh.positions()[contact as usize],
            size,
            normal,
            direction,
            lean,
            log_size: libm::logf(size),
            carried_width: width(place_width),
            anchored_width: width(ANCHORED_WIDTH),
            negligible: NEGLIGIBLE * set.depth_limit(),
        }
    }

    /// A candidate relative to the hit; `None` where it cannot answer it.
    pub(crate) fn axes(&self, candidate: &Candidate, anchored: bool) -> Option<Axes> {
        let e = &self.examples[candidate.example as usize];
        if e.depth() < self.negligible {
            return None;
        }
        let (log_depth, lean, cos, width) = if anchored {
            let u = e.displacement_at(self.contact, self.point);
            let depth = u.length();
            if depth < REACH * e.depth() || candidate.mirror != Mirror::NONE {
                return None;
            }
            let u = u / depth;
            let lean = self.normal.map_or(Vec3::ZERO, |n| u - n * n.dot(u));
            (libm::logf(depth), lean, u.dot(self.direction), self.anchored_width)
        } else {
            let normal = self.normal?;
            let lean = turn_tangent(candidate.lean, candidate.normal, normal);
            let along = normal * candidate.normal.dot(candidate.direction);
            (candidate.log_depth, lean, (along + lean).dot(self.direction), self.carried_width)
        };
        if cos.is_nan() || cos <= 1e-3 {
            return None;
        }
        let p = (candidate.point - self.point) / width;
        let l = self.lean.map_or(Vec3::ZERO, |known| (lean - known) / LEAN_WIDTH);
        Some([p.x, p.y, p.z, (log_depth - self.log_size) / SIZE_WIDTH, l.x, l.y, l.z])
    }

    /// A lower bound, exact in f32, on the squared distance of a candidate when it is carried: its first four axes.
    pub(crate) fn carried_bound(&self, candidate: &Candidate) -> f32 {
        let p = (candidate.point - self.point) / self.carried_width;
        let depth = (candidate.log_depth - self.log_size) / SIZE_WIDTH;
        p.x * p.x + p.y * p.y + p.z * p.z + depth * depth
    }
}
