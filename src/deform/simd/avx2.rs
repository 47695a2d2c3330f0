//! Eight lanes in AVX2.

#![expect(clippy::undocumented_unsafe_blocks, reason = "one reason for all of them, said once")]

use super::Simd;
use std::arch::x86_64::*;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Avx2;

// SAFETY of every block below: the trait's callers run only if AVX2 is supported, and pass valid pointers.
impl Simd for Avx2 {
    const LANES: usize = 8;
    type F = __m256;
    type I = __m256i;
    type M = __m256;

    intrinsics! {
        fn splat(x: f32) -> __m256 = _mm256_set1_ps(x);
        fn load(p: *const f32) -> __m256 = _mm256_loadu_ps(p);
        fn store(p: *mut f32, v: __m256) = _mm256_storeu_ps(p, v);
        fn add(a: __m256, b: __m256) -> __m256 = _mm256_add_ps(a, b);
        fn sub(a: __m256, b: __m256) -> __m256 = _mm256_sub_ps(a, b);
        fn mul(a: __m256, b: __m256) -> __m256 = _mm256_mul_ps(a, b);
        fn div(a: __m256, b: __m256) -> __m256 = _mm256_div_ps(a, b);
        fn sqrt(a: __m256) -> __m256 = _mm256_sqrt_ps(a);
        fn min(a: __m256, b: __m256) -> __m256 = _mm256_min_ps(a, b);
        fn max(a: __m256, b: __m256) -> __m256 = _mm256_max_ps(a, b);
        fn equal(a: __m256, b: __m256) -> __m256 = _mm256_cmp_ps::<_CMP_EQ_OQ>(a, b);
        fn greater(a: __m256, b: __m256) -> __m256 = _mm256_cmp_ps::<_CMP_GT_OQ>(a, b);
        fn both(a: __m256, b: __m256) -> __m256 = _mm256_and_ps(a, b);
        fn select(m: __m256, a: __m256, b: __m256) -> __m256 = _mm256_blendv_ps(b, a, m);
        fn splat_int(x: i32) -> __m256i = _mm256_set1_epi32(x);
        fn truncate(a: __m256) -> __m256i = _mm256_cvttps_epi32(a);
        fn float(a: __m256i) -> __m256 = _mm256_cvtepi32_ps(a);
        fn add_pairs(sum: __m256i, a: __m256i, b: __m256i) -> __m256i = _mm256_add_epi32(sum, _mm256_madd_epi16(a, b));
        fn load_pairs(p: *const i8) -> __m256i = _mm256_cvtepi8_epi16(_mm_loadu_si128(p.cast()));
        fn load_halves(p: *const u16) -> __m256 =
            _mm256_castsi256_ps(_mm256_slli_epi32::<16>(_mm256_cvtepu16_epi32(_mm_loadu_si128(p.cast()))));
        fn packed(low: __m256i, high: __m256i) -> __m256i =
            _mm256_blend_epi16::<0xAA>(low, _mm256_slli_epi32::<16>(high));
        fn store_int(p: *mut i32, v: __m256i) = _mm256_storeu_si256(p.cast(), v);
    }

    #[inline(always)]
    unsafe fn lowest(a: __m256) -> f32 {
        unsafe {
            let v = _mm_min_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a));
            let v = _mm_min_ps(v, _mm_movehl_ps(v, v));
            _mm_cvtss_f32(_mm_min_ss(v, _mm_shuffle_ps::<1>(v, v)))
        }
    }
    #[inline(always)]
    unsafe fn highest(a: __m256) -> f32 {
        unsafe {
            let v = _mm_max_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a));
            let v = _mm_max_ps(v, _mm_movehl_ps(v, v));
            _mm_cvtss_f32(_mm_max_ss(v, _mm_shuffle_ps::<1>(v, v)))
        }
    }
    #[inline(always)]
    unsafe fn deinterleave([a, b, c]: [__m256; 3]) -> [__m256; 3] {
        unsafe {
            // Elements 0-3 and 12-15, 4-7 and 16-19, 8-11 and 20-23.
            let m03 = _mm256_permute2f128_ps::<0x30>(a, b);
            let m14 = _mm256_permute2f128_ps::<0x21>(a, c);
            let m25 = _mm256_permute2f128_ps::<0x30>(b, c);
            let xy = _mm256_shuffle_ps::<0b10_01_11_10>(m14, m25);
            let yz = _mm256_shuffle_ps::<0b01_00_10_01>(m03, m14);
            [
                _mm256_shuffle_ps::<0b10_00_11_00>(m03, xy),
                _mm256_shuffle_ps::<0b11_01_10_00>(yz, xy),
                _mm256_shuffle_ps::<0b11_00_11_01>(yz, m25),
            ]
        }
    }
    #[inline(always)]
    unsafe fn interleave([x, y, z]: [__m256; 3]) -> [__m256; 3] {
        unsafe {
            let xy = _mm256_shuffle_ps::<0b10_00_10_00>(x, y);
            let yz = _mm256_shuffle_ps::<0b11_01_11_01>(y, z);
            let zx = _mm256_shuffle_ps::<0b11_01_10_00>(z, x);
            let r03 = _mm256_shuffle_ps::<0b10_00_10_00>(xy, zx);
            let r14 = _mm256_shuffle_ps::<0b11_01_10_00>(yz, xy);
            let r25 = _mm256_shuffle_ps::<0b11_01_11_01>(zx, yz);
            [
                _mm256_permute2f128_ps::<0x20>(r03, r14),
                _mm256_permute2f128_ps::<0x30>(r25, r03),
                _mm256_permute2f128_ps::<0x31>(r14, r25),
            ]
        }
    }
}
