//! Bytes that anchored examples take, for each vertex that they move.

use anyhow::Result;
use crumple::{Deltas, ExampleSet, MeshData, Placement, SetOptions};

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
            let (true, Some(options)) = (bench.wanted(&name), options(width, largest(&real))) else { continue };
            let options = SetOptions { mirror: false, ..options };
            // The same without anything that normals could come from.
            let bare = MeshData { positions: real.mesh.positions.clone(), ..Default::default() };
            let (positions, moved) = bytes(bench, &real, bare, &options, false)?;
            let (both, _) = bytes(bench, &real, real.mesh.clone(), &options, true)?;
            let (aim, more) = match width {
                Width::F32 => (None, None),
                Width::I16 => (Some(7.0), Some(4.0)),
                Width::I8 => (Some(4.0), Some(4.0)),
            };
            let row = Row::new(&name, positions / moved, "B/vertex").beside("classic", CLASSIC, Sense::Cost);
            bench.add(Row { aim: aim.map(Aim::Value), ..row });
            let row = Row::new(format!("{name}_normals"), (both - positions) / moved, "B/vertex");
            bench.add(Row { aim: more.map(Aim::Value), ..row.beside("f32", 12.0, Sense::Cost) });
        }
    }
    Ok(())
}

/// Bytes of anchored examples, headers and padding included, and how many vertices they move in all.
fn bytes(bench: &Bench, real: &Real, mesh: MeshData, options: &SetOptions, normals: bool) -> Result<(f64, f64)> {
    let mut examples = real.examples.clone();
    for e in &mut examples {
        // No stamps: they are not what is counted, and take long to make.
        e.placement = Placement::Anchored;
        if !normals {
            e.normals = None;
        }
    }
    let set = ExampleSet::build(mesh, examples, options.clone(), bench.tasks(2))?;
    let moved: usize = set.examples().iter().map(|e| e.moved_vertices()).sum();
    Ok((set.report().anchored_bytes as f64, moved.max(1) as f64))
}

/// The largest component of any displacement, m.
fn largest(real: &Real) -> f32 {
    let values = real.examples.iter().flat_map(|e| match &e.positions {
        Deltas::Full(values) | Deltas::Sparse { values, .. } => values,
    });
    values.flatten().fold(0.0, |most, c| most.max(c.abs()))
}
