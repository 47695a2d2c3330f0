//! Workgroup sizes: the lines of the paper's Figures 5.1 and 5.2.

use anyhow::Result;
use crumple::InstanceOptions;

use super::Bench;
use super::check::{Agreement, ULPS};
use super::findings::Finding;
use super::literature::{self, Literature, on_the_cpu};
use super::recorded::{Output, Recorded, WORKGROUP, marked};
use super::scene::{STRENGTHS, WEIGHT, at_strength, bytes, sheet};
use crate::bench::measure::{Contender, Times};
use crate::bench::reference::field;
use crate::bench::report::Sense;
use crate::bench::sheet::{Dent, own_marks};

pub const SIZES: [u32; 3] = [32, 64, 128];

pub fn run(bench: &Bench<'_>, sizes: &[usize]) -> Result<()> {
    for group in SIZES.into_iter().filter(|g| !bench.gpu.has_workgroup(*g)) {
        bench.findings.borrow_mut().leave_out(format!("groups of {group}: the device has no such workgroups"));
    }
    for size in sizes {
        bench.fits(&format!("groups, {size}"), one(bench, *size))?;
    }
    Ok(())
}

fn one(bench: &Bench<'_>, size: usize) -> Result<()> {
    let (gpu, tasks) = (bench.gpu, &bench.tasks);
    let set = sheet(size, &[Dent::whole([0.5; 2])], false, tasks)?;
    let (base, fields) = (set.mesh().positions(), [field(&set, &set.examples()[0])]);
    let marks = at_strength(&own_marks(&set)?, STRENGTHS[0]);
    let groups: Vec<u32> = SIZES.into_iter().filter(|g| gpu.has_workgroup(*g)).collect();
    let mut ours = Vec::new();
    let mut classic = Vec::new();
    for group in &groups {
        let instance = marked(&set, InstanceOptions::default(), &marks)?;
        ours.push(Recorded::new(gpu, vec![instance], Output::Positions, *group)?);
        classic.push(Literature::new(gpu, base, &fields, WEIGHT, *group)?);
    }
    let mut contenders: Vec<Contender<'_>> = ours.iter_mut().map(|o| Contender::new(|| o.run_all())).collect();
    contenders.extend(classic.iter_mut().map(|c| Contender::new(|| c.run())));
    let times = crate::bench::measure::interleaved(&bench.plan, &mut contenders);
    drop(contenders);
    let (of_ours, of_classic) = times.split_at(groups.len());

    let wanted = ours[0].expected(tasks)?;
    let expected = on_the_cpu(base, &fields, WEIGHT);
    let standard = groups.iter().position(|g| *g == WORKGROUP).unwrap_or(0);
    let found = |method: &str, group: u32, times: &Times, beside: &Times| {
        let finding = Finding::time("groups", method, &group.to_string(), fields[0].len(), times, "ms");
        finding.beside(&format!("in {}", groups[standard]), beside, Sense::Cost)
    };
    for (i, group) in groups.iter().enumerate() {
        let what = format!("groups of {group}");
        let agreement = Agreement::of(gpu, &what, (&ours[i].written()?, &wanted), ULPS)?;
        let finding = found("positions", *group, &of_ours[i], &of_ours[standard]).checked(agreement);
        bench.add(finding.bytes(bytes(&set, false)));
        let agreement = Agreement::of(gpu, &what, (&classic[i].vertices()?, &expected), ULPS)?;
        let finding = found("classic", *group, &of_classic[i], &of_classic[standard]).checked(agreement);
        bench.add(finding.bytes(literature::BYTES));
    }
    Ok(())
}
