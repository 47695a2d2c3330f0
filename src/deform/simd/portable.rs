//! Eight lanes in the target's baseline instructions.

use super::Simd;
use wide::{f32x8, i16x8, i32x8};

#[derive(Debug, Clone, Copy)]
pub(crate) struct Portable;

// SAFETY of the whole block: the instructions are always supported; the trait requires valid pointers.
impl Simd for Portable {
    const LANES: usize = 8;
    type F = f32x8;
    type I = i32x8;
    type M = f32x8;

    intrinsics! {
        fn splat(x: f32) -> f32x8 = f32x8::splat(x);
        fn load(p: *const f32) -> f32x8 = f32x8::from(p.cast::<[f32; 8]>().read_unaligned());
        fn store(p: *mut f32, v: f32x8) = p.cast::<[f32; 8]>().write_unaligned(v.to_array());
        fn add(a: f32x8, b: f32x8) -> f32x8 = a + b;
        fn sub(a: f32x8, b: f32x8) -> f32x8 = a - b;
        fn mul(a: f32x8, b: f32x8) -> f32x8 = a * b;
        fn div(a: f32x8, b: f32x8) -> f32x8 = a / b;
        fn sqrt(a: f32x8) -> f32x8 = a.sqrt();
        fn min(a: f32x8, b: f32x8) -> f32x8 = b.simd_gt(a).select(a, b);
        fn max(a: f32x8, b: f32x8) -> f32x8 = a.simd_gt(b).select(a, b);
        fn lowest(a: f32x8) -> f32 =
            a.to_array().into_iter().fold(f32::INFINITY, |m, x| if x < m { x } else { m });
        fn highest(a: f32x8) -> f32 =
            a.to_array().into_iter().fold(f32::NEG_INFINITY, |m, x| if x > m { x } else { m });
        fn equal(a: f32x8, b: f32x8) -> f32x8 = a.simd_eq(b);
        fn greater(a: f32x8, b: f32x8) -> f32x8 = a.simd_gt(b);
        fn both(a: f32x8, b: f32x8) -> f32x8 = a & b;
        fn select(m: f32x8, a: f32x8, b: f32x8) -> f32x8 = m.select(a, b);
        fn splat_int(x: i32) -> i32x8 = i32x8::splat(x);
        fn truncate(a: f32x8) -> i32x8 = a.trunc_int();
        fn float(a: i32x8) -> f32x8 = a.round_float();
        fn load_pairs(p: *const i8) -> i32x8 = bytemuck::cast(p.cast::<[i8; 16]>().read_unaligned().map(i16::from));
        fn load_halves(p: *const u16) -> f32x8 =
            f32x8::from(p.cast::<[u16; 8]>().read_unaligned().map(|h| f32::from_bits(u32::from(h) << 16)));
        fn packed(low: i32x8, high: i32x8) -> i32x8 = (low & i32x8::splat(0xFFFF)) | high << 16;
        fn store_int(p: *mut i32, v: i32x8) = p.cast::<[i32; 8]>().write_unaligned(v.to_array());
    }

    #[inline(always)]
    unsafe fn add_pairs(sum: i32x8, a: i32x8, b: i32x8) -> i32x8 {
        let (a, b): ([i16x8; 2], [i16x8; 2]) = (bytemuck::cast(a), bytemuck::cast(b));
        let products: i32x8 = bytemuck::cast([a[0].dot(b[0]), a[1].dot(b[1])]);
        sum + products
    }
    #[inline(always)]
    unsafe fn deinterleave([a, b, c]: [f32x8; 3]) -> [f32x8; 3] {
        let (a, b, c) = (a.to_array(), b.to_array(), c.to_array());
        [
            f32x8::from([a[0], a[3], a[6], b[1], b[4], b[7], c[2], c[5]]),
            f32x8::from([a[1], a[4], a[7], b[2], b[5], c[0], c[3], c[6]]),
            f32x8::from([a[2], a[5], b[0], b[3], b[6], c[1], c[4], c[7]]),
        ]
    }
    #[inline(always)]
    unsafe fn interleave([x, y, z]: [f32x8; 3]) -> [f32x8; 3] {
        let (x, y, z) = (x.to_array(), y.to_array(), z.to_array());
        [
            f32x8::from([x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2]]),
            f32x8::from([z[2], x[3], y[3], z[3], x[4], y[4], z[4], x[5]]),
            f32x8::from([y[5], z[5], x[6], y[6], z[6], x[7], y[7], z[7]]),
        ]
    }
}
