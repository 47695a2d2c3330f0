//! Baked sets: a file that holds an example set made ready, so that loading it rebuilds nothing.
//!
//! A header, a table of sections, and the sections: plain little-endian arrays that are used where they lie. docs/format.md
//! tells every byte. [`layout`] has the records, [`read`] finds the sections, [`check`] looks at what is in them, [`load`] makes a set of them, [`write`]
//! is the way back. Whatever a file holds, it becomes a set that keeps the library's promises, or an error.

mod check;
mod layout;
mod load;
mod read;
mod write;

pub use layout::file_checksum;

use crate::base::array::FileBytes;
use crate::base::error::Error;
use crate::base::tasks::TaskSystem;
use crate::example::set::ExampleSet;
use bytemuck::{Pod, Zeroable};
use layout::{ALIGN, IN_PLACE, MAGIC, little_endian};
use std::io::{Read, Write};
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

impl Aligned {
    fn new(length: usize) -> Result<Self, Error> {
        let mut lines = crate::base::error::reserve(length.div_ceil(ALIGN), "a baked set")?;
        lines.resize(length.div_ceil(ALIGN), Line([0; ALIGN]));
        Ok(Aligned { lines, length })
    }

    fn as_mut(&mut self) -> &mut [u8] {
        &mut bytemuck::cast_slice_mut(&mut self.lines)[..self.length]
    }
}

impl AsRef<[u8]> for Aligned {
    fn as_ref(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.lines)[..self.length]
    }
}

impl ExampleSet {
    /// The set as the bytes of a `.crumple` file, from which [`ExampleSet::load`] makes the same set again. A set always
    /// gives the same bytes, and so does one that was loaded.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`]; [`Error::Unsupported`] on a big-endian processor.
    pub fn save(&self) -> Result<Vec<u8>, Error> {
        little_endian()?;
        let file = write::File::new(self);
        let mut out = crate::base::error::reserve(file.length(), "a baked set")?;
        // Into memory that is there nothing can fail.
        let _ = file.write(&mut out);
        Ok(out)
    }

    /// Writes what [`ExampleSet::save`] returns, without holding it in memory.
    ///
    /// # Errors
    /// Those of `out`; `Unsupported` on a big-endian processor.
    pub fn save_to(&self, out: &mut impl Write) -> std::io::Result<()> {
        little_endian().map_err(|e| std::io::Error::new(std::io::ErrorKind::Unsupported, e.to_string()))?;
        write::File::new(self).write(out)
    }

    /// Bytes of what [`ExampleSet::save`] returns.
    pub fn saved_bytes(&self) -> usize {
        write::File::new(self).length()
    }

    /// A set from the bytes of a `.crumple` file: a buffer, a `&'static [u8]`, or a memory map of yours, which the set keeps.
    ///
    /// Nothing is rebuilt, and the arrays are not copied but used where they lie, as long as the memory begins at a multiple
    /// of 16 bytes; otherwise one aligned copy is made, and `bytes` is let go. The bytes must not change while the set or
    /// anything made of it is alive: see to that where other processes may write to a mapped file.
    ///
    /// Everything is checked, so that no file, whatever is in it, does worse than a set that its maker did not mean. `tasks`
    /// runs the checks.
    ///
    /// # Errors
    /// [`Error::Format`] naming what is wrong; [`Error::Unsupported`] for a file of another version, and on a big-endian
    /// processor; [`Error::OutOfMemory`].
    pub fn load<B>(bytes: B, tasks: &dyn TaskSystem) -> Result<Self, Error>
    where
        B: AsRef<[u8]> + Send + Sync + 'static,
    {
        little_endian()?;
        let file = FileBytes::new(Arc::new(bytes));
        if !file.as_slice().as_ptr().addr().is_multiple_of(IN_PLACE) {
            return Self::load_copy(file.as_slice(), tasks);
        }
        load::set(&file, tasks)
    }

    /// [`ExampleSet::load`] from a copy of the bytes.
    ///
    /// # Errors
    /// Those of [`ExampleSet::load`].
    pub fn load_copy(bytes: &[u8], tasks: &dyn TaskSystem) -> Result<Self, Error> {
        little_endian()?;
        let mut copy = Aligned::new(bytes.len())?;
        copy.as_mut().copy_from_slice(bytes);
        load::set(&FileBytes::new(Arc::new(copy)), tasks)
    }

    /// A set from a `.crumple` file, which is read into one allocation.
    ///
    /// # Errors
    /// [`Error::Io`], and those of [`ExampleSet::load`].
    pub fn load_file(path: impl AsRef<Path>, tasks: &dyn TaskSystem) -> Result<Self, Error> {
        let path = path.as_ref();
        let io = |e: std::io::Error| Error::Io { path: path.display().to_string(), message: e.to_string() };
        let mut file = std::fs::File::open(path).map_err(io)?;
        let length = file.metadata().map_err(io)?.len();
        // A pipe or a device has no length to tell.
        if length == 0 {
            let mut all = Vec::new();
            file.read_to_end(&mut all).map_err(io)?;
            return Self::load(all, tasks);
        }
        let length = usize::try_from(length)
            .map_err(|_| Error::OutOfMemory { what: path.display().to_string(), bytes: length })?;
        let mut bytes = Aligned::new(length)?;
        file.read_exact(bytes.as_mut()).map_err(io)?;
        Self::load(bytes, tasks)
    }

    /// Whether bytes begin as a `.crumple` file does.
    pub fn is_saved(bytes: &[u8]) -> bool {
        bytes.starts_with(&MAGIC)
    }
}
