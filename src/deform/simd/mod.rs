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

/// A vector of `LANES` floats, with the operations that the kernels use.
///
/// Functions with pointers read or write `LANES` values there, at any alignment.
///
/// # Safety
/// Call these functions only if the processor supports the level's instructions. That holds inside the functions that
/// [`crate::SimdLevel`] dispatches to. Pointers must be valid.
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
