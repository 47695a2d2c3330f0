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
    /// For each vertex the furthest that it may move, m: at least 0, infinity for no limit of its own. Rounded down by up to
    /// 1 in 128. The limits of the set and of the instance hold too. Vertices at one position take the least.
    /// [`MeshData::keep_out`] computes limits from solids. `None`: no vertex has one.
    pub depth_limits: Option<Vec<f32>>,
    /// For each vertex how much less than its dents it moves: 0 (as the dents say) to 1 (not at all). Displacements are
    /// multiplied by 1 - stiffness before the limits apply. Vertices at one position take the greatest. `None`: 0.
    pub stiffness: Option<Vec<f32>>,
}
