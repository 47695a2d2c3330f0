//! Meshes on the device. Each set and level of detail is uploaded once, into a few large buffers.

use super::limits::BindingLimits;
use super::mesh::{MeshPlacement, MeshWords};
use crate::base::error::Error;
use crate::example::set::ExampleSet;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Weak};

/// Bytes of the first chunk. Each further chunk is twice as large, up to `LARGEST`.
const FIRST: u64 = 16 << 20;
/// A mesh that needs more than this has a chunk of its own.
const LARGEST: u64 = 128 << 20;

/// Decides where meshes lie in the backend's buffers `B`. Chunks never grow or move.
#[derive(Debug)]
pub(crate) struct Arena<B> {
    chunks: Vec<Chunk<B>>,
    meshes: Vec<Arc<ResidentMesh>>,
    /// The id of the last chunk.
    last_id: u32,
}

#[derive(Debug)]
struct Chunk<B> {
    id: u32,
    buffer: B,
    words: u64,
    used: u64,
}

/// A mesh on the device.
#[derive(Debug)]
pub(crate) struct ResidentMesh {
    set: Weak<ExampleSet>,
    lod: usize,
    pub place: MeshPlacement,
    /// Id of the chunk that holds it.
    pub chunk: u32,
    /// The last frame that reads it, on backends that number frames.
    last_frame: AtomicU64,
}

/// Words to copy into a chunk.
pub(crate) struct Upload<'a> {
    set: &'a ExampleSet,
    lod: usize,
    mesh: &'a MeshWords,
    /// The first word in the chunk.
    pub at: u32,
    pub words: u64,
}

impl Upload<'_> {
    /// Writes the words into memory of that size.
    pub(crate) fn write(&self, to: &mut [u32]) -> Result<(), Error> {
        self.mesh.write(self.set.lod(self.lod)?, to);
        Ok(())
    }
}

impl ResidentMesh {
    /// Notes that a frame reads the mesh.
    #[cfg(feature = "vulkan")]
    pub(crate) fn used_in(&self, frame: u64) {
        self.last_frame.fetch_max(frame, Ordering::Relaxed);
    }
}

impl<B> Arena<B> {
    pub(crate) fn new() -> Self {
        Arena { chunks: Vec::new(), meshes: Vec::new(), last_id: 0 }
    }

    /// Returns a mesh of the set. If it is not on the device yet, `upload` has it copied into the chunk's buffer, and `make`
    /// makes a buffer of a given size in bytes if no chunk has room.
    pub(crate) fn mesh(
        &mut self,
        (set, lod): (&Arc<ExampleSet>, usize),
        limits: &BindingLimits,
        make: impl FnOnce(u64) -> Result<B, Error>,
        upload: impl FnOnce(&B, &Upload<'_>) -> Result<(), Error>,
    ) -> Result<Arc<ResidentMesh>, Error> {
        let same = |w: &Weak<ExampleSet>| std::ptr::eq(w.as_ptr(), Arc::as_ptr(set));
        if let Some(mesh) = self.meshes.iter().find(|m| same(&m.set) && m.lod == lod) {
            return Ok(mesh.clone());
        }
        let words = MeshWords::new(set.lod(lod)?);
        let index = match self.chunks.iter().position(|c| c.words - c.used >= words.total()) {
            Some(index) => index,
            None => self.add_chunk(words.total(), limits, make)?,
        };
        let chunk = &mut self.chunks[index];
        let at = chunk.used as u32;
        upload(&chunk.buffer, &Upload { set, lod, mesh: &words, at, words: words.total() })?;
        chunk.used += words.total();
        let place = MeshPlacement { mesh: words, at };
        let (set, chunk) = (Arc::downgrade(set), chunk.id);
        let mesh = Arc::new(ResidentMesh { set, lod, place, chunk, last_frame: AtomicU64::new(0) });
        self.meshes.push(mesh.clone());
        Ok(mesh)
    }

    fn add_chunk(
        &mut self,
        words: u64,
        limits: &BindingLimits,
        make: impl FnOnce(u64) -> Result<B, Error>,
    ) -> Result<usize, Error> {
        let bytes = 4 * words;
        limits.check("a mesh and its examples", bytes)?;
        let size = (FIRST << self.chunks.len().min(8)).min(LARGEST).min(limits.bytes).max(bytes);
        let buffer = make(size)?;
        self.last_id += 1;
        self.chunks.push(Chunk { id: self.last_id, buffer, words: size / 4, used: 0 });
        Ok(self.chunks.len() - 1)
    }

    /// The buffer of the chunk that holds a resident mesh.
    pub(crate) fn buffer(&self, chunk: u32) -> &B {
        let chunk = self.chunks.iter().find(|c| c.id == chunk);
        &chunk.expect("a chunk stays as long as any mesh in it").buffer
    }

    /// Forgets meshes that no target shows and no frame above `done` reads. Calls `freed` with each chunk that is empty then.
    pub(crate) fn collect(&mut self, done: u64, mut freed: impl FnMut(u32, &B)) {
        self.meshes.retain(|m| Arc::strong_count(m) > 1 || m.last_frame.load(Ordering::Relaxed) > done);
        self.chunks.retain(|c| {
            let kept = self.meshes.iter().any(|m| m.chunk == c.id);
            if !kept {
                freed(c.id, &c.buffer);
            }
            kept
        });
    }

    /// All buffers.
    #[cfg(feature = "vulkan")]
    pub(crate) fn buffers(&self) -> impl Iterator<Item = &B> {
        self.chunks.iter().map(|c| &c.buffer)
    }
}
