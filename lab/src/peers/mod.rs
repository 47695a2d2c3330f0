//! rapier's soft bodies on the same impacts, at several qualities, and where they fail. rapier is given the ball, its mass
//! and its speed (or its path) and finds contact and depth itself. MuJoCo's part is `lab/python/mujoco_peer.py`.

#[cfg(test)]
mod calibrate;
mod contacts;
mod rapier;
pub mod rapier_contacts;
mod sheet;
mod sweeps;

use std::path::Path;

use anyhow::Result;

use crate::Options;
use crate::metric::{deepest, median};
use crate::table::{Table, num};
use crate::truth::{Body, Impact, Truth};
use rapier::{Material, Outcome, Quality, hit};
use sheet::{FieldError, Sheet, field_error};

/// The version that `Cargo.toml` asks for.
pub const VERSION: &str = "0.36.1";

const COLUMNS: [&str; 15] = [
    "peer",
    "version",
    "body",
    "truth",
    "setting",
    "quality",
    "rel_l2_median",
    "rel_l2_p90",
    "scaled_rel_l2_median",
    "scaled_rel_l2_p90",
    "max_error_mm_median",
    "us_per_impact",
    "bytes",
    "failures",
    "n",
];

/// Presses that spring back leave less than this at the contact, m: there is no dent to predict.
const LEAST_PRESS: f64 = 0.005;

/// Step rate and substeps that rapier's documentation starts from, at half the truth's cells.
const DEFAULT: Quality = Quality { stride: 2, hz: 60.0, substeps: 4, sweeps: 3 };

/// What is measured on the shots, and the material that the search on training impacts found for it (`cargo test --release
/// -p crumple-lab -- --ignored --nocapture calibration`): what a spring does depends on the step and on the mesh.
const SHOTS: [(Quality, Material); 7] = [
    (Quality { stride: 4, ..DEFAULT }, of(1062.4, 42.1, 0.1050, 0.0)),
    (DEFAULT, of(267.7, 142.3, 0.1264, 12.79)),
    (Quality { substeps: 12, sweeps: 8, ..DEFAULT }, of(1311.4, 160.9, 0.0341, 7.660)),
    (Quality { stride: 4, hz: 240.0, ..DEFAULT }, of(3540.0, 65.6, 0.0291, 9.923)),
    (Quality { hz: 240.0, ..DEFAULT }, of(513.5, 185.4, 0.0668, 5.456)),
    (Quality { hz: 1000.0, ..DEFAULT }, of(1311.3, 160.9, 0.0341, 7.659)),
    (Quality { stride: 1, hz: 240.0, ..DEFAULT }, of(1311.3, 160.9, 0.0341, 7.659)),
];

/// The same for the presses.
const PRESSES: [(Quality, Material); 5] = [
    (Quality { stride: 4, ..DEFAULT }, of(6908.3, 4.63, 0.000587, 0.0)),
    (DEFAULT, of(159.4, 28.9, 0.0135, 0.0)),
    (Quality { substeps: 12, sweeps: 8, ..DEFAULT }, of(38934.7, 235.5, 0.0035, 0.0)),
    (Quality { stride: 4, hz: 240.0, ..DEFAULT }, of(392.4, 15.07, 0.00066, 0.0)),
    (Quality { hz: 240.0, ..DEFAULT }, of(100147.0, 151.2, 0.0041, 0.0)),
];

const fn of(edge_hz: f32, bend_hz: f32, plastic_yield: f32, shape_hz: f32) -> Material {
    Material { edge_hz, bend_hz, plastic_yield, shape_hz }
}

fn calibrated(truth: Truth) -> &'static [(Quality, Material)] {
    match truth {
        Truth::Shots => &SHOTS,
        Truth::Presses => &PRESSES,
        // No material is calibrated for them.
        Truth::Structure | Truth::Steel | Truth::Dense => &[],
    }
}

/// The springs of rapier's own defaults, which are elastic and held by matching the shape.
const DEFAULT_MATERIAL: Material = Material { edge_hz: 30.0, bend_hz: 10.0, plastic_yield: 0.0, shape_hz: 10.0 };
/// With them, the best on training impacts of 0.005, 0.01, 0.02, 0.05, 0.1 and 0.2.
const YIELD_OF_DEFAULT: f32 = 0.1;

/// A real engine's contacts as all that Crumple is told.
pub fn contacts(options: &Options, bullet: Option<&Path>, check: bool) -> Result<()> {
    contacts::run(options, bullet, check)
}

pub fn run(options: &Options) -> Result<()> {
    let bodies = Body::read_smooth()?;
    let mut table = Table::new(&COLUMNS);
    table.comment("rapier3d", VERSION);
    table.comment("setup", SETUP);
    table.comment("errors", "at the truth's vertices; scaled: after one factor gave the contact its true displacement");
    table.comment("bytes", "particles, edges, folds and surface of one soft body");
    table.comment("failures", "NaN, quarantined, exploded, or inverted beyond the truth");
    for body in &bodies {
        for (quality, material) in calibrated(body.truth).iter().filter(|(q, _)| !options.quick || q.stride == 4) {
            table.row(row(body, "rapier soft body", *quality, *material, options.quick))?;
        }
        if body.truth == Truth::Shots {
            let plastic = Material { plastic_yield: YIELD_OF_DEFAULT, ..DEFAULT_MATERIAL };
            table.row(row(body, "rapier soft body, default springs", DEFAULT, plastic, options.quick))?;
            let elastic = Material { plastic_yield: 0.0, ..SHOTS[1].1 };
            table.row(row(body, "rapier soft body, elastic", DEFAULT, elastic, options.quick))?;
        }
    }
    println!("{}", table.write(&options.out, "peers_rapier.csv")?.display());
    sweeps::run(options, &bodies)
}

const SETUP: &str = "SoftBodyBuilder::trimesh (edges, bending, shape matching) with the truth's mass, pinned rim, plastic \
                     edges and folds that flow at once; contacts, recovery and extra substeps on impact as by default";

/// The held-out impacts, one a simulation.
fn heldout(body: &Body) -> Vec<&Impact> {
    let mut seen = std::collections::BTreeSet::new();
    let dents = body.heldout.iter().filter(|i| body.truth == Truth::Shots || i.depth() > LEAST_PRESS);
    dents.filter(|i| seen.insert(i.source.clone())).collect()
}

fn row(body: &Body, peer: &str, quality: Quality, material: Material, quick: bool) -> Vec<String> {
    let sheet = Sheet::new(body, quality.stride);
    let most = if quick { 2 } else { usize::MAX };
    let impacts: Vec<_> = heldout(body).into_iter().take(most).collect();
    let outcomes: Vec<Outcome> = impacts.iter().map(|i| hit(&sheet, i, material, quality)).collect();
    let errors: Vec<FieldError> = impacts.iter().zip(&outcomes).map(|(i, o)| error(&sheet, i, o)).collect();
    let failures = impacts.iter().zip(&outcomes).filter(|(i, o)| failed(&sheet, i, o)).count();
    let all = |of: fn(&FieldError) -> f64| errors.iter().map(of).collect::<Vec<f64>>();
    let (as_is, scaled) = (all(|e| e.relative_l2), all(|e| e.scaled_relative_l2));
    let grid = sheet.grid;
    let setting = format!(
        "{} x {} particles; edges {:.0} Hz, folds {:.0} Hz, yield {:.4}, shape {:.1} Hz",
        grid.rows, grid.columns, material.edge_hz, material.bend_hz, material.plastic_yield, material.shape_hz
    );
    let cells = 1.0 / quality.stride as f64;
    let quality =
        format!("{cells}x cells, {:.0} Hz, {} substeps of {} sweeps", quality.hz, quality.substeps, 1 + quality.sweeps);
    let times: Vec<f64> = outcomes.iter().map(|o| 1e6 * o.seconds).collect();
    println!(
        "{} {} {peer} {quality}: {:.3} {:.3}",
        body.truth.name(),
        body.name,
        rank(&as_is, 0.5),
        rank(&scaled, 0.5)
    );
    vec![
        peer.to_owned(),
        VERSION.to_owned(),
        body.name.to_owned(),
        body.truth.name().to_owned(),
        setting,
        quality,
        num(rank(&as_is, 0.5)),
        num(rank(&as_is, 0.9)),
        num(rank(&scaled, 0.5)),
        num(rank(&scaled, 0.9)),
        num(rank(&all(|e| e.max_mm), 0.5)),
        num(median(&times)),
        outcomes[0].bytes.to_string(),
        failures.to_string(),
        impacts.len().to_string(),
    ]
}

/// A quantile that is infinite where one of its neighbours is.
fn rank(values: &[f64], q: f64) -> f64 {
    let found = crate::metric::quantile(values, q);
    if found.is_nan() { f64::INFINITY } else { found }
}

fn error(sheet: &Sheet, impact: &Impact, outcome: &Outcome) -> FieldError {
    field_error(&sheet.at_truth(&outcome.field), &impact.field, impact.contact_vertex as usize)
}

/// NaN, a vertex further away than the body is large, or more inverted triangles than the truth has.
fn failed(sheet: &Sheet, impact: &Impact, outcome: &Outcome) -> bool {
    outcome.is_nan()
        || deepest(&outcome.field) > sheet.diagonal()
        || sheet.inverted(&outcome.field) > sheet.inverted(&sheet.of_truth(&impact.field))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_dents_a_plastic_sheet_and_not_an_elastic_one() {
        let body = Body::read(Truth::Shots, "panel").unwrap();
        let (impact, (quality, plastic)) = (&body.train[0], SHOTS[1]);
        let sheet = Sheet::new(&body, quality.stride);
        let dent = hit(&sheet, impact, plastic, quality);
        assert!(!failed(&sheet, impact, &dent));
        assert!(sheet.rim.iter().all(|v| dent.field[*v as usize] == [0.0; 3]));
        let elastic = hit(&sheet, impact, Material { plastic_yield: 0.0, ..plastic }, quality);
        assert!(deepest(&elastic.field) < 0.5 * deepest(&dent.field));
    }

    /// Prints the search behind the materials; takes half an hour.
    #[test]
    #[ignore = "a search, not a test"]
    fn calibration() {
        let of = |truth| Truth::SMOOTH_BODIES.map(|b| Body::read(truth, b).unwrap());
        for truth in Truth::SMOOTH {
            let bodies = of(truth);
            for (quality, known) in calibrated(truth) {
                // Where a run is expensive, round what half the cells and 240 Hz found.
                let expensive = quality.stride == 1 || quality.hz > 500.0 || quality.substeps > 4;
                let found = if expensive {
                    calibrate::around(&bodies, *quality, 4, 16, calibrated(truth)[4].1)
                } else {
                    calibrate::search(&bodies, *quality, 4, 48)
                };
                println!("{} {quality:?}: {found:?}, now {known:?}", truth.name());
            }
        }
        for plastic_yield in [0.005, 0.01, 0.02, 0.05, 0.1, 0.2] {
            let material = Material { plastic_yield, ..DEFAULT_MATERIAL };
            println!("defaults, {plastic_yield}: {}", calibrate::cost(&of(Truth::Shots), DEFAULT, 4, material));
        }
    }
}
