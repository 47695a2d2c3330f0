//! Packs a frame's work for the kernels: blocks to write, their targets, and what moves them.

use super::layout::{AT_REST, BlockWork, Call, ClassicHit, LIMITED, NONE, Row, TargetWork};
use super::target::TargetState;
use super::vertices::VertexStream;
use super::{BLOCK_VERTICES, Encoding};
use crate::base::error::Error;
use crate::base::math::Aabb;
use crate::basis::{ONE, TILE};
use crate::classic::ClassicState;
use crate::deform::view::{DamageView, NodeSteps, NodeView, may_reach};
use crate::example::mesh_lod::MeshLod;
use bytemuck::{Pod, Zeroable, cast_slice, cast_slice_mut};
use glam::Vec3;
use std::ops::Range;

/// Room for the rounding of f32 in a bound on summed lengths.
const ROUNDING: f32 = 1.00001;
const ROW_WORDS: usize = size_of::<Row>() / 4;
/// Tiles of a block.
const TILES: usize = BLOCK_VERTICES as usize / TILE;

/// The lists of a frame. They are reused from frame to frame.
#[derive(Debug, Default)]
pub(super) struct FrameWork {
    blocks: Vec<BlockWork>,
    targets: Vec<TargetWork>,
    /// For each target whose vertices follow nodes, which nodes.
    followed: Vec<Followed>,
    /// The rows of all of these.
    node_rows: u32,
    /// Hits of classic rules.
    hits: Vec<ClassicHit>,
    /// States of vertices under a classic rule: position and, where a kernel writes normals, normal.
    states: Vec<[f32; 3]>,
}

/// The nodes that a job's blocks follow.
#[derive(Debug)]
struct Followed {
    job: usize,
    /// Rows of the body's nodes, two each.
    rows: Range<u32>,
}

/// A target, and the damage that it shows.
#[derive(Clone, Copy)]
pub(super) struct Shown<'a> {
    pub view: DamageView<'a>,
    pub mesh: &'a MeshLod,
    pub target: &'a TargetState,
}

impl FrameWork {
    pub(super) fn clear(&mut self) {
        self.blocks.clear();
        self.targets.clear();
        self.followed.clear();
        self.node_rows = 0;
        self.hits.clear();
        self.states.clear();
    }

    /// The size of the lists in words, and two calls with the lists' first rows: for vertices that follow nodes, and for classic rules.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for 2^32 bytes or more.
    pub(super) fn layout(&self) -> Result<(usize, [Call; 2]), Error> {
        let rows = |bytes: usize| bytes.div_ceil(size_of::<Row>());
        let targets = rows(size_of_val(&self.blocks[..]));
        let nodes = targets + rows(size_of_val(&self.targets[..]));
        let hits = nodes + self.node_rows as usize;
        let states = hits + rows(size_of_val(&self.hits[..]));
        let words = ROW_WORDS * (states + rows(size_of_val(&self.states[..])));
        let bytes = 4 * words as u64;
        if bytes > u64::from(u32::MAX) {
            let what = format!("{bytes} bytes for the work of a frame; at most 4294967295");
            return Err(Error::Unsupported { what });
        }
        let [targets, nodes, hits, states] = [targets, nodes, hits, states].map(|row| row as u32);
        Ok((words, [nodes, hits].map(|parts| Call { targets, parts, states, ..Call::zeroed() })))
    }

    /// Writes the lists one after another, each from a row on.
    ///
    /// `steps` gives the displacements of all nodes of a job's body. They are most of the bytes, so they are copied once: to where the device
    /// reads them.
    pub(super) fn write<'s>(&self, steps: impl Fn(usize) -> &'s [NodeSteps], to: &mut [u32]) {
        fn put<'a, T: Pod>(to: &'a mut [u32], list: &[T]) -> &'a mut [u32] {
            let words: &[u32] = cast_slice(list);
            let (here, after) = to.split_at_mut(words.len().next_multiple_of(ROW_WORDS));
            here[..words.len()].copy_from_slice(words);
            here[words.len()..].fill(0);
            after
        }
        let to = put(to, &self.blocks);
        let mut to = put(to, &self.targets);
        for Followed { job, rows } in &self.followed {
            let (here, after) = to.split_at_mut(ROW_WORDS * rows.len());
            let here: &mut [NodeSteps] = cast_slice_mut(here);
            let steps = steps(*job).get(2 * rows.start as usize..).unwrap_or_default();
            let (moved, rest) = here.split_at_mut(steps.len().min(here.len()));
            moved.copy_from_slice(&steps[..moved.len()]);
            rest.fill([0; 4]);
            to = after;
        }
        let to = put(to, &self.hits);
        put(to, &self.states);
    }

    /// Adds blocks of the next target. Returns their indices among all.
    pub(super) fn add_blocks(&mut self, blocks: impl Iterator<Item = usize>) -> Range<usize> {
        let target_index = self.targets.len() as u32;
        let before = self.blocks.len();
        self.blocks.extend(blocks.map(|block| BlockWork { target_index, block: block as u32 }));
        before..self.blocks.len()
    }

    /// The blocks at these indices, as they were added.
    pub(super) fn listed(&self, indices: &Range<usize>) -> impl Iterator<Item = usize> {
        self.blocks[indices.clone()].iter().map(|b| b.block as usize)
    }

    /// Adds a target of an instance whose vertices follow nodes: the displacements of the nodes from the first to the last that these
    /// blocks of it follow. Returns a box that holds its vertices.
    pub(super) fn add_nodes(
        &mut self,
        shown: Shown<'_>,
        job: usize,
        nodes: &NodeView<'_>,
        blocks: &Range<usize>,
    ) -> Aabb {
        let (rows, mut first, mut end) = (&shown.mesh.rows, u32::MAX, 0);
        for block in self.listed(blocks) {
            let tiles = block * TILES..((block + 1) * TILES).min(rows.tiles.len());
            for ends in tiles.filter_map(|t| Some((rows.nodes_of(t).first()?, rows.nodes_of(t).last()?))) {
                (first, end) = (first.min(*ends.0), end.max(*ends.1 + 1));
            }
        }
        // Two nodes a row.
        let (first, end) = ((first / 2).min(end.div_ceil(2)), end.div_ceil(2));
        let begin = self.node_rows;
        self.node_rows += end - first;
        self.followed.push(Followed { job, rows: first..end });
        let longest = f32::from(nodes.farthest) * nodes.step * (shown.target.mesh.parts.most as f32 / ONE as f32);
        let limit = Some(shown.view.depth_limit).filter(|limit| may_reach(longest, *limit));
        self.targets.push(TargetWork {
            limit: limit.unwrap_or(0.0),
            flags: if limit.is_some() { LIMITED } else { 0 },
            node_step: nodes.step,
            // The kernel counts rows from the body's first node on.
            parts_begin: begin.wrapping_sub(first),
            tiles: shown.target.mesh.at + shown.target.mesh.parts.tiles,
            ..shown.work(longest)
        });
        let grown = Vec3::splat(longest.min(shown.view.depth_limit) * ROUNDING);
        let all = shown.mesh.mesh.bounds();
        Aabb { min: all.min - grown, max: all.max + grown }
    }

    /// Adds a target of an instance with a classic rule: the hits since the epoch of the device's state, or the state itself if
    /// the device has none or it is too old. Returns a box that holds the vertices.
    pub(super) fn add_classic(
        &mut self,
        shown: Shown<'_>,
        (state, blend_constant): (&ClassicState, f32),
        normals: bool,
        since: Option<u64>,
    ) -> Aabb {
        let Shown { view, mesh, target } = shown;
        let (begin, mut given, mut flags) = (self.hits.len() as u32, NONE, 0);
        let all = 0..mesh.vertex_count();
        match since.and_then(|epoch| state.applied_since(epoch)) {
            Some(hits) => {
                for hit in hits {
                    let steps = mesh.anchored[hit.example as usize].steps;
                    self.hits.push(ClassicHit {
                        example: target.mesh.at + target.mesh.parts.examples[hit.example as usize],
                        position_step: steps.position,
                        normal_step: steps.normal,
                        weight: hit.weight,
                    });
                }
            }
            None if view.changes.blocks[0].iter().all(|changed| *changed == 0) => flags = AT_REST,
            None => {
                given = 3 * self.states.len() as u32;
                for v in all.clone() {
                    self.states.push(state.vertices().positions[v].to_array());
                    if normals {
                        self.states.push(state.vertices().normals.get(v).copied().unwrap_or(Vec3::ZERO).to_array());
                    }
                }
            }
        }
        self.targets.push(TargetWork {
            limit: blend_constant,
            flags,
            parts_begin: begin,
            parts_end: self.hits.len() as u32,
            given_state: given,
            ..shown.work(f32::INFINITY)
        });
        // A vertex with a limit lies between its base position and that of its state.
        let mut bounds = if mesh.mesh.limits().is_empty() { Aabb::EMPTY } else { mesh.mesh.bounds() };
        all.for_each(|v| bounds.add(state.vertices().positions[v]));
        bounds
    }
}

impl Shown<'_> {
    /// What the target has under every rule. Its vertices move no further than `longest`, m.
    fn work(&self, longest: f32) -> TargetWork {
        let TargetState { mesh, layout, first, .. } = self.target;
        let parts = &mesh.parts;
        let at = |part: u32| mesh.at + part;
        let word = |bytes: u64| (bytes / 4) as u32;
        let stream = |s: Option<VertexStream<Encoding>>| {
            s.map_or((0, 0, 0), |s| (word(first.wrapping_add(s.offset)), word(s.stride), s.format as u32))
        };
        let [
            (position_at, position_stride, position_format),
            (normal_at, normal_stride, normal_format),
            (tangent_at, tangent_stride, tangent_format),
        ] = layout.streams.map(stream);
        // A kernel may read an attribute that the target does not have; it writes none of it.
        let base_positions = at(parts.positions);
        let reached = self.mesh.mesh.limits().least().iter().any(|least| may_reach(longest, *least));
        let [depths, gives] = parts.limits.map(|part| part.filter(|_| reached).map_or(NONE, at));
        TargetWork {
            base_positions,
            base_normals: parts.normals.map_or(base_positions, at),
            base_tangents: parts.tangents.map_or(base_positions, at),
            vertices: self.mesh.vertex_count() as u32,
            position_at,
            position_stride,
            normal_at,
            normal_stride,
            tangent_at,
            tangent_stride,
            formats: position_format | normal_format << 8 | tangent_format << 16,
            bias: layout.bias,
            scale: layout.scale,
            depths,
            gives,
            ..TargetWork::zeroed()
        }
    }
}

impl Call {
    /// The call of a dispatch that writes these blocks with so many vertices a workgroup, and its workgroups: how many in a row, at
    /// most `most`, and rows.
    pub(super) fn of(self, blocks: &Range<usize>, vertices: u32, most: u32) -> (Call, [u32; 2]) {
        // The plan has checked that there are less than 2^32 vertices.
        let (count, split) = (blocks.len() as u32, (BLOCK_VERTICES / vertices).ilog2());
        let groups = count << split;
        let row = groups.min(most);
        (Call { blocks: blocks.start as u32, row, count, split, ..self }, [row, groups.div_ceil(row)])
    }
}
