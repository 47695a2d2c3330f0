//! A target: the place of a mesh's vertices in a buffer of the host; and the bind groups of these buffers, which targets share.

use super::pipelines::WgpuPipelines;
use super::wgpu_device::WgpuDevice;
use crate::base::error::Error;
use crate::gpu::{self, Attribute, Encoding, HostFormat, VertexStream, binding_range};
use std::num::NonZero;
use std::ops::Range;
use std::sync::{Arc, Weak};
use wgpu::VertexFormat;

impl HostFormat for VertexFormat {
    fn of(attribute: Attribute, encoding: Encoding) -> Self {
        match encoding {
            Encoding::F32 if attribute == Attribute::Tangent => VertexFormat::Float32x4,
            Encoding::F32 => VertexFormat::Float32x3,
            Encoding::F16x4 => VertexFormat::Float16x4,
            Encoding::Snorm16x4 => VertexFormat::Snorm16x4,
            Encoding::Snorm8x4 => VertexFormat::Snorm8x4,
            Encoding::Octahedral16x2 => VertexFormat::Unorm16x2,
        }
    }
}

/// Where a buffer stores one attribute of the vertices.
pub type Stream = VertexStream<VertexFormat>;

/// Where a buffer stores the vertices of one mesh.
///
/// The buffer is of the same device and made with [`wgpu::BufferUsages::STORAGE`]. It lives as long as any of its targets. wgpu
/// refuses a buffer of another device, but cannot tell buffers of two [`wgpu::Instance`]s apart: never mix those.
pub type TargetDef<'a> = gpu::TargetDef<&'a wgpu::Buffer, VertexFormat>;

/// A mesh's vertices in a buffer, and what they show. Drop it to end it.
pub type Target = gpu::Target<u64, wgpu::BindGroup, Arc<BoundBuffer>>;

impl Target {
    /// Its buffer.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.own.buffer
    }
}

/// A range of a host's buffer that is bound as a whole.
#[derive(Debug)]
pub struct BoundBuffer {
    pub(super) id: u64,
    pub(super) buffer: wgpu::Buffer,
    pub(super) range: Range<u64>,
    pub(super) group: wgpu::BindGroup,
}

/// The bindings of all targets.
#[derive(Default)]
pub(super) struct BoundBuffers {
    all: Vec<Weak<BoundBuffer>>,
    last_id: u64,
}

impl BoundBuffers {
    /// Returns a binding of the buffer that holds these bytes.
    pub(super) fn binding(
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
