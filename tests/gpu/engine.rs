//! A minimal engine: an instance with validation, a device, buffers that the CPU sees, and submissions.
#![allow(dead_code)]

use std::cell::RefCell;
use std::ffi::{CStr, c_void};
use std::sync::Mutex;

use ash::{Entry, ext, vk};

use super::compare::{POISON, TestedDevice, note_missing, required};

/// What an engine's instance and device are made with.
pub struct Needs<'a> {
    pub api_version: u32,
    /// Whether the validation layer watches, if it is there.
    pub validation: bool,
    /// Extensions of the instance, beside those of validation.
    pub instance_extensions: &'a [&'static CStr],
    /// Extensions that a device is asked for where it has them.
    pub device_extensions: &'a dyn Fn(&Instance, vk::PhysicalDevice) -> Vec<&'static CStr>,
}

/// Runs a test on each device there is, and fails if validation reports anything. Prints which software drivers are not there. With
/// CRUMPLE_REQUIRE_GPU=llvmpipe,SwiftShader these two and the validation layer must be there.
pub fn on_each_engine(needs: &Needs<'_>, test: impl Fn(&Engine)) {
    let required = required();
    // SAFETY: the system's loader.
    let entry = match unsafe { Entry::load() } {
        Ok(entry) => entry,
        Err(e) if !required => return eprintln!("left out: no Vulkan loader ({e})"),
        Err(e) => panic!("no Vulkan loader: {e}"),
    };
    let instance = match Instance::new(&entry, needs, required) {
        Ok(instance) => instance,
        // A loader that finds no driver.
        Err(vk::Result::ERROR_INCOMPATIBLE_DRIVER) if !required => return eprintln!("left out: no Vulkan driver"),
        Err(e) => panic!("no Vulkan instance: {e}"),
    };
    let mut seen = Vec::new();
    for engine in instance.engines(needs) {
        let name = engine.tested.name.clone();
        engine.tested.announce();
        test(&engine);
        drop(engine);
        let messages = instance.messages();
        assert!(messages.is_empty(), "on {name}:\n{}", messages.join("\n"));
        seen.push(name);
    }
    note_missing(&seen);
}

/// An instance under validation.
pub struct Instance {
    pub instance: ash::Instance,
    pub get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
    /// Extensions that are enabled.
    pub extensions: Vec<&'static CStr>,
    messages: Box<Mutex<Vec<String>>>,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
}

unsafe extern "system" fn collect(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    messages: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the messenger was made with these messages, and the layer's data is valid.
    let (messages, text) = unsafe {
        let messages = &*messages.cast::<Mutex<Vec<String>>>();
        (messages, CStr::from_ptr((*data).p_message).to_string_lossy().into_owned())
    };
    messages.lock().unwrap().push(text);
    vk::FALSE
}

impl Instance {
    /// The devices that there are.
    pub fn engines(&self, needs: &Needs<'_>) -> impl Iterator<Item = Engine<'_>> {
        // SAFETY: a valid instance.
        let devices = unsafe { self.instance.enumerate_physical_devices() }.unwrap_or_default();
        devices.into_iter().map(move |physical| Engine::new(self, physical, needs))
    }

    pub fn messages(&self) -> Vec<String> {
        std::mem::take(&mut *self.messages.lock().unwrap())
    }

    pub fn new(entry: &Entry, needs: &Needs<'_>, required: bool) -> Result<Self, vk::Result> {
        let layer = c"VK_LAYER_KHRONOS_validation";
        // SAFETY: a loaded library.
        let layers = unsafe { entry.enumerate_instance_layer_properties() }.unwrap();
        let validated = needs.validation && layers.iter().any(|l| l.layer_name_as_c_str() == Ok(layer));
        assert!(validated || !required, "the validation layer is required");
        if !validated {
            eprintln!("without validation: its layer is not there");
        }
        let messages: Box<Mutex<Vec<String>>> = Box::default();
        let app = vk::ApplicationInfo::default().api_version(needs.api_version);
        let names = [layer.as_ptr()];
        let mut extensions = needs.instance_extensions.to_vec();
        if validated {
            extensions.extend([ext::debug_utils::NAME, ext::validation_features::NAME]);
        }
        let pointers: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
        let sync = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&sync);
        let mut info = vk::InstanceCreateInfo::default().application_info(&app).enabled_extension_names(&pointers);
        if validated {
            info = info.enabled_layer_names(&names).push_next(&mut features);
        }
        // SAFETY: valid arguments.
        let instance = unsafe { entry.create_instance(&info, None) }?;
        let messenger = validated.then(|| {
            let utils = ext::debug_utils::Instance::new(entry, &instance);
            use vk::{DebugUtilsMessageSeverityFlagsEXT as S, DebugUtilsMessageTypeFlagsEXT as T};
            let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
                .message_severity(S::WARNING | S::ERROR)
                .message_type(T::GENERAL | T::VALIDATION)
                .pfn_user_callback(Some(collect))
                .user_data((&raw const *messages).cast_mut().cast());
            // SAFETY: the messages live as long as the messenger.
            let messenger = unsafe { utils.create_debug_utils_messenger(&info, None) }.unwrap();
            (utils, messenger)
        });
        // Messages of drivers that are being loaded are not about the tests.
        messages.lock().unwrap().clear();
        let get_instance_proc_addr = entry.static_fn().get_instance_proc_addr;
        Ok(Instance { instance, get_instance_proc_addr, extensions, messages, messenger })
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: nothing uses them any more.
        unsafe {
            if let Some((utils, messenger)) = &self.messenger {
                utils.destroy_debug_utils_messenger(*messenger, None);
            }
            self.instance.destroy_instance(None);
        }
    }
}

/// A device with one queue.
pub struct Engine<'a> {
    pub tested: TestedDevice,
    pub device: ash::Device,
    /// Extensions that are enabled.
    pub extensions: Vec<&'static CStr>,
    pub on: &'a Instance,
    pub physical: vk::PhysicalDevice,
    queue: vk::Queue,
    pool: vk::CommandPool,
    fence: vk::Fence,
    buffers: RefCell<Vec<(vk::Buffer, vk::DeviceMemory)>>,
}

/// A buffer that the CPU sees.
#[derive(Clone, Copy)]
pub struct Seen {
    pub handle: vk::Buffer,
    pub size: u64,
    data: *mut u32,
}

impl Seen {
    pub const USAGE: vk::BufferUsageFlags = vk::BufferUsageFlags::from_raw(
        vk::BufferUsageFlags::STORAGE_BUFFER.as_raw()
            | vk::BufferUsageFlags::VERTEX_BUFFER.as_raw()
            | vk::BufferUsageFlags::TRANSFER_SRC.as_raw()
            | vk::BufferUsageFlags::TRANSFER_DST.as_raw(),
    );

    pub fn words(&self) -> &[u32] {
        // SAFETY: the whole buffer is mapped, and the tests wait before they look.
        unsafe { std::slice::from_raw_parts(self.data, self.size as usize / 4) }
    }

    pub fn poison(&self) {
        // SAFETY: the whole buffer is mapped, and no frame is in flight.
        unsafe { std::slice::from_raw_parts_mut(self.data, self.size as usize / 4) }.fill(POISON);
    }
}

impl<'a> Engine<'a> {
    fn new(on: &'a Instance, physical: vk::PhysicalDevice, needs: &Needs<'_>) -> Self {
        // SAFETY: a valid device.
        let properties = unsafe { on.instance.get_physical_device_properties(physical) };
        let name = properties.device_name_as_c_str().unwrap().to_string_lossy().into_owned();
        let driver = format!("version {:#x}", properties.driver_version);
        let tested = TestedDevice { name, driver, translated: false };
        // SAFETY: as above.
        let there = unsafe { on.instance.enumerate_device_extension_properties(physical) }.unwrap();
        let mut extensions = (needs.device_extensions)(on, physical);
        extensions.retain(|name| there.iter().any(|e| e.extension_name_as_c_str() == Ok(*name)));
        let names: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(0).queue_priorities(&[1.0])];
        let mut timeline = vk::PhysicalDeviceTimelineSemaphoreFeatures::default().timeline_semaphore(true);
        let mut info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_extension_names(&names);
        if needs.api_version >= vk::API_VERSION_1_2 {
            info = info.push_next(&mut timeline);
        }
        // SAFETY: software drivers have one family that does everything; everything is destroyed in `drop`.
        unsafe {
            let device = on.instance.create_device(physical, &info, None).expect("a device");
            let pool = vk::CommandPoolCreateInfo::default().queue_family_index(0);
            Engine {
                tested,
                extensions,
                on,
                physical,
                queue: device.get_device_queue(0, 0),
                pool: device.create_command_pool(&pool, None).unwrap(),
                fence: device.create_fence(&vk::FenceCreateInfo::default(), None).unwrap(),
                buffers: RefCell::default(),
                device,
            }
        }
    }

    /// Whether the validation layer is there.
    pub fn validated(&self) -> bool {
        self.on.messenger.is_some()
    }

    /// A buffer full of poison.
    pub fn buffer(&self, size: u64) -> Seen {
        let info = vk::BufferCreateInfo::default().size(size).usage(Seen::USAGE);
        // SAFETY: valid arguments; destroyed in `drop`.
        unsafe {
            let handle = self.device.create_buffer(&info, None).unwrap();
            let needs = self.device.get_buffer_memory_requirements(handle);
            let kind = self.memory_type(needs);
            let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(kind);
            let memory = self.device.allocate_memory(&info, None).unwrap();
            self.device.bind_buffer_memory(handle, memory, 0).unwrap();
            let data = self.device.map_memory(memory, 0, size, vk::MemoryMapFlags::empty()).unwrap();
            self.buffers.borrow_mut().push((handle, memory));
            let seen = Seen { handle, size, data: data.cast() };
            seen.poison();
            seen
        }
    }

    /// A type of memory that the CPU sees.
    fn memory_type(&self, needs: vk::MemoryRequirements) -> u32 {
        // SAFETY: a valid device.
        let types = unsafe { self.on.instance.get_physical_device_memory_properties(self.physical) };
        let visible = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        let fits = |t: &u32| {
            needs.memory_type_bits >> t & 1 == 1 && types.memory_types[*t as usize].property_flags.contains(visible)
        };
        (0..types.memory_type_count).find(fits).unwrap()
    }

    pub fn begin(&self, level: vk::CommandBufferLevel) -> vk::CommandBuffer {
        let info =
            vk::CommandBufferAllocateInfo::default().command_pool(self.pool).level(level).command_buffer_count(1);
        let inherited = vk::CommandBufferInheritanceInfo::default();
        let begin = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT)
            .inheritance_info(&inherited);
        // SAFETY: valid arguments.
        unsafe {
            let commands = self.device.allocate_command_buffers(&info).unwrap()[0];
            self.device.begin_command_buffer(commands, &begin).unwrap();
            commands
        }
    }

    /// Ends and submits; the fence is signalled when it and all before are done.
    pub fn submit(&self, commands: vk::CommandBuffer, fence: vk::Fence) {
        let all = [commands];
        let submit = vk::SubmitInfo::default().command_buffers(&all);
        // SAFETY: valid arguments.
        unsafe {
            self.device.end_command_buffer(commands).unwrap();
            self.device.queue_submit(self.queue, &[submit], fence).unwrap();
        }
    }

    /// Records with `f` and waits until the device has done it.
    pub fn run<T>(&self, f: impl FnOnce(vk::CommandBuffer) -> T) -> T {
        let commands = self.begin(vk::CommandBufferLevel::PRIMARY);
        let t = f(commands);
        self.submit(commands, self.fence);
        // SAFETY: valid arguments.
        unsafe {
            self.device.wait_for_fences(&[self.fence], true, u64::MAX).unwrap();
            self.device.reset_fences(&[self.fence]).unwrap();
            self.device.free_command_buffers(self.pool, &[commands]);
        }
        t
    }
}

impl Drop for Engine<'_> {
    fn drop(&mut self) {
        // SAFETY: nothing uses them any more.
        unsafe {
            self.device.device_wait_idle().unwrap();
            for (buffer, memory) in self.buffers.take() {
                self.device.destroy_buffer(buffer, None);
                self.device.free_memory(memory, None);
            }
            self.device.destroy_fence(self.fence, None);
            self.device.destroy_command_pool(self.pool, None);
            self.device.destroy_device(None);
        }
    }
}
