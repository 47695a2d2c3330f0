//! A contact that walks to the rim of an example's support and beyond.

use anyhow::Result;
use crumple::{Hit, SetOptions};

use super::sheet::{self, Bowl};
use super::{Method, apart};
use crate::Options;
use crate::metric::deepest;
use crate::table::{Table, num};

/// Target depth at the contact, m.
const TARGET: f64 = 0.02;

pub fn run(options: &Options) -> Result<()> {
    let n = if options.quick { 80 } else { 200 };
    let first = Bowl::new([-0.25, 0.0], 0.3, 0.05);
    let others = [Bowl::new([0.3, 0.25], 0.18, 0.03), Bowl::new([0.25, -0.3], 0.2, 0.04)];
    let columns =
        ["method", "distance_over_radius", "depth_over_target", "depth_at_contact_over_target", "change_m_per_m"];
    let mut table = Table::new(&columns);
    table.comment(
        "what",
        "flat sheet, three smooth bowls; the contact walks from the first one's middle across its rim",
    );
    table.comment("target_m", TARGET);
    table.comment("squares", n * n);
    let set = sheet::set(n, &[first, others[0], others[1]], SetOptions::default())?;
    let step = 1.0 / n as f64;
    for method in [Method::Ours, Method::Classic, Method::Unclamped] {
        let mut last = None;
        for i in 0..=(0.65 / step).round() as usize {
            let distance = i as f64 * step;
            let point = [(first.at[0] + distance) as f32, 0.0, 0.0];
            let mut instance = method.instance(&set)?;
            let outcome = instance.submit(&Hit::displacement(point, [0.0, 0.0, -TARGET as f32]))?;
            let field = crate::scene::displacements(&mut instance)?;
            let change = last.as_ref().map_or(f64::NAN, |l| apart(&field, l) / step);
            let contact = crate::metric::length(field[outcome.contact_vertex as usize]);
            table.row([
                method.name().to_owned(),
                num(distance / first.radius),
                num(deepest(&field) / TARGET),
                num(contact / TARGET),
                num(change),
            ])?;
            last = Some(field);
        }
    }
    table.write(&options.out, "stability_rim.csv").map(drop)
}
