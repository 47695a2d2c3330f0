//! Values that several calls share.

use bytemuck::{Pod, Zeroable};
use std::ffi::c_void;

/// A point or a vector. Its unit is named where it is used.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub struct CrumpleVec3 {
    /// Along the mesh's (or the world's) first axis.
    pub x: f32,
    /// Along the second axis.
    pub y: f32,
    /// Along the third axis.
    pub z: f32,
}

impl CrumpleVec3 {
    pub(super) fn array(self) -> [f32; 3] {
        [self.x, self.y, self.z]
    }
}

impl From<[f32; 3]> for CrumpleVec3 {
    fn from([x, y, z]: [f32; 3]) -> Self {
        Self { x, y, z }
    }
}

impl From<glam::Vec3> for CrumpleVec3 {
    fn from(v: glam::Vec3) -> Self {
        v.to_array().into()
    }
}

/// A rotation: a unit quaternion, x y z w, w the real part.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub struct CrumpleQuat {
    /// i part.
    pub x: f32,
    /// j part.
    pub y: f32,
    /// k part.
    pub z: f32,
    /// Real part.
    pub w: f32,
}

/// A box along the mesh's axes, m.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub struct CrumpleAabb {
    /// Least coordinates, m.
    pub min: CrumpleVec3,
    /// Greatest coordinates, m.
    pub max: CrumpleVec3,
}

/// Consecutive vertices.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
pub struct CrumpleRange {
    /// First vertex.
    pub first: u32,
    /// Number of vertices.
    pub count: u32,
}

/// An array that Crumple reads during the call and never keeps. Element i lies at data + i * stride; how many there
/// are and of what type is said where the array is used. Zero everywhere: the array is absent.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleInput {
    /// First element; aligned to its type (4 bytes, or 2 for 16-bit indices). Null: absent.
    pub data: *const c_void,
    /// Readable bytes from data on; at least (count - 1) * stride + the bytes of one element.
    pub size: usize,
    /// Bytes from one element to the next: at least those of one element, a multiple of its alignment. 0 is an error,
    /// never "tightly packed".
    pub stride: usize,
}

/// An array that Crumple writes. Element i lies at data + offset + i * stride. Positions and normals are 3 floats (12
/// bytes), tangents 4 (16 bytes), indices one uint32_t; Crumple touches those bytes and none between them, so that
/// several streams may be interleaved in one vertex buffer. Zero everywhere: the array is absent.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleStream {
    /// Begin of the memory, aligned to 4 bytes. Null: absent.
    pub data: *mut c_void,
    /// Writable bytes from data on; at least offset + (count - 1) * stride + the bytes of one element.
    pub size: usize,
    /// Bytes from data to the first element, a multiple of 4.
    pub offset: usize,
    /// Bytes from one element to the next: at least those of one element, a multiple of 4. 0 is an error, never
    /// "tightly packed".
    pub stride: usize,
}

impl CrumpleInput {
    pub(super) const ABSENT: Self = Self { data: std::ptr::null(), size: 0, stride: 0 };
}

impl CrumpleStream {
    pub(super) const ABSENT: Self = Self { data: std::ptr::null_mut(), size: 0, offset: 0, stride: 0 };
}

/// A base mesh and its examples: immutable, shared by any number of instances. An id; zero is null. Compare ids field
/// by field; copy them freely; a stale or foreign id is an error, never a crash.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
pub struct CrumpleExampleSet {
    /// Place in the context, plus one; 0 is null.
    pub index: u32,
    /// Tells successive users of the place apart.
    pub generation: u16,
    /// Tells contexts apart.
    pub context: u16,
}

/// One body in the scene: an example set, a transform, and the damage so far. An id; zero is null.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
pub struct CrumpleInstance {
    /// Place in the context, plus one; 0 is null.
    pub index: u32,
    /// Tells successive users of the place apart.
    pub generation: u16,
    /// Tells contexts apart.
    pub context: u16,
}

/// Memory of yours that an instance's deformed vertices are written to. An id; zero is null.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
pub struct CrumpleBuffer {
    /// Place in the context, plus one; 0 is null.
    pub index: u32,
    /// Tells successive users of the place apart.
    pub generation: u16,
    /// Tells contexts apart.
    pub context: u16,
}
