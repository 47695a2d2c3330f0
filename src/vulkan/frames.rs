//! A frame's words on their way to the device: as many slots as there are recordings in flight, used over and over.

use super::memory::{BufferUse, OwnBuffer};
use super::pipelines::{DescriptorSet, VulkanPipelines};
use super::vulkan_device::VulkanDevice;
use crate::base::error::Error;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

/// Buffers that one recording uses.
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
