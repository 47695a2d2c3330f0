//! Kernels that wgpu translates, for a host's device that takes no SPIR-V. Its driver may fuse and reorder operations, so vertices are
//! compared within the bounds that tests/gpu/compare.rs has for such devices.

use crumple::wgpu::{DeviceDef, wgpu};

use crate::backend::on_each_device;
use crate::gpu::frames::dozen;
use crate::gpu::scene::Scene;
use crate::gpu::vertices::sets;

#[test]
fn translated_kernels_are_off_by_a_few_units_at_most() {
    let sets = sets();
    on_each_device(|gpu| {
        let [mut hosted, _] = gpu.hosted(|_| (), &DeviceDef::default()).unwrap();
        for (name, set) in &sets {
            let mut scene = Scene::of(&mut hosted, set, 12, 9);
            scene.run(&mut hosted);
            scene.check(&mut hosted, name);
        }
    });
}

#[test]
fn a_device_that_only_has_what_webgpu_guarantees_will_do() {
    on_each_device(|gpu| {
        for limits in [wgpu::Limits::default(), wgpu::Limits::downlevel_defaults()] {
            let [mut hosted, _] = gpu.hosted(|l| *l = limits.clone(), &DeviceDef::default()).unwrap();
            assert_eq!(dozen(&mut hosted), 1);
        }
    });
}
