//! Meshes as exporters leave them: degenerate, duplicated, non-manifold, empty, broken.

use std::collections::HashMap;
use std::sync::Arc;

use anyhow::Result;
use crumple::{Deltas, ExampleData, ExampleSet, MeshData, Serial, SetOptions};

use super::sheet::{self, Bowl};
use super::{Dice, Method, finite, hash, random_hit};
use crate::Options;
use crate::metric::deepest;
use crate::table::{Table, num};
use crate::truth::Field;

type Change = fn(&mut MeshData, &mut Vec<ExampleData>);

const MESHES: &[(&str, Change)] = &[
    ("a sound sheet", |_, _| {}),
    ("triangles with two equal corners", |m, _| {
        for v in 0..200 {
            m.triangles.push([v, v, v + 1]);
        }
    }),
    ("triangles without area", |m, _| {
        for v in 0..200 {
            m.triangles.push([v, v + 1, v + 2]);
        }
    }),
    ("every triangle twice, once reversed", |m, _| {
        let reversed: Vec<[u32; 3]> = m.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        m.triangles.extend(reversed);
    }),
    ("every triangle with corners of its own", soup),
    ("the same, as a tear that the examples make", |m, e| {
        soup(m, e);
        for example in e {
            if let Deltas::Full(field) = &mut example.positions {
                field.iter_mut().enumerate().for_each(|(v, u)| u[2] *= 1.0 + 0.2 * ((v / 3) % 5) as f32);
            }
        }
    }),
    ("edges with three triangles", |m, e| {
        let n = m.positions.len() as u32;
        for v in 0..n - 1 {
            let [x, y, _] = m.positions[v as usize];
            m.positions.push([x, y, 0.1]);
            m.triangles.push([v, v + 1, n + v]);
        }
        m.normals = None;
        grow(m, e);
    }),
    ("vertices that no triangle uses", |m, e| {
        for i in 0..100 {
            m.positions.push([i as f32, 5.0, 1.0]);
        }
        m.normals = None;
        grow(m, e);
    }),
    ("no triangles, no normals", |m, _| {
        m.triangles.clear();
        m.normals = None;
    }),
    ("no length of any normal", |m, _| m.normals = Some(vec![[0.0; 3]; m.positions.len()])),
    ("every vertex in one point", |m, _| m.positions.fill([0.25; 3])),
    ("one triangle", |m, e| {
        m.positions.truncate(3);
        m.positions[2] = [0.0, 0.5, 0.0];
        m.normals = None;
        m.triangles = vec![[0, 1, 2]];
        grow(m, e);
    }),
    ("one vertex", |m, e| {
        m.positions.truncate(1);
        m.normals = None;
        m.triangles.clear();
        grow(m, e);
    }),
    ("the same example 30 times", |_, e| {
        let first = e[0].clone();
        e.resize(30, first);
    }),
    ("an example that moves nothing", |_, e| {
        if let Deltas::Full(field) = &mut e[1].positions {
            field.fill([0.0; 3]);
        }
    }),
    ("an example of a thousandth of a micrometre", |_, e| {
        if let Deltas::Full(field) = &mut e[1].positions {
            field.iter_mut().for_each(|u| *u = u.map(|x| x * 1e-8));
        }
    }),
    ("an example of a kilometre", |_, e| {
        if let Deltas::Full(field) = &mut e[1].positions {
            field.iter_mut().for_each(|u| *u = u.map(|x| x * 1e5));
        }
    }),
    ("a position that is not a number", |m, _| m.positions[7][1] = f32::NAN),
    ("an index past the end", |m, _| m.triangles[3][2] = u32::MAX),
    ("an example with a vertex too few", |_, e| {
        if let Deltas::Full(field) = &mut e[0].positions {
            field.pop();
        }
    }),
    ("an infinite displacement", |_, e| {
        if let Deltas::Full(field) = &mut e[0].positions {
            field[5][0] = f32::INFINITY;
        }
    }),
    ("no vertices", |m, _| *m = MeshData::default()),
];

pub fn run(options: &Options) -> Result<()> {
    let hits = if options.quick { 30 } else { 300 };
    let columns =
        ["mesh", "method", "accepted", "says", "finite", "depth_over_limit", "seams_closed", "order_free", "marked"];
    let mut table = Table::new(&columns);
    table.comment("what", format!("{hits} random hits on a sheet of 24 by 24 squares with three bowls, spoilt"));
    table.comment("seams_closed", "vertices that share a position still do, bit for bit; empty: the mesh has none");
    for (name, change) in MESHES {
        let mut mesh = sheet::sheet(24);
        let bowls = [
            Bowl::new([0.0, 0.0], 0.25, 0.05),
            Bowl::new([0.3, 0.25], 0.2, 0.03),
            Bowl::new([-0.25, -0.25], 0.3, 0.04),
        ];
        let mut examples: Vec<ExampleData> = bowls.iter().map(|b| b.example(&mesh)).collect();
        // Where an example was hit is found, not told: the spoilt meshes have other vertices.
        examples.iter_mut().for_each(|e| e.contact = None);
        change(&mut mesh, &mut examples);
        let built = ExampleSet::build(mesh, examples, SetOptions::default(), &Serial).map(Arc::new);
        for method in [Method::Ours, Method::Classic] {
            let row = match &built {
                Err(error) => [
                    (*name).to_owned(),
                    method.name().to_owned(),
                    "no".to_owned(),
                    error.to_string(),
                    String::new(),
                    String::new(),
                    String::new(),
                    String::new(),
                    String::new(),
                ],
                Ok(set) => {
                    let mut dice = Dice::new(4);
                    let all: Vec<_> = (0..hits)
                        .map(|_| {
                            let share = dice.between(0.05, 1.5);
                            random_hit(set, &mut dice, share)
                        })
                        .collect();
                    let instance = method.instance(set)?;
                    let mut marked = 0;
                    for hit in &all {
                        let outcome = instance.preview(hit)?;
                        marked += u32::from(outcome.status == crumple::HitStatus::Marked);
                    }
                    // In one frame, where the order of the hits must not matter.
                    let field = in_one_frame(method, set, all.iter())?;
                    let reversed = in_one_frame(method, set, all.iter().rev())?;
                    let seams = seams_closed(set, &field);
                    [
                        (*name).to_owned(),
                        method.name().to_owned(),
                        "yes".to_owned(),
                        String::new(),
                        finite(&field).to_string(),
                        num(deepest(&field) / f64::from(set.depth_limit())),
                        seams.map_or(String::new(), |s| s.to_string()),
                        (hash(&field) == hash(&reversed)).to_string(),
                        marked.to_string(),
                    ]
                }
            };
            table.row(row)?;
        }
    }
    table.write(&options.out, "stability_meshes.csv").map(drop)
}

fn in_one_frame<'a>(
    method: Method,
    set: &Arc<ExampleSet>,
    hits: impl Iterator<Item = &'a crumple::Hit>,
) -> Result<Field> {
    let mut instance = method.instance(set)?;
    for hit in hits {
        instance.submit(hit)?;
    }
    crate::scene::displacements(&mut instance)
}

/// Gives every example as many displacements as the mesh has vertices now.
fn grow(mesh: &MeshData, examples: &mut [ExampleData]) {
    for e in examples {
        if let Deltas::Full(field) = &mut e.positions {
            field.resize(mesh.positions.len(), [0.0; 3]);
            if field.iter().all(|u| *u == [0.0; 3]) {
                field[0] = [0.0, 0.0, -0.03];
            }
        }
    }
}

fn soup(mesh: &mut MeshData, examples: &mut Vec<ExampleData>) {
    let corners: Vec<usize> = mesh.triangles.iter().flatten().map(|v| *v as usize).collect();
    mesh.positions = corners.iter().map(|v| mesh.positions[*v]).collect();
    mesh.normals = Some(vec![[0.0, 0.0, 1.0]; corners.len()]);
    mesh.triangles = (0..corners.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    for e in examples {
        if let Deltas::Full(field) = &mut e.positions {
            *field = corners.iter().map(|v| field[*v]).collect();
        }
    }
}

/// `None` where no vertices share a position.
fn seams_closed(set: &ExampleSet, field: &Field) -> Option<bool> {
    let mut at: HashMap<[u32; 3], [u32; 3]> = HashMap::new();
    let mut closed = None;
    for (p, u) in set.mesh().positions().iter().zip(field) {
        let u = u.map(|x| (x + 0.0).to_bits());
        if let Some(other) = at.insert(p.to_array().map(|x| (x + 0.0).to_bits()), u) {
            closed = Some(closed.unwrap_or(true) && other == u);
        }
    }
    closed
}
