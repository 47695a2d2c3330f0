//! A collision proxy: a level of detail of about 500 vertices of a sheet of 50 000.

use std::sync::Arc;

use anyhow::Result;
use crumple::{ExampleSet, Hit, InstanceOptions};

use super::Bench;
use super::baked;
use super::deformed::Deformed;
use super::measure::{Contender, interleaved};
use super::predict::spread;
use super::report::{Aim, Row, Sense};
use super::sheet::{Dent, Reach, Sheet};

const BASE: usize = 50_000;
const PROXY: usize = 500;
const EXAMPLES: usize = 24;

/// From the hit to the proxy's positions, against the same for the base mesh.
pub fn run(bench: &Bench) -> Result<()> {
    let (base, proxy) = (Sheet::new(BASE), Sheet::new(PROXY));
    let dents = spread(EXAMPLES).map(|centre| Dent { centre, depth: 0.05, reach: Reach::FIFTH });
    let examples = dents.map(|d| base.example(&d)).collect();
    let mut set = ExampleSet::build(base.surface(), examples, baked(), bench.tasks(2))?;
    let lod = set.add_lod(proxy.surface(), bench.tasks(2))?;
    let set = Arc::new(set);
    let whole = || Deformed::new(&set, InstanceOptions::default(), &[], false, bench.tasks(1));
    let (mut ours, mut of_base) = (whole()?.on_level(lod)?, whole()?);
    let hit = Hit::displacement(set.examples()[0].contact_point().into(), [0.002, 0.001, -0.04]);
    let mut contenders = [Contender::new(|| ours.hit(&[], &[hit])), Contender::new(|| of_base.hit(&[], &[hit]))];
    let times = interleaved(&bench.plan, &mut contenders);
    drop(contenders);
    let row = Row::time("collider", &times[0], "µs");
    let row = row.beside_time("the base mesh", &times[1], Sense::Speed);
    bench.add(row.aim(Aim::Value(20.0)).hash(ours.hash()));
    Ok(())
}
