//! A frame's words on their way to the device: as many slots as there are recordings in flight, used over and over.

use super::memory::{BufferUse, OwnBuffer};
use super::pipelines::{DescriptorSet, VulkanPipelines};
use super::vulkan_device::VulkanDevice;
use crate::base::error::Error;

/// Buffers that one recording uses.
pub(super) struct FrameSlot {
    /// The last frame that uses it, or 0.
    pub frame: u64,
    pub staging: OwnBuffer,
    pub storage: OwnBuffer,
    /// The descriptor sets, one for each chunk of the arena that it was used with.
    sets: Vec<(u32, DescriptorSet)>,
}

/// Returns the index of a slot of at least `bytes` bytes that no frame after `done` uses. Makes one if there is none.
pub(super) fn free_slot(slots: &mut Vec<FrameSlot>, gpu: &VulkanDevice, done: u64, bytes: u64) -> Result<usize, Error> {
    let limits = gpu.binding_limits();
    limits.check("the work of a frame", bytes)?;
    let free = |s: &FrameSlot| s.frame <= done;
    if let Some(index) = slots.iter().position(|s| free(s) && s.storage.size >= bytes) {
        return Ok(index);
    }
    let slot = FrameSlot::new(gpu, limits.frame_buffer_size(bytes))?;
    // A free slot that is too small is replaced.
    match slots.iter().position(free) {
        Some(index) => {
            let old = std::mem::replace(&mut slots[index], slot);
            // SAFETY: the frames that used it are done.
            unsafe { old.destroy(gpu) };
            Ok(index)
        }
        None => {
            slots.push(slot);
            Ok(slots.len() - 1)
        }
    }
}

impl FrameSlot {
    /// Makes the buffers, of `size` bytes each.
    fn new(gpu: &VulkanDevice, size: u64) -> Result<Self, Error> {
        let staging = gpu.buffer(size, BufferUse::Staging)?;
        let storage = gpu.buffer(size, BufferUse::Storage).inspect_err(|_| {
            // SAFETY: nothing uses it yet.
            unsafe { gpu.destroy(&staging) }
        })?;
        Ok(FrameSlot { frame: 0, staging, storage, sets: Vec::new() })
    }

    /// Adds the set for a chunk with this buffer, if it is not there yet.
    pub(super) fn add_set(
        &mut self,
        (gpu, pipelines): (&VulkanDevice, &VulkanPipelines),
        chunk: u32,
        meshes: &OwnBuffer,
    ) -> Result<(), Error> {
        if !self.sets.iter().any(|(c, _)| *c == chunk) {
            let whole = |b: &OwnBuffer| (b.handle, 0, b.size);
            let set = gpu.set(pipelines, &[whole(meshes), whole(&self.storage)])?;
            self.sets.push((chunk, set));
        }
        Ok(())
    }

    /// A set that was added.
    pub(super) fn set(&self, chunk: u32) -> &DescriptorSet {
        &self.sets.iter().find(|(c, _)| *c == chunk).expect("the set was added").1
    }

    /// Destroys the set of a chunk that is no more. No frame in flight uses it.
    pub(super) fn forget(&mut self, gpu: &VulkanDevice, chunk: u32) {
        self.sets.retain(|(c, set)| {
            if *c == chunk {
                // SAFETY: the frames that used the chunk are done.
                unsafe { gpu.destroy_set(set) };
            }
            *c != chunk
        });
    }

    /// # Safety
    /// Nothing uses it any more.
    pub(super) unsafe fn destroy(&self, gpu: &VulkanDevice) {
        // SAFETY: the caller's promise.
        unsafe {
            self.sets.iter().for_each(|(_, set)| gpu.destroy_set(set));
            gpu.destroy(&self.staging);
            gpu.destroy(&self.storage);
        }
    }
}
