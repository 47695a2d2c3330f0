//! A learned peer: proper orthogonal decomposition (POD) of the examples' shapes, and kriging of the coefficients. The same as `Modes`
//! of lab/python/surrogates.py, which `told` measures: modes of the examples' fields over their depths, times the depth of the
//! [`Law`] and kriging of what it leaves over. It is here so that its dents can be looked at.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::law::{Law, Sees};
use crate::metric::dot64;
use crate::truth::{Field, Impact};

/// Share of the examples' energy that the modes keep.
const ENERGY: f64 = 0.99;
/// The shape of a shallower example is mostly noise, so it counts as this deep, m.
const SHALLOW: f64 = 4e-3;
/// No depth is less than this in logarithms, m.
const LEAST: f64 = 1e-3;

pub struct Pod {
    /// With kriging of the logarithm that it leaves over. `None` where hits are told the displacement.
    depth: Option<(Law, Kriging)>,
    /// Over the depth, three numbers a vertex.
    mean: DVector<f64>,
    /// One a column.
    modes: DMatrix<f64>,
    coefficients: Kriging,
}

impl Pod {
    pub fn fit(train: &[Impact]) -> Self {
        let features: Vec<Vec<f64>> = train.iter().map(features).collect();
        let depth = Law::fit(train, Sees::Striker).map(|law| {
            let left = train.iter().map(|i| (i.depth().max(LEAST) / told_depth(&law, i)).ln());
            let left = DMatrix::from_iterator(train.len(), 1, left);
            (law, Kriging::fit(&features, &left))
        });

        let columns: Vec<DVector<f64>> = train.iter().map(|i| flat(&i.field) / i.depth().max(SHALLOW)).collect();
        let mut shapes = DMatrix::from_columns(&columns);
        let mean = shapes.column_mean();
        shapes.column_iter_mut().for_each(|mut shape| shape -= &mean);
        let parts = shapes.clone().svd(true, false);
        let all = parts.singular_values.norm_squared();
        let mut energy = 0.0;
        let enough = parts.singular_values.iter().position(|s| {
            energy += s * s;
            energy >= ENERGY * all
        });
        let kept = enough.map_or(parts.singular_values.len(), |last| last + 1);
        let modes = parts.u.expect("asked for").columns(0, kept).into_owned();
        let coefficients = Kriging::fit(&features, &shapes.tr_mul(&modes));
        Self { depth, mean, modes, coefficients }
    }

    /// The field that an impact leaves. Its displacement is told only where no blow is known.
    pub fn predict(&self, impact: &Impact) -> Field {
        let features = features(impact);
        let depth = self
            .depth
            .as_ref()
            .map_or_else(|| impact.depth(), |(law, left)| told_depth(law, impact) * left.predict(&features)[0].exp());
        let shape = &self.mean + &self.modes * self.coefficients.predict(&features);
        shape.as_slice().chunks_exact(3).map(|u| [u[0], u[1], u[2]].map(|x| (depth * x) as f32)).collect()
    }
}

fn told_depth(law: &Law, impact: &Impact) -> f64 {
    impact.blow.as_ref().map_or_else(|| impact.depth(), |blow| law.depth(blow))
}

fn flat(field: &Field) -> DVector<f64> {
    DVector::from_iterator(3 * field.len(), field.iter().flatten().map(|x| f64::from(*x)))
}

/// The contact, and what else is told of a hit: normal impulse, mass and radius of the striker (logarithms) and the direction of the
/// impulse; or depth (logarithm) and direction of the displacement.
fn features(impact: &Impact) -> Vec<f64> {
    let mut all = impact.point.map(f64::from).to_vec();
    if let Some(blow) = impact.blow.map(|b| b.in_engine()) {
        let (impulse, normal) = (blow.impulse.map(f64::from), blow.normal.map(f64::from));
        let along = -dot64(impulse, normal);
        all.extend([along, blow.mass.into(), blow.radius.into()].map(f64::ln));
        all.extend([0, 1, 2].map(|k| impulse[k] / along + normal[k]));
    } else {
        let depth = impact.depth().max(LEAST);
        all.push(depth.ln());
        all.extend(impact.displacement.map(|x| f64::from(x) / depth));
    }
    all
}

/// Gaussian process with one length for the three coordinates of the contact, one for all other features, and noise; each the
/// likeliest of a grid.
struct Kriging {
    centre: Vec<f64>,
    scale: Vec<f64>,
    examples: Vec<Vec<f64>>,
    lengths: [f64; 2],
    mean: DVector<f64>,
    /// A row for each example.
    weights: DMatrix<f64>,
}

impl Kriging {
    /// `values` has a row for each of the examples.
    fn fit(features: &[Vec<f64>], values: &DMatrix<f64>) -> Self {
        let n = features.len();
        let column = |k: usize| features.iter().map(move |x| x[k]);
        let centre: Vec<f64> = (0..features[0].len()).map(|k| column(k).sum::<f64>() / n as f64).collect();
        // One for all three coordinates, and one for each other feature.
        let place = spread((0..3).flat_map(column)) + 1e-9;
        let scale: Vec<f64> = (0..centre.len()).map(|k| if k < 3 { place } else { spread(column(k)) + 1e-2 }).collect();
        let mut fit = Self {
            centre,
            scale,
            examples: Vec::new(),
            lengths: [1.0; 2],
            mean: values.row_mean().transpose(),
            weights: DMatrix::zeros(0, 0),
        };
        fit.examples = features.iter().map(|x| fit.scaled(x)).collect();
        let rest = DMatrix::from_fn(n, values.ncols(), |i, j| values[(i, j)] - fit.mean[j]);
        let least = 1e-12 * rest.norm_squared() / n as f64;
        let mut best = f64::NEG_INFINITY;
        for (lengths, noise) in grid() {
            let covariance = DMatrix::from_fn(n, n, |i, j| {
                near(&fit.examples[i], &fit.examples[j], lengths) + if i == j { noise } else { 0.0 }
            });
            let factor = Cholesky::new(covariance).expect("noise makes it positive definite");
            let weights = factor.solve(&rest);
            let numbers = rest.len() as f64;
            // The variance is common to all columns, and at its likeliest.
            let variance = rest.dot(&weights) / numbers + least;
            let likelihood = -numbers * variance.ln() - rest.ncols() as f64 * factor.ln_determinant();
            if likelihood > best {
                best = likelihood;
                (fit.lengths, fit.weights) = (lengths, weights);
            }
        }
        fit
    }

    fn predict(&self, features: &[f64]) -> DVector<f64> {
        let at = self.scaled(features);
        let near = self.examples.iter().map(|x| near(x, &at, self.lengths));
        &self.mean + self.weights.tr_mul(&DVector::from_iterator(self.examples.len(), near))
    }

    fn scaled(&self, features: &[f64]) -> Vec<f64> {
        features.iter().zip(&self.centre).zip(&self.scale).map(|((x, centre), scale)| (x - centre) / scale).collect()
    }
}

/// Lengths for places and for all else, in units of their spread, and the variance of noise.
fn grid() -> impl Iterator<Item = ([f64; 2], f64)> {
    let lengths = [0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 4.0].into_iter();
    let lengths = lengths.flat_map(|place| [1.0, 2.0, 4.0, 8.0, 16.0].map(|other| [place, other]));
    lengths.flat_map(|both| [1e-4, 1e-2, 1e-1, 0.5].map(|noise| (both, noise)))
}

/// Covariance of two hits, as scaled: 1 of a hit with itself.
fn near(a: &[f64], b: &[f64], lengths: [f64; 2]) -> f64 {
    let squared = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>();
    let [place, other] = [squared(&a[..3], &b[..3]), squared(&a[3..], &b[3..])];
    (-0.5 * (place / lengths[0].powi(2) + other / lengths[1].powi(2))).exp()
}

/// Standard deviation.
fn spread(values: impl Iterator<Item = f64>) -> f64 {
    DVector::from_vec(values.collect()).variance().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::{median, relative_l2};
    use crate::truth::{Body, Truth};

    #[test]
    fn it_errs_as_the_one_in_python() {
        // `rel_l2_median` of docs/lab/told_surrogates.csv, with all examples, told the blow or, of the presses, the displacement.
        for (truth, name, least, python) in [
            (Truth::Shots, "panel", 2e-3, 0.53060),
            (Truth::Presses, "panel", 5e-3, 0.21010),
            (Truth::Steel, "hood", 2e-3, 0.58799),
        ] {
            let body = Body::read(truth, name).unwrap();
            let pod = Pod::fit(&body.train);
            let hits = body.heldout.iter().filter(|i| i.depth() >= least);
            let error = median(&hits.map(|i| relative_l2(&pod.predict(i), &i.field)).collect::<Vec<_>>());
            assert!((error / python - 1.0).abs() < 1e-4, "{name}: {error}");
        }
    }
}
