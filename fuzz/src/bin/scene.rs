//! Random scenes: every SIMD level and number of threads gives the same bits, as does an update after each frame, and the
//! oracle of the tests agrees within rounding.
#![no_main]

use std::sync::{Arc, OnceLock};

use arbitrary::Unstructured;
use crumple::glam::{DVec3, Vec3};
use crumple::{
    ExampleSet, Instance, InstanceOptions, Mark, Serial, SimdLevel, TaskSystem, ThreadPool, Tracker, VertexMemory,
};
use crumple_fuzz::{scene, seeds, target};
use oracle::marks::{Limit, Shown};

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

fn compare(set: &Arc<ExampleSet>, body: &mut Instance, updated: &Output) {
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
    // The oracle adds up what each mark moves a vertex by, so there must be a node at each.
    if set.options().basis.is_none() {
        return;
    }
    let given = body.marks().expect("marks").to_vec();
    // Nodes move in steps of their limit.
    let most = 16.0 * set.depth_limit();
    let shown = Shown::of(&given, |mark| (alone(set, mark, most), most.into()));
    // Near the limit a field is not what its mark alone leaves.
    if shown.marks.iter().any(|mark| mark.longest() > 0.7 * mark.limit) {
        return;
    }
    let limit = f64::from(body.depth_limit().min(most));
    let free = Limit { depth: f64::INFINITY, give: 1.0 };
    for (v, position) in updated.positions.iter().enumerate() {
        let at = set.mesh().positions()[v].as_dvec3() + shown.displacement(v, limit, free);
        let off = Vec3::from(*position).as_dvec3().distance(at);
        let allowed = shown.doubt(v, limit, free) + 4e-7 * at.length();
        assert!(
            off <= allowed,
            "vertex {v} at {position:?} is {off:e} m from {at:?}; {allowed:e} is allowed: {given:?}, {:?}",
            set.options()
        );
    }
}

/// The displacements of all vertices by one hit of a mark alone, m, if it moves none of them by nearly `most`.
fn alone(set: &Arc<ExampleSet>, mark: &Mark, most: f32) -> Vec<DVec3> {
    let options = InstanceOptions { depth_limit: Some(most), ..InstanceOptions::default() };
    let mut body = Instance::new(set.clone(), options).expect("an instance");
    body.set_marks(&[Mark { energy: Mark::ONE, ..*mark }]).expect("a mark of the set");
    let mut output = Output::new(set);
    output.update(&mut body, &Serial);
    let moved = output.positions.iter().zip(set.mesh().positions());
    moved.map(|(to, from)| Vec3::from(*to).as_dvec3() - from.as_dvec3()).collect()
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
