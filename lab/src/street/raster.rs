//! What a camera sees: of each pixel the body, the triangle and the place in it.

use glam::{Mat3, Vec3};

pub const WIDTH: usize = 1920;
pub const HEIGHT: usize = 1080;
/// Vertical field of view, radians.
pub const FOV: f32 = std::f32::consts::PI / 3.0;
/// Nothing nearer than this is drawn, m.
const NEAR: f32 = 0.05;

/// Where a body stands before the camera, which looks along +z with +y up.
#[derive(Clone, Copy)]
pub struct Place {
    pub turn: Mat3,
    pub at: Vec3,
}

impl Place {
    /// Pixel coordinates and depth (m) of a point of the body.
    pub fn project(&self, p: Vec3) -> Option<Vec3> {
        let p = self.turn * p + self.at;
        let focal = HEIGHT as f32 * 0.5 / (FOV * 0.5).tan();
        (p.z > NEAR)
            .then(|| Vec3::new(WIDTH as f32 * 0.5 + focal * p.x / p.z, HEIGHT as f32 * 0.5 - focal * p.y / p.z, p.z))
    }
}

/// What covers a pixel.
#[derive(Clone, Copy)]
pub struct Hit {
    pub body: u32,
    pub triangle: u32,
    /// Barycentric weights in space.
    pub weights: [f32; 3],
}

pub struct Raster {
    /// 1 / depth of what is nearest, 0 for nothing.
    near: Vec<f32>,
    hits: Vec<Hit>,
}

impl Raster {
    pub fn new() -> Self {
        let nothing = Hit { body: u32::MAX, triangle: 0, weights: [0.0; 3] };
        Self { near: vec![0.0; WIDTH * HEIGHT], hits: vec![nothing; WIDTH * HEIGHT] }
    }

    pub fn draw(&mut self, body: u32, place: &Place, positions: &[Vec3], triangles: &[[u32; 3]]) {
        let seen: Vec<Option<Vec3>> = positions.iter().map(|p| place.project(*p)).collect();
        for (i, t) in triangles.iter().enumerate() {
            if let [Some(a), Some(b), Some(c)] = t.map(|v| seen[v as usize]) {
                self.triangle(body, i as u32, [a, b, c]);
            }
        }
    }

    fn triangle(&mut self, body: u32, triangle: u32, p: [Vec3; 3]) {
        let area = |a: Vec3, b: Vec3, x: f32, y: f32| (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
        let whole = area(p[0], p[1], p[2].x, p[2].y);
        if whole == 0.0 || !whole.is_finite() {
            return;
        }
        let (low, high) = (p[0].min(p[1]).min(p[2]), p[0].max(p[1]).max(p[2]));
        let span = |low: f32, high: f32, size: usize| {
            let first = (low - 0.5).ceil().max(0.0) as usize;
            first..((high - 0.5).floor().min(size as f32 - 1.0) + 1.0).max(0.0) as usize
        };
        for y in span(low.y, high.y, HEIGHT) {
            for x in span(low.x, high.x, WIDTH) {
                let (px, py) = (x as f32 + 0.5, y as f32 + 0.5);
                let w =
                    [area(p[1], p[2], px, py), area(p[2], p[0], px, py), area(p[0], p[1], px, py)].map(|a| a / whole);
                if w.iter().any(|w| *w < 0.0) {
                    continue;
                }
                // Linear on the screen in 1 / depth.
                let over = [0, 1, 2].map(|k| w[k] / p[k].z);
                let inverse = over[0] + over[1] + over[2];
                let at = y * WIDTH + x;
                if inverse > self.near[at] {
                    self.near[at] = inverse;
                    self.hits[at] = Hit { body, triangle, weights: over.map(|o| o / inverse) };
                }
            }
        }
    }

    /// What covers the pixels that anything covers.
    pub fn hits(&self) -> impl Iterator<Item = &Hit> {
        self.hits.iter().filter(|h| h.body != u32::MAX)
    }
}
