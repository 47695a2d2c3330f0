//! Baked sets: every width of numbers, kind of stamp, SIMD level and number of threads gives the same bits. An example
//! is within the set's tolerance at any weight. The reference is computed in f64 from the repository's source files.

mod scenes;

use std::sync::Arc;

use crumple::glam::{DVec3, Vec3};
use crumple::{
    Deltas, ExampleData, ExampleSet, Hit, Instance, Mark, Mirror, Pair, Placement, Serial, SetOptions, SimdLevel,
    TaskSystem, ThreadPool, Tracker, VertexMemory,
};
use scenes::{new, random_hits};

fn written(instance: &mut Instance, normals: bool, tasks: &dyn TaskSystem) -> Vec<u32> {
    let n = instance.example_set().vertex_count();
    let (mut positions, mut turned) = (vec![[f32::NAN; 3]; n], vec![[0.0f32; 3]; n]);
    let memory = VertexMemory::separate(&mut positions, normals.then_some(&mut turned[..]), None).unwrap();
    let report = instance.deform(&mut Tracker::new(), memory, tasks).unwrap();
    assert_eq!(report.vertices_written, n as u64);
    positions.iter().chain(&turned).flatten().map(|x| x.to_bits()).collect()
}

/// Positions must not depend on whether normals are also written, which uses other kernels.
#[test]
fn levels_widths_and_threads_give_the_same_bits() {
    let pool = scenes::Eager(ThreadPool::new(3).unwrap());
    for body in ["panel", "tube"] {
        for tolerance in [None, Some(1e-6), Some(1e-5), Some(1e-4), Some(1e-3), Some(1e-2)] {
            let (mesh, mut examples) = scenes::solver(body);
            examples.truncate(8);
            examples[1].placement = Placement::Anchored;
            let set = scenes::build(mesh, examples, SetOptions { tolerance, ..SetOptions::default() });
            let widths = set.report().blocks_by_width;
            let e = &set.examples()[1];
            let alone = |share: i16| {
                let mut pairs = [Pair::NONE; 4];
                pairs[0] = Pair::anchored(1, share);
                Mark::new(e.contact_vertex(), 0.7 * e.depth(), pairs)
            };
            // A single anchored dent, then many of all kinds.
            for hits in [0, 25] {
                let mut instance = new(&set);
                if hits == 0 {
                    instance.set_marks(&[alone(Pair::WHOLE)]).unwrap();
                }
                for hit in random_hits(&set, hits, 9) {
                    instance.submit(&hit).unwrap();
                }
                let mut seen: Option<Vec<u32>> = None;
                for level in SimdLevel::available() {
                    level.force().unwrap();
                    for tasks in [&Serial as &dyn TaskSystem, &pool] {
                        let (bare, full) = (written(&mut instance, false, tasks), written(&mut instance, true, tasks));
                        let n = 3 * set.vertex_count();
                        assert!(bare[..n] == full[..n], "{body} {tolerance:?} {widths:?} {level:?}");
                        let seen = seen.get_or_insert_with(|| full.clone());
                        assert!(*seen == full, "{body} {tolerance:?} {widths:?} {level:?}");
                    }
                }
            }
        }
    }
}

/// Compares an example's displacements in the file with those that the set stores.
#[test]
fn no_vertex_is_further_off_than_the_tolerance() {
    for body in ["panel", "tube"] {
        let (mesh, mut examples) = scenes::solver(body);
        examples.truncate(6);
        examples.iter_mut().for_each(|e| e.placement = Placement::Anchored);
        for tolerance in [1e-6f32, 1e-5, 1e-4, 1e-3, 1e-2] {
            let options = SetOptions { tolerance: Some(tolerance), depth_limit: Some(10.0), ..SetOptions::default() };
            let set = scenes::build(mesh.clone(), examples.clone(), options);
            for (i, source) in examples.iter().enumerate() {
                let truth = displacements(source, set.vertex_count());
                let e = &set.examples()[i];
                if e.is_empty() {
                    continue;
                }
                let off = |(v, d): (usize, &DVec3)| (e.delta(v as u32).as_dvec3() - *d).length();
                let worst = truth.iter().enumerate().map(off).fold(0.0, f64::max);
                assert!(worst <= f64::from(tolerance) + 1e-9, "{body} {i}: {worst} > {tolerance}");
            }
        }
    }
}

/// Hits are compared with the given displacement of an example's contact, however coarsely displacements are stored.
#[test]
fn contacts_are_not_rounded() {
    for body in ["panel", "tube"] {
        let (mesh, mut examples) = scenes::solver(body);
        examples.truncate(6);
        let build = |tolerance| {
            let options = SetOptions { tolerance, ..SetOptions::default() };
            scenes::build(mesh.clone(), examples.clone(), options)
        };
        let exact = build(None);
        for tolerance in [1e-4f32, 1e-3, 1e-2] {
            let set = build(Some(tolerance));
            for (i, (a, b)) in
                exact.examples().iter().zip(set.examples()).enumerate().filter(|(_, (_, b))| !b.is_empty())
            {
                assert_eq!(a.contact_displacement(), b.contact_displacement());
                assert_eq!((a.depth(), a.support_radius()), (b.depth(), b.support_radius()));
                let hit = Hit::displacement(b.contact_point().into(), b.contact_displacement().into());
                let outcome = new(&set).submit(&hit).unwrap();
                let chosen = outcome.chosen[0].unwrap();
                assert_eq!(
                    (chosen.example, chosen.scale, outcome.chosen[1]),
                    (i as u32, 1.0, None),
                    "{body} {tolerance}"
                );
                assert!(!outcome.clamped && Vec3::from(outcome.shortfall()).length() <= 1e-6 * b.depth());
            }
        }
    }
}

fn displacements(e: &ExampleData, n: usize) -> Vec<DVec3> {
    let vector = |d: &[f32; 3]| Vec3::from(*d).as_dvec3();
    match &e.positions {
        Deltas::Full(d) => d.iter().map(vector).collect(),
        Deltas::Sparse { indices, values } => {
            let mut out = vec![DVec3::ZERO; n];
            indices.iter().zip(values).for_each(|(v, d)| out[*v as usize] = vector(d));
            out
        }
    }
}

/// A stamp holds the tolerance with as few nodes as possible, or has the most nodes allowed. The first test runs mirror
/// images too.
#[test]
fn stamps_get_the_coarsest_grid_that_holds_the_tolerance() {
    let (mesh, examples) = scenes::solver("panel");
    let stamps = |tolerance, stamp_resolution| -> Vec<(u32, f32)> {
        let options = SetOptions { tolerance, stamp_resolution, ..SetOptions::default() };
        let set: Arc<ExampleSet> = scenes::build(mesh.clone(), examples[..4].to_vec(), options);
        assert!(set.report().mirror_planes != Mirror::NONE);
        set.examples().iter().filter_map(|e| e.stamp()).map(|s| (s.dims()[0], s.error().max)).collect()
    };
    let coarser = |n: u32| stamps(None, n);
    for (i, (nodes, error)) in stamps(Some(1e-2), 64).into_iter().enumerate() {
        assert!(nodes == 64 || error <= 1e-2, "{i}: {nodes} nodes, {error} m");
        assert!(nodes == 4 || coarser(nodes - 1)[i].1 > 1e-2, "{i}: {nodes} nodes");
    }
    assert!(stamps(Some(1e-6), 32).iter().chain(&stamps(None, 32)).all(|s| s.0 == 32));
}
