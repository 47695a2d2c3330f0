//! What a mark stores of its hit, and what the set predicts of it.

use super::energy::energy_root;
use super::mark::Mark;
use crate::example::rule::Predicted;
use crate::example::set::ExampleSet;
use crate::predict::{self, Told};
use glam::{DVec3, Vec3};

/// Units of a logarithm, and the least power of 2.
const UNITS: f64 = 500.0;
const LEAST: f64 = -64.0;
/// The greatest logarithm, in units.
const MOST: u16 = 64000;

impl Mark {
    /// The mark of a hit, or of one that told a displacement in its direction. `normal` is the contact's, of length 1.
    pub(crate) fn new(contact: u32, depth: f32, told: &Told, normal: Vec3) -> Self {
        let mark = Mark { contact, depth, energy: Self::ONE, ..bytemuck::Zeroable::zeroed() };
        match told {
            Told::Displacement(u) => Mark { direction: octahedral(u.as_dvec3()), ..mark },
            Told::Strike(s) => Mark {
                told: 1,
                striker: s.kind as u16,
                direction: octahedral(DVec3::from_array(s.direction) - normal.as_dvec3()),
                strength: logarithm(s.strength),
                mass: logarithm(s.mass),
                radius: logarithm(s.radius),
                ..mark
            },
        }
    }

    /// The mark of a hit with 2^`level` times the energy, and how many times as deep it is.
    pub(super) fn harder(&self, level: u16) -> (Mark, f32) {
        let deeper = energy_root(libm::exp2(level.into())) as f32;
        let strength = self.strength.saturating_add(level * UNITS as u16).min(MOST);
        (Mark { depth: self.depth * deeper, strength: if self.told == 1 { strength } else { 0 }, ..*self }, deeper)
    }

    /// The hit of the mark, and the unit normal of its contact: that of the mesh, or against the hit if the mesh has none.
    fn hit(&self, normal: Option<Vec3>) -> (Told, Vec3) {
        let direction = unfolded(self.direction);
        let normal = normal.unwrap_or(-direction.as_vec3());
        if self.told == 0 {
            return (Told::Displacement(direction.as_vec3() * self.depth), normal);
        }
        let n = normal.as_dvec3();
        let into = (-direction.dot(n)).max(1e-3);
        let strike = predict::Strike {
            strength: power(self.strength),
            mass: power(self.mass),
            radius: power(self.radius),
            direction: ((direction - n * direction.dot(n)) / into).to_array(),
            kind: f64::from(self.striker),
        };
        (Told::Strike(strike), normal)
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

/// The prediction of a mark.
pub(crate) fn predicted(set: &ExampleSet, mark: &Mark) -> PredictedMark {
    let (told, normal) = mark.hit(set.mesh().contact_normal(mark.contact));
    let mut key = mark.key();
    if mark.told == 1 {
        // The depth follows from the blow.
        key[1] = 0;
    }
    let hit = predict::Hit { contact: set.mesh().positions()[mark.contact as usize], normal, told };
    let predicted = set.rule().predict(key, &hit);
    let moved = predicted.field.at_vertex(&set.base_lod().rows, mark.contact);
    // A blow on a held rim dents what is beside it.
    let depth = if mark.told == 1 { predicted.depth } else { moved.length() };
    let scale = mark.depth / depth;
    // Beside held rims the rest of a told displacement is left unmet.
    let most = if mark.told == 0 && set.rim().at(mark.contact) < 1.0 { 1.0 } else { predict::MOST_SCALE };
    let scale = if scale.is_finite() { scale.min(most) } else { 0.0 };
    PredictedMark { predicted, moved, scale: if (scale - 1.0).abs() < 1e-6 { 1.0 } else { scale } }
}

fn logarithm(x: f64) -> u16 {
    let units = libm::round((libm::log2(x) - LEAST) * UNITS);
    units.clamp(0.0, MOST.into()) as u16
}

fn power(units: u16) -> f64 {
    libm::exp2(f64::from(units) / UNITS + LEAST)
}

/// A direction as a point of a square: its octahedron, unfolded.
fn octahedral(v: DVec3) -> [u16; 2] {
    let sum = v.x.abs() + v.y.abs() + v.z.abs();
    let (x, y) = if sum > 0.0 { (v.x / sum, v.y / sum) } else { (0.0, 0.0) };
    let sign = |x: f64| if x < 0.0 { -1.0 } else { 1.0 };
    let (x, y) = if v.z < 0.0 { ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)) } else { (x, y) };
    [x, y].map(|x| (libm::round(x.clamp(-1.0, 1.0) * 32767.0) + 32767.0) as u16)
}

fn unfolded(at: [u16; 2]) -> DVec3 {
    let [x, y] = at.map(|x| (f64::from(x) / 32767.0 - 1.0).min(1.0));
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
            let (back, _) = Mark::new(0, 1.0, &Told::Displacement(u), normal).hit(Some(normal));
            prop_assert!(matches!(back, Told::Displacement(v) if v.distance(u) < 1e-4), "{back:?} of {u}");
            let along = Vec3::new(x, y, 0.0);
            let along = along - normal * along.dot(normal);
            let direction = along.as_dvec3().to_array();
            let strike = predict::Strike { strength: energy, mass, radius: 0.1, direction, kind: kind.into() };
            let mark = Mark::new(0, 1.0, &Told::Strike(strike), normal);
            let (Told::Strike(s), _) = mark.hit(Some(normal)) else { panic!("no strike") };
            prop_assert!((s.strength / energy - 1.0).abs() < 1e-3 && (s.mass / mass - 1.0).abs() < 1e-3);
            prop_assert!((s.radius / 0.1 - 1.0).abs() < 1e-3 && s.kind == f64::from(kind));
            prop_assert!(DVec3::from_array(s.direction).distance(along.as_dvec3()) < 1e-3, "{s:?}");
            // What was read is stored as the same numbers; on the edge of the square a direction has two.
            let again = Mark::new(0, 1.0, &Told::Strike(s), normal);
            prop_assert_eq!(Mark { direction: mark.direction, ..again }, mark);
            prop_assert!(unfolded(again.direction).distance(unfolded(mark.direction)) < 1e-4);
        }
    }
}
