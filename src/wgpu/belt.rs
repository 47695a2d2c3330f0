//! A frame's words on their way to the device: staging buffers that come back by themselves once a submission has read them.

use super::arena::{Arena, Chunk};
use super::device::Gpu;
use super::kernels::Kernels;
use crate::Error;
use crate::gpu::Call;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

/// Bytes of a staging buffer, at least.
const LEAST: u64 = 64 << 10;

/// Mapped, and the CPU's.
const FREE: u8 = 0;
/// In a command buffer.
const BUSY: u8 = 1;
/// Its command buffer was never submitted, or the device is lost.
const GONE: u8 = 2;

/// Every command buffer copies its words to the same place on the device, in front of its dispatches: what is submitted one
/// after the other runs so.
#[derive(Default)]
pub(super) struct Belt {
    staging: Vec<Staging>,
    /// A frame's words, and behind them its calls.
    storage: Option<wgpu::Buffer>,
    /// Of each arena chunk that it was used with, the bind group of both.
    groups: Vec<(u32, wgpu::BindGroup)>,
}

struct Staging {
    buffer: wgpu::Buffer,
    state: Arc<AtomicU8>,
}

/// Held by the command buffer: tells when it is done, or that it was dropped.
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
    /// Makes room on the device for so many bytes.
    pub(super) fn reserve(&mut self, gpu: &Gpu, bytes: u64) -> Result<(), Error> {
        if self.storage.as_ref().is_some_and(|s| s.size() >= bytes) {
            return Ok(());
        }
        let most = gpu.most_bound();
        if bytes > most {
            let what = format!(
                "{bytes} bytes for the work of a frame; max_storage_buffer_binding_size is {most} on this device"
            );
            return Err(Error::Unsupported { what });
        }
        use wgpu::BufferUsages as U;
        let size = bytes.next_power_of_two().max(LEAST).min(most);
        self.storage = Some(gpu.buffer("work of a frame", size, U::STORAGE | U::UNIFORM | U::COPY_DST)?);
        self.groups.clear();
        Ok(())
    }

    /// Makes sure that there is a bind group for a chunk, and drops those of chunks that are no more.
    pub(super) fn add_group(
        &mut self,
        (gpu, kernels, arena): (&Gpu, &Kernels, &Arena),
        chunk: &Chunk,
    ) -> Result<(), Error> {
        let Some(storage) = &self.storage else { return Ok(()) };
        if !self.groups.iter().any(|(c, _)| *c == chunk.id) {
            self.groups.retain(|(c, _)| arena.has(*c));
            let whole = |buffer| wgpu::BufferBinding { buffer, offset: 0, size: None };
            let call = wgpu::BufferBinding {
                buffer: storage,
                offset: 0,
                size: std::num::NonZero::new(size_of::<Call>() as u64),
            };
            let group = gpu.bind_group(&kernels.work, &[whole(&chunk.buffer), whole(storage), call])?;
            self.groups.push((chunk.id, group));
        }
        Ok(())
    }

    /// The bind group for a chunk, once it was added.
    pub(super) fn group(&self, chunk: u32) -> Option<&wgpu::BindGroup> {
        Some(&self.groups.iter().find(|(c, _)| *c == chunk)?.1)
    }

    /// Has the words copied to the device, for which there is room, by the encoder.
    pub(super) fn copy(&mut self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, words: &[u32]) -> Result<(), Error> {
        let Some(storage) = &self.storage else { return Ok(()) };
        let bytes = 4 * words.len() as u64;
        self.staging.retain(|s| s.state.load(Ordering::Acquire) != GONE);
        let free = |s: &Staging| s.state.load(Ordering::Acquire) == FREE;
        let index = match self.staging.iter().position(|s| free(s) && s.buffer.size() >= bytes) {
            Some(index) => index,
            None => {
                use wgpu::BufferUsages as U;
                // Those that have become too small give way.
                self.staging.retain(|s| !free(s));
                let buffer = gpu.buffer("staging", storage.size(), U::MAP_WRITE | U::COPY_SRC)?;
                self.staging.push(Staging { buffer, state: Arc::new(AtomicU8::new(FREE)) });
                self.staging.len() - 1
            }
        };
        let Staging { buffer, state } = &self.staging[index];
        // wgpu says that a device is lost by giving out buffers that are none.
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
