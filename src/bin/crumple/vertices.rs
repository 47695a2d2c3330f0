//! The vertices that a command deforms.

use anyhow::Result;
use crumple::glam::{Vec3, Vec4};
use crumple::{Mesh, VertexMemory};

/// The vertices, with the attributes that the mesh has.
#[derive(Clone)]
pub struct Vertices {
    pub positions: Vec<[f32; 3]>,
    pub normals: Option<Vec<[f32; 3]>>,
    pub tangents: Option<Vec<[f32; 4]>>,
}

impl Vertices {
    /// The undeformed mesh.
    pub fn at_rest(mesh: &Mesh) -> Self {
        Vertices {
            positions: mesh.positions().iter().map(Vec3::to_array).collect(),
            normals: mesh.normals().map(|n| n.iter().map(Vec3::to_array).collect()),
            tangents: mesh.tangents().map(|t| t.iter().map(Vec4::to_array).collect()),
        }
    }

    /// The memory for a deform to write to.
    pub fn memory(&mut self) -> Result<VertexMemory<'_>> {
        let Vertices { positions, normals, tangents } = self;
        Ok(VertexMemory::separate(positions, normals.as_deref_mut(), tangents.as_deref_mut())?)
    }
}
