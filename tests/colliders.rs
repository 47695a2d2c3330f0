//! Colliders that follow: which triangles a deform changed and the box around them, and convex pieces of which only those that a dent
//! reaches are made again.

mod scenes;

use std::ops::Range;
use std::sync::Arc;

use crumple::glam::Vec3;
use crumple::{Aabb, ExampleSet, MeshData, Serial, SetOptions};
use proptest::prelude::*;
use scenes::{Output, bowl, random_hits, sheet, small_bodies};

fn contains(bounds: &Aabb, p: [f32; 3]) -> bool {
    Vec3::from_array(p).cmpge(bounds.min).all() && Vec3::from_array(p).cmple(bounds.max).all()
}

proptest! {
    #![proptest_config(scenes::cases(30))]

    #[test]
    fn changed_triangles_and_their_box_hold_all_that_moved(which in 0usize..3, seed: u64, apart in 1usize..4) {
        let set = small_bodies().swap_remove(which).1;
        let mut body = scenes::new(&set);
        let mut output = Output::fresh(&mut body);
        let triangles = set.mesh().triangles();
        for hits in random_hits(&set, 6, seed).chunks(apart) {
            let before = output.positions.clone();
            hits.iter().for_each(|h| _ = body.submit(h).unwrap());
            output.update(&mut body);
            let found: Vec<Range<u32>> = output.tracker.changed_triangles(triangles);
            prop_assert!(found.array_windows().all(|[a, b]| a.end < b.start) && found.iter().all(|r| r.start < r.end));
            let moved = |v: &u32| before[*v as usize] != output.positions[*v as usize];
            for (t, corners) in triangles.iter().enumerate() {
                let written = corners.iter().any(|v| output.tracker.changed().iter().any(|r| r.contains(v)));
                prop_assert_eq!(found.iter().any(|r| r.contains(&(t as u32))), written, "triangle {}", t);
                prop_assert!(written || !corners.iter().any(moved), "triangle {} moved", t);
            }
            let Some(bounds) = output.tracker.changed_bounds() else {
                prop_assert!(found.is_empty());
                continue;
            };
            for v in output.tracker.changed().iter().cloned().flatten() {
                let v = v as usize;
                prop_assert!(contains(&bounds, before[v]) && contains(&bounds, output.positions[v]), "vertex {}", v);
            }
        }
        output.update(&mut body);
        prop_assert!(output.tracker.changed_triangles(triangles).is_empty());
        prop_assert_eq!(output.tracker.changed_bounds(), None);
    }
}

#[test]
fn only_convex_pieces_that_a_dent_reaches_are_made_again() {
    const PIECES: usize = 4;
    let mesh = sheet(48);
    let dent = bowl(&mesh, scenes::nearest(&mesh, [0.0; 3]), 0.06, 0.2);
    let mut set = ExampleSet::build(mesh, vec![dent], SetOptions::default(), &Serial).unwrap();
    // Plates of 0.25 m by 0.25 m by 1 cm.
    let piece = |n: usize| {
        let corner = |k: usize| {
            let at = |piece: usize, end: usize| 0.25 * (piece + end) as f32 - 0.5;
            [at(n % PIECES, k & 1), at(n / PIECES, k >> 1 & 1), -0.01 * (k >> 2) as f32]
        };
        MeshData { positions: (0..8).map(corner).collect(), ..MeshData::default() }
    };
    for n in 0..PIECES * PIECES {
        assert_eq!(set.add_lod(piece(n), &Serial).unwrap(), n + 1);
    }
    let mut body = scenes::new(&Arc::new(set));
    let mut pieces: Vec<Output> = (1..=PIECES * PIECES).map(|lod| Output::fresh_level(&mut body, lod)).collect();
    let rest: Vec<_> = pieces.iter().map(|p| p.positions.clone()).collect();

    // A dent on the corner at which four pieces meet reaches these four alone.
    body.submit(&scenes::push([0.25, 0.25, 0.0], [0.0, 0.0, -0.05])).unwrap();
    pieces.iter_mut().for_each(|p| _ = p.update(&mut body));
    let changed: Vec<usize> = (0..pieces.len()).filter(|&n| !pieces[n].tracker.changed().is_empty()).collect();
    assert_eq!(changed, [10, 11, 14, 15]);
    for (n, piece) in pieces.iter().enumerate() {
        assert_eq!(piece.positions != rest[n], changed.contains(&n), "piece {n}");
        let lowest = piece.positions.iter().map(|p| p[2]).fold(0.0, f32::min);
        assert_eq!(lowest < -0.05, changed.contains(&n), "piece {n} reaches down to {lowest} m");
    }
}
