//! A frame's work in words: what to write, and what moves it.
//!
//! The CPU names the blocks to write and hands over each instance's dents once; the kernels find out which of these reach a
//! block. That they look at more dents than [`crate::deform`] does changes nothing: a dent that does not reach a vertex adds
//! zeros there.

use super::NONE;
use super::format::Layout;
use super::skin::Place;
use crate::Error;
use crate::base::math::Aabb;
use crate::classic::State;
use crate::damage::dent::{Carried, DentPart, Reach};
use crate::deform::kernel::Lengths;
use crate::deform::view::DamageView;
use crate::example::mesh_lod::MeshLod;
use crate::example::stamp::{FACING, Stamp};
use glam::{Mat3, Vec3};
use std::ops::Range;

/// Words of each kind, as in the kernels.
pub(super) const BLOCK_WORDS: usize = 2;
const PART_WORDS: usize = 8;
const CARRIED_WORDS: usize = 48;
const TARGET_WORDS: usize = 24;

/// Flags of a target …
const SEVERAL: u32 = 1;
const SQUARES: u32 = 2;
const LONGEST: u32 = 4;
const LIMITED: u32 = 8;
/// … of one of a classic rule …
const AT_REST: u32 = 1;
/// … and of a part.
const IS_CARRIED: u32 = 1;

/// A dent reaches a little further than exact, for devices that round otherwise.
const SLACK: f32 = 1.0001;

/// Lists of words, used over and over.
#[derive(Debug, Default)]
pub(crate) struct Frame {
    /// One a block to write: its target, and its place in the mesh.
    blocks: Vec<u32>,
    /// One a target.
    targets: Vec<u32>,
    /// Of each target's dents, one behind the other, a head and then the parts. Of classic instances the hits.
    parts: Vec<u32>,
    /// One for each carried part. Of classic instances, states of vertices.
    carried: Vec<u32>,
    /// Parts that tolerances left out.
    pub left_out: u32,
}

/// Where the lists begin, words from the first one's first, and words in all: multiples of four, as the kernels read them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Offsets {
    pub blocks: usize,
    pub targets: usize,
    pub parts: usize,
    pub carried: usize,
    pub total: usize,
}

/// One target as its instance now is.
pub(crate) struct Shown<'a> {
    pub view: DamageView<'a>,
    pub skin: &'a MeshLod,
    pub place: &'a Place,
    pub layout: &'a Layout,
    /// Bytes before it in the buffer as it is bound, modulo 2^64.
    pub first: u64,
}

impl Frame {
    pub(crate) fn clear(&mut self) {
        [&mut self.blocks, &mut self.targets, &mut self.parts, &mut self.carried].into_iter().for_each(Vec::clear);
        self.left_out = 0;
    }

    /// Blocks so far.
    pub(crate) fn blocks(&self) -> usize {
        self.blocks.len() / BLOCK_WORDS
    }

    /// Where the lists will lie, if they take less than 2^32 bytes.
    ///
    /// # Errors
    /// [`Error::Unsupported`].
    pub(crate) fn offsets(&self) -> Result<Offsets, Error> {
        let targets = self.blocks.len().next_multiple_of(4);
        let parts = targets + self.targets.len();
        let carried = parts + self.parts.len();
        let total = (carried + self.carried.len()).next_multiple_of(4);
        if total > u32::MAX as usize / 4 {
            let what = format!("{} bytes for the work of a frame; at most 4294967295", 4 * total as u64);
            return Err(Error::Unsupported { what });
        }
        Ok(Offsets { blocks: 0, targets, parts, carried, total })
    }

    /// Writes all lists, one behind the other.
    pub(crate) fn write(&self, to: &mut [u32]) {
        let mut at = 0;
        for list in [&self.blocks, &self.targets, &self.parts, &self.carried] {
            let end = (at + list.len()).next_multiple_of(4);
            to[at..at + list.len()].copy_from_slice(list);
            to[at + list.len()..end].fill(0);
            at = end;
        }
    }

    /// Adds blocks of the target that was added last, and answers their places among all.
    pub(crate) fn add_blocks(&mut self, blocks: impl Iterator<Item = usize>) -> Range<usize> {
        let target = (self.targets.len() / TARGET_WORDS) as u32 - 1;
        let before = self.blocks();
        for block in blocks {
            self.blocks.extend_from_slice(&[target, block as u32]);
        }
        before..self.blocks()
    }

    /// The blocks at these places, as they were added.
    pub(crate) fn listed(&self, places: &Range<usize>) -> impl Iterator<Item = usize> {
        let words = &self.blocks[places.start * BLOCK_WORDS..places.end * BLOCK_WORDS];
        words.chunks_exact(BLOCK_WORDS).map(|w| w[1] as usize)
    }

    /// Adds a target of an instance with marks, and answers a box that holds its vertices.
    pub(crate) fn target(&mut self, shown: &Shown<'_>) -> Aabb {
        let Shown { view, skin, place, .. } = *shown;
        let begin = self.parts.len() / PART_WORDS;
        let (least, set) = (view.threshold, view.set);
        let (mut dents, mut longest) = (0, 0.0);
        for dent in view.damage.dents() {
            let reach = dent.reach();
            let head = self.parts.len();
            self.parts.extend_from_slice(&[0; PART_WORDS]);
            for part in dent.parts.iter() {
                if !dent.counts(set, skin, part, least) {
                    self.left_out += 1;
                    continue;
                }
                let scale = part.scale * dent.strength;
                // A scale of 0 shortens everything to nothing, however little is left out.
                let least = if scale == 0.0 { 0.0 } else { least / scale.abs() };
                match (&part.carried, set.examples()[part.example].stamp()) {
                    (Some(c), Some(stamp)) => {
                        self.add_carried(c, stamp, (place.stamp(part.example), scale, least));
                        longest += stamp.longest * scale.abs();
                    }
                    // Of nothing that could be carried nothing is left.
                    (Some(_), None) => {}
                    (None, _) => {
                        self.add_stored(skin, place, (part, scale, least));
                        longest += place.longest(part.example) * scale.abs();
                    }
                }
            }
            let parts = (self.parts.len() - head) / PART_WORDS - 1;
            if parts == 0 {
                self.parts.truncate(head);
                continue;
            }
            dents += 1;
            let [x, y, z] = reach.contact.to_array().map(f32::to_bits);
            let square = (reach.square * SLACK).min(f32::MAX).to_bits();
            self.parts[head..][..5].copy_from_slice(&[x, y, z, square, parts as u32]);
        }
        let combined = match view.lengths() {
            Lengths::Free => 0,
            Lengths::Squares => SQUARES,
            Lengths::Longest => LONGEST,
        };
        let limit = view.limit(longest);
        let flags = combined | if dents > 1 { SEVERAL } else { 0 } | if limit.is_some() { LIMITED } else { 0 };
        self.add_target(shown, begin, (flags, limit.unwrap_or(0.0), NONE));
        // A little more than exact, for the rounding of f32.
        let grown = Vec3::splat(longest.min(view.depth_limit) * 1.00001);
        let mut bounds = skin.mesh.bounds();
        if dents > 0 {
            for dent in view.damage.dents() {
                let mut near = bounds_within(&dent.reach(), &skin.mesh.bounds());
                (near.min, near.max) = (near.min - grown, near.max + grown);
                bounds.union(&near);
            }
        }
        bounds
    }

    /// Adds a target of an instance with a classic rule: the hits since the epoch that the device's state is of, or, where that is
    /// none or too old, the state itself. Answers a box that holds its vertices.
    pub(crate) fn classic_target(
        &mut self,
        shown: &Shown<'_>,
        (state, blend_constant): (&State, f32),
        normals: bool,
        since: Option<u64>,
    ) -> Aabb {
        let Shown { view, skin, place, .. } = *shown;
        let (begin, mut given, mut flags) = (self.parts.len() / PART_WORDS, NONE, 0);
        let all = 0..skin.vertex_count();
        match since.and_then(|epoch| state.applied_since(epoch)) {
            Some(hits) => {
                for hit in hits {
                    let a = &skin.anchored[hit.example as usize];
                    let steps = [a.steps.position, a.steps.normal, hit.weight].map(f32::to_bits);
                    let example = place.example(hit.example as usize);
                    self.parts.extend_from_slice(&[0, example, 0, 0, steps[0], steps[1], steps[2], 0]);
                }
            }
            None if view.changes.blocks[0].iter().all(|changed| *changed == 0) => flags = AT_REST,
            None => {
                given = self.carried.len() as u32;
                for v in all.clone() {
                    self.carried.extend_from_slice(&state.vertices().positions[v].to_array().map(f32::to_bits));
                    if normals {
                        let normal = state.vertices().normals.get(v).copied().unwrap_or(Vec3::ZERO);
                        self.carried.extend_from_slice(&normal.to_array().map(f32::to_bits));
                    }
                }
            }
        }
        self.add_target(shown, begin, (flags, blend_constant, given));
        let mut bounds = Aabb::EMPTY;
        all.for_each(|v| bounds.add(state.vertices().positions[v]));
        bounds
    }

    /// Adds a target whose parts have been added from `begin` on.
    fn add_target(&mut self, shown: &Shown<'_>, begin: usize, (flags, number, given): (u32, f32, u32)) {
        let Shown { place, layout, first, .. } = *shown;
        let word = |bytes: u64| (bytes / 4) as u32;
        let stream =
            |s: Option<super::Stream>| s.map_or([0, 0], |s| [word(first.wrapping_add(s.offset)), word(s.stride)]);
        let code = |s: Option<super::Stream>| s.map_or(0, |s| s.encoding as u32);
        // What no stream asks for is read somewhere, and not written.
        let positions = place.positions();
        let mut words = Words::<TARGET_WORDS>::new();
        words.put([positions, place.normals().unwrap_or(positions), place.tangents().unwrap_or(positions)]);
        words.put(stream(Some(layout.positions)));
        words.put(stream(layout.normals));
        words.put(stream(layout.tangents));
        words.put([code(Some(layout.positions)) | code(layout.normals) << 8 | code(layout.tangents) << 16]);
        words.floats(layout.bias);
        words.floats(layout.scale);
        words.put([shown.skin.vertex_count() as u32]);
        words.put([begin as u32, (self.parts.len() / PART_WORDS) as u32, flags]);
        words.floats([number]);
        words.put([place.bounds(), place.windows().unwrap_or(NONE), given]);
        self.targets.extend_from_slice(&words.all);
    }

    fn add_stored(&mut self, skin: &MeshLod, place: &Place, (part, scale, least): (&DentPart, f32, f32)) {
        let steps = skin.anchored[part.example].steps;
        let mut words = Words::<PART_WORDS>::new();
        words.put([0, place.example(part.example), 0, 0]);
        words.floats([steps.position * scale, steps.normal * scale, cut(least / steps.position), 0.0]);
        self.parts.extend_from_slice(&words.all);
    }

    fn add_carried(&mut self, c: &Carried, stamp: &Stamp, (nodes, scale, least): (u32, f32, f32)) {
        let mut part = Words::<PART_WORDS>::new();
        part.put([IS_CARRIED, (self.carried.len() / CARRIED_WORDS) as u32, 0, 0]);
        part.floats([scale, 0.0, cut(least), 0.0]);
        self.parts.extend_from_slice(&part.all);
        let mut words = Words::<CARRIED_WORDS>::new();
        words.floats(c.contact.to_array());
        words.matrix(&c.to_stamp);
        words.floats(c.per_cell.to_array());
        words.floats(c.grid_origin.to_array());
        words.floats(c.grid_top.to_array());
        words.matrix(&c.displacement);
        words.matrix(&c.normal_change);
        words.floats([c.height, c.fade]);
        words.floats(c.up.to_array());
        words.floats([FACING]);
        words.put(stamp.grid.dims.to_array());
        words.put([nodes, 0, 0, 0]);
        self.carried.extend_from_slice(&words.all);
    }
}

/// The part of a box that holds everything within reach.
fn bounds_within(reach: &Reach, all: &Aabb) -> Aabb {
    let radius = Vec3::splat(reach.square.sqrt() * SLACK);
    Aabb { min: all.min.max(reach.contact - radius), max: all.max.min(reach.contact + radius) }
}

/// Displacements no longer than `least` become zero; all stay where it is 0: as a square to compare with.
fn cut(least: f32) -> f32 {
    if least > 0.0 { least * least } else { -1.0 }
}

/// Words of one entry, in order.
struct Words<const N: usize> {
    all: [u32; N],
    at: usize,
}

impl<const N: usize> Words<N> {
    fn new() -> Self {
        Words { all: [0; N], at: 0 }
    }

    fn put<const M: usize>(&mut self, words: [u32; M]) {
        self.all[self.at..self.at + M].copy_from_slice(&words);
        self.at += M;
    }

    fn floats<const M: usize>(&mut self, floats: [f32; M]) {
        self.put(floats.map(f32::to_bits));
    }

    fn matrix(&mut self, m: &Mat3) {
        self.floats(m.to_cols_array());
    }
}
