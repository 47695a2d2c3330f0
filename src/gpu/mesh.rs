//! What does not change, in words: a mesh with its examples, and the stamps of its set.

use super::layout::NONE;
use crate::example::blocks::DeltaBlocks;
use crate::example::mesh_lod::MeshLod;
use crate::example::set::ExampleSet;
use crate::example::stamp::Node;
use crate::mesh::rim::{Rim, WindowBlock};
use bytemuck::{cast_slice, cast_slice_mut};

const NODE_WORDS: usize = size_of::<Node>() / 4;
const WINDOW_WORDS: usize = size_of::<WindowBlock>() / 4;
/// Of a block of an example: widths, groups, where displacements and changes of normals lie from the example's first word.
const HEAD_WORDS: usize = 4;

/// Where the parts of a mesh begin, words from its own first.
#[derive(Debug)]
pub(crate) struct MeshWords {
    positions: u32,
    normals: Option<u32>,
    tangents: Option<u32>,
    /// Six words a block: least coordinates, then greatest.
    bounds: u32,
    /// Of each example what is stored of which block: a word a block, where its head lies from here, [`NONE`] where nothing is
    /// stored; then the heads; then the numbers.
    examples: Vec<u32>,
    /// Longest displacement of each example, m.
    longest: Vec<f32>,
    /// Of each block a word, where its window lies from here, or [`NONE`]; then the windows. Nothing where nothing is held.
    windows: Option<u32>,
    total: u64,
}

impl MeshWords {
    pub(crate) fn new(skin: &MeshLod) -> Self {
        let mut at = Counter(0);
        let n = skin.vertex_count();
        MeshWords {
            positions: at.take(3 * n),
            normals: skin.mesh.normals().map(|_| at.take(3 * n)),
            tangents: skin.mesh.tangents().map(|_| at.take(4 * n)),
            bounds: at.take(6 * skin.blocks()),
            examples: skin.anchored.iter().map(|a| at.take(numbers_at(skin, a) + 2 * a.words.len())).collect(),
            longest: skin.anchored.iter().map(|a| a.heads.iter().map(|h| h.longest).fold(0.0, f32::max)).collect(),
            windows: (!skin.rim.windows.is_empty())
                .then(|| at.take(skin.blocks() + skin.rim.windows.len() * WINDOW_WORDS)),
            total: at.0,
        }
    }

    pub(crate) fn total(&self) -> u64 {
        self.total
    }

    /// Writes all of the skin that this was made from: as many words as it takes.
    pub(crate) fn write(&self, skin: &MeshLod, to: &mut [u32]) {
        let mut put = |at: u32, from: &[u32]| to[at as usize..][..from.len()].copy_from_slice(from);
        put(self.positions, cast_slice(skin.mesh.positions()));
        if let (Some(at), Some(normals)) = (self.normals, skin.mesh.normals()) {
            put(at, cast_slice(normals));
        }
        if let (Some(at), Some(tangents)) = (self.tangents, skin.mesh.tangents()) {
            put(at, cast_slice(tangents));
        }
        let corners = skin.block_bounds.iter().flat_map(|b| [b.min.to_array(), b.max.to_array()]);
        let corners: Vec<[f32; 3]> = corners.collect();
        put(self.bounds, cast_slice(&corners));
        for (at, a) in self.examples.iter().zip(&skin.anchored) {
            let (blocks, numbers) = (skin.blocks(), numbers_at(skin, a));
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
            let blocks = skin.blocks();
            let place = |w: &u32| if *w == Rim::CLEAR { NONE } else { (blocks + *w as usize * WINDOW_WORDS) as u32 };
            let table: Vec<u32> = skin.rim.blocks.iter().map(place).collect();
            put(at, &table);
            put(at + blocks as u32, cast_slice(&skin.rim.windows));
        }
    }
}

/// Words of an example before its numbers.
fn numbers_at(skin: &MeshLod, a: &DeltaBlocks) -> usize {
    skin.blocks() + HEAD_WORDS * a.heads.len()
}

/// Where the nodes of a set's stamps begin, words from the first.
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

/// A mesh and its set's stamps, placed in one arena.
#[derive(Debug)]
pub(crate) struct MeshPlacement {
    pub mesh: MeshWords,
    pub stamps: std::sync::Arc<StampWords>,
    /// Words before the skin, and before the stamps.
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

    /// What an example stores of the mesh.
    pub(crate) fn example(&self, example: usize) -> u32 {
        self.mesh_at + self.mesh.examples[example]
    }

    /// Longest displacement of an example on the mesh, m.
    pub(crate) fn longest(&self, example: usize) -> f32 {
        self.mesh.longest[example]
    }

    /// The windows, if anything is held.
    pub(crate) fn windows(&self) -> Option<u32> {
        self.mesh.windows.map(|at| self.mesh_at + at)
    }

    /// The nodes of an example's stamp.
    pub(crate) fn stamp(&self, example: usize) -> u32 {
        self.stamps_at + self.stamps.stamps[example]
    }
}

struct Counter(u64);

impl Counter {
    /// Where the next `words` begin. Above 2^32 it is the total that tells.
    fn take(&mut self, words: usize) -> u32 {
        let at = self.0 as u32;
        self.0 += words as u64;
        at
    }
}
