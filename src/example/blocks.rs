//! The displacements of an anchored example, stored densely in blocks with the narrowest number type that fits.
//!
//! Vertices keep the engine's order. They are split into blocks of 128, and blocks into groups of eight. For a block
//! that the example touches, only the groups with a nonzero value are stored, as x y z x y z …. Numbers are integer
//! multiples of one step per set, or plain floats. So there is no index per vertex, and each group takes one vector
//! load.

use crate::base::array::Array;
use crate::mesh::vertex_blocks::{BLOCK, block_range};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Vertices per group.
pub(crate) const GROUP: usize = 8;
/// Groups per block.
pub(crate) const GROUPS: usize = BLOCK / GROUP;

/// Size of a stored number, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub(crate) enum Width {
    I8 = 1,
    I16 = 2,
    /// A float. In a set with a tolerance it is a whole number of steps, up to 2^24.
    F32 = 4,
}

impl Width {
    pub(crate) fn of(code: u8) -> Option<Width> {
        match code {
            1 => Some(Width::I8),
            2 => Some(Width::I16),
            4 => Some(Width::F32),
            _ => None,
        }
    }
}

/// Header of one block that the example touches.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct Head {
    pub block: u32,
    /// Offset of its numbers in words of eight bytes. Displacements come first, then changes of normals.
    pub at: u32,
    /// Longest displacement, m.
    pub longest: f32,
    /// Bit g is set if the displacements of group g (vertices 8 g to 8 g + 7 of the block) are stored.
    pub groups: u16,
    /// Like `groups`, for changes of the normals.
    pub normal_groups: u16,
    /// Bytes per number: 1, 2 or 4.
    pub width: u8,
    pub normal_width: u8,
    pub zero: u16,
}

/// Step sizes of a set's stored numbers. 1 if they are exact floats.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Steps {
    /// Step of displacements, m.
    pub position: f32,
    pub normal: f32,
    /// Whether numbers are whole multiples of the step.
    pub whole: bool,
}

impl Steps {
    /// Exact floats.
    pub(crate) const EXACT: Steps = Steps { position: 1.0, normal: 1.0, whole: false };
    /// Largest displacement component accepted, in steps. Up to this value an f32 determines the number of steps
    /// exactly.
    pub(crate) const MOST: f32 = (1 << 21) as f32;

    /// Steps for which no displacement is wrong by more than `tolerance` (m), and no unit normal by more than
    /// `degrees`.
    ///
    /// Rounding makes each of three components wrong by at most half a step, so the vector is wrong by at most
    /// `sqrt(3)/2` steps. That is 0.999 of the tolerance. The remaining thousandth covers the rounding of
    /// `whole * step` to a float, if the displacement is at most about a thousand times the tolerance. For longer ones,
    /// f32 precision is the limit. A displacement no longer than the tolerance may be dropped. If the change of a unit
    /// normal is wrong by `e`, the normal is wrong by an angle of at most `asin(e)`.
    pub(crate) fn new(tolerance: f32, degrees: f32) -> Self {
        let step = |t: f32| t * (2.0 / 3f32.sqrt()) * 0.999;
        Steps { position: step(tolerance), normal: step(libm::sinf(degrees.to_radians())), whole: true }
    }

    /// The numbers stored for `v`: whole steps, or `v` itself if floats are exact.
    fn rounded(self, v: Vec3, step: f32) -> Vec3 {
        if self.whole { (v / step).to_array().map(f32::round_ties_even).into() } else { v }
    }

    /// The displacement as it will be read back. Zero if its length is at most `threshold` (m) and numbers are whole
    /// steps.
    pub(crate) fn displacement(self, d: Vec3, threshold: f32) -> Vec3 {
        if self.whole && d.length() <= threshold {
            Vec3::ZERO
        } else {
            self.rounded(d, self.position) * self.position + Vec3::ZERO
        }
    }

    /// The change of a normal as it will be read back.
    pub(crate) fn normal_change(self, n: Vec3) -> Vec3 {
        self.rounded(n, self.normal) * self.normal + Vec3::ZERO
    }
}

/// The displacements and changes of normals of one example.
#[derive(Debug, Clone)]
pub(crate) struct DeltaBlocks {
    pub(crate) steps: Steps,
    /// Sorted by block.
    pub(crate) heads: Array<Head>,
    pub(crate) words: Array<u64>,
}

/// The stored numbers of one block: its displacements or its changes of normals.
#[derive(Clone, Copy)]
pub(crate) struct Stored<'a> {
    /// Bit g is set if group g is stored.
    pub groups: u16,
    pub numbers: Numbers<'a>,
    /// Step that the numbers are multiples of.
    pub step: f32,
}

#[derive(Clone, Copy)]
pub(crate) enum Numbers<'a> {
    I8(&'a [i8]),
    I16(&'a [i16]),
    F32(&'a [f32]),
}

impl Stored<'_> {
    /// The vector at vertex `v`, counted from the block's first vertex.
    pub(crate) fn at(&self, v: usize) -> Vec3 {
        let group = v / GROUP;
        if self.groups >> group & 1 == 0 {
            return Vec3::ZERO;
        }
        let before = (self.groups & ((1 << group) - 1)).count_ones() as usize;
        let i = 3 * (before * GROUP + v % GROUP);
        let n = match self.numbers {
            Numbers::I8(n) => Vec3::new(n[i].into(), n[i + 1].into(), n[i + 2].into()),
            Numbers::I16(n) => Vec3::new(n[i].into(), n[i + 1].into(), n[i + 2].into()),
            Numbers::F32(n) => Vec3::new(n[i], n[i + 1], n[i + 2]),
        };
        n * self.step
    }

    /// The vectors of all vertices of the block: faster than one by one.
    fn all(&self) -> [Vec3; BLOCK] {
        fn scaled<T: Copy + Into<f32>>(to: &mut [f32], numbers: &[T], step: f32) {
            to.iter_mut().zip(numbers).for_each(|(to, n)| *to = (*n).into() * step);
        }
        let mut all = [Vec3::ZERO; BLOCK];
        let stored = all.chunks_exact_mut(GROUP).enumerate().filter(|(group, _)| self.groups >> group & 1 == 1);
        for (from, (_, to)) in (0..).step_by(3 * GROUP).zip(stored) {
            let to = bytemuck::cast_slice_mut(to);
            match self.numbers {
                Numbers::I8(n) => scaled(to, &n[from..], self.step),
                Numbers::I16(n) => scaled(to, &n[from..], self.step),
                Numbers::F32(n) => scaled(to, &n[from..], self.step),
            }
        }
        all
    }
}

impl DeltaBlocks {
    /// Stores one displacement (and one change of the normal) per vertex. Values must be as [`Steps`] rounds them.
    pub(crate) fn new(deltas: &[Vec3], normals: Option<&[Vec3]>, steps: Steps) -> Self {
        Self::of_blocks(0..deltas.len().div_ceil(BLOCK) as u32, deltas, normals, steps)
    }

    /// The same if all values outside `blocks`, which increase, are zero.
    pub(crate) fn of_blocks(
        blocks: impl IntoIterator<Item = u32>,
        deltas: &[Vec3],
        normals: Option<&[Vec3]>,
        steps: Steps,
    ) -> Self {
        let (mut heads, mut words) = (Vec::new(), Vec::new());
        for b in blocks {
            let r = block_range(b as usize, deltas.len());
            let d = &deltas[r.clone()];
            let n = normals.map_or(&[][..], |n| &n[r.clone()]);
            let (groups, normal_groups) = (moved(d), moved(n));
            if groups == 0 && normal_groups == 0 {
                continue;
            }
            let at = words.len() as u32;
            let width = store(d, groups, steps, steps.position, &mut words);
            let normal_width = store(n, normal_groups, steps, steps.normal, &mut words);
            heads.push(Head {
                block: b,
                at,
                longest: d.iter().map(|d| d.length()).fold(0.0, f32::max),
                groups,
                normal_groups,
                width: width as u8,
                normal_width: normal_width as u8,
                zero: 0,
            });
        }
        DeltaBlocks { steps, heads: heads.into(), words: words.into() }
    }

    /// The blocks that the example touches, increasing.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = u32> + '_ {
        self.heads.iter().map(|h| h.block)
    }

    /// Whether the example moves nothing.
    pub(crate) fn is_empty(&self) -> bool {
        self.heads.is_empty()
    }

    /// The header of block `b`. `None` if the example does not touch it.
    #[inline(always)]
    pub(crate) fn block(&self, b: u32) -> Option<&Head> {
        let heads: &[Head] = &self.heads;
        let (first, last) = (heads.first()?.block, heads.last()?.block);
        let (after, before) = (b.checked_sub(first)? as usize, last.checked_sub(b)? as usize);
        // Block numbers increase, so the header is at most `b - first` places after the first and at most `last - b`
        // places before the last. Without gaps that leaves one place.
        let (low, high) = ((heads.len() - 1).saturating_sub(before), after.min(heads.len() - 1));
        let near = heads.get(low..=high)?;
        near.binary_search_by_key(&b, |h| h.block).ok().map(|i| &near[i])
    }

    /// The displacements of a block.
    #[inline(always)]
    pub(crate) fn displacements(&self, h: &Head) -> Stored<'_> {
        self.stored(h.at as usize, h.groups, h.width, self.steps.position)
    }

    /// The changes of normals of a block.
    #[inline(always)]
    pub(crate) fn normals(&self, h: &Head) -> Stored<'_> {
        let at = h.at as usize + words(h.groups, h.width);
        self.stored(at, h.normal_groups, h.normal_width, self.steps.normal)
    }

    #[inline(always)]
    fn stored(&self, at: usize, groups: u16, width: u8, step: f32) -> Stored<'_> {
        let data = &self.words[at..at + words(groups, width)];
        let numbers = match width {
            1 => Numbers::I8(bytemuck::cast_slice(data)),
            2 => Numbers::I16(bytemuck::cast_slice(data)),
            _ => Numbers::F32(bytemuck::cast_slice(data)),
        };
        Stored { groups, numbers, step }
    }

    /// Displacement of vertex `v`, m.
    pub(crate) fn delta(&self, v: u32) -> Vec3 {
        self.block(v / BLOCK as u32).map_or(Vec3::ZERO, |h| self.displacements(h).at(v as usize % BLOCK))
    }

    /// Change of the unit normal of vertex `v`.
    pub(crate) fn normal_delta(&self, v: u32) -> Vec3 {
        self.block(v / BLOCK as u32).map_or(Vec3::ZERO, |h| self.normals(h).at(v as usize % BLOCK))
    }

    /// Vertex, displacement (m) and change of the normal, for all vertices where either is not zero.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (u32, Vec3, Vec3)> + '_ {
        self.heads.iter().flat_map(move |h| {
            let (displacements, normals) = (self.displacements(h).all(), self.normals(h).all());
            let all = (h.block * BLOCK as u32..).zip(displacements.into_iter().zip(normals));
            all.filter_map(|(v, (d, n))| (d != Vec3::ZERO || n != Vec3::ZERO).then_some((v, d, n)))
        })
    }

    pub(crate) fn bytes(&self) -> Bytes {
        let mut bytes = Bytes { heads: self.heads.bytes(), ..Bytes::default() };
        for h in self.heads.iter() {
            bytes.displacements += 8 * words(h.groups, h.width);
            bytes.normals += 8 * words(h.normal_groups, h.normal_width);
            let width = h.width.ilog2() as usize;
            bytes.blocks[width] += usize::from(h.groups != 0);
        }
        bytes
    }
}

/// Memory of an anchored example's parts, bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Bytes {
    pub heads: usize,
    pub displacements: usize,
    pub normals: usize,
    /// Number of blocks with displacements of 1, 2 and 4 bytes per number.
    pub blocks: [usize; 3],
}

impl Bytes {
    pub(crate) fn total(&self) -> usize {
        self.heads + self.displacements + self.normals
    }
}

/// Number of eight-byte words that `groups` take.
#[inline(always)]
pub(crate) fn words(groups: u16, width: u8) -> usize {
    // A group has 24 numbers, so it takes three words per byte of width.
    groups.count_ones() as usize * (GROUP * 3 / 8) * width as usize
}

/// Bit mask of the groups with a nonzero vector.
fn moved(v: &[Vec3]) -> u16 {
    v.chunks(GROUP).enumerate().fold(0, |m, (g, v)| m | u16::from(v.iter().any(|v| *v != Vec3::ZERO)) << g)
}

/// Appends the numbers of `groups` in the narrowest width that fits, and returns that width.
fn store(v: &[Vec3], groups: u16, steps: Steps, step: f32, out: &mut Vec<u64>) -> Width {
    let mut numbers: Vec<f32> = Vec::with_capacity(groups.count_ones() as usize * GROUP * 3);
    for group in (0..GROUPS).filter(|g| groups >> g & 1 == 1) {
        for i in group * GROUP..(group + 1) * GROUP {
            let v = v.get(i).copied().unwrap_or(Vec3::ZERO);
            numbers.extend_from_slice(&steps.rounded(v, step).to_array());
        }
    }
    let most = numbers.iter().map(|x| x.abs()).fold(0.0, f32::max);
    let width = match most {
        _ if !steps.whole => Width::F32,
        m if m <= 127.0 => Width::I8,
        m if m <= 32767.0 => Width::I16,
        _ => Width::F32,
    };
    let mut words = |bytes: &[u8]| {
        out.extend(bytes.chunks_exact(8).map(|w| u64::from_ne_bytes(std::array::from_fn(|i| w[i]))));
    };
    match width {
        Width::I8 => words(bytemuck::cast_slice(&numbers.iter().map(|x| *x as i8).collect::<Vec<_>>())),
        Width::I16 => words(bytemuck::cast_slice(&numbers.iter().map(|x| *x as i16).collect::<Vec<_>>())),
        Width::F32 => words(bytemuck::cast_slice(&numbers)),
    }
    width
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(n: usize, scale: f32) -> Vec<Vec3> {
        (0..n)
            .map(|i| {
                let x = i as f32;
                if i % 50 < 20 {
                    Vec3::new((x * 0.7).sin(), (x * 1.3).cos(), (x * 0.1).sin()) * scale
                } else {
                    Vec3::ZERO
                }
            })
            .collect()
    }

    #[test]
    fn exact_sets_give_back_what_they_got() {
        let (d, n) = (field(301, 0.1), field(301, 0.4));
        let a = DeltaBlocks::new(&d, Some(&n), Steps::EXACT);
        for v in 0..301 {
            assert_eq!(a.delta(v as u32), d[v]);
            assert_eq!(a.normal_delta(v as u32), n[v]);
        }
        assert_eq!(a.iter().count(), d.iter().filter(|d| **d != Vec3::ZERO).count());
    }

    #[test]
    fn baked_sets_keep_the_tolerance_and_give_back_what_was_rounded() {
        for (scale, tolerance, width) in [(0.1, 1e-3, Width::I8), (0.1, 1e-4, Width::I16), (0.1, 1e-6, Width::F32)] {
            let steps = Steps::new(tolerance, 1.0);
            let d = field(1000, scale);
            let kept: Vec<Vec3> = d.iter().map(|d| steps.displacement(*d, tolerance)).collect();
            let a = DeltaBlocks::new(&kept, None, steps);
            assert!(a.heads.iter().all(|h| h.width == width as u8), "{:?}", a.heads.to_vec());
            for v in 0..1000 {
                assert_eq!(a.delta(v as u32), kept[v]);
                let off = (kept[v].as_dvec3() - d[v].as_dvec3()).length();
                assert!(off <= f64::from(tolerance), "{off} at {v}");
            }
        }
    }
}
