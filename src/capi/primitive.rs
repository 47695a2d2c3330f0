//! The stretches of a mesh: those with a material of their own, and the parts of a body.

use std::ffi::{CString, c_char};
use std::ops::Range;

/// A stretch of the mesh with one material. material is its name (UTF-8, valid until the set is destroyed) or null.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumplePrimitive {
    pub material: *const c_char,
    pub first_vertex: u32,
    pub vertex_count: u32,
    /// First triangle. Its first index is 3 * first_triangle.
    pub first_triangle: u32,
    pub triangle_count: u32,
    pub reserved: [u32; 2],
}

/// What a part of a body does when it is hit.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(dead_code)] // made by `From`, with glTF
pub enum CrumplePartKind {
    /// It dents.
    Dents = 0,
    /// It never moves, such as a wheel.
    Rigid = 1,
    /// It follows dents around it. See crumple_instance_set_part_rigid().
    Glass = 2,
}

/// A part of a body that was loaded with join_nodes. It is a mesh of its own, and a stretch of the base mesh with the same
/// vertices and triangles in the same order.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumplePart {
    /// As crumple_example_set_find_part() takes it, UTF-8, valid until the set is destroyed. Never null.
    pub name: *const c_char,
    pub kind: CrumplePartKind,
    pub first_vertex: u32,
    pub vertex_count: u32,
    /// First triangle. Its first index is 3 * first_triangle.
    pub first_triangle: u32,
    pub triangle_count: u32,
    pub reserved: [u32; 3],
}

/// What a set keeps of a part.
#[derive(Clone)]
pub(super) struct PartEntry {
    pub(super) name: CString,
    pub(super) kind: CrumplePartKind,
    pub(super) vertices: Range<u32>,
    pub(super) triangles: Range<u32>,
}

#[cfg(feature = "gltf")]
impl From<crate::io::import::Part> for PartEntry {
    fn from(part: crate::io::import::Part) -> Self {
        use crate::io::import::PartKind;
        let kind = match part.kind {
            PartKind::Dents => CrumplePartKind::Dents,
            PartKind::Rigid => CrumplePartKind::Rigid,
            PartKind::Glass => CrumplePartKind::Glass,
        };
        Self {
            name: c_string(&part.name),
            kind,
            vertices: part.first_vertex..part.first_vertex + part.vertex_count,
            triangles: part.first_triangle..part.first_triangle + part.triangle_count,
        }
    }
}

impl PartEntry {
    pub(super) fn told(&self) -> CrumplePart {
        CrumplePart {
            name: self.name.as_ptr(),
            kind: self.kind,
            first_vertex: self.vertices.start,
            vertex_count: self.vertices.len() as u32,
            first_triangle: self.triangles.start,
            triangle_count: self.triangles.len() as u32,
            reserved: [0; 3],
        }
    }
}

/// A text of any origin as one that C can read.
pub(super) fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', "\u{fffd}")).unwrap_or_default()
}

// SAFETY: the pointer is to a string that lives beside it.
unsafe impl Send for CrumplePrimitive {}

impl CrumplePrimitive {
    pub(super) fn new(vertices: Range<u32>, triangles: Range<u32>) -> Self {
        Self {
            material: std::ptr::null(),
            first_vertex: vertices.start,
            vertex_count: vertices.len() as u32,
            first_triangle: triangles.start,
            triangle_count: triangles.len() as u32,
            reserved: [0; 2],
        }
    }
}
