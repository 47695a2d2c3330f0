//! Marks become vertices: a pure function, evaluated a block at a time.
//!
//! ```text
//! S(v) = sum of u_m(v)      Q(v) = sum of |u_m(v)|²
//! position(v) = base(v) + S(v) * min(1, sqrt(Q(v)) / |S(v)|, L / |S(v)|)
//! ```
//!
//! Marks are summed in their sorted order with plain f32 operations, so that coincident vertices, any cut into blocks and
//! any thread give the same bits.

use crate::anchored::{BLOCK, block_range};
use crate::examples::{Combine, ExampleSet};
use crate::instance::Instance;
use crate::math::unit;
use glam::{Vec3, Vec4};
use std::ops::Range;

/// Up to `N` deformed vertices of one block; the first `len` are valid.
pub(crate) struct Vertices<const N: usize> {
    pub positions: [Vec3; N],
    /// Unit normals, where asked for and the mesh has any.
    pub normals: [Vec3; N],
    pub len: usize,
}

/// Evaluates all of block `b`.
pub(crate) fn block(instance: &Instance, b: usize, normals: bool) -> Vertices<BLOCK> {
    evaluate(instance, block_range(b, instance.example_set().vertex_count()), normals)
}

/// Position and unit normal of one vertex: the same bits as [`block`] gives.
pub(crate) fn vertex(instance: &Instance, v: usize) -> (Vec3, Option<Vec3>) {
    let one = evaluate::<1>(instance, v..v + 1, true);
    (one.positions[0], instance.example_set().mesh().normals().is_some().then_some(one.normals[0]))
}

/// Evaluates the vertices of `r`: at most `N`, all of one block.
fn evaluate<const N: usize>(instance: &Instance, r: Range<usize>, normals: bool) -> Vertices<N> {
    let set = instance.example_set();
    let (b, len) = (r.start / BLOCK, r.len());
    let base = &set.mesh().positions()[r.clone()];
    let mut out = Vertices { positions: [Vec3::ZERO; N], normals: [Vec3::ZERO; N], len };
    out.positions[..len].copy_from_slice(base);
    let base_normals = set.mesh().normals().filter(|_| normals);
    if let Some(n) = base_normals {
        out.normals[..len].copy_from_slice(&n[r.clone()]);
    }
    if let Some(state) = instance.classic_state() {
        for (i, v) in r.enumerate() {
            out.positions[i] = state.position(v);
            if let (Some(base), Some(n)) = (base_normals, state.normal(v)) {
                out.normals[i] = if n == base[v] { n } else { unit(n).unwrap_or(base[v]) };
            }
        }
        return out;
    }
    let rim = set.rim().block(b).map(|w| &w[r.start - b * BLOCK..]);
    let mut sum = Sum::<N>::new();
    for dent in instance.damage().dents().iter().filter(|d| d.touches(set, b)) {
        sum.clear_dent(len);
        for part in &dent.parts {
            let scale = part.scale * dent.strength;
            match &part.carried {
                None => {
                    let n = if base_normals.is_some() { &mut sum.dent_normals[..len] } else { &mut [] };
                    set.examples()[part.example].anchored().add(r.clone(), scale, &mut sum.dent[..len], n);
                }
                Some(carried) => match base_normals.map(|n| &n[r.clone()]) {
                    None => {
                        for (i, p) in base.iter().enumerate() {
                            let factor = rim.map_or(1.0, |w| w[i].factor);
                            sum.dent[i] += carried.at(set, part.example, *p) * factor * scale;
                        }
                    }
                    Some(normals) => {
                        for (i, (p, n)) in base.iter().zip(normals).enumerate() {
                            if let Some((mut u, mut change)) = carried.with_normal(set, part.example, *p, *n) {
                                if let Some(w) = rim {
                                    change = w[i].turn(u, change, *n);
                                    u *= w[i].factor;
                                }
                                sum.dent[i] += u * scale;
                                sum.dent_normals[i] += change * scale;
                            }
                        }
                    }
                },
            }
        }
        sum.add_dent(len, set.options().combine);
    }
    for i in 0..len {
        let (u, f) = combined(sum.s[i], sum.q[i], set.options().combine, instance.depth_limit());
        out.positions[i] += u;
        if base_normals.is_some() && sum.normals[i] != Vec3::ZERO {
            out.normals[i] = unit(out.normals[i] + sum.normals[i] * f).unwrap_or(out.normals[i]);
        }
    }
    out
}

struct Sum<const N: usize> {
    s: [Vec3; N],
    q: [f32; N],
    normals: [Vec3; N],
    dent: [Vec3; N],
    dent_normals: [Vec3; N],
}

impl<const N: usize> Sum<N> {
    fn new() -> Self {
        let zero = [Vec3::ZERO; N];
        Sum { s: zero, q: [0.0; N], normals: zero, dent: zero, dent_normals: zero }
    }

    fn clear_dent(&mut self, len: usize) {
        self.dent[..len].fill(Vec3::ZERO);
        self.dent_normals[..len].fill(Vec3::ZERO);
    }

    fn add_dent(&mut self, len: usize, combine: Combine) {
        for i in 0..len {
            let u = self.dent[i];
            self.s[i] += u;
            self.normals[i] += self.dent_normals[i];
            let square = u.dot(u);
            self.q[i] = if combine == Combine::Deepest { self.q[i].max(square) } else { self.q[i] + square };
        }
    }
}

/// The displacement, and what the sum was multiplied with to get it.
fn combined(s: Vec3, q: f32, combine: Combine, limit: f32) -> (Vec3, f32) {
    let length = s.length();
    if length.is_nan() || length <= 0.0 {
        return (Vec3::ZERO, 1.0);
    }
    let allowed = if combine == Combine::Sum { length } else { length.min(q.sqrt()) };
    let allowed = allowed.min(limit);
    if allowed >= length { (s, 1.0) } else { (s * (allowed / length), allowed / length) }
}

/// The base tangent turned as the normal turned, orthogonal to the new normal; w is kept.
pub(crate) fn tangent(set: &ExampleSet, v: usize, normal: Vec3) -> Vec4 {
    let Some(t) = set.mesh().tangents().map(|t| t[v]) else { return Vec4::W };
    let base = set.mesh().normals().map_or(normal, |n| n[v]);
    if normal == base {
        return t;
    }
    let turned = crate::math::rotation_between(base, normal) * t.truncate();
    let flat = turned - normal * normal.dot(turned);
    unit(flat).unwrap_or_else(|| crate::math::tangent_basis(normal).x_axis).extend(t.w)
}
