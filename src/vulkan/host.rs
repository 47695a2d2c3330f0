//! The host's buffers and the targets in them.

use super::classic::ClassicBuffer;
use super::device::{Device, VulkanDevice};
use super::pipelines::{DescriptorSet, VulkanPipelines};
use crate::example::set::ExampleSet;
use crate::gpu::{self, Encoding, HostFormat, TargetState, VertexStream, binding_range};
use crate::{Aabb, Error, Tracker};
use ash::vk::{self, Handle};
use std::ops::Range;
use std::sync::Arc;

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

/// The id of a registered buffer. A stale id is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BufferId {
    index: u32,
    generation: u32,
}

impl HostFormat for vk::Format {
    const POSITIONS: [(Self, Encoding); 3] = [
        (vk::Format::R32G32B32_SFLOAT, Encoding::F32),
        (vk::Format::R16G16B16A16_SFLOAT, Encoding::F16x4),
        (vk::Format::R16G16B16A16_SNORM, Encoding::Snorm16x4),
    ];
    const NORMALS: [(Self, Encoding); 3] = [
        (vk::Format::R32G32B32_SFLOAT, Encoding::F32),
        (vk::Format::R16G16B16A16_SNORM, Encoding::Snorm16x4),
        (vk::Format::R8G8B8A8_SNORM, Encoding::Snorm8x4),
    ];
    const TANGENTS: [(Self, Encoding); 3] = [
        (vk::Format::R32G32B32A32_SFLOAT, Encoding::F32),
        (vk::Format::R16G16B16A16_SNORM, Encoding::Snorm16x4),
        (vk::Format::R8G8B8A8_SNORM, Encoding::Snorm8x4),
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
    pub(super) handle: vk::Buffer,
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

    /// Whether normals and tangents are written.
    pub(crate) fn written(&self) -> (bool, bool) {
        (self.state.layout.normals.is_some(), self.state.layout.tangents.is_some())
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

#[derive(Default)]
pub(super) struct HostBuffers {
    entries: Vec<(u32, Option<HostBuffer>)>,
}

impl HostBuffers {
    pub(super) fn get(&self, id: BufferId) -> Result<&HostBuffer, Error> {
        let entry = self.entries.get(id.index as usize).filter(|(generation, _)| *generation == id.generation);
        entry.and_then(|(_, host)| host.as_ref()).ok_or_else(|| stale(id))
    }

    pub(super) fn get_mut(&mut self, id: BufferId) -> Result<&mut HostBuffer, Error> {
        let entry = self.entries.get_mut(id.index as usize).filter(|(generation, _)| *generation == id.generation);
        entry.and_then(|(_, host)| host.as_mut()).ok_or_else(|| stale(id))
    }

    pub(super) fn sets(&self) -> impl Iterator<Item = &DescriptorSet> {
        self.entries.iter().filter_map(|(_, host)| host.as_ref()).flat_map(|h| h.windows.iter().map(|w| &w.set))
    }
}

fn stale(id: BufferId) -> Error {
    let value = format!("{}, generation {}", id.index, id.generation);
    Error::invalid("buffer", value, "one of this device that was not removed")
}

impl Device {
    /// Registers a buffer of the host. It may hold any number of targets; one dispatch writes all targets in one buffer.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a null buffer, a size of 0, a usage without `STORAGE_BUFFER`, or an access without stages.
    ///
    /// # Safety
    /// The buffer belongs to this device, is bound to memory, and has this size and usage. It lives until it is removed and all
    /// frames that wrote it are done.
    pub unsafe fn add_buffer(&mut self, def: &BufferDef) -> Result<BufferId, Error> {
        if def.buffer.is_null() {
            return Err(Error::invalid("the VkBuffer", "null", "a valid handle"));
        }
        if def.size < 4 {
            return Err(Error::invalid("the buffer's size", def.size, "at least 4 bytes"));
        }
        if !def.usage.contains(vk::BufferUsageFlags::STORAGE_BUFFER) {
            let value = format!("{:?}", def.usage);
            return Err(Error::invalid("the buffer's usage", value, "with STORAGE_BUFFER among its flags"));
        }
        for (name, access) in [("the stages before", def.before), ("the stages after", def.after)] {
            if access.stages.is_empty() {
                return Err(Error::invalid(
                    name,
                    "none",
                    "at least one stage (TOP_OF_PIPE or BOTTOM_OF_PIPE for none)",
                ));
            }
        }
        let host = HostBuffer { def: *def, windows: Vec::new(), used: 0 };
        let entries = &mut self.hosts.entries;
        let index = entries.iter().position(|(_, host)| host.is_none()).unwrap_or(entries.len());
        if index == entries.len() {
            entries.push((0, None));
        }
        let (generation, entry) = &mut entries[index];
        *generation += 1;
        *entry = Some(host);
        Ok(BufferId { index: index as u32, generation: *generation })
    }

    /// Removes a buffer. Its targets can no longer be recorded. The host may destroy it once the frames that wrote it are done.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a stale id.
    pub fn remove_buffer(&mut self, id: BufferId) -> Result<(), Error> {
        self.hosts.get(id)?;
        let Some(host) = self.hosts.entries[id.index as usize].1.take() else { return Err(stale(id)) };
        self.garbage.extend(host.windows.into_iter().map(|w| (host.used, w.set)));
        Ok(())
    }

    /// Adds a target: a place for the vertices of one of the set's meshes. The first target of a mesh copies the mesh and its
    /// examples into a staging buffer; the next recording copies them to the device.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a stale buffer, a format that the attribute cannot have, a stride that is too small, attributes
    /// that overlap, or a bad scale; [`Error::Misaligned`] for offsets and strides that are not multiples of 4;
    /// [`Error::BufferTooSmall`]; [`Error::IndexOutOfRange`] for a level of detail that the set lacks; [`Error::Unsupported`] for
    /// normals or tangents that the mesh lacks, or more bytes than the device can bind;
    /// [`Error::OutOfMemory`], [`Error::Vulkan`], [`Error::DeviceLost`].
    pub fn add_target(&mut self, set: &Arc<ExampleSet>, def: &TargetDef) -> Result<Target, Error> {
        let mesh = set.lod(def.lod)?;
        let size = self.hosts.get(def.buffer)?.def.size;
        let (layout, kernel, written) = def.layout(&mesh.mesh, size)?;
        let limits = self.gpu.binding_limits();
        let host = self.hosts.get_mut(def.buffer)?;
        let window = host.window(&self.gpu, &self.pipelines, &written)?;
        let (handle, first) = (host.def.buffer, def.offset.wrapping_sub(host.windows[window].range.start));
        self.gpu.add_pipeline(&mut self.pipelines, kernel, false)?;
        let mesh = self.arena.mesh(&self.gpu, &limits, set, def.lod)?;
        let (device, set, tracker) = (self.id, Arc::downgrade(set), Tracker::new());
        let state = TargetState { device, set, lod: def.lod, kernel, layout, first, mesh, tracker };
        Ok(Target { state, handle, buffer: def.buffer, window, classic: None, written_in: 0 })
    }
}

impl HostBuffer {
    /// Returns the index of a window that holds these bytes.
    fn window(&mut self, gpu: &VulkanDevice, pipelines: &VulkanPipelines, bytes: &Range<u64>) -> Result<usize, Error> {
        let holds = |r: &Range<u64>| r.start <= bytes.start && bytes.end <= r.end;
        if let Some(index) = self.windows.iter().position(|w| holds(&w.range)) {
            return Ok(index);
        }
        let range = binding_range(self.def.size, bytes, &gpu.binding_limits())?;
        let set = gpu.set(pipelines, &[(self.def.buffer, range.start, range.end - range.start)])?;
        self.windows.push(BufferWindow { range, set });
        Ok(self.windows.len() - 1)
    }
}
