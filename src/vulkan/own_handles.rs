//! The instance and the VkDevice of a device of Crumple's own.

use super::functions::{DeviceFnV1_0, InstanceFnV1_0, InstanceFnV1_1, checked, load};
use crate::base::error::Error;
use ash::vk;
use std::ffi::CStr;
use std::ptr::{null, null_mut};

/// The handles and functions of the own device. They are destroyed last.
pub(super) struct OwnHandles {
    pub instance: vk::Instance,
    pub instance_functions: (InstanceFnV1_0, InstanceFnV1_1),
    pub physical_device: vk::PhysicalDevice,
    pub device: vk::Device,
    pub functions: DeviceFnV1_0,
    /// `None` if the device cannot import semaphores.
    pub import_semaphore: vk::PFN_vkVoidFunction,
    pub queue: vk::Queue,
    pub family: u32,
    pub pool: vk::CommandPool,
}

/// The extension for memory, the extension for semaphores, and the function of the latter. The last two are optional.
#[cfg(not(windows))]
const EXTENSIONS: (&CStr, &CStr, &CStr) =
    (c"VK_KHR_external_memory_fd", c"VK_KHR_external_semaphore_fd", c"vkImportSemaphoreFdKHR");
#[cfg(windows)]
const EXTENSIONS: (&CStr, &CStr, &CStr) =
    (c"VK_KHR_external_memory_win32", c"VK_KHR_external_semaphore_win32", c"vkImportSemaphoreWin32HandleKHR");

impl OwnHandles {
    /// Takes over the instance.
    pub(super) fn new(
        instance: vk::Instance,
        functions: (InstanceFnV1_0, InstanceFnV1_1),
        uuid: Option<[u8; vk::UUID_SIZE]>,
    ) -> Result<Self, Error> {
        let made = Self::choose(instance, &functions, uuid).and_then(|(physical_device, family)| {
            Self::make(&functions.0, physical_device, family).map(|made| (physical_device, family, made))
        });
        match made {
            Ok((physical_device, family, (device, device_functions, import_semaphore, queue, pool))) => {
                Ok(OwnHandles {
                    instance,
                    instance_functions: functions,
                    physical_device,
                    device,
                    functions: device_functions,
                    import_semaphore,
                    queue,
                    family,
                    pool,
                })
            }
            Err(error) => {
                // SAFETY: nothing that was made with the instance is left.
                unsafe { (functions.0.destroy_instance)(instance, null()) };
                Err(error)
            }
        }
    }

    /// Chooses the physical device, and a queue family that supports compute.
    fn choose(
        instance: vk::Instance,
        (f, f_1_1): &(InstanceFnV1_0, InstanceFnV1_1),
        uuid: Option<[u8; vk::UUID_SIZE]>,
    ) -> Result<(vk::PhysicalDevice, u32), Error> {
        let mut count = 0;
        // SAFETY: the instance is valid; room for `count` below.
        checked("vkEnumeratePhysicalDevices", unsafe {
            (f.enumerate_physical_devices)(instance, &mut count, null_mut())
        })?;
        let mut devices = vec![vk::PhysicalDevice::null(); count as usize];
        // SAFETY: as above.
        let listed = unsafe { (f.enumerate_physical_devices)(instance, &mut count, devices.as_mut_ptr()) };
        checked("vkEnumeratePhysicalDevices", listed)?;
        let mut seen = Vec::new();
        for device in devices {
            let mut properties = vk::PhysicalDeviceProperties::default();
            // SAFETY: a device of the instance, here and below.
            unsafe { (f.get_physical_device_properties)(device, &mut properties) };
            if properties.api_version < vk::API_VERSION_1_1 {
                continue;
            }
            let mut ids = vk::PhysicalDeviceIDProperties::default();
            let mut both = vk::PhysicalDeviceProperties2::default().push_next(&mut ids);
            // SAFETY: as above; a device of Vulkan 1.1 fills both.
            unsafe { (f_1_1.get_physical_device_properties2)(device, &mut both) };
            let found = ids.device_uuid;
            let name = properties.device_name_as_c_str().unwrap_or_default().to_string_lossy().into_owned();
            seen.push(format!("{name} {}", hexadecimal(&found)));
            if uuid.is_some_and(|wanted| wanted != found) {
                continue;
            }
            // SAFETY: as above.
            unsafe { (f.get_physical_device_queue_family_properties)(device, &mut count, null_mut()) };
            let mut families = vec![vk::QueueFamilyProperties::default(); count as usize];
            // SAFETY: as above; there is room for `count`.
            unsafe { (f.get_physical_device_queue_family_properties)(device, &mut count, families.as_mut_ptr()) };
            let computes = |q: &vk::QueueFamilyProperties| q.queue_flags.contains(vk::QueueFlags::COMPUTE);
            if let Some(family) = families.iter().position(computes) {
                return Ok((device, family as u32));
            }
        }
        let wanted = uuid.map_or("with compute".into(), |u| format!("of UUID {}", hexadecimal(&u)));
        let there = if seen.is_empty() { "none".into() } else { seen.join(", ") };
        Err(Error::Unsupported { what: format!("a machine without a Vulkan 1.1 device {wanted}; there are: {there}") })
    }

    fn make(f: &InstanceFnV1_0, physical: vk::PhysicalDevice, family: u32) -> Result<Made, Error> {
        let (memory, semaphore, import) = EXTENSIONS;
        let mut count = 0;
        // SAFETY: a physical device of the instance; room for `count` below.
        let listed = unsafe { (f.enumerate_device_extension_properties)(physical, null(), &mut count, null_mut()) };
        checked("vkEnumerateDeviceExtensionProperties", listed)?;
        let mut extensions = vec![vk::ExtensionProperties::default(); count as usize];
        // SAFETY: as above.
        let listed =
            unsafe { (f.enumerate_device_extension_properties)(physical, null(), &mut count, extensions.as_mut_ptr()) };
        checked("vkEnumerateDeviceExtensionProperties", listed)?;
        let has = |name: &CStr| extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
        if !has(memory) {
            let what = format!("a Vulkan device without {}, which shares memory", memory.to_string_lossy());
            return Err(Error::Unsupported { what });
        }
        let mut enabled = vec![memory.as_ptr()];
        let semaphores = has(semaphore);
        if semaphores {
            enabled.push(semaphore.as_ptr());
        }
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
        let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_extension_names(&enabled);
        let mut device = vk::Device::null();
        // SAFETY: as above.
        checked("vkCreateDevice", unsafe { (f.create_device)(physical, &info, null(), &mut device) })?;
        let get = |name: &CStr| {
            // SAFETY: the device was made just now.
            unsafe { (f.get_device_proc_addr)(device, name.as_ptr()) }
        };
        let functions = load(|get| DeviceFnV1_0::load(get), get).inspect_err(|_| {
            if let Some(destroy) = get(c"vkDestroyDevice") {
                // SAFETY: nothing was made with the device; the function is the one of this name.
                unsafe {
                    std::mem::transmute::<unsafe extern "system" fn(), vk::PFN_vkDestroyDevice>(destroy)(device, null())
                }
            }
        })?;
        let (mut queue, mut pool) = (vk::Queue::null(), vk::CommandPool::null());
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER | vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: the device has this queue.
        let made = unsafe {
            (functions.get_device_queue)(device, family, 0, &mut queue);
            (functions.create_command_pool)(device, &info, null(), &mut pool)
        };
        checked("vkCreateCommandPool", made).inspect_err(|_| {
            // SAFETY: nothing else was made with the device.
            unsafe { (functions.destroy_device)(device, null()) }
        })?;
        let import = semaphores.then(|| get(import)).flatten();
        Ok((device, functions, import, queue, pool))
    }
}

type Made = (vk::Device, DeviceFnV1_0, vk::PFN_vkVoidFunction, vk::Queue, vk::CommandPool);

impl Drop for OwnHandles {
    fn drop(&mut self) {
        // SAFETY: everything else of the device was destroyed before.
        unsafe {
            (self.functions.destroy_command_pool)(self.device, self.pool, null());
            (self.functions.destroy_device)(self.device, null());
            (self.instance_functions.0.destroy_instance)(self.instance, null());
        }
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}
