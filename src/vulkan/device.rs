//! The device that hosts use: everything that is made on the VkDevice, and the frames in flight.

use super::host_buffers::{BufferDef, BufferId, BufferWindow, HostBuffers};
use super::memory::OwnBuffer;
use super::pipelines::{DescriptorSet, VulkanPipelines};
use super::staging::{FrameSlot, MeshArena};
use super::target::{ClassicState, Target, TargetBinding, TargetDef};
use super::vulkan_device::{DeviceDef, VulkanDevice};
use crate::base::error::Error;
use crate::example::set::ExampleSet;
use crate::gpu::{Case, Plan};
use ash::vk::{self, Handle};
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// A Vulkan device of the host. Deformation is recorded for it.
pub struct Device {
    pub(super) gpu: Arc<VulkanDevice>,
    pub(super) pipelines: VulkanPipelines,
    pub(super) hosts: HostBuffers,
    pub(super) arena: MeshArena,
    pub(super) slots: Vec<FrameSlot>,
    pub(super) states: Vec<(Arc<ClassicState>, OwnBuffer, DescriptorSet)>,
    /// Windows of removed buffers, each with the last frame that may use it.
    garbage: Vec<(u64, BufferWindow)>,
    pub(super) recorded: u64,
    pub(super) completed: u64,
    pub(super) plan: Plan<TargetBinding>,
    pub(super) barriers: Barriers,
}

/// The barriers of a recording. The lists are reused.
#[derive(Default)]
pub(super) struct Barriers {
    /// Buffers that another queue family owns.
    pub foreign: Vec<BufferId>,
    /// Before the dispatches, and the stages that they wait for.
    pub before: Vec<vk::BufferMemoryBarrier<'static>>,
    pub from: vk::PipelineStageFlags,
    /// After the dispatches, and the stages that wait for them.
    pub after: Vec<vk::BufferMemoryBarrier<'static>>,
    pub to: vk::PipelineStageFlags,
}

impl fmt::Debug for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Device")
            .field("device", &self.gpu.device.handle())
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
        let gpu = Arc::new(gpu);
        Ok(Device {
            pipelines: VulkanPipelines::new(&gpu, def.workgroup_size, cache)?,
            plan: Plan::new(def.workgroup_size, gpu.limits.max_compute_work_group_count[0]),
            gpu,
            hosts: HostBuffers::default(),
            arena: MeshArena::new(),
            slots: Vec::new(),
            states: Vec::new(),
            garbage: Vec::new(),
            recorded: 0,
            completed: 0,
            barriers: Barriers::default(),
        })
    }

    /// Reports that the device is done with `frame` and all frames before it. Their memory is reused or freed. Meshes that no target
    /// shows are freed too. A frame above the last recorded counts as that one. It is cheap; call it once a frame.
    pub fn completed(&mut self, frame: u64) {
        // The host may also name frames that nothing was recorded for.
        self.completed = self.completed.max(frame.min(self.recorded));
        let done = self.completed;
        // The states of dropped targets, and whatever else is no longer needed.
        self.states.retain(|(s, ..)| Arc::strong_count(s) > 1 || s.last_frame.load(Ordering::Relaxed) > done);
        self.garbage.retain(|(frame, _)| *frame > done);
        let slots = &mut self.slots;
        self.arena.completed(done, |chunk| slots.iter_mut().for_each(|slot| drop(slot.sets.remove(&chunk))));
    }

    /// Reports that the recordings for `frame` and later frames will not be submitted. Call [`super::Target::invalidate`] on their
    /// targets ([`super::Target::written_in`]).
    pub fn discard(&mut self, frame: u64) {
        self.arena.discard(frame);
    }

    /// Sets the most vertices that a recording writes; see [`crate::deform_within`]. At first there is no limit (`u64::MAX`).
    pub fn set_vertex_budget(&mut self, vertices: u64) {
        self.plan.budget = vertices;
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
        self.pipelines.cache_data()
    }

    /// Returns how many buffers, memory allocations and descriptor pools were made so far. The number does not grow in steady state.
    pub fn objects_made(&self) -> u64 {
        self.gpu.objects_made()
    }

    /// Registers a buffer of the host. It may hold any number of targets; one dispatch writes all targets in one buffer.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a null buffer, a size of 0, a usage without `STORAGE_BUFFER`, or an access without stages.
    ///
    /// # Safety
    /// The buffer belongs to this device, is bound to memory, and has this size and usage. It lives until it is removed and all
    /// frames that wrote it are done.
    pub unsafe fn add_buffer(&mut self, def: &BufferDef) -> Result<BufferId, Error> {
        if def.buffer.is_null() {
            return Err(Error::invalid("the VkBuffer", "null", "a valid handle"));
        }
        if def.size < 4 {
            return Err(Error::invalid("the buffer's size", def.size, "at least 4 bytes"));
        }
        if !def.usage.contains(vk::BufferUsageFlags::STORAGE_BUFFER) {
            let value = format!("{:?}", def.usage);
            return Err(Error::invalid("the buffer's usage", value, "with STORAGE_BUFFER among its flags"));
        }
        for (name, access) in [("the stages before", def.before), ("the stages after", def.after)] {
            if access.stages.is_empty() {
                let expected = "at least one stage (TOP_OF_PIPE or BOTTOM_OF_PIPE for none)";
                return Err(Error::invalid(name, "none", expected));
            }
        }
        Ok(self.hosts.add(def))
    }

    /// Removes a buffer. Its targets can no longer be recorded. The host may destroy it once the frames that wrote it are done.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a stale id.
    pub fn remove_buffer(&mut self, id: BufferId) -> Result<(), Error> {
        let host = self.hosts.remove(id)?;
        self.garbage.extend(host.windows.into_iter().map(|w| (host.used, w)));
        Ok(())
    }

    /// The definition of a buffer.
    #[cfg(feature = "capi")]
    pub(crate) fn buffer_def(&self, id: BufferId) -> Result<&BufferDef, Error> {
        Ok(&self.hosts.get(id)?.def)
    }

    /// Adds a target: a place for the vertices of one of the set's meshes. The first target of a mesh copies the mesh and its
    /// examples into a staging buffer; the next recording copies them to the device.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a stale buffer, a format that the attribute cannot have, a stride that is too small, attributes
    /// that overlap, or a bad scale; [`Error::Misaligned`] for offsets and strides that are not multiples of 4;
    /// [`Error::BufferTooSmall`]; [`Error::IndexOutOfRange`] for a level of detail that the set lacks; [`Error::Unsupported`] for
    /// normals or tangents that the mesh lacks, or more bytes than the device can bind;
    /// [`Error::OutOfMemory`], [`Error::Vulkan`], [`Error::DeviceLost`].
    pub fn add_target(&mut self, set: &Arc<ExampleSet>, def: &TargetDef) -> Result<Target, Error> {
        let mesh = set.lod(def.lod)?;
        let host = self.hosts.get_mut(def.buffer)?;
        let (layout, written) = def.layout(&mesh.mesh, host.def.size)?;
        let window = host.window(&self.pipelines, &self.gpu.binding_limits(), &written)?;
        let (handle, first) = (host.def.buffer, def.offset.wrapping_sub(host.windows[window].range.start));
        self.pipelines.add(layout.variant(Case::Nodes))?;
        let mesh = self.arena.mesh(&self.gpu, set, def.lod)?;
        let binding = TargetBinding { handle, buffer: def.buffer, window };
        Ok(Target::new(self.plan.id, (layout, first), mesh, (binding, ())))
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // A frame in flight may use anything.
        if self.recorded > self.completed {
            self.gpu.leak();
        }
    }
}
