//! Bad input is named, and nothing is recorded then; what goes wrong on the device is seen.

use crumple::vulkan::vk;
use crumple::vulkan::{BufferDef, Device, DeviceDef, RecordJob, RecordReport, Stream, Target, TargetDef};
use crumple::{Error, ErrorKind, Instance, InstanceOptions, Rule, SetOptions};

use crate::harness::{Engine, POISON, Tampered, on_each_device, tampered};
use crate::scenes;
use crate::{Plan, folded, same};

/// Fails unless the result is an error of this kind whose text holds all of these words.
#[track_caller]
fn refused<T>(result: Result<T, Error>, kind: ErrorKind, words: &[&str]) {
    let Err(error) = result else { panic!("accepted; {words:?} should be refused") };
    let text = error.to_string();
    assert!(error.kind() == kind && words.iter().all(|w| text.contains(w)), "{kind:?} {words:?}: {error:?} {text}");
}

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
        for workgroup_size in [0, 16, 100, 4096] {
            let size = workgroup_size.to_string();
            refused(new(&DeviceDef { workgroup_size, ..def.clone() }), InvalidArgument, &["workgroup_size", &size]);
        }
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
        refused(crumple.remove_buffer(id), InvalidArgument, &["buffer", "generation 1"]);
        // SAFETY: a valid buffer.
        let again = unsafe { crumple.add_buffer(&good) }.unwrap();
        assert_ne!(id, again);
        refused(crumple.remove_buffer(id), InvalidArgument, &["buffer"]);
    });
}

#[test]
fn targets_that_will_not_do_are_refused() {
    use ErrorKind::{BufferTooSmall, IndexOutOfRange, InvalidArgument, Misaligned, Unsupported};
    let set = scenes::cube_set();
    on_each_device(|engine| {
        let mut crumple = engine.crumple();
        let plan = Plan::everything(&set, 0, 0);
        let (_, id) = engine.target_buffer(&mut crumple, plan.size);
        let good = plan.def(id);
        let mut refused = |def: TargetDef, kind, words: &[&str]| refused(crumple.add_target(&set, &def), kind, words);
        refused(TargetDef { lod: 1, ..good }, IndexOutOfRange, &["1"]);
        refused(TargetDef { offset: 2, size: 4, ..good }, Misaligned, &["target's offset", "2"]);
        refused(TargetDef { offset: 8, ..good }, BufferTooSmall, &["buffer"]);
        refused(TargetDef { offset: u64::MAX - 3, ..good }, BufferTooSmall, &["buffer"]);
        refused(TargetDef { size: plan.size - 8, ..good }, BufferTooSmall, &["tangent"]);
        let with = |change: fn(&mut Stream)| {
            let mut positions = good.positions;
            change(&mut positions);
            TargetDef { positions, ..good }
        };
        refused(with(|s| s.stride = 50), Misaligned, &["position stride", "50", "4"]);
        refused(with(|s| s.offset = 3), Misaligned, &["position offset", "3"]);
        refused(with(|s| s.stride = 8), InvalidArgument, &["position stride", "8", "12"]);
        refused(with(|s| s.stride = 0), InvalidArgument, &["position stride", "0", "12"]);
        refused(with(|s| s.stride = 1 << 40), InvalidArgument, &["position stride"]);
        refused(with(|s| s.offset = 1 << 40), BufferTooSmall, &["position"]);
        refused(with(|s| s.offset += 8), InvalidArgument, &["position", "normal"]);
        let bad = |s: &mut Stream| s.format = vk::Format::R32G32_SFLOAT;
        refused(
            with(bad),
            InvalidArgument,
            &["position format", "R32G32_SFLOAT", "R32G32B32_SFLOAT", "R16G16B16A16_SNORM"],
        );
        let mut normals = good.normals.unwrap();
        normals.format = vk::Format::R16G16B16A16_SFLOAT;
        refused(TargetDef { normals: Some(normals), ..good }, InvalidArgument, &["normal format", "R8G8B8A8_SNORM"]);
        let half = |s: &mut Stream| s.format = vk::Format::R16G16B16A16_SNORM;
        for scale in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            let def = TargetDef { scale: [1.0, scale, 1.0], ..with(half) };
            refused(def, InvalidArgument, &["scale", &format!("{scale:?}")]);
        }
        let mut flat = scenes::sheet(4);
        (flat.normals, flat.tangents, flat.triangles) = (None, None, Vec::new());
        let example = crumple::ExampleData::new(
            "poke",
            crumple::Deltas::Sparse { indices: vec![3], values: vec![[0.0, 0.0, -0.1]] },
        );
        let bare = scenes::build(flat, vec![example], SetOptions::default());
        let stream = |offset| Stream { offset, stride: 44, format: vk::Format::R32G32B32_SFLOAT };
        let def = TargetDef { normals: Some(stream(12)), positions: stream(0), tangents: None, ..good };
        super::errors::refused(crumple.add_target(&bare, &def), Unsupported, &["normal"]);
        let ball = scenes::ball_set();
        let tangents = Stream { format: vk::Format::R32G32B32A32_SFLOAT, ..stream(24) };
        let def = TargetDef { tangents: Some(tangents), positions: stream(0), normals: None, ..good };
        super::errors::refused(crumple.add_target(&ball, &def), Unsupported, &["tangent"]);
        crumple.remove_buffer(id).unwrap();
        super::errors::refused(crumple.add_target(&set, &good), InvalidArgument, &["buffer"]);
    });
}

#[test]
fn recordings_that_will_not_do_are_refused_and_change_nothing() {
    use ErrorKind::InvalidArgument;
    let set = scenes::cube_set();
    on_each_device(|engine| {
        let (mut crumple, mut other) = (engine.crumple(), engine.crumple());
        let plan = Plan::everything(&set, 0, 0);
        let (seen, id) = engine.target_buffer(&mut crumple, plan.size);
        let mut target = crumple.add_target(&set, &plan.def(id)).unwrap();
        let instance = folded(&set, 5, 1);
        // Nothing was recorded yet: that is of no frame to come.
        crumple.completed(u64::MAX);
        let record = |d: &mut Device, c, frame, instance: &Instance, target: &mut Target| {
            // SAFETY: the command buffer is recording, or nothing is recorded.
            unsafe { d.record(c, frame, &mut [RecordJob { instance, target }]) }
        };
        engine.run(|c| {
            let none = vk::CommandBuffer::null();
            refused(record(&mut crumple, none, 4, &instance, &mut target), InvalidArgument, &["VkCommandBuffer"]);
            refused(record(&mut crumple, c, 0, &instance, &mut target), InvalidArgument, &["frame", "0"]);
            refused(record(&mut other, c, 4, &instance, &mut target), InvalidArgument, &["target of job 0"]);
            let stranger = folded(&scenes::ball_set(), 1, 1);
            refused(record(&mut crumple, c, 4, &stranger, &mut target), InvalidArgument, &["example set", "job 0"]);
        });
        assert!(seen.words().iter().all(|w| *w == POISON) && target.bounds().is_none());
        // After all that it works.
        let mut wanted = vec![POISON; seen.words().len()];
        engine.run(|c| record(&mut crumple, c, 5, &instance, &mut target)).unwrap();
        plan.expect(&instance, &mut wanted);
        same(seen.words(), &wanted, "after errors");
        let again = folded(&set, 6, 1);
        crumple.completed(5);
        refused(
            record(&mut crumple, vk::Handle::from_raw(1), 5, &again, &mut target),
            InvalidArgument,
            &["frame", "5"],
        );
        crumple.remove_buffer(id).unwrap();
        let gone = record(&mut crumple, vk::Handle::from_raw(1), 6, &again, &mut target);
        refused(gone, InvalidArgument, &["buffer of job 0"]);
    });
}

#[test]
fn classic_rules_show_the_base_mesh_alone() {
    let mesh = scenes::sheet(8);
    let examples = scenes::bowls(&mesh, 2, 0.3, 1);
    let mut set = crumple::ExampleSet::build(mesh, examples, SetOptions::default(), &crumple::Serial).unwrap();
    set.add_lod(scenes::sheet(4), &crumple::Serial).unwrap();
    let set = std::sync::Arc::new(set);
    on_each_device(|engine| {
        let mut crumple = engine.crumple();
        let plan = Plan::everything(&set, 1, 0);
        let (_, id) = engine.target_buffer(&mut crumple, plan.size);
        let target = &mut crumple.add_target(&set, &plan.def(id)).unwrap();
        let instance = &Instance::new(set.clone(), InstanceOptions::classic(Rule::MostDisplaced)).unwrap();
        // SAFETY: the command buffer is recording.
        let recorded = engine.run(|c| unsafe { crumple.record(c, 1, &mut [RecordJob { instance, target }]) });
        refused(recorded, ErrorKind::WrongRule, &["level of detail", "Marks"]);
    });
}

#[test]
fn what_was_not_submitted_is_recorded_again() {
    let set = scenes::sheet_set();
    on_each_device(|engine| {
        let mut crumple = engine.crumple();
        let plan = Plan::everything(&set, 0, 0);
        let (seen, id) = engine.target_buffer(&mut crumple, plan.size);
        let mut target = crumple.add_target(&set, &plan.def(id)).unwrap();
        let instance = folded(&set, 5, 1);
        let commands = engine.begin(vk::CommandBufferLevel::PRIMARY);
        let job = RecordJob { instance: &instance, target: &mut target };
        // SAFETY: the command buffer is recording.
        unsafe {
            crumple.record(commands, 1, &mut [job]).unwrap();
            engine.device.end_command_buffer(commands).unwrap();
        }
        crumple.discard(1);
        target.invalidate();
        let job = RecordJob { instance: &instance, target: &mut target };
        // SAFETY: the command buffer is recording.
        engine.run(|c| unsafe { crumple.record(c, 2, &mut [job]) }).unwrap();
        crumple.completed(2);
        let mut wanted = vec![POISON; seen.words().len()];
        plan.expect(&instance, &mut wanted);
        same(seen.words(), &wanted, "after one that was not submitted");
    });
}

#[test]
fn devices_dropped_with_frames_in_flight_leave_them_alone() {
    let set = scenes::sheet_set();
    on_each_device(|engine| {
        // Only what is not leaked can be checked under validation, so nothing is recorded with it.
        let mut crumple = engine.crumple();
        let plan = Plan::everything(&set, 0, 0);
        let (_, id) = engine.target_buffer(&mut crumple, plan.size);
        let target = crumple.add_target(&set, &plan.def(id)).unwrap();
        drop(crumple);
        assert!(target.bounds().is_none());
    });
}

/// Records, and copies what was written in the same command buffer; with all barriers but the first `barriers`.
fn with_barriers(engine: &Engine, barriers: Option<u32>) -> Vec<String> {
    let how = Tampered { barriers, ..Tampered::default() };
    let mut crumple = new(&tampered(engine.def(), how)).unwrap();
    let set = scenes::sheet_set();
    let plan = Plan::everything(&set, 0, 0);
    let seen = engine.buffer(plan.size);
    let mut def = seen.def();
    def.after.stages = vk::PipelineStageFlags::TRANSFER;
    def.after.access = vk::AccessFlags::TRANSFER_READ;
    // SAFETY: a valid buffer.
    let id = unsafe { crumple.add_buffer(&def) }.unwrap();
    let copy = engine.buffer(plan.size);
    let mut target = crumple.add_target(&set, &plan.def(id)).unwrap();
    let instance = folded(&set, 5, 1);
    let report = engine.run(|c| {
        let job = RecordJob { instance: &instance, target: &mut target };
        // SAFETY: the command buffer is recording.
        unsafe {
            let report = crumple.record(c, 1, &mut [job]).unwrap();
            let region = vk::BufferCopy { src_offset: 0, dst_offset: 0, size: plan.size };
            engine.device.cmd_copy_buffer(c, seen.handle, copy.handle, &[region]);
            report
        }
    });
    assert_ne!(report, RecordReport::default());
    crumple.completed(1);
    engine.messages()
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
