//! A stamp: an example's fields resampled on a flat grid at build, so that the example can be carried to any place and
//! mesh.
//!
//! In the example's contact frame (origin at the contact, x and y in the surface, z along the normal) the surface
//! around the contact is unrolled onto a plane:
//!
//! ```text
//! q = (x, y) (1 + min(z² / (x² + y²), 2) / 2)
//! ```
//!
//! On a flat sheet q is (x, y). On a cylinder it is within 5 % of the arc length, up to 109 degrees around. A small
//! grid over q stores the example's fields and the height of the surface. A vertex takes the bilinear interpolation of
//! the grid at its own q, times a fade factor. The factor depends on the distance along z between the vertex and the
//! interpolated height: it is 1 up to half of [`Stamp::fade`] and falls to 0 at [`Stamp::fade`]. Outside the grid the
//! fields are zero. A node has four 16-bit numbers, and interpolation weights have 14 bits, so integer sums are exact
//! and the same on every processor.
//!
//! A node takes the inverse-square weighted mean of the four nearest vertices. With a tolerance, the grid is the
//! coarsest whose error at the example's own vertices is within the tolerance, with at most `stamp_resolution` nodes a
//! side.

use crate::base::array::Array;
use crate::base::math::{Aabb, Four, small_floors, small_wholes, transposed};
use crate::base::pairs::{dot, pair, paired};
use crate::mesh::field::Field;
use crate::mesh::nearest::VertexIndex;
use glam::{IVec4, Mat3, UVec2, Vec2, Vec3, Vec4};
use std::collections::VecDeque;

/// Displacements below this share of the deepest do not enlarge the grid. Otherwise long flat tails would take nodes
/// from the dent itself.
const EXTENT: f32 = 1e-2;
/// Distance above or below the surface at which the stamp has faded to zero, as a share of the support radius.
const FADE: f32 = 0.2;
/// Nodes along the longest side of the coarsest grid.
const COARSEST: u32 = 4;
/// Four numbers: displacement x, y, z; height.
pub(crate) type Node = [i16; 4];
/// Sum of the four weights of a bilinear interpolation.
pub(crate) const WEIGHTS: f32 = 16384.0;
/// The largest number in a node.
pub(crate) const MOST: f32 = 32767.0;

/// An example's fields around its contact, on a grid in its contact frame.
#[derive(Debug, Clone)]
pub struct Stamp {
    pub(crate) grid: Grid,
    /// x varies fastest.
    pub(crate) nodes: Array<Node>,
    pub(crate) steps: NodeSteps,
    /// Distance above or below the surface at which the stamp has faded to zero, m.
    pub(crate) fade: f32,
    /// Heights of the lowest and the highest node, m.
    pub(crate) heights: (f32, f32),
    /// Displacement of the contact, in its frame, m.
    pub(crate) centre: Vec3,
    /// Root of the integral of squared displacements over the unrolled surface, over π, m².
    pub(crate) spread: f32,
    /// Error at the vertices that the example moves.
    pub(crate) error: StampError,
}

/// Step sizes of a node's numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NodeSteps {
    /// Steps of the displacement, m.
    pub displacement: Vec3,
    /// Step of the height, m.
    pub height: f32,
}

/// Error of a stamp at the vertices that its example moves, m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StampError {
    /// Error at the worst vertex.
    pub max: f32,
    /// Root mean square error.
    pub rms: f32,
}

/// The positions of a stamp's nodes on the unrolled surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Grid {
    /// Number of nodes along x and y, each at least 2.
    pub dims: UVec2,
    /// Position of node (0, 0), m.
    pub origin: Vec2,
    /// Distance between nodes, m.
    pub cell: Vec2,
}

/// Factor by which unrolling scales x and y. `up` is the height above or below the contact; `across` is x² + y².
#[inline(always)]
fn lift(up: Vec4, across: Vec4) -> Vec4 {
    let (steep, most) = (up * up / across, Vec4::splat(2.0));
    // NaN if both are 0. The comparison then takes 2.
    Vec4::ONE + 0.5 * Vec4::select(steep.cmplt(most), steep, most)
}

/// Maps a point in the contact frame to the plane. Points directly above or below the contact map to the origin.
pub(crate) fn unrolled(p: Vec3) -> Vec2 {
    let scale = lift(Vec4::splat(p.z), Vec4::splat(p.x * p.x + p.y * p.y)).x;
    Vec2::new(p.x * scale, p.y * scale)
}

/// The point at height `z` that [`unrolled`] maps to `q`. `z` is clamped to the range for which such a point exists.
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

/// The input of a stamp: fields over the base mesh and the contact's frame.
pub(crate) struct Source<'a> {
    pub positions: &'a [Vec3],
    pub index: &'a VertexIndex,
    pub deltas: &'a Field,
    /// Columns x, y, z of the contact frame.
    pub frame: Mat3,
    pub contact: Vec3,
    pub max_depth: f32,
    pub support_radius: f32,
}

impl Stamp {
    /// Resamples the fields with `resolution` nodes per axis. With a tolerance (m) it uses the coarsest grid within the
    /// tolerance, if there is one of at most `resolution` nodes per axis.
    pub(crate) fn build(s: &Source<'_>, resolution: u32, tolerance: Option<f32>) -> Self {
        let mut best = s.resample(resolution);
        let Some(tolerance) = tolerance.filter(|t| best.error.max <= *t) else { return best };
        // Bisection. The error usually, but not always, falls with the resolution. `best` always holds the tolerance.
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

    /// Makes a stamp from its stored parts. Computes the heights and the longest displacement from the nodes.
    pub(crate) fn new(grid: Grid, nodes: Array<Node>, steps: NodeSteps, fade: f32, error: StampError) -> Self {
        let height = |n: &Node| f32::from(n[3]) * steps.height;
        let heights =
            nodes.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(lo, hi), n| (lo.min(height(n)), hi.max(height(n))));
        let squares = nodes.iter().map(|n| f64::from((of(n) * steps.displacement).length_squared())).sum::<f64>();
        let cell = f64::from(grid.cell.x) * f64::from(grid.cell.y);
        let spread = (squares * cell / std::f64::consts::PI).sqrt() as f32;
        let stamp = Stamp { grid, nodes, steps, fade, heights, centre: Vec3::ZERO, spread, error };
        Stamp { centre: stamp.displacement(Vec3::ZERO), ..stamp }
    }

    /// Displacement at `p`, m. Both are in the contact frame. Zero outside the grid.
    pub fn displacement(&self, p: Vec3) -> Vec3 {
        Vec3::from(self.reader(1.0).read(p.to_array().map(Vec4::splat)).map(|u| u.x))
    }

    /// What reads the stamp, stretched along the surface, at many points.
    pub(crate) fn reader(&self, stretch: f32) -> Reader<'_> {
        let (grid, steps) = (&self.grid, &self.steps);
        Reader {
            nodes: &self.nodes,
            row: grid.dims.x as usize,
            per_cell: 1.0 / (grid.cell * stretch),
            origin: grid.origin / grid.cell,
            top: (grid.dims - UVec2::ONE).as_vec2(),
            last: (grid.dims - UVec2::splat(2)).as_vec2(),
            stretch_square: stretch * stretch,
            height: steps.height / WEIGHTS,
            fade: 2.0 / self.fade,
            displacement: steps.displacement / WEIGHTS,
        }
    }

    /// Number of nodes along x and y of the unrolled surface.
    pub fn dims(&self) -> [u32; 2] {
        self.grid.dims.to_array()
    }

    /// Position of node (0, 0) on the unrolled surface, and the distance between nodes along x and y, m.
    pub fn grid(&self) -> ([f32; 2], [f32; 2]) {
        (self.grid.origin.to_array(), self.grid.cell.to_array())
    }

    /// Displacements at the nodes in the contact frame, m. x varies fastest.
    pub fn nodes(&self) -> Vec<Vec3> {
        self.nodes.iter().map(|n| of(n) * self.steps.displacement).collect()
    }

    /// Heights of the surface at the nodes: z in the contact frame, m.
    pub fn height_nodes(&self) -> Vec<f32> {
        self.nodes.iter().map(|n| f32::from(n[3]) * self.steps.height).collect()
    }

    /// Distance above or below the surface at which the stamp has faded to zero, m. Up to half of it there is no
    /// fading.
    pub fn fade(&self) -> f32 {
        self.fade
    }

    /// Error of the stamp at the vertices that its example moves.
    pub fn error(&self) -> StampError {
        self.error
    }

    /// Radius of a sphere around the contact that contains the field when it is stretched by `stretch` along the
    /// surface, m.
    pub(crate) fn reach(&self, stretch: f32) -> f32 {
        let top = (self.grid.dims - UVec2::ONE).as_vec2() * self.grid.cell;
        let across = self.grid.origin.abs().max((self.grid.origin + top).abs()).length() * stretch;
        let along = self.heights.0.abs().max(self.heights.1.abs()) + self.fade;
        // Slightly larger, so that rounding excludes no vertex.
        (across * across + along * along).sqrt() * 1.0001
    }

    pub(crate) fn bytes(&self) -> usize {
        self.nodes.bytes()
    }
}

/// A stamp prepared to be read at many points.
#[derive(Clone, Copy)]
pub(crate) struct Reader<'a> {
    nodes: &'a [Node],
    row: usize,
    /// From the unrolled surface to the grid.
    per_cell: Vec2,
    origin: Vec2,
    /// The last node, and the last but one.
    top: Vec2,
    last: Vec2,
    stretch_square: f32,
    /// From weighted sums to heights and displacements, m.
    height: f32,
    displacement: Vec3,
    /// 2 divided by the fade, 1/m.
    fade: f32,
}

impl Reader<'_> {
    /// Displacements at four points, m, zero outside the grid. Both are in the contact frame.
    #[inline(always)]
    pub(crate) fn read(&self, [x, y, z]: Four) -> Four {
        let lift = lift(z, (x * x + y * y) / self.stretch_square);
        let (gx, gy) = (x * lift * self.per_cell.x - self.origin.x, y * lift * self.per_cell.y - self.origin.y);
        // Not for NaN.
        let (least, top) = (gx.min(gy).cmpge(Vec4::ZERO), (Vec4::splat(self.top.x), Vec4::splat(self.top.y)));
        let inside = least & gx.cmple(top.0) & gy.cmple(top.1);
        if !inside.any() {
            return [Vec4::ZERO; 3];
        }
        // Points outside are read on the border.
        let (gx, gy) = (gx.max(Vec4::ZERO).min(top.0), gy.max(Vec4::ZERO).min(top.1));
        // Nodes that are not the last.
        let column = small_floors(gx.min(Vec4::splat(self.last.x)));
        let row = small_floors(gy.min(Vec4::splat(self.last.y)));
        let first = small_wholes(column + row * self.row as f32);
        let (tx, ty) = ((gx - column) * WEIGHTS, (gy - row) * WEIGHTS);
        let [x, y, both] = [tx, ty, tx * ty * (1.0 / WEIGHTS)].map(small_wholes);
        let mut sums = [Vec4::ZERO; 4];
        for (i, sum) in sums.iter_mut().enumerate() {
            let none = (WEIGHTS as i32 - x[i] - y[i] + both[i]).max(0);
            let near = pair(none as i16, (x[i] - both[i]) as i16);
            let far = pair((y[i] - both[i]) as i16, both[i] as i16);
            let first = first[i] as usize;
            let Some([a, b]) = self.nodes.get(first..first + 2) else { continue };
            let Some([c, d]) = self.nodes.get(first + self.row..first + self.row + 2) else { continue };
            let (near, far) = (dot(paired(*a, *b), near), dot(paired(*c, *d), far));
            let whole = IVec4::from(near) + IVec4::from(far);
            *sum = whole.as_vec4();
        }
        let [x, y, over, h] = transposed(sums);
        let keep = (2.0 - (z - h * self.height).abs() * self.fade).clamp(Vec4::ZERO, Vec4::ONE);
        let d = self.displacement;
        [x * d.x, y * d.y, over * d.z].map(|u| Vec4::select(inside, u * keep, Vec4::ZERO))
    }
}

fn of(n: &Node) -> Vec3 {
    Vec3::new(n[0].into(), n[1].into(), n[2].into())
}

impl Source<'_> {
    fn resample(&self, resolution: u32) -> Stamp {
        // The field falls to zero over one edge length, between the last moved vertices and their unmoved neighbours.
        // If the example moves a single vertex, that is the whole field.
        let edge = self.index.four(self.contact).iter().map(|(d2, _)| d2.sqrt()).fold(0.0, f32::max);
        let edge = if edge > 0.0 { edge } else { self.max_depth };
        let radius = self.support_radius.max(edge);
        let fade = (radius * FADE).max(edge);
        let grid = self.grid(resolution, edge, radius);
        let heights = self.heights(&grid, fade);
        let samples: Vec<Vec3> = (0..grid.count())
            .map(|i| {
                let at = grid.at(i);
                let p = rolled(grid.position(i), heights[i]);
                // Zero on the grid's border, so that the field ends without a step.
                let side = at.cmpeq(UVec2::ZERO).any() || (at + UVec2::ONE).cmpeq(grid.dims).any();
                self.sample(self.contact + self.frame * p, fade, side)
            })
            .collect();
        let (displacement, displacements) = whole(samples.iter().copied());
        let (height, heights) = whole(heights.iter().map(|h| Vec3::new(0.0, 0.0, *h)));
        let nodes: Vec<Node> = (0..grid.count())
            .map(|i| {
                let [x, y, z] = displacements[i];
                [x, y, z, heights[i][2]]
            })
            .collect();
        let steps = NodeSteps { displacement, height: height.z };
        let stamp = Stamp::new(grid, nodes.into(), steps, fade, StampError::default());
        Stamp { error: self.error(&stamp), ..stamp }
    }

    /// A grid around the moved vertices. Its margin, one edge length and at least one cell, lets the field fall to
    /// zero.
    fn grid(&self, resolution: u32, edge: f32, radius: f32) -> Grid {
        let limit = self.max_depth * EXTENT;
        let mut b = Aabb::EMPTY;
        b.add(Vec3::ZERO);
        for (v, d) in self.deltas.moved() {
            if d.length() >= limit {
                b.add(unrolled(self.to_frame(self.positions[v])).extend(0.0));
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

    /// Height of the surface at each node. The search starts at the contact and goes outwards from node to node, so it
    /// stays on the sheet that was hit if there are several.
    fn heights(&self, grid: &Grid, fade: f32) -> Vec<f32> {
        let mut heights = vec![f32::NAN; grid.count()];
        let (w, h) = (grid.dims.x as usize, grid.dims.y as usize);
        let middle = (-grid.origin / grid.cell).round().as_uvec2().min(grid.dims - UVec2::ONE);
        let first = middle.x as usize + middle.y as usize * w;
        heights[first] = Some(self.height(grid.position(first), 0.0, fade)).filter(|z| z.is_finite()).unwrap_or(0.0);
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
                    let found = self.height(grid.position(j), heights[i], fade);
                    // NaN would be visited again and again.
                    heights[j] = if found.is_finite() { found } else { heights[i] };
                    next.push_back(j);
                }
            }
        }
        heights
    }

    /// Height of the surface at `q`, searched from `guess` (m). Returns `guess` if there is no surface near it.
    fn height(&self, q: Vec2, guess: f32, fade: f32) -> f32 {
        let surface = |z: f32| -> Option<f32> {
            let p = self.contact + self.frame * rolled(q, z);
            let near = self.index.four_if_near(p, fade);
            let (mut sum, mut total) = (0.0, 0.0);
            for (d2, v) in near.iter() {
                let w = 1.0 / d2.max(touching(fade));
                sum += self.to_frame(self.positions[*v as usize]).z * w;
                total += w;
            }
            (total > 0.0).then(|| sum / total)
        };
        let mut z = guess;
        for _ in 0..3 {
            let Some(a) = surface(z) else { return z };
            let Some(b) = surface(a) else { return a };
            // Aitken's extrapolation: each step reduces the error by the same factor.
            let (first, second) = (a - z, b - a);
            let further = second * second / (first - second);
            z = if further.abs() <= fade && first * second > 0.0 { b + further } else { b };
        }
        z
    }

    /// The displacement at `p` (mesh space) in the contact frame, averaged over the four nearest vertices. It fades with distance from
    /// the surface, and is zero if `still`.
    fn sample(&self, p: Vec3, fade: f32, still: bool) -> Vec3 {
        let (mut displacement, mut sum) = (Vec3::ZERO, 0.0f32);
        let floor = touching(fade);
        let near = self.index.four_if_near(p, fade);
        let Some((nearest, _)) = near.first().filter(|_| !still) else { return Vec3::ZERO };
        let keep = (2.0 - 2.0 * nearest.sqrt() / fade).clamp(0.0, 1.0);
        for (d2, v) in near.iter() {
            let w = 1.0 / d2.max(floor);
            displacement += self.deltas[*v as usize] * w;
            sum += w;
        }
        self.frame.transpose() * displacement * (keep / sum)
    }

    /// Error of a stamp against the field that it was made from, at the vertices that the field moves.
    fn error(&self, stamp: &Stamp) -> StampError {
        let (mut max, mut sum, mut count) = (0.0f32, 0.0f64, 0u32);
        for (v, d) in self.deltas.moved() {
            let off = self.frame * stamp.displacement(self.to_frame(self.positions[v])) - d;
            max = max.max(off.length());
            sum += f64::from(off.length_squared());
            count += 1;
        }
        StampError { max, rms: (sum / f64::from(count.max(1))).sqrt() as f32 }
    }
}

/// Distances below a ten-thousandth of the fade count as zero. Squared, m². Its inverse is finite for the smallest body too.
fn touching(fade: f32) -> f32 {
    (fade * fade * 1e-8).max(1e-30)
}

/// Quantizes vectors. Returns the steps of x, y and z, chosen so that the largest value is [`MOST`] steps, and the
/// vectors in steps.
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
