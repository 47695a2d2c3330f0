//! A mesh that shows damage: the set's own mesh, or another level of detail of the same body.

use super::blocks::DeltaBlocks;
use crate::base::math::Aabb;
use crate::mesh::Mesh;
use crate::mesh::rim::Rim;
use std::sync::Arc;

/// A mesh with the data needed to evaluate marks on it.
#[derive(Debug)]
pub(crate) struct MeshLod {
    pub mesh: Mesh,
    pub block_bounds: Arc<[Aabb]>,
    pub rim: Rim,
    /// One per example of the set.
    pub anchored: Vec<Arc<DeltaBlocks>>,
}

impl MeshLod {
    pub(crate) fn new(mesh: Mesh, rim: Rim, anchored: Vec<Arc<DeltaBlocks>>) -> Self {
        MeshLod { block_bounds: mesh.block_bounds().clone(), mesh, rim, anchored }
    }

    /// Memory used, with its anchored examples, bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.mesh.bytes()
            + self.blocks() * size_of::<Aabb>()
            + self.rim.bytes()
            + self.anchored.iter().map(|a| a.bytes().total()).sum::<usize>()
    }

    pub(crate) fn vertex_count(&self) -> usize {
        self.mesh.positions().len()
    }

    pub(crate) fn blocks(&self) -> usize {
        self.block_bounds.len()
    }
}
