//! Eight lanes in what every processor of the target has.

use super::{Simd, unpack};
use wide::{f32x8, i32x8};

#[derive(Debug, Clone, Copy)]
pub(crate) struct Portable;

#[inline(always)]
fn three(f: impl Fn(usize) -> [f32; 3]) -> [f32x8; 3] {
    let [a, b, c, d, e, g, h, i] = [f(0), f(1), f(2), f(3), f(4), f(5), f(6), f(7)];
    [
        f32x8::from([a[0], b[0], c[0], d[0], e[0], g[0], h[0], i[0]]),
        f32x8::from([a[1], b[1], c[1], d[1], e[1], g[1], h[1], i[1]]),
        f32x8::from([a[2], b[2], c[2], d[2], e[2], g[2], h[2], i[2]]),
    ]
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
    unsafe fn prefetch<T>(_p: *const T) {}
    #[inline(always)]
    unsafe fn prefetch_write<T>(_p: *mut T) {}
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
