//! The host's buffers, and where in them vertices lie.

use super::classic::ClassicBuffer;
use super::device::{Device, VulkanDevice};
use super::pipelines::{DescriptorSet, VulkanPipelines};
use crate::example::set::ExampleSet;
use crate::gpu::{self, Encoding, HostFormat, TargetState, VertexStream, binding_range};
use crate::{Aabb, Error, Tracker};
use ash::vk::{self, Handle};
use std::ops::Range;
use std::sync::Arc;

/// Who accesses a buffer before or after us.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Access {
    /// In which stages; at least one.
    pub stages: vk::PipelineStageFlags,
    /// How; nothing where the order alone matters.
    pub access: vk::AccessFlags,
}

impl Access {
    /// Vertex fetch: what most vertex buffers are for.
    pub const VERTEX_INPUT: Access =
        Access { stages: vk::PipelineStageFlags::VERTEX_INPUT, access: vk::AccessFlags::VERTEX_ATTRIBUTE_READ };
}

/// A VkBuffer of the host that vertices are written to.
#[derive(Debug, Clone, Copy)]
pub struct BufferDef {
    /// The buffer, bound to memory, made with `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT`.
    pub buffer: vk::Buffer,
    /// Its size, bytes.
    pub size: u64,
    /// The usage that it was made with.
    pub usage: vk::BufferUsageFlags,
    /// The family that owns it before and after what is recorded, where that is another than the device's: each recording that
    /// names one of its targets then begins with an acquire and ends with a release of the whole buffer, even where nothing
    /// changed; the release and acquire of that other family are the host's. `QUEUE_FAMILY_IGNORED` otherwise.
    pub queue_family: u32,
    /// What the host does with it before each recording. What it wrote itself is only kept where it says so here.
    pub before: Access,
    /// What the host does with it next.
    pub after: Access,
}

impl BufferDef {
    /// Whether another description is of the same buffer.
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

/// A buffer as the device knows it. Stale ids are refused, never mistaken.
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

/// A mesh's vertices in a buffer, and what they show. Dropping it is how it ends.
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
    /// Forgets what the memory holds: the next recording writes every vertex. For memory that others wrote to, and for
    /// recordings that were not submitted.
    pub fn invalidate(&mut self) {
        self.state.tracker.invalidate();
    }

    /// Whether normals and tangents are written.
    pub(crate) fn written(&self) -> (bool, bool) {
        (self.state.layout.normals.is_some(), self.state.layout.tangents.is_some())
    }

    /// A box around all vertices as of the last recording, m; `None` before the first. It is never too small but may be too
    /// large: the CPU does not know the vertices, only how far each block of them can have moved.
    pub fn bounds(&self) -> Option<Aabb> {
        self.state.tracker.bounds()
    }

    /// The last frame for which anything was recorded that writes it; 0 for none.
    pub fn written_in(&self) -> u64 {
        self.written_in
    }

    /// Vertices that the last recording wrote: ranges, increasing, apart from each other.
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

/// A part of a buffer, no larger than a descriptor may cover.
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
    /// Registers a buffer of the host. It may be that of any number of targets, and any number of buffers may be registered;
    /// all targets in one buffer are written by one dispatch.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a null buffer, a size of 0, a usage without `STORAGE_BUFFER`, or an access without stages.
    ///
    /// # Safety
    /// The buffer is one of this device, bound to memory, of this size and usage, and lives until it is removed and all frames
    /// that wrote it are done.
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

    /// Forgets a buffer. Its targets are of no more use. The host may destroy it once the frames that wrote it are done.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a buffer that is not there.
    pub fn remove_buffer(&mut self, id: BufferId) -> Result<(), Error> {
        self.hosts.get(id)?;
        let Some(host) = self.hosts.entries[id.index as usize].1.take() else { return Err(stale(id)) };
        self.garbage.extend(host.windows.into_iter().map(|w| (host.used, w.set)));
        Ok(())
    }

    /// Says where in a buffer vertices of one of the set's meshes lie. The first target of a mesh gets its vertices and examples
    /// into memory of the device: they are copied into a staging buffer now, and from there by the next recording.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a buffer that is not there, a format that an attribute cannot have, a stride that is too
    /// small, attributes that overlap, or a scale that is none; [`Error::Misaligned`] for offsets and strides that are not
    /// multiples of 4; [`Error::BufferTooSmall`]; [`Error::IndexOutOfRange`] for a level of detail that is not there;
    /// [`Error::Unsupported`] for normals or tangents that the mesh does not have, or more bytes than the device can bind;
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
    /// A window that holds these bytes.
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
