//! Damage that travels: changes since a revision leave the same marks elsewhere, the damage of many instances is one
//! piece of bytes, and bytes that do not fit are refused by name.

mod scenes;

use crumple::{Error, Instance, InstanceOptions, Mark, Rule, load_all, save_all};
use proptest::prelude::*;
use scenes::{Body, Dice, Output, new, push, random_hit};

fn bodies() -> &'static [Body] {
    static BODIES: std::sync::OnceLock<Vec<Body>> = std::sync::OnceLock::new();
    BODIES.get_or_init(scenes::small_bodies)
}

/// Changes the damage in one of the ways that a game does.
fn change(instance: &mut Instance, dice: &mut Dice) {
    let set = instance.example_set().clone();
    match dice.index(12) {
        0 => instance.repair(dice.between(0.0, 1.0)).unwrap(),
        1 => instance.reset(),
        _ => {
            for _ in 0..1 + dice.index(5) {
                instance.submit(&random_hit(&set, dice)).unwrap();
            }
        }
    }
}

fn mismatch(result: Result<(), Error>) -> String {
    match result.unwrap_err() {
        Error::DamageMismatch { what } => what,
        other => panic!("{other}"),
    }
}

proptest! {
    #![proptest_config(scenes::cases(24))]

    /// A copy that is told only changes, each since the revision that it has or had some time ago, has the same marks,
    /// revision and vertices.
    #[test]
    fn changes_leave_the_same_marks_elsewhere(body in 0usize..3, seed: u64, keeps in 1u32..12) {
        let set = &bodies()[body].1;
        let mut dice = Dice::new(seed);
        let options = InstanceOptions { capacity: keeps, ..InstanceOptions::default() };
        let make = || Instance::new(set.clone(), options).unwrap();
        let (mut server, mut client) = (make(), make());
        let mut shown = Output::new(set);
        shown.update(&mut client);
        for _ in 0..20 {
            for _ in 0..1 + dice.index(3) {
                change(&mut server, &mut dice);
                server.fold();
            }
            let since = client.revision();
            client.load(&server.save_changes(since).unwrap()).unwrap();
            prop_assert_eq!(client.marks().unwrap(), server.marks().unwrap());
            prop_assert_eq!(client.revision(), server.revision());
            shown.update(&mut client);
            prop_assert!(shown.all_bits() == Output::fresh(&mut server).all_bits());
        }
    }

    /// Instances of several sets and both kinds of rules come back from one piece of bytes; any other bytes are refused
    /// and change none of them.
    #[test]
    fn many_instances_are_one_piece_of_bytes(seed: u64, cut: prop::sample::Index, flip: u8) {
        let mut dice = Dice::new(seed);
        let rules = [Rule::Marks, Rule::MostDisplaced];
        let make = |i: usize| {
            let options = match rules[i / 3] {
                Rule::Marks => InstanceOptions::default(),
                rule => InstanceOptions::classic(rule),
            };
            Instance::new(bodies()[i % 3].1.clone(), options).unwrap()
        };
        let mut from: Vec<Instance> = (0..6).map(make).collect();
        for instance in &from {
            for _ in 0..dice.index(5) {
                instance.submit(&random_hit(instance.example_set(), &mut dice)).unwrap();
            }
        }
        let bytes = save_all(&mut from);
        let mut to: Vec<Instance> = (0..6).map(make).collect();
        load_all(&mut to.iter_mut().collect::<Vec<_>>(), &bytes).unwrap();
        for (a, b) in from.iter_mut().zip(&mut to) {
            prop_assert_eq!(a.save(), b.save());
        }
        let mut new: Vec<Instance> = (0..6).map(make).collect();
        let at = cut.index(bytes.len());
        prop_assert!(load_all(&mut new.iter_mut().collect::<Vec<_>>(), &bytes[..at]).is_err());
        let mut damaged = bytes.clone();
        damaged[at] ^= flip.max(1);
        if load_all(&mut new.iter_mut().collect::<Vec<_>>(), &damaged).is_err() {
            prop_assert!(new.iter_mut().all(|i| i.save() == Instance::new(i.example_set().clone(), *i.options()).unwrap().save()));
        }
    }
}

#[test]
fn quick_changes_are_short_and_refused_elsewhere() {
    let set = scenes::sheet_set();
    let (mut server, mut client) = (new(&set), new(&set));
    assert_eq!(server.revision(), 0);
    for i in 0..20 {
        server.submit(&push([0.04 * i as f32 - 0.4, 0.0, 0.0], [0.0, 0.0, -0.01])).unwrap();
    }
    let whole = server.save_changes(0).unwrap();
    assert_eq!(whole, server.save(), "a revision that is not remembered takes all marks");
    client.load(&whole).unwrap();
    let before = server.revision();
    assert_eq!(client.revision(), before);
    let unchanged = server.save_changes(before).unwrap();
    assert_eq!(unchanged.len(), 40);
    server.submit(&push([0.3, 0.4, 0.0], [0.0, 0.0, -0.02])).unwrap();
    let changes = server.save_changes(before).unwrap();
    assert_eq!(changes.len(), 40 + size_of::<Mark>());

    // Another revision.
    let mut elsewhere = new(&set);
    let what = mismatch(elsewhere.load(&changes));
    assert!(what.contains(&format!("{before:016x}")) && what.contains("has revision 0000000000000000"), "{what}");
    assert!(elsewhere.marks().unwrap().is_empty());
    // A hit of the client's own.
    client.submit(&push([-0.3, 0.4, 0.0], [0.0, 0.0, -0.02])).unwrap();
    assert!(mismatch(client.load(&changes)).contains("has revision"));
    assert_eq!(client.marks().unwrap().len(), 21);
    client.load(&whole).unwrap();
    // Damaged on the way: another energy, another order.
    let mut damaged = changes.clone();
    damaged[48] ^= 1;
    assert!(mismatch(client.load(&damaged)).contains("instead of"));
    assert_eq!(client.revision(), before);
    client.load(&changes).unwrap();
    assert_eq!(client.save(), server.save());
    // Too many marks.
    let few = InstanceOptions { capacity: 20, ..InstanceOptions::default() };
    let mut few = Instance::new(set.clone(), few).unwrap();
    few.load(&whole).unwrap();
    assert!(mismatch(few.load(&changes)).contains("21 marks; this instance keeps 20"));
    // Other sets and rules.
    assert!(mismatch(new(&scenes::ball_set()).load(&changes)).contains("example set"));
    let mut classic = Instance::new(set, InstanceOptions::classic(Rule::MostDisplaced)).unwrap();
    assert!(mismatch(classic.load(&changes)).contains("kind 3"));
    assert!(matches!(classic.save_changes(0), Err(Error::WrongRule { .. })));
}

#[test]
fn quick_the_memory_of_changes_is_bounded_and_old_revisions_get_everything() {
    let set = scenes::sheet_set();
    let mut server = new(&set);
    server.save_changes(0).unwrap();
    let mut dice = Dice::new(5);
    let mut revisions = Vec::new();
    let mut most = 0;
    for _ in 0..2000 {
        server.submit(&random_hit(&set, &mut dice)).unwrap();
        revisions.push(server.revision());
        most = most.max(server.memory_bytes());
        let _ = server.save_changes(revisions[revisions.len() / 2]);
    }
    assert_eq!(server.save_changes(revisions[0]).unwrap(), server.save());
    let mut plain = new(&set);
    plain.load(&server.save()).unwrap();
    assert!(most < plain.memory_bytes() + 40_000, "{most} bytes");
}
