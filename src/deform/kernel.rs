//! What the kernels share: vectors of several lanes, the limits of vertices, and normals.
//!
//! Kernels are generic over [`Simd`]. Operations and their order are the same at every level and width, so results have the same
//! bits.
//!
//! Every function here is `unsafe` for one reason: it may run only if the processor supports the level's instructions.
//! Pointers come from slices and arrays of stated lengths.

#![expect(clippy::undocumented_unsafe_blocks, reason = "where none is given, it is the one above")]
#![expect(clippy::needless_range_loop, reason = "x, y and z side by side read better by their number")]

use super::simd::Simd;
use crate::mesh::limits::{BlockLimits, LEAST_LENGTH};
use crate::mesh::vertex_blocks::BLOCK;
use glam::Vec3;

/// The vertices of one block, x y z x y z ….
pub(crate) type Flat = [f32; 3 * BLOCK];

/// A whole block: `from`, or a copy in `scratch` padded with zeros if `from` is short.
pub(crate) fn whole<'b>(from: &'b [f32], scratch: &'b mut Flat) -> &'b Flat {
    if let Some(whole) = from.first_chunk() {
        return whole;
    }
    scratch.fill(0.0);
    scratch[..from.len()].copy_from_slice(from);
    scratch
}

/// Evaluates an expression for x, y and z. There are no closures here or below: they would not be compiled for the
/// level.
macro_rules! each {
    ($k:ident => $e:expr) => {
        [
            {
                let $k = 0;
                $e
            },
            {
                let $k = 1;
                $e
            },
            {
                let $k = 2;
                $e
            },
        ]
    };
}

pub(super) use each;

/// One vector per lane, component by component.
pub(super) type V<S> = [<S as Simd>::F; 3];

#[inline(always)]
pub(super) unsafe fn add<S: Simd>(a: V<S>, b: V<S>) -> V<S> {
    // SAFETY: guaranteed by the caller, here and below.
    unsafe { each!(k => S::add(a[k], b[k])) }
}

#[inline(always)]
pub(super) unsafe fn scaled<S: Simd>(a: V<S>, f: S::F) -> V<S> {
    unsafe { each!(k => S::mul(a[k], f)) }
}

#[inline(always)]
pub(super) unsafe fn dot<S: Simd>(a: V<S>, b: V<S>) -> S::F {
    unsafe { S::add(S::add(S::mul(a[0], b[0]), S::mul(a[1], b[1])), S::mul(a[2], b[2])) }
}

#[inline(always)]
pub(super) unsafe fn select<S: Simd>(m: S::M, a: V<S>, b: V<S>) -> V<S> {
    unsafe { each!(k => S::select(m, a[k], b[k])) }
}

/// Loads `3 * LANES` floats x y z x y z … from `p` and separates the components.
#[inline(always)]
pub(super) unsafe fn load3<S: Simd>(p: *const f32) -> V<S> {
    // SAFETY: the caller guarantees that the floats are valid.
    unsafe { S::deinterleave(each!(k => S::load(p.add(k * S::LANES)))) }
}

/// The inverse of [`load3`].
#[inline(always)]
pub(super) unsafe fn store3<S: Simd>(v: V<S>, p: *mut f32) {
    // SAFETY: the caller guarantees that the floats are valid.
    unsafe {
        let v = S::interleave(v);
        for k in 0..3 {
            S::store(p.add(k * S::LANES), v[k]);
        }
    }
}

/// Lowest and highest coordinates seen so far.
pub(super) struct Extent<S: Simd> {
    low: V<S>,
    high: V<S>,
    rest: (Vec3, Vec3),
}

impl<S: Simd> Extent<S> {
    #[inline(always)]
    pub(super) unsafe fn new() -> Self {
        let (low, high) = (f32::INFINITY, f32::NEG_INFINITY);
        // SAFETY: guaranteed by the caller, here and below.
        unsafe {
            Extent { low: [S::splat(low); 3], high: [S::splat(high); 3], rest: (Vec3::splat(low), Vec3::splat(high)) }
        }
    }

    /// Adds vectors.
    #[inline(always)]
    unsafe fn add(&mut self, v: V<S>) {
        for k in 0..3 {
            unsafe {
                self.low[k] = S::min(v[k], self.low[k]);
                self.high[k] = S::max(v[k], self.high[k]);
            }
        }
    }

    /// Adds those lanes that are among a tile's vertices, `written` x y z x y z …. The lanes are `group` groups after the first.
    #[inline(always)]
    pub(super) unsafe fn add_some(&mut self, v: V<S>, written: &[f32], group: usize) {
        let (first, len) = (group * S::LANES, written.len() / 3);
        if first + S::LANES <= len {
            unsafe { self.add(v) };
        } else {
            for v in written[3 * first.min(len)..].as_chunks::<3>().0 {
                self.rest.0 = self.rest.0.min(Vec3::from_array(*v));
                self.rest.1 = self.rest.1.max(Vec3::from_array(*v));
            }
        }
    }

    /// The bounds of all vectors.
    #[inline(always)]
    pub(super) unsafe fn bounds(self) -> (Vec3, Vec3) {
        let (mut low, mut high) = (Vec3::ZERO, Vec3::ZERO);
        for k in 0..3 {
            unsafe {
                low[k] = S::lowest(self.low[k]);
                high[k] = S::highest(self.high[k]);
            }
        }
        let rest = &self.rest;
        if rest.0.x > rest.1.x { (low, high) } else { (low.min(rest.0), high.max(rest.1)) }
    }
}

/// Writes normals, x y z x y z …, in [`crate::Encoding::Octahedral16x2`], which has the formula.
#[inline(always)]
pub(crate) unsafe fn octahedral<S: Simd>(normals: &Flat, to: &mut [u32; BLOCK]) {
    // SAFETY: guaranteed by the caller; lanes lie in the block.
    unsafe {
        for at in (0..BLOCK).step_by(S::LANES) {
            let v = load3::<S>(normals.as_ptr().add(3 * at));
            let length = S::add(S::add(absolute::<S>(v[0]), absolute::<S>(v[1])), absolute::<S>(v[2]));
            let n = each!(k => S::div(v[k], length));
            let below = S::greater(S::splat(0.0), n[2]);
            let a = S::select(below, folded::<S>(n[0], n[1]), n[0]);
            let b = S::select(below, folded::<S>(n[1], n[0]), n[1]);
            S::store_int(to.as_mut_ptr().add(at).cast(), S::packed(word::<S>(a, length), word::<S>(b, length)));
        }
    }
}

#[inline(always)]
unsafe fn absolute<S: Simd>(x: S::F) -> S::F {
    unsafe { S::max(x, S::sub(S::splat(0.0), x)) }
}

/// A coordinate of the octahedron's lower half, unfolded, with the sign that it had.
#[inline(always)]
unsafe fn folded<S: Simd>(x: S::F, other: S::F) -> S::F {
    unsafe {
        let (zero, one) = (S::splat(0.0), S::splat(1.0));
        S::mul(S::sub(one, absolute::<S>(other)), S::select(S::greater(zero, x), S::splat(-1.0), one))
    }
}

/// A coordinate from -1 to 1 as 0 to 65535, of a vector with this length; 0.5 for one without.
#[inline(always)]
unsafe fn word<S: Simd>(x: S::F, length: S::F) -> S::I {
    unsafe {
        let half = S::splat(0.5);
        let x = S::select(S::greater(length, S::splat(0.0)), S::add(S::mul(x, half), half), half);
        let x = S::select(S::greater(length, S::splat(f32::MAX)), half, x);
        S::truncate(S::mul(x, S::splat(65535.0)))
    }
}

/// The share of the displacements `s` of some lanes that the depth limit and the vertices' own limits leave, exactly 1 where nothing
/// is shortened. `at` is the first lane's vertex in the block.
#[inline(always)]
pub(super) unsafe fn kept_share<S: Simd>(s: V<S>, limit: Option<f32>, own: Option<BlockLimits<'_>>, at: usize) -> S::F {
    // SAFETY: guaranteed by the caller; lanes `at` to `at + LANES` lie in the block.
    unsafe {
        if limit.is_none() && own.is_none() {
            return S::splat(1.0);
        }
        let length = S::max(S::sqrt(dot::<S>(s, s)), S::splat(LEAST_LENGTH));
        let mut allowed = length;
        if let Some(gives) = own.and_then(|own| own.gives) {
            allowed = S::mul(allowed, S::load_halves(gives.as_ptr().add(at)));
        }
        if let Some(limit) = limit {
            allowed = S::min(S::splat(limit), allowed);
        }
        if let Some(depths) = own.and_then(|own| own.depths) {
            allowed = S::min(S::load_halves(depths.as_ptr().add(at)), allowed);
        }
        S::select(S::greater(length, allowed), S::div(allowed, length), S::splat(1.0))
    }
}

/// The unit vector along `n + change`; `n` itself if `sum` is zero or the result is too short, or longer than floats tell.
#[inline(always)]
pub(super) unsafe fn normal<S: Simd>(n: V<S>, sum: V<S>, change: V<S>) -> V<S> {
    // SAFETY: guaranteed by the caller.
    unsafe {
        let zero = S::splat(0.0);
        let same = S::both(S::equal(sum[0], zero), S::both(S::equal(sum[1], zero), S::equal(sum[2], zero)));
        let v = add::<S>(n, change);
        let square = dot::<S>(v, v);
        let long = S::both(S::greater(square, S::splat(1e-12)), S::greater(S::splat(1e38), square));
        let v = scaled::<S>(v, S::div(S::splat(1.0), S::sqrt(square)));
        select::<S>(same, n, select::<S>(long, v, n))
    }
}
