//! Devices and buffers that are refused.

use crumple::ErrorKind;
use crumple::wgpu::wgpu;
use crumple::wgpu::{Device, DeviceDef, HeadlessDef, adapters};

use crate::backend::on_each_device;
use crate::gpu::layout::TestLayout;
use crate::gpu::refusals::refused;
use crate::gpu::scene::Scene;
use crate::scenes;

#[test]
fn devices_that_will_not_do_are_refused() {
    use ErrorKind::Unsupported;
    let def = HeadlessDef { adapter: Some("no such thing"), ..HeadlessDef::default() };
    let there: Vec<String> = adapters(def.backends).into_iter().map(|a| a.name).collect();
    let mut words = vec!["no adapter named \"no such thing\""];
    words.extend(there.iter().map(String::as_str));
    refused(Device::headless(&def), Unsupported, &words);
    let none = HeadlessDef { backends: wgpu::Backends::empty(), ..HeadlessDef::default() };
    refused(Device::headless(&none), Unsupported, &["no adapter", "none"]);
    on_each_device(|gpu| {
        let lower = |change: fn(&mut wgpu::Limits)| gpu.hosted(change, &DeviceDef::default());
        let words = ["max_storage_buffers_per_shader_stage 3", "at least 4"];
        refused(lower(|l| l.max_storage_buffers_per_shader_stage = 3), Unsupported, &words);
        refused(lower(|l| l.max_bind_groups = 2), Unsupported, &["max_bind_groups 2", "at least 3"]);
    });
}

#[test]
fn buffers_that_will_not_do_are_refused() {
    use ErrorKind::{InvalidArgument, Vulkan};
    let set = scenes::cube_set();
    on_each_device(|gpu| {
        let layout = TestLayout::everything(&set, 0, 0);
        let (size, usage) = (layout.size, wgpu::BufferUsages::VERTEX);
        let descriptor = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
        let vertex = gpu.crumple.device().create_buffer(&descriptor);
        let added = gpu.crumple.add_target(&set, &layout.def(&vertex));
        refused(added, InvalidArgument, &["usage", "VERTEX", "STORAGE"]);
        // What wgpu itself refuses is an error of the call, and does not reach the host's handler of uncaptured errors.
        let [mut mine, mut other] = gpu.hosted(|_| (), &DeviceDef::default()).unwrap();
        mine.crumple.device().on_uncaptured_error(std::sync::Arc::new(|e| panic!("{e}")));
        let foreign = other.buffer(layout.size);
        refused(mine.add_target(&set, &layout, &foreign), Vulkan, &["binding a buffer", "wgpu"]);
        // A buffer that the host destroyed.
        let mut scene = Scene::of(gpu, &set, 6, 1);
        scene.buffer.0.destroy();
        refused(gpu.run(&mut scene.jobs()), Vulkan, &["submitting", "destroyed"]);
    });
}

#[test]
fn what_a_device_says_by_itself_is_the_next_error() {
    let set = scenes::ball_set();
    on_each_device(|gpu| {
        let mut gpu = gpu.another();
        let mut scene = Scene::of(&mut gpu, &set, 3, 1);
        // A mistake of the caller's own: the buffer is not that large.
        let seen = scene.buffer.0.clone();
        gpu.crumple.queue().write_buffer(&seen, seen.size(), &[0; 64]);
        refused(gpu.run(&mut scene.jobs()), ErrorKind::Vulkan, &["an earlier call"]);
        scene.run(&mut gpu);
        // A device that is lost takes nothing else with it.
        gpu.crumple.device().destroy();
        let _ = gpu.crumple.device().poll(wgpu::PollType::wait_indefinitely());
        scene.targets[0].invalidate();
        refused(gpu.run(&mut scene.jobs()), ErrorKind::DeviceLost, &["lost"]);
        refused(gpu.crumple.read(&seen, 0, &mut [0; 4]), ErrorKind::DeviceLost, &["lost"]);
    });
}
