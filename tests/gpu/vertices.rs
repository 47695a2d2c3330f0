//! The vertices are the CPU's.

use std::sync::Arc;

use crumple::{ExampleSet, Instance, InstanceOptions, Mark, Rule, Serial, SetOptions};

use super::layout::TestLayout;
use super::scene::Scene;
use super::{folded, hit};
use crate::backend::{Encoding, Gpu, on_each_device};
use crate::scenes::{self, Dice};

fn sheet(options: SetOptions) -> Arc<ExampleSet> {
    let mesh = scenes::sheet(30);
    let examples = scenes::bowls(&mesh, 5, 0.3, 3);
    scenes::build(mesh, examples, options)
}

fn baked(tolerance: f32) -> Arc<ExampleSet> {
    sheet(SetOptions { tolerance: Some(tolerance), ..SetOptions::default() })
}

/// Bodies of every kind: exact and baked, in each width, carried and anchored, with a held rim.
pub fn sets() -> Vec<(String, Arc<ExampleSet>)> {
    let mut all: Vec<(String, Arc<ExampleSet>)> =
        scenes::small_bodies().into_iter().map(|(n, s)| (n.to_owned(), s)).collect();
    for (tolerance, name) in [(3e-3, "8 bits"), (1e-5, "16 bits"), (1e-7, "floats")] {
        all.push((format!("sheet in {name}"), baked(tolerance)));
    }
    all.push(("flat sheet".into(), sheet(SetOptions { depth_limit: Some(0.05), ..SetOptions::default() })));
    let cube = scenes::cube(12);
    let bowls = scenes::bowls(&cube, 6, 0.4, 5);
    all.push(("fine cube".into(), scenes::build(cube, bowls, SetOptions::default())));
    all.push(("limits".into(), limited()));
    let mut points = scenes::sheet(20);
    (points.normals, points.tangents, points.triangles) = (None, None, Vec::new());
    all.push(("points".into(), scenes::build(points, vec![scenes::poke(21, 0.1)], SetOptions::default())));
    let cube = scenes::cube(16);
    let bowls = scenes::bowls(&cube, 6, 0.4, 5);
    let mut levels = ExampleSet::build(cube, bowls, SetOptions::default(), &Serial).unwrap();
    levels.add_lod(scenes::cube(6), &Serial).unwrap();
    all.push(("levels of detail".into(), Arc::new(levels)));
    all.push(("panel".into(), scenes::solver_set("panel", 6)));
    all.push(("cube that has learned".into(), scenes::learned(&scenes::cube(6), 12, 6)));
    all
}

/// A sheet with a limit and a stiffness for each vertex.
fn limited() -> Arc<ExampleSet> {
    let mut mesh = scenes::sheet(30);
    let examples = scenes::bowls(&mesh, 5, 0.3, 3);
    let limit = |v: usize| if v.is_multiple_of(5) { f32::INFINITY } else { 0.001 * (v % 60) as f32 };
    mesh.depth_limits = Some((0..mesh.positions.len()).map(limit).collect());
    mesh.stiffness = Some((0..mesh.positions.len()).map(|v| 0.1 * (v % 7) as f32).collect());
    scenes::build(mesh, examples, SetOptions::default())
}

/// Marks that no hit would make.
fn any_marks(set: &ExampleSet, count: usize, dice: &mut Dice) -> Vec<Mark> {
    let mut all = Vec::new();
    for _ in 0..count {
        let depth = set.depth_limit() * dice.between(0.01, 2.0);
        let energy = [1 << 20, Mark::ONE, 5 * Mark::ONE][dice.index(3)];
        let (contact, direction) = (dice.index(set.vertex_count()) as u32, [dice.next() as u16, dice.next() as u16]);
        all.push(Mark { contact, depth, energy, direction, ..bytemuck::Zeroable::zeroed() });
    }
    all
}

/// Writes an instance again and again as it changes, and compares the whole buffer each time.
fn compare(
    gpu: &mut Gpu,
    name: &str,
    instance: Instance,
    layout: &TestLayout,
    mut change: impl FnMut(&mut Instance, u64) -> bool,
) {
    let mut scene = Scene::at(gpu, vec![instance], vec![*layout]);
    for frame in 1.. {
        let report = scene.run(gpu);
        scene.check(gpu, &format!("{name}, frame {frame}, {report:?}"));
        let (instance, bounds) = (&mut scene.instances[0], scene.targets[0].bounds().unwrap());
        let count = if layout.lod == 0 { instance.example_set().vertex_count() as u32 } else { 0 };
        for v in 0..count {
            let p = instance.displaced(v).unwrap();
            assert!(bounds.distance_squared(p) == 0.0, "{name}: vertex {v} at {p} is outside {bounds:?}");
        }
        if !change(instance, frame) {
            break;
        }
    }
}

/// Of all levels of detail; dents of small bodies that grow, too.
#[test]
fn vertices_are_those_of_the_cpu() {
    let sets = sets();
    let cases = sets.iter().enumerate().flat_map(|(i, (name, set))| {
        let grow_times = if i < 3 { &[0.0, 1.0][..] } else { &[0.0] };
        (0..set.lod_count()).flat_map(move |lod| grow_times.iter().map(move |grow_time| (name, set, lod, *grow_time)))
    });
    let cases: Vec<_> = cases.collect();
    on_each_device(|gpu| {
        for (name, set, lod, grow_time) in &cases {
            let options = InstanceOptions { grow_time: *grow_time, ..InstanceOptions::default() };
            let instance = Instance::new((*set).clone(), options).unwrap();
            let layout = TestLayout::everything(set, *lod, 20);
            compare(gpu, &format!("{name}, {lod}, {grow_time}"), instance, &layout, |instance, frame| {
                instance.set_time(0.3 * frame as f64).unwrap();
                match frame {
                    1 => hit(instance, 1, 7),
                    2 => hit(instance, 2, 8),
                    3 => hit(instance, 30, 9),
                    4 => instance.set_depth_limit(Some(set.depth_limit() * 0.3)).unwrap(),
                    5 => instance.set_marks(&any_marks(set, 12, &mut Dice::new(11))).unwrap(),
                    6 => hit(instance, 5, 6),
                    7 => instance.repair(0.5).unwrap(),
                    8 | 9 => {}
                    _ => instance.reset(),
                }
                frame < 11
            });
        }
    });
}

#[test]
fn classic_rules_are_those_of_the_cpu() {
    let sets = [scenes::cube_set(), scenes::ball_set(), baked(3e-3), baked(1e-5), limited()];
    let rules = [Rule::MostDisplaced, Rule::Blend(0.3), Rule::Blend(0.0), Rule::Blend(1.0), Rule::Blend(0.5)];
    let positions = [Some(Encoding::F32), None, None];
    on_each_device(|gpu| {
        for (set, rule) in sets.iter().zip(rules) {
            let unclamped = crumple::Selection::ClassicUnclamped;
            let options = InstanceOptions { selection: unclamped, ..InstanceOptions::classic(rule) };
            for layout in [TestLayout::everything(set, 0, 8), TestLayout::interleaved(set, 0, 0, positions)] {
                let instance = Instance::new(set.clone(), options).unwrap();
                // The first frame is undamaged. Then come more hits than the journal holds, and changes that it does not hold.
                compare(gpu, &format!("{rule:?}"), instance, &layout, |i, frame| {
                    match frame {
                        4 => hit(i, 300, frame),
                        6 => i.repair(0.7).unwrap(),
                        8 => i.reset(),
                        _ => hit(i, 1 + 7 * (frame as usize % 3), frame),
                    }
                    frame < 10
                });
                let mut damaged = Instance::new(set.clone(), options).unwrap();
                hit(&mut damaged, 20, 5);
                compare(gpu, "damaged before", damaged, &layout, |i, frame| {
                    hit(i, 1, frame);
                    frame < 2
                });
            }
        }
    });
}

#[test]
fn formats_are_converted_as_rust_does() {
    let set = scenes::cube_set();
    let positions = [Encoding::F32, Encoding::F16x4, Encoding::Snorm16x4, Encoding::F32];
    let others = [Encoding::F32, Encoding::Snorm16x4, Encoding::Snorm8x4, Encoding::Octahedral16x2];
    let pairs = positions.into_iter().zip(others);
    let mut all: Vec<_> = pairs.flat_map(|(p, n)| others.map(|t| [p, n, t].map(Some))).collect();
    // Positions alone, and normals and tangents without the others.
    let float = Some(Encoding::F32);
    all.extend([[float, None, None], [float, float, None], [float, None, float]]);
    on_each_device(|gpu| {
        for encodings in &all {
            let layout = TestLayout::interleaved(&set, 0, 16, *encodings);
            compare(gpu, &format!("{encodings:?}"), folded(&set, 9, 5), &layout, |i, frame| {
                hit(i, 9, frame);
                frame < 2
            });
        }
    });
}
