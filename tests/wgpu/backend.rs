//! The library on a wgpu device, for the tests in `tests/gpu`.

use std::collections::VecDeque;
use std::sync::Arc;

use crumple::wgpu::wgpu::{self, VertexFormat};
pub use crumple::wgpu::{Attribute, Encoding, FrameReport as Report, Stream, Target, TargetDef as Def};
use crumple::wgpu::{Device, DeviceDef, HeadlessDef, adapters};
use crumple::{Error, ExampleSet};

use crate::gpu::Lowered;
use crate::gpu::compare::{POISON, TestedDevice, note_missing};
use crate::gpu::layout::TestLayout;

pub type BufferRef<'a> = &'a wgpu::Buffer;
pub type Job<'a> = crumple::wgpu::Job<'a, Target>;

pub const HALF_POSITION: VertexFormat = VertexFormat::Float16x4;
pub const OCTAHEDRAL: VertexFormat = VertexFormat::Unorm16x2;
pub const PACKED_POSITION: VertexFormat = VertexFormat::Snorm16x4;
/// A format that is refused, and one that is good instead.
pub const BAD_POSITION: (VertexFormat, &str) = (VertexFormat::Float32x2, "Float32x3");

pub fn format(attribute: Attribute, encoding: Encoding) -> VertexFormat {
    match (encoding, attribute) {
        (Encoding::F32, Attribute::Tangent) => VertexFormat::Float32x4,
        (Encoding::F32, _) => VertexFormat::Float32x3,
        (Encoding::F16x4, _) => VertexFormat::Float16x4,
        (Encoding::Snorm16x4, _) => VertexFormat::Snorm16x4,
        (Encoding::Snorm8x4, _) => VertexFormat::Snorm8x4,
        (Encoding::Octahedral16x2, _) => VertexFormat::Unorm16x2,
    }
}

/// Runs a test on each Vulkan device there is, with a device that the library makes.
pub fn on_each_device(test: impl Fn(&mut Gpu)) {
    let all = adapters(wgpu::Backends::VULKAN);
    for adapter in &all {
        let driver = format!("{} {}", adapter.driver, adapter.driver_info);
        let device = TestedDevice { name: adapter.name.clone(), driver, translated: false };
        device.announce();
        test(&mut Gpu::headless(device));
    }
    note_missing(&all.into_iter().map(|a| a.name).collect::<Vec<_>>());
}

/// A device with the library on it.
pub struct Gpu {
    pub device: TestedDevice,
    pub crumple: Device,
    /// Frames that are not submitted yet.
    started: VecDeque<wgpu::CommandBuffer>,
}

/// A buffer that can be read back.
pub struct Buffer(pub wgpu::Buffer);

impl Buffer {
    pub fn words(&self) -> usize {
        self.0.size() as usize / 4
    }

    pub fn as_ref(&self) -> &wgpu::Buffer {
        &self.0
    }
}

impl Gpu {
    fn new(device: TestedDevice, crumple: Device) -> Self {
        Gpu { device, crumple, started: VecDeque::new() }
    }

    fn headless(device: TestedDevice) -> Self {
        let adapter = Some(device.name.as_str());
        let def = HeadlessDef { adapter, backends: wgpu::Backends::VULKAN, device: DeviceDef::default() };
        let crumple = Device::headless(&def).unwrap();
        Self::new(device, crumple)
    }

    /// Another device of the library's on the same adapter.
    pub fn another(&self) -> Self {
        Self::headless(self.device.clone())
    }

    /// The library on two devices of a host without features. `change` changes the adapter's limits.
    pub fn hosted(&self, change: impl Fn(&mut wgpu::Limits), def: &DeviceDef) -> Result<[Self; 2], Error> {
        let instance = wgpu::Instance::default();
        let adapters = at_once(instance.enumerate_adapters(wgpu::Backends::VULKAN));
        let adapter = adapters.iter().find(|a| a.get_info().name == self.device.name).unwrap();
        let mut required_limits = adapter.limits();
        change(&mut required_limits);
        let descriptor = wgpu::DeviceDescriptor { required_limits, ..Default::default() };
        let made = || {
            let (device, queue) = at_once(adapter.request_device(&descriptor)).unwrap();
            let tested = TestedDevice { translated: true, ..self.device.clone() };
            Ok(Self::new(tested, Device::new(&device, &queue, def)?))
        };
        Ok([made()?, made()?])
    }

    /// A host's device with lower limits.
    pub fn lowered(&self, lowered: Lowered) -> Result<Gpu, Error> {
        let change = |l: &mut wgpu::Limits| {
            l.max_compute_workgroups_per_dimension =
                lowered.workgroups.unwrap_or(l.max_compute_workgroups_per_dimension);
            l.max_storage_buffer_binding_size = lowered.binding_bytes.unwrap_or(l.max_storage_buffer_binding_size);
        };
        let [device, _] = self.hosted(change, &DeviceDef { workgroup_size: lowered.workgroup_size })?;
        Ok(device)
    }

    /// A buffer full of poison.
    pub fn buffer(&mut self, bytes: u64) -> Buffer {
        let descriptor = wgpu::BufferDescriptor { label: None, size: bytes, usage: USAGE, mapped_at_creation: false };
        let buffer = self.crumple.device().create_buffer(&descriptor);
        self.crumple.queue().write_buffer(&buffer, 0, &POISON.to_le_bytes().repeat(bytes as usize / 4));
        Buffer(buffer)
    }

    pub fn add_target(&mut self, set: &Arc<ExampleSet>, layout: &TestLayout, at: &Buffer) -> Result<Target, Error> {
        self.crumple.add_target(set, &layout.def(&at.0))
    }

    /// Submits a frame.
    pub fn run(&mut self, jobs: &mut [Job<'_>]) -> Result<Report, Error> {
        self.crumple.submit(jobs)
    }

    /// Encodes a frame that is submitted later.
    pub fn start(&mut self, jobs: &mut [Job<'_>]) {
        let mut encoder = self.crumple.device().create_command_encoder(&Default::default());
        self.crumple.encode(&mut encoder, jobs).unwrap();
        self.started.push_back(encoder.finish());
    }

    /// Submits the oldest frame of `start`.
    pub fn finish(&mut self) {
        self.crumple.queue().submit(self.started.pop_front());
    }

    /// Encodes a frame that is not submitted.
    pub fn drop_frame(&mut self, jobs: &mut [Job<'_>]) -> Report {
        let mut encoder = self.crumple.device().create_command_encoder(&Default::default());
        self.crumple.encode(&mut encoder, jobs).unwrap()
    }

    pub fn frame_done(&mut self) {}

    /// Everything that a buffer holds.
    pub fn read(&mut self, buffer: &Buffer) -> Vec<u32> {
        let mut bytes = vec![0; buffer.0.size() as usize];
        self.crumple.read(&buffer.0, 0, &mut bytes).unwrap();
        bytes.chunks_exact(4).map(|w| u32::from_le_bytes(w.try_into().unwrap())).collect()
    }

    /// Objects that a target in a new buffer takes, if its mesh finds room in a chunk: a bind group.
    pub fn objects_per_target(&self) -> u64 {
        1
    }
}

/// The output of a future that is ready.
fn at_once<F: Future>(future: F) -> F::Output {
    let mut context = std::task::Context::from_waker(std::task::Waker::noop());
    match std::pin::pin!(future).poll(&mut context) {
        std::task::Poll::Ready(output) => output,
        std::task::Poll::Pending => panic!("outside of browsers wgpu's futures are ready"),
    }
}

const USAGE: wgpu::BufferUsages = wgpu::BufferUsages::STORAGE
    .union(wgpu::BufferUsages::VERTEX)
    .union(wgpu::BufferUsages::COPY_SRC)
    .union(wgpu::BufferUsages::COPY_DST);
