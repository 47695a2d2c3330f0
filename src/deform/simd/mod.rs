//! Vectors of eight or sixteen floats, in which the kernels of `deform` are written.
//!
//! All levels share one source: a kernel is generic over [`Simd`], and each level compiles it for its instructions. All
//! operations follow IEEE 754 (no fused multiply-add, no approximate reciprocals), so every level gives the same bits.

/// Defines functions of [`Simd`] that are one expression.
macro_rules! intrinsics {
    ($(fn $name:ident ($($arg:ident: $type:ty),*) $(-> $out:ty)? = $body:expr;)*) => {$(
        #[inline(always)]
        #[allow(unused_unsafe, reason = "some expressions are safe")]
        unsafe fn $name($($arg: $type),*) $(-> $out)? {
            // SAFETY: callers uphold the trait's requirements, which are those of the intrinsics.
            unsafe { $body }
        }
    )*};
}

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod portable;

#[cfg(target_arch = "x86_64")]
pub(crate) use avx2::Avx2;
#[cfg(target_arch = "x86_64")]
pub(crate) use avx512::Avx512;
pub(crate) use portable::Portable;

use crate::base::error::Error;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU8, Ordering};

/// Instruction sets that deformation is compiled for. The result has the same bits at every level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum SimdLevel {
    /// The target's baseline: SSE2 on x86-64, NEON on AArch64.
    Portable = 1,
    /// AVX2: eight lanes.
    Avx2 = 2,
    /// AVX-512 (F, BW, DQ, VL, VNNI): sixteen lanes where they are faster.
    Avx512 = 3,
}

/// The level that [`SimdLevel::force`] set; 0: none.
static LEVEL: AtomicU8 = AtomicU8::new(0);

impl SimdLevel {
    /// Returns the best level of this processor. The environment variable `CRUMPLE_SIMD` caps it if it is `portable` or
    /// `avx2` at the first call, for tools that do not know newer instructions.
    pub fn best() -> Self {
        static BEST: OnceLock<SimdLevel> = OnceLock::new();
        *BEST.get_or_init(|| match std::env::var("CRUMPLE_SIMD").as_deref() {
            Ok("portable") => SimdLevel::Portable,
            Ok("avx2") => Self::of_processor().min(SimdLevel::Avx2),
            _ => Self::of_processor(),
        })
    }

    fn of_processor() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::is_x86_feature_detected as has;
            let has_512 =
                has!("avx512f") && has!("avx512bw") && has!("avx512dq") && has!("avx512vl") && has!("avx512vnni");
            if has_512 && has!("avx2") {
                return SimdLevel::Avx512;
            }
            if has!("avx2") {
                return SimdLevel::Avx2;
            }
        }
        SimdLevel::Portable
    }

    /// Returns the levels up to [`SimdLevel::best`], simplest first.
    pub fn available() -> impl Iterator<Item = SimdLevel> {
        [SimdLevel::Portable, SimdLevel::Avx2, SimdLevel::Avx512].into_iter().filter(|l| *l <= Self::best())
    }

    /// Returns the level in use in this process: the best, unless [`SimdLevel::force`] set another.
    pub fn current() -> Self {
        match LEVEL.load(Ordering::Relaxed) {
            1 => SimdLevel::Portable,
            2 => SimdLevel::Avx2,
            3 => SimdLevel::Avx512,
            _ => Self::best(),
        }
    }

    /// Sets the level of the whole process from now on. For tests and comparisons: results do not depend on the level.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the level is above [`SimdLevel::best`].
    pub fn force(self) -> Result<(), Error> {
        if self > Self::best() {
            return Err(Error::Unsupported { what: format!("{self:?}: this processor goes up to {:?}", Self::best()) });
        }
        LEVEL.store(self as u8, Ordering::Relaxed);
        Ok(())
    }
}

/// A vector of `LANES` floats, with the operations that the kernels use.
///
/// Functions with pointers read or write `LANES` values there, at any alignment.
///
/// # Safety
/// Call these functions only if the processor supports the level's instructions. That holds inside the functions that
/// [`SimdLevel::current`] dispatches to. Pointers must be valid.
pub(crate) trait Simd: Copy {
    const LANES: usize;
    /// Floats.
    type F: Copy;
    /// 32-bit integers.
    type I: Copy;
    /// A boolean in each lane.
    type M: Copy;

    unsafe fn splat(x: f32) -> Self::F;
    unsafe fn load(p: *const f32) -> Self::F;
    unsafe fn store(p: *mut f32, v: Self::F);
    unsafe fn add(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn sub(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn mul(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn div(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn sqrt(a: Self::F) -> Self::F;
    /// The lesser of two numbers; `b` where `a` is NaN.
    unsafe fn min(a: Self::F, b: Self::F) -> Self::F;
    /// The greater of two numbers; `b` where `a` is NaN.
    unsafe fn max(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn equal(a: Self::F, b: Self::F) -> Self::M;
    unsafe fn greater(a: Self::F, b: Self::F) -> Self::M;
    unsafe fn both(a: Self::M, b: Self::M) -> Self::M;
    /// The least lane. No lane may be NaN.
    unsafe fn lowest(a: Self::F) -> f32;
    /// The greatest lane. No lane may be NaN.
    unsafe fn highest(a: Self::F) -> f32;
    /// `a` where `m`, else `b`.
    unsafe fn select(m: Self::M, a: Self::F, b: Self::F) -> Self::F;

    unsafe fn splat_int(x: i32) -> Self::I;
    /// Truncates towards zero. Values must be in the range of i32.
    unsafe fn truncate(a: Self::F) -> Self::I;
    unsafe fn float(a: Self::I) -> Self::F;
    /// Adds to each lane the products of the two 16-bit numbers of the others. No sum may overflow.
    unsafe fn add_pairs(sum: Self::I, a: Self::I, b: Self::I) -> Self::I;

    /// Loads two 8-bit numbers a lane, as 16-bit numbers.
    unsafe fn load_pairs(p: *const i8) -> Self::I;
    /// Loads the upper halves of floats whose lower halves are 0.
    unsafe fn load_halves(p: *const u16) -> Self::F;
    /// Separates `3 * LANES` values x y z x y z … into three vectors.
    unsafe fn deinterleave(v: [Self::F; 3]) -> [Self::F; 3];
    /// The inverse of `deinterleave`.
    unsafe fn interleave(v: [Self::F; 3]) -> [Self::F; 3];

    /// Puts the lower 16 bits of each lane of `high` above those of `low`.
    unsafe fn packed(low: Self::I, high: Self::I) -> Self::I;
    unsafe fn store_int(p: *mut i32, v: Self::I);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_that_the_processor_lacks_are_refused() {
        assert_eq!(SimdLevel::available().last(), Some(SimdLevel::best()));
        if SimdLevel::best() < SimdLevel::Avx512 {
            assert!(SimdLevel::Avx512.force().is_err());
        }
    }
}
