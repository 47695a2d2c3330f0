//! Many outputs at once, on any number of threads, as each alone. Beyond a vertex budget outputs wait whole, and none for ever.

mod scenes;

use crumple::{DeformJob, DeformReport, Instance, Serial, TaskSystem, ThreadPool, deform_within};
use proptest::prelude::*;
use scenes::{Dice, Eager, Output, cases, new, push, random_hits, small_bodies};

/// Deforms all instances within a budget.
fn frame(instances: &mut [Instance], outputs: &mut [Output], budget: u64, tasks: &dyn TaskSystem) -> DeformReport {
    instances.iter_mut().for_each(Instance::fold);
    let jobs = instances.iter().zip(outputs).map(|(instance, output)| {
        let (tracker, memory) = output.memory();
        DeformJob { lod: 0, instance, tracker, memory }
    });
    deform_within(&mut jobs.collect::<Vec<_>>(), budget, tasks).unwrap()
}

proptest! {
    #![proptest_config(cases(30))]

    #[test]
    fn outputs_beyond_the_budget_wait_whole_and_get_the_same_vertices(seed: u64, threads in 0usize..4) {
        let tasks: &dyn TaskSystem = if threads == 0 { &Serial } else { &Eager(ThreadPool::new(threads).unwrap()) };
        let mut dice = Dice::new(seed);
        let mut instances: Vec<Instance> = (0..5).map(|_| new(&small_bodies()[dice.index(3)].1)).collect();
        let mut outputs: Vec<Output> = instances.iter().map(|i| Output::new(i.example_set())).collect();
        let all: u64 = instances.iter().map(|i| i.example_set().vertex_count() as u64).sum();
        // What holds nothing does not wait.
        prop_assert_eq!(frame(&mut instances, &mut outputs, 1, tasks).vertices_written, all);
        for step in 0..12 {
            // At the end nothing more happens.
            for instance in instances.iter_mut().filter(|_| step < 6) {
                for _ in 0..dice.index(3) {
                    instance.submit(&random_hits(instance.example_set(), 1, dice.next())[0]).unwrap();
                }
                instance.set_view(1.0, dice.between(0.0, 100.0), 1.0, 1000.0).unwrap();
            }
            let before: Vec<_> = outputs.iter().map(Output::all_bits).collect();
            let budget = [1 + dice.index(all as usize) as u64, u64::MAX][dice.index(4) / 3];
            let report = frame(&mut instances, &mut outputs, budget, tasks);
            let fresh: Vec<_> = instances.iter_mut().map(Output::fresh).collect();
            let is_done: Vec<bool> = outputs.iter().zip(&fresh).map(|(is, ought)| is.all_bits() == ought.all_bits()).collect();
            for i in 0..5 {
                prop_assert!(is_done[i] || outputs[i].all_bits() == before[i], "output {} is half written", i);
                prop_assert!(!is_done[i] || outputs[i].tracker.bounds() == fresh[i].tracker.bounds());
            }
            let is_done = is_done == [true; 5];
            let written = outputs.iter().filter(|o| !o.tracker.changed().is_empty()).count();
            prop_assert!(report.vertices_written <= budget || written == 1, "{:?} of {}", report, budget);
            prop_assert!(report.vertices_waiting > 0 || is_done);
            prop_assert!(report.vertices_waiting == 0 || report.vertices_written.saturating_add(report.vertices_waiting) > budget);
            prop_assert!(step < 10 || is_done, "{:?}", report);
        }
    }
}

#[test]
fn nothing_waits_for_ever_and_the_nearest_come_first() {
    let set = scenes::sheet_set();
    let mut instances: Vec<Instance> = (0..3).map(|_| new(&set)).collect();
    for (instance, distance) in instances.iter_mut().zip([0.0, 64.0, 32.0]) {
        instance.set_view(0.5, distance, 1.0, 1000.0).unwrap();
    }
    let mut outputs: Vec<Output> = (0..3).map(|_| Output::new(&set)).collect();
    frame(&mut instances, &mut outputs, u64::MAX, &Serial);
    let deep = push([0.0, 0.0, 0.0], [0.0, 0.0, -set.depth_limit()]);
    for instance in &instances[1..] {
        instance.submit(&deep).unwrap();
    }
    let mut seen = Vec::new();
    for _ in 0..200 {
        // The nearest one changes in every frame.
        instances[0].submit(&push([0.0, 0.0, 0.0], [0.0, 0.0, -0.02])).unwrap();
        frame(&mut instances, &mut outputs, 1, &Serial);
        seen.extend((0..3).find(|o| !outputs[*o].tracker.changed().is_empty()));
    }
    let first = |output: usize| seen.iter().position(|o| *o == output).unwrap();
    assert!(first(0) == 0 && first(0) < first(2) && first(2) < first(1), "{} {}", first(2), first(1));
    for (instance, output) in instances.iter_mut().zip(&outputs).skip(1) {
        assert_eq!(output.all_bits(), Output::fresh(instance).all_bits());
    }
}
