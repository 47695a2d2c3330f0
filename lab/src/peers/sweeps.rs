//! Where rapier's soft bodies fail: time step, stiffness and impact speed, each far beyond what is sensible.

use anyhow::Result;

use super::rapier::{Material, Outcome, Quality, hit};
use super::sheet::Sheet;
use super::{DEFAULT, SHOTS, VERSION};
use crate::Options;
use crate::metric::{deepest, length};
use crate::table::{Table, num};
use crate::truth::{Body, Impact, Striker, Truth};

const COLUMNS: [&str; 11] = [
    "peer",
    "version",
    "body",
    "sweep",
    "value",
    "unit",
    "outcome",
    "max_displacement_m",
    "inverted_triangles",
    "depth_mm",
    "cpu_s_per_simulated_s",
];

/// What is varied, its unit, its values.
type Sweep = (&'static str, &'static str, &'static [f64]);

const SWEEPS: [Sweep; 3] = [
    ("time step", "ms", &[0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 33.0]),
    ("stiffness", "times", &[0.01, 0.1, 1.0, 10.0, 100.0, 1000.0]),
    ("impact speed", "m/s", &[1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0]),
];
const QUICK: [Sweep; 3] = [
    ("time step", "ms", &[1.0, 4.0, 33.0]),
    ("stiffness", "times", &[0.01, 1.0, 1000.0]),
    ("impact speed", "m/s", &[10.0, 1000.0]),
];

/// Writes `stability_peers_rapier.csv`.
pub fn run(options: &Options, bodies: &[Body]) -> Result<()> {
    let mut table = Table::new(&COLUMNS);
    table.comment("rapier3d", VERSION);
    table.comment("reference", "the training shot of median depth, half the truth's cells, 4 substeps a step");
    table.comment("stiffness", "springs times this (frequency times its root), yield stress kept (yield divided)");
    table.comment("lost", "depth under a tenth of the reference's (not for balls slower than it)");
    let shots = bodies.iter().filter(|b| b.truth == Truth::Shots).take(if options.quick { 1 } else { 2 });
    for body in shots {
        let impact = middle(body);
        table.comment(format!("true depth {}", body.name), format!("{} mm", num(1e3 * impact.depth())));
        for hz in [60.0, 240.0] {
            let quality = Quality { hz, ..DEFAULT };
            let (_, material) = *SHOTS.iter().find(|(q, _)| *q == quality).expect("both are calibrated");
            let reference = Reference::new(body, impact, quality, material);
            for (sweep, unit, values) in if options.quick { QUICK } else { SWEEPS } {
                for value in values {
                    table.row(reference.row(body, sweep, unit, *value))?;
                }
            }
        }
    }
    println!("{}", table.write(&options.out, "stability_peers_rapier.csv")?.display());
    Ok(())
}

/// The training shot of median depth.
fn middle(body: &Body) -> &Impact {
    let mut order: Vec<&Impact> = body.train.iter().collect();
    order.sort_by(|a, b| a.depth().total_cmp(&b.depth()));
    order[order.len() / 2]
}

/// What the sweeps vary, and what it does when left as it is.
struct Reference<'a> {
    sheet: Sheet,
    impact: &'a Impact,
    quality: Quality,
    material: Material,
    depth: f64,
    inverted: usize,
}

impl<'a> Reference<'a> {
    fn new(body: &Body, impact: &'a Impact, quality: Quality, material: Material) -> Self {
        let sheet = Sheet::new(body, quality.stride);
        let outcome = hit(&sheet, impact, material, quality);
        let inverted = sheet.inverted(&outcome.field);
        let mut reference = Self { sheet, impact, quality, material, depth: 0.0, inverted };
        reference.depth = reference.depth_of(&outcome);
        reference
    }

    fn depth_of(&self, outcome: &Outcome) -> f64 {
        length(self.sheet.at_truth(&outcome.field)[self.impact.contact_vertex as usize])
    }

    fn row(&self, body: &Body, sweep: &str, unit: &str, value: f64) -> Vec<String> {
        let (mut impact, mut quality, mut material) = (self.impact.clone(), self.quality, self.material);
        let mut slower = false;
        match (sweep, &mut impact.striker) {
            ("time step", _) => quality.hz = (1e3 / value) as f32,
            ("stiffness", _) => material = material.stiffened(value as f32),
            (_, Striker::Ball { speed, .. }) => {
                slower = value < *speed;
                *speed = value;
            }
            _ => unreachable!("shots have balls"),
        }
        let outcome = hit(&self.sheet, &impact, material, quality);
        let depth = self.depth_of(&outcome);
        let flips = self.sheet.inverted(&outcome.field).saturating_sub(self.inverted);
        let verdict = if outcome.is_nan() {
            "nan"
        } else if deepest(&outcome.field) > self.sheet.diagonal() {
            "exploded"
        } else if flips > 0 {
            "inverted"
        } else if depth < 0.1 * self.depth && !slower {
            "lost"
        } else {
            "ok"
        };
        vec![
            format!("rapier soft body, {:.0} Hz", self.quality.hz),
            VERSION.to_owned(),
            body.name.to_owned(),
            sweep.to_owned(),
            num(value),
            unit.to_owned(),
            verdict.to_owned(),
            num(deepest(&outcome.field)),
            flips.to_string(),
            num(1e3 * depth),
            num(outcome.seconds / outcome.simulated_s),
        ]
    }
}
