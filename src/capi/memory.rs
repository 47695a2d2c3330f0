//! The caller's arrays, checked before a byte is touched: pointers, alignment, strides, sizes.

use super::check::{defs, enumerator};
use super::result::Failure;
use super::types::{CrumpleDirectionFormat, CrumpleStream};
use crate::base::error::reserve;
use crate::base::strided::Strided;
use crate::deform::{Attribute, Encoding, RawStream, VertexMemory};
use crate::instance::Instance;
use std::ffi::c_void;
use std::mem::MaybeUninit;

/// An array that Crumple reads during the call. Element i is at data + i * stride. The field that uses it states count
/// and type. All fields zero: absent.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleInput {
    /// First element, aligned to its type (4 bytes; 2 for 16-bit indices). Null: absent.
    pub data: *const c_void,
    /// Readable bytes at data: at least (count - 1) * stride + the size of one element.
    pub size: usize,
    /// Bytes from one element to the next: at least the size of one element, a multiple of its alignment. Not 0.
    pub stride: usize,
}

/// Where the elements of an array lie: by address. Checks that `count` elements of `element` bytes fit into `size` bytes at
/// `data + offset`.
fn checked(
    (data, size, offset, stride): (usize, usize, usize, usize),
    (element, align, count): (usize, usize, usize),
    name: &str,
) -> Result<Strided, Failure> {
    for (what, value) in [("data", data), ("offset", offset), ("stride", stride)] {
        Strided::check_aligned(format_args!("{name}.{what}"), value as u64, align as u64)?;
    }
    let at = |first: usize| Strided {
        first: first as u64,
        stride: stride as u64,
        element: element as u64,
        count: count as u64,
    };
    at(offset).check_stride(format_args!("{name}.stride"))?;
    at(offset).check_size(name, size as u64)?;
    if size > isize::MAX as usize || data.checked_add(size).is_none() {
        return Err(Failure::invalid(format!("{name}.size is {size} bytes, which reaches past the end of memory")));
    }
    Ok(at(data + offset))
}

fn absent(is_null: bool, size: usize, name: &str) -> Result<bool, Failure> {
    if is_null && size != 0 {
        return Err(Failure::null_pointer(format!("{name}.data is null but {name}.size is {size} bytes")));
    }
    Ok(is_null)
}

/// Copies `count` elements out of a caller's array; nothing where it is absent.
pub(super) unsafe fn read<T: bytemuck::AnyBitPattern>(
    input: CrumpleInput,
    count: usize,
    name: &str,
) -> Result<Option<Vec<T>>, Failure> {
    if absent(input.data.is_null(), input.size, name)? {
        return Ok(None);
    }
    let place = (input.data.addr(), input.size, 0, input.stride);
    checked(place, (size_of::<T>(), align_of::<T>(), count), name)?;
    let mut values = reserve(count, name)?;
    for i in 0..count {
        // SAFETY: aligned and inside the `size` bytes that the caller vouches for, as `checked` found.
        values.push(unsafe { input.data.byte_add(i * input.stride).cast::<T>().read() });
    }
    Ok(Some(values))
}

/// An output array that was checked.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stream {
    pub(super) data: *mut u8,
    pub(super) layout: Strided,
}

// SAFETY: a pointer to the caller's memory, which the header asks to be reachable from every thread that runs tasks;
// what may write to it when is decided by who holds the `Stream`.
unsafe impl Send for Stream {}
// SAFETY: as above.
unsafe impl Sync for Stream {}

impl Stream {
    /// Checks that `count` elements of `element` bytes fit; nothing where the stream is absent.
    fn new(name: &str, stream: CrumpleStream, (element, count): (usize, usize)) -> Result<Option<Self>, Failure> {
        if absent(stream.data.is_null(), stream.size, name)? {
            return Ok(None);
        }
        let place = (stream.data.addr(), stream.size, stream.offset, stream.stride);
        let layout = checked(place, (element, 4, count), name)?;
        Ok(Some(Self { data: stream.data.cast::<u8>().wrapping_add(stream.offset), layout }))
    }

    /// Checks output arrays, each with its name, the bytes of an element and their number. They must not share bytes.
    pub(super) fn all<const N: usize>(
        given: [(&str, CrumpleStream, (usize, usize)); N],
    ) -> Result<[Option<Self>; N], Failure> {
        let mut found = [None; N];
        for (i, (a, stream, size)) in given.into_iter().enumerate() {
            found[i] = Self::new(a, stream, size)?;
            let Some(x) = found[i] else { continue };
            if let Some(k) = (0..i).find(|k| found[*k].is_some_and(|y: Self| x.layout.overlaps(&y.layout))) {
                return Err(Failure::invalid(format!(
                    "{a} and {b} overlap; each must have bytes of its own (interleaved arrays need one stride and offsets apart)",
                    b = given[k].0
                )));
            }
        }
        Ok(found)
    }

    /// Writes all elements.
    ///
    /// # Safety
    /// The memory that was checked is still writable, and nobody else touches the elements.
    pub(super) unsafe fn write<T: bytemuck::Pod>(&self, values: &[T]) {
        assert!(values.len() as u64 == self.layout.count && size_of::<T>() as u64 == self.layout.element);
        for (i, &value) in values.iter().enumerate() {
            // SAFETY: inside the memory, as `new` checked; the caller vouches for the rest.
            unsafe { self.data.add(i * self.layout.stride as usize).cast::<T>().write_unaligned(value) }
        }
    }
}

/// Memory for the deformed vertices of one instance, in the mesh's order and space.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleHostBufferDef {
    pub struct_size: u32,
    /// Which mesh: 0 for the base mesh, or a number from crumple_example_set_add_lod(). Default 0.
    pub lod: u32,
    /// Any number of yours. Default 0.
    pub user_data: u64,
    /// Positions, m. Required.
    pub positions: CrumpleStream,
    /// Unit normals in normal_format. Absent: not written.
    pub normals: CrumpleStream,
    /// Tangents in tangent_format: xyz of unit length and orthogonal to the normal, w as in the mesh. Absent: not
    /// written.
    pub tangents: CrumpleStream,
    pub normal_format: MaybeUninit<CrumpleDirectionFormat>,
    pub tangent_format: MaybeUninit<CrumpleDirectionFormat>,
}

defs!(CrumpleHostBufferDef);

/// Fails for a mesh that instances with this one's rule cannot show.
pub(super) fn check_lod(instance: &Instance, lod: u32) -> Result<(), Failure> {
    if lod > 0 {
        instance.only_marks("a buffer of another level of detail than 0")?;
    }
    Ok(())
}

/// Checked memory of the host.
#[derive(Debug, Clone, Copy)]
pub(super) struct HostMemory {
    positions: Stream,
    normals: Option<Stream>,
    tangents: Option<Stream>,
    /// Formats of normals and tangents.
    formats: [Encoding; 2],
}

impl HostMemory {
    pub(super) fn new(def: &CrumpleHostBufferDef, instance: &Instance) -> Result<Self, Failure> {
        check_lod(instance, def.lod)?;
        let mesh = instance.example_set().lod_mesh(def.lod as usize)?;
        let n = mesh.positions().len();
        let formats = [
            enumerator(def.normal_format, "def.normal_format")?,
            enumerator(def.tangent_format, "def.tangent_format")?,
        ];
        let bytes = |format, floats| if format == CrumpleDirectionFormat::Float { floats } else { 4 };
        let [positions, normals, tangents] = Stream::all([
            ("def.positions", def.positions, (12, n)),
            ("def.normals", def.normals, (bytes(formats[0], 12), n)),
            ("def.tangents", def.tangents, (bytes(formats[1], 16), n)),
        ])?;
        if normals.is_some() && mesh.normals().is_none() {
            return Err(Failure::mesh("it has no normals to deform, nor triangles to compute them from"));
        }
        if tangents.is_some() && mesh.tangents().is_none() {
            return Err(Failure::mesh("it has no tangents to deform"));
        }
        let positions =
            positions.ok_or_else(|| Failure::null_pointer("def.positions.data is null; a buffer needs positions"))?;
        Ok(Self { positions, normals, tangents, formats: formats.map(Encoding::from) })
    }

    /// The memory as the deformer sees it.
    ///
    /// # Safety
    /// The host's memory is still there, and nobody else touches it while a deform runs.
    pub(super) unsafe fn vertices(&self) -> Result<VertexMemory<'static>, Failure> {
        let raw = |s: &Stream, format| RawStream {
            data: s.data,
            size: (s.layout.span().end - s.layout.first) as usize,
            layout: Attribute { offset: 0, stride: s.layout.stride as usize, format },
        };
        let [normals, tangents] = [(&self.normals, self.formats[0]), (&self.tangents, self.formats[1])]
            .map(|(s, format)| s.as_ref().map(|s| raw(s, format)));
        // SAFETY: the caller's; `new` checked sizes, alignment, strides and that the streams are disjoint.
        Ok(unsafe { VertexMemory::from_raw(raw(&self.positions, Encoding::F32), normals, tangents) }?)
    }

    pub(super) fn streams(&self) -> impl Iterator<Item = Stream> {
        [Some(self.positions), self.normals, self.tangents].into_iter().flatten()
    }
}
