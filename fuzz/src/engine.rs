//! The Vulkan devices that there are, each with the library on it and one buffer that the CPU sees. They live as long as the
//! process, so nothing is destroyed.
#![allow(unsafe_op_in_unsafe_fn)]

use ash::{Entry, vk};
use crumple::ExampleSet;
use crumple::vulkan::{Access, BufferDef, BufferId, Device, DeviceDef, RecordJob, Target, TargetDef};
use std::sync::Arc;

/// Bytes of each device's buffer.
pub const SIZE: u64 = 64 << 10;

/// One device.
pub struct Engine {
    pub name: String,
    /// The driver, with its version.
    pub driver: String,
    device: ash::Device,
    queue: vk::Queue,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
    crumple: Device,
    buffer: BufferId,
    /// The mapped buffer.
    words: &'static mut [u32],
    frame: u64,
}

/// All devices of the system's loader. Empty without a loader or a driver.
pub fn all() -> Vec<Engine> {
    // SAFETY: the system's loader. Everything that is made here lives as long as the process.
    unsafe {
        let Ok(entry) = Entry::load() else { return Vec::new() };
        let app = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_1);
        let info = vk::InstanceCreateInfo::default().application_info(&app);
        let Ok(instance) = entry.create_instance(&info, None) else { return Vec::new() };
        let devices = instance.enumerate_physical_devices().unwrap_or_default();
        let engines = devices.into_iter().map(|physical| Engine::new(&entry, &instance, physical)).collect();
        std::mem::forget(entry);
        engines
    }
}

impl Engine {
    /// # Safety
    /// Entry, instance and device are valid and live as long as the process.
    unsafe fn new(entry: &Entry, instance: &ash::Instance, physical: vk::PhysicalDevice) -> Self {
        let properties = instance.get_physical_device_properties(physical);
        let name = properties.device_name_as_c_str().expect("a name").to_string_lossy().into_owned();
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(0).queue_priorities(&[1.0])];
        let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
        let device = instance.create_device(physical, &info, None).expect("a device");
        let flags = vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER;
        let info = vk::CommandPoolCreateInfo::default().queue_family_index(0).flags(flags);
        let pool = device.create_command_pool(&info, None).expect("a pool");
        let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
        let commands = device.allocate_command_buffers(&info).expect("a command buffer")[0];
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let info = vk::BufferCreateInfo::default().size(SIZE).usage(usage);
        let handle = device.create_buffer(&info, None).expect("a buffer");
        let needs = device.get_buffer_memory_requirements(handle);
        let memory = instance.get_physical_device_memory_properties(physical);
        let visible = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        let fits = |kind: &u32| {
            let flags = memory.memory_types[*kind as usize].property_flags;
            needs.memory_type_bits >> kind & 1 == 1 && flags.contains(visible)
        };
        let kind = (0..memory.memory_type_count).find(fits).expect("memory that the CPU sees");
        let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(kind);
        let memory = device.allocate_memory(&info, None).expect("memory");
        device.bind_buffer_memory(handle, memory, 0).expect("a bound buffer");
        let data = device.map_memory(memory, 0, SIZE, vk::MemoryMapFlags::empty()).expect("mapped memory");
        let load = entry.static_fn().get_instance_proc_addr;
        let def = DeviceDef::new(load, instance.handle(), physical, device.handle(), 0);
        let mut crumple = Device::new(&def).expect("a device that computes");
        let host = Access { stages: vk::PipelineStageFlags::HOST, access: vk::AccessFlags::HOST_READ };
        let family = vk::QUEUE_FAMILY_IGNORED;
        let def = BufferDef { buffer: handle, size: SIZE, usage, queue_family: family, before: host, after: host };
        Engine {
            name,
            driver: format!("{:#x}", properties.driver_version),
            queue: device.get_device_queue(0, 0),
            commands,
            fence: device.create_fence(&vk::FenceCreateInfo::default(), None).expect("a fence"),
            buffer: crumple.add_buffer(&def).expect("a buffer"),
            words: std::slice::from_raw_parts_mut(data.cast(), SIZE as usize / 4),
            crumple,
            device,
            frame: 0,
        }
    }

    /// The buffer, for the definition of a target.
    pub fn buffer(&self) -> BufferId {
        self.buffer
    }

    /// A target in the buffer, which is filled with a word.
    pub fn target(&mut self, set: &Arc<ExampleSet>, def: &TargetDef, word: u32) -> Target {
        self.words.fill(word);
        self.crumple.add_target(set, def).expect("a target in the buffer")
    }

    /// Records what changed and waits for it. Returns the whole buffer.
    pub fn run(&mut self, job: RecordJob<'_>) -> &[u32] {
        self.frame += 1;
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        let commands = [self.commands];
        let submit = [vk::SubmitInfo::default().command_buffers(&commands)];
        // SAFETY: the last frame is complete, and handles are valid.
        unsafe {
            self.device.begin_command_buffer(self.commands, &begin).expect("begun");
            self.crumple.record(self.commands, self.frame, &mut [job]).expect("recorded");
            self.device.end_command_buffer(self.commands).expect("ended");
            self.device.queue_submit(self.queue, &submit, self.fence).expect("submitted");
            self.device.wait_for_fences(&[self.fence], true, u64::MAX).expect("done");
            self.device.reset_fences(&[self.fence]).expect("reset");
        }
        self.crumple.completed(self.frame);
        self.words
    }
}
