//! Frames that wait in the host's encoders, and devices with the limits of WebGPU.

use crumple::wgpu::wgpu;
use crumple::wgpu::{Device, DeviceDef, EncodeJob, Target};

use crate::backend::{buffer, on_each_device, read};
use crate::gpu::compare::Expected;
use crate::gpu::frames::dozen;
use crate::gpu::layout::TestLayout;
use crate::gpu::{folded, hit};
use crate::scenes;

fn encoder(crumple: &Device) -> wgpu::CommandEncoder {
    crumple.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
}

/// What is encoded reads its own words, however many command buffers are encoded before the first is submitted.
#[test]
fn several_frames_wait_in_encoders() {
    let set = scenes::cube_set();
    on_each_device(|gpu| {
        let (mut crumple, device) = (gpu.another(), &gpu.device);
        let layout = TestLayout::everything(&set, 0, 4);
        // A buffer for each frame in flight, as for meshes that are drawn while the next is made.
        let ring: Vec<_> = (0..3).map(|_| buffer(&crumple, layout.size + 4)).collect();
        let mut targets: Vec<Target> = ring.iter().map(|b| crumple.add_target(&set, &layout.def(b)).unwrap()).collect();
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
                let mut words = Expected::poison(ring[i].size() as usize / 4);
                layout.expect(&mut instance, &mut words);
                wanted.push(words);
            }
            crumple.queue().submit(waiting);
            for (buffer, wanted) in ring.iter().zip(&wanted) {
                wanted.compare(&read(&mut crumple, buffer), device, &format!("round {round}"));
            }
            if round == 2 {
                steady = crumple.objects_made();
            }
        }
        assert_eq!(crumple.objects_made(), steady, "something is made anew in every frame");
    });
}

#[test]
fn a_device_that_only_has_what_webgpu_guarantees_will_do() {
    on_each_device(|gpu| {
        for limits in [wgpu::Limits::default(), wgpu::Limits::downlevel_defaults()] {
            let mut hosted = gpu.hosted(|l| *l = limits.clone(), &DeviceDef::default()).unwrap();
            assert_eq!(dozen(&mut hosted), 1);
        }
    });
}
