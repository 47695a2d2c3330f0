//! What a set learns from its body and its examples: mirror planes, held rims, and what stays in its place.

mod scenes;

use std::sync::Arc;

use crumple::glam::Vec3;
use crumple::{Contact, Deltas, ExampleData, ExampleSet, Hit, Instance, InstanceOptions, MeshData, SetOptions};
use scenes::{Dice, Output, build, displacements, new, push, random_hit, relative_l2, solver_with};

fn positions(set: &ExampleSet) -> &[Vec3] {
    set.mesh().positions()
}

/// The displacements and the outcome of one hit.
fn dent(set: &Arc<ExampleSet>, options: InstanceOptions, hit: &Hit) -> (Vec<Vec3>, crumple::Outcome) {
    let mut instance = Instance::new(set.clone(), options).unwrap();
    let outcome = instance.submit(hit).unwrap();
    (displacements(&mut instance), outcome)
}

/// An example that moves every vertex by `field` of its base position.
fn example(mesh: &MeshData, contact: u32, field: impl Fn(Vec3) -> Vec3) -> ExampleData {
    let values = mesh.positions.iter().map(|p| field(Vec3::from_array(*p)).to_array()).collect();
    ExampleData {
        contact: Some(Contact::Vertex(contact)),
        ..ExampleData::new(format!("at {contact}"), Deltas::Full(values))
    }
}

/// A sheet with its vertices moved so that no plane maps it onto itself.
fn lopsided(n: usize) -> MeshData {
    let mut mesh = scenes::sheet(n);
    for p in &mut mesh.positions {
        p[0] += 0.06 * (p[0] + 0.5) * (p[0] - 0.5) + 0.02 * p[1] * (p[0] + 0.3);
        p[1] += 0.05 * (p[1] + 0.5) * (p[1] - 0.5);
        p[2] = 0.1 * p[0] * p[0] + 0.03 * p[1];
    }
    mesh.normals = None;
    mesh.tangents = None;
    mesh
}

// ----------------------------------------------------------------------------------------------------------------- mirror

#[test]
fn mirror_planes_are_found_where_they_are() {
    let planes = |set: &ExampleSet| set.report().mirror_planes.bits();
    assert_eq!(planes(&scenes::solver_set("panel", 2)), 0b011);
    assert_eq!(planes(&scenes::solver_set("tube", 2)), 0b111);
    assert_eq!(planes(&solver_with("tube", 2, SetOptions { mirror: false, ..SetOptions::default() })), 0);
    // flat in z: a mirror image in that plane would be the example itself
    assert_eq!(planes(&scenes::sheet_set()), 0b011);
    assert_eq!(planes(&scenes::ball_set()), 0b111);
    let mesh = lopsided(12);
    let examples = vec![example(&mesh, 80, |p| Vec3::new(0.0, 0.0, -0.1 * (-20.0 * p.length_squared()).exp()))];
    assert_eq!(planes(&build(mesh, examples, SetOptions::default())), 0);
}

#[test]
fn examples_on_one_side_count_on_the_other_and_contradict_only_the_plane_between_them() {
    let mesh = scenes::sheet(40);
    // Wider towards the middle of x, and towards +y on both sides of the middle of y.
    let dent = |c: Vec3, p: Vec3| {
        let d = p - c;
        let wide = |towards: bool| if towards { 0.15f32 } else { 0.06 };
        let (x, y) = (d.x / wide(d.x * c.x < 0.0), d.y / wide(d.y > 0.0));
        Vec3::new(0.0, 0.0, -0.04 * (-x * x - y * y).exp())
    };
    let places = [-0.3f32, -0.2].into_iter().flat_map(|x| [-0.3f32, -0.1, 0.1, 0.3].map(|y| [x, y, 0.0]));
    let contacts: Vec<u32> = places.map(|p| scenes::nearest(&mesh, p)).collect();
    let at = |v: u32| Vec3::from(mesh.positions[v as usize]);
    let examples = contacts.iter().map(|v| example(&mesh, *v, |p| dent(at(*v), p))).collect();
    let set = build(mesh.clone(), examples, SetOptions::default());
    // Between the examples' images, where the false plane's would be as near as the true one's.
    for y in [-0.2, 0.0, 0.2] {
        let there = at(scenes::nearest(&mesh, [0.25, y, 0.0]));
        let hit = Hit::displacement(there.to_array(), [0.0, 0.0, -0.04]);
        let truth: Vec<Vec3> = mesh.positions.iter().map(|p| dent(there, Vec3::from(*p))).collect();
        let error = relative_l2(&self::dent(&set, InstanceOptions::default(), &hit).0, &truth);
        assert!(error < 0.05, "{there}: {error}");
    }
}

#[test]
fn planes_survive_a_few_strays_but_no_more() {
    // of 625 vertices 6 may lack an image
    let with = |strays: usize, off: f32| {
        let mut mesh = scenes::sheet(24);
        for i in 0..strays {
            // towards +y, off the lines that map onto themselves
            mesh.positions[30 + 25 * i][1] += off;
        }
        let examples = vec![scenes::bowl(&mesh, 312, 0.1, 0.3)];
        build(mesh, examples, SetOptions::default()).report().mirror_planes.bits()
    };
    assert_eq!(with(0, 0.0), 0b011);
    // each stray leaves its image without a partner too
    assert_eq!(with(3, 0.013), 0b011);
    assert_eq!(with(4, 0.013), 0);
    // off by more than a thousandth of the diagonal, or less
    assert_eq!(with(4, 0.0015), 0);
    assert_eq!(with(4, 0.0013), 0b011);
}

// ------------------------------------------------------------------------------------------------------------------- rims

/// Vertices on edges that belong to one triangle only.
fn rim(set: &ExampleSet) -> Vec<usize> {
    let weld = set.mesh().weld();
    let mut edges = std::collections::HashMap::new();
    for t in set.mesh().triangles() {
        let t = t.map(|v| weld[v as usize]);
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            *edges.entry((a.min(b), a.max(b))).or_insert(0) += 1;
        }
    }
    let mut on: Vec<usize> =
        edges.into_iter().filter(|(_, n)| *n == 1).flat_map(|((a, b), _)| [a as usize, b as usize]).collect();
    on.sort_unstable();
    on.dedup();
    on
}

#[test]
fn a_held_rim_never_moves_under_what_is_carried() {
    let moves = |held_rims: bool| {
        let set = solver_with("panel", 12, SetOptions { held_rims, ..SetOptions::default() });
        let rim = rim(&set);
        assert_eq!(set.report().held_vertices, if held_rims { rim.len() } else { 0 });
        let mut instance = new(&set);
        let mut dice = Dice::new(11);
        for i in 0..60 {
            // most of them near the rim
            let hit = if i % 4 == 0 {
                random_hit(&set, &mut dice)
            } else {
                scenes::hit_at(&set, rim[dice.index(rim.len())], &mut dice)
            };
            instance.submit(&hit).unwrap();
        }
        let out = Output::fresh(&mut instance);
        rim.iter().filter(|v| out.positions[**v] != positions(&set)[**v].to_array()).count()
    };
    assert_eq!(moves(true), 0);
    assert!(moves(false) > 50);
}

#[test]
fn the_rest_of_a_target_beside_a_held_rim_is_unmet() {
    let set = solver_with("panel", 12, SetOptions::default());
    let rim = rim(&set);
    let at = positions(&set)[rim[3]];
    let instance = new(&set);
    let outcome = instance.preview(&push(at.to_array(), [0.0, 0.0, -0.02])).unwrap();
    assert_eq!((outcome.achieved, outcome.shortfall()), ([0.0; 3], outcome.target));
}

/// A sheet of 20 by 20 squares with one round dent in the middle, which ends at `radius`.
fn dented(radius: f32, also: impl Fn(Vec3) -> f32) -> Arc<ExampleSet> {
    let mesh = scenes::sheet(20);
    let deep = move |p: Vec3| (1.0 - p.length_squared() / (radius * radius)).max(0.0).powi(2) + also(p);
    let e = example(&mesh, 220, |p| Vec3::new(0.0, 0.0, -0.1 * deep(p)));
    build(mesh, vec![e], SetOptions::default())
}

#[test]
fn a_rim_is_held_where_examples_show_it() {
    let held = |set: Arc<ExampleSet>| set.report().held_vertices;
    // a square dent up to the sides, which do not move
    let square = |p: Vec3| 5.0 * ((0.25 - p.x * p.x) * (0.25 - p.y * p.y)).max(0.0);
    assert_eq!(held(dented(0.3, square)), 80);
    // moved by a tenth of the deepest displacement: free
    assert_eq!(held(dented(0.3, |p| square(p) + if p.x > 0.49 && p.y > 0.49 { 0.2 } else { 0.0 })), 0);
    // moved by less than a hundredth: still held
    assert_eq!(held(dented(0.3, |p| square(p) + if p.x > 0.49 { 0.005 } else { 0.0 })), 80);
    // where nothing comes near the rim, it is unknown whether it is held
    assert_eq!(held(dented(0.3, |_| 0.0)), 0);
    assert_eq!(held(dented(0.3, |p| if p.x > 0.4 && p.x < 0.49 && p.y == 0.0 { 0.2 } else { 0.0 })), 80);
    // so is it where only the third row moves, which is further from it than 3 % of the diagonal
    assert_eq!(held(dented(0.3, |p| if p.x > 0.35 && p.x < 0.44 && p.y == 0.0 { 0.2 } else { 0.0 })), 0);
    // a closed body has no rim
    assert_eq!(held(scenes::ball_set()), 0);
    assert_eq!(held(scenes::cube_set()), 0);
}

#[test]
fn each_loop_is_held_or_free_by_itself() {
    // a sheet with a hole, dented everywhere but on its sides, where one vertex exists twice
    let mut mesh = MeshData { tangents: None, ..scenes::sheet(20) };
    let in_hole = |v: &u32| mesh.positions[*v as usize][..2].iter().all(|x| x.abs() < 0.11);
    mesh.triangles.retain(|t| !t.iter().all(in_hole));
    let copy = mesh.positions.len() as u32;
    mesh.positions.push(mesh.positions[0]);
    mesh.normals.as_mut().unwrap().push([0.0, 0.0, 1.0]);
    mesh.triangles[0].iter_mut().filter(|v| **v == 0).for_each(|v| *v = copy);
    let square = |p: Vec3| Vec3::NEG_Z * ((0.25 - p.x * p.x) * (0.25 - p.y * p.y)).max(0.0);
    let e = example(&mesh, scenes::nearest(&mesh, [0.25, 0.0, 0.0]), square);
    let set = build(mesh, vec![e], SetOptions::default());
    assert_eq!(set.report().held_vertices, 81);
    let moved = displacements(&mut scenes::dented(&set, InstanceOptions::default(), &scenes::random_hits(&set, 30, 2)));
    let is_side = |v: usize| positions(&set)[v].truncate().abs().max_element() == 0.5;
    let (sides, hole): (Vec<usize>, Vec<usize>) = rim(&set).into_iter().partition(|v| is_side(*v));
    assert!(sides.len() == 80 && sides.iter().all(|v| moved[*v] == Vec3::ZERO), "the sides");
    assert!(hole.len() == 16 && hole.iter().any(|v| moved[*v] != Vec3::ZERO), "the hole");
}

// ---------------------------------------------------------------------------------------------------------------- normals

/// The greatest angle between a normal that is shown and that of the triangles around it, degrees. A rim has triangles on one side only.
fn worst_normal(set: &Arc<ExampleSet>, hit: &Hit) -> f32 {
    let out = Output::fresh(&mut scenes::dented(set, InstanceOptions::default(), &[*hit]));
    let (sums, rim) = (scenes::area_normals(set, &out.positions), rim(set));
    let angle = |v: usize| sums[v].normalize().angle_between(Vec3::from_array(out.normals[v])).to_degrees();
    (0..sums.len()).filter(|v| rim.binary_search(v).is_err()).map(angle).fold(0.0, f32::max)
}

#[test]
fn normals_without_given_ones_and_beside_a_held_rim_are_those_of_the_surface() {
    let mesh = scenes::ball(3);
    let set = build(mesh.clone(), vec![scenes::bowl(&mesh, 17, 0.08, 0.3)], SetOptions::default());
    let worst = worst_normal(&set, &scenes::own_hit(&set.examples()[0]));
    assert!(worst < 8.0, "{worst} degrees on the ball");

    let mesh = scenes::sheet(200);
    let contact = scenes::nearest(&mesh, [0.0; 3]);
    // moves everything a little but the sides, which shows that they are held
    let inside = |p: Vec3| if p.x.abs().max(p.y.abs()) < 0.4999 { 0.011 } else { 0.0 };
    let round =
        example(&mesh, contact, |p| Vec3::new(0.0, 0.0, -0.05 * ((-p.length_squared() / 0.01).exp() + inside(p))));
    let set = build(mesh, vec![round], SetOptions::default());
    assert_eq!(set.report().held_vertices, 800);
    // away from corners, where the window has a crease because two sides are equally near
    for (x, y) in [(0.47, 0.1), (0.49, -0.3), (-0.3, 0.48), (-0.46, 0.0), (0.2, 0.1)] {
        for depth in [0.005, 0.015, 0.03] {
            let worst = worst_normal(&set, &push([x, y, 0.0], [0.0, 0.0, -depth]));
            // The window is as wide as two nodes are apart, and the example has a cliff along the rim.
            assert!(worst < 24.0, "at {x}, {y}, depth {depth}: {worst} degrees");
        }
    }
}

// ---------------------------------------------------------------------------------------------------------------- learned

/// A drum: one shape of dent wherever it is hit.
fn drum(count: usize) -> Arc<ExampleSet> {
    let mesh = lopsided(20);
    let mut dice = Dice::new(8);
    let shape = |p: Vec3| (std::f32::consts::PI * p.x).cos() * (std::f32::consts::PI * p.y).cos();
    let inside = |v: &u32| mesh.positions[*v as usize][..2].iter().all(|x| x.abs() < 0.35);
    let examples = scenes::spread(&mesh.positions, 4 * count, 220)
        .into_iter()
        .filter(inside)
        .take(count)
        .map(|c| {
            let size = dice.between(0.03, 0.12);
            example(&mesh, c, |p| Vec3::new(0.0, 0.0, -size * shape(p)))
        })
        .collect();
    build(mesh, examples, SetOptions::default())
}

#[test]
fn what_dents_the_same_wherever_it_is_hit_stays_in_place() {
    let set = drum(12);
    assert!(set.example_errors().iter().all(|e| *e < 0.05), "{:?}", set.example_errors());
    // a hit between the examples gets that shape too
    let at = positions(&set)[scenes::nearest(&lopsided(20), [0.1, 0.2, 0.0]) as usize];
    let (field, outcome) = dent(&set, InstanceOptions::default(), &push(at.to_array(), [0.0, 0.0, -0.05]));
    let shape: Vec<Vec3> = (0..set.vertex_count() as u32).map(|v| set.examples()[0].delta(v)).collect();
    let contact = outcome.contact_vertex as usize;
    let as_deep: Vec<Vec3> = shape.iter().map(|d| *d * (0.05 / shape[contact].length())).collect();
    assert!(relative_l2(&field, &as_deep) < 0.02);
}
