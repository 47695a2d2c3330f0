//! Pairs of 16-bit numbers, which processors multiply and add at once.

/// Four pairs: the first number of each in the lower half.
pub(crate) type Pairs = [i32; 4];

/// Pairs of the numbers of `a` and those of `b`.
#[inline(always)]
pub(crate) fn paired(a: [i16; 4], b: [i16; 4]) -> Pairs {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_mm_cvtsi64_si128, _mm_unpacklo_epi16};
        // SAFETY: every x86-64 has SSE2.
        bytemuck::cast(unsafe {
            _mm_unpacklo_epi16(_mm_cvtsi64_si128(bytemuck::cast(a)), _mm_cvtsi64_si128(bytemuck::cast(b)))
        })
    }
    #[cfg(not(target_arch = "x86_64"))]
    std::array::from_fn(|k| pair(a[k], b[k]))
}

/// A pair.
#[inline(always)]
pub(crate) fn pair(a: i16, b: i16) -> i32 {
    (i32::from(b) << 16) | i32::from(a as u16)
}

/// For each pair the sum of the products of its numbers with those of `factors`, a pair too.
#[inline(always)]
pub(crate) fn dot(pairs: Pairs, factors: i32) -> [i32; 4] {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_mm_madd_epi16, _mm_set1_epi32};
        // SAFETY: every x86-64 has SSE2.
        bytemuck::cast(unsafe { _mm_madd_epi16(bytemuck::cast(pairs), _mm_set1_epi32(factors)) })
    }
    #[cfg(not(target_arch = "x86_64"))]
    pairs.map(|p| i32::from(p as i16) * i32::from(factors as i16) + (p >> 16) * (factors >> 16))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_added_by_pairs() {
        let pairs = paired([1, -2, 300, i16::MIN], [5, 7, -11, i16::MAX]);
        assert_eq!(pairs[1], pair(-2, 7));
        assert_eq!(dot(pairs, pair(16384, -3)), [16384 - 15, -32768 - 21, 4_915_200 + 33, -536_870_912 - 98_301]);
    }
}
