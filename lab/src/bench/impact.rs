//! A whole impact on a real body of about 50 000 vertices: from the contact to written positions, normals and bounds.

use std::sync::Arc;

use anyhow::Result;
use crumple::{ExampleSet, Hit, InstanceOptions};
use glam::Vec3;

use super::Bench;
use super::baked;
use super::deformed::Deformed;
use super::measure::{Contender, Plan, Times, interleaved, timed};
use super::radial::RadialDent;
use super::real::{bodies, finer, name};
use super::reference::Classic;
use super::report::{Aim, Row, Sense};
use crate::accuracy::heldout;
use crate::metric::median;
use crate::scene;
use crate::truth::Impact;

const VERTICES: usize = 50_000;
/// Above every dent, m: measures the dents, not the depth of the deepest example.
const DEEP: f32 = 1.0;

pub fn run(bench: &Bench) -> Result<()> {
    for body in bodies(bench.quick)? {
        let row = format!("impact_{}", name(&body));
        if !bench.wanted(&row) {
            continue;
        }
        let (mesh, examples) = finer(&body, VERTICES).build(&body);
        let set = ExampleSet::build(mesh, examples, baked(), bench.tasks(2))?;
        measure(bench, &row, Arc::new(set), &heldout(&body, bench.quick))?;
    }
    Ok(())
}

fn measure(bench: &Bench, name: &str, set: Arc<ExampleSet>, impacts: &[&Impact]) -> Result<()> {
    let plan = Plan { budget: bench.plan.budget / impacts.len().max(1) as u32, ..bench.plan };
    let options = InstanceOptions { depth_limit: Some(DEEP), ..Default::default() };
    let mut ours = Deformed::new(&set, options, &[], true, bench.tasks(1))?;
    let (mut whole, mut classics, mut radials, mut counts) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut a_vertex, mut classic_a_vertex) = (Vec::new(), Vec::new());
    let mut hash = 0u64;
    for impact in impacts {
        let hit: Hit = scene::hit(impact);
        ours.hit(&[], &[hit]);
        hash = hash.rotate_left(1) ^ ours.hash();
        let base = set.mesh().positions();
        let field = base.iter().zip(ours.positions()).enumerate().filter_map(|(v, (b, p))| {
            let d = Vec3::from_array(*p) - *b;
            (d != Vec3::ZERO).then_some((v as u32, d))
        });
        let field: Vec<(u32, Vec3)> = field.collect();
        let moved = field.len().max(1) as f64;
        let contact = Vec3::from_array(hit.point);
        let furthest = |(v, _): &(u32, Vec3)| base[*v as usize].distance(contact);
        let radius = field.iter().map(furthest).fold(f32::MIN_POSITIVE, f32::max);
        let push = field.iter().map(|(_, d)| *d).max_by(|a, b| a.length().total_cmp(&b.length())).unwrap_or(Vec3::Z);
        let mut radial = RadialDent::new(base, set.mesh().triangles());
        // The classic kernel, told which example and where: no selection, no normals, no bounds.
        let mut classic = Classic::new(base, &[field], bench.tasks(1));
        let mut contenders = [
            Contender::new(|| ours.hit(&[], &[hit])),
            Contender::new(|| classic.run()),
            Contender::new(|| timed(|| radial.run(contact, push, radius))),
        ];
        let times: Vec<f64> = interleaved(&plan, &mut contenders).iter().map(Times::median).collect();
        counts.push(moved);
        whole.push(times[0]);
        classics.push(times[1]);
        radials.push(times[2]);
        a_vertex.push(times[0] / moved);
        classic_a_vertex.push(times[1] / moved);
    }
    let row = |suffix: &str, ours: Vec<f64>, classic: &[f64], unit| {
        let row = Row::time(format!("{name}{suffix}"), &Times::new(ours), unit);
        row.beside_time("classic", &Times::new(classic.to_vec()), Sense::Cost).hash(hash)
    };
    let beside_radial = Row::time(format!("{name}_radial"), &Times::new(whole.clone()), "µs");
    bench.add(beside_radial.beside_time("radial dent", &Times::new(radials), Sense::Speed));
    bench.add(row("", whole, &classics, "µs").aim(Aim::Value(150.0)));
    bench.add(row("_vertex", a_vertex, &classic_a_vertex, "ns/vertex"));
    let all = set.vertex_count() as f64;
    bench.add(Row::new(format!("{name}_moved"), median(&counts), "vertices").beside("of the body", all, Sense::Cost));
    Ok(())
}
