//! A stamp: an example's displacement field resampled once, at build, into a small grid in its contact frame, so that it
//! can be carried to where the body was hit, on any mesh.
//!
//! The frame has its origin at the example's contact, x and y in the surface, z along the normal. A node's value is that
//! of the surface nearest to it (inverse-square mean of the four nearest vertices), faded out away from the surface; a
//! vertex of the deformed mesh reads it by trilinear interpolation. Outside the grid the field is zero.
//!
//! With a tolerance the grid is the coarsest that holds it at the example's own vertices (at most `stamp_resolution` nodes a
//! side), and nodes are packed into 4 or 8 bytes.

use crate::array::Array;
use crate::math::Aabb;
use crate::nearest::VertexIndex;
use crate::simd::{PACKED, pack, unpack};
use glam::{Mat3, UVec3, Vec3};

/// Displacements below this share of the deepest are left out of a stamp's extent: long flat tails would cost the dent itself
/// its nodes.
const EXTENT: f32 = 1e-2;
/// Full value up to this distance from the surface, as a share of the support radius …
const FADE_FROM: f32 = 0.1;
/// … and nothing from here.
const FADE_TO: f32 = 0.2;
/// Nodes along the longest side of the coarsest grid.
const COARSEST: u32 = 4;
/// Where no grid holds the tolerance, narrower nodes may add this share to the error that the finest has.
const NARROWER: f32 = 1.05;

/// An example's field on a grid in its contact frame.
#[derive(Debug, Clone)]
pub struct Stamp {
    pub(crate) grid: Grid,
    /// Displacements in the contact frame, m; x runs fastest.
    pub(crate) displacements: Nodes,
    /// Changes of the unit normal in the contact frame; empty where the mesh has no normals.
    pub(crate) normals: Nodes,
    /// The base normals those are changes of, in the contact frame: a vertex that faces elsewhere (the lid beside a dented
    /// wall) must not take them over.
    pub(crate) facing: Nodes,
    /// Length of the longest displacement of a node, m.
    pub(crate) longest: f32,
    /// How far it is off the example at its own vertices, m; unknown in exact sets.
    pub(crate) error: Option<StampError>,
}

/// How far a stamp is off its example, at the vertices that the example moves, m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StampError {
    /// At the worst vertex.
    pub max: f32,
    /// Root of the mean square.
    pub rms: f32,
}

/// Where a stamp's nodes are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Grid {
    /// Nodes along x, y, z; each at least 2.
    pub dims: UVec3,
    /// Position of node (0, 0, 0), m.
    pub origin: Vec3,
    /// Distance between nodes, m.
    pub cell: Vec3,
}

impl Grid {
    /// Of nothing.
    pub(crate) const POINT: Grid = Grid { dims: UVec3::splat(2), origin: Vec3::ZERO, cell: Vec3::ONE };

    pub(crate) fn count(&self) -> usize {
        (self.dims.x * self.dims.y * self.dims.z) as usize
    }

    /// Greatest distance of a corner from the contact: across the surface, and along the normal, m.
    fn reach(&self) -> (f32, f32) {
        let far = self.origin.abs().max((self.origin + (self.dims - UVec3::ONE).as_vec3() * self.cell).abs());
        (far.truncate().length(), far.z)
    }

    fn position(&self, i: usize) -> (UVec3, Vec3) {
        let (i, d) = (i as u32, self.dims);
        let at = UVec3::new(i % d.x, i / d.x % d.y, i / (d.x * d.y));
        (at, self.origin + at.as_vec3() * self.cell)
    }
}

/// One field over a grid.
#[derive(Debug, Clone)]
pub(crate) struct Nodes {
    pub array: NodeArray,
    /// What the numbers of x, y and z are multiples of; 1 where they are floats.
    pub step: Vec3,
}

#[derive(Debug, Clone)]
pub(crate) enum NodeArray {
    /// 10, 11 and 11 bits.
    Packed(Array<u32>),
    /// 16 bits each; the fourth is 0.
    Half(Array<[i16; 4]>),
    Exact(Array<[f32; 3]>),
}

impl Nodes {
    fn exact(nodes: &[Vec3]) -> Self {
        let nodes: Vec<[f32; 3]> = nodes.iter().map(|n| n.to_array()).collect();
        Nodes { array: NodeArray::Exact(nodes.into()), step: Vec3::ONE }
    }

    fn none() -> Self {
        Nodes { array: NodeArray::Exact(Array::default()), step: Vec3::ONE }
    }

    fn packed(nodes: &[Vec3]) -> Self {
        let (step, whole) = steps(nodes, Vec3::from(PACKED.map(|m| m as f32)));
        let nodes: Vec<u32> = whole.map(|n| pack(n.map(|x| x as i32))).collect();
        Nodes { array: NodeArray::Packed(nodes.into()), step }
    }

    fn half(nodes: &[Vec3]) -> Self {
        let (step, whole) = steps(nodes, Vec3::splat(32767.0));
        let nodes: Vec<[i16; 4]> = whole.map(|[x, y, z]| [x as i16, y as i16, z as i16, 0]).collect();
        Nodes { array: NodeArray::Half(nodes.into()), step }
    }

    pub(crate) fn len(&self) -> usize {
        match &self.array {
            NodeArray::Packed(n) => n.len(),
            NodeArray::Half(n) => n.len(),
            NodeArray::Exact(n) => n.len(),
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        match &self.array {
            NodeArray::Packed(n) => n.bytes(),
            NodeArray::Half(n) => n.bytes(),
            NodeArray::Exact(n) => n.bytes(),
        }
    }

    #[inline]
    fn at(&self, i: usize) -> Vec3 {
        let n = match &self.array {
            NodeArray::Packed(n) => Vec3::from(unpack(n[i]).map(|x| x as f32)),
            NodeArray::Half(n) => Vec3::new(n[i][0].into(), n[i][1].into(), n[i][2].into()),
            NodeArray::Exact(n) => Vec3::from(n[i]),
        };
        n * self.step
    }

    pub(crate) fn longest(&self) -> f32 {
        (0..self.len()).map(|i| self.at(i).length()).fold(0.0, f32::max)
    }

    fn all(&self) -> Vec<Vec3> {
        (0..self.len()).map(|i| self.at(i)).collect()
    }
}

/// The step of each component for which the largest is `most` steps, and the nodes in steps.
fn steps(nodes: &[Vec3], most: Vec3) -> (Vec3, impl Iterator<Item = [f32; 3]> + '_) {
    let largest = nodes.iter().fold(Vec3::ZERO, |m, n| m.max(n.abs()));
    let step = Vec3::select(largest.cmpgt(Vec3::ZERO), largest / most, Vec3::ONE);
    (step, nodes.iter().map(move |n| (*n / step).clamp(-most, most).to_array().map(f32::round_ties_even)))
}

/// What a stamp is made from: fields over the base mesh, and the contact's frame.
pub(crate) struct Source<'a> {
    pub positions: &'a [Vec3],
    pub index: &'a VertexIndex,
    pub deltas: &'a [Vec3],
    /// Changes of the unit normals, and the base normals themselves.
    pub normals: Option<(&'a [Vec3], &'a [Vec3])>,
    /// Columns x, y, z of the contact frame.
    pub frame: Mat3,
    pub contact: Vec3,
    pub max_depth: f32,
    pub support_radius: f32,
}

impl Stamp {
    /// Resamples a field into at most `resolution` nodes an axis; with a tolerance (m) into the coarsest grid and the narrowest
    /// nodes that hold it, or, where none does, that are about as good as the finest.
    pub(crate) fn build(s: &Source<'_>, resolution: u32, tolerance: Option<f32>) -> Self {
        let finest = Fields::resample(s, resolution);
        let Some(tolerance) = tolerance else { return finest.stamp(Nodes::exact, Nodes::exact) };
        let error = |f: &Fields| s.error(&f.grid, &Nodes::exact(&f.displacements));
        let reached = error(&finest).max;
        let (mut best, mut allowed) = (finest, tolerance);
        if reached > tolerance {
            allowed = reached * NARROWER;
        } else {
            // The error falls with the resolution, if not always: bisected, then held.
            let (mut low, mut high) = (COARSEST.min(resolution), resolution);
            while low < high {
                let middle = low.midpoint(high);
                let fields = Fields::resample(s, middle);
                if error(&fields).max <= tolerance * 0.9 {
                    high = middle;
                    best = fields;
                } else {
                    low = middle + 1;
                }
            }
        }
        let mut stamp = best.stamp(Nodes::packed, Nodes::packed);
        let mut off = s.error(&stamp.grid, &stamp.displacements);
        if off.max > allowed {
            stamp = best.stamp(Nodes::half, Nodes::packed);
            off = s.error(&stamp.grid, &stamp.displacements);
        }
        stamp.error = Some(off);
        stamp
    }

    /// Displacement at `p` (contact frame, m), in the contact frame, m.
    pub fn displacement(&self, p: Vec3) -> Vec3 {
        self.grid.cell_of(p).map_or(Vec3::ZERO, |c| c.read(&self.displacements, self.grid.dims))
    }

    /// Nodes along x, y and z.
    pub fn dims(&self) -> [u32; 3] {
        self.grid.dims.to_array()
    }

    /// Position of node (0, 0, 0) in the contact frame, and the distance between nodes, m.
    pub fn grid(&self) -> ([f32; 3], [f32; 3]) {
        (self.grid.origin.to_array(), self.grid.cell.to_array())
    }

    /// The nodes' displacements in the contact frame, m; x runs fastest, then y.
    pub fn nodes(&self) -> Vec<Vec3> {
        self.displacements.all()
    }

    /// The nodes' changes of the unit normal in the contact frame; empty where the mesh has no normals.
    pub fn normal_nodes(&self) -> Vec<Vec3> {
        self.normals.all()
    }

    /// The nodes' base normals (not of unit length between vertices) in the contact frame; as many as there are normals.
    pub fn facing_nodes(&self) -> Vec<Vec3> {
        self.facing.all()
    }

    /// How far it is off the example at the vertices that the example moves; `None` in a set without a tolerance, where it was
    /// not measured.
    pub fn error(&self) -> Option<StampError> {
        self.error
    }

    /// Bytes a node's displacement takes: 4, 8 or (exact) 12.
    pub fn node_bytes(&self) -> usize {
        self.displacements.bytes() / self.displacements.len().max(1)
    }

    /// Radius of a sphere around the contact that holds the grid when it is stretched by `stretch` in the surface, m.
    pub(crate) fn reach(&self, stretch: f32) -> f32 {
        let (across, along) = self.grid.reach();
        let across = across * stretch;
        // A little more than exact, so that rounding never cuts a vertex off.
        (across * across + along * along).sqrt() * 1.0001
    }

    pub(crate) fn bytes(&self) -> usize {
        self.displacements.bytes() + self.normals.bytes() + self.facing.bytes()
    }
}

/// The fields of a stamp, as floats.
struct Fields {
    grid: Grid,
    displacements: Vec<Vec3>,
    normals: Vec<Vec3>,
    facing: Vec<Vec3>,
}

impl Fields {
    fn resample(s: &Source<'_>, resolution: u32) -> Self {
        let to_frame = s.frame.transpose();
        let limit = s.max_depth * EXTENT;
        let mut b = Aabb::EMPTY;
        b.add(Vec3::ZERO);
        for (p, d) in s.positions.iter().zip(s.deltas) {
            if d.length() >= limit {
                b.add(to_frame * (*p - s.contact));
            }
        }
        // Between the last vertex that moves and its unmoved neighbours the field falls to zero over an edge's length; an
        // example that moves a single vertex is nothing but that.
        let edge = s.index.four(s.contact).iter().map(|(d2, _)| d2.sqrt()).fold(0.0, f32::max);
        let edge = if edge > 0.0 { edge } else { s.max_depth };
        let radius = s.support_radius.max(edge);
        // Room for the fade along the normal, and for the taper across the surface: an edge, and at least a cell.
        let fade = (radius * FADE_FROM, radius * FADE_TO);
        let across = (b.max - b.min).max(Vec3::splat(radius * 0.02)) / (resolution - 3).max(1) as f32;
        let pad = Vec3::new(across.x.max(edge), across.y.max(edge), fade.1);
        let (lo, hi) = (b.min - pad, b.max + pad);
        let fine = across.x.min(across.y);
        let dims = UVec3::new(
            resolution,
            resolution,
            (((hi.z - lo.z) / fine).ceil() as u32).saturating_add(1).clamp(2, resolution),
        );
        let grid = Grid { dims, origin: lo, cell: (hi - lo) / (dims - UVec3::ONE).as_vec3() };
        let count = grid.count();
        let with_normals = if s.normals.is_some() { count } else { 0 };
        let mut fields = Fields {
            grid,
            displacements: vec![Vec3::ZERO; count],
            normals: vec![Vec3::ZERO; with_normals],
            facing: vec![Vec3::ZERO; with_normals],
        };
        for i in 0..count {
            let (at, p) = grid.position(i);
            let node = stamp_node(s, s.contact + s.frame * p, fade);
            // Zero on the sides of the grid: the field ends without a step.
            if at.x > 0 && at.y > 0 && at.x + 1 < dims.x && at.y + 1 < dims.y {
                fields.displacements[i] = to_frame * node.displacement;
                if s.normals.is_some() {
                    fields.normals[i] = to_frame * node.normal;
                }
            }
            if s.normals.is_some() {
                fields.facing[i] = to_frame * node.facing;
            }
        }
        fields
    }

    fn stamp(&self, displacements: impl Fn(&[Vec3]) -> Nodes, normals: impl Fn(&[Vec3]) -> Nodes) -> Stamp {
        let some = |nodes: &[Vec3]| if nodes.is_empty() { Nodes::none() } else { normals(nodes) };
        let displacements = displacements(&self.displacements);
        Stamp {
            grid: self.grid,
            longest: displacements.longest(),
            displacements,
            normals: some(&self.normals),
            facing: some(&self.facing),
            error: None,
        }
    }
}

impl Source<'_> {
    /// How far `nodes` are off the field they were made from, at the vertices that it moves.
    fn error(&self, grid: &Grid, nodes: &Nodes) -> StampError {
        let to_frame = self.frame.transpose();
        let (mut max, mut sum, mut count) = (0.0f32, 0.0f64, 0u32);
        for (p, d) in self.positions.iter().zip(self.deltas).filter(|(_, d)| **d != Vec3::ZERO) {
            let at = grid.cell_of(to_frame * (*p - self.contact));
            let off = at.map_or(Vec3::ZERO, |c| self.frame * c.read(nodes, grid.dims)) - *d;
            max = max.max(off.length());
            sum += f64::from(off.length_squared());
            count += 1;
        }
        StampError { max, rms: (sum / f64::from(count.max(1))).sqrt() as f32 }
    }
}

impl Grid {
    fn cell_of(&self, p: Vec3) -> Option<Cell> {
        let g = (p - self.origin) / self.cell;
        let top = (self.dims - UVec3::ONE).as_vec3();
        // Also false for NaN.
        if !(g.cmpge(Vec3::ZERO).all() && g.cmple(top).all()) {
            return None;
        }
        let base = g.as_uvec3().min(self.dims - UVec3::splat(2));
        Some(Cell { base, t: g - base.as_vec3() })
    }
}

struct Cell {
    base: UVec3,
    t: Vec3,
}

impl Cell {
    fn read(&self, nodes: &Nodes, dims: UVec3) -> Vec3 {
        let (sy, sz) = (dims.x as usize, (dims.x * dims.y) as usize);
        let o = self.base.x as usize + self.base.y as usize * sy + self.base.z as usize * sz;
        let lerp = |a: Vec3, b: Vec3, t: f32| a + (b - a) * t;
        let row = |o: usize| lerp(nodes.at(o), nodes.at(o + 1), self.t.x);
        let plane = |o: usize| lerp(row(o), row(o + sy), self.t.y);
        lerp(plane(o), plane(o + sz), self.t.z)
    }
}

/// The fields at one node, in mesh space.
#[derive(Default)]
struct Node {
    displacement: Vec3,
    normal: Vec3,
    facing: Vec3,
}

/// The fields at `p`: mean of the four nearest vertices, changes faded with distance from the surface.
fn stamp_node(s: &Source<'_>, p: Vec3, fade: (f32, f32)) -> Node {
    let near = s.index.four_if_near(p, fade.1);
    let Some(d) = near.first().map(|(d2, _)| d2.sqrt()).filter(|d| *d < fade.1) else { return Node::default() };
    let keep = ((fade.1 - d) / (fade.1 - fade.0)).min(1.0);
    // Distances below a ten-thousandth of the fade count as hits of the vertex itself.
    let floor = fade.0 * fade.0 * 1e-8;
    let (mut node, mut sum) = (Node::default(), 0.0f32);
    for &(d2, v) in &near {
        let w = 1.0 / d2.max(floor);
        node.displacement += s.deltas[v as usize] * w;
        if let Some((changes, base)) = s.normals {
            node.normal += changes[v as usize] * w;
            node.facing += base[v as usize] * w;
        }
        sum += w;
    }
    node.displacement *= keep / sum;
    node.normal *= keep / sum;
    node.facing /= sum;
    node
}
