//! Frames of many instances, on devices with low limits too.

use std::sync::Arc;

use crumple::{ExampleSet, SetOptions};

use super::compare::Expected;
use super::layout::TestLayout;
use super::scene::Scene;
use super::{Lowered, folded, hit};
use crate::backend::{Gpu, Job, Report, on_each_device};
use crate::scenes;

#[test]
fn many_instances_in_one_buffer_are_one_dispatch() {
    let sets = [scenes::cube_set(), scenes::sheet_set(), scenes::ball_set()];
    on_each_device(|gpu| {
        let mut scene = Scene::new(gpu, (0..20).map(|i| folded(&sets[i % 3], i, i as u64)).collect());
        let all: u64 = scene.instances.iter().map(|i| i.example_set().vertex_count() as u64).sum();
        for frame in 1..4 {
            let report = scene.run(gpu);
            assert_eq!(report.dispatches, 1);
            let changed: u64 = scene.targets.iter().flat_map(|t| t.changed()).map(|r| u64::from(r.end - r.start)).sum();
            assert_eq!(report.vertices_written, changed);
            assert!(frame > 1 || report.vertices_written == all);
            scene.check(gpu, &format!("frame {frame}"));
            scene.instances.iter_mut().skip(frame as usize).step_by(7).for_each(|i| hit(i, 2, frame));
        }
        assert_eq!(gpu.run(&mut []).unwrap(), Report::default());
    });
}

#[test]
fn targets_beyond_the_budget_wait_whole() {
    let set = scenes::cube_set();
    on_each_device(|gpu| {
        let mut scene = Scene::new(gpu, (0..3).map(|i| folded(&set, 2, i)).collect());
        let all = 3 * set.vertex_count() as u64;
        gpu.crumple.set_vertex_budget(1);
        let report = scene.run(gpu);
        assert_eq!((report.vertices_written, report.vertices_waiting), (all, 0), "what holds nothing does not wait");
        scene.check(gpu, "first");
        scene.instances.iter_mut().for_each(|i| hit(i, 1, 9));
        for round in 0..4 {
            let report = scene.run(gpu);
            let written: Vec<usize> = (0..3).filter(|t| !scene.targets[*t].changed().is_empty()).collect();
            assert_eq!(written.len(), usize::from(round < 3));
            assert_eq!(report.vertices_waiting > 0, round < 2);
            scene.expect(written);
            scene.compare(gpu, &format!("round {round}"));
        }
    });
}

/// Writes a dozen meshes in one buffer. Returns the number of dispatches.
pub fn dozen(gpu: &mut Gpu) -> u32 {
    let mesh = scenes::sheet(16);
    let examples = scenes::bowls(&mesh, 3, 0.3, 1);
    let set = scenes::build(mesh, examples, SetOptions::default());
    let mut scene = Scene::new(gpu, (0..12).map(|i| folded(&set, 4, i)).collect());
    let report = scene.run(gpu);
    scene.check(gpu, "a dozen");
    report.dispatches
}

/// Dispatches go over two dimensions where one is too short, and buffers larger than a binding are windowed.
#[test]
fn low_limits_and_every_workgroup_size_give_the_same() {
    let plain = Lowered::default();
    for (lowered, windowed) in [
        (Lowered { workgroups: Some(8), ..plain }, false),
        (Lowered { workgroup_size: 32, ..plain }, false),
        (Lowered { workgroup_size: 64, ..plain }, false),
        // The mesh and its examples fit. At 128 KiB some targets fit, but not all.
        (Lowered { binding_bytes: Some(1 << 20), ..plain }, false),
        (Lowered { binding_bytes: Some(1 << 17), ..plain }, true),
    ] {
        on_each_device(|gpu| {
            let dispatches = dozen(&mut gpu.lowered(lowered).unwrap());
            assert_eq!(dispatches > 1, windowed, "{lowered:?}: {dispatches}");
        });
    }
}

#[test]
fn meshes_that_no_target_shows_leave_the_device() {
    on_each_device(|gpu| {
        let mut show = |set: &Arc<ExampleSet>, seed| {
            let mut scene = Scene::of(gpu, set, 3, seed);
            scene.run(gpu);
            scene.check(gpu, "again");
            drop(scene);
            gpu.frame_done();
            gpu.crumple.objects_made()
        };
        // Each time it is another set. If the chunks stayed, one would do for all.
        let made: Vec<u64> = (0..4).map(|i| show(&scenes::sheet_set(), i)).collect();
        let each: Vec<u64> = made.windows(2).map(|m| m[1] - m[0]).collect();
        assert!(each.iter().all(|n| *n > gpu.objects_per_target()), "{made:?}");
    });
}

/// Each frame is recorded while the two before it are not done, into a buffer of its own, as for meshes that are drawn while the
/// next is made.
#[test]
fn several_frames_are_in_flight() {
    let set = scenes::cube_set();
    on_each_device(|gpu| {
        let layout = TestLayout::everything(&set, 0, 4);
        let mut instance = folded(&set, 0, 0);
        let mut ring = [(); 3].map(|()| {
            let buffer = gpu.buffer(layout.size + 4);
            let target = gpu.add_target(&set, &layout, &buffer).unwrap();
            (buffer, target, Expected::poison(0))
        });
        let mut steady = 0;
        for frame in 1..=24 {
            let (buffer, target, expected) = &mut ring[frame % 3];
            if frame > 3 {
                gpu.finish();
                expected.compare(&gpu.read(buffer), &gpu.device, &format!("frame {}", frame - 3));
            }
            hit(&mut instance, 1, frame as u64);
            gpu.start(&mut [Job { instance: &instance, target }]);
            *expected = Expected::poison(buffer.words());
            layout.expect(&mut instance, expected);
            if frame == 8 {
                steady = gpu.crumple.objects_made();
            }
        }
        assert_eq!(gpu.crumple.objects_made(), steady, "something is made anew in every frame");
        (0..3).for_each(|_| gpu.finish());
    });
}

#[test]
fn what_was_not_submitted_is_written_again() {
    let set = scenes::sheet_set();
    on_each_device(|gpu| {
        let mut scene = Scene::of(gpu, &set, 5, 1);
        for _ in 0..3 {
            assert_eq!(gpu.drop_frame(&mut scene.jobs()).dispatches, 1);
            scene.targets[0].invalidate();
        }
        scene.compare(gpu, "not submitted");
        scene.run(gpu);
        scene.check(gpu, "submitted");
    });
}
