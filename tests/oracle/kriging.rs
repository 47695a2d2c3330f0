//! Ordinary kriging: one linear system, solved by elimination.

/// Place (3), logarithm of depth, lean (3), the blow's tangent (3), logarithm of the striker's radius, each divided by
/// its width.
pub type Axes = [f64; 11];
/// The hit's own coordinates.
pub const HIT: Axes = [0.0; 11];

/// The documented kernel, as a function of the squared distance.
pub fn kernel(squared: f64) -> f64 {
    1.0 / (1.0 + squared / 2.0)
}
pub const NUGGET: f64 = 0.03;

pub fn squared(a: &Axes, b: &Axes) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// Gaussian elimination with pivoting.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for col in 0..n {
        let pivot = (col..n).max_by(|i, j| a[*i][col].abs().total_cmp(&a[*j][col].abs())).unwrap();
        a.swap(col, pivot);
        b.swap(col, pivot);
        for row in 0..n {
            if row != col {
                let f = a[row][col] / a[col][col];
                let upper = a[col].clone();
                a[row].iter_mut().zip(&upper).for_each(|(x, y)| *x -= f * y);
                b[row] -= f * b[col];
            }
        }
    }
    (0..n).map(|i| b[i] / a[i][i]).collect()
}

/// Inverse of a matrix, column by column.
pub fn inverse(a: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let n = a.len();
    let unit = |i: usize| (0..n).map(|j| f64::from(u8::from(i == j))).collect();
    let columns: Vec<Vec<f64>> = (0..n).map(|i| solve(a.clone(), unit(i))).collect();
    (0..n).map(|i| (0..n).map(|j| columns[j][i]).collect()).collect()
}

/// Shares of the points for a hit at the origin, by `(K + 0.03 I) s + m = k`, `sum s = 1`, and the variance that
/// remains.
pub fn weights(points: &[Axes]) -> (Vec<f64>, f64) {
    let n = points.len();
    let covariance = |i: usize, j: usize| kernel(squared(&points[i], &points[j])) + if i == j { NUGGET } else { 0.0 };
    let hit: Vec<f64> = points.iter().map(|p| kernel(squared(p, &HIT))).collect();
    let mut rows: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| covariance(i, j)).chain([1.0]).collect()).collect();
    rows.push(vec![1.0; n].into_iter().chain([0.0]).collect());
    let mut s = solve(rows, hit.iter().copied().chain([1.0]).collect());
    s.truncate(n);
    let mut variance = 1.0;
    for i in 0..n {
        variance -= 2.0 * s[i] * hit[i];
        for j in 0..n {
            variance += s[i] * covariance(i, j) * s[j];
        }
    }
    (s, variance)
}

/// Two variances that differ by no more than this may be swapped by rounding.
const TIE: f64 = 3e-5;

/// Every way to choose `k` of the points one by one, each time the one that gives the least variance. There are several
/// ways if there are ties; `None` if there are too many.
pub fn choices(points: &[Axes], k: usize) -> Option<Vec<Vec<usize>>> {
    let mut ways: Vec<Vec<usize>> = vec![Vec::new()];
    for _ in 0..k.min(points.len()) {
        let mut next: Vec<Vec<usize>> = Vec::new();
        for way in &ways {
            let with = |i: usize| way.iter().copied().chain([i]).collect::<Vec<usize>>();
            let tried: Vec<(Vec<usize>, f64)> = (0..points.len())
                .filter(|i| !way.contains(i))
                .map(|i| {
                    let way = with(i);
                    let variance = weights(&way.iter().map(|i| points[*i]).collect::<Vec<_>>()).1;
                    (way, variance)
                })
                .collect();
            let least = tried.iter().map(|t| t.1).fold(f64::INFINITY, f64::min);
            next.extend(tried.into_iter().filter(|t| t.1 <= least + TIE).map(|t| t.0));
        }
        next.iter_mut().for_each(|w| w.sort_unstable());
        next.sort();
        next.dedup();
        if next.len() > 60 {
            return None;
        }
        ways = next;
    }
    Some(ways)
}
