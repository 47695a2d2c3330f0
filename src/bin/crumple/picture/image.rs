//! A picture in memory.

/// An 8-bit sRGB picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    pub width: usize,
    pub height: usize,
    pub rgb: Vec<u8>,
}

impl Image {
    pub(super) fn put(&mut self, x: i32, y: i32, colour: [u8; 3]) {
        self.blend(x, y, colour, 1.0);
    }

    /// Mixes a colour into a pixel. Does nothing outside the picture.
    pub(super) fn blend(&mut self, x: i32, y: i32, colour: [u8; 3], share: f32) {
        if x < 0 || y < 0 || x >= self.width as i32 || y >= self.height as i32 {
            return;
        }
        let at = (y as usize * self.width + x as usize) * 3;
        for (old, new) in self.rgb[at..at + 3].iter_mut().zip(colour) {
            *old = (f32::from(*old) + (f32::from(new) - f32::from(*old)) * share).round() as u8;
        }
    }

    pub fn beside(&self, other: &Image) -> Image {
        let rows = self.rgb.chunks_exact(self.width * 3).zip(other.rgb.chunks_exact(other.width * 3));
        let rgb = rows.flat_map(|(a, b)| a.iter().chain(b)).copied().collect();
        Image { width: self.width + other.width, height: self.height, rgb }
    }

    /// The picture as a PNG file with a one-line description.
    pub fn to_png(&self, description: &str) -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.add_text_chunk("Description".into(), description.into())?;
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.rgb)?;
        writer.finish()?;
        Ok(bytes)
    }
}
