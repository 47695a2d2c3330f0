//! The demo's hood with vertices that follow nodes: one more hit, all vertices, and memory.

use std::sync::Arc;

use anyhow::{Context, Result};
use crumple::{BasisOptions, ExampleSet, Hit, Instance, InstanceOptions, Mark, Placement, reorder};

use super::Bench;
use super::deformed::Deformed;
use super::measure::{Contender, interleaved};
use super::real::all;
use super::reference::{Classic, field};
use super::report::{Aim, Row, Sense};
use super::width::baked;

/// How far a vertex may be off, m.
const TOLERANCE: f32 = 0.5e-3;
/// Which of 64 hits is timed.
const TIMED: [usize; 3] = [1, 9, 64];

/// One more hit. Names end in `marks` where vertices are computed from marks.
pub fn hits_upon_hits(bench: &Bench) -> Result<()> {
    let (marks, nodes) = (set(bench, false)?, set(bench, true)?);
    for count in TIMED {
        let name = format!("hit_hood_{count}");
        if bench.wanted(&name) || bench.wanted(&format!("{name}_marks")) {
            one_more(bench, &marks, &nodes, count)?;
        }
    }
    Ok(())
}

/// Memory of the set.
pub fn memory(bench: &Bench) -> Result<()> {
    let bytes = |set: &ExampleSet| set.memory_bytes() as f64 / set.vertex_count() as f64;
    let (marks, nodes) = (set(bench, false)?, set(bench, true)?);
    bench.add(Row::new("bytes_vertex", bytes(&nodes), "B/vertex").beside("from marks", bytes(&marks), Sense::Cost));
    Ok(())
}

fn set(bench: &Bench, nodes: bool) -> Result<Arc<ExampleSet>> {
    let mut hood = all()?.into_iter().find(|real| real.name == "hood").context("the demo's hood is missing")?;
    reorder(&mut hood.mesh, &mut hood.examples);
    hood.examples.iter_mut().for_each(|e| e.placement = Placement::Carried);
    let mut set = ExampleSet::build(hood.mesh, hood.examples, baked(), bench.tasks(2))?;
    if nodes {
        set.learn_basis(&BasisOptions { rounds: 2, ..BasisOptions::new(TOLERANCE) }, bench.tasks(2))?;
    }
    Ok(Arc::new(set))
}

/// From the hit to positions and normals on one thread, against the classic kernel's positions of the example that moves most.
fn one_more(bench: &Bench, marks: &Arc<ExampleSet>, nodes: &Arc<ExampleSet>, count: usize) -> Result<()> {
    let options = InstanceOptions::default();
    let hits = hits(marks, count);
    let (before, last) = (made(marks, options, &hits[..count - 1])?, hits[count - 1]);
    let deformed = |set| Deformed::new(set, options, &[], true, bench.tasks(1));
    let (mut direct, mut ours) = (deformed(marks)?, deformed(nodes)?);
    let base = marks.mesh().positions();
    let fields = marks.examples().iter().map(|e| field(marks, e));
    let most = fields.max_by_key(Vec::len).unwrap_or_default();
    let mut classic = Classic::new(base, &[most], bench.tasks(1));
    let mut contenders = [
        Contender::new(|| ours.hit(&before, &[last])),
        Contender::new(|| direct.hit(&before, &[last])),
        Contender::new(|| classic.run()),
    ];
    let times = interleaved(&bench.plan, &mut contenders);
    drop(contenders);
    let row = |name: String, ours| Row::time(name, ours, "µs").beside_time("classic", &times[2], Sense::Cost);
    bench.add(row(format!("hit_hood_{count}"), &times[0]).aim(Aim::AtMost(1.6)).hash(ours.hash()));
    bench.add(row(format!("hit_hood_{count}_marks"), &times[1]).hash(direct.hash()));
    Ok(())
}

/// Positions of all vertices of a body with nine marks, against the classic kernel with one example of all vertices.
pub fn every_vertex(bench: &Bench) -> Result<()> {
    let (options, nodes) = (InstanceOptions::default(), &set(bench, true)?);
    let marks = made(nodes, options, &hits(nodes, 9))?;
    let mut ours = Deformed::new(nodes, options, &marks, false, bench.tasks(1))?;
    ours.run();
    let base = nodes.mesh().positions();
    let all = (0..base.len() as u32).map(|v| (v, glam::Vec3::splat(1e-3))).collect();
    let mut classic = Classic::new(base, &[all], bench.tasks(1));
    let mut contenders = [Contender::new(|| ours.again()), Contender::new(|| classic.run())];
    let times = interleaved(&bench.plan, &mut contenders);
    drop(contenders);
    let time = Row::time("expand_cache", &times[0], "µs").beside_time("classic", &times[1], Sense::Cost);
    bench.add(time.aim(Aim::AtMost(1.0)).hash(ours.hash()));
    Ok(())
}

/// Hits all over the body, as deep as its examples.
fn hits(set: &ExampleSet, count: usize) -> Vec<Hit> {
    let hit = |i: usize| {
        // Steps of the golden ratio spread over the vertices, whatever the count.
        let v = ((0.5 + 0.618_034 * i as f64).fract() * set.vertex_count() as f64) as usize;
        let depth = set.examples()[i % set.examples().len()].depth();
        let inward = -set.mesh().contact_normal(v as u32).unwrap_or_default() * depth;
        Hit::displacement(set.mesh().positions()[v].to_array(), inward.to_array())
    };
    (0..count).map(hit).collect()
}

/// The marks of hits.
fn made(set: &Arc<ExampleSet>, options: InstanceOptions, hits: &[Hit]) -> Result<Vec<Mark>> {
    let mut instance = Instance::new(set.clone(), options)?;
    for hit in hits {
        instance.submit(hit)?;
        instance.fold();
    }
    Ok(instance.marks()?.to_vec())
}
