//! One more hit on a body that was hit many times.

use std::sync::Arc;

use anyhow::Result;
use crumple::{ExampleSet, Hit, Instance, InstanceOptions, Mark};

use super::Bench;
use super::baked;
use super::deformed::Deformed;
use super::measure::{Contender, interleaved};
use super::real::{bodies, finer, name};
use super::report::{Aim, Row, Sense};
use crate::accuracy::heldout;
use crate::scene;
use crate::truth::{Body, Truth};

const VERTICES: usize = 20_000;
/// Hits before the one that is timed. An instance keeps 64 marks.
const BEFORE: [usize; 2] = [9, 63];
/// Above every dent, m: measures the dents, not the depth limit.
const DEEP: f32 = 1.0;

/// From the hit to positions and normals, against the same hit on a body without dents: the lab's smooth bodies, and a hood
/// whose examples move all of it.
pub fn run(bench: &Bench) -> Result<()> {
    for body in bodies(bench.quick)?.into_iter().chain([Body::read(Truth::Steel, "hood")?]) {
        let row = format!("worn_{}", name(&body));
        if bench.wanted(&row) {
            measure(bench, &row, &body)?;
        }
    }
    Ok(())
}

fn measure(bench: &Bench, row: &str, body: &Body) -> Result<()> {
    let (mesh, examples) = finer(body, VERTICES).build(body);
    let set = Arc::new(ExampleSet::build(mesh, examples, baked(), bench.tasks(2))?);
    let options = InstanceOptions { depth_limit: Some(DEEP), ..Default::default() };
    let last = scene::hit(heldout(body, bench.quick)[0]);
    for count in BEFORE {
        let marks = worn(&set, options, count)?;
        let deformed = || Deformed::new(&set, options, &[], true, bench.tasks(1));
        let (mut ours, mut new) = (deformed()?, deformed()?);
        let mut contenders = [Contender::new(|| ours.hit(&marks, &[last])), Contender::new(|| new.hit(&[], &[last]))];
        let times = interleaved(&bench.plan, &mut contenders);
        drop(contenders);
        let name = format!("{row}_{count}");
        let (blocks, alone) = (ours.blocks_written() as f64, new.blocks_written() as f64);
        let time = Row::time(&name, &times[0], "µs").beside_time("the first hit", &times[1], Sense::Cost);
        bench.add(time.aim(Aim::Value(150.0)).hash(ours.hash()));
        bench.add(Row::new(format!("{name}_blocks"), blocks, "blocks").beside("the first hit", alone, Sense::Cost));
    }
    Ok(())
}

/// The marks of hits all over the body, as deep as its examples.
fn worn(set: &Arc<ExampleSet>, options: InstanceOptions, count: usize) -> Result<Vec<Mark>> {
    let mut instance = Instance::new(set.clone(), options)?;
    let (all, examples) = (set.vertex_count(), set.examples());
    for i in 0..count {
        // Steps of the golden ratio spread over the vertices, whatever the count.
        let v = ((0.5 + 0.618_034 * i as f64).fract() * all as f64) as usize;
        let depth = examples[i % examples.len()].depth();
        let inward = -set.mesh().contact_normal(v as u32).unwrap_or_default() * depth;
        instance.submit(&Hit::displacement(set.mesh().positions()[v].to_array(), inward.to_array()))?;
        instance.fold();
    }
    Ok(instance.marks()?.to_vec())
}
