//! Copies a frame's data to the device through staging buffers, which come back once a submission has read them.
//!
//! `wgpu::util::StagingBelt` does not fit: it keeps chunks that have become too small, and does not tell when it makes one, which
//! `Device::objects_made` counts.

use super::pipelines::WgpuPipelines;
use super::wgpu_device::WgpuDevice;
use crate::base::error::Error;
use crate::gpu::Call;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::{Arc, Mutex};

/// Every command buffer first copies its words to the same place on the device, and then dispatches. Submissions run one after
/// another, so that each reads its own words.
#[derive(Default)]
pub(super) struct Belt {
    /// Staging buffers that are mapped: the CPU may write them. A command buffer holds the one that it copies from, and returns it
    /// once it is done. One that is never submitted drops it.
    free: Arc<Mutex<Vec<wgpu::Buffer>>>,
    /// A frame's data, and behind it the calls.
    storage: Option<wgpu::Buffer>,
    /// Bind groups of a chunk of the arena and the storage buffer, by chunk.
    pub groups: BTreeMap<u32, wgpu::BindGroup>,
}

impl Belt {
    /// Makes room on the device for `bytes` bytes.
    pub(super) fn reserve(&mut self, gpu: &WgpuDevice, bytes: u64) -> Result<(), Error> {
        if self.storage.as_ref().is_some_and(|s| s.size() >= bytes) {
            return Ok(());
        }
        let limits = gpu.binding_limits();
        limits.check("the work of a frame", bytes)?;
        use wgpu::BufferUsages as U;
        let size = limits.frame_buffer_size(bytes);
        self.storage = Some(gpu.buffer("work of a frame", size, U::STORAGE | U::UNIFORM | U::COPY_DST)?);
        self.groups.clear();
        Ok(())
    }

    /// Adds the bind group for a chunk, if it is not there yet.
    pub(super) fn add_group(
        &mut self,
        (gpu, pipelines): (&WgpuDevice, &WgpuPipelines),
        chunk: u32,
        meshes: &wgpu::Buffer,
    ) -> Result<(), Error> {
        let Some(storage) = &self.storage else { return Ok(()) };
        if let Entry::Vacant(entry) = self.groups.entry(chunk) {
            let whole = |buffer| wgpu::BufferBinding { buffer, offset: 0, size: None };
            let size = std::num::NonZero::new(size_of::<Call>() as u64);
            let call = wgpu::BufferBinding { buffer: storage, offset: 0, size };
            entry.insert(gpu.bind_group(&pipelines.work, &[whole(meshes), whole(storage), call])?);
        }
        Ok(())
    }

    /// Encodes a copy of the words to the device. There must be room for them.
    pub(super) fn copy(
        &mut self,
        gpu: &WgpuDevice,
        encoder: &mut wgpu::CommandEncoder,
        words: &[u32],
    ) -> Result<(), Error> {
        let Some(storage) = &self.storage else { return Ok(()) };
        let bytes = 4 * words.len() as u64;
        let found = {
            let mut free = self.free.lock().unwrap_or_else(|e| e.into_inner());
            let found = free.iter().position(|buffer| buffer.size() >= bytes).map(|index| free.swap_remove(index));
            if found.is_none() {
                // They are too small now.
                free.clear();
            }
            found
        };
        use wgpu::BufferUsages as U;
        let buffer = match found {
            Some(buffer) => buffer,
            None => gpu.buffer("staging", storage.size(), U::MAP_WRITE | U::COPY_SRC)?,
        };
        // The buffers of a lost device cannot be mapped.
        let lost = |_| Error::DeviceLost { call: "mapping a buffer".into() };
        buffer.get_mapped_range_mut(..bytes).map_err(lost)?.copy_from_slice(bytemuck::cast_slice(words));
        buffer.unmap();
        encoder.copy_buffer_to_buffer(&buffer, 0, storage, 0, bytes);
        let (free, done) = (self.free.clone(), buffer.clone());
        encoder.map_buffer_on_submit(&buffer, wgpu::MapMode::Write, .., move |mapped| {
            if mapped.is_ok() {
                free.lock().unwrap_or_else(|e| e.into_inner()).push(done);
            }
        });
        Ok(())
    }
}
