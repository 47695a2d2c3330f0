//! A stamp: an example's displacement field resampled once, at build, into a small grid in its contact frame, so that it
//! can be carried to where the body was hit, on any mesh.
//!
//! The frame has its origin at the example's contact, x and y in the surface, z along the normal. A node's value is that
//! of the surface nearest to it (inverse-square mean of the four nearest vertices), faded out away from the surface; a
//! vertex of the deformed mesh reads it by trilinear interpolation. Outside the grid the field is zero.

use crate::math::Aabb;
use crate::nearest::VertexIndex;
use glam::{Mat3, UVec3, Vec3};

/// Displacements below this share of the deepest are left out of a stamp's extent: long flat tails would cost the dent itself
/// its nodes.
const EXTENT: f32 = 1e-2;
/// Full value up to this distance from the surface, as a share of the support radius …
const FADE_FROM: f32 = 0.1;
/// … and nothing from here.
const FADE_TO: f32 = 0.2;

/// An example's field on a grid in its contact frame.
#[derive(Debug, Clone)]
pub struct Stamp {
    /// Nodes along x, y, z; each at least 2.
    dims: UVec3,
    /// Position of node (0, 0, 0), m.
    origin: Vec3,
    /// Distance between nodes, m.
    cell: Vec3,
    /// Displacements in the contact frame, m; x runs fastest.
    displacements: Vec<Vec3>,
    /// Changes of the unit normal in the contact frame; empty where the mesh has no normals.
    normals: Vec<Vec3>,
    /// The base normals those are changes of, in the contact frame: a vertex that faces elsewhere (the lid beside a dented
    /// wall) must not take them over.
    facing: Vec<Vec3>,
    /// Greatest distance of a grid corner from the contact: across the surface, and along the normal, m.
    reach: (f32, f32),
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
    /// Resamples a field into at most `resolution` nodes an axis.
    pub(crate) fn build(s: &Source<'_>, resolution: u32) -> Self {
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
        let edge = s.index.four(s.contact).iter().map(|(_, d2)| d2.sqrt()).fold(0.0, f32::max);
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
        let cell = (hi - lo) / (dims - UVec3::ONE).as_vec3();
        let count = (dims.x * dims.y * dims.z) as usize;
        let mut stamp = Stamp {
            dims,
            origin: lo,
            cell,
            displacements: vec![Vec3::ZERO; count],
            normals: vec![Vec3::ZERO; if s.normals.is_some() { count } else { 0 }],
            facing: vec![Vec3::ZERO; if s.normals.is_some() { count } else { 0 }],
            reach: (
                Vec3::new(lo.x.abs().max(hi.x.abs()), lo.y.abs().max(hi.y.abs()), 0.0).length(),
                lo.z.abs().max(hi.z.abs()),
            ),
        };
        for i in 0..count {
            let at = UVec3::new(i as u32 % dims.x, i as u32 / dims.x % dims.y, i as u32 / (dims.x * dims.y));
            let p = s.contact + s.frame * (lo + at.as_vec3() * cell);
            let node = stamp_node(s, p, fade);
            // Zero on the sides of the grid: the field ends without a step.
            if at.x > 0 && at.y > 0 && at.x + 1 < dims.x && at.y + 1 < dims.y {
                stamp.displacements[i] = to_frame * node.displacement;
                if s.normals.is_some() {
                    stamp.normals[i] = to_frame * node.normal;
                }
            }
            if s.normals.is_some() {
                stamp.facing[i] = to_frame * node.facing;
            }
        }
        stamp
    }

    /// Displacement at `p` (contact frame, m), in the contact frame, m.
    pub fn displacement(&self, p: Vec3) -> Vec3 {
        self.cell_of(p).map_or(Vec3::ZERO, |c| c.read(&self.displacements, self.dims))
    }

    /// Displacement at `p`, and the change of a unit normal that is `normal` at rest (both in the contact frame): the
    /// example's own change, times the cosine between the two surfaces, none where they face apart.
    pub(crate) fn with_normal(&self, p: Vec3, normal: Vec3) -> Option<(Vec3, Vec3)> {
        let c = self.cell_of(p)?;
        let u = c.read(&self.displacements, self.dims);
        if self.normals.is_empty() {
            return Some((u, Vec3::ZERO));
        }
        let facing = c.read(&self.facing, self.dims);
        let length = facing.length();
        let cos = if length > 0.0 { (facing.dot(normal) / length).clamp(0.0, 1.0) } else { 0.0 };
        Some((u, c.read(&self.normals, self.dims) * cos))
    }

    /// Nodes along x, y and z.
    pub fn dims(&self) -> [u32; 3] {
        self.dims.to_array()
    }

    /// Position of node (0, 0, 0) in the contact frame, and the distance between nodes, m.
    pub fn grid(&self) -> ([f32; 3], [f32; 3]) {
        (self.origin.to_array(), self.cell.to_array())
    }

    /// The nodes' displacements in the contact frame, m; x runs fastest, then y.
    pub fn nodes(&self) -> &[Vec3] {
        &self.displacements
    }

    /// The nodes' changes of the unit normal in the contact frame; empty where the mesh has no normals.
    pub fn normal_nodes(&self) -> &[Vec3] {
        &self.normals
    }

    /// The nodes' base normals (not of unit length between vertices) in the contact frame; as many as there are normals.
    pub fn facing_nodes(&self) -> &[Vec3] {
        &self.facing
    }

    /// Radius of a sphere around the contact that holds the grid when it is stretched by `stretch` in the surface, m.
    pub(crate) fn reach(&self, stretch: f32) -> f32 {
        let (across, along) = (self.reach.0 * stretch, self.reach.1);
        // A little more than exact, so that rounding never cuts a vertex off.
        (across * across + along * along).sqrt() * 1.0001
    }

    pub(crate) fn bytes(&self) -> usize {
        (self.displacements.len() + self.normals.len() + self.facing.len()) * 12
    }

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
    fn read(&self, nodes: &[Vec3], dims: UVec3) -> Vec3 {
        let (sy, sz) = (dims.x as usize, (dims.x * dims.y) as usize);
        let o = self.base.x as usize + self.base.y as usize * sy + self.base.z as usize * sz;
        let lerp = |a: Vec3, b: Vec3, t: f32| a + (b - a) * t;
        let row = |o: usize| lerp(nodes[o], nodes[o + 1], self.t.x);
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
    let (mut node, mut sum, mut keep) = (Node::default(), 0.0f32, 1.0f32);
    // Distances below a ten-thousandth of the fade count as hits of the vertex itself.
    let floor = fade.0 * fade.0 * 1e-8;
    let near = s.index.four_if_near(p, fade.1);
    if near.is_empty() {
        return node;
    }
    for (k, (v, d2)) in near.iter().enumerate() {
        if k == 0 {
            let d = d2.sqrt();
            if d >= fade.1 {
                return Node::default();
            }
            keep = ((fade.1 - d) / (fade.1 - fade.0)).min(1.0);
        }
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
