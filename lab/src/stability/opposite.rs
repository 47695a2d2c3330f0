//! Two examples at one place that push in different directions, up to opposite ones: what a hit between them makes of both.

use anyhow::Result;
use crumple::{Hit, SetOptions};

use super::sheet::{self, Bowl};
use super::{Method, finite};
use crate::Options;
use crate::metric::{deepest, dot64, sub};
use crate::table::{Table, num};

/// Depth of the examples and of the target, m.
const DEPTH: f64 = 0.03;

pub fn run(options: &Options) -> Result<()> {
    let n = if options.quick { 40 } else { 80 };
    let columns = ["method", "angle_deg", "depth_over_target", "miss_over_target", "finite"];
    let mut table = Table::new(&columns);
    table.comment("what", "two bowls in one place, tilted apart by the angle; a hit straight down beside their middle");
    table.comment("miss", "distance between the target and what the contact got");
    let coarse = (0..34).map(|i| 5.0 * f64::from(i));
    let fine = (0..10).map(|i| 170.0 + f64::from(i));
    let last = [179.5, 179.9, 179.99, 179.999, 180.0];
    let angles: Vec<f64> = coarse.chain(fine).chain(last).collect();
    for method in [Method::Ours, Method::Classic, Method::Unclamped] {
        for angle in &angles {
            let half = (angle / 2.0).to_radians();
            let tilted = |side: f64| Bowl {
                direction: [side * DEPTH * half.sin(), 0.0, -DEPTH * half.cos()],
                ..Bowl::new([0.0, 0.0], 0.3, DEPTH)
            };
            let set = sheet::set(n, &[tilted(1.0), tilted(-1.0)], SetOptions::default())?;
            let mut instance = method.instance(&set)?;
            let target = [0.0, 0.0, -DEPTH as f32];
            let outcome = instance.submit(&Hit::displacement([0.1, 0.05, 0.0], target))?;
            let field = crate::scene::displacements(&mut instance)?;
            let miss = sub(field[outcome.contact_vertex as usize], target);
            table.row([
                method.name().to_owned(),
                num(*angle),
                num(deepest(&field) / DEPTH),
                num(dot64(miss, miss).sqrt() / DEPTH),
                finite(&field).to_string(),
            ])?;
        }
    }
    table.write(&options.out, "stability_opposite.csv").map(drop)
}
