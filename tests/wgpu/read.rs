//! Vertices come back into the CPU's memory.

use crumple::wgpu::wgpu;
use crumple::{ErrorKind, VertexMemory};

use crate::backend::on_each_device;
use crate::gpu::layout::TestLayout;
use crate::gpu::refusals::refused;
use crate::gpu::scene::Scene;
use crate::scenes;

#[test]
fn vertices_come_back_into_memory() {
    let set = scenes::cube_set();
    on_each_device(|gpu| {
        let mut scene = Scene::of(gpu, &set, 9, 5);
        scene.run(gpu);
        let mut out = scenes::Output::new(&set);
        gpu.crumple.read_vertices(&set, &scene.targets[0], &mut out.memory().1).unwrap();
        scene.check(gpu, "written");
        let cpu = scenes::Output::fresh(&mut scene.instances[0]);
        assert!(!gpu.device.exact() || out.all_bits() == cpu.all_bits());
    });
}

#[test]
fn readings_that_will_not_do_are_refused() {
    use ErrorKind::{BufferTooSmall, InvalidArgument, Misaligned, Unsupported};
    let set = scenes::ball_set();
    on_each_device(|gpu| {
        let layout = TestLayout::everything(&set, 0, 0);
        let seen = gpu.buffer(layout.size).0;
        let crumple = &mut gpu.crumple;
        let mut bytes = [7; 8];
        refused(crumple.read(&seen, 2, &mut bytes), Misaligned, &["offset", "2"]);
        refused(crumple.read(&seen, 0, &mut bytes[..3]), Misaligned, &["bytes to read", "3"]);
        refused(crumple.read(&seen, layout.size - 4, &mut bytes), BufferTooSmall, &["buffer"]);
        refused(crumple.read(&seen, u64::MAX - 3, &mut bytes), BufferTooSmall, &["buffer"]);
        let usage = wgpu::BufferUsages::STORAGE;
        let descriptor = wgpu::BufferDescriptor { label: None, size: 64, usage, mapped_at_creation: false };
        let sealed = crumple.device().create_buffer(&descriptor);
        refused(crumple.read(&sealed, 0, &mut bytes), InvalidArgument, &["usage", "COPY_SRC"]);
        assert_eq!(bytes, [7; 8]);
        let target = crumple.add_target(&set, &layout.def(&seen)).unwrap();
        let count = set.vertex_count();
        let (mut p, mut t) = (vec![[0.0; 3]; count], vec![[0.0; 4]; count]);
        let mut memory = VertexMemory::separate(&mut p, None, Some(&mut t)).unwrap();
        refused(crumple.read_vertices(&set, &target, &mut memory), Unsupported, &["tangents"]);
        let mut memory = VertexMemory::separate(&mut p[1..], None, None).unwrap();
        refused(crumple.read_vertices(&set, &target, &mut memory), BufferTooSmall, &["position"]);
        let other = scenes::cube_set();
        let mut memory = VertexMemory::separate(&mut p, None, None).unwrap();
        refused(crumple.read_vertices(&other, &target, &mut memory), InvalidArgument, &["set"]);
    });
}
