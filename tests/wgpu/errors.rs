//! Bad input is named, and nothing is encoded then.

use crumple::wgpu::wgpu;
use crumple::wgpu::{Device, DeviceDef, EncodeJob, HeadlessDef, Stream, TargetDef, adapters};
use crumple::{Error, ErrorKind, Instance, InstanceOptions, Rule, SetOptions, VertexMemory};

use crate::harness::{POISON, buffer, on_each_device, read};
use crate::{Plan, folded, same, scenes};

/// Fails unless the result is an error of this kind whose text holds all of these words.
#[track_caller]
pub fn refused<T>(result: Result<T, Error>, kind: ErrorKind, words: &[&str]) {
    let Err(error) = result else { panic!("accepted; {words:?} should be refused") };
    let text = error.to_string();
    assert!(error.kind() == kind && words.iter().all(|w| text.contains(w)), "{kind:?} {words:?}: {error:?} {text}");
}

#[test]
fn devices_that_will_not_do_are_refused() {
    use ErrorKind::{InvalidArgument, Unsupported};
    let def = HeadlessDef { adapter: Some("no such thing"), ..HeadlessDef::default() };
    let there: Vec<String> = adapters(def.backends).into_iter().map(|a| a.name).collect();
    let mut words = vec!["no adapter named \"no such thing\""];
    words.extend(there.iter().map(String::as_str));
    refused(Device::headless(&def), Unsupported, &words);
    let none = HeadlessDef { backends: wgpu::Backends::empty(), ..HeadlessDef::default() };
    refused(Device::headless(&none), Unsupported, &["no adapter", "none"]);
    on_each_device(|gpu| {
        let [(device, queue), _] = gpu.hosts(|_| ());
        for workgroup_size in [0, 16, 100, 4096] {
            let made = Device::new(&device, &queue, &DeviceDef { workgroup_size });
            refused(made, InvalidArgument, &["workgroup_size", &workgroup_size.to_string(), "power of two"]);
        }
        let lower = |change: fn(&mut wgpu::Limits), words: &[&str]| {
            let [(device, queue), _] = gpu.hosts(change);
            refused(Device::new(&device, &queue, &DeviceDef::default()), Unsupported, words);
        };
        lower(
            |l| l.max_storage_buffers_per_shader_stage = 3,
            &["max_storage_buffers_per_shader_stage 3", "at least 4"],
        );
        lower(|l| l.max_bind_groups = 2, &["max_bind_groups 2", "at least 3"]);
    });
}

#[test]
fn targets_that_will_not_do_are_refused() {
    use ErrorKind::{BufferTooSmall, IndexOutOfRange, InvalidArgument, Misaligned, Unsupported, Vulkan};
    let set = scenes::cube_set();
    on_each_device(|gpu| {
        let mut crumple = gpu.crumple();
        let plan = Plan::everything(&set, 0, 0);
        let seen = buffer(&crumple, plan.size);
        let good = plan.def(&seen);
        let mut no = |def: TargetDef<'_>, kind, words: &[&str]| refused(crumple.add_target(&set, &def), kind, words);
        no(TargetDef { lod: 1, ..good }, IndexOutOfRange, &["1"]);
        no(TargetDef { offset: 2, size: 4, ..good }, Misaligned, &["target's offset", "2"]);
        no(TargetDef { offset: 8, ..good }, BufferTooSmall, &["buffer"]);
        no(TargetDef { offset: u64::MAX - 3, ..good }, BufferTooSmall, &["buffer"]);
        no(TargetDef { size: plan.size - 8, ..good }, BufferTooSmall, &["tangent"]);
        let with = |change: fn(&mut Stream)| {
            let mut positions = good.positions;
            change(&mut positions);
            TargetDef { positions, ..good }
        };
        no(with(|s| s.stride = 50), Misaligned, &["position stride", "50", "4"]);
        no(with(|s| s.offset = 3), Misaligned, &["position offset", "3"]);
        no(with(|s| s.stride = 8), InvalidArgument, &["position stride", "8", "12"]);
        no(with(|s| s.stride = 0), InvalidArgument, &["position stride", "0", "12"]);
        no(with(|s| s.offset = 1 << 40), BufferTooSmall, &["position"]);
        no(with(|s| s.offset += 8), InvalidArgument, &["position", "normal"]);
        let flat = |s: &mut Stream| s.format = wgpu::VertexFormat::Float32x2;
        no(with(flat), InvalidArgument, &["position format", "Float32x2", "Float32x3", "Snorm16x4"]);
        let normals = Some(Stream { format: wgpu::VertexFormat::Float16x4, ..good.normals.unwrap() });
        no(TargetDef { normals, ..good }, InvalidArgument, &["normal format", "Snorm8x4"]);
        for scale in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            let packed = with(|s| s.format = wgpu::VertexFormat::Snorm16x4);
            let def = TargetDef { scale: [1.0, scale, 1.0], ..packed };
            no(def, InvalidArgument, &["scale", &format!("{scale:?}")]);
        }
        let ball = scenes::ball_set();
        let stream = |offset, format| Stream { offset, stride: 44, format };
        let positions = stream(0, wgpu::VertexFormat::Float32x3);
        let tangents = Some(stream(24, wgpu::VertexFormat::Float32x4));
        let def = TargetDef { tangents, positions, normals: None, ..good };
        refused(crumple.add_target(&ball, &def), Unsupported, &["tangent"]);
        let descriptor = wgpu::BufferDescriptor {
            label: None,
            size: plan.size,
            usage: wgpu::BufferUsages::VERTEX,
            mapped_at_creation: false,
        };
        let vertex = crumple.device().create_buffer(&descriptor);
        refused(crumple.add_target(&set, &plan.def(&vertex)), InvalidArgument, &["usage", "VERTEX", "STORAGE"]);
        // What wgpu itself finds out comes back too, and not to its handler of uncaptured errors.
        let [mut mine, other] = gpu.hosts(|_| ()).map(|(device, queue)| {
            device.on_uncaptured_error(std::sync::Arc::new(|e| panic!("{e}")));
            Device::new(&device, &queue, &DeviceDef::default()).unwrap()
        });
        let foreign = buffer(&other, plan.size);
        refused(mine.add_target(&set, &plan.def(&foreign)), Vulkan, &["binding a buffer", "wgpu"]);
        crumple.add_target(&set, &good).unwrap();
    });
}

#[test]
fn encodings_that_will_not_do_are_refused_and_change_nothing() {
    use ErrorKind::{InvalidArgument, Vulkan};
    let set = scenes::cube_set();
    on_each_device(|gpu| {
        let (mut crumple, mut other) = (gpu.crumple(), gpu.crumple());
        let plan = Plan::everything(&set, 0, 0);
        let seen = buffer(&crumple, plan.size);
        let mut target = crumple.add_target(&set, &plan.def(&seen)).unwrap();
        let instance = folded(&set, 5, 1);
        let job = EncodeJob { instance: &instance, target: &mut target };
        refused(other.submit(&mut [job]), InvalidArgument, &["target of job 0", "another device"]);
        let stranger = folded(&scenes::ball_set(), 1, 1);
        let job = EncodeJob { instance: &stranger, target: &mut target };
        refused(crumple.submit(&mut [job]), InvalidArgument, &["instance of job 0", "example set"]);
        assert!(read(&mut crumple, &seen).iter().all(|w| *w == POISON) && target.bounds().is_none());
        // After all that it works.
        crumple.submit(&mut [EncodeJob { instance: &instance, target: &mut target }]).unwrap();
        let mut wanted = vec![POISON; seen.size() as usize / 4];
        plan.expect(&instance, &mut wanted);
        same(&read(&mut crumple, &seen), &wanted, "after errors");
        // A buffer that the host destroyed.
        seen.destroy();
        let again = folded(&set, 6, 1);
        let job = EncodeJob { instance: &again, target: &mut target };
        refused(crumple.submit(&mut [job]), Vulkan, &["submitting", "destroyed"]);
    });
}

#[test]
fn classic_rules_show_the_base_mesh_alone() {
    let mesh = scenes::sheet(8);
    let examples = scenes::bowls(&mesh, 2, 0.3, 1);
    let mut set = crumple::ExampleSet::build(mesh, examples, SetOptions::default(), &crumple::Serial).unwrap();
    set.add_lod(scenes::sheet(4), &crumple::Serial).unwrap();
    let set = std::sync::Arc::new(set);
    on_each_device(|gpu| {
        let mut crumple = gpu.crumple();
        let plan = Plan::everything(&set, 1, 0);
        let seen = buffer(&crumple, plan.size);
        let target = &mut crumple.add_target(&set, &plan.def(&seen)).unwrap();
        let instance = &Instance::new(set.clone(), InstanceOptions::classic(Rule::MostDisplaced)).unwrap();
        let encoded = crumple.submit(&mut [EncodeJob { instance, target }]);
        refused(encoded, ErrorKind::WrongRule, &["level of detail", "Marks"]);
    });
}

#[test]
fn readings_that_will_not_do_are_refused() {
    use ErrorKind::{BufferTooSmall, InvalidArgument, Misaligned, Unsupported};
    let set = scenes::ball_set();
    on_each_device(|gpu| {
        let mut crumple = gpu.crumple();
        let plan = Plan::everything(&set, 0, 0);
        let seen = buffer(&crumple, plan.size);
        let mut bytes = [7; 8];
        refused(crumple.read(&seen, 2, &mut bytes), Misaligned, &["offset", "2"]);
        refused(crumple.read(&seen, 0, &mut bytes[..3]), Misaligned, &["bytes to read", "3"]);
        refused(crumple.read(&seen, plan.size - 4, &mut bytes), BufferTooSmall, &["buffer"]);
        refused(crumple.read(&seen, u64::MAX - 3, &mut bytes), BufferTooSmall, &["buffer"]);
        let usage = wgpu::BufferUsages::STORAGE;
        let descriptor = wgpu::BufferDescriptor { label: None, size: 64, usage, mapped_at_creation: false };
        let sealed = crumple.device().create_buffer(&descriptor);
        refused(crumple.read(&sealed, 0, &mut bytes), InvalidArgument, &["usage", "COPY_SRC"]);
        assert_eq!(bytes, [7; 8]);
        let target = crumple.add_target(&set, &plan.def(&seen)).unwrap();
        let count = set.vertex_count();
        let (mut p, mut t) = (vec![[0.0; 3]; count], vec![[0.0; 4]; count]);
        let mut memory = VertexMemory::separate(&mut p, None, Some(&mut t)).unwrap();
        refused(crumple.read_vertices(&set, &target, &mut memory), Unsupported, &["tangents"]);
        let mut memory = VertexMemory::separate(&mut p[1..], None, None).unwrap();
        refused(crumple.read_vertices(&set, &target, &mut memory), BufferTooSmall, &["position"]);
        let other = scenes::cube_set();
        let mut memory = VertexMemory::separate(&mut p, None, None).unwrap();
        refused(crumple.read_vertices(&other, &target, &mut memory), InvalidArgument, &["set"]);
    });
}

#[test]
fn what_a_device_says_by_itself_is_the_next_error() {
    let set = scenes::ball_set();
    on_each_device(|gpu| {
        let mut crumple = gpu.crumple();
        let plan = Plan::everything(&set, 0, 0);
        let seen = buffer(&crumple, plan.size);
        let mut target = crumple.add_target(&set, &plan.def(&seen)).unwrap();
        let instance = folded(&set, 3, 1);
        // A mistake of the caller's own: the buffer is not that large.
        crumple.queue().write_buffer(&seen, plan.size, &[0; 64]);
        let job = EncodeJob { instance: &instance, target: &mut target };
        refused(crumple.submit(&mut [job]), ErrorKind::Vulkan, &["an earlier call"]);
        crumple.submit(&mut [EncodeJob { instance: &instance, target: &mut target }]).unwrap();
        // A device that is lost takes nothing else with it.
        crumple.device().destroy();
        let _ = crumple.device().poll(wgpu::PollType::wait_indefinitely());
        target.invalidate();
        let job = EncodeJob { instance: &instance, target: &mut target };
        refused(crumple.submit(&mut [job]), ErrorKind::DeviceLost, &["lost"]);
        refused(crumple.read(&seen, 0, &mut [0; 4]), ErrorKind::DeviceLost, &["lost"]);
    });
}
