//! What the device reads: meshes, which are copied once, and a frame's data. Both go through staging buffers.

use super::memory::{BufferUse, OwnBuffer};
use super::pipelines::{DescriptorSet, VulkanPipelines};
use super::vulkan_device::VulkanDevice;
use crate::base::error::Error;
use crate::example::set::ExampleSet;
use crate::gpu::{Arena, ResidentMesh};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::{Arc, Weak};

/// The arena's buffers, and what is still to be copied into them.
pub(super) struct MeshArena {
    arena: Arena<OwnBuffer>,
    uploads: Vec<StagedMesh>,
}

/// A mesh in a staging buffer.
struct StagedMesh {
    mesh: Weak<ResidentMesh>,
    staging: OwnBuffer,
    /// The frame that copies it.
    recorded: Option<u64>,
}

impl MeshArena {
    pub(super) fn new() -> Self {
        MeshArena { arena: Arena::new(), uploads: Vec::new() }
    }

    /// Returns a mesh of the set. A new one is in a staging buffer until the next frame copies it.
    pub(super) fn mesh(
        &mut self,
        gpu: &Arc<VulkanDevice>,
        set: &Arc<ExampleSet>,
        lod: usize,
    ) -> Result<Arc<ResidentMesh>, Error> {
        let make = |bytes| OwnBuffer::new(gpu, bytes, BufferUse::Storage);
        self.arena.mesh((set, lod), &gpu.binding_limits(), make, |_, mesh, words| {
            let mut staging = OwnBuffer::new(gpu, 4 * words.len() as u64, BufferUse::Staging)?;
            staging.write(words.len(), |to| to.copy_from_slice(&words))?;
            self.uploads.push(StagedMesh { mesh: Arc::downgrade(mesh), staging, recorded: None });
            Ok(())
        })
    }

    /// The buffer of the chunk that holds a resident mesh.
    pub(super) fn buffer(&self, chunk: u32) -> &OwnBuffer {
        self.arena.buffer(chunk)
    }

    /// Calls `copy` with staging buffer, chunk and bytes from the chunk's start of each mesh that was not copied yet.
    pub(super) fn record(&mut self, frame: u64, mut copy: impl FnMut(&OwnBuffer, &OwnBuffer, u64)) {
        for u in self.uploads.iter_mut().filter(|u| u.recorded.is_none()) {
            let Some(mesh) = u.mesh.upgrade() else { continue };
            copy(&u.staging, self.arena.buffer(mesh.chunk), mesh.offset());
            u.recorded = Some(frame);
            mesh.used_in(frame);
        }
    }

    /// Frees what frames up to `done` needed. Calls `freed` with each chunk that is no more.
    pub(super) fn completed(&mut self, done: u64, freed: impl FnMut(u32)) {
        self.arena.collect(done, freed);
        self.uploads.retain(|u| u.mesh.strong_count() > 0 && u.recorded.is_none_or(|frame| frame > done));
    }

    /// Notes that frames from `frame` on will not run.
    pub(super) fn discard(&mut self, frame: u64) {
        let lost = self.uploads.iter_mut().filter(|u| u.recorded.is_some_and(|f| f >= frame));
        lost.for_each(|u| u.recorded = None);
    }
}

/// The buffers of one recording, for its data on the way to the device. There are as many as there are recordings in flight, used
/// over and over.
pub(super) struct FrameSlot {
    /// The last frame that uses it, or 0.
    pub frame: u64,
    pub staging: OwnBuffer,
    pub storage: OwnBuffer,
    /// The descriptor sets, one for each chunk of the arena that it was used with.
    pub sets: BTreeMap<u32, DescriptorSet>,
}

impl FrameSlot {
    /// Returns the index of a slot of at least `bytes` bytes that no frame after `done` uses. Makes one if there is none.
    pub(super) fn free(slots: &mut Vec<Self>, gpu: &Arc<VulkanDevice>, done: u64, bytes: u64) -> Result<usize, Error> {
        let limits = gpu.binding_limits();
        limits.check("the work of a frame", bytes)?;
        let free = |s: &FrameSlot| s.frame <= done;
        if let Some(index) = slots.iter().position(|s| free(s) && s.storage.size >= bytes) {
            return Ok(index);
        }
        let size = limits.frame_buffer_size(bytes);
        let staging = OwnBuffer::new(gpu, size, BufferUse::Staging)?;
        let storage = OwnBuffer::new(gpu, size, BufferUse::Storage)?;
        let slot = FrameSlot { frame: 0, staging, storage, sets: BTreeMap::new() };
        // A free slot that is too small is replaced.
        if let Some(index) = slots.iter().position(free) {
            slots[index] = slot;
            return Ok(index);
        }
        slots.push(slot);
        Ok(slots.len() - 1)
    }

    /// Adds the set for a chunk with this buffer, if it is not there yet.
    pub(super) fn add_set(&mut self, pipelines: &VulkanPipelines, chunk: u32, meshes: &OwnBuffer) -> Result<(), Error> {
        if let Entry::Vacant(entry) = self.sets.entry(chunk) {
            let whole = |b: &OwnBuffer| (b.handle, 0, b.size);
            entry.insert(pipelines.set(&[whole(meshes), whole(&self.storage)])?);
        }
        Ok(())
    }
}
