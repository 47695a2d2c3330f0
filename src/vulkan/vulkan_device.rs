//! The host's VkDevice with its functions and limits.

use super::functions;
use crate::base::error::Error;
use crate::gpu::{BindingLimits, check_workgroup_size};
use ash::vk::{self, Handle};
use std::ffi::CStr;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

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
    /// Family of the queue that command buffers are submitted to. It must support compute.
    pub queue_family: u32,
    /// Data from [`super::Device::pipeline_cache_data`] of an earlier run, or nothing. Data of another driver is ignored.
    pub pipeline_cache: &'a [u8],
    /// Invocations a workgroup: a power of two from 32 to 128 that the device supports. The default is 128.
    pub workgroup_size: u32,
}

impl<'a> DeviceDef<'a> {
    /// A definition with these handles and the defaults.
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

/// The Vulkan device, its functions and its limits.
pub(super) struct VulkanDevice {
    pub device: ash::Device,
    pub memory: vk::PhysicalDeviceMemoryProperties,
    pub limits: vk::PhysicalDeviceLimits,
    /// Family of the queue that command buffers are submitted to.
    pub family: u32,
    /// Buffers, memory allocations and descriptor pools made so far.
    made: AtomicU64,
    /// Whether what is dropped is leaked, since a frame in flight may use it.
    leaks: AtomicBool,
}

impl VulkanDevice {
    /// Loads the functions and asks for the limits. Returns the pipeline cache data of the definition too, if this driver made it.
    ///
    /// # Safety
    /// As [`super::Device::new`].
    pub(super) unsafe fn new<'a>(def: &DeviceDef<'a>) -> Result<(Self, &'a [u8]), Error> {
        let named = [
            ("the VkInstance", def.instance.is_null()),
            ("the VkPhysicalDevice", def.physical_device.is_null()),
            ("the VkDevice", def.device.is_null()),
        ];
        if let Some((name, _)) = named.iter().find(|(_, null)| *null) {
            return Err(Error::invalid(name, "null", "a valid handle"));
        }
        let of_instance = |name: &CStr| {
            // SAFETY: the caller's loader and instance.
            unsafe { (def.get_instance_proc_addr)(def.instance, name.as_ptr()) }
        };
        let instance = functions::instance(def.instance, of_instance, false)?;
        let of_device = |name: &CStr| {
            // SAFETY: the caller's device, and its own loader.
            unsafe { instance.get_device_proc_addr(def.device, name.as_ptr()) }
        };
        let device = functions::device(def.device, of_device)?;
        // SAFETY: the caller's physical device.
        let (properties, memory, families) = unsafe {
            (
                instance.get_physical_device_properties(def.physical_device),
                instance.get_physical_device_memory_properties(def.physical_device),
                instance.get_physical_device_queue_family_properties(def.physical_device),
            )
        };
        check(def, &properties, &families)?;
        let (limits, family) = (properties.limits, def.queue_family);
        let cache = if fits(def.pipeline_cache, &properties) { def.pipeline_cache } else { &[] };
        let (made, leaks) = (AtomicU64::new(0), AtomicBool::new(false));
        Ok((VulkanDevice { device, memory, limits, family, made, leaks }, cache))
    }

    /// Leaks everything that is dropped from now on.
    pub(super) fn leak(&self) {
        self.leaks.store(true, Ordering::Relaxed);
    }

    /// Calls `destroy` with the device, unless objects are leaked.
    pub(super) fn destroy(&self, destroy: impl FnOnce(&ash::Device)) {
        if !self.leaks.load(Ordering::Relaxed) {
            destroy(&self.device);
        }
    }

    /// Whether a buffer's owner is another queue family.
    pub(super) fn foreign(&self, family: u32) -> bool {
        family != vk::QUEUE_FAMILY_IGNORED && family != self.family
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

    /// The number of objects that were counted.
    pub(super) fn objects_made(&self) -> u64 {
        self.made.load(Ordering::Relaxed)
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
        let expected = format!("one that computes: {}", good.collect::<Vec<_>>().join(", "));
        return Err(Error::invalid("queue_family", def.queue_family, &expected));
    }
    let limits = &properties.limits;
    let most = limits.max_compute_work_group_size[0].min(limits.max_compute_work_group_invocations);
    check_workgroup_size(def.workgroup_size, most)
}

/// Whether the data's header names this driver. Other data must not be handed to it.
fn fits(data: &[u8], properties: &vk::PhysicalDeviceProperties) -> bool {
    let word = |i: usize| Some(u32::from_le_bytes(data.get(4 * i..4 * i + 4)?.try_into().ok()?));
    word(0) == Some(32)
        && word(1) == Some(vk::PipelineCacheHeaderVersion::ONE.as_raw() as u32)
        && word(2) == Some(properties.vendor_id)
        && word(3) == Some(properties.device_id)
        && data.get(16..32) == Some(&properties.pipeline_cache_uuid)
}
