//! Eight lanes in AVX2.

#![expect(clippy::undocumented_unsafe_blocks, reason = "one reason for all of them, said once")]

use super::Simd;
use crate::example::stamp::Node;
use std::arch::x86_64::*;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Avx2;

// SAFETY of every block below: the trait's callers run only if AVX2 is supported, and pass valid pointers and nodes.
impl Simd for Avx2 {
    const LANES: usize = 8;
    type F = __m256;
    type I = __m256i;
    type M = __m256;

    intrinsics! {
        fn splat(x: f32) -> __m256 = _mm256_set1_ps(x);
        fn load(p: *const f32) -> __m256 = _mm256_loadu_ps(p);
        fn store(p: *mut f32, v: __m256) = _mm256_storeu_ps(p, v);
        fn prefetch<T>(p: *const T) = _mm_prefetch::<_MM_HINT_T0>(p.cast());
        fn prefetch_write<T>(p: *mut T) = _mm_prefetch::<_MM_HINT_ET0>(p.cast());
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
        fn any(m: __m256) -> bool = _mm256_movemask_ps(m) != 0;
        fn select(m: __m256, a: __m256, b: __m256) -> __m256 = _mm256_blendv_ps(b, a, m);
        fn splat_int(x: i32) -> __m256i = _mm256_set1_epi32(x);
        fn truncate(a: __m256) -> __m256i = _mm256_cvttps_epi32(a);
        fn float(a: __m256i) -> __m256 = _mm256_cvtepi32_ps(a);
        fn add_int(a: __m256i, b: __m256i) -> __m256i = _mm256_add_epi32(a, b);
        fn sub_int(a: __m256i, b: __m256i) -> __m256i = _mm256_sub_epi32(a, b);
        fn mul_short(a: __m256i, b: __m256i) -> __m256i = _mm256_madd_epi16(a, b);
        fn dot_pairs(a: __m256i, b: __m256i) -> __m256i = _mm256_madd_epi16(a, b);
        fn load_pairs(p: *const i8) -> __m256i = _mm256_cvtepi8_epi16(_mm_loadu_si128(p.cast()));
        fn split(a: __m256i) -> [__m256i; 2] =
            [_mm256_srli_epi32::<14>(a), _mm256_and_si256(a, _mm256_set1_epi32(0x3FFF))];
        fn load_i8(p: *const i8) -> __m256 = _mm256_cvtepi32_ps(_mm256_cvtepi8_epi32(_mm_loadl_epi64(p.cast())));
        fn load_i16(p: *const i16) -> __m256 = _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(_mm_loadu_si128(p.cast())));
        fn load_halves(p: *const u16) -> __m256 =
            _mm256_castsi256_ps(_mm256_slli_epi32::<16>(_mm256_cvtepu16_epi32(_mm_loadu_si128(p.cast()))));
        fn packed(low: __m256i, high: __m256i) -> __m256i =
            _mm256_blend_epi16::<0xAA>(low, _mm256_slli_epi32::<16>(high));
        fn load_int(p: *const i32) -> __m256i = _mm256_loadu_si256(p.cast());
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
    #[inline(always)]
    unsafe fn blend<const ALL: bool>(
        p: *const Node,
        row: usize,
        at: __m256i,
        near: __m256i,
        far: __m256i,
    ) -> [[__m256i; 4]; 2] {
        unsafe {
            let mut index = [0i32; 8];
            _mm256_storeu_si256(index.as_mut_ptr().cast(), at);
            let nodes = [p, p.add(row)];
            let a = two::<0x00, ALL>(nodes, [index[0], index[4]], [near, far]);
            let b = two::<0x55, ALL>(nodes, [index[1], index[5]], [near, far]);
            let c = two::<0xAA, ALL>(nodes, [index[2], index[6]], [near, far]);
            let d = two::<0xFF, ALL>(nodes, [index[3], index[7]], [near, far]);
            let rest = if ALL { columns([a[1], b[1], c[1], d[1]]) } else { [_mm256_setzero_si256(); 4] };
            [columns([a[0], b[0], c[0], d[0]]), rest]
        }
    }
}

/// The weighted sums of two lanes, four apart, each in its half. `LANE` selects the lane's weight within each half.
///
/// # Safety
/// As [`Simd::blend`].
#[inline(always)]
unsafe fn two<const LANE: i32, const ALL: bool>(
    rows: [*const Node; 2],
    at: [i32; 2],
    weights: [__m256i; 2],
) -> [__m256i; 2] {
    unsafe {
        let mut sums = [_mm256_setzero_si256(); 2];
        for k in 0..2 {
            let (p, q) = (rows[k].add(at[0] as usize), rows[k].add(at[1] as usize));
            let (a, b) = (both(p, q), both(p.add(1), q.add(1)));
            let w = _mm256_shuffle_epi32::<LANE>(weights[k]);
            sums[0] = _mm256_add_epi32(sums[0], _mm256_madd_epi16(_mm256_unpacklo_epi16(a, b), w));
            if ALL {
                sums[1] = _mm256_add_epi32(sums[1], _mm256_madd_epi16(_mm256_unpackhi_epi16(a, b), w));
            }
        }
        sums
    }
}

/// # Safety
/// As [`Simd::blend`].
#[inline(always)]
unsafe fn both(a: *const Node, b: *const Node) -> __m256i {
    unsafe {
        _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(_mm_loadu_si128(a.cast())), _mm_loadu_si128(b.cast()))
    }
}

/// Transposes each half: four rows become four columns.
///
/// # Safety
/// The processor supports AVX2.
#[inline(always)]
unsafe fn columns([a, b, c, d]: [__m256i; 4]) -> [__m256i; 4] {
    unsafe {
        let (ab, cd) = (_mm256_unpacklo_epi32(a, b), _mm256_unpacklo_epi32(c, d));
        let (ab_high, cd_high) = (_mm256_unpackhi_epi32(a, b), _mm256_unpackhi_epi32(c, d));
        [
            _mm256_unpacklo_epi64(ab, cd),
            _mm256_unpackhi_epi64(ab, cd),
            _mm256_unpacklo_epi64(ab_high, cd_high),
            _mm256_unpackhi_epi64(ab_high, cd_high),
        ]
    }
}
