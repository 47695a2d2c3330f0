//! A mesh that shows damage: the set's own mesh, or another level of detail of the same body.

use super::blocks::DeltaBlocks;
use crate::base::math::Aabb;
use crate::basis::Rows;
use crate::mesh::Mesh;
use crate::mesh::rim::Rim;
use glam::Vec3;
use std::sync::{Arc, OnceLock};

/// A mesh with the data needed to evaluate marks on it.
#[derive(Debug)]
pub(crate) struct MeshLod {
    pub mesh: Mesh,
    pub rim: Rim,
    /// One per example of the set, where it was made: of the nodes, and of the base mesh if it has them. Other meshes have none.
    pub anchored: Vec<Arc<DeltaBlocks>>,
    /// How the vertices follow the set's nodes. The nodes themselves follow nothing.
    pub rows: Arc<Rows>,
    edge: OnceLock<f32>,
}

impl MeshLod {
    pub(crate) fn new(mesh: Mesh, rim: Rim, anchored: Vec<Arc<DeltaBlocks>>) -> Self {
        MeshLod { mesh, rim, anchored, rows: Arc::default(), edge: OnceLock::new() }
    }

    /// The displacements of all vertices by an example where it was made, m.
    pub(crate) fn field(&self, example: usize) -> Vec<Vec3> {
        let mut field = vec![Vec3::ZERO; self.vertex_count()];
        self.anchored[example].iter().for_each(|(v, d, _)| field[v as usize] = d);
        field
    }

    /// Memory used, with its examples, bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.mesh.bytes()
            + self.blocks() * size_of::<Aabb>()
            + self.rim.bytes()
            + self.anchored.iter().map(|a| a.bytes().total()).sum::<usize>()
            + self.rows.bytes()
    }

    /// Root mean square length of the triangles' edges, m; infinite without triangles.
    pub(crate) fn edge(&self) -> f32 {
        *self.edge.get_or_init(|| {
            let (positions, triangles) = (self.mesh.positions(), self.mesh.triangles());
            let sides = triangles.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
            let square = |[a, b]: [u32; 2]| (positions[a as usize] - positions[b as usize]).as_dvec3().length_squared();
            let mean = sides.map(square).sum::<f64>() / (3 * triangles.len()) as f64;
            if mean.is_nan() { f32::INFINITY } else { mean.sqrt() as f32 }
        })
    }

    pub(crate) fn vertex_count(&self) -> usize {
        self.mesh.positions().len()
    }

    pub(crate) fn blocks(&self) -> usize {
        self.mesh.block_bounds().len()
    }
}
