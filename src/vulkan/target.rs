//! A target: the place of a mesh's vertices in a buffer of the host.

use super::host_buffers::BufferId;
use crate::gpu::{self, Attribute, Encoding, HostFormat, VertexStream};
use ash::vk;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

impl HostFormat for vk::Format {
    fn of(attribute: Attribute, encoding: Encoding) -> Self {
        match encoding {
            Encoding::F32 if attribute == Attribute::Tangent => vk::Format::R32G32B32A32_SFLOAT,
            Encoding::F32 => vk::Format::R32G32B32_SFLOAT,
            Encoding::F16x4 => vk::Format::R16G16B16A16_SFLOAT,
            Encoding::Snorm16x4 => vk::Format::R16G16B16A16_SNORM,
            Encoding::Snorm8x4 => vk::Format::R8G8B8A8_SNORM,
            Encoding::Octahedral16x2 => vk::Format::R16G16_UNORM,
        }
    }
}

/// Where a buffer stores one attribute of the vertices.
pub type Stream = VertexStream<vk::Format>;

/// Where a buffer stores the vertices of one mesh.
pub type TargetDef = gpu::TargetDef<BufferId, vk::Format>;

/// A mesh's vertices in a buffer, and what they show. Drop it to end it.
pub type Target = gpu::Target<TargetBinding, Arc<ClassicState>>;

impl Target {
    /// The last frame with a recording that writes it, or 0.
    pub fn written_in(&self) -> u64 {
        self.state.written_in
    }
}

/// The part of a host's buffer that a dispatch writes. Ids of one VkBuffer lie side by side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct TargetBinding {
    pub(crate) handle: vk::Buffer,
    pub(super) buffer: BufferId,
    /// Index of its window of the buffer.
    pub(super) window: usize,
}

/// The buffer with the states of one target's vertices under a classic rule. The device owns it.
#[derive(Debug)]
pub struct ClassicState {
    pub(super) buffer: vk::Buffer,
    pub(super) set: vk::DescriptorSet,
    /// The last frame that uses it, or 0.
    pub(super) last_frame: AtomicU64,
}
