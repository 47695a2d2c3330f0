//! The host's buffers, and where in them vertices lie.

use super::arena::Home;
use super::device::{Device, Gpu};
use super::kernels::{Kernels, Set};
use super::state::State;
use crate::example::set::ExampleSet;
use crate::gpu::{self, Encoding, Kernel, Layout};
use crate::{Aabb, Error, Tracker};
use ash::vk::{self, Handle};
use std::ops::Range;
use std::sync::{Arc, Weak};

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

/// Where the values of an attribute lie in a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stream {
    /// Bytes from the target's offset to the first vertex's value; a multiple of 4.
    pub offset: u64,
    /// Bytes from one vertex's value to the next; a multiple of 4, no smaller than a value.
    pub stride: u64,
    /// `R32G32B32_SFLOAT` for positions and normals, `R32G32B32A32_SFLOAT` for tangents; `R16G16B16A16_SFLOAT` for positions
    /// (the fourth is 1); `R16G16B16A16_SNORM` for all, `R8G8B8A8_SNORM` for normals and tangents (a normal's fourth is 0).
    pub format: vk::Format,
}

/// Where the vertices of one mesh lie.
#[derive(Debug, Clone, Copy)]
pub struct TargetDef {
    /// The mesh: 0 is the set's own, then its levels of detail.
    pub lod: usize,
    /// The buffer.
    pub buffer: BufferId,
    /// Bytes before the target; a multiple of 4.
    pub offset: u64,
    /// Bytes of the target: nothing outside is written. Ranges of targets may interleave, values must not overlap.
    pub size: u64,
    /// Positions, m.
    pub positions: Stream,
    /// Unit normals, where they are wanted.
    pub normals: Option<Stream>,
    /// Tangents, where they are wanted; the fourth number is the base tangent's.
    pub tangents: Option<Stream>,
    /// Of positions in `R16G16B16A16_SNORM`: a stored number s stands for `s * scale + bias`, m, s from -1 to 1. What lies
    /// outside is held at the border, so take bounds grown by the depth limit. Scales are above 0.
    pub scale: [f32; 3],
    /// See `scale`; m.
    pub bias: [f32; 3],
}

impl TargetDef {
    /// Positions alone, three floats each, one behind the other, from `offset` on.
    pub fn positions(buffer: BufferId, offset: u64, size: u64) -> Self {
        let positions = Stream { offset: 0, stride: 12, format: vk::Format::R32G32B32_SFLOAT };
        let (normals, tangents) = (None, None);
        let (scale, bias) = ([1.0; 3], [0.0; 3]);
        TargetDef { lod: 0, buffer, offset, size, positions, normals, tangents, scale, bias }
    }
}

/// A mesh's vertices in a buffer, and what they show. Dropping it is how it ends.
#[derive(Debug)]
pub struct Target {
    pub(super) device: u64,
    pub(super) set: Weak<ExampleSet>,
    pub(super) lod: usize,
    pub(super) buffer: BufferId,
    pub(super) window: usize,
    pub(super) kernel: Kernel,
    pub(super) layout: Layout,
    /// Bytes before it in the window, modulo 2^64: what is not written may begin before.
    pub(super) first: u64,
    pub(super) home: Arc<Home>,
    /// Of an instance with a classic rule.
    pub(super) state: Option<Arc<State>>,
    pub(super) tracker: Tracker,
    /// The last frame that writes it.
    pub(super) written_in: u64,
}

impl Target {
    /// Forgets what the memory holds: the next recording writes every vertex. For memory that others wrote to, and for
    /// recordings that were not submitted.
    pub fn invalidate(&mut self) {
        self.tracker.invalidate();
    }

    /// Whether normals and tangents are written.
    pub(crate) fn written(&self) -> (bool, bool) {
        (self.layout.normals.is_some(), self.layout.tangents.is_some())
    }

    /// A box around all vertices as of the last recording, m; `None` before the first. It is never too small but may be too
    /// large: the CPU does not know the vertices, only how far each block of them can have moved.
    pub fn bounds(&self) -> Option<Aabb> {
        self.tracker.bounds()
    }

    /// The last frame for which anything was recorded that writes it; 0 for none.
    pub fn written_in(&self) -> u64 {
        self.written_in
    }

    /// Vertices that the last recording wrote: ranges, increasing, apart from each other.
    pub fn changed(&self) -> &[Range<u32>] {
        self.tracker.changed()
    }
}

/// A registered buffer.
pub(super) struct Host {
    pub def: BufferDef,
    pub windows: Vec<Window>,
    /// The last frame that writes it.
    pub used: u64,
}

/// A part of a buffer, no larger than a descriptor may cover.
pub(super) struct Window {
    pub range: Range<u64>,
    pub set: Set,
}

#[derive(Default)]
pub(super) struct Hosts {
    entries: Vec<(u32, Option<Host>)>,
}

impl Hosts {
    pub(super) fn get(&self, id: BufferId) -> Result<&Host, Error> {
        let entry = self.entries.get(id.index as usize).filter(|(generation, _)| *generation == id.generation);
        entry.and_then(|(_, host)| host.as_ref()).ok_or_else(|| stale(id))
    }

    pub(super) fn get_mut(&mut self, id: BufferId) -> Result<&mut Host, Error> {
        let entry = self.entries.get_mut(id.index as usize).filter(|(generation, _)| *generation == id.generation);
        entry.and_then(|(_, host)| host.as_mut()).ok_or_else(|| stale(id))
    }

    pub(super) fn sets(&self) -> impl Iterator<Item = &Set> {
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
        let host = Host { def: *def, windows: Vec::new(), used: 0 };
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
        let skin = set.lod(def.lod)?;
        let layout = layout(def)?;
        let size = self.hosts.get(def.buffer)?.def.size;
        if !def.offset.is_multiple_of(4) {
            return Err(Error::Misaligned { name: "the target's offset".into(), value: def.offset, align: 4 });
        }
        let needed = def.offset.saturating_add(def.size);
        if needed > size {
            return Err(Error::BufferTooSmall { name: "the buffer".into(), size, needed });
        }
        let kernel = Kernel::of(&layout, &skin.mesh)?;
        let (low, high) = layout.check(skin.vertex_count(), def.size)?;
        let written = def.offset + low..def.offset + high;
        let host = self.hosts.get_mut(def.buffer)?;
        let window = host.window(&self.gpu, &self.kernels, &written)?;
        let first = def.offset.wrapping_sub(host.windows[window].range.start);
        self.gpu.add_pipeline(&mut self.kernels, kernel, false)?;
        let home = self.arena.home(&self.gpu, set, def.lod)?;
        Ok(Target {
            device: self.id,
            set: Arc::downgrade(set),
            lod: def.lod,
            buffer: def.buffer,
            window,
            kernel,
            layout,
            first,
            home,
            state: None,
            tracker: Tracker::new(),
            written_in: 0,
        })
    }
}

impl Host {
    /// A window that holds these bytes.
    fn window(&mut self, gpu: &Gpu, kernels: &Kernels, bytes: &Range<u64>) -> Result<usize, Error> {
        let holds = |r: &Range<u64>| r.start <= bytes.start && bytes.end <= r.end;
        if let Some(index) = self.windows.iter().position(|w| holds(&w.range)) {
            return Ok(index);
        }
        let most = u64::from(gpu.limits.max_storage_buffer_range);
        let start = if self.def.size <= most {
            0
        } else {
            bytes.start - bytes.start % gpu.limits.min_storage_buffer_offset_alignment.max(4)
        };
        let range = start..start + ((self.def.size - start).min(most) & !3);
        if !holds(&range) {
            let what = format!(
                "a target that spans {} bytes; maxStorageBufferRange is {most} on this device",
                bytes.end - bytes.start
            );
            return Err(Error::Unsupported { what });
        }
        let set = gpu.set(kernels, &[(self.def.buffer, range.start, range.end - range.start)])?;
        self.windows.push(Window { range, set });
        Ok(self.windows.len() - 1)
    }
}

fn layout(def: &TargetDef) -> Result<Layout, Error> {
    use vk::Format;
    let stream = |name: &str, s: &Stream, allowed: &[(Format, Encoding)]| {
        gpu::stream(name, (s.offset, s.stride, s.format), allowed)
    };
    let (half, snorm16) = (Format::R16G16B16A16_SFLOAT, Format::R16G16B16A16_SNORM);
    let packed = [(snorm16, Encoding::Snorm16x4), (Format::R8G8B8A8_SNORM, Encoding::Snorm8x4)];
    let floats = |format| (format, Encoding::F32);
    let of_positions = [floats(Format::R32G32B32_SFLOAT), (half, Encoding::F16x4), (snorm16, Encoding::Snorm16x4)];
    let of_normals = [floats(Format::R32G32B32_SFLOAT), packed[0], packed[1]];
    let of_tangents = [floats(Format::R32G32B32A32_SFLOAT), packed[0], packed[1]];
    let positions = stream("position", &def.positions, &of_positions)?;
    gpu::check_scale(&positions, def.scale, def.bias)?;
    Ok(Layout {
        positions,
        normals: def.normals.as_ref().map(|s| stream("normal", s, &of_normals)).transpose()?,
        tangents: def.tangents.as_ref().map(|s| stream("tangent", s, &of_tangents)).transpose()?,
        scale: def.scale,
        bias: def.bias,
    })
}
