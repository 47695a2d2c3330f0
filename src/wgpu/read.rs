//! Reads vertices back into the CPU's memory, for tools and tests. It waits for the device.

use super::device::Device;
use super::target::Target;
use crate::base::error::Error;
use crate::deform::VertexMemory;
use crate::example::set::ExampleSet;
use crate::gpu::{Encoding, VertexStream};

impl Device {
    /// Waits for everything that was submitted, and reads bytes of a buffer. `offset` and the number of bytes are multiples of 4.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a buffer without `COPY_SRC`; [`Error::Misaligned`]; [`Error::BufferTooSmall`];
    /// [`Error::OutOfMemory`], [`Error::Wgpu`], [`Error::DeviceLost`]. After an error nothing was written.
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
            Some(s) => Err(Error::Unsupported { what: format!("reading {name} from {:?}: only floats", s.format) }),
            None => Err(Error::Unsupported { what: format!("reading {name}, which the target does not have") }),
        };
        let positions = stream("positions", Some(target.state.layout.positions), true)?;
        let normals = stream("normals", target.state.layout.normals, memory.has_normals())?;
        let tangents = stream("tangents", target.state.layout.tangents, memory.has_tangents())?;
        let mut all = crate::base::error::reserve::<u32>(target.size.div_ceil(4) as usize, "a target's vertices")?;
        all.resize((target.size / 4) as usize, 0);
        self.read(target.buffer(), target.offset, bytemuck::cast_slice_mut(&mut all))?;
        let value = |s: VertexStream<Encoding>, v: usize, i: u64| {
            f32::from_bits(all[((s.offset + v as u64 * s.stride) / 4 + i) as usize])
        };
        for v in 0..count {
            let four = |s| [0, 1, 2, 3].map(|i| value(s, v, i));
            let three = |s| [0, 1, 2].map(|i| value(s, v, i));
            // SAFETY: the memory has room for all vertices, and only this function borrows it.
            unsafe {
                if let Some(s) = positions {
                    memory.write_positions(v, &three(s));
                }
                if let Some(s) = normals {
                    memory.write_normals(v, &three(s));
                }
                if let Some(s) = tangents {
                    memory.write_tangent(v, four(s).into());
                }
            }
        }
        Ok(())
    }
}
