//! Memory that an engine's device exported, written by a device of Crumple's own.
#![cfg(target_os = "linux")]

use std::os::fd::{AsRawFd, FromRawFd, OwnedFd};

use ash::khr;
use crumple::vulkan::{BufferId, ImportDef, Job, OwnDevice, OwnDeviceDef, SemaphoreId, Shared, vk};
use crumple::{Error, ErrorKind};

use crate::gpu::compare::Expected;
use crate::gpu::layout::TestLayout;
use crate::gpu::refusals::refused;
use crate::gpu::{folded, hit};
use crate::harness::{Engine, Seen, on_each_device_with};
use crate::scenes;

const EXTENSIONS: [&std::ffi::CStr; 2] = [khr::external_memory_fd::NAME, khr::external_semaphore_fd::NAME];
const TYPE: vk::ExternalMemoryHandleTypeFlags = vk::ExternalMemoryHandleTypeFlags::OPAQUE_FD;
const SEMAPHORE: vk::ExternalSemaphoreHandleTypeFlags = vk::ExternalSemaphoreHandleTypeFlags::OPAQUE_FD;

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

/// Whether the driver exports semaphores.
fn has_semaphores(engine: &Engine) -> bool {
    let info = vk::PhysicalDeviceExternalSemaphoreInfo::default().handle_type(SEMAPHORE);
    let mut found = vk::ExternalSemaphoreProperties::default();
    // SAFETY: a valid device.
    unsafe {
        engine.instance().get_physical_device_external_semaphore_properties(engine.physical, &info, &mut found);
    }
    found.external_semaphore_features.contains(vk::ExternalSemaphoreFeatureFlags::EXPORTABLE)
}

/// A semaphore of the engine's, and that of Crumple's device which is the same.
fn semaphore(engine: &Engine, own: &mut OwnDevice) -> (vk::Semaphore, SemaphoreId) {
    let mut export = vk::ExportSemaphoreCreateInfo::default().handle_types(SEMAPHORE);
    let info = vk::SemaphoreCreateInfo::default().push_next(&mut export);
    // SAFETY: valid arguments.
    unsafe {
        let handle = engine.device.create_semaphore(&info, None).unwrap();
        let get = khr::external_semaphore_fd::Device::new(engine.instance(), &engine.device);
        let info = vk::SemaphoreGetFdInfoKHR::default().semaphore(handle).handle_type(SEMAPHORE);
        let fd = OwnedFd::from_raw_fd(get.get_semaphore_fd(&info).unwrap());
        (handle, own.import_semaphore(Shared::OpaqueFd(fd.as_raw_fd())).unwrap())
    }
}

#[test]
fn exported_memory_is_written_between_semaphores_or_waits() {
    let set = scenes::sheet_set();
    on_each_device_with(&EXTENSIONS, |engine| {
        let (mut own, mut instance) = (own(engine), folded(&set, 4, 5));
        let layout = TestLayout::everything(&set, 0, 8);
        let exported = export(engine, layout.offset + layout.size + 8);
        let id = import(&mut own, &exported.def).unwrap();
        let mut target = own.device().add_target(&set, &layout.def(id)).unwrap();
        let mut wanted = Expected::poison(exported.seen.words().len());
        let mut write = |own: &mut OwnDevice, waits: &[SemaphoreId], signals: &[SemaphoreId], round| {
            let jobs = &mut [Job { instance: &instance, target: &mut target }];
            let (frame, _) = own.submit(jobs, waits, signals).unwrap();
            layout.expect(&mut instance, &mut wanted);
            hit(&mut instance, 1, round);
            (frame, wanted.clone())
        };
        hand_over(engine, exported.seen.handle, false);
        let (frame, wanted) = write(&mut own, &[], &[], 0);
        assert!(own.wait(frame, u64::MAX).unwrap());
        hand_over(engine, exported.seen.handle, true);
        wanted.compare(exported.seen.words(), &engine.tested, "after a wait");
        if !has_semaphores(engine) {
            // SAFETY: refused before the handle is looked at.
            refused(unsafe { own.import_semaphore(Shared::OpaqueFd(0)) }, ErrorKind::Unsupported, &["fence"]);
            return;
        }
        // SAFETY: nothing that Vulkan could take for a semaphore.
        assert!(unsafe { own.import_semaphore(Shared::OpaqueFd(-1)) }.is_err());
        let [ready, done] = [(); 2].map(|()| semaphore(engine, &mut own));
        let submit = |info: vk::SubmitInfo| {
            // SAFETY: valid semaphores.
            unsafe { engine.device.queue_submit(engine.queue, &[info], vk::Fence::null()) }.unwrap();
        };
        for round in 1..4 {
            // The engine signals, Crumple waits and signals, the engine waits.
            submit(vk::SubmitInfo::default().signal_semaphores(&[ready.0]));
            let (_, wanted) = write(&mut own, &[ready.1], &[done.1], round);
            let stages = [vk::PipelineStageFlags::ALL_COMMANDS];
            submit(vk::SubmitInfo::default().wait_semaphores(&[done.0]).wait_dst_stage_mask(&stages));
            // The engine's queue alone is waited for.
            engine.wait();
            wanted.compare(exported.seen.words(), &engine.tested, &format!("round {round}"));
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
