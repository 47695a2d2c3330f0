//! What a set learns from all of its examples at once. src/predict/tests.rs has the facts of the rule itself, tests/promises.rs the promises
//! that all bodies share.

mod scenes;

use std::sync::{Arc, LazyLock};

use crumple::glam::Vec3;
use crumple::{BasisOptions, Blow, Error, ExampleData, ExampleSet, Hit, MeshData, SetOptions, ThreadPool, map_damage};
use scenes::{Dice, displacements, new, relative_l2};

/// A sheet whose dents go with the root of the blow's energy, and are three times as deep on the right as on the left.
struct Soft {
    mesh: MeshData,
}

impl Soft {
    fn new() -> Self {
        Soft { mesh: scenes::sheet(24) }
    }

    /// A vertex away from the edges.
    fn place(&self, dice: &mut Dice) -> u32 {
        let at = [0, 1].map(|_| dice.between(-0.35, 0.35));
        scenes::nearest(&self.mesh, [at[0], at[1], 0.0])
    }

    fn examples(&self, count: usize, seed: u64) -> Vec<ExampleData> {
        let mut dice = Dice::new(seed);
        (0..count).map(|_| scenes::struck(&self.mesh, self.place(&mut dice), dice.between(20.0, 400.0))).collect()
    }

    /// A set of this many examples.
    fn set(&self, count: usize) -> Arc<ExampleSet> {
        learned(&self.mesh, self.examples(count, 5), SetOptions::default())
    }
}

/// Learning takes a second.
static TWENTY: LazyLock<Arc<ExampleSet>> = LazyLock::new(|| Soft::new().set(20));

/// A set with as many nodes as a hundredth of the depth limit needs.
fn learned(mesh: &MeshData, examples: Vec<ExampleData>, options: SetOptions) -> Arc<ExampleSet> {
    let moved = examples.iter().flat_map(|e| scenes::field(&e.positions, mesh.positions.len()));
    let deepest = moved.map(|u| u.length()).fold(0.0, f32::max);
    let options = SetOptions { basis: Some(BasisOptions::new(0.01 * deepest)), ..options };
    let set = ExampleSet::build(mesh.clone(), examples, options, &ThreadPool::new(2).unwrap()).unwrap();
    assert_eq!(set.example_errors().len(), set.examples().len());
    Arc::new(set)
}

fn hit(set: &ExampleSet, vertex: u32, energy: f32) -> Hit {
    Hit::blow(set.mesh().positions()[vertex as usize].to_array(), scenes::blow(energy, [0.0, 0.0, 1.0]))
}

fn after(set: &Arc<ExampleSet>, hit: &Hit) -> Vec<Vec3> {
    let mut body = new(set);
    body.submit(hit).unwrap();
    displacements(&mut body)
}

#[test]
fn an_example_s_own_blow_gives_the_example() {
    let soft = Soft::new();
    // What is told with an example may lean away from the mesh.
    let mut leaning = soft.examples(8, 5);
    leaning.iter_mut().for_each(|e| e.contact_normal = Some([0.0, 0.6, 0.8]));
    let leaning = learned(&soft.mesh, leaning, SetOptions::default());
    let sets = [TWENTY.clone(), leaning];
    for (set, e) in sets.iter().flat_map(|set| set.examples().iter().map(move |e| (set, e))) {
        let told = [Hit::blow(e.contact_point().to_array(), *e.blow()), scenes::own_hit(e)];
        for hit in &told {
            let error =
                relative_l2(&after(set, hit), &(0..set.vertex_count() as u32).map(|v| e.delta(v)).collect::<Vec<_>>());
            assert!(error < 0.05, "{}: {error}", e.name());
        }
    }
}

#[test]
fn examples_that_look_alike_tell_of_each_other() {
    // One bowl at six places, none of them the mirror image of another.
    let mesh = scenes::sheet(24);
    let bowl = |x: f32| scenes::bowl(&mesh, scenes::nearest(&mesh, [x, 0.5 * x, 0.0]), 0.05, 0.2);
    let set = learned(&mesh, [-0.29, -0.21, -0.08, 0.04, 0.13, 0.25].map(bowl).to_vec(), SetOptions::default());
    assert!(set.example_errors().iter().all(|error| *error < 0.1), "{:?}", set.example_errors());
}

#[test]
fn expected_errors_tell_where_examples_contradict_each_other() {
    let soft = Soft::new();
    // Examples of one half keep the law, those of the other do not.
    let mut dice = Dice::new(2);
    let examples = (0..24)
        .map(|_| {
            let (v, energy) = (soft.place(&mut dice), dice.between(20.0, 400.0));
            let keeps = soft.mesh.positions[v as usize][1] < 0.0;
            let told = scenes::struck(&soft.mesh, v, energy);
            let left = scenes::struck(&soft.mesh, v, if keeps { energy } else { energy * dice.between(0.1, 6.0) });
            ExampleData { blow: told.blow, ..left }
        })
        .collect();
    let set = learned(&soft.mesh, examples, SetOptions { mirror: false, ..SetOptions::default() });
    let expected = |y: f32| {
        let at = scenes::nearest(&soft.mesh, [0.0, y, 0.0]);
        new(&set).preview(&hit(&set, at, 100.0)).unwrap().expected_error.unwrap()
    };
    let (good, bad) = (expected(-0.25), expected(0.25));
    assert!(
        good > 0.0 && bad < 2.0 && bad > 1.05 * good,
        "{good} where examples keep the law, {bad} where they do not"
    );
}

#[test]
fn marks_hold_the_hit_and_survive_another_set() {
    let soft = Soft::new();
    let set = TWENTY.clone();
    let mut body = new(&set);
    let mut dice = Dice::new(3);
    for _ in 0..10 {
        body.submit(&hit(&set, soft.place(&mut dice), dice.between(30.0, 200.0))).unwrap();
    }
    body.submit(&scenes::push([-0.1, 0.1, 0.0], [0.0, 0.01, -0.03])).unwrap();
    let marks = body.marks().unwrap().to_vec();
    assert_eq!((marks.len(), marks.iter().filter(|m| m.told == 1).count()), (11, 10));
    // A set with more examples takes the hits and predicts them better.
    let larger = soft.set(30);
    assert!(matches!(new(&larger).load(&body.save()), Err(Error::DamageMismatch { .. })), "another fingerprint");
    let (bytes, mapping) = map_damage(&set, &larger, &body.save(), 0.01).unwrap();
    assert_eq!((mapping.kept, mapping.without_blows), (11, 0));
    let mut mapped = new(&larger);
    mapped.load(&bytes).unwrap();
    let error = relative_l2(&displacements(&mut mapped), &displacements(&mut body));
    assert!(error > 1e-4 && error < 0.3, "{error}");
}

/// `bad_input.rs` has marks that are refused.
#[test]
fn a_set_without_blows_takes_no_hit_that_was_told_as_one() {
    let soft = Soft::new();
    let set = TWENTY.clone();
    let mut body = new(&set);
    body.submit(&hit(&set, 300, 100.0)).unwrap();
    let deaf = soft.examples(6, 5).into_iter().map(|e| ExampleData { blow: Blow::default(), ..e }).collect();
    let deaf = learned(&soft.mesh, deaf, SetOptions::default());
    let error = new(&deaf).set_marks(body.marks().unwrap()).unwrap_err().to_string();
    assert!(error.contains("no example of the set knows its blow"), "{error}");
    let (_, mapping) = map_damage(&set, &deaf, &body.save(), 0.0).unwrap();
    assert_eq!((mapping.kept, mapping.without_blows), (0, 1));
}
