//! Computes vertices from marks: a pure function, evaluated one block at a time.
//!
//! ```text
//! S(v) = sum of u_m(v)      position(v) = base(v) + S(v) * min(1, L / |S(v)|)
//! ```
//!
//! Anchored examples are summed in the sorted order of their marks with plain f32 operations, carried ones in whole steps
//! ([`super::sums`]). So the result has the same bits for coincident vertices, for any division into blocks, on any thread and
//! at any [`crate::SimdLevel`].

use super::follow::Following;
use super::kernel::{Block, Flat, ReadyLookup, ReadyPart, Source, whole};
use super::levels;
use super::sums::{BlockSums, ChangedDent};
use super::view::{DamageView, DisplacedVertices, NodeView, may_reach};
use crate::base::math::{Aabb, tangent_basis, turned_as, unit};
use crate::basis::{ONE, Rows, TILE};
use crate::damage::dent::{Dent, Part};
use crate::example::blocks::Stored;
use crate::example::mesh_lod::MeshLod;
use crate::mesh::Mesh;
use crate::mesh::vertex_blocks::{BLOCK, block_range};
use glam::{Vec3, Vec4};

/// One block to evaluate.
#[derive(Clone, Copy)]
pub(crate) struct BlockJob<'a> {
    pub view: &'a DamageView<'a>,
    pub lod: &'a MeshLod,
    pub block: usize,
}

/// Position and unit normal of one vertex, with the same bits as [`block`] writes.
pub(crate) fn vertex(view: &DamageView<'_>, lod: &MeshLod, v: usize) -> (Vec3, Option<Vec3>) {
    let (block, i) = (v / BLOCK, v % BLOCK);
    let n = 3 * block_range(block, lod.vertex_count()).len();
    let (mut positions, mut normals): (Flat, Flat) = ([0.0; 3 * BLOCK], [0.0; 3 * BLOCK]);
    let some = lod.mesh.normals().is_some();
    let job = BlockJob { view, lod, block };
    let mut bounds = Aabb::EMPTY;
    self::block(job, &mut Scratch::new(), None, &mut positions[..n], some.then_some(&mut normals[..n]), &mut bounds);
    let at = |f: &Flat| Vec3::new(f[3 * i], f[3 * i + 1], f[3 * i + 2]);
    (at(&positions), some.then(|| at(&normals)))
}

/// Memory reused between blocks.
pub(crate) struct Scratch<'a> {
    parts: Vec<ReadyPart<'a>>,
    lookups: Vec<ReadyLookup<'a>>,
    /// The steps of a tile's nodes.
    moves: Vec<[i32; 3]>,
    /// Number of parts that the tolerance has left out of blocks so far.
    pub left_out: u32,
    base: Flat,
    base_normals: Flat,
    positions: Flat,
    normals: Flat,
}

impl Scratch<'_> {
    pub(crate) fn new() -> Self {
        let zero = [0.0; 3 * BLOCK];
        Scratch {
            parts: Vec::new(),
            lookups: Vec::new(),
            moves: Vec::new(),
            left_out: 0,
            base: zero,
            base_normals: zero,
            positions: zero,
            normals: zero,
        }
    }
}

/// Whether the dents that changed have fewer look-ups in the block than all dents there are.
#[inline(always)]
fn fewer(job: BlockJob<'_>, changed: &[ChangedDent<'_>]) -> bool {
    let bounds = &job.lod.block_bounds[job.block];
    let near = changed.iter().filter(|c| c.reach.meets(bounds));
    let changed: usize = near.map(|c| c.dent.lookups()).sum();
    let all: usize = job.view.damage.near(bounds).map(Dent::lookups).sum();
    changed < all
}

/// Collects in `scratch`, in order, the parts of the instance's dents that move vertices of the block. If the dents that
/// `changed` are given, these take the place of all carried examples.
#[inline(always)]
fn active<'a>(
    job: BlockJob<'a>,
    changed: Option<&'a [ChangedDent<'a>]>,
    normals: bool,
    scratch: &mut Scratch<'a>,
) -> Touched {
    scratch.parts.clear();
    scratch.lookups.clear();
    let bounds = &job.lod.block_bounds[job.block];
    let mut touched = Touched { dents: 0, longest: 0.0, stored: false };
    let which = if changed.is_some() { Which::Anchored } else { Which::All };
    job.view.damage.near(bounds).for_each(|dent| add_dent(job, (dent, 1.0, which), normals, scratch, &mut touched));
    for ChangedDent { dent, reach, sign } in changed.into_iter().flatten() {
        if reach.meets(bounds) {
            add_dent(job, (dent, *sign, Which::Carried), normals, scratch, &mut touched);
        }
    }
    touched
}

/// Parts of a dent.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Which {
    All,
    Anchored,
    Carried,
}

/// Adds parts of a dent, with a sign, to those of the block.
#[inline(always)]
fn add_dent<'a>(
    job: BlockJob<'a>,
    (dent, sign, which): (&'a Dent, f32, Which),
    normals: bool,
    scratch: &mut Scratch<'a>,
    touched: &mut Touched,
) {
    let Scratch { parts, lookups, left_out, .. } = scratch;
    let (lod, examples) = (job.lod, job.view.set.examples());
    let bounds = &lod.block_bounds[job.block];
    let before = parts.len();
    for part in &dent.parts {
        let scale = sign * dent.strength * if let Part::Anchored(_, scale) = part { *scale } else { 1.0 };
        let threshold = if scale == 0.0 { 0.0 } else { job.view.threshold / scale.abs() };
        let source = match part {
            Part::Carried(_) if which == Which::Anchored => continue,
            Part::Anchored(..) if which == Which::Carried => continue,
            Part::Carried(carried) => {
                let first = lookups.len();
                for lookup in carried.reaching(bounds) {
                    let Some(stamp) = examples[lookup.example].stamp() else { continue };
                    if threshold == 0.0 || lookup.longest > threshold {
                        lookups.push(ReadyLookup(lookup, &stamp.nodes));
                        touched.longest += lookup.longest * scale.abs();
                    } else {
                        *left_out += 1;
                    }
                }
                (lookups.len() > first).then_some(Source::Carried(carried, first..lookups.len()))
            }
            // Nodes sum these; vertices follow nodes.
            Part::Predicted(..) => continue,
            Part::Anchored(example, _) => {
                let anchored = &lod.anchored[*example];
                let Some(head) = anchored.block(job.block as u32) else { continue };
                // The normals are applied in all blocks or in none, so that they agree where blocks meet.
                let shown = threshold == 0.0 || head.longest > threshold || (normals && anchored.exceeds(threshold));
                let changes = if normals { anchored.normals(head) } else { Stored::NOTHING };
                *left_out += u32::from(!shown);
                touched.longest += if shown { head.longest * scale.abs() } else { 0.0 };
                touched.stored |= shown;
                shown.then(|| Source::Stored(anchored.displacements(head), changes))
            }
        };
        parts.extend(source.map(|source| ReadyPart { source, scale, threshold, last: false }));
    }
    if let Some(last) = parts[before..].last_mut() {
        last.last = true;
        touched.dents += 1;
    }
}

/// Summary of what moves a block.
struct Touched {
    dents: usize,
    /// The most that all of them together can move a vertex, m.
    longest: f32,
    /// Whether some of them are anchored examples.
    stored: bool,
}

/// Writes positions (m) and, if wanted, unit normals: exactly three floats per vertex of the block. Also writes the
/// bounds of the positions. Writes no normals if the mesh has none. With `kept` sums, and the dents that changed since, only
/// these and anchored examples are evaluated, for the same bits.
pub(crate) fn block<'a>(
    job: BlockJob<'a>,
    scratch: &mut Scratch<'a>,
    mut kept: Option<(&mut BlockSums, &'a [ChangedDent<'a>])>,
    positions: &mut [f32],
    normals: Option<&mut [f32]>,
    bounds: &mut Aabb,
) {
    let mesh = &job.lod.mesh;
    let range = block_range(job.block, job.lod.vertex_count());
    assert!(positions.len() == 3 * range.len() && normals.as_ref().is_none_or(|n| n.len() == 3 * range.len()));
    let base: &[f32] = bytemuck::cast_slice(&mesh.positions()[range.clone()]);
    let base_normals: Option<&[f32]> = mesh.normals().map(|n| bytemuck::cast_slice(&n[range.clone()]));
    let normals = normals.zip(base_normals);
    if let (Some(rows), Some(nodes)) = (&job.lod.rows, &job.view.nodes) {
        *bounds = followed(job, (rows, nodes), scratch, base, positions, normals);
        return;
    }
    if let Some(state) = job.view.vertices {
        *bounds = given(state, mesh, range.start, positions, normals);
        return;
    }
    let mut normals = normals;
    if kept.is_none() && lone(job, base, positions, &mut normals, bounds) {
        return;
    }
    let changed = kept.as_mut().and_then(|(sums, changed)| {
        let pays = sums.known && fewer(job, changed);
        if sums.known && !pays {
            **sums = BlockSums::UNKNOWN;
        }
        pays.then_some(*changed)
    });
    let mut touched = active(job, changed, normals.is_some(), scratch);
    if changed.is_some() {
        // Others contribute as well. Limits that are not reached change no bit.
        touched.longest = f32::INFINITY;
    } else if touched.dents == 0 {
        positions.copy_from_slice(base);
        if let Some((normals, base)) = normals {
            normals.copy_from_slice(base);
        }
        *bounds = job.lod.block_bounds[job.block];
        return;
    }
    let block = Block {
        base: whole(base, &mut scratch.base),
        base_normals: normals.as_ref().map(|(_, base)| whole(base, &mut scratch.base_normals)),
        len: range.len(),
        parts: &scratch.parts,
        lookups: &scratch.lookups,
        window: job.lod.rim.block(job.block),
        step: job.view.step(),
        turn_step: job.view.turn_step(),
        limit: job.view.limit(touched.longest),
        own: DamageView::own_limits(mesh, job.block, touched.longest),
    };
    // The last block of a mesh may be short.
    let short = range.len() < BLOCK;
    let to = if short { &mut scratch.positions } else { into(positions, &mut scratch.positions) };
    let mut normals = normals.map(|(n, _)| n);
    let to_normals = match &mut normals {
        Some(n) if !short => into(n, &mut scratch.normals),
        _ => &mut scratch.normals,
    };
    let carried = kept.is_some() || !block.lookups.is_empty();
    let sums = kept.map(|(kept, _)| {
        kept.known = true;
        &mut kept.sums
    });
    (bounds.min, bounds.max) = levels::displace(&block, (touched.stored, carried), sums, to, to_normals);
    if short {
        positions.copy_from_slice(&scratch.positions[..positions.len()]);
        if let Some(n) = normals {
            n.copy_from_slice(&scratch.normals[..n.len()]);
        }
    }
}

/// The vertices of a block that follow nodes.
fn followed(
    job: BlockJob<'_>,
    (rows, nodes): (&Rows, &NodeView<'_>),
    scratch: &mut Scratch<'_>,
    base: &[f32],
    positions: &mut [f32],
    normals: Option<(&mut [f32], &[f32])>,
) -> Aabb {
    let vertices = job.lod.vertex_count();
    let first = job.block * (BLOCK / TILE);
    let short = base.len() < 3 * BLOCK;
    let (mut normals, base_normals) = normals.unzip();
    let Scratch {
        moves,
        base: whole_base,
        base_normals: whole_normals,
        positions: short_to,
        normals: short_normals,
        ..
    } = scratch;
    let whole_base = whole(base, whole_base);
    let whole_normals = base_normals.map(|base| whole(base, whole_normals));
    let mut bounds = Aabb::EMPTY;
    {
        // The last block of a mesh may be short.
        let to = if short { &mut *short_to } else { into(positions, short_to) };
        let to_normals = match &mut normals {
            Some(n) if !short => into(n, short_normals),
            _ => &mut *short_normals,
        };
        for (tile, head) in (0..).zip(&rows.tiles[first..rows.tiles.len().min(first + BLOCK / TILE)]) {
            let range = (first + tile) * TILE..((first + tile + 1) * TILE).min(vertices);
            let of_tile = rows.nodes_of(first + tile);
            let steps = |n: &u32| nodes.steps[*n as usize];
            if of_tile.iter().all(|n| steps(n) == [0; 4]) {
                let floats = 3 * tile * TILE..3 * (tile * TILE + range.len());
                to[floats.clone()].copy_from_slice(&whole_base[floats.clone()]);
                if let Some(base) = whole_normals {
                    to_normals[floats.clone()].copy_from_slice(&base[floats]);
                }
                bounds.union(&Aabb::of(&job.lod.mesh.positions()[range]));
                continue;
            }
            moves.clear();
            let mut farthest = 0.0f32;
            for pair in of_tile.chunks_exact(2) {
                let [a, b] = [steps(&pair[0]), steps(&pair[1])];
                moves.push([0, 1, 2].map(|k| (i32::from(b[k]) << 16) | i32::from(a[k] as u16)));
                for s in [a, b] {
                    farthest = farthest.max(Vec3::from([s[0], s[1], s[2]].map(f32::from)).length_squared());
                }
            }
            // No vertex moves further.
            let longest = farthest.sqrt() * nodes.step * (head.most as f32 / ONE as f32);
            let following = Following {
                base: whole_base,
                base_normals: whole_normals,
                first: tile * TILE,
                len: range.len(),
                moves,
                weights: rows.weights_of(first + tile),
                slopes: rows.slopes_of(first + tile).unwrap_or_default(),
                unit: nodes.step / ONE as f32,
                slope_unit: nodes.step * head.slope,
                limit: job.view.limit(longest),
                own: DamageView::own_limits(&job.lod.mesh, job.block, longest),
            };
            let (low, high) = levels::follow(&following, to, to_normals);
            bounds.union(&Aabb { min: low, max: high });
        }
    }
    if short {
        positions.copy_from_slice(&short_to[..positions.len()]);
        if let Some(n) = normals {
            n.copy_from_slice(&short_normals[..n.len()]);
        }
    }
    bounds
}

/// The fast path for a block that a single anchored example moves by less than the depth limit: one pass, limited by
/// memory bandwidth. Writes the same bits as the general path. Returns false and writes nothing if the path does not
/// apply. It does not apply to a short block if normals are wanted.
#[inline(always)]
fn lone(
    job: BlockJob<'_>,
    base: &[f32],
    positions: &mut [f32],
    normals: &mut Option<(&mut [f32], &[f32])>,
    bounds: &mut Aabb,
) -> bool {
    let mut near = job.view.damage.near(&job.lod.block_bounds[job.block]);
    let (Some(dent), None) = (near.next(), near.next()) else { return false };
    let [Part::Anchored(example, scale)] = &dent.parts[..] else { return false };
    let anchored = &job.lod.anchored[*example];
    let (Some(head), scale) = (anchored.block(job.block as u32), scale * dent.strength) else { return false };
    let longest = head.longest * scale.abs();
    if job.view.threshold > 0.0
        || may_reach(longest, job.view.depth_limit)
        || DamageView::own_limits(&job.lod.mesh, job.block, longest).is_some()
    {
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

/// A whole block to write to: `to`, or `scratch` if `to` is short.
fn into<'b>(to: &'b mut [f32], scratch: &'b mut Flat) -> &'b mut Flat {
    match to.first_chunk_mut() {
        Some(whole) => whole,
        None => scratch,
    }
}

fn given(
    state: DisplacedVertices<'_>,
    mesh: &Mesh,
    first: usize,
    positions: &mut [f32],
    normals: Option<(&mut [f32], &[f32])>,
) -> Aabb {
    let mut bounds = Aabb::EMPTY;
    let mut normals = normals.map(|(to, base)| to.chunks_exact_mut(3).zip(base.chunks_exact(3)));
    for (i, p) in positions.chunks_exact_mut(3).enumerate() {
        let (at, factor) = shortened(state, mesh, first + i);
        bounds.add(at);
        p.copy_from_slice(&at.to_array());
        let Some((n, base)) = normals.as_mut().and_then(Iterator::next) else { continue };
        let base = Vec3::from_slice(base);
        let mut now = state.normals.get(first + i).copied().unwrap_or(base);
        if factor < 1.0 {
            now = base + (now - base) * factor;
        }
        let now = if now == base { now } else { unit(now).unwrap_or(base) };
        n.copy_from_slice(&now.to_array());
    }
    bounds
}

/// The position of a vertex that a classic rule displaced, with its own limits, and their factor for the displacement.
fn shortened(state: DisplacedVertices<'_>, mesh: &Mesh, v: usize) -> (Vec3, f32) {
    let (base, at) = (mesh.positions()[v], state.positions[v]);
    let factor = mesh.limits().factor(v as u32, at - base);
    (if factor < 1.0 { base + (at - base) * factor } else { at }, factor)
}

/// The base tangent, rotated as the normal was and made orthogonal to the new normal. Keeps w.
pub(crate) fn tangent(lod: &MeshLod, v: usize, normal: Vec3) -> Vec4 {
    let Some(t) = lod.mesh.tangents().map(|t| t[v]) else { return Vec4::W };
    let base = lod.mesh.normals().map_or(normal, |n| n[v]);
    if normal == base {
        return t;
    }
    let turned = turned_as(base, normal, t.truncate());
    let flat = turned - normal * normal.dot(turned);
    unit(flat).unwrap_or_else(|| tangent_basis(normal).x_axis).extend(t.w)
}
