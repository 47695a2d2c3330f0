//! Statistics from building a set.

use crate::mesh::mirror::Mirror;

/// Statistics and warnings from building a set.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SetReport {
    /// Indices of the examples that move nothing.
    pub empty_examples: Vec<usize>,
    /// Number of coincident vertices that examples moved apart and that were welded, summed over all examples.
    pub welded: usize,
    /// The widest gap that was welded, m.
    pub widest_weld: f32,
    /// Number of base normals of length zero that were replaced by computed ones.
    pub repaired_normals: usize,
    /// Number of triangles without area.
    pub degenerate_triangles: usize,
    /// Memory of whole examples: displacements and normals with their headers, bytes. 0 in a set from a file without
    /// ([`crate::SetOptions::whole_examples`]), like the other numbers of them here.
    pub anchored_bytes: usize,
    /// The part of `anchored_bytes` that normals use.
    pub normal_bytes: usize,
    /// Number of vertices that examples move, summed over all examples. Known of every set.
    pub moved_vertices: usize,
    /// Number of blocks of whole examples with 1, 2 and 4 bytes per number, summed over all examples.
    pub blocks_by_width: [usize; 3],
    /// Planes of symmetry through the centre of the bounds. None if [`crate::SetOptions::mirror`] is off.
    pub mirror_planes: Mirror,
    /// Number of vertices on held edges. Each vertex of a seam counts.
    pub held_vertices: usize,
    /// Number of vertices with a depth limit of their own.
    pub limited_vertices: usize,
    /// Number of vertices with a stiffness above 0.
    pub stiff_vertices: usize,
    /// Number of vertices that cannot move: their depth limit is 0 or their stiffness 1, as stored.
    pub rigid_vertices: usize,
    /// One report per level of detail added. The other fields describe the base mesh only.
    pub lods: Vec<LodReport>,
}

/// Statistics from adding a level of detail.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LodReport {
    /// Number of vertices.
    pub vertices: usize,
    /// Memory used, bytes.
    pub bytes: usize,
    /// Greatest distance of a vertex from the base surface, m. If it is much larger than the simplification error, the
    /// mesh belongs to another body or is in another space.
    pub farthest: f32,
}
