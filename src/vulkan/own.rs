//! A device of Crumple's own, for hosts that share memory instead of a command buffer: what the host's device allocated and
//! exported is imported here, written, and given back through semaphores or a fence.

use super::device::{Device, DeviceDef};
use super::functions::{DeviceFnV1_0, InstanceFnV1_0, InstanceFnV1_1, checked, load};
use super::host::BufferId;
use super::import::{ImportedBuffer, SemaphoreId};
use super::record::{RecordJob, RecordReport};
use crate::Error;
use ash::vk;
use std::ffi::CStr;
use std::fmt;
use std::mem::ManuallyDrop;
use std::ptr::{null, null_mut};

/// Which device Crumple makes its own of.
#[derive(Debug, Clone)]
pub struct OwnDeviceDef<'a> {
    /// A loader: `vkGetInstanceProcAddr`. All functions are taken from it.
    pub get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
    /// `deviceUUID` of the host's physical device (`VkPhysicalDeviceIDProperties`): memory can be shared within it alone. `None`:
    /// the first that can compute.
    pub device_uuid: Option<[u8; vk::UUID_SIZE]>,
    /// As [`DeviceDef::pipeline_cache`].
    pub pipeline_cache: &'a [u8],
    /// As [`DeviceDef::workgroup_size`].
    pub workgroup_size: u32,
}

impl<'a> OwnDeviceDef<'a> {
    /// Of any device, without cached pipelines.
    pub fn new(get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr) -> Self {
        OwnDeviceDef { get_instance_proc_addr, device_uuid: None, pipeline_cache: &[], workgroup_size: 128 }
    }
}

/// What everything of the own device is made with, destroyed last.
pub(super) struct OwnHandles {
    pub instance: vk::Instance,
    pub instance_functions: (InstanceFnV1_0, InstanceFnV1_1),
    pub physical_device: vk::PhysicalDevice,
    pub device: vk::Device,
    pub functions: DeviceFnV1_0,
    /// Null where the device cannot.
    pub import_semaphore: vk::PFN_vkVoidFunction,
    queue: vk::Queue,
    family: u32,
    pool: vk::CommandPool,
}

/// A command buffer and the fence that tells when it was done.
struct Submission {
    frame: u64,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
    pending: bool,
}

/// A Vulkan device of Crumple's own, beside the host's on the same physical device.
///
/// Buffers and semaphores of the host come by [`OwnDevice::import_buffer`] and [`OwnDevice::import_semaphore`]; targets are added
/// to [`OwnDevice::device`], and [`OwnDevice::submit`] takes the place of [`Device::record`]. Dropping it waits for the device.
pub struct OwnDevice {
    device: ManuallyDrop<Device>,
    pub(super) own: OwnHandles,
    submissions: Vec<Submission>,
    pub(super) buffers: Vec<(BufferId, ImportedBuffer)>,
    pub(super) semaphores: Vec<vk::Semaphore>,
    frame: u64,
}

impl fmt::Debug for OwnDevice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OwnDevice").field("device", &*self.device).field("frame", &self.frame).finish_non_exhaustive()
    }
}

// SAFETY: Vulkan's handles belong to no thread, and all that uses them takes `&mut self`.
unsafe impl Send for OwnDevice {}
// SAFETY: the same.
unsafe impl Sync for OwnDevice {}

/// Extensions that sharing needs, and one that it can do without.
#[cfg(not(windows))]
const EXTENSIONS: (&CStr, &CStr, &CStr) =
    (c"VK_KHR_external_memory_fd", c"VK_KHR_external_semaphore_fd", c"vkImportSemaphoreFdKHR");
#[cfg(windows)]
const EXTENSIONS: (&CStr, &CStr, &CStr) =
    (c"VK_KHR_external_memory_win32", c"VK_KHR_external_semaphore_win32", c"vkImportSemaphoreWin32HandleKHR");

impl OwnDevice {
    /// Makes an instance and a device (some milliseconds to tenths of a second, as the driver is).
    ///
    /// # Errors
    /// [`Error::Unsupported`] where no device is there, none has this UUID (the text names those there are), it cannot import
    /// memory, or the loader lacks a function; [`Error::InvalidArgument`] for the workgroup size; [`Error::Vulkan`],
    /// [`Error::DeviceLost`].
    ///
    /// # Safety
    /// The loader is one, and stays loaded until this is dropped.
    pub unsafe fn new(def: &OwnDeviceDef<'_>) -> Result<Self, Error> {
        let get = def.get_instance_proc_addr;
        // SAFETY: the caller's loader.
        let ask = |instance: vk::Instance, name: &CStr| unsafe { get(instance, name.as_ptr()) };
        let Some(create) = ask(vk::Instance::null(), c"vkCreateInstance") else {
            return Err(Error::Unsupported { what: "a Vulkan loader without vkCreateInstance".into() });
        };
        // SAFETY: the function has this name.
        let create = unsafe { std::mem::transmute::<unsafe extern "system" fn(), vk::PFN_vkCreateInstance>(create) };
        let app = vk::ApplicationInfo::default().application_name(c"crumple").api_version(vk::API_VERSION_1_1);
        let info = vk::InstanceCreateInfo::default().application_info(&app);
        let mut instance = vk::Instance::null();
        // SAFETY: valid arguments that live through the call; so everywhere in this file.
        match unsafe { create(&info, null(), &mut instance) } {
            vk::Result::ERROR_INCOMPATIBLE_DRIVER => {
                return Err(Error::Unsupported { what: "a machine without a Vulkan driver".into() });
            }
            other => checked("vkCreateInstance", other)?,
        }
        let of_instance = |name: &CStr| ask(instance, name);
        let functions = load(|get| (InstanceFnV1_0::load(&mut *get), InstanceFnV1_1::load(get)), of_instance);
        let (functions, functions_1_1) = functions.inspect_err(|_| {
            // SAFETY: nothing else was made with the instance; the function is the one of this name.
            if let Some(destroy) = ask(instance, c"vkDestroyInstance") {
                // SAFETY: as above.
                unsafe {
                    std::mem::transmute::<unsafe extern "system" fn(), vk::PFN_vkDestroyInstance>(destroy)(
                        instance,
                        null(),
                    )
                }
            }
        })?;
        let own = OwnHandles::new(instance, (functions, functions_1_1), def.device_uuid)?;
        let device = DeviceDef {
            get_instance_proc_addr: get,
            instance: own.instance,
            physical_device: own.physical_device,
            device: own.device,
            queue_family: own.family,
            pipeline_cache: def.pipeline_cache,
            workgroup_size: def.workgroup_size,
        };
        // SAFETY: handles made just now, which outlive the device: they are destroyed after it is dropped.
        let device = ManuallyDrop::new(unsafe { Device::new(&device) }?);
        let (submissions, buffers, semaphores) = (Vec::new(), Vec::new(), Vec::new());
        Ok(OwnDevice { device, own, submissions, buffers, semaphores, frame: 0 })
    }

    /// Where targets are added, and where frames and pipelines can be asked about. It must not record or complete frames:
    /// [`OwnDevice::submit`] does.
    pub fn device(&mut self) -> &mut Device {
        &mut self.device
    }

    pub(super) fn id(&self) -> u64 {
        self.device.id
    }

    /// Brings the targets up to date: records the blocks that changed since each was last written, and submits that. Waits for
    /// each of `wait` before and signals each of `signal` after, also where nothing changed. Answers the number of the frame, for
    /// [`OwnDevice::wait`], and what was recorded. Nothing is waited for here.
    ///
    /// # Errors
    /// Those of [`Device::record`], and [`Error::InvalidArgument`] for a semaphore that is not there. Nothing was submitted then.
    pub fn submit(
        &mut self,
        jobs: &mut [RecordJob<'_>],
        wait: &[SemaphoreId],
        signal: &[SemaphoreId],
    ) -> Result<(u64, RecordReport), Error> {
        let wait = self.handles(wait)?;
        let signal = self.handles(signal)?;
        self.poll()?;
        let slot = self.submission()?;
        let (commands, fence) = (self.submissions[slot].commands, self.submissions[slot].fence);
        let f = &self.own.functions;
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the fence of the command buffer's last use has signalled.
        unsafe {
            checked("vkResetFences", (f.reset_fences)(self.own.device, 1, &fence))?;
            checked("vkBeginCommandBuffer", (f.begin_command_buffer)(commands, &begin))?;
        }
        let frame = self.frame + 1;
        // SAFETY: the command buffer is recording.
        let recorded = unsafe { self.device.record(commands, frame, jobs) };
        // SAFETY: it was begun.
        let ended = checked("vkEndCommandBuffer", unsafe { (f.end_command_buffer)(commands) });
        let report = recorded?;
        let stages = vec![vk::PipelineStageFlags::ALL_COMMANDS; wait.len()];
        let all = [commands];
        let submit = vk::SubmitInfo::default()
            .command_buffers(&all)
            .wait_semaphores(&wait)
            .wait_dst_stage_mask(&stages)
            .signal_semaphores(&signal);
        let submitted = ended.and_then(|()| {
            // SAFETY: the queue is used here alone.
            checked("vkQueueSubmit", unsafe { (f.queue_submit)(self.own.queue, 1, &submit, fence) })
        });
        if let Err(error) = submitted {
            // What was recorded will not run.
            self.device.discard(frame);
            jobs.iter_mut().filter(|j| j.target.written_in() == frame).for_each(|j| j.target.invalidate());
            return Err(error);
        }
        self.frame = frame;
        self.submissions[slot].frame = frame;
        self.submissions[slot].pending = true;
        Ok((frame, report))
    }

    /// The last frame that was submitted; 0 for none.
    pub fn last_submitted(&self) -> u64 {
        self.frame
    }

    /// Waits until the device is done with a frame, or for so many nanoseconds; answers whether it is done. `u64::MAX` waits for as
    /// long as it takes.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a frame that was not submitted; [`Error::Vulkan`], [`Error::DeviceLost`].
    pub fn wait(&mut self, frame: u64, nanoseconds: u64) -> Result<bool, Error> {
        if frame > self.frame {
            return Err(Error::invalid("frame", frame, &format!("at most {}, the last submitted", self.frame)));
        }
        let f = &self.own.functions;
        let pending = self.submissions.iter().filter(|s| s.pending && s.frame <= frame).map(|s| s.fence);
        let fences: Vec<vk::Fence> = pending.collect();
        if !fences.is_empty() {
            let count = fences.len() as u32;
            // SAFETY: fences of this device.
            match unsafe { (f.wait_for_fences)(self.own.device, count, fences.as_ptr(), vk::TRUE, nanoseconds) } {
                vk::Result::TIMEOUT => return Ok(false),
                other => checked("vkWaitForFences", other)?,
            }
        }
        self.poll()?;
        Ok(true)
    }

    /// Notes what is done.
    fn poll(&mut self) -> Result<(), Error> {
        let f = &self.own.functions;
        for s in self.submissions.iter_mut().filter(|s| s.pending) {
            // SAFETY: a fence of this device.
            match unsafe { (f.get_fence_status)(self.own.device, s.fence) } {
                vk::Result::NOT_READY => {}
                other => {
                    checked("vkGetFenceStatus", other)?;
                    s.pending = false;
                }
            }
        }
        // Fences of one queue signal in order.
        let oldest = self.submissions.iter().filter(|s| s.pending).map(|s| s.frame).min();
        self.device.completed(oldest.map_or(self.frame, |frame| frame - 1));
        Ok(())
    }

    /// A submission that is not pending.
    fn submission(&mut self) -> Result<usize, Error> {
        if let Some(free) = self.submissions.iter().position(|s| !s.pending) {
            return Ok(free);
        }
        let (f, device) = (&self.own.functions, self.own.device);
        let (mut commands, mut fence) = (vk::CommandBuffer::null(), vk::Fence::null());
        let info = vk::CommandBufferAllocateInfo::default().command_pool(self.own.pool).command_buffer_count(1);
        // SAFETY: a pool of this device; it goes with its command buffers.
        checked("vkAllocateCommandBuffers", unsafe { (f.allocate_command_buffers)(device, &info, &mut commands) })?;
        let info = vk::FenceCreateInfo::default();
        // SAFETY: as above.
        checked("vkCreateFence", unsafe { (f.create_fence)(device, &info, null(), &mut fence) })?;
        self.submissions.push(Submission { frame: 0, commands, fence, pending: false });
        Ok(self.submissions.len() - 1)
    }
}

impl Drop for OwnDevice {
    fn drop(&mut self) {
        let f = &self.own.functions;
        // SAFETY: everything was made with this device; it is idle, or lost, in which case nothing runs any more either.
        unsafe {
            let _ = (f.device_wait_idle)(self.own.device);
            self.device.completed(u64::MAX);
            ManuallyDrop::drop(&mut self.device);
            for (_, buffer) in &self.buffers {
                buffer.destroy(&self.own);
            }
            for s in &self.semaphores {
                (f.destroy_semaphore)(self.own.device, *s, null());
            }
            for s in &self.submissions {
                (f.destroy_fence)(self.own.device, s.fence, null());
            }
        }
    }
}

impl OwnHandles {
    /// Takes over the instance.
    fn new(
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
                // SAFETY: nothing of the instance is left.
                unsafe { (functions.0.destroy_instance)(instance, null()) };
                Err(error)
            }
        }
    }

    /// The physical device, and a family of it that computes.
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
        let wanted = uuid.map_or("that computes".into(), |u| format!("of UUID {}", hexadecimal(&u)));
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
            let what = format!("a Vulkan device without {}, by which memory is shared", memory.to_string_lossy());
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
