//! The options of a contact layer.

use crate::base::error::{Error, at_least_zero, positive};

/// What the impulses of contact points mean, which differs among physics engines.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Impulses {
    /// Each point has its own impulse: Bullet, PhysX, rapier, ODE. A point whose impulse is 0 did not push. The default.
    #[default]
    PerPoint = 0,
    /// Each point has the impulse of the whole pair in the step. It is divided among the pair's points.
    WholeAtEveryPoint = 1,
    /// Each point has its own impulse, but 0 means that it is unknown: Godot Physics reports 0 in the step of impact.
    ZeroIsUnknown = 2,
}

/// The options of a [`ContactLayer`](crate::ContactLayer).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactOptions {
    /// Factor of the energy of every blow. At least 0; 1 is what the physics says.
    pub gain: f32,
    /// No touch begins with points that approach more slowly, m/s. `None`: a quarter of the speed of the set's slowest
    /// example, at least 0.5 m/s, which is above what gravity adds in a step of 1/30 s.
    pub min_speed: Option<f32>,
    /// Touches of less energy leave nothing, J. `None`: a sixteenth of the energy of the set's weakest example.
    pub min_energy: Option<f32>,
    /// Points of a pair that are nearer to each other make one dent, m, in the mesh's space. `None`: half of the median
    /// [support radius](crate::Example::support_radius) of the set's examples.
    pub dent_radius: Option<f32>,
    /// How long a touch lasts at most, s. Above 0. What pushes longer makes another dent, if it is fast enough.
    pub touch_time: f32,
    /// A touch whose pair was not reported for longer than this has ended, s.
    pub separation_time: f32,
    /// What the impulses of points mean.
    pub impulses: Impulses,
    /// The most points between two steps, 1 to 16777216.
    pub max_points: u32,
    /// The most touches at a time, 1 to 65536. Beyond it, the oldest ends early.
    pub max_touches: u32,
}

impl Default for ContactOptions {
    fn default() -> Self {
        Self {
            gain: 1.0,
            min_speed: None,
            min_energy: None,
            dent_radius: None,
            touch_time: 0.1,
            separation_time: 0.05,
            impulses: Impulses::PerPoint,
            max_points: 65536,
            max_touches: 1024,
        }
    }
}

impl ContactOptions {
    pub(super) fn check(&self) -> Result<(), Error> {
        at_least_zero("gain", self.gain, "a factor")?;
        self.min_speed.map_or(Ok(()), |v| at_least_zero("min_speed", v, "m/s"))?;
        self.min_energy.map_or(Ok(()), |e| at_least_zero("min_energy", e, "J"))?;
        self.dent_radius.map_or(Ok(()), |r| positive("dent_radius", r, "m"))?;
        positive("touch_time", self.touch_time, "s")?;
        at_least_zero("separation_time", self.separation_time, "s")?;
        let within = |name, value, most: u32, what: &str| {
            let right = (1..=most).contains(&value);
            if right { Ok(()) } else { Err(Error::invalid(name, value, &format!("1 to {most} {what}"))) }
        };
        within("max_points", self.max_points, 1 << 24, "points")?;
        within("max_touches", self.max_touches, 1 << 16, "touches")
    }
}
