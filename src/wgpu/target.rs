//! Where in the host's buffers vertices lie.

use super::arena::Home;
use super::device::{Device, Gpu};
use super::kernels::Kernels;
use crate::example::set::ExampleSet;
use crate::gpu::{self, Encoding, Kernel, Layout};
use crate::{Aabb, Error, Tracker};
use std::num::NonZero;
use std::ops::Range;
use std::sync::{Arc, Weak};

/// Where the values of an attribute lie in a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stream {
    /// Bytes from the target's offset to the first vertex's value; a multiple of 4.
    pub offset: u64,
    /// Bytes from one vertex's value to the next; a multiple of 4, no smaller than a value.
    pub stride: u64,
    /// `Float32x3` for positions and normals, `Float32x4` for tangents; `Float16x4` for positions (the fourth is 1);
    /// `Snorm16x4` for all, `Snorm8x4` for normals and tangents (a normal's fourth is 0).
    pub format: wgpu::VertexFormat,
}

/// Where the vertices of one mesh lie.
#[derive(Debug, Clone, Copy)]
pub struct TargetDef<'a> {
    /// The mesh: 0 is the set's own, then its levels of detail.
    pub lod: usize,
    /// The buffer, of the same device, made with [`wgpu::BufferUsages::STORAGE`]; of a buffer of another device wgpu tells, but
    /// never mix those of two instances: it cannot tell them apart. It may be that of any number of targets; all
    /// targets in one buffer are written by one dispatch. It lives as long as any of its targets.
    pub buffer: &'a wgpu::Buffer,
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
    /// Of positions in `Snorm16x4`: a stored number s stands for `s * scale + bias`, m, s from -1 to 1. What lies outside is
    /// held at the border, so take bounds grown by the depth limit. Scales are above 0.
    pub scale: [f32; 3],
    /// See `scale`; m.
    pub bias: [f32; 3],
}

impl<'a> TargetDef<'a> {
    /// Positions alone, three floats each, one behind the other, from `offset` on.
    pub fn positions(buffer: &'a wgpu::Buffer, offset: u64, size: u64) -> Self {
        let positions = Stream { offset: 0, stride: 12, format: wgpu::VertexFormat::Float32x3 };
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
    pub(super) offset: u64,
    pub(super) size: u64,
    pub(super) kernel: Kernel,
    pub(super) layout: Layout,
    pub(super) window: Arc<Window>,
    /// Bytes before it in the window, modulo 2^64: what is not written may begin before.
    pub(super) first: u64,
    pub(super) home: Arc<Home>,
    /// What a classic rule keeps of each vertex.
    pub(super) state: Option<wgpu::BindGroup>,
    pub(super) tracker: Tracker,
}

impl Target {
    /// Forgets what the memory holds: the next encoding writes every vertex. For memory that others wrote to, and for
    /// encodings that were not submitted.
    pub fn invalidate(&mut self) {
        self.tracker.invalidate();
    }

    /// A box around all vertices as of the last encoding, m; `None` before the first. It is never too small but may be too
    /// large: the CPU does not know the vertices, only how far each block of them can have moved.
    pub fn bounds(&self) -> Option<Aabb> {
        self.tracker.bounds()
    }

    /// Vertices that the last encoding wrote: ranges, increasing, apart from each other.
    pub fn changed(&self) -> &[Range<u32>] {
        self.tracker.changed()
    }

    /// The buffer that it is in.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.window.buffer
    }
}

/// A part of a host's buffer, no larger than what can be bound.
#[derive(Debug)]
pub(super) struct Window {
    pub id: u64,
    buffer: wgpu::Buffer,
    range: Range<u64>,
    pub group: wgpu::BindGroup,
}

/// Those that targets have.
#[derive(Default)]
pub(super) struct Windows {
    all: Vec<Weak<Window>>,
    made: u64,
}

impl Windows {
    /// A window of the buffer that holds these bytes.
    fn window(
        &mut self,
        (gpu, kernels): (&Gpu, &Kernels),
        buffer: &wgpu::Buffer,
        bytes: &Range<u64>,
    ) -> Result<Arc<Window>, Error> {
        self.all.retain(|w| w.strong_count() > 0);
        let holds = |r: &Range<u64>| r.start <= bytes.start && bytes.end <= r.end;
        let mut alive = self.all.iter().filter_map(Weak::upgrade);
        if let Some(window) = alive.find(|w| w.buffer == *buffer && holds(&w.range)) {
            return Ok(window);
        }
        let (size, most) = (buffer.size() & !3, gpu.most_bound());
        let align = u64::from(gpu.limits.min_storage_buffer_offset_alignment.max(4));
        let start = if size <= most { 0 } else { bytes.start - bytes.start % align };
        let range = start..start + (size - start).min(most);
        if !holds(&range) {
            let what = format!(
                "a target that spans {} bytes; max_storage_buffer_binding_size is {most} on this device",
                bytes.end - bytes.start
            );
            return Err(Error::Unsupported { what });
        }
        let bound = wgpu::BufferBinding { buffer, offset: start, size: NonZero::new(range.end - start) };
        let group = gpu.bind_group(&kernels.one, &[bound])?;
        self.made += 1;
        let window = Arc::new(Window { id: self.made, buffer: buffer.clone(), range, group });
        self.all.push(Arc::downgrade(&window));
        Ok(window)
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
        self.heard()?;
        let skin = set.lod(def.lod)?;
        let layout = layout(def)?;
        let usage = def.buffer.usage();
        if !usage.contains(wgpu::BufferUsages::STORAGE) {
            let value = format!("{usage:?}");
            return Err(Error::invalid("the buffer's usage", value, "with STORAGE among its flags"));
        }
        if !def.offset.is_multiple_of(4) {
            return Err(Error::Misaligned { name: "the target's offset".into(), value: def.offset, align: 4 });
        }
        let (size, needed) = (def.buffer.size() & !3, def.offset.saturating_add(def.size));
        if needed > size {
            return Err(Error::BufferTooSmall { name: "the buffer".into(), size, needed });
        }
        let kernel = Kernel::of(&layout, &skin.mesh)?;
        let (low, high) = layout.check(skin.vertex_count(), def.size)?;
        let written = def.offset + low..def.offset + high;
        let window = self.windows.window((&self.gpu, &self.kernels), def.buffer, &written)?;
        let first = def.offset.wrapping_sub(window.range.start);
        let home = self.arena.home(&self.gpu, set, def.lod)?;
        Ok(Target {
            device: self.id,
            set: Arc::downgrade(set),
            lod: def.lod,
            offset: def.offset,
            size: def.size,
            kernel,
            layout,
            window,
            first,
            home,
            state: None,
            tracker: Tracker::new(),
        })
    }
}

fn layout(def: &TargetDef<'_>) -> Result<Layout, Error> {
    use wgpu::VertexFormat::{Float16x4, Float32x3, Float32x4, Snorm8x4, Snorm16x4};
    let stream = |name: &str, s: &Stream, allowed: &[(wgpu::VertexFormat, Encoding)]| {
        gpu::stream(name, (s.offset, s.stride, s.format), allowed)
    };
    let packed = [(Snorm16x4, Encoding::Snorm16x4), (Snorm8x4, Encoding::Snorm8x4)];
    let of_positions = [(Float32x3, Encoding::F32), (Float16x4, Encoding::F16x4), packed[0]];
    let of_normals = [(Float32x3, Encoding::F32), packed[0], packed[1]];
    let of_tangents = [(Float32x4, Encoding::F32), packed[0], packed[1]];
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
