//! What classic rules keep of each vertex, on the device: a buffer for each target that shows such an instance.

use super::device::{Device, Gpu};
use super::host::Target;
use super::kernels::Set;
use super::memory::{Buffer, Use};
use crate::{Error, Instance};
use ash::vk;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// One target's state.
#[derive(Debug)]
pub(super) struct State {
    buffer: Buffer,
    set: Set,
    /// The last frame that uses it.
    used: AtomicU64,
}

impl State {
    pub(super) fn handle(&self) -> vk::Buffer {
        self.buffer.handle
    }

    pub(super) fn set(&self) -> vk::DescriptorSet {
        self.set.handle
    }

    pub(super) fn use_in(&self, frame: u64) {
        self.used.fetch_max(frame, Ordering::Relaxed);
    }

    /// # Safety
    /// Nothing uses it any more.
    pub(super) unsafe fn destroy(&self, gpu: &Gpu) {
        // SAFETY: passed on.
        unsafe {
            gpu.destroy_set(&self.set);
            gpu.destroy(&self.buffer);
        }
    }
}

impl Device {
    /// Makes sure that a target of an instance with a classic rule has a state.
    pub(super) fn add_state(&mut self, instance: &Instance, target: &mut Target) -> Result<(), Error> {
        if instance.classic_state().is_none() || target.state.is_some() {
            return Ok(());
        }
        self.gpu.add_pipeline(&mut self.kernels, target.kernel, true)?;
        let vertices = instance.example_set().vertex_count() as u64;
        let bytes = vertices * target.kernel.state_bytes();
        let most = u64::from(self.gpu.limits.max_storage_buffer_range);
        if bytes > most {
            let what =
                format!("a classic rule's state of {bytes} bytes; maxStorageBufferRange is {most} on this device");
            return Err(Error::Unsupported { what });
        }
        let buffer = self.gpu.buffer(bytes, Use::Storage)?;
        let set = self.gpu.set(&self.kernels, &[(buffer.handle, 0, bytes)]).inspect_err(|_| {
            // SAFETY: nothing uses it yet.
            unsafe { self.gpu.destroy(&buffer) }
        })?;
        let state = Arc::new(State { buffer, set, used: AtomicU64::new(0) });
        self.states.push(state.clone());
        target.state = Some(state);
        // What the memory may hold already says nothing about the state.
        target.tracker.invalidate();
        Ok(())
    }

    /// Destroys states that no target has any more, once their frames are done.
    pub(super) fn drop_states(&mut self) {
        self.states.retain(|s| {
            let kept = Arc::strong_count(s) > 1 || s.used.load(Ordering::Relaxed) > self.completed;
            if !kept {
                // SAFETY: the frames that used it are done.
                unsafe { s.destroy(&self.gpu) };
            }
            kept
        });
    }
}
