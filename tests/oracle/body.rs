//! The body's mirror planes and held rims, by brute force.

use std::collections::{BTreeMap, BTreeSet};

use super::vector::{V, add, length, scale, sub};

/// `v` with x negated if bit 0 of `planes` is set, y if bit 1 is, z if bit 2 is.
pub fn mirrored(v: V, planes: u8) -> V {
    [0, 1, 2].map(|k| 0.0 + if planes >> k & 1 == 1 { -v[k] } else { v[k] })
}

/// A point mirrored in planes through `centre`.
pub fn mirrored_point(p: V, planes: u8, centre: V) -> V {
    if planes == 0 { p } else { add(centre, mirrored(sub(p, centre), planes)) }
}

/// The coordinate planes through the middle of the bounds that map 99 % of the vertices to within a thousandth of the
/// diagonal from another. There is none across an axis along which the body is at most twice that thick.
pub fn mirror_planes(positions: &[V]) -> u8 {
    let (mut low, mut high) = (positions[0], positions[0]);
    for p in positions {
        low = [0, 1, 2].map(|k| low[k].min(p[k]));
        high = [0, 1, 2].map(|k| high[k].max(p[k]));
    }
    let (centre, diagonal) = (scale(0.5, add(low, high)), length(sub(high, low)));
    let near = 1e-3 * diagonal;
    let mut planes = 0;
    for k in 0..3 {
        let allowed = positions.len() / 100;
        let mut lost = 0;
        for p in positions {
            let image = mirrored_point(*p, 1 << k, centre);
            lost += usize::from(!positions.iter().any(|q| length(sub(*q, image)) <= near));
            if lost > allowed {
                break;
            }
        }
        if lost <= allowed && high[k] - low[k] > 2.0 * near {
            planes |= 1 << k;
        }
    }
    planes
}

/// Vertices on held rims, with every copy at a seam. A rim is a loop of edges that belong to one triangle only. It is
/// held if no example moves it by more than a hundredth of the example's deepest displacement, but some example moves a
/// vertex beside it so. A vertex is beside it if it is in a triangle with it or within 3 % of the diagonal. Sets
/// `close` if the result depends on rounding.
pub fn held_vertices(positions: &[V], triangles: &[[u32; 3]], fields: &[&[V]], close: &mut bool) -> Vec<usize> {
    // vertices at one position are one point
    let mut points: BTreeMap<[u64; 3], usize> = BTreeMap::new();
    let point: Vec<usize> =
        positions.iter().enumerate().map(|(v, p)| *points.entry(p.map(f64::to_bits)).or_insert(v)).collect();
    let triangles: Vec<[usize; 3]> = triangles.iter().map(|t| t.map(|v| point[v as usize])).collect();
    let mut edges: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for [a, b, c] in &triangles {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            if a != b {
                *edges.entry((*a.min(b), *a.max(b))).or_insert(0) += 1;
            }
        }
    }
    let low = |k: usize| positions.iter().map(|p| p[k]).fold(f64::MAX, f64::min);
    let high = |k: usize| positions.iter().map(|p| p[k]).fold(f64::MIN, f64::max);
    let diagonal = length([0, 1, 2].map(|k| high(k) - low(k)));
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
        let width = 0.03 * diagonal;
        let within: Vec<usize> = (0..positions.len())
            .filter(|v| point[*v] == *v && !on_rim.contains(v))
            .filter(|v| {
                let off = ring.iter().map(|r| length(sub(positions[*v], positions[*r]))).fold(f64::MAX, f64::min);
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
                let least = 0.01 * d.iter().map(|u| length(*u)).fold(0.0, f64::max);
                (0..positions.len()).filter(|v| which.contains(&point[*v])).any(|v| {
                    *close |= least > 0.0 && (length(d[v]) / least - 1.0).abs() < 1e-5;
                    length(d[v]) > least
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
