//! A target: the place of a mesh's vertices in a buffer of the host.

use super::bound_buffers::BoundBuffer;
use crate::base::math::Aabb;
use crate::gpu::{self, Encoding, HostFormat, PlanTarget, TargetState, VertexStream};
use std::ops::Range;
use std::sync::Arc;
use wgpu::VertexFormat;

impl HostFormat for VertexFormat {
    const POSITIONS: [(Self, Encoding); 3] = [
        (VertexFormat::Float32x3, Encoding::F32),
        (VertexFormat::Float16x4, Encoding::F16x4),
        (VertexFormat::Snorm16x4, Encoding::Snorm16x4),
    ];
    const NORMALS: [(Self, Encoding); 4] = [
        (VertexFormat::Float32x3, Encoding::F32),
        (VertexFormat::Snorm16x4, Encoding::Snorm16x4),
        (VertexFormat::Snorm8x4, Encoding::Snorm8x4),
        (VertexFormat::Unorm16x2, Encoding::Octahedral16x2),
    ];
    const TANGENTS: [(Self, Encoding); 4] = [
        (VertexFormat::Float32x4, Encoding::F32),
        (VertexFormat::Snorm16x4, Encoding::Snorm16x4),
        (VertexFormat::Snorm8x4, Encoding::Snorm8x4),
        (VertexFormat::Unorm16x2, Encoding::Octahedral16x2),
    ];
}

/// Where a buffer stores one attribute of the vertices.
pub type Stream = VertexStream<VertexFormat>;

/// Where a buffer stores the vertices of one mesh.
///
/// The buffer is of the same device and made with [`wgpu::BufferUsages::STORAGE`]. It lives as long as any of its targets. wgpu
/// refuses a buffer of another device, but cannot tell buffers of two [`wgpu::Instance`]s apart: never mix those.
pub type TargetDef<'a> = gpu::TargetDef<&'a wgpu::Buffer, VertexFormat>;

/// A mesh's vertices in a buffer, and what they show. Drop it to end it.
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
    /// Forgets what the memory holds, so that the next encoding writes every vertex. Call it if anyone else wrote to the memory, or
    /// if an encoding was not submitted.
    pub fn invalidate(&mut self) {
        self.state.tracker.invalidate();
    }

    /// A box around all vertices as of the last encoding, m; `None` before the first. It may be too large, since the CPU only knows
    /// how far each block can have moved, but never too small.
    pub fn bounds(&self) -> Option<Aabb> {
        self.state.tracker.bounds()
    }

    /// Vertices that the last encoding wrote, as increasing ranges with gaps between them.
    pub fn changed(&self) -> &[Range<u32>] {
        self.state.tracker.changed()
    }

    /// Its buffer.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.bound.buffer
    }
}

impl PlanTarget for Target {
    /// The id of its binding.
    type Binding = u64;

    fn binding(&self) -> u64 {
        self.bound.id
    }

    fn state(&self) -> &TargetState {
        &self.state
    }

    fn state_mut(&mut self) -> &mut TargetState {
        &mut self.state
    }
}
