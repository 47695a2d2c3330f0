//! What predicting a hit from many examples costs.

use std::cell::Cell;
use std::sync::Arc;

use anyhow::Result;
use crumple::{ExampleSet, Hit, Instance, InstanceOptions};
use xxhash_rust::xxh3::Xxh3;

use super::baked;
use super::measure::{Contender, interleaved, timed};
use super::report::{Row, Sense};
use super::sheet::{Dent, Reach, Sheet};
use super::{Bench, Size};

const EXAMPLES: usize = 100;
const HITS: usize = 1000;
/// Calls that are timed together.
const BATCH: usize = 10;

pub fn run(bench: &Bench) -> Result<()> {
    for size in [Size::K10, Size::K100, Size::M1] {
        let name = format!("predict_{EXAMPLES}_{}", size.name());
        if !bench.wanted(&name) || bench.quick && size == Size::M1 {
            continue;
        }
        let sheet = Sheet::new(size.vertices());
        let dents = spread(EXAMPLES).map(|centre| Dent { centre, depth: 0.02, reach: Reach::Disc(0.05) });
        let examples = dents.map(|d| sheet.example(&d)).collect();
        let set = ExampleSet::build(sheet.surface(), examples, baked(), bench.tasks(2))?;
        measure(bench, name, &sheet, Arc::new(set))?;
    }
    Ok(())
}

fn measure(bench: &Bench, name: String, sheet: &Sheet, set: Arc<ExampleSet>) -> Result<()> {
    let body = Instance::new(set.clone(), InstanceOptions::default())?;
    let hits: Vec<Hit> = spread(HITS)
        .enumerate()
        .map(|(i, at)| {
            let point = set.mesh().positions()[sheet.vertex(at) as usize];
            // Beside the surface, as contacts are, of many depths, leaning a little.
            let depth = 0.01 + 0.01 * (i as f32 / HITS as f32);
            Hit::displacement([point.x, point.y, point.z + 1e-4], [0.05 * depth, 0.02 * depth, -depth])
        })
        .collect();
    let mut hash = Xxh3::new();
    for hit in &hits {
        let outcome = body.preview(hit)?;
        hash.update(&outcome.contact_vertex.to_le_bytes());
        hash.update(bytemuck::cast_slice(&outcome.mark.map_or([0; 8], bytemuck::cast::<_, [u32; 8]>)));
    }
    let turn = |at: &Cell<usize>| {
        let from = at.get();
        at.set((from + BATCH) % HITS);
        from..from + BATCH
    };
    let (a, b) = (Cell::new(0), Cell::new(0));
    let mut contenders = [
        Contender::new(|| {
            let hits = &hits[turn(&a)];
            timed(|| hits.iter().for_each(|h| _ = std::hint::black_box(body.preview(h))))
        }),
        Contender::new(|| {
            let hits = &hits[turn(&b)];
            timed(|| hits.iter().for_each(|h| _ = std::hint::black_box(set.nearest_vertex(h.point))))
        }),
    ];
    let times = interleaved(&bench.plan, &mut contenders);
    let row = Row::time(name, &times[0].per(BATCH as f64), "µs");
    let row = row.beside_time("nearest vertex", &times[1].per(BATCH as f64), Sense::Cost);
    bench.add(row.hash(hash.digest()));
    Ok(())
}

/// Places spread evenly, in no order: a sequence of low discrepancy (Roberts' R2).
pub fn spread(count: usize) -> impl Iterator<Item = [f32; 2]> {
    (1..=count).map(|i| [0.754_877_666_246_692_8, 0.569_840_290_998_053_3].map(|s: f64| (i as f64 * s).fract() as f32))
}
