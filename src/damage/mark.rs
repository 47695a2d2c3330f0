//! The mark: one stored hit. Mark m displaces vertex v by
//!
//! ```text
//! u_m(v) = strength * sum over pairs of scale(depth, share) * e_i(v)
//! ```
//!
//! The strength follows from the energies of this mark and of those near it ([`super::overlap`]).

use crate::base::error::Error;
use crate::example::set::ExampleSet;
use crate::mesh::MAX_COORDINATE;
use crate::mesh::mirror::Mirror;
use bytemuck::{Pod, Zeroable};

/// Maximum number of pairs of a mark.
pub(crate) const MAX_PAIRS: usize = 4;

/// An example, how it is placed, and its share of a dent.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
pub struct Pair {
    /// Index of the example; 0xFFFF in an unused pair.
    pub example: u16,
    /// Low 12 bits: share of the dent, two's complement; 1024 is the whole dent. Bits 12, 13 and 14: the example is
    /// mirrored in x, y and z. Bit 15: the example is anchored.
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

    /// A pair whose example stays where it was made. `share` is in units of 1 / [`Pair::WHOLE`], -2048 to 2047; only
    /// its low 12 bits are kept.
    pub fn anchored(example: u16, share: i16) -> Self {
        Pair { example, share: share as u16 & 0xFFF | 1 << 15 }
    }

    /// A pair whose example is carried to the contact, mirrored by `mirror`. `share` is in units of 1 /
    /// [`Pair::WHOLE`], -2048 to 2047; only its low 12 bits are kept.
    pub fn carried(example: u16, share: i16, mirror: Mirror) -> Self {
        Pair { example, share: share as u16 & 0xFFF | u16::from(mirror.bits()) << 12 }
    }

    /// Whether the pair is unused.
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

    /// The share as a fraction, from -2 to just under 2. It is negative if the example corrects others that overshoot.
    pub fn share_fraction(self) -> f32 {
        f32::from(self.units()) / f32::from(Self::WHOLE)
    }
}

/// One dent. Plain data, 32 bytes, little-endian, equal on all machines: send or save it as is.
/// cbindgen:field-names=[contact, depth, hits, pairs]
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Mark {
    /// The vertex that was hit.
    pub contact: u32,
    /// Requested depth at the contact, m, above 0.
    pub depth: f32,
    /// Number of hits of this depth that it stands for, fixed point 32.32: 4294967296 for one hit.
    pub energy: u64,
    /// Up to four examples. Used pairs come first. If the first has the example 65534, the set predicts the dent, and the pairs
    /// are the numbers of its hit (docs/model.md, "Prediction from all examples").
    pub pairs: [Pair; 4],
}

impl Mark {
    /// <!--
    /// cbindgen:ignore
    /// -->
    /// Energy of one hit.
    pub const ONE: u64 = 1 << 32;

    /// The mark of one hit.
    pub fn new(contact: u32, depth: f32, pairs: [Pair; 4]) -> Self {
        let mut pairs = pairs;
        // Moves used pairs to the front and keeps their order.
        pairs.sort_by_key(|p| p.is_none());
        Mark { contact, depth, energy: Self::ONE, pairs }
    }

    /// Contact, depth and pairs. Marks with equal keys are merged. Marks are sorted by key.
    pub(crate) fn key(&self) -> (u32, u32, [Pair; MAX_PAIRS]) {
        (self.contact, self.depth.to_bits(), self.pairs)
    }

    pub(crate) fn check(&self, set: &ExampleSet, at: usize) -> Result<(), Error> {
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
            return Err(bad("hits", "0".into(), "above 0".into()));
        }
        if self.is_predicted() {
            let expected = match set.rule() {
                None => Some("examples: the set has not learned to predict hits"),
                Some(rule) => match (self.pairs[0].share, rule.predicts()) {
                    (0, [_, true]) | (1, [true, _]) => None,
                    (0, _) => Some("examples: the set predicts blows only"),
                    (1, _) => Some("examples: the set predicts displacements only"),
                    _ => Some("told as a displacement (0) or a blow (1)"),
                },
            };
            return expected.map_or(Ok(()), |e| Err(bad("pairs", format!("{:?}", self.pairs), e.into())));
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
