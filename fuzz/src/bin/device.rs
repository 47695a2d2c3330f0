//! Random scenes on Vulkan devices: after each frame their vertices are the CPU's, in random formats.
#![no_main]

use std::cell::RefCell;

use arbitrary::Unstructured;
use compare::Expected;
use crumple::ExampleSet;
use crumple::vulkan::{Access, BufferDef, BufferId, Device, DeviceDef, Job, vk};
use crumple_fuzz::{scene, seeds, target};
use engine::{Engine, Needs, Seen};
use layout::TestLayout;

/// What the comparison of the tests needs.
mod backend {
    use crumple::vulkan::vk;
    pub use crumple::vulkan::{Attribute, Encoding, Stream};
    use crumple::vulkan::{BufferId, TargetDef};

    pub type BufferRef<'a> = BufferId;
    pub type Def<'a> = TargetDef;

    pub fn format(attribute: Attribute, encoding: Encoding) -> vk::Format {
        match (encoding, attribute) {
            (Encoding::F32, Attribute::Tangent) => vk::Format::R32G32B32A32_SFLOAT,
            (Encoding::F32, _) => vk::Format::R32G32B32_SFLOAT,
            (Encoding::F16x4, _) => vk::Format::R16G16B16A16_SFLOAT,
            (Encoding::Snorm16x4, _) => vk::Format::R16G16B16A16_SNORM,
            (Encoding::Snorm8x4, _) => vk::Format::R8G8B8A8_SNORM,
            (Encoding::Octahedral16x2, _) => vk::Format::R16G16_UNORM,
        }
    }
}

#[allow(dead_code)]
#[path = "../../../tests/gpu/compare.rs"]
mod compare;
#[path = "../../../tests/gpu/encode.rs"]
mod encode;
#[path = "../../../tests/gpu/engine.rs"]
mod engine;
#[allow(dead_code)]
#[path = "../../../tests/gpu/layout.rs"]
mod layout;

/// Bytes of each device's buffer.
const SIZE: u64 = 64 << 10;

target!(run, seeds: seeds::noise);

/// A device with the library on it, and one buffer.
struct Gpu {
    engine: Engine<'static>,
    crumple: Device,
    seen: Seen,
    buffer: BufferId,
    frame: u64,
}

impl Gpu {
    /// All devices of the system's loader, which live as long as the process. None without a loader or a driver.
    fn all() -> Vec<Gpu> {
        // Validation would take most of the time.
        let (api_version, none) = (vk::API_VERSION_1_1, &|_: &_, _| Vec::new());
        let needs = Needs { api_version, validation: false, instance_extensions: &[], device_extensions: none };
        // SAFETY: the system's loader.
        let Ok(entry) = (unsafe { ash::Entry::load() }) else { return Vec::new() };
        let Ok(instance) = engine::Instance::new(Box::leak(Box::new(entry)), &needs, false) else { return Vec::new() };
        Box::leak(Box::new(instance)).engines(&needs).map(Self::new).collect()
    }

    fn new(engine: Engine<'static>) -> Self {
        let (on, seen) = (engine.on, engine.buffer(SIZE));
        let device = engine.device.handle();
        let def = DeviceDef::new(on.get_instance_proc_addr, on.instance.handle(), engine.physical, device, 0);
        let host = Access { stages: vk::PipelineStageFlags::HOST, access: vk::AccessFlags::HOST_READ };
        let (usage, queue_family) = (Seen::USAGE, vk::QUEUE_FAMILY_IGNORED);
        let def_of_buffer =
            BufferDef { buffer: seen.handle, size: SIZE, usage, queue_family, before: host, after: host };
        // SAFETY: valid handles, which live as long as the process.
        unsafe {
            let mut crumple = Device::new(&def).expect("a device that computes");
            let buffer = crumple.add_buffer(&def_of_buffer).expect("a buffer");
            Gpu { engine, crumple, seen, buffer, frame: 0 }
        }
    }
}

fn run(data: &[u8]) {
    thread_local! {
        // Drivers are gone when the program's end would drop them.
        static ALL: RefCell<&'static mut [Gpu]> = RefCell::new(Gpu::all().leak());
    }
    ALL.with_borrow_mut(|all| all.iter_mut().for_each(|gpu| play(&mut Unstructured::new(data), gpu)));
}

/// Plays the scene on one device. The first bytes choose the formats.
fn play(bytes: &mut Unstructured<'_>, gpu: &mut Gpu) {
    let chosen: [u8; 4] = bytes.arbitrary().unwrap_or_default();
    let mut shown = None;
    scene::play(bytes, |body| {
        let set = body.example_set().clone();
        let (layout, target) = shown.get_or_insert_with(|| {
            let layout = TestLayout::interleaved(&set, 0, 4 * u64::from(chosen[3] >> 4), encodings(&set, chosen));
            gpu.seen.poison();
            (layout, gpu.crumple.add_target(&set, &layout.def(gpu.buffer)).expect("a target in the buffer"))
        });
        let mut expected = Expected::poison(SIZE as usize / 4);
        layout.expect(body, &mut expected);
        gpu.frame += 1;
        let jobs = &mut [Job { instance: body, target }];
        // SAFETY: the command buffer is recording.
        gpu.engine.run(|commands| unsafe { gpu.crumple.record(commands, gpu.frame, jobs) }).expect("recorded");
        gpu.crumple.completed(gpu.frame);
        expected.compare(gpu.seen.words(), &gpu.engine.tested, "the frame");
    });
}

/// An encoding for each attribute that the mesh has.
fn encodings(set: &ExampleSet, chosen: [u8; 4]) -> [Option<backend::Encoding>; 3] {
    use backend::Encoding::{F16x4, F32, Octahedral16x2, Snorm8x4, Snorm16x4};
    let of = |i: usize, list: &[Option<backend::Encoding>]| list[usize::from(chosen[i] & 15) % list.len()];
    let directions = [Some(F32), Some(Snorm16x4), Some(Snorm8x4), Some(Octahedral16x2), None];
    let normals = set.mesh().normals().and_then(|_| of(1, &directions));
    [
        of(0, &[Some(F32), Some(F16x4), Some(Snorm16x4)]),
        normals,
        set.mesh().tangents().and(normals).and_then(|_| of(2, &directions)),
    ]
}
