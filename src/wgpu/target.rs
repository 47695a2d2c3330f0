//! Where in the host's buffers vertices lie.

use super::device::{Device, WgpuDevice};
use super::pipelines::WgpuPipelines;
use crate::example::set::ExampleSet;
use crate::gpu::{self, Encoding, HostFormat, TargetState, VertexStream, binding_range};
use crate::{Aabb, Error, Tracker};
use std::num::NonZero;
use std::ops::Range;
use std::sync::{Arc, Weak};
use wgpu::VertexFormat;

impl HostFormat for VertexFormat {
    const POSITIONS: [(Self, Encoding); 3] = [
        (VertexFormat::Float32x3, Encoding::F32),
        (VertexFormat::Float16x4, Encoding::F16x4),
        (VertexFormat::Snorm16x4, Encoding::Snorm16x4),
    ];
    const NORMALS: [(Self, Encoding); 3] = [
        (VertexFormat::Float32x3, Encoding::F32),
        (VertexFormat::Snorm16x4, Encoding::Snorm16x4),
        (VertexFormat::Snorm8x4, Encoding::Snorm8x4),
    ];
    const TANGENTS: [(Self, Encoding); 3] = [
        (VertexFormat::Float32x4, Encoding::F32),
        (VertexFormat::Snorm16x4, Encoding::Snorm16x4),
        (VertexFormat::Snorm8x4, Encoding::Snorm8x4),
    ];
}

/// Where a buffer stores one attribute of the vertices.
pub type Stream = VertexStream<VertexFormat>;

/// Where a buffer stores the vertices of one mesh.
///
/// The buffer is of the same device and made with [`wgpu::BufferUsages::STORAGE`]. It lives as long as any of its targets. wgpu
/// refuses a buffer of another device, but cannot tell buffers of two [`wgpu::Instance`]s apart: never mix those.
pub type TargetDef<'a> = gpu::TargetDef<&'a wgpu::Buffer, VertexFormat>;

/// A mesh's vertices in a buffer, and what they show. Dropping it is how it ends.
#[derive(Debug)]
pub struct Target {
    pub(super) state: TargetState,
    pub(super) offset: u64,
    pub(super) size: u64,
    pub(super) bound: Arc<BoundBuffer>,
    /// States of the vertices, for an instance with a classic rule.
    pub(super) classic: Option<wgpu::BindGroup>,
}

impl Target {
    /// Forgets what the memory holds: the next encoding writes every vertex. For memory that others wrote to, and for
    /// encodings that were not submitted.
    pub fn invalidate(&mut self) {
        self.state.tracker.invalidate();
    }

    /// A box around all vertices as of the last encoding, m; `None` before the first. It is never too small but may be too
    /// large: the CPU does not know the vertices, only how far each block of them can have moved.
    pub fn bounds(&self) -> Option<Aabb> {
        self.state.tracker.bounds()
    }

    /// Vertices that the last encoding wrote: ranges, increasing, apart from each other.
    pub fn changed(&self) -> &[Range<u32>] {
        self.state.tracker.changed()
    }

    /// The buffer that it is in.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.bound.buffer
    }
}

/// A range of a host's buffer that is bound as a whole.
#[derive(Debug)]
pub(super) struct BoundBuffer {
    pub id: u64,
    buffer: wgpu::Buffer,
    range: Range<u64>,
    pub group: wgpu::BindGroup,
}

/// The bindings of all targets.
#[derive(Default)]
pub(super) struct BoundBuffers {
    all: Vec<Weak<BoundBuffer>>,
    last_id: u64,
}

impl BoundBuffers {
    /// Returns a binding of the buffer that holds these bytes.
    fn binding(
        &mut self,
        (gpu, pipelines): (&WgpuDevice, &WgpuPipelines),
        buffer: &wgpu::Buffer,
        bytes: &Range<u64>,
    ) -> Result<Arc<BoundBuffer>, Error> {
        self.all.retain(|w| w.strong_count() > 0);
        let holds = |r: &Range<u64>| r.start <= bytes.start && bytes.end <= r.end;
        let mut alive = self.all.iter().filter_map(Weak::upgrade);
        if let Some(bound) = alive.find(|b| b.buffer == *buffer && holds(&b.range)) {
            return Ok(bound);
        }
        let range = binding_range(buffer.size(), bytes, &gpu.binding_limits())?;
        let size = NonZero::new(range.end - range.start);
        let binding = wgpu::BufferBinding { buffer, offset: range.start, size };
        let group = gpu.bind_group(&pipelines.one, &[binding])?;
        self.last_id += 1;
        let bound = Arc::new(BoundBuffer { id: self.last_id, buffer: buffer.clone(), range, group });
        self.all.push(Arc::downgrade(&bound));
        Ok(bound)
    }
}

impl Device {
    /// Says where in a buffer vertices of one of the set's meshes lie. The first target of a mesh gets its vertices and examples
    /// into memory of the device, in front of whatever is submitted next.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a buffer without `STORAGE`, a format that an attribute cannot have, a stride that is too
    /// small, attributes that overlap, or a scale that is none; [`Error::Misaligned`] for offsets and strides that are not
    /// multiples of 4; [`Error::BufferTooSmall`]; [`Error::IndexOutOfRange`] for a level of detail that is not there;
    /// [`Error::Unsupported`] for normals or tangents that the mesh does not have, or more bytes than the device can bind;
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
}
