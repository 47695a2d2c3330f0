//! Damage: a short, sorted list of marks. The only state an instance of the default rule has.

use crate::dent::{Dent, MAX_PAIRS, Reach};
use crate::examples::{Combine, ExampleSet};
use crate::math::Aabb;
use crate::mesh::MAX_COORDINATE;
use crate::{Error, Mirror, error::reserve};
use bytemuck::{Pod, Zeroable};
use std::cmp::Ordering;

/// An example, how it is placed, and its share of a dent.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
pub struct Pair {
    /// Index of the example; 0xFFFF in an unused pair.
    pub example: u16,
    /// Low 12 bits: share of the dent, two's complement, 1024 for the whole dent. Bits 12, 13 and 14: the example is mirrored
    /// in x, y and z. Bit 15: it stays where it was made.
    pub share: u16,
}

impl Pair {
    /// <!--
    /// cbindgen:ignore
    /// -->
    /// An unused pair.
    pub const NONE: Pair = Pair { example: u16::MAX, share: 0 };
    /// <!--
    /// cbindgen:ignore
    /// -->
    /// The share of an example that makes a dent alone. Shares go from -2 to just under 2 of it.
    pub const WHOLE: i16 = 1024;

    /// `share` of [`Pair::WHOLE`], -2048 to 2047 (its low 12 bits are kept), where and as the example was made.
    pub fn anchored(example: u16, share: i16) -> Self {
        Pair { example, share: share as u16 & 0xFFF | 1 << 15 }
    }

    /// `share` of [`Pair::WHOLE`], -2048 to 2047 (its low 12 bits are kept), carried to the contact, perhaps as a mirror image.
    pub fn carried(example: u16, share: i16, mirror: Mirror) -> Self {
        Pair { example, share: share as u16 & 0xFFF | u16::from(mirror.bits()) << 12 }
    }

    /// Whether it is unused.
    pub fn is_none(self) -> bool {
        self == Self::NONE
    }

    /// Whether the example stays where it was made.
    pub fn is_anchored(self) -> bool {
        self.share >> 15 == 1
    }

    /// The planes that the example is mirrored in.
    pub fn mirror(self) -> Mirror {
        Mirror::from_bits((self.share >> 12) as u8)
    }

    /// The share in units of 1 / [`Pair::WHOLE`].
    pub fn units(self) -> i16 {
        // Sign extension of 12 bits.
        (self.share << 4) as i16 >> 4
    }

    /// The share, -2 to just under 2; negative where the example corrects others that overshoot.
    pub fn share_fraction(self) -> f32 {
        f32::from(self.units()) / f32::from(Self::WHOLE)
    }
}

/// One dent: where, how deep, and made of which examples. Plain data of 32 bytes, equal on all machines: send or save it as
/// it is (little-endian).
///
/// ```text
/// u_m(v) = strength * sum over pairs of scale(depth, share) * e_i(v)          strength = sqrt(energy)
/// ```
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Mark {
    /// The vertex that was hit.
    pub contact: u32,
    /// Depth asked for at the contact, m; above 0.
    pub depth: f32,
    /// Strength squared, in units of 2^-32: 4294967296 for one hit; each hit that repeats the mark adds as much. Sets that
    /// combine by sum or by the deepest store the strength itself.
    pub energy: u64,
    /// Up to four examples, the used ones first.
    pub pairs: [Pair; 4],
}

impl Mark {
    /// <!--
    /// cbindgen:ignore
    /// -->
    /// Energy of one hit.
    pub const ONE: u64 = 1 << 32;

    /// One hit's mark.
    pub fn new(contact: u32, depth: f32, pairs: [Pair; 4]) -> Self {
        let mut pairs = pairs;
        // Used pairs first, their order kept.
        pairs.sort_by_key(|p| p.is_none());
        Mark { contact, depth, energy: Self::ONE, pairs }
    }

    /// What two marks must share to be one: contact, depth and pairs. Marks are kept in this order.
    fn key(&self) -> (u32, u32, [Pair; MAX_PAIRS]) {
        (self.contact, self.depth.to_bits(), self.pairs)
    }

    fn check(&self, set: &ExampleSet, at: usize) -> Result<(), Error> {
        let bad = |name: &str, value: String, expected: String| Error::InvalidArgument {
            name: format!("{name} of mark {at}"),
            value,
            expected,
        };
        if self.contact as usize >= set.vertex_count() {
            return Err(bad(
                "contact",
                self.contact.to_string(),
                format!("below {}, the number of vertices", set.vertex_count()),
            ));
        }
        if !(self.depth > 0.0 && self.depth <= MAX_COORDINATE) {
            return Err(bad("depth", self.depth.to_string(), "above 0 and at most 1e9 m".into()));
        }
        if self.energy == 0 {
            return Err(bad("energy", "0".into(), "above 0".into()));
        }
        let used = self.pairs.iter().take_while(|p| !p.is_none()).count();
        if used == 0 || self.pairs[used..].iter().any(|p| !p.is_none()) {
            return Err(bad(
                "pairs",
                format!("{:?}", self.pairs),
                "one to four used pairs, then unused ones (65535, 0)".into(),
            ));
        }
        let mut total = 0i32;
        for p in &self.pairs[..used] {
            let Some(e) = set.examples().get(p.example as usize).filter(|e| !e.is_empty()) else {
                return Err(bad(
                    "example",
                    p.example.to_string(),
                    format!("one of the set's {} examples, not an empty one", set.examples().len()),
                ));
            };
            if !p.is_anchored() && e.stamp().is_none() {
                return Err(bad(
                    "pair",
                    format!("example {} carried", p.example),
                    "anchored, as the set's example is".into(),
                ));
            }
            if p.is_anchored() && p.mirror() != Mirror::NONE {
                return Err(bad(
                    "pair",
                    format!("example {} anchored and mirrored", p.example),
                    "either: an anchored example is never mirrored".into(),
                ));
            }
            total += i32::from(p.units());
        }
        if !(1..=i32::from(Pair::WHOLE)).contains(&total) {
            return Err(bad("shares", total.to_string(), "1 to 1024 in all".into()));
        }
        Ok(())
    }
}

/// Called with every dent that a change of the damage adds, alters or takes away.
type Touched<'a> = &'a mut dyn FnMut(&Dent);

/// The marks of one instance, sorted, each beside its dent.
#[derive(Debug, Clone, Default)]
pub(crate) struct Damage {
    marks: Vec<Mark>,
    dents: Vec<Dent>,
    /// Of each dent, side by side: every block that is evaluated looks at all of them.
    reaches: Vec<Reach>,
}

impl Damage {
    pub(crate) fn marks(&self) -> &[Mark] {
        &self.marks
    }

    pub(crate) fn dents(&self) -> &[Dent] {
        &self.dents
    }

    /// All dents in order, and where each may move anything.
    #[cfg(feature = "gpu")]
    pub(crate) fn reached(&self) -> impl Iterator<Item = (&Dent, &Reach)> {
        self.dents.iter().zip(&self.reaches)
    }

    /// The dents that may move something in a box, in order.
    pub(crate) fn near<'a>(&'a self, bounds: &'a Aabb) -> impl Iterator<Item = &'a Dent> {
        let near = self.reaches.iter().zip(&self.dents).filter(|(r, _)| bounds.distance_squared(r.contact) <= r.square);
        near.map(|(_, dent)| dent)
    }

    /// Adds new marks in canonical order, whatever order they came in. A mark that is there already gets the energy. Above
    /// `capacity` the weakest mark (least `strength * depth`; the first in order where equal) gives its energy, in metres
    /// squared, to the mark whose contact is nearest (the first in order where equal).
    pub(crate) fn add(&mut self, set: &ExampleSet, mut new: Vec<Mark>, capacity: usize, touched: Touched<'_>) {
        new.sort_unstable_by(|a, b| a.key().cmp(&b.key()).then(a.energy.cmp(&b.energy)));
        for mark in new {
            self.add_one(set, mark, touched);
            if self.marks.len() > capacity {
                self.merge_weakest(set, touched);
            }
        }
    }

    fn add_one(&mut self, set: &ExampleSet, mark: Mark, touched: Touched<'_>) {
        match self.marks.binary_search_by(|m| m.key().cmp(&mark.key())) {
            Ok(at) => {
                let e = combined(self.marks[at].energy, mark.energy, set.options().combine);
                self.set_energy(set, at, e);
                touched(&self.dents[at]);
            }
            Err(at) => {
                let dent = Dent::new(set, &mark);
                touched(&dent);
                self.marks.insert(at, mark);
                self.reaches.insert(at, dent.reach());
                self.dents.insert(at, dent);
            }
        }
    }

    fn set_energy(&mut self, set: &ExampleSet, at: usize, energy: u64) {
        self.marks[at].energy = energy;
        self.dents[at].strength = crate::dent::strength(energy, set.options().combine);
    }

    fn merge_weakest(&mut self, set: &ExampleSet, touched: Touched<'_>) {
        let size = |i: usize| self.dents[i].strength * self.marks[i].depth;
        let weakest = (0..self.marks.len()).fold(0, |best, i| if size(i) < size(best) { i } else { best });
        let from = self.dents[weakest].contact;
        let distance = |i: usize| (self.dents[i].contact - from).length_squared();
        let others = (0..self.marks.len()).filter(|i| *i != weakest);
        let Some(heir) = others.reduce(|best, i| if distance(i) < distance(best) { i } else { best }) else { return };
        let combine = set.options().combine;
        let ratio = f64::from(self.marks[weakest].depth) / f64::from(self.marks[heir].depth);
        let power = if combine == Combine::Energies { ratio * ratio } else { ratio };
        // `as` saturates; u64 as f64 rounds to nearest: both the same everywhere.
        let given = (self.marks[weakest].energy as f64 * power) as u64;
        let energy = combined(self.marks[heir].energy, given, combine);
        self.set_energy(set, heir, energy);
        touched(&self.dents[heir]);
        touched(&self.dents[weakest]);
        self.marks.remove(weakest);
        self.dents.remove(weakest);
        self.reaches.remove(weakest);
    }

    /// Replaces all marks. Fails before anything changes.
    pub(crate) fn replace(
        &mut self,
        set: &ExampleSet,
        marks: &[Mark],
        capacity: usize,
        touched: Touched<'_>,
    ) -> Result<(), Error> {
        marks.iter().enumerate().try_for_each(|(i, m)| m.check(set, i))?;
        let mut copy = reserve(marks.len(), "marks")?;
        copy.extend_from_slice(marks);
        self.clear(touched);
        self.add(set, copy, capacity, touched);
        Ok(())
    }

    /// Multiplies every dent's depth by `keep`; what falls under a ten-thousandth of its depth goes.
    pub(crate) fn scale(&mut self, set: &ExampleSet, keep: f32, touched: Touched<'_>) {
        let keep = f64::from(keep);
        let factor = if set.options().combine == Combine::Energies { keep * keep } else { keep };
        for i in 0..self.marks.len() {
            touched(&self.dents[i]);
            let e = (self.marks[i].energy as f64 * factor) as u64;
            self.set_energy(set, i, e);
        }
        let gone = |d: &Dent| d.strength < 1e-4;
        let keep: Vec<bool> = self.dents.iter().map(|d| !gone(d)).collect();
        let mut k = keep.iter();
        self.marks.retain(|_| *k.next().unwrap_or(&true));
        self.dents.retain(|d| !gone(d));
        self.reaches = self.dents.iter().map(Dent::reach).collect();
    }

    pub(crate) fn clear(&mut self, touched: Touched<'_>) {
        self.dents.iter().for_each(touched);
        self.marks.clear();
        self.dents.clear();
        self.reaches.clear();
    }

    /// Calls `touched` with every dent that only one of two lists has, or whose strength is another.
    pub(crate) fn differences(&self, other: &Damage, touched: Touched<'_>) {
        let (mut a, mut b) = (0, 0);
        while a < self.marks.len() || b < other.marks.len() {
            let order = match (self.marks.get(a), other.marks.get(b)) {
                (Some(x), Some(y)) => x.key().cmp(&y.key()),
                (Some(_), None) => Ordering::Less,
                (None, _) => Ordering::Greater,
            };
            match order {
                Ordering::Less => touched(&self.dents[a]),
                Ordering::Greater => touched(&other.dents[b]),
                Ordering::Equal if self.marks[a].energy != other.marks[b].energy => {
                    touched(&self.dents[a]);
                    touched(&other.dents[b]);
                }
                Ordering::Equal => {}
            }
            a += usize::from(order.is_le());
            b += usize::from(order.is_ge());
        }
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.marks.len() * (size_of::<Mark>() + size_of::<Dent>() + size_of::<Reach>())
    }

    pub(crate) fn touch_all(&self, touched: Touched<'_>) {
        self.dents.iter().for_each(touched);
    }
}

fn combined(a: u64, b: u64, combine: Combine) -> u64 {
    match combine {
        Combine::Sum | Combine::Energies => a.saturating_add(b),
        Combine::Deepest => a.max(b),
    }
}

/// Saved damage: 24 bytes of header (magic `CRDM`, u16 version, u16 kind, u64 fingerprint of the set, u32 count, u32
/// zero), then the entries, all little-endian.
pub(crate) mod saved {
    use super::*;

    pub(crate) const MAGIC: [u8; 4] = *b"CRDM";
    pub(crate) const VERSION: u16 = 1;
    pub(crate) const HEADER: usize = 24;
    /// Entries are marks of 32 bytes.
    pub(crate) const MARKS: u16 = 1;
    /// Entries are vertices of a classic rule's state, 28 bytes each.
    pub(crate) const CLASSIC: u16 = 2;

    pub(crate) fn header(set: &ExampleSet, kind: u16, count: usize) -> Vec<u8> {
        let mut out = Vec::with_capacity(HEADER + count * 32);
        out.extend(MAGIC);
        out.extend(VERSION.to_le_bytes());
        out.extend(kind.to_le_bytes());
        out.extend(set.fingerprint().to_le_bytes());
        out.extend((count as u32).to_le_bytes());
        out.extend(0u32.to_le_bytes());
        out
    }

    /// The entries, checked to be as many as the header says.
    pub(crate) fn entries<'a>(set: &ExampleSet, bytes: &'a [u8], kind: u16, size: usize) -> Result<&'a [u8], Error> {
        let bad = |what: String| Err(Error::DamageMismatch { what });
        if bytes.len() < HEADER {
            return bad(format!("{} bytes; at least {HEADER} are needed", bytes.len()));
        }
        let u16_at = |i: usize| u16::from_le_bytes([bytes[i], bytes[i + 1]]);
        let u32_at = |i: usize| u32::from_le_bytes([bytes[i], bytes[i + 1], bytes[i + 2], bytes[i + 3]]);
        if bytes[..4] != MAGIC {
            return bad(format!("it begins with {:?}; saved damage begins with {:?}", &bytes[..4], MAGIC));
        }
        if u16_at(4) != VERSION {
            return bad(format!("version {}; this library reads version {VERSION}", u16_at(4)));
        }
        if u16_at(6) != kind {
            return bad(format!(
                "kind {} (1: marks, 2: a classic rule's vertices); this instance's rule needs {kind}",
                u16_at(6)
            ));
        }
        let mark = u64::from(u32_at(8)) | u64::from(u32_at(12)) << 32;
        if mark != set.fingerprint() {
            return bad(format!(
                "it belongs to example set {mark:016x}; this instance's is {:016x}",
                set.fingerprint()
            ));
        }
        if u32_at(20) != 0 {
            return bad(format!("bytes 20 to 23 are {:#x}; they must be 0", u32_at(20)));
        }
        let rest = &bytes[HEADER..];
        let needed = u64::from(u32_at(16)) * size as u64;
        if rest.len() as u64 != needed {
            return bad(format!("{} bytes after the header; {} entries take {needed}", rest.len(), u32_at(16)));
        }
        Ok(rest)
    }

    pub(crate) fn write_mark(m: &Mark, out: &mut Vec<u8>) {
        out.extend(m.contact.to_le_bytes());
        out.extend(m.depth.to_bits().to_le_bytes());
        out.extend(m.energy.to_le_bytes());
        for p in &m.pairs {
            out.extend(p.example.to_le_bytes());
            out.extend(p.share.to_le_bytes());
        }
    }

    pub(crate) fn read_mark(b: &[u8]) -> Mark {
        let u16_at = |i: usize| u16::from_le_bytes([b[i], b[i + 1]]);
        let u32_at = |i: usize| u32::from_le_bytes([b[i], b[i + 1], b[i + 2], b[i + 3]]);
        Mark {
            contact: u32_at(0),
            depth: f32::from_bits(u32_at(4)),
            energy: u64::from(u32_at(8)) | u64::from(u32_at(12)) << 32,
            pairs: [0, 1, 2, 3].map(|i| Pair { example: u16_at(16 + 4 * i), share: u16_at(18 + 4 * i) }),
        }
    }
}
