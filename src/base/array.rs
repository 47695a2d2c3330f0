//! Arrays of plain data that are either owned or borrowed from the bytes of a baked file. The file is never copied.

use bytemuck::Pod;
use std::fmt;
use std::ops::{Deref, Range};
use std::sync::Arc;

/// The bytes of a baked file. Every array that borrows from them keeps a reference.
pub(crate) type Bytes = Arc<dyn AsRef<[u8]> + Send + Sync>;

/// A read-only array.
pub(crate) enum Array<T: Pod> {
    Owned(Vec<T>),
    Within(Within<T>),
}

/// Part of a file's bytes. [`Array::within`] checked that it is aligned for `T` and that its length is a multiple of
/// the size of `T`.
///
/// It keeps the slice that `as_ref` returned when the file was checked and never calls `as_ref` again. An `as_ref` that
/// returns another slice later has no effect.
pub(crate) struct Within<T: 'static> {
    data: &'static [T],
    owner: Bytes,
}

impl<T: Pod> Array<T> {
    /// Returns the elements at `range` (bytes) of a file. `None` if the range is not inside the file, is not aligned
    /// for `T`, or is not a whole number of elements.
    pub(crate) fn within(file: &FileBytes, range: Range<usize>) -> Option<Self> {
        let data = bytemuck::try_cast_slice::<u8, T>(file.data.get(range)?).ok()?;
        Some(Array::Within(Within { data, owner: file.owner.clone() }))
    }

    /// Size of the elements, bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val::<[T]>(self)
    }
}

/// A file's bytes, borrowed once from their owner.
#[derive(Clone)]
pub(crate) struct FileBytes {
    /// Valid only while `owner` lives, so it must not be handed out without it.
    data: &'static [u8],
    owner: Bytes,
}

impl FileBytes {
    pub(crate) fn new(owner: Bytes) -> Self {
        let data: &[u8] = owner.as_ref().as_ref();
        // SAFETY: the slice is borrowed from the value inside the `Arc`. Every copy of the slice is stored beside a
        // clone of the `Arc`. While that clone lives, the value is not moved, changed or dropped: nobody can get it
        // mutably, because the `Arc` was either created here or already shared.
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
