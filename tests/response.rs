//! What a set makes of blows: its own examples' and harder ones, of known and of unknown strikers.

mod scenes;

use std::num::NonZeroU64;
use std::sync::Arc;

use crumple::glam::{Mat4, Quat, Vec3};
use crumple::{Blow, Contact, ExampleData, ExampleSet, Hit, HitStatus, Instance, MeshData, SetOptions, Space, Striker};
use scenes::{Dice, build, displacements, new};

/// A ball and a sheet without symmetry, with bowls whose blows are known in part: `knows` has bits for the mass with the
/// velocity (1), the impulse (2), the radius (4) and the normal (8).
fn struck(seed: u64, count: usize, knows: u8) -> (MeshData, Vec<ExampleData>) {
    let mut dice = Dice::new(seed);
    let mesh = if seed.is_multiple_of(2) { scenes::ball(2) } else { scenes::sheet(16) };
    let mut examples = scenes::bowls(&mesh, count, 0.3, seed);
    for e in &mut examples {
        let Some(Contact::Vertex(v)) = e.contact else { unreachable!() };
        e.blow = blow(&mut dice, mesh.normals.as_ref().unwrap()[v as usize], knows);
    }
    (mesh, examples)
}

fn blow(dice: &mut Dice, normal: [f32; 3], knows: u8) -> Blow {
    let (along, speed, mass) = (dice.vector(0.3), dice.between(1.0, 20.0), dice.between(1.0, 40.0));
    let velocity = [0, 1, 2].map(|k| speed * (along[k] - normal[k]));
    let radius = dice.between(0.01, 0.2);
    Blow {
        impulse: (knows & 2 != 0).then_some(velocity.map(|v| 1.2 * mass * v)),
        duration: None,
        normal: (knows & 8 != 0).then_some(normal),
        striker: Striker {
            mass: (knows & 1 != 0).then_some(mass),
            velocity: (knows & 1 != 0).then_some(velocity),
            radius: (knows & 4 != 0).then_some(radius),
            ..Default::default()
        },
    }
}

/// The same blow with its impulse and velocity times `factor`.
fn harder(blow: &Blow, factor: f32) -> Blow {
    let times = |v: [f32; 3]| v.map(|x| factor * x);
    let striker = Striker { velocity: blow.striker.velocity.map(times), ..blow.striker };
    Blow { impulse: blow.impulse.map(times), striker, ..*blow }
}

/// Sets with different knowledge and 1 to 70 examples.
fn sets() -> impl Iterator<Item = Arc<ExampleSet>> {
    [(1, 1, 2), (2, 4, 1), (3, 8, 15), (4, 20, 7), (5, 24, 3), (6, 70, 15)].into_iter().map(|(seed, count, knows)| {
        let (mesh, examples) = struck(seed, count, knows);
        build(mesh, examples, SetOptions::default())
    })
}

fn depth(set: &Arc<ExampleSet>, point: [f32; 3], blow: Blow) -> f32 {
    Vec3::from_array(new(set).preview(&Hit::blow(point, blow)).unwrap().target).length()
}

#[test]
fn quick_an_examples_own_blow_gives_the_example() {
    for set in sets() {
        let response = set.response().unwrap();
        for (i, e) in set.examples().iter().enumerate() {
            let contradicted = response.contradictions().iter().any(|(a, b)| [*a as usize, *b as usize].contains(&i));
            // With more than 64 examples, the others are only predicted.
            if contradicted || response.depth_error()[i].is_none() {
                continue;
            }
            let mut instance = new(&set);
            let outcome = instance.submit(&Hit::blow(e.contact_point().to_array(), *e.blow())).unwrap();
            let target = Vec3::from_array(outcome.target).length();
            assert!((target / e.depth() - 1.0).abs() < 1e-4, "{} has {target} instead of {}", e.name(), e.depth());
            let chosen = outcome.chosen.iter().flatten().map(|c| (c.example as usize, c.anchored)).collect::<Vec<_>>();
            assert_eq!(chosen, [(i, true)], "{}", e.name());
            let out = scenes::Output::fresh(&mut instance);
            for (v, base) in set.mesh().positions().iter().enumerate() {
                let off = Vec3::from(out.positions[v]).distance(*base + e.delta(v as u32));
                // Vertices follow nodes.
                assert!(off <= 0.02 * e.depth(), "{}, vertex {v}: {off}", e.name());
            }
        }
    }
}

#[test]
fn a_harder_blow_is_never_shallower() {
    for set in sets() {
        let mut dice = Dice::new(7);
        for _ in 0..60 {
            let vertex = dice.index(set.vertex_count());
            let normal = set.mesh().contact_normal(vertex as u32).unwrap().to_array();
            let any = 1 + dice.index(15) as u8;
            let blow = blow(&mut dice, normal, if any & 3 == 0 { any | 1 } else { any });
            let point = set.mesh().positions()[vertex].to_array();
            let mut last = 0.0;
            for step in -12..=12 {
                let is = depth(&set, point, harder(&blow, 1.4f32.powi(step)));
                assert!(is >= last * (1.0 - 1e-5), "{is} after {last} at vertex {vertex}, step {step}: {blow:?}");
                last = is;
            }
            assert!(last > 0.0);
        }
    }
}

#[test]
fn quick_a_blow_of_zero_leaves_nothing() {
    for set in sets() {
        let e = &set.examples()[0];
        let mut instance = new(&set);
        let outcome = instance.submit(&Hit::blow(e.contact_point().to_array(), harder(e.blow(), 0.0))).unwrap();
        assert_eq!((outcome.status, outcome.mark), (HitStatus::BelowYield, None));
        assert!(displacements(&mut instance).iter().all(|d| *d == Vec3::ZERO));
    }
}

#[test]
fn quick_a_blow_out_of_the_body_leaves_nothing() {
    for set in sets() {
        let e = &set.examples()[0];
        let outward = harder(e.blow(), -1.0);
        let told = new(&set).preview(&Hit::blow(e.contact_point().to_array(), outward)).unwrap();
        assert_eq!((told.status, told.target), (HitStatus::BelowYield, [0.0; 3]));
    }
}

#[test]
fn quick_without_blows_the_formula_is_the_papers() {
    let (mesh, mut examples) = struck(2, 6, 15);
    examples.iter_mut().for_each(|e| e.blow = Blow::default());
    let point = mesh.positions[5];
    let set = build(mesh, examples, SetOptions::default());
    assert!(set.response().is_none());
    let target = new(&set).preview(&Hit::impulse(point, [4.0, 0.0, -8.0], 0.5, Some(100.0))).unwrap().target;
    assert_eq!(target, [0.02, 0.0, -0.04]);
    let error = new(&set).preview(&Hit::blow(point, Blow { duration: None, ..Blow::of_impulse([1.0; 3], 1.0) }));
    assert!(error.unwrap_err().to_string().contains("duration"));
}

#[test]
fn quick_a_radius_that_no_example_knows_changes_nothing() {
    let (mesh, examples) = struck(4, 20, 3);
    let set = build(mesh, examples, SetOptions::default());
    for v in [3, 50, 99] {
        let point = set.mesh().positions()[v].to_array();
        let normal = set.mesh().contact_normal(v as u32).unwrap().to_array();
        let unknown = blow(&mut Dice::new(v as u64), normal, 3);
        let known = Blow { striker: Striker { radius: Some(0.02), ..unknown.striker }, ..unknown };
        assert_eq!(depth(&set, point, unknown), depth(&set, point, known));
    }
}

#[test]
fn the_order_of_examples_does_not_matter() {
    for (seed, count, knows) in [(2, 6, 15), (3, 20, 3), (4, 40, 7)] {
        let (mesh, examples) = struck(seed, count, knows);
        let mut dice = Dice::new(seed);
        let mut other = examples.clone();
        dice.shuffle(&mut other);
        let (a, b) =
            (build(mesh.clone(), examples, SetOptions::default()), build(mesh.clone(), other, SetOptions::default()));
        for _ in 0..80 {
            let vertex = dice.index(mesh.positions.len());
            let blow = blow(&mut dice, mesh.normals.as_ref().unwrap()[vertex], knows);
            let hit = Hit::blow(mesh.positions[vertex], blow);
            let targets = [&a, &b].map(|set| Vec3::from_array(new(set).preview(&hit).unwrap().target));
            let off = (targets[0] - targets[1]).length();
            assert!(off <= 1e-5 * (targets[0].length() + a.depth_limit()), "{targets:?}");
        }
    }
}

#[test]
fn quick_contradictions_are_reported() {
    let (mesh, mut examples) = struck(3, 9, 15);
    let blows = [examples[4].blow, harder(&examples[4].blow, 1.5)];
    let Some(Contact::Vertex(at)) = examples[4].contact else { unreachable!() };
    let deepest = scenes::bowl(&mesh, at, 0.2, 0.3);
    let shallow = scenes::bowl(&mesh, at, 0.05, 0.3);
    examples[4] = ExampleData { blow: blows[0], ..deepest };
    examples.push(ExampleData { blow: blows[1], ..shallow });
    let set = build(mesh.clone(), examples.clone(), SetOptions::default());
    assert_eq!(set.response().unwrap().contradictions(), [(9, 4)]);
    // the other way round they agree
    (examples[4].blow, examples[9].blow) = (blows[1], blows[0]);
    let set = build(mesh, examples, SetOptions::default());
    assert!(set.response().unwrap().contradictions().is_empty());
}

#[test]
fn quick_a_blow_in_world_space_is_that_in_the_meshs_space() {
    for set in sets() {
        let to_world = Mat4::from_scale_rotation_translation(
            Vec3::splat(1.0),
            Quat::from_rotation_y(0.7) * Quat::from_rotation_x(1.1),
            Vec3::new(3.0, -2.0, 1.0),
        );
        let instance = new(&set);
        instance.set_transform(to_world).unwrap();
        let mut dice = Dice::new(9);
        for _ in 0..20 {
            let vertex = dice.index(set.vertex_count());
            let normal = set.mesh().contact_normal(vertex as u32).unwrap().to_array();
            let blow = blow(&mut dice, normal, 15);
            let local = Hit::blow(set.mesh().positions()[vertex].to_array(), blow);
            let turn = |v: [f32; 3]| to_world.transform_vector3(Vec3::from_array(v)).to_array();
            let world = Hit {
                point: to_world.transform_point3(Vec3::from_array(local.point)).to_array(),
                space: Space::World,
                ..Hit::blow(local.point, blow_turned(&blow, turn))
            };
            let [a, b] = [local, world].map(|h| instance.preview(&h).unwrap());
            assert_eq!(a.contact_vertex, b.contact_vertex);
            let [a, b] = [a, b].map(|o| Vec3::from_array(o.target));
            assert!((a - b).length() <= 1e-4 * (a.length() + 0.1 * set.depth_limit()), "{a} in the mesh's space, {b}");
        }
    }
}

fn blow_turned(blow: &Blow, turn: impl Fn([f32; 3]) -> [f32; 3]) -> Blow {
    let striker = Striker { velocity: blow.striker.velocity.map(&turn), ..blow.striker };
    Blow { impulse: blow.impulse.map(&turn), normal: blow.normal.map(&turn), striker, ..*blow }
}

#[test]
fn quick_a_contact_in_parts_is_the_whole_blow() {
    let id = NonZeroU64::new(5).unwrap();
    for set in sets() {
        let mut dice = Dice::new(11);
        for _ in 0..12 {
            let vertex = dice.index(set.vertex_count());
            let normal = set.mesh().contact_normal(vertex as u32).unwrap().to_array();
            let any = dice.index(16) as u8;
            let blow = blow(&mut dice, normal, any | 2);
            let point = set.mesh().positions()[vertex].to_array();
            let marks = |parts: usize| {
                let mut instance: Instance = new(&set);
                let part = Blow { impulse: blow.impulse.map(|j| j.map(|x| x / parts as f32)), ..blow };
                for _ in 0..parts {
                    instance.submit(&Hit::blow(point, part).of_contact(id)).unwrap();
                    instance.fold();
                }
                instance.end_contact(id).unwrap();
                instance.fold();
                instance.marks().unwrap().to_vec()
            };
            let mut separate = new(&set);
            separate.submit(&Hit::blow(point, blow)).unwrap();
            separate.fold();
            let whole = separate.marks().unwrap().to_vec();
            for parts in [1, 3, 8] {
                let is = marks(parts);
                assert_eq!(is.len(), whole.len(), "{parts} parts");
                for (a, b) in is.iter().zip(&whole) {
                    assert_eq!(a.contact, b.contact);
                    assert!((a.depth / b.depth - 1.0).abs() < 1e-4, "{parts} parts: {a:?} instead of {b:?}");
                }
            }
        }
    }
}
