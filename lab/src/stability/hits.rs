//! A hundred thousand random hits on one body.

use anyhow::Result;

use super::{Dice, Method, finite, random_hit, shots};
use crate::Options;
use crate::metric::{deepest, edges, largest_jump};
use crate::scene::displacements;
use crate::table::{Table, num};
use crate::truth::Truth;

pub fn run(options: &Options) -> Result<()> {
    let stops: &[usize] = if options.quick {
        &[1, 10, 100, 1000]
    } else {
        &[1, 3, 10, 30, 100, 300, 1000, 3000, 10_000, 30_000, 100_000]
    };
    let columns = ["body", "method", "hits", "depth", "seam", "bytes_of_damage", "marks", "finite"];
    let mut table = Table::new(&columns);
    table.comment("what", "random hits of 0.02 to 1.5 times the depth limit, one sequence");
    table.comment("depth", "deepest vertex over the depth limit");
    table.comment("seam", "largest edge jump over the largest in any example");
    for name in Truth::SMOOTH_BODIES {
        let (body, set) = shots(name)?;
        let edges = edges(&body.triangles);
        let jumps = body.train.iter().take(super::EXAMPLES).map(|e| largest_jump(&e.field, &edges));
        let jump = jumps.fold(0.0, f64::max);
        for method in Method::ALL {
            let mut instance = method.instance(&set)?;
            let mut dice = Dice::new(5);
            let mut submitted = 0;
            // What diverges or forgets has done so long before.
            let most = if matches!(method, Method::Ours | Method::Classic) { usize::MAX } else { 10_000 };
            for stop in stops.iter().filter(|s| **s <= most) {
                while submitted < *stop {
                    let share = dice.between(0.02, 1.5);
                    instance.submit(&random_hit(&set, &mut dice, share))?;
                    instance.fold();
                    submitted += 1;
                }
                let field = displacements(&mut instance)?;
                let marks = instance.marks().map_or(f64::NAN, |m| m.len() as f64);
                table.row([
                    name.to_owned(),
                    method.name().to_owned(),
                    stop.to_string(),
                    num(deepest(&field) / f64::from(set.depth_limit())),
                    num(largest_jump(&field, &edges) / jump),
                    instance.save().len().to_string(),
                    num(marks),
                    finite(&field).to_string(),
                ])?;
            }
        }
    }
    table.write(&options.out, "stability_hits.csv").map(drop)
}
