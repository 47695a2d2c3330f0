//! Baked sets: every width of numbers, SIMD level and number of threads gives the same bits, and examples are within the set's tolerance.

mod scenes;

use crumple::glam::Vec3;
use crumple::{Hit, Serial, SetOptions, SimdLevel, TaskSystem, ThreadPool};
use scenes::{Dice, Output, new, random_hits};

/// Positions must not depend on whether normals are also written, which uses other kernels.
#[test]
fn levels_widths_and_threads_give_the_same_bits() {
    let pool = scenes::Eager(ThreadPool::new(3).unwrap());
    for body in ["panel", "tube"] {
        for tolerance in [None, Some(1e-6), Some(1e-5), Some(1e-4), Some(1e-3), Some(1e-2)] {
            let (mut mesh, examples) = scenes::solver(body, 8);
            if tolerance == Some(1e-3) {
                let (mut dice, n) = (Dice::new(4), mesh.positions.len());
                mesh.depth_limits =
                    Some((0..n).map(|_| [f32::INFINITY, dice.between(0.0, 0.02)][dice.index(2)]).collect());
                mesh.stiffness = Some((0..n).map(|_| dice.unit()).collect());
            }
            let set = scenes::build(mesh, examples, SetOptions { tolerance, ..SetOptions::default() });
            let e = &set.examples()[1];
            let own = Hit::displacement(e.contact_point().into(), (e.contact_displacement() * 0.7).into());
            // A single dent, then many of all kinds.
            for hits in [0, 25] {
                let hits: Vec<Hit> = [own].into_iter().chain(random_hits(&set, hits, 9)).collect();
                let mut instance = scenes::dented(&set, Default::default(), &hits);
                let mut seen: Option<Vec<[u32; 10]>> = None;
                for level in SimdLevel::available() {
                    level.force().unwrap();
                    for tasks in [&Serial as &dyn TaskSystem, &pool] {
                        let mut out = Output::new(&set);
                        out.update_with(&mut instance, tasks);
                        let alike = scenes::positions_with(&mut instance, tasks).0 == out.positions
                            && *seen.get_or_insert_with(|| out.all_bits()) == out.all_bits();
                        assert!(alike, "{body} {tolerance:?} {:?} {level:?}", set.report().blocks_by_width);
                    }
                }
            }
        }
    }
}

/// Hits are compared with the given displacement of an example's contact, however coarsely displacements are stored.
#[test]
fn examples_are_within_the_tolerance_and_their_contacts_not_rounded() {
    for body in ["panel", "tube"] {
        let build = |tolerance| scenes::solver_with(body, 6, SetOptions { tolerance, ..SetOptions::default() });
        let exact = build(None);
        for tolerance in [1e-6f32, 1e-4, 1e-3, 1e-2] {
            let set = build(Some(tolerance));
            for (a, b) in exact.examples().iter().zip(set.examples()).filter(|(_, b)| !b.is_empty()) {
                assert_eq!(a.contact_displacement(), b.contact_displacement());
                assert_eq!((a.depth(), a.support_radius()), (b.depth(), b.support_radius()));
                let off = |v: u32| a.delta(v).as_dvec3().distance(b.delta(v).as_dvec3());
                let worst = (0..set.vertex_count() as u32).map(off).fold(0.0, f64::max);
                assert!(worst <= f64::from(tolerance) + 1e-9, "{body} {}: {worst} > {tolerance}", a.name());
                let outcome = new(&set).submit(&scenes::own_hit(b)).unwrap();
                assert!(!outcome.clamped && Vec3::from(outcome.shortfall()).length() <= tolerance + 1e-3 * b.depth());
            }
        }
    }
}
