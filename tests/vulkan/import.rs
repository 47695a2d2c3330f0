//! Memory that an engine's device exported, written by a device of Crumple's own: in the same process, and in another.
#![cfg(target_os = "linux")]

use std::os::fd::{AsRawFd, FromRawFd, OwnedFd};
use std::process::{Command, Stdio};

use ash::khr;
use crumple::vulkan::{BufferId, ImportDef, OwnDevice, OwnDeviceDef, RecordJob, SemaphoreId, Shared, vk};
use crumple::{Error, ErrorKind, Instance};

use crate::gpu::compare::Expected;
use crate::gpu::layout::TestLayout;
use crate::gpu::refusals::refused;
use crate::gpu::{folded, hit};
use crate::harness::{Engine, Seen, on_each_device_with};
use crate::scenes;

const EXTENSIONS: [&std::ffi::CStr; 2] = [khr::external_memory_fd::NAME, khr::external_semaphore_fd::NAME];
const TYPE: vk::ExternalMemoryHandleTypeFlags = vk::ExternalMemoryHandleTypeFlags::OPAQUE_FD;

/// A buffer in exported memory.
struct Exported {
    seen: Seen,
    fd: OwnedFd,
    def: ImportDef,
}

fn uuid(engine: &Engine) -> [u8; 16] {
    let mut ids = vk::PhysicalDeviceIDProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut ids);
    // SAFETY: a valid device.
    unsafe { engine.instance().get_physical_device_properties2(engine.physical, &mut properties) };
    ids.device_uuid
}

/// As an engine does it: `guard` bytes lie before the buffer and after it in the same memory.
fn export(engine: &Engine, size: u64) -> Exported {
    let mut external = vk::ExternalMemoryBufferCreateInfo::default().handle_types(TYPE);
    let info = vk::BufferCreateInfo::default().size(size).usage(Seen::USAGE).push_next(&mut external);
    // SAFETY: valid arguments; the engine destroys both.
    unsafe {
        let handle = engine.device.create_buffer(&info, None).unwrap();
        let needs = engine.device.get_buffer_memory_requirements(handle);
        let guard = 4096u64.next_multiple_of(needs.alignment);
        let memory_type = engine.memory_type(needs);
        let mut export = vk::ExportMemoryAllocateInfo::default().handle_types(TYPE);
        let memory_size = needs.size + 2 * guard;
        let allocate = vk::MemoryAllocateInfo::default()
            .allocation_size(memory_size)
            .memory_type_index(memory_type)
            .push_next(&mut export);
        let memory = engine.device.allocate_memory(&allocate, None).unwrap();
        engine.device.bind_buffer_memory(handle, memory, guard).unwrap();
        let get = khr::external_memory_fd::Device::new(engine.instance(), &engine.device);
        let fd = get.get_memory_fd(&vk::MemoryGetFdInfoKHR::default().memory(memory).handle_type(TYPE)).unwrap();
        let fd = OwnedFd::from_raw_fd(fd);
        let seen = engine.seen((handle, memory), (guard, size));
        let def = ImportDef {
            memory: Shared::OpaqueFd(fd.as_raw_fd()),
            memory_size,
            memory_type,
            dedicated: false,
            offset: guard,
            size,
            usage: Seen::USAGE,
        };
        Exported { seen, fd, def }
    }
}

fn own(engine: &Engine) -> OwnDevice {
    let def =
        OwnDeviceDef { device_uuid: Some(uuid(engine)), ..OwnDeviceDef::new(engine.def().get_instance_proc_addr) };
    // SAFETY: the system's loader.
    unsafe { OwnDevice::new(&def) }.unwrap()
}

fn import(own: &mut OwnDevice, def: &ImportDef) -> Result<BufferId, Error> {
    // SAFETY: a handle of the engine's, or one that must be refused.
    unsafe { own.import_buffer(def) }
}

/// What the engine does around: gives the buffer away, and takes it back.
fn hand_over(engine: &Engine, buffer: vk::Buffer, ours: bool) {
    let (from, to) = if ours { (vk::QUEUE_FAMILY_EXTERNAL, 0) } else { (0, vk::QUEUE_FAMILY_EXTERNAL) };
    let barrier = vk::BufferMemoryBarrier::default()
        .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
        .dst_access_mask(vk::AccessFlags::MEMORY_READ)
        .src_queue_family_index(from)
        .dst_queue_family_index(to)
        .buffer(buffer)
        .size(vk::WHOLE_SIZE);
    let all = vk::PipelineStageFlags::ALL_COMMANDS;
    // SAFETY: valid arguments.
    engine.run(|c| unsafe {
        engine.device.cmd_pipeline_barrier(c, all, all, vk::DependencyFlags::empty(), &[], &[barrier], &[]);
    });
}

#[test]
fn semaphores_order_the_two_devices_where_the_driver_has_them() {
    let set = scenes::ball_set();
    on_each_device_with(&EXTENSIONS, |engine| {
        let mut own = own(engine);
        let there = {
            let info = vk::PhysicalDeviceExternalSemaphoreInfo::default()
                .handle_type(vk::ExternalSemaphoreHandleTypeFlags::OPAQUE_FD);
            let mut properties = vk::ExternalSemaphoreProperties::default();
            // SAFETY: a valid device.
            unsafe {
                engine.instance().get_physical_device_external_semaphore_properties(
                    engine.physical,
                    &info,
                    &mut properties,
                );
            }
            properties.external_semaphore_features.contains(vk::ExternalSemaphoreFeatureFlags::EXPORTABLE)
        };
        if !there {
            // SAFETY: refused before the handle is looked at.
            refused(unsafe { own.import_semaphore(Shared::OpaqueFd(0)) }, ErrorKind::Unsupported, &["fence"]);
            return;
        }
        // SAFETY: nothing that Vulkan could take for a semaphore.
        assert!(unsafe { own.import_semaphore(Shared::OpaqueFd(-1)) }.is_err());
        let semaphore = || {
            let kind = vk::ExternalSemaphoreHandleTypeFlags::OPAQUE_FD;
            let mut export = vk::ExportSemaphoreCreateInfo::default().handle_types(kind);
            let info = vk::SemaphoreCreateInfo::default().push_next(&mut export);
            // SAFETY: valid arguments.
            unsafe {
                let handle = engine.device.create_semaphore(&info, None).unwrap();
                let get = khr::external_semaphore_fd::Device::new(engine.instance(), &engine.device);
                let info = vk::SemaphoreGetFdInfoKHR::default().semaphore(handle).handle_type(kind);
                (handle, OwnedFd::from_raw_fd(get.get_semaphore_fd(&info).unwrap()))
            }
        };
        let (ready, done) = (semaphore(), semaphore());
        let mut import_semaphore = |fd: &OwnedFd| -> SemaphoreId {
            // SAFETY: a semaphore of the same driver.
            unsafe { own.import_semaphore(Shared::OpaqueFd(fd.as_raw_fd())) }.unwrap()
        };
        let (wait, signal) = (import_semaphore(&ready.1), import_semaphore(&done.1));
        let layout = TestLayout::everything(&set, 0, 0);
        let exported = export(engine, layout.size);
        let id = import(&mut own, &exported.def).unwrap();
        let mut instance = folded(&set, 2, 4);
        let mut target = own.device().add_target(&set, &layout.def(id)).unwrap();
        let mut wanted = Expected::poison(exported.seen.words().len());
        for round in 0..3 {
            let (signals, waits) = ([ready.0], [done.0]);
            let stages = [vk::PipelineStageFlags::ALL_COMMANDS];
            // SAFETY: valid arguments: the engine signals, Crumple waits and signals, the engine waits.
            unsafe {
                let first = vk::SubmitInfo::default().signal_semaphores(&signals);
                engine.device.queue_submit(engine.queue, &[first], vk::Fence::null()).unwrap();
                let jobs = &mut [RecordJob { instance: &instance, target: &mut target }];
                own.submit(jobs, &[wait], &[signal]).unwrap();
                let last = vk::SubmitInfo::default().wait_semaphores(&waits).wait_dst_stage_mask(&stages);
                engine.device.queue_submit(engine.queue, &[last], vk::Fence::null()).unwrap();
            }
            // The engine's queue alone is waited for.
            engine.wait();
            layout.expect(&mut instance, &mut wanted);
            wanted.compare(exported.seen.words(), &engine.tested, &format!("round {round}"));
            hit(&mut instance, 1, round);
        }
        drop(own);
        // SAFETY: nothing uses them any more.
        unsafe { [ready.0, done.0].iter().for_each(|s| engine.device.destroy_semaphore(*s, None)) };
    });
}

#[test]
fn what_is_no_memory_of_the_driver_is_refused() {
    use ErrorKind::{BufferTooSmall, InvalidArgument, Unsupported};
    on_each_device_with(&EXTENSIONS, |engine| {
        let exported = export(engine, 4096);
        let mut own = own(engine);
        let good = exported.def;
        let mut no = |def, kind, words: &[&str]| refused(import(&mut own, &def), kind, words);
        let (reader, _writer) = std::io::pipe().unwrap();
        let folder = std::fs::File::open("/").unwrap();
        let mut small = tempfile::tempfile().unwrap();
        std::io::Write::write_all(&mut small, b"not memory").unwrap();
        let fd = |fd: i32| ImportDef { memory: Shared::OpaqueFd(fd), ..good };
        no(fd(-1), InvalidArgument, &["-1", "open file descriptor"]);
        no(fd(i32::MAX), InvalidArgument, &["open file descriptor"]);
        no(fd(reader.as_raw_fd()), InvalidArgument, &["pipe"]);
        no(fd(folder.as_raw_fd()), InvalidArgument, &["folder"]);
        no(fd(small.as_raw_fd()), InvalidArgument, &["a file of 10"]);
        no(ImportDef { memory: Shared::OpaqueWin32(4), ..good }, Unsupported, &["file descriptors"]);
        no(ImportDef { memory_type: 31, ..good }, InvalidArgument, &["memory type", "31"]);
        no(ImportDef { size: u64::MAX, ..good }, BufferTooSmall, &["imported memory"]);
        no(ImportDef { offset: good.memory_size, ..good }, BufferTooSmall, &["imported memory"]);
        no(ImportDef { offset: 1, ..good }, ErrorKind::Misaligned, &["offset"]);
        no(ImportDef { size: 0, ..good }, InvalidArgument, &["size"]);
        let usage = vk::BufferUsageFlags::VERTEX_BUFFER;
        no(ImportDef { usage, ..good }, InvalidArgument, &["usage", "STORAGE_BUFFER"]);
        // After all of that the real one does, and its descriptor is still the engine's.
        import(&mut own, &good).unwrap();
        assert!(exported.fd.try_clone().is_ok());

        let found: String = uuid(engine).iter().map(|b| format!("{b:02x}")).collect();
        let good = OwnDeviceDef::new(engine.def().get_instance_proc_addr);
        // SAFETY: the system's loader.
        let open = |def: OwnDeviceDef| unsafe { OwnDevice::new(&def) };
        refused(open(OwnDeviceDef { device_uuid: Some([0xEE; 16]), ..good }), Unsupported, &[&found]);
        refused(open(OwnDeviceDef { workgroup_size: 7, ..good }), InvalidArgument, &["workgroup_size"]);
    });
}

/// The numbers of an import, from one process to another.
const ACROSS: &str = "CRUMPLE_TEST_IMPORT";

fn across() -> (Instance, TestLayout) {
    let set = scenes::sheet_set();
    let layout = TestLayout::everything(&set, 0, 8);
    (folded(&set, 4, 5), layout)
}

#[test]
fn another_process_writes_exported_memory() {
    on_each_device_with(&EXTENSIONS, |engine| {
        let (mut instance, layout) = across();
        let exported = export(engine, layout.offset + layout.size + 8);
        hand_over(engine, exported.seen.handle, false);
        let ImportDef { memory_size, memory_type, offset, size, .. } = exported.def;
        let uuid: String = uuid(engine).iter().map(|b| format!("{b:02x}")).collect();
        let numbers = format!("{memory_size} {memory_type} {offset} {size} {uuid}");
        let mut child = Command::new(std::env::current_exe().unwrap());
        child.args(["--exact", "import::in_another_process", "--ignored", "--nocapture"]).env(ACROSS, numbers);
        // Its own device is under validation too, which prints what it finds.
        if engine.validated() {
            child.env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation");
            child.env("VK_LAYER_ENABLES", "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT");
        }
        let out = child.stdin(Stdio::from(exported.fd)).output().unwrap();
        let text = String::from_utf8_lossy(&out.stdout) + String::from_utf8_lossy(&out.stderr);
        assert!(
            out.status.success() && text.contains("1 passed") && !text.contains("VUID"),
            "{}: {text}",
            engine.tested.name
        );
        assert!(!text.contains("Validation Error") && !text.contains("SYNC-HAZARD"), "{text}");
        hand_over(engine, exported.seen.handle, true);
        let mut wanted = Expected::poison(exported.seen.words().len());
        layout.expect(&mut instance, &mut wanted);
        wanted.compare(exported.seen.words(), &engine.tested, "from another process");
    });
}

#[test]
#[ignore = "the other process of another_process_writes_exported_memory"]
fn in_another_process() {
    let Ok(numbers) = std::env::var(ACROSS) else { return };
    let parts: Vec<&str> = numbers.split(' ').collect();
    let number = |i: usize| parts[i].parse::<u64>().unwrap();
    let byte = |i: usize| u8::from_str_radix(&parts[4][2 * i..2 * i + 2], 16).unwrap();
    // SAFETY: the system's loader.
    let entry = unsafe { ash::Entry::load() }.unwrap();
    let def = OwnDeviceDef {
        device_uuid: Some(std::array::from_fn(byte)),
        ..OwnDeviceDef::new(entry.static_fn().get_instance_proc_addr)
    };
    // SAFETY: the system's loader.
    let mut own = unsafe { OwnDevice::new(&def) }.unwrap();
    let import_def = ImportDef {
        // Standard input is how the descriptor came.
        memory: Shared::OpaqueFd(0),
        memory_size: number(0),
        memory_type: number(1) as u32,
        dedicated: false,
        offset: number(2),
        size: number(3),
        usage: Seen::USAGE,
    };
    let id = import(&mut own, &import_def).unwrap();
    let (instance, layout) = across();
    let mut target = own.device().add_target(instance.example_set(), &layout.def(id)).unwrap();
    let (frame, _) = own.submit(&mut [RecordJob { instance: &instance, target: &mut target }], &[], &[]).unwrap();
    assert!(own.wait(frame, u64::MAX).unwrap());
}
