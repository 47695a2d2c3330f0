//! The number formats of vertices that kernels write, from floats.

use half::f16;

use crate::backend::Encoding;

/// The words that a kernel stores for a value, as many as the encoding has. The octahedral format is compared with what the CPU writes.
pub fn encode(encoding: Encoding, v: [f32; 4]) -> [u32; 4] {
    let pair = |a: u32, b: u32| a & 0xFFFF | b << 16;
    match encoding {
        Encoding::F32 => v.map(f32::to_bits),
        Encoding::F16x4 => {
            // What is too large for a half is the largest one.
            let v = v.map(|x| f16::from_f32(x.clamp(-65504.0, 65504.0)).to_bits().into());
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

fn snorm_bits(x: f32, top: f32) -> u32 {
    let x = if x > -1.0 { x } else { -1.0 };
    let y = if x < 1.0 { x } else { 1.0 } * top;
    (y + if y < 0.0 { -0.5 } else { 0.5 }) as i32 as u32
}
