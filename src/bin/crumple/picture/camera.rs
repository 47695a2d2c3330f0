//! The camera: a three-quarter view that faces the dents and fills the frame.

use glam::{Vec2, Vec3};

/// A body is an open sheet, such as a hood or a door, if |sum of area vectors| / area is at least this.
const SHEET: f32 = 0.6;
/// Tangent of half the vertical field of view: about 26 degrees in all, as of a portrait lens.
const HALF_FIELD: f32 = 0.23;

/// Elevation of the view of a body, radians above the floor.
const ELEVATION: f32 = 0.42;
/// Number of directions tried around a body.
const AZIMUTHS: usize = 48;

/// A perspective camera.
#[derive(Debug, Clone)]
pub struct Camera {
    pub eye: Vec3,
    pub right: Vec3,
    pub up: Vec3,
    /// Unit vector from the scene to the viewer.
    pub back: Vec3,
    /// Half the width and height of the frame at distance 1.
    pub tan: Vec2,
    pub near: f32,
    pub far: f32,
}

/// The direction from which a body is shown, before the size of the frame is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Unit, away from the floor.
    pub up: Vec3,
    /// Unit, from the body to the viewer.
    pub toward: Vec3,
}

/// Share of the frame kept free on each side.
#[derive(Debug, Clone, Copy)]
pub struct Margins {
    pub side: f32,
    pub top: f32,
    pub bottom: f32,
}

impl View {
    /// An open sheet lies on the floor with its outside (or the side that was hit) up. Any other body keeps the file's
    /// `up` and turns the dents to the viewer. `displacements` are those of the hits, m, one per vertex.
    pub fn of(positions: &[Vec3], triangles: &[[u32; 3]], displacements: &[Vec3], up: Vec3) -> View {
        let (mut sum, mut area, mut side) = (Vec3::ZERO, 0.0, 0.0);
        let mut dents = Vec::new();
        for t in triangles {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            let n = (b - a).cross(c - a);
            sum += n;
            area += n.length();
            let u = t.iter().map(|&i| displacements[i as usize]).sum::<Vec3>();
            if u != Vec3::ZERO {
                // A dent goes inward, so the outside of the side that was hit faces against the displacement.
                side -= n.dot(u) * u.length();
                dents.push((n.normalize_or_zero(), n.length() * u.length_squared()));
            }
        }
        if area > 0.0 && sum.length() / area > SHEET {
            let mut normal = sum.normalize();
            if side < 0.0 {
                normal = -normal;
            }
            return View { up: normal, toward: three_quarter(normal, long_side(positions, normal), 0.50, 0.82) };
        }
        // Try directions around the body and take the one that shows most of the dents; an oblique view counts as
        // enough.
        let ahead = up.any_orthonormal_vector();
        let mut best = (0.0, three_quarter(up, ahead, 0.0, ELEVATION));
        for step in 0..AZIMUTHS {
            let turn = step as f32 * std::f32::consts::TAU / AZIMUTHS as f32;
            let toward = three_quarter(up, ahead, turn, ELEVATION);
            let score: f32 = dents.iter().map(|(n, weight)| weight * n.dot(toward).clamp(0.0, 0.6)).sum();
            if score > best.0 {
                best = (score, toward);
            }
        }
        View { up, toward: best.1 }
    }

    /// The horizontal axis to the viewer's right.
    pub fn right(&self) -> Vec3 {
        self.up.cross(self.toward).normalize_or(self.up.any_orthonormal_vector())
    }
}

impl Camera {
    /// The nearest camera along `view` that shows all `points` within the margins of a frame of this aspect (width /
    /// height).
    pub fn framing<'a>(
        points: impl IntoIterator<Item = &'a Vec3> + Clone,
        view: View,
        aspect: f32,
        margins: Margins,
    ) -> Camera {
        let (back, right) = (view.toward, view.right());
        let up = back.cross(right);
        let tan = Vec2::new(HALF_FIELD * aspect, HALF_FIELD);
        // Each side of the frame is a plane through the eye. The furthest point against each plane gives the eye's
        // position.
        let inner = Vec2::new(1.0 - 2.0 * margins.side, 1.0 - margins.top - margins.bottom) * tan;
        let (mut low, mut high) = (Vec2::MIN, Vec2::MIN);
        let (mut nearest, mut farthest) = (f32::MIN, f32::MAX);
        for &p in points.clone() {
            let (q, z) = (Vec2::new(p.dot(right), p.dot(up)), p.dot(back));
            high = high.max(q + inner * z);
            low = low.max(-q + inner * z);
            nearest = nearest.max(z);
            farthest = farthest.min(z);
        }
        let distance = ((high + low) / (2.0 * inner)).max_element();
        let centre = (high - low) * 0.5;
        let size = (nearest - farthest).max(1e-6);
        let distance = distance.max(nearest + size * 0.05);
        // The margins above and below differ: shift the picture by half the difference.
        let shift = (margins.top - margins.bottom) * tan.y * (distance - 0.5 * (nearest + farthest));
        let eye = right * centre.x + up * (centre.y + shift) + back * distance;
        let near = (distance - nearest).max(size * 1e-3) * 0.5;
        Camera { eye, right, up, back, tan, near, far: (distance - farthest) * 1.5 + size }
    }

    /// Homogeneous clip coordinates of a point, and its distance along the view axis, m.
    pub fn project(&self, p: Vec3) -> ([f32; 4], f32) {
        let q = p - self.eye;
        let w = -q.dot(self.back);
        let z = (w * (self.far + self.near) - 2.0 * self.far * self.near) / (self.far - self.near);
        ([q.dot(self.right) / self.tan.x, q.dot(self.up) / self.tan.y, z, w], w)
    }

    /// Pixel of a point in a frame of this size; y points down.
    pub fn pixel(&self, p: Vec3, size: [usize; 2]) -> Vec2 {
        let ([x, y, _, w], _) = self.project(p);
        Vec2::new((x / w + 1.0) * 0.5 * size[0] as f32, (1.0 - y / w) * 0.5 * size[1] as f32)
    }

    /// Direction from the eye through a pixel, with length 1 along the view axis.
    pub fn ray(&self, x: f32, y: f32, size: [usize; 2]) -> Vec3 {
        let ndc = Vec2::new(2.0 * x / size[0] as f32 - 1.0, 1.0 - 2.0 * y / size[1] as f32) * self.tan;
        self.right * ndc.x + self.up * ndc.y - self.back
    }
}

/// The direction `elevation` radians above the floor and `turn` radians to the side of `facing` (horizontal, unit).
fn three_quarter(up: Vec3, facing: Vec3, turn: f32, elevation: f32) -> Vec3 {
    let level = facing * turn.cos() + up.cross(facing) * turn.sin();
    (level * elevation.cos() + up * elevation.sin()).normalize()
}

/// The direction of the viewer, at a right angle to the horizontal direction in which a sheet is widest.
fn long_side(positions: &[Vec3], up: Vec3) -> Vec3 {
    let mean = positions.iter().sum::<Vec3>() / positions.len().max(1) as f32;
    let a = up.any_orthonormal_vector();
    let b = up.cross(a);
    let (mut aa, mut ab, mut bb) = (0.0f32, 0.0f32, 0.0f32);
    for p in positions {
        let (x, y) = ((*p - mean).dot(a), (*p - mean).dot(b));
        aa += x * x;
        ab += x * y;
        bb += y * y;
    }
    let angle = 0.5 * (2.0 * ab).atan2(aa - bb);
    let wide = a * angle.cos() + b * angle.sin();
    wide.cross(up).normalize()
}
