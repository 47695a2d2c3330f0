//! Compares every rule of the library with a naive f64 implementation (`oracle`), on random sets and on the solver's bodies.

mod oracle;
mod scenes;

use std::collections::BTreeSet;
use std::sync::Arc;

use crumple::{
    Blow, Contact, Deltas, ExampleData, ExampleSet, Hit, HitStatus, Instance, InstanceOptions, Mark, MeshData, Mirror,
    Outcome, Pair, Placement, Rule, Selection, SetOptions, Striker,
};
use oracle::marks::Limit;
use oracle::response::{Known, Strike};
use oracle::vector::{self, V, add, from_f32, length, scale, sub};
use oracle::{Model, classic, damage::Ledger, learn, marks, select};
use proptest::prelude::*;
use scenes::{Dice, Output, build, new, push};

/// A random set: a bumpy sheet, ball or cube, with smooth and ragged examples. Some are anchored, some carried, some
/// without a given contact.
fn random_set(dice: &mut Dice) -> Arc<ExampleSet> {
    let (mesh, examples, options) = random_data(dice);
    build(mesh, examples, options)
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
        e.placement = [Placement::Automatic, Placement::Anchored, Placement::Carried][dice.index(3)];
        if dice.index(3) == 0 {
            e.contact = None;
        } else if dice.index(3) == 0 {
            let Some(Contact::Vertex(v)) = e.contact else { continue };
            let p = mesh.positions[v as usize];
            e.contact = Some(Contact::Point([p[0] + 0.001, p[1], p[2]]));
        }
    }
    let depth_limit = (dice.index(2) == 0).then(|| dice.between(0.02, 0.5));
    dice.index(4); // a number of the sequences that the seeds below were found with
    let stamp_resolution = 8 + dice.index(20) as u32;
    let (mirror, held_rims) = (dice.index(4) != 0, dice.index(6) != 0);
    let options = SetOptions { depth_limit, stamp_resolution, mirror, held_rims, ..Default::default() };
    (mesh, examples, options)
}

/// A random set of up to 140 examples whose blows are known in part.
fn random_blows(dice: &mut Dice) -> Arc<ExampleSet> {
    let mut mesh = match dice.index(3) {
        0 => scenes::sheet(9 + dice.index(4)),
        1 => scenes::ball(2),
        _ => scenes::cube(4),
    };
    bump(&mut mesh, dice);
    let normals = area_normals(&mesh);
    let count = [1, 2, 4, 7, 8, 20, 70][dice.index(7)];
    let mut examples = scenes::bowls(&mesh_with(&mesh, &normals), count, 0.25, dice.next());
    let (hidden, spread) = (dice.next(), [1.02, 1.3, 4.0][dice.index(3)]);
    let twice = dice.index(2) == 0;
    for mut e in std::mem::take(&mut examples) {
        lean(&mut e, dice);
        let Some(Contact::Vertex(contact)) = e.contact else { unreachable!() };
        let normal = normals[contact as usize];
        // some at one place, by another blow
        for _ in 0..1 + usize::from(twice && dice.index(3) == 0) {
            let Deltas::Sparse { values, .. } = &mut e.positions else { unreachable!() };
            let size = if dice.index(12) == 0 { -1.0 } else { dice.between(0.5, 2.0) };
            values.iter_mut().for_each(|u| *u = u.map(|x| size * x));
            let depth = values.iter().map(|u| scenes::length(*u)).fold(0.0, f32::max);
            let hidden = if dice.index(4) == 0 { dice.next() } else { hidden };
            let made = depth * dice.between(1.0, spread) * if dice.index(2) == 0 { 1.0 } else { 1.0 / spread };
            let blow = if dice.index(8) == 0 { Blow::default() } else { random_blow(dice, normal, made, hidden) };
            let placement = [Placement::Automatic, Placement::Anchored, Placement::Carried][dice.index(3)];
            examples.push(ExampleData { blow, placement, ..e.clone() });
        }
    }
    if dice.index(8) == 0 {
        (mesh.normals, mesh.tangents, mesh.triangles) = (None, None, Vec::new());
        examples.iter_mut().for_each(|e| e.placement = Placement::Anchored);
    }
    build(mesh, examples, SetOptions { mirror: dice.index(4) != 0, ..SetOptions::default() })
}

/// A blow that would leave a dent of about `depth`. Bits of `hidden` say which of its parts are unknown.
fn random_blow(dice: &mut Dice, normal: [f32; 3], depth: f32, hidden: u64) -> Blow {
    let knows = |bit: u64| hidden >> bit & 1 == 0;
    let mass = dice.between(0.5, 50.0);
    let speed = 300.0 * depth / mass.powf(0.6);
    let sideways = [0.3, 0.3, 0.3, 0.3, 0.3, 6.0][dice.index(6)];
    let along = dice.vector(sideways);
    let velocity = [0, 1, 2].map(|k| speed * (along[k] - normal[k]));
    let bounce = dice.between(1.0, 1.5);
    let turn = dice.vector(0.1);
    let size = dice.between(0.5, 2.0);
    let rubs = dice.vector(0.3);
    let impulse = [0, 1, 2].map(|k| bounce * mass * (velocity[k] + speed * rubs[k]));
    let radius = dice.between(0.005, 0.3);
    let by_impulse = knows(0);
    Blow {
        impulse: by_impulse.then_some(impulse),
        duration: None,
        normal: knows(1).then_some([0, 1, 2].map(|k| size * (normal[k] + turn[k]))),
        striker: Striker {
            mass: (knows(2) || !by_impulse).then_some(mass),
            velocity: (knows(3) || !by_impulse).then_some(velocity),
            radius: knows(4).then_some(radius),
            ..Default::default()
        },
    }
}

/// The unit normals of the mesh's surface.
fn area_normals(mesh: &MeshData) -> Vec<[f32; 3]> {
    if let Some(normals) = &mesh.normals {
        return normals.clone();
    }
    let mut sums = vec![[0.0; 3]; mesh.positions.len()];
    for t in &mesh.triangles {
        let p = t.map(|v| from_f32(mesh.positions[v as usize]));
        let n = vector::cross(sub(p[1], p[0]), sub(p[2], p[0]));
        t.iter().for_each(|v| sums[*v as usize] = add(sums[*v as usize], n));
    }
    sums.into_iter().map(|n| vector::unit(n).map(|x| x as f32)).collect()
}

fn mesh_with(mesh: &MeshData, normals: &[[f32; 3]]) -> MeshData {
    MeshData { normals: Some(normals.to_vec()), ..mesh.clone() }
}

/// Whether an example does not move the sides of the sheet.
fn inside(mesh: &MeshData, e: &ExampleData) -> bool {
    let Deltas::Sparse { indices, .. } = &e.positions else { return false };
    indices.iter().all(|v| mesh.positions[*v as usize][..2].iter().all(|x| x.abs() < 0.48))
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

/// Asserts that two displacements agree within the resolution of f32 and of the weights. `size` is the size of what was summed.
fn agree(is: V, ought: V, size: f64, what: &str) -> Result<(), TestCaseError> {
    let (off, allowed) = (length(sub(is, ought)), marks::rounding(ought, size, 0.0));
    prop_assert!(off <= allowed, "{what}: {is:?} is {off:e} from {ought:?}; {allowed:e} is allowed");
    Ok(())
}

/// An instance with the marks of random hits on `set`, some of them repeated.
fn random_marks(set: &Arc<ExampleSet>, dice: &mut Dice, options: &InstanceOptions, count: usize) -> Instance {
    let mut instance = Instance::new(set.clone(), *options).unwrap();
    for hit in scenes::random_hits(set, count, dice.next()) {
        instance.submit(&hit).unwrap();
    }
    instance.fold();
    instance
}

/// Compares every vertex between the library and the oracle, for the instance's damage on a body with a node at every vertex.
fn check_evaluation(instance: &mut Instance) -> Result<(), TestCaseError> {
    let count = instance.example_set().vertex_count();
    check_limited(instance, &vec![Limit { depth: f64::INFINITY, give: 1.0 }; count])
}

/// The same for a set whose vertices have these limits.
fn check_limited(instance: &mut Instance, limits: &[Limit]) -> Result<(), TestCaseError> {
    let set = scenes::every_node(instance.example_set());
    let mut exact = Instance::new(set.clone(), *instance.options()).unwrap();
    exact.load(&instance.save()).unwrap();
    let model = Model::of(&set);
    let list = marks::marks_of(&model, exact.marks().unwrap());
    let scaled = marks::scaled(&model, &list);
    let size: f64 = scaled.iter().map(|m| marks::size(&model, m)).sum();
    let limit = f64::from(exact.depth_limit());
    let out = Output::fresh(&mut exact);
    for (v, own) in limits.iter().enumerate() {
        if list.iter().any(|m| marks::on_a_border(&model, m, v)) {
            continue;
        }
        let ought = add(model.positions[v], marks::displacement(&model, &scaled, v, limit, *own));
        let off = length(sub(from_f32(out.positions[v]), ought));
        let allowed = marks::rounding(ought, size, limit.min(16.0 * model.depth_limit));
        prop_assert!(
            off <= allowed,
            "vertex {v}: {:?} is {off:e} from {ought:?}; {allowed:e} is allowed",
            out.positions[v]
        );
    }
    Ok(())
}

proptest! {
    #![proptest_config(scenes::cases(48))]

    #[test]
    fn nearest_vertex_is_the_nearest(seed in any::<u64>()) {
        let mut dice = Dice::new(seed);
        let set = random_set(&mut dice);
        let model = Model::of(&set);
        for _ in 0..50 {
            let point = dice.vector(1.0);
            let found = set.nearest_vertex(point).unwrap();
            let (vertex, distance) = model.nearest(from_f32(point));
            let of_found = length(sub(model.positions[found.vertex as usize], from_f32(point)));
            prop_assert!((of_found - distance).abs() <= 1e-6 * (1.0 + distance), "{} instead of {vertex}", found.vertex);
            prop_assert!((f64::from(found.distance) - distance).abs() <= 1e-6 * (1.0 + distance));
        }
    }

    #[test]
    fn ties_go_to_the_lowest_index(seed in any::<u64>()) {
        // a lattice in random order with duplicates: all distances are exact in f32, and many are equal
        let mut dice = Dice::new(seed);
        let mut positions: Vec<[f32; 3]> = Vec::new();
        for i in 0..64 {
            positions.push([(i % 4) as f32, (i / 4 % 4) as f32, (i / 16) as f32]);
        }
        for _ in 0..16 {
            positions.push(positions[dice.index(64)]);
        }
        dice.shuffle(&mut positions);
        let example = ExampleData::new("any", Deltas::Sparse { indices: vec![0], values: vec![[0.0, 0.0, 1.0]] });
        let set = build(MeshData { positions, ..MeshData::default() }, vec![example], SetOptions::default());
        let model = Model::of(&set);
        for _ in 0..100 {
            let point = [0; 3].map(|_| dice.index(9) as f32 * 0.5 - 0.5);
            prop_assert_eq!(set.nearest_vertex(point).unwrap().vertex as usize, model.nearest(from_f32(point)).0);
        }
    }

    #[test]
    fn displacements_are_stored_as_given(seed in any::<u64>()) {
        let mut dice = Dice::new(seed);
        let mesh = scenes::cube(4);
        let example = ragged(&mesh, &mut dice);
        let Deltas::Sparse { indices, values } = &example.positions else { unreachable!() };
        let mut full = vec![[0.0f32; 3]; mesh.positions.len()];
        indices.iter().zip(values).for_each(|(i, d)| full[*i as usize] = *d);
        let as_full = ExampleData { positions: Deltas::Full(full.clone()), ..example.clone() };
        let groups = scenes::coincident(&mesh.positions);
        let set = build(mesh.clone(), vec![example.clone(), as_full.clone()], SetOptions::default());
        for v in 0..full.len() {
            let given = match groups.iter().find(|g| g.contains(&v)) {
                Some(group) => {
                    let sum = group.iter().fold([0.0; 3], |s, v| add(s, from_f32(full[*v])));
                    scale(1.0 / group.len() as f64, sum)
                }
                None => from_f32(full[v]),
            };
            for e in set.examples() {
                let stored = e.delta(v as u32).to_array();
                prop_assert!(length(sub(from_f32(stored), given)) <= 1e-7, "vertex {v}: {stored:?}, given {given:?}");
            }
        }
    }

    #[test]
    fn the_classic_rules_are_the_papers(seed in any::<u64>(), k in prop_oneof![Just(0.0f32), 0.0f32..=1.0], clamp in any::<bool>()) {
        let mut dice = Dice::new(seed);
        let set = random_set(&mut dice);
        check_classic(&set, &mut dice, k, clamp)?;
    }

    #[test]
    fn the_default_selection_is_the_designs(seed in any::<u64>(), k in 1u32..=4) {
        let mut dice = Dice::new(seed);
        let set = random_set(&mut dice);
        check_selection(&set, &mut dice, k, 12)?;
    }

    #[test]
    fn the_response_to_a_blow_is_the_models(seed in any::<u64>(), k in 1u32..=4) {
        let mut dice = Dice::new(seed);
        let set = random_blows(&mut dice);
        check_response(&set, &mut dice, k, 12)?;
    }

    #[test]
    fn planes_rims_and_what_is_learned_are_the_models(seed in any::<u64>()) {
        let mut dice = Dice::new(seed);
        dice.index(2);
        check_body(&random_set(&mut dice))?;
    }

    #[test]
    fn one_to_six_marks_displace_as_the_design_says(seed in any::<u64>(), hits in 1usize..=6, k in 1u32..=4) {
        let mut dice = Dice::new(seed);
        let set = random_set(&mut dice);
        let depth_limit = (dice.index(3) == 0).then(|| dice.between(0.01, 0.3));
        let options = InstanceOptions { examples_per_hit: k, depth_limit, ..InstanceOptions::default() };
        let mut instance = random_marks(&set, &mut dice, &options, hits);
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
        let mut instance = random_marks(&set, &mut dice, &InstanceOptions::default(), hits);
        check_limited(&mut instance, &limits)?;
        for _ in 0..8 {
            let outcome = instance.preview(&scenes::random_hit(&set, &mut dice)).unwrap();
            let own = limits[outcome.contact_vertex as usize];
            let limit = Limit { depth: own.depth.min(f64::from(set.depth_limit())), ..own };
            let rigid = limit.depth == 0.0 || limit.give == 0.0;
            prop_assert_eq!(outcome.status == HitStatus::Rigid, rigid, "{:?}", outcome);
            let over = length(from_f32(outcome.target)) / limit.depth - 1.0;
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
        // marks that no selection would make: any contact, any shares, anchored or carried as the example allows
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
    let mut pairs = [Pair::NONE; 4];
    let (mut total, mut used) = (0, 0);
    for _ in 0..4 {
        let example = dice.index(set.examples().len());
        let e = &set.examples()[example];
        let anchored = match e.placement() {
            Placement::Anchored => true,
            Placement::Carried => false,
            Placement::Automatic => dice.index(2) == 0,
        };
        // an anchored example must move the contact
        if anchored && e.delta(contact).length() < 0.02 * e.depth() {
            continue;
        }
        // the first share is large enough that the others may be negative
        let share = if used == 0 { 900 + dice.index(1100) as i32 } else { dice.index(1200) as i32 - 700 };
        if !(100..=1024).contains(&(total + share)) && used > 0 {
            continue;
        }
        total += share;
        pairs[used] = if anchored {
            Pair::anchored(example as u16, share as i16)
        } else {
            // mirrored in any planes, whether or not they are the body's
            Pair::carried(example as u16, share as i16, Mirror::from_bits(dice.index(8) as u8))
        };
        used += 1;
    }
    if used == 0 || total > 1024 {
        let e = &set.examples()[0];
        let contact = e.contact_vertex();
        pairs = [Pair::NONE; 4];
        pairs[0] = if e.placement() == Placement::Anchored {
            Pair::anchored(0, Pair::WHOLE)
        } else {
            Pair::carried(0, Pair::WHOLE, Mirror::NONE)
        };
        return Mark { contact, depth: e.depth() * 0.5, energy: Mark::ONE, pairs };
    }
    let energy = (Mark::ONE as f64 * f64::from(dice.between(0.05, 9.0))) as u64;
    Mark { contact, depth: set.depth_limit() * dice.between(0.05, 1.0), energy, pairs }
}

fn check_classic(set: &Arc<ExampleSet>, dice: &mut Dice, k: f32, clamp: bool) -> Result<(), TestCaseError> {
    let rule = if k == 0.0 { Rule::MostDisplaced } else { Rule::Blend(k) };
    let selection = if clamp { Selection::Classic } else { Selection::ClassicUnclamped };
    let model = Model::of(set);
    let mut instance =
        Instance::new(set.clone(), InstanceOptions { rule, selection, ..InstanceOptions::default() }).unwrap();
    let mut current = model.positions.clone();
    // the error of f32 so far, and whether a decision of Figure 4.3 depended on it; such vertices are no longer
    // compared
    let mut error: Vec<f64> = current.iter().map(|p| 1e-7 * length(*p)).collect();
    let mut doubtful = vec![false; current.len()];
    for _ in 0..5 {
        let hit = scenes::random_hit(set, dice);
        let outcome = instance.submit(&hit).unwrap();
        let vertex = outcome.contact_vertex as usize;
        let target = from_f32(outcome.target);
        let target =
            if clamp { scale((f64::from(set.depth_limit()) / length(target)).min(1.0), target) } else { target };
        let Some((best, _)) = classic::choose(&model, vertex, target, clamp) else {
            prop_assert_eq!(outcome.status, HitStatus::NothingReaches);
            continue;
        };
        let chosen = outcome.chosen[0].expect("some example moves the contact").example as usize;
        let cosine = |e: usize| classic::cosine(target, model.examples[e].deltas[vertex]);
        prop_assert!(chosen == best || (cosine(chosen) - cosine(best)).abs() < 1e-6, "{chosen} instead of {best}");
        let weight = classic::blend_weight(target, model.examples[chosen].deltas[vertex]);
        let weight = if clamp { weight.min(1.0) } else { weight };
        let is = f64::from(outcome.chosen[0].unwrap().scale);
        prop_assert!((is - weight).abs() <= 1e-5 * weight, "weight {is} instead of {weight}");
        let before = current.clone();
        classic::deform(&model, &mut current, chosen, is, f64::from(k));
        for v in 0..current.len() {
            let (base, d) = (model.positions[v], model.examples[chosen].deltas[v]);
            if d == [0.0; 3] {
                continue;
            }
            let result = add(scale(1.0 - is, before[v]), scale(is, add(base, d)));
            let rounding = 3e-7 * (length(base) + length(before[v]) + is * length(sub(add(base, d), before[v])));
            let off = (1.0 - is).abs() * error[v] + rounding;
            let (a, b) = (length(sub(result, base)), length(sub(before[v], base)));
            let differ = length(sub(result, before[v]));
            doubtful[v] |= (a - b).abs() <= error[v] + off && differ > error[v] + off;
            error[v] = error[v].max(off);
        }
        let out = Output::fresh(&mut instance);
        for v in (0..current.len()).filter(|v| !doubtful[*v]) {
            let off = length(sub(from_f32(out.positions[v]), current[v]));
            prop_assert!(
                off <= error[v] + 1e-6,
                "vertex {v}: {:?}, not {:?}: {off:e}, {:e}",
                out.positions[v],
                current[v],
                error[v]
            );
        }
    }
    Ok(())
}

/// Returns the number of hits that could be compared.
fn check_selection(set: &Arc<ExampleSet>, dice: &mut Dice, k: u32, hits: usize) -> Result<usize, TestCaseError> {
    let mut compared = 0;
    let model = Model::of(set);
    let options = InstanceOptions { examples_per_hit: k, ..InstanceOptions::default() };
    let instance = Instance::new(set.clone(), options).unwrap();
    for _ in 0..hits {
        let hit = scenes::random_hit(set, dice);
        let outcome = instance.preview(&hit).unwrap();
        compared += usize::from(check_outcome(set, &model, &outcome, None, k)?);
    }
    Ok(compared)
}

/// Compares the outcome of a hit with what the oracle makes of its target. Returns whether it could be compared.
fn check_outcome(
    set: &ExampleSet,
    model: &Model,
    outcome: &Outcome,
    strike: Option<Strike>,
    k: u32,
) -> Result<bool, TestCaseError> {
    let limit = f64::from(set.depth_limit());
    let target = from_f32(outcome.target);
    if (length(target) / limit - 1.0).abs() > 1e-6 {
        prop_assert_eq!(outcome.clamped, length(target) > limit);
    }
    let (ways, close) = select::select(model, outcome.contact_vertex as usize, target, strike, limit, k as usize);
    if close {
        return Ok(false);
    }
    let Some(mark) = outcome.mark else {
        prop_assert!(ways.iter().any(Option::is_none), "{outcome:?} instead of {ways:?}");
        prop_assert_eq!(outcome.status, HitStatus::NothingReaches, "{:?}", outcome);
        prop_assert_eq!(outcome.shortfall(), outcome.target);
        return Ok(true);
    };
    prop_assert_eq!(outcome.status, HitStatus::Marked);
    let is = marks::mark_of(&mark);
    prop_assert_eq!(is.strength, 1.0);
    let total: f64 = is.parts.iter().map(|p| p.share).sum();
    prop_assert!((total - 1.0).abs() < 1e-12, "shares sum to {total}");
    prop_assert!(is.parts.windows(2).all(|p| p[0].share >= p[1].share - 3.0 / 1024.0), "{:?}", is.parts);
    let Some(ought) = ways.iter().flatten().find(|w| same_parts(&is.parts, &w.mark.parts)) else {
        prop_assert!(false, "{:?}\ninstead of {ways:?}", is.parts);
        unreachable!()
    };
    let near = |a: f64, b: f64| (a - b).abs() <= 3e-3 * length(target).min(limit);
    prop_assert!(near(is.depth, ought.mark.depth), "depth {} instead of {}", is.depth, ought.mark.depth);
    // the outcome's displacement is that of its mark, to rounding, and near that of the oracle's mark
    let met = from_f32(outcome.achieved);
    agree(met, marks::met(model, &is), length(met) + 1e-3 * limit, "met")?;
    prop_assert!(near(length(sub(met, ought.met)), 0.0), "met {met:?} instead of {:?}", ought.met);
    agree(from_f32(outcome.shortfall()), sub(target, met), length(target), "unmet")?;
    for (chosen, (part, scale)) in outcome.chosen.iter().flatten().zip(is.parts.iter().zip(marks::scales(model, &is))) {
        prop_assert_eq!((chosen.example as usize, chosen.mirror.bits()), (part.example, part.mirror));
        prop_assert_eq!(chosen.anchored, part.anchored);
        prop_assert!((f64::from(chosen.scale) - scale).abs() <= 1e-4 * scale.abs() + 2e-6);
    }
    Ok(true)
}

/// Compares what blows are predicted to leave, and their marks. Returns the number of hits that could be compared.
fn check_response(set: &Arc<ExampleSet>, dice: &mut Dice, k: u32, hits: usize) -> Result<usize, TestCaseError> {
    let model = Model::of(set);
    let Some(response) = &model.response else {
        prop_assert!(set.response().is_none());
        return Ok(0);
    };
    let Some(learned) = set.response() else {
        prop_assert!(false, "nothing learned");
        unreachable!()
    };
    if response.close {
        return Ok(0);
    }
    let pairs: BTreeSet<_> = learned.contradictions().iter().map(|(a, b)| (*a as usize, *b as usize)).collect();
    prop_assert_eq!(pairs, response.contradictions().iter().copied().collect::<BTreeSet<_>>());
    let errors = response.depth_errors(set.examples().len());
    for (is, ought) in learned.depth_error().iter().zip(&errors) {
        prop_assert_eq!(is.is_some(), ought.is_some());
        let off = is.map_or(0.0, f64::from) - ought.unwrap_or(0.0);
        prop_assert!(off.abs() <= 1e-5 * (1.0 + ought.unwrap_or(0.0)), "{is:?} instead of {ought:?}");
    }
    let options = InstanceOptions { examples_per_hit: k, ..InstanceOptions::default() };
    let instance = Instance::new(set.clone(), options).unwrap();
    let mut compared = 0;
    for i in 0..hits {
        let known: Vec<_> = set.examples().iter().filter(|e| Known::of(e.blow()).is_some()).collect();
        let (point, blow) = if i % 4 == 0 {
            let e = known[dice.index(known.len())];
            (e.contact_point().to_array(), *e.blow())
        } else {
            let vertex = dice.index(set.vertex_count());
            let normal = set.mesh().contact_normal(vertex as u32).map_or([0.0, 0.0, 1.0], |n| n.to_array());
            let (depth, hidden) = (set.depth_limit() * dice.between(0.0, 1.0).powi(2) * 3.0, dice.next());
            (set.mesh().positions()[vertex].to_array(), random_blow(dice, normal, depth, hidden))
        };
        let outcome = instance.preview(&Hit::blow(point, blow)).unwrap();
        let ought = response.predict(&model, &Known::of(&blow).unwrap(), outcome.contact_vertex as usize);
        let (off, size) = (length(sub(from_f32(outcome.target), ought.target)), length(ought.target));
        prop_assert!(
            off <= 3e-6 * (size + response.elastic),
            "{:?} instead of {:?} for {blow:?}",
            outcome.target,
            ought.target
        );
        let least = 1e-6 * f64::from(set.depth_limit());
        if size < 0.5 * least {
            prop_assert_eq!((outcome.status, outcome.mark), (HitStatus::BelowYield, None));
        } else if size > 2.0 * least {
            compared += usize::from(check_outcome(set, &model, &outcome, Some(ought.strike), k)?);
        }
    }
    Ok(compared)
}

/// The same examples in about the same shares, in any order; one with almost no share may be absent.
fn same_parts(a: &[marks::Part], b: &[marks::Part]) -> bool {
    let share = |list: &[marks::Part], p: &marks::Part| {
        let same = |q: &&marks::Part| (q.example, q.anchored, q.mirror) == (p.example, p.anchored, p.mirror);
        list.iter().find(same).map_or(0.0, |q| q.share)
    };
    a.iter().chain(b).all(|p| (share(a, p) - share(b, p)).abs() < 3.5 / 1024.0)
}

/// Compares planes, rims and what was learned with the oracle's.
fn check_body(set: &Arc<ExampleSet>) -> Result<(), TestCaseError> {
    let model = Model::of(set);
    prop_assert_eq!(set.report().mirror_planes.bits(), model.planes);
    if model.close {
        return Ok(());
    }
    prop_assert_eq!(set.report().held_vertices, model.held.len());
    let (is, ought) = (set.learned(), learn::learn(&model));
    if ought.close {
        return Ok(());
    }
    prop_assert!((f64::from(is.place_width) - ought.width).abs() < 1e-6, "{} not {}", is.place_width, ought.width);
    for i in 0..model.examples.len() {
        let found = [is.carried_error[i], is.anchored_error[i]];
        let Some((carried, anchored)) = ought.errors[i] else {
            prop_assert_eq!(found, [None, None]);
            continue;
        };
        for (is, ought) in found.into_iter().zip([carried, anchored]).filter(|(_, ought)| ought.sure) {
            let near = match (is, ought.error) {
                (Some(is), Some(ought)) => (f64::from(is) - ought).abs() <= 0.01 * (0.1 + ought),
                (is, ought) => is.is_none() && ought.is_none(),
            };
            prop_assert!(near, "error of example {i}: {is:?} instead of {ought:?}");
        }
        if !ought.close_placement[i] {
            prop_assert_eq!(is.anchored[i], ought.anchored[i], "placement of example {}", i);
        }
    }
    Ok(())
}

fn check_ledger(set: &Arc<ExampleSet>, dice: &mut Dice, capacity: u32) -> Result<(), TestCaseError> {
    let model = Model::of(set);
    let options = InstanceOptions { capacity, ..InstanceOptions::default() };
    let mut instance = Instance::new(set.clone(), options).unwrap();
    let mut ledger = Ledger::default();
    for _ in 0..4 {
        let count = 1 + dice.index(8);
        let hits: Vec<Hit> = scenes::random_hits(set, count, dice.index(3) as u64);
        let made: Vec<Mark> = hits.iter().filter_map(|h| instance.submit(h).unwrap().mark).collect();
        ledger.frame(&model, &made, capacity as usize);
        let ought = ledger.marks();
        prop_assert_eq!(instance.marks().unwrap(), ought.as_slice());
    }
    Ok(())
}

/// The same checks on the solver's bodies: 2173 and 2244 vertices, 32 examples.
mod solver_bodies {
    use super::*;

    fn check(body: &str, placement: Placement) {
        let set = scenes::solver_set(body, 32, placement);
        let mut dice = Dice::new(7);
        let compared = check_selection(&set, &mut dice, 3, 40).unwrap();
        assert!(compared >= 30, "{compared} of 40 hits could be compared");
        for hits in [1, 3, 6] {
            let options = InstanceOptions::default();
            let mut instance = random_marks(&set, &mut dice, &options, hits);
            check_evaluation(&mut instance).unwrap();
        }
        for (k, clamp) in [(0.0, true), (0.5, true), (0.1, false)] {
            check_classic(&set, &mut dice, k, clamp).unwrap();
        }
        check_ledger(&set, &mut dice, 5).unwrap();
    }

    #[test]
    fn planes_rims_and_what_is_learned() {
        for (body, count) in [("panel", 12), ("tube", 10)] {
            check_body(&scenes::solver_set(body, count, Placement::Automatic)).unwrap();
        }
    }

    #[test]
    fn panel() {
        check("panel", Placement::Automatic);
    }

    #[test]
    fn panel_carried() {
        check("panel", Placement::Carried);
    }

    #[test]
    fn tube() {
        check("tube", Placement::Automatic);
    }

    #[test]
    fn tube_anchored() {
        check("tube", Placement::Anchored);
    }
}

#[test]
fn quick_eight_marks_at_one_vertex_add_energies() {
    // by hand: eight dents of depth 1 at one place are 8^(1/2.4) deep without a limit
    let mesh = MeshData {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..MeshData::default()
    };
    let down = ExampleData::new("down", Deltas::Sparse { indices: vec![0], values: vec![[0.0, 0.0, -1.0]] });
    let options = SetOptions { depth_limit: Some(100.0), ..SetOptions::default() };
    let set = build(mesh, vec![ExampleData { placement: Placement::Anchored, ..down }], options);
    // Nodes move in steps of a 16 000th of the limit at most.
    let mut instance = Instance::new(set, InstanceOptions::default()).unwrap();
    for n in 1..=8u16 {
        instance.submit(&push([0.0; 3], [0.0, 0.0, -1.0])).unwrap();
        let z = Output::fresh(&mut instance).positions[0][2];
        assert!((z + f32::from(n).powf(1.0 / 2.4)).abs() < 100.0 / 16000.0, "{n} hits: {z}");
    }
}

#[test]
fn quick_the_oracle_agrees_on_a_few_sets() {
    for seed in 0..6 {
        let mut dice = Dice::new(seed);
        let set = random_set(&mut dice);
        check_selection(&set, &mut dice, 1 + seed as u32 % 4, 4).unwrap();
        check_classic(&set, &mut dice, 0.25 * seed as f32 % 1.0, seed % 2 == 0).unwrap();
        check_ledger(&set, &mut dice, 4).unwrap();
        let mut instance = random_marks(&set, &mut dice, &InstanceOptions::default(), 3);
        check_evaluation(&mut instance).unwrap();
    }
    let mut dice = Dice::new(6);
    let compared: usize = (0..6).map(|_| check_response(&random_blows(&mut dice), &mut dice, 3, 6).unwrap()).sum();
    assert!(compared >= 10, "{compared} of 36 blows could be compared");
}
