//! Vertices come back into the CPU's memory.

use crumple::wgpu::{EncodeJob, wgpu};
use crumple::{ErrorKind, VertexMemory};

use crate::backend::{buffer, on_each_device};
use crate::gpu::compare::Expected;
use crate::gpu::layout::TestLayout;
use crate::gpu::refusals::refused;
use crate::gpu::{POISON, folded};
use crate::scenes;

#[test]
fn vertices_come_back_into_memory() {
    let set = scenes::cube_set();
    on_each_device(|gpu| {
        let (mut crumple, device) = (gpu.another(), &gpu.device);
        let layout = TestLayout::everything(&set, 0, 12);
        let seen = buffer(&crumple, layout.offset + layout.size);
        let mut target = crumple.add_target(&set, &layout.def(&seen)).unwrap();
        let mut instance = folded(&set, 9, 5);
        crumple.submit(&mut [EncodeJob { instance: &instance, target: &mut target }]).unwrap();
        let count = set.vertex_count();
        let (mut p, mut n, mut t) = (vec![[0.0; 3]; count], vec![[0.0; 3]; count], vec![[0.0; 4]; count]);
        let mut memory = VertexMemory::separate(&mut p, Some(&mut n), Some(&mut t)).unwrap();
        crumple.read_vertices(&set, &target, &mut memory).unwrap();
        let mut wanted = Expected::poison(seen.size() as usize / 4);
        layout.expect(&mut instance, &mut wanted);
        // Put what was read where the buffer holds it, so that it is compared as the buffer is.
        let mut got = vec![POISON; seen.size() as usize / 4];
        for v in 0..count {
            let values = [p[v].to_vec(), n[v].to_vec(), t[v].to_vec()];
            for (stream, value) in layout.streams.iter().zip(values) {
                let stream = stream.unwrap().0;
                let at = (layout.offset + stream.offset + v as u64 * stream.stride) as usize / 4;
                got[at..at + value.len()].copy_from_slice(&value.iter().map(|x| x.to_bits()).collect::<Vec<_>>());
            }
        }
        wanted.compare(&got, device, "read back");
    });
}

#[test]
fn readings_that_will_not_do_are_refused() {
    use ErrorKind::{BufferTooSmall, InvalidArgument, Misaligned, Unsupported};
    let set = scenes::ball_set();
    on_each_device(|gpu| {
        let mut crumple = gpu.another();
        let layout = TestLayout::everything(&set, 0, 0);
        let seen = buffer(&crumple, layout.size);
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
