//! Contacts reported in parts leave the same dent at any frame rate, whole or split, and among other hits.

mod scenes;

use crumple::{Blow, Cause, Error, Hit, HitStatus, Instance, InstanceOptions, Mark};
use proptest::prelude::*;
use scenes::{Dice, Output, dented, push, random_hit, with};
use std::num::NonZeroU64;

fn id(n: u64) -> NonZeroU64 {
    NonZeroU64::new(n).unwrap()
}

/// Asserts equal contacts and energies, and depths and hits that are equal up to rounding.
fn assert_alike(a: &[Mark], b: &[Mark]) {
    assert_eq!(a.len(), b.len(), "{a:?}\n{b:?}");
    for (x, y) in a.iter().zip(b) {
        assert_eq!((x.contact, x.energy), (y.contact, y.energy));
        assert!((x.depth - y.depth).abs() <= 1e-6 * x.depth, "{} {}", x.depth, y.depth);
        assert_eq!((x.told, x.striker), (y.told, y.striker));
        let numbers = |m: &Mark| [m.direction[0], m.direction[1], m.strength, m.mass, m.radius];
        assert!(numbers(x).iter().zip(numbers(y)).all(|(a, b)| a.abs_diff(b) <= 1), "{x:?} {y:?}");
    }
}

fn scaled(hit: &Hit, factor: f64) -> Hit {
    let by = |v: [f32; 3]| v.map(|x| (f64::from(x) * factor) as f32);
    let cause = match hit.cause {
        Cause::Displacement(d) => Cause::Displacement(by(d)),
        Cause::Impulse { blow, mass } => Cause::Impulse { blow: Blow { impulse: blow.impulse.map(by), ..blow }, mass },
    };
    Hit { cause, ..*hit }
}

#[test]
fn quick_the_point_is_the_mean_weighted_by_depth() {
    let set = scenes::sheet_set();
    let mut instance = with(&set, InstanceOptions::default());
    instance.submit(&push([-0.3, 0.0, 0.0], [0.0, 0.0, -0.01]).of_contact(id(1))).unwrap();
    instance.submit(&push([0.1, 0.0, 0.0], [0.0, 0.0, -0.03]).of_contact(id(1))).unwrap();
    let mut whole = with(&set, InstanceOptions::default());
    whole.submit(&push([0.0, 0.0, 0.0], [0.0, 0.0, -0.04])).unwrap();
    assert_alike(instance.marks().unwrap(), whole.marks().unwrap());
}

#[test]
fn quick_yield_thresholds_hold_for_a_hit_and_for_the_sum_of_a_contact() {
    let set = scenes::sheet_set();
    let options = InstanceOptions { yield_impulse: 5.0, yield_displacement: 0.01, ..InstanceOptions::default() };
    let mut instance = with(&set, options);
    let impulse = |j: f32| Hit::impulse([0.0; 3], [0.0, 0.0, -j], 0.1, Some(10.0));
    let pushed = |depth: f32| push([0.0; 3], [0.0, 0.0, -depth]);
    for (weak, strong) in [(impulse(4.9), impulse(5.1)), (pushed(0.0099), pushed(0.0101))] {
        let outcome = instance.submit(&weak).unwrap();
        assert_eq!((outcome.status, outcome.achieved, outcome.mark), (HitStatus::BelowYield, [0.0; 3], None));
        assert_eq!(outcome.shortfall(), outcome.target);
        assert_eq!(instance.submit(&strong).unwrap().status, HitStatus::Marked);
    }
    assert_eq!(instance.marks().unwrap().len(), 2);
    instance.reset();
    for n in 1..=10 {
        let alone = instance.submit(&impulse(1.0).of_contact(id(1))).unwrap();
        assert_eq!((alone.status, alone.mark), (HitStatus::Accumulated, None));
        let whole = instance.contact(id(1)).unwrap();
        assert_eq!(whole.is_some_and(|w| w.status == HitStatus::Marked), n >= 5, "after {n} N s");
        assert_eq!(whole.and_then(|w| w.mark), instance.marks().unwrap().first().copied());
        assert_eq!(instance.marks().unwrap().len(), usize::from(n >= 5), "after {n} N s");
    }
    // Pushes that cancel leave nothing, though each alone would leave a dent.
    instance.reset();
    for depth in [0.03, -0.03] {
        instance.submit(&pushed(depth).of_contact(id(2))).unwrap();
    }
    assert!(instance.marks().unwrap().is_empty());
}

/// Bug: a body without a buffer was folded only once in many frames, and took successive contacts with one id for a
/// single contact.
#[test]
fn quick_contacts_do_not_depend_on_when_a_body_is_read() {
    let set = scenes::sheet_set();
    let (mut seen, mut unseen) = (with(&set, InstanceOptions::default()), with(&set, InstanceOptions::default()));
    for _ in 0..5 {
        for body in [&seen, &unseen] {
            body.submit(&push([0.1, 0.1, 0.0], [0.0, 0.0, -0.01]).of_contact(id(11))).unwrap();
            body.end_contact(id(11)).unwrap();
        }
        seen.fold();
    }
    assert_eq!(seen.marks().unwrap()[0].energy, 5 * Mark::ONE);
    assert_eq!(seen.save(), unseen.save());
}

#[test]
fn quick_the_result_of_a_contact_outlives_it() {
    let set = scenes::sheet_set();
    let mut body = with(&set, InstanceOptions { yield_displacement: 0.005, ..InstanceOptions::default() });
    let part = |depth: f32| push([0.1, 0.1, 0.0], [0.0, 0.0, -depth]).of_contact(id(1));
    for depth in [0.01, 0.02] {
        body.submit(&part(depth)).unwrap();
    }
    body.end_contact(id(1)).unwrap();
    let whole = body.contact(id(1)).unwrap().expect("it ended just now");
    let alone = body.preview(&push([0.1, 0.1, 0.0], [0.0, 0.0, -0.03])).unwrap();
    assert!((whole.target[2] + 0.03).abs() < 1e-6 && whole.status == HitStatus::Marked);
    assert_alike(&[whole.mark.unwrap()], &[alone.mark.unwrap()]);
    assert_eq!(whole.mark, Some(body.marks().unwrap()[0]));
    // The id is used again: first the open contact counts, then the one that ended last.
    body.submit(&part(0.001)).unwrap();
    assert_eq!(body.contact(id(1)).unwrap().map(|o| o.status), Some(HitStatus::BelowYield));
    body.reset();
    assert_eq!(body.contact(id(1)).unwrap().map(|o| o.status), Some(HitStatus::BelowYield));
    // So many are remembered.
    body.submit(&part(0.02)).unwrap();
    body.end_contact(id(1)).unwrap();
    for n in 2..=Instance::MAX_CONTACTS as u64 {
        body.submit(&Hit { contact: Some(id(n)), ..part(0.01) }).unwrap();
        body.end_contact(id(n)).unwrap();
    }
    assert_eq!(body.contact(id(1)).unwrap().map(|o| o.status), Some(HitStatus::Marked));
    body.submit(&Hit { contact: Some(id(999)), ..part(0.01) }).unwrap();
    body.end_contact(id(999)).unwrap();
    assert_eq!(body.contact(id(1)), Err(Error::UnknownContact { id: 1 }));
}

#[test]
fn quick_compliance_replaces_mass_and_duration() {
    let set = scenes::sheet_set();
    let soft = with(&set, InstanceOptions { compliance: Some(0.02), ..InstanceOptions::default() });
    let hit = Hit::blow([0.1, 0.1, 0.0], Blow { impulse: Some([0.0, 0.0, -1.5]), ..Blow::default() });
    assert!((soft.preview(&hit).unwrap().target[2] + 0.03).abs() < 1e-7);
    let by_mass = Hit::impulse([0.1, 0.1, 0.0], [0.0, 0.0, -1.5], 0.01, Some(0.5));
    let hard = with(&set, InstanceOptions::default());
    assert!((hard.preview(&by_mass).unwrap().target[2] + 0.03).abs() < 1e-7);
    assert_eq!(soft.preview(&by_mass).unwrap().mark, soft.preview(&hit).unwrap().mark);
    assert!(hard.preview(&hit).unwrap_err().to_string().contains("duration"));
}

#[test]
fn quick_replacing_or_repairing_damage_ends_contacts_and_forgets_hits_that_wait() {
    let set = scenes::sheet_set();
    let part = push([0.1, 0.1, 0.0], [0.0, 0.0, -0.01]).of_contact(id(3));
    let waits = push([-0.3, 0.2, 0.0], [0.0, 0.0, -0.02]);
    let mut other = dented(&set, InstanceOptions::default(), &[push([0.3, 0.3, 0.0], [0.0, 0.0, -0.02]); 2]);
    let (saved, marks) = (other.save(), other.marks().unwrap().to_vec());
    // Each with the marks that it leaves: those of the other body, or how many of its own, of which the first is the contact's.
    type End<'a> = (&'a str, &'a dyn Fn(&mut Instance, &mut Instance), Option<usize>);
    let ends: [End<'_>; 6] = [
        ("load", &|i, _| i.load(&saved).unwrap(), None),
        ("set_marks", &|i, _| i.set_marks(&marks).unwrap(), None),
        ("copy", &|i, other| i.copy_damage_from(other).unwrap(), None),
        ("reset", &|i, _| i.reset(), Some(0)),
        ("repair", &|i, _| i.repair(0.5).unwrap(), Some(2)),
        ("end_contact", &|i, _| i.end_contact(id(3)).unwrap(), Some(2)),
    ];
    for (name, end, own) in ends {
        let mut instance = with(&set, InstanceOptions::default());
        instance.submit(&part).unwrap();
        assert_eq!((instance.contact_count(), instance.marks().unwrap().len()), (1, 1));
        instance.submit(&waits).unwrap();
        end(&mut instance, &mut other);
        assert_eq!(instance.contact_count(), 0, "{name}");
        let left = instance.marks().unwrap().to_vec();
        assert!(own.map_or(left == marks, |own| left.len() == own), "{name}: {left:?}");
        // The same id begins another dent, so energies add; later hits are not lost.
        instance.submit(&part).unwrap();
        let energy = |marks: &[Mark]| marks.iter().map(|m| m.energy).sum::<u64>();
        assert_eq!(energy(instance.marks().unwrap()), energy(&left) + Mark::ONE, "{name}");
        assert_eq!(instance.contact_count(), 1);
    }
}

#[test]
fn the_oldest_contact_ends_when_there_are_too_many() {
    let set = scenes::sheet_set();
    let mut dice = Dice::new(3);
    let mut instance = with(&set, InstanceOptions { capacity: 1000, ..InstanceOptions::default() });
    let hit = random_hit(&set, &mut dice);
    for n in 0..2 * Instance::MAX_CONTACTS as u64 {
        instance.submit(&hit.of_contact(id(1 + n))).unwrap();
        // The first contact is hit again and again, so it stays open.
        instance.submit(&scaled(&hit, 1e-3).of_contact(id(1))).unwrap();
        assert!(instance.contact_count() <= Instance::MAX_CONTACTS);
    }
    assert_eq!(instance.contact_count(), Instance::MAX_CONTACTS);
    let energy = |i: &mut Instance| i.marks().unwrap().iter().map(|m| m.energy).sum::<u64>();
    assert_eq!(energy(&mut instance), 2 * Instance::MAX_CONTACTS as u64 * Mark::ONE);
    // If the first contact had ended, this hit would make a separate dent.
    instance.submit(&hit.of_contact(id(1))).unwrap();
    assert_eq!(energy(&mut instance), 2 * Instance::MAX_CONTACTS as u64 * Mark::ONE);
}

#[test]
fn quick_an_unknown_contact_is_an_error_that_names_it() {
    let mut instance = with(&scenes::sheet_set(), InstanceOptions::default());
    let hit = |n| push([0.1, 0.1, 0.0], [0.0, 0.0, -0.01]).of_contact(id(n));
    let unknown = |n| Err(Error::UnknownContact { id: n });
    assert_eq!(instance.end_contact(id(5)), unknown(5));
    assert!(instance.end_contact(id(5)).unwrap_err().to_string().starts_with("contact_id is 5"));
    assert_eq!(instance.contact(id(5)), Err(Error::UnknownContact { id: 5 }));
    assert_eq!((instance.contact_count(), instance.marks().unwrap().len()), (0, 0));
    // Hits begin it, also before they are folded. It ends once.
    instance.submit(&hit(5)).unwrap();
    instance.end_contact(id(5)).unwrap();
    assert_eq!(instance.end_contact(id(5)), unknown(5));
    assert_eq!(instance.marks().unwrap().len(), 1);
    // What ended by itself may be ended once.
    instance.submit(&hit(5)).unwrap();
    instance.reset();
    instance.end_contact(id(5)).unwrap();
    assert_eq!(instance.end_contact(id(5)), unknown(5));
    assert_eq!((instance.contact_count(), instance.marks().unwrap().len()), (0, 0));
}

#[test]
fn contacts_that_nobody_ends_are_forgotten_at_last() {
    let mut instance = with(&scenes::sheet_set(), InstanceOptions::default());
    let hit = push([0.1, 0.1, 0.0], [0.0, 0.0, -0.01]);
    let most = 16 * Instance::MAX_CONTACTS as u64;
    for first in (1..=2 * most).step_by(128) {
        (first..first + 128).for_each(|n| _ = instance.submit(&hit.of_contact(id(n))).unwrap());
        instance.fold();
    }
    assert_eq!(instance.end_contact(id(1)), Err(Error::UnknownContact { id: 1 }));
    instance.end_contact(id(2 * most)).unwrap(); // still open
}

proptest! {
    #![proptest_config(scenes::cases(24))]

    /// Many contacts at once, each split at random over random frames, as at any frame rate, among other hits. The marks are those of the
    /// whole contacts as long as none merge. In any order within the frames they have the same bits, merged or not.
    #[test]
    fn contacts_in_parts_are_contacts_reported_whole(
        which in 0..3usize, contacts in 1usize..12, singles in 0usize..6,
        frames in 1usize..9, capacity in prop_oneof![Just(3u32), Just(64)], seed in any::<u64>(),
    ) {
        let set = &scenes::small_bodies().swap_remove(which).1;
        let mut dice = Dice::new(seed);
        let options = InstanceOptions { capacity, ..InstanceOptions::default() };
        let (mut whole, mut split, mut turned) = (with(set, options), with(set, options), with(set, options));
        let (mut by_frame, mut out) = (vec![Vec::new(); frames], Output::new(set));
        for c in 0..contacts {
            let mut hit = random_hit(set, &mut dice);
            if let (Cause::Displacement(d), 0) = (hit.cause, dice.index(2)) {
                hit.cause = Cause::Impulse { blow: Blow::of_impulse(d.map(|x| x * 100.0), 0.01), mass: Some(1.0) };
            }
            whole.submit(&hit.of_contact(id(1 + c as u64))).unwrap();
            let cuts = 1 + dice.index(20);
            let weights: Vec<f64> = (0..cuts).map(|_| f64::from(dice.between(0.01, 1.0))).collect();
            let sum: f64 = weights.iter().sum();
            for w in weights {
                by_frame[dice.index(frames)].push(scaled(&hit, w / sum).of_contact(id(1 + c as u64)));
            }
        }
        for _ in 0..singles {
            let hit = random_hit(set, &mut dice);
            whole.submit(&hit).unwrap();
            by_frame[0].push(hit);
        }
        for hits in &by_frame {
            for hit in hits {
                split.submit(hit).unwrap();
            }
            for hit in hits.iter().rev() {
                turned.submit(hit).unwrap();
            }
            prop_assert!(split.marks().unwrap().len() <= capacity as usize);
            out.update(&mut split);
            prop_assert!(exact(split.marks().unwrap()) == exact(turned.marks().unwrap()));
        }
        if capacity == 64 {
            assert_alike(split.marks().unwrap(), whole.marks().unwrap());
        }
        for c in (0..contacts).rev() {
            split.end_contact(id(1 + c as u64)).unwrap();
            turned.end_contact(id(contacts as u64 - c as u64)).unwrap();
        }
        prop_assert!(exact(split.marks().unwrap()) == exact(turned.marks().unwrap()));
        prop_assert_eq!(split.contact_count(), 0);
        out.update(&mut split);
        prop_assert!(out.all_bits() == Output::fresh(&mut split).all_bits(), "a replaced mark left something behind");
        scenes::check_sound(&mut split)?;
    }
}

fn exact(marks: &[Mark]) -> Vec<(Vec<u8>, u64)> {
    marks.iter().map(|m| (scenes::key(m), m.energy)).collect()
}
