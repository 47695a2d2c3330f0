//! The states of vertices under the classic rules. Each target of an instance with such a rule has a buffer for them.

use super::memory::{BufferUse, OwnBuffer};
use super::pipelines::{DescriptorSet, VulkanPipelines};
use super::vulkan_device::VulkanDevice;
use crate::base::error::Error;
use ash::vk;
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
    /// Makes a buffer of `bytes` bytes.
    pub(super) fn new(gpu: &VulkanDevice, pipelines: &VulkanPipelines, bytes: u64) -> Result<Self, Error> {
        gpu.binding_limits().check("a classic rule's state", bytes)?;
        let buffer = gpu.buffer(bytes, BufferUse::Storage)?;
        let set = gpu.set(pipelines, &[(buffer.handle, 0, bytes)]).inspect_err(|_| {
            // SAFETY: nothing uses it yet.
            unsafe { gpu.destroy(&buffer) }
        })?;
        Ok(ClassicBuffer { buffer, set, used: AtomicU64::new(0) })
    }

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

    /// The last frame that uses it, or 0.
    pub(super) fn last_frame(&self) -> u64 {
        self.used.load(Ordering::Relaxed)
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
