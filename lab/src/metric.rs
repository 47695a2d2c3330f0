//! What is measured about a displacement field.

use std::collections::BTreeSet;

pub fn sub(a: [f32; 3], b: [f32; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| f64::from(a[k]) - f64::from(b[k]))
}

pub fn dot64(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn length(v: [f32; 3]) -> f64 {
    let v = v.map(f64::from);
    dot64(v, v).sqrt()
}

fn cross64(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Root of the sum of squared differences over that of the truth: 0 is exact, 1 is what predicting no dent gets.
pub fn relative_l2(field: &[[f32; 3]], truth: &[[f32; 3]]) -> f64 {
    let (mut wrong, mut all) = (0.0, 0.0);
    for (a, b) in field.iter().zip(truth) {
        let d = sub(*a, *b);
        let t = b.map(f64::from);
        wrong += dot64(d, d);
        all += dot64(t, t);
    }
    (wrong / all).sqrt()
}

/// The longest difference at any vertex, mm.
pub fn max_error_mm(field: &[[f32; 3]], truth: &[[f32; 3]]) -> f64 {
    let worst = field.iter().zip(truth).map(|(a, b)| sub(*a, *b)).map(|d| dot64(d, d)).fold(0.0, f64::max);
    1e3 * worst.sqrt()
}

/// The longest displacement, m.
pub fn deepest(field: &[[f32; 3]]) -> f64 {
    field.iter().map(|u| length(*u)).fold(0.0, f64::max)
}

/// Each edge once.
pub fn edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let all = triangles.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
    all.map(|[a, b]| [a.min(b), a.max(b)]).collect::<BTreeSet<_>>().into_iter().collect()
}

/// The largest difference of displacement across an edge, m: what tears show in.
pub fn largest_jump(field: &[[f32; 3]], edges: &[[u32; 2]]) -> f64 {
    let jump = |e: &[u32; 2]| sub(field[e[0] as usize], field[e[1] as usize]);
    edges.iter().map(jump).map(|d| dot64(d, d)).fold(0.0, f64::max).sqrt()
}

/// Triangles whose normal turned by more than 90 degrees from the base.
pub fn inverted(field: &[[f32; 3]], vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> usize {
    let moved = |v: u32| {
        let (p, u) = (vertices[v as usize], field[v as usize]);
        [0, 1, 2].map(|k| f64::from(p[k]) + f64::from(u[k]))
    };
    let rest = |v: u32| vertices[v as usize].map(f64::from);
    let normal = |[a, b, c]: [[f64; 3]; 3]| {
        let edge = |p: [f64; 3]| [0, 1, 2].map(|k| p[k] - a[k]);
        cross64(edge(b), edge(c))
    };
    triangles.iter().filter(|t| dot64(normal(t.map(moved)), normal(t.map(rest))) < 0.0).count()
}

/// As NumPy's: linear between the two nearest ranks. NaN of nothing.
pub fn quantile(values: &[f64], q: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let at = q * last as f64;
    let low = at.floor() as usize;
    let high = (low + 1).min(last);
    sorted[low] + (at - low as f64) * (sorted[high] - sorted[low])
}

pub fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

/// The median, the quartiles, and the 90th percentile.
pub fn spread(values: &[f64]) -> [f64; 4] {
    [0.5, 0.25, 0.75, 0.9].map(|q| quantile(values, q))
}

/// Between the corners (0, 0), (1, 0), (0, 1) and (1, 1) of a cell.
pub fn bilinear([a, b, c, d]: [[f32; 3]; 4], u: f32, w: f32) -> [f32; 3] {
    [0, 1, 2].map(|k| {
        let low = a[k] * (1.0 - u) + b[k] * u;
        let high = c[k] * (1.0 - u) + d[k] * u;
        low * (1.0 - w) + high * w
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_dent_is_wrong_by_one_and_the_truth_by_nothing() {
        let truth = vec![[0.0, 0.1, -0.2], [0.3, 0.0, 0.0]];
        assert_eq!(relative_l2(&truth, &truth), 0.0);
        assert_eq!(relative_l2(&[[0.0; 3]; 2], &truth), 1.0);
        assert!((max_error_mm(&[[0.0; 3]; 2], &truth) - 300.0).abs() < 1e-4);
    }

    #[test]
    fn quantiles_are_numpys() {
        let values = [4.0, 1.0, 3.0, 2.0];
        assert_eq!(median(&values), 2.5);
        assert!((quantile(&values, 0.9) - 3.7).abs() < 1e-12);
        assert_eq!(quantile(&[7.0], 0.9), 7.0);
    }

    #[test]
    fn a_folded_triangle_counts_and_a_dented_one_does_not() {
        let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let triangles = [[0, 1, 2]];
        assert_eq!(inverted(&[[0.0, 0.0, -5.0], [0.0; 3], [0.0; 3]], &vertices, &triangles), 0);
        assert_eq!(inverted(&[[2.0, 2.0, 0.0], [0.0; 3], [0.0; 3]], &vertices, &triangles), 1);
        assert_eq!(edges(&[[0, 1, 2], [2, 1, 3]]).len(), 5);
    }
}
