//! The tolerance at run time: what an instance may leave out, so that far bodies cost less and no vertex is visibly wrong.
//!
//! A displacement that a part (one example of one mark) brings to a vertex is left out where it is no longer than the threshold
//! `t`. That rule looks at one vertex and one part alone, so vertices at one position agree whatever blocks they are in; that
//! whole blocks and whole parts need not be read follows from it. `t` is one number for the whole instance at any time: where
//! it changes, all that either threshold shows is written anew.
//!
//! **No vertex is wrong by more than the tolerance.** At a vertex, let the lengths left out sum to `e`, those of mark m to `e_m`.
//! `position = base + P_r(S)`, with `P_r` the projection onto the ball of radius `r` and `r = min(sqrt Q, L)` (energies),
//! `r = min(max |u_m|, L)` (deepest) or `r = L` (sum). Then
//!
//! - `S` moves by at most `e`, by the triangle inequality;
//! - `sqrt Q` is the length of the vector of all `|u_m|`, so it changes by at most `sqrt(sum of e_m²) <= e`; the greatest `|u_m|`
//!   changes by at most the greatest `e_m`; `L` does not change; a minimum changes by no more than what it is of;
//! - `P_r(S)` moves by no more than `S` does where `r` stays, and by no more than `r` does where `S` stays.
//!
//! So the vertex moves by at most `2 e`; by at most `e` where a lone mark is (there `sqrt Q = |S|`, and only `L` shortens) or
//! lengths are summed. Of a part no more is left out than `t`, nor than its longest displacement in the block: [`threshold`]
//! takes the greatest `t` (of the tolerance and its halves) for which this bound holds in every block. Rounding of f32 comes on
//! top. Stored normals are left out only with a whole part.

use crate::damage::dent::Dent;
use crate::example::options::Combine;
use crate::example::set::ExampleSet;

/// Leaves room for the rounding of thresholds and sums.
const MARGIN: f32 = 0.999;
/// Halvings that are tried.
const STEPS: i32 = 30;

/// `tolerance` (m) rounded down to a power of two times 1 m; 0 where it is too small to tell.
pub(crate) fn rounded(tolerance: f32) -> f32 {
    // The exponent alone.
    f32::from_bits(tolerance.to_bits() & 0x7F80_0000)
}

/// Displacements of a part no longer than this, as scaled, may be left out, m.
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
    // Of each block of each lod the dents that touch it: none, one, or more.
    let (mut last, mut several) = (vec![usize::MAX; count], vec![set.options().combine == Combine::Deepest; count]);
    let mut lengths: Vec<(u32, f32)> = Vec::new();
    for (i, dent) in dents.iter().enumerate() {
        for (lod, first) in set.lods().zip(&firsts) {
            dent.lengths(set, lod, |block, longest| {
                let at = first + block;
                several[at] |= last[at] != usize::MAX && last[at] != i;
                last[at] = i;
                lengths.push((at as u32, longest));
            });
        }
    }
    let allowed = f64::from(tolerance * MARGIN);
    let twice = set.options().combine != Combine::Sum;
    let mut sums = vec![0.0f64; count];
    for step in 0..STEPS {
        let t = tolerance * MARGIN * 0.5f32.powi(step);
        sums.fill(0.0);
        lengths.iter().for_each(|(at, longest)| sums[*at as usize] += f64::from(longest.min(t)));
        let fits = |(sum, several): (&f64, &bool)| if *several && twice { 2.0 * sum } else { *sum } <= allowed;
        if sums.iter().zip(&several).all(fits) {
            return t;
        }
    }
    0.0
}

/// The length (m) that covers so many pixels at a distance (m) before a camera with this vertical field of view (radians) and
/// viewport height (pixels): the tolerance of an instance whose nearest vertex is that far off. 0, which leaves out nothing,
/// where a value is negative or not a number, the field of view is not below half a turn, or the height is 0; at most 1e9 m.
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
