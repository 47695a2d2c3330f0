//! Rasterises triangles with `euc`: the surface seen through each pixel, and depth maps for shadows.

use super::camera::Camera;
use euc::buffer::Buffer2d;
use euc::rasterizer::{BackfaceCullingDisabled, Triangles};
use euc::{DepthStrategy, Interpolate, Pipeline};
use glam::{Vec2, Vec3};

/// A triangle mesh to draw, with one scalar per vertex.
#[derive(Clone, Copy)]
pub struct Body<'a> {
    pub positions: &'a [Vec3],
    pub normals: &'a [Vec3],
    pub triangles: &'a [[u32; 3]],
    /// Length of the displacement of each vertex, m; empty if it is not needed.
    pub values: &'a [f32],
}

/// The surface behind one pixel.
#[derive(Debug, Clone, Copy)]
pub struct Surface {
    /// On the viewer's side; interpolated, so not of unit length.
    pub normal: Vec3,
    /// Along the view axis, m; infinite if there is no surface.
    pub distance: f32,
    pub value: f32,
}

impl Surface {
    pub const NONE: Surface = Surface { normal: Vec3::ZERO, distance: f32::INFINITY, value: 0.0 };

    pub fn is_some(&self) -> bool {
        self.distance < f32::INFINITY
    }
}

impl Interpolate for Surface {
    fn lerp2(a: Self, b: Self, x: f32, y: f32) -> Self {
        Self::lerp3(a, b, b, x, y, 0.0)
    }

    fn lerp3(a: Self, b: Self, c: Self, x: f32, y: f32, z: f32) -> Self {
        Surface {
            normal: a.normal * x + b.normal * y + c.normal * z,
            distance: a.distance * x + b.distance * y + c.distance * z,
            value: a.value * x + b.value * y + c.value * z,
        }
    }
}

struct Draw;

impl Pipeline for Draw {
    type Vertex = ([f32; 4], Surface);
    type VsOut = Surface;
    type Pixel = Surface;

    fn vert(&self, v: &Self::Vertex) -> ([f32; 4], Surface) {
        *v
    }

    fn frag(&self, s: &Surface) -> Surface {
        *s
    }

    fn get_depth_strategy(&self) -> DepthStrategy {
        DepthStrategy::IfLessWrite
    }
}

/// Twice the signed area of a triangle seen from the eye, in clip coordinates (x, y, w).
fn facing([a, b, c]: [[f32; 4]; 3]) -> f32 {
    let v = |p: [f32; 4]| Vec3::new(p[0], p[1], p[3]);
    v(a).dot(v(b).cross(v(c)))
}

/// Draws `body` through `project` (clip coordinates and distance). Both sides of a triangle are drawn. Normals of the
/// side that faces away are reversed.
pub fn rasterise(body: Body<'_>, project: impl Fn(Vec3) -> ([f32; 4], f32), size: [usize; 2]) -> Buffer2d<Surface> {
    let seen: Vec<_> = body.positions.iter().map(|&p| project(p)).collect();
    let mut corners = Vec::with_capacity(body.triangles.len() * 3);
    for t in body.triangles {
        let clip = t.map(|i| seen[i as usize].0);
        let side = facing(clip);
        // euc divides by this area. A triangle seen edge-on has no pixels and would give NaN.
        let reach = clip.iter().flatten().fold(0.0f32, |m, c| m.max(c.abs()));
        if side.abs() <= 1e-12 * reach * reach * reach || !side.is_finite() {
            continue;
        }
        let turn = side.signum();
        for (&i, clip) in t.iter().zip(clip) {
            let i = i as usize;
            let value = body.values.get(i).copied().unwrap_or(0.0);
            corners.push((clip, Surface { normal: body.normals[i] * turn, distance: seen[i].1, value }));
        }
    }
    let mut pixels = Buffer2d::new(size, Surface::NONE);
    let mut depth = Buffer2d::new(size, f32::INFINITY);
    Draw.draw::<Triangles<'_, _, BackfaceCullingDisabled>, _>(&corners, &mut pixels, Some(&mut depth));
    heal(pixels.as_mut(), size);
    pixels
}

/// Closes the pinholes that rounding leaves between neighbouring triangles: single pixels that see past a surface which
/// continues on both sides.
fn heal(pixels: &mut [Surface], [width, height]: [usize; 2]) {
    let hole = |a: Surface, middle: Surface, b: Surface| {
        let (low, high) = (a.distance.min(b.distance), a.distance.max(b.distance));
        high.is_finite() && middle.distance - high > 8.0 * (high - low) + 1e-3 * high
    };
    for y in 0..height {
        for x in 0..width {
            let at = y * width + x;
            let sides = [(x > 0 && x + 1 < width, 1), (y > 0 && y + 1 < height, width)];
            for (inside, step) in sides {
                if inside && hole(pixels[at - step], pixels[at], pixels[at + step]) {
                    pixels[at] = pixels[at - step];
                }
            }
        }
    }
}

/// Draws `body` as seen by a camera.
pub fn through(camera: &Camera, body: Body<'_>, size: [usize; 2]) -> Buffer2d<Surface> {
    rasterise(body, |p| camera.project(p), size)
}

/// Distances to a body in one direction, from far away, for shadows.
pub struct ShadowMap {
    size: usize,
    /// Distance along `-direction` from the reference plane, m.
    depth: Vec<f32>,
    right: Vec3,
    up: Vec3,
    direction: Vec3,
    centre: Vec3,
    reach: f32,
}

impl ShadowMap {
    /// `direction` is the unit vector towards the light. The map covers a sphere.
    pub fn new(body: Body<'_>, direction: Vec3, centre: Vec3, reach: f32, size: usize) -> ShadowMap {
        let right = direction.any_orthonormal_vector();
        let up = direction.cross(right);
        let project = |p: Vec3| {
            let q = (p - centre) / reach;
            let z = -q.dot(direction);
            ([q.dot(right), q.dot(up), z, 1.0], z * reach)
        };
        let depth = rasterise(body, project, [size; 2]).as_ref().iter().map(|s| s.distance).collect();
        ShadowMap { size, depth, right, up, direction, centre, reach }
    }

    /// How close the surface above `p` comes to it: 1 where it touches, falling off over `height` m.
    pub fn contact(&self, p: Vec3, radius: f32, height: f32, taps: Taps<'_>) -> f32 {
        self.gather(p, radius, taps, |gap| if gap > -0.1 * height { (-gap.max(0.0) / height).exp() } else { 0.0 })
    }

    /// The share of a disc of `radius` m around the ray from `p` to the light that is blocked: 0 none, 1 all. Gaps up
    /// to `bias` (m) count as touching, not as blocking.
    pub fn occlusion(&self, p: Vec3, radius: f32, bias: f32, taps: Taps<'_>) -> f32 {
        self.gather(p, radius, taps, |gap| f32::from(gap > bias))
    }

    /// Mean of `weight` over the gaps (m) between `p` and the depths that the light sees around it.
    fn gather(&self, p: Vec3, radius: f32, taps: Taps<'_>, weight: impl Fn(f32) -> f32) -> f32 {
        let q = p - self.centre;
        let at = Vec2::new(q.dot(self.right), -q.dot(self.up));
        if at.abs().max_element() > self.reach + radius {
            return 0.0;
        }
        let z = -q.dot(self.direction);
        let texels = 0.5 * self.size as f32 / self.reach;
        let size = self.size as f32;
        let mut sum = 0.0;
        for tap in taps.points {
            let t = (at + taps.turn.rotate(*tap) * radius) * texels + 0.5 * size;
            if t.x >= 0.0 && t.y >= 0.0 && t.x < size && t.y < size {
                let distance = self.depth[t.y as usize * self.size + t.x as usize];
                if distance < f32::INFINITY {
                    sum += weight(z - distance);
                }
            }
        }
        sum / taps.points.len() as f32
    }
}

/// Points of the unit disc, with a rotation that differs at each pixel so that no pattern shows.
#[derive(Clone, Copy)]
pub struct Taps<'a> {
    pub points: &'a [Vec2],
    /// Cosine and sine of the rotation.
    pub turn: Vec2,
}

/// `n` points spread evenly over the unit disc.
pub fn disc(n: usize) -> Vec<Vec2> {
    let point = |i: usize| {
        let angle = i as f32 * 0.381_966 * std::f32::consts::TAU;
        Vec2::from_angle(angle) * ((i as f32 + 0.5) / n as f32).sqrt()
    };
    (0..n).map(point).collect()
}
