//! What a mark of a set that has learned stores of its hit, in the 16 bytes of a mark's pairs. The displacements follow from the
//! contact and these numbers.
//!
//! | pair | example | share |
//! |---|---|---|
//! | 0 | [`Told::TAG`] | 0: told as a displacement; 1: as a blow |
//! | 1 | direction into the body, octahedral: first coordinate | second coordinate |
//! | 2 | logarithm of the energy | logarithm of the mass |
//! | 3 | logarithm of the radius | kind of the striker |
//!
//! Logarithms are to the base of 2, in units of 1/500, from 2^-64 on.

use super::mark::{MAX_PAIRS, Mark, Pair};
use crate::example::rule::Predicted;
use crate::example::set::ExampleSet;
use crate::predict;
use glam::{DVec3, Vec3};

/// A hit as a mark stores it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Told {
    /// The unit direction of the contact's displacement. Its length is the mark's depth.
    Displacement(Vec3),
    /// A blow.
    Strike(predict::Strike),
}

/// A predicted field is scaled to its mark's depth by at most this factor.
const MOST_SCALE: f32 = 4.0;
/// Units of a logarithm, and the least power of 2.
const UNITS: f64 = 500.0;
const LEAST: f64 = -64.0;

impl Told {
    /// The example of the first pair.
    pub(crate) const TAG: u16 = u16::MAX - 1;

    /// The pairs of a hit's mark. `normal` is the contact's, of length 1.
    pub(crate) fn pairs(&self, normal: Vec3) -> [Pair; MAX_PAIRS] {
        let mut pairs = [Pair { example: 0, share: 0 }; MAX_PAIRS];
        pairs[0].example = Self::TAG;
        let direction = match self {
            Told::Displacement(u) => u.as_dvec3(),
            Told::Strike(s) => {
                pairs[0].share = 1;
                pairs[2] = Pair { example: logarithm(s.strength), share: logarithm(s.mass) };
                pairs[3] = Pair { example: logarithm(s.radius), share: s.kind as u16 };
                DVec3::from_array(s.direction) - normal.as_dvec3()
            }
        };
        let [a, b] = octahedral(direction);
        pairs[1] = Pair { example: a as u16, share: b as u16 };
        pairs
    }

    /// What the pairs of a mark tell of its hit. `None` if they are examples.
    pub(crate) fn of(pairs: &[Pair; MAX_PAIRS], normal: Vec3) -> Option<Self> {
        if pairs[0].example != Self::TAG {
            return None;
        }
        let direction = unfolded([pairs[1].example as i16, pairs[1].share as i16]);
        if pairs[0].share == 0 {
            return Some(Told::Displacement(direction.as_vec3()));
        }
        let n = normal.as_dvec3();
        let into = (-direction.dot(n)).max(1e-3);
        Some(Told::Strike(predict::Strike {
            strength: power(pairs[2].example),
            mass: power(pairs[2].share),
            radius: power(pairs[3].example),
            direction: ((direction - n * direction.dot(n)) / into).to_array(),
            kind: f64::from(pairs[3].share),
        }))
    }
}

/// What the hit of a mark alone is predicted to leave.
pub(crate) struct PredictedMark {
    pub predicted: Predicted,
    /// How far the field moves the contact, m.
    pub moved: Vec3,
    /// The factor with which the contact gets the mark's depth.
    pub scale: f32,
}

/// The prediction of a mark. `None` if it has examples, or the set has not learned to predict.
pub(crate) fn predicted(set: &ExampleSet, mark: &Mark) -> Option<PredictedMark> {
    let (rule, rows) = (set.rule()?, &set.base_lod().rows);
    let normal = set.mesh().contact_normal(mark.contact)?;
    let (told, depth) = match Told::of(&mark.pairs, normal)? {
        Told::Displacement(direction) => (predict::Told::Displacement(direction * mark.depth), mark.depth.to_bits()),
        Told::Strike(strike) => (predict::Told::Strike(strike), 0),
    };
    let hit = predict::Hit { contact: set.mesh().positions()[mark.contact as usize], normal, told };
    let [a, b, c, d] = mark.pairs.map(|p| u32::from(p.example) << 16 | u32::from(p.share));
    let predicted = rule.predict([mark.contact, depth, a, b, c, d], &hit);
    let moved = predicted.field.at_vertex(rows, mark.contact);
    let scale = mark.depth / moved.length();
    let scale = if scale.is_finite() { scale.min(MOST_SCALE) } else { 0.0 };
    Some(PredictedMark { predicted, moved, scale: if (scale - 1.0).abs() < 1e-6 { 1.0 } else { scale } })
}

impl Mark {
    /// Whether the set predicts the mark's dent from its hit, instead of mixing the pairs' examples.
    pub fn is_predicted(&self) -> bool {
        self.pairs[0].example == Told::TAG
    }
}

fn logarithm(x: f64) -> u16 {
    let units = libm::round((libm::log2(x) - LEAST) * UNITS);
    // Never a pair that is unused.
    units.clamp(0.0, 64000.0) as u16
}

fn power(units: u16) -> f64 {
    libm::exp2(f64::from(units) / UNITS + LEAST)
}

/// A direction as a point of a square: its octahedron, unfolded.
fn octahedral(v: DVec3) -> [i16; 2] {
    let sum = v.x.abs() + v.y.abs() + v.z.abs();
    let (x, y) = if sum > 0.0 { (v.x / sum, v.y / sum) } else { (0.0, 0.0) };
    let sign = |x: f64| if x < 0.0 { -1.0 } else { 1.0 };
    let (x, y) = if v.z < 0.0 { ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)) } else { (x, y) };
    [x, y].map(|x| libm::round(x.clamp(-1.0, 1.0) * 32767.0) as i16)
}

fn unfolded(at: [i16; 2]) -> DVec3 {
    let [x, y] = at.map(|x| (f64::from(x) / 32767.0).max(-1.0));
    let z = 1.0 - x.abs() - y.abs();
    let sign = |x: f64| if x < 0.0 { -1.0 } else { 1.0 };
    let (x, y) = if z < 0.0 { ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)) } else { (x, y) };
    DVec3::new(x, y, z).normalize_or(DVec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_stored_is_read_to_a_thousandth(
            x in -1.0f32..1.0, y in -1.0f32..1.0, energy in 1e-6f64..1e9, mass in 1e-3f64..1e6, kind in 0u16..9,
        ) {
            let normal = Vec3::new(0.3, -0.5, 0.81).normalize();
            let u = (-normal + Vec3::new(x, y, 0.0)).normalize();
            let back = Told::of(&Told::Displacement(u).pairs(normal), normal);
            prop_assert!(matches!(back, Some(Told::Displacement(v)) if v.distance(u) < 1e-4), "{back:?} of {u}");
            let along = Vec3::new(x, y, 0.0);
            let along = along - normal * along.dot(normal);
            let direction = along.as_dvec3().to_array();
            let strike = predict::Strike { strength: energy, mass, radius: 0.1, direction, kind: kind.into() };
            let pairs = Told::Strike(strike).pairs(normal);
            let Some(Told::Strike(s)) = Told::of(&pairs, normal) else { panic!("no strike") };
            prop_assert!((s.strength / energy - 1.0).abs() < 1e-3 && (s.mass / mass - 1.0).abs() < 1e-3);
            prop_assert!((s.radius / 0.1 - 1.0).abs() < 1e-3 && s.kind == f64::from(kind));
            prop_assert!(DVec3::from_array(s.direction).distance(along.as_dvec3()) < 1e-3, "{s:?}");
            // What was read is stored as the same bytes.
            prop_assert_eq!(Told::Strike(s).pairs(normal), pairs);
        }
    }
}
