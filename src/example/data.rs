//! One example as plain arrays, made by an importer or by the caller.

use super::blow::Blow;

/// Displacements of an example from the base mesh, m, or changes of the unit normals.
#[derive(Debug, Clone, PartialEq)]
pub enum Deltas {
    /// One value per vertex of the base mesh. Zero for vertices that the example does not move.
    Full(Vec<[f32; 3]>),
    /// Only the vertices that the example moves.
    Sparse {
        /// Vertex indices, strictly increasing.
        indices: Vec<u32>,
        /// One value per index.
        values: Vec<[f32; 3]>,
    },
}

/// Where an example was hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Contact {
    /// A vertex of the base mesh.
    Vertex(u32),
    /// A point in the mesh's space, m; its nearest vertex becomes the contact.
    Point([f32; 3]),
}

/// One example: the base mesh after a collision, stored as differences from the base mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct ExampleData {
    /// Name of the example. Any text; it need not be unique.
    pub name: String,
    /// Displacements, m.
    pub positions: Deltas,
    /// Changes of the unit normals. If `None`, they are computed from the displaced triangles.
    pub normals: Option<Deltas>,
    /// Where the example was hit. If `None`, the deepest vertex is used.
    pub contact: Option<Contact>,
    /// Outward unit normal of the surface at the contact. If `None`, it is taken from the mesh.
    pub contact_normal: Option<[f32; 3]>,
    /// The blow that made the dent. If its normal is unknown, it takes `contact_normal`.
    pub blow: Blow,
}

impl ExampleData {
    /// An example with a name and displacements. Everything else takes its default.
    pub fn new(name: impl Into<String>, positions: Deltas) -> Self {
        Self { name: name.into(), positions, normals: None, contact: None, contact_normal: None, blow: Blow::default() }
    }
}
