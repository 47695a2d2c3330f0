//! Costs that a scene chooses. The runtime tolerance: no vertex is wrong by more, seams stay closed bit for bit, an output
//! updated in steps equals a new one, and work is saved. The vertex budget: outputs wait whole, and none for ever.

mod scenes;

use std::sync::Arc;

use crumple::{
    DeformJob, DeformReport, ErrorKind, ExampleSet, Instance, InstanceOptions, Placement, Rule, Serial, SetOptions,
    deform_within, pixel_tolerance,
};
use proptest::prelude::*;
use scenes::{
    Body, Dice, Output, bowls, build, cases, coincident, cube, positions, push, random_hits, sheet, small_bodies,
};

fn with(set: &Arc<ExampleSet>, tolerance: f32) -> Instance {
    Instance::new(set.clone(), InstanceOptions { tolerance, ..InstanceOptions::default() }).unwrap()
}

fn furthest(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let distance =
        |p: &[f32; 3], q: &[f32; 3]| (0..3).map(|k| (f64::from(p[k]) - f64::from(q[k])).powi(2)).sum::<f64>().sqrt();
    a.iter().zip(b).map(|(p, q)| distance(p, q)).fold(0.0, f64::max)
}

/// Bodies with exact and with rounded displacements.
fn bodies() -> &'static [Body] {
    static BODIES: std::sync::OnceLock<Vec<Body>> = std::sync::OnceLock::new();
    BODIES.get_or_init(|| {
        let mut all = small_bodies();
        let mesh = cube(10);
        let mut examples = bowls(&mesh, 6, 0.5, 5);
        examples[1].placement = Placement::Anchored;
        let options = SetOptions { tolerance: Some(1e-4), stamp_resolution: 12, ..SetOptions::default() };
        all.push(("baked", build(mesh, examples, options)));
        all
    })
}

proptest! {
    #![proptest_config(cases(60))]

    #[test]
    fn no_vertex_is_wrong_by_more(body in 0usize..4, seed: u64, count in 1usize..40, fine in 0.0f32..12.0) {
        let set = &bodies()[body].1;
        let mut exact = with(set, 0.0);
        for hit in random_hits(set, count, seed) {
            exact.submit(&hit).unwrap();
        }
        let tolerance = set.depth_limit() * 0.5f32.powf(fine);
        let mut coarse = with(set, tolerance);
        coarse.copy_damage_from(&mut exact).unwrap();
        prop_assert!(coarse.tolerance() <= tolerance && coarse.tolerance() * 2.0 > tolerance);
        let (wanted, _) = positions(&mut exact);
        let (got, _) = positions(&mut coarse);
        // Two roundings to f32, of coordinates and of displacements of about 1 m.
        let off = furthest(&wanted, &got);
        prop_assert!(off <= f64::from(coarse.tolerance()) + 4e-7, "{off} of {}", coarse.tolerance());
        let full = Output::fresh(&mut coarse);
        prop_assert_eq!(&full.positions, &got, "positions depend on whether normals are written");
    }

    #[test]
    fn seams_stay_closed_while_everything_changes(body in 0usize..4, seed: u64) {
        let set = &bodies()[body].1;
        let mut dice = Dice::new(seed);
        let mut instance = with(set, 0.0);
        let mut output = Output::new(set);
        let rest: Vec<[f32; 3]> = set.mesh().positions().iter().map(|p| p.to_array()).collect();
        let normals = set.mesh().normals().unwrap();
        let groups = coincident(&rest);
        for _ in 0..12 {
            match dice.index(6) {
                0 => instance.set_tolerance(set.depth_limit() * 0.5f32.powi(dice.index(9) as i32)).unwrap(),
                1 => instance.set_tolerance(0.0).unwrap(),
                2 => instance.repair(0.7).unwrap(),
                _ => {
                    for hit in random_hits(set, 1 + dice.index(6), dice.next()) {
                        instance.submit(&hit).unwrap();
                    }
                }
            }
            output.update(&mut instance);
            // Blocks written at different times equal those written at once.
            prop_assert_eq!(output.all_bits(), Output::fresh(&mut instance).all_bits());
            for g in &groups {
                for v in g {
                    prop_assert_eq!(output.positions[*v].map(f32::to_bits), output.positions[g[0]].map(f32::to_bits));
                    if normals[*v] == normals[g[0]] {
                        prop_assert_eq!(output.normals[*v].map(f32::to_bits), output.normals[g[0]].map(f32::to_bits));
                    }
                }
            }
        }
    }
}

/// Deforms all instances within a budget.
fn frame(instances: &mut [Instance], outputs: &mut [Output], budget: u64) -> DeformReport {
    instances.iter_mut().for_each(Instance::fold);
    let jobs = instances.iter().zip(outputs).map(|(instance, output)| {
        let (tracker, memory) = output.memory();
        DeformJob { lod: 0, instance, tracker, memory }
    });
    deform_within(&mut jobs.collect::<Vec<_>>(), budget, &Serial).unwrap()
}

proptest! {
    #![proptest_config(cases(30))]

    #[test]
    fn outputs_beyond_the_budget_wait_whole_and_get_the_same_vertices(body in 0usize..4, seed: u64) {
        let set = &bodies()[body].1;
        let mut dice = Dice::new(seed);
        let mut instances: Vec<Instance> = (0..5).map(|_| with(set, 0.0)).collect();
        let mut outputs: Vec<Output> = (0..5).map(|_| Output::new(set)).collect();
        let all = 5 * set.vertex_count() as u64;
        // What holds nothing does not wait.
        prop_assert_eq!(frame(&mut instances, &mut outputs, 1).vertices_written, all);
        for step in 0..12 {
            // At the end nothing more happens.
            for instance in instances.iter_mut().filter(|_| step < 6) {
                if dice.index(2) == 0 {
                    continue;
                }
                instance.submit(&random_hits(set, 1, dice.next())[0]).unwrap();
                instance.set_tolerance(set.depth_limit() * [0.0, 0.01, 0.1][dice.index(3)]).unwrap();
            }
            let before: Vec<_> = outputs.iter().map(Output::all_bits).collect();
            let budget = 1 + dice.index(all as usize) as u64;
            let report = frame(&mut instances, &mut outputs, budget);
            let fresh: Vec<_> = instances.iter_mut().map(|i| Output::fresh(i).all_bits()).collect();
            let bits: Vec<_> = outputs.iter().map(Output::all_bits).collect();
            for i in 0..5 {
                prop_assert!(bits[i] == fresh[i] || bits[i] == before[i], "output {} is half written", i);
            }
            let written = outputs.iter().filter(|o| !o.tracker.changed().is_empty()).count();
            prop_assert!(report.vertices_written <= budget || written == 1, "{:?} of {}", report, budget);
            prop_assert!(report.vertices_waiting > 0 || bits == fresh);
            prop_assert!(report.vertices_waiting == 0 || report.vertices_written + report.vertices_waiting > budget);
            prop_assert!(step < 10 || bits == fresh, "{:?}", report);
        }
    }
}

#[test]
fn nothing_waits_for_ever_and_the_nearest_come_first() {
    let set = scenes::sheet_set();
    let mut instances: Vec<Instance> = [0.0, 1.0 / 64.0, 1.0 / 128.0].map(|tolerance| with(&set, tolerance)).into();
    let mut outputs: Vec<Output> = (0..3).map(|_| Output::new(&set)).collect();
    frame(&mut instances, &mut outputs, u64::MAX);
    let deep = push([0.0, 0.0, 0.0], [0.0, 0.0, -set.depth_limit()]);
    for instance in &instances[1..] {
        instance.submit(&deep).unwrap();
    }
    let mut seen = Vec::new();
    for _ in 0..200 {
        // The exact one, which counts as the nearest, changes in every frame.
        instances[0].submit(&push([0.0, 0.0, 0.0], [0.0, 0.0, -0.02])).unwrap();
        frame(&mut instances, &mut outputs, 1);
        seen.extend((0..3).find(|o| !outputs[*o].tracker.changed().is_empty()));
    }
    let first = |output: usize| seen.iter().position(|o| *o == output).unwrap();
    assert!(first(0) == 0 && first(0) < first(2) && first(2) < first(1), "{} {}", first(2), first(1));
    for (instance, output) in instances.iter_mut().zip(&outputs).skip(1) {
        assert_eq!(output.all_bits(), Output::fresh(instance).all_bits());
    }
}

#[test]
fn what_is_too_short_to_matter_is_skipped() {
    let mesh = sheet(40);
    let set = build(mesh.clone(), bowls(&mesh, 5, 0.4, 2), SetOptions::default());
    let e = &set.examples()[0];
    let deepest = push(e.contact_point().into(), e.contact_displacement().into());
    let mut body = with(&set, 0.0);
    body.submit(&deepest).unwrap();
    let (exact, report) = positions(&mut body);
    assert_eq!(report.parts_skipped, 0);

    // Blocks on the slopes of the dent are left out.
    body.set_tolerance(e.max_depth() / 4.0).unwrap();
    let (_, report) = positions(&mut body);
    assert!(report.parts_skipped > 0, "{report:?}");

    // All of a dent that is no deeper than the tolerance is left out: nothing moves, and nothing is written any more.
    body.set_tolerance(16.0 * e.max_depth()).unwrap();
    let mut output = Output::new(&set);
    output.update(&mut body);
    assert_eq!(output.positions, mesh.positions);
    body.submit(&push([0.3, 0.3, 0.0], [0.0, 0.0, -0.5 * e.max_depth()])).unwrap();
    let report = output.update(&mut body);
    assert_eq!((report.blocks_written, body.marks().unwrap().len()), (0, 2));

    body.set_tolerance(0.0).unwrap();
    let marks = body.marks().unwrap().to_vec();
    body.set_marks(&marks).unwrap();
    output.update(&mut body);
    let mut fresh = with(&set, 0.0);
    fresh.submit(&deepest).unwrap();
    assert_eq!(positions(&mut fresh).0, exact);
    assert_ne!(output.positions, mesh.positions);
}

#[test]
fn a_tolerance_of_the_same_power_of_two_writes_nothing() {
    let set = scenes::ball_set();
    let mut body = with(&set, 0.013);
    assert_eq!(body.tolerance(), 1.0 / 128.0);
    random_hits(&set, 5, 1).iter().for_each(|h| assert!(body.submit(h).is_ok()));
    let mut output = Output::new(&set);
    output.update(&mut body);
    for tolerance in [0.0080, 0.0100, 0.0156] {
        body.set_tolerance(tolerance).unwrap();
        assert_eq!(output.update(&mut body).vertices_written, 0);
    }
    body.set_tolerance(0.0).unwrap();
    output.update(&mut body);
    assert_eq!(output.all_bits(), Output::fresh(&mut body).all_bits());
    assert_eq!(body.tolerance(), 0.0);
    body.set_tolerance(f32::MIN_POSITIVE / 8.0).unwrap();
    assert_eq!(body.tolerance(), 0.0);
    for bad in [-1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(body.set_tolerance(bad).unwrap_err().kind(), ErrorKind::InvalidArgument);
        let options = InstanceOptions { tolerance: bad, ..InstanceOptions::default() };
        assert!(Instance::new(set.clone(), options).unwrap_err().to_string().starts_with("tolerance is "));
    }
}

#[test]
fn classic_rules_ignore_it() {
    let set = scenes::sheet_set();
    let hits = random_hits(&set, 6, 3);
    let deformed = |tolerance: f32| {
        let options = InstanceOptions { tolerance, ..InstanceOptions::classic(Rule::MostDisplaced) };
        let mut body = Instance::new(set.clone(), options).unwrap();
        body.set_tolerance(tolerance).unwrap();
        hits.iter().for_each(|h| assert!(body.submit(h).is_ok()));
        positions(&mut body).0
    };
    assert_eq!(deformed(0.0), deformed(1.0));
}

#[test]
fn a_pixel_covers_what_the_camera_shows() {
    // 90 degrees: the height of the view is twice its distance.
    let right = std::f32::consts::FRAC_PI_2;
    assert!((pixel_tolerance(1.0, 10.0, right, 1000.0) - 0.02).abs() < 1e-7);
    assert!((pixel_tolerance(0.5, 20.0, right, 1000.0) - 0.02).abs() < 1e-7);
    assert_eq!(pixel_tolerance(1.0, 0.0, right, 1000.0), 0.0);
    for (pixels, distance, fov, height) in [
        (-1.0, 10.0, right, 1000.0),
        (1.0, -1.0, right, 1000.0),
        (1.0, 10.0, 0.0, 1000.0),
        (1.0, 10.0, 3.2, 1000.0),
        (1.0, 10.0, right, 0.0),
        (f32::NAN, 10.0, right, 1000.0),
        (0.0, f32::INFINITY, right, 1000.0),
    ] {
        assert_eq!(pixel_tolerance(pixels, distance, fov, height), 0.0);
    }
    assert_eq!(pixel_tolerance(1.0, f32::INFINITY, right, 1000.0), 1e9);
}
