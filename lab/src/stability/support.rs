//! Examples that reach a few vertices, and examples that reach far beyond the body.

use anyhow::Result;
use crumple::{Hit, SetOptions};

use super::sheet::{self, Bowl};
use super::{Method, finite};
use crate::Options;
use crate::metric::{deepest, relative_l2};
use crate::table::{Table, num};

const DEPTH: f64 = 0.02;
/// The smallest radius, m: smaller bowls fall between the nodes.
const LEAST: f64 = 0.03;
/// Where the body is hit, away from the example in its middle. Both are vertices.
const HIT: [f64; 2] = [0.125, 0.0625];

pub fn run(options: &Options) -> Result<()> {
    let n = if options.quick { 64 } else { 160 };
    let columns = ["method", "radius_m", "radius_over_edge", "rel_l2", "depth_over_target", "finite"];
    let mut table = Table::new(&columns);
    table.comment(
        "what",
        "a sheet of 1 m, one bowl in its middle, a hit 14 cm beside it; the truth is the bowl moved there",
    );
    table.comment("squares", n * n);
    let per_decade = if options.quick { 4 } else { 10 };
    for method in [Method::Ours, Method::Classic, Method::Unclamped] {
        for i in 0..=5 * per_decade / 2 {
            let radius = LEAST * 10f64.powf(f64::from(i) / f64::from(per_decade));
            let bowl = Bowl::new([0.0, 0.0], radius, DEPTH);
            let set = sheet::set(n, &[bowl], SetOptions::default())?;
            let point = [HIT[0] as f32, HIT[1] as f32, 0.0];
            let field = method.after(&set, &[Hit::displacement(point, [0.0, 0.0, -DEPTH as f32])])?;
            let truth = Bowl { at: HIT, ..bowl }.field(&sheet::sheet(n).positions);
            table.row([
                method.name().to_owned(),
                num(radius),
                num(radius * n as f64),
                num(relative_l2(&field, &truth)),
                num(deepest(&field) / DEPTH),
                finite(&field).to_string(),
            ])?;
        }
    }
    table.write(&options.out, "stability_support.csv").map(drop)
}
