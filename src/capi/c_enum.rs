//! Enums that C may fill with any number.

use std::mem::MaybeUninit;

/// An enum of the header, which C may fill with any number.
///
/// # Safety
/// The type is `repr(C)` and has an enumerator for each number from 0 to `LAST`.
pub(super) unsafe trait CEnum: Copy + 'static {
    const LAST: u32;
}

/// Declares enums of the header by their last enumerators.
macro_rules! c_enums {
    ($($name:ident::$last:ident),* $(,)?) => {$(
        // SAFETY: `repr(C)`, and its enumerators are numbered from 0 without a gap.
        unsafe impl $crate::capi::c_enum::CEnum for $name {
            const LAST: u32 = $name::$last as u32;
        }
    )*};
}
pub(super) use c_enums;

/// The number that C stored in an enum.
pub(super) fn number<E>(value: MaybeUninit<E>) -> u32 {
    const { assert!(size_of::<E>() == 4 && align_of::<E>() == 4) };
    // SAFETY: four bytes (asserted above), which C initialised when it passed the value.
    unsafe { (&raw const value).cast::<u32>().read() }
}
