//! The same scene a millionth and a million times as large, and far from the origin.

use std::sync::Arc;

use anyhow::Result;
use crumple::{Deltas, ExampleSet, Hit, Serial, SetOptions};

use super::{Dice, Method};
use crate::metric::relative_l2;
use crate::table::{Table, num};
use crate::truth::{Body, Field, Truth};
use crate::{Options, scene};

const HITS: usize = 20;
const EXAMPLES: usize = 8;

pub fn run(options: &Options) -> Result<()> {
    let every = if options.quick { 3 } else { 1 };
    let mut table =
        Table::new(&["body", "method", "sweep", "scale", "distance_over_size", "rel_l2", "rounding_rel_l2"]);
    table.comment(
        "what",
        format!("{HITS} random hits, {EXAMPLES} examples; error to the same scene at scale 1 around the origin"),
    );
    table.comment("rounding", "error of the exact result once its positions are rounded to f32");
    let methods = [Method::Ours, Method::Classic];
    for name in Truth::SMOOTH_BODIES {
        let body = Body::read(Truth::Shots, name)?;
        let home = Placed::new(&body, 1.0, 0.0)?;
        let size = f64::from(home.set.mesh().bounds().diagonal());
        let hits = home.hits();
        let references = methods.map(|m| m.after(&home.set, &home.moved(&hits)));
        let references: Vec<Field> = references.into_iter().collect::<Result<_>>()?;
        let scales = (-6..=6).step_by(every).map(|p| ("scale", 10f64.powi(p), 0.0));
        let distances = (-1..=6).step_by(every).map(|p| ("distance", 1.0, 10f64.powi(p)));
        for (sweep, scale, distance) in scales.chain(distances) {
            let there = Placed::new(&body, scale, distance * size)?;
            for (method, reference) in methods.iter().zip(&references) {
                let field = method.after(&there.set, &there.moved(&hits))?;
                let back: Field = field.into_iter().map(|u| u.map(|x| (f64::from(x) / scale) as f32)).collect();
                table.row([
                    name.to_owned(),
                    method.name().to_owned(),
                    sweep.to_owned(),
                    num(scale),
                    num(distance),
                    num(relative_l2(&back, reference)),
                    num(relative_l2(&there.rounded(reference), reference)),
                ])?;
            }
        }
    }
    table.write(&options.out, "stability_scale.csv").map(drop)
}

/// The body scaled, then moved.
struct Placed {
    set: Arc<ExampleSet>,
    scale: f64,
}

impl Placed {
    fn new(body: &Body, scale: f64, offset: f64) -> Result<Self> {
        let mut mesh = scene::mesh(body);
        let away = [1.0, 0.7, 0.3].map(|x| x * offset / 1.257f64);
        for p in &mut mesh.positions {
            *p = [0, 1, 2].map(|k| (f64::from(p[k]) * scale + away[k]) as f32);
        }
        let mut examples = scene::examples(body, EXAMPLES);
        for e in &mut examples {
            if let Deltas::Full(field) = &mut e.positions {
                field.iter_mut().for_each(|u| *u = u.map(|x| (f64::from(x) * scale) as f32));
            }
        }
        Ok(Self { set: Arc::new(ExampleSet::build(mesh, examples, SetOptions::default(), &Serial)?), scale })
    }

    /// Vertices and displacements at scale 1.
    fn hits(&self) -> Vec<(usize, [f32; 3])> {
        let mut dice = Dice::new(9);
        let hit = |_| {
            let vertex = dice.index(self.set.vertex_count());
            let n = self.set.mesh().contact_normal(vertex as u32).unwrap_or_default();
            let depth = dice.between(0.2, 1.0) * f64::from(self.set.depth_limit());
            (vertex, n.to_array().map(|x| (-depth * f64::from(x)) as f32))
        };
        (0..HITS).map(hit).collect()
    }

    fn moved(&self, hits: &[(usize, [f32; 3])]) -> Vec<Hit> {
        let positions = self.set.mesh().positions();
        let hit = |(v, d): &(usize, [f32; 3])| {
            Hit::displacement(positions[*v].to_array(), d.map(|x| (f64::from(x) * self.scale) as f32))
        };
        hits.iter().map(hit).collect()
    }

    /// A field of scale 1 as it is once its positions here are rounded to f32.
    fn rounded(&self, field: &Field) -> Field {
        let one = |(u, b): (&[f32; 3], &glam::Vec3)| {
            [0, 1, 2].map(|k| {
                let exact = f64::from(b[k]) + f64::from(u[k]) * self.scale;
                ((f64::from(exact as f32) - f64::from(b[k])) / self.scale) as f32
            })
        };
        field.iter().zip(self.set.mesh().positions()).map(one).collect()
    }
}
