//! How two bodies that dent share the energy of a blow.

use super::manifold::Push;
use super::point::Reported;
use super::touch::blow;
use crate::base::math::to_f32;
use crate::instance::inbox::Inbox;
use crate::select::hit::{Hit, HitStatus, Space};
use glam::DVec3;

/// The bodies' shares of the energy of a pair's points, which sum to 1. Both feel the same force, as two springs in series do: with a
/// depth `d` under the whole blow a spring has the stiffness `2E / d²`, and takes the energy in proportion to `d²`. Bodies that neither
/// dent take half each.
pub(super) fn shares(points: &[Reported], pushes: &[Push], bodies: [&Inbox; 2]) -> [f64; 2] {
    let pushing = || points.iter().zip(pushes).filter(|(_, push)| push.impulse > 0.0);
    let Some((fastest, push)) = pushing().reduce(|a, b| if b.1.speed > a.1.speed { b } else { a }) else {
        return [0.5; 2];
    };
    let total: f64 = pushing().map(|(_, push)| push.impulse).sum();
    let place = to_f32(pushing().map(|(p, push)| p.point * push.impulse).sum::<DVec3>() / total);
    let speed = push.speed.filter(|speed| *speed > 0.0);
    // In the first of many steps only a part of the impulse is known.
    let expected = fastest.mass.zip(speed).map_or(total, |(mass, speed)| total.max(mass * speed));
    let velocity = |speed: f64| fastest.velocity.unwrap_or(fastest.normal * -speed);
    // How deep the blow would dent a body that took all of it, m.
    let depth = |side: usize| {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let striker = speed.map(|speed| (expected / speed, velocity(speed) * sign));
        let mut blow = blow((fastest.normal * sign, expected), striker);
        blow.striker.radius = fastest.radii[1 - side];
        match bodies[side].preview(&Hit { space: Space::World, ..Hit::blow(place, blow) }) {
            Ok(outcome) if outcome.status != HitStatus::Rigid => {
                DVec3::from_array(outcome.target.map(f64::from)).length()
            }
            _ => 0.0,
        }
    };
    let give = [depth(0), depth(1)].map(|d| d * d);
    let sum = give[0] + give[1];
    if sum > 0.0 { give.map(|g| g / sum) } else { [0.5; 2] }
}
