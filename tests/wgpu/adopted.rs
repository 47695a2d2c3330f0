//! A Vulkan device of an engine, under validation: wgpu works on it and on its buffers, and leaves both to the engine.

use std::ffi::{CStr, c_void};
use std::sync::Mutex;

use ash::{Entry, ext, khr, vk};
use crumple::ErrorKind::{InvalidArgument, Unsupported};
use crumple::wgpu::wgpu::BufferUsages;
use crumple::wgpu::{Device, DeviceDef, EncodeJob, VulkanDef};

use crate::gpu::compare::{Expected, TestedDevice};
use crate::gpu::layout::TestLayout;
use crate::gpu::refusals::refused;
use crate::gpu::{POISON, folded, hit, note_missing, required};
use crate::scenes;

/// A minimal engine.
struct Engine {
    instance: ash::Instance,
    entry: Entry,
    messages: Box<Mutex<Vec<String>>>,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
}

const INSTANCE_EXTENSIONS: [&CStr; 2] = [khr::get_physical_device_properties2::NAME, ext::debug_utils::NAME];

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

impl Engine {
    fn new() -> Option<Self> {
        // SAFETY: the system's loader.
        let entry = match unsafe { Entry::load() } {
            Ok(entry) => entry,
            Err(e) => {
                assert!(!required(), "no Vulkan loader: {e}");
                eprintln!("left out: no Vulkan loader ({e})");
                return None;
            }
        };
        let layer = c"VK_LAYER_KHRONOS_validation";
        // SAFETY: a loaded library.
        let layers = unsafe { entry.enumerate_instance_layer_properties() }.unwrap();
        let validated = layers.iter().any(|l| l.layer_name_as_c_str() == Ok(layer));
        assert!(validated || !required(), "the validation layer is required");
        let messages: Box<Mutex<Vec<String>>> = Box::default();
        let app = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
        let layers = [layer.as_ptr()];
        let mut extensions = INSTANCE_EXTENSIONS.map(CStr::as_ptr).to_vec();
        extensions.push(ext::validation_features::NAME.as_ptr());
        let sync = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&sync);
        let mut info = vk::InstanceCreateInfo::default().application_info(&app);
        if validated {
            info = info.enabled_layer_names(&layers).enabled_extension_names(&extensions).push_next(&mut features);
        } else {
            eprintln!("without validation: its layer is not there");
            info = info.enabled_extension_names(&extensions[..1]);
        }
        // SAFETY: valid arguments.
        let instance = match unsafe { entry.create_instance(&info, None) } {
            Ok(instance) => instance,
            Err(e) => {
                assert!(!required(), "no Vulkan instance: {e}");
                eprintln!("left out: no Vulkan instance ({e})");
                return None;
            }
        };
        let messenger = validated.then(|| {
            let utils = ext::debug_utils::Instance::new(&entry, &instance);
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
        messages.lock().unwrap().clear();
        Some(Engine { instance, entry, messages, messenger })
    }

    /// The definition for a physical device, before its device is made.
    fn def(&self, physical_device: vk::PhysicalDevice) -> VulkanDef<'static> {
        VulkanDef {
            get_instance_proc_addr: self.entry.static_fn().get_instance_proc_addr,
            instance: self.instance.handle(),
            api_version: vk::API_VERSION_1_3,
            instance_extensions: if self.messenger.is_some() {
                &INSTANCE_EXTENSIONS
            } else {
                &INSTANCE_EXTENSIONS[..1]
            },
            physical_device,
            device: vk::Device::null(),
            device_extensions: &[],
            queue_family: 0,
            queue_index: 0,
        }
    }

    fn device(&self, physical: vk::PhysicalDevice, extensions: &[&CStr]) -> ash::Device {
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(0).queue_priorities(&[1.0])];
        let names: Vec<_> = extensions.iter().map(|e| e.as_ptr()).collect();
        let mut timeline = vk::PhysicalDeviceTimelineSemaphoreFeatures::default().timeline_semaphore(true);
        let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_extension_names(&names);
        let info = info.push_next(&mut timeline);
        // SAFETY: software drivers have one family that does everything.
        unsafe { self.instance.create_device(physical, &info, None) }.expect("a device")
    }

    /// A buffer full of poison that the CPU sees.
    fn buffer(&self, physical: vk::PhysicalDevice, device: &ash::Device, size: u64) -> Seen {
        use vk::BufferUsageFlags as U;
        use vk::MemoryPropertyFlags as P;
        let usage = U::STORAGE_BUFFER | U::VERTEX_BUFFER | U::TRANSFER_SRC | U::TRANSFER_DST;
        let info = vk::BufferCreateInfo::default().size(size).usage(usage);
        // SAFETY: valid arguments; so much is mapped.
        unsafe {
            let handle = device.create_buffer(&info, None).unwrap();
            let needs = device.get_buffer_memory_requirements(handle);
            let types = self.instance.get_physical_device_memory_properties(physical);
            let visible = P::HOST_VISIBLE | P::HOST_COHERENT;
            let fits = |t: &u32| {
                needs.memory_type_bits >> t & 1 == 1 && types.memory_types[*t as usize].property_flags.contains(visible)
            };
            let type_ = (0..types.memory_type_count).find(fits).unwrap();
            let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(type_);
            let memory = device.allocate_memory(&info, None).unwrap();
            device.bind_buffer_memory(handle, memory, 0).unwrap();
            let data = device.map_memory(memory, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty()).unwrap();
            std::slice::from_raw_parts_mut(data.cast::<u32>(), size as usize / 4).fill(POISON);
            Seen { handle, memory, data: data.cast(), size }
        }
    }
}

impl Drop for Engine {
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

struct Seen {
    handle: vk::Buffer,
    memory: vk::DeviceMemory,
    data: *const u32,
    size: u64,
}

impl Seen {
    fn words(&self) -> &[u32] {
        // SAFETY: the whole buffer is mapped, and the tests wait before they look.
        unsafe { std::slice::from_raw_parts(self.data, self.size as usize / 4) }
    }
}

/// Submits a command buffer of the engine, which copies one buffer to the other, with barriers before and after.
fn copy(device: &ash::Device, (from, to): (&Seen, &Seen)) {
    use vk::{AccessFlags as A, PipelineStageFlags as S};
    let barrier = |(src, before): (S, A), (dst, after): (S, A), commands| {
        let memory = [vk::MemoryBarrier::default().src_access_mask(before).dst_access_mask(after)];
        // SAFETY: the command buffer is recording.
        unsafe { device.cmd_pipeline_barrier(commands, src, dst, vk::DependencyFlags::empty(), &memory, &[], &[]) };
    };
    // SAFETY: valid arguments; everything is done before it is destroyed.
    unsafe {
        let pool = vk::CommandPoolCreateInfo::default().queue_family_index(0);
        let pool = device.create_command_pool(&pool, None).unwrap();
        let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
        let commands = device.allocate_command_buffers(&info).unwrap()[0];
        device.begin_command_buffer(commands, &vk::CommandBufferBeginInfo::default()).unwrap();
        let compute = (S::COMPUTE_SHADER, A::SHADER_WRITE);
        barrier(compute, (S::TRANSFER, A::TRANSFER_READ), commands);
        let region = vk::BufferCopy { src_offset: 0, dst_offset: 0, size: from.size };
        device.cmd_copy_buffer(commands, from.handle, to.handle, &[region]);
        barrier((S::TRANSFER, A::TRANSFER_READ), compute, commands);
        barrier((S::TRANSFER, A::TRANSFER_WRITE), (S::HOST, A::HOST_READ), commands);
        device.end_command_buffer(commands).unwrap();
        let all = [commands];
        let submit = vk::SubmitInfo::default().command_buffers(&all);
        device.queue_submit(device.get_device_queue(0, 0), &[submit], vk::Fence::null()).unwrap();
        device.device_wait_idle().unwrap();
        device.destroy_command_pool(pool, None);
    }
}

/// Runs a test with a device of the engine on each physical device, and fails if validation reports anything.
fn on_each_engine(test: impl Fn(&Engine, &VulkanDef<'_>, &ash::Device, &TestedDevice)) {
    let Some(engine) = Engine::new() else { return };
    // SAFETY: a valid instance.
    let devices = unsafe { engine.instance.enumerate_physical_devices() }.unwrap_or_default();
    let mut seen = Vec::new();
    for physical in devices {
        // SAFETY: a valid device.
        let properties = unsafe { engine.instance.get_physical_device_properties(physical) };
        let name = properties.device_name_as_c_str().unwrap().to_string_lossy().into_owned();
        let driver = format!("version {:#x}", properties.driver_version);
        let tested = TestedDevice { name: name.clone(), driver, translated: false };
        tested.announce();
        seen.push(name);
        let def = engine.def(physical);
        // SAFETY: valid handles.
        let wanted = unsafe { def.wanted_extensions() }.unwrap();
        let device = engine.device(physical, &wanted);
        test(&engine, &VulkanDef { device: device.handle(), device_extensions: &wanted, ..def }, &device, &tested);
        // SAFETY: the tests have waited.
        unsafe { device.destroy_device(None) };
        let messages = std::mem::take(&mut *engine.messages.lock().unwrap());
        assert!(messages.is_empty(), "on {:?}:\n{}", seen.last(), messages.join("\n"));
    }
    note_missing(&seen);
}

#[test]
fn vertices_go_into_the_engines_own_buffer() {
    let set = scenes::cube_set();
    on_each_engine(|engine, def, device, tested| {
        let layout = TestLayout::everything(&set, 0, 20);
        let size = layout.offset + layout.size + 64;
        let [seen, copied] = [(); 2].map(|()| engine.buffer(def.physical_device, device, size));
        // SAFETY: valid handles, extensions as enabled.
        let mut crumple = unsafe { Device::adopt(def, &DeviceDef::default()) }.unwrap();
        // SAFETY: a buffer of that device, which outlives it.
        let wrapped =
            unsafe { crumple.adopt_buffer(seen.handle, size, BufferUsages::STORAGE | BufferUsages::VERTEX) }.unwrap();
        let mut target = crumple.add_target(&set, &layout.def(&wrapped)).unwrap();
        let mut instance = folded(&set, 0, 0);
        let mut wanted = Expected::poison(size as usize / 4);
        for frame in 1..5 {
            crumple.submit(&mut [EncodeJob { instance: &instance, target: &mut target }]).unwrap();
            copy(device, (&seen, &copied));
            layout.expect(&mut instance, &mut wanted);
            wanted.compare(copied.words(), tested, &format!("frame {frame}"));
            hit(&mut instance, 2, frame);
        }
        drop((target, wrapped, crumple));
        // Both are still the engine's.
        copy(device, (&seen, &copied));
        for buffer in [seen, copied] {
            // SAFETY: nothing uses it any more.
            unsafe {
                device.destroy_buffer(buffer.handle, None);
                device.free_memory(buffer.memory, None);
            }
        }
    });
}

#[test]
fn what_cannot_be_adopted_is_refused() {
    on_each_engine(|engine, def, device, _| {
        // SAFETY: valid handles, or null.
        let adopt = |def: VulkanDef<'_>| unsafe { Device::adopt(&def, &DeviceDef::default()) };
        let no = |def, kind, words: &[&str]| refused(adopt(def), kind, words);
        no(VulkanDef { instance: vk::Instance::null(), ..def.clone() }, InvalidArgument, &["VkInstance"]);
        let physical_device = vk::PhysicalDevice::null();
        no(VulkanDef { physical_device, ..def.clone() }, InvalidArgument, &["VkPhysicalDevice"]);
        no(VulkanDef { device: vk::Device::null(), ..def.clone() }, InvalidArgument, &["VkDevice"]);
        no(
            VulkanDef { api_version: vk::API_VERSION_1_0, ..def.clone() },
            Unsupported,
            &["Vulkan 1.0", "needs one of 1.3"],
        );
        let device_extensions = &def.device_extensions[1..];
        let missing = def.device_extensions[0].to_str().unwrap();
        no(VulkanDef { device_extensions, ..def.clone() }, InvalidArgument, &["device_extensions", missing]);
        // SAFETY: as above.
        let crumple = unsafe { Device::adopt(def, &DeviceDef::default()) }.unwrap();
        let seen = engine.buffer(def.physical_device, device, 64);
        let usage = BufferUsages::STORAGE;
        for (handle, size, usage, words) in [
            (vk::Buffer::null(), 64, usage, ["VkBuffer", "null"]),
            (seen.handle, 0, usage, ["size", "0"]),
            (seen.handle, 64, BufferUsages::VERTEX, ["usage", "STORAGE"]),
            (seen.handle, 64, usage | BufferUsages::MAP_READ, ["usage", "MAP_READ"]),
        ] {
            // SAFETY: a valid buffer, or null.
            refused(unsafe { crumple.adopt_buffer(handle, size, usage) }, InvalidArgument, &words);
        }
        drop(crumple);
        // SAFETY: nothing uses it any more.
        unsafe {
            device.destroy_buffer(seen.handle, None);
            device.free_memory(seen.memory, None);
        }
    });
}
