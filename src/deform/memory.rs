//! The caller's vertex memory: the offset and the stride of each attribute. Apart from the C interface, this is the
//! only file that writes through pointers from the caller.

use super::encoding::{Encoding, octahedral_tangent};
use super::kernel::whole;
use super::levels;
use crate::base::error::Error;
use crate::base::strided::Strided;
use crate::mesh::vertex_blocks::BLOCK;
use glam::Vec4;
use std::marker::PhantomData;
use std::ops::Range;

/// Location and format of an attribute in interleaved vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Attribute {
    /// Distance from the start of the memory to the first vertex's value, bytes; a multiple of 4.
    pub offset: usize,
    /// Distance from one vertex's value to the next, bytes; a multiple of 4.
    pub stride: usize,
    /// [`Encoding::F32`], or for normals and tangents [`Encoding::Octahedral16x2`] too.
    pub format: Encoding,
}

impl Attribute {
    fn floats(stride: usize) -> Self {
        Self { offset: 0, stride, format: Encoding::F32 }
    }

    /// The bytes of a value that has `floats` bytes in floats.
    fn bytes(&self, floats: u64) -> u64 {
        if self.format == Encoding::Octahedral16x2 { 4 } else { floats }
    }

    fn strided(&self, element: u64, count: u64) -> Strided {
        Strided { first: self.offset as u64, stride: self.stride as u64, element, count }
    }
}

/// One attribute in raw memory, for [`VertexMemory::from_raw`].
#[derive(Debug, Clone, Copy)]
pub struct RawStream {
    /// Start of the memory.
    pub data: *mut u8,
    /// Size of the memory, bytes.
    pub size: usize,
    /// Location of the values.
    pub layout: Attribute,
}

/// The caller's memory for one output: positions (3 × f32, m) and optional normals (3 × f32) and tangents (4 × f32).
/// Normals and tangents may be octahedral instead ([`Encoding::Octahedral16x2`], 2 × u16).
/// Bytes between values are never touched.
#[derive(Debug)]
pub struct VertexMemory<'a> {
    position: RawStream,
    normal: Option<RawStream>,
    tangent: Option<RawStream>,
    owner: PhantomData<&'a mut [u8]>,
}

// SAFETY: the memory is borrowed mutably for 'a, so moving this to another thread is moving a `&mut [u8]`.
unsafe impl Send for VertexMemory<'_> {}
// SAFETY: shared access only writes, and its callers (one task per block) never write a vertex twice.
unsafe impl Sync for VertexMemory<'_> {}

impl<'a> VertexMemory<'a> {
    /// Attributes interleaved in one piece of memory.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a format that the attribute does not take, a stride smaller than its value, or
    /// attributes that overlap; [`Error::Misaligned`] for offsets and strides that are not multiples of 4. `deform`
    /// checks the size.
    pub fn interleaved(
        data: &'a mut [u8],
        position: Attribute,
        normal: Option<Attribute>,
        tangent: Option<Attribute>,
    ) -> Result<Self, Error> {
        let (data, size) = (data.as_mut_ptr(), data.len());
        let raw = |layout| RawStream { data, size, layout };
        let (position, normal, tangent) = (raw(position), normal.map(raw), tangent.map(raw));
        let memory = Self { position, normal, tangent, owner: PhantomData };
        let streams: Vec<_> = memory.streams().map(|(name, s, bytes)| (name, s.layout, bytes)).collect();
        for (i, (name, a, bytes)) in streams.iter().enumerate() {
            for (other, b, other_bytes) in &streams[i + 1..] {
                // Checked for the largest vertex count, since the count is not known yet.
                if a.strided(*bytes, u32::MAX.into()).overlaps(&b.strided(*other_bytes, u32::MAX.into())) {
                    let value = format!(
                        "offset {} stride {}, {other} offset {} stride {}",
                        a.offset, a.stride, b.offset, b.stride
                    );
                    return Err(Error::invalid(name, value, "apart from the others, with the same stride"));
                }
            }
        }
        memory.checked()
    }

    /// Attributes in separate arrays of floats.
    ///
    /// # Errors
    /// None today; `deform` checks the sizes.
    pub fn separate(
        positions: &'a mut [[f32; 3]],
        normals: Option<&'a mut [[f32; 3]]>,
        tangents: Option<&'a mut [[f32; 4]]>,
    ) -> Result<Self, Error> {
        let raw =
            |data: *mut u8, size: usize, stride: usize| RawStream { data, size, layout: Attribute::floats(stride) };
        Ok(Self {
            position: raw(positions.as_mut_ptr().cast(), size_of_val(positions), 12),
            normal: normals.map(|n| raw(n.as_mut_ptr().cast(), size_of_val(n), 12)),
            tangent: tangents.map(|t| raw(t.as_mut_ptr().cast(), size_of_val(t), 16)),
            owner: PhantomData,
        })
    }

    /// Adds an array for normals in [`Encoding::Octahedral16x2`], in place of other normals. `deform` checks the size.
    #[must_use]
    pub fn with_octahedral_normals(mut self, normals: &'a mut [[u16; 2]]) -> Self {
        self.normal = Some(octahedral(normals));
        self
    }

    /// Adds an array for tangents in [`Encoding::Octahedral16x2`], in place of other tangents. `deform` checks the size.
    #[must_use]
    pub fn with_octahedral_tangents(mut self, tangents: &'a mut [[u16; 2]]) -> Self {
        self.tangent = Some(octahedral(tangents));
        self
    }

    /// Raw memory, for the C interface and for mapped graphics buffers.
    ///
    /// # Safety
    /// Each stream's memory must be valid for writes of its size for all of `'a`. Nobody else may read or write the
    /// attributes' bytes while a `deform` with it runs. Streams may lie in one interleaved memory, but their values
    /// must not overlap.
    ///
    /// # Errors
    /// As [`VertexMemory::interleaved`].
    pub unsafe fn from_raw(
        position: RawStream,
        normal: Option<RawStream>,
        tangent: Option<RawStream>,
    ) -> Result<Self, Error> {
        Self { position, normal, tangent, owner: PhantomData }.checked()
    }

    fn checked(self) -> Result<Self, Error> {
        for (name, s, bytes) in self.streams() {
            let direction = matches!(name, "normal" | "tangent");
            match s.layout.format {
                Encoding::F32 => {}
                Encoding::Octahedral16x2 if direction => {}
                other => {
                    let good = if direction { "F32 or Octahedral16x2" } else { "F32" };
                    return Err(Error::invalid(&format!("the {name} format"), format!("{other:?}"), good));
                }
            }
            for (what, value) in [("offset", s.layout.offset), ("stride", s.layout.stride)] {
                Strided::check_aligned(format_args!("{name} {what}"), value as u64, 4)?;
            }
            s.layout.strided(bytes, 1).check_stride(format_args!("{name} stride"))?;
        }
        Ok(self)
    }

    /// The streams that there are, with their names and the bytes of a value.
    fn streams(&self) -> impl Iterator<Item = (&'static str, &RawStream, u64)> {
        let all = [
            ("position", Some(&self.position), 12),
            ("normal", self.normal.as_ref(), 12),
            ("tangent", self.tangent.as_ref(), 16),
        ];
        all.into_iter().filter_map(|(name, stream, floats)| Some((name, stream?, stream?.layout.bytes(floats))))
    }

    /// Returns an error if `count` vertices do not fit.
    pub(crate) fn check_size(&self, count: usize) -> Result<(), Error> {
        self.streams().try_for_each(|(name, s, bytes)| {
            s.layout.strided(bytes, count as u64).check_size(format_args!("{name} memory"), s.size as u64)
        })
    }

    pub(crate) fn has_normals(&self) -> bool {
        self.normal.is_some()
    }

    pub(crate) fn has_tangents(&self) -> bool {
        self.tangent.is_some()
    }

    /// The positions of vertices `r` as a slice of floats; `None` if they are not contiguous or not aligned.
    ///
    /// # Safety
    /// `check_size` has passed for all vertices of `r`, and no other thread accesses them while the slice lives.
    #[allow(clippy::mut_from_ref)]
    pub(crate) unsafe fn positions(&self, r: Range<usize>) -> Option<&mut [f32]> {
        // SAFETY: guaranteed by the caller.
        unsafe { floats(&self.position, r) }
    }

    /// The same of normals; `None` also if there are none, or in another encoding.
    ///
    /// # Safety
    /// As [`VertexMemory::positions`].
    #[allow(clippy::mut_from_ref)]
    pub(crate) unsafe fn normals(&self, r: Range<usize>) -> Option<&mut [f32]> {
        // SAFETY: guaranteed by the caller.
        self.normal.as_ref().and_then(|s| unsafe { floats(s, r) })
    }

    /// Writes positions, three floats each, starting at vertex `first`.
    ///
    /// # Safety
    /// `check_size` has passed for all these vertices, and no other thread accesses them at the same time.
    pub(crate) unsafe fn write_positions(&self, first: usize, positions: &[f32]) {
        // SAFETY: guaranteed by the caller.
        unsafe { put_all::<f32, 3>(&self.position, first, positions) }
    }

    /// Writes normals, given as three floats each, starting at vertex `first`. Does nothing if the memory has no normals.
    ///
    /// # Safety
    /// As [`VertexMemory::write_positions`].
    pub(crate) unsafe fn write_normals(&self, first: usize, normals: &[f32]) {
        let Some(s) = &self.normal else { return };
        if s.layout.format == Encoding::F32 {
            // SAFETY: guaranteed by the caller.
            return unsafe { put_all::<f32, 3>(s, first, normals) };
        }
        for (i, block) in normals.chunks(3 * BLOCK).enumerate() {
            let mut words = [0; BLOCK];
            levels::octahedral(whole(block, &mut [0.0; 3 * BLOCK]), &mut words);
            // SAFETY: guaranteed by the caller.
            unsafe { put_all::<u32, 1>(s, first + i * BLOCK, &words[..block.len() / 3]) }
        }
    }

    /// Writes the tangent of vertex `v`. Does nothing if the memory has no tangents.
    ///
    /// # Safety
    /// As [`VertexMemory::write_positions`].
    pub(crate) unsafe fn write_tangent(&self, v: usize, tangent: Vec4) {
        let Some(s) = &self.tangent else { return };
        let tangent = tangent.to_array();
        // SAFETY: guaranteed by the caller.
        unsafe {
            match s.layout.format {
                Encoding::F32 => put(s, v, tangent),
                _ => put(s, v, octahedral_tangent(tangent)),
            }
        }
    }
}

fn octahedral(values: &mut [[u16; 2]]) -> RawStream {
    let layout = Attribute { offset: 0, stride: 4, format: Encoding::Octahedral16x2 };
    RawStream { data: values.as_mut_ptr().cast(), size: size_of_val(values), layout }
}

/// The vectors of vertices `r` as floats; `None` if they are none, not contiguous or not aligned.
///
/// # Safety
/// They lie within the stream, and no other thread accesses them while the slice lives.
#[allow(clippy::mut_from_ref)]
unsafe fn floats(s: &RawStream, r: Range<usize>) -> Option<&mut [f32]> {
    let first = s.data.wrapping_add(s.layout.offset + r.start * s.layout.stride).cast::<f32>();
    if s.layout.format != Encoding::F32 || s.layout.stride != 12 || !first.is_aligned() {
        return None;
    }
    // SAFETY: in bounds and unaliased, as the caller guarantees; aligned; any bytes are valid floats.
    Some(unsafe { std::slice::from_raw_parts_mut(first, 3 * r.len()) })
}

/// Writes `N` numbers a vertex.
///
/// # Safety
/// The values of all these vertices lie within the stream, and no other thread accesses them.
unsafe fn put_all<T: Copy, const N: usize>(s: &RawStream, first: usize, values: &[T]) {
    if s.layout.stride == size_of::<[T; N]>() {
        // SAFETY: the values are contiguous, so all lie within the stream; bytes need no alignment.
        return unsafe {
            let to = s.data.add(s.layout.offset + first * s.layout.stride);
            values.as_ptr().cast::<u8>().copy_to_nonoverlapping(to, size_of_val(values));
        };
    }
    for (i, v) in values.as_chunks::<N>().0.iter().enumerate() {
        // SAFETY: guaranteed by the caller.
        unsafe { put(s, first + i, *v) }
    }
}

/// # Safety
/// The value of vertex `v` lies within the stream, and no other thread accesses it.
unsafe fn put<T: Copy>(s: &RawStream, v: usize, value: T) {
    // SAFETY: in bounds, as the caller guarantees; unaligned, since a `&mut [u8]` may begin anywhere.
    unsafe { s.data.add(s.layout.offset + v * s.layout.stride).cast::<T>().write_unaligned(value) }
}
