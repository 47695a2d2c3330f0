//! The basis of a body's damage: the displacements of a few of its vertices, the *nodes*. All other vertices follow them.
//!
//! ```text
//! u(v) = sum over nodes k of w(v, k) U(k)
//! ```
//!
//! Vertices are grouped in tiles of [`TILE`], in the mesh's order. The vertices of a tile follow the same few nodes, each with its
//! own weights. The weights are learned from displacement fields ([`learn`]): examples, and copies of them elsewhere on the body. So
//! a dent costs as much as it has nodes, and vertices cost the same whatever the number of examples and hits.
//!
//! Two further weights for each vertex and node give the slopes of the displacement along the surface, which turn the normal.
//!
//! Weights are 8-bit numbers and the nodes' displacements 16-bit ones. A sum of products stays below 2^24, so integers and f32 hold
//! it exactly: it has the same bits in any order, at any SIMD level and on a GPU.

pub(crate) mod field;
pub(crate) mod fit;
pub(crate) mod learn;
pub(crate) mod nodes;
pub(crate) mod slopes;

use crate::base::array::Array;

/// Vertices in a tile.
pub(crate) const TILE: usize = 16;
/// A weight of 1.
pub(crate) const ONE: i32 = 64;
/// The largest sum of a vertex's absolute weights: 511 times 32767 is below 2^24.
pub(crate) const MOST_WEIGHT: i32 = 511;

/// How the vertices of a mesh follow the nodes.
#[derive(Debug, Clone, Default)]
pub(crate) struct Rows {
    /// One entry per tile.
    pub tiles: Array<Tile>,
    /// The nodes of each tile, an even number. Tiles with an odd number repeat their last node with weights of 0.
    pub nodes: Array<u32>,
    /// For each tile, pair of nodes and vertex: the two weights, in units of 1 / [`ONE`]. A tile has room for [`TILE`] vertices.
    pub weights: Array<i8>,
    /// The same for slopes along the two tangents of the vertex ([`crate::base::math::tangent_basis`] of its normal), in units of
    /// the vertex's own: all pairs along the first tangent, then all along the second. Empty for meshes without normals.
    pub slopes: Array<i8>,
    /// The unit of each vertex's slopes, 1/m; [`TILE`] for each tile. Empty for meshes without normals.
    pub slope_units: Array<f32>,
}

/// One tile.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Tile {
    /// Index of its first node in [`Rows::nodes`]. Its first weight has [`TILE`] times this index.
    pub first: u32,
    /// Number of its nodes, even.
    pub count: u32,
    /// The largest sum of absolute weights of a vertex, in units of 1 / [`ONE`].
    pub most: u32,
}

/// The nodes of a body, and how the vertices of its mesh follow them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Basis {
    /// Vertices of the base mesh, one per position at most, ascending.
    pub nodes: Array<u32>,
    pub rows: Rows,
}

impl Rows {
    /// The nodes of a tile.
    pub(crate) fn nodes_of(&self, tile: usize) -> &[u32] {
        let t = self.tiles[tile];
        &self.nodes[t.first as usize..(t.first + t.count) as usize]
    }

    /// The weights of a tile.
    pub(crate) fn weights_of(&self, tile: usize) -> &[i8] {
        let t = self.tiles[tile];
        &self.weights[TILE * t.first as usize..TILE * (t.first + t.count) as usize]
    }

    /// The weights of a tile's slopes along both tangents; `None` for meshes without normals.
    pub(crate) fn slopes_of(&self, tile: usize) -> Option<&[i8]> {
        let t = self.tiles[tile];
        self.slopes.get(2 * TILE * t.first as usize..2 * TILE * (t.first + t.count) as usize).filter(|s| !s.is_empty())
    }

    /// The units of a tile's slopes, 1/m; empty for meshes without normals.
    pub(crate) fn slope_units_of(&self, tile: usize) -> &[f32] {
        self.slope_units.get(tile * TILE..(tile + 1) * TILE).unwrap_or_default()
    }

    /// Memory used, bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.tiles.bytes() + self.nodes.bytes() + self.weights.bytes() + self.slopes.bytes() + self.slope_units.bytes()
    }
}
