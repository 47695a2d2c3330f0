//! The same vertices as the CPU's.

use std::sync::Arc;

use crumple::wgpu::{Device, EncodeJob, Encoding};
use crumple::{Combine, ExampleSet, Instance, InstanceOptions, Placement, Rule, Serial, SetOptions, VertexMemory};

use crate::harness::{Gpu, POISON, buffer, on_each_device, read};
use crate::{Plan, folded, hit, same, scenes};

/// Bodies of every kind: exact and baked, in each width, by each way to combine, carried and anchored, with a held rim.
fn sets() -> Vec<(String, Arc<ExampleSet>)> {
    let mut all: Vec<(String, Arc<ExampleSet>)> =
        scenes::small_bodies().into_iter().map(|(n, s)| (n.to_owned(), s)).collect();
    let sheet = |options: SetOptions| {
        let mesh = scenes::sheet(30);
        let examples = scenes::bowls(&mesh, 5, 0.3, 3);
        scenes::build(mesh, examples, options)
    };
    for (tolerance, name) in [(3e-3, "8 bits"), (1e-5, "16 bits"), (1e-7, "floats")] {
        let options = SetOptions { tolerance: Some(tolerance), ..SetOptions::default() };
        all.push((format!("sheet in {name}"), sheet(options)));
    }
    for combine in [Combine::Sum, Combine::Deepest] {
        let options = SetOptions { combine, depth_limit: Some(0.05), ..SetOptions::default() };
        all.push((format!("{combine:?}"), sheet(options)));
    }
    for placement in [Placement::Anchored, Placement::Carried] {
        let mesh = scenes::cube(12);
        let mut examples = scenes::bowls(&mesh, 6, 0.4, 5);
        examples.iter_mut().for_each(|e| e.placement = placement);
        all.push((format!("{placement:?} cube"), scenes::build(mesh, examples, SetOptions::default())));
    }
    all.push(("panel".into(), scenes::solver_set("panel", 6, Placement::Automatic)));
    all
}

/// Submits an instance again and again as it changes, and compares the whole buffer each time.
fn compare(
    (gpu, crumple): (&Gpu, &mut Device),
    name: &str,
    instance: &mut Instance,
    plan: &Plan,
    mut change: impl FnMut(&mut Instance, u64) -> bool,
) {
    let seen = buffer(crumple, plan.offset + plan.size + 64);
    let mut target = crumple.add_target(&instance.example_set().clone(), &plan.def(&seen)).unwrap();
    let mut wanted = vec![POISON; seen.size() as usize / 4];
    for frame in 1.. {
        let report = crumple.submit(&mut [EncodeJob { instance, target: &mut target }]).unwrap();
        plan.expect(instance, &mut wanted);
        same(&read(crumple, &seen), &wanted, &format!("{name} on {}, frame {frame}, {report:?}", gpu.name));
        let bounds = target.bounds().unwrap();
        for v in 0..if plan.lod == 0 { instance.example_set().vertex_count() as u32 } else { 0 } {
            let p = instance.displaced(v).unwrap();
            assert!(bounds.distance_squared(p) == 0.0, "{name}: vertex {v} at {p} is outside {bounds:?}");
        }
        if !change(instance, frame) {
            break;
        }
    }
}

#[test]
fn vertices_are_those_of_the_cpu() {
    let sets = sets();
    on_each_device(|gpu| {
        let mut crumple = gpu.crumple();
        for (name, set) in &sets {
            let mut instance = Instance::new(set.clone(), InstanceOptions::default()).unwrap();
            let plan = Plan::everything(set, 0, 20);
            compare((gpu, &mut crumple), name, &mut instance, &plan, |instance, frame| {
                match frame {
                    1 => hit(instance, 1, 7),
                    2 => hit(instance, 30, 9),
                    3 => instance.set_tolerance(set.depth_limit() * 0.1).unwrap(),
                    4 => instance.set_depth_limit(Some(set.depth_limit() * 0.3)).unwrap(),
                    5 => instance.repair(0.5).unwrap(),
                    _ => instance.reset(),
                }
                frame < 7
            });
        }
    });
}

#[test]
fn positions_alone_and_normals_alone_are_the_same() {
    let set = scenes::cube_set();
    let float = Some(Encoding::F32);
    on_each_device(|gpu| {
        let mut crumple = gpu.crumple();
        // Tangents without normals too.
        for encodings in [[float, None, None], [float, float, None], [float, None, float]] {
            let plan = Plan::interleaved(&set, 0, 8, encodings);
            compare((gpu, &mut crumple), "cube", &mut folded(&set, 9, 3), &plan, |_, _| false);
        }
    });
}

#[test]
fn levels_of_detail_show_the_same_damage() {
    let mesh = scenes::cube(16);
    let examples = scenes::bowls(&mesh, 6, 0.4, 5);
    let mut set = ExampleSet::build(mesh, examples, SetOptions::default(), &Serial).unwrap();
    set.add_lod(scenes::cube(6), &Serial).unwrap();
    let set = Arc::new(set);
    on_each_device(|gpu| {
        let mut crumple = gpu.crumple();
        for lod in 0..2 {
            let plan = Plan::everything(&set, lod, 4);
            compare((gpu, &mut crumple), "lod", &mut folded(&set, 5, 3), &plan, |i, frame| {
                hit(i, 3, frame);
                frame < 3
            });
        }
    });
}

#[test]
fn classic_rules_are_those_of_the_cpu() {
    let baked = |tolerance| {
        let mesh = scenes::sheet(30);
        let examples = scenes::bowls(&mesh, 5, 0.3, 3);
        scenes::build(mesh, examples, SetOptions { tolerance: Some(tolerance), ..SetOptions::default() })
    };
    let sets = [scenes::cube_set(), scenes::ball_set(), baked(3e-3), baked(1e-5)];
    on_each_device(|gpu| {
        let mut crumple = gpu.crumple();
        for (set, rule) in sets.iter().zip([Rule::MostDisplaced, Rule::Blend(0.3), Rule::Blend(0.0), Rule::Blend(1.0)])
        {
            let unclamped = crumple::Selection::ClassicUnclamped;
            let options = InstanceOptions { selection: unclamped, ..InstanceOptions::classic(rule) };
            for plan in [Plan::everything(set, 0, 8), Plan::interleaved(set, 0, 0, [Some(Encoding::F32), None, None])] {
                let mut instance = Instance::new(set.clone(), options).unwrap();
                // Undamaged in the first frame; then more hits than the journal holds, and what no journal tells.
                compare((gpu, &mut crumple), &format!("{rule:?}"), &mut instance, &plan, |i, frame| {
                    match frame {
                        3 => hit(i, 300, frame),
                        5 => i.repair(0.7).unwrap(),
                        7 => i.reset(),
                        _ => hit(i, 1 + 7 * (frame as usize % 3), frame),
                    }
                    frame < 8
                });
            }
        }
    });
}

#[test]
fn formats_are_converted_as_rust_does() {
    let set = scenes::cube_set();
    let positions = [Encoding::F32, Encoding::F16x4, Encoding::Snorm16x4];
    let others = [Encoding::F32, Encoding::Snorm16x4, Encoding::Snorm8x4];
    on_each_device(|gpu| {
        let mut crumple = gpu.crumple();
        for (p, n) in positions.into_iter().zip(others) {
            for t in others {
                let plan = Plan::interleaved(&set, 0, 16, [Some(p), Some(n), Some(t)]);
                let name = format!("{p:?} {n:?} {t:?}");
                compare((gpu, &mut crumple), &name, &mut folded(&set, 9, 5), &plan, |i, frame| {
                    hit(i, 9, frame);
                    frame < 2
                });
            }
        }
    });
}

#[test]
fn vertices_come_back_into_memory() {
    let set = scenes::cube_set();
    on_each_device(|gpu| {
        let mut crumple = gpu.crumple();
        let plan = Plan::everything(&set, 0, 12);
        let seen = buffer(&crumple, plan.offset + plan.size);
        let mut target = crumple.add_target(&set, &plan.def(&seen)).unwrap();
        let instance = folded(&set, 9, 5);
        crumple.submit(&mut [EncodeJob { instance: &instance, target: &mut target }]).unwrap();
        let count = set.vertex_count();
        let (mut p, mut n, mut t) = (vec![[0.0; 3]; count], vec![[0.0; 3]; count], vec![[0.0; 4]; count]);
        let mut memory = VertexMemory::separate(&mut p, Some(&mut n), Some(&mut t)).unwrap();
        crumple.read_vertices(&set, &target, &mut memory).unwrap();
        let mut wanted = vec![POISON; seen.size() as usize / 4];
        plan.expect(&instance, &mut wanted);
        for v in 0..count {
            let all = p[v].iter().chain(&n[v]).chain(&t[v]).map(|x| x.to_bits());
            let from = |i: usize, n: usize| {
                let stream = plan.streams[i].unwrap().0;
                let at = (plan.offset + stream.offset + v as u64 * stream.stride) as usize / 4;
                wanted[at..at + n].to_vec()
            };
            same(&all.collect::<Vec<_>>(), &[from(0, 3), from(1, 3), from(2, 4)].concat(), "read back");
        }
    });
}

/// What a host's device gets that takes no SPIR-V: kernels that wgpu translates, and a driver that may fuse and reorder. Stated
/// in src/wgpu/mod.rs.
#[test]
fn translated_kernels_are_off_by_a_few_units_at_most() {
    let sets = sets();
    on_each_device(|gpu| {
        let [(device, queue), _] = gpu.hosts(|_| ());
        let mut crumple = Device::new(&device, &queue, &Default::default()).unwrap();
        for (name, set) in &sets {
            let plan = Plan::everything(set, 0, 0);
            let seen = buffer(&crumple, plan.size);
            let mut target = crumple.add_target(set, &plan.def(&seen)).unwrap();
            let instance = folded(set, 12, 9);
            crumple.submit(&mut [EncodeJob { instance: &instance, target: &mut target }]).unwrap();
            let got = read(&mut crumple, &seen);
            let mut wanted = vec![POISON; got.len()];
            plan.expect(&instance, &mut wanted);
            // Unit in the last place of the largest coordinate, and of 1 for normals and tangents.
            let bounds = set.lod_mesh(0).unwrap().bounds();
            let largest = bounds.min.abs().max(bounds.max.abs()).max_element() + set.depth_limit();
            let units = [largest, 1.0, 1.0].map(|x| x * f32::EPSILON);
            let mut worst = [0.0f32; 3];
            for v in 0..set.vertex_count() {
                for (i, stream) in plan.streams.iter().enumerate() {
                    let Some((stream, _)) = stream else { continue };
                    let at = ((stream.offset + v as u64 * stream.stride) / 4) as usize;
                    for at in at..at + if i == 2 { 4 } else { 3 } {
                        let off = f32::from_bits(got[at]) - f32::from_bits(wanted[at]);
                        worst[i] = worst[i].max(off.abs() / units[i]);
                    }
                }
            }
            println!("{name} on {}: off by {worst:?} units", gpu.name);
            assert!(worst[0] <= 4.0 && worst[1] <= 16.0 && worst[2] <= 16.0, "{name} on {}: {worst:?}", gpu.name);
        }
    });
}
