//! What recording costs the CPU, in a release build without validation.

use std::sync::Arc;

use anyhow::{Result, ensure};
use ash::vk;
use crumple::{ExampleSet, Instance, InstanceOptions, Mark};

use super::buffer::{Buffer, Place};
use super::check::{Agreement, ULPS};
use super::findings::Finding;
use super::literature::Literature;
use super::recorded::{Output, Recorded, WORKGROUP};
use super::scene::{Toggled, WEIGHT, sheet};
use super::{Bench, Scale};
use crate::bench::measure::{Contender, Times, timed};
use crate::bench::reference::field;
use crate::bench::report::Sense;
use crate::bench::sheet::{Dent, Reach, own_marks};

/// Of each instance; fewer where only that it runs is of interest.
const VERTICES: usize = 10_000;
/// A tenth of the body's 79 blocks change.
const DENT: Dent = Dent { centre: [0.5; 2], depth: 0.02, reach: Reach::Disc(0.05) };

/// `counts` instances; the aims are for one, and for the most.
pub fn run(bench: &Bench<'_>, counts: &[usize]) -> Result<()> {
    let tasks = &bench.tasks;
    let vertices = if bench.scale == Scale::Least { 256 } else { VERTICES };
    let set = sheet(vertices, &[DENT], false, tasks)?;
    let marks = own_marks(&set)?;
    let by_hand = by_hand(bench, &set)?;
    bench.add(Finding::time("record", "by hand", "", 0, &by_hand, "µs"));
    for count in counts {
        let what = format!("recording {count} instances");
        let aim = match count {
            1 => Some("record one"),
            _ if Some(count) == counts.last() => Some("record many"),
            _ => None,
        };
        bench.fits(&what, one(bench, (&set, &marks), (*count, aim), &by_hand))?;
    }
    Ok(())
}

fn one(
    bench: &Bench<'_>,
    (set, marks): (&Arc<ExampleSet>, &[Mark]),
    (count, aim): (usize, Option<&str>),
    by_hand: &Times,
) -> Result<()> {
    let instance = |_| Ok(Instance::new(set.clone(), InstanceOptions::default())?);
    let instances = (0..count).map(instance).collect::<Result<Vec<_>>>()?;
    let bodies = Recorded::new(bench.gpu, instances, Output::Positions, WORKGROUP)?;
    let mut bodies = Toggled::marks(bodies, marks, 1)?;
    let cost = bodies.frame()?;
    ensure!(cost.report.dispatches == 1, "{} dispatches for one buffer", cost.report.dispatches);
    let [changed] = bench.measure([Contender::new(|| bodies.frame().unwrap_or_else(|e| panic!("{e:#}")).record)]);
    // Nothing has changed since.
    let idle = Contender::new(|| bodies.recorded.frame().unwrap_or_else(|e| panic!("{e:#}")).record);
    let [idle] = bench.measure([idle]);
    let (got, wanted) = bodies.vertices(&bench.tasks)?;
    let agreement = Agreement::of(bench.gpu, &format!("{count} instances"), (&got, &wanted), ULPS)?;
    let found = |method: &str, times| Finding::time("record", method, &count.to_string(), 0, times, "µs");
    let finding = found("changed", &changed).beside("by hand", by_hand, Sense::Cost).checked(agreement);
    bench.add(match aim {
        Some(aim) => finding.aim(aim),
        None => finding,
    });
    bench.add(found("idle", &idle).checked(agreement));
    Ok(())
}

/// The commands of a recording, recorded without the library: a copy, a barrier, a dispatch, a barrier.
fn by_hand(bench: &Bench<'_>, set: &ExampleSet) -> Result<Times> {
    let gpu = bench.gpu;
    let fields = [field(set, &set.examples()[0])];
    let kernel = Literature::new(gpu, set.mesh().positions(), &fields, WEIGHT, WORKGROUP)?;
    let (from, to) = (Buffer::new(gpu, 4096, Place::Upload)?, gpu.local(4096)?);
    let record = |commands: vk::CommandBuffer| {
        gpu.copy(commands, &from, &to, 4096);
        gpu.barrier(commands);
        kernel.record_pass(commands);
        gpu.barrier(commands);
    };
    let run = || -> Result<std::time::Duration> {
        let commands = gpu.begin()?;
        let took = timed(|| record(commands));
        gpu.finish()?;
        Ok(took)
    };
    let [times] = bench.measure([Contender::new(|| run().unwrap_or_else(|e| panic!("{e:#}")))]);
    Ok(times)
}
