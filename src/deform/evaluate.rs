//! Marks become vertices: a pure function, evaluated a block at a time.
//!
//! ```text
//! S(v) = sum of u_m(v)      Q(v) = sum of |u_m(v)|²
//! position(v) = base(v) + S(v) * min(1, sqrt(Q(v)) / |S(v)|, L / |S(v)|)
//! ```
//!
//! Marks are summed in their sorted order with plain f32 operations, so that coincident vertices, any cut into blocks,
//! any thread and any [`SimdLevel`] give the same bits.

use super::kernel::{self, Finish, Lengths, Look, Soa};
use crate::anchored::{BLOCK, GROUP, block_range};
use crate::classic::State;
use crate::dent::{Dent, Part};
use crate::examples::Combine;
use crate::instance::Instance;
use crate::math::{Aabb, unit};
#[cfg(target_arch = "x86_64")]
use crate::simd::{Avx2, Avx512};
use crate::simd::{Portable, Simd, SimdLevel};
use crate::skin::Skin;
use glam::{Vec3, Vec4};
use std::cell::Cell;

/// Vertices x y z x y z … of one block.
pub(crate) type Flat = [f32; 3 * BLOCK];

/// One block to evaluate.
#[derive(Clone, Copy)]
pub(crate) struct Job<'a> {
    pub instance: &'a Instance,
    pub skin: &'a Skin,
    pub block: usize,
    /// Counts parts that the tolerance leaves out of the block.
    pub left_out: &'a Cell<u32>,
}

/// Writes positions (m), and unit normals if wanted: three floats a vertex of the block, no more. Returns the bounds of the
/// positions. A mesh without normals gets none.
pub(crate) fn block(job: Job<'_>, positions: &mut [f32], normals: Option<&mut [f32]>) -> Aabb {
    let len = block_range(job.block, job.skin.vertex_count()).len();
    assert!(positions.len() == 3 * len && normals.as_ref().is_none_or(|n| n.len() == 3 * len));
    match SimdLevel::current() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: the level is in force only where the processor has it.
        SimdLevel::Avx512 => unsafe { avx512(job, positions, normals) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: the same.
        SimdLevel::Avx2 => unsafe { avx2(job, positions, normals) },
        // SAFETY: always there.
        _ => unsafe { evaluate::<Portable, Portable>(job, positions, normals) },
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2")]
fn avx512(job: Job<'_>, positions: &mut [f32], normals: Option<&mut [f32]>) -> Aabb {
    // SAFETY: the attribute says so.
    unsafe { evaluate::<Avx2, Avx512>(job, positions, normals) }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2(job: Job<'_>, positions: &mut [f32], normals: Option<&mut [f32]>) -> Aabb {
    // SAFETY: the attribute says so.
    unsafe { evaluate::<Avx2, Avx2>(job, positions, normals) }
}

/// Position and unit normal of one vertex: the same bits as [`block`] gives.
pub(crate) fn vertex(instance: &Instance, skin: &Skin, v: usize) -> (Vec3, Option<Vec3>) {
    let (block, i) = (v / BLOCK, v % BLOCK);
    let n = 3 * block_range(block, skin.vertex_count()).len();
    let (mut positions, mut normals): (Flat, Flat) = ([0.0; 3 * BLOCK], [0.0; 3 * BLOCK]);
    let some = skin.mesh.normals().is_some();
    self::block(
        Job { instance, skin, block, left_out: &Cell::new(0) },
        &mut positions[..n],
        some.then_some(&mut normals[..n]),
    );
    let at = |f: &Flat| Vec3::new(f[3 * i], f[3 * i + 1], f[3 * i + 2]);
    (at(&positions), some.then(|| at(&normals)))
}

/// A part that moves vertices of the block.
#[derive(Clone, Copy)]
struct Active<'a> {
    dent: usize,
    part: &'a Part,
    scale: f32,
    /// Displacements of the example no longer than this are left out, m.
    least: f32,
    /// Nothing in the block is moved further by it, m.
    longest: f32,
}

/// The parts of an instance's dents that move vertices of the block, in order.
fn active<'a>(job: Job<'a>, normals: bool) -> impl Iterator<Item = Active<'a>> {
    let dents = job.instance.damage().near(&job.skin.block_bounds[job.block]);
    dents.flat_map(move |(dent, d)| d.parts.iter().filter_map(move |part| one(job, normals, dent, d, part)))
}

fn one<'a>(job: Job<'a>, normals: bool, dent: usize, d: &Dent, part: &'a Part) -> Option<Active<'a>> {
    let skin = job.skin;
    let longest = match &part.carried {
        Some(c) if c.reaches(&skin.block_bounds[job.block]) => {
            job.instance.example_set().examples()[part.example].stamp()?.longest
        }
        Some(_) => return None,
        None => skin.anchored[part.example].block(job.block as u32)?.longest,
    };
    let scale = part.scale * d.strength;
    let least = if scale == 0.0 { 0.0 } else { job.instance.least() / scale.abs() };
    // Normals of a part are shown in all blocks or in none, so that they agree where blocks meet.
    let shown = least == 0.0
        || longest > least
        || (normals && part.carried.is_none() && skin.anchored[part.example].exceeds(least));
    if !shown {
        job.left_out.set(job.left_out.get() + 1);
        return None;
    }
    Some(Active { dent, part, scale, least, longest: longest * scale.abs() })
}

/// # Safety
/// Where the instructions of `N` and `W` are there. `N` has eight lanes.
#[inline(always)]
unsafe fn evaluate<N: Simd, W: Simd>(job: Job<'_>, positions: &mut [f32], normals: Option<&mut [f32]>) -> Aabb {
    debug_assert_eq!(N::LANES, GROUP);
    let mesh = &job.skin.mesh;
    let range = block_range(job.block, job.skin.vertex_count());
    let base: &[f32] = bytemuck::cast_slice(&mesh.positions()[range.clone()]);
    let base_normals: Option<&[f32]> = mesh.normals().map(|n| bytemuck::cast_slice(&n[range.clone()]));
    let mut normals = normals.zip(base_normals);
    if let Some(state) = job.instance.classic_state() {
        return classic(state, range.start, positions, normals);
    }
    let mut parts = active(job, normals.is_some());
    let (first, second) = (parts.next(), parts.next());
    let Some(first) = first else {
        positions.copy_from_slice(base);
        if let Some((normals, base)) = normals {
            normals.copy_from_slice(base);
        }
        return job.skin.block_bounds[job.block];
    };
    let limit = job.instance.depth_limit();
    // Rounding never takes a length over the limit by this much.
    let reaches_limit = |longest: f32| longest * 1.00001 > limit;
    if second.is_none()
        && normals.is_none()
        && first.least == 0.0
        && !reaches_limit(first.longest)
        && first.part.carried.is_none()
    {
        let anchored = &job.skin.anchored[first.part.example];
        if let Some(head) = anchored.block(job.block as u32) {
            // SAFETY: passed on.
            let (min, max) = unsafe {
                kernel::displace_stored::<N>(base, &anchored.displacements(head), first.scale, positions).bounds()
            };
            return Aabb { min, max };
        }
    }
    let parts: Vec<Active<'_>> = [Some(first), second].into_iter().flatten().chain(parts).collect();
    let rim = job.skin.rim.block(job.block);
    let groups = (0, range.len().div_ceil(16));
    let (mut at, mut sum) = (Soa::ZERO, Soa::ZERO);
    // Only where they are needed: base normals, sums of their changes and unit normals; one dent and squares of several.
    let (mut base_n, mut sum_n) = (Soa::ZERO, Soa::ZERO);
    let (mut dent, mut dent_n, mut squares) = (Soa::ZERO, Soa::ZERO, [0.0f32; BLOCK]);
    // SAFETY: passed on.
    unsafe {
        kernel::split::<N>(base, &mut at);
        if let Some((_, base)) = &normals {
            kernel::split::<N>(base, &mut base_n);
        }
        let mut longest = 0.0;
        let lengths = match job.instance.example_set().options().combine {
            Combine::Sum => Lengths::Free,
            Combine::Energies => Lengths::Squares,
            Combine::Deepest => Lengths::Longest,
        };
        // A lone dent needs no sums of its own.
        let alone = parts.iter().all(|p| p.dent == first.dent);
        let mut current = first.dent;
        for p in &parts {
            if p.dent != current {
                kernel::add_dent::<N>(&mut dent, &mut sum, &mut squares, lengths);
                current = p.dent;
            }
            longest += p.longest;
            let to = if alone { &mut sum } else { &mut dent };
            match &p.part.carried {
                None => {
                    let anchored = &job.skin.anchored[p.part.example];
                    let Some(head) = anchored.block(job.block as u32) else { continue };
                    kernel::add_stored::<N>(&anchored.displacements(head), p.scale, p.least, to);
                    if normals.is_some() {
                        kernel::add_stored::<N>(&anchored.normals(head), p.scale, 0.0, &mut sum_n);
                    }
                }
                Some(carried) => {
                    let Some(stamp) = job.instance.example_set().examples()[p.part.example].stamp() else { continue };
                    let look = Look { carried, stamp, scale: p.scale, least: p.least, window: rim, base: &at };
                    let normals = normals.is_some().then_some((&base_n, &mut sum_n));
                    kernel::add_carried::<W>(&look, groups, to, normals);
                }
            }
        }
        if !alone {
            kernel::add_dent::<N>(&mut dent, &mut sum, &mut squares, lengths);
        }
        let finish = Finish {
            base: &at,
            normals: normals.is_some().then_some((&base_n, &sum_n)),
            squares: (!alone).then_some(&squares),
            lengths,
            limit: reaches_limit(longest).then_some(limit),
        };
        kernel::finish::<N>(&finish, &mut sum, normals.is_some().then_some(&mut dent_n));
        write::<N>(&sum, positions);
        if let Some((normals, _)) = &mut normals {
            write::<N>(&dent_n, normals);
        }
        let (min, max) = kernel::bounds::<N>(&sum, range.len());
        Aabb { min, max }
    }
}

/// # Safety
/// As [`evaluate`].
#[inline(always)]
unsafe fn write<N: Simd>(from: &Soa, to: &mut [f32]) {
    // SAFETY: passed on.
    unsafe {
        if let Ok(whole) = <&mut Flat>::try_from(&mut *to) {
            kernel::join::<N>(from, whole);
        } else {
            let mut whole = [0.0; 3 * BLOCK];
            kernel::join::<N>(from, &mut whole);
            to.copy_from_slice(&whole[..to.len()]);
        }
    }
}

fn classic(state: &State, first: usize, positions: &mut [f32], normals: Option<(&mut [f32], &[f32])>) -> Aabb {
    let mut bounds = Aabb::EMPTY;
    for (i, p) in positions.chunks_exact_mut(3).enumerate() {
        let at = state.position(first + i);
        bounds.add(at);
        p.copy_from_slice(&at.to_array());
    }
    if let Some((normals, base)) = normals {
        for (i, (n, base)) in normals.chunks_exact_mut(3).zip(base.chunks_exact(3)).enumerate() {
            let base = Vec3::from_slice(base);
            let now = state.normal(first + i).unwrap_or(base);
            let now = if now == base { now } else { unit(now).unwrap_or(base) };
            n.copy_from_slice(&now.to_array());
        }
    }
    bounds
}

/// The base tangent turned as the normal turned, orthogonal to the new normal; w is kept.
pub(crate) fn tangent(skin: &Skin, v: usize, normal: Vec3) -> Vec4 {
    let Some(t) = skin.mesh.tangents().map(|t| t[v]) else { return Vec4::W };
    let base = skin.mesh.normals().map_or(normal, |n| n[v]);
    if normal == base {
        return t;
    }
    let turned = crate::math::rotation_between(base, normal) * t.truncate();
    let flat = turned - normal * normal.dot(turned);
    unit(flat).unwrap_or_else(|| crate::math::tangent_basis(normal).x_axis).extend(t.w)
}
