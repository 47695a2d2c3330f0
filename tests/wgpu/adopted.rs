//! A Vulkan device of an engine, under validation: wgpu works on it and on its buffers, and leaves both to the engine.

use std::ffi::CStr;

use ash::{khr, vk};
use crumple::ErrorKind::{InvalidArgument, Unsupported};
use crumple::wgpu::wgpu::BufferUsages;
use crumple::wgpu::{Device, DeviceDef, Job, VulkanDef};

use crate::gpu::compare::Expected;
use crate::gpu::engine::{Engine, Instance, Needs, Seen, on_each_engine};
use crate::gpu::layout::TestLayout;
use crate::gpu::refusals::refused;
use crate::gpu::{folded, hit};
use crate::scenes;

/// The definition for a physical device and its device, which may be null so far.
fn def<'a>(
    on: &'a Instance,
    physical_device: vk::PhysicalDevice,
    device: vk::Device,
    device_extensions: &'a [&'static CStr],
) -> VulkanDef<'a> {
    VulkanDef {
        get_instance_proc_addr: on.get_instance_proc_addr,
        instance: on.instance.handle(),
        api_version: vk::API_VERSION_1_3,
        instance_extensions: &on.extensions,
        physical_device,
        device,
        device_extensions,
        queue_family: 0,
        queue_index: 0,
    }
}

/// Runs a test with a device of the engine on each physical device, and fails if validation reports anything.
fn on_each_device(test: impl Fn(&Engine, &VulkanDef<'_>)) {
    let needs = Needs {
        api_version: vk::API_VERSION_1_3,
        validation: true,
        instance_extensions: &[khr::get_physical_device_properties2::NAME],
        // SAFETY: valid handles.
        device_extensions: &|on, physical| unsafe {
            def(on, physical, vk::Device::null(), &[]).wanted_extensions().unwrap()
        },
    };
    on_each_engine(&needs, |engine| {
        test(engine, &def(engine.on, engine.physical, engine.device.handle(), &engine.extensions));
    });
}

/// Submits a command buffer of the engine, which copies one buffer to the other, with barriers before and after.
fn copy(engine: &Engine, (from, to): (&Seen, &Seen)) {
    use vk::{AccessFlags as A, PipelineStageFlags as S};
    let device = &engine.device;
    let barrier = |(src, before): (S, A), (dst, after): (S, A), commands| {
        let memory = [vk::MemoryBarrier::default().src_access_mask(before).dst_access_mask(after)];
        // SAFETY: the command buffer is recording.
        unsafe { device.cmd_pipeline_barrier(commands, src, dst, vk::DependencyFlags::empty(), &memory, &[], &[]) };
    };
    engine.run(|commands| {
        let compute = (S::COMPUTE_SHADER, A::SHADER_WRITE);
        barrier(compute, (S::TRANSFER, A::TRANSFER_READ), commands);
        let region = vk::BufferCopy { src_offset: 0, dst_offset: 0, size: from.size };
        // SAFETY: as above.
        unsafe { device.cmd_copy_buffer(commands, from.handle, to.handle, &[region]) };
        barrier((S::TRANSFER, A::TRANSFER_READ), compute, commands);
        barrier((S::TRANSFER, A::TRANSFER_WRITE), (S::HOST, A::HOST_READ), commands);
    });
}

#[test]
fn vertices_go_into_the_engines_own_buffer() {
    let set = scenes::cube_set();
    on_each_device(|engine, def| {
        let layout = TestLayout::everything(&set, 0, 20);
        let size = layout.offset + layout.size + 64;
        let [seen, copied] = [(); 2].map(|()| engine.buffer(size));
        // SAFETY: valid handles, extensions as enabled.
        let mut crumple = unsafe { Device::adopt(def, &DeviceDef::default()) }.unwrap();
        // SAFETY: a buffer of that device, which outlives it.
        let wrapped =
            unsafe { crumple.adopt_buffer(seen.handle, size, BufferUsages::STORAGE | BufferUsages::VERTEX) }.unwrap();
        let mut target = crumple.add_target(&set, &layout.def(&wrapped)).unwrap();
        let mut instance = folded(&set, 0, 0);
        let mut wanted = Expected::poison(size as usize / 4);
        for frame in 1..5 {
            crumple.submit(&mut [Job { instance: &instance, target: &mut target }]).unwrap();
            copy(engine, (&seen, &copied));
            layout.expect(&mut instance, &mut wanted);
            wanted.compare(copied.words(), &engine.tested, &format!("frame {frame}"));
            hit(&mut instance, 2, frame);
        }
        drop((target, wrapped, crumple));
        // Both are still the engine's.
        copy(engine, (&seen, &copied));
    });
}

#[test]
fn what_cannot_be_adopted_is_refused() {
    on_each_device(|engine, def| {
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
        let seen = engine.buffer(64);
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
    });
}
