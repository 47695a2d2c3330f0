//! A hit that is an example's own gives that example.

use super::features::{Point, STRENGTH_AXIS, differences};
use glam::Vec3;

/// Differences at which an example's own field has no more weight: place over the diagonal, normal, logarithms of
/// strength, mass and radius, direction.
const REACH: [f64; 6] = [0.01, 0.1, 0.05, 0.05, 0.05, 0.05];
/// The logarithm of the size stays within this many times the distance of a near example's.
const CONE: f64 = 1.0;
/// And within this many times the difference of the strengths.
const STEEP: f64 = 4.0;

/// Distance of two hits but for their strengths, in units of [`REACH`]; infinite for another kind.
fn apart(a: &Point, b: &Point) -> f64 {
    let d = differences(a, b);
    if d[6] != 0.0 {
        return f64::INFINITY;
    }
    (0..6).filter(|g| *g != 2).map(|g| d[g] / (REACH[g] * REACH[g])).sum::<f64>().sqrt()
}

/// The example whose own hit is nearest to `x`, and the weight of its field, 0 to 1: 1 up to half the reach.
pub(super) fn nearest(points: &[Point], x: &Point) -> Option<(usize, f64)> {
    let mut best = (1.0, None);
    for (i, p) in points.iter().enumerate() {
        if (p[0] - x[0]).abs() < REACH[0] && (p[STRENGTH_AXIS] - x[STRENGTH_AXIS]).abs() < REACH[2] {
            let strength = (p[STRENGTH_AXIS] - x[STRENGTH_AXIS]) / REACH[2];
            let d = apart(p, x);
            let d = (d * d + strength * strength).sqrt();
            if d < best.0 {
                best = (d, Some(i));
            }
        }
    }
    let t = (2.0 - 2.0 * best.0).clamp(0.0, 1.0);
    best.1.map(|i| (i, t * t * (3.0 - 2.0 * t)))
}

/// `log`, kept within the cones around the sizes (logarithms) of near examples. It never falls with the strength of `x`
/// if `log` does not.
pub(super) fn within_cones(points: &[Point], logs: &[f64], x: &Point, mut log: f64) -> f64 {
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    for (p, own) in points.iter().zip(logs) {
        // A cone that is wider than any correction need not be looked at.
        if (p[0] - x[0]).abs() > 3.0 * REACH[0] || (p[1] - x[1]).abs() > 3.0 * REACH[0] {
            continue;
        }
        let d = CONE * apart(p, x);
        let harder = x[STRENGTH_AXIS] - p[STRENGTH_AXIS];
        low = low.max(own - d - STEEP * (-harder).max(0.0));
        high = high.min(own + d + STEEP * harder.max(0.0));
    }
    log = log.max(low);
    log.min(high)
}

/// The fields of the samples that a rule was learned from, which it does not keep.
pub trait Fields {
    /// Calls `f` with each point that the sample moves, and its displacement, m.
    fn moved(&self, sample: usize, f: &mut dyn FnMut(usize, Vec3));
}
