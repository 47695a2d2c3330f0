//! How the depth of a dent grows with the energy of its hits.

use super::mark::Mark;

/// The depth of a dent to this power grows as the energy does.
const EXPONENT: f64 = 2.4;
/// Dents whose strength alone is below this are removed.
const LEAST: f32 = 1e-4;

/// The energy, as a factor, that makes a dent `factor` times as deep.
pub(crate) fn energy_factor(factor: f64) -> f64 {
    libm::pow(factor, EXPONENT)
}

/// How many times as deep so many times the energy makes a dent.
pub(super) fn energy_root(factor: f64) -> f64 {
    libm::pow(factor, 1.0 / EXPONENT)
}

/// Strength of a mark that has no other near it.
pub(crate) fn strength_alone(energy: u64) -> f32 {
    energy_root(energy as f64 / Mark::ONE as f64) as f32
}

/// Whether the dent of a mark with this energy is so weak that it is removed.
pub(crate) fn is_gone(energy: u64) -> bool {
    strength_alone(energy) < LEAST
}

/// The depth of one hit that has the energy of all these marks, m.
pub(crate) fn depth_of_one<'a>(marks: impl Iterator<Item = &'a Mark>) -> f32 {
    let hits = |mark: &Mark| mark.energy as f64 / Mark::ONE as f64;
    let all: f64 = marks.map(|mark| hits(mark) * energy_factor(mark.depth.into())).sum();
    energy_root(all) as f32
}
