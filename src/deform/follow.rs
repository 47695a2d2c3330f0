//! The kernel of vertices that follow nodes: weighted sums of the nodes' displacements ([`crate::basis`]).
//!
//! Sums are whole numbers below 2^24, so they have the same bits at every level and in any order. As in [`super::kernel`], every
//! function is `unsafe` because the processor must support the level's instructions.

#![expect(clippy::undocumented_unsafe_blocks, reason = "where none is given, it is the one above")]

use super::kernel::{Extent, Flat, V, add, each, kept_share, load3, normal, scaled, store3};
use super::simd::Simd;
use super::view::{NodeView, may_reach};
use crate::base::pairs::{Pairs, paired};
use crate::basis::{ONE, Rows, TILE};
use crate::mesh::limits::BlockLimits;
use crate::mesh::vertex_blocks::BLOCK;
use glam::Vec3;

/// The vertices of one block and the nodes that they follow.
pub(crate) struct Following<'a> {
    /// Undeformed positions of the block x y z x y z ….
    pub base: &'a Flat,
    /// Number of its vertices.
    pub len: usize,
    pub rows: &'a Rows,
    /// Its first tile.
    pub tile: usize,
    pub nodes: NodeView<'a>,
    /// The depth limit, m.
    pub limit: f32,
    /// The limits of the block's vertices, and the least of them, m.
    pub own: Option<(f32, BlockLimits<'a>)>,
}

/// For each pair of a tile's nodes the steps of both, 16 bits each, along x, y and z.
pub(crate) type Moves = Vec<Pairs>;

/// Gathers the steps of a tile's nodes. Returns the longest displacement, in steps: 0 if none moves.
#[inline(always)]
fn gather(nodes: NodeView<'_>, of_tile: &[u32], moves: &mut Moves) -> u16 {
    let pairs = of_tile.as_chunks::<2>().0;
    moves.resize(pairs.len(), [0; 4]);
    let mut most = [0u16; 8];
    for ([a, b], to) in pairs.iter().zip(moves) {
        *to = paired(nodes.steps[*a as usize], nodes.steps[*b as usize]);
        let numbers: [u16; 8] = bytemuck::cast(*to);
        most.iter_mut().zip(numbers).for_each(|(most, x)| *most = (*most).max(x));
    }
    most[6].max(most[7])
}

/// Weighted sums of the pairs' steps for all vertices of a tile, with each set of weights. Groups of lanes and sets are summed side by
/// side, so that each pair's steps are loaded once.
#[inline(always)]
unsafe fn sums<S: Simd, const GROUPS: usize, const SETS: usize>(
    moves: &[Pairs],
    weights: [*const i8; SETS],
) -> [[[S::I; 3]; GROUPS]; SETS] {
    // SAFETY: the caller passes where the weights of as many pairs begin, for whole tiles.
    unsafe {
        let mut sums = [[[S::splat_int(0); 3]; GROUPS]; SETS];
        for (pair, moves) in moves.iter().enumerate() {
            let steps = each!(k => S::splat_int(moves[k]));
            for (sums, weights) in sums.iter_mut().zip(weights) {
                let own = weights.add(2 * pair * TILE);
                for (group, sum) in sums.iter_mut().enumerate() {
                    let w = S::load_pairs(own.add(2 * group * S::LANES));
                    *sum = each!(k => S::add_pairs(sum[k], w, steps[k]));
                }
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

/// The undeformed unit normals of a block, and where to write them.
pub(crate) type Normals<'a> = Option<(&'a Flat, &'a mut Flat)>;

/// Writes deformed positions, and with `NORMALS` unit normals, of the block's vertices: [`TILE`] are `GROUPS` times the lanes.
/// `moves` is memory to use. Returns the bounds of the positions.
#[inline(always)]
pub(crate) unsafe fn follow<S: Simd, const GROUPS: usize, const NORMALS: bool>(
    block: &Following<'_>,
    moves: &mut Moves,
    positions: &mut Flat,
    normals: Normals<'_>,
) -> (Vec3, Vec3) {
    let mut normals = normals.filter(|_| NORMALS);
    const { assert!(GROUPS * S::LANES == TILE) };
    assert!(block.len <= BLOCK);
    // SAFETY: guaranteed by the caller; the lanes lie in a tile, which lies in the block.
    unsafe {
        let mut extent = Extent::<S>::new();
        for (tile, first) in (block.tile..).zip((0..block.len).step_by(TILE)) {
            let longest = gather(block.nodes, block.rows.nodes_of(tile), moves);
            let (at, len) = (3 * first, (block.len - first).min(TILE));
            if longest == 0 {
                for group in 0..GROUPS {
                    let here = at + 3 * group * S::LANES;
                    let p = load3::<S>(block.base.as_ptr().add(here));
                    store3::<S>(p, positions.as_mut_ptr().add(here));
                    extent.add_some(p, &positions[at..at + 3 * len], group);
                }
                if let Some((base, normals)) = &mut normals {
                    normals[at..at + 3 * TILE].copy_from_slice(&base[at..at + 3 * TILE]);
                }
                continue;
            }
            // No vertex moves further.
            let most = block.rows.tiles[tile].most as f32 / ONE as f32;
            let longest = f32::from(longest) * block.nodes.step * most;
            let limit = Some(block.limit).filter(|limit| may_reach(longest, *limit));
            let own = block.own.filter(|(least, _)| may_reach(longest, *least)).map(|(_, own)| own);
            let weights = block.rows.weights_of(tile);
            assert!(weights.len() == 2 * TILE * moves.len());
            let [moved, along_x, along_y] = if NORMALS {
                let slopes = block.rows.slopes_of(tile).unwrap_or_default();
                assert!(slopes.len() == 2 * weights.len());
                let sets = [weights.as_ptr(), slopes.as_ptr(), slopes.as_ptr().add(weights.len())];
                sums::<S, GROUPS, 3>(moves, sets)
            } else {
                let [moved] = sums::<S, GROUPS, 1>(moves, [weights.as_ptr()]);
                [moved; 3]
            };
            let unit = S::splat(block.nodes.step / ONE as f32);
            let mut factors = [S::splat(1.0); GROUPS];
            for group in 0..GROUPS {
                let here = first + group * S::LANES;
                let s = in_units::<S>(moved[group], unit);
                factors[group] = kept_share::<S>(s, limit, own, here);
                let p = add::<S>(load3::<S>(block.base.as_ptr().add(3 * here)), scaled::<S>(s, factors[group]));
                store3::<S>(p, positions.as_mut_ptr().add(3 * here));
                extent.add_some(p, &positions[at..at + 3 * len], group);
            }
            let Some((base, normals)) = &mut normals else { continue };
            let units = block.rows.slope_units_of(tile);
            assert!(units.len() == TILE);
            for group in 0..GROUPS {
                let here = 3 * (first + group * S::LANES);
                let n = load3::<S>(base.as_ptr().add(here));
                let units = S::load(units.as_ptr().add(group * S::LANES));
                let unit = S::mul(S::splat(block.nodes.step), units);
                let [a, b] = [in_units::<S>(along_x[group], unit), in_units::<S>(along_y[group], unit)];
                let change = turned::<S>(n, a, b);
                let n = normal::<S>(n, change, scaled::<S>(change, factors[group]));
                store3::<S>(n, normals.as_mut_ptr().add(here));
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
