//! Wraps an engine's Vulkan device and buffers for wgpu. The engine keeps owning them.

use super::device::Device;
use super::headless::{descriptor, exact};
use super::wgpu_device::{DeviceDef, one_line};
use crate::base::error::Error;
use ash::khr;
use ash::vk::{self, Handle};
use std::ffi::CStr;
use wgpu::hal;

type Vulkan = hal::api::Vulkan;

/// An engine's Vulkan device.
#[derive(Clone)]
pub struct VulkanDef<'a> {
    /// The loader that the instance was made with: `vkGetInstanceProcAddr`. All functions are taken from it.
    pub get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
    /// The instance.
    pub instance: vk::Instance,
    /// `apiVersion` of the instance's VkApplicationInfo, Vulkan 1.1 or later. wgpu calls functions of the physical device's version,
    /// so `apiVersion` must be at least that version or 1.3.
    pub api_version: u32,
    /// All extensions that were enabled on it.
    pub instance_extensions: &'a [&'static CStr],
    /// The physical device.
    pub physical_device: vk::PhysicalDevice,
    /// The device; null is allowed for [`VulkanDef::wanted_extensions`].
    pub device: vk::Device,
    /// All extensions that were enabled on it.
    pub device_extensions: &'a [&'static CStr],
    /// Family of the queue that wgpu submits to. It must support compute.
    pub queue_family: u32,
    /// The queue in that family.
    pub queue_index: u32,
}

impl VulkanDef<'_> {
    /// Returns the extensions that the VkDevice must be made with, in addition to the engine's own. wgpu uses them wherever the
    /// physical device has them. Call this before vkCreateDevice.
    ///
    /// The VkDevice also needs the features of these extensions, since wgpu assumes that every feature of the physical device is
    /// enabled. Only `timelineSemaphore` matters here (`VkPhysicalDeviceTimelineSemaphoreFeatures`, or that of Vulkan 1.2).
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a null handle; [`Error::Unsupported`] for a loader that lacks a function, or a physical
    /// device that wgpu cannot use.
    ///
    /// # Safety
    /// Instance and physical device are valid and belong together; versions and extensions are as the definition says.
    pub unsafe fn wanted_extensions(&self) -> Result<Vec<&'static CStr>, Error> {
        // SAFETY: the caller's promise.
        let (_, exposed) = unsafe { self.expose()? };
        Ok(wanted(&exposed))
    }

    /// # Safety
    /// As [`VulkanDef::wanted_extensions`].
    unsafe fn expose(&self) -> Result<(wgpu::Instance, hal::ExposedAdapter<Vulkan>), Error> {
        let named =
            [("the VkInstance", self.instance.is_null()), ("the VkPhysicalDevice", self.physical_device.is_null())];
        if let Some((name, _)) = named.iter().find(|(_, null)| *null) {
            return Err(Error::invalid(name, "null", "a valid handle"));
        }
        for name in [c"vkGetDeviceProcAddr", c"vkGetPhysicalDeviceProperties", c"vkEnumerateDeviceExtensionProperties"]
        {
            // SAFETY: the caller's loader and instance.
            if unsafe { (self.get_instance_proc_addr)(self.instance, name.as_ptr()) }.is_none() {
                let name = name.to_string_lossy();
                return Err(Error::Unsupported { what: format!("a Vulkan loader without {name} for its instance") });
            }
        }
        let functions = ash::StaticFn { get_instance_proc_addr: self.get_instance_proc_addr };
        // SAFETY: the caller's loader and instance. The instance stays the engine's, as the callback says; wgpu calls no
        // function of an extension that is not listed.
        let instance = unsafe {
            let raw = ash::Instance::load(&functions, self.instance);
            hal::vulkan::Instance::from_raw(
                ash::Entry::from_static_fn(functions),
                raw,
                self.api_version,
                0,
                None,
                self.instance_extensions.to_vec(),
                wgpu::InstanceFlags::empty(),
                wgpu::MemoryBudgetThresholds::default(),
                false,
                Some(Box::new(|| ())),
            )
        };
        let failed = |e: hal::InstanceError| Error::Wgpu { call: "adopting a VkInstance".into(), what: e.to_string() };
        let instance = instance.map_err(failed)?;
        // SAFETY: the caller's physical device.
        let properties =
            unsafe { instance.shared_instance().raw_instance().get_physical_device_properties(self.physical_device) };
        let needed = properties.api_version.clamp(vk::API_VERSION_1_1, vk::API_VERSION_1_3);
        if self.api_version < vk::make_api_version(0, vk::api_version_major(needed), vk::api_version_minor(needed), 0) {
            let version = |v| format!("{}.{}", vk::api_version_major(v), vk::api_version_minor(v));
            let (is, needed) = (version(self.api_version), version(needed));
            let what = format!("an instance of Vulkan {is}; for this physical device wgpu needs one of {needed}");
            return Err(Error::Unsupported { what });
        }
        let exposed = instance.expose_adapter(self.physical_device).ok_or_else(|| Error::Unsupported {
            what: "a physical device that wgpu cannot use: it lacks what WebGPU needs".into(),
        })?;
        // SAFETY: a valid instance.
        Ok((unsafe { wgpu::Instance::from_hal::<Vulkan>(instance) }, exposed))
    }
}

impl Device {
    /// Takes an engine's Vulkan device. The engine keeps owning it: nothing here destroys it.
    ///
    /// wgpu submits to the engine's queue whenever something is submitted or read here. The engine keeps its other threads off that
    /// queue meanwhile, as vkQueueSubmit demands. The engine's own barriers order its earlier and later submissions against these. Before: what uses a target's buffer (vertex fetch,
    /// transfer) → `COMPUTE_SHADER`, `SHADER_WRITE`; after: `COMPUTE_SHADER`, `SHADER_WRITE` → what uses it next. Other queues
    /// need semaphores: `add_wait_semaphore` and `add_signal_semaphore` of the queue that `as_hal` returns.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a null handle, and for an extension that wgpu wants and the list of enabled ones lacks
    /// ([`VulkanDef::wanted_extensions`]); [`Error::Unsupported`] and [`Error::Wgpu`] as there; and those of [`Device::new`].
    ///
    /// # Safety
    /// The handles are valid, belong together, and stay valid until the device, and all buffers that were adopted or made on it,
    /// are dropped. Versions and extensions are as the definition says, the features of the extensions are enabled. There is such a queue.
    pub unsafe fn adopt(vulkan: &VulkanDef<'_>, def: &DeviceDef) -> Result<Self, Error> {
        if vulkan.device.is_null() {
            return Err(Error::invalid("the VkDevice", "null", "a valid handle"));
        }
        // SAFETY: the caller's promise.
        let (instance, exposed) = unsafe { vulkan.expose()? };
        let wanted = wanted(&exposed);
        if let Some(missing) = wanted.iter().find(|name| !vulkan.device_extensions.contains(*name)) {
            let (missing, wanted) = (missing.to_string_lossy(), names(&wanted));
            let value = names(vulkan.device_extensions);
            return Err(Error::invalid(
                "device_extensions",
                value,
                &format!("with {missing} too; wgpu wants {wanted}"),
            ));
        }
        let (limits, features) = (exposed.capabilities.limits.clone(), exact(exposed.features));
        // SAFETY: the caller's device, made with what wgpu wants; it stays the caller's, as the callback says.
        let open = unsafe {
            let raw = ash::Device::load(exposed.adapter.shared_instance().raw_instance().fp_v1_0(), vulkan.device);
            exposed.adapter.device_from_raw(
                raw,
                Some(Box::new(|| ())),
                vulkan.device_extensions,
                features,
                &limits,
                &wgpu::MemoryHints::Performance,
                vulkan.queue_family,
                vulkan.queue_index,
            )
        };
        let call = || "adopting a VkDevice".to_string();
        let open = open.map_err(|e| Error::Wgpu { call: call(), what: e.to_string() })?;
        let descriptor = descriptor(features, limits);
        // SAFETY: of one instance, adapter and device.
        let made = unsafe {
            let adapter = instance.create_adapter_from_hal::<Vulkan>(exposed);
            adapter.create_device_from_hal::<Vulkan>(open, &descriptor)
        };
        let (device, queue) = made.map_err(|e| Error::Wgpu { call: call(), what: one_line(&e.to_string()) })?;
        Self::with(device, queue, def, true)
    }

    /// Wraps a VkBuffer of an adopted device, or of any wgpu device on Vulkan, as a buffer for targets. It stays the engine's.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a null buffer, a size below 4, a usage without `STORAGE` or with mapping, indirect or
    /// query flags, which a wrapped buffer cannot have; [`Error::Unsupported`] where the device is not Vulkan;
    /// [`Error::Wgpu`].
    ///
    /// # Safety
    /// The buffer is one of this VkDevice, bound to memory, of this size, made with the Vulkan flags of this usage
    /// (`VK_BUFFER_USAGE_STORAGE_BUFFER_BIT` and so on), owned by the queue's family or shared, and lives until the wrapped
    /// buffer and its targets are dropped and everything that was submitted with them is done.
    pub unsafe fn adopt_buffer(
        &self,
        buffer: vk::Buffer,
        size: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, Error> {
        use wgpu::BufferUsages as U;
        let possible = U::STORAGE | U::VERTEX | U::INDEX | U::UNIFORM | U::COPY_SRC | U::COPY_DST;
        if buffer.is_null() {
            return Err(Error::invalid("the VkBuffer", "null", "a valid handle"));
        }
        if size < 4 {
            return Err(Error::invalid("the buffer's size", size, "at least 4 bytes"));
        }
        if !usage.contains(U::STORAGE) || !possible.contains(usage) {
            let expected = format!("with STORAGE among its flags, and none but {possible:?}");
            return Err(Error::invalid("the buffer's usage", format!("{usage:?}"), &expected));
        }
        // SAFETY: only asked for.
        if unsafe { self.gpu.device.as_hal::<Vulkan>() }.is_none() {
            let backend = self.gpu.device.adapter_info().backend;
            return Err(Error::Unsupported {
                what: format!("a VkBuffer on a device of {backend:?}; it must be Vulkan"),
            });
        }
        let descriptor =
            wgpu::BufferDescriptor { label: Some("crumple: adopted"), size, usage, mapped_at_creation: false };
        // SAFETY: the caller's buffer, which outlives the wrapped one; as the callback says, it stays the caller's.
        self.gpu.checked("adopting a VkBuffer", 0, || unsafe {
            let raw = hal::vulkan::Buffer::from_raw_externally_owned(buffer, Box::new(|| ()));
            self.gpu.device.create_buffer_from_hal::<Vulkan>(raw, &descriptor)
        })
    }
}

/// The extensions that wgpu enables on its own devices, without those that present: they need more of the instance, and nothing
/// here presents.
fn wanted(exposed: &hal::ExposedAdapter<Vulkan>) -> Vec<&'static CStr> {
    let mut all = exposed.adapter.required_device_extensions(exact(exposed.features));
    all.retain(|name| ![khr::swapchain::NAME, khr::swapchain_mutable_format::NAME].contains(name));
    all
}

fn names(extensions: &[&CStr]) -> String {
    let names: Vec<_> = extensions.iter().map(|e| e.to_string_lossy()).collect();
    if names.is_empty() { "none".into() } else { names.join(", ") }
}
