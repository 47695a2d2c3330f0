//! Chooses the examples of a dent and their shares by ordinary kriging.
//!
//! Hits and examples are points in a space with eleven axes: place (3), logarithm of depth (1), lean (3, the
//! tangential part of the unit displacement), tangential part of the blow (3) and logarithm of the striker's radius (1).
//! Coordinates are relative to the hit and divided by the width of their axis. With `D` the squared distance, the kernel is the rational quadratic `1 / (1 + D / 2)`. K of the [`CANDIDATES`]
//! nearest examples are picked one after the other, each time the one that reduces the kriging variance most. Their
//! shares are the kriging weights, which sum to 1. A negative weight corrects an example that overshoots. Far from all
//! examples the weights become equal. (Krige 1951; Cressie, "Statistics for Spatial Data", 1993, section 3.2.)
//!
//! Uses only IEEE f32 and f64 operations without transcendental functions, so it gives the same bits on every platform.

use crate::base::array_vec::ArrayVec;
use crate::damage::mark::MAX_PAIRS;

/// Number of nearest examples that are considered.
pub(crate) const CANDIDATES: usize = 12;
/// Variance that the axes do not explain (the nugget), as a share of the kernel's height.
const NUGGET: f64 = 0.03;

/// Coordinates of an example relative to a hit.
pub(crate) type Axes = [f32; 11];

/// Squared distance from the hit, which is the origin.
pub(crate) fn distance(a: &Axes) -> f32 {
    a.iter().map(|x| x * x).sum()
}

fn kernel(d: f64) -> f64 {
    1.0 / (1.0 + 0.5 * d)
}

/// Chooses up to `k` (at most [`MAX_PAIRS`]) examples from `near`, which is sorted with the nearest first. Only the
/// first [`CANDIDATES`] are considered. Returns indices into `near` and weights. Weights sum to 1 up to rounding.
pub(crate) fn choose(near: &[Axes], k: usize) -> ArrayVec<(usize, f64), MAX_PAIRS> {
    let n = near.len().min(CANDIDATES);
    let mut system = System::new(&near[..n]);
    let mut picked: ArrayVec<Row, MAX_PAIRS> = ArrayVec::new();
    while picked.len() < k.min(n).min(MAX_PAIRS) {
        let Some(row) = system.best(&picked, n) else { break };
        system.take(&picked, &row, near);
        picked.push(row);
    }
    weights(&picked)
}

/// One value per candidate. Loops also compute picked and unused candidates, so that they vectorize.
type Each = [f64; CANDIDATES];

/// The Cholesky factor `L` of the picked examples' covariances, with the next row for each candidate that could be
/// picked.
struct System {
    /// Each candidate's covariance with the hit, `k`.
    to_hit: Each,
    /// Each candidate's row. `square` is the row's sum of squares; `hit` and `one` are its products with `L^-1 k` and
    /// `L^-1 1`.
    lower: [Each; MAX_PAIRS],
    square: Each,
    hit: Each,
    one: Each,
    picked: [bool; CANDIDATES],
}

/// One row of the factor: `lower`, its diagonal, and its entries of `L^-1 k` (`hit`) and `L^-1 1` (`one`).
#[derive(Debug, Clone, Copy, Default)]
struct Row {
    candidate: usize,
    lower: [f64; MAX_PAIRS],
    diagonal: f64,
    hit: f64,
    one: f64,
}

impl System {
    fn new(near: &[Axes]) -> Self {
        let mut to_hit = [0.0; CANDIDATES];
        for (k, a) in to_hit.iter_mut().zip(near) {
            *k = kernel(a.iter().map(|x| f64::from(*x) * f64::from(*x)).sum());
        }
        let zero = [0.0; CANDIDATES];
        System { to_hit, lower: [zero; MAX_PAIRS], square: zero, hit: zero, one: zero, picked: [false; CANDIDATES] }
    }

    /// The candidate among the first `n` that gives the smallest kriging variance.
    fn best(&self, rows: &[Row], n: usize) -> Option<Row> {
        let sum = |f: fn(&Row) -> f64| rows.iter().map(f).sum::<f64>();
        let (cross, ones, hits) = (sum(|r| r.hit * r.one), sum(|r| r.one * r.one), sum(|r| r.hit * r.hit));
        let (mut diagonal, mut hit, mut one, mut variance) =
            ([0.0; CANDIDATES], [0.0; CANDIDATES], [0.0; CANDIDATES], [0.0; CANDIDATES]);
        for i in 0..CANDIDATES {
            diagonal[i] = (1.0 + NUGGET - self.square[i]).sqrt();
            hit[i] = (self.to_hit[i] - self.hit[i]) / diagonal[i];
            one[i] = (1.0 - self.one[i]) / diagonal[i];
            // The variance up to a constant.
            let missing = 1.0 - (cross + hit[i] * one[i]);
            variance[i] = missing * missing / (ones + one[i] * one[i]) - (hits + hit[i] * hit[i]);
        }
        let mut best: Option<usize> = None;
        // Skips a diagonal of zero or NaN: such a candidate adds no information.
        for i in (0..n).filter(|i| !self.picked[*i] && diagonal[*i] > 0.0) {
            if best.is_none_or(|b| variance[i] < variance[b]) {
                best = Some(i);
            }
        }
        best.map(|i| {
            let lower = self.lower.map(|l| l[i]);
            Row { candidate: i, lower, diagonal: diagonal[i], hit: hit[i], one: one[i] }
        })
    }

    /// Picks `row` as the next after `rows`. Extends every candidate's row by one entry.
    fn take(&mut self, rows: &[Row], row: &Row, near: &[Axes]) {
        self.picked[row.candidate] = true;
        let mut d = [0.0; CANDIDATES];
        for (d, a) in d.iter_mut().zip(near) {
            *d = a.iter().zip(&near[row.candidate]).map(|(a, b)| f64::from(a - b) * f64::from(a - b)).sum();
        }
        for i in 0..CANDIDATES {
            let mut known = 0.0;
            for (lower, own) in self.lower.iter().zip(row.lower).take(rows.len()) {
                known += own * lower[i];
            }
            let l = (kernel(d[i]) - known) / row.diagonal;
            self.lower[rows.len()][i] = l;
            self.square[i] += l * l;
            self.hit[i] += l * row.hit;
            self.one[i] += l * row.one;
        }
    }
}

fn weights(rows: &[Row]) -> ArrayVec<(usize, f64), MAX_PAIRS> {
    let sum = |f: fn(&Row) -> f64| rows.iter().map(f).sum::<f64>();
    let lift = (1.0 - sum(|r| r.hit * r.one)) / sum(|r| r.one * r.one);
    let n = rows.len();
    // Back substitution: L^T w = L^-1 k + lift L^-1 1.
    let mut w = [0.0; MAX_PAIRS];
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|j| rows[j].lower[i] * w[j]).sum();
        w[i] = (rows[i].hit + lift * rows[i].one - known) / rows[i].diagonal;
    }
    let mut weights = ArrayVec::new();
    rows.iter().zip(w).for_each(|(r, w)| weights.push((r.candidate, w)));
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f32) -> Axes {
        [x, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    }

    #[test]
    fn weights_sum_to_one() {
        for k in 1..=4 {
            let w = choose(&[at(0.2), at(-0.5), at(1.0), at(3.0), at(-7.0)], k);
            assert_eq!(w.len(), k);
            assert!((w.iter().map(|(_, w)| w).sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn between_two_the_hit_gets_half_of_each() {
        let w = choose(&[at(0.3), at(-0.3)], 2);
        assert!((w[0].1 - 0.5).abs() < 1e-12 && (w[1].1 - 0.5).abs() < 1e-12);
    }

    #[test]
    fn beyond_the_last_example_the_trend_goes_on() {
        // Both are on one side, at 0.4 and 0.8. The nearer gets a weight above 1, the further one below 0.
        let w = choose(&[at(0.4), at(0.8)], 2);
        assert!(w[0].0 == 0 && w[0].1 > 1.0 && w[1].1 < 0.0, "{w:?}");
    }

    #[test]
    fn far_from_all_they_share_alike() {
        let w = choose(&[at(1e4), at(1e4 + 50.0), at(1e4 - 50.0)], 3);
        assert!(w.iter().all(|(_, w)| (w - 1.0 / 3.0).abs() < 1e-3), "{w:?}");
    }

    #[test]
    fn the_second_is_the_one_on_the_other_side() {
        // The first two are close together, so the third, which is further off on the other side, adds more.
        let w = choose(&[at(0.5), at(0.55), at(-0.7)], 2);
        assert_eq!(w.iter().map(|(i, _)| *i).collect::<Vec<_>>(), [0, 2]);
    }

    /// The weights solve the textbook system [K + nugget, 1; 1, 0] [w; m] = [k; 1].
    #[test]
    fn weights_solve_the_kriging_system() {
        let axes: Vec<Axes> = (0..4)
            .map(|i| {
                std::array::from_fn(|k| {
                    [0.3 * i as f32, 0.2 - 0.1 * i as f32, 0.5, 0.0, 0.1 * (i * i) as f32, 0.0, -0.2]
                        .get(k)
                        .copied()
                        .unwrap_or(0.0)
                })
            })
            .collect();
        let w = choose(&axes, 4);
        let d = |a: &Axes, b: &Axes| -> f64 { a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum() };
        let lagrange: Vec<f64> = w
            .iter()
            .map(|(i, _)| {
                let lhs: f64 = w
                    .iter()
                    .map(|(j, wj)| wj * (kernel(d(&axes[*i], &axes[*j])) + if i == j { NUGGET } else { 0.0 }))
                    .sum();
                kernel(d(&axes[*i], &[0.0; 11])) - lhs
            })
            .collect();
        assert!(lagrange.iter().all(|m| (m - lagrange[0]).abs() < 1e-12), "{lagrange:?}");
    }
}
