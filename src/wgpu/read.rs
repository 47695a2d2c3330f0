//! Back into the CPU's memory, for tools and tests: no frame should wait for this.

use super::device::{Device, WgpuDevice};
use super::target::Target;
use crate::deform::VertexMemory;
use crate::gpu::{Encoding, VertexStream};
use crate::{Error, ExampleSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A buffer that the CPU reads, used over and over.
#[derive(Default)]
pub(super) struct Readback {
    buffer: Option<wgpu::Buffer>,
}

impl Device {
    /// Reads bytes of a buffer as they are after everything that was submitted, and waits for that. `offset` and the number of
    /// bytes are multiples of 4.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a buffer without `COPY_SRC`; [`Error::Misaligned`]; [`Error::BufferTooSmall`];
    /// [`Error::OutOfMemory`], [`Error::Wgpu`], [`Error::DeviceLost`]. Nothing is written then.
    pub fn read(&mut self, buffer: &wgpu::Buffer, offset: u64, to: &mut [u8]) -> Result<(), Error> {
        self.reported_error()?;
        let bytes = to.len() as u64;
        for (name, value) in [("the offset", offset), ("the number of bytes to read", bytes)] {
            if value % 4 != 0 {
                return Err(Error::Misaligned { name: name.into(), value, align: 4 });
            }
        }
        let (size, needed) = (buffer.size(), offset.saturating_add(bytes));
        if needed > size {
            return Err(Error::BufferTooSmall { name: "the buffer".into(), size, needed });
        }
        if !buffer.usage().contains(wgpu::BufferUsages::COPY_SRC) {
            let value = format!("{:?}", buffer.usage());
            return Err(Error::invalid("the buffer's usage", value, "with COPY_SRC among its flags"));
        }
        if bytes > 0 { self.reader.read(&self.gpu, (buffer, offset), to) } else { Ok(()) }
    }

    /// Reads a target's vertices, as they are after everything that was submitted, into memory of the CPU: what it has of
    /// positions, normals and tangents. Waits for the device.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a target of another device or set, and a buffer without `COPY_SRC`;
    /// [`Error::Unsupported`] for attributes that the target does not have, or has in other formats than floats;
    /// [`Error::BufferTooSmall`], [`Error::OutOfMemory`], [`Error::Wgpu`], [`Error::DeviceLost`]. Nothing is written then.
    pub fn read_vertices(
        &mut self,
        set: &ExampleSet,
        target: &Target,
        memory: &mut VertexMemory<'_>,
    ) -> Result<(), Error> {
        if target.state.device != self.id {
            return Err(Error::invalid("target", "of another device", "a target of this device"));
        }
        if !std::ptr::eq(target.state.set.as_ptr(), set) {
            return Err(Error::invalid("set", "another one", "the set of the target"));
        }
        let count = set.lod(target.state.lod)?.vertex_count();
        memory.check_size(count)?;
        let stream = |name: &str, s: Option<VertexStream<Encoding>>, wanted: bool| match s {
            _ if !wanted => Ok(None),
            Some(s) if s.format == Encoding::F32 => Ok(Some(s)),
            Some(s) => Err(Error::Unsupported { what: format!("reading {name}s from {:?}: only floats", s.format) }),
            None => Err(Error::Unsupported { what: format!("reading {name}s, which the target does not have") }),
        };
        let positions = stream("position", Some(target.state.layout.positions), true)?;
        let normals = stream("normal", target.state.layout.normals, memory.has_normals())?;
        let tangents = stream("tangent", target.state.layout.tangents, memory.has_tangents())?;
        let mut all = crate::base::error::reserve::<u32>(target.size.div_ceil(4) as usize, "a target's vertices")?;
        all.resize((target.size / 4) as usize, 0);
        self.read(target.buffer(), target.offset, bytemuck::cast_slice_mut(&mut all))?;
        let value = |s: VertexStream<Encoding>, v: usize, i: u64| {
            f32::from_bits(all[((s.offset + v as u64 * s.stride) / 4 + i) as usize])
        };
        for v in 0..count {
            let three = |s| [0, 1, 2].map(|i| value(s, v, i));
            // SAFETY: the memory has room for all vertices, and is borrowed here alone.
            unsafe {
                if let Some(s) = positions {
                    memory.write_positions(v, &three(s));
                }
                if let Some(s) = normals {
                    memory.write_normals(v, &three(s));
                }
                if let Some(s) = tangents {
                    memory.write_tangent(v, [0, 1, 2, 3].map(|i| value(s, v, i)).into());
                }
            }
        }
        Ok(())
    }
}

impl Readback {
    fn read(&mut self, gpu: &WgpuDevice, (from, offset): (&wgpu::Buffer, u64), to: &mut [u8]) -> Result<(), Error> {
        let bytes = to.len() as u64;
        // Taken, so that one that stays mapped by a failure is not used again.
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
        // wgpu panics where a device is lost while somebody waits for it.
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
