//! The kernel of vertices that follow nodes: weighted sums of the nodes' displacements ([`crate::basis`]).
//!
//! Sums are whole numbers below 2^24, so they have the same bits at every level and in any order. As in [`super::kernel`], every
//! function is `unsafe` because the processor must support the level's instructions.

#![expect(clippy::undocumented_unsafe_blocks, reason = "where none is given, it is the one above")]

use super::kernel::{Extent, V, add, each, kept_share, load3, normal, scaled, store3};
use super::simd::Simd;
use crate::basis::TILE;
use crate::mesh::limits::BlockLimits;
use crate::mesh::vertex_blocks::BLOCK;
use glam::Vec3;

/// The vertices of one tile and the nodes that they follow.
pub(crate) struct Following<'a> {
    /// Undeformed positions of the block x y z x y z …, and unit normals if they are wanted.
    pub base: &'a [f32; 3 * BLOCK],
    pub base_normals: Option<&'a [f32; 3 * BLOCK]>,
    /// The tile's first vertex in the block, and the number of its vertices.
    pub first: usize,
    pub len: usize,
    /// For each pair of nodes the steps of both, 16 bits each, along x, y and z.
    pub moves: &'a [[i32; 3]],
    /// [`TILE`] pairs of weights for each pair of nodes.
    pub weights: &'a [i8],
    /// The same for slopes along both tangents, first all pairs of one, then all of the other. Empty without normals.
    pub slopes: &'a [i8],
    /// What a sum of weights times steps is multiplied by, m.
    pub unit: f32,
    /// The unit of each vertex's slopes, 1/m, [`TILE`] of them, and the step, m. Empty without normals.
    pub slope_units: &'a [f32],
    pub step: f32,
    /// The depth limit, m; `None` if nothing reaches it.
    pub limit: Option<f32>,
    /// The limits of the block's vertices; `None` if nothing reaches them.
    pub own: Option<BlockLimits<'a>>,
}

/// Groups of lanes that are summed side by side, so that each pair's steps are loaded once for all of them.
const GROUPS: usize = 2;

/// Weighted sums of the pairs' steps for the lanes of some groups, the first of which begins with vertex `at` of the tile.
#[inline(always)]
unsafe fn sums<S: Simd>(moves: &[[i32; 3]], weights: *const i8, at: usize) -> [[S::I; 3]; GROUPS] {
    // SAFETY: the caller passes the weights of as many pairs, for whole tiles.
    unsafe {
        let mut sums = [[S::splat_int(0); 3]; GROUPS];
        for (pair, moves) in moves.iter().enumerate() {
            let own = weights.add(2 * (pair * TILE + at));
            let steps = each!(k => S::splat_int(moves[k]));
            for (group, sum) in sums.iter_mut().enumerate() {
                let w = S::load_pairs(own.add(2 * group * S::LANES));
                *sum = each!(k => S::add_int(sum[k], S::dot_pairs(w, steps[k])));
            }
        }
        sums
    }
}

/// Vectors of whole numbers times `unit`.
#[inline(always)]
unsafe fn in_units<S: Simd>(v: [S::I; 3], unit: S::F) -> V<S> {
    unsafe { each!(k => S::mul(S::float(v[k]), unit)) }
}

/// Writes deformed positions, and unit normals if `NORMALS`, of the tile's vertices. Returns the bounds of the positions.
#[inline(always)]
pub(crate) unsafe fn follow<S: Simd, const NORMALS: bool>(
    tile: &Following<'_>,
    positions: &mut [f32; 3 * BLOCK],
    normals: &mut [f32; 3 * BLOCK],
) -> (Vec3, Vec3) {
    let pairs = tile.moves.len();
    assert!(tile.weights.len() == 2 * TILE * pairs && tile.first + TILE <= BLOCK && tile.len <= TILE);
    assert!(!NORMALS || tile.slopes.len() == 4 * TILE * pairs && tile.slope_units.len() == TILE);
    // SAFETY: guaranteed by the caller; the lanes lie in the tile, which lies in the block.
    unsafe {
        let mut extent = Extent::<S>::new();
        for at in (0..tile.len).step_by(GROUPS * S::LANES) {
            let moved = sums::<S>(tile.moves, tile.weights.as_ptr(), at);
            let mut factors = [S::splat(1.0); GROUPS];
            for group in 0..GROUPS {
                let here = tile.first + at + group * S::LANES;
                let s = in_units::<S>(moved[group], S::splat(tile.unit));
                factors[group] = kept_share::<S>(s, tile.limit, tile.own, here);
                let p = add::<S>(load3::<S>(tile.base.as_ptr().add(3 * here)), scaled::<S>(s, factors[group]));
                store3::<S>(p, positions.as_mut_ptr().add(3 * here));
                let end = at + (group + 1) * S::LANES;
                if end <= tile.len {
                    extent.add(p);
                } else if end - S::LANES < tile.len {
                    extent.add_rest(&positions[3 * here..3 * (tile.first + tile.len)]);
                }
            }
            let Some(base) = tile.base_normals.filter(|_| NORMALS) else { continue };
            let along_x = sums::<S>(tile.moves, tile.slopes.as_ptr(), at);
            let along_y = sums::<S>(tile.moves, tile.slopes.as_ptr().add(2 * TILE * pairs), at);
            for group in 0..GROUPS {
                let here = tile.first + at + group * S::LANES;
                let n = load3::<S>(base.as_ptr().add(3 * here));
                let slopes = [along_x[group], along_y[group]];
                let units = S::load(tile.slope_units.as_ptr().add(at + group * S::LANES));
                let unit = S::mul(S::splat(tile.step), units);
                let [a, b] = [in_units::<S>(slopes[0], unit), in_units::<S>(slopes[1], unit)];
                let change = turned::<S>(n, a, b);
                let n = normal::<S>(n, change, scaled::<S>(change, factors[group]));
                store3::<S>(n, normals.as_mut_ptr().add(3 * here));
            }
        }
        extent.bounds()
    }
}

/// What slopes `a` and `b` of the displacement along the two tangents add to the normal: `(x + a) × (y + b) - n`. The tangents are
/// those of [`crate::basis::slopes::frame`], by the same operations.
#[inline(always)]
unsafe fn turned<S: Simd>(n: V<S>, a: V<S>, b: V<S>) -> V<S> {
    unsafe {
        let (one, zero) = (S::splat(1.0), S::splat(0.0));
        let sign = S::select(S::greater(zero, n[2]), S::splat(-1.0), one);
        let c = S::div(S::splat(-1.0), S::add(sign, n[2]));
        let d = S::mul(S::mul(n[0], n[1]), c);
        let sx = S::mul(sign, n[0]);
        let x = [S::add(one, S::mul(S::mul(sx, n[0]), c)), S::mul(sign, d), S::sub(zero, sx)];
        let y = [d, S::add(sign, S::mul(S::mul(n[1], n[1]), c)), S::sub(zero, n[1])];
        let sum = add::<S>(cross::<S>(x, b), cross::<S>(a, y));
        add::<S>(sum, cross::<S>(a, b))
    }
}

#[inline(always)]
unsafe fn cross<S: Simd>(a: V<S>, b: V<S>) -> V<S> {
    unsafe {
        [
            S::sub(S::mul(a[1], b[2]), S::mul(a[2], b[1])),
            S::sub(S::mul(a[2], b[0]), S::mul(a[0], b[2])),
            S::sub(S::mul(a[0], b[1]), S::mul(a[1], b[0])),
        ]
    }
}
