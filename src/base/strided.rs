//! Strided arrays in the caller's memory. Offsets, strides and sizes are checked only here.

use super::error::Error;
use std::fmt;
use std::ops::Range;

/// `count` elements of `element` bytes each. The first is at `first`; each next one is `stride` bytes further.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Strided {
    /// Offset or address of the first element, bytes.
    pub first: u64,
    pub stride: u64,
    pub element: u64,
    pub count: u64,
}

impl Strided {
    /// Fails if `value` is not a multiple of `align` bytes. The error calls it `name`.
    pub(crate) fn check_aligned(name: impl fmt::Display, value: u64, align: u64) -> Result<(), Error> {
        if value.is_multiple_of(align) {
            Ok(())
        } else {
            Err(Error::Misaligned { name: name.to_string(), value, align })
        }
    }

    /// Fails if consecutive elements overlap.
    pub(crate) fn check_stride(&self, name: impl fmt::Display) -> Result<(), Error> {
        if self.stride >= self.element {
            return Ok(());
        }
        let zero = if self.stride == 0 { "; 0 never means tightly packed" } else { "" };
        let expected = format!("at least the {} bytes of an element{zero}", self.element);
        Err(Error::invalid(&name.to_string(), format!("{} bytes", self.stride), &expected))
    }

    /// Fails if the elements do not fit into bytes `0..size`.
    pub(crate) fn check_size(&self, name: impl fmt::Display, size: u64) -> Result<(), Error> {
        let needed = self.span().end;
        if needed <= size { Ok(()) } else { Err(Error::BufferTooSmall { name: name.to_string(), size, needed }) }
    }

    /// The byte range from the first element to the end of the last. Saturates at `u64::MAX`.
    pub(crate) fn span(&self) -> Range<u64> {
        match self.count {
            0 => self.first..self.first,
            n => {
                self.first..(n - 1).saturating_mul(self.stride).saturating_add(self.first).saturating_add(self.element)
            }
        }
    }

    /// Whether elements of both arrays share a byte. Exact for interleaved arrays (equal strides). Other arrays count
    /// as overlapping if their spans overlap.
    pub(crate) fn overlaps(&self, other: &Strided) -> bool {
        let (a, b) = (self.span(), other.span());
        if a.end <= b.start || b.end <= a.start {
            return false;
        }
        if self.stride != other.stride || self.stride == 0 {
            return true;
        }
        // Offset, within one stride, from this array's elements to the other's.
        let gap = (other.first % self.stride + self.stride - self.first % self.stride) % self.stride;
        gap < self.element || gap + other.element > self.stride
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(first: u64, stride: u64, element: u64) -> Strided {
        Strided { first, stride, element, count: 10 }
    }

    #[test]
    fn interleaved_elements_are_told_apart_exactly() {
        let positions = at(0, 24, 12);
        for (other, overlap) in [
            (at(12, 24, 12), false),
            (at(36, 24, 12), false),
            (at(240, 12, 12), false),
            (at(8, 24, 12), true),
            (at(20, 24, 12), true),
            (at(12, 12, 12), true),
        ] {
            assert_eq!(positions.overlaps(&other), overlap, "{other:?}");
            assert_eq!(other.overlaps(&positions), overlap, "{other:?}");
        }
    }

    #[test]
    fn sizes_count_to_the_last_byte_and_never_wrap() {
        assert!(at(4, 24, 12).check_size("x", 4 + 9 * 24 + 12).is_ok());
        assert!(at(4, 24, 12).check_size("x", 4 + 9 * 24 + 11).is_err());
        assert!(at(u64::MAX - 3, 24, 12).check_size("x", u64::MAX - 1).is_err());
        assert!(Strided { count: 0, ..at(4, 24, 12) }.check_size("x", 4).is_ok());
    }
}
