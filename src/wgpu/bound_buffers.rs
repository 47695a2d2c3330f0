//! The bind groups of the host's buffers. Targets share them.

use super::pipelines::WgpuPipelines;
use super::wgpu_device::WgpuDevice;
use crate::base::error::Error;
use crate::gpu::binding_range;
use std::num::NonZero;
use std::ops::Range;
use std::sync::{Arc, Weak};

/// A range of a host's buffer that is bound as a whole.
#[derive(Debug)]
pub(super) struct BoundBuffer {
    pub id: u64,
    pub buffer: wgpu::Buffer,
    pub range: Range<u64>,
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
