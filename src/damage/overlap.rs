//! How marks near each other act together: hits on a dented place deepen it less.
//!
//! `n` hits of depth `T` at one place leave a dent `T n^(1/p)` deep. So the energy of a mark, in hits of another mark's
//! depth, goes with the depth to the power `p`. For marks `m` and `j` with contacts `c`, depths `T`, energies `n` and
//! fields `u` of one hit alone:
//!
//! ```text
//! o_mj     = clamp((max(|u_j(c_m)| / |u_j(c_j)|, |u_m(c_j)| / |u_m(c_m)|) - 0.3) / 0.7, 0, 1)     o_mm = 1
//! E_m      = sum over j of o_mj n_j (T_j / T_m)^p               all energy near the contact, in hits of m's depth
//! strength = n_m / E_m * E_m^(1/p)
//! ```
//!
//! The field that is shown is that of one hit with the energy `n_m`, rounded to a power of 2 (8 at most), scaled to the depth
//! `T`: so what is hit again and again at one place gets wider as it gets deeper. Energies of other marks do not widen a dent:
//! their own dents lie there.
//!
//! Terms of other marks are rounded down to whole units of energy. So `E_m` is a sum of integers: hits can be added and
//! taken away one by one, and the sum does not depend on their order.

use super::dent::{Dent, Nearby};
use super::energy::{energy_factor, energy_root, strength_alone};
use super::mark::Mark;
use crate::example::set::ExampleSet;

/// Below this share of its depth, a dent does not count as overlapping.
const FLOOR: f64 = 0.3;
/// The greatest level of energy for which a dent is predicted ([`Mark::harder`]): 8 hits.
const WIDEST: u16 = 3;

/// Makes the dent of a mark, which knows of no other near it. [`settle`] sets its strength.
pub(crate) fn dent_alone(set: &ExampleSet, mark: &Mark) -> Dent {
    let mut dent = Dent::of_one_hit(set, mark);
    dent.nearby = Nearby {
        contact: mark.contact,
        power: energy_factor(mark.depth.into()),
        depth: dent.alone_at(set, mark.contact).length(),
        reach_square: dent.own_reach_square(set),
        others: 0,
    };
    dent
}

/// How far two dents act on the same place, 0 to 1.
pub(crate) fn overlap(set: &ExampleSet, a: &Dent, b: &Dent) -> f64 {
    let apart = (a.contact - b.contact).length_squared();
    let share = |of: &Dent, at: &Dent| {
        let near = of.nearby.depth > 0.0 && apart <= of.nearby.reach_square;
        let moved = if near { of.alone_at(set, at.nearby.contact).length() } else { 0.0 };
        if near { f64::from(moved) / f64::from(of.nearby.depth) } else { 0.0 }
    };
    ((share(a, b).max(share(b, a)) - FLOOR) / (1.0 - FLOOR)).clamp(0.0, 1.0)
}

/// Adds to the energy that other marks have at `dent` the difference that a change of `other`'s energy makes.
pub(crate) fn change(dent: &mut Dent, other: &Dent, overlap: f64, before: u64, after: u64) {
    let factor = overlap * (other.nearby.power / dent.nearby.power);
    // `as` saturates, and u64 as f64 rounds to nearest. Both are the same on every platform.
    let given = |energy: u64| u128::from((energy as f64 * factor) as u64);
    dent.nearby.others = dent.nearby.others + given(after) - given(before);
}

/// Sets the strength of a mark's dent, and its width.
pub(crate) fn settle(set: &ExampleSet, mark: &Mark, dent: &mut Dent) {
    dent.alone = strength_alone(mark.energy);
    let all = u128::from(mark.energy) + dent.nearby.others;
    dent.strength = (mark.energy as f64 / all as f64 * energy_root(all as f64 / Mark::ONE as f64)) as f32;
    let hits = mark.energy as f64 / Mark::ONE as f64;
    dent.widen(set, mark, (libm::round(libm::log2(hits.max(1.0))) as u16).min(WIDEST));
}
