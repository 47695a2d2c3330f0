//! Examples that fold the surface: how many triangles turn over, in the example itself and in what is made of it.

use anyhow::Result;
use crumple::{Hit, SetOptions};

use super::Method;
use super::sheet::{self, Bowl};
use crate::Options;
use crate::metric::inverted;
use crate::table::{Table, num};
use crate::truth::Field;

const RADIUS: f64 = 0.2;
const DEPTH: f64 = 0.03;

pub fn run(options: &Options) -> Result<()> {
    let n = if options.quick { 40 } else { 100 };
    let steps = if options.quick { 6 } else { 30 };
    let mut table = Table::new(&["method", "hits", "pull", "inverted", "inverted_over_example", "triangles"]);
    table.comment(
        "what",
        "a bowl that also pulls the surface to its middle, by `pull` times the distance: above 1 it folds",
    );
    table.comment("squares", n * n);
    let mesh = sheet::sheet(n);
    let overlapping = [[0.0, 0.0], [0.06, 0.0], [-0.03, 0.05], [-0.03, -0.05], [0.0, 0.1], [0.1, -0.06]];
    let places: [(&str, Vec<[f64; 2]>); 3] = [
        ("at its own place", vec![[0.0, 0.0]]),
        ("elsewhere", vec![[0.22, 0.17]]),
        ("six, overlapping", overlapping.to_vec()),
    ];
    for i in 0..=steps {
        let pull = 3.0 * f64::from(i) / f64::from(steps);
        let bowl = Bowl { pull, ..Bowl::new([0.0, 0.0], RADIUS, DEPTH) };
        let set = sheet::set(n, &[bowl], SetOptions::default())?;
        let turned = |field: &Field| inverted(field, &mesh.positions, &mesh.triangles);
        let own = turned(&bowl.field(&mesh.positions));
        let mut row = |method: &str, hits: &str, count: usize| {
            table.row([
                method.to_owned(),
                hits.to_owned(),
                num(pull),
                count.to_string(),
                num(if own == 0 { f64::NAN } else { count as f64 / own as f64 }),
                mesh.triangles.len().to_string(),
            ])
        };
        row("the example itself", "", own)?;
        for method in [Method::Ours, Method::Classic, Method::Blend] {
            for (name, at) in &places {
                let hit = |p: &[f64; 2]| Hit::displacement([p[0] as f32, p[1] as f32, 0.0], [0.0, 0.0, -DEPTH as f32]);
                let field = method.after(&set, &at.iter().map(hit).collect::<Vec<_>>())?;
                row(method.name(), name, turned(&field))?;
            }
        }
    }
    table.write(&options.out, "stability_inversion.csv").map(drop)
}
