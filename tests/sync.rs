//! Damage that travels: the damage of many instances is one piece of bytes, and that of a changed set is mapped. That saved damage leaves
//! the same marks elsewhere is in `promises.rs`.

mod scenes;

use crumple::{
    Error, Instance, InstanceOptions, Mapping, Rule, Serial, ThreadPool, fold_all, load_all, map_damage, save_all,
};
use proptest::prelude::*;
use scenes::{Dice, dented, new, random_hit, with};

fn mismatch(result: Result<(), Error>) -> String {
    match result.unwrap_err() {
        Error::DamageMismatch { what } => what,
        other => panic!("{other}"),
    }
}

proptest! {
    #![proptest_config(scenes::cases(24))]

    /// Instances of several sets and both kinds of rules, folded and loaded on two threads, come back from one piece of bytes; fewer
    /// bytes are refused. `bad_input.rs` flips each bit.
    #[test]
    fn many_instances_are_one_piece_of_bytes(seed: u64, cut: prop::sample::Index) {
        let mut dice = Dice::new(seed);
        let rules = [InstanceOptions::default(), InstanceOptions::classic(Rule::MostDisplaced)];
        let make = |i: usize| with(&scenes::small_bodies()[i % 3].1, rules[i / 3]);
        let mut from: Vec<Instance> = (0..6).map(make).collect();
        let mut alone: Vec<Instance> = (0..6).map(make).collect();
        for (instance, alone) in from.iter().zip(&mut alone) {
            for _ in 0..dice.index(5) {
                let hit = random_hit(instance.example_set(), &mut dice);
                instance.submit(&hit).unwrap();
                alone.submit(&hit).unwrap();
            }
            alone.fold();
        }
        let threads = ThreadPool::new(2).unwrap();
        fold_all(&mut from, &threads);
        let bytes = save_all(&mut from);
        prop_assert!(bytes == save_all(&mut alone));
        let mut to: Vec<Instance> = (0..6).map(make).collect();
        load_all(&mut to.iter_mut().collect::<Vec<_>>(), &bytes, &threads).unwrap();
        for (a, b) in from.iter_mut().zip(&mut to) {
            prop_assert_eq!(a.save(), b.save());
        }
        let mut new: Vec<Instance> = (0..6).map(make).collect();
        let at = cut.index(bytes.len());
        prop_assert!(load_all(&mut new.iter_mut().collect::<Vec<_>>(), &bytes[..at], &Serial).is_err());
    }
}

/// A sheet of `n` by `n` cells, with bowls whose names do not depend on the mesh.
fn patched(n: usize, order: &[usize]) -> std::sync::Arc<crumple::ExampleSet> {
    let mesh = scenes::sheet(n);
    let bowls = order.iter().map(|&i| {
        let point = [[-0.25, -0.25], [0.0, 0.0], [0.25, 0.0]][i];
        let contact = scenes::nearest(&mesh, [point[0], point[1], 0.0]);
        crumple::ExampleData { name: format!("bowl {i}"), ..scenes::bowl(&mesh, contact, 0.04 + 0.02 * i as f32, 0.2) }
    });
    let bowls = bowls.collect();
    scenes::build(mesh, bowls, crumple::SetOptions::default())
}

#[test]
fn quick_damage_of_a_changed_set_is_mapped() {
    let old = patched(32, &[0, 1, 2]);
    let mut body = dented(&old, InstanceOptions::default(), &scenes::random_hits(&old, 30, 7));
    let saved = body.save();
    let count = body.marks().unwrap().len();
    let far = f32::INFINITY;

    // The same set: the same bytes.
    let (same, mapping) = map_damage(&old, &old, &saved, 0.0).unwrap();
    assert_eq!((same, mapping), (saved.clone(), Mapping { kept: count, ..Mapping::default() }));

    // The same examples in another order, on twice as dense a mesh that has all vertices of the old one.
    let dense = patched(64, &[2, 0, 1]);
    assert!(mismatch(new(&dense).load(&saved)).contains("belongs to example set"));
    let (bytes, mapping) = map_damage(&old, &dense, &saved, 0.0).unwrap();
    assert_eq!(mapping, Mapping { kept: count, ..Mapping::default() });
    let mut there = new(&dense);
    there.load(&bytes).unwrap();
    let worst = furthest_apart(&mut body, &mut there);
    // Each mesh has nodes of its own.
    assert!(worst < 0.05 * old.depth_limit(), "{worst}");

    // A mesh without most of the old vertices. No vertex of it is further from an old one than half a cell's diagonal.
    let coarse = patched(24, &[0, 1, 2]);
    let (bytes, mapping) = map_damage(&old, &coarse, &saved, far).unwrap();
    assert_eq!((mapping.kept + mapping.moved, mapping.too_far, mapping.without_blows), (count, 0, 0));
    assert!(mapping.moved > 0 && mapping.distance > 0.0, "{mapping:?}");
    let mut there = new(&coarse);
    there.load(&bytes).unwrap();
    assert_eq!(there.marks().unwrap().len(), count);
    let (_, strict) = map_damage(&old, &coarse, &saved, mapping.distance / 2.0).unwrap();
    assert!(strict.too_far > 0 && strict.kept + strict.moved + strict.too_far == count, "{strict:?}");

    // With fewer examples.
    let fewer = patched(32, &[0, 2]);
    let (bytes, mapping) = map_damage(&old, &fewer, &saved, far).unwrap();
    assert_eq!(mapping.kept, count);
    new(&fewer).load(&bytes).unwrap();

    // Of many instances, those of other sets stay as they are.
    let mut other = new(&fewer);
    let all = save_all([&mut body, &mut other]);
    let (bytes, mapping) = map_damage(&old, &dense, &all, 0.0).unwrap();
    assert_eq!(mapping.kept, count);
    let mut dense_body = new(&dense);
    load_all(&mut [&mut dense_body, &mut other], &bytes, &Serial).unwrap();
    assert_eq!(dense_body.marks().unwrap().len(), count);

    // What does not fit is refused by name.
    assert!(mismatch(map_damage(&dense, &old, &saved, far).map(drop)).contains("belongs to example set"));
    assert!(mismatch(map_damage(&old, &dense, &saved[..40], far).map(drop)).contains("cut short"));
    assert!(mismatch(map_damage(&old, &dense, &all[..60], far).map(drop)).contains("cut short"));
    let classic = with(&old, InstanceOptions::classic(Rule::MostDisplaced)).save();
    assert!(mismatch(map_damage(&old, &dense, &classic, far).map(drop)).contains("kind 2"));
    for wrong in [f32::NAN, -1.0] {
        assert!(map_damage(&old, &dense, &saved, wrong).unwrap_err().to_string().contains("max_distance"));
    }
}

/// The furthest that a vertex of the first body is displaced otherwise than the vertex at the same place of the second.
fn furthest_apart(a: &mut Instance, b: &mut Instance) -> f32 {
    let (ua, ub) = (scenes::displacements(a), scenes::displacements(b));
    let (a, b) = (a.example_set().clone(), b.example_set().clone());
    let there = |p: crumple::glam::Vec3| b.nearest_vertex(p.to_array()).unwrap().vertex as usize;
    a.mesh().positions().iter().zip(&ua).map(|(p, u)| (*u - ub[there(*p)]).length()).fold(0.0, f32::max)
}
