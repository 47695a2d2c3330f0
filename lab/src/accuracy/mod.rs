//! How near single dents come to the truth, and what they cost: every method on every held-out impact of the smooth bodies,
//! given only the contact point and the displacement wanted there. [`told`] measures all bodies by what a hit tells.
//!
//! Nothing here chooses anything: parameters come from the training impacts (cross-validation) or are the library's.

pub mod law;
pub mod learn;
mod methods;
pub mod pod;
pub mod radial;
pub mod told;

use std::collections::BTreeSet;

use anyhow::Result;

use crate::Options;
use crate::metric::{max_error_mm, median, quantile, relative_l2};
use crate::table::{Table, num};
use crate::truth::{Body, Impact, Striker, Truth};
use methods::{Answer, Method};

/// Presses that spring back leave less than this at the contact, m: there is no dent to predict.
const LEAST_PRESS: f64 = 0.005;

const COLUMNS: [&str; 24] = [
    "truth",
    "body",
    "method",
    "examples",
    "rel_l2_median",
    "rel_l2_p25",
    "rel_l2_p75",
    "rel_l2_p90",
    "rel_l2_min",
    "rel_l2_max",
    "max_error_mm_median",
    "max_error_mm_worst",
    "us_per_impact",
    "us_p25",
    "us_p75",
    "us_with_normals",
    "ns_per_moved_vertex",
    "moved_vertices",
    "written_vertices",
    "bytes",
    "unanswered",
    "n",
    "simulations",
    "train_simulations",
];

pub fn run(options: &Options) -> Result<()> {
    let mut table = Table::new(&COLUMNS);
    let mut each = Table::new(&[
        "truth",
        "body",
        "method",
        "examples",
        "source",
        "impact",
        "depth_mm",
        "striker_radius_mm",
        "speed_m_s",
        "travel_mm",
        "tilt_deg",
        "rel_l2",
        "max_error_mm",
        "us_per_impact",
        "moved_vertices",
    ]);
    for t in [&mut table, &mut each] {
        t.comment("command", "cargo xtask lab --only accuracy");
        t.comment("error", "relative L2 of the displacement field over all vertices, held-out impacts");
        t.comment("us_per_impact", "one thread: submit, predict, deform the positions of all vertices touched; median over impacts of the median of repeated runs");
        t.comment("us_with_normals", "the same with normals written too");
        t.comment("bytes", "what the set holds beside positions and triangles");
        t.comment("left out", format!("presses that leave less than {} mm at the contact", 1e3 * LEAST_PRESS));
    }
    for body in Body::read_smooth()? {
        let impacts = heldout(&body, options.quick);
        let simulations = impacts.iter().map(|i| &i.source).collect::<BTreeSet<_>>().len();
        each.comment(
            "n",
            format!("{} {}: {} impacts of {simulations} simulations", body.truth.name(), body.name, impacts.len()),
        );
        table.comment(
            "n",
            format!("{} {}: {} impacts of {simulations} simulations", body.truth.name(), body.name, impacts.len()),
        );
        methods::each(
            &body,
            options.quick,
            &mut |method: &Method, answer: &mut dyn FnMut(&Impact) -> Result<Answer>| {
                let answers: Vec<Answer> = impacts.iter().map(|i| answer(i)).collect::<Result<_>>()?;
                let head = [
                    body.truth.name().to_owned(),
                    body.name.to_owned(),
                    method.name.to_owned(),
                    method.examples.to_string(),
                ];
                for (index, (impact, a)) in impacts.iter().zip(&answers).enumerate() {
                    let (radius, speed, travel) = match impact.striker {
                        Striker::Ball { speed, radius, .. } => (radius, speed, f64::NAN),
                        Striker::Punch { depth, radius } => (radius, f64::NAN, depth),
                    };
                    let tail = [
                        impact.source.clone(),
                        index.to_string(),
                        num(1e3 * impact.depth()),
                        num(1e3 * radius),
                        num(speed),
                        num(1e3 * travel),
                        num(body.tilt_deg(impact)),
                        num(relative_l2(&a.field, &impact.field)),
                        num(max_error_mm(&a.field, &impact.field)),
                        num(a.us),
                        a.moved.to_string(),
                    ];
                    each.row(head.iter().chain(&tail))?;
                }
                let tail = summary(&body, method, &impacts, &answers, simulations);
                table.row(head.iter().chain(&tail))
            },
        )?;
        // What no method can beat, and what predicting nothing gets.
        for (name, error) in [("floor", body.truth.noise_floor(body.name)), ("none", 1.0)] {
            let mut row = vec![body.truth.name().to_owned(), body.name.to_owned(), name.to_owned()];
            row.push("0".to_owned());
            row.extend(std::iter::repeat_n(num(error), 6));
            row.resize(COLUMNS.len() - 3, String::new());
            row.extend([impacts.len().to_string(), simulations.to_string(), String::new()]);
            table.row(row)?;
        }
        println!("accuracy: {} {}, {} impacts", body.truth.name(), body.name, impacts.len());
    }
    table.write(&options.out, "accuracy.csv")?;
    each.write(&options.out, "accuracy_impacts.csv")?;
    Ok(())
}

/// The impacts measured on: presses that leave no dent are left out.
pub fn heldout(body: &Body, quick: bool) -> Vec<&Impact> {
    let kept = body.heldout.iter().filter(|i| body.truth != Truth::Presses || i.depth() >= LEAST_PRESS);
    kept.take(if quick { 4 } else { usize::MAX }).collect()
}

fn summary(body: &Body, method: &Method, impacts: &[&Impact], answers: &[Answer], simulations: usize) -> Vec<String> {
    let of = |f: &dyn Fn(&Answer) -> f64| answers.iter().map(f).collect::<Vec<f64>>();
    let errors: Vec<f64> = impacts.iter().zip(answers).map(|(i, a)| relative_l2(&a.field, &i.field)).collect();
    let worst: Vec<f64> = impacts.iter().zip(answers).map(|(i, a)| max_error_mm(&a.field, &i.field)).collect();
    let us = of(&|a| a.us);
    let moved = of(&|a| a.moved as f64);
    let per_vertex = of(&|a| 1e3 * a.us / a.moved.max(1) as f64);
    let train: BTreeSet<_> = body.train.iter().take(method.examples).map(|i| &i.source).collect();
    let mut cells: Vec<String> = [
        median(&errors),
        quantile(&errors, 0.25),
        quantile(&errors, 0.75),
        quantile(&errors, 0.9),
        quantile(&errors, 0.0),
        quantile(&errors, 1.0),
        median(&worst),
        quantile(&worst, 1.0),
        median(&us),
        quantile(&us, 0.25),
        quantile(&us, 0.75),
        median(&of(&|a| a.us_with_normals)),
        median(&per_vertex),
        median(&moved),
        median(&of(&|a| a.written as f64)),
    ]
    .map(num)
    .to_vec();
    let unanswered = answers.iter().filter(|a| !a.answered).count();
    let counts = [method.bytes, unanswered, impacts.len(), simulations, train.len()];
    cells.extend(counts.map(|c| c.to_string()));
    cells
}
