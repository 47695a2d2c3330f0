//! Eight lanes in what every processor of the target has.

use super::{Simd, unpack};
use wide::{f32x8, i32x8};

#[derive(Debug, Clone, Copy)]
pub(crate) struct Portable;

fn three(f: impl Fn(usize) -> [f32; 3]) -> [f32x8; 3] {
    let v: [[f32; 3]; 8] = std::array::from_fn(f);
    [0, 1, 2].map(|k| f32x8::from(v.map(|v| v[k])))
}

// SAFETY of the whole block: the instructions are always there; pointers are valid by the trait's terms.
impl Simd for Portable {
    const LANES: usize = 8;
    type F = f32x8;
    type I = i32x8;
    type M = f32x8;

    #[inline(always)]
    unsafe fn splat(x: f32) -> f32x8 {
        f32x8::splat(x)
    }
    #[inline(always)]
    unsafe fn load(p: *const f32) -> f32x8 {
        // SAFETY: eight floats lie there.
        f32x8::from(unsafe { p.cast::<[f32; 8]>().read_unaligned() })
    }
    #[inline(always)]
    unsafe fn store(p: *mut f32, v: f32x8) {
        // SAFETY: there is room for eight floats.
        unsafe { p.cast::<[f32; 8]>().write_unaligned(v.to_array()) }
    }
    #[inline(always)]
    unsafe fn stream(p: *mut f32, v: f32x8) {
        // SAFETY: passed on.
        unsafe { Self::store(p, v) }
    }
    #[inline(always)]
    unsafe fn add(a: f32x8, b: f32x8) -> f32x8 {
        a + b
    }
    #[inline(always)]
    unsafe fn sub(a: f32x8, b: f32x8) -> f32x8 {
        a - b
    }
    #[inline(always)]
    unsafe fn mul(a: f32x8, b: f32x8) -> f32x8 {
        a * b
    }
    #[inline(always)]
    unsafe fn div(a: f32x8, b: f32x8) -> f32x8 {
        a / b
    }
    #[inline(always)]
    unsafe fn sqrt(a: f32x8) -> f32x8 {
        a.sqrt()
    }
    #[inline(always)]
    unsafe fn min(a: f32x8, b: f32x8) -> f32x8 {
        b.simd_gt(a).select(a, b)
    }
    #[inline(always)]
    unsafe fn max(a: f32x8, b: f32x8) -> f32x8 {
        a.simd_gt(b).select(a, b)
    }
    #[inline(always)]
    unsafe fn lowest(a: f32x8) -> f32 {
        a.to_array().into_iter().fold(f32::INFINITY, |m, x| if x < m { x } else { m })
    }
    #[inline(always)]
    unsafe fn highest(a: f32x8) -> f32 {
        a.to_array().into_iter().fold(f32::NEG_INFINITY, |m, x| if x > m { x } else { m })
    }
    #[inline(always)]
    unsafe fn equal(a: f32x8, b: f32x8) -> f32x8 {
        a.simd_eq(b)
    }
    #[inline(always)]
    unsafe fn greater(a: f32x8, b: f32x8) -> f32x8 {
        a.simd_gt(b)
    }
    #[inline(always)]
    unsafe fn both(a: f32x8, b: f32x8) -> f32x8 {
        a & b
    }
    #[inline(always)]
    unsafe fn any(m: f32x8) -> bool {
        m.any()
    }
    #[inline(always)]
    unsafe fn select(m: f32x8, a: f32x8, b: f32x8) -> f32x8 {
        m.select(a, b)
    }
    #[inline(always)]
    unsafe fn splat_int(x: i32) -> i32x8 {
        i32x8::splat(x)
    }
    #[inline(always)]
    unsafe fn truncate(a: f32x8) -> i32x8 {
        a.trunc_int()
    }
    #[inline(always)]
    unsafe fn float(a: i32x8) -> f32x8 {
        a.round_float()
    }
    #[inline(always)]
    unsafe fn add_int(a: i32x8, b: i32x8) -> i32x8 {
        a + b
    }
    #[inline(always)]
    unsafe fn mul_int(a: i32x8, b: i32x8) -> i32x8 {
        a * b
    }
    #[inline(always)]
    unsafe fn min_int(a: i32x8, b: i32x8) -> i32x8 {
        a.min(b)
    }
    #[inline(always)]
    unsafe fn max_int(a: i32x8, b: i32x8) -> i32x8 {
        a.max(b)
    }
    #[inline(always)]
    unsafe fn load_i8(p: *const i8) -> f32x8 {
        // SAFETY: eight values lie there.
        f32x8::from(unsafe { p.cast::<[i8; 8]>().read_unaligned() }.map(f32::from))
    }
    #[inline(always)]
    unsafe fn load_i16(p: *const i16) -> f32x8 {
        // SAFETY: eight values lie there.
        f32x8::from(unsafe { p.cast::<[i16; 8]>().read_unaligned() }.map(f32::from))
    }
    #[inline(always)]
    unsafe fn deinterleave(v: [f32x8; 3]) -> [f32x8; 3] {
        let v = v.map(|v| v.to_array());
        let flat = |i: usize| v[i / 8][i % 8];
        [0, 1, 2].map(|k| f32x8::from(std::array::from_fn::<f32, 8, _>(|i| flat(3 * i + k))))
    }
    #[inline(always)]
    unsafe fn interleave(v: [f32x8; 3]) -> [f32x8; 3] {
        let v = v.map(|v| v.to_array());
        [0, 1, 2].map(|part| f32x8::from(std::array::from_fn::<f32, 8, _>(|i| v[(8 * part + i) % 3][(8 * part + i) / 3])))
    }
    #[inline(always)]
    unsafe fn gather_packed(p: *const u32, at: i32x8) -> [f32x8; 3] {
        let at = at.to_array();
        // SAFETY: `at` is within the nodes.
        three(|i| unpack(unsafe { p.add(at[i] as usize).read() }).map(|x| x as f32))
    }
    #[inline(always)]
    unsafe fn gather_i16(p: *const [i16; 4], at: i32x8) -> [f32x8; 3] {
        let at = at.to_array();
        three(|i| {
            // SAFETY: `at` is within the nodes.
            let [x, y, z, _] = unsafe { p.add(at[i] as usize).read() }.map(f32::from);
            [x, y, z]
        })
    }
    #[inline(always)]
    unsafe fn gather_f32(p: *const [f32; 3], at: i32x8) -> [f32x8; 3] {
        let at = at.to_array();
        // SAFETY: `at` is within the nodes.
        three(|i| unsafe { p.add(at[i] as usize).read() })
    }
}
