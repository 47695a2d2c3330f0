//! Reads vertices back into the CPU's memory, for tools and tests. It waits for the device.

use super::device::Device;
use super::target::Target;
use crate::base::error::{Error, reserve};
use crate::base::strided::Strided;
use crate::deform::VertexMemory;
use crate::example::set::ExampleSet;
use crate::gpu::{Attribute, Encoding, VertexStream};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

impl Device {
    /// Waits for everything that was submitted, and reads bytes of a buffer. `offset` and the number of bytes are multiples of 4.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a buffer without `COPY_SRC`; [`Error::Misaligned`]; [`Error::BufferTooSmall`];
    /// [`Error::OutOfMemory`], [`Error::Wgpu`], [`Error::DeviceLost`]. After an error nothing was written.
    pub fn read(&mut self, buffer: &wgpu::Buffer, offset: u64, to: &mut [u8]) -> Result<(), Error> {
        self.gpu.reported_error()?;
        let bytes = to.len() as u64;
        for (name, value) in [("the offset", offset), ("the number of bytes to read", bytes)] {
            Strided::check_aligned(name, value, 4)?;
        }
        let (size, needed) = (buffer.size(), offset.saturating_add(bytes));
        if needed > size {
            return Err(Error::BufferTooSmall { name: "the buffer".into(), size, needed });
        }
        if !buffer.usage().contains(wgpu::BufferUsages::COPY_SRC) {
            let value = format!("{:?}", buffer.usage());
            return Err(Error::invalid("the buffer's usage", value, "with COPY_SRC among its flags"));
        }
        if bytes == 0 {
            return Ok(());
        }
        let gpu = &self.gpu;
        // It is taken, so that a buffer that stays mapped after a failure is not reused.
        let mapping = match self.mapping.take().filter(|b| b.size() >= bytes) {
            Some(mapping) => mapping,
            None => gpu.buffer("read back", bytes, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST)?,
        };
        let mapped = Arc::new(AtomicBool::new(false));
        gpu.checked("reading a buffer", 0, || {
            let descriptor = wgpu::CommandEncoderDescriptor { label: Some("crumple: read back") };
            let mut encoder = gpu.device.create_command_encoder(&descriptor);
            encoder.copy_buffer_to_buffer(buffer, offset, &mapping, 0, bytes);
            gpu.queue.submit([encoder.finish()]);
            let done = mapped.clone();
            mapping
                .map_async(wgpu::MapMode::Read, ..bytes, move |result| done.store(result.is_ok(), Ordering::Release));
        })?;
        // wgpu panics if the device is lost during the wait.
        let lost = || Error::DeviceLost { call: "waiting for the device".into() };
        let poll = || gpu.device.poll(wgpu::PollType::wait_indefinitely());
        catch_unwind(AssertUnwindSafe(poll)).map_err(|_| lost())?.map_err(|_| lost())?;
        if !mapped.load(Ordering::Acquire) {
            return Err(lost());
        }
        to.copy_from_slice(&mapping.get_mapped_range(..bytes).map_err(|_| lost())?);
        mapping.unmap();
        self.mapping = Some(mapping);
        Ok(())
    }

    /// Waits for everything that was submitted, and reads a target's vertices into memory of the CPU: those of positions, normals,
    /// and tangents that the memory has.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a target of another device or set, and a buffer without `COPY_SRC`;
    /// [`Error::Unsupported`] for attributes that the target lacks, or has in other formats than floats;
    /// [`Error::BufferTooSmall`], [`Error::OutOfMemory`], [`Error::Wgpu`], [`Error::DeviceLost`]. After an error nothing was written.
    pub fn read_vertices(
        &mut self,
        set: &ExampleSet,
        target: &Target,
        memory: &mut VertexMemory<'_>,
    ) -> Result<(), Error> {
        if target.state.device != self.plan.id {
            return Err(Error::invalid("target", "of another device", "a target of this device"));
        }
        if !std::ptr::eq(target.state.mesh.set.as_ptr(), set) {
            return Err(Error::invalid("set", "another one", "the set of the target"));
        }
        let count = set.lod(target.state.mesh.lod)?.vertex_count();
        memory.check_size(count)?;
        let wanted = [true, memory.has_normals(), memory.has_tangents()];
        let (mut streams, mut end) = ([None; 3], 0);
        for (i, attribute) in Attribute::ALL.into_iter().enumerate().filter(|(i, _)| wanted[*i]) {
            let refused = |why| Error::Unsupported { what: format!("reading {}{why}", attribute.plural()) };
            let Some(s) = target.state.layout.streams[i] else {
                return Err(refused(", which the target does not have".to_owned()));
            };
            if s.format != Encoding::F32 {
                return Err(refused(format!(" from {:?}: only floats", s.format)));
            }
            streams[i] = Some(s);
            end = end.max(s.strided(attribute, count).span().end);
        }
        let mut all = reserve::<u32>(end as usize / 4, "a target's vertices")?;
        all.resize(end as usize / 4, 0);
        let offset = target.own.range.start.wrapping_add(target.state.first);
        self.read(target.buffer(), offset, bytemuck::cast_slice_mut(&mut all))?;
        for v in 0..count {
            let value =
                |s: VertexStream<Encoding>, i| f32::from_bits(all[(s.offset + v as u64 * s.stride) as usize / 4 + i]);
            let three = |s| [0, 1, 2].map(|i| value(s, i));
            // SAFETY: the memory has room for all vertices, and only this function borrows it.
            unsafe {
                streams[0].into_iter().for_each(|s| memory.write_positions(v, &three(s)));
                streams[1].into_iter().for_each(|s| memory.write_normals(v, &three(s)));
                streams[2].into_iter().for_each(|s| memory.write_tangent(v, [0, 1, 2, 3].map(|i| value(s, i)).into()));
            }
        }
        Ok(())
    }
}
