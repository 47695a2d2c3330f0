//! Elements at equal distances in memory that belongs to the caller. The one place where offsets, strides and sizes are checked.

use super::error::Error;
use std::ops::Range;

/// `count` elements of `element` bytes: the first at `first`, each next one `stride` bytes further.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Strided {
    /// An offset or an address, bytes.
    pub first: u64,
    pub stride: u64,
    pub element: u64,
    pub count: u64,
}

impl Strided {
    /// Fails where `value`, called `name`, is not a multiple of `align` bytes.
    pub(crate) fn check_aligned(name: String, value: u64, align: u64) -> Result<(), Error> {
        if value.is_multiple_of(align) { Ok(()) } else { Err(Error::Misaligned { name, value, align }) }
    }

    /// Fails where elements overlap their successors.
    pub(crate) fn check_stride(&self, name: &str) -> Result<(), Error> {
        if self.stride >= self.element {
            return Ok(());
        }
        let zero = if self.stride == 0 { "; 0 never means tightly packed" } else { "" };
        let expected = format!("at least the {} bytes of an element{zero}", self.element);
        Err(Error::invalid(name, format!("{} bytes", self.stride), &expected))
    }

    /// Fails where the elements do not fit into the `size` bytes that begin at 0.
    pub(crate) fn check_size(&self, name: &str, size: u64) -> Result<(), Error> {
        let needed = self.span().end;
        if needed <= size { Ok(()) } else { Err(Error::BufferTooSmall { name: name.into(), size, needed }) }
    }

    /// From the first byte to the one behind the last; what does not fit 64 bits is held at their end.
    pub(crate) fn span(&self) -> Range<u64> {
        match self.count {
            0 => self.first..self.first,
            n => {
                self.first..(n - 1).saturating_mul(self.stride).saturating_add(self.first).saturating_add(self.element)
            }
        }
    }

    /// Whether a byte belongs to elements of both. Interleaved arrays (of one stride) are told exactly; others overlap where
    /// their spans do.
    pub(crate) fn overlaps(&self, other: &Strided) -> bool {
        let (a, b) = (self.span(), other.span());
        if a.end <= b.start || b.end <= a.start {
            return false;
        }
        if self.stride != other.stride || self.stride == 0 {
            return true;
        }
        // Within one stride: where the other's elements begin behind this one's.
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
