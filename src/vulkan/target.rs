//! A target: the place of a mesh's vertices in a buffer of the host.

use super::classic::ClassicBuffer;
use super::host_buffers::BufferId;
use crate::base::math::Aabb;
use crate::gpu::{self, Encoding, HostFormat, PlanTarget, TargetState, VertexStream};
use ash::vk;
use std::ops::Range;
use std::sync::Arc;

impl HostFormat for vk::Format {
    const POSITIONS: [(Self, Encoding); 3] = [
        (vk::Format::R32G32B32_SFLOAT, Encoding::F32),
        (vk::Format::R16G16B16A16_SFLOAT, Encoding::F16x4),
        (vk::Format::R16G16B16A16_SNORM, Encoding::Snorm16x4),
    ];
    const NORMALS: [(Self, Encoding); 4] = [
        (vk::Format::R32G32B32_SFLOAT, Encoding::F32),
        (vk::Format::R16G16B16A16_SNORM, Encoding::Snorm16x4),
        (vk::Format::R8G8B8A8_SNORM, Encoding::Snorm8x4),
        (vk::Format::R16G16_UNORM, Encoding::Octahedral16x2),
    ];
    const TANGENTS: [(Self, Encoding); 4] = [
        (vk::Format::R32G32B32A32_SFLOAT, Encoding::F32),
        (vk::Format::R16G16B16A16_SNORM, Encoding::Snorm16x4),
        (vk::Format::R8G8B8A8_SNORM, Encoding::Snorm8x4),
        (vk::Format::R16G16_UNORM, Encoding::Octahedral16x2),
    ];
}

/// Where a buffer stores one attribute of the vertices.
pub type Stream = VertexStream<vk::Format>;

/// Where a buffer stores the vertices of one mesh.
pub type TargetDef = gpu::TargetDef<BufferId, vk::Format>;

/// A mesh's vertices in a buffer, and what they show. Drop it to end it.
#[derive(Debug)]
pub struct Target {
    pub(super) state: TargetState,
    pub(crate) handle: vk::Buffer,
    pub(super) buffer: BufferId,
    /// Index of its window of the buffer.
    pub(super) window: usize,
    /// States of the vertices, for an instance with a classic rule.
    pub(super) classic: Option<Arc<ClassicBuffer>>,
    /// The last frame that writes it.
    pub(super) written_in: u64,
}

impl Target {
    /// Forgets what the memory holds, so that the next recording writes every vertex. Call it if anyone else wrote to the memory, or
    /// if a recording was not submitted.
    pub fn invalidate(&mut self) {
        self.state.tracker.invalidate();
    }

    /// A box around all vertices as of the last recording, m; `None` before the first. It may be too large, since the CPU only knows
    /// how far each block can have moved, but never too small.
    pub fn bounds(&self) -> Option<Aabb> {
        self.state.tracker.bounds()
    }

    /// The last frame with a recording that writes it, or 0.
    pub fn written_in(&self) -> u64 {
        self.written_in
    }

    /// Vertices that the last recording wrote, as increasing ranges with gaps between them.
    pub fn changed(&self) -> &[Range<u32>] {
        self.state.tracker.changed()
    }
}

/// The part of a host's buffer that a dispatch writes. Ids of one VkBuffer lie side by side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct TargetBinding {
    pub handle: vk::Buffer,
    pub buffer: BufferId,
    pub window: usize,
}

impl PlanTarget for Target {
    type Binding = TargetBinding;

    fn binding(&self) -> TargetBinding {
        TargetBinding { handle: self.handle, buffer: self.buffer, window: self.window }
    }

    fn state(&self) -> &TargetState {
        &self.state
    }

    fn state_mut(&mut self) -> &mut TargetState {
        &mut self.state
    }
}
