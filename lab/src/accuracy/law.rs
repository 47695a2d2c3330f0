//! What an engine without Crumple would do with a blow: a power law from the blow to the depth, fitted to the examples. The
//! classic rule and the radial profile get their target displacement from it.

use crate::metric::dot64;
use crate::truth::{Blow, Impact};

/// What the law sees of a blow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sees {
    /// Normal impulse, mass and radius of the striker.
    Striker,
    /// Normal impulse alone.
    Impulse,
}

/// ln depth = constant + exponents * ln(normal impulse, mass, radius).
pub struct Law {
    sees: Sees,
    constant: f64,
    /// Mean of the logarithms over the examples.
    centre: [f64; 3],
    exponents: [f64; 3],
}

/// Exponents where the examples tell nothing: depth as the square root of the energy, or as the impulse.
const OF_STRIKER: [f64; 3] = [1.0, -0.5, 0.0];
const OF_IMPULSE: [f64; 3] = [1.0, 0.0, 0.0];
/// Pull toward those exponents, as so many examples one unit of logarithm from the mean.
const PULL: f64 = 1.0;
/// Shallower examples count as this deep, m.
const SHALLOW: f64 = 1e-3;

impl Law {
    /// Of the impacts whose blow is known. `None` if there are none.
    pub fn fit(train: &[Impact], sees: Sees) -> Option<Self> {
        let known: Vec<([f64; 3], f64)> =
            train.iter().filter_map(|i| Some((logs(i.blow.as_ref()?, sees), i.depth().max(SHALLOW).ln()))).collect();
        if known.is_empty() {
            return None;
        }
        let count = known.len() as f64;
        let centre = [0, 1, 2].map(|k| known.iter().map(|(x, _)| x[k]).sum::<f64>() / count);
        let constant = known.iter().map(|(_, y)| y).sum::<f64>() / count;
        let usual = if sees == Sees::Striker { OF_STRIKER } else { OF_IMPULSE };
        let (mut matrix, mut right) = (glam::DMat3::IDENTITY * PULL, glam::DVec3::ZERO);
        for (x, y) in &known {
            let x = [0, 1, 2].map(|k| x[k] - centre[k]);
            let residual = y - constant - dot64(x, usual);
            let x = glam::DVec3::from_array(x);
            matrix += glam::DMat3::from_cols(x * x.x, x * x.y, x * x.z);
            right += x * residual;
        }
        let change = (matrix.inverse() * right).to_array();
        Some(Law { sees, constant, centre, exponents: [0, 1, 2].map(|k| usual[k] + change[k]) })
    }

    /// Depth that a blow leaves, m.
    pub fn depth(&self, blow: &Blow) -> f64 {
        let x = logs(blow, self.sees);
        (self.constant + dot64([0, 1, 2].map(|k| x[k] - self.centre[k]), self.exponents)).exp()
    }

    /// Displacement that a blow leaves: the depth, against the contact normal, m.
    pub fn displacement(&self, blow: &Blow) -> [f32; 3] {
        let depth = self.depth(blow) as f32;
        blow.normal.map(|n| -depth * n)
    }
}

/// What a method is told that wants a displacement: that of the law or, without a law or a blow, that of the truth.
pub fn target(law: Option<&Law>, impact: &Impact) -> [f32; 3] {
    match (law, &impact.blow) {
        (Some(law), Some(blow)) => law.displacement(&blow.in_engine()),
        _ => impact.displacement,
    }
}

fn logs(blow: &Blow, sees: Sees) -> [f64; 3] {
    let impulse = blow.in_engine().impulse;
    let along = -dot64(impulse.map(f64::from), blow.normal.map(f64::from));
    let normal = along.max(1e-6).ln();
    match sees {
        Sees::Striker => [normal, f64::from(blow.mass).ln(), f64::from(blow.radius).ln()],
        Sees::Impulse => [normal, 0.0, 0.0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::truth::{Body, Truth};

    #[test]
    fn a_harder_blow_is_deeper_and_examples_are_met_on_average() {
        for (truth, name) in [(Truth::Shots, "panel"), (Truth::Structure, "door"), (Truth::Steel, "hood")] {
            let body = Body::read(truth, name).unwrap();
            for sees in [Sees::Striker, Sees::Impulse] {
                let law = Law::fit(&body.train, sees).unwrap();
                let blow = body.train[0].blow.unwrap();
                let harder = Blow { velocity: blow.velocity.map(|v| 2.0 * v), ..blow };
                assert!(law.depth(&harder) > law.depth(&blow), "{name} {sees:?}");
                let ratio = |i: &Impact| (law.depth(&i.blow.unwrap()) / i.depth().max(SHALLOW)).ln();
                let mean = body.train.iter().map(ratio).sum::<f64>() / body.train.len() as f64;
                assert!(mean.abs() < 1e-9, "{name} {sees:?}: {mean}");
            }
        }
        let presses = Body::read(Truth::Presses, "panel").unwrap();
        assert!(Law::fit(&presses.train, Sees::Striker).is_none());
    }
}
