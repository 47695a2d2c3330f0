//! Baked sets: files with a prepared example set, so that loading rebuilds nothing.
//!
//! A file is a header, a table of sections, and the sections: plain little-endian arrays that are used in place.
//! docs/format.md describes every byte. [`layout`] defines the records, [`read`] finds the sections and verifies
//! the checksum, [`check`] checks the sections' content, [`load`] makes a set from them, and [`write`] writes a file.
//! Any file becomes either a set that keeps the library's promises or an error.

mod check;
mod layout;
mod load;
mod read;
mod write;

pub use layout::file_checksum;

use crate::base::array::FileBytes;
use crate::base::error::{Error, reserve};
use crate::base::tasks::TaskSystem;
use crate::example::set::ExampleSet;
use bytemuck::{Pod, Zeroable};
use layout::{ALIGN, IN_PLACE, MAGIC};
use std::path::Path;
use std::sync::Arc;

/// 64 bytes of a file, aligned.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Line([u8; ALIGN]);

/// An aligned copy of a file.
struct Aligned {
    lines: Vec<Line>,
    length: usize,
}

impl AsRef<[u8]> for Aligned {
    fn as_ref(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.lines)[..self.length]
    }
}

impl ExampleSet {
    /// Returns the set as the bytes of a `.crumple` file, from which [`ExampleSet::load`] makes the same set again. A
    /// set always gives the same bytes, also after it was saved and loaded.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn save(&self) -> Result<Vec<u8>, Error> {
        write::File::new(self).bytes()
    }

    /// Returns the size of what [`ExampleSet::save`] returns, bytes.
    pub fn saved_bytes(&self) -> usize {
        write::File::new(self).length()
    }

    /// Makes a set from the bytes of a `.crumple` file: a buffer, a `&'static [u8]`, or your memory map. The set keeps
    /// the bytes.
    ///
    /// Nothing is rebuilt. If the memory begins at a multiple of 16 bytes, the arrays are used in place. Otherwise one
    /// aligned copy is made, and `bytes` is dropped. The bytes must not change while the set or anything made from it
    /// is alive: ensure this if other processes may write to a mapped file.
    ///
    /// Everything is checked. The worst that a damaged or forged file can do is to give a valid set that its maker did
    /// not intend. `tasks` runs the checks.
    ///
    /// # Errors
    /// [`Error::Format`] naming what is wrong; [`Error::Unsupported`] for a file of another version;
    /// [`Error::OutOfMemory`].
    pub fn load<B>(bytes: B, tasks: &dyn TaskSystem) -> Result<Self, Error>
    where
        B: AsRef<[u8]> + Send + Sync + 'static,
    {
        let file = FileBytes::new(Arc::new(bytes));
        if !file.as_slice().as_ptr().addr().is_multiple_of(IN_PLACE) {
            return Self::load_copy(file.as_slice(), tasks);
        }
        load::set(&file, tasks)
    }

    /// Does what [`ExampleSet::load`] does, with a copy of the bytes.
    ///
    /// # Errors
    /// Those of [`ExampleSet::load`].
    pub fn load_copy(bytes: &[u8], tasks: &dyn TaskSystem) -> Result<Self, Error> {
        let length = bytes.len();
        let mut lines = reserve(length.div_ceil(ALIGN), "a baked set")?;
        lines.resize(length.div_ceil(ALIGN), Line([0; ALIGN]));
        bytemuck::cast_slice_mut(&mut lines)[..length].copy_from_slice(bytes);
        load::set(&FileBytes::new(Arc::new(Aligned { lines, length })), tasks)
    }

    /// Makes a set from a `.crumple` file, which is read into one allocation.
    ///
    /// # Errors
    /// [`Error::Io`], and those of [`ExampleSet::load`].
    pub fn load_file(path: impl AsRef<Path>, tasks: &dyn TaskSystem) -> Result<Self, Error> {
        let path = path.as_ref();
        let io = |e: std::io::Error| Error::Io { path: path.display().to_string(), message: e.to_string() };
        Self::load(std::fs::read(path).map_err(io)?, tasks)
    }

    /// Returns whether the bytes begin as a `.crumple` file does.
    pub fn is_saved(bytes: &[u8]) -> bool {
        bytes.starts_with(&MAGIC)
    }
}
