//! Copies bytes of the device to the CPU, through a buffer that the CPU maps.

use super::wgpu_device::WgpuDevice;
use crate::base::error::Error;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A buffer that the CPU reads. It is reused.
#[derive(Default)]
pub(super) struct Readback {
    buffer: Option<wgpu::Buffer>,
}

impl Readback {
    /// Copies bytes of `from`, from `offset` on, once everything that was submitted has run.
    pub(super) fn read(
        &mut self,
        gpu: &WgpuDevice,
        (from, offset): (&wgpu::Buffer, u64),
        to: &mut [u8],
    ) -> Result<(), Error> {
        let bytes = to.len() as u64;
        // It is taken, so that a buffer that stays mapped after a failure is not reused.
        let buffer = match self.buffer.take().filter(|b| b.size() >= bytes) {
            Some(buffer) => buffer,
            None => gpu.buffer("read back", bytes, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST)?,
        };
        let mapped = Arc::new(AtomicBool::new(false));
        gpu.checked("reading a buffer", 0, || {
            let descriptor = wgpu::CommandEncoderDescriptor { label: Some("crumple: read back") };
            let mut encoder = gpu.device.create_command_encoder(&descriptor);
            encoder.copy_buffer_to_buffer(from, offset, &buffer, 0, bytes);
            gpu.queue.submit([encoder.finish()]);
            let done = mapped.clone();
            buffer.map_async(wgpu::MapMode::Read, ..bytes, move |result| done.store(result.is_ok(), Ordering::Release));
        })?;
        // wgpu panics if the device is lost during the wait.
        let lost = || Error::DeviceLost { call: "waiting for the device".into() };
        let poll = || gpu.device.poll(wgpu::PollType::wait_indefinitely());
        catch_unwind(AssertUnwindSafe(poll)).map_err(|_| lost())?.map_err(|_| lost())?;
        if !mapped.load(Ordering::Acquire) {
            return Err(lost());
        }
        to.copy_from_slice(&buffer.get_mapped_range(..bytes).map_err(|_| lost())?);
        buffer.unmap();
        self.buffer = Some(buffer);
        Ok(())
    }
}
