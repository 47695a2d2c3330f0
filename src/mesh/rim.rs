//! Held rims. If the examples show that an edge of the sheet does not move, carried dents fade to zero towards it.
//!
//! A rim is a loop of boundary edges. It is held if no example moves any of its vertices, but some example moves a
//! vertex beside it. A vertex counts as moved if its displacement exceeds a hundredth of the example's deepest. A
//! vertex is beside a rim if it shares a triangle with it or lies within the window's width. Near a held rim, carried
//! displacements are multiplied by a window that rises smoothly from 0 on the rim to 1 at [`WIDTH`] of the diagonal.
//! Anchored examples are not changed.

use super::Mesh;
use super::vertex_blocks::{BLOCK, block_range};
use crate::base::array::Array;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use rstar::{RTree, primitives::GeomWithData};

/// Width of the window, as a share of the bounds' diagonal.
const WIDTH: f32 = 0.03;
/// A vertex counts as moved above this share of the example's deepest displacement.
const MOVED: f32 = 0.01;

/// The window at one vertex.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Window {
    /// Factor for carried displacements, 0 to 1.
    pub factor: f32,
    /// Gradient of the factor, 1/m.
    pub gradient: Vec3,
}

impl Window {
    /// The window away from every held rim.
    pub(crate) const OPEN: Window = Window { factor: 1.0, gradient: Vec3::ZERO };
}

/// The windows of one block's vertices, one array per component.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct WindowBlock {
    pub factor: [f32; BLOCK],
    /// x, y, z; 1/m.
    pub gradient: [[f32; BLOCK]; 3],
}

impl WindowBlock {
    const OPEN: WindowBlock = WindowBlock { factor: [1.0; BLOCK], gradient: [[0.0; BLOCK]; 3] };

    /// Upper bound of the length of a window's gradient, 1/m, for a body with this diagonal (m).
    pub(crate) fn steepest(diagonal: f32) -> f32 {
        // 6 s (1 - s) is at most 1.5. Slightly more to allow for rounding.
        1.51 / (WIDTH * diagonal)
    }

    fn set(&mut self, i: usize, w: Window) {
        self.factor[i] = w.factor;
        self.gradient.iter_mut().zip(w.gradient.to_array()).for_each(|(g, x)| g[i] = x);
    }
}

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
        let held = held(mesh, examples);
        let points: Vec<Vec3> = held.iter().map(|v| mesh.positions()[*v as usize]).collect();
        let (blocks, windows) = windows(&points, mesh.bounds().diagonal(), mesh.positions());
        Rim { blocks: blocks.into(), windows: windows.into(), held: held.into() }
    }

    /// The windows of the same rims for the vertices of another mesh of the same body. Its list of held vertices is
    /// empty.
    pub(crate) fn on(&self, own: &Mesh, other: &[Vec3]) -> Self {
        let points: Vec<Vec3> = self.held.iter().map(|v| own.positions()[*v as usize]).collect();
        let (blocks, windows) = windows(&points, own.bounds().diagonal(), other);
        Rim { blocks: blocks.into(), windows: windows.into(), held: Array::default() }
    }

    /// The windows of block `b`, or `None` if all are open.
    pub(crate) fn block(&self, b: usize) -> Option<&WindowBlock> {
        self.windows.get(*self.blocks.get(b)? as usize)
    }

    /// The window at vertex `v`.
    pub(crate) fn at(&self, v: u32) -> Window {
        let i = v as usize % BLOCK;
        self.block(v as usize / BLOCK)
            .map_or(Window::OPEN, |b| Window { factor: b.factor[i], gradient: Vec3::from(b.gradient.map(|g| g[i])) })
    }

    /// Number of held vertices.
    pub(crate) fn vertices(&self) -> usize {
        self.held.len()
    }

    pub(crate) fn bytes(&self) -> usize {
        self.blocks.bytes() + self.windows.bytes() + self.held.bytes()
    }
}

/// Windows around held points for a body with this diagonal (m). Returns the index of each block's windows, and the
/// windows.
fn windows(held: &[Vec3], diagonal: f32, positions: &[Vec3]) -> (Vec<u32>, Vec<WindowBlock>) {
    if held.is_empty() {
        return Default::default();
    }
    let width = WIDTH * diagonal;
    let points = held.iter().map(|p| p.to_array()).collect();
    let index: RTree<[f32; 3]> = RTree::bulk_load(points);
    let window = |p: Vec3| {
        let Some((near, d2)) = index.nearest_neighbor_iter_with_distance_2(p.to_array()).next() else {
            return Window::OPEN;
        };
        let away = p - Vec3::from(*near);
        let s = d2.sqrt() / width;
        if s.is_nan() || s >= 1.0 {
            return Window::OPEN;
        }
        let slope = if d2 > 0.0 { away / d2.sqrt() * (6.0 * s * (1.0 - s) / width) } else { Vec3::ZERO };
        Window { factor: s * s * (3.0 - 2.0 * s), gradient: slope }
    };
    let mut all: Vec<WindowBlock> = Vec::new();
    let blocks = (0..positions.len().div_ceil(BLOCK)).map(|b| {
        let mut block = WindowBlock::OPEN;
        positions[block_range(b, positions.len())].iter().enumerate().for_each(|(i, p)| block.set(i, window(*p)));
        if block.factor.iter().all(|f| *f >= 1.0) {
            return Rim::CLEAR;
        }
        all.push(block);
        all.len() as u32 - 1
    });
    (blocks.collect(), all)
}

/// Whether an example moves each vertex. Pass the displacements as given: those that a tolerance drops still show that
/// an edge is free.
pub(crate) fn moves(deltas: &[Vec3]) -> Vec<bool> {
    let deepest = deltas.iter().map(|d| d.length()).fold(0.0, f32::max);
    deltas.iter().map(|d| d.length() > MOVED * deepest).collect()
}

/// Returns the vertices of the held loops. Includes every vertex at each position, because an example may tear them
/// apart.
fn held(mesh: &Mesh, examples: &[Vec<bool>]) -> Vec<u32> {
    let (triangles, weld) = (mesh.triangles(), mesh.weld());
    let welded = |t: &[u32; 3]| t.map(|v| weld[v as usize]);
    let mut edges: Vec<(u32, u32)> = Vec::with_capacity(triangles.len() * 3);
    for t in triangles.iter().map(welded) {
        edges.extend(
            [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])].map(|(a, b)| (a.min(b), a.max(b))).iter().filter(|e| e.0 != e.1),
        );
    }
    edges.sort_unstable();
    let boundary: Vec<(u32, u32)> = edges.chunk_by(|a, b| a == b).filter(|c| c.len() == 1).map(|c| c[0]).collect();
    if boundary.is_empty() {
        return Vec::new();
    }
    let mut loops = Loops::new(mesh.positions().len(), &boundary);
    // Pairs of a vertex beside a loop (the lowest at its position) and the loop.
    let mut beside: Vec<(u32, u32)> = Vec::new();
    for t in triangles.iter().map(welded) {
        for v in t {
            for w in t {
                if !loops.has(w)
                    && let Some(l) = loops.of(v)
                {
                    beside.push((w, l));
                }
            }
        }
    }
    // Next to a clamped edge of a fine mesh, vertices hardly move, so vertices within the window's width count too.
    let positions = mesh.positions();
    let edge = (0..positions.len() as u32).filter(|v| weld[*v as usize] == *v && loops.has(*v));
    let edge = RTree::bulk_load(edge.map(|v| GeomWithData::new(positions[v as usize].to_array(), v)).collect());
    let near = (WIDTH * mesh.bounds().diagonal()).powi(2);
    for v in 0..positions.len() as u32 {
        if weld[v as usize] != v || loops.has(v) {
            continue;
        }
        let mut last = None;
        for r in edge.locate_within_distance(positions[v as usize].to_array(), near) {
            let at = loops.of(r.data);
            if at != last {
                beside.extend(at.map(|l| (v, l)));
                last = at;
            }
        }
    }
    beside.sort_unstable();
    beside.dedup();
    let rim: Vec<(u32, u32)> = (0..weld.len() as u32).filter_map(|v| loops.of(v).map(|l| (v, l))).collect();
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

/// Adds to `near` (sorted) all vertices at the positions of its vertices.
fn copies(weld: &[u32], near: &[(u32, u32)]) -> Vec<(u32, u32)> {
    let at = |w: u32| near[near.partition_point(|n| n.0 < w)..].iter().take_while(move |n| n.0 == w);
    weld.iter().zip(0..).flat_map(|(w, v)| at(*w).map(move |n| (v, n.1))).collect()
}

/// Boundary vertices joined into loops (union-find).
struct Loops {
    parent: Vec<u32>,
    member: Vec<bool>,
}

impl Loops {
    fn new(vertices: usize, edges: &[(u32, u32)]) -> Self {
        let mut loops = Loops { parent: (0..vertices as u32).collect(), member: vec![false; vertices] };
        for (a, b) in edges {
            loops.member[*a as usize] = true;
            loops.member[*b as usize] = true;
            let (a, b) = (loops.root(*a), loops.root(*b));
            loops.parent[a.max(b) as usize] = a.min(b);
        }
        loops
    }

    fn has(&self, v: u32) -> bool {
        self.member[v as usize]
    }

    /// The loop of vertex `v`, named by the loop's lowest vertex.
    fn of(&mut self, v: u32) -> Option<u32> {
        self.has(v).then(|| self.root(v))
    }

    fn root(&mut self, mut v: u32) -> u32 {
        while self.parent[v as usize] != v {
            let up = self.parent[self.parent[v as usize] as usize];
            self.parent[v as usize] = up;
            v = up;
        }
        v
    }
}
