//! A hit as a point in the space in which examples are compared: place, depth and lean ([`super::kriging`]).

use super::kriging::Axes;
use super::target::HitTarget;
use crate::base::math::{OPPOSITE, turn_tangent};
use crate::example::candidates::{Candidate, CandidateLanes, REACH};
use crate::example::example::Example;
use crate::example::set::ExampleSet;
use crate::mesh::mirror::Mirror;
use glam::{Vec3, Vec4};

/// Width of the depth axis: natural logarithm of the ratio of depths.
const SIZE_WIDTH: f32 = 2.4;
/// Width of the lean axes: tangential part of a unit displacement.
const LEAN_WIDTH: f32 = 0.05;
/// Width of the place axes of anchored examples, as a share of the diagonal. They predict little about other places.
const ANCHORED_WIDTH: f32 = 0.15;
/// Width of the axes of the blow's tangential part, and of the logarithm of the striker's radius.
const TANGENT_WIDTH: f32 = 1.0;
const RADIUS_WIDTH: f32 = 2.0;
/// A target that leans less than this (a tenth of a degree) counts as along the normal. Its lean is unknown.
const UPRIGHT: f32 = 0.002;
/// A lean above this many times the greatest of all examples is implausible for a dent and counts as unknown.
const BEYOND: f32 = 3.0;
/// An example shallower than this share of the depth limit is never used.
const NEGLIGIBLE: f32 = 1e-6;

/// A hit that asks for a displacement of a vertex, prepared for comparison with examples.
pub(crate) struct HitQuery<'a> {
    examples: &'a [Example],
    contact: u32,
    pub point: Vec3,
    pub size: f32,
    normal: Option<Vec3>,
    direction: Vec3,
    /// `None` if unknown.
    lean: Option<Vec3>,
    /// The blow's tangential part and the logarithm of the striker's radius. `None` if unknown.
    tangent: Option<Vec3>,
    log_radius: Option<f32>,
    log_size: f32,
    /// Widths of the place axes, m.
    carried_width: f32,
    anchored_width: f32,
    negligible: f32,
}

impl<'a> HitQuery<'a> {
    /// A hit with this target. `place_width` is the width of the place axes of carried examples, as a share of the
    /// diagonal.
    pub(crate) fn new(set: &'a ExampleSet, target: &HitTarget, place_width: f32) -> Self {
        let HitTarget { contact, normal, direction, size, strike, .. } = *target;
        let candidates = set.candidates();
        let lean = normal.map_or(Vec3::ZERO, |n| direction - n * n.dot(direction));
        // The direction of an impulse, or a displacement constructed along the normal, does not tell how a dent leans.
        let length = lean.length();
        let cut = if length > candidates.max_lean { lean * (candidates.max_lean / length) } else { lean };
        let lean = (UPRIGHT..=BEYOND * candidates.max_lean).contains(&length).then_some(cut);
        let width = |share: f32| (share * candidates.diagonal).max(f32::MIN_POSITIVE);
        HitQuery {
            examples: set.examples(),
            contact,
            point: set.mesh().positions()[contact as usize],
            size,
            normal,
            direction,
            lean,
            tangent: strike.map(|s| s.tangent.as_vec3()),
            log_radius: strike.and_then(|s| s.radius).map(|r| r as f32),
            log_size: libm::logf(size),
            carried_width: width(place_width),
            anchored_width: width(ANCHORED_WIDTH),
            negligible: NEGLIGIBLE * set.depth_limit(),
        }
    }

    /// Coordinates of a candidate relative to the hit. `None` if the candidate cannot be used for it.
    #[inline]
    pub(crate) fn axes(&self, candidate: &Candidate, anchored: bool) -> Option<Axes> {
        if candidate.depth < self.negligible {
            return None;
        }
        let (log_depth, lean, tangent, cos, width) = if anchored {
            let e = &self.examples[candidate.example as usize];
            let u = e.displacement_at(self.contact, self.point);
            let depth = u.length();
            if depth < REACH * candidate.depth || candidate.mirror != Mirror::NONE {
                return None;
            }
            let u = u / depth;
            let lean = self.normal.map_or(Vec3::ZERO, |n| u - n * n.dot(u));
            (libm::logf(depth), lean, candidate.tangent, u.dot(self.direction), self.anchored_width)
        } else {
            let normal = self.normal?;
            let lean = turn_tangent(candidate.lean, candidate.normal, normal);
            let along = normal * candidate.normal.dot(candidate.direction);
            let tangent = candidate.tangent.map(|t| turn_tangent(t, candidate.normal, normal));
            (candidate.log_depth, lean, tangent, (along + lean).dot(self.direction), self.carried_width)
        };
        if cos.is_nan() || cos <= 1e-3 {
            return None;
        }
        let p = (candidate.point - self.point) / width;
        let l = self.lean.map_or(Vec3::ZERO, |known| (lean - known) / LEAN_WIDTH);
        let t = self.tangent.zip(tangent).map_or(Vec3::ZERO, |(known, t)| (t - known) / TANGENT_WIDTH);
        let r = self.log_radius.zip(candidate.log_radius).map_or(0.0, |(known, r)| (r - known) / RADIUS_WIDTH);
        Some([p.x, p.y, p.z, (log_depth - self.log_size) / SIZE_WIDTH, l.x, l.y, l.z, t.x, t.y, t.z, r])
    }

    /// Lower bounds of the squared distances of carried candidates. A bound is minus infinity if the candidate may be
    /// used anchored, or if only [`HitQuery::axes`] is precise enough. This function multiplies where `axes` divides,
    /// so each bound is lowered by more than the rounding difference.
    #[inline]
    pub(crate) fn bounds(&self, lanes: &CandidateLanes) -> Vec4 {
        const ROUNDING: f32 = 4e-6;
        #[inline]
        fn dot(a: [Vec4; 3], b: [Vec4; 3]) -> Vec4 {
            a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
        }
        let wide = |v: Option<Vec3>| v.unwrap_or(Vec3::ZERO).to_array().map(Vec4::splat);
        let (point, normal) = (wide(Some(self.point)), wide(self.normal));
        let off = [0, 1, 2].map(|i| lanes.point[i] - point[i]);
        let off_square = dot(off, off);
        let depth = (lanes.log_depth - Vec4::splat(self.log_size)) * (1.0 / SIZE_WIDTH);
        let mut distance = off_square * (1.0 / (self.carried_width * self.carried_width)) + depth * depth;
        let k = Vec4::ONE + dot(lanes.normal, normal);
        if let Some(known) = self.lean {
            let t = dot(lanes.lean, normal) / k;
            let lean = [0, 1, 2].map(|i| lanes.lean[i] - (lanes.normal[i] + normal[i]) * t - Vec4::splat(known[i]));
            distance += dot(lean, lean) * (1.0 / (LEAN_WIDTH * LEAN_WIDTH));
        }
        let unclear = off_square.cmple(lanes.own_place_square) | k.cmplt(Vec4::splat(OPPOSITE));
        Vec4::select(unclear, Vec4::NEG_INFINITY, distance * (1.0 - ROUNDING))
    }
}
