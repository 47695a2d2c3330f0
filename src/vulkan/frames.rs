//! A frame's words on their way to the device: as many slots as there are recordings in flight, used over and over.

use super::device::{Device, VulkanDevice};
use super::memory::{BufferUse, OwnBuffer};
use super::pipelines::DescriptorSet;
use crate::Error;

/// The smallest slot in bytes.
const SMALLEST: u64 = 64 << 10;

/// Buffers that one recording uses.
pub(super) struct FrameSlot {
    /// The last frame that uses it, or 0.
    pub frame: u64,
    pub staging: OwnBuffer,
    pub storage: OwnBuffer,
    /// The descriptor sets, one for each chunk of the arena that it was used with.
    sets: Vec<(u32, DescriptorSet)>,
}

impl Device {
    /// Returns a slot of at least `bytes` bytes that no frame in flight uses.
    pub(super) fn slot(&mut self, bytes: u64) -> Result<usize, Error> {
        let limits = self.gpu.binding_limits();
        limits.check("the work of a frame", bytes)?;
        let free = |s: &FrameSlot| s.frame <= self.completed;
        if let Some(index) = self.slots.iter().position(|s| free(s) && s.storage.size >= bytes) {
            return Ok(index);
        }
        let size = bytes.next_power_of_two().max(SMALLEST).min(limits.bytes);
        let staging = self.gpu.buffer(size, BufferUse::Staging)?;
        let storage = self.gpu.buffer(size, BufferUse::Storage).inspect_err(|_| {
            // SAFETY: nothing uses it yet.
            unsafe { self.gpu.destroy(&staging) }
        })?;
        let slot = FrameSlot { frame: 0, staging, storage, sets: Vec::new() };
        // A free slot that is too small is replaced.
        match self.slots.iter().position(free) {
            Some(index) => {
                let old = std::mem::replace(&mut self.slots[index], slot);
                // SAFETY: the frames that used it are done.
                unsafe { old.destroy(&self.gpu) };
                Ok(index)
            }
            None => {
                self.slots.push(slot);
                Ok(self.slots.len() - 1)
            }
        }
    }

    /// Adds the slot's set for a chunk, if it is not there yet.
    pub(super) fn add_slot_set(&mut self, slot: usize, chunk: u32) -> Result<(), Error> {
        let slot = &mut self.slots[slot];
        if !slot.sets.iter().any(|(c, _)| *c == chunk) {
            let whole = |b: &OwnBuffer| (b.handle, 0, b.size);
            let set = self.gpu.set(&self.pipelines, &[whole(self.arena.buffer(chunk)), whole(&slot.storage)])?;
            slot.sets.push((chunk, set));
        }
        Ok(())
    }
}

impl FrameSlot {
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
