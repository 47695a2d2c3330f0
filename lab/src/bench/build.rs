//! Making sets: from arrays, and from baked files once there are such.

use std::time::Instant;

use anyhow::{Result, ensure};
use crumple::ExampleSet;
use kiddo::ImmutableKdTree;
use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::baked;
use super::measure::{Contender, Times, interleaved, timed};
use super::reference::Memcpy;
use super::report::{Aim, Row, Sense};
use super::sheet::{Dent, Reach, Sheet};
use super::{Bench, Size};

const EXAMPLES: usize = 24;

/// The sheet with its local examples, spread over it.
fn dents() -> Vec<Dent> {
    let centre = |i: usize| [0.1 + 0.16 * (i % 6) as f32, 0.14 + 0.24 * (i / 6) as f32];
    (0..EXAMPLES).map(|i| Dent { centre: centre(i), depth: 0.03, reach: Reach::Disc(0.1) }).collect()
}

/// A set of a million vertices and 24 local examples, from arrays, on two threads.
pub fn build(bench: &Bench) -> Result<()> {
    let sheet = Sheet::new(Size::M1.vertices());
    let mut seconds = Vec::new();
    let mut fingerprint = 0;
    let mut bytes = 0;
    for _ in 0..if bench.quick { 1 } else { 3 } {
        let mesh = sheet.surface();
        let examples: Vec<_> = dents().iter().map(|d| sheet.example(d)).collect();
        bytes = mesh.positions.len() * 12 + mesh.triangles.len() * 12;
        let start = Instant::now();
        let set = ExampleSet::build(mesh, examples, baked(), bench.tasks(2))?;
        seconds.push(start.elapsed().as_secs_f64());
        bytes += set.examples().iter().map(|e| 16 * e.moved_vertices()).sum::<usize>();
        fingerprint = set.fingerprint();
    }
    // Copying what goes in.
    let (from, mut to) = (vec![1u8; bytes], vec![0u8; bytes]);
    let mut copy = [Contender::new(|| timed(|| to.copy_from_slice(&from)))];
    let memcpy = interleaved(&bench.plan, &mut copy).remove(0);
    let row = Row::time("build_1m_24ex", &Times::new(seconds), "s");
    bench.add(row.beside_time("memcpy", &memcpy, Sense::Cost).hash(fingerprint));
    Ok(())
}

/// The index of nearest vertices. The library's own is not reachable alone: two others are shown, as what to beat.
pub fn index(bench: &Bench) -> Result<()> {
    let sheet = Sheet::new(Size::M1.vertices());
    let points = sheet.positions();
    let vectors: Vec<glam::Vec3> = points.iter().map(|p| (*p).into()).collect();
    let mut memcpy = Memcpy::new(&vectors, points.len(), bench.tasks(1));
    let mut contenders = [
        Contender::new(|| timed(|| _ = std::hint::black_box(kd_tree(&points)))),
        Contender::new(|| {
            let entries: Vec<_> = points.iter().zip(0u32..).map(|(p, v)| GeomWithData::new(*p, v)).collect();
            timed(|| _ = std::hint::black_box(RTree::bulk_load(entries)))
        }),
        Contender::new(|| memcpy.run()),
    ];
    let times = interleaved(&bench.plan, &mut contenders);
    drop(contenders);
    for (name, times_of) in [("index_build_1m_kiddo", &times[0]), ("index_build_1m_rstar", &times[1])] {
        bench.add(Row::time(name, times_of, "ms").beside_time("memcpy", &times[2], Sense::Cost));
    }
    Ok(())
}

fn kd_tree(points: &[[f32; 3]]) -> ImmutableKdTree<f32, 3> {
    ImmutableKdTree::new_from_slice(points)
}

/// Loading a baked set of a million vertices and 24 examples from memory, against copying the file's bytes.
pub fn load(bench: &Bench) -> Result<()> {
    let sheet = Sheet::new(Size::M1.vertices());
    let examples: Vec<_> = dents().iter().map(|d| sheet.example(d)).collect();
    let set = ExampleSet::build(sheet.surface(), examples, baked(), bench.tasks(2))?;
    let saved = set.save()?;
    let (fingerprint, bytes) = (set.fingerprint(), saved.len());
    drop(set);
    // A set keeps what it was loaded from.
    let file: &'static [u8] = saved.leak();
    let mut to = vec![0u8; bytes];
    let load = |threads| timed(|| _ = std::hint::black_box(ExampleSet::load(file, bench.tasks(threads))));
    let mut contenders =
        [Contender::new(|| load(1)), Contender::new(|| load(2)), Contender::new(|| timed(|| to.copy_from_slice(file)))];
    let times = interleaved(&bench.plan, &mut contenders);
    drop(contenders);
    ensure!(ExampleSet::load(file, bench.tasks(1))?.fingerprint() == fingerprint, "the loaded set is another one");
    for (name, time) in [("load_1m_24ex", &times[0]), ("load_1m_24ex_t2", &times[1])] {
        let row = Row::time(name, time, "ms").beside_time("memcpy", &times[2], Sense::Cost).hash(fingerprint);
        bench.add(row.aim(Aim::AtMost(1.2)));
    }
    bench.add(Row::new("load_1m_24ex_size", bytes as f64 / 1e6, "MB"));
    Ok(())
}
