//! Copies a frame's data to the device through staging buffers, which come back once a submission has read them.
//!
//! `wgpu::util::StagingBelt` does not fit: it keeps chunks that have become too small, and does not tell when it makes one, which
//! `Device::objects_made` counts.

use super::pipelines::WgpuPipelines;
use super::wgpu_device::WgpuDevice;
use crate::base::error::Error;
use crate::gpu::Call;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

/// Mapped; the CPU may write it.
const FREE: u8 = 0;
/// Used by a command buffer.
const BUSY: u8 = 1;
/// Of no more use: its command buffer was never submitted, or the device is lost.
const GONE: u8 = 2;

/// Every command buffer first copies its words to the same place on the device, and then dispatches. Submissions run one after
/// another, so that each reads its own words.
#[derive(Default)]
pub(super) struct Belt {
    staging: Vec<Staging>,
    /// A frame's data, and behind it the calls.
    storage: Option<wgpu::Buffer>,
    /// Bind groups of a chunk of the arena and the storage buffer.
    groups: Vec<(u32, wgpu::BindGroup)>,
}

struct Staging {
    buffer: wgpu::Buffer,
    state: Arc<AtomicU8>,
}

/// Held by a command buffer. It sets the state when the command buffer is done or dropped.
struct Ticket(Arc<AtomicU8>);

impl Ticket {
    fn done(self, mapped: bool) {
        self.0.store(if mapped { FREE } else { GONE }, Ordering::Release);
    }
}

impl Drop for Ticket {
    fn drop(&mut self) {
        let _ = self.0.compare_exchange(BUSY, GONE, Ordering::AcqRel, Ordering::Acquire);
    }
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
        if self.group(chunk).is_none() {
            let whole = |buffer| wgpu::BufferBinding { buffer, offset: 0, size: None };
            let size = std::num::NonZero::new(size_of::<Call>() as u64);
            let call = wgpu::BufferBinding { buffer: storage, offset: 0, size };
            let group = gpu.bind_group(&pipelines.work, &[whole(meshes), whole(storage), call])?;
            self.groups.push((chunk, group));
        }
        Ok(())
    }

    /// Drops the bind group of a chunk that is no more.
    pub(super) fn remove_group(&mut self, chunk: u32) {
        self.groups.retain(|(c, _)| *c != chunk);
    }

    /// A bind group that was added.
    pub(super) fn group(&self, chunk: u32) -> Option<&wgpu::BindGroup> {
        Some(&self.groups.iter().find(|(c, _)| *c == chunk)?.1)
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
        self.staging.retain(|s| s.state.load(Ordering::Acquire) != GONE);
        let free = |s: &Staging| s.state.load(Ordering::Acquire) == FREE;
        let index = match self.staging.iter().position(|s| free(s) && s.buffer.size() >= bytes) {
            Some(index) => index,
            None => {
                use wgpu::BufferUsages as U;
                // Free buffers are too small now.
                self.staging.retain(|s| !free(s));
                let buffer = gpu.buffer("staging", storage.size(), U::MAP_WRITE | U::COPY_SRC)?;
                self.staging.push(Staging { buffer, state: Arc::new(AtomicU8::new(FREE)) });
                self.staging.len() - 1
            }
        };
        let Staging { buffer, state } = &self.staging[index];
        // The buffers of a lost device cannot be mapped.
        let lost = |_| Error::DeviceLost { call: "mapping a buffer".into() };
        buffer.get_mapped_range_mut(..bytes).map_err(lost)?.copy_from_slice(bytemuck::cast_slice(words));
        buffer.unmap();
        encoder.copy_buffer_to_buffer(buffer, 0, storage, 0, bytes);
        state.store(BUSY, Ordering::Release);
        let ticket = Ticket(state.clone());
        encoder.map_buffer_on_submit(buffer, wgpu::MapMode::Write, .., move |mapped| ticket.done(mapped.is_ok()));
        Ok(())
    }
}
