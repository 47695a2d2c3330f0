//! Compares every rule of the library with a naive f64 implementation (`oracle`), on random sets and on the solver's bodies.

mod oracle;
mod scenes;

use std::sync::Arc;

use crumple::glam::{DVec3, Vec3};
use crumple::{
    BasisOptions, Contact, Deltas, ExampleData, ExampleSet, Hit, HitStatus, Instance, InstanceOptions, Mark, MeshData,
    Rule, Selection, SetOptions,
};
use oracle::damage::Ledger;
use oracle::marks::{Limit, Shown};
use proptest::prelude::*;
use scenes::{Dice, Output, build, every_node, new, with};

/// A random set: a bumpy sheet, ball or cube, with smooth and ragged examples, some without a given contact. There is a node at each
/// vertex.
fn random_set(dice: &mut Dice) -> Arc<ExampleSet> {
    let (mesh, examples, options) = random_data(dice);
    build(mesh, examples, every_node(options))
}

fn random_data(dice: &mut Dice) -> (MeshData, Vec<ExampleData>, SetOptions) {
    let mut mesh = match dice.index(3) {
        0 => scenes::sheet(6 + dice.index(8)),
        1 => scenes::ball(2),
        _ => scenes::cube(4),
    };
    bump(&mut mesh, dice);
    // small bowls do not move rims, and a set learns from many of them
    let (count, radius) = [(1 + dice.index(6), 0.4), (8 + dice.index(6), 0.25)][dice.index(3) / 2];
    let mut examples = scenes::bowls(&mesh, count, radius, dice.next());
    if dice.index(3) == 0 {
        examples.retain(|e| inside(&mesh, e));
    }
    if examples.is_empty() {
        let middle = scenes::nearest(&mesh, [0.0, 0.0, 0.5]);
        examples.push(scenes::bowl(&mesh, middle, 0.1, 0.35));
    }
    for e in &mut examples {
        lean(e, dice);
    }
    if dice.index(2) == 0 {
        examples.push(ragged(&mesh, dice));
    }
    for e in &mut examples {
        if dice.index(3) == 0 {
            e.contact = None;
        } else if dice.index(3) == 0 {
            let Some(Contact::Vertex(v)) = e.contact else { continue };
            let p = mesh.positions[v as usize];
            e.contact = Some(Contact::Point([p[0] + 0.001, p[1], p[2]]));
        }
    }
    let depth_limit = (dice.index(2) == 0).then(|| dice.between(0.02, 0.5));
    let (mirror, held_rims) = (dice.index(4) != 0, dice.index(6) != 0);
    let options = SetOptions { depth_limit, mirror, held_rims, ..Default::default() };
    (mesh, examples, options)
}

/// Whether an example does not move the sides of the sheet.
fn inside(mesh: &MeshData, e: &ExampleData) -> bool {
    let Deltas::Sparse { indices, .. } = &e.positions else { return false };
    indices.iter().all(|v| mesh.positions[*v as usize][..2].iter().all(|x| x.abs() < 0.48))
}

fn f64s(v: [f32; 3]) -> DVec3 {
    Vec3::from(v).as_dvec3()
}

/// Adds a small sideways displacement to an example, so that it leans.
fn lean(e: &mut ExampleData, dice: &mut Dice) {
    let Deltas::Sparse { values, .. } = &mut e.positions else { return };
    let along = dice.vector(0.2);
    for u in values {
        let size = scenes::length(*u);
        *u = [0, 1, 2].map(|k| u[k] + along[k] * size);
    }
}

/// Moves every position a little, coincident vertices together, and removes the normals so that they are computed.
fn bump(mesh: &mut MeshData, dice: &mut Dice) {
    if dice.index(2) == 0 {
        return;
    }
    let seed = dice.next();
    for p in &mut mesh.positions {
        let bits = p.iter().fold(seed, |h, x| h.rotate_left(21) ^ u64::from((x + 0.0).to_bits()));
        let shift = Dice::new(bits).vector(0.01);
        *p = [0, 1, 2].map(|k| p[k] + shift[k]);
    }
}

/// Unrelated displacements of a random third of the vertices. Coincident vertices disagree.
fn ragged(mesh: &MeshData, dice: &mut Dice) -> ExampleData {
    let (mut indices, mut values) = (Vec::new(), Vec::new());
    for v in 0..mesh.positions.len() as u32 {
        if dice.index(3) == 0 {
            indices.push(v);
            values.push(dice.vector(0.1));
        }
    }
    if indices.is_empty() {
        (indices, values) = (vec![0], vec![[0.0, 0.0, -0.1]]);
    }
    ExampleData::new("ragged", Deltas::Sparse { indices, values })
}

/// What each example moves each vertex by, m: vertices at one place by their mean.
fn given(mesh: &MeshData, examples: &[ExampleData]) -> Vec<Vec<DVec3>> {
    let groups = scenes::coincident(&mesh.positions);
    let one = |e: &ExampleData| {
        let mut field: Vec<DVec3> =
            scenes::field(&e.positions, mesh.positions.len()).iter().map(|u| u.as_dvec3()).collect();
        for group in &groups {
            let mean = group.iter().map(|v| field[*v]).sum::<DVec3>() / group.len() as f64;
            group.iter().for_each(|v| field[*v] = mean);
        }
        field
    };
    examples.iter().map(one).collect()
}

/// An instance with the marks of random hits on `set`, some of them repeated.
fn random_marks(set: &Arc<ExampleSet>, dice: &mut Dice, options: InstanceOptions, count: usize) -> Instance {
    scenes::dented(set, options, &scenes::random_hits(set, count, dice.next()))
}

/// The displacements of all vertices by one hit of a mark alone, m, and a depth limit that none of them comes near.
fn alone(set: &Arc<ExampleSet>, mark: &Mark) -> (Vec<DVec3>, f64) {
    let mut limit = 4.0 * mark.depth.max(set.depth_limit());
    loop {
        let options = InstanceOptions { depth_limit: Some(limit), ..InstanceOptions::default() };
        let mut body = with(set, options);
        body.set_marks(&[Mark { energy: Mark::ONE, ..*mark }]).unwrap();
        let moved = scenes::displacements(&mut body);
        if moved.iter().all(|u| u.length() < 0.7 * limit) {
            return (moved.iter().map(|u| u.as_dvec3()).collect(), f64::from(limit));
        }
        limit *= 4.0;
    }
}

/// Compares every vertex between the library and the oracle, for the instance's damage. `free` is the same set without limits of vertices.
fn check_limited(instance: &mut Instance, free: &Arc<ExampleSet>, limits: &[Limit]) -> Result<(), TestCaseError> {
    let given = instance.marks().unwrap().to_vec();
    let shown = Shown::of(&given, |mark| alone(free, mark));
    let limit = f64::from(instance.depth_limit().min(16.0 * free.depth_limit()));
    let out = Output::fresh(instance);
    for (v, own) in limits.iter().enumerate() {
        let ought = free.mesh().positions()[v].as_dvec3() + shown.displacement(v, limit, *own);
        let off = f64s(out.positions[v]).distance(ought);
        let allowed = shown.doubt(v, limit, *own) + 4e-7 * ought.length();
        prop_assert!(
            off <= allowed,
            "vertex {v}: {:?} is {off:e} from {ought:?}; {allowed:e} is allowed",
            out.positions[v]
        );
    }
    Ok(())
}

/// The same for a set without limits of vertices.
fn check_evaluation(instance: &mut Instance) -> Result<(), TestCaseError> {
    let set = instance.example_set().clone();
    check_limited(instance, &set, &vec![Limit { depth: f64::INFINITY, give: 1.0 }; set.vertex_count()])
}

proptest! {
    #![proptest_config(scenes::cases(48))]

    #[test]
    fn displacements_are_stored_as_given(seed in any::<u64>()) {
        let mut dice = Dice::new(seed);
        let mesh = scenes::cube(4);
        let example = ragged(&mesh, &mut dice);
        let full = scenes::field(&example.positions, mesh.positions.len()).iter().map(|u| u.to_array()).collect();
        let as_full = ExampleData { positions: Deltas::Full(full), ..example.clone() };
        let given = given(&mesh, std::slice::from_ref(&example)).remove(0);
        let set = build(mesh, vec![example, as_full], SetOptions::default());
        for (v, given) in given.into_iter().enumerate() {
            for e in set.examples() {
                let stored = e.delta(v as u32);
                prop_assert!(stored.as_dvec3().distance(given) <= 1e-7, "vertex {v}: {stored:?}, given {given:?}");
            }
        }
    }

    #[test]
    fn hits_by_the_classic_rules_are_the_papers(seed in any::<u64>()) {
        let mut dice = Dice::new(seed);
        let (mesh, examples, options) = random_data(&mut dice);
        // They do not follow nodes.
        let basis = Some(BasisOptions { tolerance: 1e9, rounds: 0, nodes: [8, usize::MAX][dice.index(2)] });
        let given = given(&mesh, &examples);
        check_classic(&build(mesh, examples, SetOptions { basis, ..options }), &given, &mut dice)?;
    }

    #[test]
    fn one_to_six_marks_displace_as_the_design_says(seed in any::<u64>(), hits in 1usize..=6) {
        let mut dice = Dice::new(seed);
        let set = random_set(&mut dice);
        let depth_limit = (dice.index(3) == 0).then(|| dice.between(0.01, 0.3));
        let options = InstanceOptions { depth_limit, ..InstanceOptions::default() };
        let mut instance = random_marks(&set, &mut dice, options, hits);
        check_evaluation(&mut instance)?;
    }

    #[test]
    fn limits_of_vertices_shorten_as_the_design_says(seed in any::<u64>(), hits in 1usize..=6) {
        let mut dice = Dice::new(seed);
        let (mut mesh, examples, options) = random_data(&mut dice);
        // numbers that are stored exactly
        let count = mesh.positions.len();
        let depths: Vec<f32> =
            (0..count).map(|_| [f32::INFINITY, dice.index(100) as f32 / 512.0][dice.index(2)]).collect();
        let stiffness: Vec<f32> = (0..count).map(|_| dice.index(9) as f32 / 8.0).collect();
        let given = dice.index(3);
        mesh.depth_limits = (given != 0).then(|| depths.clone());
        mesh.stiffness = (given != 1).then(|| stiffness.clone());
        let options = every_node(options);
        let free = MeshData { depth_limits: None, stiffness: None, ..mesh.clone() };
        let free = build(free, examples.clone(), options.clone());
        let set = build(mesh, examples, options);
        // vertices at one position take the least
        let least = |v: usize, values: &dyn Fn(usize) -> f32| {
            let (positions, all) = (set.mesh().positions(), (0..count));
            all.filter(|w| positions[*w] == positions[v]).map(values).fold(f32::INFINITY, f32::min)
        };
        let limits: Vec<Limit> = (0..count)
            .map(|v| Limit {
                depth: f64::from(if given != 0 { least(v, &|w| depths[w]) } else { f32::INFINITY }),
                give: f64::from(if given != 1 { least(v, &|w| 1.0 - stiffness[w]) } else { 1.0 }),
            })
            .collect();
        let mut instance = random_marks(&set, &mut dice, InstanceOptions::default(), hits);
        check_limited(&mut instance, &free, &limits)?;
        for _ in 0..8 {
            let outcome = instance.preview(&scenes::random_hit(&set, &mut dice)).unwrap();
            let own = limits[outcome.contact_vertex as usize];
            let limit = Limit { depth: own.depth.min(f64::from(set.depth_limit())), ..own };
            let rigid = limit.depth == 0.0 || limit.give == 0.0;
            prop_assert_eq!(outcome.status == HitStatus::Rigid, rigid, "{:?}", outcome);
            let over = f64s(outcome.target).length() / limit.depth - 1.0;
            prop_assert!(rigid || over.abs() < 1e-6 || outcome.clamped == (over > 0.0), "{outcome:?}, {limit:?}");
        }
    }

    #[test]
    fn repeats_and_the_capacity_keep_the_ledger(seed in any::<u64>(), capacity in 1u32..12) {
        let mut dice = Dice::new(seed);
        let set = random_set(&mut dice);
        check_ledger(&set, &mut dice, capacity)?;
    }

    #[test]
    fn saved_and_arbitrary_marks_evaluate_alike(seed in any::<u64>()) {
        // marks that no hit would make: any contact, depth, direction and energy
        let mut dice = Dice::new(seed);
        let set = random_set(&mut dice);
        let list: Vec<Mark> = (0..1 + dice.index(5)).map(|_| any_mark(&set, &mut dice)).collect();
        let mut instance = new(&set);
        instance.set_marks(&list).unwrap();
        check_evaluation(&mut instance)?;
    }
}

fn any_mark(set: &ExampleSet, dice: &mut Dice) -> Mark {
    let contact = dice.index(set.vertex_count()) as u32;
    let energy = (Mark::ONE as f64 * f64::from(dice.between(0.05, 9.0))) as u64;
    let direction = [dice.next() as u16, dice.next() as u16];
    let depth = set.depth_limit() * dice.between(0.05, 1.0);
    Mark { contact, depth, energy, told: 0, striker: 0, direction, strength: 0, mass: 0, radius: 0, reserved: 0 }
}

/// Eq. 4.5-4.7 and Figures 4.2 and 4.3 of the paper: of the examples that move the contact, the one with the highest cosine, as much of it as
/// the target is as long; then what is longer, blended by `k` where the rule blends.
fn check_classic(set: &Arc<ExampleSet>, given: &[Vec<DVec3>], dice: &mut Dice) -> Result<(), TestCaseError> {
    let clamp = dice.index(2) == 0;
    let selection = if clamp { Selection::Classic } else { Selection::ClassicUnclamped };
    let (rule, k) = [(Rule::MostDisplaced, 0.0), (Rule::Blend(0.25), 0.25), (Rule::Blend(1.0), 1.0)][dice.index(3)];
    let mut instance = with(set, InstanceOptions { rule, selection, ..InstanceOptions::default() });
    let base = |v: usize| set.mesh().positions()[v].as_dvec3();
    let mut shown: Vec<DVec3> = (0..set.vertex_count()).map(base).collect();
    for _ in 0..1 + dice.index(4) {
        let outcome = instance.submit(&scenes::random_hit(set, dice)).unwrap();
        let target = f64s(outcome.target);
        let limit = if clamp { f64::from(set.depth_limit()) } else { f64::INFINITY };
        let target = target * (limit / target.length()).min(1.0);
        let at_contact = |e: &Vec<DVec3>| e[outcome.contact_vertex as usize];
        let cosine = |e: &Vec<DVec3>| target.dot(at_contact(e)) / (target.length() * at_contact(e).length());
        // NaN where an example does not move the contact
        let best = given.iter().map(cosine).fold(f64::NAN, f64::max);
        let Some(chosen) = outcome.classic else {
            prop_assert!(best.is_nan() && outcome.status == HitStatus::NothingReaches);
            prop_assert_eq!(outcome.shortfall(), outcome.target);
            continue;
        };
        let e = &given[chosen.example as usize];
        prop_assert!((cosine(e) - best).abs() < 1e-6, "{} instead of {best}", cosine(e));
        let weight = target.length() / at_contact(e).length();
        let (is, weight) = (f64::from(chosen.weight), if clamp { weight.min(1.0) } else { weight });
        prop_assert!((is - weight).abs() <= 1e-5 * weight, "weight {is} instead of {weight}");
        let out = Output::fresh(&mut instance);
        for (v, before) in shown.iter_mut().enumerate() {
            let (was, d) = (*before - base(v), e[v]);
            *before = f64s(out.positions[v]);
            let result = was.lerp(d, is);
            let (longer, kept) = (result, was.lerp(result, k));
            let size = base(v).length() + was.length() + is.abs() * (was.length() + d.length());
            // Examples are stored to 1e-7 m.
            let allowed = 1e-6 + 1e-6 * size + 2e-7 * is;
            let is_near = |ought: DVec3| (*before - base(v)).distance(ought) <= allowed;
            let by = result.length() - was.length();
            // Vertices that the example does not move stay, also where it turns their normals. Where both are as long, either may be.
            let fits = if d == DVec3::ZERO {
                is_near(was)
            } else {
                by > -allowed && is_near(longer) || by < allowed && is_near(kept)
            };
            prop_assert!(fits, "vertex {v}: {} after {was}, not {longer} or {kept}", *before - base(v));
        }
    }
    Ok(())
}

fn check_ledger(set: &Arc<ExampleSet>, dice: &mut Dice, capacity: u32) -> Result<(), TestCaseError> {
    let options = InstanceOptions { capacity, ..InstanceOptions::default() };
    let mut instance = with(set, options);
    let mut ledger = Ledger::default();
    for _ in 0..4 {
        let count = 1 + dice.index(8);
        let hits: Vec<Hit> = scenes::random_hits(set, count, dice.index(3) as u64);
        let made: Vec<Mark> = hits.iter().filter_map(|h| instance.submit(h).unwrap().mark).collect();
        ledger.frame(set.mesh().positions(), &made, capacity as usize);
        let ought = ledger.marks();
        prop_assert_eq!(instance.marks().unwrap(), ought.as_slice());
    }
    Ok(())
}

#[test]
fn the_solver_s_bodies_agree_too() {
    for (body, count) in [("panel", 12), ("tube", 10)] {
        let (mesh, examples) = scenes::solver(body, count);
        let given = given(&mesh, &examples);
        let set = build(mesh, examples, every_node(SetOptions::default()));
        let mut dice = Dice::new(7);
        for hits in [1, 6] {
            let mut instance = random_marks(&set, &mut dice, InstanceOptions::default(), hits);
            check_evaluation(&mut instance).unwrap();
        }
        (0..4).for_each(|_| check_classic(&set, &given, &mut dice).unwrap());
        check_ledger(&set, &mut dice, 5).unwrap();
    }
}

/// What random hits do not meet.
#[test]
fn quick_the_first_of_equal_cosines_and_the_last_of_equal_lengths_win() {
    let examples = [1.0, 2.0, 1.0, -1.0].map(|depth| scenes::poke(4, depth));
    let set = build(scenes::sheet(2), examples.to_vec(), SetOptions::default());
    let mut body = with(&set, InstanceOptions::classic(Rule::MostDisplaced));
    for (along, example) in [(-1.0, 0), (1.0, 3)] {
        let chosen = body.submit(&scenes::push([0.0; 3], [0.0, 0.0, along])).unwrap().classic.unwrap();
        assert_eq!((chosen.example, chosen.weight), (example, 1.0));
        assert_eq!(scenes::positions(&mut body).0[4], [0.0, 0.0, along]);
    }
}

#[test]
fn quick_the_oracle_agrees_on_a_few_sets() {
    for seed in 0..6 {
        let mut dice = Dice::new(seed);
        let (mesh, examples, options) = random_data(&mut dice);
        let given = given(&mesh, &examples);
        let set = build(mesh, examples, every_node(options));
        check_classic(&set, &given, &mut dice).unwrap();
        check_ledger(&set, &mut dice, 4).unwrap();
        let mut instance = random_marks(&set, &mut dice, InstanceOptions::default(), 3);
        check_evaluation(&mut instance).unwrap();
    }
}
