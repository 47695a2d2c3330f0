//! An example where the artist made it: displacements of the vertices it moves, dense in blocks, in the narrowest width.
//!
//! Vertices keep the engine's order and are cut into blocks of 128, blocks into groups of eight. Of a block that the example
//! touches those groups are stored in which it moves anything, x y z x y z …, as whole multiples of one step for the whole set
//! (or as plain floats): no index a vertex, and one vector load a group.

use crate::base::array::Array;
use crate::mesh::vertex_blocks::{BLOCK, block_range};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Vertices a group.
pub(crate) const GROUP: usize = 8;
/// Groups a block.
pub(crate) const GROUPS: usize = BLOCK / GROUP;

/// Bytes of a stored number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub(crate) enum Width {
    I8 = 1,
    I16 = 2,
    /// A float; in a set with a tolerance a whole number of steps, up to 2^24.
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

/// One block that the example touches.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct Head {
    pub block: u32,
    /// Where its numbers begin, in words of eight bytes: displacements, then normals.
    pub at: u32,
    /// Longest displacement, m.
    pub longest: f32,
    /// Bit g: displacements of the vertices from 8 g on are stored.
    pub groups: u16,
    /// The same for changes of the normals.
    pub normal_groups: u16,
    /// Widths in bytes: 1, 2 or 4.
    pub width: u8,
    pub normal_width: u8,
    pub zero: u16,
}

/// What a set stores numbers in multiples of; 1 where they are exact floats.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Steps {
    /// m.
    pub position: f32,
    pub normal: f32,
    /// Whether numbers are whole multiples.
    pub whole: bool,
}

impl Steps {
    /// Exact floats.
    pub(crate) const EXACT: Steps = Steps { position: 1.0, normal: 1.0, whole: false };
    /// Displacements of more steps than this are refused: up to here a float tells the number of steps without doubt.
    pub(crate) const MOST: f32 = (1 << 21) as f32;

    /// Steps for which no displacement is wrong by more than `tolerance` (m), and no unit normal by more than `degrees`.
    ///
    /// Rounded to the nearest multiple each of three components is wrong by half a step at most, so the vector by at most
    /// `sqrt(3)/2` steps: 0.999 of the tolerance here. The thousandth that is left covers the rounding of `whole * step` to a
    /// float, as long as a displacement is not longer than some thousand times the tolerance; beyond that float itself is what
    /// limits. A displacement no longer than the tolerance may be dropped altogether. A unit normal plus a change that is wrong
    /// by `e` is turned by at most `asin(e)`.
    pub(crate) fn new(tolerance: f32, degrees: f32) -> Self {
        let step = |t: f32| t * (2.0 / 3f32.sqrt()) * 0.999;
        Steps { position: step(tolerance), normal: step(libm::sinf(degrees.to_radians())), whole: true }
    }

    /// The vector that is stored for `v`.
    fn rounded(self, v: Vec3, step: f32) -> Vec3 {
        if self.whole { (v / step).to_array().map(f32::round_ties_even).into() } else { v }
    }

    /// What will be read back for a displacement; zero where it is no longer than `threshold` (m).
    pub(crate) fn displacement(self, d: Vec3, threshold: f32) -> Vec3 {
        if self.whole && d.length() <= threshold {
            Vec3::ZERO
        } else {
            self.rounded(d, self.position) * self.position + Vec3::ZERO
        }
    }

    /// What will be read back for a change of a normal.
    pub(crate) fn normal_change(self, n: Vec3) -> Vec3 {
        self.rounded(n, self.normal) * self.normal + Vec3::ZERO
    }
}

/// Displacements and changes of normals of one example.
#[derive(Debug, Clone)]
pub(crate) struct DeltaBlocks {
    pub(crate) steps: Steps,
    /// By block, increasing.
    pub(crate) heads: Array<Head>,
    pub(crate) words: Array<u64>,
}

/// The stored numbers of one block's displacements, or of its changes of normals.
#[derive(Clone, Copy)]
pub(crate) struct Stored<'a> {
    /// Bit g: the vertices from 8 g on.
    pub groups: u16,
    pub numbers: Numbers<'a>,
    /// What numbers are multiples of.
    pub step: f32,
}

#[derive(Clone, Copy)]
pub(crate) enum Numbers<'a> {
    I8(&'a [i8]),
    I16(&'a [i16]),
    F32(&'a [f32]),
}

impl Stored<'_> {
    pub(crate) const NOTHING: Stored<'static> = Stored { groups: 0, numbers: Numbers::I8(&[]), step: 1.0 };

    /// The vector of vertex `v` of the block.
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
}

impl DeltaBlocks {
    /// From one displacement (and change of the normal) a vertex, as [`Steps`] rounds them.
    pub(crate) fn new(deltas: &[Vec3], normals: Option<&[Vec3]>, steps: Steps) -> Self {
        let (mut heads, mut words) = (Vec::new(), Vec::new());
        for b in 0..deltas.len().div_ceil(BLOCK) {
            let r = block_range(b, deltas.len());
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
                block: b as u32,
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

    /// The blocks it touches, increasing.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = u32> + '_ {
        self.heads.iter().map(|h| h.block)
    }

    /// Whether it moves any vertex by more than `threshold`, m.
    pub(crate) fn exceeds(&self, threshold: f32) -> bool {
        self.heads.iter().any(|h| h.longest > threshold)
    }

    /// What is stored of block `b`.
    #[inline(always)]
    pub(crate) fn block(&self, b: u32) -> Option<&Head> {
        let heads: &[Head] = &self.heads;
        let (first, last) = (heads.first()?.block, heads.last()?.block);
        let (after, before) = (b.checked_sub(first)? as usize, last.checked_sub(b)? as usize);
        // Blocks increase, so that head is at most as many on from the first as its block is, and likewise before the last:
        // without gaps that is one place.
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

    /// Vertex, displacement and change of the normal of all vertices where either is not zero.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (u32, Vec3, Vec3)> + '_ {
        self.heads.iter().flat_map(move |h| {
            let (d, n) = (self.displacements(h), self.normals(h));
            (0..BLOCK).filter_map(move |i| {
                let (d, n) = (d.at(i), n.at(i));
                (d != Vec3::ZERO || n != Vec3::ZERO).then_some((h.block * BLOCK as u32 + i as u32, d, n))
            })
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

/// Where the bytes of anchored examples go.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Bytes {
    pub heads: usize,
    pub displacements: usize,
    pub normals: usize,
    /// Blocks with displacements in 1, 2 and 4 bytes a number.
    pub blocks: [usize; 3],
}

impl Bytes {
    pub(crate) fn total(&self) -> usize {
        self.heads + self.displacements + self.normals
    }
}

/// Words of eight bytes that `groups` take.
#[inline(always)]
pub(crate) fn words(groups: u16, width: u8) -> usize {
    // A group of 24 numbers is three words for each byte of a number.
    groups.count_ones() as usize * (GROUP * 3 / 8) * width as usize
}

/// Groups of a block in which anything is not zero.
fn moved(v: &[Vec3]) -> u16 {
    v.chunks(GROUP).enumerate().fold(0, |m, (g, v)| m | u16::from(v.iter().any(|v| *v != Vec3::ZERO)) << g)
}

/// Appends the numbers of `groups` in the narrowest width that holds them.
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

    #[test]
    fn the_last_block_may_be_short() {
        let d = vec![Vec3::X; 129];
        let a = DeltaBlocks::new(&d, None, Steps::EXACT);
        assert_eq!(a.heads.len(), 2);
        assert_eq!(a.heads[1].groups, 1);
        assert_eq!(a.delta(128), Vec3::X);
        assert_eq!(a.iter().count(), 129);
    }
}
