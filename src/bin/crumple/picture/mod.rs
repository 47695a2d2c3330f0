//! Pictures of a body before and after, drawn without a GPU. The lab uses this module too.

mod camera;
mod coats;
mod image;
pub mod legend;
mod raster;
mod shade;
#[cfg(test)]
mod tests;

pub use camera::{Camera, Margins, View};
pub use coats::coats;
pub use image::Image;
pub use legend::{Scale, millimetres};
pub use raster::Body;
pub use shade::{Coat, Finish};

use glam::Vec3;
use rayon::prelude::*;
use shade::{Frame, Studio};

/// Each pixel is the mean of this number of samples in each direction.
const SAMPLES: usize = 3;
const MARGINS: Margins = Margins { side: 0.055, top: 0.10, bottom: 0.14 };

/// The mesh shown, before and after.
pub struct Subject<'a> {
    pub triangles: &'a [[u32; 3]],
    pub before: &'a [Vec3],
    pub before_normals: &'a [Vec3],
    pub after: &'a [Vec3],
    pub after_normals: &'a [Vec3],
    /// How its materials look, and the index of each vertex's among them; empty for a body of one paint.
    pub coats: (&'a [Coat], &'a [f32]),
    /// Vertices that were hit.
    pub contacts: &'a [u32],
    /// Unit vector in the mesh's space, away from the floor.
    pub up: Vec3,
    /// Size of the picture, pixels. The time to draw it is in proportion.
    pub size: [usize; 2],
}

/// The kind of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Base,
    After,
    Heat,
    BeforeAfter,
}

impl Kind {
    pub const ALL: [Kind; 4] = [Kind::Base, Kind::After, Kind::Heat, Kind::BeforeAfter];

    pub fn file_name(self) -> &'static str {
        match self {
            Kind::Base => "base.png",
            Kind::After => "after.png",
            Kind::Heat => "heat.png",
            Kind::BeforeAfter => "before_after.png",
        }
    }
}

impl Subject<'_> {
    /// The vertex that moved furthest, and its displacement, m.
    pub fn deepest(&self) -> (usize, f32) {
        let lengths = self.after.iter().zip(self.before).map(|(a, b)| (*a - *b).length());
        lengths.enumerate().fold((0, 0.0), |best, new| if new.1 > best.1 { new } else { best })
    }

    /// Draws one picture. All pictures share the view, so that they can be overlaid.
    pub fn draw(&self, kind: Kind) -> Image {
        let size = self.size;
        let margin = if size[1] >= legend::SMALL { 48 } else { 8 };
        let moved: Vec<Vec3> = self.after.iter().zip(self.before).map(|(a, b)| *a - *b).collect();
        let values: Vec<f32> = moved.iter().map(|u| u.length()).collect();
        let scale = Scale { maximum: self.deepest().1 };
        let view = View::of(self.before, self.triangles, &moved, self.up);
        let (coats, coat_of) = self.coats;
        let before = self.body(self.before, self.before_normals, coat_of);
        let after = self.body(self.after, self.after_normals, coat_of);
        let finish = Finish::Coats(coats);
        let hits = match self.contacts.len() {
            1 => "1 hit".to_owned(),
            n => format!("{n} hits"),
        };
        let dented = format!("{hits}, up to {} mm", millimetres(scale.maximum));
        let camera = |size: [usize; 2]| {
            let points = self.before.iter().chain(self.after);
            Camera::framing(points, view, size[0] as f32 / size[1] as f32, MARGINS)
        };
        let photo = |body, size, finish: &Finish<'_>| photograph(body, &camera(size), view, size, finish, None);
        let half = [size[0] / 2, size[1]];
        let mut image = match kind {
            Kind::Base => photo(before, size, &finish),
            Kind::After => photo(after, size, &finish),
            Kind::BeforeAfter => photo(before, half, &finish).beside(&photo(after, half, &finish)),
            Kind::Heat => {
                let colour = |t: f32| scale.light(t);
                let after = self.body(self.after, self.after_normals, &values);
                let maximum = scale.maximum.max(f32::MIN_POSITIVE);
                let mut image = photo(after, size, &Finish::Heat { colour: &colour, maximum });
                self.mark_contacts(&mut image, &camera(size), after);
                image
            }
        };
        let mut caption = |x: usize, title: &str, detail: &str| legend::caption(&mut image, x as i32, title, detail);
        match kind {
            Kind::Base => caption(margin, "before", "as it came"),
            Kind::After => caption(margin, "after", &dented),
            Kind::Heat => {
                caption(margin, "displacement", &dented);
                legend::bar(&mut image, scale);
            }
            Kind::BeforeAfter => {
                caption(margin, "before", "as it came");
                caption(margin + half[0], "after", &dented);
            }
        }
        image
    }

    fn body<'a>(&'a self, positions: &'a [Vec3], normals: &'a [Vec3], values: &'a [f32]) -> Body<'a> {
        Body { positions, normals, triangles: self.triangles, values }
    }

    /// Draws rings around the contacts that are visible.
    fn mark_contacts(&self, image: &mut Image, camera: &Camera, after: Body<'_>) {
        let size = self.size;
        let surfaces = raster::through(camera, after, size);
        let slack = (camera.far - camera.near) * 0.02;
        for &contact in self.contacts {
            let Some(&p) = self.after.get(contact as usize) else { continue };
            let at = camera.pixel(p, size);
            let (x, y) = (at.x as usize, at.y as usize);
            if x < size[0] && y < size[1] && camera.project(p).1 <= surfaces.as_ref()[y * size[0] + x].distance + slack
            {
                legend::marker(image, at);
            }
        }
    }
}

/// Draws a body in the studio, or several that are `body` together. Then `radius` is that of one of them, m.
pub fn photograph(
    body: Body<'_>,
    camera: &Camera,
    view: View,
    size: [usize; 2],
    finish: &Finish<'_>,
    radius: Option<f32>,
) -> Image {
    let fine = size.map(|n| n * SAMPLES);
    let surfaces = raster::through(camera, body, fine);
    let frame = Frame { surfaces: surfaces.as_ref(), size: fine };
    let studio = Studio::new(body, camera, view, size, radius);
    let mut rgb = vec![0u8; size[0] * size[1] * 3];
    rgb.par_chunks_mut(size[0] * 3).enumerate().for_each(|(y, row)| {
        for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
            let light = studio.pixel(x, y, SAMPLES, &frame, finish);
            pixel.copy_from_slice(&light.to_array().map(shade::encode));
        }
    });
    Image { width: size[0], height: size[1], rgb }
}
