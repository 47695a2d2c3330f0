//! Secondary command buffers, other queue families, cached pipelines.

use crumple::vulkan::{BufferDef, Device, Job, vk};

use crate::backend;
use crate::gpu::compare::Expected;
use crate::gpu::layout::TestLayout;
use crate::gpu::scene::Scene;
use crate::gpu::{folded, hit};
use crate::harness::{Tampered, families, on_each_device, tampered};
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
            let mut jobs = [Job { instance: &instance, target: &mut target }];
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

#[test]
fn secondary_command_buffers_do() {
    let set = scenes::ball_set();
    backend::on_each_device(|gpu| {
        let mut scene = Scene::of(gpu, &set, 3, 7);
        let inner = gpu.engine.begin(vk::CommandBufferLevel::SECONDARY);
        // SAFETY: the command buffers are recording.
        unsafe {
            gpu.crumple.record(inner, 1, &mut scene.jobs()).unwrap();
            gpu.engine.device.end_command_buffer(inner).unwrap();
            gpu.engine.run(|c| gpu.engine.device.cmd_execute_commands(c, &[inner]));
        }
        gpu.crumple.completed(1);
        scene.check(gpu, "secondary");
    });
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
