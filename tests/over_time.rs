//! Repair around a point, and dents that grow over time: functions of the marks, and of times that the caller gives. `promises.rs` does both
//! in any sequence.

mod scenes;

use crumple::{Instance, InstanceOptions};
use proptest::prelude::*;
use scenes::{Dice, Output, dented, displacements, push, random_hit, random_hits, with};

proptest! {
    #![proptest_config(scenes::cases(24))]

    /// Repair around a point leaves marks outside its radius as they are, and makes no dent inside deeper.
    #[test]
    fn repair_around_a_point_is_local(body in 0usize..3, seed: u64, radius in 0.05f32..1.0, keep in 0.0f32..=1.0) {
        let set = &scenes::small_bodies().swap_remove(body).1;
        let at = set.mesh().positions()[Dice::new(seed).index(set.vertex_count())];
        let mut instance = dented(set, InstanceOptions::default(), &random_hits(set, 20, seed));
        let before = instance.marks().unwrap().to_vec();
        instance.repair_around(at.to_array(), radius, keep).unwrap();
        let after = instance.marks().unwrap();
        for mark in &before {
            let is_inside = (set.mesh().positions()[mark.contact as usize] - at).length() < radius;
            match after.iter().find(|m| scenes::key(m) == scenes::key(mark)) {
                Some(now) if is_inside => prop_assert!(now.energy <= mark.energy),
                Some(now) => prop_assert_eq!(now, mark),
                None => prop_assert!(is_inside && keep < 1.0),
            }
        }
    }
}

#[test]
fn quick_a_dent_grows_evenly_and_pops_out_again() {
    let set = scenes::sheet_set();
    let mut body = with(&set, InstanceOptions { grow_time: 0.1, ..InstanceOptions::default() });
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
