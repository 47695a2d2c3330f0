//! The words of a mesh: its vertices, how they follow nodes, and for a classic rule its examples. They do not change.

use super::layout::NONE;
use crate::basis::{Rows, TILE};
use crate::example::blocks::DeltaBlocks;
use crate::example::mesh_lod::MeshLod;
use bytemuck::cast_slice;

/// Words of the head of an example's block: widths, groups, and the first words of displacements and of changes of normals.
const HEAD_WORDS: usize = 4;

/// The first words of the parts of a mesh in a chunk of the arena.
#[derive(Debug)]
pub(crate) struct MeshWords {
    /// The first of all.
    pub at: u32,
    pub positions: u32,
    pub normals: Option<u32>,
    pub tangents: Option<u32>,
    /// For each example a word a block: the offset of the block's head from here, or [`NONE`] if the example stores nothing of
    /// the block. The heads and the numbers follow.
    pub examples: Vec<u32>,
    /// The vertices' depth limits, and 1 - stiffness, where there are any: two vertices a word.
    pub limits: [Option<u32>; 2],
    /// The heads of tiles; then nodes, weights and slopes.
    pub tiles: u32,
    /// The largest sum of a vertex's absolute weights, in units of 1 / [`crate::basis::ONE`].
    pub most: u32,
    /// Number of words.
    pub total: u64,
}

impl MeshWords {
    /// Lays out a mesh from a word of its chunk on.
    pub(crate) fn new(lod: &MeshLod, first: u32) -> Self {
        let mut at = Counter(u64::from(first));
        let n = lod.vertex_count();
        MeshWords {
            at: first,
            positions: at.take(3 * n),
            normals: lod.mesh.normals().map(|_| at.take(3 * n)),
            tangents: lod.mesh.tangents().map(|_| at.take(4 * n)),
            examples: lod.anchored.iter().map(|a| at.take(numbers_at(lod, a) + 2 * a.words.len())).collect(),
            limits: lod.mesh.limits().parts().map(|l| (!l.is_empty()).then(|| at.take(l.as_flattened().len() / 2))),
            tiles: at.take(tile_words_len(&lod.rows)),
            most: lod.rows.tiles.iter().map(|t| t.most).max().unwrap_or(0),
            total: at.0 - u64::from(first),
        }
    }

    /// Writes the mesh that this was made from to its words.
    pub(crate) fn write(&self, lod: &MeshLod, to: &mut [u32]) {
        let mut put = |at: u32, from: &[u32]| to[(at - self.at) as usize..][..from.len()].copy_from_slice(from);
        put(self.positions, cast_slice(lod.mesh.positions()));
        if let (Some(at), Some(normals)) = (self.normals, lod.mesh.normals()) {
            put(at, cast_slice(normals));
        }
        if let (Some(at), Some(tangents)) = (self.tangents, lod.mesh.tangents()) {
            put(at, cast_slice(tangents));
        }
        for (at, a) in self.examples.iter().zip(&lod.anchored) {
            let (blocks, numbers) = (lod.blocks(), numbers_at(lod, a));
            let mut table = vec![NONE; blocks];
            let mut heads = Vec::with_capacity(numbers - blocks);
            for h in a.heads.iter() {
                table[h.block as usize] = (blocks + heads.len()) as u32;
                let displacements = numbers + 2 * h.at as usize;
                let normals = displacements + 2 * crate::example::blocks::words(h.groups, h.width);
                heads.extend([
                    u32::from(h.width) | u32::from(h.normal_width) << 8,
                    u32::from(h.groups) | u32::from(h.normal_groups) << 16,
                    displacements as u32,
                    normals as u32,
                ]);
            }
            put(*at, &table);
            put(*at + blocks as u32, &heads);
            put(*at + numbers as u32, cast_slice(&a.words));
        }
        for (at, halves) in self.limits.iter().zip(lod.mesh.limits().parts()) {
            if let Some(at) = at {
                // A file's arrays are aligned for their elements only.
                let words: Vec<u32> = bytemuck::pod_collect_to_vec(&halves[..]);
                put(*at, &words);
            }
        }
        put(self.tiles, &tile_words(&lod.rows));
    }
}

/// Words of the head of a tile: `TILE_WORDS` in nodes.wgsl.
const TILE_WORDS: usize = 5;

fn tile_words_len(rows: &Rows) -> usize {
    TILE_WORDS * rows.tiles.len()
        + rows.nodes.len()
        + (rows.weights.len() + rows.slopes.len()) / 4
        + rows.slope_units.len()
}

/// The words of vertices that follow nodes, as nodes.wgsl reads them.
fn tile_words(rows: &Rows) -> Vec<u32> {
    let nodes = TILE_WORDS * rows.tiles.len();
    let weights = nodes + rows.nodes.len();
    let slopes = weights + rows.weights.len() / 4;
    let units = slopes + rows.slopes.len() / 4;
    let mut words = Vec::with_capacity(tile_words_len(rows));
    for (t, tile) in rows.tiles.iter().enumerate() {
        let first = tile.first as usize;
        let numbers = TILE * first / 4;
        let [node, weight, slope] = [nodes + first, weights + numbers, slopes + 2 * numbers];
        words.extend([node, tile.count as usize, weight, slope, units + TILE * t].map(|w| w as u32));
    }
    words.extend_from_slice(&rows.nodes);
    // A file's arrays are aligned for their elements only.
    words.extend(bytemuck::pod_collect_to_vec::<i8, u32>(&rows.weights));
    words.extend(bytemuck::pod_collect_to_vec::<i8, u32>(&rows.slopes));
    words.extend(rows.slope_units.iter().map(|u| u.to_bits()));
    words
}

/// Words of an example before its numbers.
fn numbers_at(lod: &MeshLod, a: &DeltaBlocks) -> usize {
    lod.blocks() + HEAD_WORDS * a.heads.len()
}

struct Counter(u64);

impl Counter {
    /// Returns where the next `words` words begin. Above 2^32 only the total is right.
    fn take(&mut self, words: usize) -> u32 {
        let at = self.0 as u32;
        self.0 += words as u64;
        at
    }
}
