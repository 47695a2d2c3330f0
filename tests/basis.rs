//! Vertices that follow nodes: how near they are to those of a node at every vertex, their normals, seams and cost in memory.
//! tests/promises.rs holds the promises that all bodies share.

mod scenes;

use std::sync::Arc;

use crumple::glam::Vec3;
use crumple::{BasisOptions, BasisReport, ExampleSet, Hit, SetOptions};
use scenes::{Output, displacements, new};

/// A solver body whose vertices follow nodes.
fn following(body: &str, options: BasisOptions) -> (Arc<ExampleSet>, BasisReport) {
    let set = scenes::solver_with(body, 8, SetOptions { basis: Some(options), ..SetOptions::default() });
    let report = set.basis_report().unwrap();
    (set, report)
}

fn panel() -> Arc<ExampleSet> {
    scenes::solver_set("panel", 8)
}

fn options(set: &ExampleSet) -> BasisOptions {
    BasisOptions { tolerance: 0.02 * set.depth_limit(), rounds: 4, nodes: 512 }
}

#[test]
fn dents_and_their_normals_are_near_those_with_all_vertices_as_nodes() {
    for (body, most) in [("panel", 0.05), ("tube", 0.08)] {
        let set = scenes::solver_set(body, 8);
        let (copy, _) = following(body, options(&set));
        let (all, _) = following(body, scenes::every_node(SetOptions::default()).basis.unwrap());
        let (mut errors, mut turns) = (Vec::new(), Vec::new());
        for e in set.examples() {
            let hit = scenes::own_hit(e);
            let (mut exact, mut near) = (new(&all), new(&copy));
            exact.submit(&hit).unwrap();
            near.submit(&hit).unwrap();
            let ought = displacements(&mut exact);
            errors.push(scenes::relative_l2(&displacements(&mut near), &ought));
            let (a, b) = (Output::fresh(&mut exact), Output::fresh(&mut near));
            let angle = |v: usize| Vec3::from(a.normals[v]).angle_between(Vec3::from(b.normals[v])).to_degrees();
            turns.extend((0..ought.len()).filter(|v| ought[*v].length() > 1e-3 * set.depth_limit()).map(angle));
        }
        errors.sort_by(f64::total_cmp);
        turns.sort_by(f32::total_cmp);
        let (error, turn) = (errors[errors.len() / 2], turns[turns.len() / 2]);
        assert!(errors.len() >= 8 && error < most, "{error} over {} hits", errors.len());
        assert!(turn < 0.5, "normals are off by {turn} degrees in the median");
    }
}

#[test]
fn nodes_are_vertices_of_distinct_positions_and_fewer_than_vertices() {
    let set = panel();
    let tolerance = 0.05 * set.depth_limit();
    let (_, report) = following("panel", BasisOptions { tolerance, rounds: 12, nodes: 512 });
    assert!(report.nodes * 3 < set.vertex_count(), "{report:?}");
    assert!(report.worst > 0.0 && report.worst <= tolerance, "{report:?}");
    let strict = BasisOptions { tolerance: 1e-9, rounds: 0, nodes: 512 };
    assert!(following("panel", strict).1.worst > strict.tolerance);
    // All of the panel's positions are fewer than a set begins with.
    let built = set.basis_report().unwrap();
    assert!(built.nodes > 2000 && built.worst == 0.0, "{built:?}");
}

/// Where it is made, and elsewhere; at nodes, and between them.
#[test]
fn an_example_that_moves_one_vertex_dents_one_vertex() {
    let (few, many) = (scenes::sheet(8), scenes::sheet(80));
    for (mesh, vertices) in [(&few, vec![(30, 30), (30, 33)]), (&many, (3000..3008).map(|v| (v, v)).collect())] {
        for (vertex, at) in vertices {
            let set = scenes::build(mesh.clone(), vec![scenes::poke(vertex, 0.01)], SetOptions::default());
            let mut body = new(&set);
            body.submit(&Hit::displacement(mesh.positions[at as usize], [0.0, 0.0, -0.01])).unwrap();
            for (v, u) in displacements(&mut body).iter().enumerate() {
                let (ought, within) = if v == at as usize { (-0.01, 1e-4) } else { (0.0, 5e-3) };
                assert!((u.z - ought).abs() < within, "vertex {v} for {at}: {u}");
            }
        }
    }
}

#[test]
fn examples_that_move_no_node_are_saved_with_the_others() {
    // The basis is learned from every other one of so many.
    let mesh = scenes::sheet(20);
    let examples = (0..258u32).map(|i| match i % 2 {
        0 => scenes::bowl(&mesh, 37 * i % 400, 0.05, 0.2),
        _ => scenes::poke(i, 0.01),
    });
    let basis = Some(BasisOptions { tolerance: 1.0, rounds: 0, nodes: 32 });
    let set =
        scenes::build(mesh.clone(), examples.collect(), SetOptions { basis, mirror: false, ..SetOptions::default() });
    let again = crumple::ExampleSet::load_copy(&set.save().unwrap(), &crumple::Serial).unwrap();
    assert_eq!(again.example_errors(), set.example_errors());
}

/// At least 512 nodes, spread evenly.
fn few_nodes() -> SetOptions {
    let basis = Some(BasisOptions { tolerance: 1.0, rounds: 0, nodes: 512 });
    SetOptions { basis, ..SetOptions::default() }
}

#[test]
fn a_mirrored_hit_leaves_the_mirrored_dent() {
    let mesh = scenes::sheet(61);
    let contact = scenes::nearest(&mesh, [-0.2, -0.1, 0.0]);
    let dent = scenes::bowl(&mesh, contact, 0.05, 0.25);
    let set = scenes::build(mesh.clone(), vec![dent], few_nodes());
    assert!(set.basis_report().unwrap().nodes < mesh.positions.len() / 2);
    let after = |v: u32| {
        let mut body = new(&set);
        body.submit(&Hit::displacement(mesh.positions[v as usize], [0.0, 0.0, -0.05])).unwrap();
        displacements(&mut body)
    };
    let here = after(contact);
    for flip in [Vec3::new(-1.0, 1.0, 1.0), Vec3::new(1.0, -1.0, 1.0), Vec3::new(-1.0, -1.0, 1.0)] {
        let image = |p: [f32; 3]| scenes::nearest(&mesh, (Vec3::from(p) * flip).to_array());
        let there = after(image(mesh.positions[contact as usize]));
        let back: Vec<Vec3> = mesh.positions.iter().map(|p| there[image(*p) as usize] * flip).collect();
        // Tiles, and so weights, are not the same on both sides.
        let error = scenes::relative_l2(&back, &here);
        assert!(error < 0.02, "{flip}: {error}");
    }
}

#[test]
fn both_skins_of_a_thin_plate_have_nodes_and_no_more_than_one_skin_would() {
    let skin = scenes::sheet(61);
    let mut plate = skin.clone();
    let count = skin.positions.len() as u32;
    plate.positions.extend(skin.positions.iter().map(|p| [p[0], p[1], p[2] - 0.01]));
    plate.triangles.extend(skin.triangles.iter().map(|t| [t[0] + count, t[2] + count, t[1] + count]));
    plate.normals = Some([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]].map(|n| vec![n; count as usize]).concat());
    plate.tangents = None;
    let dent = scenes::bowl(&plate, count / 2, 0.05, 0.25);
    let set = scenes::build(plate, vec![dent], few_nodes());
    let nodes = set.basis_report().unwrap().nodes;
    assert!((512..1536).contains(&nodes), "{nodes} nodes for {} vertices", 2 * count);
}

/// Angle between the normals of the triangles on both sides of an edge, degrees.
fn folded(mesh: &crumple::MeshData, moved: &[Vec3], edge: [u32; 2]) -> f32 {
    let at = |v: u32| Vec3::from(mesh.positions[v as usize]) + moved[v as usize];
    let sides = mesh.triangles.iter().filter(|t| edge.iter().all(|v| t.contains(v)));
    let normals: Vec<Vec3> = sides.map(|t| (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0]))).collect();
    normals[0].angle_between(normals[1]).to_degrees()
}

#[test]
fn a_sculpted_example_keeps_its_sharp_fold() {
    const N: usize = 100;
    let mesh = scenes::sheet(N);
    // A valley along a row of vertices, 30 mm deep and 120 mm wide, that runs out at both ends.
    let valley = |p: &[f32; 3]| (1.0 - p[0].abs() / 0.06).max(0.0) * (1.0 - (p[1] / 0.3).powi(2)).max(0.0);
    let values: Vec<[f32; 3]> = mesh.positions.iter().map(|p| [0.0, 0.0, -0.03 * valley(p)]).collect();
    let sculpted: Vec<Vec3> = values.iter().map(|u| Vec3::from(*u)).collect();
    let example = crumple::ExampleData::new("valley", crumple::Deltas::Full(values));
    let basis = Some(BasisOptions::new(3e-4));
    let set = scenes::build(mesh.clone(), vec![example], SetOptions { basis, ..SetOptions::default() });
    let mut body = new(&set);
    body.submit(&Hit::displacement([0.0; 3], [0.0, 0.0, -0.03])).unwrap();
    let moved = displacements(&mut body);
    let row = |k: usize| ((N / 2) * (N + 1) + k) as u32;
    for k in N / 4..3 * N / 4 {
        let edge = [row(k), row(k + 1)];
        let (ought, is) = (folded(&mesh, &sculpted, edge), folded(&mesh, &moved, edge));
        assert!((is - ought).abs() < 0.1 * ought, "the fold at {k} has {is} degrees instead of {ought}");
    }
    let nodes = set.basis_report().unwrap().nodes;
    assert!(2 * nodes < mesh.positions.len(), "{nodes} nodes: the fold does not lie at nodes alone");
}
