//! The same contact as engines at different frame rates report it: whole, one impulse a step, or several a step.

use std::num::NonZeroU64;

use anyhow::Result;
use crumple::Hit;

use super::{Dice, Method, shots, without_blows};
use crate::Options;
use crate::metric::{deepest, quantile};
use crate::scene::displacements;
use crate::table::{Table, num};
use crate::truth::{Impact, Truth};

/// How long the bodies touch, s.
const LASTS: f64 = 0.025;
/// The duration that is a constant of the material, s.
const DURATION: f64 = 1.0 / 60.0;
const RATES: [f64; 4] = [30.0, 60.0, 144.0, 240.0];

/// How impulses become displacements, and what binds the parts of one contact together.
#[derive(Clone, Copy)]
struct Way {
    name: &'static str,
    method: Method,
    /// The time step is taken for the duration, as the paper's formula has it. Crumple predicts the blow, whatever its duration.
    steps: bool,
    contact: bool,
}

const WAYS: [Way; 4] = [
    Way { name: "classic, duration = time step", method: Method::Classic, steps: true, contact: false },
    Way { name: "classic, constant duration", method: Method::Classic, steps: false, contact: false },
    Way { name: "crumple, no contact id", method: Method::Ours, steps: false, contact: false },
    Way { name: "crumple, contact id", method: Method::Ours, steps: false, contact: true },
];

pub fn run(options: &Options) -> Result<()> {
    let (impacts, phases) = if options.quick { (4, 2) } else { (12, 4) };
    let mut table =
        Table::new(&["body", "way", "reported", "rate_hz", "depth_median", "depth_least", "depth_most", "n"]);
    table.comment("what", "one contact of 25 ms whose force rises and falls, begun at any phase of a step");
    table.comment("depth", "deepest vertex over that of the same contact reported whole at 60 Hz");
    for name in Truth::SMOOTH_BODIES {
        let (body, set) = shots(name)?;
        let literature = without_blows(&body)?;
        for way in WAYS {
            let depth = |impact: &Impact, rate: f64, parts: usize, phase: f64| -> Result<f64> {
                let duration = if way.steps { 1.0 / rate / parts.max(1) as f64 } else { DURATION };
                let mut instance = way.method.instance(if way.method == Method::Ours { &set } else { &literature })?;
                // The blow's own; or, with 1 kg, what makes the impact's displacement in a 60th of a second.
                let blow = impact.blow.filter(|_| way.method == Method::Ours).map(|blow| blow.in_engine().impulse);
                let whole = blow.unwrap_or(impact.displacement.map(|x| x / DURATION as f32));
                for share in shares(rate, parts, phase) {
                    let impulse = whole.map(|x| (f64::from(x) * share) as f32);
                    let hit = Hit::impulse(impact.point, impulse, duration as f32, Some(1.0));
                    let id = if way.contact { NonZeroU64::new(1) } else { None };
                    instance.submit(&Hit { contact: id, ..hit })?;
                    instance.fold();
                }
                Ok(deepest(&displacements(&mut instance)?))
            };
            for (reported, parts) in [("whole", 0), ("one a step", 1), ("four a step", 4)] {
                for rate in RATES {
                    let mut ratios = Vec::new();
                    for impact in body.heldout.iter().take(impacts) {
                        let expected = depth(impact, 60.0, 0, 0.0)?;
                        // No example of the classic rule may reach the contact: then there is nothing to compare.
                        if expected == 0.0 {
                            continue;
                        }
                        let mut dice = Dice::new(u64::from(impact.contact_vertex));
                        for _ in 0..if parts == 0 { 1 } else { phases } {
                            ratios.push(depth(impact, rate, parts, dice.unit())? / expected);
                        }
                    }
                    table.row([
                        name.to_owned(),
                        way.name.to_owned(),
                        reported.to_owned(),
                        num(rate),
                        num(quantile(&ratios, 0.5)),
                        num(quantile(&ratios, 0.0)),
                        num(quantile(&ratios, 1.0)),
                        ratios.len().to_string(),
                    ])?;
                }
            }
        }
    }
    table.write(&options.out, "stability_rates.csv").map(drop)
}

/// What each report holds of the whole impulse: `parts` reports a step, or all at once (0).
fn shares(rate: f64, parts: usize, phase: f64) -> Vec<f64> {
    if parts == 0 {
        return vec![1.0];
    }
    let so_far = |t: f64| 0.5 - 0.5 * (std::f64::consts::PI * (t / LASTS).clamp(0.0, 1.0)).cos();
    let step = 1.0 / rate / parts as f64;
    let at = |i: usize| (i as f64 - phase) * step;
    let count = (LASTS / step).ceil() as usize + 1;
    (0..count).map(|i| so_far(at(i + 1)) - so_far(at(i))).filter(|s| *s > 0.0).collect()
}
