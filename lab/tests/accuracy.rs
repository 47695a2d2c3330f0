//! Compares predicted dents with those of an independent elasto-plastic solver, on impacts that no example shows. The
//! table has the classic rule beside carried examples. `cargo test -p crumple-lab --test accuracy -- --nocapture` prints it.
//!
//! Errors are the relative L2 norm of the displacement field over all vertices: median and 90th percentile over 16
//! held-out impacts per body. A hit is what an engine would report: the contact point and the displacement wanted
//! there.

#[path = "../../tests/scenes/mod.rs"]
mod scenes;

use std::fs::File;
use std::sync::Arc;

use crumple::glam::Vec3;
use crumple::{ExampleSet, Instance, InstanceOptions, Placement, Rule, Selection, SetOptions};
use scenes::{displacements, push, relative_l2, solver_set};

struct HeldOut {
    fields: Vec<f32>,
    points: Vec<f32>,
    displacements: Vec<f32>,
}

impl HeldOut {
    fn read(body: &str) -> Self {
        let path = scenes::repository().join(format!("assets/solver/{body}_heldout.npz"));
        let mut archive = zip::ZipArchive::new(File::open(path).expect("the committed asset")).unwrap();
        let mut array = |name: &str| -> Vec<f32> {
            let file = archive.by_name(&format!("{name}.npy")).expect("an array of that name");
            npyz::NpyFile::new(file).unwrap().into_vec().expect("f32 numbers")
        };
        Self { fields: array("fields"), points: array("contact_point"), displacements: array("contact_displacement") }
    }

    fn impacts(&self) -> impl Iterator<Item = ([f32; 3], [f32; 3], &[f32])> {
        let count = self.points.len() / 3;
        let three = |a: &[f32], i: usize| [a[3 * i], a[3 * i + 1], a[3 * i + 2]];
        let size = self.fields.len() / count;
        (0..count).map(move |i| {
            (three(&self.points, i), three(&self.displacements, i), &self.fields[i * size..(i + 1) * size])
        })
    }
}

/// Relative L2 errors of one method over the held-out impacts, sorted.
fn errors(set: &Arc<ExampleSet>, options: &InstanceOptions, held_out: &HeldOut) -> Vec<f64> {
    let mut errors: Vec<f64> = held_out
        .impacts()
        .map(|(point, displacement, truth)| {
            let mut instance = Instance::new(set.clone(), *options).unwrap();
            instance.submit(&push(point, displacement)).unwrap();
            let truth: Vec<Vec3> = truth.chunks_exact(3).map(Vec3::from_slice).collect();
            relative_l2(&displacements(&mut instance), &truth)
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    errors
}

/// Interpolates linearly between the two nearest ranks, as numpy does.
fn quantile(sorted: &[f64], q: f64) -> f64 {
    let at = q * (sorted.len() - 1) as f64;
    let low = at.floor() as usize;
    let high = (low + 1).min(sorted.len() - 1);
    sorted[low] + (at - low as f64) * (sorted[high] - sorted[low])
}

/// The medians of the design's table, which at 32 examples has classic and carried by 3 only, and the largest median
/// allowed: about 15 % above the value when the shares became those of kriging.
struct Row {
    body: &'static str,
    examples: usize,
    classic: f64,
    carried_1: Option<f64>,
    carried_3: f64,
    at_most: f64,
}

const TABLE: [Row; 6] = [
    Row { body: "panel", examples: 4, classic: 1.01, carried_1: Some(0.33), carried_3: 0.24, at_most: 0.156 },
    Row { body: "panel", examples: 24, classic: 0.90, carried_1: Some(0.20), carried_3: 0.19, at_most: 0.122 },
    Row { body: "panel", examples: 32, classic: 0.83, carried_1: None, carried_3: 0.18, at_most: 0.112 },
    Row { body: "tube", examples: 4, classic: 1.05, carried_1: Some(0.28), carried_3: 0.21, at_most: 0.170 },
    Row { body: "tube", examples: 24, classic: 1.12, carried_1: Some(0.27), carried_3: 0.18, at_most: 0.142 },
    Row { body: "tube", examples: 32, classic: 1.24, carried_1: None, carried_3: 0.16, at_most: 0.135 },
];

/// Allowed difference from the design's figures for the classic rules, which are reproduced.
const TOLERANCE: f64 = 0.05;
/// Largest 90th percentile, except for the classic rules and the default depth limit.
const WORST: f64 = 0.4;

#[test]
fn no_worse_than_the_designs_table_and_than_it_was() {
    let classic = InstanceOptions { rule: Rule::MostDisplaced, selection: Selection::Classic, ..Default::default() };
    // The table's carried examples were scaled to any depth. By default no dent is deeper than the deepest example's.
    let carried = |k| InstanceOptions { examples_per_hit: k, depth_limit: Some(1.0), ..Default::default() };
    let mut wrong = Vec::new();
    println!("relative L2, median / p90 (design's median)\n");
    println!(
        "| examples | classic, clamped | carried, 1 | carried, 3 | automatic, 3 | all defaults |\n|---|---|---|---|---|---|"
    );
    for row in &TABLE {
        let held_out = HeldOut::read(row.body);
        let as_carried = solver_set(row.body, row.examples, Placement::Carried);
        let automatic = solver_set(row.body, row.examples, Placement::Automatic);
        // The classic figures count a vertex as affected by an example from 0.1 mm on. Without this, examples are
        // chosen that barely move the contact (tube, 32 examples: 1.03 instead of 1.24).
        let cut = {
            let (mesh, mut examples) = scenes::solver(row.body);
            examples.truncate(row.examples);
            scenes::build(mesh, examples, SetOptions { drop_below: 1e-4, ..SetOptions::default() })
        };
        let near = |v: f64| v - TOLERANCE..=v + TOLERANCE;
        let below = |v: f64| 0.0..=v;
        let anything = below(f64::INFINITY);
        let by_3 = below(row.at_most.min(row.carried_3));
        let by_1 = row.carried_1.map_or(anything.clone(), below);
        let mut line = format!("| {}: {} |", row.body, row.examples);
        for (set, options, design, allowed, worst, what) in [
            (&cut, classic, Some(row.classic), near(row.classic), f64::INFINITY, "classic"),
            (&as_carried, carried(1), row.carried_1, by_1, WORST, "carried by 1"),
            (&as_carried, carried(3), Some(row.carried_3), by_3.clone(), WORST, "carried by 3"),
            (&automatic, carried(3), None, by_3, WORST, "automatic"),
            (&automatic, InstanceOptions::default(), None, anything, f64::INFINITY, "defaults"),
        ] {
            let errors = errors(set, &options, &held_out);
            let (median, p90) = (quantile(&errors, 0.5), quantile(&errors, 0.9));
            line += &format!(" {median:.3} / {p90:.3}");
            if let Some(design) = design {
                line += &format!(" ({design:.2})");
            }
            if !allowed.contains(&median) || p90 > worst {
                wrong.push(format!(
                    "{} {} {what}: {median:.3} / {p90:.3}, not in {allowed:?} / {worst}",
                    row.body, row.examples
                ));
            }
            line += " |";
        }
        println!("{line}");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Vertices that follow a few nodes are as near to the solver's dents as if each were a node.
#[test]
fn few_nodes_are_as_near_to_the_truth_as_all() {
    let deep = InstanceOptions { depth_limit: Some(1.0), ..InstanceOptions::default() };
    for body in ["panel", "tube"] {
        let held_out = HeldOut::read(body);
        let set = solver_set(body, 24, Placement::Automatic);
        let [all, few] = [&scenes::every_node(&set), &set].map(|set| errors(set, &deep, &held_out));
        for q in [0.5, 0.9] {
            let [all, few] = [&all, &few].map(|e| quantile(e, q));
            println!("{body} {q}: {all:.4} with all, {few:.4} with few nodes");
            assert!(few < 1.02 * all, "{body}, quantile {q}: {few} with few nodes, {all} with all");
        }
    }
}
