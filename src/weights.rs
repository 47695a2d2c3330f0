//! Which examples make a dent, and with what shares: ordinary kriging over what is known of a hit.
//!
//! A hit and an example are points in a space of seven axes: place (3), logarithm of depth (1), and lean (3), the tangential
//! part of the unit displacement, all relative to the hit and each divided by its width. With `D` their squared distance, the kernel
//! is the rational quadratic `1 / (1 + D / 2)`. Of the [`CANDIDATES`] nearest examples those K are taken that bring the
//! kriging variance down most, one after the other; their shares are the kriging weights, which sum to 1 and may be negative
//! (an example that overshoots is corrected by another). Far from all examples the weights fall back to equal shares.
//! (Krige 1951; Cressie, "Statistics for Spatial Data", 1993, section 3.2.)
//!
//! Plain IEEE f32/f64 operations without transcendentals: the same bits everywhere.

/// Only so many nearest examples are considered.
pub(crate) const CANDIDATES: usize = 12;
/// Variance of what the axes do not tell, as a share of the kernel's height.
const NUGGET: f64 = 0.03;

/// An example as seen from a hit, or the other way round.
pub(crate) type Axes = [f32; 7];

/// Squared distance from the hit, which is the origin.
pub(crate) fn distance(a: &Axes) -> f32 {
    a.iter().map(|x| x * x).sum()
}

fn kernel(d: f64) -> f64 {
    1.0 / (1.0 + 0.5 * d)
}

/// Indices into `near` (at most [`CANDIDATES`], nearest first) of the `k` chosen, with their weights; the sum of weights is 1
/// to rounding.
pub(crate) fn choose(near: &[Axes], k: usize) -> Vec<(usize, f64)> {
    let n = near.len();
    let d = |i: usize, j: usize| -> f64 {
        near[i].iter().zip(&near[j]).map(|(a, b)| f64::from(a - b) * f64::from(a - b)).sum()
    };
    let to_hit: Vec<f64> = near.iter().map(|a| kernel(a.iter().map(|x| f64::from(*x) * f64::from(*x)).sum())).collect();
    let mut chosen = Factor::default();
    while chosen.picked.len() < k.min(n) {
        let mut best: Option<(f64, usize, Row)> = None;
        for i in (0..n).filter(|i| !chosen.picked.contains(i)) {
            let covariances: Vec<f64> = chosen.picked.iter().map(|j| kernel(d(i, *j))).collect();
            let Some(row) = chosen.row(&covariances, to_hit[i]) else { continue };
            let variance = chosen.variance(&row);
            if best.as_ref().is_none_or(|b| variance < b.0) {
                best = Some((variance, i, row));
            }
        }
        let Some((_, i, row)) = best else { break };
        chosen.push(i, row);
    }
    chosen.weights()
}

/// A Cholesky factor that grows by one example at a time, with the systems that kriging solves.
#[derive(Default)]
struct Factor {
    picked: Vec<usize>,
    rows: Vec<Row>,
}

/// One more row of the factor: `lower` and its diagonal, and the next entries of `L^-1 k` and `L^-1 1`.
struct Row {
    lower: Vec<f64>,
    diagonal: f64,
    hit: f64,
    one: f64,
}

impl Factor {
    fn row(&self, covariances: &[f64], to_hit: f64) -> Option<Row> {
        let mut lower: Vec<f64> = Vec::with_capacity(covariances.len());
        for (r, c) in self.rows.iter().zip(covariances) {
            let known: f64 = r.lower.iter().zip(&lower).map(|(a, b)| a * b).sum();
            lower.push((c - known) / r.diagonal);
        }
        let dot = |f: fn(&Row) -> f64| -> f64 { lower.iter().zip(&self.rows).map(|(l, r)| l * f(r)).sum() };
        let square = 1.0 + NUGGET - lower.iter().map(|l| l * l).sum::<f64>();
        let diagonal = (square > 0.0).then(|| square.sqrt())?;
        Some(Row { diagonal, hit: (to_hit - dot(|r| r.hit)) / diagonal, one: (1.0 - dot(|r| r.one)) / diagonal, lower })
    }

    /// Kriging variance with `row` added, up to a constant.
    fn variance(&self, row: &Row) -> f64 {
        let sum = |f: fn(&Row) -> f64| self.rows.iter().map(f).sum::<f64>() + f(row);
        let missing = 1.0 - sum(|r| r.hit * r.one);
        missing * missing / sum(|r| r.one * r.one) - sum(|r| r.hit * r.hit)
    }

    fn push(&mut self, i: usize, row: Row) {
        self.picked.push(i);
        self.rows.push(row);
    }

    fn weights(&self) -> Vec<(usize, f64)> {
        let sum = |f: fn(&Row) -> f64| self.rows.iter().map(f).sum::<f64>();
        let lift = (1.0 - sum(|r| r.hit * r.one)) / sum(|r| r.one * r.one);
        let n = self.rows.len();
        // Back substitution: L^T w = L^-1 k + lift L^-1 1.
        let mut w = vec![0.0; n];
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|j| self.rows[j].lower[i] * w[j]).sum();
            w[i] = (self.rows[i].hit + lift * self.rows[i].one - known) / self.rows[i].diagonal;
        }
        self.picked.iter().copied().zip(w).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f32) -> Axes {
        [x, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
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
        // At 0.4 and 0.8 on one side: the nearer weighs above 1, the further below 0.
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
        // Two near each other say the same: the third, further off but opposite, tells more.
        let w = choose(&[at(0.5), at(0.55), at(-0.7)], 2);
        assert_eq!(w.iter().map(|(i, _)| *i).collect::<Vec<_>>(), [0, 2]);
    }

    /// Against the textbook: the weights solve [K + nugget, 1; 1, 0] [w; m] = [k; 1].
    #[test]
    fn weights_solve_the_kriging_system() {
        let axes: Vec<Axes> =
            (0..4).map(|i| [0.3 * i as f32, 0.2 - 0.1 * i as f32, 0.5, 0.0, 0.1 * (i * i) as f32, 0.0, -0.2]).collect();
        let w = choose(&axes, 4);
        let d = |a: &Axes, b: &Axes| -> f64 { a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum() };
        let lagrange: Vec<f64> = w
            .iter()
            .map(|(i, _)| {
                let lhs: f64 = w
                    .iter()
                    .map(|(j, wj)| wj * (kernel(d(&axes[*i], &axes[*j])) + if i == j { NUGGET } else { 0.0 }))
                    .sum();
                kernel(d(&axes[*i], &[0.0; 7])) - lhs
            })
            .collect();
        assert!(lagrange.iter().all(|m| (m - lagrange[0]).abs() < 1e-12), "{lagrange:?}");
    }
}
