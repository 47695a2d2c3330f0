//! Where a host's buffer stores the vertices of a mesh: definition and checks.

use super::format::Attribute;
use super::kernel::{Case, Kernel, Variant};
use super::limits::BindingLimits;
use crate::base::error::Error;
use crate::base::strided::Strided;
use crate::deform::Encoding;
use crate::mesh::Mesh;
use std::fmt::Debug;
use std::ops::Range;

/// Where a buffer stores one attribute of the vertices. `F` is the graphics interface's vertex format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VertexStream<F> {
    /// Bytes from the target's offset to the first vertex's value; a multiple of 4.
    pub offset: u64,
    /// Bytes from one vertex's value to the next; a multiple of 4, at least the size of a value.
    pub stride: u64,
    /// The format of a value. Each attribute takes these formats:
    ///
    /// | attribute | Vulkan | wgpu |
    /// |---|---|---|
    /// | position | `R32G32B32_SFLOAT`, `R16G16B16A16_SFLOAT`, `R16G16B16A16_SNORM` | `Float32x3`, `Float16x4`, `Snorm16x4` |
    /// | normal | `R32G32B32_SFLOAT`, `R16G16B16A16_SNORM`, `R8G8B8A8_SNORM`, `R16G16_UNORM` | `Float32x3`, `Snorm16x4`, `Snorm8x4`, `Unorm16x2` |
    /// | tangent | `R32G32B32A32_SFLOAT`, `R16G16B16A16_SNORM`, `R8G8B8A8_SNORM`, `R16G16_UNORM` | `Float32x4`, `Snorm16x4`, `Snorm8x4`, `Unorm16x2` |
    ///
    /// A position's fourth number is 1, a normal's is 0, a tangent's is the base tangent's. The formats of two numbers are
    /// octahedral, see [`Encoding::Octahedral16x2`].
    pub format: F,
}

/// Where a buffer stores the vertices of one mesh. `B` names the buffer, `F` is the graphics interface's vertex format.
#[derive(Debug, Clone, Copy)]
pub struct TargetDef<B, F> {
    /// The mesh: 0 is the set's base mesh, 1 its first level of detail, and so on.
    pub lod: usize,
    /// The buffer. It may hold any number of targets; one dispatch writes all targets in one buffer.
    pub buffer: B,
    /// Bytes from the buffer's start to the target; a multiple of 4.
    pub offset: u64,
    /// Bytes of the target. Nothing outside is written. The ranges of targets may interleave; their values must not overlap.
    pub size: u64,
    /// Positions, m.
    pub positions: VertexStream<F>,
    /// Unit normals; `None` writes none.
    pub normals: Option<VertexStream<F>>,
    /// Tangents; `None` writes none. The fourth number is the base tangent's.
    pub tangents: Option<VertexStream<F>>,
    /// Scale of positions in 16-bit normalised integers, m, above 0: a stored number s from -1 to 1 stands for
    /// `s * scale + bias`. Positions outside are clamped, so take the bounds and add the depth limit.
    pub scale: [f32; 3],
    /// Bias of positions in 16-bit normalised integers, m.
    pub bias: [f32; 3],
}

/// A graphics interface's vertex format.
pub trait HostFormat: Copy + PartialEq + Debug {
    /// The format of an attribute in an encoding that it can have.
    fn of(attribute: Attribute, encoding: Encoding) -> Self;
}

impl<B, F: HostFormat> TargetDef<B, F> {
    /// Positions alone, three floats each, tightly packed from `offset` on.
    pub fn positions(buffer: B, offset: u64, size: u64) -> Self {
        let format = F::of(Attribute::Position, Encoding::F32);
        let positions = VertexStream { offset: 0, stride: 12, format };
        let (normals, tangents) = (None, None);
        let (scale, bias) = ([1.0; 3], [0.0; 3]);
        TargetDef { lod: 0, buffer, offset, size, positions, normals, tangents, scale, bias }
    }

    /// Checks the definition for a mesh and a buffer of `buffer_size` bytes. Returns the layout, and the bytes of the buffer from
    /// the first that is written to the last.
    pub(crate) fn layout(&self, mesh: &Mesh, buffer_size: u64) -> Result<(VertexLayout, Range<u64>), Error> {
        let mut streams = [None; 3];
        let given = [Some(self.positions), self.normals, self.tangents];
        for ((to, attribute), stream) in streams.iter_mut().zip(Attribute::ALL).zip(given) {
            *to = stream.map(|s| s.encoded(attribute)).transpose()?;
        }
        let good = self.scale.iter().all(|s| *s > 0.0 && s.is_finite()) && self.bias.iter().all(|b| b.is_finite());
        if streams[0].is_some_and(|s| s.format == Encoding::Snorm16x4) && !good {
            let value = format!("{:?}, bias {:?}", self.scale, self.bias);
            return Err(Error::invalid("the scale", value, "above 0 and finite, the bias finite, m"));
        }
        let layout = VertexLayout { streams, scale: self.scale, bias: self.bias };
        Strided::check_aligned("the target's offset", self.offset, 4)?;
        let needed = self.offset.saturating_add(self.size);
        if needed > buffer_size {
            return Err(Error::BufferTooSmall { name: "the buffer".into(), size: buffer_size, needed });
        }
        let kernel = layout.kernel();
        if kernel > Kernel::Positions && mesh.normals().is_none() {
            let what = "a normal or tangent output: the mesh has neither normals nor triangles to compute them from";
            return Err(Error::Unsupported { what: what.into() });
        }
        if kernel == Kernel::Tangents && mesh.tangents().is_none() {
            return Err(Error::Unsupported { what: "a tangent output: the mesh has no tangents".into() });
        }
        let written = layout.check(mesh.positions().len(), self.size)?;
        Ok((layout, self.offset + written.start..self.offset + written.end))
    }
}

/// The layout of a target's vertices.
#[derive(Debug, Clone, Copy)]
pub(crate) struct VertexLayout {
    /// In the order of [`Attribute::ALL`]. There are always positions.
    pub streams: [Option<VertexStream<Encoding>>; 3],
    /// Positions in normalised integers are stored as (p - bias) / scale.
    pub scale: [f32; 3],
    pub bias: [f32; 3],
}

impl VertexLayout {
    fn named(&self) -> impl Iterator<Item = (Attribute, VertexStream<Encoding>)> {
        Attribute::ALL.into_iter().zip(self.streams).filter_map(|(attribute, s)| Some((attribute, s?)))
    }

    /// Whether an output has another format than 32-bit floats.
    pub(crate) fn packed(&self) -> bool {
        self.streams.iter().flatten().any(|s| s.format != Encoding::F32)
    }

    /// The kernel that writes this layout.
    pub(crate) fn kernel(&self) -> Kernel {
        match self.streams {
            [.., Some(_)] => Kernel::Tangents,
            [_, Some(_), None] => Kernel::Normals,
            _ => Kernel::Positions,
        }
    }

    /// The variant that writes this layout.
    pub(crate) fn variant(&self, case: Case) -> Variant {
        Variant { kernel: self.kernel(), case, packed: self.packed() }
    }

    /// Fails if a stream is misaligned, overlaps another, or does not fit into `size` bytes. Returns the bytes from the first
    /// that is written to the last.
    fn check(&self, vertices: usize, size: u64) -> Result<Range<u64>, Error> {
        let (mut low, mut high) = (u64::MAX, 0);
        for (attribute, s) in self.named() {
            let name = attribute.name();
            for (what, value) in [("offset", s.offset), ("stride", s.stride)] {
                Strided::check_aligned(format_args!("the {name} {what}"), value, 4)?;
            }
            let strided = s.strided(attribute, vertices);
            strided.check_stride(format_args!("the {name} stride"))?;
            if s.stride > u64::from(u32::MAX) {
                return Err(Error::invalid(&format!("the {name} stride"), s.stride, "at most 4294967295 bytes"));
            }
            strided.check_size(format_args!("the target's range, for {},", attribute.plural()), size)?;
            low = low.min(s.offset);
            high = high.max(strided.span().end);
        }
        for (i, (a, s)) in self.named().enumerate() {
            for (b, t) in self.named().skip(i + 1) {
                if s.strided(a, vertices).overlaps(&t.strided(b, vertices)) {
                    let value = format!("offset {} stride {}", s.offset, s.stride);
                    let other = format!("offset {} stride {}", t.offset, t.stride);
                    let expected = format!("apart from the {} (at {other})", b.plural());
                    return Err(Error::invalid(&format!("the layout of {}", a.plural()), value, &expected));
                }
            }
        }
        Ok(low..high)
    }
}

impl<F: HostFormat> VertexStream<F> {
    fn encoded(self, attribute: Attribute) -> Result<VertexStream<Encoding>, Error> {
        let VertexStream { offset, stride, format } = self;
        let possible = attribute.encodings();
        if let Some(encoding) = possible.iter().find(|e| F::of(attribute, **e) == format) {
            return Ok(VertexStream { offset, stride, format: *encoding });
        }
        let names: Vec<String> = possible.iter().map(|e| format!("{:?}", F::of(attribute, *e))).collect();
        let name = format!("the {} format", attribute.name());
        Err(Error::invalid(&name, format!("{format:?}"), &format!("one of {}", names.join(", "))))
    }
}

impl VertexStream<Encoding> {
    pub(crate) fn strided(&self, attribute: Attribute, vertices: usize) -> Strided {
        let (first, stride) = (self.offset, self.stride);
        Strided { first, stride, element: self.format.bytes(attribute), count: vertices as u64 }
    }
}

/// The range of a buffer of `size` bytes to bind for a target that writes these bytes: the whole buffer if the device can bind
/// it, else a window that begins at the target.
pub(crate) fn binding_range(size: u64, written: &Range<u64>, limits: &BindingLimits) -> Result<Range<u64>, Error> {
    let (size, most) = (size & !3, limits.bytes);
    let start = if size <= most { 0 } else { written.start - written.start % limits.alignment };
    let range = start..start + (size - start).min(most);
    if range.start <= written.start && written.end <= range.end {
        return Ok(range);
    }
    Err(limits.exceeded(&format!("a target that spans {} bytes", written.end - written.start)))
}
