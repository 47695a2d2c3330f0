//! Bytes that anchored examples take, for each vertex that they move.

use anyhow::Result;
use crumple::{Deltas, ExampleSet, Placement, SetOptions, SetReport};

use super::Bench;
use super::real::{Real, all};
use super::report::{Aim, Row, Sense};
use super::width::{Width, options};

/// The literature's sparse entry: index and displacement, f32.
const CLASSIC: f64 = 16.0;

pub fn run(bench: &Bench) -> Result<()> {
    for real in all()? {
        for width in Width::ALL {
            let name = format!("memory_{}_{}", width.name(), real.name);
            if !bench.wanted(&name) {
                continue;
            }
            let options = SetOptions { mirror: false, ..options(width, largest(&real)) };
            let report = report(bench, &real, &options)?;
            let moved = report.moved_vertices.max(1) as f64;
            let (normals, all) = (report.normal_bytes as f64, report.anchored_bytes as f64);
            let (aim, more) = match width {
                Width::F32 => (None, None),
                Width::I16 => (Some(7.0), Some(4.0)),
                Width::I8 => (Some(4.0), Some(4.0)),
            };
            let row = Row::new(&name, (all - normals) / moved, "B/vertex").beside("classic", CLASSIC, Sense::Cost);
            bench.add(Row { aim: aim.map(Aim::Value), ..row });
            let row = Row::new(format!("{name}_normals"), normals / moved, "B/vertex");
            bench.add(Row { aim: more.map(Aim::Value), ..row.beside("f32", 12.0, Sense::Cost) });
        }
    }
    Ok(())
}

/// What a set of the anchored examples takes.
fn report(bench: &Bench, real: &Real, options: &SetOptions) -> Result<SetReport> {
    let mut examples = real.examples.clone();
    // No stamps: they are not what is counted, and take long to make.
    examples.iter_mut().for_each(|e| e.placement = Placement::Anchored);
    Ok(ExampleSet::build(real.mesh.clone(), examples, options.clone(), bench.tasks(2))?.report().clone())
}

/// The largest component of any displacement, m.
fn largest(real: &Real) -> f32 {
    let values = real.examples.iter().flat_map(|e| match &e.positions {
        Deltas::Full(values) | Deltas::Sparse { values, .. } => values,
    });
    values.flatten().fold(0.0, |most, c| most.max(c.abs()))
}
