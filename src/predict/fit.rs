//! Lengths and noise of a regression by maximum marginal likelihood (Rasmussen and Williams, Gaussian Processes for
//! Machine Learning, 2006, section 5.4.1), with Gaussian priors on their logarithms.

use super::features::{Point, differences};
use super::kernel::{GROUPS, Lengths, exp, factors, noise_ratio};
use super::linear::{cholesky, inverse, product};

/// What is expected of lengths and noise before the data.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prior {
    pub mean: Lengths,
    /// Standard deviation of each logarithm.
    pub deviation: f64,
    /// Number of independent outputs that the data count as.
    pub outputs: f64,
    /// Whether the mean is unknown and constant.
    pub ordinary: bool,
}

/// Steps of the search.
const STEPS: usize = 40;

/// Fits lengths to those of `points` that are `used`, and the products of their outputs.
pub(super) fn fit(points: &[Point], used: &[usize], product: impl Fn(usize, usize) -> f64, prior: &Prior) -> Lengths {
    let n = used.len();
    let trace: f64 = used.iter().map(|i| product(*i, *i)).sum();
    if n < 4 || trace.is_nan() || trace <= 0.0 {
        return prior.mean;
    }
    let product = |i: usize, j: usize| product(i, j) * n as f64 / trace;
    let gram: Vec<f64> = (0..n * n).map(|at| product(used[at / n], used[at % n])).collect();
    let d2 = squared_differences(&used.iter().map(|i| points[*i]).collect::<Vec<_>>());
    // Resilient propagation: each logarithm has its own step, which grows while the slope keeps its sign.
    let start = prior.mean;
    let (mut at, mut step, mut last) = (start, [0.15f64; GROUPS + 1], [0.0f64; GROUPS + 1]);
    let mut best = (f64::INFINITY, start);
    for _ in 0..STEPS {
        let Some((mut cost, mut slope)) = likelihood(&d2, &gram, n, &at, prior) else { break };
        for g in 0..=GROUPS {
            let off = (at[g] - start[g]) / prior.deviation;
            cost += 0.5 * off * off;
            slope[g] += off / prior.deviation;
        }
        if cost < best.0 {
            best = (cost, at);
        }
        for g in 0..=GROUPS {
            let sign = slope[g] * last[g];
            if sign > 0.0 {
                step[g] = (step[g] * 1.3).min(0.6);
            } else if sign < 0.0 {
                step[g] *= 0.5;
            }
            last[g] = if sign < 0.0 { 0.0 } else { slope[g] };
            let direction = if slope[g] > 0.0 { -1.0 } else { 1.0 };
            if last[g] != 0.0 {
                at[g] += direction * step[g];
            }
        }
    }
    best.1
}

/// For each group a square of which the lower half is filled.
fn squared_differences(points: &[Point]) -> Vec<f64> {
    let n = points.len();
    let mut d2 = vec![0.0; n * n * GROUPS];
    for i in 0..n {
        for j in 0..i {
            let d = differences(&points[i], &points[j]);
            (0..GROUPS).for_each(|g| d2[g * n * n + i * n + j] = d[g]);
        }
    }
    d2
}

/// The negative logarithm of the marginal likelihood, the variance profiled out, and its slope.
fn likelihood(d2: &[f64], gram: &[f64], n: usize, at: &Lengths, prior: &Prior) -> Option<(f64, [f64; GROUPS + 1])> {
    let (f, noise) = (factors(at), noise_ratio(at));
    let (mut k, mut decay) = (vec![0.0; n * n], vec![0.0; n * n]);
    for i in 0..n {
        for j in 0..i {
            let at = i * n + j;
            let s: f64 = (0..GROUPS).map(|g| f[g] * d2[g * n * n + at]).sum();
            let d = (s + 1e-12).sqrt();
            decay[at] = exp(-d);
            k[at] = (1.0 + d) * decay[at];
        }
        k[i * n + i] = 1.0 + noise;
    }
    if !cholesky(&mut k, n) {
        return None;
    }
    let mut half_log = (0..n).map(|i| libm::log(k[i * n + i])).sum::<f64>();
    let mut p = inverse(&k, n);
    let mut freedom = n as f64;
    if prior.ordinary {
        let sums: Vec<f64> = p.chunks_exact(n).map(|row| row.iter().sum()).collect();
        let all: f64 = sums.iter().sum();
        for i in 0..n {
            for j in 0..n {
                p[i * n + j] -= sums[i] * sums[j] / all;
            }
        }
        half_log += 0.5 * libm::log(all);
        freedom -= 1.0;
    }
    let ps = product(&p, gram, n, n);
    let q: f64 = (0..n).map(|i| ps[i * n + i]).sum();
    if q.is_nan() || q <= 0.0 {
        return None;
    }
    let psp = product(&ps, &p, n, n);
    let r = prior.outputs;
    let cost = r * half_log + 0.5 * r * freedom * libm::log(q / freedom);
    let mut slope = [0.0; GROUPS + 1];
    for i in 0..n {
        for j in 0..i {
            let at = i * n + j;
            // Both triangles.
            let w = r * (p[at] - freedom / q * psp[at]) * decay[at];
            (0..GROUPS).for_each(|g| slope[g] += w * d2[g * n * n + at]);
        }
        slope[GROUPS] += 0.5 * r * (p[i * n + i] - freedom / q * psp[i * n + i]) * noise;
    }
    (0..GROUPS).for_each(|g| slope[g] *= f[g]);
    Some((cost, slope))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_is_that_of_the_likelihood() {
        let n = 9;
        let points: Vec<Point> =
            (0..n).map(|i| std::array::from_fn(|k| ((i * 7 + k * 3) % 11) as f64 / 11.0)).collect();
        let y: Vec<f64> = (0..n).map(|i| ((i * 5) % 7) as f64 - 3.0).collect();
        let gram: Vec<f64> = (0..n * n).map(|k| y[k / n] * y[k % n]).collect();
        let d2 = squared_differences(&points);
        for ordinary in [false, true] {
            let l = [-0.3, 0.1, 0.4, 0.7, 0.5, -0.2, 0.6, -1.0];
            let prior = Prior { mean: l, deviation: 1.0, outputs: 3.0, ordinary };
            let (_, slope) = likelihood(&d2, &gram, n, &l, &prior).unwrap();
            for (g, slope) in slope.iter().enumerate() {
                let moved = |by: f64| {
                    let mut m = l;
                    m[g] += by;
                    likelihood(&d2, &gram, n, &m, &prior).unwrap().0
                };
                let numeric = (moved(1e-4) - moved(-1e-4)) / 2e-4;
                assert!((numeric - slope).abs() < 1e-4 * (1.0 + numeric.abs()), "{g}: {numeric} {slope}");
            }
        }
    }
}
