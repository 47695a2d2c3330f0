//! The library on a Vulkan device, for the tests in `tests/gpu`.

use std::collections::VecDeque;
use std::sync::Arc;

use crumple::vulkan::vk;
pub use crumple::vulkan::{Attribute, Encoding, FrameReport as Report, Stream, Target, TargetDef};
use crumple::vulkan::{BufferId, Device, DeviceDef};
use crumple::{Error, ExampleSet};

use crate::gpu::Lowered;
use crate::gpu::compare::TestedDevice;
use crate::gpu::layout::TestLayout;
use crate::harness::{self, Engine, Seen, Tampered, tampered};

pub type BufferRef<'a> = BufferId;
pub type Def<'a> = TargetDef;
pub type Job<'a> = crumple::vulkan::Job<'a, Target>;

pub const HALF_POSITION: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
pub const OCTAHEDRAL: vk::Format = vk::Format::R16G16_UNORM;
pub const PACKED_POSITION: vk::Format = vk::Format::R16G16B16A16_SNORM;
/// A format that is refused, and one that is good instead.
pub const BAD_POSITION: (vk::Format, &str) = (vk::Format::R32G32_SFLOAT, "R32G32B32_SFLOAT");

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

/// An engine's device with the library on it.
pub struct Gpu<'e> {
    pub device: TestedDevice,
    pub crumple: Device,
    pub engine: &'e Engine<'e>,
    frame: u64,
    /// Frames that are not waited for yet.
    started: VecDeque<(u64, vk::Fence)>,
}

/// A buffer that the CPU sees.
pub struct Buffer {
    seen: Seen,
    id: BufferId,
}

impl Buffer {
    pub fn words(&self) -> usize {
        self.seen.words().len()
    }

    pub fn as_ref(&self) -> BufferId {
        self.id
    }
}

/// Runs a test on each device there is.
pub fn on_each_device(test: impl Fn(&mut Gpu<'_>)) {
    harness::on_each_device(|engine| {
        test(&mut Gpu::new(engine, engine.crumple()));
    });
}

impl<'e> Gpu<'e> {
    fn new(engine: &'e Engine<'e>, crumple: Device) -> Self {
        Gpu { device: engine.tested.clone(), crumple, engine, frame: 0, started: VecDeque::new() }
    }

    /// The same device with lower limits.
    pub fn lowered(&self, lowered: Lowered) -> Result<Gpu<'e>, Error> {
        let def = tampered(self.engine.def(), Tampered { lowered, ..Tampered::default() });
        let def = DeviceDef { workgroup_size: lowered.workgroup_size, ..def };
        // SAFETY: valid handles.
        Ok(Self::new(self.engine, unsafe { Device::new(&def) }?))
    }

    pub fn buffer(&mut self, bytes: u64) -> Buffer {
        let (seen, id) = self.engine.target_buffer(&mut self.crumple, bytes);
        Buffer { seen, id }
    }

    pub fn add_target(&mut self, set: &Arc<ExampleSet>, layout: &TestLayout, at: &Buffer) -> Result<Target, Error> {
        self.crumple.add_target(set, &layout.def(at.id))
    }

    /// Records a frame and waits for it.
    pub fn run(&mut self, jobs: &mut [Job<'_>]) -> Result<Report, Error> {
        self.frame += 1;
        // SAFETY: the command buffer is recording.
        let report = self.engine.run(|c| unsafe { self.crumple.record(c, self.frame, jobs) });
        self.frame_done();
        report
    }

    /// Records and submits a frame that is not waited for.
    pub fn start(&mut self, jobs: &mut [Job<'_>]) {
        self.frame += 1;
        let commands = self.engine.begin(vk::CommandBufferLevel::PRIMARY);
        // SAFETY: the command buffer is recording.
        unsafe { self.crumple.record(commands, self.frame, jobs) }.unwrap();
        // SAFETY: a valid device; destroyed in `finish`.
        let fence = unsafe { self.engine.device.create_fence(&Default::default(), None) }.unwrap();
        self.engine.submit(commands, fence);
        self.started.push_back((self.frame, fence));
    }

    /// Waits for the oldest frame of `start`.
    pub fn finish(&mut self) {
        let (frame, fence) = self.started.pop_front().unwrap();
        // SAFETY: a valid fence, which nothing uses after that.
        unsafe {
            self.engine.device.wait_for_fences(&[fence], true, u64::MAX).unwrap();
            self.engine.device.destroy_fence(fence, None);
        }
        self.crumple.completed(frame);
    }

    /// Records a frame that is not submitted.
    pub fn drop_frame(&mut self, jobs: &mut [Job<'_>]) -> Report {
        self.frame += 1;
        let commands = self.engine.begin(vk::CommandBufferLevel::PRIMARY);
        // SAFETY: the command buffer is recording.
        let report = unsafe { self.crumple.record(commands, self.frame, jobs) }.unwrap();
        // SAFETY: as above.
        unsafe { self.engine.device.end_command_buffer(commands) }.unwrap();
        self.crumple.discard(self.frame);
        report
    }

    pub fn frame_done(&mut self) {
        self.crumple.completed(self.frame);
    }

    pub fn read(&mut self, buffer: &Buffer) -> Vec<u32> {
        buffer.seen.words().to_vec()
    }

    /// Objects that a target in a new buffer takes, if its mesh finds room in a chunk: a descriptor set, and a staging buffer
    /// with its memory.
    pub fn objects_per_target(&self) -> u64 {
        3
    }
}
