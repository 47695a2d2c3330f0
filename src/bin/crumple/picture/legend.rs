//! The colours of the heat map, their legend, captions and markers.

use super::{image::Image, shade::Light};
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle, iso_8859_1};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics::text::{Alignment, Text};
use embedded_graphics::{Drawable, Pixel};
use glam::Vec2;

const INK: Rgb888 = Rgb888::new(40, 44, 52);
/// A picture less high than this is small, pixels.
pub const SMALL: usize = 300;
const PALE: Rgb888 = Rgb888::new(110, 116, 126);

/// The range of a heat map's colours: 0 to `maximum` metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    pub maximum: f32,
}

impl Scale {
    /// The 8-bit sRGB colour of a displacement (m), from a perceptual colour map. It is pale where nothing moved, so
    /// that light shows the shape there, and ends before it turns black.
    pub fn colour(&self, value: f32) -> [u8; 3] {
        let t = if self.maximum > 0.0 { (value / self.maximum).clamp(0.0, 1.0) } else { 0.0 };
        let c = colorous::MAGMA.eval_continuous(1.0 - 0.82 * f64::from(t));
        [c.r, c.g, c.b]
    }

    /// The same as linear light, for `t` in 0..1.
    pub fn light(&self, t: f32) -> Light {
        Light::from(self.colour(t * self.maximum).map(super::shade::decode))
    }

    /// Round values below the maximum, for the legend's ticks, m.
    fn ticks(&self) -> Vec<f32> {
        let raw = self.maximum / 5.0;
        let power = 10f32.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|&s| s >= raw * 0.999).unwrap_or(raw);
        // The last tick leaves room for the label of the maximum.
        (0..).map(|i| i as f32 * step).take_while(|&t| t <= self.maximum * 0.9).take(12).collect()
    }
}

/// A length in millimetres, with its significant digits only.
pub fn millimetres(metres: f32) -> String {
    let mm = metres * 1e3;
    match mm.abs() {
        x if x >= 99.95 => format!("{mm:.0}"),
        x if x >= 0.0995 || x == 0.0 => format!("{mm:.1}"),
        x if x >= 0.000_95 => format!("{mm:.3}"),
        _ => format!("{mm:.2e}"),
    }
}

/// Draws the colour bar with its values at the bottom of the picture.
pub fn bar(image: &mut Image, scale: Scale) {
    let (w, h) = (image.width as i32, image.height as i32);
    let small = image.height < SMALL;
    let (length, thick) = (w * 9 / 20, if small { 6 } else { 14 });
    let (x0, y0) = ((w - length) / 2, h - if small { 24 } else { 62 });
    let (large, fine) = if small {
        (&iso_8859_1::FONT_6X10, &iso_8859_1::FONT_5X8)
    } else {
        (&iso_8859_1::FONT_9X18, &iso_8859_1::FONT_8X13)
    };
    let (above, below) = if small { (4, 14) } else { (12, 19) };
    label(image, large, INK, "displacement, mm", x0, y0 - above, Alignment::Left);
    if scale.maximum <= 0.0 {
        label(image, large, INK, "nothing moved", x0 + length, y0 - above, Alignment::Right);
    }
    for x in 0..length {
        let c = scale.colour(scale.maximum * x as f32 / (length - 1) as f32);
        for y in 0..thick {
            image.put(x0 + x, y0 + y, c);
        }
    }
    let mut marks: Vec<(f32, String)> = scale.ticks().into_iter().map(|t| (t, tick(t))).collect();
    if scale.maximum > 0.0 {
        marks.push((scale.maximum, format!("max {}", millimetres(scale.maximum))));
    }
    for (value, text) in marks {
        let x = x0 + (value / scale.maximum * (length - 1) as f32).round() as i32;
        for y in 0..6 {
            image.put(x, y0 + thick + y, [40, 44, 52]);
        }
        label(image, fine, INK, &text, x, y0 + thick + below, Alignment::Center);
    }
}

/// The label of a round value, without superfluous digits.
fn tick(metres: f32) -> String {
    let text = format!("{:.3}", metres * 1e3);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Draws a title at the upper left, with a smaller line below it. Small pictures have small letters.
pub fn caption(image: &mut Image, x: i32, title: &str, detail: &str) {
    if image.height >= SMALL {
        label(image, &iso_8859_1::FONT_10X20, INK, title, x, 44, Alignment::Left);
        label(image, &iso_8859_1::FONT_8X13, PALE, detail, x, 64, Alignment::Left);
    } else {
        label(image, &iso_8859_1::FONT_6X10, INK, title, x, 12, Alignment::Left);
        label(image, &iso_8859_1::FONT_5X8, PALE, detail, x, 22, Alignment::Left);
    }
}

/// Draws a ring around a contact point: white with a dark edge, so that it shows on every colour.
pub fn marker(image: &mut Image, at: Vec2) {
    let reach = 9i32;
    for dy in -reach..=reach {
        for dx in -reach..=reach {
            let (x, y) = (at.x.floor() as i32 + dx, at.y.floor() as i32 + dy);
            let r = Vec2::new(x as f32 + 0.5 - at.x, y as f32 + 0.5 - at.y).length();
            let ring = |radius: f32, half: f32| (half + 0.5 - (r - radius).abs()).clamp(0.0, 1.0);
            image.blend(x, y, [20, 22, 26], ring(6.0, 1.9) * 0.75);
            image.blend(x, y, [255, 255, 255], ring(6.0, 0.7));
        }
    }
}

fn label(image: &mut Image, font: &MonoFont<'_>, colour: Rgb888, text: &str, x: i32, y: i32, alignment: Alignment) {
    let style = MonoTextStyle::new(font, colour);
    // Drawing into memory cannot fail.
    let Ok(_) = Text::with_alignment(text, Point::new(x, y), style, alignment).draw(image);
}

impl OriginDimensions for Image {
    fn size(&self) -> Size {
        Size::new(self.width as u32, self.height as u32)
    }
}

impl DrawTarget for Image {
    type Color = Rgb888;
    type Error = std::convert::Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Self::Error> {
        for Pixel(at, c) in pixels {
            self.put(at.x, at.y, [c.r(), c.g(), c.b()]);
        }
        Ok(())
    }
}
