//! Kernels that wgpu translates, for a host's device that takes no SPIR-V. Its driver may fuse and reorder operations, so the
//! vertices are off by a few units, as src/wgpu/mod.rs states.

use crumple::wgpu::{DeviceDef, wgpu};

use crate::backend::on_each_device;
use crate::gpu::compare::{Bounds, Expected};
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
            let (got, layout, instance) = (hosted.read(&scene.buffer), scene.layouts[0], &mut scene.instances[0]);
            let mut wanted = Expected::poison(got.len());
            layout.expect(instance, &mut wanted);
            // Unit in the last place of the largest coordinate, and of 1 for normals and tangents.
            let bounds = set.lod_mesh(0).unwrap().bounds();
            let largest = bounds.min.abs().max(bounds.max.abs()).max_element() + set.depth_limit();
            let units = [largest, 1.0, 1.0].map(|x| x * f32::EPSILON);
            let mut worst = [0.0f32; 3];
            for v in 0..set.vertex_count() {
                for (i, stream) in layout.streams.iter().enumerate() {
                    let Some((stream, _)) = stream else { continue };
                    let at = ((layout.offset + stream.offset + v as u64 * stream.stride) / 4) as usize;
                    let of = at..at + if i == 2 { 4 } else { 3 };
                    for (g, w) in got[of.clone()].iter().zip(&wanted.words()[of]) {
                        let off = f32::from_bits(*g) - f32::from_bits(*w);
                        worst[i] = worst[i].max(off.abs() / units[i]);
                    }
                }
            }
            let on = &gpu.device.name;
            println!("{name} on {on}: off by {worst:?} units");
            // Other devices may also divide otherwise: tests/gpu/compare.rs.
            let [position, direction] = if gpu.device.exact() {
                [4.0, 32.0]
            } else {
                let bounds = Bounds::of(instance);
                [4.0 + bounds.position / units[0], 32.0 + bounds.direction / units[1]]
            };
            let good = worst.iter().zip([position, direction, direction]).all(|(off, most)| *off <= most);
            assert!(good, "{name} on {on}: {worst:?}");
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
