//! Frames in flight, secondary command buffers, other queue families, cached pipelines.

use crumple::ExampleSet;
use crumple::vulkan::{BufferDef, Device, RecordJob, Target, vk};
use std::sync::Arc;

use crate::gpu::compare::Expected;
use crate::gpu::layout::TestLayout;
use crate::gpu::{folded, hit};
use crate::harness::{Engine, Tampered, families, on_each_device, tampered};
use crate::scenes;

#[test]
fn buffers_of_other_queue_families_are_taken_and_given_back() {
    let set = scenes::sheet_set();
    on_each_device(|engine| {
        let def = tampered(engine.def(), Tampered { watch: true, ..Tampered::default() });
        // SAFETY: valid handles.
        let mut crumple = unsafe { Device::new(&def) }.unwrap();
        let layout = TestLayout::everything(&set, 0, 0);
        let seen = engine.buffer(layout.size);
        // The one other family that software drivers know.
        let external = vk::QUEUE_FAMILY_EXTERNAL;
        // SAFETY: a valid buffer that lives until the engine is dropped.
        let id = unsafe { crumple.add_buffer(&BufferDef { queue_family: external, ..seen.def() }) }.unwrap();
        let mut instance = folded(&set, 3, 7);
        let mut target = crumple.add_target(&set, &layout.def(id)).unwrap();
        families();
        for frame in 1..5 {
            let mut jobs = [RecordJob { instance: &instance, target: &mut target }];
            // SAFETY: the command buffer is recording.
            let report = engine.run(|c| unsafe { crumple.record(c, frame, &mut jobs) }).unwrap();
            crumple.completed(frame);
            assert_eq!(report.blocks_written > 0, frame % 2 == 1, "frame {frame}");
            let ours: Vec<_> = families().into_iter().filter(|b| b.0 == seen.handle).map(|b| (b.1, b.2)).collect();
            assert_eq!(ours, [(external, 0), (0, external)], "frame {frame}");
            let mut wanted = Expected::poison(seen.words().len());
            layout.expect(&mut instance, &mut wanted);
            wanted.compare(seen.words(), &engine.tested, &format!("frame {frame}"));
            if frame == 2 {
                hit(&mut instance, 1, 9);
            }
        }
    });
}

/// Records frame after frame without waiting for any but the third before.
fn in_flight(engine: &Engine, set: &Arc<ExampleSet>, level: vk::CommandBufferLevel) {
    const FLIGHT: usize = 3;
    let mut crumple = engine.crumple();
    let layout = TestLayout::everything(set, 0, 4);
    let mut instance = folded(set, 0, 0);
    // A buffer for each frame in flight, as for meshes that are drawn while the next is made.
    let ring: Vec<_> = (0..FLIGHT).map(|_| engine.target_buffer(&mut crumple, layout.size + 4)).collect();
    let mut targets: Vec<Target> =
        ring.iter().map(|(_, id)| crumple.add_target(set, &layout.def(*id)).unwrap()).collect();
    let info = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
    // SAFETY: valid arguments, here and below.
    let fences: Vec<vk::Fence> =
        (0..FLIGHT).map(|_| unsafe { engine.device.create_fence(&info, None) }.unwrap()).collect();
    let (mut steady, mut all) = (0, vec![Expected::poison(0); FLIGHT]);
    for frame in 1..=24u64 {
        let i = frame as usize % FLIGHT;
        // SAFETY: as above.
        unsafe {
            engine.device.wait_for_fences(&[fences[i]], true, u64::MAX).unwrap();
            engine.device.reset_fences(&[fences[i]]).unwrap();
        }
        if frame > FLIGHT as u64 {
            crumple.completed(frame - FLIGHT as u64);
            all[i].compare(ring[i].0.words(), &engine.tested, &format!("frame {}", frame - FLIGHT as u64));
        }
        hit(&mut instance, 1, frame);
        let commands = engine.begin(vk::CommandBufferLevel::PRIMARY);
        let mut jobs = [RecordJob { instance: &instance, target: &mut targets[i] }];
        if level == vk::CommandBufferLevel::SECONDARY {
            let inner = engine.begin(level);
            // SAFETY: as above.
            unsafe {
                crumple.record(inner, frame, &mut jobs).unwrap();
                engine.device.end_command_buffer(inner).unwrap();
                engine.device.cmd_execute_commands(commands, &[inner]);
            }
        } else {
            // SAFETY: as above.
            unsafe { crumple.record(commands, frame, &mut jobs) }.unwrap();
        }
        engine.submit(commands, fences[i]);
        all[i] = Expected::poison(ring[i].0.words().len());
        layout.expect(&mut instance, &mut all[i]);
        if frame == 8 {
            steady = crumple.objects_made();
        }
    }
    assert_eq!(crumple.objects_made(), steady, "something is made anew in every frame");
    engine.wait();
    crumple.completed(24);
    // SAFETY: the device has done all.
    fences.iter().for_each(|f| unsafe { engine.device.destroy_fence(*f, None) });
}

#[test]
fn several_frames_are_in_flight() {
    on_each_device(|engine| in_flight(engine, &scenes::cube_set(), vk::CommandBufferLevel::PRIMARY));
}

#[test]
fn secondary_command_buffers_do() {
    on_each_device(|engine| in_flight(engine, &scenes::ball_set(), vk::CommandBufferLevel::SECONDARY));
}

#[test]
fn pipelines_are_cached() {
    on_each_device(|engine| {
        let data = engine.crumple().pipeline_cache_data().unwrap();
        assert!(data.len() >= 32);
        for data in [&data[..], &data[..20], &[7; 100], &[]] {
            let def = crumple::vulkan::DeviceDef { pipeline_cache: data, ..engine.def() };
            // SAFETY: valid handles.
            assert_eq!(unsafe { crumple::vulkan::Device::new(&def) }.unwrap().recorded(), 0);
        }
    });
}
