//! A hit, what physics knows of its blow, reduced to what the regressions use, and what is predicted of it.

use super::features::Strike;
use glam::Vec3;

/// What is known of a hit's strength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Told {
    /// The blow, as [`Predictor::strike`](super::Predictor::strike) reads it.
    Strike(Strike),
    /// The displacement of the contact, m.
    Displacement(Vec3),
}

/// A hit on the undented body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Where the body is hit, m.
    pub contact: Vec3,
    /// Unit normal of the body there, out of it.
    pub normal: Vec3,
    /// How hard.
    pub told: Told,
}

/// What is predicted of a hit, besides its field.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Prediction {
    /// Root of the sum of the squared displacements of all points, m. 0 if the hit leaves nothing. A harder blow is
    /// never predicted smaller.
    pub size: f32,
    /// Displacement of the point nearest to the contact if no rim were held, m.
    pub depth: f32,
    /// Expected relative L2 error of the field; 1 is the error of no dent at all.
    pub expected_error: f32,
}

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

/// What is assumed of unknown numbers of a blow.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Typical {
    /// kg
    pub mass: f64,
    /// m
    pub radius: f64,
    pub kind: u32,
    /// The usual ratio of impulse to momentum.
    pub rebound: f64,
}

impl Blow {
    /// What the regressions know of the blow on a surface with unit normal `n`. `None` if it points out of the body or tells
    /// neither velocity nor impulse.
    pub(super) fn strike(&self, n: Vec3, typical: &Typical) -> Option<Strike> {
        let n = n.as_dvec3();
        let w = self.velocity.or(self.impulse)?.as_dvec3();
        let length = w.length();
        let into = -w.dot(n);
        if length.is_nan() || length <= 0.0 || into < -GRAZING * length {
            return None;
        }
        let into = into.max(GRAZING * length).max(1e-9);
        let known = self.mass.map(f64::from);
        let push = self.impulse.map(|j| (-j.as_dvec3().dot(n)).max(GRAZING * j.as_dvec3().length()) / typical.rebound);
        let (energy, mass) = match (self.velocity.is_some(), known, push) {
            (true, Some(m), _) => (0.5 * m * into * into, Some(m)),
            (true, None, Some(push)) => (0.5 * push * into, Some(push / into)),
            (true, None, None) => (0.5 * typical.mass * into * into, None),
            (false, m, _) => {
                let push = into / typical.rebound;
                (0.5 * push * push / m.unwrap_or(typical.mass), m)
            }
        };
        let mut t = (w + n * w.dot(n).abs()) / into;
        t -= n * t.dot(n);
        let long = t.length();
        if long > MAX_TANGENT {
            t *= MAX_TANGENT / long;
        }
        Some(Strike {
            strength: energy.max(1e-12),
            mass: mass.filter(|m| *m > 0.0).unwrap_or(typical.mass),
            radius: self.radius.map_or(typical.radius, f64::from).max(1e-6),
            direction: t.to_array(),
            kind: f64::from(self.kind.unwrap_or(typical.kind)),
        })
    }

    /// Impulse over momentum along the normal, if all of it is known.
    pub(super) fn rebound(&self, n: Vec3) -> Option<f64> {
        let n = n.as_dvec3();
        let (j, v, m) = (self.impulse?.as_dvec3(), self.velocity?.as_dvec3(), f64::from(self.mass?));
        let (push, momentum) = (-j.dot(n), -v.dot(n) * m);
        (push > 0.0 && momentum > 0.0).then(|| push / momentum)
    }
}
