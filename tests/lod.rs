//! Levels of detail: several meshes show the same damage. A level that is the base mesh is compared bit for bit (`parts.rs` does that
//! with pieces of it), others with an interpolation in f64. `promises.rs` has what is written of a level, and when; and which triangles a deform
//! changed, with the box around them.

mod scenes;

use std::sync::Arc;

use crumple::glam::DVec3;
use crumple::{
    DeformJob, Error, ErrorKind, ExampleData, ExampleSet, Hit, Instance, InstanceOptions, MeshData, Rule, Serial,
    SetOptions, Tracker, VertexMemory, deform,
};
use scenes::{Dice, Output, ball, bowls, coincident, cube, dented, new, own_hit, push, random_hits, sheet};

fn options(tolerance: Option<f32>) -> SetOptions {
    SetOptions { tolerance, ..SetOptions::default() }
}

fn with_lods(mesh: MeshData, examples: Vec<ExampleData>, options: SetOptions, lods: &[MeshData]) -> Arc<ExampleSet> {
    let mut set = ExampleSet::build(mesh, examples, options, &Serial).unwrap();
    for (i, lod) in lods.iter().enumerate() {
        assert_eq!(set.add_lod(lod.clone(), &Serial).unwrap(), i + 1);
    }
    assert_eq!((set.lod_count(), set.report().lods.len()), (1 + lods.len(), lods.len()));
    Arc::new(set)
}

/// Hits at the examples' own contacts, and hits anywhere else.
fn hits(set: &ExampleSet, seed: u64) -> Vec<Hit> {
    set.examples().iter().map(own_hit).take(3).chain(random_hits(set, 5, seed)).collect()
}

#[test]
fn a_level_that_is_the_base_mesh_moves_as_the_base_does_and_seams_stay_closed() {
    for (mesh, radius, others) in
        [(sheet(12), 0.4, vec![]), (ball(2), 0.45, vec![]), (cube(10), 0.6, vec![cube(6), cube(14)])]
    {
        for tolerance in [None, Some(1e-4)] {
            let lods = [std::slice::from_ref(&mesh), &others[..]].concat();
            let set = with_lods(mesh.clone(), bowls(&mesh, 5, radius, 3), options(tolerance), &lods);
            assert_eq!(set.report().lods[0].farthest, 0.0);
            let mut body = dented(&set, InstanceOptions::default(), &hits(&set, 9));
            let levels: Vec<Output> = (0..=lods.len()).map(|lod| Output::fresh_level(&mut body, lod)).collect();
            for (lod, level) in lods.iter().zip(&levels[1..]) {
                let bits = level.position_bits();
                assert!(coincident(&lod.positions).iter().all(|g| g.iter().all(|v| bits[*v] == bits[g[0]])));
            }
            let [base, same] = [&levels[0], &levels[1]];
            assert_eq!(base.position_bits(), same.position_bits(), "{tolerance:?}");
            for (a, b) in base.normals.iter().zip(&same.normals) {
                // Slopes of the base mesh were fitted, those of the level follow from its rows.
                assert!(scenes::distance(*a, *b) < 0.1, "{a:?} {b:?}");
            }
            assert_eq!(base.tracker.bounds(), same.tracker.bounds());
        }
    }
}

/// Displacement of a point of the flat sheet by linear interpolation over its triangles, in f64.
fn interpolated(n: usize, point: [f32; 3], of: &dyn Fn(usize) -> DVec3) -> DVec3 {
    let (x, y) = ((f64::from(point[0]) + 0.5) * n as f64, (f64::from(point[1]) + 0.5) * n as f64);
    let (i, j) = ((x.floor() as usize).min(n - 1), (y.floor() as usize).min(n - 1));
    let (u, v) = (x - i as f64, y - j as f64);
    let at = |a: usize, b: usize| of((i + a) * (n + 1) + j + b);
    // Each square is cut along the diagonal from (0, 0) to (1, 1).
    if u >= v {
        at(0, 0) * (1.0 - u) + at(1, 0) * (u - v) + at(1, 1) * v
    } else {
        at(0, 0) * (1.0 - v) + at(0, 1) * (v - u) + at(1, 1) * u
    }
}

#[test]
fn vertices_between_follow_the_interpolated_displacement() {
    let (n, tolerance) = (24, 1e-4);
    let mut dice = Dice::new(8);
    let mut points: Vec<[f32; 3]> =
        (0..700).map(|_| [dice.between(-0.5, 0.5), dice.between(-0.5, 0.5), dice.between(-0.02, 0.02)]).collect();
    // A point on an edge, and one on a vertex.
    points.extend([[0.5, 0.01, 0.0], [-0.5, -0.5, 0.0]]);
    let lod = MeshData { positions: points.clone(), normals: Some(vec![[0.0, 0.0, 1.0]; 702]), ..MeshData::default() };
    for tolerance in [None, Some(tolerance)] {
        let mesh = sheet(n);
        let examples = bowls(&mesh, 4, 0.35, 2);
        let set = with_lods(mesh, examples, options(tolerance), std::slice::from_ref(&lod));
        assert!((set.report().lods[0].farthest - 0.02).abs() < 1e-3);
        let mut still = 0;
        for e in set.examples() {
            let mut body = dented(&set, InstanceOptions::default(), &[own_hit(e)]);
            let level = Output::fresh_level(&mut body, 1);
            let delta = |v: usize| e.delta(v as u32).as_dvec3();
            for (p, q) in points.iter().zip(&level.positions) {
                let wanted = interpolated(n, *p, &delta);
                let got = DVec3::new(f64::from(q[0]), f64::from(q[1]), f64::from(q[2]))
                    - DVec3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]));
                let off = (got - wanted).length();
                assert!(off <= 0.03 * f64::from(e.depth()), "{off} at {p:?}");
                still += usize::from(wanted == DVec3::ZERO && off == 0.0);
            }
        }
        assert!(still > 100, "{still}");
    }
}

#[test]
fn what_cannot_be_a_level_is_refused_and_leaves_nothing() {
    let mesh = sheet(8);
    let mut set = ExampleSet::build(mesh.clone(), bowls(&mesh, 2, 0.4, 2), options(None), &Serial).unwrap();
    let (bytes, fingerprint) = (set.memory_bytes(), set.fingerprint());
    let error = set.add_lod(MeshData::default(), &Serial).unwrap_err();
    assert_eq!(error.to_string(), "mesh: level of detail 1: it has 0 vertices; at least 1 is needed");
    let far = MeshData { positions: vec![[f32::NAN; 3]], ..MeshData::default() };
    assert_eq!(set.add_lod(far, &Serial).unwrap_err().kind(), ErrorKind::NotFinite);
    let loose = MeshData { triangles: vec![[0, 1, 9]], positions: vec![[0.0; 3]; 3], ..MeshData::default() };
    assert_eq!(set.add_lod(loose, &Serial).unwrap_err().kind(), ErrorKind::IndexOutOfRange);
    assert_eq!((set.lod_count(), set.memory_bytes()), (1, bytes));

    set.add_lod(sheet(4), &Serial).unwrap();
    assert_eq!(set.fingerprint(), fingerprint);
    assert_eq!(set.memory_bytes(), bytes + set.report().lods[0].bytes);
    let error = set.lod_mesh(2).unwrap_err();
    assert_eq!(error, Error::IndexOutOfRange { name: "the level of detail".into(), index: 2, len: 2 });
    let set = Arc::new(set);
    let job = |lod: usize, rule: Rule, count: usize| {
        let options = if rule == Rule::Marks { InstanceOptions::default() } else { InstanceOptions::classic(rule) };
        let instance = Instance::new(set.clone(), options).unwrap();
        let (mut positions, mut tracker) = (vec![[0.0f32; 3]; count], Tracker::new());
        let memory = VertexMemory::separate(&mut positions, None, None).unwrap();
        deform(&mut [DeformJob { lod, instance: &instance, tracker: &mut tracker, memory }], &Serial)
    };
    assert_eq!(job(2, Rule::Marks, 25).unwrap_err().to_string(), "the level of detail is 2; it must be below 2");
    assert_eq!(job(1, Rule::MostDisplaced, 25).unwrap_err().kind(), ErrorKind::WrongRule);
    assert_eq!(job(1, Rule::Marks, 24).unwrap_err().kind(), ErrorKind::BufferTooSmall);
    assert_eq!(job(0, Rule::MostDisplaced, 81).unwrap().vertices_written, 81);
    assert_eq!(job(1, Rule::Marks, 25).unwrap().vertices_written, 25);
}

#[test]
fn a_view_chooses_the_coarsest_level_whose_edges_are_short_on_the_screen() {
    // Right triangles over cells of 1/16, 1/8 and 1/4 m: the root mean square edge is the cell times the root of 4/3.
    let mesh = scenes::sheet(16);
    let examples = bowls(&mesh, 3, 0.3, 1);
    let levels = [scenes::sheet(8), scenes::sheet(4)];
    let set = with_lods(mesh, examples, options(None), &levels);
    let mut body = new(&set);
    // At 90 degrees and 1000 pixels, a pixel covers 1/500 of the distance. Edges may cover 16 pixels for each pixel of error.
    let edge = |cell: f32| cell * (4.0f32 / 3.0).sqrt();
    let (fov, rest) = (std::f32::consts::FRAC_PI_2, 0.999);
    for (pixels, level) in [(0.5, 0), (1.0, 0), (0.5, 1), (1.0, 1), (0.25, 2)] {
        let cell = [1.0 / 8.0, 1.0 / 4.0, 1.0 / 2.0][level];
        // Just below the distance at which the next level's edges are short enough.
        let distance = rest * edge(cell) / (16.0 * pixels) * 500.0;
        assert_eq!(body.set_view(pixels, distance, fov, 1000.0).unwrap(), level, "{pixels} {level}");
        let next = (level + 1).min(2);
        assert_eq!(body.set_view(pixels, distance * 1.01 / rest, fov, 1000.0).unwrap(), next);
    }
    assert_eq!(body.set_view(0.0, 1e6, fov, 1000.0).unwrap(), 0);
    assert_eq!(new(&scenes::sheet_set()).set_view(2.0, 10.0, fov, 1000.0).unwrap(), 0, "there is no other level");
    for (bad, name) in [
        ([-1.0, 1.0, 1.0, 1.0], "pixels is -1"),
        ([1.0, f32::NAN, 1.0, 1.0], "distance is NaN"),
        ([1.0, 1.0, 3.2, 1.0], "fov_y is 3.2"),
        ([1.0, 1.0, 1.0, 0.0], "viewport_height is 0"),
    ] {
        let error = body.set_view(bad[0], bad[1], bad[2], bad[3]).unwrap_err();
        assert!(error.to_string().starts_with(name), "{error}");
    }
}

#[test]
fn thousands_of_vertices_at_one_place_bind_in_linear_time() {
    // Comparing each with each would take minutes.
    let count = 100_000;
    let mesh = MeshData { positions: vec![[0.0; 3]; count], triangles: vec![[0, 1, 2]; count], ..MeshData::default() };
    let dent = ExampleData::new("dent", crumple::Deltas::Full(vec![[0.0, 0.0, -0.1]; count]));
    let beside = MeshData { positions: vec![[0.0, 0.0, 0.1]; 1000], triangles: vec![[0, 1, 2]], ..MeshData::default() };
    let set = with_lods(mesh.clone(), vec![dent], options(None), &[mesh, beside]);
    let mut body = Instance::new(set, InstanceOptions::default()).unwrap();
    body.inbox().submit(&push([0.0; 3], [0.0, 0.0, -0.1])).unwrap();
    let levels = [0, 1, 2].map(|lod| Output::fresh_level(&mut body, lod));
    assert!(levels[0].positions[0][2] < -0.05);
    assert_eq!(levels[0].position_bits(), levels[1].position_bits());
    assert!(levels[2].positions.iter().all(|p| *p == levels[2].positions[0]));
}

/// Convex pieces, of which a collider is made.
#[test]
fn only_convex_pieces_that_a_dent_reaches_are_made_again() {
    const PIECES: usize = 4;
    let mesh = sheet(48);
    let dent = scenes::bowl(&mesh, scenes::nearest(&mesh, [0.0; 3]), 0.06, 0.2);
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
    let mut body = new(&Arc::new(set));
    let mut pieces: Vec<Output> = (1..=PIECES * PIECES).map(|lod| Output::fresh_level(&mut body, lod)).collect();
    let rest: Vec<_> = pieces.iter().map(|p| p.positions.clone()).collect();

    // A dent on the corner at which four pieces meet reaches these four alone.
    body.submit(&push([0.25, 0.25, 0.0], [0.0, 0.0, -0.05])).unwrap();
    pieces.iter_mut().for_each(|p| _ = p.update(&mut body));
    let changed: Vec<usize> = (0..pieces.len()).filter(|&n| !pieces[n].tracker.changed().is_empty()).collect();
    assert_eq!(changed, [10, 11, 14, 15]);
    for (n, piece) in pieces.iter().enumerate() {
        assert_eq!(piece.positions != rest[n], changed.contains(&n), "piece {n}");
        let lowest = piece.positions.iter().map(|p| p[2]).fold(0.0, f32::min);
        assert_eq!(lowest < -0.05, changed.contains(&n), "piece {n} reaches down to {lowest} m");
    }
}
