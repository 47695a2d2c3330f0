//! The runtime tolerance: no vertex is wrong by more, seams stay closed bit for bit, an output updated in steps equals
//! a new one, and work is saved.

mod scenes;

use std::sync::Arc;

use crumple::{
    Combine, ErrorKind, ExampleSet, Instance, InstanceOptions, Placement, Rule, SetOptions, pixel_tolerance,
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

/// Bodies that combine dents in each way, with exact and with rounded displacements.
fn bodies() -> &'static [Body] {
    static BODIES: std::sync::OnceLock<Vec<Body>> = std::sync::OnceLock::new();
    BODIES.get_or_init(|| {
        let mut all = small_bodies();
        for (name, combine, tolerance) in [
            ("summed", Combine::Sum, None),
            ("deepest", Combine::Deepest, Some(1e-4)),
            ("baked", Combine::Energies, Some(1e-4)),
        ] {
            let mesh = cube(10);
            let mut examples = bowls(&mesh, 6, 0.5, 5);
            examples[1].placement = Placement::Anchored;
            let options = SetOptions { combine, tolerance, stamp_resolution: 12, ..SetOptions::default() };
            all.push((name, build(mesh, examples, options)));
        }
        all
    })
}

proptest! {
    #![proptest_config(cases(60))]

    #[test]
    fn no_vertex_is_wrong_by_more(body in 0usize..6, seed: u64, count in 1usize..40, fine in 0.0f32..12.0) {
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
    fn seams_stay_closed_while_everything_changes(body in 0usize..6, seed: u64) {
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
