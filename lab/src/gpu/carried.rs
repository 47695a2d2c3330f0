//! Carried marks whose stamps cover the sheet, against one pass of the classic kernel over as many vertices.

use anyhow::Result;
use crumple::InstanceOptions;

use super::Bench;
use super::check::{ANCHORED_ULPS, Agreement, CARRIED_ULPS};
use super::copy::Copy;
use super::findings::Finding;
use super::literature::{self, Literature, on_the_cpu};
use super::recorded::{Output, Recorded, WORKGROUP, marked};
use super::scene::{CARRIED_BYTES, STRENGTHS, WEIGHT, at_strength};
use crate::bench::marks::{carried_marks, carried_set};
use crate::bench::measure::Contender;
use crate::bench::reference::field;
use crate::bench::report::Sense;

/// Marks, examples of each, output, and the aim.
const CASES: [(usize, usize, Output, Option<&str>); 5] = [
    (1, 1, Output::Positions, Some("one carried")),
    (3, 1, Output::Positions, Some("three carried")),
    (10, 1, Output::Positions, None),
    (1, 3, Output::Positions, None),
    (1, 1, Output::Normals, None),
];

pub fn run(bench: &Bench<'_>, sizes: &[usize]) -> Result<()> {
    for (i, size) in sizes.iter().enumerate() {
        let largest = i + 1 == sizes.len();
        bench.fits(&format!("carried, {size}"), one(bench, *size, largest))?;
    }
    Ok(())
}

fn one(bench: &Bench<'_>, size: usize, largest: bool) -> Result<()> {
    let (gpu, tasks) = (bench.gpu, &bench.tasks);
    let set = carried_set(size, tasks)?;
    let base = set.mesh().positions();
    let mut ours = Vec::new();
    for (marks, k, output, _) in CASES {
        let marks = at_strength(&carried_marks(&set, size, marks, k), STRENGTHS[0]);
        ours.push(Recorded::one(gpu, marked(&set, InstanceOptions::default(), &marks)?, output)?);
    }
    // All vertices, since the example moves them all.
    let fields = [field(&set, &set.examples()[0])];
    let mut classic = Literature::new(gpu, base, &fields, WEIGHT, WORKGROUP)?;
    let mut copy = Copy::moving(gpu, CARRIED_BYTES * fields[0].len() as f64)?;
    let [a, b, c, d, e] = &mut ours[..] else { unreachable!("as many as there are cases") };
    let times = bench.measure([
        Contender::new(|| a.run_all()),
        Contender::new(|| b.run_all()),
        Contender::new(|| c.run_all()),
        Contender::new(|| d.run_all()),
        Contender::new(|| e.run_all()),
        Contender::new(|| classic.run()),
        Contender::new(|| copy.run()),
    ]);
    let of_classic = &times[CASES.len()];
    let found = |method: &str, case: &str, times| Finding::time("carried", method, case, fields[0].len(), times, "ms");
    for (i, (marks, k, output, aim)) in CASES.into_iter().enumerate() {
        let what = format!("{marks} carried marks of {k}");
        let wanted = ours[i].expected(tasks)?;
        let agreement = Agreement::of(gpu, &what, (&ours[i].written()?, &wanted), CARRIED_ULPS)?;
        let method = match (k, output) {
            (_, Output::Normals) => "with normals",
            (1, _) => "marks",
            _ => "marks of three",
        };
        let mut finding = found(method, &marks.to_string(), &times[i]).checked(agreement);
        finding = finding.beside("classic", of_classic, Sense::Speed);
        if output == Output::Positions {
            finding = finding.moving(CARRIED_BYTES, &times[CASES.len() + 1]);
        }
        bench.add(match aim {
            Some(aim) => finding.aim_if(largest, aim),
            None => finding,
        });
    }
    let wanted = on_the_cpu(base, &fields, WEIGHT);
    let agreement = Agreement::of(gpu, "the classic kernel", (&classic.vertices()?, &wanted), ANCHORED_ULPS)?;
    bench.add(found("classic", "", of_classic).bytes(literature::BYTES).checked(agreement));
    copy.check()?;
    Ok(())
}
