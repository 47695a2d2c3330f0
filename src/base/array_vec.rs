//! A list of at most `N` elements stored inline, so that selection does not allocate.

use std::ops::Deref;

#[derive(Debug, Clone, Copy)]
pub(crate) struct ArrayVec<T, const N: usize> {
    items: [T; N],
    len: usize,
}

impl<T: Copy + Default, const N: usize> ArrayVec<T, N> {
    pub(crate) fn new() -> Self {
        ArrayVec { items: [T::default(); N], len: 0 }
    }

    /// Inserts an element at `at`. If the list was full, its last element is dropped.
    pub(crate) fn insert(&mut self, at: usize, item: T) {
        if at < N {
            self.len = (self.len + 1).min(N);
            // Faster than a call to `memmove` for so few elements.
            for i in (at + 1..self.len).rev() {
                self.items[i] = self.items[i - 1];
            }
            self.items[at] = item;
        }
    }
}

impl<T, const N: usize> Deref for ArrayVec<T, N> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        &self.items[..self.len]
    }
}
