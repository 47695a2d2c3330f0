//! A stamp: an example's fields laid flat at build, so that the example can be carried to where a body was hit, on any mesh.
//!
//! In the example's contact frame (origin at the contact, x and y in the surface, z along the normal) the surface around the
//! contact is unrolled onto a plane:
//!
//! ```text
//! q = (x, y) (1 + min(z² / (x² + y²), 2) / 2)
//! ```
//!
//! On a flat sheet that is (x, y); on a cylinder, up to 109 degrees around, within 5 % of the length of the arc. A small grid over q
//! keeps what the example does there, and how high the surface lies. A vertex takes the grid's bilinear mean at its own q, times a
//! factor that falls with its distance along z from that height: from 1 at half the stamp's [`Stamp::fade`] to 0 at all of it.
//! Outside the grid the fields are zero. Nodes are eight numbers of 16 bits, weights whole numbers of 14 bits, so that means are exact
//! in integers and the same on every processor.
//!
//! A node's value is that of the surface under it (inverse-square mean of the four nearest vertices). With a tolerance the grid is
//! the coarsest that holds it at the example's own vertices (at most `stamp_resolution` nodes a side).

use crate::base::array::Array;
use crate::base::math::Aabb;
use crate::mesh::nearest::VertexIndex;
use glam::{Mat3, UVec2, Vec2, Vec3};
use std::collections::VecDeque;

/// Displacements below this share of the deepest are left out of a stamp's extent: long flat tails would cost the dent itself
/// its nodes.
const EXTENT: f32 = 1e-2;
/// Nothing is moved from this distance above or below the surface, as a share of the support radius.
const FADE: f32 = 0.2;
/// Nodes along the longest side of the coarsest grid.
const COARSEST: u32 = 4;
/// Displacement x, y, z; height; change of the unit normal x, y, z; z of the base normal.
pub(crate) type Node = [i16; 8];
/// What the four weights of a bilinear mean sum to.
pub(crate) const WEIGHTS: f32 = 16384.0;
/// The greatest number in a node.
const MOST: f32 = 32767.0;
/// From a weighted sum of the nodes' last numbers to the z of a base normal.
pub(crate) const FACING: f32 = 1.0 / (MOST * WEIGHTS);

/// An example's fields around its contact, in its contact frame.
#[derive(Debug, Clone)]
pub struct Stamp {
    pub(crate) grid: Grid,
    /// x runs fastest.
    pub(crate) nodes: Array<Node>,
    pub(crate) steps: NodeSteps,
    /// Nothing is moved from this distance above or below the surface, m.
    pub(crate) fade: f32,
    /// The lowest and the highest node, m.
    pub(crate) heights: (f32, f32),
    /// No displacement read from it is longer, m.
    pub(crate) longest: f32,
    /// How far it is off the example at its own vertices.
    pub(crate) error: StampError,
}

/// What a node's numbers are multiples of. (The z of the base normal: of 1/32767.)
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NodeSteps {
    /// m.
    pub displacement: Vec3,
    /// m.
    pub height: f32,
    pub normal: Vec3,
}

/// How far a stamp is off its example, at the vertices that the example moves, m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StampError {
    /// At the worst vertex.
    pub max: f32,
    /// Root of the mean square.
    pub rms: f32,
}

/// Where a stamp's nodes are, on the unrolled surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Grid {
    /// Nodes along x and y; each at least 2.
    pub dims: UVec2,
    /// Position of node (0, 0), m.
    pub origin: Vec2,
    /// Distance between nodes, m.
    pub cell: Vec2,
}

/// What unrolling multiplies x and y with at height `up` above or below the contact, `across` (squared) beside it.
pub(crate) fn lift(up: f32, across: f32) -> f32 {
    // Not a number where both are 0, which is then no less than 2.
    let steep = up * up / across;
    1.0 + 0.5 * if steep < 2.0 { steep } else { 2.0 }
}

/// A point of the contact frame on the plane. A point right above or below the contact is at its place.
pub(crate) fn unrolled(p: Vec3) -> Vec2 {
    let scale = lift(p.z, p.x * p.x + p.y * p.y);
    Vec2::new(p.x * scale, p.y * scale)
}

/// The point at height `z` that [`unrolled`] takes to `q`; `z` is held to where there is one.
fn rolled(q: Vec2, z: f32) -> Vec3 {
    let r = q.length();
    let z = z.clamp(-0.7 * r, 0.7 * r);
    let across = 0.5 * (r + (r * r - 2.0 * z * z).max(0.0).sqrt());
    (q.normalize_or_zero() * across).extend(z)
}

impl Grid {
    pub(crate) fn count(&self) -> usize {
        (self.dims.x * self.dims.y) as usize
    }

    fn at(&self, i: usize) -> UVec2 {
        UVec2::new(i as u32 % self.dims.x, i as u32 / self.dims.x)
    }

    fn position(&self, i: usize) -> Vec2 {
        self.origin + self.at(i).as_vec2() * self.cell
    }
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
    /// Resamples fields into `resolution` nodes an axis; with a tolerance (m) into the coarsest grid of up to as many that
    /// holds it, if one does.
    pub(crate) fn build(s: &Source<'_>, resolution: u32, tolerance: Option<f32>) -> Self {
        let mut best = s.resample(resolution);
        let Some(tolerance) = tolerance.filter(|t| best.error.max <= *t) else { return best };
        // The error falls with the resolution, if not always: bisected, then held.
        let (mut low, mut high) = (COARSEST.min(resolution), resolution);
        while low < high {
            let middle = low.midpoint(high);
            let stamp = s.resample(middle);
            if stamp.error.max <= tolerance {
                high = middle;
                best = stamp;
            } else {
                low = middle + 1;
            }
        }
        best
    }

    /// From what a file says; heights and longest displacement are told from the nodes.
    pub(crate) fn new(grid: Grid, nodes: Array<Node>, steps: NodeSteps, fade: f32, error: StampError) -> Self {
        let height = |n: &Node| f32::from(n[3]) * steps.height;
        let heights =
            nodes.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(lo, hi), n| (lo.min(height(n)), hi.max(height(n))));
        // Weights may sum to a unit more than they should.
        let longest = nodes.iter().map(|n| (of(n, 0) * steps.displacement).length()).fold(0.0, f32::max) * 1.0002;
        Stamp { grid, nodes, steps, fade, heights, longest, error }
    }

    /// Displacement and change of the unit normal at `p` (contact frame, m) where the surface faces along its own base normal, in the
    /// contact frame; and the z of that base normal.
    pub fn read(&self, p: Vec3) -> Option<StampSample> {
        let (grid, steps) = (&self.grid, &self.steps);
        let g = unrolled(p) * (1.0 / grid.cell) - grid.origin / grid.cell;
        let top = (grid.dims - UVec2::ONE).as_vec2();
        // Also false for NaN.
        if !(g.cmpge(Vec2::ZERO).all() && g.cmple(top).all()) {
            return None;
        }
        let base = g.as_uvec2().min(grid.dims - UVec2::splat(2));
        let t = g - base.as_vec2();
        let (x, y, both) = ((t.x * WEIGHTS) as i32, (t.y * WEIGHTS) as i32, (t.x * t.y * WEIGHTS) as i32);
        let weights = [(WEIGHTS as i32 - x - y + both).max(0), x - both, y - both, both];
        let row = grid.dims.x as usize;
        let first = base.x as usize + base.y as usize * row;
        let mut sums = [0i32; 8];
        for (at, w) in [first, first + 1, first + row, first + row + 1].into_iter().zip(weights) {
            sums.iter_mut().zip(self.nodes[at]).for_each(|(s, n)| *s += w * i32::from(n));
        }
        let [x, y, z, h, nx, ny, nz, facing] = sums.map(|s| s as f32 / WEIGHTS);
        let keep = (2.0 - (p.z - h * steps.height).abs() * (2.0 / self.fade)).clamp(0.0, 1.0);
        Some(StampSample {
            displacement: Vec3::new(x, y, z) * steps.displacement * keep,
            normal: Vec3::new(nx, ny, nz) * steps.normal * keep,
            facing: facing / MOST,
        })
    }

    /// Displacement at `p` (contact frame, m), in the contact frame, m.
    pub fn displacement(&self, p: Vec3) -> Vec3 {
        self.read(p).map_or(Vec3::ZERO, |r| r.displacement)
    }

    /// Nodes along x and y of the unrolled surface.
    pub fn dims(&self) -> [u32; 2] {
        self.grid.dims.to_array()
    }

    /// Position of node (0, 0) on the unrolled surface, and the distance between nodes, m.
    pub fn grid(&self) -> ([f32; 2], [f32; 2]) {
        (self.grid.origin.to_array(), self.grid.cell.to_array())
    }

    /// The nodes' displacements in the contact frame, m; x runs fastest.
    pub fn nodes(&self) -> Vec<Vec3> {
        self.nodes.iter().map(|n| of(n, 0) * self.steps.displacement).collect()
    }

    /// How high the surface lies at the nodes: z in the contact frame, m.
    pub fn height_nodes(&self) -> Vec<f32> {
        self.nodes.iter().map(|n| f32::from(n[3]) * self.steps.height).collect()
    }

    /// The nodes' changes of the unit normal in the contact frame; zero where the mesh has no normals.
    pub fn normal_nodes(&self) -> Vec<Vec3> {
        self.nodes.iter().map(|n| of(n, 4) * self.steps.normal).collect()
    }

    /// The z of the nodes' base normals in the contact frame, -1 to 1.
    pub fn facing_nodes(&self) -> Vec<f32> {
        self.nodes.iter().map(|n| f32::from(n[7]) / MOST).collect()
    }

    /// Nothing is moved from this distance above or below the surface, m; all of it up to half the distance.
    pub fn fade(&self) -> f32 {
        self.fade
    }

    /// How far it is off the example at the vertices that the example moves.
    pub fn error(&self) -> StampError {
        self.error
    }

    /// Radius of a sphere around the contact that holds the field when it is stretched by `stretch` in the surface, m.
    pub(crate) fn reach(&self, stretch: f32) -> f32 {
        let top = (self.grid.dims - UVec2::ONE).as_vec2() * self.grid.cell;
        let across = self.grid.origin.abs().max((self.grid.origin + top).abs()).length() * stretch;
        let along = self.heights.0.abs().max(self.heights.1.abs()) + self.fade;
        // A little more than exact, so that rounding never cuts a vertex off.
        (across * across + along * along).sqrt() * 1.0001
    }

    pub(crate) fn bytes(&self) -> usize {
        self.nodes.bytes()
    }
}

/// What a [`Stamp`] says of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StampSample {
    /// Displacement in the contact frame, m.
    pub displacement: Vec3,
    /// Change of the unit normal in the contact frame.
    pub normal: Vec3,
    /// The z of the base normal.
    pub facing: f32,
}

fn of(n: &Node, first: usize) -> Vec3 {
    Vec3::new(n[first].into(), n[first + 1].into(), n[first + 2].into())
}

impl Source<'_> {
    fn resample(&self, resolution: u32) -> Stamp {
        // Between the last vertex that moves and its unmoved neighbours the field falls to zero over an edge's length; an
        // example that moves a single vertex is nothing but that.
        let edge = self.index.four(self.contact).iter().map(|(d2, _)| d2.sqrt()).fold(0.0, f32::max);
        let edge = if edge > 0.0 { edge } else { self.max_depth };
        let radius = self.support_radius.max(edge);
        let fade = (radius * FADE).max(edge);
        let grid = self.grid(resolution, edge, radius);
        let heights = self.heights(&grid, fade);
        let samples: Vec<Sample> = (0..grid.count())
            .map(|i| {
                let at = grid.at(i);
                let p = rolled(grid.position(i), heights[i]);
                // Zero on the sides of the grid: the field ends without a step.
                let side = at.cmpeq(UVec2::ZERO).any() || (at + UVec2::ONE).cmpeq(grid.dims).any();
                self.sample(self.contact + self.frame * p, fade, side)
            })
            .collect();
        let (displacement, displacements) = whole(samples.iter().map(|s| s.displacement));
        let (normal, normals) = whole(samples.iter().map(|s| s.normal));
        let (height, heights) = whole(heights.iter().map(|h| Vec3::new(0.0, 0.0, *h)));
        let nodes: Vec<Node> = (0..grid.count())
            .map(|i| {
                let ([x, y, z], [nx, ny, nz]) = (displacements[i], normals[i]);
                let facing = (samples[i].facing.clamp(-1.0, 1.0) * MOST).round_ties_even() as i16;
                [x, y, z, heights[i][2], nx, ny, nz, facing]
            })
            .collect();
        let steps = NodeSteps { displacement, height: height.z, normal };
        let stamp = Stamp::new(grid, nodes.into(), steps, fade, StampError::default());
        Stamp { error: self.error(&stamp), ..stamp }
    }

    /// A grid around what moves, with room to fall to zero: an edge, and at least a cell.
    fn grid(&self, resolution: u32, edge: f32, radius: f32) -> Grid {
        let limit = self.max_depth * EXTENT;
        let mut b = Aabb::EMPTY;
        b.add(Vec3::ZERO);
        for (p, d) in self.positions.iter().zip(self.deltas) {
            if d.length() >= limit {
                b.add(unrolled(self.to_frame(*p)).extend(0.0));
            }
        }
        let (lo, hi) = (b.min.truncate(), b.max.truncate());
        let cell = (hi - lo).max(Vec2::splat(radius * 0.02)) / (resolution - 3).max(1) as f32;
        let pad = cell.max(Vec2::splat(edge));
        let dims = UVec2::splat(resolution);
        Grid { dims, origin: lo - pad, cell: (hi - lo + pad * 2.0) / (dims - UVec2::ONE).as_vec2() }
    }

    fn to_frame(&self, p: Vec3) -> Vec3 {
        self.frame.transpose() * (p - self.contact)
    }

    /// How high the surface lies at each node. It is followed from the contact outwards, from node to node, so that of several sheets
    /// the one that was hit is kept.
    fn heights(&self, grid: &Grid, fade: f32) -> Vec<f32> {
        let mut heights = vec![f32::NAN; grid.count()];
        let (w, h) = (grid.dims.x as usize, grid.dims.y as usize);
        let middle = (-grid.origin / grid.cell).round().as_uvec2().min(grid.dims - UVec2::ONE);
        let first = middle.x as usize + middle.y as usize * w;
        heights[first] = self.height(grid.position(first), 0.0, fade);
        let mut next = VecDeque::from([first]);
        while let Some(i) = next.pop_front() {
            let (x, y) = (i % w, i / w);
            let beside = [
                (x > 0).then(|| i - 1),
                (x + 1 < w).then_some(i + 1),
                (y > 0).then(|| i - w),
                (y + 1 < h).then_some(i + w),
            ];
            for j in beside.into_iter().flatten() {
                if heights[j].is_nan() {
                    heights[j] = self.height(grid.position(j), heights[i], fade);
                    next.push_back(j);
                }
            }
        }
        heights
    }

    /// How high the surface lies at `q`, sought from a guess (m); the guess where none is near.
    fn height(&self, q: Vec2, guess: f32, fade: f32) -> f32 {
        let surface = |z: f32| -> Option<f32> {
            let p = self.contact + self.frame * rolled(q, z);
            let near = self.index.four_if_near(p, fade);
            let (mut sum, mut total) = (0.0, 0.0);
            for (d2, v) in near.iter() {
                let w = 1.0 / d2.max(fade * fade * 1e-8);
                sum += self.to_frame(self.positions[*v as usize]).z * w;
                total += w;
            }
            (total > 0.0).then(|| sum / total)
        };
        let mut z = guess;
        for _ in 0..3 {
            let Some(a) = surface(z) else { return z };
            let Some(b) = surface(a) else { return a };
            // Each step leaves the same share of the error (Aitken's extrapolation).
            let (first, second) = (a - z, b - a);
            let further = second * second / (first - second);
            z = if further.abs() <= fade && first * second > 0.0 { b + further } else { b };
        }
        z
    }

    /// The fields at `p` (mesh space): mean of the four nearest vertices, changes faded with distance from the surface, and zero if
    /// `still`.
    fn sample(&self, p: Vec3, fade: f32, still: bool) -> Sample {
        let (mut sample, mut facing, mut sum) = (Sample::default(), Vec3::ZERO, 0.0f32);
        // Distances below a ten-thousandth of the fade count as hits of the vertex itself.
        let floor = fade * fade * 1e-8;
        let near = self.index.four_if_near(p, fade);
        let Some((nearest, _)) = near.first() else { return sample };
        let keep = (2.0 - 2.0 * nearest.sqrt() / fade).clamp(0.0, 1.0);
        for (d2, v) in near.iter() {
            let w = 1.0 / d2.max(floor);
            sample.displacement += self.deltas[*v as usize] * w;
            if let Some((changes, base)) = self.normals {
                sample.normal += changes[*v as usize] * w;
                facing += base[*v as usize] * w;
            }
            sum += w;
        }
        let keep = if still { 0.0 } else { keep / sum };
        let to_frame = self.frame.transpose();
        Sample {
            displacement: to_frame * sample.displacement * keep,
            normal: to_frame * sample.normal * keep,
            facing: (to_frame * facing).normalize_or_zero().z,
        }
    }

    /// How far a stamp is off the field that it was made from, at the vertices that it moves.
    fn error(&self, stamp: &Stamp) -> StampError {
        let (mut max, mut sum, mut count) = (0.0f32, 0.0f64, 0u32);
        for (p, d) in self.positions.iter().zip(self.deltas).filter(|(_, d)| **d != Vec3::ZERO) {
            let off = self.frame * stamp.displacement(self.to_frame(*p)) - *d;
            max = max.max(off.length());
            sum += f64::from(off.length_squared());
            count += 1;
        }
        StampError { max, rms: (sum / f64::from(count.max(1))).sqrt() as f32 }
    }
}

/// The fields at one node, in the contact frame.
#[derive(Default, Clone, Copy)]
struct Sample {
    displacement: Vec3,
    normal: Vec3,
    facing: f32,
}

/// The steps of x, y and z for which the largest is [`MOST`] of them, and the vectors in steps.
fn whole(vectors: impl Iterator<Item = Vec3> + Clone) -> (Vec3, Vec<[i16; 3]>) {
    let largest = vectors.clone().fold(Vec3::ZERO, |m, v| m.max(v.abs()));
    let step = Vec3::select(largest.cmpgt(Vec3::ZERO), largest / MOST, Vec3::ONE);
    let round = |v: Vec3| (v / step).clamp(Vec3::splat(-MOST), Vec3::splat(MOST)).to_array();
    (step, vectors.map(|v| round(v).map(|x| x.round_ties_even() as i16)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cylinders_unroll_to_the_length_of_the_arc() {
        for degrees in 1..109 {
            let a = (degrees as f32).to_radians();
            let q = unrolled(Vec3::new(a.sin(), 0.0, a.cos() - 1.0));
            assert!((q.x / a - 1.0).abs() < 0.05 && q.y == 0.0, "{degrees}: {} of {a}", q.x);
        }
        assert_eq!(unrolled(Vec3::new(0.3, -0.4, 0.0)), Vec2::new(0.3, -0.4));
        assert_eq!(unrolled(Vec3::new(0.0, 0.0, 0.5)), Vec2::ZERO);
    }

    #[test]
    fn rolling_is_the_way_back() {
        for z in [-0.5f32, -0.1, 0.0, 0.3, 0.6] {
            let q = Vec2::new(0.8, -0.5);
            let p = rolled(q, z);
            assert!(p.z == z && (unrolled(p) - q).length() < 1e-5, "{p}");
        }
    }
}
