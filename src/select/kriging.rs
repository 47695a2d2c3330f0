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
pub(crate) type Axes = [f32; AXES];
const AXES: usize = 11;
/// The first axes, which every hit has. The others are zero for a hit that is not a blow.
const ALWAYS: usize = 7;

/// Squared distance from the hit, which is the origin.
pub(crate) fn distance(a: &Axes) -> f32 {
    a.iter().map(|x| x * x).sum()
}

fn kernel(d: f64) -> f64 {
    1.0 / (1.0 + 0.5 * d)
}

/// Chooses up to `k` (at most [`MAX_PAIRS`]) examples from `near`, which is sorted with the nearest first. Only the
/// first [`CANDIDATES`] are considered. Returns indices into `near` and weights. Weights sum to 1 up to rounding.
pub(crate) fn choose<'a>(near: impl IntoIterator<Item = &'a Axes>, k: usize) -> ArrayVec<(usize, f64), MAX_PAIRS> {
    let mut system = System::new(near);
    let most = k.min(system.count).min(MAX_PAIRS);
    while system.picked.len() < most {
        let Some(row) = system.best() else { break };
        system.picked.push(row);
        // The rows of the others matter only if one more is picked.
        if system.picked.len() < most {
            system.extend(&row);
        }
    }
    weights(&system.picked)
}

/// One value per candidate. Loops also compute picked and unused candidates, so that they vectorize.
type Each = [f64; CANDIDATES];

/// The Cholesky factor `L` of the picked examples' covariances, with the next row for each candidate that could be
/// picked.
struct System {
    /// The candidates' coordinates, one array per axis.
    axes: [[f32; CANDIDATES]; AXES],
    /// Number of axes that are not zero for all candidates.
    used: usize,
    /// Number of candidates.
    count: usize,
    /// Each candidate's covariance with the hit, `k`.
    to_hit: Each,
    /// Each candidate's row. `square` is the row's sum of squares; `hit` and `one` are its products with `L^-1 k` and
    /// `L^-1 1`.
    lower: [Each; MAX_PAIRS],
    square: Each,
    hit: Each,
    one: Each,
    picked: ArrayVec<Row, MAX_PAIRS>,
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

/// The products of `L^-1 k` and `L^-1 1` with each other and themselves.
fn products(rows: &[Row]) -> (f64, f64, f64) {
    let (mut cross, mut ones, mut hits) = (0.0, 0.0, 0.0);
    for r in rows {
        cross += r.hit * r.one;
        ones += r.one * r.one;
        hits += r.hit * r.hit;
    }
    (cross, ones, hits)
}

impl System {
    fn new<'a>(near: impl IntoIterator<Item = &'a Axes>) -> Self {
        let zero = [0.0; CANDIDATES];
        let mut system = System {
            axes: [[0.0; CANDIDATES]; AXES],
            used: ALWAYS,
            count: 0,
            to_hit: zero,
            lower: [zero; MAX_PAIRS],
            square: zero,
            hit: zero,
            one: zero,
            picked: ArrayVec::new(),
        };
        for (i, near) in near.into_iter().take(CANDIDATES).enumerate() {
            system.axes.iter_mut().zip(near).for_each(|(axis, x)| axis[i] = *x);
            system.count += 1;
            if near[ALWAYS..] != [0.0; AXES - ALWAYS] {
                system.used = AXES;
            }
        }
        system.to_hit = system.kernels(&[0.0; AXES]);
        system
    }

    /// The kernel's values between each candidate and a point.
    fn kernels(&self, point: &Axes) -> Each {
        let mut squared = [0.0; CANDIDATES];
        for (axis, x) in self.axes.iter().zip(point).take(self.used) {
            for (sum, a) in squared.iter_mut().zip(axis) {
                *sum += f64::from(a - x) * f64::from(a - x);
            }
        }
        squared.map(kernel)
    }

    /// The candidate that gives the smallest kriging variance.
    fn best(&self) -> Option<Row> {
        let (cross, ones, hits) = products(&self.picked);
        let zero = [0.0; CANDIDATES];
        let (mut diagonal, mut hit, mut one, mut variance) = (zero, zero, zero, zero);
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
        for i in (0..self.count).filter(|i| diagonal[*i] > 0.0) {
            if best.is_none_or(|b| variance[i] < variance[b]) && self.picked.iter().all(|r| r.candidate != i) {
                best = Some(i);
            }
        }
        best.map(|i| {
            let lower = std::array::from_fn(|row| self.lower[row][i]);
            Row { candidate: i, lower, diagonal: diagonal[i], hit: hit[i], one: one[i] }
        })
    }

    /// Extends every candidate's row by one entry, for `row`, the last that was picked.
    fn extend(&mut self, row: &Row) {
        let kernels = self.kernels(&std::array::from_fn(|axis| self.axes[axis][row.candidate]));
        let last = self.picked.len() - 1;
        for i in 0..CANDIDATES {
            let mut known = 0.0;
            for (lower, own) in self.lower.iter().zip(row.lower).take(last) {
                known += own * lower[i];
            }
            let l = (kernels[i] - known) / row.diagonal;
            self.lower[last][i] = l;
            self.square[i] += l * l;
            self.hit[i] += l * row.hit;
            self.one[i] += l * row.one;
        }
    }
}

fn weights(rows: &[Row]) -> ArrayVec<(usize, f64), MAX_PAIRS> {
    let (cross, ones, _) = products(rows);
    let lift = (1.0 - cross) / ones;
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
