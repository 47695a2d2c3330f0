//! The arrays that a mesh is made of.

/// The base mesh, as plain arrays. Positions in metres, any handedness, any axis up.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeshData {
    /// One position a vertex, m. The order is the engine's and is kept.
    pub positions: Vec<[f32; 3]>,
    /// One unit normal a vertex. Computed from the triangles where absent.
    pub normals: Option<Vec<[f32; 3]>>,
    /// One tangent a vertex: xyz of unit length, w the handedness (+1 or -1), as in glTF.
    pub tangents: Option<Vec<[f32; 4]>>,
    /// Three vertex indices a triangle, counter-clockwise seen from outside. May be empty.
    pub triangles: Vec<[u32; 3]>,
}
