//! A frame's words on their way to the device: as many slots as there are recordings in flight, used over and over.

use super::device::{Device, Gpu};
use super::kernels::Set;
use super::memory::{Buffer, Use};
use crate::Error;

/// Bytes of a slot, at least.
const LEAST: u64 = 64 << 10;

/// What one recording uses.
pub(super) struct Slot {
    /// The last frame that uses it; 0 for none.
    pub frame: u64,
    pub staging: Buffer,
    pub storage: Buffer,
    /// Of each arena chunk that it was used with, the set of both.
    sets: Vec<(u32, Set)>,
}

impl Device {
    /// A slot of at least so many bytes that no frame in flight uses.
    pub(super) fn slot(&mut self, bytes: u64) -> Result<usize, Error> {
        let most = u64::from(self.gpu.limits.max_storage_buffer_range);
        if bytes > most {
            let what = format!("{bytes} bytes for the work of a frame; maxStorageBufferRange is {most} on this device");
            return Err(Error::Unsupported { what });
        }
        let free = |s: &Slot| s.frame <= self.completed;
        if let Some(index) = self.slots.iter().position(|s| free(s) && s.storage.size >= bytes) {
            return Ok(index);
        }
        let size = bytes.next_power_of_two().max(LEAST).min(most & !3);
        let staging = self.gpu.buffer(size, Use::Staging)?;
        let storage = self.gpu.buffer(size, Use::Storage).inspect_err(|_| {
            // SAFETY: nothing uses it yet.
            unsafe { self.gpu.destroy(&staging) }
        })?;
        let slot = Slot { frame: 0, staging, storage, sets: Vec::new() };
        // One that has become too small gives way.
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

    /// Makes sure that the slot has its set for a chunk.
    pub(super) fn add_slot_set(&mut self, slot: usize, chunk: u32) -> Result<(), Error> {
        let slot = &mut self.slots[slot];
        if !slot.sets.iter().any(|(c, _)| *c == chunk) {
            let whole = |b: &Buffer| (b.handle, 0, b.size);
            let set = self.gpu.set(&self.kernels, &[whole(self.arena.chunk(chunk)), whole(&slot.storage)])?;
            slot.sets.push((chunk, set));
        }
        Ok(())
    }
}

impl Slot {
    /// The set for a chunk, which must have been added.
    pub(super) fn set(&self, chunk: u32) -> &Set {
        &self.sets.iter().find(|(c, _)| *c == chunk).expect("the set was added").1
    }

    /// Destroys the set of a chunk that is no more, and that no frame in flight uses.
    pub(super) fn forget(&mut self, gpu: &Gpu, chunk: u32) {
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
    pub(super) unsafe fn destroy(&self, gpu: &Gpu) {
        // SAFETY: passed on.
        unsafe {
            self.sets.iter().for_each(|(_, set)| gpu.destroy_set(set));
            gpu.destroy(&self.staging);
            gpu.destroy(&self.storage);
        }
    }
}
