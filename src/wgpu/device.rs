//! The device that hosts use: everything that is made on the wgpu device.

use super::belt::Belt;
use super::pipelines::WgpuPipelines;
use super::target::{BoundBuffers, Target, TargetDef};
use super::wgpu_device::{DeviceDef, WgpuDevice};
use crate::base::error::Error;
use crate::example::set::ExampleSet;
use crate::gpu::{Arena, Plan};
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// A `wgpu` device that deforms.
pub struct Device {
    pub(super) gpu: WgpuDevice,
    pub(super) pipelines: WgpuPipelines,
    bound: BoundBuffers,
    pub(super) arena: Arena<wgpu::Buffer>,
    pub(super) plan: Plan<u64>,
    /// The data of a frame, and behind it a call for each dispatch. It is reused.
    pub(super) words: Vec<u32>,
    pub(super) belt: Belt,
    /// A buffer that the CPU reads. It is reused.
    pub(super) mapping: Option<wgpu::Buffer>,
}

impl fmt::Debug for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Device").field("device", &self.gpu.device).finish_non_exhaustive()
    }
}

impl Device {
    /// Takes the host's device and its queue. It needs no features, and no limits above those of WebGPU. With a higher
    /// [`wgpu::Limits::max_storage_buffer_binding_size`] one dispatch can write larger buffers.
    ///
    /// The errors of calls here are returned, and do not reach the host's handler of uncaptured errors. But an encoder of another
    /// device than the targets' fails when the host finishes or submits it.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a bad workgroup size; [`Error::Unsupported`] for a limit that is too low; [`Error::Wgpu`].
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, def: &DeviceDef) -> Result<Self, Error> {
        Self::with(device.clone(), queue.clone(), def, false)
    }

    pub(super) fn with(device: wgpu::Device, queue: wgpu::Queue, def: &DeviceDef, own: bool) -> Result<Self, Error> {
        let gpu = WgpuDevice::new(device, queue, def, own)?;
        Ok(Device {
            pipelines: WgpuPipelines::new(&gpu, def.workgroup_size)?,
            plan: Plan::new(def.workgroup_size, gpu.limits.max_compute_workgroups_per_dimension),
            gpu,
            bound: BoundBuffers::default(),
            arena: Arena::new(),
            words: Vec::new(),
            belt: Belt::default(),
            mapping: None,
        })
    }

    /// The wgpu device.
    pub fn device(&self) -> &wgpu::Device {
        &self.gpu.device
    }

    /// Its queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.gpu.queue
    }

    /// Returns how many buffers and bind groups were made so far. The number does not grow in steady state.
    pub fn objects_made(&self) -> u64 {
        self.gpu.made.load(Ordering::Relaxed)
    }

    /// Sets the most vertices that a frame writes; see [`crate::deform_within`]. At first there is no limit (`u64::MAX`).
    pub fn set_vertex_budget(&mut self, vertices: u64) {
        self.plan.budget = vertices;
    }

    /// Frees meshes that no target shows.
    pub(super) fn free_meshes(&mut self) {
        self.arena.collect(0, |chunk| drop(self.belt.groups.remove(&chunk)));
    }

    /// Adds a target: a place for the vertices of one of the set's meshes. The first target of a mesh uploads the mesh and its
    /// examples before the next submission.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a buffer without `STORAGE`, a format that the attribute cannot have, a stride that is too
    /// small, attributes that overlap, or a bad scale; [`Error::Misaligned`] for offsets and strides that are not multiples of 4;
    /// [`Error::BufferTooSmall`]; [`Error::IndexOutOfRange`] for a level of detail that the set lacks; [`Error::Unsupported`] for
    /// normals or tangents that the mesh lacks, or more bytes than the device can bind;
    /// [`Error::Wgpu`] for a buffer of another device or one that was destroyed; [`Error::OutOfMemory`], [`Error::DeviceLost`].
    pub fn add_target(&mut self, set: &Arc<ExampleSet>, def: &TargetDef<'_>) -> Result<Target, Error> {
        self.gpu.reported_error()?;
        let mesh = set.lod(def.lod)?;
        let usage = def.buffer.usage();
        if !usage.contains(wgpu::BufferUsages::STORAGE) {
            let value = format!("{usage:?}");
            return Err(Error::invalid("the buffer's usage", value, "with STORAGE among its flags"));
        }
        let (layout, written) = def.layout(&mesh.mesh, def.buffer.size() & !3)?;
        let bound = self.bound.binding((&self.gpu, &self.pipelines), def.buffer, &written)?;
        let first = def.offset.wrapping_sub(bound.range.start);
        self.free_meshes();
        let gpu = &self.gpu;
        let mut limits = gpu.binding_limits();
        if gpu.limits.max_buffer_size < limits.bytes {
            (limits.bytes, limits.name) = (gpu.limits.max_buffer_size & !3, "max_buffer_size");
        }
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let make = |bytes| gpu.buffer("meshes and examples", bytes, usage);
        let mesh = self.arena.mesh((set, def.lod), &limits, make, |chunk, mesh, words| {
            let bytes: &[u8] = bytemuck::cast_slice(&words);
            gpu.checked("uploading a mesh and its examples", bytes.len() as u64, || {
                gpu.queue.write_buffer(chunk, mesh.offset(), bytes)
            })
        })?;
        Ok(Target::new(self.plan.id, (layout, first), mesh, (bound.id, bound)))
    }
}
