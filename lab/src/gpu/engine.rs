//! An engine as small as can be: the devices that the loader finds, one queue each, buffers, and what a piece of work takes on
//! the device. No extension, no feature, no layer: validation would be what is measured.

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, ensure};
use ash::{Entry, vk};
use crumple::vulkan::{Access, BufferDef, Device, DeviceDef};

use super::buffer::{Buffer, Place};

/// The loader and an instance.
pub struct Loader {
    entry: Entry,
    instance: ash::Instance,
    /// What was asked for.
    version: u32,
}

impl Loader {
    /// # Errors
    /// Where there is no loader, or none of its drivers can be used; says what is missing.
    pub fn open() -> Result<Arc<Self>> {
        // SAFETY: the system's loader.
        let entry = unsafe { Entry::load() }.map_err(|e| {
            anyhow!("there is no Vulkan loader ({e}); it comes with a graphics driver, or as libvulkan1 (Debian)")
        })?;
        // SAFETY: a loaded library.
        let offered = unsafe { entry.try_enumerate_instance_version()? }.unwrap_or(vk::API_VERSION_1_0);
        let version = offered.min(vk::API_VERSION_1_2);
        let app = vk::ApplicationInfo::default().api_version(version);
        let info = vk::InstanceCreateInfo::default().application_info(&app);
        // SAFETY: valid arguments; destroyed in `drop`.
        let instance = unsafe { entry.create_instance(&info, None) }.map_err(|e| {
            anyhow!(
                "the Vulkan loader finds no driver that it can use ({e}); install one (mesa-vulkan-drivers has a software \
                 driver), or name one's manifest in VK_DRIVER_FILES"
            )
        })?;
        Ok(Arc::new(Loader { entry, instance, version }))
    }

    /// Every device that there is.
    pub fn devices(self: &Arc<Self>) -> Result<Vec<Gpu>> {
        // SAFETY: a valid instance.
        let devices = unsafe { self.instance.enumerate_physical_devices() }?;
        ensure!(!devices.is_empty(), "the Vulkan drivers that are there have no device");
        devices.into_iter().map(|d| Gpu::new(self.clone(), d)).collect()
    }
}

impl Drop for Loader {
    fn drop(&mut self) {
        // SAFETY: devices hold on to the loader, so none is left.
        unsafe { self.instance.destroy_instance(None) };
    }
}

/// A device with one queue.
pub struct Gpu {
    pub name: String,
    /// Driver and its version, as they call themselves.
    pub driver: String,
    /// Runs on the CPU.
    pub software: bool,
    pub device: ash::Device,
    pub limits: vk::PhysicalDeviceLimits,
    pub(super) memory: vk::PhysicalDeviceMemoryProperties,
    loader: Arc<Loader>,
    physical: vk::PhysicalDevice,
    family: u32,
    graphics: bool,
    queue: vk::Queue,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
    queries: Option<vk::QueryPool>,
    /// The bits of a timestamp that count.
    mask: u64,
}

impl Gpu {
    fn new(loader: Arc<Loader>, physical: vk::PhysicalDevice) -> Result<Self> {
        let instance = &loader.instance;
        // SAFETY: a valid device, here and below.
        let properties = unsafe { instance.get_physical_device_properties(physical) };
        let name = properties.device_name_as_c_str()?.to_string_lossy().into_owned();
        let software = properties.device_type == vk::PhysicalDeviceType::CPU;
        // SAFETY: as above.
        let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
        use vk::QueueFlags as Q;
        let with = |flags: Q| families.iter().position(|f| f.queue_flags.contains(flags));
        // Engines draw with the queue that they record for.
        let family = with(Q::GRAPHICS | Q::COMPUTE).or_else(|| with(Q::COMPUTE));
        let family = family.with_context(|| format!("{name} has no queue that computes"))?;
        let bits = families[family].timestamp_valid_bits;
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family as u32).queue_priorities(&[1.0])];
        let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
        // SAFETY: valid arguments; everything is destroyed in `drop`.
        unsafe {
            let device = instance.create_device(physical, &info, None)?;
            let pool = vk::CommandPoolCreateInfo::default().queue_family_index(family as u32);
            let pool = device.create_command_pool(&pool, None)?;
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(pool)
                .level(vk::CommandBufferLevel::PRIMARY)
                .command_buffer_count(1);
            let commands = device.allocate_command_buffers(&info)?[0];
            let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(2);
            let queries = if bits > 0 { Some(device.create_query_pool(&info, None)?) } else { None };
            Ok(Gpu {
                driver: driver(&loader, physical, &properties),
                name,
                software,
                limits: properties.limits,
                memory: instance.get_physical_device_memory_properties(physical),
                physical,
                family: family as u32,
                graphics: families[family].queue_flags.contains(Q::GRAPHICS),
                queue: device.get_device_queue(family as u32, 0),
                pool,
                commands,
                fence: device.create_fence(&vk::FenceCreateInfo::default(), None)?,
                queries,
                mask: u64::MAX.checked_shr(64 - bits).unwrap_or(0),
                device,
                loader,
            })
        }
    }

    /// What times are measured with.
    pub fn clock(&self) -> String {
        match self.queries {
            Some(_) => format!("timestamps of the device, {} ns each", self.limits.timestamp_period),
            None => "the CPU's clock around a submission: the queue has no timestamps".to_owned(),
        }
    }

    /// Whether a workgroup may have so many invocations.
    pub fn has_workgroup(&self, size: u32) -> bool {
        size <= self.limits.max_compute_work_group_size[0].min(self.limits.max_compute_work_group_invocations)
    }

    /// The library on this device.
    pub fn crumple(&self, workgroup_size: u32) -> Result<Device> {
        let get = self.loader.entry.static_fn().get_instance_proc_addr;
        let def = DeviceDef::new(get, self.loader.instance.handle(), self.physical, self.device.handle(), self.family);
        // SAFETY: valid handles that belong together; `Recorded` drops the library's device first.
        Ok(unsafe { Device::new(&DeviceDef { workgroup_size, ..def }) }?)
    }

    /// A vertex buffer as the library is told of it.
    pub fn def(&self, buffer: &Buffer<'_>) -> BufferDef {
        // Queues that cannot draw have no stage that fetches vertices.
        let all = Access { stages: vk::PipelineStageFlags::ALL_COMMANDS, access: vk::AccessFlags::MEMORY_READ };
        let access = if self.graphics { Access::VERTEX_INPUT } else { all };
        BufferDef {
            buffer: buffer.handle,
            size: buffer.size,
            usage: Buffer::USAGE,
            queue_family: vk::QUEUE_FAMILY_IGNORED,
            before: access,
            after: access,
        }
    }

    /// Memory of the device.
    pub fn local(&self, size: u64) -> Result<Buffer<'_>> {
        Buffer::new(self, size, Place::Device)
    }

    /// Begins the one command buffer, with the first timestamp; nothing is in flight. Everything that earlier submissions wrote
    /// is visible to everything recorded.
    pub fn begin(&self) -> Result<vk::CommandBuffer> {
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the command buffer is not in flight: `finish` waits.
        unsafe {
            self.device.reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty())?;
            self.device.begin_command_buffer(self.commands, &begin)?;
        }
        self.barrier(self.commands);
        if let Some(queries) = self.queries {
            // SAFETY: the command buffer is recording.
            unsafe { self.device.cmd_reset_query_pool(self.commands, queries, 0, 2) };
        }
        self.stamp(0);
        Ok(self.commands)
    }

    /// Submits what was recorded since `begin` and waits for it; answers what it took on the device.
    pub fn finish(&self) -> Result<Duration> {
        self.stamp(1);
        let all = [self.commands];
        let submit = vk::SubmitInfo::default().command_buffers(&all);
        let start = Instant::now();
        // SAFETY: the command buffer is recording; the fence is not in use.
        unsafe {
            self.device.end_command_buffer(self.commands)?;
            self.device.queue_submit(self.queue, &[submit], self.fence)?;
            self.device.wait_for_fences(&[self.fence], true, u64::MAX)?;
            self.device.reset_fences(&[self.fence])?;
        }
        let waited = start.elapsed();
        let Some(queries) = self.queries else { return Ok(waited) };
        let mut stamps = [0u64; 2];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        // SAFETY: both queries were written by what has completed.
        unsafe { self.device.get_query_pool_results(queries, 0, &mut stamps, flags)? };
        let ticks = stamps[1].wrapping_sub(stamps[0]) & self.mask;
        Ok(Duration::from_secs_f64(ticks as f64 * f64::from(self.limits.timestamp_period) * 1e-9))
    }

    /// What `record` records takes on the device.
    pub fn timed(&self, record: impl FnOnce(vk::CommandBuffer)) -> Result<Duration> {
        record(self.begin()?);
        self.finish()
    }

    /// Once all that was recorded before it is done.
    fn stamp(&self, query: u32) {
        if let Some(queries) = self.queries {
            let after = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
            // SAFETY: the command buffer is recording; the queries were reset.
            unsafe { self.device.cmd_write_timestamp(self.commands, after, queries, query) };
        }
    }

    /// Everything before it is done and visible to everything behind it.
    pub fn barrier(&self, commands: vk::CommandBuffer) {
        let all = vk::PipelineStageFlags::ALL_COMMANDS;
        let memory = [vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
            .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE)];
        let none = vk::DependencyFlags::empty();
        // SAFETY: the command buffer is recording.
        unsafe { self.device.cmd_pipeline_barrier(commands, all, all, none, &memory, &[], &[]) };
    }

    /// Copies the first `size` bytes.
    pub fn copy(&self, commands: vk::CommandBuffer, from: &Buffer<'_>, to: &Buffer<'_>, size: u64) {
        let region = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size }];
        assert!(size <= from.size && size <= to.size);
        // SAFETY: the command buffer is recording; the range lies within both.
        unsafe { self.device.cmd_copy_buffer(commands, from.handle, to.handle, &region) };
    }
}

impl Drop for Gpu {
    fn drop(&mut self) {
        // SAFETY: buffers and pipelines borrow the device, and every submission was waited for.
        unsafe {
            if let Some(queries) = self.queries {
                self.device.destroy_query_pool(queries, None);
            }
            self.device.destroy_fence(self.fence, None);
            self.device.destroy_command_pool(self.pool, None);
            self.device.destroy_device(None);
        }
    }
}

/// What the driver calls itself, where it does.
fn driver(loader: &Loader, physical: vk::PhysicalDevice, properties: &vk::PhysicalDeviceProperties) -> String {
    let raw = format!("version {:#x}", properties.driver_version);
    if loader.version.min(properties.api_version) < vk::API_VERSION_1_2 {
        return raw;
    }
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut all = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
    // SAFETY: instance and device are of Vulkan 1.2 at least, which has both structures.
    unsafe { loader.instance.get_physical_device_properties2(physical, &mut all) };
    let text = |c: Result<&std::ffi::CStr, _>| c.map_or(String::new(), |c| c.to_string_lossy().into_owned());
    let said = format!("{} {}", text(driver.driver_name_as_c_str()), text(driver.driver_info_as_c_str()));
    if said.trim().is_empty() { raw } else { said.trim().to_owned() }
}
