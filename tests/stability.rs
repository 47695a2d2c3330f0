//! The facts behind the lab's stability charts, where other methods fail. `promises.rs` tests hits of any size and in
//! any order, `contacts.rs` frame rates, `bad_input.rs` broken meshes.

mod scenes;

use std::sync::Arc;

use crumple::glam::Vec3;
use crumple::{BasisOptions, Contact, Deltas, ExampleData, ExampleSet, Hit, Mark, MeshData, Serial, SetOptions};
use proptest::prelude::*;
use scenes::{Dice, Output, build, check_sound, dented, displacements, new, push, random_hit, relative_l2, sheet};

/// Displacements after these hits in this order.
fn after(set: &Arc<ExampleSet>, hits: &[Hit]) -> Vec<Vec3> {
    let mut instance = new(set);
    for hit in hits {
        instance.submit(hit).unwrap();
        instance.fold();
    }
    displacements(&mut instance)
}

fn deepest(field: &[Vec3]) -> f32 {
    field.iter().map(|u| u.length()).fold(0.0, f32::max)
}

/// A dent around `at` of the sheet that ends at `radius` and pulls the surface towards its middle by `pull` times the
/// distance.
fn dent(mesh: &MeshData, at: [f32; 2], radius: f32, direction: [f32; 3], pull: f32) -> ExampleData {
    let one = |p: &[f32; 3]| {
        let r = [p[0] - at[0], p[1] - at[1], 0.0];
        let q = (r[0] * r[0] + r[1] * r[1]) / (radius * radius);
        let w = if q < 1.0 { (1.0 - q) * (1.0 - q) } else { 0.0 };
        [0, 1, 2].map(|k| w * (direction[k] - pull * r[k]))
    };
    ExampleData {
        contact: Some(Contact::Point([at[0], at[1], 0.0])),
        ..ExampleData::new("dent", Deltas::Full(mesh.positions.iter().map(one).collect()))
    }
}

proptest! {
    #![proptest_config(scenes::cases(24))]

    /// Supports from one vertex to far beyond the body, examples that contradict each other, and such as hardly move their own contact: scaling
    /// one to a target would multiply its other displacements by up to 1e22.
    #[test]
    fn examples_of_any_kind_stay_bounded(seed: u64) {
        let mut dice = Dice::new(seed);
        let mesh = sheet(24);
        let mut pick = |list: &[f32]| list[dice.index(list.len())];
        let angle = pick(&[0.0, 30.0, 90.0, 150.0, 175.0, 179.0, 179.9, 179.999, 180.0]);
        let (sin, cos) = (angle / 2.0).to_radians().sin_cos();
        let examples = [1.0, -1.0].map(|side: f32| {
            let at = [pick(&[-0.25, 0.0, 0.25]), pick(&[0.0, 0.125])];
            let radius = pick(&[1e-3, 0.05, 0.3, 0.3, 2.0, 1e4]);
            let mut e = dent(&mesh, at, radius, [side * 0.03 * sin, 0.0, -0.03 * cos], 0.0);
            let contact = scenes::nearest(&mesh, [at[0], at[1], 0.0]);
            let Deltas::Full(values) = &mut e.positions else { unreachable!() };
            let tiny = pick(&[1.0, 1.0, 1.0, 1e-3, 1e-9, 1e-15, 1e-18, 1e-20]);
            values[contact as usize] = values[contact as usize].map(|x| x * tiny);
            ExampleData { contact: Some(Contact::Vertex(contact)), ..e }
        });
        let set = build(mesh, examples.to_vec(), SetOptions::default());
        let mut hits: Vec<Hit> = (0..12).map(|_| random_hit(&set, &mut dice)).collect();
        for e in set.examples() {
            let targets = [[0.0, 0.0, -0.03], [0.0, 0.0, 0.03], [0.02, 0.01, -0.001], [0.0, 0.0, -1e-6], [0.0, 0.0, -1e30]];
            hits.extend(targets.map(|target| push(e.contact_point().into(), target)));
        }
        for hits in hits.chunks(1).chain([&hits[..]]) {
            check_sound(&mut dented(&set, Default::default(), hits))?;
        }
    }
}

/// The panel or the tube with its first 8 examples, moved away, and 20 hits on it.
fn placed(body: &str, away: f32) -> (Arc<ExampleSet>, Vec<Hit>) {
    let (mut mesh, mut examples) = scenes::solver(body, 8);
    let moved = |p: [f32; 3]| p.map(|x| x + away);
    for e in &mut examples {
        if let Some(Contact::Point(p)) = &mut e.contact {
            *p = moved(*p);
        }
    }
    mesh.positions.iter_mut().for_each(|p| *p = moved(*p));
    let mut dice = Dice::new(8);
    let hit = |_| {
        let v = dice.index(mesh.positions.len());
        let size = dice.between(-0.04, -0.01);
        push(mesh.positions[v], mesh.normals.as_ref().unwrap()[v].map(|x| x * size))
    };
    let hits = (0..20).map(hit).collect();
    (build(mesh, examples, SetOptions::default()), hits)
}

#[test]
fn far_from_the_origin_only_rounding_is_lost() {
    for body in ["panel", "tube"] {
        let (set, hits) = placed(body, 0.0);
        let reference = after(&set, &hits);
        for away in [1.0, 100.0] {
            let (set, hits) = placed(body, away);
            let error = relative_l2(&after(&set, &hits), &reference);
            // One rounding of a position, relative to a dent of this depth.
            let rounding = f64::from(away) * 6e-8 / f64::from(deepest(&reference));
            assert!(error < 0.01 + 100.0 * rounding, "{body} at {away} m: {error}");
        }
        // So far away that the body's own vertices coincide: still bounded.
        let (set, hits) = placed(body, 1e6);
        let field = after(&set, &hits);
        assert!(field.iter().all(|u| u.is_finite()) && deepest(&field) <= set.depth_limit() * 1.00001 + 0.25);
    }
}

#[test]
fn bodies_of_any_kind_are_bounded_watertight_and_free_of_order() {
    let good = MeshData { normals: None, tangents: None, ..sheet(16) };
    let dents = |mesh: &MeshData| {
        [([0.0, 0.0], 0.25, 0.05), ([0.25, 0.25], 0.2, 0.03), ([-0.25, -0.125], 0.3, 0.04)]
            .map(|(at, r, d)| ExampleData { contact: None, ..dent(mesh, at, r, [0.0, 0.0, -d], 0.3) })
            .to_vec()
    };
    type Spoil = fn(&mut MeshData);
    let spoils: [(&str, Spoil); 10] = [
        ("equal corners", |m| m.triangles.extend((0..100).map(|v| [v, v, v + 1]))),
        ("no area", |m| m.triangles.extend((0..100).map(|v| [v, v + 1, v + 2]))),
        ("every triangle twice", |m| m.triangles.extend(m.triangles.clone())),
        ("reversed ones beside", |m| {
            let reversed: Vec<_> = m.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
            m.triangles.extend(reversed);
        }),
        ("corners of its own", |m| {
            let all: Vec<u32> = m.triangles.iter().flatten().copied().collect();
            m.positions = all.iter().map(|v| m.positions[*v as usize]).collect();
            m.triangles = (0..all.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        }),
        ("three at an edge", |m| {
            let n = m.positions.len() as u32;
            let fins: Vec<_> = m.positions.iter().map(|p| [p[0], p[1], 0.1]).collect();
            m.positions.extend(fins);
            m.triangles.extend((0..n - 1).map(|v| [v, v + 1, n + v]));
        }),
        ("folded flat on itself", |m| {
            let n = m.positions.len() as u32;
            m.positions.extend(m.positions.clone());
            m.triangles.extend(m.triangles.clone().iter().map(|[a, b, c]| [n + a, n + c, n + b]));
        }),
        ("unused vertices", |m| m.positions.extend([[0.0, 0.0, 3.0]; 50])),
        ("no triangles", |m| m.triangles.clear()),
        ("one point", |m| m.positions.fill([0.125; 3])),
    ];
    let spoilt = spoils.map(|(name, spoil)| {
        let mut mesh = good.clone();
        spoil(&mut mesh);
        let examples = dents(&mesh);
        (name, mesh, examples)
    });
    let changed = |change: &dyn Fn([f32; 3]) -> [f32; 3]| MeshData {
        positions: good.positions.iter().map(|p| change(*p)).collect(),
        ..sheet(16)
    };
    let odd = [
        ("one vertex", MeshData { positions: vec![[1.0, 2.0, 3.0]], ..MeshData::default() }),
        ("small", changed(&|p| p.map(|x| x * 1e-6))),
        // The squares of its distances are 0 in f32. The search for the surface's height never ended.
        ("too small for squares", changed(&|p| p.map(|x| x * 1e-22))),
        ("far away", changed(&|p| p.map(|x| x + 1e6))),
        ("large", changed(&|p| p.map(|x| x * 1e8))),
        ("a line", changed(&|[_, y, z]| [0.0, y, z])),
    ];
    let odd = odd.map(|(name, mesh)| (name, mesh, vec![scenes::poke(0, 0.1)]));
    for (name, mesh, examples) in spoilt.into_iter().chain(odd) {
        let basis = Some(BasisOptions::new(1e-3));
        let set = build(mesh, examples, SetOptions { basis, ..SetOptions::default() });
        let report = set.basis_report().unwrap();
        assert!(report.worst.is_finite() && report.nodes >= 1, "{name}: {report:?}");
        let again = ExampleSet::load_copy(&set.save().unwrap(), &Serial).unwrap();
        assert!(again.save().unwrap() == set.save().unwrap(), "{name}");
        let mut dice = Dice::new(9);
        let mut hit = |_| push(scenes::base(&set, dice.index(set.vertex_count())), dice.vector(set.depth_limit()));
        let mut hits: Vec<Hit> = (0..60).map(&mut hit).collect();
        let mut results = Vec::new();
        for _ in 0..3 {
            dice.shuffle(&mut hits);
            let mut instance = dented(&set, Default::default(), &hits);
            check_sound(&mut instance).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert!(!instance.marks().unwrap().is_empty(), "{name}");
            results.push(Output::fresh(&mut instance).positions);
        }
        assert!(results.iter().all(|r| *r == results[0]), "{name}: the order matters");
    }
}

#[test]
fn only_examples_that_fold_the_surface_fold_it() {
    let mesh = sheet(50);
    let turned = |field: &[Vec3]| {
        let at = |v: u32| Vec3::from_array(mesh.positions[v as usize]) + field[v as usize];
        let up = |t: &[u32; 3]| (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).z;
        mesh.triangles.iter().filter(|t| up(t) <= 0.0).count()
    };
    for pull in [0.0, 0.3, 0.6, 0.9, 1.5, 3.0] {
        let example = dent(&mesh, [0.0, 0.0], 0.2, [0.0, 0.0, -0.03], pull);
        let own = turned(&scenes::field(&example.positions, mesh.positions.len()));
        assert_eq!(own > 0, pull > 1.0);
        let set = build(mesh.clone(), vec![example], SetOptions::default());
        let at = |x: f32, y: f32| push([x, y, 0.0], [0.0, 0.0, -0.03]);
        assert_eq!(turned(&after(&set, &[at(0.0, 0.0)])), own, "at its own place, pull {pull}");
        let elsewhere = turned(&after(&set, &[at(0.22, 0.16)]));
        assert_eq!(elsewhere > 0, own > 0, "{elsewhere} elsewhere, {own} in the example, pull {pull}");
    }
}

/// Sums of whole steps wrapped around, so the surface bulged outwards. Found by fuzzing.
#[test]
fn thousands_of_hits_at_one_place_do_not_turn_the_dent_inside_out() {
    let mesh = sheet(24);
    let example = dent(&mesh, [0.0, 0.0], 0.3, [0.0, 0.0, -0.05], 0.0);
    let set = build(mesh, vec![example], SetOptions::default());
    let mut instance = new(&set);
    for i in 0..40 {
        let at = [0.03 * (i % 7) as f32 - 0.09, 0.03 * (i / 7) as f32 - 0.09, 0.0];
        instance.submit(&Hit::displacement(at, [0.0, 0.0, -0.04])).unwrap();
    }
    let mut output = Output::new(&set);
    output.update(&mut instance);
    let few = instance.marks().unwrap().to_vec();
    let few_field = displacements(&mut instance);
    let many: Vec<Mark> = few.iter().map(|m| Mark { energy: m.energy * 100_000_000, ..*m }).collect();
    // Blocks that the marks do not reach are summed otherwise now, too.
    for marks in [&many, &few, &many] {
        instance.set_marks(marks).unwrap();
        output.update(&mut instance);
        let field = displacements(&mut instance);
        // Beside a dent its grid may swing by a little.
        assert!(few_field.iter().zip(&field).all(|(few, u)| few.z > -5e-3 || u.z < 0.0), "{field:?}");
        check_sound(&mut instance).unwrap();
        let fresh = Output::fresh(&mut instance);
        assert!((0..set.vertex_count()).all(|v| fresh.bits(v) == output.bits(v)));
    }
}
