//! The kernels: what turns stored displacements and stamps into vertices, some lanes at a time.
//!
//! They work on one block's arrays, component by component ([`Soa`]), and are generic over [`Simd`]. Operations and their
//! order are the same at every level and width, so results are the same bits.
//!
//! Every function here is `unsafe` for one reason: it may only run where the level's instructions are there. Pointers are made
//! from slices and arrays whose lengths are stated.

use crate::anchored::{BLOCK, GROUP, GROUPS, Numbers, Stored};
use crate::dent::Carried;
use crate::rim::WindowBlock;
use crate::simd::Simd;
use crate::stamp::{NodeArray, Nodes, Stamp};
use glam::{Mat3, Vec3};

/// One vector a vertex of a block.
#[derive(Clone)]
#[repr(C, align(64))]
pub(crate) struct Soa(pub [[f32; BLOCK]; 3]);

impl Soa {
    pub(crate) const ZERO: Soa = Soa([[0.0; BLOCK]; 3]);
}

/// Vectors of lanes.
type V<S> = [<S as Simd>::F; 3];

#[inline(always)]
unsafe fn load<S: Simd>(from: &Soa, at: usize) -> V<S> {
    debug_assert!(at + S::LANES <= BLOCK);
    // SAFETY: lanes `at` to `at + LANES` lie in the block.
    unsafe { [0, 1, 2].map(|k| S::load(from.0[k].as_ptr().add(at))) }
}

#[inline(always)]
unsafe fn store<S: Simd>(to: &mut Soa, at: usize, v: V<S>) {
    debug_assert!(at + S::LANES <= BLOCK);
    // SAFETY: as in `load`.
    unsafe { (0..3).for_each(|k| S::store(to.0[k].as_mut_ptr().add(at), v[k])) }
}

#[inline(always)]
unsafe fn add<S: Simd>(a: V<S>, b: V<S>) -> V<S> {
    // SAFETY: passed on, here and below.
    unsafe { [S::add(a[0], b[0]), S::add(a[1], b[1]), S::add(a[2], b[2])] }
}

#[inline(always)]
unsafe fn scaled<S: Simd>(a: V<S>, f: S::F) -> V<S> {
    unsafe { [S::mul(a[0], f), S::mul(a[1], f), S::mul(a[2], f)] }
}

#[inline(always)]
unsafe fn dot<S: Simd>(a: V<S>, b: V<S>) -> S::F {
    unsafe { S::add(S::add(S::mul(a[0], b[0]), S::mul(a[1], b[1])), S::mul(a[2], b[2])) }
}

#[inline(always)]
unsafe fn select<S: Simd>(m: S::M, a: V<S>, b: V<S>) -> V<S> {
    unsafe { [S::select(m, a[0], b[0]), S::select(m, a[1], b[1]), S::select(m, a[2], b[2])] }
}

/// `m * v`.
#[inline(always)]
unsafe fn turned<S: Simd>(m: &[f32; 9], v: V<S>) -> V<S> {
    unsafe {
        let row = |k: usize| {
            let xy = S::add(S::mul(S::splat(m[k]), v[0]), S::mul(S::splat(m[3 + k]), v[1]));
            S::add(xy, S::mul(S::splat(m[6 + k]), v[2]))
        };
        [row(0), row(1), row(2)]
    }
}

#[inline(always)]
unsafe fn lerp<S: Simd>(a: V<S>, b: V<S>, t: S::F) -> V<S> {
    unsafe {
        let one = |k: usize| S::add(a[k], S::mul(S::sub(b[k], a[k]), t));
        [one(0), one(1), one(2)]
    }
}

/// Vectors no longer than `least` become zero; all stay where it is 0.
#[inline(always)]
unsafe fn cut<S: Simd>(v: V<S>, least: f32) -> V<S> {
    unsafe {
        if least > 0.0 {
            let keep = S::greater(dot::<S>(v, v), S::splat(least * least));
            select::<S>(keep, v, [S::splat(0.0); 3])
        } else {
            v
        }
    }
}

/// `3 * BLOCK` floats x y z x y z … of a block's vertices (fewer are followed by zeros), component by component.
#[inline(always)]
pub(crate) unsafe fn split<S: Simd>(from: &[f32], to: &mut Soa) {
    let mut padded = [0.0; 3 * BLOCK];
    let from: &[f32] = if from.len() == 3 * BLOCK {
        from
    } else {
        padded[..from.len()].copy_from_slice(from);
        &padded
    };
    for at in (0..BLOCK).step_by(S::LANES) {
        // SAFETY: `from` has 3 * BLOCK floats.
        unsafe {
            let p = from.as_ptr().add(3 * at);
            let v = [S::load(p), S::load(p.add(S::LANES)), S::load(p.add(2 * S::LANES))];
            store::<S>(to, at, S::deinterleave(v));
        }
    }
}

/// The way back, into `3 * BLOCK` floats.
#[inline(always)]
pub(crate) unsafe fn join<S: Simd>(from: &Soa, to: &mut [f32; 3 * BLOCK]) {
    for at in (0..BLOCK).step_by(S::LANES) {
        // SAFETY: `to` has 3 * BLOCK floats.
        unsafe { put::<S>(load::<S>(from, at), to.as_mut_ptr().add(3 * at)) }
    }
}

/// # Safety
/// `3 * LANES` floats may be written at `to`.
#[inline(always)]
unsafe fn put<S: Simd>(v: V<S>, to: *mut f32) {
    unsafe {
        for (i, v) in S::interleave(v).into_iter().enumerate() {
            S::store(to.add(i * S::LANES), v);
        }
    }
}

/// Stored numbers of one group as floats, x y z x y z ….
#[inline(always)]
unsafe fn numbers<S: Simd>(stored: &Numbers<'_>, group: usize) -> V<S> {
    let at = group * 3 * GROUP;
    let end = at + 3 * GROUP;
    // SAFETY: the slices make sure that the group is there.
    unsafe {
        match stored {
            Numbers::I8(n) => {
                let n = &n[at..end];
                [0, 1, 2].map(|k| S::load_i8(n.as_ptr().add(k * GROUP)))
            }
            Numbers::I16(n) => {
                let n = &n[at..end];
                [0, 1, 2].map(|k| S::load_i16(n.as_ptr().add(k * GROUP)))
            }
            Numbers::F32(n) => {
                let n = &n[at..end];
                [0, 1, 2].map(|k| S::load(n.as_ptr().add(k * GROUP)))
            }
        }
    }
}

/// Adds `scale` times stored vectors, but none that are no longer than `least` unscaled. `S` has `GROUP` lanes.
#[inline(always)]
pub(crate) unsafe fn add_stored<S: Simd>(stored: &Stored<'_>, scale: f32, least: f32, to: &mut Soa) {
    let scale = stored.step * scale;
    let least = least / stored.step;
    let mut kept = 0;
    for group in (0..GROUPS).filter(|g| stored.groups >> g & 1 == 1) {
        // SAFETY: passed on.
        unsafe {
            let v = S::deinterleave(numbers::<S>(&stored.numbers, kept));
            let u = scaled::<S>(cut::<S>(v, least), S::splat(scale));
            store::<S>(to, group * GROUP, add::<S>(load::<S>(to, group * GROUP), u));
        }
        kept += 1;
    }
}

/// `to = base + scale * stored`, all x y z x y z …: what [`add_stored`] and [`finish`] give for a lone dent under the depth limit,
/// in one pass. `S` has `GROUP` lanes. Returns bounds of what it wrote.
#[inline(always)]
pub(crate) unsafe fn displace_stored<S: Simd>(base: &[f32], stored: &Stored<'_>, scale: f32, to: &mut [f32]) -> Extent<S> {
    let scale = stored.step * scale;
    let mut kept = 0;
    // SAFETY: groups of 3 * GROUP floats, all within the slices; the last, which may be short, goes one by one.
    unsafe {
        let mut extent = Extent::<S>::new();
        let f = S::splat(scale);
        let zero = [S::splat(0.0); 3];
        for (group, (b, o)) in base.chunks_exact(3 * GROUP).zip(to.chunks_exact_mut(3 * GROUP)).enumerate() {
            let u = if stored.groups >> group & 1 == 1 {
                kept += 1;
                scaled::<S>(numbers::<S>(&stored.numbers, kept - 1), f)
            } else {
                zero
            };
            let mut v = zero;
            for k in 0..3 {
                v[k] = S::add(S::load(b.as_ptr().add(k * GROUP)), u[k]);
                S::store(o.as_mut_ptr().add(k * GROUP), v[k]);
            }
            extent.add_flat(v);
        }
        let done = base.len() / (3 * GROUP);
        let (b, o) = (&base[done * 3 * GROUP..], &mut to[done * 3 * GROUP..base.len()]);
        if !b.is_empty() {
            let mut u = [0.0; 3 * GROUP];
            if stored.groups >> done & 1 == 1 {
                let v = scaled::<S>(numbers::<S>(&stored.numbers, kept), f);
                (0..3).for_each(|k| S::store(u.as_mut_ptr().add(k * GROUP), v[k]));
            }
            for i in 0..b.len() {
                o[i] = b[i] + u[i];
                extent.add_one(i % 3, o[i]);
            }
        }
        extent
    }
}

/// Length of the longest stored vector; all numbers are finite. `S` has `GROUP` lanes.
#[inline(always)]
pub(crate) unsafe fn longest<S: Simd>(stored: &Stored<'_>) -> f32 {
    // SAFETY: passed on; 16 lanes at most.
    unsafe {
        let (step, mut most) = (S::splat(stored.step), S::splat(0.0));
        for kept in 0..stored.groups.count_ones() as usize {
            let v = scaled::<S>(S::deinterleave(numbers::<S>(&stored.numbers, kept)), step);
            most = S::max(dot::<S>(v, v), most);
        }
        let mut lanes = [0.0f32; 16];
        S::store(lanes.as_mut_ptr(), most);
        lanes.iter().copied().fold(0.0, f32::max).sqrt()
    }
}

/// Lowest and highest coordinates seen so far.
pub(crate) struct Extent<S: Simd> {
    /// x y z x y z …, as vertices lie in memory.
    low: V<S>,
    high: V<S>,
    rest: ([f32; 3], [f32; 3]),
}

impl<S: Simd> Extent<S> {
    #[inline(always)]
    unsafe fn new() -> Self {
        let (low, high) = (f32::INFINITY, f32::NEG_INFINITY);
        // SAFETY: passed on, here and below.
        unsafe { Extent { low: [S::splat(low); 3], high: [S::splat(high); 3], rest: ([low; 3], [high; 3]) } }
    }

    #[inline(always)]
    unsafe fn add_flat(&mut self, v: V<S>) {
        for k in 0..3 {
            unsafe {
                self.low[k] = S::min(self.low[k], v[k]);
                self.high[k] = S::max(self.high[k], v[k]);
            }
        }
    }

    #[inline(always)]
    fn add_one(&mut self, component: usize, x: f32) {
        self.rest.0[component] = self.rest.0[component].min(x);
        self.rest.1[component] = self.rest.1[component].max(x);
    }

    #[inline(always)]
    pub(crate) unsafe fn bounds(mut self) -> (Vec3, Vec3) {
        // 16 lanes at most.
        let (mut low, mut high) = ([0.0f32; 48], [0.0f32; 48]);
        for k in 0..3 {
            // SAFETY: 3 * LANES floats fit.
            unsafe {
                S::store(low.as_mut_ptr().add(k * S::LANES), self.low[k]);
                S::store(high.as_mut_ptr().add(k * S::LANES), self.high[k]);
            }
        }
        for i in 0..3 * S::LANES {
            self.add_one(i % 3, low[i]);
            self.add_one(i % 3, high[i]);
        }
        (Vec3::from(self.rest.0), Vec3::from(self.rest.1))
    }
}

/// A field over a grid, and how its nodes are read.
trait Field: Copy {
    /// # Safety
    /// `at` lies within the nodes.
    unsafe fn read<S: Simd>(self, at: S::I) -> V<S>;
    /// The field some nodes further on.
    fn after(self, nodes: usize) -> Self;
}

#[derive(Clone, Copy)]
struct Packed<'a>(&'a [u32]);
#[derive(Clone, Copy)]
struct Half<'a>(&'a [[i16; 4]]);
#[derive(Clone, Copy)]
struct Exact<'a>(&'a [[f32; 3]]);

macro_rules! field {
    ($name:ident, $gather:ident) => {
        impl Field for $name<'_> {
            #[inline(always)]
            unsafe fn read<S: Simd>(self, at: S::I) -> V<S> {
                // SAFETY: passed on.
                unsafe { S::$gather(self.0.as_ptr(), at) }
            }
            #[inline(always)]
            fn after(self, nodes: usize) -> Self {
                $name(&self.0[nodes..])
            }
        }
    };
}
field!(Packed, gather_packed);
field!(Half, gather_i16);
field!(Exact, gather_f32);

/// What a stamp's kernel needs besides the stamp.
pub(crate) struct Look<'a> {
    pub carried: &'a Carried,
    pub stamp: &'a Stamp,
    pub scale: f32,
    /// Displacements no longer than this, unscaled, are left out, m.
    pub least: f32,
    pub window: Option<&'a WindowBlock>,
    pub base: &'a Soa,
}

/// Adds what a carried example brings to the vertices of `groups` (first, end; 16 vertices each).
#[inline(always)]
pub(crate) unsafe fn add_carried<S: Simd>(
    look: &Look<'_>,
    groups: (usize, usize),
    to: &mut Soa,
    normals: Option<(&Soa, &mut Soa)>,
) {
    let nodes = |n: &Nodes| (n.len(), n.step);
    let (count, step) = nodes(&look.stamp.displacements);
    debug_assert_eq!(count, look.stamp.grid.count());
    // SAFETY: passed on; a stamp's fields have as many nodes as its grid.
    unsafe {
        match (&look.stamp.displacements.array, &look.stamp.normals.array, &look.stamp.facing.array) {
            (NodeArray::Packed(d), NodeArray::Packed(n), NodeArray::Packed(f)) => {
                add_fields::<S, _, _>(look, groups, (Packed(d), step), (Packed(n), Packed(f)), to, normals)
            }
            (NodeArray::Half(d), NodeArray::Packed(n), NodeArray::Packed(f)) => {
                add_fields::<S, _, _>(look, groups, (Half(d), step), (Packed(n), Packed(f)), to, normals)
            }
            (NodeArray::Exact(d), NodeArray::Exact(n), NodeArray::Exact(f)) => {
                add_fields::<S, _, _>(look, groups, (Exact(d), step), (Exact(n), Exact(f)), to, normals)
            }
            // Of a mesh without normals.
            (NodeArray::Packed(d), ..) => {
                add_fields::<S, _, _>(look, groups, (Packed(d), step), (Exact(&[]), Exact(&[])), to, None)
            }
            (NodeArray::Half(d), ..) => {
                add_fields::<S, _, _>(look, groups, (Half(d), step), (Exact(&[]), Exact(&[])), to, None)
            }
            (NodeArray::Exact(d), ..) => {
                add_fields::<S, _, _>(look, groups, (Exact(d), step), (Exact(&[]), Exact(&[])), to, None)
            }
        }
    }
}

/// Where in a grid's cell the lanes are.
struct Cell<S: Simd> {
    at: S::I,
    t: V<S>,
    /// Nodes from one row, and from one layer, to the next.
    row: usize,
    layer: usize,
}

impl<S: Simd> Cell<S> {
    #[inline(always)]
    unsafe fn read<F: Field>(&self, f: F) -> V<S> {
        // SAFETY: `at` is at least a node short of the last in each direction.
        unsafe {
            let line = |from: usize| {
                let f = f.after(from);
                lerp::<S>(f.read::<S>(self.at), f.after(1).read::<S>(self.at), self.t[0])
            };
            let plane = |from: usize| lerp::<S>(line(from), line(from + self.row), self.t[1]);
            lerp::<S>(plane(0), plane(self.layer), self.t[2])
        }
    }
}

#[inline(always)]
unsafe fn add_fields<S: Simd, D: Field, N: Field>(
    look: &Look<'_>,
    groups: (usize, usize),
    (displacements, step): (D, Vec3),
    (changes, facing): (N, N),
    to: &mut Soa,
    mut normals: Option<(&Soa, &mut Soa)>,
) {
    let (c, grid) = (look.carried, &look.stamp.grid);
    let (dims, top) = (grid.dims, (grid.dims - 1).as_vec3().to_array());
    let to_grid = c.to_grid.to_cols_array();
    let (contact, origin) = (c.contact.to_array(), c.grid_origin.to_array());
    let out = (c.from_stamp * Mat3::from_diagonal(step)).to_cols_array();
    let normal_out = (c.from_stamp * Mat3::from_diagonal(look.stamp.normals.step)).to_cols_array();
    let back = c.from_stamp.transpose().to_cols_array();
    let facing_step = look.stamp.facing.step.to_array();
    let strides = [1, dims.x as i32, (dims.x * dims.y) as i32];
    for at in (groups.0 * 16..groups.1 * 16).step_by(S::LANES) {
        // SAFETY: all lanes read within the grid: coordinates are held in it, also where they are not a number.
        unsafe {
            let p = load::<S>(look.base, at);
            let p = [0, 1, 2].map(|k| S::sub(p[k], S::splat(contact[k])));
            let g = turned::<S>(&to_grid, p);
            let g = [0, 1, 2].map(|k| S::sub(g[k], S::splat(origin[k])));
            let held = [0, 1, 2].map(|k| S::min(S::max(g[k], S::splat(0.0)), S::splat(top[k])));
            let inside = S::both(
                S::equal(g[0], held[0]),
                S::both(S::equal(g[1], held[1]), S::equal(g[2], held[2])),
            );
            if !S::any(inside) {
                continue;
            }
            let node = [0, 1, 2].map(|k| {
                let last = S::splat_int(dims.to_array()[k] as i32 - 2);
                S::max_int(S::min_int(S::truncate(held[k]), last), S::splat_int(0))
            });
            let cell = Cell::<S> {
                at: S::add_int(
                    node[0],
                    S::add_int(
                        S::mul_int(node[1], S::splat_int(strides[1])),
                        S::mul_int(node[2], S::splat_int(strides[2])),
                    ),
                ),
                t: [0, 1, 2].map(|k| S::sub(held[k], S::float(node[k]))),
                row: strides[1] as usize,
                layer: strides[2] as usize,
            };
            let zero = [S::splat(0.0); 3];
            let mut u = cut::<S>(turned::<S>(&out, cell.read(displacements)), look.least);
            let factor = look.window.map(|w| S::load(w.factor.as_ptr().add(at)));
            if let Some((base, to)) = &mut normals {
                let n = load::<S>(base, at);
                let f = cell.read(facing);
                let f = [0, 1, 2].map(|k| S::mul(f[k], S::splat(facing_step[k])));
                let length = S::sqrt(dot::<S>(f, f));
                let cos = S::div(dot::<S>(f, turned::<S>(&back, n)), length);
                // A facing of length 0 gives no number, and thus 0.
                let cos = S::min(S::max(cos, S::splat(0.0)), S::splat(1.0));
                let change = turned::<S>(&normal_out, cell.read(changes));
                let mut change = scaled::<S>(change, S::mul(cos, S::splat(c.normal_scale)));
                if let (Some(w), Some(factor)) = (look.window, factor) {
                    // The window's own slope tilts the surface too.
                    let slope = [0, 1, 2].map(|k| S::load(w.gradient[k].as_ptr().add(at)));
                    let along = dot::<S>(n, slope);
                    let along = [0, 1, 2].map(|k| S::sub(slope[k], S::mul(n[k], along)));
                    let lift = dot::<S>(u, n);
                    change = [0, 1, 2].map(|k| S::sub(S::mul(change[k], factor), S::mul(along[k], lift)));
                }
                let change = select::<S>(inside, scaled::<S>(change, S::splat(look.scale)), zero);
                store::<S>(to, at, add::<S>(load::<S>(to, at), change));
            }
            if let Some(factor) = factor {
                u = scaled::<S>(u, factor);
            }
            let u = select::<S>(inside, scaled::<S>(u, S::splat(look.scale)), zero);
            store::<S>(to, at, add::<S>(load::<S>(to, at), u));
        }
    }
}

/// How lengths of dents combine at a vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Lengths {
    /// Their squares add.
    Squares,
    /// The longest counts.
    Longest,
    /// Nothing is shortened but by the depth limit.
    Free,
}

/// Adds one dent to the sums and clears it.
#[inline(always)]
pub(crate) unsafe fn add_dent<S: Simd>(dent: &mut Soa, sum: &mut Soa, squares: &mut [f32; BLOCK], lengths: Lengths) {
    for at in (0..BLOCK).step_by(S::LANES) {
        // SAFETY: lanes within the block.
        unsafe {
            let u = load::<S>(dent, at);
            store::<S>(sum, at, add::<S>(load::<S>(sum, at), u));
            store::<S>(dent, at, [S::splat(0.0); 3]);
            let (q, square) = (S::load(squares.as_ptr().add(at)), dot::<S>(u, u));
            let q = if lengths == Lengths::Longest { S::max(square, q) } else { S::add(q, square) };
            S::store(squares.as_mut_ptr().add(at), q);
        }
    }
}

/// What is left to do when all dents are summed.
pub(crate) struct Finish<'a> {
    pub base: &'a Soa,
    /// Base normals and sums of their changes.
    pub normals: Option<(&'a Soa, &'a Soa)>,
    /// Sums of the squares of dents (or the greatest); `None` where one dent at most is there.
    pub squares: Option<&'a [f32; BLOCK]>,
    pub lengths: Lengths,
    /// The depth limit, m; `None` where nothing reaches it.
    pub limit: Option<f32>,
}

/// Sums become positions, in place, and changes of normals become `unit` normals.
#[inline(always)]
pub(crate) unsafe fn finish<S: Simd>(f: &Finish<'_>, sum: &mut Soa, mut unit: Option<&mut Soa>) {
    for at in (0..BLOCK).step_by(S::LANES) {
        // SAFETY: lanes within the block.
        unsafe {
            let s = load::<S>(sum, at);
            let factor = if f.squares.is_none() && f.limit.is_none() {
                None
            } else {
                let length = S::sqrt(dot::<S>(s, s));
                let mut allowed = length;
                if let (Some(q), true) = (f.squares, f.lengths != Lengths::Free) {
                    allowed = S::min(S::sqrt(S::load(q.as_ptr().add(at))), allowed);
                }
                if let Some(limit) = f.limit {
                    allowed = S::min(S::splat(limit), allowed);
                }
                // Where nothing is shortened, exactly 1; also where the length is 0.
                Some(S::select(S::greater(length, allowed), S::div(allowed, length), S::splat(1.0)))
            };
            let u = factor.map_or(s, |factor| scaled::<S>(s, factor));
            store::<S>(sum, at, add::<S>(load::<S>(f.base, at), u));
            if let (Some((base, changes)), Some(unit)) = (f.normals, &mut unit) {
                let (n, change) = (load::<S>(base, at), load::<S>(changes, at));
                store::<S>(unit, at, normal::<S>(n, change, factor));
            }
        }
    }
}

/// The unit vector along `n + change`; `n` itself where nothing changes.
#[inline(always)]
unsafe fn normal<S: Simd>(n: V<S>, change: V<S>, factor: Option<S::F>) -> V<S> {
    unsafe {
        let zero = S::splat(0.0);
        let same = S::both(S::equal(change[0], zero), S::both(S::equal(change[1], zero), S::equal(change[2], zero)));
        let v = add::<S>(n, factor.map_or(change, |factor| scaled::<S>(change, factor)));
        let square = dot::<S>(v, v);
        let long = S::greater(square, S::splat(1e-12));
        let v = scaled::<S>(v, S::div(S::splat(1.0), S::sqrt(square)));
        select::<S>(same, n, select::<S>(long, v, n))
    }
}

/// Bounds of the first `len` vertices.
#[inline(always)]
pub(crate) unsafe fn bounds<S: Simd>(positions: &Soa, len: usize) -> (Vec3, Vec3) {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for k in 0..3 {
        // SAFETY: lanes within the block.
        unsafe {
            let p = positions.0[k].as_ptr();
            let whole = len / S::LANES * S::LANES;
            let (mut l, mut h) = (S::splat(f32::INFINITY), S::splat(f32::NEG_INFINITY));
            for at in (0..whole).step_by(S::LANES) {
                let v = S::load(p.add(at));
                l = S::min(l, v);
                h = S::max(h, v);
            }
            let (mut ends, mut lows) = ([0.0f32; 16], [0.0f32; 16]);
            S::store(lows.as_mut_ptr(), l);
            S::store(ends.as_mut_ptr(), h);
            let rest = positions.0[k][whole..len].iter().copied();
            low[k] = lows[..S::LANES].iter().copied().chain(rest.clone()).fold(f32::INFINITY, f32::min);
            high[k] = ends[..S::LANES].iter().copied().chain(rest).fold(f32::NEG_INFINITY, f32::max);
        }
    }
    (low, high)
}
