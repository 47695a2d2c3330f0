//! The library at work on a device: instances whose vertices lie one behind the other in one buffer of the device.

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Result;
use ash::vk;
use crumple::vulkan::{Device, FrameReport, Job, Stream, Target, TargetDef};
use crumple::{DeformJob, ExampleSet, Instance, TaskSystem, Tracker, VertexMemory, deform};

use super::buffer::Buffer;
use super::engine::Gpu;

/// What is written of each vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Output {
    /// 12 bytes.
    Positions,
    /// Position and normal side by side, 24 bytes.
    Normals,
}

impl Output {
    pub fn bytes(self) -> u64 {
        match self {
            Output::Positions => 12,
            Output::Normals => 24,
        }
    }
}

/// Invocations a workgroup where nothing else is measured.
pub const WORKGROUP: u32 = 128;

/// What a frame took.
#[derive(Debug, Clone, Copy)]
pub struct Cost {
    /// Of recording, on the CPU.
    pub record: Duration,
    /// Of what was recorded, on the device.
    pub device: Duration,
    pub report: FrameReport,
}

pub struct Recorded<'g> {
    gpu: &'g Gpu,
    // Dropped before the buffer that it writes to.
    crumple: Device,
    targets: Vec<Target>,
    buffer: Buffer<'g>,
    pub instances: Vec<Instance>,
    pub output: Output,
    frame: u64,
}

impl<'g> Recorded<'g> {
    /// Instances of one set. Nothing is recorded yet.
    pub fn new(gpu: &'g Gpu, instances: Vec<Instance>, output: Output, workgroup: u32) -> Result<Self> {
        Self::on(gpu, gpu.crumple(workgroup)?, instances, output)
    }

    /// The same with the library on the device already.
    fn on(gpu: &'g Gpu, mut crumple: Device, instances: Vec<Instance>, output: Output) -> Result<Self> {
        let set = instances[0].example_set().clone();
        let size = set.vertex_count() as u64 * output.bytes();
        let buffer = gpu.local(size * instances.len() as u64)?;
        // SAFETY: a buffer of this device, which is dropped after the library's device and is never in use then.
        let id = unsafe { crumple.add_buffer(&gpu.def(&buffer)) }?;
        let format = vk::Format::R32G32B32_SFLOAT;
        let stream = |offset| Stream { offset, stride: output.bytes(), format };
        let def = |i: usize| TargetDef {
            positions: stream(0),
            normals: (output == Output::Normals).then(|| stream(12)),
            ..TargetDef::positions(id, i as u64 * size, size)
        };
        let targets = (0..instances.len()).map(|i| crumple.add_target(&set, &def(i))).collect::<Result<_, _>>()?;
        let frame = crumple.recorded();
        Ok(Recorded { gpu, crumple, targets, buffer, instances, output, frame })
    }

    /// Adds the first target of another set, and records what there was, so that the set is uploaded and no vertex of it
    /// written. Answers what adding took, what recording took and copied, and the library with the set's first instance.
    pub fn upload(mut self, instance: Instance) -> Result<(Duration, Cost, Self)> {
        let set = instance.example_set().clone();
        let size = set.vertex_count() as u64 * Output::Positions.bytes();
        let buffer = self.gpu.local(size)?;
        // SAFETY: as above; nothing is recorded that writes to it.
        let id = unsafe { self.crumple.add_buffer(&self.gpu.def(&buffer)) }?;
        let start = Instant::now();
        let target = self.crumple.add_target(&set, &TargetDef::positions(id, 0, size))?;
        let added = start.elapsed();
        self.targets.iter_mut().for_each(Target::invalidate);
        let cost = self.frame()?;
        let with_set = Self::on(self.gpu, self.crumple, vec![instance], Output::Positions)?;
        drop(target);
        Ok((added, cost, with_set))
    }

    /// Of one instance.
    pub fn one(gpu: &'g Gpu, instance: Instance, output: Output) -> Result<Self> {
        Self::new(gpu, vec![instance], output, WORKGROUP)
    }

    /// Brings all vertices up to date, and waits.
    pub fn frame(&mut self) -> Result<Cost> {
        self.frame += 1;
        let mut jobs: Vec<Job<'_, Target>> =
            self.instances.iter().zip(&mut self.targets).map(|(instance, target)| Job { instance, target }).collect();
        let commands = self.gpu.begin()?;
        let start = Instant::now();
        // SAFETY: the command buffer is recording, and submitted below.
        let report = unsafe { self.crumple.record(commands, self.frame, &mut jobs) };
        let record = start.elapsed();
        let device = self.gpu.finish()?;
        let report = report?;
        self.crumple.completed(self.frame);
        Ok(Cost { record, device, report })
    }

    /// What bringing the vertices up to date takes on the device.
    pub fn run(&mut self) -> Duration {
        self.frame().unwrap_or_else(|e| panic!("{e:#}")).device
    }

    /// The same of every vertex, whether it changed or not.
    pub fn run_all(&mut self) -> Duration {
        self.targets.iter_mut().for_each(Target::invalidate);
        self.run()
    }

    /// The vertices on the device, written anew over what is none of them.
    pub fn written(&mut self) -> Result<Vec<f32>> {
        self.buffer.poison()?;
        self.targets.iter_mut().for_each(Target::invalidate);
        self.frame()?;
        self.vertices()
    }

    /// The vertices on the device.
    pub fn vertices(&self) -> Result<Vec<f32>> {
        self.buffer.read()
    }

    pub fn vertex_buffer(&self) -> &Buffer<'g> {
        &self.buffer
    }

    /// What the CPU makes of all instances.
    pub fn expected(&self, tasks: &dyn TaskSystem) -> Result<Vec<f32>> {
        let mut all = Vec::new();
        for instance in &self.instances {
            all.extend(on_the_cpu(instance, self.output, tasks)?);
        }
        Ok(all)
    }
}

/// The vertices of an instance as the CPU path has them, as they lie in the buffer.
pub fn on_the_cpu(instance: &Instance, output: Output, tasks: &dyn TaskSystem) -> Result<Vec<f32>> {
    let count = instance.example_set().vertex_count();
    let mut positions = vec![[0.0f32; 3]; count];
    let mut normals = (output == Output::Normals).then(|| vec![[0.0f32; 3]; count]);
    let memory = VertexMemory::separate(&mut positions, normals.as_deref_mut(), None)?;
    let mut tracker = Tracker::new();
    deform(&mut [DeformJob { lod: 0, instance, tracker: &mut tracker, memory }], tasks)?;
    Ok(match normals {
        None => positions.into_iter().flatten().collect(),
        Some(normals) => positions.into_iter().zip(normals).flat_map(|(p, n)| [p, n]).flatten().collect(),
    })
}

/// An instance that has these marks.
pub fn marked(set: &Arc<ExampleSet>, options: crumple::InstanceOptions, marks: &[crumple::Mark]) -> Result<Instance> {
    let mut instance = Instance::new(set.clone(), options)?;
    instance.set_marks(marks)?;
    Ok(instance)
}
