//! Meshes, examples and stamps on the device. Each set and level of detail is uploaded once, into a few large buffers.

use super::limits::BindingLimits;
use super::mesh::{MeshPlacement, MeshWords, StampWords};
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
    stamps: Vec<(Weak<ExampleSet>, Arc<StampWords>, u32)>,
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

/// Words to copy into a chunk: a mesh, and its set's stamps if the chunk has none of them yet.
pub(crate) struct Upload<'a> {
    set: &'a ExampleSet,
    lod: usize,
    mesh: &'a MeshWords,
    stamps: Option<&'a StampWords>,
    /// The first word in the chunk.
    pub at: u32,
    pub words: u64,
}

impl Upload<'_> {
    /// Writes the words into memory of that size.
    pub(crate) fn write(&self, to: &mut [u32]) -> Result<(), Error> {
        let (mesh, stamps) = to.split_at_mut(self.mesh.total() as usize);
        self.mesh.write(self.set.lod(self.lod)?, mesh);
        if let Some(words) = self.stamps {
            words.write(self.set, stamps);
        }
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
        let stamps_in = |c: &Chunk<B>| c.stamps.iter().find(|s| same(&s.0)).map(|s| (s.1.clone(), s.2));
        let left = |c: &Chunk<B>| c.words - c.used;
        let stamps = Arc::new(StampWords::new(set));
        let both = words.total() + stamps.total();
        // Stamps that are on the device serve every level of detail of their set.
        let with_stamps = self.chunks.iter().position(|c| stamps_in(c).is_some() && left(c) >= words.total());
        let index = match with_stamps.or_else(|| self.chunks.iter().position(|c| left(c) >= both)) {
            Some(index) => index,
            None => self.add_chunk(both, limits, make)?,
        };
        let chunk = &mut self.chunks[index];
        let (at, known) = (chunk.used as u32, stamps_in(chunk));
        let new_stamps = known.is_none();
        let (stamps, stamps_at) = known.unwrap_or((stamps, at + words.total() as u32));
        let total = if new_stamps { both } else { words.total() };
        let new = new_stamps.then_some(&*stamps);
        upload(&chunk.buffer, &Upload { set, lod, mesh: &words, stamps: new, at, words: total })?;
        if new_stamps {
            chunk.stamps.push((Arc::downgrade(set), stamps.clone(), stamps_at));
        }
        chunk.used += total;
        let place = MeshPlacement { mesh: words, stamps, mesh_at: at, stamps_at };
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
        self.chunks.push(Chunk { id: self.last_id, buffer, words: size / 4, used: 0, stamps: Vec::new() });
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
