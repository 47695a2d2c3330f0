//! Held rims. If the examples show that an edge of the sheet does not move, carried dents fade to zero towards it.
//!
//! A rim is a loop of boundary edges. It is held if no example moves any of its vertices, but some example moves a
//! vertex beside it. A vertex counts as moved if its displacement exceeds a hundredth of the example's deepest. A
//! vertex is beside a rim if it shares a triangle with it or lies within the window's width. Near a held rim, carried
//! displacements are multiplied by a window that rises smoothly from 0 on the rim to 1 at [`WIDTH`] of the diagonal.
//! What examples leave where they were made is not changed.

use super::Mesh;
use super::field::Field;
use super::nearest::VertexIndex;
use super::vertex_blocks::{BLOCK, block_range};
use crate::base::array::Array;
use crate::base::lists::Lists;
use crate::base::math::Aabb;
use glam::Vec3;
use rstar::{RTree, primitives::GeomWithData};

/// Width of the window, as a share of the bounds' diagonal.
const WIDTH: f32 = 0.03;
/// A vertex counts as moved above this share of the example's deepest displacement.
const MOVED: f32 = 0.01;

/// Vertices of a block that are looked at only if their box is near a held rim.
const PART: usize = 16;

/// The factors for carried displacements of one block's vertices, 0 to 1.
pub(crate) type WindowBlock = [f32; BLOCK];

const OPEN: WindowBlock = [1.0; BLOCK];

/// The windows of the blocks near held rims.
#[derive(Debug, Default, Clone)]
pub(crate) struct Rim {
    /// For each block the index of its windows, or [`Rim::CLEAR`] if all are open. Empty if no rim is held.
    pub(crate) blocks: Array<u32>,
    pub(crate) windows: Array<WindowBlock>,
    /// The held vertices, increasing.
    pub(crate) held: Array<u32>,
}

impl Rim {
    /// Marks a block away from every held rim.
    pub(crate) const CLEAR: u32 = u32::MAX;

    /// Finds the held rims. `examples` says for each example which vertices it [moves](moves).
    pub(crate) fn find(mesh: &Mesh, examples: &[Vec<bool>]) -> Self {
        let rim = Rim { held: held(mesh, examples).into(), ..Rim::default() };
        let windows = rim.on(mesh, mesh);
        Rim { held: rim.held, ..windows }
    }

    /// The windows of the same rims for the vertices of another mesh of the same body. Its list of held vertices is
    /// empty.
    pub(crate) fn on(&self, own: &Mesh, other: &Mesh) -> Self {
        let held = self.held.iter().map(|v| *v as usize).filter(|v| own.weld()[*v] as usize == *v);
        let points: Vec<Vec3> = held.map(|v| own.positions()[v]).collect();
        let (blocks, windows) = windows(&points, own.bounds().diagonal(), other);
        Rim { blocks: blocks.into(), windows: windows.into(), held: Array::default() }
    }

    /// Whether no rim is held.
    pub(crate) fn is_open(&self) -> bool {
        self.windows.is_empty()
    }

    /// The factor at vertex `v`.
    pub(crate) fn at(&self, v: u32) -> f32 {
        let block = self.blocks.get(v as usize / BLOCK).and_then(|b| self.windows.get(*b as usize));
        block.map_or(1.0, |b| b[v as usize % BLOCK])
    }

    pub(crate) fn bytes(&self) -> usize {
        self.blocks.bytes() + self.windows.bytes() + self.held.bytes()
    }
}

/// Windows of a mesh's vertices around held points, for a body with this diagonal (m). Returns the index of each
/// block's windows, and the windows.
fn windows(held: &[Vec3], diagonal: f32, mesh: &Mesh) -> (Vec<u32>, Vec<WindowBlock>) {
    if held.is_empty() {
        return Default::default();
    }
    let width = WIDTH * diagonal;
    let index = VertexIndex::of_points(held);
    // Squared distance to the nearest held point, m².
    let nearest = |p: Vec3| index.several::<1>(p).first().map(|(d2, _)| *d2);
    let window = |p: Vec3| {
        let Some(d2) = nearest(p) else { return 1.0 };
        let s = d2.sqrt() / width;
        if s.is_nan() || s >= 1.0 {
            return 1.0;
        }
        s * s * (3.0 - 2.0 * s)
    };
    let any_near = |b: &Aabb| nearest(b.centre()).is_some_and(|d2| d2.sqrt() <= reach_of(b, width));
    let positions = mesh.positions();
    let mut all: Vec<WindowBlock> = Vec::new();
    let blocks = mesh.block_bounds().iter().enumerate().map(|(b, bounds)| {
        if !any_near(bounds) {
            return Rim::CLEAR;
        }
        let mut block = OPEN;
        for (part, points) in positions[block_range(b, positions.len())].chunks(PART).enumerate() {
            if any_near(&Aabb::of(points)) {
                points.iter().enumerate().for_each(|(i, p)| block[part * PART + i] = window(*p));
            }
        }
        if block == OPEN {
            return Rim::CLEAR;
        }
        all.push(block);
        all.len() as u32 - 1
    });
    (blocks.collect(), all)
}

/// The distance from a box's centre beyond which nothing is within `width` of any point of the box, m. More than
/// rounding errors need.
fn reach_of(b: &Aabb, width: f32) -> f32 {
    (width + 0.5 * b.diagonal()) * 1.001 + f32::MIN_POSITIVE
}

/// Whether an example moves each vertex. Pass the displacements as given: those that a tolerance drops still show that
/// an edge is free.
pub(crate) fn moves(deltas: &Field) -> Vec<bool> {
    let deepest = deltas.longest();
    let mut moves = vec![false; deltas.len()];
    deltas.moved().for_each(|(v, d)| moves[v] = d.length() > MOVED * deepest);
    moves
}

/// Returns the vertices of the held loops, every vertex at each position.
fn held(mesh: &Mesh, examples: &[Vec<bool>]) -> Vec<u32> {
    let (triangles, weld) = (mesh.triangles(), mesh.weld());
    let welded = |t: &[u32; 3]| t.map(|v| weld[v as usize]);
    let boundary = boundary(triangles.iter().map(welded), weld.len());
    if boundary.is_empty() {
        return Vec::new();
    }
    let loops = loops(mesh.positions().len(), &boundary);
    // Pairs of a vertex beside a loop (the lowest at its position) and the loop.
    let mut beside: Vec<(u32, u32)> = Vec::new();
    for t in triangles.iter().map(welded) {
        for v in t {
            for w in t {
                if let (None, Some(l)) = (loops[w as usize], loops[v as usize]) {
                    beside.push((w, l));
                }
            }
        }
    }
    // Next to a clamped edge of a fine mesh, vertices hardly move, so vertices within the window's width count too.
    let positions = mesh.positions();
    let width = WIDTH * mesh.bounds().diagonal();
    let edge = (0..positions.len() as u32).filter(|v| weld[*v as usize] == *v);
    let edge = edge.filter_map(|v| Some(GeomWithData::new(positions[v as usize].to_array(), loops[v as usize]?)));
    let edge: RTree<GeomWithData<[f32; 3], u32>> = RTree::bulk_load(edge.collect());
    // Most bodies have one loop, so the first vertex found tells all.
    let first = edge.iter().next().map(|r| r.data);
    let single = edge.iter().all(|r| Some(r.data) == first);
    let within = |p: Vec3, distance: f32| edge.locate_within_distance(p.to_array(), distance.powi(2));
    for (b, bounds) in mesh.block_bounds().iter().enumerate() {
        if within(bounds.centre(), reach_of(bounds, width)).next().is_none() {
            continue;
        }
        for v in block_range(b, positions.len()).filter(|v| weld[*v] as usize == *v && loops[*v].is_none()) {
            let mut last = None;
            for r in within(positions[v], width).take(if single { 1 } else { usize::MAX }) {
                if last.replace(r.data) != Some(r.data) {
                    beside.push((v as u32, r.data));
                }
            }
        }
    }
    beside.sort_unstable();
    beside.dedup();
    let rim: Vec<(u32, u32)> = loops.iter().zip(0..).filter_map(|(l, v)| l.map(|l| (v, l))).collect();
    let (beside, rim) = (copies(weld, &beside), copies(weld, &rim));
    let moves = |near: &[(u32, u32)]| {
        let mut moved = vec![false; weld.len()];
        for (v, l) in near {
            moved[*l as usize] |= examples.iter().any(|e| e[*v as usize]);
        }
        moved
    };
    let (free, shown) = (moves(&rim), moves(&beside));
    rim.iter().filter(|(_, l)| !free[*l as usize] && shown[*l as usize]).map(|(v, _)| *v).collect()
}

/// The edges that belong to one triangle only, sorted, with the lower vertex first.
pub(super) fn boundary(triangles: impl Iterator<Item = [u32; 3]> + Clone, vertices: usize) -> Vec<(u32, u32)> {
    let edges = triangles.flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
    let edges = edges.map(|(a, b)| (a.min(b), a.max(b))).filter(|e| e.0 != e.1);
    // Sorts by the lower vertex by counting, then each vertex's few edges by the higher one.
    let mut higher = Lists::new(vertices, || edges.clone().map(|(a, b)| (a as usize, b)));
    let mut boundary = Vec::new();
    for (own, v) in higher.all_mut().zip(0..) {
        own.sort_unstable();
        boundary.extend(own.chunk_by(|a, b| a == b).filter(|c| c.len() == 1).map(|c| (v, c[0])));
    }
    boundary
}

/// Adds to `near` (sorted) all vertices at the positions of its vertices.
fn copies(weld: &[u32], near: &[(u32, u32)]) -> Vec<(u32, u32)> {
    let at = |w: u32| near[near.partition_point(|n| n.0 < w)..].iter().take_while(move |n| n.0 == w);
    weld.iter().zip(0..).flat_map(|(w, v)| at(*w).map(move |n| (v, n.1))).collect()
}

/// The loop of boundary edges that each vertex is on, named by the loop's lowest vertex (union-find).
fn loops(vertices: usize, boundary: &[(u32, u32)]) -> Vec<Option<u32>> {
    fn root(parent: &mut [u32], mut v: u32) -> u32 {
        while parent[v as usize] != v {
            parent[v as usize] = parent[parent[v as usize] as usize];
            v = parent[v as usize];
        }
        v
    }
    let mut parent: Vec<u32> = (0..vertices as u32).collect();
    for (a, b) in boundary {
        let (a, b) = (root(&mut parent, *a), root(&mut parent, *b));
        parent[a.max(b) as usize] = a.min(b);
    }
    let mut loops = vec![None; vertices];
    boundary.iter().flat_map(|(a, b)| [*a, *b]).for_each(|v| loops[v as usize] = Some(root(&mut parent, v)));
    loops
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::data::MeshData;

    #[test]
    fn windows_are_those_of_comparing_all_points() {
        let at = |v: usize| [(v % 70) as f32 * 0.1, (v / 70) as f32 * 0.1, ((v * 37) % 11) as f32 * 0.01];
        let mesh = MeshData { positions: (0..4900).map(at).collect(), ..Default::default() };
        let (mesh, _) = Mesh::new(mesh).unwrap();
        let held: Vec<Vec3> = (0..70).chain([2500, 2500, 4899]).map(|v| mesh.positions()[v]).collect();
        let diagonal = 12.0;
        let (blocks, windows) = windows(&held, diagonal, &mesh);
        assert!(blocks.contains(&Rim::CLEAR) && windows.len() > 3);
        let rim = Rim { blocks: blocks.into(), windows: windows.into(), held: Array::default() };
        for (p, v) in mesh.positions().iter().zip(0..) {
            let off = |h: &Vec3| (p.x - h.x) * (p.x - h.x) + (p.y - h.y) * (p.y - h.y) + (p.z - h.z) * (p.z - h.z);
            let s = held.iter().map(off).fold(f32::INFINITY, f32::min).sqrt() / (WIDTH * diagonal);
            let factor = if s < 1.0 { s * s * (3.0 - 2.0 * s) } else { 1.0 };
            assert_eq!(rim.at(v), factor, "{v}");
        }
    }

    #[test]
    fn boundary_edges_have_one_triangle() {
        let triangles = [[0, 1, 2], [2, 1, 3], [4, 4, 3]];
        let found = boundary(triangles.into_iter(), 5);
        assert_eq!(found, [(0, 1), (0, 2), (1, 3), (2, 3)]);
        assert_eq!(boundary([[0, 1, 2], [2, 1, 0]].into_iter(), 3), []);
    }
}
