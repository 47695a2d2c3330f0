//! Arrays of plain data that are either owned or lie in the bytes of a baked file, which is never copied.

use bytemuck::Pod;
use std::fmt;
use std::ops::{Deref, Range};
use std::sync::Arc;

/// The bytes of a baked file, kept as long as anything lies in them.
pub(crate) type Bytes = Arc<dyn AsRef<[u8]> + Send + Sync>;

/// A read-only array.
pub(crate) enum Array<T: Pod> {
    Owned(Vec<T>),
    /// A range of a file's bytes: aligned for `T`, a multiple of its size, as [`Array::within`] checked.
    Within(Bytes, Range<usize>),
}

impl<T: Pod> Array<T> {
    /// The elements at `range` (bytes) of a file; `None` where it does not lie in the file, or not aligned, or where the last
    /// element is cut short.
    pub(crate) fn within(bytes: &Bytes, range: Range<usize>) -> Option<Self> {
        let data = bytes.as_ref().as_ref().get(range.clone())?;
        bytemuck::try_cast_slice::<u8, T>(data).ok()?;
        Some(Array::Within(bytes.clone(), range))
    }

    /// Bytes of its elements.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val::<[T]>(self)
    }
}

impl<T: Pod> Deref for Array<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        match self {
            Array::Owned(v) => v,
            Array::Within(bytes, range) => bytemuck::cast_slice(&bytes.as_ref().as_ref()[range.clone()]),
        }
    }
}

impl<T: Pod> Default for Array<T> {
    fn default() -> Self {
        Array::Owned(Vec::new())
    }
}

impl<T: Pod> From<Vec<T>> for Array<T> {
    fn from(v: Vec<T>) -> Self {
        Array::Owned(v)
    }
}

impl<T: Pod> Clone for Array<T> {
    fn clone(&self) -> Self {
        match self {
            Array::Owned(v) => Array::Owned(v.clone()),
            Array::Within(b, r) => Array::Within(b.clone(), r.clone()),
        }
    }
}

impl<T: Pod> fmt::Debug for Array<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} × {}", self.len(), std::any::type_name::<T>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_whole_aligned_elements_inside_the_file_are_taken() {
        let words: Vec<u64> = vec![1, 2, 3];
        let bytes: Bytes = Arc::new(bytemuck::cast_slice::<u64, u8>(&words).to_vec());
        let base = bytes.as_ref().as_ref().as_ptr() as usize % 4;
        let at = (4 - base) % 4;
        let a = Array::<u32>::within(&bytes, at..at + 8).unwrap();
        assert_eq!(a.len(), 2);
        assert!(Array::<u32>::within(&bytes, at..at + 7).is_none());
        assert!(Array::<u32>::within(&bytes, at + 1..at + 9).is_none());
        assert!(Array::<u32>::within(&bytes, at..at + 400).is_none());
        assert!(Array::<u8>::within(&bytes, 24..23).is_none());
    }
}
