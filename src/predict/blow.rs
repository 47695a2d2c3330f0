//! What physics knows of a blow, reduced to what the regressions use.

use glam::Vec3;

/// A blow on the body. Each part may be unknown, which costs accuracy and not correctness.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Blow {
    /// Velocity of the striker relative to the body before the touch, m/s.
    pub velocity: Option<Vec3>,
    /// Impulse on the body, N·s.
    pub impulse: Option<Vec3>,
    /// Mass of the striker, kg. Above 0.
    pub mass: Option<f32>,
    /// Radius of the striker's surface at the contact, m. Above 0.
    pub radius: Option<f32>,
    /// Any number that tells kinds of strikers apart, such as balls and poles.
    pub kind: Option<u32>,
}

/// A blow whose direction deviates less than this from the surface points neither in nor out, as a share of its length.
const GRAZING: f64 = 0.02;
/// Longest tangential over normal speed that is told apart.
const MAX_TANGENT: f64 = 1.5;

/// What the regressions know of a blow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Strike {
    /// Kinetic energy of the normal speed, J.
    pub energy: f64,
    /// Mass of the striker, kg; `None` if unknown.
    pub mass: Option<f64>,
    /// Tangential over normal speed, in the surface.
    pub tangent: [f64; 3],
}

impl Blow {
    /// The strike on a surface with unit normal `n`. `typical` is the mass (kg) that is assumed if it is unknown, and
    /// `rebound` the usual ratio of impulse to momentum. `None` if the blow points out of the body or tells neither
    /// velocity nor impulse.
    pub(super) fn strike(&self, n: Vec3, typical: f64, rebound: f64) -> Option<Strike> {
        let n = n.as_dvec3();
        let w = self.velocity.or(self.impulse)?.as_dvec3();
        let length = w.length();
        let into = -w.dot(n);
        if length.is_nan() || length <= 0.0 || into < -GRAZING * length {
            return None;
        }
        let into = into.max(GRAZING * length).max(1e-9);
        let known = self.mass.map(f64::from);
        let push = self.impulse.map(|j| (-j.as_dvec3().dot(n)).max(GRAZING * j.as_dvec3().length()) / rebound);
        let (energy, mass) = match (self.velocity.is_some(), known, push) {
            (true, Some(m), _) => (0.5 * m * into * into, Some(m)),
            (true, None, Some(push)) => (0.5 * push * into, Some(push / into)),
            (true, None, None) => (0.5 * typical * into * into, None),
            (false, m, _) => {
                let push = into / rebound;
                (0.5 * push * push / m.unwrap_or(typical), m)
            }
        };
        let mut t = (w + n * w.dot(n).abs()) / into;
        t -= n * t.dot(n);
        let long = t.length();
        if long > MAX_TANGENT {
            t *= MAX_TANGENT / long;
        }
        Some(Strike { energy: energy.max(1e-12), mass: mass.filter(|m| *m > 0.0), tangent: t.to_array() })
    }

    /// Impulse over momentum along the normal, if all of it is known.
    pub(super) fn rebound(&self, n: Vec3) -> Option<f64> {
        let n = n.as_dvec3();
        let (j, v, m) = (self.impulse?.as_dvec3(), self.velocity?.as_dvec3(), f64::from(self.mass?));
        let (push, momentum) = (-j.dot(n), -v.dot(n) * m);
        (push > 0.0 && momentum > 0.0).then(|| push / momentum)
    }
}
