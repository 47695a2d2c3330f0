//! A frame's work in words: what to write, and what moves it.

use super::NONE;
use super::format::Layout;
use super::skin::Place;
use crate::anchored::{Anchored, block_range};
use crate::classic::State;
use crate::deform::evaluate::{self, Job, Which};
use crate::deform::kernel::{Lengths, Ready, Source};
use crate::dent::{Carried, MAX_PAIRS};
use crate::math::Aabb;
use crate::stamp::{FACING, Stamp};
use glam::{Mat3, Vec3};

/// Words of each kind, as in the kernels.
pub(crate) const ITEM_WORDS: usize = 8;
const PART_WORDS: usize = 8;
const CARRIED_WORDS: usize = 48;
const TARGET_WORDS: usize = 16;

/// Flags of an item …
const SEVERAL: u32 = 1;
const SQUARES: u32 = 2;
const LONGEST: u32 = 4;
const LIMITED: u32 = 8;
/// … of an item of a classic rule …
const AT_REST: u32 = 1;
/// … and of a part.
const LAST: u32 = 1;
const IS_CARRIED: u32 = 2;

/// Lists of words, used over and over.
#[derive(Debug, Default)]
pub(crate) struct Frame {
    /// One a block to write.
    items: Vec<u32>,
    /// One for each part of a dent that moves a block.
    parts: Vec<u32>,
    /// One for each carried part of an instance's dents, whatever blocks it moves. Of classic instances, states of vertices.
    carried: Vec<u32>,
    /// One a target.
    targets: Vec<u32>,
    /// Of the present instance's parts, which `carried` each is.
    known: Vec<u32>,
    /// Parts that tolerances left out.
    pub left_out: u32,
}

impl Frame {
    pub(crate) fn clear(&mut self) {
        [&mut self.items, &mut self.parts, &mut self.carried, &mut self.targets].into_iter().for_each(Vec::clear);
        self.left_out = 0;
    }

    /// Items so far.
    pub(crate) fn items(&self) -> usize {
        self.items.len() / ITEM_WORDS
    }

    /// Where items, parts, carried parts and targets begin, and words in all.
    pub(crate) fn offsets(&self) -> ([usize; 4], usize) {
        let (mut at, mut total) = ([0; 4], 0);
        for (at, list) in at.iter_mut().zip(self.lists()) {
            *at = total;
            total += list.len();
        }
        (at, total)
    }

    /// Writes all lists, one behind the other.
    pub(crate) fn write(&self, to: &mut [u32]) {
        let mut at = 0;
        for list in self.lists() {
            to[at..at + list.len()].copy_from_slice(list);
            at += list.len();
        }
    }

    fn lists(&self) -> [&[u32]; 4] {
        [&self.items, &self.parts, &self.carried, &self.targets]
    }

    /// Begins a target: `layout` from `first` bytes (modulo 2^64) on in the buffer as it is bound. What follows is of one instance.
    pub(crate) fn target(&mut self, instance: &crate::Instance, place: &Place, layout: &Layout, first: u64) {
        let word = |bytes: u64| (bytes / 4) as u32;
        let stream =
            |s: Option<super::Stream>| s.map_or([0, 0], |s| [word(first.wrapping_add(s.offset)), word(s.stride)]);
        let code = |s: Option<super::Stream>| s.map_or(0, |s| s.encoding as u32);
        // What no stream asks for is read somewhere, and not written.
        let positions = place.positions();
        let mut words = Words(&mut self.targets);
        words.put([positions, place.normals().unwrap_or(positions), place.tangents().unwrap_or(positions)]);
        words.put(stream(Some(layout.positions)));
        words.put(stream(layout.normals));
        words.put(stream(layout.tangents));
        words.put([code(Some(layout.positions)) | code(layout.normals) << 8 | code(layout.tangents) << 16]);
        words.floats(layout.bias);
        words.floats(layout.scale);
        self.known.clear();
        self.known.resize(instance.damage().dents().len() * MAX_PAIRS, NONE);
    }

    /// Adds a block of the present target, and answers a box that holds its vertices.
    pub(crate) fn block(&mut self, job: Job<'_>, normals: bool, place: &Place) -> Aabb {
        let Frame { items, parts, carried, targets, known, left_out } = self;
        let range = block_range(job.block, job.skin.vertex_count());
        let begin = parts.len() / PART_WORDS;
        let touched = evaluate::shown(job, normals, left_out, |which, ready| match ready.source {
            Source::Carried(c, stamp) => {
                let index = &mut known[which.dent * MAX_PAIRS + which.number];
                if *index == NONE {
                    *index = (carried.len() / CARRIED_WORDS) as u32;
                    add_carried(carried, c, stamp, place.stamp(which.part.example));
                }
                add_carried_part(parts, &ready, *index);
            }
            Source::Stored(..) => add_stored_part(parts, job, which, &ready, place),
        });
        let limit = evaluate::limit(job.instance, &touched);
        let several = touched.dents > 1;
        let combined = match evaluate::lengths(job.instance) {
            Lengths::Free => 0,
            Lengths::Squares => SQUARES,
            Lengths::Longest => LONGEST,
        };
        let flags = combined | if several { SEVERAL } else { 0 } | if limit.is_some() { LIMITED } else { 0 };
        let window = place.window(&job.skin.rim, job.block).unwrap_or(NONE);
        let mut words = Words(items);
        words.put([(targets.len() / TARGET_WORDS) as u32 - 1, range.start as u32, range.len() as u32]);
        words.put([begin as u32, (parts.len() / PART_WORDS) as u32, flags, window]);
        words.floats([limit.unwrap_or(0.0)]);
        let mut bounds = job.skin.block_bounds[job.block];
        // A little more than exact, for the rounding of f32.
        let grown = Vec3::splat(touched.longest.min(job.instance.depth_limit()) * 1.00001);
        (bounds.min, bounds.max) = (bounds.min - grown, bounds.max + grown);
        bounds
    }
}

impl Frame {
    /// Adds a block of the present target, of an instance with a classic rule: the hits since the epoch that the device's state
    /// is of, or, where that is none or too old, the state itself. Answers a box that holds its vertices.
    pub(crate) fn classic_block(
        &mut self,
        (job, state): (Job<'_>, &State),
        normals: bool,
        place: &Place,
        since: Option<u64>,
    ) -> Aabb {
        let Frame { items, parts, carried, targets, .. } = self;
        let range = block_range(job.block, job.skin.vertex_count());
        let (begin, mut given, mut flags) = (parts.len() / PART_WORDS, NONE, 0);
        match since.and_then(|epoch| state.applied_since(epoch)) {
            Some(hits) => {
                for hit in hits {
                    let (example, weight) = (hit.example as usize, hit.weight);
                    add_hit(parts, &job.skin.anchored[example], (job.block, weight), |at| place.numbers(example, at));
                }
            }
            None if job.instance.changes().blocks[0][job.block] == 0 => flags = AT_REST,
            None => {
                given = carried.len() as u32;
                for v in range.clone() {
                    let mut words = Words(carried);
                    words.floats(state.position(v).to_array());
                    if normals {
                        words.floats(state.normal(v).unwrap_or(Vec3::ZERO).to_array());
                    }
                }
            }
        }
        let mut words = Words(items);
        words.put([(targets.len() / TARGET_WORDS) as u32 - 1, range.start as u32, range.len() as u32]);
        words.put([begin as u32, (parts.len() / PART_WORDS) as u32, flags, given]);
        words.floats([job.instance.blend_constant()]);
        let mut bounds = Aabb::EMPTY;
        range.for_each(|v| bounds.add(state.position(v)));
        bounds
    }
}

/// Adds what a hit's example stores of a block, if anything; `words` tells where its numbers are.
fn add_hit(parts: &mut Vec<u32>, a: &Anchored, (block, weight): (usize, f32), words: impl Fn(usize) -> u32) {
    let Some(head) = a.block(block as u32) else { return };
    let (displacements, changes) = (a.displacements(head), a.normals(head));
    let at = head.at as usize;
    let normals_at = at + crate::anchored::words(head.groups, head.width);
    let mut to = Words(parts);
    to.put([
        u32::from(head.width) << 8 | u32::from(head.normal_width) << 16,
        u32::from(head.groups) | u32::from(head.normal_groups) << 16,
        words(at),
        words(normals_at),
    ]);
    to.floats([displacements.step, changes.step, weight, 0.0]);
}

/// Displacements no longer than `least` become zero; all stay where it is 0: as a square to compare with.
fn cut(least: f32) -> f32 {
    if least > 0.0 { least * least } else { -1.0 }
}

fn add_stored_part(parts: &mut Vec<u32>, job: Job<'_>, which: Which<'_>, ready: &Ready<'_>, place: &Place) {
    let example = which.part.example;
    let anchored = &job.skin.anchored[example];
    let (Some(head), Source::Stored(displacements, changes)) = (anchored.block(job.block as u32), ready.source) else {
        return;
    };
    let normals_at = head.at as usize + crate::anchored::words(head.groups, head.width);
    let last = if ready.last { LAST } else { 0 };
    let mut words = Words(parts);
    words.put([
        last | u32::from(head.width) << 8 | u32::from(head.normal_width) << 16,
        u32::from(displacements.groups) | u32::from(changes.groups) << 16,
        place.numbers(example, head.at as usize),
        place.numbers(example, normals_at),
    ]);
    words.floats([displacements.step * ready.scale, changes.step * ready.scale]);
    words.floats([cut(ready.least / displacements.step), 0.0]);
}

fn add_carried_part(parts: &mut Vec<u32>, ready: &Ready<'_>, index: u32) {
    let mut words = Words(parts);
    words.put([if ready.last { LAST } else { 0 } | IS_CARRIED, index, 0, 0]);
    words.floats([ready.scale, 0.0, cut(ready.least), 0.0]);
}

fn add_carried(carried: &mut Vec<u32>, c: &Carried, stamp: &Stamp, nodes: u32) {
    let mut words = Words(carried);
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
}

/// Appends words.
struct Words<'a>(&'a mut Vec<u32>);

impl Words<'_> {
    fn put<const N: usize>(&mut self, words: [u32; N]) {
        self.0.extend_from_slice(&words);
    }

    fn floats<const N: usize>(&mut self, floats: [f32; N]) {
        self.put(floats.map(f32::to_bits));
    }

    fn matrix(&mut self, m: &Mat3) {
        self.floats(m.to_cols_array());
    }
}
