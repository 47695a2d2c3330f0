//! How large a field is: a power law of strength, mass and radius, and a regression on what it misses.

use super::features::{Point, Points, STRENGTH_AXIS};
use super::fit::{Prior, fit};
use super::kernel::{GROUPS, Lengths, STRENGTH, factors, matern};
use super::kriging::Kriging;
use super::linear::solve;

/// Distance of the strengths at which the law is computed; between them it is a straight line. Logarithm.
const KNOT: f64 = 0.9;
/// Most knots.
const MOST_KNOTS: usize = 12;
/// Least exponent of the strength, so that a harder hit is never smaller.
const LEAST_SLOPE: f64 = 0.1;
/// Precision of the prior on the exponents of strength, mass and radius. Examples have nearly one radius, which tells little of its
/// exponent.
const PRECISION: [f64; 3] = [0.5, 0.5, 5.0];

/// The logarithm of the size of a field.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct SizeLaw {
    /// Level, and exponents of strength, mass and radius.
    pub law: [f64; 4],
    pub factors: [f64; GROUPS],
    pub mean: f64,
    pub coefficients: Vec<f64>,
    /// Strengths (logarithms), rising.
    pub knots: Vec<f64>,
}

impl SizeLaw {
    /// Learns the law of `logs`, logarithms of sizes. `exponent` is the expected exponent of the strength. `used` are the
    /// points for the fit. Also returns what the others miss of each logarithm.
    pub(super) fn learn(
        points: &[Point],
        logs: &[f64],
        groups: &[Vec<usize>],
        used: &[usize],
        exponent: f64,
        prior: Lengths,
    ) -> (Self, Vec<f64>) {
        let row = |p: &Point| [1.0, p[STRENGTH_AXIS], p[STRENGTH_AXIS + 1], p[STRENGTH_AXIS + 2]];
        let (mut a, mut law) = (vec![0.0; 16], vec![0.0; 4]);
        for (p, y) in points.iter().zip(logs) {
            let x = row(p);
            for i in 0..4 {
                law[i] += x[i] * (y - exponent * x[1]);
                (0..4).for_each(|j| a[i * 4 + j] += x[i] * x[j]);
            }
        }
        (0..4).for_each(|i| a[i * 5] += if i == 0 { 1e-6 } else { PRECISION[i - 1] });
        solve(&mut a, &mut law, 4, 1);
        let law = [law[0], (law[1] + exponent).max(LEAST_SLOPE), law[2], law[3]];
        let base = |p: &Point| row(p).iter().zip(law).map(|(x, b)| x * b).sum::<f64>();
        let rest: Vec<f64> = points.iter().zip(logs).map(|(p, y)| y - base(p)).collect();
        let prior = Prior { mean: prior, deviation: 1.0, outputs: 1.0, ordinary: true };
        let lengths = fit(points, used, |i, j| rest[i] * rest[j], &prior);
        let kriging = Kriging::new(points, &lengths, true);
        let missed = kriging.missed(&rest, 1, groups);
        let (mean, coefficients) = kriging.coefficients(&rest, 1);
        let strengths = points.iter().map(|p| p[STRENGTH_AXIS]);
        let (low, high) = strengths.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let count = (libm::ceil((high - low) / KNOT) as usize + 1).clamp(1, MOST_KNOTS);
        let gap = if count > 1 { (high - low) / (count - 1) as f64 } else { 0.0 };
        let knots = (0..count).map(|k| low + gap * k as f64).collect();
        (Self { law, factors: factors(&lengths), mean: mean[0], coefficients, knots }, missed)
    }

    /// Logarithm of the least strength of an example.
    pub(super) fn weakest(&self) -> f64 {
        self.knots[0]
    }

    /// The logarithm of the size at `x`, which never falls with its strength. `d2` are the groups of squared differences
    /// to the points. `near` takes the covariances at the strength of `x`.
    pub(super) fn at(
        &self,
        x: &Point,
        points: &Points,
        d2: &[f64],
        near: &mut Vec<f64>,
        scratch: &mut Vec<f64>,
    ) -> f64 {
        let n = points.count;
        let f = &self.factors;
        scratch.clear();
        scratch.resize(n, 0.0);
        for g in (0..GROUPS).filter(|g| *g != STRENGTH) {
            scratch.iter_mut().zip(&d2[g * n..(g + 1) * n]).for_each(|(s, d)| *s += f[g] * d);
        }
        near.clear();
        near.extend(
            scratch.iter().zip(&d2[STRENGTH * n..(STRENGTH + 1) * n]).map(|(s, d)| matern(s + f[STRENGTH] * d)),
        );
        let strengths = &points.axes[STRENGTH_AXIS * n..(STRENGTH_AXIS + 1) * n];
        let at = |strength: f64| {
            let mut sums = [0.0; 4];
            for (k, ((s, e), c)) in scratch.iter().zip(strengths).zip(&self.coefficients).enumerate() {
                let d = e - strength;
                sums[k % 4] += c * matern(s + f[STRENGTH] * d * d);
            }
            let others = self.law[0] + self.law[2] * x[STRENGTH_AXIS + 1] + self.law[3] * x[STRENGTH_AXIS + 2];
            others + self.law[1] * strength + self.mean + (sums[0] + sums[1]) + (sums[2] + sums[3])
        };
        // The running maximum over knots, straight between them; outside, the law's exponent.
        let e = x[STRENGTH_AXIS];
        let (first, last) = (self.knots[0], self.knots[self.knots.len() - 1]);
        let mut low = at(first);
        if e <= first {
            return low + self.law[1] * (e - first);
        }
        for pair in self.knots.windows(2) {
            let high = at(pair[1]).max(low);
            if e <= pair[1] {
                return low + (high - low) * ((e - pair[0]) / (pair[1] - pair[0]));
            }
            low = high;
        }
        low + self.law[1] * (e - last)
    }
}
