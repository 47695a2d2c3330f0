//! The parts of a mesh with materials of their own.

use std::ffi::c_char;
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
