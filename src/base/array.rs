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
    Within(Within<T>),
}

/// A part of a file's bytes: aligned for `T` and a multiple of its size, as [`Array::within`] checked.
///
/// It refers to the slice that `as_ref` gave when the file was checked, and never asks again: an `as_ref` that answers
/// differently the next time changes nothing here.
pub(crate) struct Within<T: 'static> {
    data: &'static [T],
    owner: Bytes,
}

impl<T: Pod> Array<T> {
    /// The elements at `range` (bytes) of a file; `None` where it does not lie in the file, or not aligned, or where the last
    /// element is cut short.
    pub(crate) fn within(file: &FileBytes, range: Range<usize>) -> Option<Self> {
        let data = bytemuck::try_cast_slice::<u8, T>(file.data.get(range)?).ok()?;
        Some(Array::Within(Within { data, owner: file.owner.clone() }))
    }

    /// Bytes of its elements.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val::<[T]>(self)
    }
}

/// A file's bytes, borrowed once from what holds them.
#[derive(Clone)]
pub(crate) struct FileBytes {
    /// Not to be handed out without the owner: it lives no longer.
    data: &'static [u8],
    owner: Bytes,
}

impl FileBytes {
    pub(crate) fn new(owner: Bytes) -> Self {
        let data: &[u8] = owner.as_ref().as_ref();
        // SAFETY: the slice is borrowed from what the `Arc` holds, which is neither moved nor changed nor dropped while the
        // clone of the `Arc` that is kept beside every copy of the slice lives: nobody gets it mutably, since this is where
        // the `Arc` came to be or it was shared already.
        let data: &'static [u8] = unsafe { std::slice::from_raw_parts(data.as_ptr(), data.len()) };
        FileBytes { data, owner }
    }

    pub(crate) fn as_slice(&self) -> &[u8] {
        self.data
    }
}

impl<T: Pod> Deref for Array<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        match self {
            Array::Owned(v) => v,
            Array::Within(w) => w.data,
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
            Array::Within(w) => Array::Within(Within { data: w.data, owner: w.owner.clone() }),
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
        let file = FileBytes::new(Arc::new(bytemuck::cast_slice::<u64, u8>(&words).to_vec()));
        let base = file.as_slice().as_ptr() as usize % 4;
        let at = (4 - base) % 4;
        let a = Array::<u32>::within(&file, at..at + 8).unwrap();
        assert_eq!(a.len(), 2);
        assert!(Array::<u32>::within(&file, at..at + 7).is_none());
        assert!(Array::<u32>::within(&file, at + 1..at + 9).is_none());
        assert!(Array::<u32>::within(&file, at..at + 400).is_none());
        #[allow(clippy::reversed_empty_ranges)]
        let reversed = 24..23;
        assert!(Array::<u8>::within(&file, reversed).is_none());
    }

    #[test]
    fn arrays_outlive_everything_else_of_the_file() {
        let file = FileBytes::new(Arc::new(vec![7u8; 64]));
        let a = Array::<u8>::within(&file, 8..16).unwrap();
        let b = a.clone();
        drop((file, a));
        assert_eq!(*b, [7; 8]);
    }
}
