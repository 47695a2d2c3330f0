//! The checks of what C hands over: pointers, defs, enumerators, strings, scalars.

use super::c_enum::{CEnum, number};
use super::result::{CrumpleResult, Failure};
use crate::base::error::Error;
use crate::base::strided::Strided;
use std::ffi::{CStr, c_char};
use std::mem::MaybeUninit;

/// Reads an enumerator.
pub(super) fn enumerator<E: CEnum>(value: MaybeUninit<E>, name: &str) -> Result<E, Failure> {
    match number(value) {
        // SAFETY: an enumerator, as the trait promises.
        n if n <= E::LAST => Ok(unsafe { value.assume_init() }),
        n => Err(Failure::invalid(format!("{name} is {n}; it must be an enumerator, 0 to {}", E::LAST))),
    }
}

/// Reads a C `bool`: anything but zero is true.
pub(super) fn boolean(value: MaybeUninit<bool>) -> bool {
    // SAFETY: one byte, which C initialised when it passed the value.
    unsafe { (&raw const value).cast::<u8>().read() != 0 }
}

/// Checks that a pointer may be read or written as a `T`.
pub(super) fn usable<T>(pointer: *const T, name: &str) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::null(name));
    }
    Ok(Strided::check_aligned(name, pointer.addr() as u64, align_of::<T>() as u64)?)
}

/// A struct that starts with its size.
///
/// # Safety
/// The type is `repr(C)`, starts with a `u32` that is its size, and every pattern of bytes, zeros too, is a value of it.
pub(super) unsafe trait Def: Copy {}

/// Declares defs.
macro_rules! defs {
    ($($name:ident),* $(,)?) => {$(
        // SAFETY: `repr(C)`, starts with its size, and any bytes are a value of it.
        unsafe impl $crate::capi::check::Def for $name {}
    )*};
}
pub(super) use defs;

/// A def with its size and zero everywhere else: absent arrays, null pointers, first enumerators.
pub(super) fn zeroed<T: Def>() -> T {
    let mut def = MaybeUninit::<T>::zeroed();
    // SAFETY: a `Def` starts with its size, and any bytes are a value of it.
    unsafe {
        def.as_mut_ptr().cast::<u32>().write(size_of::<T>() as u32);
        def.assume_init()
    }
}

/// Copies a def after checking its size.
pub(super) unsafe fn def<T: Def>(pointer: *const T, name: &str) -> Result<T, Failure> {
    usable(pointer, name)?;
    let size = pointer.cast::<u32>().read();
    if size as usize == size_of::<T>() {
        return Ok(pointer.read());
    }
    let (must, made_by) = (size_of::<T>(), default_function::<T>());
    let message = format!("{name}.struct_size is {size}; it must be {must}: start from {made_by}()");
    Err(Failure::new(CrumpleResult::CrumpleErrorStructSize, message))
}

/// The C function that makes a def: `crumple_mesh_def_default` for `CrumpleMeshDef`.
fn default_function<T>() -> String {
    let mut name = String::new();
    for character in std::any::type_name::<T>().rsplit("::").next().unwrap_or_default().chars() {
        if character.is_uppercase() && !name.is_empty() {
            name.push('_');
        }
        name.extend(character.to_lowercase());
    }
    name + "_default"
}

/// Reads a plain value.
pub(super) unsafe fn read<T: bytemuck::AnyBitPattern>(pointer: *const T, name: &str) -> Result<T, Failure> {
    usable(pointer, name)?;
    Ok(pointer.read())
}

/// Reads an array of plain values. Null is an empty array where `count` is 0.
pub(super) unsafe fn array<'a, T>(pointer: *const T, count: usize, name: &str) -> Result<&'a [T], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    usable(pointer, name)?;
    if count > isize::MAX as usize / size_of::<T>().max(1) {
        return Err(Failure::invalid(format!("{name} has {count} elements, more than memory can hold")));
    }
    Ok(std::slice::from_raw_parts(pointer, count))
}

/// Reads a string; null is none.
pub(super) unsafe fn string<'a>(pointer: *const c_char, name: &str) -> Result<Option<&'a str>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    let text = CStr::from_ptr(pointer).to_str();
    text.map(Some).map_err(|e| Failure::invalid(format!("{name} is not UTF-8 ({e})")))
}

/// Reads a string that must be there.
pub(super) unsafe fn required_string<'a>(pointer: *const c_char, name: &str) -> Result<&'a str, Failure> {
    string(pointer, name)?.ok_or_else(|| Failure::null(name))
}

/// Where an output goes; written once everything else succeeded.
#[must_use]
pub(super) struct Out<T>(*mut T);

impl<T> Out<T> {
    /// An output that must be there.
    pub(super) unsafe fn new(pointer: *mut T, name: &str) -> Result<Self, Failure> {
        usable(pointer, name)?;
        Ok(Self(pointer))
    }

    /// An output that may be left out with null.
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

    /// Writes what a call ends with.
    pub(super) fn answer(self, value: T) -> Result<(), Failure> {
        self.write(value);
        Ok(())
    }
}

/// Writes an array into memory that the caller sized, and its count, the latter also where the memory is too small. Null with
/// capacity 0 asks for the count alone.
pub(super) unsafe fn write_array<T: Copy, N: TryFrom<usize>>(
    values: &[T],
    pointer: *mut T,
    capacity: usize,
    name: &str,
    count: Out<N>,
) -> Result<(), Failure> {
    let needed = values.len();
    let asks = pointer.is_null() && capacity == 0;
    if !asks && needed > 0 {
        usable(pointer, name)?;
    }
    if let Ok(needed) = N::try_from(needed) {
        count.write(needed);
    }
    if asks || needed == 0 {
        return Ok(());
    }
    if capacity < needed {
        let message = format!("{name} has room for {capacity}; {needed} are needed (pass null and 0 to ask how many)");
        return Err(Failure::new(CrumpleResult::CrumpleErrorBufferTooSmall, message));
    }
    std::ptr::copy_nonoverlapping(values.as_ptr(), pointer, needed);
    Ok(())
}

/// The element with an index from C.
pub(super) fn item<'a, T>(items: &'a [T], index: u32, name: &str) -> Result<&'a T, Failure> {
    let (index, len) = (u64::from(index), items.len() as u64);
    items.get(index as usize).ok_or_else(|| Error::IndexOutOfRange { name: name.into(), index, len }.into())
}

/// Refuses NaN and infinities.
pub(super) fn finite<const N: usize>(value: [f32; N], name: &str) -> Result<[f32; N], Failure> {
    if value.iter().all(|x| x.is_finite()) {
        return Ok(value);
    }
    let value = if N == 1 { value[0].to_string() } else { format!("{value:?}") };
    Err(Error::NotFinite { name: name.into(), value }.into())
}

/// A length or mass in `unit`; 0 stands for `zero`.
pub(super) fn positive_or(value: f32, name: &str, unit: &str, zero: &str) -> Result<Option<f32>, Failure> {
    finite([value], name)?;
    match value {
        0.0 => Ok(None),
        v if v > 0.0 => Ok(Some(v)),
        v => Err(Failure::invalid(format!("{name} is {v} {unit}; it must be positive, or 0 for {zero}"))),
    }
}
