//! The mark: one stored hit. What it moves follows from the set ([`super::told`]), and how strongly from the marks near it
//! ([`super::dent`]).

use crate::base::error::Error;
use crate::example::rule::Key;
use crate::example::set::ExampleSet;
use crate::mesh::MAX_COORDINATE;
use bytemuck::{Pod, Zeroable};

/// One dent. Plain data, 32 bytes, little-endian, equal on all machines: send or save it as is. Logarithms are to the base of 2, in units
/// of 1/500, from 2^-64 on (docs/model.md, "Marks").
/// cbindgen:field-names=[contact, depth, hits, told, striker, direction, strength, mass, radius, reserved]
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Mark {
    /// The vertex that was hit.
    pub contact: u32,
    /// Depth at the contact, m, above 0.
    pub depth: f32,
    /// Number of hits of this depth that it stands for, fixed point 32.32: 4294967296 for one hit.
    pub energy: u64,
    /// What the hit told: 0 the displacement of its contact, 1 its blow.
    pub told: u16,
    /// Shape of the striker of a blow, as CrumpleStrikerShape.
    pub striker: u16,
    /// Direction of the displacement or of the striker, octahedral: 0 to 65534 for -1 to 1.
    pub direction: [u16; 2],
    /// Logarithm of a blow's energy, J. This and what follows is 0 for a displacement.
    pub strength: u16,
    /// Logarithm of the striker's mass, kg.
    pub mass: u16,
    /// Logarithm of the striker's radius, m.
    pub radius: u16,
    /// 0.
    pub reserved: u16,
}

impl Mark {
    /// <!--
    /// cbindgen:ignore
    /// -->
    /// Energy of one hit.
    pub const ONE: u64 = 1 << 32;

    /// Contact, bits of the depth, and the numbers of the hit. Marks with equal keys are merged. Marks are sorted by key.
    pub(crate) fn key(&self) -> Key {
        let two = |a: u16, b: u16| u32::from(a) << 16 | u32::from(b);
        let [x, y] = self.direction;
        let numbers =
            [two(self.told, self.striker), two(x, y), two(self.strength, self.mass), two(self.radius, self.reserved)];
        [self.contact, self.depth.to_bits(), numbers[0], numbers[1], numbers[2], numbers[3]]
    }

    /// Checks that the set can have these marks.
    pub(crate) fn check_all(marks: &[Mark], set: &ExampleSet) -> Result<(), Error> {
        marks.iter().enumerate().try_for_each(|(at, mark)| mark.check(set, at))
    }

    fn check(&self, set: &ExampleSet, at: usize) -> Result<(), Error> {
        let bad = |name: &str, value: String, expected: String| {
            Err(Error::InvalidArgument { name: format!("{name} of mark {at}"), value, expected })
        };
        if self.contact as usize >= set.vertex_count() {
            let expected = format!("below {}, the number of vertices", set.vertex_count());
            return bad("contact", self.contact.to_string(), expected);
        }
        if !(self.depth > 0.0 && self.depth <= MAX_COORDINATE) {
            return bad("depth", self.depth.to_string(), "above 0 and at most 1e9 m".into());
        }
        if self.energy == 0 {
            return bad("hits", "0".into(), "above 0".into());
        }
        match self.told {
            0 => {
                let others = [self.striker, self.strength, self.mass, self.radius];
                if others != [0; 4] {
                    let expected = "0: a displacement has no striker".into();
                    return bad("striker, strength, mass and radius", format!("{others:?}"), expected);
                }
            }
            1 if set.predicts_blows() => {}
            1 => return bad("told", "1".into(), "0, a displacement: no example of the set knows its blow".into()),
            other => return bad("told", other.to_string(), "0, a displacement, or 1, a blow".into()),
        }
        if self.reserved != 0 { bad("reserved", self.reserved.to_string(), "0".into()) } else { Ok(()) }
    }
}
