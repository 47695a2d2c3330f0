//! The runtime tolerance: what an instance may leave out, so that distant bodies cost less and no vertex is visibly
//! wrong.
//!
//! A part is one example of one mark. A part's displacement of a vertex is left out if it is no longer than the
//! threshold `t`. The rule depends on one vertex and one part alone, so vertices at one position agree whatever blocks
//! they are in. It follows that some blocks and parts need not be read at all. `t` is the same for the whole instance.
//! When it changes, everything that the old or the new threshold shows is written again.
//!
//! **No vertex is wrong by more than the tolerance.** At a vertex, let `e` be the sum of the lengths left out. `S` moves
//! by at most `e`, by the triangle inequality. Then `position = base + P(S)`, where `P` is the projection onto the ball
//! of radius `L`. `P(S)` moves by no more than `S` does. So the vertex moves by at most `e`.
//!
//! A part leaves out at most `t`, and at most its longest displacement in the block. [`threshold`] takes the greatest
//! `t`, among the tolerance and its halves, for which this bound holds in every block. Rounding of f32 comes on top.
//! Stored normals are left out only with a whole part.

use crate::damage::dent::Dent;
use crate::example::set::ExampleSet;

/// Margin for the rounding of thresholds and sums.
const MARGIN: f32 = 0.999;
/// Number of thresholds tried, each half of the one before.
const STEPS: i32 = 30;

/// `tolerance` (m) rounded down to a power of two times 1 m; 0 if it is subnormal.
pub(crate) fn rounded(tolerance: f32) -> f32 {
    // Keeps only the exponent.
    f32::from_bits(tolerance.to_bits() & 0x7F80_0000)
}

/// The threshold, m. Scaled displacements of a part that are no longer may be left out.
pub(crate) fn threshold(set: &ExampleSet, dents: &[Dent], tolerance: f32) -> f32 {
    if tolerance <= 0.0 {
        return 0.0;
    }
    let firsts: Vec<usize> = set
        .lods()
        .scan(0, |n, s| {
            let first = *n;
            *n += s.blocks();
            Some(first)
        })
        .collect();
    let count: usize = set.lods().map(|s| s.blocks()).sum();
    let mut lengths: Vec<(u32, f32)> = Vec::new();
    for dent in dents {
        for (lod, first) in set.lods().zip(&firsts) {
            dent.lengths(lod, |block, longest| lengths.push(((first + block) as u32, longest)));
        }
    }
    let allowed = f64::from(tolerance * MARGIN);
    let mut sums = vec![0.0f64; count];
    for step in 0..STEPS {
        let t = tolerance * MARGIN * 0.5f32.powi(step);
        sums.fill(0.0);
        lengths.iter().for_each(|(at, longest)| sums[*at as usize] += f64::from(longest.min(t)));
        if sums.iter().all(|sum| *sum <= allowed) {
            return t;
        }
    }
    0.0
}

/// How much longer than the error that is allowed the edges of a level of detail may be. Measured in the lab's scene
/// (docs/lab, "A scene"): there, for up to two pixels, the dents of 99 in 100 pixels are wrong by less than a fifth of that.
pub(crate) const EDGES: f32 = 16.0;

/// Returns the length (m) that covers `pixels` pixels at `distance` (m) from a camera with this vertical field of view
/// (radians) and viewport height (pixels). Use it as the tolerance of an instance whose nearest vertex is at that
/// distance. The result is at most 1e9 m. It is 0, which leaves out nothing, if a value is negative or NaN, the field
/// of view is not between 0 and π, or the height is 0.
pub fn pixel_tolerance(pixels: f32, distance: f32, fov_y: f32, viewport_height: f32) -> f32 {
    let sensible =
        pixels >= 0.0 && distance >= 0.0 && fov_y > 0.0 && fov_y < std::f32::consts::PI && viewport_height > 0.0;
    if !sensible {
        return 0.0;
    }
    let at_one = 2.0 * libm::tanf(fov_y * 0.5) / viewport_height;
    let length = pixels * distance * at_one;
    if length.is_nan() { 0.0 } else { length.min(1e9) }
}
