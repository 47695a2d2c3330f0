//! Meshes on the device. Each set and level of detail is uploaded once, into a few large buffers.

use super::limits::BindingLimits;
use super::mesh::MeshParts;
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
    pub set: Weak<ExampleSet>,
    pub lod: usize,
    pub parts: MeshParts,
    /// Id of the chunk that holds it, and its first word there.
    pub chunk: u32,
    pub at: u32,
    /// The last frame that reads it, on backends that number frames.
    last_frame: AtomicU64,
}

impl ResidentMesh {
    /// Whether it is a mesh of the set.
    pub(crate) fn is_of(&self, set: &Arc<ExampleSet>) -> bool {
        std::ptr::eq(self.set.as_ptr(), Arc::as_ptr(set))
    }

    /// Bytes from the start of the chunk to the mesh.
    pub(crate) fn offset(&self) -> u64 {
        4 * u64::from(self.at)
    }

    /// Notes that a frame reads the mesh.
    pub(crate) fn used_in(&self, frame: u64) {
        self.last_frame.fetch_max(frame, Ordering::Relaxed);
    }
}

impl<B> Arena<B> {
    pub(crate) fn new() -> Self {
        Arena { chunks: Vec::new(), meshes: Vec::new(), last_id: 0 }
    }

    /// Returns a mesh of the set. If it is not on the device yet, `upload` has its words copied into the chunk's buffer, and `make`
    /// makes a buffer of a given size in bytes if no chunk has room.
    pub(crate) fn mesh(
        &mut self,
        (set, lod): (&Arc<ExampleSet>, usize),
        limits: &BindingLimits,
        make: impl FnOnce(u64) -> Result<B, Error>,
        upload: impl FnOnce(&B, &Arc<ResidentMesh>, Vec<u32>) -> Result<(), Error>,
    ) -> Result<Arc<ResidentMesh>, Error> {
        if let Some(mesh) = self.meshes.iter().find(|m| m.is_of(set) && m.lod == lod) {
            return Ok(mesh.clone());
        }
        let (parts, words) = MeshParts::new(set.lod(lod)?)?;
        let size = words.len() as u64;
        let index = match self.chunks.iter().position(|c| c.words - c.used >= size) {
            Some(index) => index,
            None => self.add_chunk(size, limits, make)?,
        };
        let chunk = &mut self.chunks[index];
        let (set, last_frame) = (Arc::downgrade(set), AtomicU64::new(0));
        let mesh = Arc::new(ResidentMesh { set, lod, parts, chunk: chunk.id, at: chunk.used as u32, last_frame });
        upload(&chunk.buffer, &mesh, words)?;
        chunk.used += size;
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

    /// Forgets meshes that no target shows and no frame above `done` reads, and drops the buffers of chunks that are empty then.
    /// Calls `freed` with the id of each.
    pub(crate) fn collect(&mut self, done: u64, mut freed: impl FnMut(u32)) {
        self.meshes.retain(|m| Arc::strong_count(m) > 1 || m.last_frame.load(Ordering::Relaxed) > done);
        self.chunks.retain(|c| {
            let kept = self.meshes.iter().any(|m| m.chunk == c.id);
            if !kept {
                freed(c.id);
            }
            kept
        });
    }
}
