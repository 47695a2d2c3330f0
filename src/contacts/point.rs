//! A contact point as a physics engine reports it.

use crate::base::error::Error;
use crate::base::math::unit;
use crate::example::blow::StrikerShape;
use crate::instance::inbox::Inbox;
use crate::mesh::finite;
use glam::DVec3;
use std::cmp::Ordering;
use std::sync::{Arc, Weak};

/// One point at which two bodies touch in a step of the physics. Vectors are in world space.
///
/// Give the impulse, or the velocity and what the bodies weigh; best all of them:
///
/// | known | impulse J | approach speed v | energy |
/// |---|---|---|---|
/// | impulse and velocity | given | given | J v / 2 |
/// | impulse and masses | given | J / m | J² / 2m |
/// | velocity and masses | m v | given | m v² / 2 |
/// | impulse alone | given | unknown | the set's law of impulses |
///
/// `m` is the reduced mass: 1 / [`inverse_mass`](Self::inverse_mass) if given, else `m_a m_b / (m_a + m_b)`, which is the
/// mass of the free body if nothing moves the other.
#[derive(Debug, Clone)]
pub struct ContactPoint {
    /// The two bodies as one number, the same in every step in which they touch.
    pub pair: u64,
    /// The inboxes of the bodies a and b. `None` for a body that does not dent.
    pub bodies: [Option<Arc<Inbox>>; 2],
    /// Where they touch, m.
    pub point: [f32; 3],
    /// From a to b: out of a. Any length above 0.
    pub normal: [f32; 3],
    /// Length of the normal impulse of the step, N·s. At least 0. `None`: the reduced mass times the change of the
    /// approach speed.
    pub impulse: Option<f32>,
    /// Velocity of b relative to a at the point, before the step, m/s.
    pub velocity: Option<[f32; 3]>,
    /// The same after the step, for points without an impulse. `None`: the bodies stop each other.
    pub velocity_after: Option<[f32; 3]>,
    /// Masses of a and b, kg. Above 0; infinity for a static or kinematic body.
    pub masses: [Option<f32>; 2],
    /// How easily the two move at the point along the normal, with rotation, 1/kg; above 0. `None`: `1/m_a + 1/m_b`.
    pub inverse_mass: Option<f32>,
    /// Radii of the surfaces of a and b at the point, m. Above 0: small for a corner, large for a flat face.
    pub radii: [Option<f32>; 2],
    /// Shapes of a and b at the point.
    pub shapes: [StrikerShape; 2],
    /// Factor of the point's energy, for the materials of the pair. At least 0.
    pub gain: f32,
}

impl ContactPoint {
    /// A point of which only the place is known.
    pub fn new(pair: u64, bodies: [Option<Arc<Inbox>>; 2], point: [f32; 3], normal: [f32; 3]) -> Self {
        ContactPoint {
            pair,
            bodies,
            point,
            normal,
            impulse: None,
            velocity: None,
            velocity_after: None,
            masses: [None; 2],
            inverse_mass: None,
            radii: [None; 2],
            shapes: [StrikerShape::Unknown; 2],
            gain: 1.0,
        }
    }

    /// The reduced mass, kg. `None` if it is unknown, or if nothing moves either body.
    fn reduced_mass(&self) -> Option<f64> {
        let given = self.inverse_mass.map(f64::from);
        let inverse = given.or_else(|| Some(1.0 / f64::from(self.masses[0]?) + 1.0 / f64::from(self.masses[1]?)))?;
        (inverse > 0.0).then(|| 1.0 / inverse)
    }

    /// Checks every part. `i` is the point's index in the call.
    pub(super) fn check(&self, i: usize) -> Result<(), Error> {
        let vectors = [
            ("point", Some(self.point)),
            ("normal", Some(self.normal)),
            ("velocity", self.velocity),
            ("velocity_after", self.velocity_after),
        ];
        for (part, v) in vectors {
            v.map_or(Ok(()), |v| finite(v, || format!("points[{i}].{part}")).map(|_| ()))?;
        }
        self.wrong_part().map_or(Ok(()), |(part, value, expected)| {
            Err(Error::invalid(&format!("points[{i}].{part}"), value, expected))
        })?;
        self.bodies.iter().flatten().try_for_each(|body| body.contacts_allowed("a contact point"))
    }

    /// The first wrong part: its name, its value and what would be right. Allocates only if there is one.
    fn wrong_part(&self) -> Option<(&'static str, String, &'static str)> {
        if unit(self.normal.into()).is_none() {
            return Some(("normal", format!("{:?}", self.normal), "longer than 0"));
        }
        let [mass_a, mass_b] = self.masses;
        let [radius_a, radius_b] = self.radii;
        let at_least_zero = |x: f32| x >= 0.0 && x.is_finite();
        let positive = |x: f32| x > 0.0 && x.is_finite();
        let mass = |x: f32| x > 0.0;
        type Test<'a> = &'a dyn Fn(f32) -> bool;
        let numbers: [(_, _, Test<'_>, _); 7] = [
            ("impulse", self.impulse, &at_least_zero, "at least 0 and finite, N·s"),
            ("masses[0]", mass_a, &mass, "above 0 kg; infinity for a body that nothing moves"),
            ("masses[1]", mass_b, &mass, "above 0 kg; infinity for a body that nothing moves"),
            ("inverse_mass", self.inverse_mass, &positive, "above 0 and finite, 1/kg"),
            ("radii[0]", radius_a, &positive, "above 0 and finite, m"),
            ("radii[1]", radius_b, &positive, "above 0 and finite, m"),
            ("gain", Some(self.gain), &at_least_zero, "at least 0 and finite"),
        ];
        if let Some((part, Some(x), _, expected)) = numbers.iter().find(|(_, x, right, _)| x.is_some_and(|x| !right(x)))
        {
            return Some((part, x.to_string(), expected));
        }
        let guess = self.velocity.is_some() && self.reduced_mass().is_some();
        (self.impulse.is_none() && !guess).then(|| {
            let expected = "given (N·s), or the velocity and the masses, of which at most one is infinite";
            ("impulse", "absent".to_owned(), expected)
        })
    }
}

/// A body that dents, and its number in the order of a step.
#[derive(Debug, Clone)]
pub(crate) struct Body {
    pub number: u64,
    pub inbox: Weak<Inbox>,
}

/// A point that waits for the step.
#[derive(Debug)]
pub(super) struct Reported {
    pub pair: u64,
    pub bodies: [Option<Body>; 2],
    pub point: DVec3,
    /// Unit vector from a to b.
    pub normal: DVec3,
    pub impulse: Option<f64>,
    pub velocity: Option<DVec3>,
    pub velocity_after: Option<DVec3>,
    pub mass: Option<f64>,
    pub radii: [Option<f32>; 2],
    pub shapes: [StrikerShape; 2],
    pub gain: f64,
}

impl Reported {
    /// A point that was checked.
    pub fn new(p: &ContactPoint) -> Self {
        let double = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let body = |side: usize| {
            let inbox = p.bodies[side].as_ref()?;
            Some(Body { number: inbox.number(), inbox: Arc::downgrade(inbox) })
        };
        let mut reported = Reported {
            pair: p.pair,
            bodies: [body(0), body(1)],
            point: double(p.point),
            normal: double(p.normal).normalize(),
            impulse: p.impulse.map(f64::from),
            velocity: p.velocity.map(double),
            velocity_after: p.velocity_after.map(double),
            mass: p.reduced_mass(),
            radii: p.radii,
            shapes: p.shapes,
            gain: p.gain.into(),
        };
        let (_, [a, b]) = reported.key();
        if a > b {
            reported.turn();
        }
        reported
    }

    /// Exchanges the bodies. Engines name a pair's bodies in either order, some in another one at each step.
    fn turn(&mut self) {
        self.bodies.swap(0, 1);
        self.radii.swap(0, 1);
        self.shapes.swap(0, 1);
        self.normal = -self.normal;
        self.velocity = self.velocity.map(|v| -v);
        self.velocity_after = self.velocity_after.map(|v| -v);
    }

    /// The pair and the numbers of its bodies; 0 for one that does not dent.
    pub fn key(&self) -> (u64, [u64; 2]) {
        (self.pair, [0, 1].map(|side| self.bodies[side].as_ref().map_or(0, |body| body.number)))
    }

    /// Order of the points of a step, which does not depend on the order in which they arrived. Points that compare as
    /// equal are equal.
    pub fn order(&self, other: &Self) -> Ordering {
        self.key().cmp(&other.key()).then_with(|| self.bits().cmp(&other.bits()))
    }

    fn bits(&self) -> [u64; 18] {
        let vector = |v: Option<DVec3>| v.unwrap_or(DVec3::NAN).to_array();
        let size = |x: Option<f64>| x.unwrap_or(f64::NAN);
        let [px, py, pz] = self.point.to_array();
        let [nx, ny, nz] = self.normal.to_array();
        let [vx, vy, vz] = vector(self.velocity);
        let [wx, wy, wz] = vector(self.velocity_after);
        let [r, s] = self.radii.map(|r| size(r.map(f64::from)));
        // Both in one number.
        let shapes = f64::from(self.shapes[0] as u8) + 256.0 * f64::from(self.shapes[1] as u8);
        let (j, m, gain) = (size(self.impulse), size(self.mass), self.gain);
        [px, py, pz, nx, ny, nz, vx, vy, vz, wx, wy, wz, j, m, r, s, gain, shapes].map(f64::to_bits)
    }

    /// Speed at which the bodies approach along the normal, m/s. Negative while they separate.
    pub fn approach(&self) -> Option<f64> {
        self.velocity.map(|v| -v.dot(self.normal))
    }
}
