//! Time against the number of moved vertices, ours and the classic kernel, and the CPU path beside them: the literature's
//! Figures 5.1 to 5.3 and 5.7, Table 5.1.

use anyhow::Result;
use crumple::{Hit, Instance, InstanceOptions, Rule};

use super::Bench;
use super::check::{Agreement, ULPS};
use super::copy::Copy;
use super::findings::Finding;
use super::literature::{self, Literature, on_the_cpu};
use super::recorded::{Output, Recorded, WORKGROUP, marked};
use super::scene::{STRENGTHS, WEIGHT, at_strength, bytes, sheet};
use crate::bench::deformed::Deformed;
use crate::bench::measure::{Contender, Times};
use crate::bench::reference::field;
use crate::bench::report::Sense;
use crate::bench::sheet::{Dent, own_marks};

pub fn run(bench: &Bench<'_>, sizes: &[usize]) -> Result<()> {
    for (i, size) in sizes.iter().enumerate() {
        let largest = i + 1 == sizes.len();
        bench.fits(&format!("vertices, {size}"), one(bench, *size, largest))?;
    }
    Ok(())
}

/// The aims are for the largest number of vertices.
fn one(bench: &Bench<'_>, size: usize, largest: bool) -> Result<()> {
    let (gpu, tasks) = (bench.gpu, &bench.tasks);
    let dents = [Dent::whole([0.5; 2])];
    let [bare, shaded] = [false, true].map(|normals| sheet(size, &dents, normals, tasks));
    let (bare, shaded) = (bare?, shaded?);
    let count = bare.examples()[0].moved_vertices();
    let marks = at_strength(&own_marks(&bare)?, STRENGTHS[0]);
    let options = InstanceOptions::default();
    let mut positions = Recorded::one(gpu, marked(&bare, options, &marks)?, Output::Positions)?;
    let mut normals = Recorded::one(gpu, marked(&shaded, options, &marks)?, Output::Normals)?;
    let rule = Instance::new(bare.clone(), InstanceOptions::classic(Rule::MostDisplaced))?;
    let mut rule = Recorded::one(gpu, rule, Output::Positions)?;
    let example = &bare.examples()[0];
    let hit = (example.contact_displacement() * WEIGHT).to_array();
    let hit = Hit::displacement(example.contact_point().to_array(), hit);
    let fields = [field(&bare, example)];
    let base = bare.mesh().positions();
    let mut classic = Literature::new(gpu, base, &fields, WEIGHT, WORKGROUP)?;
    let per_vertex = [bytes(&bare, false), bytes(&shaded, true), literature::BYTES];
    let copy = |bytes: f64| Copy::moving(gpu, bytes * count as f64);
    let (mut copy_positions, mut copy_normals, mut copy_classic) =
        (copy(per_vertex[0])?, copy(per_vertex[1])?, copy(per_vertex[2])?);
    let mut cpu = Deformed::new(&bare, options, &own_marks(&bare)?, false, tasks)?;

    let [p, n, c, r, copy_p, copy_n, copy_c, on_cpu, nothing] = bench.measure([
        Contender::new(|| positions.run_all()),
        Contender::new(|| normals.run_all()),
        Contender::new(|| classic.run()),
        Contender::new(|| {
            rule.instances[0].submit(&hit).unwrap_or_else(|e| panic!("{e}"));
            rule.instances[0].fold();
            rule.run()
        }),
        Contender::new(|| copy_positions.run()),
        Contender::new(|| copy_normals.run()),
        Contender::new(|| copy_classic.run()),
        Contender::new(|| cpu.run()),
        Contender::new(|| gpu.timed(|_| ()).unwrap_or_else(|e| panic!("{e:#}"))),
    ]);

    let agreement = |what: &str, got: Vec<f32>, wanted: Vec<f32>| Agreement::of(gpu, what, (&got, &wanted), ULPS);
    let wanted = positions.expected(tasks)?;
    cpu.hash();
    let of_cpu = Agreement::of(gpu, "the CPU path", (cpu.positions().as_flattened(), &wanted), ULPS)?;
    let of_positions = agreement("positions", positions.written()?, wanted)?;
    let of_normals = agreement("normals", normals.written()?, normals.expected(tasks)?)?;
    let of_classic = agreement("the classic kernel", classic.vertices()?, on_the_cpu(base, &fields, WEIGHT))?;
    let of_rule = agreement("the classic rule", rule.vertices()?, rule.expected(tasks)?)?;

    let found = |method: &str, times: &Times| Finding::time("vertices", method, "", count, times, "ms");
    let ours = |method: &str| found(method, if method == "normals" { &n } else { &p });
    bench.add(
        ours("positions")
            .moving(per_vertex[0], &copy_p)
            .beside("classic", &c, Sense::Cost)
            .checked(of_positions)
            .aim_if(largest, "classic"),
    );
    let share = Finding::time("vertices", "positions", "of_copy", count, &p, "ms").moving(per_vertex[0], &copy_p);
    bench.add(share.beside("copy", &copy_p, Sense::Speed).checked(of_positions).aim_if(largest, "bandwidth"));
    bench.add(ours("normals").moving(per_vertex[1], &copy_n).beside("copy", &copy_n, Sense::Speed).checked(of_normals));
    bench.add(
        found("classic", &c).moving(per_vertex[2], &copy_c).beside("copy", &copy_c, Sense::Speed).checked(of_classic),
    );
    bench.add(found("classic rule", &r).beside("classic", &c, Sense::Speed).checked(of_rule));
    bench.add(found("copy", &copy_p).moving(per_vertex[0], &copy_p).checked(copy_positions.check()?));
    copy_normals.check()?;
    copy_classic.check()?;
    bench.add(found("cpu", &on_cpu).beside("positions", &p, Sense::Cost).checked(of_cpu));
    // What the host's own barrier and timestamps take.
    bench.add(found("nothing", &nothing));
    Ok(())
}
