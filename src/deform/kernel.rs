//! The kernels, which compute vertices from stored displacements and stamps, several lanes at a time.
//!
//! Each visits one block's vertices once, with all sums in registers, and is generic over [`Simd`]. Operations and
//! their order are the same at every level and width, so results have the same bits.
//!
//! Every function here is `unsafe` for one reason: it may run only if the processor supports the level's instructions.
//! Pointers come from slices and arrays of stated lengths.

#![expect(clippy::undocumented_unsafe_blocks, reason = "where none is given, it is the one above")]
#![expect(clippy::needless_range_loop, reason = "x, y and z side by side read better by their number")]

use super::simd::Simd;
use crate::damage::carried::{Carried, Lookup};
use crate::example::blocks::{GROUP, GROUPS, Numbers, Stored};
use crate::example::stamp::{FACING, Node, WEIGHTS};
use crate::mesh::limits::{BlockLimits, LEAST_LENGTH};
use crate::mesh::rim::WindowBlock;
use crate::mesh::vertex_blocks::BLOCK;
use glam::Vec3;
use std::ops::Range;

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

/// `m * v`.
#[inline(always)]
unsafe fn turned<S: Simd>(m: &[f32; 9], v: V<S>) -> V<S> {
    unsafe {
        each!(k => S::add(
            S::add(S::mul(S::splat(m[k]), v[0]), S::mul(S::splat(m[3 + k]), v[1])),
            S::mul(S::splat(m[6 + k]), v[2])
        ))
    }
}

/// Sets vectors no longer than `threshold` to zero. A threshold of 0 keeps all.
#[inline(always)]
unsafe fn cut<S: Simd>(v: V<S>, threshold: f32) -> V<S> {
    unsafe {
        if threshold > 0.0 {
            let keep = S::greater(dot::<S>(v, v), S::splat(threshold * threshold));
            select::<S>(keep, v, [S::splat(0.0); 3])
        } else {
            v
        }
    }
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

/// Stored numbers of one group as floats, x y z x y z ….
#[inline(always)]
unsafe fn numbers<S: Simd>(stored: &Numbers<'_>, group: usize) -> V<S> {
    let at = group * 3 * GROUP;
    let end = at + 3 * GROUP;
    // SAFETY: the slicing checks that the group exists.
    unsafe {
        match stored {
            Numbers::I8(n) => {
                let n = &n[at..end];
                each!(k => S::load_i8(n.as_ptr().add(k * GROUP)))
            }
            Numbers::I16(n) => {
                let n = &n[at..end];
                each!(k => S::load_i16(n.as_ptr().add(k * GROUP)))
            }
            Numbers::F32(n) => {
                let n = &n[at..end];
                each!(k => S::load(n.as_ptr().add(k * GROUP)))
            }
        }
    }
}

/// Length of the longest stored vector. All numbers must be finite. `S` must have `GROUP` lanes.
#[inline(always)]
pub(crate) unsafe fn longest<S: Simd>(stored: &Stored<'_>) -> f32 {
    // SAFETY: guaranteed by the caller.
    unsafe {
        let (step, mut most) = (S::splat(stored.step), S::splat(0.0));
        for kept in 0..stored.groups.count_ones() as usize {
            let v = scaled::<S>(S::deinterleave(numbers::<S>(&stored.numbers, kept)), step);
            most = S::max(dot::<S>(v, v), most);
        }
        S::highest(most).sqrt()
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

    /// Adds vectors, with components either separate or x y z x y z …, but the same way in every call.
    #[inline(always)]
    pub(super) unsafe fn add(&mut self, v: V<S>) {
        for k in 0..3 {
            unsafe {
                self.low[k] = S::min(v[k], self.low[k]);
                self.high[k] = S::max(v[k], self.high[k]);
            }
        }
    }

    /// Adds vectors x y z x y z …, one by one.
    #[inline(always)]
    pub(super) fn add_rest(&mut self, rest: &[f32]) {
        for v in rest.chunks_exact(3) {
            self.rest.0 = self.rest.0.min(Vec3::from_slice(v));
            self.rest.1 = self.rest.1.max(Vec3::from_slice(v));
        }
    }

    /// The bounds of vectors that were added with separate components.
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

    /// The bounds of vectors that were added as x y z x y z ….
    #[inline(always)]
    unsafe fn bounds_of_flat(mut self) -> (Vec3, Vec3) {
        unsafe {
            (self.low, self.high) = (S::deinterleave(self.low), S::deinterleave(self.high));
            self.bounds()
        }
    }
}

/// Writes `to = base + scale * stored`, all x y z x y z …, and returns the bounds of `to`. The result is that of
/// [`displace`] for a single dent below the depth limit, in one pass without separating components. `S` must have
/// `GROUP` lanes.
#[inline(always)]
pub(crate) unsafe fn displace_stored<S: Simd>(
    base: &[f32],
    stored: &Stored<'_>,
    scale: f32,
    to: &mut [f32],
) -> (Vec3, Vec3) {
    let scale = stored.step * scale;
    // SAFETY: guaranteed by the caller.
    unsafe {
        match stored.numbers {
            Numbers::I8(n) => displace_numbers::<S, I8>(base, I8(n), stored.groups, scale, to),
            Numbers::I16(n) => displace_numbers::<S, I16>(base, I16(n), stored.groups, scale, to),
            Numbers::F32(n) => displace_numbers::<S, F32>(base, F32(n), stored.groups, scale, to),
        }
    }
}

/// Stored numbers of one width.
trait Narrow: Copy {
    /// # Safety
    /// `at + LANES` numbers exist.
    unsafe fn load<S: Simd>(self, at: usize) -> S::F;
    fn len(self) -> usize;
    /// # Safety
    /// The processor supports the instructions.
    unsafe fn prefetch<S: Simd>(self, at: usize);
}

macro_rules! narrow {
    ($name:ident, $of:ty, $load:ident) => {
        #[derive(Clone, Copy)]
        struct $name<'a>(&'a [$of]);
        impl Narrow for $name<'_> {
            #[inline(always)]
            unsafe fn load<S: Simd>(self, at: usize) -> S::F {
                // SAFETY: guaranteed by the caller.
                unsafe { S::$load(self.0.as_ptr().add(at)) }
            }
            #[inline(always)]
            fn len(self) -> usize {
                self.0.len()
            }
            #[inline(always)]
            unsafe fn prefetch<S: Simd>(self, at: usize) {
                // SAFETY: guaranteed by the caller.
                unsafe { S::prefetch(self.0.as_ptr().wrapping_add(at)) }
            }
        }
    };
}
narrow!(I8, i8, load_i8);
narrow!(I16, i16, load_i16);
narrow!(F32, f32, load);

#[inline(always)]
unsafe fn displace_numbers<S: Simd, N: Narrow>(
    base: &[f32],
    numbers: N,
    groups: u16,
    scale: f32,
    to: &mut [f32],
) -> (Vec3, Vec3) {
    const FLOATS: usize = 3 * GROUP;
    assert!(base.len() == to.len() && numbers.len() == groups.count_ones() as usize * FLOATS);
    let whole = base.len() / FLOATS;
    let (b, o) = (base.as_ptr(), to.as_mut_ptr());
    // SAFETY: whole groups lie within the slices, with one stored group per set bit. The last group may be short; it is
    // done float by float.
    unsafe {
        let mut extent = Extent::<S>::new();
        let f = S::splat(scale);
        if groups == u16::MAX && whole == GROUPS {
            for group in 0..GROUPS {
                let at = group * FLOATS;
                // Prefetch two blocks ahead, most often the next to be written. (With prefetching, non-temporal stores
                // are slower.)
                for k in 0..2 {
                    S::prefetch(b.wrapping_add(at + BLOCK * 6 + k * 16));
                    S::prefetch_write(o.wrapping_add(at + BLOCK * 6 + k * 16));
                }
                numbers.prefetch::<S>(at + BLOCK * 6);
                let v =
                    each!(k => S::add(S::load(b.add(at + k * GROUP)), S::mul(numbers.load::<S>(at + k * GROUP), f)));
                for k in 0..3 {
                    S::store(o.add(at + k * GROUP), v[k]);
                }
                extent.add(v);
            }
            return extent.bounds_of_flat();
        }
        let mut kept = 0;
        for group in 0..whole {
            let at = group * FLOATS;
            let mut v = each!(k => S::load(b.add(at + k * GROUP)));
            if groups >> group & 1 == 1 {
                v = each!(k => S::add(v[k], S::mul(numbers.load::<S>(kept + k * GROUP), f)));
                kept += FLOATS;
            }
            for k in 0..3 {
                S::store(o.add(at + k * GROUP), v[k]);
            }
            extent.add(v);
        }
        let (b, o) = (&base[whole * FLOATS..], &mut to[whole * FLOATS..]);
        if !b.is_empty() {
            let mut u = [0.0; FLOATS];
            if groups >> whole & 1 == 1 {
                for k in 0..3 {
                    S::store(u.as_mut_ptr().add(k * GROUP), S::mul(numbers.load::<S>(kept + k * GROUP), f));
                }
            }
            for i in 0..b.len() {
                o[i] = b[i] + u[i];
            }
            extent.add_rest(o);
        }
        extent.bounds_of_flat()
    }
}

/// Writes unit normals along `base + scale * stored`, x y z x y z …. The result is that of [`displace`] for a single
/// dent below the depth limit. `S` must have `GROUP` lanes.
#[inline(always)]
pub(crate) unsafe fn turn_stored<S: Simd>(
    base: &[f32; 3 * BLOCK],
    stored: &Stored<'_>,
    scale: f32,
    to: &mut [f32; 3 * BLOCK],
) {
    let mut kept = 0;
    // SAFETY: groups within the block.
    unsafe {
        let scale = S::splat(stored.step * scale);
        for group in 0..GROUPS {
            let at = 3 * GROUP * group;
            let (from, to) = (base.as_ptr().add(at), to.as_mut_ptr().add(at));
            if stored.groups >> group & 1 == 0 {
                for k in 0..3 {
                    S::store(to.add(k * GROUP), S::load(from.add(k * GROUP)));
                }
                continue;
            }
            let change = scaled::<S>(S::deinterleave(numbers::<S>(&stored.numbers, kept)), scale);
            kept += 1;
            store3::<S>(normal::<S>(load3::<S>(from), change, change), to);
        }
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

/// One part of a dent, prepared for a block.
pub(crate) struct ReadyPart<'a> {
    pub source: Source<'a>,
    /// Factor of its displacements.
    pub scale: f32,
    /// Unscaled displacements no longer than this are left out, m.
    pub threshold: f32,
    /// Whether it is the last part of its dent.
    pub last: bool,
}

pub(crate) enum Source<'a> {
    /// Displacements and changes of normals.
    Stored(Stored<'a>, Stored<'a>),
    /// The look-ups are those of the block at these indices.
    Carried(&'a Carried, Range<usize>),
}

/// A look-up in a stamp, whose nodes these are.
pub(crate) struct ReadyLookup<'a>(pub &'a Lookup, pub &'a [Node]);

/// Sums at the vertices of some lanes.
struct Sums<S: Simd> {
    /// Displacement of the current dent, m, without what is in `carried`.
    dent: V<S>,
    /// Displacement of all dents, m, without what is in `carried`.
    all: V<S>,
    /// Change of the normal by anchored examples.
    change: V<S>,
    /// What carried examples add to `all` and to `change`, in steps.
    carried: [[S::I; 3]; 2],
}

/// Sums of the contributions of carried examples to the vertices of a block: displacements x, y, z in steps of
/// [`Block::step`], then changes of normals in steps of [`Block::turn_step`]. Integers, so contributions can be taken away again,
/// and their order does not matter.
pub(crate) type CarriedSums = [[i32; BLOCK]; 6];

/// Step of changes of normals, unless many dents need a coarser one.
pub(crate) const TURN_STEP: f32 = 1.0 / (1 << 22) as f32;
/// The most steps that one dent contributes.
pub(crate) const MOST_STEPS: f32 = (1 << 27) as f32;

/// Vectors in whole steps, `1 / per_step` long, rounded towards zero.
#[inline(always)]
unsafe fn in_steps<S: Simd>(v: V<S>, per_step: S::F) -> [S::I; 3] {
    unsafe {
        let (low, high) = (S::splat(-MOST_STEPS), S::splat(MOST_STEPS));
        each!(k => S::truncate(S::min(S::max(S::mul(v[k], per_step), low), high)))
    }
}

/// Adds steps to a sum.
#[inline(always)]
unsafe fn add_steps<S: Simd>(to: &mut [S::I; 3], steps: [S::I; 3]) {
    *to = unsafe { each!(k => S::add_int(to[k], steps[k])) };
}

/// Undeformed vertices of some lanes.
struct Rest<S: Simd> {
    position: V<S>,
    normal: V<S>,
    /// Index in the block of the first lane's vertex.
    at: usize,
}

/// Adds stored vectors. `S` has `GROUP` lanes.
#[inline(always)]
unsafe fn add_stored<S: Simd>(stored: &Stored<'_>, at: usize, scale: f32, threshold: f32, to: &mut V<S>) {
    let group = at / GROUP;
    if stored.groups >> group & 1 == 1 {
        let before = (stored.groups & ((1 << group) - 1)).count_ones() as usize;
        // SAFETY: guaranteed by the caller.
        unsafe {
            let v = S::deinterleave(numbers::<S>(&stored.numbers, before));
            *to = add::<S>(*to, scaled::<S>(cut::<S>(v, threshold / stored.step), S::splat(stored.step * scale)));
        }
    }
}

/// The transpose of `m` times `v`.
#[inline(always)]
unsafe fn turned_back<S: Simd>(m: &[f32; 9], v: V<S>) -> V<S> {
    unsafe { each!(k => dot::<S>([S::splat(m[3 * k]), S::splat(m[3 * k + 1]), S::splat(m[3 * k + 2])], v)) }
}

/// `m * v` in the plane.
#[inline(always)]
unsafe fn turned_flat<S: Simd>(m: &[f32; 4], v: [S::F; 2]) -> [S::F; 2] {
    unsafe {
        [
            S::add(S::mul(S::splat(m[0]), v[0]), S::mul(S::splat(m[2]), v[1])),
            S::add(S::mul(S::splat(m[1]), v[0]), S::mul(S::splat(m[3]), v[1])),
        ]
    }
}

/// What the look-ups of carried examples that share a frame find at the vertices of some lanes, in this frame.
struct Found<S: Simd> {
    displacement: V<S>,
    change: V<S>,
}

/// The vertices of some lanes in the frame that carried examples share.
struct Framed<S: Simd> {
    p: V<S>,
    /// z² / (x² + y²).
    steep: S::F,
    /// z of the base normal.
    facing: S::F,
}

/// Adds the displacement, and the change of normal if `NORMALS`, of carried examples at one contact.
#[inline(always)]
unsafe fn add_carried<S: Simd, const NORMALS: bool>(
    part: &ReadyPart<'_>,
    (c, lookups): (&Carried, &[ReadyLookup<'_>]),
    block: &Block<'_>,
    rest: &Rest<S>,
    sums: &mut Sums<S>,
) {
    let window = block.window;
    // SAFETY: guaranteed by the caller.
    unsafe {
        let zero = S::splat(0.0);
        let p = each!(k => S::sub(rest.position[k], S::splat(c.contact[k])));
        let p = turned::<S>(&c.to_frame.to_cols_array(), p);
        let across = S::add(S::mul(p[0], p[0]), S::mul(p[1], p[1]));
        let facing = if NORMALS { dot::<S>(rest.normal, each!(k => S::splat(c.to_frame.col(k).z))) } else { zero };
        let vertices = Framed::<S> { p, steep: S::div(S::mul(p[2], p[2]), across), facing };
        let mut found = Found::<S> { displacement: [zero; 3], change: [zero; 3] };
        let mut any = false;
        for lookup in lookups {
            any |= look_up::<S, NORMALS>(lookup, part.threshold, &vertices, &mut found);
        }
        if !any {
            return;
        }
        let back = c.to_frame.to_cols_array();
        let scale = S::splat(part.scale);
        let mut u = scaled::<S>(turned_back::<S>(&back, found.displacement), scale);
        let (mut factor, mut slope) = (S::splat(1.0), [zero; 3]);
        if let Some(w) = window {
            factor = S::load(w.factor.as_ptr().add(rest.at));
            slope = each!(k => S::load(w.gradient[k].as_ptr().add(rest.at)));
        }
        if NORMALS {
            let mut change = scaled::<S>(turned_back::<S>(&back, found.change), scale);
            if window.is_some() {
                // The window's own slope tilts the surface too.
                let n = rest.normal;
                let along = dot::<S>(n, slope);
                let along = each!(k => S::sub(slope[k], S::mul(n[k], along)));
                let lift = dot::<S>(u, n);
                change = each!(k => S::sub(S::mul(change[k], factor), S::mul(along[k], lift)));
            }
            add_steps::<S>(&mut sums.carried[1], in_steps::<S>(change, S::splat(1.0 / block.turn_step)));
        }
        if window.is_some() {
            u = scaled::<S>(u, factor);
        }
        add_steps::<S>(&mut sums.carried[0], in_steps::<S>(u, S::splat(1.0 / block.step)));
    }
}

/// Adds what one example's stamp has for the vertices: [`Stamp::read`] in lanes. Returns false if it has nothing.
#[inline(always)]
unsafe fn look_up<S: Simd, const NORMALS: bool>(
    lookup: &ReadyLookup<'_>,
    threshold: f32,
    vertices: &Framed<S>,
    found: &mut Found<S>,
) -> bool {
    let ReadyLookup(l, nodes) = lookup;
    // SAFETY: guaranteed by the caller; coordinates are clamped to the grid, even if they are NaN.
    unsafe {
        let (zero, one, two) = (S::splat(0.0), S::splat(1.0), S::splat(2.0));
        let p = &vertices.p;
        // The same as `unrolled`, in units of 1 / WEIGHTS cells.
        let steep = S::min(S::mul(vertices.steep, S::splat(l.stretch_square)), two);
        let lift = S::add(one, S::mul(steep, S::splat(0.5)));
        let g = turned_flat::<S>(&l.to_grid.to_cols_array(), [p[0], p[1]]);
        let gx = S::sub(S::mul(g[0], lift), S::splat(l.origin.x));
        let gy = S::sub(S::mul(g[1], lift), S::splat(l.origin.y));
        let x = S::min(S::max(gx, zero), S::splat(l.last.x));
        let y = S::min(S::max(gy, zero), S::splat(l.last.y));
        let inside = S::both(S::equal(gx, x), S::equal(gy, y));
        if !S::any(inside) {
            return false;
        }
        let ([column, x], [row, y]) = (S::split(S::truncate(x)), S::split(S::truncate(y)));
        let [both, _] = S::split(S::mul_short(x, y));
        let neither = S::add_int(S::sub_int(S::sub_int(S::splat_int(WEIGHTS as i32), x), y), both);
        let near = S::packed(neither, S::sub_int(x, both));
        let far = S::packed(S::sub_int(y, both), both);
        let columns = l.dims.x as i32;
        let at = S::add_int(column, S::mul_short(row, S::splat_int(columns)));
        let [u, change] = S::blend::<NORMALS>(nodes.as_ptr(), columns as usize, at, near, far);
        let off = absolute::<S>(S::sub(p[2], S::mul(S::float(u[3]), S::splat(l.height))));
        let keep = S::min(S::max(S::sub(two, S::mul(off, S::splat(l.fade))), zero), one);
        let keep = S::select(inside, keep, zero);
        if !S::any(S::greater(keep, zero)) {
            return false;
        }
        let flat = turned_flat::<S>(&l.displacement.to_cols_array(), [S::float(u[0]), S::float(u[1])]);
        let u = [flat[0], flat[1], S::mul(S::float(u[2]), S::splat(l.displacement_z))];
        found.displacement = add::<S>(found.displacement, cut::<S>(scaled::<S>(u, keep), threshold));
        if NORMALS {
            // A vertex that faces another way than the example's surface (the lid beside a dented wall) does not take
            // over the surface's change of normal.
            let apart = absolute::<S>(S::sub(vertices.facing, S::mul(S::float(change[3]), S::splat(FACING))));
            let alike = S::min(S::max(S::sub(two, S::add(apart, apart)), zero), one);
            let flat = turned_flat::<S>(&l.normal_change.to_cols_array(), [S::float(change[0]), S::float(change[1])]);
            let change = [flat[0], flat[1], S::mul(S::float(change[2]), S::splat(l.normal_change_z))];
            found.change = add::<S>(found.change, scaled::<S>(change, S::mul(keep, alike)));
        }
        true
    }
}

/// The vertices of one block and what moves them.
pub(crate) struct Block<'a> {
    /// Undeformed positions x y z x y z …, and unit normals if they are wanted.
    pub base: &'a [f32; 3 * BLOCK],
    pub base_normals: Option<&'a [f32; 3 * BLOCK]>,
    /// Number of vertices; the rest are zeros.
    pub len: usize,
    /// In the order of summation.
    pub parts: &'a [ReadyPart<'a>],
    pub lookups: &'a [ReadyLookup<'a>],
    pub window: Option<&'a WindowBlock>,
    /// Step of the displacements of carried examples, m; a power of two.
    pub step: f32,
    /// Step of their changes of normals; a power of two.
    pub turn_step: f32,
    /// The depth limit, m; `None` if nothing reaches it.
    pub limit: Option<f32>,
    /// The limits of the vertices; `None` if nothing reaches them.
    pub own: Option<BlockLimits<'a>>,
}

/// Writes deformed positions, and unit normals if `NORMALS`. What carried examples contribute is added to the sums `kept`, if
/// they are given, and the vertices are those of the new sums. Without `CARRIED` there are neither sums nor carried parts.
/// Returns the bounds of the first `len` positions. If there are stored parts, `S` must have `GROUP` lanes.
#[inline(always)]
pub(crate) unsafe fn displace<S: Simd, const NORMALS: bool, const CARRIED: bool>(
    block: &Block<'_>,
    mut kept: Option<&mut CarriedSums>,
    positions: &mut [f32; 3 * BLOCK],
    normals: &mut [f32; 3 * BLOCK],
) -> (Vec3, Vec3) {
    // SAFETY: guaranteed by the caller; lanes `at` to `at + LANES` lie in the block.
    unsafe {
        let mut extent = Extent::<S>::new();
        let zero = [S::splat(0.0); 3];
        for at in (0..block.len).step_by(S::LANES) {
            let rest = Rest::<S> {
                position: load3::<S>(block.base.as_ptr().add(3 * at)),
                normal: match block.base_normals {
                    Some(n) if NORMALS => load3::<S>(n.as_ptr().add(3 * at)),
                    _ => zero,
                },
                at,
            };
            let mut sums = Sums::<S> { dent: zero, all: zero, change: zero, carried: [[S::splat_int(0); 3]; 2] };
            if let Some(kept) = kept.as_ref().filter(|_| CARRIED) {
                let load = |k: usize| kept[k].as_ptr().add(at);
                sums.carried[0] = each!(k => S::load_int(load(k)));
                if NORMALS {
                    sums.carried[1] = each!(k => S::load_int(load(3 + k)));
                }
            }
            for part in block.parts {
                match &part.source {
                    Source::Stored(displacements, changes) => {
                        add_stored::<S>(displacements, at, part.scale, part.threshold, &mut sums.dent);
                        if NORMALS {
                            add_stored::<S>(changes, at, part.scale, 0.0, &mut sums.change);
                        }
                    }
                    Source::Carried(..) if !CARRIED => {}
                    Source::Carried(c, lookups) => {
                        let lookups = &block.lookups[lookups.clone()];
                        add_carried::<S, NORMALS>(part, (c, lookups), block, &rest, &mut sums);
                    }
                }
                if part.last {
                    sums.all = add::<S>(sums.all, sums.dent);
                    sums.dent = zero;
                }
            }
            if let Some(kept) = kept.as_mut().filter(|_| CARRIED) {
                for k in 0..3 {
                    S::store_int(kept[k].as_mut_ptr().add(at), sums.carried[0][k]);
                    if NORMALS {
                        S::store_int(kept[3 + k].as_mut_ptr().add(at), sums.carried[1][k]);
                    }
                }
            }
            let (mut s, mut turn) = (sums.all, sums.change);
            if CARRIED {
                let [moved, turned] = sums.carried;
                s = each!(k => S::add(s[k], S::mul(S::float(moved[k]), S::splat(block.step))));
                turn = each!(k => S::add(turn[k], S::mul(S::float(turned[k]), S::splat(block.turn_step))));
            }
            let factor = kept_share::<S>(s, block.limit, block.own, at);
            let (u, change) = (scaled::<S>(s, factor), scaled::<S>(turn, factor));
            let p = add::<S>(rest.position, u);
            store3::<S>(p, positions.as_mut_ptr().add(3 * at));
            if NORMALS {
                store3::<S>(normal::<S>(rest.normal, turn, change), normals.as_mut_ptr().add(3 * at));
            }
            if at + S::LANES <= block.len {
                extent.add(p);
            } else {
                extent.add_rest(&positions[3 * at..3 * block.len]);
            }
        }
        extent.bounds()
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

/// The unit vector along `n + change`; `n` itself if `sum` is zero or the result is too short.
#[inline(always)]
pub(super) unsafe fn normal<S: Simd>(n: V<S>, sum: V<S>, change: V<S>) -> V<S> {
    // SAFETY: guaranteed by the caller.
    unsafe {
        let zero = S::splat(0.0);
        let same = S::both(S::equal(sum[0], zero), S::both(S::equal(sum[1], zero), S::equal(sum[2], zero)));
        let v = add::<S>(n, change);
        let square = dot::<S>(v, v);
        let long = S::greater(square, S::splat(1e-12));
        let v = scaled::<S>(v, S::div(S::splat(1.0), S::sqrt(square)));
        select::<S>(same, n, select::<S>(long, v, n))
    }
}
