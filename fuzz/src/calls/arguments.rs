//! Arguments that bytes choose: ids, numbers, arrays and defs.

use std::ffi::{CStr, c_char, c_void};
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use arbitrary::Unstructured;
use crumple::entry_points::*;

use super::{Host, Step};

impl Host<'_> {
    /// One of these, the null id or an invented one.
    pub(super) fn pick<T: Copy + bytemuck::Pod>(bytes: &mut Unstructured<'_>, list: &[T]) -> Step<T> {
        Ok(match bytes.arbitrary::<u8>()? {
            255 => bytemuck::pod_read_unaligned(&bytes.arbitrary::<[u8; 8]>()?),
            254 => T::zeroed(),
            i if list.is_empty() => bytemuck::pod_read_unaligned(&[i, 0, 0, 0, 1, 0, 1, 0]),
            i => list[usize::from(i) % list.len()],
        })
    }

    pub(super) fn context(&mut self) -> Step<*mut CrumpleContext> {
        Ok(match self.bytes.arbitrary::<u8>()? {
            255 => self.bytes.arbitrary::<usize>()? as *mut CrumpleContext,
            254 => null_mut(),
            i if i < 224 => self.contexts[0],
            i => self.contexts[usize::from(i) % self.contexts.len()],
        })
    }

    pub(super) fn set(&mut self) -> Step<CrumpleExampleSet> {
        Self::pick(&mut self.bytes, &self.sets)
    }

    pub(super) fn instance(&mut self) -> Step<CrumpleInstance> {
        Self::pick(&mut self.bytes, &self.instances)
    }

    pub(super) fn buffer(&mut self) -> Step<CrumpleBuffer> {
        Self::pick(&mut self.bytes, &self.buffers)
    }

    /// Up to four ids, or null.
    pub(super) fn some<T>(&mut self, one: fn(&mut Self) -> Step<T>) -> Step<Vec<T>> {
        let count = self.bytes.int_in_range(0..=4)?;
        (0..count).map(|_| one(self)).collect()
    }

    /// A path or name, or one that is wrong, or none.
    pub(super) fn path(&mut self, right: &'static CStr) -> Step<*const c_char> {
        Ok(match self.bytes.arbitrary::<u8>()? {
            255 => null(),
            254 => c"/nowhere/\xff".as_ptr(),
            253 => c"".as_ptr(),
            _ => right.as_ptr(),
        })
    }

    /// A number that is at the edge of something more often than by chance.
    pub(super) fn word(&mut self) -> Step<u32> {
        const EDGES: &[f32] = &[0.0, -0.0, 1.0, -1.0, 0.5, 0.01, -0.03, 1e-12, 1e30, f32::MAX, f32::INFINITY, f32::NAN];
        let kind = self.bytes.arbitrary::<u8>()?;
        Ok(match usize::from(kind & 31) {
            i if i < EDGES.len() => EDGES[i].to_bits(),
            12..=15 => u32::MAX >> (kind >> 5),
            i @ 16..=23 => i as u32 - 16,
            _ => self.bytes.arbitrary()?,
        })
    }

    pub(super) fn number(&mut self) -> Step<f32> {
        Ok(f32::from_bits(self.word()?))
    }

    /// A point near the sheet, or any.
    pub(super) fn point(&mut self) -> Step<CrumpleVec3> {
        let [x, y, any, _] = self.bytes.arbitrary::<[u8; 4]>()?;
        if any < 224 {
            return Ok([f32::from(x) / 255.0, f32::from(y) / 255.0, 0.0].into());
        }
        Ok([self.number()?, self.number()?, self.number()?].into())
    }

    /// Overwrites some words. The caller writes the pointers afterwards.
    pub(super) fn patched<T: Copy>(&mut self, mut def: T) -> Step<T> {
        for _ in 0..self.bytes.arbitrary::<u8>()? & 3 {
            let at = self.bytes.choose_index(size_of::<T>() / 4)?;
            let word = self.word()?;
            // SAFETY: within the def, of which every pattern of bytes is a value.
            unsafe { (&raw mut def).cast::<u32>().add(at).write_unaligned(word) };
        }
        Ok(def)
    }

    /// An array to read, or less of it than there is, or none.
    pub(super) fn input<T>(&mut self, values: &[T]) -> Step<CrumpleInput> {
        let mut input =
            CrumpleInput { data: values.as_ptr().cast(), size: size_of_val(values), stride: size_of::<T>() };
        match self.bytes.arbitrary::<u8>()? {
            255 => input.data = null(),
            254 => input.size /= 2,
            253 => input.stride = self.word()? as usize,
            252 => (input.data, input.size) = (input.data.wrapping_byte_add(2), input.size - 2),
            _ => {}
        }
        Ok(input)
    }

    pub(super) fn no_input() -> CrumpleInput {
        CrumpleInput { data: null(), size: 0, stride: 0 }
    }

    /// A mesh of the given arrays. The def's own pointers are overwritten.
    pub(super) fn mesh(&mut self, def: &mut CrumpleMeshDef, mesh: &crumple::MeshData, values: &[f32]) -> Step<()> {
        def.positions = self.input(&mesh.positions)?;
        def.indices = self.input(mesh.triangles.as_flattened())?;
        let present = self.bytes.arbitrary::<u8>()?;
        let n = mesh.positions.len();
        for (bit, field, width) in [
            (1, &raw mut def.normals, 3),
            (2, &raw mut def.tangents, 4),
            (4, &raw mut def.depth_limits, 1),
            (8, &raw mut def.stiffness, 1),
        ] {
            let input = if present & bit != 0 { self.input(&values[..width * n])? } else { Self::no_input() };
            let stride = if input.stride == 4 { 4 * width } else { input.stride };
            // SAFETY: a field of the def.
            unsafe { field.write(CrumpleInput { stride, ..input }) };
        }
        Ok(())
    }

    pub(super) fn mesh_def(&mut self, mesh: &crumple::MeshData) -> Step<CrumpleMeshDef> {
        let def = CrumpleMeshDef {
            vertex_count: mesh.positions.len() as u32,
            index_count: 3 * mesh.triangles.len() as u32,
            ..crumple_mesh_def_default()
        };
        self.patched(def)
    }

    /// Memory for vertices, in one array for each stream or interleaved.
    pub(super) fn buffer_def(&mut self) -> Step<CrumpleHostBufferDef> {
        const VERTICES: usize = 200;
        let mut memory = vec![0.0f32; 10 * VERTICES];
        let (data, size) = (memory.as_mut_ptr().cast::<c_void>(), size_of_val(memory.as_slice()));
        self.memory.push(memory);
        let mut def = self.patched(crumple_host_buffer_def_default())?;
        let (present, interleaved) = (self.bytes.arbitrary::<u8>()?, self.bytes.ratio(1, 2)?);
        let stream = |first: usize, width: usize| {
            let (offset, stride) = if interleaved { (4 * first, 40) } else { (4 * first * VERTICES, 4 * width) };
            CrumpleStream { data, size, offset, stride }
        };
        let none = CrumpleStream { data: null_mut(), size: 0, offset: 0, stride: 0 };
        let either = |bit: u8, stream| if present & bit != 0 { stream } else { none };
        def.positions = either(!1, stream(0, 3));
        def.normals = either(2, stream(3, 3));
        def.tangents = either(4, stream(6, 4));
        if self.bytes.ratio(1, 8)? {
            def.positions.stride = self.word()? as usize;
            def.positions.offset = self.word()? as usize;
            def.positions.size /= 1 + usize::from(self.bytes.arbitrary::<u8>()?);
        }
        Ok(def)
    }

    pub(super) fn hit(&mut self) -> Step<CrumpleHitDef> {
        let mut def = crumple_hit_def_default();
        def.kind = enumerator(u32::from(self.bytes.arbitrary::<u8>()? % 3));
        (def.point, def.duration, def.mass) = (self.point()?, 0.01, 1.0);
        def.impulse = [0.0, 0.0, -f32::from(self.bytes.arbitrary::<u8>()?) / 40.0].into();
        def.displacement = [0.0, 0.0, -f32::from(self.bytes.arbitrary::<u8>()?) / 2000.0].into();
        def.contact_id = u64::from(self.bytes.arbitrary::<u8>()? / 64);
        self.patched(def)
    }

    pub(super) fn contact_point(&mut self, body: CrumpleInstance) -> Step<CrumpleContactPointDef> {
        let mut def = crumple_contact_point_def_default();
        (def.pair, def.point, def.normal) = (self.bytes.int_in_range(0..=3)?, self.point()?, [0.0, 0.0, 1.0].into());
        def.bodies = [body, if self.bytes.arbitrary()? { self.instance()? } else { CrumpleInstance::default() }];
        (def.has_velocity, def.has_velocity_after) =
            (boolean(self.bytes.arbitrary()?), boolean(self.bytes.arbitrary()?));
        def.velocity = [0.0, 0.0, -f32::from(self.bytes.arbitrary::<u8>()?) / 8.0].into();
        def.impulse = f32::from(self.bytes.arbitrary::<u8>()?) / 8.0 - 1.0;
        def.masses = [self.number()?, 2.0];
        self.patched(def)
    }

    /// Saved bytes, perhaps with one of them changed.
    pub(super) fn saved_bytes(&mut self) -> Step<Vec<u8>> {
        let at = self.bytes.choose_index(self.saved.len())?;
        let mut bytes = self.saved[at].clone();
        if !bytes.is_empty() && self.bytes.ratio(1, 4)? {
            let at = self.bytes.choose_index(bytes.len())?;
            bytes[at] = self.bytes.arbitrary()?;
        }
        Ok(bytes)
    }
}

/// An enumerator or any other number.
pub(super) fn enumerator<E>(number: u32) -> MaybeUninit<E> {
    const { assert!(size_of::<E>() == 4) };
    let mut value = MaybeUninit::<E>::uninit();
    // SAFETY: four bytes, as asserted.
    unsafe { value.as_mut_ptr().cast::<u32>().write(number) };
    value
}

/// A byte that C passes as a `bool`.
pub(super) fn boolean(byte: u8) -> MaybeUninit<bool> {
    let mut value = MaybeUninit::<bool>::uninit();
    // SAFETY: one byte.
    unsafe { value.as_mut_ptr().cast::<u8>().write(byte) };
    value
}
