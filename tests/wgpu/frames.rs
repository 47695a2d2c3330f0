//! Frames as engines have them: many instances, several in flight, encoders of the host's.

use crumple::wgpu::wgpu;
use crumple::wgpu::{Device, DeviceDef, EncodeJob, EncodeReport, Target};
use crumple::{ExampleSet, Instance, SetOptions};
use std::sync::Arc;

use crate::harness::{Gpu, POISON, buffer, on_each_device, read};
use crate::{Plan, folded, hit, same, scenes};

/// Jobs of all targets, in the order of their instances.
fn jobs<'a>(instances: &'a [Instance], targets: &'a mut [Target]) -> Vec<EncodeJob<'a>> {
    instances.iter().zip(targets).map(|(instance, target)| EncodeJob { instance, target }).collect()
}

fn encoder(crumple: &Device) -> wgpu::CommandEncoder {
    crumple.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
}

#[test]
fn many_instances_in_one_buffer_are_one_dispatch() {
    let sets = [scenes::cube_set(), scenes::sheet_set(), scenes::ball_set()];
    on_each_device(|gpu| {
        let mut crumple = gpu.crumple();
        let mut instances: Vec<Instance> = (0..20).map(|i| folded(&sets[i % 3], i, i as u64)).collect();
        let mut at = 12;
        let plans: Vec<Plan> = instances
            .iter()
            .map(|i| {
                let plan = Plan::everything(i.example_set(), 0, at);
                at += plan.size + 8;
                plan
            })
            .collect();
        let seen = buffer(&crumple, at);
        let add = |(i, p): (&Instance, &Plan)| crumple.add_target(i.example_set(), &p.def(&seen)).unwrap();
        let mut targets: Vec<Target> = instances.iter().zip(&plans).map(add).collect();
        let mut wanted = vec![POISON; seen.size() as usize / 4];
        for frame in 1..4 {
            let report = crumple.submit(&mut jobs(&instances, &mut targets)).unwrap();
            assert_eq!(report.dispatches, 1);
            let changed: u64 = targets.iter().flat_map(|t| t.changed()).map(|r| u64::from(r.end - r.start)).sum();
            assert_eq!(report.vertices_written, changed);
            instances.iter().zip(&plans).for_each(|(i, p)| p.expect(i, &mut wanted));
            same(&read(&mut crumple, &seen), &wanted, &format!("frame {frame}"));
            let few: Vec<usize> = (0..20).filter(|i| i % 7 == frame as usize).collect();
            few.iter().for_each(|i| hit(&mut instances[*i], 2, frame));
        }
        assert_eq!(crumple.submit(&mut []).unwrap(), EncodeReport::default());
    });
}

/// What is encoded reads its own words, however many command buffers are encoded before the first is submitted.
#[test]
fn several_frames_wait_in_encoders() {
    let set = scenes::cube_set();
    on_each_device(|gpu| {
        let mut crumple = gpu.crumple();
        let plan = Plan::everything(&set, 0, 4);
        // A buffer for each frame in flight, as for meshes that are drawn while the next is made.
        let ring: Vec<_> = (0..3).map(|_| buffer(&crumple, plan.size + 4)).collect();
        let mut targets: Vec<Target> = ring.iter().map(|b| crumple.add_target(&set, &plan.def(b)).unwrap()).collect();
        let mut instance = folded(&set, 0, 0);
        let mut steady = 0;
        for round in 0..6u64 {
            let mut waiting = Vec::new();
            let mut wanted = Vec::new();
            for (i, target) in targets.iter_mut().enumerate() {
                hit(&mut instance, 1, 3 * round + i as u64);
                let mut encoder = encoder(&crumple);
                crumple.encode(&mut encoder, &mut [EncodeJob { instance: &instance, target }]).unwrap();
                waiting.push(encoder.finish());
                let mut words = vec![POISON; ring[i].size() as usize / 4];
                plan.expect(&instance, &mut words);
                wanted.push(words);
            }
            crumple.queue().submit(waiting);
            for (buffer, wanted) in ring.iter().zip(&wanted) {
                same(&read(&mut crumple, buffer), wanted, &format!("round {round}"));
            }
            if round == 2 {
                steady = crumple.objects_made();
            }
        }
        assert_eq!(crumple.objects_made(), steady, "something is made anew in every frame");
    });
}

#[test]
fn what_was_not_submitted_is_encoded_again() {
    let set = scenes::sheet_set();
    on_each_device(|gpu| {
        let mut crumple = gpu.crumple();
        let plan = Plan::everything(&set, 0, 0);
        let seen = buffer(&crumple, plan.size);
        let mut target = crumple.add_target(&set, &plan.def(&seen)).unwrap();
        let instance = folded(&set, 5, 1);
        let mut made = 0;
        for frame in 0..4 {
            let mut dropped = encoder(&crumple);
            let job = EncodeJob { instance: &instance, target: &mut target };
            assert_eq!(crumple.encode(&mut dropped, &mut [job]).unwrap().dispatches, 1);
            drop(dropped);
            target.invalidate();
            if frame == 0 {
                made = crumple.objects_made();
            }
        }
        // Each encoder that was dropped took its staging buffer with it, and nothing else.
        assert_eq!(crumple.objects_made(), made + 3);
        assert!(read(&mut crumple, &seen).iter().all(|w| *w == POISON));
        crumple.submit(&mut [EncodeJob { instance: &instance, target: &mut target }]).unwrap();
        let mut wanted = vec![POISON; seen.size() as usize / 4];
        plan.expect(&instance, &mut wanted);
        same(&read(&mut crumple, &seen), &wanted, "after those that were not submitted");
    });
}

/// A dozen meshes in one buffer, on a host's device with lower limits.
fn limited(gpu: &Gpu, change: impl Fn(&mut wgpu::Limits), def: DeviceDef) -> u32 {
    let [(device, queue), _] = gpu.hosts(change);
    let mut crumple = Device::new(&device, &queue, &def).unwrap();
    let mesh = scenes::sheet(24);
    let mut examples = scenes::bowls(&mesh, 3, 0.3, 1);
    examples.iter_mut().for_each(|e| e.placement = crumple::Placement::Anchored);
    let set = scenes::build(mesh, examples, SetOptions::default());
    let instances: Vec<Instance> = (0..12).map(|i| folded(&set, 4, i)).collect();
    let size = Plan::everything(&set, 0, 0).size;
    let plans: Vec<Plan> = (0..12).map(|i| Plan::everything(&set, 0, 4 + i * (size + 4))).collect();
    let seen = buffer(&crumple, 16 + 12 * (size + 4));
    let mut targets: Vec<Target> = plans.iter().map(|p| crumple.add_target(&set, &p.def(&seen)).unwrap()).collect();
    let report = crumple.submit(&mut jobs(&instances, &mut targets)).unwrap();
    let mut wanted = vec![POISON; seen.size() as usize / 4];
    instances.iter().zip(&plans).for_each(|(i, p)| p.expect(i, &mut wanted));
    same(&read(&mut crumple, &seen), &wanted, &gpu.name);
    report.dispatches
}

#[test]
fn a_device_that_only_has_what_webgpu_guarantees_will_do() {
    on_each_device(|gpu| {
        assert_eq!(limited(gpu, |l| *l = wgpu::Limits::default(), DeviceDef::default()), 1);
        let least = |l: &mut wgpu::Limits| *l = wgpu::Limits::downlevel_defaults();
        assert_eq!(limited(gpu, least, DeviceDef::default()), 1);
    });
}

#[test]
fn dispatches_go_over_two_dimensions_where_one_is_too_short() {
    let few = |l: &mut wgpu::Limits| l.max_compute_workgroups_per_dimension = 8;
    on_each_device(|gpu| assert_eq!(limited(gpu, few, DeviceDef::default()), 1));
}

#[test]
fn buffers_larger_than_a_binding_are_windowed() {
    on_each_device(|gpu| {
        let of = |most| limited(gpu, |l| l.max_storage_buffer_binding_size = most, DeviceDef::default());
        assert_eq!(of(1 << 20), 1, "all fit");
        let dispatches = of(1 << 17);
        assert!(dispatches > 1, "{dispatches}");
    });
}

#[test]
fn every_workgroup_size_gives_the_same() {
    on_each_device(|gpu| {
        for workgroup_size in [32, 64, 256] {
            assert_eq!(limited(gpu, |_| (), DeviceDef { workgroup_size }), 1);
        }
    });
}

#[test]
fn meshes_that_no_target_shows_leave_the_device() {
    on_each_device(|gpu| {
        let mut crumple = gpu.crumple();
        let mut show = |set: &Arc<ExampleSet>, seed| {
            let plan = Plan::everything(set, 0, 0);
            let seen = buffer(&crumple, plan.size);
            let mut target = crumple.add_target(set, &plan.def(&seen)).unwrap();
            let instance = folded(set, 3, seed);
            crumple.submit(&mut [EncodeJob { instance: &instance, target: &mut target }]).unwrap();
            let mut wanted = vec![POISON; seen.size() as usize / 4];
            plan.expect(&instance, &mut wanted);
            same(&read(&mut crumple, &seen), &wanted, "again");
            crumple.objects_made()
        };
        // Another set each time: were the chunks kept, one would do for all.
        let made: Vec<u64> = (0..4).map(|i| show(&scenes::sheet_set(), i)).collect();
        assert!(made.windows(2).all(|m| m[0] < m[1]), "{made:?}");
    });
}
