//! rapier's soft bodies on the same impacts, at several qualities, and where they fail. rapier is given the ball, its mass
//! and its speed (or its path) and finds contact and depth itself. MuJoCo's part is `lab/python/mujoco_peer.py`.

mod calibrate;
mod rapier;
mod sheet;
mod sweeps;

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

const QUALITIES: [Quality; 9] = [
    Quality { stride: 4, ..DEFAULT },
    DEFAULT,
    Quality { stride: 1, ..DEFAULT },
    Quality { substeps: 12, sweeps: 8, ..DEFAULT },
    Quality { stride: 4, hz: 240.0, ..DEFAULT },
    Quality { hz: 240.0, ..DEFAULT },
    Quality { stride: 1, hz: 240.0, ..DEFAULT },
    Quality { hz: 1000.0, ..DEFAULT },
    Quality { stride: 1, hz: 1000.0, ..DEFAULT },
];

const QUICK: [Quality; 2] = [DEFAULT, Quality { hz: 240.0, ..DEFAULT }];

/// rapier's own defaults: elastic, and held by matching its shape.
const DEFAULT_MATERIAL: Material = Material { edge_hz: 30.0, bend_hz: 10.0, plastic_yield: 0.0, shape_hz: 10.0 };
/// With them, the best on training impacts of 0.005, 0.01, 0.02, 0.05, 0.1 and 0.2.
const YIELD_OF_DEFAULT: f32 = 0.1;

pub fn run(options: &Options) -> Result<()> {
    let bodies = Body::read_all()?;
    let mut table = Table::new(&COLUMNS);
    table.comment("rapier3d", VERSION);
    table.comment("setup", SETUP);
    table.comment("errors", "at the truth's vertices; scaled: after one factor gave the contact its true displacement");
    table.comment("bytes", "particles, edges, folds and surface of one soft body");
    table.comment("failures", "NaN, quarantined, exploded, or inverted beyond the truth");
    for body in &bodies {
        for quality in if options.quick { &QUICK[..] } else { &QUALITIES } {
            table.row(row(body, "rapier soft body", *quality, material(body.truth, quality.hz), options.quick))?;
        }
        if body.truth == Truth::Shots {
            let plastic = Material { plastic_yield: YIELD_OF_DEFAULT, ..DEFAULT_MATERIAL };
            table.row(row(body, "rapier soft body, default springs", DEFAULT, plastic, options.quick))?;
            table.row(row(body, "rapier soft body, elastic", DEFAULT, DEFAULT_MATERIAL, options.quick))?;
        }
    }
    println!("{}", table.write(&options.out, "peers_rapier.csv")?.display());
    sweeps::run(options, &bodies)
}

const SETUP: &str = "SoftBodyBuilder::trimesh (edges, bending, shape matching) with the truth's mass, pinned rim, plastic \
                     edges and folds that flow at once; contacts, recovery and extra substeps on impact as by default";

/// What the search on training impacts found for this step rate (`cargo test --release -p crumple-lab -- --ignored --nocapture calibration`).
fn material(truth: Truth, hz: f32) -> Material {
    match truth {
        Truth::Shots if hz < 120.0 => SHOTS_60,
        Truth::Shots if hz < 500.0 => SHOTS_240,
        Truth::Shots => SHOTS_1000,
        Truth::Presses => PRESSES,
    }
}

const SHOTS_60: Material = Material { edge_hz: 267.7, bend_hz: 142.3, plastic_yield: 0.1264, shape_hz: 12.79 };
const SHOTS_240: Material = Material { edge_hz: 513.5, bend_hz: 185.4, plastic_yield: 0.0668, shape_hz: 5.456 };
const SHOTS_1000: Material = Material { edge_hz: 1311.3, bend_hz: 160.9, plastic_yield: 0.0341, shape_hz: 7.659 };
const PRESSES: Material = Material { edge_hz: 100147.0, bend_hz: 151.2, plastic_yield: 0.0041, shape_hz: 0.0 };

/// The held-out impacts, one a simulation.
fn heldout(body: &Body) -> Vec<&Impact> {
    let mut seen = std::collections::BTreeSet::new();
    let dents = body.heldout.iter().filter(|i| body.truth == Truth::Shots || i.depth() > LEAST_PRESS);
    dents.filter(|i| seen.insert(i.source.clone())).collect()
}

fn row(body: &Body, peer: &str, quality: Quality, material: Material, quick: bool) -> Vec<String> {
    let sheet = Sheet::new(body, quality.stride);
    let most = match (quick, quality.stride, quality.hz > 500.0) {
        (true, ..) => 2,
        (_, 1, true) => 4,
        _ => usize::MAX,
    };
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
        let sheet = Sheet::new(&body, 4);
        let impact = &body.train[0];
        let quality = Quality { stride: 4, ..DEFAULT };
        let plastic = hit(&sheet, impact, material(Truth::Shots, 60.0), quality);
        assert!(!failed(&sheet, impact, &plastic) && deepest(&plastic.field) > 1e-3);
        assert!(sheet.rim.iter().all(|v| plastic.field[*v as usize] == [0.0; 3]));
        let elastic = hit(&sheet, impact, DEFAULT_MATERIAL, quality);
        assert!(deepest(&elastic.field) < 0.2 * deepest(&plastic.field));
    }

    /// Prints the search behind the materials; takes ten minutes.
    #[test]
    #[ignore = "a search, not a test"]
    fn calibration() {
        let of = |truth| Truth::BODIES.map(|b| Body::read(truth, b).unwrap());
        let half = |hz| Quality { hz, ..DEFAULT };
        println!("shots, 240 Hz: {:?}", calibrate::search(&of(Truth::Shots), half(240.0), 4, 80));
        println!("shots, 60 Hz: {:?}", calibrate::around(&of(Truth::Shots), half(60.0), 4, 24, SHOTS_240));
        println!("shots, 1000 Hz: {:?}", calibrate::around(&of(Truth::Shots), half(1000.0), 4, 16, SHOTS_240));
        println!("presses, 240 Hz: {:?}", calibrate::search(&of(Truth::Presses), half(240.0), 3, 60));
        for plastic_yield in [0.005, 0.01, 0.02, 0.05, 0.1, 0.2] {
            let material = Material { plastic_yield, ..DEFAULT_MATERIAL };
            println!("defaults, {plastic_yield}: {}", calibrate::cost(&of(Truth::Shots), DEFAULT, 4, material));
        }
    }
}
