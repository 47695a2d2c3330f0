//! Shading as in a photographer's studio: satin metal under strip lights, on a bright seamless floor.

use super::camera::{Camera, View};
use super::raster::{Body, ShadowMap, Surface, Taps, disc};
use glam::{Vec2, Vec3};

/// Linear light; 1 is paper white.
pub type Light = Vec3;

/// Sides of the shadow map of the key light for each side of the picture, texels.
const SHADOW_TEXELS: f32 = 1.5;
/// Brightness of a strip light.
const STRIP: f32 = 5.0;
const GROUND: Light = Vec3::new(0.80, 0.81, 0.825);

/// How a material looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coat {
    /// Diffuse reflectance.
    pub paint: Light,
    /// Colour of the metal flakes in the paint.
    pub flakes: Light,
    /// How much of a mirror the lacquer is, from 0 to 1.
    pub gloss: f32,
}

/// Blue metallic paint.
pub const PAINT: Coat = Coat { paint: Vec3::new(0.045, 0.130, 0.205), flakes: Vec3::new(0.16, 0.34, 0.46), gloss: 1.0 };

impl Coat {
    /// Of glTF's base colour (linear), metalness and roughness.
    pub fn of(colour: Light, metal: f32, roughness: f32) -> Self {
        let gloss = (1.0 - roughness).powi(2);
        Coat { paint: colour * (1.0 - 0.5 * metal), flakes: colour * (1.5 * metal), gloss }
    }
}

/// Everything that is the same for all pixels.
pub struct Studio<'a> {
    camera: &'a Camera,
    up: Vec3,
    right: Vec3,
    front: Vec3,
    key: Vec3,
    rim: Vec3,
    key_shadow: ShadowMap,
    sky_shadow: ShadowMap,
    /// Height of the floor along `up`, m.
    floor: f32,
    /// Radius of a bounding sphere, m: light and shadows are as soft as suits a body of this size.
    radius: f32,
    /// Sample points for soft shadows on the floor, and on the body.
    floor_taps: Vec<Vec2>,
    body_taps: Vec<Vec2>,
}

/// The appearance of the body's surface.
pub enum Finish<'a> {
    /// The values of the body's vertices are indices of these. A body without any has blue paint.
    Coats(&'a [Coat]),
    /// Colours of values from 0 to `maximum`, m.
    Heat { colour: &'a (dyn Fn(f32) -> Light + Sync), maximum: f32 },
}

impl<'a> Studio<'a> {
    /// `radius` is that of one of several bodies, m; `None` for one body.
    pub fn new(
        body: Body<'_>,
        camera: &'a Camera,
        view: View,
        [width, height]: [usize; 2],
        radius: Option<f32>,
    ) -> Studio<'a> {
        let texels = (SHADOW_TEXELS * ((width * height) as f32).sqrt()).ceil().max(16.0) as usize;
        let (mut low, mut high) = (Vec3::MAX, Vec3::MIN);
        let mut floor = f32::MAX;
        for &p in body.positions {
            low = low.min(p);
            high = high.max(p);
            floor = floor.min(p.dot(view.up));
        }
        let centre = (low + high) * 0.5;
        let all = ((high - low).length() * 0.5).max(1e-6);
        let (up, right) = (view.up, view.right());
        let front = right.cross(up);
        // Low over the surface and from the side, so that a shallow dent has a bright and a dark flank.
        let key = (right * -0.82 + up * 0.42 + front * 0.34).normalize();
        let rim = (right * 0.75 + up * 0.35 + front * -0.85).normalize();
        Studio {
            camera,
            up,
            right,
            front,
            key,
            rim,
            key_shadow: ShadowMap::new(body, (key + up * 0.8).normalize(), centre, all * 1.05, texels),
            sky_shadow: ShadowMap::new(body, up, centre, all * 1.05, texels / 2),
            floor,
            radius: radius.unwrap_or(all),
            floor_taps: disc(32),
            body_taps: disc(32),
        }
    }

    /// Light that reaches the viewer through pixel (x, y), which has `samples` by `samples` points of the frame.
    pub fn pixel(&self, x: usize, y: usize, samples: usize, frame: &Frame<'_>, finish: &Finish<'_>) -> Light {
        let (x, y) = (x * samples, y * samples);
        let points = (0..samples * samples).map(|i| (x + i % samples, y + i / samples));
        let covered = points.clone().filter(|&(x, y)| frame.at(x, y).is_some()).count();
        let mut sum = Vec3::ZERO;
        if covered < samples * samples {
            let middle = samples as f32 * 0.5;
            let taps = Taps { points: &self.floor_taps, turn: turn(x / samples, y / samples) };
            let light = self.backdrop(x as f32 + middle, y as f32 + middle, frame, taps);
            sum += light * (samples * samples - covered) as f32;
        }
        // Soft effects are computed once per pixel, at its first sample.
        let mut shade = None;
        for (x, y) in points.filter(|&(x, y)| frame.at(x, y).is_some()) {
            let (x, y) = (x as f32 + 0.5, y as f32 + 0.5);
            let shade = *shade.get_or_insert_with(|| self.soft_shade(x, y, samples, frame));
            sum += self.sample(x, y, frame, finish, shade);
        }
        sum / (samples * samples) as f32
    }

    fn soft_shade(&self, x: f32, y: f32, samples: usize, frame: &Frame<'_>) -> Shade {
        let surface = frame.at(x as usize, y as usize);
        let ray = self.camera.ray(x, y, frame.size);
        let p = self.camera.eye + ray * surface.distance;
        let taps = Taps { points: &self.body_taps, turn: turn(x as usize / samples, y as usize / samples) };
        let n = surface.normal.normalize_or(-ray);
        // A wall always sees half of the sky, so only what hangs over the space in front of it counts.
        let roof =
            self.sky_shadow.occlusion(p + n * (self.radius * 0.10), self.radius * 0.10, self.radius * 0.08, taps);
        let open = self.openness(x, y, p, n, frame, taps);
        Shade { open: open * (1.0 - 0.75 * roof), direct: 1.0 - roof }
    }

    fn sample(&self, x: f32, y: f32, frame: &Frame<'_>, finish: &Finish<'_>, shade: Shade) -> Light {
        let surface = frame.at(x as usize, y as usize);
        let ray = self.camera.ray(x, y, frame.size);
        let n = surface.normal.normalize_or(-ray);
        let v = -ray.normalize();
        match finish {
            Finish::Coats(coats) => {
                let coat = coats.get(surface.value.round() as usize).copied().unwrap_or(PAINT);
                self.paint(coat, n, v, shade)
            }
            Finish::Heat { colour, maximum } => {
                let base = colour((surface.value / maximum).clamp(0.0, 1.0));
                // The colour carries the information; light only hints at the shape.
                let light = 0.72 + 0.30 * n.dot(self.key).max(0.0) + 0.08 * n.dot(self.up);
                base * (light * (0.45 + 0.55 * shade.open)).min(1.0)
            }
        }
    }

    /// Metallic paint under clear lacquer. The paint shows the shape by raking light. The lacquer shows it by the
    /// reflections of the strip lights, which bend wherever the surface does.
    fn paint(&self, coat: Coat, n: Vec3, v: Vec3, Shade { open, direct }: Shade) -> Light {
        let nv = n.dot(v).max(0.02);
        let key = n.dot(self.key).max(0.0);
        let rim = n.dot(self.rim).max(0.0);
        let sky = 0.5 + 0.5 * n.dot(self.up);
        let ambient = (GROUND * (0.50 * (1.0 - sky)) + Vec3::new(0.80, 0.90, 1.0) * (0.38 * sky)) * open;
        let lit = Vec3::new(1.0, 0.95, 0.88) * (2.1 * key * direct) + Vec3::new(0.8, 0.9, 1.0) * (0.5 * rim * open);
        let half = (self.key + v).normalize();
        let flakes = n.dot(half).max(0.0).powi(14) * 0.9 * direct;
        let mirror = (2.0 * n.dot(v)) * n - v;
        let lacquer = 0.055 + (1.0 - 0.055) * (1.0 - nv).powi(5);
        let glint = n.dot(half).max(0.0).powi(220) * 6.0 * direct;
        let reflected = self.room(mirror) * (0.25 + 0.75 * open) + Vec3::splat(glint);
        coat.paint * (ambient + lit) + coat.flakes * flakes + reflected * lacquer * coat.gloss
    }

    /// The light that a mirror reflects from direction `d`: a dim room with strip lights in the ceiling.
    fn room(&self, d: Vec3) -> Light {
        let (x, y, z) = (d.dot(self.right), d.dot(self.up), d.dot(self.front));
        let wall = Vec3::new(0.80, 0.84, 0.90);
        let ceiling = Vec3::new(0.22, 0.25, 0.30);
        let mut light =
            if y <= 0.0 { wall.lerp(GROUND * 0.7, step(0.0, 0.25, -y)) } else { wall.lerp(ceiling, step(0.0, 0.5, y)) };
        // Upright tubes in the walls, for upright bodies, placed by azimuth; 0 is behind the viewer.
        let compass = x.atan2(z);
        for at in [-1.9, -1.15, -0.45, 0.5, 1.2] {
            light += Vec3::new(0.96, 0.98, 1.0)
                * (0.8 * STRIP * band(compass - at, 0.07, 0.12) * band(y + 0.15, 0.62, 0.40));
        }
        if y <= 0.0 {
            return light;
        }
        // Where the ray meets a ceiling at height 1; distant strips fade into the horizon.
        let (u, w) = (x / y.max(0.05), z / y.max(0.05));
        for i in -5..=5 {
            let at = i as f32 * 0.55 + 0.12;
            let strip = band(u - at, 0.09, 0.16) * band(w + 0.9, 2.4, 1.8);
            light += Vec3::new(1.0, 0.985, 0.96) * (STRIP * strip * step(0.02, 0.2, y));
        }
        light
    }

    fn backdrop(&self, x: f32, y: f32, frame: &Frame<'_>, taps: Taps<'_>) -> Light {
        let ray = self.camera.ray(x, y, frame.size);
        let (u, v) = (x / frame.size[0] as f32 - 0.5, y / frame.size[1] as f32);
        let glow = (-(v - 0.45) * (v - 0.45) * 3.0).exp();
        let mut light = GROUND * (0.80 + 0.20 * glow);
        let down = -ray.dot(self.up);
        if down > 1e-4 {
            let t = (self.camera.eye.dot(self.up) - self.floor) / down;
            let p = self.camera.eye + ray * t;
            let inside = 1.0 - step(0.38, 0.5, u.abs());
            let key = self.key_shadow.occlusion(p, self.radius * 0.14, self.radius * 0.004, taps);
            let sky = self.sky_shadow.occlusion(p, self.radius * 0.22, self.radius * 0.004, taps);
            let touch = self.sky_shadow.contact(p, self.radius * 0.05, self.radius * 0.10, taps);
            light *= (1.0 - 0.22 * key * inside) * (1.0 - 0.22 * sky) * (1.0 - 0.60 * touch);
        }
        light
    }

    /// The share of the surroundings that a surface point sees, estimated from the depths around its pixel (Alchemy's
    /// estimator, McGuire et al. 2011) at the scale of a dent. Shallow dents darken a little, folds and gaps a lot.
    fn openness(&self, x: f32, y: f32, p: Vec3, n: Vec3, frame: &Frame<'_>, taps: Taps<'_>) -> f32 {
        let reach = self.radius * 0.11;
        let pixels =
            reach / (2.0 * self.camera.tan.y * (self.camera.eye - p).dot(self.camera.back)) * frame.size[1] as f32;
        let mut shut = 0.0;
        for tap in taps.points {
            let Vec2 { x: sx, y: sy } = Vec2::new(x, y) + taps.turn.rotate(*tap) * pixels;
            if sx < 0.0 || sy < 0.0 || sx >= frame.size[0] as f32 || sy >= frame.size[1] as f32 {
                continue;
            }
            let other = frame.at(sx as usize, sy as usize);
            if !other.is_some() {
                continue;
            }
            let (cx, cy) = (sx.floor() + 0.5, sy.floor() + 0.5);
            let to = self.camera.eye + self.camera.ray(cx, cy, frame.size) * other.distance - p;
            let square = to.length_squared();
            if square < reach * reach * 4.0 {
                shut += (n.dot(to) - 0.004 * reach).max(0.0) / (square + 0.01 * reach * reach) * reach;
            }
        }
        (1.0 - 1.1 * shut / taps.points.len() as f32).clamp(0.0, 1.0)
    }
}

/// The shares of the ambient light and of the key light that arrive, 0 to 1.
#[derive(Clone, Copy)]
struct Shade {
    open: f32,
    direct: f32,
}

/// A frame of surfaces, row by row.
pub struct Frame<'a> {
    pub surfaces: &'a [Surface],
    pub size: [usize; 2],
}

impl Frame<'_> {
    pub fn at(&self, x: usize, y: usize) -> Surface {
        self.surfaces[y * self.size[0] + x]
    }
}

/// 0 below `a`, 1 above `b`, smooth in between.
fn step(a: f32, b: f32, x: f32) -> f32 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// 1 within `half` of zero, falling to 0 over `soft` around the edge.
fn band(x: f32, half: f32, soft: f32) -> f32 {
    1.0 - step(half - soft * 0.5, half + soft * 0.5, x.abs())
}

/// A rotation (cosine, sine) that differs between neighbouring pixels: Jimenez's interleaved gradient noise, 2014.
fn turn(x: usize, y: usize) -> Vec2 {
    let noise = (52.982_918 * (0.067_110_56 * x as f32 + 0.005_837_15 * y as f32).fract()).fract();
    Vec2::from_angle(noise * std::f32::consts::TAU)
}

/// Converts linear light to an 8-bit sRGB value, with a soft shoulder above 0.8 instead of clipping.
pub fn encode(light: f32) -> u8 {
    let x = light.max(0.0);
    let x = if x > 0.8 { 0.8 + 0.2 * (1.0 - (-(x - 0.8) / 0.2).exp()) } else { x };
    let s = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    (s * 255.0 + 0.5) as u8
}

/// Converts an 8-bit sRGB value to linear light.
pub fn decode(byte: u8) -> f32 {
    let s = f32::from(byte) / 255.0;
    if s <= 0.040_45 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}
