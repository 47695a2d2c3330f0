//! Adds targets in the host's buffers, and uploads their meshes.

use super::device::Device;
use super::target::{Target, TargetDef};
use super::wgpu_device::WgpuDevice;
use crate::base::error::Error;
use crate::deform::Tracker;
use crate::example::set::ExampleSet;
use crate::gpu::{ResidentMesh, TargetState, Upload};
use std::sync::Arc;

impl Device {
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
        self.reported_error()?;
        let mesh = set.lod(def.lod)?;
        let usage = def.buffer.usage();
        if !usage.contains(wgpu::BufferUsages::STORAGE) {
            let value = format!("{usage:?}");
            return Err(Error::invalid("the buffer's usage", value, "with STORAGE among its flags"));
        }
        let (layout, kernel, written) = def.layout(&mesh.mesh, def.buffer.size() & !3)?;
        let bound = self.bound.binding((&self.gpu, &self.pipelines), def.buffer, &written)?;
        let first = def.offset.wrapping_sub(bound.range.start);
        let mesh = self.mesh(set, def.lod)?;
        let (device, set, tracker) = (self.id, Arc::downgrade(set), Tracker::new());
        let state = TargetState { device, set, lod: def.lod, kernel, layout, first, mesh, tracker };
        Ok(Target { state, offset: def.offset, size: def.size, bound, classic: None })
    }

    /// Returns a mesh of the set. A new one is uploaded before the next submission runs.
    fn mesh(&mut self, set: &Arc<ExampleSet>, lod: usize) -> Result<Arc<ResidentMesh>, Error> {
        self.free_meshes();
        let gpu = &self.gpu;
        let mut limits = gpu.binding_limits();
        if gpu.limits.max_buffer_size < limits.bytes {
            (limits.bytes, limits.name) = (gpu.limits.max_buffer_size & !3, "max_buffer_size");
        }
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let make = |bytes| gpu.buffer("meshes and examples", bytes, usage);
        self.arena.mesh((set, lod), &limits, make, |chunk, mesh| upload(gpu, chunk, mesh))
    }
}

fn upload(gpu: &WgpuDevice, chunk: &wgpu::Buffer, mesh: &Upload<'_>) -> Result<(), Error> {
    let mut words: Vec<u32> = crate::base::error::reserve(mesh.words as usize, "a mesh and its examples")?;
    words.resize(mesh.words as usize, 0);
    mesh.write(&mut words)?;
    let bytes = bytemuck::cast_slice(&words);
    gpu.checked("uploading a mesh and its examples", 4 * mesh.words, || {
        gpu.queue.write_buffer(chunk, 4 * u64::from(mesh.at), bytes)
    })
}
