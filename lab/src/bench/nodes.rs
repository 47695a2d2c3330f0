//! The demo's hood: one more hit, a prediction, all vertices, and memory.

use std::sync::Arc;

use anyhow::{Context, Result};
use crumple::{Blow, Deltas, ExampleSet, Hit, Instance, InstanceOptions, Mark, Serial, Striker, reorder};

use super::Bench;
use super::baked;
use super::deformed::Deformed;
use super::measure::{Contender, interleaved, timed};
use super::real::all;
use super::reference::{Classic, field};
use super::report::{Aim, Row, Sense};

/// Which of 64 hits is timed.
const TIMED: [usize; 3] = [1, 9, 64];

/// One more hit, told as a blow.
pub fn hits_upon_hits(bench: &Bench) -> Result<()> {
    let set = Arc::new(set(bench, "hood", 12)?);
    for count in TIMED {
        if bench.wanted(&format!("hit_hood_{count}")) {
            one_more(bench, &set, count)?;
        }
    }
    Ok(())
}

/// From a blow to the displacements of the nodes.
pub fn predictions(bench: &Bench) -> Result<()> {
    let set = Arc::new(set(bench, "hood", 12)?);
    let instance = Instance::new(set.clone(), InstanceOptions::default())?;
    let hits = blows(&set, 997);
    let mut next = hits.iter().cycle();
    let mut predict = Contender::new(|| {
        let hit = next.next();
        timed(|| drop(std::hint::black_box(hit.map(|hit| instance.preview(hit)))))
    });
    let times = interleaved(&bench.plan, std::slice::from_mut(&mut predict));
    bench.add(Row::time("predict_12", &times[0], "µs"));
    Ok(())
}

/// Memory of a set from a file, without what any renderer keeps of the mesh: positions, normals and triangles.
pub fn memory(bench: &Bench) -> Result<()> {
    let bytes = |set: &ExampleSet| -> Result<f64> {
        let loaded = ExampleSet::load(set.save()?, &Serial)?;
        let mesh = 24 * loaded.vertex_count() + 12 * loaded.mesh().triangles().len();
        Ok((loaded.memory_bytes() - mesh) as f64 / loaded.vertex_count() as f64)
    };
    for (name, count, aim) in [("bytes_vertex", 12, 90.0), ("bytes_vertex_300", 300, 110.0)] {
        if bench.wanted(name) {
            bench.add(Row::new(name, bytes(&set(bench, "hood", count)?)?, "B/vertex").aim(Aim::Value(aim)));
        }
    }
    Ok(())
}

/// The set of one of the demo's bodies with so many examples: those that it has, and then the same again, a little shallower each time.
pub fn set(bench: &Bench, body: &str, count: usize) -> Result<ExampleSet> {
    let found = all()?.into_iter().find(|real| real.name == body);
    let mut body = found.with_context(|| format!("the demo's {body} is missing"))?;
    reorder(&mut body.mesh, &mut body.examples);
    let own = body.examples.len();
    let again = |i: usize| {
        let mut example = body.examples[i % own].clone();
        let share = 1.0 - 0.02 * (i / own) as f32;
        let (Deltas::Full(values) | Deltas::Sparse { values, .. }) = &mut example.positions;
        values.iter_mut().flatten().for_each(|x| *x *= share);
        if let Some(velocity) = &mut example.blow.striker.velocity {
            velocity.iter_mut().for_each(|x| *x *= share);
        }
        example
    };
    let examples = (0..count.max(own)).map(again).collect();
    Ok(ExampleSet::build(body.mesh, examples, baked(), bench.tasks(2))?)
}

/// From the hit to positions and normals on one thread, against the classic kernel's positions of the example that moves most.
fn one_more(bench: &Bench, set: &Arc<ExampleSet>, count: usize) -> Result<()> {
    let options = InstanceOptions::default();
    let mut ours = Deformed::new(set, options, &[], true, bench.tasks(1))?;
    // Another blow each time, because a set remembers its latest predictions.
    let blows = blows(set, 997);
    let before = made(set, options, &blows[..count - 1])?;
    let mut next = 0;
    let base = set.mesh().positions();
    let fields = set.examples().iter().map(|e| field(set, e));
    let most = fields.max_by_key(Vec::len).unwrap_or_default();
    let mut classic = Classic::new(base, &[most], bench.tasks(1));
    let mut contenders = [
        Contender::new(|| {
            next = (next + 1) % blows.len();
            ours.hit(&before, &blows[next..=next])
        }),
        Contender::new(|| classic.run()),
    ];
    let times = interleaved(&bench.plan, &mut contenders);
    drop(contenders);
    let row = Row::time(format!("hit_hood_{count}"), &times[0], "µs").beside_time("classic", &times[1], Sense::Cost);
    bench.add(row.aim(Aim::AtMost(1.6)));
    Ok(())
}

/// Positions of all vertices of a body with nine marks, against the classic kernel with one example of all vertices.
pub fn every_vertex(bench: &Bench) -> Result<()> {
    let (options, nodes) = (InstanceOptions::default(), &Arc::new(set(bench, "hood", 12)?));
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
    with_normals(bench, nodes, &marks)
}

/// The same with normals, against reading and writing as many bytes: what memory alone would take.
fn with_normals(bench: &Bench, set: &Arc<ExampleSet>, marks: &[Mark]) -> Result<()> {
    // Of a vertex: weights and slopes; base position and normal, and what becomes of them.
    const READ: usize = 62 + 24;
    const WRITTEN: usize = 24;
    let mut ours = Deformed::new(set, InstanceOptions::default(), marks, true, bench.tasks(1))?;
    ours.run();
    let from: Vec<u64> = (0..(set.vertex_count() * READ / 8) as u64).collect();
    let mut to = vec![0u64; set.vertex_count() * WRITTEN / 8];
    let mut bytes = || {
        let mut sums = [1; 8];
        from.as_chunks::<8>()
            .0
            .iter()
            .for_each(|words| sums.iter_mut().zip(words).for_each(|(sum, word)| *sum ^= word));
        to.fill(std::hint::black_box(sums).iter().sum());
        std::hint::black_box(&to);
    };
    let mut contenders = [Contender::new(|| ours.again()), Contender::new(|| timed(&mut bytes))];
    let times = interleaved(&bench.plan, &mut contenders);
    drop(contenders);
    bench.add(Row::time("expand_cache_normals", &times[0], "µs").beside_time("its bytes", &times[1], Sense::Cost));
    Ok(())
}

/// Hits all over the body, as deep as its examples.
pub fn hits(set: &ExampleSet, count: usize) -> Vec<Hit> {
    let hit = |i: usize| {
        // Steps of the golden ratio spread over the vertices, whatever the count.
        let v = ((0.5 + 0.618_034 * i as f64).fract() * set.vertex_count() as f64) as usize;
        let depth = set.examples()[i % set.examples().len()].depth();
        let inward = -set.mesh().contact_normal(v as u32).unwrap_or_default() * depth;
        Hit::displacement(set.mesh().positions()[v].to_array(), inward.to_array())
    };
    (0..count).map(hit).collect()
}

/// Blows all over the body, as hard as those of its examples.
pub fn blows(set: &ExampleSet, count: usize) -> Vec<Hit> {
    let blow = |i: usize| {
        let v = ((0.5 + 0.618_034 * i as f64).fract() * set.vertex_count() as f64) as usize;
        let known = set.examples()[i % set.examples().len()].blow();
        let speed = known.striker.velocity.map_or(0.0, |v| glam::Vec3::from(v).length());
        let velocity = -set.mesh().contact_normal(v as u32).unwrap_or_default() * speed;
        let striker = Striker { velocity: Some(velocity.to_array()), ..known.striker };
        Hit::blow(set.mesh().positions()[v].to_array(), Blow::of_striker(striker))
    };
    (0..count).map(blow).collect()
}

/// The marks of hits.
pub fn made(set: &Arc<ExampleSet>, options: InstanceOptions, hits: &[Hit]) -> Result<Vec<Mark>> {
    let mut instance = Instance::new(set.clone(), options)?;
    for hit in hits {
        instance.submit(hit)?;
        instance.fold();
    }
    Ok(instance.marks()?.to_vec())
}
