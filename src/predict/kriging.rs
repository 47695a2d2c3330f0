//! Kriging: the best linear unbiased prediction of rows of numbers from those of known points.

use super::features::{Point, differences};
use super::kernel::{GROUPS, Lengths, factors, matern, noise_ratio};
use super::linear::{cholesky, inverse, product, solve};

/// The system of a set of points, and its inverse.
pub(super) struct Kriging {
    n: usize,
    /// Inverse of covariances and noise; for an unknown mean without what a constant explains.
    projected: Vec<f64>,
    /// Weights of the points in the mean; empty if the mean is 0.
    mean: Vec<f64>,
}

/// The covariance of two points.
pub(super) fn covariance(a: &Point, b: &Point, factors: &[f64; GROUPS]) -> f64 {
    let d = differences(a, b);
    matern((0..GROUPS).map(|g| factors[g] * d[g]).sum())
}

impl Kriging {
    /// Factors the system. Noise is raised until that works.
    pub(super) fn new(points: &[Point], lengths: &Lengths, ordinary: bool) -> Self {
        let n = points.len();
        let f = factors(lengths);
        let mut noise = noise_ratio(lengths);
        let mut projected = loop {
            let mut k = vec![0.0; n * n];
            for i in 0..n {
                (0..i).for_each(|j| k[i * n + j] = covariance(&points[i], &points[j], &f));
                k[i * n + i] = 1.0 + noise;
            }
            if cholesky(&mut k, n) {
                break inverse(&k, n);
            }
            noise = 4.0 * noise + 1e-9;
        };
        let mut mean = Vec::new();
        if ordinary {
            mean = projected.chunks_exact(n).map(|row| row.iter().sum::<f64>()).collect();
            let all: f64 = mean.iter().sum();
            for i in 0..n {
                for j in 0..n {
                    projected[i * n + j] -= mean[i] * mean[j] / all;
                }
            }
            mean.iter_mut().for_each(|m| *m /= all);
        }
        Self { n, projected, mean }
    }

    /// The mean of `columns` numbers a point, and the coefficients of the covariances with the points:
    /// a prediction is the mean plus the sum of covariance times coefficient.
    pub(super) fn coefficients(&self, rows: &[f64], columns: usize) -> (Vec<f64>, Vec<f64>) {
        let mut mean = vec![0.0; columns];
        for (m, row) in self.mean.iter().zip(rows.chunks_exact(columns.max(1))) {
            mean.iter_mut().zip(row).for_each(|(to, x)| *to += m * x);
        }
        (mean, product(&self.projected, rows, self.n, columns))
    }

    /// What the others miss of each row if its group is left out. `groups` are lists of points.
    pub(super) fn missed(&self, rows: &[f64], columns: usize, groups: &[Vec<usize>]) -> Vec<f64> {
        let n = self.n;
        let mut out = product(&self.projected, rows, n, columns);
        for group in groups {
            let m = group.len();
            let mut block: Vec<f64> =
                group.iter().flat_map(|i| group.iter().map(move |j| self.projected[i * n + j])).collect();
            let mut right: Vec<f64> =
                group.iter().flat_map(|i| out[i * columns..(i + 1) * columns].iter().copied()).collect();
            if m == n || !solve(&mut block, &mut right, m, columns) {
                // Nothing is left to predict from.
                right.clear();
                group.iter().for_each(|i| right.extend(&rows[i * columns..(i + 1) * columns]));
            }
            for (i, row) in group.iter().zip(right.chunks_exact(columns.max(1))) {
                out[i * columns..(i + 1) * columns].copy_from_slice(row);
            }
        }
        out
    }
}
