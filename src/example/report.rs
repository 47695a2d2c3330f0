//! What building a set found out.

use crate::mesh::mirror::Mirror;

/// What building a set found out.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SetReport {
    /// Examples that move nothing.
    pub empty_examples: Vec<usize>,
    /// Coincident vertices that examples moved apart and that were welded, counted over all examples.
    pub welded: usize,
    /// The longest such gap, m.
    pub widest_weld: f32,
    /// Base normals of length zero that were replaced by computed ones.
    pub repaired_normals: usize,
    /// Triangles without area.
    pub degenerate_triangles: usize,
    /// Bytes of anchored displacements and normals, with their headers.
    pub anchored_bytes: usize,
    /// Of these, the normals'.
    pub normal_bytes: usize,
    /// Vertices that examples move, counted over all examples.
    pub moved_vertices: usize,
    /// Blocks of anchored displacements with 1, 2 and 4 bytes a number, counted over all examples.
    pub blocks_by_width: [usize; 3],
    /// Bytes of stamps.
    pub stamp_bytes: usize,
    /// Planes through the centre of the bounds that map the body onto itself; none where [`crate::SetOptions::mirror`] is off.
    pub mirror_planes: Mirror,
    /// Vertices (seams counted) on edges that the examples show to be held.
    pub held_vertices: usize,
    /// Of each level of detail that was added; what stands above is the base mesh's alone.
    pub lods: Vec<LodReport>,
}

/// What adding a level of detail found out.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LodReport {
    /// Its vertices.
    pub vertices: usize,
    /// Memory it takes, bytes.
    pub bytes: usize,
    /// Greatest distance of a vertex from the base surface it is bound to, m: much more than the simplification's own error
    /// tells of a mesh of another body, or in another space.
    pub farthest: f32,
}
