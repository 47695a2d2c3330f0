//! Frames of many instances, on devices with low limits too.

use std::sync::Arc;

use crumple::{ExampleSet, Instance, SetOptions};

use super::compare::Expected;
use super::layout::TestLayout;
use super::{Lowered, folded, hit};
use crate::backend::{Gpu, Job, Report, Target, on_each_device};
use crate::scenes;

/// Jobs of all targets, in the order of their instances.
pub fn jobs<'a>(instances: &'a [Instance], targets: &'a mut [Target]) -> Vec<Job<'a>> {
    instances.iter().zip(targets).map(|(instance, target)| Job { instance, target }).collect()
}

#[test]
fn many_instances_in_one_buffer_are_one_dispatch() {
    let sets = [scenes::cube_set(), scenes::sheet_set(), scenes::ball_set()];
    on_each_device(|gpu| {
        let mut instances: Vec<Instance> = (0..20).map(|i| folded(&sets[i % 3], i, i as u64)).collect();
        let mut at = 12;
        let mut layouts = Vec::new();
        for i in &instances {
            let layout = TestLayout::everything(i.example_set(), 0, at);
            at += layout.size + 8;
            layouts.push(layout);
        }
        let buffer = gpu.buffer(at);
        let mut targets: Vec<Target> = Vec::new();
        for (i, layout) in instances.iter().zip(&layouts) {
            targets.push(gpu.add_target(i.example_set(), layout, &buffer).unwrap());
        }
        let mut expected = Expected::poison(buffer.words());
        for frame in 1..4 {
            let report = gpu.run(&mut jobs(&instances, &mut targets)).unwrap();
            assert_eq!(report.dispatches, 1);
            let changed: u64 = targets.iter().flat_map(|t| t.changed()).map(|r| u64::from(r.end - r.start)).sum();
            assert_eq!(report.vertices_written, changed);
            let all: u64 = instances.iter().map(|i| i.example_set().vertex_count() as u64).sum();
            assert!(frame > 1 || report.vertices_written == all);
            instances.iter_mut().zip(&layouts).for_each(|(i, l)| l.expect(i, &mut expected));
            expected.compare(&gpu.read(&buffer), &gpu.device, &format!("frame {frame}"));
            let few: Vec<usize> = (0..20).filter(|i| i % 7 == frame as usize).collect();
            few.iter().for_each(|i| hit(&mut instances[*i], 2, frame));
        }
        assert_eq!(gpu.run(&mut []).unwrap(), Report::default());
    });
}

#[test]
fn targets_beyond_the_budget_wait_whole() {
    let set = scenes::cube_set();
    on_each_device(|gpu| {
        let mut instances: Vec<Instance> = (0..3).map(|i| folded(&set, 2, i)).collect();
        let size = TestLayout::everything(&set, 0, 0).size;
        let layouts: Vec<TestLayout> = (0..3).map(|i| TestLayout::everything(&set, 0, i * size)).collect();
        let buffer = gpu.buffer(3 * size);
        let mut targets: Vec<Target> = layouts.iter().map(|l| gpu.add_target(&set, l, &buffer).unwrap()).collect();
        let all = 3 * set.vertex_count() as u64;
        gpu.crumple.set_vertex_budget(1);
        let report = gpu.run(&mut jobs(&instances, &mut targets)).unwrap();
        assert_eq!((report.vertices_written, report.vertices_waiting), (all, 0), "what holds nothing does not wait");
        let mut expected = Expected::poison(buffer.words());
        instances.iter_mut().zip(&layouts).for_each(|(i, l)| l.expect(i, &mut expected));
        instances.iter_mut().for_each(|i| hit(i, 1, 9));
        for round in 0..4 {
            let report = gpu.run(&mut jobs(&instances, &mut targets)).unwrap();
            let written: Vec<usize> = (0..3).filter(|t| !targets[*t].changed().is_empty()).collect();
            assert_eq!(written.len(), usize::from(round < 3));
            assert_eq!(report.vertices_waiting > 0, round < 2);
            written.iter().for_each(|t| layouts[*t].expect(&mut instances[*t], &mut expected));
            expected.compare(&gpu.read(&buffer), &gpu.device, &format!("round {round}"));
        }
    });
}

/// Writes a dozen meshes in one buffer. Returns the number of dispatches.
pub fn dozen(gpu: &mut Gpu) -> u32 {
    let mesh = scenes::sheet(16);
    let examples = scenes::bowls(&mesh, 3, 0.3, 1);
    let set = scenes::build(mesh, examples, SetOptions::default());
    let mut instances: Vec<Instance> = (0..12).map(|i| folded(&set, 4, i)).collect();
    let size = TestLayout::everything(&set, 0, 0).size;
    let layouts: Vec<TestLayout> = (0..12).map(|i| TestLayout::everything(&set, 0, 4 + i * (size + 4))).collect();
    let buffer = gpu.buffer(16 + 12 * (size + 4));
    let mut targets: Vec<Target> = layouts.iter().map(|l| gpu.add_target(&set, l, &buffer).unwrap()).collect();
    let report = gpu.run(&mut jobs(&instances, &mut targets)).unwrap();
    let mut expected = Expected::poison(buffer.words());
    instances.iter_mut().zip(&layouts).for_each(|(i, l)| l.expect(i, &mut expected));
    expected.compare(&gpu.read(&buffer), &gpu.device, "a dozen");
    report.dispatches
}

#[test]
fn dispatches_go_over_two_dimensions_where_one_is_too_short() {
    let lowered = Lowered { workgroups: Some(8), ..Lowered::default() };
    on_each_device(|gpu| assert_eq!(dozen(&mut gpu.lowered(lowered).unwrap()), 1));
}

#[test]
fn buffers_larger_than_a_binding_are_windowed() {
    // The mesh and its examples fit. At 128 KiB some targets fit, but not all.
    on_each_device(|gpu| {
        let dispatches = |bytes| {
            let lowered = Lowered { binding_bytes: Some(bytes), ..Lowered::default() };
            dozen(&mut gpu.lowered(lowered).unwrap())
        };
        assert_eq!(dispatches(1 << 20), 1, "all fit");
        let windowed = dispatches(1 << 17);
        assert!(windowed > 1, "{windowed}");
    });
}

#[test]
fn every_workgroup_size_gives_the_same() {
    on_each_device(|gpu| {
        for workgroup_size in [32, 64] {
            let mut gpu = gpu.lowered(Lowered { workgroup_size, ..Lowered::default() }).unwrap();
            assert_eq!(dozen(&mut gpu), 1);
        }
    });
}

#[test]
fn meshes_that_no_target_shows_leave_the_device() {
    on_each_device(|gpu| {
        let mut show = |set: &Arc<ExampleSet>, seed| {
            let layout = TestLayout::everything(set, 0, 0);
            let buffer = gpu.buffer(layout.size);
            let mut target = gpu.add_target(set, &layout, &buffer).unwrap();
            let mut instance = folded(set, 3, seed);
            gpu.run(&mut [Job { instance: &instance, target: &mut target }]).unwrap();
            let mut expected = Expected::poison(buffer.words());
            layout.expect(&mut instance, &mut expected);
            expected.compare(&gpu.read(&buffer), &gpu.device, "again");
            drop(target);
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
        let mut slot = || {
            let buffer = gpu.buffer(layout.size + 4);
            let target = gpu.add_target(&set, &layout, &buffer).unwrap();
            (buffer, target, Expected::poison(0))
        };
        let mut ring = [slot(), slot(), slot()];
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
        let layout = TestLayout::everything(&set, 0, 0);
        let buffer = gpu.buffer(layout.size);
        let mut target = gpu.add_target(&set, &layout, &buffer).unwrap();
        let mut instance = folded(&set, 5, 1);
        for _ in 0..3 {
            let job = Job { instance: &instance, target: &mut target };
            assert_eq!(gpu.drop_frame(&mut [job]).dispatches, 1);
            target.invalidate();
        }
        let mut expected = Expected::poison(buffer.words());
        expected.compare(&gpu.read(&buffer), &gpu.device, "not submitted");
        gpu.run(&mut [Job { instance: &instance, target: &mut target }]).unwrap();
        layout.expect(&mut instance, &mut expected);
        expected.compare(&gpu.read(&buffer), &gpu.device, "submitted");
    });
}
