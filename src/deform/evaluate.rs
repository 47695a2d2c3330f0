//! Computes vertices from nodes: a pure function, evaluated one block at a time.
//!
//! ```text
//! s(v) = sum over nodes k of w(v, k) U(k)      position(v) = base(v) + s(v) * min(1, L / |s(v)|)
//! ```
//!
//! Sums are whole numbers ([`super::follow`]). So the result has the same bits for coincident vertices, for any division into
//! blocks, on any thread and at any [`crate::SimdLevel`].

use super::follow::{Following, Moves};
use super::kernel::{Flat, whole};
use super::levels;
use super::view::{DamageView, DisplacedVertices, NodeView, Shape};
use crate::base::math::{Aabb, tangent_basis, turned_as, unit};
use crate::basis::TILE;
use crate::example::mesh_lod::MeshLod;
use crate::mesh::Mesh;
use crate::mesh::vertex_blocks::{BLOCK, block_range};
use glam::{Vec3, Vec4};
use std::ops::Range;

/// One block to evaluate.
#[derive(Clone, Copy)]
pub(crate) struct BlockJob<'a> {
    pub view: &'a DamageView<'a>,
    pub lod: &'a MeshLod,
    pub block: usize,
}

/// Position and unit normal of one vertex, with the same bits as [`block`] writes.
pub(crate) fn vertex(view: &DamageView<'_>, lod: &MeshLod, v: usize) -> (Vec3, Option<Vec3>) {
    let (mut positions, mut normals): (Flat, Flat) = ([0.0; 3 * BLOCK], [0.0; 3 * BLOCK]);
    let some = lod.mesh.normals().is_some();
    let job = BlockJob { view, lod, block: v / BLOCK };
    block(job, &mut Scratch::new(), &mut positions, some.then_some(&mut normals));
    let at = |f: &Flat| Vec3::from_slice(&f[3 * (v % BLOCK)..]);
    (at(&positions), some.then(|| at(&normals)))
}

/// Room for the pairs of nodes of a tile; some need more.
const PAIRS: usize = 64;

/// Memory reused between blocks.
pub(crate) struct Scratch {
    /// The steps of a tile's nodes.
    moves: Moves,
    base: Flat,
    base_normals: Flat,
}

impl Scratch {
    pub(crate) fn new() -> Self {
        let zero = [0.0; 3 * BLOCK];
        Scratch { moves: Vec::with_capacity(PAIRS), base: zero, base_normals: zero }
    }
}

/// Writes positions (m) and, if wanted, unit normals. The last block of a mesh may be short: what is beyond it then means nothing.
/// Returns the bounds of the positions. Writes no normals if the mesh has none.
pub(crate) fn block(
    job: BlockJob<'_>,
    scratch: &mut Scratch,
    positions: &mut Flat,
    normals: Option<&mut Flat>,
) -> Aabb {
    let mesh = &job.lod.mesh;
    let range = block_range(job.block, job.lod.vertex_count());
    let base: &[f32] = bytemuck::cast_slice(&mesh.positions()[range.clone()]);
    let base_normals: Option<&[f32]> = mesh.normals().map(|n| bytemuck::cast_slice(&n[range.clone()]));
    let normals = normals.zip(base_normals);
    match job.view.shape {
        Shape::Nodes(nodes) => followed(job, nodes, scratch, base, positions, normals),
        Shape::Vertices(state) => given(state, mesh, range, positions, normals),
    }
}

/// The vertices of a block that follow nodes.
fn followed(
    job: BlockJob<'_>,
    nodes: NodeView<'_>,
    scratch: &mut Scratch,
    base: &[f32],
    positions: &mut Flat,
    normals: Option<(&mut Flat, &[f32])>,
) -> Aabb {
    if nodes.farthest == 0 {
        positions[..base.len()].copy_from_slice(base);
        if let Some((to, base)) = normals {
            to[..base.len()].copy_from_slice(base);
        }
        return job.lod.mesh.block_bounds()[job.block];
    }
    let Scratch { moves, base: whole_base, base_normals: whole_normals } = scratch;
    let normals = normals.map(|(to, base)| (whole(base, whole_normals), to));
    let limits = job.lod.mesh.limits();
    let following = Following {
        base: whole(base, whole_base),
        len: base.len() / 3,
        rows: &job.lod.rows,
        tile: job.block * (BLOCK / TILE),
        nodes,
        limit: job.view.depth_limit,
        own: limits.least().get(job.block).map(|least| (*least, limits.block(job.block))),
    };
    let (min, max) = levels::follow(&following, moves, positions, normals);
    Aabb { min, max }
}

/// The vertices of a block that a classic rule displaced.
fn given(
    state: DisplacedVertices<'_>,
    mesh: &Mesh,
    range: Range<usize>,
    positions: &mut Flat,
    normals: Option<(&mut Flat, &[f32])>,
) -> Aabb {
    let mut bounds = Aabb::EMPTY;
    let mut normals = normals.map(|(to, base)| to.chunks_exact_mut(3).zip(base.chunks_exact(3)));
    for (v, p) in range.zip(positions.chunks_exact_mut(3)) {
        let (base, at) = (mesh.positions()[v], state.positions[v]);
        // The vertex has its own limits.
        let factor = mesh.limits().factor(v as u32, at - base);
        let at = if factor < 1.0 { base + (at - base) * factor } else { at };
        bounds.add(at);
        p.copy_from_slice(&at.to_array());
        let Some((n, base)) = normals.as_mut().and_then(Iterator::next) else { continue };
        let base = Vec3::from_slice(base);
        let mut now = state.normals.get(v).copied().unwrap_or(base);
        if factor < 1.0 {
            now = base + (now - base) * factor;
        }
        let now = if now == base { now } else { unit(now).unwrap_or(base) };
        n.copy_from_slice(&now.to_array());
    }
    bounds
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
