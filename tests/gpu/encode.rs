//! The number formats of vertices that kernels write, from floats.

use crate::backend::Encoding;

/// The words that a kernel stores for a value, as many as the encoding has. The octahedral format is compared with what the CPU writes.
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
        Encoding::Octahedral16x2 => unreachable!("the CPU writes it"),
    }
}

fn f16_bits(x: f32) -> u32 {
    let bits = x.to_bits();
    let (sign, size) = (bits >> 16 & 0x8000, bits & 0x7FFF_FFFF);
    if size >= 0x477F_E000 {
        return sign | if size > 0x7F80_0000 { 0x7E00 } else { 0x7BFF };
    }
    if size < 0x3880_0000 {
        // Below 2^-14 a half is a multiple of 2^-24, and so is a float between 0.5 and 1.
        return sign | ((f32::from_bits(size) + 0.5).to_bits() - 0x3F00_0000);
    }
    sign | (size - 0x3800_0000 + 0xFFF + (size >> 13 & 1)) >> 13
}

fn snorm_bits(x: f32, top: f32) -> u32 {
    let x = if x > -1.0 { x } else { -1.0 };
    let y = if x < 1.0 { x } else { 1.0 } * top;
    (y + if y < 0.0 { -0.5 } else { 0.5 }) as i32 as u32
}

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
    // Every half survives the way to a float and back.
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
fn normalised_numbers_are_clamped_and_rounded() {
    for (x, top, n) in [(1.0, 127.0, 127), (-1.0, 127.0, -127), (7.0, 127.0, 127), (-7.0, 32767.0, -32767)] {
        assert_eq!(snorm_bits(x, top) as i32, n);
    }
    assert_eq!(snorm_bits(0.5, 127.0) as i32, 64);
    assert_eq!(snorm_bits(-0.004, 127.0) as i32, -1);
    assert_eq!(snorm_bits(0.003, 127.0) as i32, 0);
    assert_eq!(snorm_bits(f32::NAN, 127.0) as i32, -127);
}
