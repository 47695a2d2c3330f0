//! A touch: what one place of a body gets from another body, over the steps that it lasts. It makes one dent.

use super::manifold::Part;
use super::point::Body;
use crate::base::math::to_f32;
use crate::example::blow::{Blow, Striker, StrikerShape};
use crate::select::hit::{Cause, Hit, Space};
use glam::{DMat3, DVec3};
use std::num::NonZeroU64;

/// A part that approaches faster than the touch did, by this factor, is another blow.
const FASTER: f64 = 1.25;
/// A part slower than this share of the touch only holds the bodies apart.
const HOLDS: f64 = 0.05;

/// The pair that a touch belongs to, the bodies' numbers, and which of them dents.
pub(super) type Key = (u64, [u64; 2], usize);

/// How a part relates to a touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fit {
    Same,
    /// It is another blow at the same place.
    Another,
    /// It only holds the bodies apart.
    Holds,
}

#[derive(Debug)]
pub(super) struct Touch {
    pub key: Key,
    pub id: NonZeroU64,
    pub body: Body,
    /// Where it began, in the body's space, m.
    pub place: DVec3,
    /// When it began and when its pair was seen last, s.
    pub begin: f64,
    pub last: f64,
    /// The body's share of the energy.
    share: f64,
    /// Approach speed, m/s.
    speed: Option<f64>,
    /// Of the striker relative to the body, m/s, when it approached fastest.
    velocity: Option<DVec3>,
    radius: Option<f32>,
    shape: StrikerShape,
    /// Impulse of all parts, N·s.
    impulse: f64,
    /// The most energy that the touches of its key may have together, J, before the bodies share it.
    pub cap: f64,
    /// The parts that the body has not got yet: impulse, and place and normal times impulse.
    waiting: (f64, DVec3, DVec3),
}

impl Touch {
    pub fn new(key: Key, id: NonZeroU64, body: Body, place: DVec3, now: f64, share: f64) -> Self {
        Touch {
            key,
            id,
            body,
            place,
            begin: now,
            last: now,
            share,
            speed: None,
            velocity: None,
            radius: None,
            shape: StrikerShape::Unknown,
            impulse: 0.0,
            cap: f64::INFINITY,
            waiting: (0.0, DVec3::ZERO, DVec3::ZERO),
        }
    }

    pub fn fit(&self, part: &Part) -> Fit {
        let holds = |(old, new): (f64, f64)| !part.push.derived && new < HOLDS * old;
        match self.speed.zip(part.push.speed) {
            _ if self.is_slower_than(part) => Fit::Another,
            speeds if speeds.is_some_and(holds) => Fit::Holds,
            _ => Fit::Same,
        }
    }

    /// Whether a part approaches so fast that it is another blow.
    pub fn is_slower_than(&self, part: &Part) -> bool {
        self.speed.zip(part.push.speed).is_some_and(|(old, new)| !part.push.derived && new > FASTER * old)
    }

    /// Adds a part, as far as the touch then has at most `most` J.
    pub fn add(&mut self, part: &Part, most: f64) {
        let push = &part.push;
        let given = if push.derived || push.guessed.is_some() {
            push.impulse
        } else {
            let speed = if push.speed > self.speed { push.speed } else { self.speed };
            let room = speed.map_or(f64::INFINITY, |speed| 2.0 * most / speed - self.impulse);
            push.impulse.min(room)
        };
        if given <= 0.0 {
            return;
        }
        if push.derived {
            self.speed = push.speed.map(|v| v + self.speed.unwrap_or(0.0));
        } else if push.speed > self.speed {
            (self.speed, self.velocity) = (push.speed, part.velocity);
        }
        let impulse = match (push.guessed, self.speed) {
            // The bodies stop each other once, however many steps that takes.
            (Some(mass), Some(speed)) => (mass * speed - self.impulse).max(0.0),
            _ => given,
        };
        if part.radius > self.radius {
            self.radius = part.radius;
        }
        self.shape = self.shape.max(part.shape);
        self.impulse += impulse;
        let (waiting, place, normal) = self.waiting;
        self.waiting = (waiting + impulse, place + part.place * impulse, normal + part.normal * impulse);
    }

    /// Energy before the bodies share it, J. `None` if the speed is unknown.
    pub fn whole(&self) -> Option<f64> {
        self.speed.map(|speed| 0.5 * self.impulse * speed)
    }

    /// Energy that the body gets, J. `None` if the speed is unknown.
    pub fn energy(&self) -> Option<f64> {
        self.whole().map(|whole| whole * self.share)
    }

    /// Whether it was strong enough for a hit.
    pub fn has_struck(&self) -> bool {
        self.waiting.0 < self.impulse
    }

    /// What the body has not got yet, if the touch has at least `least` J. `to_body` is the body's transform from world
    /// space.
    ///
    /// Bodies share the energy as two springs in series do: both get the whole impulse, each a share of the speed. The
    /// mass of the hit is that of all parts so far, so that the parts' impulses, the fastest velocity and the
    /// largest mass are together one blow whose energy is half of impulse times speed.
    pub fn hit(&mut self, least: f64, to_body: (DMat3, DVec3)) -> Option<Hit> {
        let (waiting, place, normal) = self.waiting;
        let normal = normal.try_normalize()?;
        if waiting <= 0.0 || self.share <= 0.0 || self.energy().is_some_and(|e| e < least) {
            return None;
        }
        self.waiting = (0.0, DVec3::ZERO, DVec3::ZERO);
        let speed = self.speed.map(|speed| speed * self.share);
        let impulse = if speed.is_some() { waiting } else { waiting * self.share };
        let velocity = |speed: f64| self.velocity.map_or(normal * -speed, |v| v * self.share);
        let striker = speed.map(|speed| (self.impulse / speed, velocity(speed)));
        let mut blow = blow((normal, impulse), striker);
        (blow.striker.radius, blow.striker.shape) = (self.radius, self.shape);
        let point = to_body.0.inverse() * (place / waiting) + to_body.1;
        Some(Hit {
            point: to_f32(point),
            cause: Cause::Impulse { blow, mass: None },
            space: Space::World,
            contact: Some(self.id),
        })
    }
}

/// A blow of an impulse (N·s) against a normal, by a striker with a mass (kg) and a velocity (m/s), if they are known.
pub(super) fn blow((normal, impulse): (DVec3, f64), striker: Option<(f64, DVec3)>) -> Blow {
    let mass = striker.map(|(mass, _)| mass as f32).filter(|m| *m > 0.0 && m.is_finite());
    let striker = Striker { mass, velocity: striker.map(|(_, v)| to_f32(v)), ..Striker::default() };
    Blow { impulse: Some(to_f32(normal * -impulse)), duration: None, normal: Some(to_f32(normal)), striker }
}
