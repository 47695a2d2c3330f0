//! Many instances in one buffer against the same vertices in one instance: one dispatch either way.

use anyhow::Result;
use crumple::{Instance, InstanceOptions};

use super::check::{Agreement, ULPS};
use super::findings::Finding;
use super::recorded::{Output, Recorded, WORKGROUP};
use super::scene::{Toggled, sheet};
use super::{Bench, Scale};
use crate::bench::measure::Contender;
use crate::bench::report::Sense;
use crate::bench::sheet::{Dent, own_marks};

/// Fewer where only that it runs is of interest.
const INSTANCES: usize = 1000;
/// Every so many-th is hit.
const STEP: usize = 10;

pub fn run(bench: &Bench<'_>, sizes: &[usize]) -> Result<()> {
    for size in sizes {
        bench.fits(&format!("instances of {size}"), one(bench, *size))?;
    }
    Ok(())
}

fn one(bench: &Bench<'_>, size: usize) -> Result<()> {
    let (gpu, tasks) = (bench.gpu, &bench.tasks);
    let of = |vertices: usize, count: usize, step: usize| -> Result<Toggled<'_>> {
        let set = sheet(vertices, &[Dent::whole([0.5; 2])], false, tasks)?;
        let instance = |_| Ok(Instance::new(set.clone(), InstanceOptions::default())?);
        let instances = (0..count).map(instance).collect::<Result<Vec<_>>>()?;
        Toggled::marks(Recorded::new(gpu, instances, Output::Positions, WORKGROUP)?, &own_marks(&set)?, step)
    };
    let instances = if bench.scale == Scale::Least { 2 * STEP } else { INSTANCES };
    let cases = [("hit", instances / STEP, STEP, Some("instances")), ("all", instances, 1, None)];
    for (method, changing, step, aim) in cases {
        let (mut many, mut one) = (of(size, instances, step)?, of(changing * size, 1, 1)?);
        let [of_many, of_one] = bench.measure([Contender::new(|| many.run()), Contender::new(|| one.run())]);
        let cost = many.frame()?;
        anyhow::ensure!(cost.report.dispatches == 1, "{} dispatches for one buffer", cost.report.dispatches);
        let vertices = changing * size;
        let add = |method: &str, body: &mut Toggled<'_>, times, beside| -> Result<()> {
            let (got, wanted) = body.vertices(tasks)?;
            let agreement = Agreement::of(gpu, method, (&got, &wanted), ULPS)?;
            let finding = Finding::time("instances", method, &changing.to_string(), vertices, times, "ms");
            let finding = finding.checked(agreement);
            bench.add(match beside {
                Some(beside) => {
                    let finding = finding.beside("one instance", beside, Sense::Cost);
                    if let Some(aim) = aim { finding.aim(aim) } else { finding }
                }
                None => finding,
            });
            Ok(())
        };
        add(method, &mut many, &of_many, Some(&of_one))?;
        add("in one", &mut one, &of_one, None)?;
    }
    Ok(())
}
