//! Marks become vertices: a pure function, evaluated a block at a time.
//!
//! ```text
//! S(v) = sum of u_m(v)      Q(v) = sum of |u_m(v)|²
//! position(v) = base(v) + S(v) * min(1, sqrt(Q(v)) / |S(v)|, L / |S(v)|)
//! ```
//!
//! Marks are summed in their sorted order with plain f32 operations, so that coincident vertices, any cut into blocks,
//! any thread and any [`crate::SimdLevel`] give the same bits.

use super::kernel::{Block, Lengths, Ready, Source};
use super::levels;
use crate::anchored::{BLOCK, Stored, block_range};
use crate::classic::State;
use crate::dent::Part;
use crate::examples::Combine;
use crate::instance::Instance;
use crate::math::{Aabb, turned_as, unit};
use crate::skin::Skin;
use glam::{Vec3, Vec4};

/// Vertices x y z x y z … of one block.
pub(crate) type Flat = [f32; 3 * BLOCK];

/// One block to evaluate.
#[derive(Clone, Copy)]
pub(crate) struct Job<'a> {
    pub instance: &'a Instance,
    pub skin: &'a Skin,
    pub block: usize,
}

/// Position and unit normal of one vertex: the same bits as [`block`] gives.
pub(crate) fn vertex(instance: &Instance, skin: &Skin, v: usize) -> (Vec3, Option<Vec3>) {
    let (block, i) = (v / BLOCK, v % BLOCK);
    let n = 3 * block_range(block, skin.vertex_count()).len();
    let (mut positions, mut normals): (Flat, Flat) = ([0.0; 3 * BLOCK], [0.0; 3 * BLOCK]);
    let some = skin.mesh.normals().is_some();
    let job = Job { instance, skin, block };
    let mut bounds = Aabb::EMPTY;
    self::block(job, &mut Room::new(), &mut positions[..n], some.then_some(&mut normals[..n]), &mut bounds);
    let at = |f: &Flat| Vec3::new(f[3 * i], f[3 * i + 1], f[3 * i + 2]);
    (at(&positions), some.then(|| at(&normals)))
}

/// What evaluating blocks needs of memory, used over and over.
pub(crate) struct Room<'a> {
    parts: Vec<Ready<'a>>,
    /// Parts that the tolerance left out of blocks so far.
    pub left_out: u32,
    base: Flat,
    base_normals: Flat,
    positions: Flat,
    normals: Flat,
}

impl Room<'_> {
    pub(crate) fn new() -> Self {
        let zero = [0.0; 3 * BLOCK];
        Room { parts: Vec::new(), left_out: 0, base: zero, base_normals: zero, positions: zero, normals: zero }
    }
}

/// The parts of an instance's dents that move vertices of the block, in order.
#[inline(always)]
fn active<'a>(job: Job<'a>, normals: bool, room: &mut Room<'a>) -> Touched {
    let Room { parts, left_out, .. } = room;
    parts.clear();
    let mut touched = Touched { dents: 0, longest: 0.0, stored: false };
    for dent in job.instance.damage().near(&job.skin.block_bounds[job.block]) {
        let before = parts.len();
        for part in dent.parts.iter() {
            if let Some((source, longest)) = reached(job, normals, part) {
                let scale = part.scale * dent.strength;
                let least = if scale == 0.0 { 0.0 } else { job.instance.least() / scale.abs() };
                // Normals of a part are shown in all blocks or in none, so that they agree where blocks meet.
                let shown = least == 0.0
                    || longest > least
                    || (normals && part.carried.is_none() && job.skin.anchored[part.example].exceeds(least));
                if shown {
                    parts.push(Ready { source, scale, least, last: false });
                    touched.longest += longest * scale.abs();
                    touched.stored |= part.carried.is_none();
                } else {
                    *left_out += 1;
                }
            }
        }
        if let Some(last) = parts[before..].last_mut() {
            last.last = true;
            touched.dents += 1;
        }
    }
    touched
}

/// What moves a block.
struct Touched {
    dents: usize,
    /// No vertex is moved further by all of them together, m.
    longest: f32,
    /// Whether anchored examples are among them.
    stored: bool,
}

/// What a part brings to the block, if anything, and the longest of its displacements, m.
#[inline(always)]
fn reached<'a>(job: Job<'a>, normals: bool, part: &'a Part) -> Option<(Source<'a>, f32)> {
    let skin = job.skin;
    match &part.carried {
        Some(c) if c.reaches(&skin.block_bounds[job.block]) => {
            let stamp = job.instance.example_set().examples()[part.example].stamp()?;
            Some((Source::Carried(c, stamp), stamp.longest))
        }
        Some(_) => None,
        None => {
            let anchored = &skin.anchored[part.example];
            let head = anchored.block(job.block as u32)?;
            let changes = if normals { anchored.normals(head) } else { Stored::NOTHING };
            Some((Source::Stored(anchored.displacements(head), changes), head.longest))
        }
    }
}

/// Writes positions (m), and unit normals if wanted: three floats a vertex of the block, no more; and the bounds of the
/// positions. A mesh without normals gets none.
pub(crate) fn block<'a>(
    job: Job<'a>,
    room: &mut Room<'a>,
    positions: &mut [f32],
    normals: Option<&mut [f32]>,
    bounds: &mut Aabb,
) {
    let mesh = &job.skin.mesh;
    let range = block_range(job.block, job.skin.vertex_count());
    assert!(positions.len() == 3 * range.len() && normals.as_ref().is_none_or(|n| n.len() == 3 * range.len()));
    let base: &[f32] = bytemuck::cast_slice(&mesh.positions()[range.clone()]);
    let base_normals: Option<&[f32]> = mesh.normals().map(|n| bytemuck::cast_slice(&n[range.clone()]));
    let normals = normals.zip(base_normals);
    if let Some(state) = job.instance.classic_state() {
        *bounds = classic(state, range.start, positions, normals);
        return;
    }
    let mut normals = normals;
    if lone(job, base, positions, &mut normals, bounds) {
        return;
    }
    let touched = active(job, normals.is_some(), room);
    if touched.dents == 0 {
        positions.copy_from_slice(base);
        if let Some((normals, base)) = normals {
            normals.copy_from_slice(base);
        }
        *bounds = job.skin.block_bounds[job.block];
        return;
    }
    let block = Block {
        base: whole(base, &mut room.base),
        base_normals: normals.as_ref().map(|(_, base)| whole(base, &mut room.base_normals)),
        len: range.len(),
        parts: &room.parts,
        window: job.skin.rim.block(job.block),
        several: touched.dents > 1,
        lengths: lengths(job.instance),
        limit: limit(job.instance, touched.longest),
    };
    // The last block of a mesh may be short.
    let short = range.len() < BLOCK;
    let to = if short { &mut room.positions } else { into(positions, &mut room.positions) };
    let mut normals = normals.map(|(n, _)| n);
    let to_normals = match &mut normals {
        Some(n) if !short => into(n, &mut room.normals),
        _ => &mut room.normals,
    };
    (bounds.min, bounds.max) = levels::displace(&block, touched.stored, to, to_normals);
    if short {
        positions.copy_from_slice(&room.positions[..positions.len()]);
        if let Some(n) = normals {
            n.copy_from_slice(&room.normals[..n.len()]);
        }
    }
}

/// Where one anchored example is all that can move the block, under the depth limit: in one pass, bound by memory. The same
/// bits as the general way gives. False where it is not so; nothing is written then. A block that is short of vertices goes the
/// general way if normals are wanted.
#[inline(always)]
fn lone(
    job: Job<'_>,
    base: &[f32],
    positions: &mut [f32],
    normals: &mut Option<(&mut [f32], &[f32])>,
    bounds: &mut Aabb,
) -> bool {
    let mut near = job.instance.damage().near(&job.skin.block_bounds[job.block]);
    let (Some(dent), None) = (near.next(), near.next()) else { return false };
    let [Part { example, scale, carried: None }] = &dent.parts[..] else { return false };
    let anchored = &job.skin.anchored[*example];
    let (Some(head), scale) = (anchored.block(job.block as u32), scale * dent.strength) else { return false };
    if job.instance.least() > 0.0 || reaches(head.longest * scale.abs(), job.instance.depth_limit()) {
        return false;
    }
    if let Some((to, base)) = normals {
        let (Some(to), Some(base)) = (to.first_chunk_mut(), base.first_chunk()) else { return false };
        levels::turn_stored(base, &anchored.normals(head), scale, to);
    }
    let stored = anchored.displacements(head);
    (bounds.min, bounds.max) = levels::displace_stored(base, &stored, scale, positions);
    true
}

/// How lengths of the instance's dents combine.
pub(crate) fn lengths(instance: &Instance) -> Lengths {
    match instance.example_set().options().combine {
        Combine::Sum => Lengths::Free,
        Combine::Energies => Lengths::Squares,
        Combine::Deepest => Lengths::Longest,
    }
}

/// The instance's depth limit, m, where dents of this summed length may reach it.
pub(crate) fn limit(instance: &Instance, longest: f32) -> Option<f32> {
    Some(instance.depth_limit()).filter(|limit| reaches(longest, *limit))
}

/// Whether dents of this summed length may reach the limit, m: rounding never takes a length over it by more.
fn reaches(longest: f32, limit: f32) -> bool {
    longest * 1.00001 > limit
}

/// A whole block: `from`, or `room` with its floats and zeros where it is short.
fn whole<'b>(from: &'b [f32], room: &'b mut Flat) -> &'b Flat {
    if let Some(whole) = from.first_chunk() {
        return whole;
    }
    room.fill(0.0);
    room[..from.len()].copy_from_slice(from);
    room
}

/// A whole block to write: `to` itself, unless it is short.
fn into<'b>(to: &'b mut [f32], room: &'b mut Flat) -> &'b mut Flat {
    match to.first_chunk_mut() {
        Some(whole) => whole,
        None => room,
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
    let turned = turned_as(base, normal, t.truncate());
    let flat = turned - normal * normal.dot(turned);
    unit(flat).unwrap_or_else(|| crate::math::tangent_basis(normal).x_axis).extend(t.w)
}
