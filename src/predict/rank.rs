//! Rows of numbers as mixtures of a few.

use super::linear::{add, dot, product};

/// Rows of low rank: each is a sum of coefficients times modes.
#[derive(Debug, Clone, Default)]
pub(super) struct LowRank {
    /// Number of modes.
    pub rank: usize,
    /// `rank` rows of `columns` numbers, orthonormal.
    pub modes: Vec<f32>,
    /// For each row its `rank` coefficients.
    pub coefficients: Vec<f64>,
}

/// Rounds of subspace iteration.
const ROUNDS: usize = 8;

/// The scalar products of the rows.
pub(super) fn gram(rows: &[f32], columns: usize) -> Vec<f64> {
    let n = rows.len() / columns.max(1);
    let mut g = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            let x = dot(&rows[i * columns..(i + 1) * columns], &rows[j * columns..(j + 1) * columns]);
            (g[i * n + j], g[j * n + i]) = (x, x);
        }
    }
    g
}

impl LowRank {
    /// The `most` modes that hold most of the rows' squares, or fewer if less than `lost` of them is left out.
    /// `gram` are the scalar products of the rows.
    pub(super) fn of(rows: &[f32], columns: usize, gram: &[f64], most: usize, lost: f64) -> Self {
        let n = rows.len() / columns.max(1);
        let total: f64 = (0..n).map(|i| gram[i * n + i]).sum();
        if total.is_nan() || total <= 0.0 {
            return Self::default();
        }
        // Start: the row with the largest part that is not yet explained, again and again (pivoted Cholesky).
        let mut left: Vec<f64> = (0..n).map(|i| gram[i * n + i]).collect();
        let mut factor: Vec<Vec<f64>> = Vec::new();
        while factor.len() < most.min(n) {
            let pivot = (0..n).fold(0, |best, i| if left[i] > left[best] { i } else { best });
            if left.iter().map(|x| x.max(0.0)).sum::<f64>() < 0.1 * lost * total || left[pivot] <= 1e-12 * total {
                break;
            }
            let mut column: Vec<f64> = gram[pivot * n..(pivot + 1) * n].to_vec();
            factor.iter().for_each(|f| add(&mut column, -f[pivot], f));
            let root = left[pivot].sqrt();
            column.iter_mut().for_each(|x| *x /= root);
            left.iter_mut().zip(&column).for_each(|(l, c)| *l -= c * c);
            factor.push(column);
        }
        // Orthogonal iteration turns it towards the leading eigenvectors of the scalar products.
        for _ in 0..ROUNDS {
            orthonormal(&mut factor);
            factor = factor.iter().map(|f| product(gram, f, n, 1)).collect();
        }
        let mut energies: Vec<(f64, usize)> = Vec::new();
        orthonormal(&mut factor);
        for (k, f) in factor.iter().enumerate() {
            energies.push((dot(&product(gram, f, n, 1), f), k));
        }
        energies.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut rest = total;
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for (energy, k) in energies {
            if rest <= lost * total {
                break;
            }
            rest -= energy;
            basis.push(factor[k].clone());
        }
        // Modes are mixtures of rows, made orthonormal among themselves.
        let mut modes: Vec<Vec<f32>> = Vec::new();
        for weights in &basis {
            let mut mode = vec![0.0f32; columns];
            weights.iter().zip(rows.chunks_exact(columns)).for_each(|(w, row)| add(&mut mode, *w as f32, row));
            for _ in 0..2 {
                for other in &modes {
                    let along = dot(&mode, other);
                    add(&mut mode, -along as f32, other);
                }
            }
            let length = dot(&mode, &mode).sqrt();
            if length > 1e-12 * total.sqrt() {
                mode.iter_mut().for_each(|x| *x = (f64::from(*x) / length) as f32);
                modes.push(mode);
            }
        }
        let coefficients =
            rows.chunks_exact(columns).flat_map(|row| modes.iter().map(|mode| dot(row, mode)).collect::<Vec<_>>());
        Self { rank: modes.len(), coefficients: coefficients.collect(), modes: modes.concat() }
    }

    /// Adds the modes, times `weights`, to `out`.
    pub(super) fn mix(&self, weights: &[f64], out: &mut [f32]) {
        let columns = out.len();
        for (w, mode) in weights.iter().zip(self.modes.chunks_exact(columns.max(1))) {
            add(out, *w as f32, mode);
        }
    }
}

/// Gram-Schmidt, twice for accuracy. What is left of dependent vectors is dropped.
fn orthonormal(vectors: &mut Vec<Vec<f64>>) {
    let mut done: Vec<Vec<f64>> = Vec::new();
    for mut v in vectors.drain(..) {
        let before = dot(&v, &v).sqrt();
        for _ in 0..2 {
            for d in &done {
                let along = dot(&v, d);
                add(&mut v, -along, d);
            }
        }
        let length = dot(&v, &v).sqrt();
        if length > 1e-9 * before && length > 0.0 {
            v.iter_mut().for_each(|x| *x /= length);
            done.push(v);
        }
    }
    *vectors = done;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_rank_two_are_two_modes() {
        let (n, columns) = (6, 10);
        let rows: Vec<f32> = (0..n * columns)
            .map(|k| {
                let (i, c) = ((k / columns) as f32, (k % columns) as f32);
                (1.0 + i) * (0.3 * c).sin() + (i * i - 3.0) * 0.1 * c
            })
            .collect();
        let low = LowRank::of(&rows, columns, &gram(&rows, columns), 5, 1e-9);
        assert_eq!(low.rank, 2);
        for i in 0..n {
            let mut row = vec![0.0f32; columns];
            low.mix(&low.coefficients[i * 2..i * 2 + 2], &mut row);
            (0..columns).for_each(|c| assert!((row[c] - rows[i * columns + c]).abs() < 1e-4));
        }
    }
}
