//! Devices, buffers and recordings that are refused; frames that are not submitted; barriers that validation misses.

use crumple::vulkan::vk;
use crumple::vulkan::{BufferDef, Device, DeviceDef, FrameReport, Job};
use crumple::{Error, ErrorKind};

use crate::backend;
use crate::gpu::layout::TestLayout;
use crate::gpu::refusals::refused;
use crate::gpu::scene::Scene;
use crate::gpu::{folded, hit};
use crate::harness::{Engine, Tampered, on_each_device, tampered};
use crate::scenes;

fn new(def: &DeviceDef<'_>) -> Result<Device, Error> {
    // SAFETY: valid handles, or null, or a loader that lacks something.
    unsafe { Device::new(def) }
}

#[test]
fn devices_that_will_not_do_are_refused() {
    use ErrorKind::{InvalidArgument, Unsupported};
    on_each_device(|engine| {
        let def = engine.def();
        refused(new(&DeviceDef { instance: vk::Instance::null(), ..def.clone() }), InvalidArgument, &["VkInstance"]);
        let physical_device = vk::PhysicalDevice::null();
        refused(new(&DeviceDef { physical_device, ..def.clone() }), InvalidArgument, &["VkPhysicalDevice"]);
        refused(new(&DeviceDef { device: vk::Device::null(), ..def.clone() }), InvalidArgument, &["VkDevice"]);
        refused(new(&DeviceDef { queue_family: 7, ..def.clone() }), InvalidArgument, &["queue_family", "7", "0"]);
        for name in [c"vkGetDeviceProcAddr", c"vkGetPhysicalDeviceProperties", c"vkCmdDispatch", c"vkCreateBuffer"] {
            let how = Tampered { without: Some(name), ..Tampered::default() };
            refused(new(&tampered(def.clone(), how)), Unsupported, &[name.to_str().unwrap()]);
        }
        let how = Tampered { api_version: Some(vk::API_VERSION_1_0), ..Tampered::default() };
        refused(new(&tampered(def.clone(), how)), Unsupported, &["1.0", "1.1"]);
    });
}

#[test]
fn buffers_that_will_not_do_are_refused() {
    use ErrorKind::InvalidArgument;
    on_each_device(|engine| {
        let mut crumple = engine.crumple();
        let seen = engine.buffer(64);
        // SAFETY: a valid buffer, or null.
        let mut add = |def: BufferDef| unsafe { crumple.add_buffer(&def) };
        let good = seen.def();
        refused(add(BufferDef { buffer: vk::Buffer::null(), ..good }), InvalidArgument, &["VkBuffer", "null"]);
        refused(add(BufferDef { size: 0, ..good }), InvalidArgument, &["size", "0"]);
        let usage = vk::BufferUsageFlags::VERTEX_BUFFER;
        refused(add(BufferDef { usage, ..good }), InvalidArgument, &["usage", "VERTEX_BUFFER", "STORAGE_BUFFER"]);
        let mut none = good.before;
        none.stages = vk::PipelineStageFlags::empty();
        refused(add(BufferDef { before: none, ..good }), InvalidArgument, &["the stages before"]);
        refused(add(BufferDef { after: none, ..good }), InvalidArgument, &["the stages after"]);
        let id = add(good).unwrap();
        crumple.remove_buffer(id).unwrap();
        refused(crumple.remove_buffer(id), InvalidArgument, &["buffer", "number 1"]);
        // SAFETY: a valid buffer.
        let again = unsafe { crumple.add_buffer(&good) }.unwrap();
        assert_ne!(id, again);
        refused(crumple.remove_buffer(id), InvalidArgument, &["buffer"]);
    });
}

#[test]
fn recordings_that_will_not_do_are_refused() {
    use ErrorKind::InvalidArgument;
    let set = scenes::cube_set();
    backend::on_each_device(|gpu| {
        let mut scene = Scene::of(gpu, &set, 5, 1);
        // Nothing was recorded yet: that is of no frame to come.
        gpu.crumple.completed(u64::MAX);
        // A command buffer that must not be touched.
        let (none, any) = (vk::CommandBuffer::null(), vk::Handle::from_raw(1));
        // SAFETY: nothing is recorded.
        let record = |d: &mut Device, commands, frame, scene: &mut Scene| unsafe {
            d.record(commands, frame, &mut scene.jobs())
        };
        refused(record(&mut gpu.crumple, none, 4, &mut scene), InvalidArgument, &["VkCommandBuffer"]);
        refused(record(&mut gpu.crumple, any, 0, &mut scene), InvalidArgument, &["frame", "0"]);
        assert!(scene.targets[0].bounds().is_none());
        scene.run(gpu);
        scene.check(gpu, "after errors");
        hit(&mut scene.instances[0], 1, 6);
        refused(record(&mut gpu.crumple, any, 1, &mut scene), InvalidArgument, &["frame", "1"]);
        let buffer = scene.buffer.as_ref();
        gpu.crumple.remove_buffer(buffer).unwrap();
        refused(gpu.crumple.add_target(&set, &scene.layouts[0].def(buffer)), InvalidArgument, &["buffer"]);
        refused(record(&mut gpu.crumple, any, 6, &mut scene), InvalidArgument, &["buffer of job 0"]);
    });
}

/// Records, and copies what was written in the same command buffer; with all barriers but the first `barriers`.
fn with_barriers(engine: &Engine, barriers: Option<u32>) -> Vec<String> {
    let how = Tampered { barriers, ..Tampered::default() };
    let mut crumple = new(&tampered(engine.def(), how)).unwrap();
    let set = scenes::sheet_set();
    let layout = TestLayout::everything(&set, 0, 0);
    let seen = engine.buffer(layout.size);
    let mut def = seen.def();
    def.after.stages = vk::PipelineStageFlags::TRANSFER;
    def.after.access = vk::AccessFlags::TRANSFER_READ;
    // SAFETY: a valid buffer.
    let id = unsafe { crumple.add_buffer(&def) }.unwrap();
    let copy = engine.buffer(layout.size);
    let mut target = crumple.add_target(&set, &layout.def(id)).unwrap();
    let instance = folded(&set, 5, 1);
    let report = engine.run(|c| {
        let job = Job { instance: &instance, target: &mut target };
        // SAFETY: the command buffer is recording.
        unsafe {
            let report = crumple.record(c, 1, &mut [job]).unwrap();
            let region = vk::BufferCopy { src_offset: 0, dst_offset: 0, size: layout.size };
            engine.device.cmd_copy_buffer(c, seen.handle, copy.handle, &[region]);
            report
        }
    });
    assert_ne!(report, FrameReport::default());
    crumple.completed(1);
    engine.on.messages()
}

#[test]
fn validation_sees_each_missing_barrier() {
    on_each_device(|engine| {
        if !engine.validated() {
            return;
        }
        assert_eq!(with_barriers(engine, None), Vec::<String>::new());
        let before = with_barriers(engine, Some(0)).join("\n");
        assert!(before.contains("SYNC-HAZARD-READ-AFTER-WRITE"), "{before}");
        // The kernel's writes are seen through their chains of accesses.
        let after = with_barriers(engine, Some(1)).join("\n");
        assert!(after.contains("SYNC-HAZARD-READ-AFTER-WRITE"), "{after}");
    });
}
