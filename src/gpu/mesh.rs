//! The words of a mesh with its examples, and of its set's stamps. They do not change.

use super::layout::NONE;
use crate::basis::{Rows, TILE};
use crate::example::blocks::DeltaBlocks;
use crate::example::mesh_lod::MeshLod;
use crate::example::set::ExampleSet;
use crate::example::stamp::Node;
use crate::mesh::rim::{Rim, WindowBlock};
use bytemuck::{cast_slice, cast_slice_mut};

const NODE_WORDS: usize = size_of::<Node>() / 4;
const WINDOW_WORDS: usize = size_of::<WindowBlock>() / 4;
/// Words of the head of an example's block: widths, groups, and the first words of displacements and of changes of normals.
const HEAD_WORDS: usize = 4;

/// The first words of the parts of a mesh, counted from the mesh.
#[derive(Debug)]
pub(crate) struct MeshWords {
    positions: u32,
    normals: Option<u32>,
    tangents: Option<u32>,
    /// Six words a block: the least coordinates, then the greatest.
    bounds: u32,
    /// For each example a word a block: the offset of the block's head from here, or [`NONE`] if the example stores nothing of
    /// the block. The heads and the numbers follow.
    examples: Vec<u32>,
    /// The longest displacement of each example, m.
    longest: Vec<f32>,
    /// A word a block: the offset of the block's window from here, or [`NONE`]. The windows follow. `None` if no rim is held.
    windows: Option<u32>,
    /// Depth limits, and 1 - stiffness: two vertices a word.
    limits: [Option<u32>; 2],
    /// Where vertices follow nodes, the heads of tiles; then nodes, weights and slopes.
    tiles: Option<u32>,
    total: u64,
}

impl MeshWords {
    pub(crate) fn new(lod: &MeshLod) -> Self {
        let mut at = Counter(0);
        let n = lod.vertex_count();
        MeshWords {
            positions: at.take(3 * n),
            normals: lod.mesh.normals().map(|_| at.take(3 * n)),
            tangents: lod.mesh.tangents().map(|_| at.take(4 * n)),
            bounds: at.take(6 * lod.blocks()),
            examples: lod.anchored.iter().map(|a| at.take(numbers_at(lod, a) + 2 * a.words.len())).collect(),
            longest: lod.anchored.iter().map(|a| a.heads.iter().map(|h| h.longest).fold(0.0, f32::max)).collect(),
            windows: (!lod.rim.windows.is_empty())
                .then(|| at.take(lod.blocks() + lod.rim.windows.len() * WINDOW_WORDS)),
            limits: lod.mesh.limits().parts().map(|l| (!l.is_empty()).then(|| at.take(l.as_flattened().len() / 2))),
            tiles: lod.rows.as_ref().map(|rows| {
                let numbers = (rows.weights.len() + rows.slopes.len()) / 4;
                at.take(TILE_WORDS * rows.tiles.len() + rows.nodes.len() + numbers)
            }),
            total: at.0,
        }
    }

    pub(crate) fn total(&self) -> u64 {
        self.total
    }

    /// Writes the mesh that this was made from.
    pub(crate) fn write(&self, lod: &MeshLod, to: &mut [u32]) {
        let mut put = |at: u32, from: &[u32]| to[at as usize..][..from.len()].copy_from_slice(from);
        put(self.positions, cast_slice(lod.mesh.positions()));
        if let (Some(at), Some(normals)) = (self.normals, lod.mesh.normals()) {
            put(at, cast_slice(normals));
        }
        if let (Some(at), Some(tangents)) = (self.tangents, lod.mesh.tangents()) {
            put(at, cast_slice(tangents));
        }
        let corners = lod.block_bounds.iter().flat_map(|b| [b.min.to_array(), b.max.to_array()]);
        let corners: Vec<[f32; 3]> = corners.collect();
        put(self.bounds, cast_slice(&corners));
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
        if let Some(at) = self.windows {
            let blocks = lod.blocks();
            let place = |w: &u32| if *w == Rim::CLEAR { NONE } else { (blocks + *w as usize * WINDOW_WORDS) as u32 };
            let table: Vec<u32> = lod.rim.blocks.iter().map(place).collect();
            put(at, &table);
            put(at + blocks as u32, cast_slice(&lod.rim.windows));
        }
        for (at, halves) in self.limits.iter().zip(lod.mesh.limits().parts()) {
            if let Some(at) = at {
                // A file's arrays are aligned for their elements only.
                let words: Vec<u32> = bytemuck::pod_collect_to_vec(&halves[..]);
                put(*at, &words);
            }
        }
        if let (Some(at), Some(rows)) = (self.tiles, &lod.rows) {
            put(at, &tile_words(rows));
        }
    }
}

/// Words of the head of a tile: `TILE_WORDS` in nodes.wgsl.
const TILE_WORDS: usize = 5;

/// The words of vertices that follow nodes, as nodes.wgsl reads them.
fn tile_words(rows: &Rows) -> Vec<u32> {
    let nodes = TILE_WORDS * rows.tiles.len();
    let weights = nodes + rows.nodes.len();
    let slopes = weights + rows.weights.len() / 4;
    let mut words = Vec::with_capacity(slopes + rows.slopes.len() / 4);
    for tile in rows.tiles.iter() {
        let first = tile.first as usize;
        let numbers = TILE * first / 4;
        let [node, weight, slope] = [nodes + first, weights + numbers, slopes + 2 * numbers];
        words.extend([node as u32, tile.count, tile.slope.to_bits(), weight as u32, slope as u32]);
    }
    words.extend_from_slice(&rows.nodes);
    // A file's arrays are aligned for their elements only.
    words.extend(bytemuck::pod_collect_to_vec::<i8, u32>(&rows.weights));
    words.extend(bytemuck::pod_collect_to_vec::<i8, u32>(&rows.slopes));
    words
}

/// Words of an example before its numbers.
fn numbers_at(lod: &MeshLod, a: &DeltaBlocks) -> usize {
    lod.blocks() + HEAD_WORDS * a.heads.len()
}

/// The first words of the nodes of a set's stamps, counted from the first stamp.
#[derive(Debug)]
pub(crate) struct StampWords {
    stamps: Vec<u32>,
    total: u64,
}

impl StampWords {
    pub(crate) fn new(set: &ExampleSet) -> Self {
        let mut at = Counter(0);
        let stamps = set.examples().iter().map(|e| e.stamp().map_or(0, |s| at.take(s.nodes.len() * NODE_WORDS)));
        StampWords { stamps: stamps.collect(), total: at.0 }
    }

    pub(crate) fn total(&self) -> u64 {
        self.total
    }

    pub(crate) fn write(&self, set: &ExampleSet, to: &mut [u32]) {
        for (e, at) in set.examples().iter().zip(&self.stamps) {
            let Some(s) = e.stamp() else { continue };
            let words = &mut to[*at as usize..][..s.nodes.len() * NODE_WORDS];
            cast_slice_mut::<u32, u8>(words).copy_from_slice(cast_slice(&s.nodes));
        }
    }
}

/// A mesh and its set's stamps in one chunk of the arena.
#[derive(Debug)]
pub(crate) struct MeshPlacement {
    pub mesh: MeshWords,
    pub stamps: std::sync::Arc<StampWords>,
    /// The first words in the chunk.
    pub mesh_at: u32,
    pub stamps_at: u32,
}

impl MeshPlacement {
    pub(crate) fn positions(&self) -> u32 {
        self.mesh_at + self.mesh.positions
    }

    pub(crate) fn normals(&self) -> Option<u32> {
        self.mesh.normals.map(|at| self.mesh_at + at)
    }

    pub(crate) fn tangents(&self) -> Option<u32> {
        self.mesh.tangents.map(|at| self.mesh_at + at)
    }

    pub(crate) fn bounds(&self) -> u32 {
        self.mesh_at + self.mesh.bounds
    }

    /// The first word of an example.
    pub(crate) fn example(&self, example: usize) -> u32 {
        self.mesh_at + self.mesh.examples[example]
    }

    /// The longest displacement of an example on the mesh, m.
    pub(crate) fn longest(&self, example: usize) -> f32 {
        self.mesh.longest[example]
    }

    /// The first word of the windows, if a rim is held.
    pub(crate) fn windows(&self) -> Option<u32> {
        self.mesh.windows.map(|at| self.mesh_at + at)
    }

    /// The first words of the vertices' depth limits and of 1 - stiffness, where there are any.
    pub(crate) fn limits(&self) -> [Option<u32>; 2] {
        self.mesh.limits.map(|at| at.map(|at| self.mesh_at + at))
    }

    /// The first word of the tiles, if vertices follow nodes.
    pub(crate) fn tiles(&self) -> Option<u32> {
        self.mesh.tiles.map(|at| self.mesh_at + at)
    }

    /// The first word of an example's stamp.
    pub(crate) fn stamp(&self, example: usize) -> u32 {
        self.stamps_at + self.stamps.stamps[example]
    }
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
