//! How two bodies that dent share the energy of a blow.

use crate::example::blow::{Blow, Striker};
use crate::instance::inbox::Inbox;
use crate::select::hit::{Cause, Hit, HitStatus, Space};

/// The whole blow between two bodies, as the first one gets it, in world space.
#[derive(Debug, Clone, Copy)]
pub(super) struct Whole {
    pub point: [f32; 3],
    pub blow: Blow,
}

impl Whole {
    /// How deep the blow would dent a body that took all of it, m.
    fn depth(&self, inbox: &Inbox, turned: bool, radius: Option<f32>) -> f64 {
        let turn = |v: [f32; 3]| if turned { v.map(|x| -x) } else { v };
        let striker = Striker { velocity: self.blow.striker.velocity.map(turn), radius, ..self.blow.striker };
        let blow =
            Blow { impulse: self.blow.impulse.map(turn), normal: self.blow.normal.map(turn), striker, ..self.blow };
        let hit =
            Hit { point: self.point, cause: Cause::Impulse { blow, mass: None }, space: Space::World, contact: None };
        match inbox.preview(&hit) {
            Ok(outcome) if outcome.status != HitStatus::Rigid => {
                outcome.target.iter().map(|x| f64::from(*x) * f64::from(*x)).sum::<f64>().sqrt()
            }
            _ => 0.0,
        }
    }
}

/// The bodies' shares of the energy, which sum to 1. Both feel the same force, as two springs in series do: with a depth `d`
/// under the whole blow a spring has the stiffness `2E / d²`, and takes the energy in proportion to `d²`. Bodies that
/// neither dent take half each. `radii` are those of the bodies themselves.
pub(super) fn shares(whole: &Whole, bodies: [&Inbox; 2], radii: [Option<f32>; 2]) -> [f64; 2] {
    let give = [whole.depth(bodies[0], false, radii[1]), whole.depth(bodies[1], true, radii[0])].map(|d| d * d);
    let sum = give[0] + give[1];
    if sum > 0.0 { give.map(|g| g / sum) } else { [0.5; 2] }
}
