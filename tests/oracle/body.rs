//! The body's mirror planes and held rims, by brute force.

use std::collections::{BTreeMap, BTreeSet};

use crumple::glam::DVec3;

/// The corners of the box around the positions.
fn bounds(positions: &[DVec3]) -> (DVec3, DVec3) {
    positions.iter().fold((DVec3::MAX, DVec3::MIN), |(low, high), p| (low.min(*p), high.max(*p)))
}

/// The coordinate planes through the middle of the bounds that map 99 % of the vertices to within a thousandth of the
/// diagonal from another. There is none across an axis along which the body is at most twice that thick.
pub fn mirror_planes(positions: &[DVec3]) -> u8 {
    let (low, high) = bounds(positions);
    let near = 1e-3 * low.distance(high);
    let is_mirror = |k: &usize| {
        let lost = |p: &&DVec3| {
            let mut image = **p;
            image[*k] = low[*k] + high[*k] - p[*k];
            !positions.iter().any(|q| q.distance(image) <= near)
        };
        high[*k] - low[*k] > 2.0 * near && positions.iter().filter(lost).nth(positions.len() / 100).is_none()
    };
    (0..3).filter(is_mirror).map(|k| 1 << k).sum()
}

/// Vertices on held rims, with every copy at a seam. A rim is a loop of edges that belong to one triangle only. It is
/// held if no example moves it by more than a hundredth of the example's deepest displacement, but some example moves a
/// vertex beside it so. A vertex is beside it if it is in a triangle with it or within 3 % of the diagonal. Sets
/// `close` if the result depends on rounding.
pub fn held_vertices(positions: &[DVec3], triangles: &[[u32; 3]], fields: &[&[DVec3]], close: &mut bool) -> Vec<usize> {
    // vertices at one position are one point
    let mut points: BTreeMap<[u64; 3], usize> = BTreeMap::new();
    let point: Vec<usize> =
        positions.iter().enumerate().map(|(v, p)| *points.entry(p.to_array().map(f64::to_bits)).or_insert(v)).collect();
    let triangles: Vec<[usize; 3]> = triangles.iter().map(|t| t.map(|v| point[v as usize])).collect();
    let mut edges: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for [a, b, c] in &triangles {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            if a != b {
                *edges.entry((*a.min(b), *a.max(b))).or_insert(0) += 1;
            }
        }
    }
    let (low, high) = bounds(positions);
    let rim: Vec<(usize, usize)> = edges.into_iter().filter(|(_, n)| *n == 1).map(|(e, _)| e).collect();
    let on_rim: BTreeSet<usize> = rim.iter().flat_map(|(a, b)| [*a, *b]).collect();
    let mut left = on_rim.clone();
    let mut held = Vec::new();
    while let Some(first) = left.pop_first() {
        let mut ring = BTreeSet::from([first]);
        loop {
            let before = ring.len();
            for (a, b) in &rim {
                if ring.contains(a) || ring.contains(b) {
                    ring.extend([*a, *b]);
                }
            }
            if ring.len() == before {
                break;
            }
        }
        left.retain(|v| !ring.contains(v));
        let width = 0.03 * low.distance(high);
        let within: Vec<usize> = (0..positions.len())
            .filter(|v| point[*v] == *v && !on_rim.contains(v))
            .filter(|v| {
                let off = ring.iter().map(|r| positions[*v].distance(positions[*r])).fold(f64::MAX, f64::min);
                *close |= (off / width - 1.0).abs() < 1e-5;
                off <= width
            })
            .collect();
        let beside: BTreeSet<usize> = triangles
            .iter()
            .filter(|t| t.iter().any(|v| ring.contains(v)))
            .flatten()
            .copied()
            .filter(|v| !on_rim.contains(v))
            .chain(within)
            .collect();
        let mut moves = |which: &BTreeSet<usize>| {
            fields.iter().any(|d| {
                let least = 0.01 * d.iter().map(|u| u.length()).fold(0.0, f64::max);
                (0..positions.len()).filter(|v| which.contains(&point[*v])).any(|v| {
                    *close |= least > 0.0 && (d[v].length() / least - 1.0).abs() < 1e-5;
                    d[v].length() > least
                })
            })
        };
        if !moves(&ring) && moves(&beside) {
            held.extend((0..positions.len()).filter(|v| ring.contains(&point[*v])));
        }
    }
    held.sort_unstable();
    held
}
