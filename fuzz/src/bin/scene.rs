//! Random scenes: every SIMD level and number of threads gives the same bits, as does an update after each frame, and the
//! oracle of the tests agrees within rounding.
#![no_main]

use std::sync::{Arc, OnceLock};

use arbitrary::Unstructured;
use crumple::{
    BasisOptions, ExampleSet, Instance, Mark, Serial, SimdLevel, TaskSystem, ThreadPool, Tracker, VertexMemory,
};
use crumple_fuzz::{scene, seeds, target};
use oracle::vector::{add, from_f32, length, sub};
use oracle::{Model, marks};

#[path = "../../../tests/oracle/mod.rs"]
mod oracle;

target!(
    |data| {
        let mut updated: Option<Output> = None;
        let update = |body: &mut Instance| {
            let output = updated.get_or_insert_with(|| Output::new(body.example_set()));
            output.update(body, &Serial);
        };
        if let Some(mut body) = scene::play(&mut Unstructured::new(data), update) {
            compare(&body.example_set().clone(), &mut body, &updated.expect("a frame"));
        }
    },
    seeds: seeds::noise
);

/// Threads that take even the little work that a [`ThreadPool`] would leave to its caller.
struct Eager(ThreadPool);

impl TaskSystem for Eager {
    fn parallel_for(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        self.0.parallel_for(count, task);
    }

    fn workers(&self) -> usize {
        self.0.workers()
    }
}

fn compare(set: &ExampleSet, body: &mut Instance, updated: &Output) {
    static THREADS: OnceLock<Eager> = OnceLock::new();
    let threads = THREADS.get_or_init(|| Eager(ThreadPool::new(3).expect("three threads")));
    let best = SimdLevel::best();
    for level in SimdLevel::available() {
        level.force().expect("an available level");
        for tasks in [&Serial as &dyn TaskSystem, threads] {
            let mut fresh = Output::new(set);
            fresh.update(body, tasks);
            assert!(fresh.bits() == updated.bits(), "{level:?} with {} threads gives other bits", tasks.workers());
        }
    }
    best.force().expect("the best level");
    let model = Model::of(set);
    // The oracle knows displacements as they are stored. With a tolerance they differ from those that the set learned from,
    // and rounding may decide whether a rim is held.
    if set.options().tolerance.is_some() || model.close || model.held.len() != set.report().held_vertices {
        return;
    }
    let given = body.marks().expect("marks").to_vec();
    let list = marks::marks_of(&model, &given);
    let scaled = marks::scaled(&model, &list);
    let sizes = scaled.iter().map(|mark| marks::size(&model, mark));
    // A mark moves a vertex by at most the body's diagonal, before all are shortened to the depth limit.
    if sizes.fold(0.0, f64::max) > model.diagonal {
        return;
    }
    // The oracle computes every vertex from the marks, so each is a node here.
    let mut exact = ExampleSet::load_copy(&set.save().expect("a set of this version"), &Serial).expect("the same set");
    let every = BasisOptions { tolerance: 1e9, rounds: 0, nodes: usize::MAX };
    exact.learn_basis(&every, &Serial).expect("nodes");
    let exact = Arc::new(exact);
    let mut exact_body = Instance::new(exact.clone(), *body.options()).expect("an instance");
    exact_body.load(&body.save()).expect("the same marks");
    let mut shown = Output::new(&exact);
    shown.update(&mut exact_body, &Serial);
    let limit = f64::from(body.depth_limit());
    let free = marks::Limit { depth: f64::INFINITY, give: 1.0 };
    for (v, position) in shown.positions.iter().enumerate() {
        if list.iter().any(|mark| marks::on_a_border(&model, mark, v)) {
            continue;
        }
        let moved = marks::displacement(&model, &scaled, v, limit, free);
        let ought = add(model.positions[v], moved);
        let off = length(sub(from_f32(*position), ought));
        let mut allowed = marks::rounding(ought, rounded(&model, &scaled), limit.min(16.0 * model.depth_limit));
        if off > allowed {
            // Where little changes much, such as the energy of a small dent at the rim of a great one, rounding does too.
            for factor in [1.0 - 2e-4, 1.0 + 2e-4] {
                let near: Vec<_> = given.iter().map(|mark| Mark { depth: mark.depth * factor, ..*mark }).collect();
                let near = marks::marks_of(&model, &near);
                let other = marks::displacement(&model, &marks::scaled(&model, &near), v, limit, free);
                allowed += 2.0 * length(sub(other, moved));
            }
        }
        assert!(
            off <= allowed,
            "vertex {v} at {position:?} is {off:e} m from {ought:?}; {allowed:e} is allowed: {given:?}, {:?}",
            set.options()
        );
    }
}

/// The size of the displacements that the rounding of a stamp's weights is a share of. From one node to the next a
/// displacement may turn round, in both directions of the grid; the height may rise above where a dent has faded; and parts
/// that cancel each other at the contact are scaled up.
fn rounded(model: &Model, scaled: &[marks::Scaled<'_>]) -> f64 {
    let steep = |mark: &marks::Mark| {
        let grids = mark.parts.iter().filter_map(|part| model.examples[part.example].grid.as_ref());
        let rise = |heights: &[f64]| {
            let (low, high) = heights.iter().fold((f64::MAX, f64::MIN), |(a, b), h| (a.min(*h), b.max(*h)));
            high - low
        };
        grids.map(|grid| rise(&grid.heights) / grid.fade).fold(0.0, f64::max)
    };
    scaled.iter().map(|mark| marks::TOGETHER * 2.0 * (1.0 + steep(mark.0)) * marks::size(model, mark)).sum()
}

/// Memory for each attribute that the mesh has.
struct Output {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    tangents: Vec<[f32; 4]>,
    tracker: Tracker,
}

impl Output {
    fn new(set: &ExampleSet) -> Self {
        let (mesh, n) = (set.mesh(), set.vertex_count());
        let normals = vec![[0.0; 3]; if mesh.normals().is_some() { n } else { 0 }];
        let tangents = vec![[0.0; 4]; if mesh.tangents().is_some() { n } else { 0 }];
        Self { positions: vec![[0.0; 3]; n], normals, tangents, tracker: Tracker::new() }
    }

    fn update(&mut self, body: &mut Instance, tasks: &dyn TaskSystem) {
        let normals = (!self.normals.is_empty()).then_some(self.normals.as_mut_slice());
        let tangents = (!self.tangents.is_empty()).then_some(self.tangents.as_mut_slice());
        let memory = VertexMemory::separate(&mut self.positions, normals, tangents).expect("separate arrays");
        body.deform(&mut self.tracker, memory, tasks).expect("arrays of the set's length");
    }

    fn bits(&self) -> Vec<u32> {
        let vectors = [&self.positions, &self.normals].into_iter().flat_map(|list| list.as_flattened());
        vectors.chain(self.tangents.as_flattened()).map(|x| x.to_bits()).collect()
    }
}
