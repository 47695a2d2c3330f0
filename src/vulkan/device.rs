//! The device that hosts use: everything that is made on the VkDevice, and the frames in flight.

use super::arena::MeshArena;
use super::classic::ClassicBuffer;
use super::frames::FrameSlot;
use super::host_buffers::HostBuffers;
use super::pipelines::{DescriptorSet, VulkanPipelines};
use super::recording::Recording;
use super::vulkan_device::{DeviceDef, VulkanDevice};
use crate::base::error::Error;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A Vulkan device of the host. Deformation is recorded for it.
pub struct Device {
    pub(super) gpu: VulkanDevice,
    /// Distinguishes its targets from those of other devices.
    pub(super) id: u64,
    pub(super) pipelines: VulkanPipelines,
    pub(super) workgroup: u32,
    pub(super) hosts: HostBuffers,
    pub(super) arena: MeshArena,
    pub(super) slots: Vec<FrameSlot>,
    pub(super) states: Vec<Arc<ClassicBuffer>>,
    /// Descriptor sets of removed buffers, each with the last frame that may use it.
    pub(super) garbage: Vec<(u64, DescriptorSet)>,
    pub(super) recorded: u64,
    pub(super) completed: u64,
    pub(super) recording: Recording,
}

impl fmt::Debug for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Device")
            .field("device", &self.gpu.device)
            .field("recorded", &self.recorded)
            .field("completed", &self.completed)
            .finish_non_exhaustive()
    }
}

impl Device {
    /// Takes the host's device, loads functions and makes layouts. The first target that needs a pipeline makes it, which takes some
    /// milliseconds, or less with cached data.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a null handle, a queue family that does not exist or does not support compute, or a bad
    /// workgroup size; [`Error::Unsupported`] for a function that the loader lacks, or a device below Vulkan 1.1;
    /// [`Error::Vulkan`], [`Error::DeviceLost`].
    ///
    /// # Safety
    /// The handles are valid, belong together, and stay valid until the device is dropped.
    pub unsafe fn new(def: &DeviceDef<'_>) -> Result<Self, Error> {
        // SAFETY: the caller's promise.
        let (gpu, cache) = unsafe { VulkanDevice::new(def)? };
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Ok(Device {
            pipelines: gpu.pipelines(def.workgroup_size, cache)?,
            gpu,
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            workgroup: def.workgroup_size,
            hosts: HostBuffers::default(),
            arena: MeshArena::new(),
            slots: Vec::new(),
            states: Vec::new(),
            garbage: Vec::new(),
            recorded: 0,
            completed: 0,
            recording: Recording::default(),
        })
    }

    /// Reports that the device is done with `frame` and all frames before it. Their memory is reused or freed. Meshes that no target
    /// shows are freed too. A frame above the last recorded counts as that one. It is cheap; call it once a frame.
    pub fn completed(&mut self, frame: u64) {
        // The host may also name frames that nothing was recorded for.
        self.completed = self.completed.max(frame.min(self.recorded));
        self.drop_states();
        let (gpu, done) = (&self.gpu, self.completed);
        self.arena.completed(gpu, done, |chunk| {
            for slot in &mut self.slots {
                slot.forget(gpu, chunk);
            }
        });
        self.garbage.retain(|(frame, set)| {
            if *frame <= done {
                // SAFETY: the frames that might have used it are done.
                unsafe { gpu.destroy_set(set) };
            }
            *frame > done
        });
    }

    /// Destroys the states of dropped targets, once their frames are done.
    fn drop_states(&mut self) {
        self.states.retain(|s| {
            let kept = Arc::strong_count(s) > 1 || s.last_frame() > self.completed;
            if !kept {
                // SAFETY: the frames that used it are done.
                unsafe { s.destroy(&self.gpu) };
            }
            kept
        });
    }

    /// Reports that the recordings for `frame` and later frames will not be submitted. Call [`super::Target::invalidate`] on their
    /// targets ([`super::Target::written_in`]).
    pub fn discard(&mut self, frame: u64) {
        self.arena.discard(frame);
    }

    /// Sets the most vertices that a recording writes; see [`crate::deform_within`]. At first there is no limit (`u64::MAX`).
    pub fn set_vertex_budget(&mut self, vertices: u64) {
        self.recording.plan.budget = vertices;
    }

    /// The last frame that was recorded. Frames above [`Device::last_completed`] are in flight.
    pub fn recorded(&self) -> u64 {
        self.recorded
    }

    /// The last completed frame, or 0.
    pub fn last_completed(&self) -> u64 {
        self.completed
    }

    /// Returns data for [`DeviceDef::pipeline_cache`] of the next run on the same driver.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn pipeline_cache_data(&self) -> Result<Vec<u8>, Error> {
        self.gpu.cache_data(&self.pipelines)
    }

    /// Returns how many buffers, memory allocations and descriptor pools were made so far. The number does not grow in steady state.
    pub fn objects_made(&self) -> u64 {
        self.gpu.objects_made()
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        if self.recorded > self.completed {
            // A frame in flight may use anything.
            return;
        }
        self.completed(u64::MAX);
        // SAFETY: all frames are done.
        unsafe {
            self.arena.destroy(&self.gpu);
            self.states.iter().for_each(|s| s.destroy(&self.gpu));
            self.hosts.sets().for_each(|s| self.gpu.destroy_set(s));
            for slot in &self.slots {
                slot.destroy(&self.gpu);
            }
            self.gpu.destroy_pipelines(&self.pipelines);
        }
    }
}
