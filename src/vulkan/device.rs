//! The host's device as it is used here, and everything that is made on it.

use super::arena::MeshArena;
use super::classic::ClassicBuffer;
use super::frames::FrameSlot;
use super::functions::{DeviceFnV1_0, InstanceFnV1_0, load};
use super::host::{BufferDef, HostBuffers};
use super::pipelines::{DescriptorSet, VulkanPipelines};
use super::record::Recording;
use crate::Error;
use crate::gpu::BindingLimits;
use ash::vk::{self, Handle};
use std::ffi::CStr;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The host's Vulkan device.
#[derive(Clone)]
pub struct DeviceDef<'a> {
    /// The loader that the instance was made with: `vkGetInstanceProcAddr`. All functions are taken from it.
    pub get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
    /// The instance, of Vulkan 1.1 or later.
    pub instance: vk::Instance,
    /// The physical device, of Vulkan 1.1 or later.
    pub physical_device: vk::PhysicalDevice,
    /// The device.
    pub device: vk::Device,
    /// Family of the queue that command buffers will be submitted to; one that can compute.
    pub queue_family: u32,
    /// What [`Device::pipeline_cache_data`] gave at an earlier run, or nothing. Data of another driver is not used.
    pub pipeline_cache: &'a [u8],
    /// Invocations a workgroup: a power of two from 32 to 256, no more than the device can. 128 where nothing says otherwise.
    pub workgroup_size: u32,
}

impl<'a> DeviceDef<'a> {
    /// Of these handles, without cached pipelines.
    pub fn new(
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
        physical_device: vk::PhysicalDevice,
        device: vk::Device,
        queue_family: u32,
    ) -> Self {
        let (pipeline_cache, workgroup_size): (&'a [u8], u32) = (&[], 128);
        DeviceDef {
            get_instance_proc_addr,
            instance,
            physical_device,
            device,
            queue_family,
            pipeline_cache,
            workgroup_size,
        }
    }
}

/// What everything is made with.
pub(super) struct VulkanDevice {
    pub functions: DeviceFnV1_0,
    pub device: vk::Device,
    pub memory: vk::PhysicalDeviceMemoryProperties,
    pub limits: vk::PhysicalDeviceLimits,
    /// Of the queue that recorded work is submitted to.
    pub family: u32,
    /// Buffers, pieces of memory and descriptor pools made so far.
    made: AtomicU64,
}

impl VulkanDevice {
    /// Whether another queue family owns a buffer.
    pub(super) fn foreign(&self, def: &BufferDef) -> bool {
        def.queue_family != vk::QUEUE_FAMILY_IGNORED && def.queue_family != self.family
    }

    pub(super) fn binding_limits(&self) -> BindingLimits {
        BindingLimits {
            bytes: u64::from(self.limits.max_storage_buffer_range) & !3,
            name: "maxStorageBufferRange",
            alignment: self.limits.min_storage_buffer_offset_alignment.max(4),
        }
    }

    /// Counts an object that is made.
    pub(super) fn count(&self) {
        self.made.fetch_add(1, Ordering::Relaxed);
    }
}

/// A Vulkan device of the host that deformation is recorded for.
pub struct Device {
    pub(super) gpu: VulkanDevice,
    /// Tells targets of other devices.
    pub(super) id: u64,
    pub(super) pipelines: VulkanPipelines,
    pub(super) workgroup: u32,
    pub(super) hosts: HostBuffers,
    pub(super) arena: MeshArena,
    pub(super) slots: Vec<FrameSlot>,
    pub(super) states: Vec<Arc<ClassicBuffer>>,
    /// Sets that are no longer needed, each with the last frame that may use it.
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
    /// Takes the host's device: loads functions and makes layouts. Pipelines are made with the first targets that need them (some
    /// milliseconds each, less with cached data).
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a null handle, a queue family that is not there or cannot compute, or a workgroup size
    /// that is none; [`Error::Unsupported`] naming a function that the loader does not have, or a device below Vulkan 1.1;
    /// [`Error::Vulkan`], [`Error::DeviceLost`].
    ///
    /// # Safety
    /// The handles are valid, belong together, and stay valid until the device is dropped.
    pub unsafe fn new(def: &DeviceDef<'_>) -> Result<Self, Error> {
        let named = [
            ("the VkInstance", def.instance.is_null()),
            ("the VkPhysicalDevice", def.physical_device.is_null()),
            ("the VkDevice", def.device.is_null()),
        ];
        for (name, null) in named {
            if null {
                return Err(Error::invalid(name, "null", "a valid handle"));
            }
        }
        let get = def.get_instance_proc_addr;
        let of_instance = |name: &CStr| {
            // SAFETY: the caller's loader and instance.
            unsafe { get(def.instance, name.as_ptr()) }
        };
        let instance = load(|get| InstanceFnV1_0::load(get), of_instance)?;
        let of_device = |name: &CStr| {
            // SAFETY: the caller's device, and its own loader.
            unsafe { (instance.get_device_proc_addr)(def.device, name.as_ptr()) }
        };
        let functions = load(|get| DeviceFnV1_0::load(get), of_device)?;
        let mut properties = vk::PhysicalDeviceProperties::default();
        let mut memory = vk::PhysicalDeviceMemoryProperties::default();
        let mut count = 0;
        // SAFETY: the caller's physical device.
        unsafe {
            (instance.get_physical_device_properties)(def.physical_device, &mut properties);
            (instance.get_physical_device_memory_properties)(def.physical_device, &mut memory);
            (instance.get_physical_device_queue_family_properties)(
                def.physical_device,
                &mut count,
                std::ptr::null_mut(),
            );
        }
        let mut families = vec![vk::QueueFamilyProperties::default(); count as usize];
        // SAFETY: the same; there is room for `count`.
        unsafe {
            (instance.get_physical_device_queue_family_properties)(
                def.physical_device,
                &mut count,
                families.as_mut_ptr(),
            )
        };
        check(def, &properties, &families)?;
        static NEXT: AtomicU64 = AtomicU64::new(1);
        let (device, limits, family) = (def.device, properties.limits, def.queue_family);
        let gpu = VulkanDevice { functions, device, memory, limits, family, made: AtomicU64::new(0) };
        let cache = if fits(def.pipeline_cache, &properties) { def.pipeline_cache } else { &[] };
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

    /// Says that the device is done with `frame` and all before it: everything that was submitted for them has completed.
    /// What they used is used again or freed, and what belonged to sets that no target shows any more. Frames above the last
    /// recorded count as that one. Cheap; once a frame.
    pub fn completed(&mut self, frame: u64) {
        // Frames that nothing was recorded for may be told of as well.
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

    /// Says that what was recorded for `frame` and those after it will not be submitted: it is as if these recordings had not
    /// been, but that their targets ([`super::Target::written_in`]) must be told by [`super::Target::invalidate`].
    pub fn discard(&mut self, frame: u64) {
        self.arena.discard(frame);
    }

    /// The handle of a buffer.
    pub(crate) fn handle_of(&self, id: super::BufferId) -> Result<u64, Error> {
        Ok(self.hosts.get(id)?.def.buffer.as_raw())
    }

    /// The last frame that was recorded; above what [`Device::completed`] was told, frames are in flight.
    pub fn recorded(&self) -> u64 {
        self.recorded
    }

    /// The last frame that [`Device::completed`] was told of; 0 for none.
    pub fn last_completed(&self) -> u64 {
        self.completed
    }

    /// Data for [`DeviceDef::pipeline_cache`] at the next run, on the same driver.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn pipeline_cache_data(&self) -> Result<Vec<u8>, Error> {
        self.gpu.cache_data(&self.pipelines)
    }

    /// How many buffers, pieces of memory and descriptor pools were made so far: a number that stands still once as many frames
    /// are in flight as ever, and as much changes a frame as ever.
    pub fn objects_made(&self) -> u64 {
        self.gpu.made.load(Ordering::Relaxed)
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

fn check(
    def: &DeviceDef<'_>,
    properties: &vk::PhysicalDeviceProperties,
    families: &[vk::QueueFamilyProperties],
) -> Result<(), Error> {
    if properties.api_version < vk::API_VERSION_1_1 {
        let (major, minor) =
            (vk::api_version_major(properties.api_version), vk::api_version_minor(properties.api_version));
        return Err(Error::Unsupported { what: format!("a device of Vulkan {major}.{minor}; 1.1 is needed") });
    }
    let compute = |f: &vk::QueueFamilyProperties| f.queue_flags.contains(vk::QueueFlags::COMPUTE);
    if !families.get(def.queue_family as usize).is_some_and(compute) {
        let good = families.iter().enumerate().filter(|(_, f)| compute(f)).map(|(i, _)| i.to_string());
        let good: Vec<String> = good.collect();
        return Err(Error::invalid(
            "queue_family",
            def.queue_family,
            &format!("one that computes: {}", good.join(", ")),
        ));
    }
    let limits = &properties.limits;
    let most = limits.max_compute_work_group_size[0].min(limits.max_compute_work_group_invocations).min(256);
    if !def.workgroup_size.is_power_of_two() || !(32..=most).contains(&def.workgroup_size) {
        return Err(Error::invalid("workgroup_size", def.workgroup_size, &format!("a power of two, 32 to {most}")));
    }
    Ok(())
}

/// Whether the data's header is of this driver: other data must not be handed to it.
fn fits(data: &[u8], properties: &vk::PhysicalDeviceProperties) -> bool {
    let word = |i: usize| Some(u32::from_le_bytes(data.get(4 * i..4 * i + 4)?.try_into().ok()?));
    word(0) == Some(32)
        && word(1) == Some(vk::PipelineCacheHeaderVersion::ONE.as_raw() as u32)
        && word(2) == Some(properties.vendor_id)
        && word(3) == Some(properties.device_id)
        && data.get(16..32) == Some(&properties.pipeline_cache_uuid)
}
