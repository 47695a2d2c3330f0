//! The points of one pair in one step: what each pushes, and which of them make one dent.

use super::options::{ContactOptions, Impulses};
use super::point::Reported;
use crate::example::blow::StrikerShape;
use glam::{DMat3, DVec3};

/// What one point did in the step.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Push {
    /// Normal impulse times the gain, N·s.
    pub impulse: f64,
    /// Approach speed, m/s. `None` if neither velocity nor masses are known.
    pub speed: Option<f64>,
    /// Whether the speed is the impulse over the mass: parts of a touch then add up to its speed.
    pub derived: bool,
    /// The mass behind the impulse times the gain, kg. `None` if it is unknown.
    pub mass: Option<f64>,
    /// If the impulse is a guess that the bodies stop each other: the mass behind it times the gain, kg.
    pub guessed: Option<f64>,
}

/// Fills `out` with the pushes of the points of one pair.
pub(super) fn pushes(points: &[Reported], options: &ContactOptions, out: &mut Vec<Push>) {
    let count = points.len() as f64;
    let given = |p: &Reported| match options.impulses {
        Impulses::PerPoint => p.impulse,
        Impulses::WholeAtEveryPoint => p.impulse.map(|j| j / count),
        Impulses::ZeroIsUnknown => p.impulse.filter(|j| *j > 0.0),
    };
    let coming = |p: &Reported| p.approach().is_some_and(|v| v > 0.0);
    let unknown = points.iter().filter(|p| given(p).is_none() && coming(p)).count().max(1) as f64;
    // Impulse and guessed mass, without the gain.
    let push = |p: &Reported| match (given(p), p.mass, p.approach()) {
        (Some(impulse), ..) => (impulse, None),
        (None, Some(mass), Some(v)) if v > 0.0 => {
            let mass = mass / unknown;
            match p.velocity_after {
                Some(after) => (mass * (v + after.dot(p.normal)).max(0.0), None),
                None => (mass * v, Some(mass)),
            }
        }
        _ => (0.0, None),
    };
    let total: f64 = points.iter().map(|p| push(p).0).sum();
    let share = blow_share(points, |p| push(p).0);
    out.clear();
    out.extend(points.iter().map(|p| {
        let (impulse, guessed) = push(p);
        let gain = p.gain * f64::from(options.gain) * share;
        let speed = p.approach().or_else(|| Some(total / p.mass?));
        let mass = p.mass.map(|m| m * p.gain * f64::from(options.gain));
        let derived = p.velocity.is_none();
        Push { impulse: impulse * gain, speed, derived, mass, guessed: guessed.map(|m| m * gain) }
    }));
}

/// An impulse that exceeds what stops the bodies by up to this factor only moves them apart again: solvers do so where bodies
/// sank into each other.
const SOLVER: f64 = 1.25;
/// From this factor on, something else pushes the bodies together, and all of the impulse counts.
const PUSHED: f64 = 1.75;

/// The share of the impulses that belongs to the blow. Points at which the bodies do not approach stop nothing: where a box sank into a
/// mesh, solvers push its sides, too.
fn blow_share(points: &[Reported], impulse: impl Fn(&Reported) -> f64) -> f64 {
    let (mut all, mut stops) = (0.0, 0.0);
    for p in points {
        let (Some(mass), Some(speed)) = (p.mass, p.approach()) else { return 1.0 };
        if speed > 0.0 {
            let j = impulse(p);
            all += j;
            stops += j * mass * speed;
        }
    }
    // The impulses' mean of what stops the bodies.
    let excess = all * all / stops;
    match excess {
        e if e > 1.0 && e <= SOLVER => 1.0 / e,
        e if e > SOLVER && e < PUSHED => (1.0 + (PUSHED - 1.0) * (e - SOLVER) / (PUSHED - SOLVER)) / e,
        _ => 1.0,
    }
}

impl Push {
    /// Energy, J. 0 if the speed is unknown.
    pub fn energy(&self) -> f64 {
        0.5 * self.impulse * self.speed.unwrap_or(0.0)
    }

    /// Energy of the bodies' approach, J. `None` if it is unknown.
    pub fn approach(&self) -> Option<f64> {
        let (mass, speed) = self.mass.zip(self.speed)?;
        (!self.derived).then_some(0.5 * mass * speed * speed)
    }
}

/// A push on one of the two bodies.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Part {
    /// In the body's own space, m.
    pub place: DVec3,
    /// Out of the body, of length 1, in world space.
    pub normal: DVec3,
    /// Of the striker relative to the body, m/s, in world space.
    pub velocity: Option<DVec3>,
    /// Radius of the striker, m.
    pub radius: Option<f32>,
    pub shape: StrikerShape,
    pub push: Push,
}

impl Part {
    /// What a point does to the body on `side` of its pair, whose transform from world space is `to_body`.
    pub fn new(p: &Reported, push: Push, side: usize, to_body: (DMat3, DVec3)) -> Self {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        Part {
            place: to_body.0 * (p.point - to_body.1),
            normal: p.normal * sign,
            velocity: p.velocity.map(|v| v * sign),
            radius: p.radii[1 - side],
            shape: p.shapes[1 - side],
            push,
        }
    }

    /// This sum of parts and another part. Places, normals and velocities are added up times the impulses; the mass is guessed if all
    /// are.
    fn and(self, part: Part) -> Part {
        let (sum, push, j) = (self.push, part.push, part.push.impulse);
        Part {
            place: self.place + part.place * j,
            normal: self.normal + part.normal * j,
            velocity: part.velocity.map(|v| v * j + self.velocity.unwrap_or_default()).or(self.velocity),
            radius: larger(part.radius, self.radius),
            shape: self.shape.max(part.shape),
            push: Push {
                impulse: sum.impulse + j,
                speed: larger(push.speed, sum.speed),
                derived: sum.derived || push.derived,
                mass: larger(push.mass, sum.mass),
                guessed: sum.guessed.zip(push.guessed).map(|(a, b)| a + b),
            },
        }
    }

    /// The one part that a sum is.
    fn mean(self) -> Part {
        let impulse = self.push.impulse;
        let normal = self.normal.normalize_or_zero();
        let velocity = self.velocity.filter(|_| !self.push.derived).map(|v| v / impulse);
        let speed = velocity.map(|v| -v.dot(normal)).or(self.push.speed);
        Part { place: self.place / impulse, normal, velocity, push: Push { speed, ..self.push }, ..self }
    }
}

/// Takes the parts that make one dent with the strongest out of `parts`, and joins them at their centre by impulse.
/// `None` if no part is left.
pub(super) fn next_blow(parts: &mut Vec<Part>, radius: f64) -> Option<Part> {
    let stronger = |a: &Part, b: &Part| if b.push.impulse > a.push.impulse { *b } else { *a };
    let strongest = parts.iter().copied().reduce(|a, b| stronger(&a, &b))?;
    let near = |part: &Part| part.place.distance_squared(strongest.place) <= radius * radius;
    let none = Part { push: Push { guessed: Some(0.0), ..Push::default() }, ..Part::default() };
    let sum = parts.extract_if(.., |part| near(part)).fold(none, Part::and);
    // A place out of range has no distance, not even from itself.
    if sum.push.impulse == 0.0 {
        parts.clear();
        return None;
    }
    Some(sum.mean())
}

/// The larger of two numbers. What is unknown is less than any.
fn larger<T: PartialOrd>(a: Option<T>, b: Option<T>) -> Option<T> {
    if b > a { b } else { a }
}
