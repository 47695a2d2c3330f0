//! Packs a frame's work for the kernels: blocks to write, their targets, and what moves them.
//!
//! The CPU lists the blocks to write, and each instance's dents once. The kernels find out which dents reach a block. They test
//! more dents than [`crate::deform`] does; a dent that does not reach a vertex adds zeros there.

use super::layout::{
    AT_REST, BlockWork, Call, CarriedWork, ClassicHit, DentHead, DentPart, LIMITED, LookupWork, NONE, Row, TargetWork,
};
use super::target::TargetState;
use super::vertices::VertexStream;
use super::{BLOCK_VERTICES, Encoding};
use crate::base::error::Error;
use crate::base::math::Aabb;
use crate::basis::ONE;
use crate::classic::ClassicState;
use crate::damage::carried::{Carried, Lookup};
use crate::damage::dent::{Part, Reach};
use crate::deform::view::{DamageView, NodeSteps, NodeView, may_reach};
use crate::example::mesh_lod::MeshLod;
use bytemuck::{Pod, cast, cast_slice};
use glam::{Mat2, Vec3};
use std::ops::Range;

/// Dents reach a little further than exactly, for devices that round otherwise.
const SLACK: f32 = 1.0001;
/// Room for the rounding of f32 in a bound on summed lengths.
const ROUNDING: f32 = 1.00001;
const ROW_WORDS: usize = size_of::<Row>() / 4;

/// The lists of a frame. They are reused from frame to frame.
#[derive(Debug, Default)]
pub(super) struct FrameWork {
    blocks: Vec<BlockWork>,
    targets: Vec<TargetWork>,
    /// For each target its dents: a [`DentHead`], then its [`DentPart`]s. For a classic rule [`ClassicHit`]s.
    parts: Vec<Row>,
    /// [`CarriedWork`]s, each with its [`LookupWork`]s.
    carried: Vec<Row>,
    /// States of vertices under a classic rule: position and, where a kernel writes normals, normal.
    states: Vec<[f32; 3]>,
    /// Parts that tolerances left out.
    pub parts_skipped: u32,
}

/// First rows of the lists.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WorkOffsets {
    targets: usize,
    parts: usize,
    carried: usize,
    states: usize,
    rows: usize,
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
        self.parts.clear();
        self.carried.clear();
        self.states.clear();
        self.parts_skipped = 0;
    }

    /// Number of blocks so far.
    pub(super) fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// Rows of carried examples so far.
    pub(super) fn lookups(&self) -> usize {
        self.carried.len()
    }

    /// Where the lists will lie.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for 2^32 bytes or more.
    pub(super) fn offsets(&self) -> Result<WorkOffsets, Error> {
        let rows = |bytes: usize| bytes.div_ceil(size_of::<Row>());
        let targets = rows(size_of_val(&self.blocks[..]));
        let parts = targets + rows(size_of_val(&self.targets[..]));
        let carried = parts + self.parts.len();
        let states = carried + self.carried.len();
        let offsets =
            WorkOffsets { targets, parts, carried, states, rows: states + rows(size_of_val(&self.states[..])) };
        if offsets.bytes() > u64::from(u32::MAX) {
            let what = format!("{} bytes for the work of a frame; at most 4294967295", offsets.bytes());
            return Err(Error::Unsupported { what });
        }
        Ok(offsets)
    }

    /// Writes the lists one after another, each from a row on.
    pub(super) fn write(&self, to: &mut [u32]) {
        fn put<'a, T: Pod>(to: &'a mut [u32], list: &[T]) -> &'a mut [u32] {
            let words: &[u32] = cast_slice(list);
            let (here, after) = to.split_at_mut(words.len().next_multiple_of(ROW_WORDS));
            here[..words.len()].copy_from_slice(words);
            here[words.len()..].fill(0);
            after
        }
        let to = put(to, &self.blocks);
        let to = put(to, &self.targets);
        let to = put(to, &self.parts);
        let to = put(to, &self.carried);
        put(to, &self.states);
    }

    /// Adds blocks of the next target. Returns their indices among all.
    pub(super) fn add_blocks(&mut self, blocks: impl Iterator<Item = usize>) -> Range<usize> {
        let target_index = self.targets.len() as u32;
        let before = self.blocks();
        self.blocks.extend(blocks.map(|block| BlockWork { target_index, block: block as u32 }));
        before..self.blocks()
    }

    /// The blocks at these indices, as they were added.
    pub(super) fn listed(&self, indices: &Range<usize>) -> impl Iterator<Item = usize> {
        self.blocks[indices.clone()].iter().map(|b| b.block as usize)
    }

    /// Adds a target of an instance with marks. Returns a box that holds its vertices.
    pub(super) fn add_marks(&mut self, shown: Shown<'_>) -> Aabb {
        let Shown { view, mesh, target } = shown;
        let begin = self.parts.len();
        let threshold = view.threshold;
        let (mut dents, mut longest) = (0, 0.0);
        for dent in view.damage.dents() {
            let reach = dent.reach();
            let head = self.parts.len();
            self.parts.extend_from_slice(&[[0; 4]; size_of::<DentHead>() / size_of::<Row>()]);
            let mut parts = 0;
            for part in &dent.parts {
                let scale = dent.strength * if let Part::Anchored(_, scale) = part { *scale } else { 1.0 };
                // A scale of 0 makes every displacement zero, whatever is dropped.
                let dropped = if scale == 0.0 { 0.0 } else { threshold / scale.abs() };
                let place = &target.mesh.place;
                let work = match part {
                    Part::Carried(carried) => {
                        let source = self.carried.len() as u32;
                        let mut lookups = 0;
                        for lookup in carried.lookups.iter() {
                            if !dent.shows_carried(lookup, threshold) {
                                self.parts_skipped += 1;
                                continue;
                            }
                            if lookups == 0 {
                                self.carried.extend_from_slice(&cast::<_, [Row; 4]>(carried_work(carried)));
                            }
                            let nodes = place.stamp(lookup.example);
                            self.carried.extend_from_slice(&cast::<_, [Row; 6]>(lookup_work(lookup, nodes)));
                            lookups += 1;
                            longest += lookup.longest * scale.abs();
                        }
                        if lookups == 0 {
                            continue;
                        }
                        let dropped_square = dropped_square(dropped);
                        DentPart { scale, normal_scale: 0.0, dropped_square, lookups, source, padding: [0; 3] }
                    }
                    // Only sets whose vertices follow nodes have these.
                    Part::Predicted(..) => continue,
                    Part::Anchored(example, own) => {
                        if !dent.shows_anchored(mesh, (*example, *own), threshold) {
                            self.parts_skipped += 1;
                            continue;
                        }
                        longest += place.longest(*example) * scale.abs();
                        anchored_part(mesh, *example, (scale, dropped), place.example(*example))
                    }
                };
                self.parts.extend_from_slice(&cast::<_, [Row; 2]>(work));
                parts += 1;
            }
            if parts == 0 {
                self.parts.truncate(head);
                continue;
            }
            dents += 1;
            let reach_square = (reach.square * SLACK).min(f32::MAX);
            let dent = DentHead { contact: reach.contact.to_array(), reach_square, parts, padding: [0; 3] };
            let rows: [Row; 2] = cast(dent);
            self.parts[head..head + rows.len()].copy_from_slice(&rows);
        }
        let limit = view.limit(longest);
        let flags = if limit.is_some() { LIMITED } else { 0 };
        self.add_target(shown, (begin, longest), (flags, limit.unwrap_or(0.0), NONE));
        let grown = Vec3::splat(longest.min(view.depth_limit) * ROUNDING);
        let mut bounds = mesh.mesh.bounds();
        if dents > 0 {
            for dent in view.damage.dents() {
                let mut near = bounds_within(&dent.reach(), &mesh.mesh.bounds());
                (near.min, near.max) = (near.min - grown, near.max + grown);
                bounds.union(&near);
            }
        }
        bounds
    }

    /// Adds a target of an instance whose vertices follow nodes: the displacements of all nodes. Returns a box that holds its vertices.
    pub(super) fn add_nodes(&mut self, shown: Shown<'_>, nodes: &NodeView<'_>) -> Aabb {
        let begin = self.parts.len();
        for pair in nodes.steps.chunks(2) {
            let node = |n: &NodeSteps| n.map(|x| u32::from(x as u16));
            let [a, b] = [node(&pair[0]), pair.get(1).map_or([0; 4], node)];
            self.parts.push([a[0] | a[1] << 16, a[2], b[0] | b[1] << 16, b[2]]);
        }
        let length = |n: &NodeSteps| Vec3::new(n[0].into(), n[1].into(), n[2].into()).length_squared();
        let farthest = nodes.steps.iter().map(length).fold(0.0, f32::max).sqrt() * nodes.step;
        let most = shown.mesh.rows.as_ref().map_or(0, |rows| rows.tiles.iter().map(|t| t.most).max().unwrap_or(0));
        let longest = farthest * (most as f32 / ONE as f32);
        let limit = shown.view.limit(longest);
        let flags = if limit.is_some() { LIMITED } else { 0 };
        self.add_target(shown, (begin, longest), (flags, limit.unwrap_or(0.0), NONE));
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
        let (begin, mut given, mut flags) = (self.parts.len(), NONE, 0);
        let all = 0..mesh.vertex_count();
        match since.and_then(|epoch| state.applied_since(epoch)) {
            Some(hits) => {
                for hit in hits {
                    let steps = mesh.anchored[hit.example as usize].steps;
                    self.parts.push(cast(ClassicHit {
                        example: target.mesh.place.example(hit.example as usize),
                        position_step: steps.position,
                        normal_step: steps.normal,
                        weight: hit.weight,
                    }));
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
        self.add_target(shown, (begin, f32::INFINITY), (flags, blend_constant, given));
        // A vertex with a limit lies between its base position and that of its state.
        let mut bounds = if mesh.mesh.limits().is_empty() { Aabb::EMPTY } else { mesh.mesh.bounds() };
        all.for_each(|v| bounds.add(state.vertices().positions[v]));
        bounds
    }

    /// Adds a target whose parts were added from `begin` on. They move no vertex further than `longest`, m.
    fn add_target(
        &mut self,
        shown: Shown<'_>,
        (begin, longest): (usize, f32),
        (flags, limit, given_state): (u32, f32, u32),
    ) {
        let TargetState { mesh, layout, first, .. } = shown.target;
        let place = &mesh.place;
        let word = |bytes: u64| (bytes / 4) as u32;
        let stream = |s: Option<VertexStream<Encoding>>| {
            s.map_or((0, 0, 0), |s| (word(first.wrapping_add(s.offset)), word(s.stride), s.format as u32))
        };
        let (position_at, position_stride, position_format) = stream(Some(layout.positions));
        let (normal_at, normal_stride, normal_format) = stream(layout.normals);
        let (tangent_at, tangent_stride, tangent_format) = stream(layout.tangents);
        // A kernel may read an attribute that the target does not have; it writes none of it.
        let base_positions = place.positions();
        let reached = shown.mesh.mesh.limits().least().iter().any(|least| may_reach(longest, *least));
        let [depths, gives] = place.limits().map(|at| at.filter(|_| reached).unwrap_or(NONE));
        self.targets.push(TargetWork {
            base_positions,
            base_normals: place.normals().unwrap_or(base_positions),
            base_tangents: place.tangents().unwrap_or(base_positions),
            block_bounds: place.bounds(),
            position_at,
            position_stride,
            normal_at,
            normal_stride,
            tangent_at,
            tangent_stride,
            formats: position_format | normal_format << 8 | tangent_format << 16,
            vertices: shown.mesh.vertex_count() as u32,
            bias: layout.bias,
            limit,
            scale: layout.scale,
            flags,
            parts_begin: begin as u32,
            parts_end: self.parts.len() as u32,
            windows: place.windows().unwrap_or(NONE),
            given_state,
            depths,
            gives,
            step: shown.view.step(),
            per_step: 1.0 / shown.view.step(),
            coarse: shown.view.coarse,
            tiles: place.tiles().unwrap_or(NONE),
            node_step: shown.view.nodes.map_or(0.0, |nodes| nodes.step),
            padding: 0,
        });
    }
}

impl WorkOffsets {
    /// Size of the lists in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        (size_of::<Row>() * self.rows) as u64
    }

    /// Size of the lists in words.
    pub(crate) fn words(&self) -> usize {
        ROW_WORDS * self.rows
    }

    /// The call of a dispatch that writes these blocks, and its workgroups: how many in a row, at most `most`, and rows.
    pub(crate) fn call(&self, (blocks, classic): (&Range<usize>, bool), workgroup: u32, most: u32) -> (Call, [u32; 2]) {
        // The plan has checked that there are less than 2^32 invocations.
        let (count, split) = (blocks.len() as u32, (BLOCK_VERTICES / workgroup).ilog2());
        let groups = count << split;
        let across = groups.min(most);
        let call = Call {
            blocks: blocks.start as u32,
            targets: self.targets as u32,
            parts: self.parts as u32,
            carried: if classic { self.states } else { self.carried } as u32,
            row: across,
            count,
            split,
        };
        (call, [across, groups.div_ceil(across)])
    }
}

/// The part of a box that holds everything within reach.
fn bounds_within(reach: &Reach, all: &Aabb) -> Aabb {
    let radius = Vec3::splat(reach.square.sqrt() * SLACK);
    Aabb { min: all.min.max(reach.contact - radius), max: all.max.min(reach.contact + radius) }
}

fn anchored_part(mesh: &MeshLod, example: usize, (scale, dropped): (f32, f32), source: u32) -> DentPart {
    let steps = mesh.anchored[example].steps;
    DentPart {
        scale: steps.position * scale,
        normal_scale: steps.normal * scale,
        dropped_square: dropped_square(dropped / steps.position),
        lookups: 0,
        source,
        padding: [0; 3],
    }
}

fn carried_work(c: &Carried) -> CarriedWork {
    let [to_frame_x, to_frame_y, to_frame_z] = c.to_frame.to_cols_array_2d();
    CarriedWork {
        contact: c.contact.to_array(),
        padding_contact: 0,
        to_frame_x,
        padding_x: 0,
        to_frame_y,
        padding_y: 0,
        to_frame_z,
        padding_z: 0,
    }
}

/// `nodes` is the first word of the stamp's nodes.
fn lookup_work(l: &Lookup, nodes: u32) -> LookupWork {
    let columns = |m: &Mat2| m.to_cols_array_2d();
    let [to_grid_x, to_grid_y] = columns(&l.to_grid);
    let [displacement_x, displacement_y] = columns(&l.displacement);
    let [normal_x, normal_y] = columns(&l.normal_change);
    LookupWork {
        to_grid_x,
        to_grid_y,
        origin: l.origin.to_array(),
        last: l.last.to_array(),
        nodes,
        columns: l.dims.x,
        stretch_square: l.stretch_square,
        height: l.height,
        displacement_x,
        displacement_y,
        displacement_z: l.displacement_z,
        fade: l.fade,
        normal_z: l.normal_change_z,
        padding: 0,
        normal_x,
        normal_y,
    }
}

/// The square for `DentPart`: displacements of this length or less are dropped; 0 keeps all.
fn dropped_square(dropped: f32) -> f32 {
    if dropped > 0.0 { dropped * dropped } else { -1.0 }
}
