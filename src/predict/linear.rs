//! Dense linear algebra in double precision, in a fixed order of operations. (Kept crates choose their instructions by
//! processor, and so their bits.)

use std::ops::{AddAssign, Mul};

/// Whether the symmetric positive definite `n` x `n` matrix `a` (rows one after the other) could be factored. Its lower
/// triangle then holds the Cholesky factor.
pub(super) fn cholesky(a: &mut [f64], n: usize) -> bool {
    for i in 0..n {
        for j in 0..=i {
            let (above, row) = a.split_at_mut(i * n);
            let sum = if i == j { dot(&row[..j], &row[..j]) } else { dot(&row[..j], &above[j * n..j * n + j]) };
            let left = row[j] - sum;
            if i == j {
                if left.is_nan() || left <= 0.0 {
                    return false;
                }
                row[j] = left.sqrt();
            } else {
                row[j] = left / above[j * n + j];
            }
        }
    }
    true
}

/// The dot product, in four interleaved sums of double precision.
#[inline]
pub(super) fn dot<T: Copy + Into<f64>>(a: &[T], b: &[T]) -> f64 {
    let (fours, rest) = a.as_chunks::<4>();
    let (with, with_rest) = b[..a.len()].as_chunks::<4>();
    let product = |x: T, y: T| -> f64 { x.into() * y.into() };
    let mut s = [0.0f64; 4];
    for (x, y) in fours.iter().zip(with) {
        for k in 0..4 {
            s[k] += product(x[k], y[k]);
        }
    }
    let tail: f64 = rest.iter().zip(with_rest).map(|(x, y)| product(*x, *y)).sum();
    (s[0] + s[1]) + (s[2] + s[3]) + tail
}

/// `to += k * from`
#[inline]
pub(super) fn add<T: Copy + AddAssign + Mul<Output = T>>(to: &mut [T], k: T, from: &[T]) {
    for (t, f) in to.iter_mut().zip(from) {
        *t += k * *f;
    }
}

/// The inverse of the matrix whose Cholesky factor is in the lower triangle of `l`.
pub(super) fn inverse(l: &[f64], n: usize) -> Vec<f64> {
    // Row i of the factor's inverse, then its transpose times itself.
    let mut inv = vec![0.0; n * n];
    for i in 0..n {
        let (above, row) = inv.split_at_mut(i * n);
        for (j, k) in l[i * n..i * n + i].iter().enumerate() {
            add(&mut row[..=j], -k, &above[j * n..j * n + j + 1]);
        }
        row[i] = 1.0;
        let d = 1.0 / l[i * n + i];
        row[..=i].iter_mut().for_each(|x| *x *= d);
    }
    let mut out = vec![0.0; n * n];
    for k in 0..n {
        let row = &inv[k * n..k * n + k + 1];
        for (i, x) in row.iter().enumerate() {
            add(&mut out[i * n..i * n + i + 1], *x, &row[..=i]);
        }
    }
    for i in 0..n {
        for j in 0..i {
            out[j * n + i] = out[i * n + j];
        }
    }
    out
}

/// `a` (`n` x `m`) times `b` (`m` x `r`).
pub(super) fn product(a: &[f64], b: &[f64], m: usize, r: usize) -> Vec<f64> {
    if m == 0 || r == 0 {
        return Vec::new();
    }
    let mut out = vec![0.0; a.len() / m * r];
    for (row, to) in a.chunks_exact(m).zip(out.chunks_exact_mut(r)) {
        for (k, from) in row.iter().zip(b.chunks_exact(r)) {
            add(to, *k, from);
        }
    }
    out
}

/// Solves the small symmetric positive definite system `a x = b`, for `columns` right sides (rows of `b`). `a` and `b`
/// are overwritten, `b` by the solution.
pub(super) fn solve(a: &mut [f64], b: &mut [f64], n: usize, columns: usize) -> bool {
    if !cholesky(a, n) {
        return false;
    }
    for i in 0..n {
        let (above, row) = b.split_at_mut(i * columns);
        for j in 0..i {
            add(&mut row[..columns], -a[i * n + j], &above[j * columns..(j + 1) * columns]);
        }
        row[..columns].iter_mut().for_each(|x| *x /= a[i * n + i]);
    }
    for i in (0..n).rev() {
        let (upto, below) = b.split_at_mut((i + 1) * columns);
        let row = &mut upto[i * columns..];
        for j in i + 1..n {
            add(row, -a[j * n + i], &below[(j - i - 1) * columns..(j - i) * columns]);
        }
        row.iter_mut().for_each(|x| *x /= a[i * n + i]);
    }
    true
}

/// A symmetric positive definite matrix of which only `band` entries left of the diagonal are not zero.
pub(super) struct Banded {
    n: usize,
    band: usize,
    /// Row i holds columns i - band to i.
    rows: Vec<f64>,
}

impl Banded {
    pub(super) fn new(n: usize, band: usize) -> Self {
        Self { n, band, rows: vec![0.0; n * (band + 1)] }
    }

    /// Adds `x` at row `i`, column `j`, for `j` of at most `i`.
    pub(super) fn add(&mut self, i: usize, j: usize, x: f64) {
        self.rows[i * (self.band + 1) + self.band + j - i] += x;
    }

    /// Replaces the rows of `b` (three columns) by the solution.
    pub(super) fn solve(mut self, b: &mut [[f64; 3]]) {
        let (n, w) = (self.n, self.band + 1);
        for i in 0..n {
            let first = i.saturating_sub(self.band);
            for j in first..=i {
                // Columns that both rows have.
                let from = first.max(j.saturating_sub(self.band));
                let (above, row) = self.rows.split_at_mut(i * w);
                let at = |row: usize, column: usize| column + self.band - row;
                let mine = &row[at(i, from)..at(i, j)];
                if i == j {
                    let left = row[self.band] - dot(mine, mine);
                    row[self.band] = left.max(1e-300).sqrt();
                } else {
                    let theirs = &above[j * w + at(j, from)..j * w + self.band];
                    let left = row[at(i, j)] - dot(mine, theirs);
                    row[at(i, j)] = left / above[j * w + self.band];
                }
            }
        }
        let l = |i: usize, j: usize| self.rows[i * w + self.band + j - i];
        for i in 0..n {
            let (before, rest) = b.split_at_mut(i);
            let from = i.saturating_sub(self.band);
            for (j, other) in before.iter().enumerate().skip(from) {
                (0..3).for_each(|c| rest[0][c] -= l(i, j) * other[c]);
            }
            (0..3).for_each(|c| rest[0][c] /= l(i, i));
        }
        for i in (0..n).rev() {
            (0..3).for_each(|c| b[i][c] /= l(i, i));
            let (before, rest) = b.split_at_mut(i);
            let from = i.saturating_sub(self.band);
            for (j, other) in before.iter_mut().enumerate().skip(from) {
                (0..3).for_each(|c| other[c] -= l(i, j) * rest[0][c]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_times_matrix_is_the_identity() {
        let n = 7usize;
        let a: Vec<f64> =
            (0..n * n).map(|k| if k / n == k % n { 3.0 } else { 1.0 / (1 + (k / n).abs_diff(k % n)) as f64 }).collect();
        let mut l = a.clone();
        assert!(cholesky(&mut l, n));
        let one = product(&a, &inverse(&l, n), n, n);
        (0..n * n).for_each(|k| assert!((one[k] - f64::from(k / n == k % n)).abs() < 1e-12));
        let mut b: Vec<f64> = (0..n).map(|k| k as f64).collect();
        assert!(solve(&mut a.clone(), &mut b, n, 1));
        let back = product(&a, &b, n, 1);
        (0..n).for_each(|k| assert!((back[k] - k as f64).abs() < 1e-12));
    }

    #[test]
    fn a_banded_solve_solves() {
        let n = 9;
        let mut m = Banded::new(n, 2);
        let mut full = vec![0.0; n * n];
        for i in 0..n {
            for (j, x) in [(i, 4.0), (i.wrapping_sub(1), -1.0), (i.wrapping_sub(2), 0.5)] {
                if j < n {
                    m.add(i, j, x);
                    (full[i * n + j], full[j * n + i]) = (x, x);
                }
            }
        }
        let mut b: Vec<[f64; 3]> = (0..n).map(|k| [k as f64, 1.0, -2.0]).collect();
        m.solve(&mut b);
        for i in 0..n {
            let x: f64 = (0..n).map(|j| full[i * n + j] * b[j][0]).sum();
            assert!((x - i as f64).abs() < 1e-12);
        }
    }

    #[test]
    fn a_matrix_that_is_not_positive_is_refused() {
        assert!(!cholesky(&mut [1.0, 2.0, 2.0, 1.0], 2));
    }
}
