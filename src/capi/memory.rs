//! The caller's arrays, checked before a byte is touched: pointers, alignment, strides, sizes.

use super::check::misaligned;
use super::result::{CrumpleResult, Failure};
use super::types::{CrumpleInput, CrumpleStream};
use crate::base::error::reserve;

/// Where the elements of an array lie.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    /// Address of the first element.
    pub(super) first: usize,
    /// Bytes from one to the next.
    pub(super) stride: usize,
    /// Bytes of one.
    pub(super) element: usize,
    /// How many.
    pub(super) count: usize,
}

impl Layout {
    /// Checks that `count` elements of `element` bytes fit into `size` bytes at `data + offset`.
    fn new(
        (data, size, offset, stride): (usize, usize, usize, usize),
        (element, align, count): (usize, usize, usize),
        name: &str,
    ) -> Result<Self, Failure> {
        for (what, value) in [("data", data), ("offset", offset), ("stride", stride)] {
            if !value.is_multiple_of(align) {
                return Err(misaligned(&format!("{name}.{what}"), value as u64, align as u64));
            }
        }
        if stride < element {
            let zero = if stride == 0 { "; 0 never means tightly packed" } else { "" };
            return Err(Failure::invalid(format!(
                "{name}.stride is {stride} bytes; it must be at least the {element} bytes of an element{zero}"
            )));
        }
        let needed = match count {
            0 => offset as u128,
            _ => offset as u128 + (count as u128 - 1) * stride as u128 + element as u128,
        };
        if needed > size as u128 {
            let needed = u64::try_from(needed).unwrap_or(u64::MAX);
            return Err(crate::Error::BufferTooSmall { name: name.into(), size: size as u64, needed }.into());
        }
        if size > isize::MAX as usize || data.checked_add(size).is_none() {
            return Err(Failure::invalid(format!("{name}.size is {size} bytes, which reaches past the end of memory")));
        }
        Ok(Self { first: data + offset, stride, element, count })
    }

    /// First byte, and the one past the last.
    pub(super) fn span(&self) -> std::ops::Range<usize> {
        match self.count {
            0 => self.first..self.first,
            n => self.first..self.first + (n - 1) * self.stride + self.element,
        }
    }

    /// Whether a byte belongs to elements of both. Interleaved arrays (same stride) are told exactly; others count as
    /// overlapping where their spans do.
    pub(super) fn overlaps(&self, other: &Layout) -> bool {
        let (a, b) = (self.span(), other.span());
        if a.end <= b.start || b.end <= a.start {
            return false;
        }
        if self.stride != other.stride {
            return true;
        }
        // Within one period, where the other's elements begin after this one's.
        let after = (other.first as isize).wrapping_sub(self.first as isize).rem_euclid(self.stride as isize) as usize;
        after < self.element || after + other.element > self.stride
    }
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
    Layout::new(place, (size_of::<T>(), align_of::<T>(), count), name)?;
    let mut values = reserve(count, name)?;
    for i in 0..count {
        // SAFETY: aligned and inside the `size` bytes that the caller vouches for, as `Layout::new` checked.
        values.push(unsafe { input.data.byte_add(i * input.stride).cast::<T>().read() });
    }
    Ok(Some(values))
}

/// The same, for an array that must be there.
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
    pub(super) layout: Layout,
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
        let layout = Layout::new(place, (element, 4, count), name)?;
        Ok(Some(Self { data: stream.data.cast::<u8>().wrapping_add(stream.offset), layout }))
    }

    /// Writes all elements.
    ///
    /// # Safety
    /// The memory that was checked is still writable, and nobody else touches the elements.
    pub(super) unsafe fn write<T: bytemuck::Pod>(&self, values: &[T]) {
        assert!(values.len() == self.layout.count && size_of::<T>() == self.layout.element);
        for (i, &value) in values.iter().enumerate() {
            // SAFETY: inside the memory, as `new` checked; the caller vouches for the rest.
            unsafe { self.data.add(i * self.layout.stride).cast::<T>().write_unaligned(value) }
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

    fn layout(first: usize, stride: usize, element: usize, count: usize) -> Layout {
        Layout { first, stride, element, count }
    }

    #[test]
    fn overlap_is_exact_for_interleaved_arrays() {
        let position = layout(4096, 32, 12, 100);
        assert!(!position.overlaps(&layout(4096 + 12, 32, 12, 100)));
        assert!(!layout(4096 + 12, 32, 12, 100).overlaps(&position));
        assert!(position.overlaps(&layout(4096 + 8, 32, 12, 100)));
        assert!(position.overlaps(&layout(4096 + 24, 32, 12, 100)));
        assert!(!position.overlaps(&layout(4096 + 20, 32, 12, 100)));
        assert!(position.overlaps(&layout(4096, 32, 12, 1)));
        assert!(position.overlaps(&layout(4096 + 64, 16, 12, 2)));
        assert!(!position.overlaps(&layout(4096 + 3200, 16, 12, 2)));
    }

    #[test]
    fn sizes_do_not_overflow() {
        let max = usize::MAX & !3;
        assert!(Layout::new((4096, 100, 0, max), (12, 4, 3), "x").is_err());
        assert!(Layout::new((4096, max, 0, 12), (12, 4, 1), "x").is_err());
        assert!(Layout::new((4096, 100, max, 12), (12, 4, 1), "x").is_err());
        assert!(Layout::new((4096, 36, 0, 12), (12, 4, 3), "x").is_ok());
        assert!(Layout::new((4096, 35, 0, 12), (12, 4, 3), "x").is_err());
        assert!(Layout::new((4098, 36, 0, 12), (12, 4, 3), "x").is_err());
    }
}
