//! Repair around a point, and dents that grow over time: functions of the marks, and of times that the caller gives.

mod scenes;

use crumple::{Instance, InstanceOptions, Mark};
use proptest::prelude::*;
use scenes::{Dice, Output, dented, displacements, new, push, random_hit, random_hits, with};

fn contact(instance: &Instance, mark: &Mark) -> crumple::glam::Vec3 {
    instance.example_set().mesh().positions()[mark.contact as usize]
}

fn growing(set: &std::sync::Arc<crumple::ExampleSet>, grow_time: f32) -> Instance {
    with(set, InstanceOptions { grow_time, ..InstanceOptions::default() })
}

proptest! {
    #![proptest_config(scenes::cases(24))]

    /// Repair around a point leaves marks outside its radius as they are, makes no dent inside deeper, and does not
    /// depend on the order of hits or on saving in between.
    #[test]
    fn repair_around_a_point_is_local_and_canonical(body in 0usize..3, seed: u64, radius in 0.05f32..1.0, keep in 0.0f32..=1.0) {
        let set = &scenes::small_bodies().swap_remove(body).1;
        let mut dice = Dice::new(seed);
        let mut hits = random_hits(set, 20, seed);
        let at = set.mesh().positions()[dice.index(set.vertex_count())];
        let mut instance = dented(set, InstanceOptions::default(), &hits);
        let before = instance.marks().unwrap().to_vec();
        let mut out = Output::new(set);
        out.update(&mut instance);
        let saved = instance.save();
        instance.repair_around(at.to_array(), radius, keep).unwrap();
        out.update(&mut instance);
        prop_assert!(out.all_bits() == Output::fresh(&mut instance).all_bits());

        let after = instance.marks().unwrap().to_vec();
        let is_inside = |m: &Mark| (contact(&new(set), m) - at).length() < radius;
        for mark in &before {
            let now = after.iter().find(|m| scenes::key(m) == scenes::key(mark));
            match now {
                Some(now) if is_inside(mark) => prop_assert!(now.energy <= mark.energy),
                Some(now) => prop_assert_eq!(now, mark),
                None => prop_assert!(is_inside(mark) && keep < 1.0),
            }
        }
        dice.shuffle(&mut hits);
        let mut other = dented(set, InstanceOptions::default(), &hits);
        other.repair_around(at.to_array(), radius, keep).unwrap();
        prop_assert_eq!(other.save(), instance.save());
        let mut loaded = new(set);
        loaded.load(&saved).unwrap();
        loaded.repair_around(at.to_array(), radius, keep).unwrap();
        prop_assert_eq!(loaded.save(), instance.save());
    }

    /// Whatever happens at whatever times: marks are those of an instance whose dents do not grow, vertices are the same
    /// in changed blocks as in all, and once the time has passed they are those of the other instance.
    #[test]
    fn what_grows_is_complete_in_the_end(body in 0usize..3, seed: u64) {
        let set = &scenes::small_bodies().swap_remove(body).1;
        let mut dice = Dice::new(seed);
        let (mut slow, mut plain) = (growing(set, 0.05), new(set));
        let mut out = Output::new(set);
        let mut time = f64::from(dice.between(-1e3, 1e3));
        for _ in 0..12 {
            slow.set_time(time).unwrap();
            match dice.index(5) {
                0 => {
                    let keep = dice.between(0.0, 1.0);
                    let _ = [&mut slow, &mut plain].map(|i| i.repair(keep).unwrap());
                }
                1 => {
                    let (at, keep) = (dice.vector(0.5), dice.between(0.0, 1.0));
                    let _ = [&mut slow, &mut plain].map(|i| i.repair_around(at, 0.4, keep).unwrap());
                }
                _ => {
                    let hit = random_hit(set, &mut dice);
                    let _ = [&mut slow, &mut plain].map(|i| i.submit(&hit).unwrap());
                }
            }
            out.update(&mut slow);
            prop_assert!(out.all_bits() == Output::fresh(&mut slow).all_bits());
            prop_assert_eq!(slow.save(), plain.save());
            time += f64::from(dice.between(0.0, 0.06));
        }
        slow.set_time(time + 0.1).unwrap();
        out.update(&mut slow);
        prop_assert!(out.all_bits() == Output::fresh(&mut plain).all_bits());
        prop_assert!(slow.memory_bytes() == plain.memory_bytes(), "nothing is kept");
        // More time changes nothing.
        slow.set_time(time + 0.2).unwrap();
        prop_assert_eq!(out.update(&mut slow).blocks_written, 0);
    }
}

#[test]
fn quick_a_dent_grows_evenly_and_pops_out_again() {
    let set = scenes::sheet_set();
    let mut body = growing(&set, 0.1);
    body.set_time(7.0).unwrap();
    let hit = push([0.1, 0.1, 0.0], [0.0, 0.0, -0.04]);
    let told = body.submit(&hit).unwrap();
    let at_contact = |body: &mut Instance| -displacements(body)[told.contact_vertex as usize].z;
    let lamp = set.attach(set.mesh().positions()[told.contact_vertex as usize].to_array()).unwrap();
    for (time, depth) in [(7.0, 0.0), (7.025, 0.01), (7.075, 0.03), (7.05, 0.02), (7.1, 0.04), (9.0, 0.04)] {
        body.set_time(time).unwrap();
        assert!((at_contact(&mut body) - depth).abs() < 1e-5, "{} at {time}", at_contact(&mut body));
        assert!((body.attached_pose(&lamp).unwrap().position[2] + depth).abs() < 1e-5, "the lamp at {time}");
        assert!((body.marks().unwrap()[0].depth - 0.04).abs() < 1e-6);
    }
    body.repair(0.0).unwrap();
    assert!(body.marks().unwrap().is_empty());
    for (time, depth) in [(9.0, 0.04), (9.05, 0.02), (9.1, 0.0)] {
        body.set_time(time).unwrap();
        assert!((at_contact(&mut body) - depth).abs() < 1e-5, "{} at {time}", at_contact(&mut body));
    }
    // What is loaded or reset does not grow.
    body.submit(&hit).unwrap();
    let saved = body.save();
    body.reset();
    assert_eq!(at_contact(&mut body), 0.0);
    body.load(&saved).unwrap();
    assert!((at_contact(&mut body) - 0.04).abs() < 1e-5);
}

#[test]
fn quick_more_dents_than_can_grow_are_complete_at_once() {
    let set = scenes::sheet_set();
    let options = InstanceOptions { grow_time: 1.0, capacity: 1000, ..InstanceOptions::default() };
    let (mut body, mut plain) = (with(&set, options), with(&set, InstanceOptions { grow_time: 0.0, ..options }));
    let mut out = Output::new(&set);
    out.update(&mut body);
    let mut dice = Dice::new(3);
    for (frame, count) in [200, 200, 0, 50].into_iter().enumerate() {
        body.set_time(0.2 * frame as f64).unwrap();
        for _ in 0..count {
            let hit = random_hit(&set, &mut dice);
            for instance in [&body, &plain] {
                instance.submit(&hit).unwrap();
            }
        }
        out.update(&mut body);
        assert!(out.all_bits() == Output::fresh(&mut body).all_bits(), "frame {frame}");
    }
    body.set_time(9.0).unwrap();
    out.update(&mut body);
    assert!(out.all_bits() == Output::fresh(&mut plain).all_bits());
}
