//! The checks that every entry point makes of what C hands over: pointers, defs, enumerators, strings, scalars.

use super::result::{CrumpleResult, Failure};
use std::ffi::{CStr, c_char};
use std::mem::MaybeUninit;

/// An enum of the header, which C may fill with any number.
pub(super) trait CEnum: Copy + 'static {
    /// All its enumerators.
    const ALL: &'static [Self];

    /// The enumerator, or nothing for a number that is none.
    fn read(value: MaybeUninit<Self>) -> Option<Self> {
        let number = number(value);
        Self::ALL.iter().copied().find(|&e| self::number(MaybeUninit::new(e)) == number)
    }
}

/// The number that C stored in an enum.
fn number<E: CEnum>(value: MaybeUninit<E>) -> u32 {
    const { assert!(size_of::<E>() == 4 && align_of::<E>() == 4) };
    // SAFETY: four bytes (asserted above), which C initialised when it passed the value.
    unsafe { (&raw const value).cast::<u32>().read() }
}

/// Reads an enumerator.
pub(super) fn enumerator<E: CEnum>(value: MaybeUninit<E>, name: &str) -> Result<E, Failure> {
    E::read(value).ok_or_else(|| {
        let numbers: Vec<_> = E::ALL.iter().map(|&e| number(MaybeUninit::new(e)).to_string()).collect();
        Failure::invalid(format!("{name} is {}; it must be one of {}", number(value), numbers.join(", ")))
    })
}

/// Reads a C `bool`: anything but zero is true.
pub(super) fn boolean(value: MaybeUninit<bool>) -> bool {
    // SAFETY: one byte, which C initialised when it passed the value.
    unsafe { (&raw const value).cast::<u8>().read() != 0 }
}

/// A pointer that may be read or written as a `T`.
fn usable<T>(pointer: *const T, name: &str) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::new(CrumpleResult::CrumpleErrorNullPointer, format!("{name} is null")));
    }
    if !pointer.is_aligned() {
        return Err(misaligned(name, pointer.addr() as u64, align_of::<T>() as u64));
    }
    Ok(())
}

pub(super) fn misaligned(name: &str, value: u64, align: u64) -> Failure {
    crate::Error::Misaligned { name: name.into(), value, align }.into()
}

/// A struct that starts with its size.
///
/// # Safety
/// The type is `repr(C)`, starts with a `u32` that is its size, and every pattern of bytes is a value of it.
pub(super) unsafe trait Def: Copy {
    /// The function that makes one.
    const DEFAULT: MadeBy<Self>;
    /// The sizes that it had before it grew, in versions with the same SONAME. What is newer than one of them begins behind it, never in
    /// what was padding.
    const EARLIER: &'static [u32] = &[];
}

/// The name of a def's `crumple_..._def_default` function, and the function.
pub(super) type MadeBy<T> = (&'static str, extern "C" fn() -> T);

/// Copies a def after checking its size. What one of an earlier version lacks is as the default.
///
/// # Safety
/// `pointer` is null or points to as many readable bytes as its first four say.
pub(super) unsafe fn def<T: Def>(pointer: *const T, name: &str) -> Result<T, Failure> {
    usable(pointer, name)?;
    // SAFETY: not null, aligned, and a `Def` starts with its size.
    let size = unsafe { pointer.cast::<u32>().read() };
    let (made_by, default) = T::DEFAULT;
    if T::EARLIER.contains(&size) && (size as usize) < size_of::<T>() {
        let mut whole = default();
        // SAFETY: the caller vouches for the bytes, there are fewer than `whole` has, and every pattern of bytes is a value.
        unsafe { std::ptr::copy_nonoverlapping(pointer.cast::<u8>(), (&raw mut whole).cast::<u8>(), size as usize) };
        return Ok(whole);
    }
    if size as usize != size_of::<T>() {
        return Err(Failure::new(
            CrumpleResult::CrumpleErrorStructSize,
            format!("{name}.struct_size is {size}; it must be {}: start from {made_by}()", size_of::<T>()),
        ));
    }
    // SAFETY: the caller vouches for the bytes; every pattern of bytes is a value.
    Ok(unsafe { pointer.read() })
}

/// Where the def at `index` of an array begins. They lie as far apart as the first says that it is large.
///
/// # Safety
/// `first` is null or points to more than `index` defs; with `index` above 0, `def` took the first.
pub(super) unsafe fn nth_def<T: Def>(first: *const T, index: usize, name: &str) -> Result<*const T, Failure> {
    usable(first, name)?;
    // SAFETY: not null, aligned, and a `Def` starts with its size.
    let size = unsafe { first.cast::<u32>().read() } as usize;
    // SAFETY: the caller vouches for as many defs, of the size that was taken with the first.
    Ok(unsafe { first.byte_add(index * size) })
}

/// Reads a plain value.
///
/// # Safety
/// `pointer` is null or points to a readable `T`, of which every pattern of bytes is a value.
pub(super) unsafe fn read<T: bytemuck::AnyBitPattern>(pointer: *const T, name: &str) -> Result<T, Failure> {
    usable(pointer, name)?;
    // SAFETY: not null, aligned, and the caller vouches for the rest.
    Ok(unsafe { pointer.read() })
}

/// Reads an array of plain values. Null is an empty array where `count` is 0.
///
/// # Safety
/// `pointer` is null or points to `count` readable `T`, of which every pattern of bytes is a value,
/// unchanged for `'a`.
pub(super) unsafe fn array<'a, T>(pointer: *const T, count: usize, name: &str) -> Result<&'a [T], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    usable(pointer, name)?;
    if count > isize::MAX as usize / size_of::<T>().max(1) {
        return Err(Failure::invalid(format!("{name} has {count} elements, more than memory can hold")));
    }
    // SAFETY: not null, aligned, of a possible size, and the caller vouches for the rest.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// Reads a string; null is none.
///
/// # Safety
/// `pointer` is null or points to bytes that end with a zero, unchanged for `'a`.
pub(super) unsafe fn string<'a>(pointer: *const c_char, name: &str) -> Result<Option<&'a str>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: not null, and the caller vouches for the rest.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map(Some).map_err(|e| Failure::invalid(format!("{name} is not UTF-8 ({e})")))
}

/// Where an output goes; written once everything else succeeded.
#[must_use]
pub(super) struct Out<T>(*mut T);

impl<T> Out<T> {
    /// An output that must be there.
    ///
    /// # Safety
    /// `pointer` is null or points to a writable `T` until `write`.
    pub(super) unsafe fn new(pointer: *mut T, name: &str) -> Result<Self, Failure> {
        usable(pointer, name)?;
        Ok(Self(pointer))
    }

    /// An output that may be left out with null.
    ///
    /// # Safety
    /// As for `new`.
    pub(super) unsafe fn optional(pointer: *mut T, name: &str) -> Result<Self, Failure> {
        if !pointer.is_null() {
            usable(pointer, name)?;
        }
        Ok(Self(pointer))
    }

    pub(super) fn write(self, value: T) {
        if !self.0.is_null() {
            // SAFETY: checked by the constructors, whose caller vouched for the rest.
            unsafe { self.0.write(value) }
        }
    }
}

/// An array that the caller sized: nothing is written where it is null and its capacity 0 (the caller asks for the
/// count), and a capacity below the count is an error.
///
/// # Safety
/// `pointer` is null or points to `capacity` writable `T`.
pub(super) unsafe fn write_array<T: Copy>(
    values: &[T],
    pointer: *mut T,
    capacity: usize,
    name: &str,
) -> Result<(), Failure> {
    if pointer.is_null() && capacity == 0 || values.is_empty() {
        return Ok(());
    }
    usable(pointer, name)?;
    if capacity < values.len() {
        return Err(Failure::new(
            CrumpleResult::CrumpleErrorBufferTooSmall,
            format!("{name} has room for {capacity}; {} are needed (pass null and 0 to ask how many)", values.len()),
        ));
    }
    // SAFETY: not null, aligned, room for all of them, and `values` is this library's own memory.
    unsafe { std::ptr::copy_nonoverlapping(values.as_ptr(), pointer, values.len()) }
    Ok(())
}

/// Refuses NaN and infinities.
pub(super) fn finite<const N: usize>(value: [f32; N], name: &str) -> Result<[f32; N], Failure> {
    if value.iter().all(|x| x.is_finite()) {
        return Ok(value);
    }
    let value = if N == 1 { value[0].to_string() } else { format!("{value:?}") };
    Err(crate::Error::NotFinite { name: name.into(), value }.into())
}

/// A length, mass or threshold where 0 means "not given".
pub(super) fn positive_or_none(value: f32, name: &str, unit: &str) -> Result<Option<f32>, Failure> {
    finite([value], name)?;
    match value {
        0.0 => Ok(None),
        v if v > 0.0 => Ok(Some(v)),
        v => Err(Failure::invalid(format!("{name} is {v} {unit}; it must be above 0, or 0 for the default"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refused_length_is_not_said_to_turn_a_default_off() {
        // 0 is the default, which is not always "none": the depth limit's is the deepest example.
        assert_eq!(positive_or_none(0.0, "depth_limit", "m").ok(), Some(None));
        let failure = positive_or_none(-1.0, "depth_limit", "m").expect_err("a negative length");
        assert_eq!(failure.message, "depth_limit is -1 m; it must be above 0, or 0 for the default");
    }

    /// What a program was built against once.
    #[repr(C)]
    #[derive(Clone, Copy)]
    struct First {
        struct_size: u32,
        depth: f32,
    }

    /// The same def, grown twice since.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Today {
        struct_size: u32,
        depth: f32,
        lean: f32,
        width: f32,
        height: f32,
    }

    extern "C" fn default_today() -> Today {
        Today { struct_size: size_of::<Today>() as u32, depth: 1.0, lean: 2.0, width: 3.0, height: 4.0 }
    }

    // SAFETY: `repr(C)`, starts with its size, and any bytes are a value of it.
    unsafe impl Def for Today {
        const DEFAULT: MadeBy<Self> = ("crumple_today_def_default", default_today);
        const EARLIER: &'static [u32] = &[8, 12];
    }

    #[test]
    fn a_def_of_an_earlier_version_gets_the_defaults_of_what_it_lacks() {
        let old = [First { struct_size: 8, depth: 9.0 }, First { struct_size: 8, depth: 7.0 }];
        let first = old.as_ptr().cast::<Today>();
        let expected = |depth| Today { struct_size: 8, depth, ..default_today() };
        // SAFETY: two defs, each of the eight bytes that it says.
        unsafe {
            assert_eq!(def(first, "def").ok(), Some(expected(9.0)));
            let second = nth_def(first, 1, "defs").ok().unwrap();
            assert_eq!(def(second, "def").ok(), Some(expected(7.0)));
        }
    }

    #[test]
    fn a_def_of_this_version_is_taken_as_it_is() {
        let new = [Today { depth: 5.0, ..default_today() }, Today { height: 6.0, ..default_today() }];
        // SAFETY: two defs of today.
        unsafe {
            assert_eq!(def(&raw const new[0], "def").ok(), Some(new[0]));
            assert_eq!(def(nth_def(new.as_ptr(), 1, "defs").ok().unwrap(), "def").ok(), Some(new[1]));
        }
    }

    #[test]
    fn a_size_that_never_was_is_refused_by_name() {
        for size in [0, 4, 9, 16, 19, 21, 24, u32::MAX] {
            let wrong = Today { struct_size: size, ..default_today() };
            // SAFETY: no more than the size is read of a def whose size is refused.
            let failure = unsafe { def(&raw const wrong, "def") }.expect_err("a size that never was");
            assert_eq!(failure.result, CrumpleResult::CrumpleErrorStructSize);
            let says = format!("def.struct_size is {size}; it must be 20: start from crumple_today_def_default()");
            assert_eq!(failure.message, says);
        }
    }
}
