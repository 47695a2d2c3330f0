//! What a set's examples say about blows on its body: from when on a contact is a blow, and how wide a dent is.

use super::options::ContactOptions;
use crate::example::example::Example;
use crate::example::set::ExampleSet;
use glam::DVec3;
use std::sync::{Arc, Weak};

/// Shares of the slowest example's speed and of the weakest example's energy. Energy goes with the square of speed.
const SPEED: f64 = 0.25;
const ENERGY: f64 = SPEED * SPEED;
/// Least speed of a blow, m/s: gravity adds 0.33 m/s in a step of 1/30 s.
const LEAST_SPEED: f64 = 0.5;
/// Share of the examples' median support radius.
const WIDTH: f64 = 0.5;

/// The thresholds of one body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    /// Least approach speed of a blow, m/s.
    pub speed: f64,
    /// Least energy of a touch, J.
    pub energy: f64,
    /// Least impulse in a step if neither speed nor masses are known, N·s.
    pub impulse: f64,
    /// Points nearer to each other than this make one dent, m.
    pub radius: f64,
}

impl Scale {
    fn of(set: &ExampleSet) -> Self {
        let examples = || set.examples().iter().filter(|e| !e.is_empty());
        let least = |of: fn(&Example) -> Option<f64>| examples().filter_map(of).reduce(f64::min);
        let mut radii: Vec<f32> = examples().map(Example::support_radius).collect();
        radii.sort_by(f32::total_cmp);
        let radius = radii.get(radii.len() / 2).copied().unwrap_or_else(|| set.mesh().bounds().diagonal());
        Scale {
            speed: least(speed).map_or(LEAST_SPEED, |v| (SPEED * v).max(LEAST_SPEED)),
            energy: least(|e| Some(0.5 * speed(e)? * impulse(e)?)).map_or(0.0, |e| ENERGY * e),
            impulse: least(impulse).map_or(0.0, |j| SPEED * j),
            radius: WIDTH * f64::from(radius),
        }
    }

    /// The same with what the options say.
    pub fn with(self, options: &ContactOptions) -> Self {
        let or = |given: Option<f32>, own| given.map_or(own, f64::from);
        Scale {
            speed: or(options.min_speed, self.speed),
            energy: or(options.min_energy, self.energy),
            impulse: self.impulse,
            radius: or(options.dent_radius, self.radius),
        }
    }
}

/// The part of `v` that goes into the body at the example's contact.
fn into(e: &Example, v: [f32; 3]) -> Option<f64> {
    let double = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let normal = e.blow().normal.map(double).or(e.contact_normal().map(|n| n.as_dvec3()))?;
    Some(-double(v).dot(normal)).filter(|into| *into > 0.0)
}

/// Approach speed of an example's blow, m/s.
fn speed(e: &Example) -> Option<f64> {
    into(e, e.blow().striker.velocity?)
}

/// Normal impulse of an example's blow, N·s.
fn impulse(e: &Example) -> Option<f64> {
    into(e, e.blow().total_impulse()?)
}

/// The scales of the sets seen so far.
#[derive(Debug, Default)]
pub(super) struct Scales(Vec<(Weak<ExampleSet>, Scale)>);

impl Scales {
    pub fn of(&mut self, set: &Arc<ExampleSet>) -> Scale {
        if let Some((_, scale)) = self.0.iter().find(|(known, _)| known.as_ptr() == Arc::as_ptr(set)) {
            return *scale;
        }
        let scale = Scale::of(set);
        self.0.retain(|(known, _)| known.strong_count() > 0);
        self.0.push((Arc::downgrade(set), scale));
        scale
    }
}
