//! The same scene a millionth and a million times as large, and far from the origin.

use std::sync::Arc;

use anyhow::Result;
use crumple::{ExampleSet, Hit, Placement, Serial, SetOptions};

use super::{Dice, Method, random_hit};
use crate::metric::relative_l2;
use crate::table::{Table, num};
use crate::truth::{Body, Field, Truth};
use crate::{Options, scene};

const HITS: usize = 20;

pub fn run(options: &Options) -> Result<()> {
    let every = if options.quick { 3 } else { 1 };
    let mut table =
        Table::new(&["body", "method", "sweep", "scale", "distance_over_size", "rel_l2", "rounding_rel_l2"]);
    table.comment("what", format!("{HITS} random hits; error to the same scene at scale 1 around the origin"));
    table.comment("rounding", "error of the exact result once its positions are rounded to f32");
    for name in Truth::BODIES {
        let body = Body::read(Truth::Shots, name)?;
        let size = f64::from(placed(&body, 1.0, 0.0)?.mesh().bounds().diagonal());
        for method in [Method::Ours, Method::Classic] {
            let reference = after(&body, method, 1.0, 0.0)?.0;
            let mut row = |sweep: &str, scale: f64, distance: f64| -> Result<()> {
                let (field, rounded) = after(&body, method, scale, distance * size)?;
                table.row([
                    name.to_owned(),
                    method.name().to_owned(),
                    sweep.to_owned(),
                    num(scale),
                    num(distance),
                    num(relative_l2(&field, &reference)),
                    num(relative_l2(&rounded(&reference), &reference)),
                ])
            };
            for power in (-6..=6).step_by(every) {
                row("scale", 10f64.powi(power), 0.0)?;
            }
            for power in (-1..=6).step_by(every) {
                row("distance", 1.0, 10f64.powi(power))?;
            }
        }
    }
    table.write(&options.out, "stability_scale.csv").map(drop)
}

/// The field after the hits, back at scale 1, and what rounding positions to f32 alone would do to a field there.
fn after(body: &Body, method: Method, scale: f64, offset: f64) -> Result<(Field, impl Fn(&Field) -> Field)> {
    let set = placed(body, scale, offset)?;
    // The hits of the scene at scale 1; vertices and displacements scale exactly enough.
    let reference = placed(body, 1.0, 0.0)?;
    let mut dice = Dice::new(9);
    let mut hits = Vec::new();
    for _ in 0..HITS {
        let share = dice.between(0.2, 1.0);
        let hit = random_hit(&reference, &mut dice, share);
        let vertex = reference.nearest_vertex(hit.point)?.vertex as usize;
        let crumple::Cause::Displacement(d) = hit.cause else { unreachable!("random hits are displacements") };
        let point = set.mesh().positions()[vertex].to_array();
        hits.push(Hit::displacement(point, d.map(|x| (f64::from(x) * scale) as f32)));
    }
    let field = method.after(&set, &hits)?;
    let back = |f: Field| f.into_iter().map(|u| u.map(|x| (f64::from(x) / scale) as f32)).collect::<Field>();
    let base: Vec<[f32; 3]> = set.mesh().positions().iter().map(|p| p.to_array()).collect();
    let rounded = move |f: &Field| {
        let one = |(u, b): (&[f32; 3], &[f32; 3])| {
            [0, 1, 2].map(|k| {
                let exact = f64::from(b[k]) + f64::from(u[k]) * scale;
                ((f64::from(exact as f32) - f64::from(b[k])) / scale) as f32
            })
        };
        f.iter().zip(&base).map(one).collect()
    };
    Ok((back(field), rounded))
}

/// A set of the body, scaled, then moved.
fn placed(body: &Body, scale: f64, offset: f64) -> Result<Arc<ExampleSet>> {
    let mut mesh = scene::mesh(body);
    let away = [1.0, 0.7, 0.3].map(|x| x * offset / 1.257f64);
    for p in &mut mesh.positions {
        *p = [0, 1, 2].map(|k| (f64::from(p[k]) * scale + away[k]) as f32);
    }
    let mut body = body.clone();
    for impact in &mut body.train {
        for u in &mut impact.field {
            *u = u.map(|x| (f64::from(x) * scale) as f32);
        }
    }
    let examples = scene::examples(&body, super::EXAMPLES, Placement::Automatic);
    Ok(Arc::new(ExampleSet::build(mesh, examples, SetOptions::default(), &Serial)?))
}
