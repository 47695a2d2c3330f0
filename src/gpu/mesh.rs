//! The words of a mesh: its vertices, how they follow nodes, and for a classic rule its examples. They do not change.

use super::layout::NONE;
use crate::base::error::Error;
use crate::base::memory::may_fail;
use crate::basis::{Rows, TILE};
use crate::example::blocks::DeltaBlocks;
use crate::example::mesh_lod::MeshLod;
use bytemuck::{cast_slice, pod_collect_to_vec};

/// Words of the head of an example's block: widths, groups, and the first words of displacements and of changes of normals.
const HEAD_WORDS: usize = 4;
/// Words of the head of a tile: `TILE_WORDS` in nodes.wgsl.
const TILE_WORDS: usize = 5;

/// The first words of the parts of a mesh, counted from the mesh.
#[derive(Debug)]
pub(crate) struct MeshParts {
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
}

impl MeshParts {
    /// Returns the words of a mesh too. Above 2^32 words only their number is right.
    pub(super) fn new(lod: &MeshLod) -> Result<(Self, Vec<u32>), Error> {
        let mut words = Vec::new();
        let mut put = |part: &[u32]| {
            let at = words.len() as u32;
            let bytes = 4 * (words.len() + part.len()) as u64;
            let failed = |_| Error::OutOfMemory { what: "a mesh and its examples".into(), bytes };
            may_fail(|| words.try_reserve(part.len())).map_err(failed)?;
            words.extend_from_slice(part);
            Ok(at)
        };
        let mesh = &lod.mesh;
        let positions = put(cast_slice(mesh.positions()))?;
        let normals = mesh.normals().map(|n| put(cast_slice(n))).transpose()?;
        let tangents = mesh.tangents().map(|t| put(cast_slice(t))).transpose()?;
        let mut examples = Vec::with_capacity(lod.anchored.len());
        for example in lod.anchored.iter() {
            examples.push(put(&example_heads(lod.blocks(), example))?);
            put(cast_slice(&example.words))?;
        }
        let mut limits = [None; 2];
        for (at, halves) in limits.iter_mut().zip(mesh.limits().parts()).filter(|(_, halves)| !halves.is_empty()) {
            // A file's arrays are aligned for their elements only.
            *at = Some(put(&pod_collect_to_vec(&halves[..]))?);
        }
        let tiles = put(&tile_words(&lod.rows))?;
        let most = lod.rows.tiles.iter().map(|t| t.most).max().unwrap_or(0);
        Ok((MeshParts { positions, normals, tangents, examples, limits, tiles, most }, words))
    }
}

/// The words of an example before its numbers.
fn example_heads(blocks: usize, example: &DeltaBlocks) -> Vec<u32> {
    let numbers = blocks + HEAD_WORDS * example.heads.len();
    let mut words = Vec::with_capacity(numbers);
    words.resize(blocks, NONE);
    for h in example.heads.iter() {
        words[h.block as usize] = words.len() as u32;
        let displacements = numbers + 2 * h.at as usize;
        let normals = displacements + 2 * crate::example::blocks::words(h.groups, h.width);
        words.extend([
            u32::from(h.width) | u32::from(h.normal_width) << 8,
            u32::from(h.groups) | u32::from(h.normal_groups) << 16,
            displacements as u32,
            normals as u32,
        ]);
    }
    words
}

/// The words of vertices that follow nodes, as nodes.wgsl reads them.
fn tile_words(rows: &Rows) -> Vec<u32> {
    let nodes = TILE_WORDS * rows.tiles.len();
    let weights = nodes + rows.nodes.len();
    let slopes = weights + rows.weights.len() / 4;
    let units = slopes + rows.slopes.len() / 4;
    let mut words = Vec::with_capacity(units + rows.slope_units.len());
    for (t, tile) in rows.tiles.iter().enumerate() {
        let first = tile.first as usize;
        let numbers = TILE * first / 4;
        let [node, weight, slope] = [nodes + first, weights + numbers, slopes + 2 * numbers];
        words.extend([node, tile.count as usize, weight, slope, units + TILE * t].map(|w| w as u32));
    }
    words.extend_from_slice(&rows.nodes);
    // A file's arrays are aligned for their elements only.
    words.extend(pod_collect_to_vec::<i8, u32>(&rows.weights));
    words.extend(pod_collect_to_vec::<i8, u32>(&rows.slopes));
    words.extend(rows.slope_units.iter().map(|u| u.to_bits()));
    words
}
