//! The states of vertices under the classic rules. Each target of an instance with such a rule has a buffer for them.

use super::device::{Device, VulkanDevice};
use super::memory::{BufferUse, OwnBuffer};
use super::pipelines::DescriptorSet;
use super::record::RecordJob;
use crate::Error;
use crate::gpu::missing_state;
use ash::vk;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The states of one target's vertices.
#[derive(Debug)]
pub(super) struct ClassicBuffer {
    buffer: OwnBuffer,
    set: DescriptorSet,
    /// The last frame that uses it.
    used: AtomicU64,
}

impl ClassicBuffer {
    pub(super) fn handle(&self) -> vk::Buffer {
        self.buffer.handle
    }

    pub(super) fn set(&self) -> vk::DescriptorSet {
        self.set.handle
    }

    /// Notes that a frame uses it.
    pub(super) fn used_in(&self, frame: u64) {
        self.used.fetch_max(frame, Ordering::Relaxed);
    }

    /// # Safety
    /// Nothing uses it any more.
    pub(super) unsafe fn destroy(&self, gpu: &VulkanDevice) {
        // SAFETY: the caller's promise.
        unsafe {
            gpu.destroy_set(&self.set);
            gpu.destroy(&self.buffer);
        }
    }
}

impl Device {
    /// Makes the buffer and the pipeline that a target of an instance with a classic rule lacks.
    pub(super) fn add_state(&mut self, job: &mut RecordJob<'_>) -> Result<(), Error> {
        let Some(bytes) = missing_state(job, job.target.classic.is_some()) else { return Ok(()) };
        self.gpu.add_pipeline(&mut self.pipelines, job.target.state.kernel, true)?;
        self.gpu.binding_limits().check("a classic rule's state", bytes)?;
        let buffer = self.gpu.buffer(bytes, BufferUse::Storage)?;
        let set = self.gpu.set(&self.pipelines, &[(buffer.handle, 0, bytes)]).inspect_err(|_| {
            // SAFETY: nothing uses it yet.
            unsafe { self.gpu.destroy(&buffer) }
        })?;
        let state = Arc::new(ClassicBuffer { buffer, set, used: AtomicU64::new(0) });
        self.states.push(state.clone());
        job.target.classic = Some(state);
        // The new buffer holds no state, whatever the vertices show.
        job.target.state.tracker.invalidate();
        Ok(())
    }

    /// Destroys the states of dropped targets, once their frames are done.
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
