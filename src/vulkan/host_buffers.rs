//! The buffers that the host registered, and the windows of them that descriptor sets cover.

use super::pipelines::{DescriptorSet, VulkanPipelines};
use crate::base::error::Error;
use crate::gpu::{BindingLimits, binding_range};
use ash::vk;
use std::collections::BTreeMap;
use std::ops::Range;

/// An access to a buffer before or after the recorded commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Access {
    /// The stages; at least one.
    pub stages: vk::PipelineStageFlags,
    /// The kinds of access. It may be empty if only the order matters.
    pub access: vk::AccessFlags,
}

impl Access {
    /// Vertex fetch, the use of most vertex buffers.
    pub const VERTEX_INPUT: Access =
        Access { stages: vk::PipelineStageFlags::VERTEX_INPUT, access: vk::AccessFlags::VERTEX_ATTRIBUTE_READ };
}

/// A VkBuffer of the host for vertices.
#[derive(Debug, Clone, Copy)]
pub struct BufferDef {
    /// The buffer, bound to memory, made with `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT`.
    pub buffer: vk::Buffer,
    /// Its size in bytes.
    pub size: u64,
    /// The usage that it was made with.
    pub usage: vk::BufferUsageFlags,
    /// The family that owns it before and after the recorded commands, if that is not the device's, else `QUEUE_FAMILY_IGNORED`.
    /// Each recording that names one of its targets then begins with an acquire and ends with a release of the whole buffer, even
    /// if nothing changed. The host does the release and the acquire on the other family.
    pub queue_family: u32,
    /// The host's access before each recording. List the host's own writes here, or they may be lost.
    pub before: Access,
    /// The host's next access.
    pub after: Access,
}

#[cfg(feature = "capi")]
impl BufferDef {
    /// Fails if another definition of the same buffer differs.
    pub(crate) fn same(&self, other: &BufferDef) -> Result<(), Error> {
        let differs = |name: &str, was: String, is: String| -> Result<(), Error> {
            if was == is { Ok(()) } else { Err(Error::invalid(name, is, &format!("{was}, as for its other ranges"))) }
        };
        differs("the buffer's size", self.size.to_string(), other.size.to_string())?;
        differs("the buffer's usage", format!("{:?}", self.usage), format!("{:?}", other.usage))?;
        differs("the buffer's queue family", self.queue_family.to_string(), other.queue_family.to_string())?;
        differs("before", format!("{:?}", self.before), format!("{:?}", other.before))?;
        differs("after", format!("{:?}", self.after), format!("{:?}", other.after))
    }
}

/// The id of a registered buffer. No id is used twice; that of a removed buffer is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BufferId(u64);

/// A registered buffer.
pub(super) struct HostBuffer {
    pub def: BufferDef,
    pub windows: Vec<BufferWindow>,
    /// The last frame that writes it.
    pub used: u64,
}

/// A range of a buffer that a descriptor can cover.
pub(super) struct BufferWindow {
    pub range: Range<u64>,
    pub set: DescriptorSet,
}

/// All registered buffers.
#[derive(Default)]
pub(super) struct HostBuffers {
    all: BTreeMap<BufferId, HostBuffer>,
    last: u64,
}

impl HostBuffers {
    /// Adds a checked definition.
    pub(super) fn add(&mut self, def: &BufferDef) -> BufferId {
        self.last += 1;
        self.all.insert(BufferId(self.last), HostBuffer { def: *def, windows: Vec::new(), used: 0 });
        BufferId(self.last)
    }

    pub(super) fn remove(&mut self, id: BufferId) -> Result<HostBuffer, Error> {
        self.all.remove(&id).ok_or_else(|| stale(id))
    }

    pub(super) fn get(&self, id: BufferId) -> Result<&HostBuffer, Error> {
        self.all.get(&id).ok_or_else(|| stale(id))
    }

    pub(super) fn get_mut(&mut self, id: BufferId) -> Result<&mut HostBuffer, Error> {
        self.all.get_mut(&id).ok_or_else(|| stale(id))
    }
}

fn stale(id: BufferId) -> Error {
    Error::invalid("buffer", format!("number {}", id.0), "one of this device that was not removed")
}

impl HostBuffer {
    /// Returns the index of a window that holds these bytes.
    pub(super) fn window(
        &mut self,
        pipelines: &VulkanPipelines,
        limits: &BindingLimits,
        bytes: &Range<u64>,
    ) -> Result<usize, Error> {
        let holds = |r: &Range<u64>| r.start <= bytes.start && bytes.end <= r.end;
        if let Some(index) = self.windows.iter().position(|w| holds(&w.range)) {
            return Ok(index);
        }
        let range = binding_range(self.def.size, bytes, limits)?;
        let set = pipelines.set(&[(self.def.buffer, range.start, range.end - range.start)])?;
        self.windows.push(BufferWindow { range, set });
        Ok(self.windows.len() - 1)
    }
}
