//! The instance and the VkDevice of a device of Crumple's own.

use super::functions::{self, failed};
use crate::base::error::Error;
use ash::vk;
use std::ffi::CStr;

#[cfg(not(windows))]
use ash::khr::{external_memory_fd as external_memory, external_semaphore_fd as external_semaphore};
#[cfg(windows)]
use ash::khr::{external_memory_win32 as external_memory, external_semaphore_win32 as external_semaphore};

#[cfg(not(windows))]
const IMPORT_SEMAPHORE: &CStr = c"vkImportSemaphoreFdKHR";
#[cfg(windows)]
const IMPORT_SEMAPHORE: &CStr = c"vkImportSemaphoreWin32HandleKHR";

/// An instance, and a physical device of it. The instance is destroyed last.
pub(super) struct OwnInstance {
    pub instance: ash::Instance,
    pub physical_device: vk::PhysicalDevice,
    /// A queue family that supports compute.
    pub family: u32,
}

/// The handles and functions of the own device. They are destroyed last.
pub(super) struct OwnHandles {
    pub device: ash::Device,
    /// `None` if the device cannot import semaphores.
    pub semaphores: Option<external_semaphore::Device>,
    pub queue: vk::Queue,
    pub pool: vk::CommandPool,
    pub instance: OwnInstance,
}

impl OwnInstance {
    /// Makes an instance, and chooses the physical device.
    ///
    /// # Safety
    /// The function is a loader's, which stays loaded while this lives.
    pub(super) unsafe fn new(
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        uuid: Option<[u8; vk::UUID_SIZE]>,
    ) -> Result<Self, Error> {
        // SAFETY: the caller's loader.
        let ask = |instance: vk::Instance, name: &CStr| unsafe { get_instance_proc_addr(instance, name.as_ptr()) };
        if ask(vk::Instance::null(), c"vkCreateInstance").is_none() {
            return Err(Error::Unsupported { what: "a Vulkan loader without vkCreateInstance".into() });
        }
        let app = vk::ApplicationInfo::default().application_name(c"crumple").api_version(vk::API_VERSION_1_1);
        let info = vk::InstanceCreateInfo::default().application_info(&app);
        // SAFETY: the caller's loader, which has the function that is called.
        let made = unsafe {
            ash::Entry::from_static_fn(ash::StaticFn { get_instance_proc_addr }).create_instance(&info, None)
        };
        let made = made.map_err(|result| match result {
            vk::Result::ERROR_INCOMPATIBLE_DRIVER => {
                Error::Unsupported { what: "a machine without a Vulkan driver".into() }
            }
            other => failed("vkCreateInstance")(other),
        })?;
        let of_instance = |name: &CStr| ask(made.handle(), name);
        let instance = functions::instance(made.handle(), of_instance, true).inspect_err(|_| {
            if of_instance(c"vkDestroyInstance").is_some() {
                // SAFETY: nothing else was made with the instance.
                unsafe { made.destroy_instance(None) };
            }
        })?;
        let mut own = OwnInstance { instance, physical_device: vk::PhysicalDevice::null(), family: 0 };
        own.choose(uuid)?;
        Ok(own)
    }

    /// Chooses the physical device, and a queue family that supports compute.
    fn choose(&mut self, uuid: Option<[u8; vk::UUID_SIZE]>) -> Result<(), Error> {
        let instance = &self.instance;
        // SAFETY: the instance is valid, and so are its devices, here and below.
        let devices = unsafe { instance.enumerate_physical_devices() }.map_err(failed("vkEnumeratePhysicalDevices"))?;
        let mut seen = Vec::new();
        for device in devices {
            // SAFETY: as above.
            let properties = unsafe { instance.get_physical_device_properties(device) };
            if properties.api_version < vk::API_VERSION_1_1 {
                continue;
            }
            let mut ids = vk::PhysicalDeviceIDProperties::default();
            let mut both = vk::PhysicalDeviceProperties2::default().push_next(&mut ids);
            // SAFETY: as above; a device of Vulkan 1.1 fills both.
            unsafe { instance.get_physical_device_properties2(device, &mut both) };
            let found = ids.device_uuid;
            let name = properties.device_name_as_c_str().unwrap_or_default().to_string_lossy().into_owned();
            seen.push(format!("{name} {}", hexadecimal(&found)));
            if uuid.is_some_and(|wanted| wanted != found) {
                continue;
            }
            // SAFETY: as above.
            let families = unsafe { instance.get_physical_device_queue_family_properties(device) };
            let computes = |q: &vk::QueueFamilyProperties| q.queue_flags.contains(vk::QueueFlags::COMPUTE);
            if let Some(family) = families.iter().position(computes) {
                (self.physical_device, self.family) = (device, family as u32);
                return Ok(());
            }
        }
        let wanted = uuid.map_or("with compute".into(), |u| format!("of UUID {}", hexadecimal(&u)));
        let there = if seen.is_empty() { "none".into() } else { seen.join(", ") };
        Err(Error::Unsupported { what: format!("a machine without a Vulkan 1.1 device {wanted}; there are: {there}") })
    }
}

impl Drop for OwnInstance {
    fn drop(&mut self) {
        // SAFETY: everything that was made with the instance was destroyed before.
        unsafe { self.instance.destroy_instance(None) };
    }
}

impl OwnHandles {
    /// Makes a device with one queue.
    pub(super) fn new(own: OwnInstance) -> Result<Self, Error> {
        let (instance, physical, family) = (&own.instance, own.physical_device, own.family);
        // SAFETY: a physical device of the instance.
        let extensions = unsafe { instance.enumerate_device_extension_properties(physical) }
            .map_err(failed("vkEnumerateDeviceExtensionProperties"))?;
        let has = |name: &CStr| extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
        if !has(external_memory::NAME) {
            let what =
                format!("a Vulkan device without {}, which shares memory", external_memory::NAME.to_string_lossy());
            return Err(Error::Unsupported { what });
        }
        let mut enabled = vec![external_memory::NAME.as_ptr()];
        let semaphores = has(external_semaphore::NAME);
        if semaphores {
            enabled.push(external_semaphore::NAME.as_ptr());
        }
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
        let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_extension_names(&enabled);
        // SAFETY: as above.
        let made = unsafe { instance.create_device(physical, &info, None) }.map_err(failed("vkCreateDevice"))?;
        let get = |name: &CStr| {
            // SAFETY: the device was made just now.
            unsafe { instance.get_device_proc_addr(made.handle(), name.as_ptr()) }
        };
        let device = functions::device(made.handle(), get).inspect_err(|_| {
            if get(c"vkDestroyDevice").is_some() {
                // SAFETY: nothing was made with the device.
                unsafe { made.destroy_device(None) };
            }
        })?;
        let semaphores = semaphores && get(IMPORT_SEMAPHORE).is_some();
        let semaphores = semaphores.then(|| external_semaphore::Device::new(instance, &device));
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER | vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: the device has this queue.
        let queue = unsafe { device.get_device_queue(family, 0) };
        let mut handles = OwnHandles { device, semaphores, queue, pool: vk::CommandPool::null(), instance: own };
        // SAFETY: as above.
        let pool = unsafe { handles.device.create_command_pool(&info, None) };
        handles.pool = pool.map_err(failed("vkCreateCommandPool"))?;
        Ok(handles)
    }
}

impl Drop for OwnHandles {
    fn drop(&mut self) {
        // SAFETY: everything else of the device was destroyed before; null handles are ignored.
        unsafe {
            self.device.destroy_command_pool(self.pool, None);
            self.device.destroy_device(None);
        }
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}
