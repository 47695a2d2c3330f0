//! The arrays of a mesh, as the caller gives them.

/// The base mesh as plain arrays. Positions are in metres. Any handedness and any up axis will do.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeshData {
    /// One position per vertex, m, in the engine's order. The order is kept.
    pub positions: Vec<[f32; 3]>,
    /// One unit normal per vertex. If `None`, normals are computed from the triangles.
    pub normals: Option<Vec<[f32; 3]>>,
    /// One tangent per vertex, as in glTF: xyz is a unit vector, w is the handedness (+1 or -1).
    pub tangents: Option<Vec<[f32; 4]>>,
    /// Three vertex indices per triangle, counter-clockwise seen from outside. May be empty.
    pub triangles: Vec<[u32; 3]>,
}
