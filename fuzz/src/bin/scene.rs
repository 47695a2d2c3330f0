//! Random scenes: every SIMD level and number of threads gives the same bits, as does an update after each frame, and the
//! oracle of the tests agrees within rounding.
#![no_main]

use std::sync::{Arc, OnceLock};

use arbitrary::Unstructured;
use crumple::glam::{DVec3, Vec3};
use crumple::{ExampleSet, Instance, InstanceOptions, Mark, Serial, SimdLevel, TaskSystem, ThreadPool};
use crumple_fuzz::{scene, seeds, target};
use oracle::marks::{Limit, Shown};
use output::{Eager, Output};

#[path = "../../../tests/oracle/mod.rs"]
mod oracle;
#[allow(dead_code)]
#[path = "../../../tests/scenes/output.rs"]
mod output;

target!(
    |data| {
        let mut updated: Option<Output> = None;
        let update = |body: &mut Instance| {
            updated.get_or_insert_with(|| Output::new(body.example_set())).update(body);
        };
        if let Some(mut body) = scene::play(&mut Unstructured::new(data), update) {
            compare(&body.example_set().clone(), &mut body, &updated.expect("a frame"));
        }
    },
    seeds: seeds::noise
);

fn compare(set: &Arc<ExampleSet>, body: &mut Instance, updated: &Output) {
    static THREADS: OnceLock<Eager> = OnceLock::new();
    let threads = THREADS.get_or_init(|| Eager(ThreadPool::new(3).expect("three threads")));
    let best = SimdLevel::best();
    for level in SimdLevel::available() {
        level.force().expect("an available level");
        for tasks in [&Serial as &dyn TaskSystem, threads] {
            let mut fresh = Output::new(set);
            fresh.update_with(body, tasks);
            assert!(
                fresh.all_bits() == updated.all_bits(),
                "{level:?} with {} threads gives other bits",
                tasks.workers()
            );
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
    output::displacements(&mut body).iter().map(|u| u.as_dvec3()).collect()
}
