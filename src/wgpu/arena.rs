//! Meshes, examples and stamps on the device. wgpu keeps a buffer as long as a command buffer uses it.

use super::device::{Device, WgpuDevice};
use crate::Error;
use crate::example::set::ExampleSet;
use crate::gpu::{ResidentMesh, Upload};
use std::sync::Arc;

impl Device {
    /// Returns a mesh of the set. A new one is uploaded before the next submission runs.
    pub(super) fn mesh(&mut self, set: &Arc<ExampleSet>, lod: usize) -> Result<Arc<ResidentMesh>, Error> {
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

    /// Frees meshes that no target shows.
    pub(super) fn free_meshes(&mut self) {
        self.arena.collect(0, |chunk, _| self.belt.remove_group(chunk));
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
