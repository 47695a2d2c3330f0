//! A minimal engine: an instance with validation, a device, buffers that the CPU sees, and submissions.

use std::cell::RefCell;
use std::ffi::{CStr, c_char, c_void};
use std::sync::Mutex;

use ash::{Entry, ext, vk};
use crumple::vulkan::{Access, BufferDef, BufferId, Device, DeviceDef};

use crate::gpu::compare::TestedDevice;
use crate::gpu::{Lowered, POISON, note_missing, required};

/// What the CPU sees of a buffer before and after each recording.
pub const HOST: Access = Access { stages: vk::PipelineStageFlags::HOST, access: vk::AccessFlags::HOST_READ };

/// Runs a test on each device there is, and fails if validation reports anything. Prints which software drivers are not there. With
/// CRUMPLE_REQUIRE_GPU=llvmpipe,SwiftShader these two and the validation layer must be there.
pub fn on_each_device(test: impl Fn(&Engine)) {
    on_each_device_with(&[], test);
}

/// The same, with the extensions of this list that the device has.
pub fn on_each_device_with(extensions: &[&CStr], test: impl Fn(&Engine)) {
    let required = required();
    // SAFETY: the system's loader.
    let entry = match unsafe { Entry::load() } {
        Ok(entry) => entry,
        Err(e) if !required => return eprintln!("left out: no Vulkan loader ({e})"),
        Err(e) => panic!("no Vulkan loader: {e}"),
    };
    let instance = match Instance::new(&entry, required) {
        Ok(instance) => instance,
        // A loader that finds no driver.
        Err(vk::Result::ERROR_INCOMPATIBLE_DRIVER) if !required => return eprintln!("left out: no Vulkan driver"),
        Err(e) => panic!("no Vulkan instance: {e}"),
    };
    // SAFETY: a valid instance.
    let devices = unsafe { instance.instance.enumerate_physical_devices() }.unwrap_or_default();
    let mut seen = Vec::new();
    for physical in devices {
        // SAFETY: a valid device.
        let properties = unsafe { instance.instance.get_physical_device_properties(physical) };
        let name = properties.device_name_as_c_str().unwrap().to_string_lossy().into_owned();
        seen.push(name.clone());
        let tested =
            TestedDevice { name: name.clone(), driver: driver(&instance.instance, physical), translated: false };
        tested.announce();
        let engine = Engine::new(&entry, &instance, physical, tested, extensions);
        test(&engine);
        drop(engine);
        let messages = std::mem::take(&mut *instance.messages.lock().unwrap());
        assert!(messages.is_empty(), "on {name}:\n{}", messages.join("\n"));
    }
    note_missing(&seen);
}

/// The driver of a device, with its version.
fn driver(instance: &ash::Instance, physical: vk::PhysicalDevice) -> String {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    // SAFETY: a valid device. One that has the extension fills the struct.
    unsafe {
        let extensions = instance.enumerate_device_extension_properties(physical).unwrap_or_default();
        if !extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(ash::khr::driver_properties::NAME)) {
            return format!("version {:#x}", instance.get_physical_device_properties(physical).driver_version);
        }
        let mut all = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
        instance.get_physical_device_properties2(physical, &mut all);
    }
    let text = |s: Result<&CStr, _>| s.map_or_else(|_| String::new(), |s: &CStr| s.to_string_lossy().into_owned());
    format!("{} {}", text(driver.driver_name_as_c_str()), text(driver.driver_info_as_c_str()))
}

struct Instance {
    instance: ash::Instance,
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
    fn new(entry: &Entry, required: bool) -> Result<Self, vk::Result> {
        let layer = c"VK_LAYER_KHRONOS_validation";
        // SAFETY: a loaded library.
        let layers = unsafe { entry.enumerate_instance_layer_properties() }.unwrap();
        let validated = layers.iter().any(|l| l.layer_name_as_c_str() == Ok(layer));
        assert!(validated || !required, "the validation layer is required");
        if !validated {
            eprintln!("without validation: its layer is not there");
        }
        let messages: Box<Mutex<Vec<String>>> = Box::default();
        let app = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_1);
        let names = [layer.as_ptr()];
        let extensions = [ext::debug_utils::NAME.as_ptr(), ext::validation_features::NAME.as_ptr()];
        let sync = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&sync);
        let mut info = vk::InstanceCreateInfo::default().application_info(&app);
        if validated {
            info = info.enabled_layer_names(&names).enabled_extension_names(&extensions).push_next(&mut features);
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
        Ok(Instance { instance, messages, messenger })
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
    get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
    instance: &'a Instance,
    pub physical: vk::PhysicalDevice,
    pub queue: vk::Queue,
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

    /// Copies words to an offset in bytes.
    pub fn write(&self, offset: u64, words: &[u32]) {
        let at = offset as usize / 4;
        // SAFETY: the whole buffer is mapped, and no frame is in flight.
        let all = unsafe { std::slice::from_raw_parts_mut(self.data, self.size as usize / 4) };
        all[at..at + words.len()].copy_from_slice(words);
    }

    pub fn poison(&self) {
        // SAFETY: the whole buffer is mapped, and no frame is in flight.
        unsafe { std::slice::from_raw_parts_mut(self.data, self.size as usize / 4) }.fill(POISON);
    }

    pub fn def(&self) -> BufferDef {
        BufferDef {
            buffer: self.handle,
            size: self.size,
            usage: Self::USAGE,
            queue_family: vk::QUEUE_FAMILY_IGNORED,
            before: HOST,
            after: HOST,
        }
    }
}

impl<'a> Engine<'a> {
    fn new(
        entry: &Entry,
        instance: &'a Instance,
        physical: vk::PhysicalDevice,
        tested: TestedDevice,
        extensions: &[&CStr],
    ) -> Self {
        // SAFETY: a valid device.
        let there = unsafe { instance.instance.enumerate_device_extension_properties(physical) }.unwrap();
        let has = |name: &&&CStr| there.iter().any(|e| e.extension_name_as_c_str() == Ok(**name));
        let extensions: Vec<_> = extensions.iter().filter(has).map(|name| name.as_ptr()).collect();
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(0).queue_priorities(&[1.0])];
        let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_extension_names(&extensions);
        // SAFETY: software drivers have one family that does everything; everything is destroyed in `drop`.
        unsafe {
            let device = instance.instance.create_device(physical, &info, None).expect("a device");
            let pool = vk::CommandPoolCreateInfo::default().queue_family_index(0);
            Engine {
                tested,
                get_instance_proc_addr: entry.static_fn().get_instance_proc_addr,
                instance,
                physical,
                queue: device.get_device_queue(0, 0),
                pool: device.create_command_pool(&pool, None).unwrap(),
                fence: device.create_fence(&vk::FenceCreateInfo::default(), None).unwrap(),
                buffers: RefCell::default(),
                device,
            }
        }
    }

    pub fn def(&self) -> DeviceDef<'static> {
        let instance = self.instance.instance.handle();
        DeviceDef::new(self.get_instance_proc_addr, instance, self.physical, self.device.handle(), 0)
    }

    pub fn crumple(&self) -> Device {
        // SAFETY: valid handles.
        unsafe { Device::new(&self.def()) }.unwrap()
    }

    #[cfg(target_os = "linux")]
    pub fn instance(&self) -> &ash::Instance {
        &self.instance.instance
    }

    /// Whether the validation layer is there.
    pub fn validated(&self) -> bool {
        self.instance.messenger.is_some()
    }

    pub fn messages(&self) -> Vec<String> {
        std::mem::take(&mut *self.instance.messages.lock().unwrap())
    }

    /// A buffer full of poison.
    pub fn buffer(&self, size: u64) -> Seen {
        let info = vk::BufferCreateInfo::default().size(size).usage(Seen::USAGE);
        use vk::MemoryPropertyFlags as P;
        // SAFETY: valid arguments; destroyed in `drop`.
        unsafe {
            let handle = self.device.create_buffer(&info, None).unwrap();
            let needs = self.device.get_buffer_memory_requirements(handle);
            let memory = self.instance.instance.get_physical_device_memory_properties(self.physical);
            let visible = P::HOST_VISIBLE | P::HOST_COHERENT;
            let type_ = (0..memory.memory_type_count)
                .find(|t| {
                    let flags = memory.memory_types[*t as usize].property_flags;
                    needs.memory_type_bits >> t & 1 == 1 && flags.contains(visible)
                })
                .unwrap();
            let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(type_);
            let memory = self.device.allocate_memory(&info, None).unwrap();
            self.device.bind_buffer_memory(handle, memory, 0).unwrap();
            self.seen((handle, memory), (0, size))
        }
    }

    /// Maps a buffer at an offset of its memory, fills it with poison, and takes over both.
    ///
    /// # Safety
    /// Both are valid, and the memory is visible to the host.
    pub unsafe fn seen(&self, both: (vk::Buffer, vk::DeviceMemory), (offset, size): (u64, u64)) -> Seen {
        // SAFETY: the caller's.
        let data = unsafe { self.device.map_memory(both.1, offset, size, vk::MemoryMapFlags::empty()) }.unwrap();
        self.buffers.borrow_mut().push(both);
        let seen = Seen { handle: both.0, size, data: data.cast() };
        seen.poison();
        seen
    }

    /// A new buffer, registered.
    pub fn target_buffer(&self, crumple: &mut Device, size: u64) -> (Seen, BufferId) {
        let seen = self.buffer(size);
        // SAFETY: a valid buffer that lives until the engine is dropped.
        let id = unsafe { crumple.add_buffer(&seen.def()) }.unwrap();
        (seen, id)
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
        }
        t
    }

    pub fn wait(&self) {
        // SAFETY: a valid device.
        unsafe { self.device.device_wait_idle() }.unwrap();
    }
}

impl Drop for Engine<'_> {
    fn drop(&mut self) {
        self.wait();
        // SAFETY: nothing uses them any more.
        unsafe {
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

/// How a loader differs from the system's.
#[derive(Clone, Copy, Default)]
pub struct Tampered {
    /// A function that it does not have.
    pub without: Option<&'static CStr>,
    /// Barriers are dropped from this one on, of each device.
    pub barriers: Option<u32>,
    /// Queue families of buffers' barriers are kept for [`families`].
    pub watch: bool,
    pub lowered: Lowered,
    pub api_version: Option<u32>,
}

thread_local! {
    static TAMPERED: RefCell<(Tampered, Option<vk::PFN_vkGetInstanceProcAddr>)> = RefCell::default();
    static REAL: RefCell<Real> = RefCell::default();
}

thread_local! {
    static FAMILIES: RefCell<Vec<(vk::Buffer, u32, u32)>> = const { RefCell::new(Vec::new()) };
}

/// Buffers, source and destination families of this thread's watched barriers since it was last asked.
pub fn families() -> Vec<(vk::Buffer, u32, u32)> {
    FAMILIES.take()
}

#[derive(Clone, Copy, Default)]
struct Real {
    get_device: Option<vk::PFN_vkGetDeviceProcAddr>,
    properties: Option<vk::PFN_vkGetPhysicalDeviceProperties>,
    barrier: Option<vk::PFN_vkCmdPipelineBarrier>,
}

/// The same definition with a loader that is tampered with, for this thread.
pub fn tampered(def: DeviceDef<'static>, how: Tampered) -> DeviceDef<'static> {
    TAMPERED.set((how, Some(def.get_instance_proc_addr)));
    DeviceDef { get_instance_proc_addr: get_instance, ..def }
}

unsafe extern "system" fn get_instance(instance: vk::Instance, name: *const c_char) -> vk::PFN_vkVoidFunction {
    let (how, real) = TAMPERED.with_borrow(|t| *t);
    // SAFETY: the caller's name, the system's loader, and functions of the types their names say.
    unsafe {
        let found = real.unwrap()(instance, name);
        let name = CStr::from_ptr(name);
        if how.without == Some(name) {
            return None;
        }
        if name == c"vkGetDeviceProcAddr" {
            let found = std::mem::transmute::<vk::PFN_vkVoidFunction, Option<vk::PFN_vkGetDeviceProcAddr>>(found);
            REAL.with_borrow_mut(|r| r.get_device = found);
            let own: vk::PFN_vkGetDeviceProcAddr = get_device;
            return std::mem::transmute::<vk::PFN_vkGetDeviceProcAddr, vk::PFN_vkVoidFunction>(own);
        }
        if name == c"vkGetPhysicalDeviceProperties" {
            let found =
                std::mem::transmute::<vk::PFN_vkVoidFunction, Option<vk::PFN_vkGetPhysicalDeviceProperties>>(found);
            REAL.with_borrow_mut(|r| r.properties = found);
            let own: vk::PFN_vkGetPhysicalDeviceProperties = properties;
            return std::mem::transmute::<vk::PFN_vkGetPhysicalDeviceProperties, vk::PFN_vkVoidFunction>(own);
        }
        found
    }
}

unsafe extern "system" fn properties(physical: vk::PhysicalDevice, out: *mut vk::PhysicalDeviceProperties) {
    let how = TAMPERED.with_borrow(|t| t.0);
    // SAFETY: the system's function, and the caller's memory.
    unsafe {
        REAL.with_borrow(|r| r.properties).unwrap()(physical, out);
        let (limits, lowered) = (&mut (*out).limits, how.lowered);
        let groups = &mut limits.max_compute_work_group_count[0];
        *groups = lowered.workgroups.unwrap_or(*groups);
        let bytes = lowered.binding_bytes.map(|bytes| bytes as u32);
        limits.max_storage_buffer_range = bytes.unwrap_or(limits.max_storage_buffer_range);
        (*out).api_version = how.api_version.unwrap_or((*out).api_version);
    }
}

unsafe extern "system" fn get_device(device: vk::Device, name: *const c_char) -> vk::PFN_vkVoidFunction {
    let how = TAMPERED.with_borrow(|t| t.0);
    // SAFETY: as above.
    unsafe {
        let found = REAL.with_borrow(|r| r.get_device).unwrap()(device, name);
        let name = CStr::from_ptr(name);
        if how.without == Some(name) {
            return None;
        }
        if name == c"vkCmdPipelineBarrier" {
            let found = std::mem::transmute::<vk::PFN_vkVoidFunction, Option<vk::PFN_vkCmdPipelineBarrier>>(found);
            REAL.with_borrow_mut(|r| r.barrier = found);
            let own: vk::PFN_vkCmdPipelineBarrier = barrier;
            return std::mem::transmute::<vk::PFN_vkCmdPipelineBarrier, vk::PFN_vkVoidFunction>(own);
        }
        found
    }
}

#[allow(clippy::too_many_arguments)] // Vulkan's
unsafe extern "system" fn barrier(
    commands: vk::CommandBuffer,
    from: vk::PipelineStageFlags,
    to: vk::PipelineStageFlags,
    flags: vk::DependencyFlags,
    memory_count: u32,
    memory: *const vk::MemoryBarrier<'_>,
    buffer_count: u32,
    buffers: *const vk::BufferMemoryBarrier<'_>,
    image_count: u32,
    images: *const vk::ImageMemoryBarrier<'_>,
) {
    let dropped = TAMPERED.with_borrow_mut(|t| match &mut t.0.barriers {
        Some(0) => true,
        Some(left) => {
            *left -= 1;
            false
        }
        None => false,
    });
    if TAMPERED.with_borrow(|t| t.0.watch) {
        // SAFETY: the caller's barriers.
        let all = unsafe { std::slice::from_raw_parts(buffers, buffer_count as usize) };
        let families = all.iter().map(|b| (b.buffer, b.src_queue_family_index, b.dst_queue_family_index));
        FAMILIES.with_borrow_mut(|f| f.extend(families));
    }
    if !dropped {
        let real = REAL.with_borrow(|r| r.barrier).unwrap();
        // SAFETY: passed on.
        unsafe { real(commands, from, to, flags, memory_count, memory, buffer_count, buffers, image_count, images) };
    }
}
