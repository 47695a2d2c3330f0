//! What does not change, in words: a mesh with its examples, and the stamps of its set.

use crate::examples::ExampleSet;
use crate::rim::Rim;
use crate::skin::Skin;
use crate::stamp::Node;
use bytemuck::{cast_slice, cast_slice_mut};

const NODE_WORDS: usize = size_of::<Node>() / 4;

/// Where the parts of a mesh begin, words from its own first.
#[derive(Debug)]
pub(crate) struct SkinWords {
    positions: u32,
    normals: Option<u32>,
    tangents: Option<u32>,
    /// Of each example's numbers.
    examples: Vec<u32>,
    windows: u32,
    total: u64,
}

impl SkinWords {
    pub(crate) fn new(skin: &Skin) -> Self {
        let mut at = Counter(0);
        let n = skin.vertex_count();
        SkinWords {
            positions: at.take(3 * n),
            normals: skin.mesh.normals().map(|_| at.take(3 * n)),
            tangents: skin.mesh.tangents().map(|_| at.take(4 * n)),
            examples: skin.anchored.iter().map(|a| at.take(2 * a.words.len())).collect(),
            windows: at.take(cast_slice::<_, u32>(&skin.rim.windows).len()),
            total: at.0,
        }
    }

    pub(crate) fn total(&self) -> u64 {
        self.total
    }

    /// Writes all of the skin that this was made from: as many words as it takes.
    pub(crate) fn write(&self, skin: &Skin, to: &mut [u32]) {
        let mut put = |at: u32, from: &[u32]| to[at as usize..][..from.len()].copy_from_slice(from);
        put(self.positions, cast_slice(skin.mesh.positions()));
        if let (Some(at), Some(normals)) = (self.normals, skin.mesh.normals()) {
            put(at, cast_slice(normals));
        }
        if let (Some(at), Some(tangents)) = (self.tangents, skin.mesh.tangents()) {
            put(at, cast_slice(tangents));
        }
        self.examples.iter().zip(&skin.anchored).for_each(|(at, a)| put(*at, cast_slice(&a.words)));
        put(self.windows, cast_slice(&skin.rim.windows));
    }
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
pub(crate) struct Place {
    pub skin: SkinWords,
    pub stamps: std::sync::Arc<StampWords>,
    /// Words before the skin, and before the stamps.
    pub skin_at: u32,
    pub stamps_at: u32,
}

impl Place {
    pub(crate) fn positions(&self) -> u32 {
        self.skin_at + self.skin.positions
    }

    pub(crate) fn normals(&self) -> Option<u32> {
        self.skin.normals.map(|at| self.skin_at + at)
    }

    pub(crate) fn tangents(&self) -> Option<u32> {
        self.skin.tangents.map(|at| self.skin_at + at)
    }

    /// An example's numbers, from word `at` (of eight bytes) on.
    pub(crate) fn numbers(&self, example: usize, at: usize) -> u32 {
        self.skin_at + self.skin.examples[example] + 2 * at as u32
    }

    /// The windows of a block, if any vertex of it is near a held rim.
    pub(crate) fn window(&self, rim: &Rim, block: usize) -> Option<u32> {
        let window = *rim.blocks.get(block).filter(|w| **w != Rim::CLEAR)?;
        Some(self.skin_at + self.skin.windows + window * (size_of::<crate::rim::WindowBlock>() / 4) as u32)
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
