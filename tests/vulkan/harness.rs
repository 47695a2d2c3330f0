//! An engine with the library on its device, and loaders that differ from the system's.

use std::cell::RefCell;
use std::ffi::{CStr, c_char};

use ash::vk;
use crumple::vulkan::{Access, BufferDef, BufferId, Device, DeviceDef};

use crate::gpu::Lowered;
pub use crate::gpu::engine::{Engine, Seen};
use crate::gpu::engine::{Needs, on_each_engine};

/// What the CPU sees of a buffer before and after each recording.
pub const HOST: Access = Access { stages: vk::PipelineStageFlags::HOST, access: vk::AccessFlags::HOST_READ };

/// Runs a test on each device there is, and fails if validation reports anything.
pub fn on_each_device(test: impl Fn(&Engine)) {
    let device_extensions = &|_: &_, _| Vec::new();
    let api_version = vk::API_VERSION_1_1;
    on_each_engine(&Needs { api_version, validation: true, instance_extensions: &[], device_extensions }, test);
}

impl Seen {
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

impl Engine<'_> {
    pub fn def(&self) -> DeviceDef<'static> {
        let instance = self.on.instance.handle();
        DeviceDef::new(self.on.get_instance_proc_addr, instance, self.physical, self.device.handle(), 0)
    }

    pub fn crumple(&self) -> Device {
        // SAFETY: valid handles.
        unsafe { Device::new(&self.def()) }.unwrap()
    }

    /// A new buffer, registered.
    pub fn target_buffer(&self, crumple: &mut Device, size: u64) -> (Seen, BufferId) {
        let seen = self.buffer(size);
        // SAFETY: a valid buffer that lives until the engine is dropped.
        let id = unsafe { crumple.add_buffer(&seen.def()) }.unwrap();
        (seen, id)
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

/// What this thread's loader does, and the system's functions that it stands before.
#[derive(Default)]
struct Loader {
    how: Tampered,
    get_instance: Option<vk::PFN_vkGetInstanceProcAddr>,
    get_device: Option<vk::PFN_vkGetDeviceProcAddr>,
    properties: Option<vk::PFN_vkGetPhysicalDeviceProperties>,
    barrier: Option<vk::PFN_vkCmdPipelineBarrier>,
    families: Vec<(vk::Buffer, u32, u32)>,
}

thread_local! {
    static LOADER: RefCell<Loader> = RefCell::default();
}

/// Buffers, source and destination families of this thread's watched barriers since it was last asked.
pub fn families() -> Vec<(vk::Buffer, u32, u32)> {
    LOADER.with_borrow_mut(|loader| std::mem::take(&mut loader.families))
}

/// The same definition with a loader that is tampered with, for this thread.
pub fn tampered(def: DeviceDef<'static>, how: Tampered) -> DeviceDef<'static> {
    LOADER.with_borrow_mut(|loader| (loader.how, loader.get_instance) = (how, Some(def.get_instance_proc_addr)));
    DeviceDef { get_instance_proc_addr: get_instance, ..def }
}

/// `own` instead of the function that was found, which the loader keeps.
///
/// # Safety
/// The function that was found is of the type of `own`.
unsafe fn instead<F: Copy>(
    own: F,
    found: vk::PFN_vkVoidFunction,
    keep: fn(&mut Loader) -> &mut Option<F>,
) -> vk::PFN_vkVoidFunction {
    // SAFETY: as the caller says; all are pointers to functions, or null.
    unsafe {
        LOADER.with_borrow_mut(|loader| *keep(loader) = std::mem::transmute_copy(&found));
        std::mem::transmute_copy(&Some(own))
    }
}

unsafe extern "system" fn get_instance(instance: vk::Instance, name: *const c_char) -> vk::PFN_vkVoidFunction {
    let (how, real) = LOADER.with_borrow(|loader| (loader.how, loader.get_instance.unwrap()));
    // SAFETY: the caller's name, the system's loader, and functions of the types their names say.
    unsafe {
        let (found, name) = (real(instance, name), CStr::from_ptr(name));
        if how.without == Some(name) {
            None
        } else if name == c"vkGetDeviceProcAddr" {
            instead(get_device as vk::PFN_vkGetDeviceProcAddr, found, |loader| &mut loader.get_device)
        } else if name == c"vkGetPhysicalDeviceProperties" {
            instead(properties as vk::PFN_vkGetPhysicalDeviceProperties, found, |loader| &mut loader.properties)
        } else {
            found
        }
    }
}

unsafe extern "system" fn get_device(device: vk::Device, name: *const c_char) -> vk::PFN_vkVoidFunction {
    let (how, real) = LOADER.with_borrow(|loader| (loader.how, loader.get_device.unwrap()));
    // SAFETY: as above.
    unsafe {
        let (found, name) = (real(device, name), CStr::from_ptr(name));
        if how.without == Some(name) {
            None
        } else if name == c"vkCmdPipelineBarrier" {
            instead(barrier as vk::PFN_vkCmdPipelineBarrier, found, |loader| &mut loader.barrier)
        } else {
            found
        }
    }
}

unsafe extern "system" fn properties(physical: vk::PhysicalDevice, out: *mut vk::PhysicalDeviceProperties) {
    let (how, real) = LOADER.with_borrow(|loader| (loader.how, loader.properties.unwrap()));
    // SAFETY: the system's function, and the caller's memory.
    unsafe {
        real(physical, out);
        let (limits, lowered) = (&mut (*out).limits, how.lowered);
        let groups = &mut limits.max_compute_work_group_count[0];
        *groups = lowered.workgroups.unwrap_or(*groups);
        let bytes = lowered.binding_bytes.map(|bytes| bytes as u32);
        limits.max_storage_buffer_range = bytes.unwrap_or(limits.max_storage_buffer_range);
        (*out).api_version = how.api_version.unwrap_or((*out).api_version);
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
    // SAFETY: the caller's barriers.
    let all = unsafe { std::slice::from_raw_parts(buffers, buffer_count as usize) };
    let (dropped, real) = LOADER.with_borrow_mut(|loader| {
        if loader.how.watch {
            let families = |b: &vk::BufferMemoryBarrier| (b.buffer, b.src_queue_family_index, b.dst_queue_family_index);
            loader.families.extend(all.iter().map(families));
        }
        let dropped = loader.how.barriers == Some(0);
        loader.how.barriers = loader.how.barriers.map(|left| left.saturating_sub(1));
        (dropped, loader.barrier.unwrap())
    });
    if !dropped {
        // SAFETY: passed on.
        unsafe { real(commands, from, to, flags, memory_count, memory, buffer_count, buffers, image_count, images) };
    }
}
