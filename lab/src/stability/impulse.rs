//! Impulses from next to nothing to absurd: how deep the deepest vertex ends after 75 of them.

use anyhow::Result;
use crumple::{Cause, Hit};

use super::{Dice, Method, deepest_example, finite, random_hit, shots, without_blows};
use crate::Options;
use crate::metric::{deepest, median};
use crate::table::{Table, num};
use crate::truth::Truth;

const HITS: usize = 75;
const DURATION: f32 = 0.01;

pub fn run(options: &Options) -> Result<()> {
    let (step, seeds) = if options.quick { (4, 2) } else { (2, 5) };
    let columns =
        ["body", "method", "impulse_ns", "target_over_limit", "depth_median", "depth_worst", "all_finite", "n"];
    let mut table = Table::new(&columns);
    table.comment(
        "what",
        format!("{HITS} random hits of one impulse, 10 ms, 1 kg; depth: deepest vertex over the depth limit"),
    );
    for name in Truth::SMOOTH_BODIES {
        let (body, set) = shots(name)?;
        let literature = without_blows(&body)?;
        let limit = f64::from(set.depth_limit());
        for method in Method::ALL {
            for third in (-18..=36).step_by(step) {
                let impulse = 10f64.powf(f64::from(third) / 3.0);
                let fields = (0..seeds).map(|seed| {
                    let mut dice = Dice::new(seed);
                    let hit = |_| {
                        let one = random_hit(&set, &mut dice, 1.0 / deepest_example(&set));
                        let Cause::Displacement(unit) = one.cause else {
                            unreachable!("random hits are displacements")
                        };
                        Hit::impulse(one.point, unit.map(|x| (f64::from(x) * impulse) as f32), DURATION, Some(1.0))
                    };
                    let set = if method == Method::Ours { &set } else { &literature };
                    method.after(set, &(0..HITS).map(hit).collect::<Vec<_>>())
                });
                let fields = fields.collect::<Result<Vec<_>>>()?;
                let depths: Vec<f64> = fields.iter().map(|f| deepest(f) / limit).collect();
                let worst = depths.iter().copied().fold(0.0, f64::max);
                table.row([
                    name.to_owned(),
                    method.name().to_owned(),
                    num(impulse),
                    num(impulse * f64::from(DURATION) / limit),
                    num(median(&depths)),
                    num(worst),
                    fields.iter().all(finite).to_string(),
                    seeds.to_string(),
                ])?;
            }
        }
    }
    table.write(&options.out, "stability_impulse.csv").map(drop)
}
