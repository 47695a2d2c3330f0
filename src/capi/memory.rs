//! The caller's arrays, checked before a byte is touched: pointers, alignment, strides, sizes.

use super::result::{CrumpleResult, Failure};
use super::types::CrumpleStream;
use crate::base::error::reserve;
use crate::base::strided::Strided;
use std::ffi::c_void;

/// An array that Crumple reads during the call. Element i is at data + i * stride. The field that uses it states count
/// and type. All fields zero: absent.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleInput {
    /// First element, aligned to its type (4 bytes; 2 for 16-bit indices). Null: absent.
    pub data: *const c_void,
    /// Readable bytes at data: at least (count - 1) * stride + the size of one element.
    pub size: usize,
    /// Bytes from one element to the next: at least the size of one element, a multiple of its alignment. Not 0.
    pub stride: usize,
}

/// Where the elements of an array lie: by address. Checks that `count` elements of `element` bytes fit into `size` bytes at
/// `data + offset`.
fn checked(
    (data, size, offset, stride): (usize, usize, usize, usize),
    (element, align, count): (usize, usize, usize),
    name: &str,
) -> Result<Strided, Failure> {
    for (what, value) in [("data", data), ("offset", offset), ("stride", stride)] {
        Strided::check_aligned(format_args!("{name}.{what}"), value as u64, align as u64)?;
    }
    let at = |first: usize| Strided {
        first: first as u64,
        stride: stride as u64,
        element: element as u64,
        count: count as u64,
    };
    at(offset).check_stride(format_args!("{name}.stride"))?;
    at(offset).check_size(name, size as u64)?;
    if size > isize::MAX as usize || data.checked_add(size).is_none() {
        return Err(Failure::invalid(format!("{name}.size is {size} bytes, which reaches past the end of memory")));
    }
    Ok(at(data + offset))
}

fn absent(is_null: bool, size: usize, name: &str) -> Result<bool, Failure> {
    if is_null && size != 0 {
        return Err(Failure::new(
            CrumpleResult::CrumpleErrorNullPointer,
            format!("{name}.data is null but {name}.size is {size} bytes"),
        ));
    }
    Ok(is_null)
}

/// An element that may be read from a caller's array.
pub(super) trait Element: bytemuck::AnyBitPattern {}
impl Element for u16 {}
impl Element for u32 {}
impl Element for f32 {}
impl Element for [f32; 3] {}
impl Element for [f32; 4] {}

/// Copies `count` elements out of a caller's array; nothing where it is absent.
///
/// # Safety
/// `input.data` is null or points to `input.size` readable bytes.
pub(super) unsafe fn read<T: Element>(
    input: CrumpleInput,
    count: usize,
    name: &str,
) -> Result<Option<Vec<T>>, Failure> {
    if absent(input.data.is_null(), input.size, name)? {
        return Ok(None);
    }
    let place = (input.data.addr(), input.size, 0, input.stride);
    checked(place, (size_of::<T>(), align_of::<T>(), count), name)?;
    let mut values = reserve(count, name)?;
    for i in 0..count {
        // SAFETY: aligned and inside the `size` bytes that the caller vouches for, as `checked` found.
        values.push(unsafe { input.data.byte_add(i * input.stride).cast::<T>().read() });
    }
    Ok(Some(values))
}

/// The same as `read`, for an array that must be there.
///
/// # Safety
/// As for `read`.
pub(super) unsafe fn read_required<T: Element>(
    input: CrumpleInput,
    count: usize,
    name: &str,
) -> Result<Vec<T>, Failure> {
    read(input, count, name)?
        .ok_or_else(|| Failure::new(CrumpleResult::CrumpleErrorNullPointer, format!("{name}.data is null")))
}

/// An output array that was checked.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stream {
    pub(super) data: *mut u8,
    pub(super) layout: Strided,
}

// SAFETY: a pointer to the caller's memory, which the header asks to be reachable from every thread that runs tasks;
// what may write to it when is decided by who holds the `Stream`.
unsafe impl Send for Stream {}
// SAFETY: as above.
unsafe impl Sync for Stream {}

impl Stream {
    /// Checks that `count` elements of `element` bytes fit; nothing where the stream is absent.
    pub(super) fn new(
        stream: CrumpleStream,
        element: usize,
        count: usize,
        name: &str,
    ) -> Result<Option<Self>, Failure> {
        if absent(stream.data.is_null(), stream.size, name)? {
            return Ok(None);
        }
        let place = (stream.data.addr(), stream.size, stream.offset, stream.stride);
        let layout = checked(place, (element, 4, count), name)?;
        Ok(Some(Self { data: stream.data.cast::<u8>().wrapping_add(stream.offset), layout }))
    }

    /// Writes all elements.
    ///
    /// # Safety
    /// The memory that was checked is still writable, and nobody else touches the elements.
    pub(super) unsafe fn write<T: bytemuck::Pod>(&self, values: &[T]) {
        assert!(values.len() as u64 == self.layout.count && size_of::<T>() as u64 == self.layout.element);
        for (i, &value) in values.iter().enumerate() {
            // SAFETY: inside the memory, as `new` checked; the caller vouches for the rest.
            unsafe { self.data.add(i * self.layout.stride as usize).cast::<T>().write_unaligned(value) }
        }
    }
}

/// Refuses output arrays that share bytes.
pub(super) fn disjoint(streams: &[(&str, Option<Stream>)]) -> Result<(), Failure> {
    for (i, (a, x)) in streams.iter().enumerate() {
        for (b, y) in &streams[..i] {
            if let (Some(x), Some(y)) = (x, y)
                && x.layout.overlaps(&y.layout)
            {
                return Err(Failure::invalid(format!(
                    "{a} and {b} overlap; each must have bytes of its own (interleaved arrays need one stride and offsets apart)"
                )));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_do_not_overflow() {
        let max = usize::MAX & !3;
        assert!(checked((4096, 100, 0, max), (12, 4, 3), "x").is_err());
        assert!(checked((4096, max, 0, 12), (12, 4, 1), "x").is_err());
        assert!(checked((4096, 100, max, 12), (12, 4, 1), "x").is_err());
        assert!(checked((4096, 36, 0, 12), (12, 4, 3), "x").is_ok());
        assert!(checked((4096, 35, 0, 12), (12, 4, 3), "x").is_err());
        assert!(checked((4098, 36, 0, 12), (12, 4, 3), "x").is_err());
    }
}
