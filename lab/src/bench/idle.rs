//! Bodies that nothing hits: what they cost in a frame.

use std::sync::Arc;

use anyhow::Result;
use crumple::{DeformJob, ExampleSet, Instance, InstanceOptions, Mark, TaskSystem, Tracker, VertexMemory};
use xxhash_rust::xxh3::Xxh3;

use super::Bench;
use super::measure::{Contender, interleaved, timed};
use super::report::{Aim, Row, Sense};
use super::sheet::{Dent, Reach, Sheet, own_marks};

const BODIES: usize = 1000;
const HIT: usize = 10;
const VERTICES: usize = 20_000;

/// A frame with all bodies, ten of which were hit, against one with only those ten.
pub fn run(bench: &Bench) -> Result<()> {
    let dent = Dent { reach: Reach::FIFTH, ..Dent::whole([0.5; 2]) };
    let set = &Sheet::new(VERTICES).set(&[dent], bench.tasks(2))?;
    let (mut all, mut few) = (Fleet::new(set, BODIES, bench.tasks(1))?, Fleet::new(set, HIT, bench.tasks(1))?);
    let mut contenders = [Contender::new(|| all.frame()), Contender::new(|| few.frame())];
    let times = interleaved(&bench.plan, &mut contenders);
    drop(contenders);
    let row = Row::time("idle_1000", &times[0], "µs").beside_time("10 bodies", &times[1], Sense::Cost);
    bench.add(row.aim(Aim::AtMost(1.2)).hash(all.hash()));
    Ok(())
}

struct Fleet<'t> {
    instances: Vec<Instance>,
    trackers: Vec<Tracker>,
    outputs: Vec<Vec<[f32; 3]>>,
    marks: [Vec<Mark>; 2],
    turn: usize,
    tasks: &'t dyn TaskSystem,
}

impl<'t> Fleet<'t> {
    fn new(set: &Arc<ExampleSet>, count: usize, tasks: &'t dyn TaskSystem) -> Result<Self> {
        let mark = own_marks(set)?[0];
        let damage = |share: u64| vec![Mark { energy: Mark::ONE / 100 * share, ..mark }];
        let instance = |_| Instance::new(set.clone(), InstanceOptions::default());
        let mut fleet = Fleet {
            instances: (0..count).map(instance).collect::<Result<_, _>>()?,
            trackers: vec![Tracker::new(); count],
            outputs: vec![vec![[0.0; 3]; set.vertex_count()]; count],
            marks: [damage(81), damage(64)],
            turn: 0,
            tasks,
        };
        fleet.frame();
        Ok(fleet)
    }

    /// Hits ten bodies, evenly spread, then times one deform of all.
    fn frame(&mut self) -> std::time::Duration {
        self.turn ^= 1;
        let step = self.instances.len() / HIT;
        for instance in self.instances.iter_mut().step_by(step) {
            instance.set_marks(&self.marks[self.turn]).unwrap_or_else(|e| panic!("{e}"));
        }
        let parts = self.instances.iter().zip(&mut self.trackers).zip(&mut self.outputs);
        let jobs: Result<Vec<DeformJob>, crumple::Error> = parts
            .map(|((instance, tracker), output)| {
                Ok(DeformJob { lod: 0, instance, tracker, memory: VertexMemory::separate(output, None, None)? })
            })
            .collect();
        let mut jobs = jobs.unwrap_or_else(|e| panic!("{e}"));
        timed(|| crumple::deform(&mut jobs, self.tasks).map(drop).unwrap_or_else(|e| panic!("{e}")))
    }

    fn hash(&mut self) -> u64 {
        self.turn = 1;
        self.frame();
        let mut hash = Xxh3::new();
        self.outputs.iter().for_each(|o| hash.update(bytemuck::cast_slice(o)));
        hash.digest()
    }
}
