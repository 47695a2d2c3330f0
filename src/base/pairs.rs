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
    std::array::from_fn(|k| (i32::from(b[k]) << 16) | i32::from(a[k] as u16))
}
