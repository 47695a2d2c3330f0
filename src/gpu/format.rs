//! How the host stores vertices: where, and in which numbers. `common.wgsl` converts as this file does, bit for bit.

use crate::Error;

/// Numbers of a vertex attribute.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Encoding {
    /// Floats: three, of tangents four.
    F32 = 0,
    /// Four of 16 bits (IEEE binary16, rounded to nearest even; what is too large becomes 65504).
    F16x4 = 1,
    /// Four of 16 bits, -32767 to 32767 for -1 to 1.
    Snorm16x4 = 2,
    /// Four of 8 bits, -127 to 127 for -1 to 1.
    Snorm8x4 = 3,
}

/// What is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Attribute {
    /// m; the fourth number is 1.
    Position,
    /// The fourth number is 0.
    Normal,
    /// The fourth number is the base tangent's w.
    Tangent,
}

impl Encoding {
    /// Bytes of a value.
    pub(crate) fn bytes(self, attribute: Attribute) -> u64 {
        match (self, attribute) {
            (Encoding::F32, Attribute::Tangent) => 16,
            (Encoding::F32, _) => 12,
            (Encoding::F16x4 | Encoding::Snorm16x4, _) => 8,
            (Encoding::Snorm8x4, _) => 4,
        }
    }
}

/// The words that a kernel stores for a value; of [`Encoding::F32`] the floats themselves. Only its first words count, as many
/// as the encoding has.
pub fn encode(encoding: Encoding, v: [f32; 4]) -> [u32; 4] {
    let pair = |a: u32, b: u32| a & 0xFFFF | b << 16;
    match encoding {
        Encoding::F32 => v.map(f32::to_bits),
        Encoding::F16x4 => {
            let v = v.map(f16_bits);
            [pair(v[0], v[1]), pair(v[2], v[3]), 0, 0]
        }
        Encoding::Snorm16x4 => {
            let v = v.map(|x| snorm_bits(x, 32767.0));
            [pair(v[0], v[1]), pair(v[2], v[3]), 0, 0]
        }
        Encoding::Snorm8x4 => {
            let v = v.map(|x| snorm_bits(x, 127.0) & 0xFF);
            [v[0] | v[1] << 8 | v[2] << 16 | v[3] << 24, 0, 0, 0]
        }
    }
}

fn f16_bits(x: f32) -> u32 {
    let bits = x.to_bits();
    let (sign, size) = (bits >> 16 & 0x8000, bits & 0x7FFF_FFFF);
    if size >= 0x477F_E000 {
        return sign | if size > 0x7F80_0000 { 0x7E00 } else { 0x7BFF };
    }
    if size < 0x3880_0000 {
        // Below 2^-14 numbers are multiples of 2^-24, as floats from one half on are.
        return sign | ((f32::from_bits(size) + 0.5).to_bits() - 0x3F00_0000);
    }
    sign | (size - 0x3800_0000 + 0xFFF + (size >> 13 & 1)) >> 13
}

fn snorm_bits(x: f32, top: f32) -> u32 {
    let x = if x > -1.0 { x } else { -1.0 };
    let y = if x < 1.0 { x } else { 1.0 } * top;
    (y + if y < 0.0 { -0.5 } else { 0.5 }) as i32 as u32
}

/// One attribute in the host's buffer.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stream {
    /// Bytes from the start of the target to the first vertex's value, and from one to the next.
    pub offset: u64,
    pub stride: u64,
    pub encoding: Encoding,
}

/// Where the vertices of a target lie.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layout {
    pub positions: Stream,
    pub normals: Option<Stream>,
    pub tangents: Option<Stream>,
    /// Positions are stored as (p - bias) / scale where they are normalised.
    pub scale: [f32; 3],
    pub bias: [f32; 3],
}

impl Layout {
    fn streams(&self) -> impl Iterator<Item = (Attribute, Stream)> {
        let some = |a, s: Option<Stream>| s.map(|s| (a, s));
        let normals = some(Attribute::Normal, self.normals);
        let tangents = some(Attribute::Tangent, self.tangents);
        [Some((Attribute::Position, self.positions)), normals, tangents].into_iter().flatten()
    }

    /// Fails where anything is not aligned, overlaps, or does not fit `size` bytes. Returns the bytes that `vertices` take, from
    /// the first that is written to the one behind the last.
    pub(crate) fn check(&self, vertices: usize, size: u64) -> Result<(u64, u64), Error> {
        let (mut low, mut high) = (u64::MAX, 0);
        for (attribute, s) in self.streams() {
            let name = name(attribute);
            let bytes = s.encoding.bytes(attribute);
            for (what, value) in [("offset", s.offset), ("stride", s.stride)] {
                if value % 4 != 0 {
                    return Err(Error::Misaligned { name: format!("the {name} {what}"), value, align: 4 });
                }
            }
            if s.stride < bytes || s.stride > u64::from(u32::MAX) {
                let expected = format!("{bytes} bytes, as {:?} takes, to 4294967295", s.encoding);
                return Err(Error::invalid(&format!("the {name} stride"), s.stride, &expected));
            }
            let last = (vertices as u64 - 1).saturating_mul(s.stride);
            let needed = last.saturating_add(s.offset).saturating_add(bytes);
            if needed > size {
                return Err(Error::BufferTooSmall { name: format!("the target's range, for {name}s,"), size, needed });
            }
            low = low.min(s.offset);
            high = high.max(needed);
        }
        for (i, (a, s)) in self.streams().enumerate() {
            for (b, t) in self.streams().skip(i + 1) {
                if overlap((s, s.encoding.bytes(a)), (t, t.encoding.bytes(b)), vertices as u64) {
                    let value = format!("offset {} stride {}", s.offset, s.stride);
                    let other = format!("offset {} stride {}", t.offset, t.stride);
                    let expected = format!("apart from the {}s (at {other})", name(b));
                    return Err(Error::invalid(&format!("where {}s lie", name(a)), value, &expected));
                }
            }
        }
        Ok((low, high))
    }
}

fn name(attribute: Attribute) -> &'static str {
    match attribute {
        Attribute::Position => "position",
        Attribute::Normal => "normal",
        Attribute::Tangent => "tangent",
    }
}

/// Whether values of two streams share bytes; each with the bytes of a value.
fn overlap((s, s_bytes): (Stream, u64), (t, t_bytes): (Stream, u64), vertices: u64) -> bool {
    let end = |s: Stream, bytes: u64| s.offset + (vertices - 1) * s.stride + bytes;
    if end(s, s_bytes) <= t.offset || end(t, t_bytes) <= s.offset {
        return false;
    }
    // Interleaved: apart within one vertex, on a circle of one stride.
    let gap = (t.offset % s.stride + s.stride - s.offset % s.stride) % s.stride;
    s.stride != t.stride || gap < s_bytes || gap + t_bytes > s.stride
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_round_to_nearest_even() {
        let half = |x: f32| f16_bits(x);
        for (x, bits) in [
            (0.0, 0),
            (-0.0, 0x8000),
            (1.0, 0x3C00),
            (-2.0, 0xC000),
            (65504.0, 0x7BFF),
            (1e9, 0x7BFF),
            (-f32::INFINITY, 0xFBFF),
            (1.0 + 1.0 / 2048.0, 0x3C00),
            (1.0 + 3.0 / 2048.0, 0x3C02),
            (6.1035156e-5, 0x0400),
            (5.9604645e-8, 1),
            (2.9802322e-8, 0),
            (2.9802326e-8, 1),
            (1e-30, 0),
        ] {
            assert_eq!(half(x), bits, "{x}");
        }
        assert_eq!(half(f32::NAN), 0x7E00);
        // Every half comes back from the float that it is.
        for bits in (0..0x7C00u32).chain(0x8000..0xFC00) {
            let (exponent, fraction) = ((bits >> 10 & 31) as i32, (bits & 0x3FF) as f32);
            let size = match exponent {
                0 => fraction * 2f32.powi(-24),
                e => (1.0 + fraction / 1024.0) * 2f32.powi(e - 15),
            };
            assert_eq!(half(if bits & 0x8000 != 0 { -size } else { size }), bits);
        }
    }

    #[test]
    fn normalised_numbers_are_held_and_rounded() {
        for (x, top, n) in [(1.0, 127.0, 127), (-1.0, 127.0, -127), (7.0, 127.0, 127), (-7.0, 32767.0, -32767)] {
            assert_eq!(snorm_bits(x, top) as i32, n);
        }
        assert_eq!(snorm_bits(0.5, 127.0) as i32, 64);
        assert_eq!(snorm_bits(-0.004, 127.0) as i32, -1);
        assert_eq!(snorm_bits(0.003, 127.0) as i32, 0);
        assert_eq!(snorm_bits(f32::NAN, 127.0) as i32, -127);
    }

    #[test]
    fn streams_that_share_bytes_are_refused() {
        let stream = |offset, stride| Stream { offset, stride, encoding: Encoding::F32 };
        let layout = |normals| Layout {
            positions: stream(0, 24),
            normals: Some(normals),
            tangents: None,
            scale: [1.0; 3],
            bias: [0.0; 3],
        };
        assert_eq!(layout(stream(12, 24)).check(10, 240).unwrap(), (0, 240));
        assert_eq!(layout(stream(240, 12)).check(10, 360).unwrap(), (0, 360));
        for bad in [stream(8, 24), stream(12, 12), stream(36, 24), stream(20, 24)] {
            let ok = layout(bad).check(10, 400).is_ok();
            assert_eq!(ok, bad.offset == 36, "{bad:?}");
        }
        assert!(layout(stream(12, 24)).check(10, 239).is_err());
    }
}
