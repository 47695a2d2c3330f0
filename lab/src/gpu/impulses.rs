//! Impulses that overlap: ten of them against ten passes and one pass of the classic kernel.

use anyhow::Result;
use crumple::{Instance, InstanceOptions, Mark};
use glam::Vec3;

use super::Bench;
use super::check::{Agreement, ULPS};
use super::findings::Finding;
use super::literature::{Literature, on_the_cpu};
use super::recorded::{Output, Recorded, WORKGROUP};
use super::scene::{STRENGTHS, Toggled, WEIGHT, at_strength, sheet};
use crate::bench::marks::overlapping;
use crate::bench::measure::{Contender, Times};
use crate::bench::reference::field;
use crate::bench::report::Sense;
use crate::bench::sheet::own_marks;

const COUNTS: [usize; 3] = [1, 3, 10];

pub fn run(bench: &Bench<'_>, sizes: &[usize]) -> Result<()> {
    for (i, size) in sizes.iter().enumerate() {
        let largest = i + 1 == sizes.len();
        bench.fits(&format!("impulses, {size}"), one(bench, *size, largest))?;
    }
    Ok(())
}

fn one(bench: &Bench<'_>, size: usize, largest: bool) -> Result<()> {
    let (gpu, tasks) = (bench.gpu, &bench.tasks);
    let set = sheet(size, &overlapping(), false, tasks)?;
    // As deep as ten dents may add up to: the limit must not be what is measured.
    let options = InstanceOptions { depth_limit: Some(1.0), ..InstanceOptions::default() };
    let body =
        || -> Result<Recorded<'_>> { Recorded::one(gpu, Instance::new(set.clone(), options)?, Output::Positions) };
    let all = own_marks(&set)?;
    let fresh = |count: usize| Toggled::marks(body()?, &all[..count], 1);
    // Of a body that has all ten, all change, or the first alone.
    let ten = at_strength(&all, STRENGTHS[0]);
    let first = [at_strength(&all[..1], STRENGTHS[1]), ten[1..].to_vec()].concat();
    let has_ten = |other: Vec<Mark>| Toggled::new(body()?, [ten.clone(), other], 1);
    let mut ours = [fresh(COUNTS[0])?, fresh(COUNTS[1])?, fresh(COUNTS[2])?];
    let mut again = [has_ten(first)?, has_ten(at_strength(&all, STRENGTHS[1]))?];

    let fields: Vec<Vec<(u32, Vec3)>> = set.examples().iter().map(|e| field(&set, e)).collect();
    let base = set.mesh().positions();
    let classic = |count: usize| Literature::new(gpu, base, &fields[..count], WEIGHT, WORKGROUP);
    let mut classic = [classic(COUNTS[0])?, classic(COUNTS[1])?, classic(COUNTS[2])?];
    let ([a, b, c], [d, e], [f, g, h]) = (&mut ours, &mut again, &mut classic);
    let times: [Times; 8] = bench.measure([
        Contender::new(|| a.run()),
        Contender::new(|| b.run()),
        Contender::new(|| c.run()),
        Contender::new(|| d.run()),
        Contender::new(|| e.run()),
        Contender::new(|| f.run()),
        Contender::new(|| g.run()),
        Contender::new(|| h.run()),
    ]);

    let found = |method: &str, count: usize, times: &Times| {
        let moved = union(&fields[..count], base.len());
        Finding::time("impulses", method, &count.to_string(), moved, times, "ms")
    };
    for (i, count) in COUNTS.into_iter().enumerate() {
        let (got, wanted) = ours[i].vertices(tasks)?;
        let agreement = Agreement::of(gpu, &format!("{count} impulses"), (&got, &wanted), ULPS)?;
        bench.add(found("fresh", count, &times[i]).beside("classic", &times[5 + i], Sense::Speed).checked(agreement));
        if count == 10 {
            let finding = found("fresh against one pass", count, &times[i]).checked(agreement);
            bench.add(finding.beside("classic, one example", &times[5], Sense::Cost).aim_if(largest, "ten"));
        }
        let expected = on_the_cpu(base, &fields[..count], WEIGHT);
        let agreement = Agreement::of(gpu, &format!("{count} classic"), (&classic[i].vertices()?, &expected), ULPS)?;
        bench.add(found("classic", count, &times[5 + i]).checked(agreement));
    }
    for (i, body) in again.iter_mut().enumerate() {
        let (got, wanted) = body.vertices(tasks)?;
        let agreement = Agreement::of(gpu, "repeated impulses", (&got, &wanted), ULPS)?;
        let finding = found("repeated", [1, 10][i], &times[3 + i]).checked(agreement);
        bench.add(if i == 1 { finding.beside("one", &times[3], Sense::Cost) } else { finding });
    }
    Ok(())
}

/// How many vertices any of these fields moves.
fn union(fields: &[Vec<(u32, Vec3)>], vertices: usize) -> usize {
    let mut moved = vec![false; vertices];
    fields.iter().flatten().for_each(|(v, _)| moved[*v as usize] = true);
    moved.into_iter().filter(|m| *m).count()
}
