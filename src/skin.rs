//! What damage is shown on: the set's own mesh, or another level of detail of the same body.

use crate::anchored::{Anchored, BLOCK, block_range};
use crate::math::Aabb;
use crate::mesh::Mesh;
use crate::rim::Rim;
use std::sync::Arc;

/// A mesh with all that evaluating marks on it needs.
#[derive(Debug)]
pub(crate) struct Skin {
    pub mesh: Mesh,
    pub block_bounds: Vec<Aabb>,
    pub rim: Rim,
    /// One an example of the set.
    pub anchored: Vec<Arc<Anchored>>,
}

impl Skin {
    pub(crate) fn new(mesh: Mesh, rim: Rim, anchored: Vec<Arc<Anchored>>) -> Self {
        let positions = mesh.positions();
        let block_bounds = (0..positions.len().div_ceil(BLOCK))
            .map(|b| Aabb::of(&positions[block_range(b, positions.len())]))
            .collect();
        Skin { mesh, block_bounds, rim, anchored }
    }

    /// Bytes it takes, its anchored examples among them.
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
