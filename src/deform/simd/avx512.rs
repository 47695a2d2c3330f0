//! Sixteen lanes in AVX-512 (F, BW, DQ, VL).

#![expect(clippy::undocumented_unsafe_blocks, reason = "one reason for all of them, said once")]

use super::{Avx2, Simd};
use std::arch::x86_64::*;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Avx512;

/// # Safety
/// The processor supports AVX-512.
#[inline(always)]
unsafe fn join(lo: __m256, hi: __m256) -> __m512 {
    unsafe { _mm512_insertf32x8::<1>(_mm512_castps256_ps512(lo), hi) }
}

/// # Safety
/// The processor supports AVX-512.
#[inline(always)]
unsafe fn halves(v: __m512) -> [__m256; 2] {
    unsafe { [_mm512_castps512_ps256(v), _mm512_extractf32x8_ps::<1>(v)] }
}

// SAFETY of every block below: the trait's callers run only if AVX-512 is supported, and pass valid pointers.
impl Simd for Avx512 {
    const LANES: usize = 16;
    type F = __m512;
    type I = __m512i;
    type M = __mmask16;

    intrinsics! {
        fn splat(x: f32) -> __m512 = _mm512_set1_ps(x);
        fn load(p: *const f32) -> __m512 = _mm512_loadu_ps(p);
        fn store(p: *mut f32, v: __m512) = _mm512_storeu_ps(p, v);
        fn add(a: __m512, b: __m512) -> __m512 = _mm512_add_ps(a, b);
        fn sub(a: __m512, b: __m512) -> __m512 = _mm512_sub_ps(a, b);
        fn mul(a: __m512, b: __m512) -> __m512 = _mm512_mul_ps(a, b);
        fn div(a: __m512, b: __m512) -> __m512 = _mm512_div_ps(a, b);
        fn sqrt(a: __m512) -> __m512 = _mm512_sqrt_ps(a);
        fn min(a: __m512, b: __m512) -> __m512 = _mm512_min_ps(a, b);
        fn max(a: __m512, b: __m512) -> __m512 = _mm512_max_ps(a, b);
        fn equal(a: __m512, b: __m512) -> __mmask16 = _mm512_cmp_ps_mask::<_CMP_EQ_OQ>(a, b);
        fn greater(a: __m512, b: __m512) -> __mmask16 = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(a, b);
        fn both(a: __mmask16, b: __mmask16) -> __mmask16 = a & b;
        fn select(m: __mmask16, a: __m512, b: __m512) -> __m512 = _mm512_mask_blend_ps(m, b, a);
        fn splat_int(x: i32) -> __m512i = _mm512_set1_epi32(x);
        fn truncate(a: __m512) -> __m512i = _mm512_cvttps_epi32(a);
        fn float(a: __m512i) -> __m512 = _mm512_cvtepi32_ps(a);
        fn add_pairs(sum: __m512i, a: __m512i, b: __m512i) -> __m512i = _mm512_dpwssd_epi32(sum, a, b);
        fn load_pairs(p: *const i8) -> __m512i = _mm512_cvtepi8_epi16(_mm256_loadu_si256(p.cast()));
        fn load_halves(p: *const u16) -> __m512 =
            _mm512_castsi512_ps(_mm512_slli_epi32::<16>(_mm512_cvtepu16_epi32(_mm256_loadu_si256(p.cast()))));
        fn packed(low: __m512i, high: __m512i) -> __m512i =
            _mm512_mask_blend_epi16(0xAAAA_AAAA, low, _mm512_slli_epi32::<16>(high));
        fn store_int(p: *mut i32, v: __m512i) = _mm512_storeu_si512(p.cast(), v);
    }

    #[inline(always)]
    unsafe fn lowest(a: __m512) -> f32 {
        unsafe {
            let [lo, hi] = halves(a);
            Avx2::lowest(_mm256_min_ps(lo, hi))
        }
    }
    #[inline(always)]
    unsafe fn highest(a: __m512) -> f32 {
        unsafe {
            let [lo, hi] = halves(a);
            Avx2::highest(_mm256_max_ps(lo, hi))
        }
    }
    #[inline(always)]
    unsafe fn deinterleave([a, b, c]: [__m512; 3]) -> [__m512; 3] {
        unsafe {
            let ([a0, a1], [b0, b1], [c0, c1]) = (halves(a), halves(b), halves(c));
            let (lo, hi) = (Avx2::deinterleave([a0, a1, b0]), Avx2::deinterleave([b1, c0, c1]));
            [join(lo[0], hi[0]), join(lo[1], hi[1]), join(lo[2], hi[2])]
        }
    }
    #[inline(always)]
    unsafe fn interleave([x, y, z]: [__m512; 3]) -> [__m512; 3] {
        unsafe {
            let ([x0, x1], [y0, y1], [z0, z1]) = (halves(x), halves(y), halves(z));
            let (lo, hi) = (Avx2::interleave([x0, y0, z0]), Avx2::interleave([x1, y1, z1]));
            [join(lo[0], lo[1]), join(lo[2], hi[0]), join(hi[1], hi[2])]
        }
    }
}
