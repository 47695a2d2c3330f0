//! Bodies that carry several marks: what a frame of many hits costs beside one hit, and what carried marks cost.

use std::sync::Arc;

use anyhow::Result;
use crumple::{ExampleSet, Hit, InstanceOptions, Mark, Mirror, Pair, Placement, TaskSystem};

use super::deformed::Deformed;
use super::measure::{Contender, Times, interleaved};
use super::reference::Classic;
use super::report::{Aim, Row, Sense};
use super::sheet::{Dent, Reach, Sheet, own_marks};
use super::{Bench, Size};

/// Ten impulses that repeat the ten marks of a body, against one of them; and ten on a fresh body, against one.
pub fn batch(bench: &Bench) -> Result<()> {
    let set = Sheet::new(Size::K64.vertices()).set(&overlapping(), bench.tasks(2))?;
    // As deep as ten dents may add up to: the limit must not be what is measured.
    let options = InstanceOptions { depth_limit: Some(1.0), ..Default::default() };
    let hit =
        |e: &crumple::Example| Hit::displacement(e.contact_point().to_array(), e.contact_displacement().to_array());
    let hits: Vec<Hit> = set.examples().iter().map(hit).collect();
    let marks = own_marks(&set);
    let tasks = bench.tasks(1);
    for (name, before, aim) in [("batch_10", &marks[..], Some(Aim::AtMost(1.5))), ("batch_10_fresh", &[], None)] {
        let mut bodies = [0, 1].map(|_| Deformed::new(&set, options, &[], false, tasks));
        let [Ok(ten), Ok(one)] = &mut bodies else { anyhow::bail!("the body of {name} cannot be made") };
        let mut contenders =
            [Contender::new(|| ten.hit(before, &hits)), Contender::new(|| one.hit(before, &hits[..1]))];
        let times = interleaved(&bench.plan, &mut contenders);
        drop(contenders);
        let row = Row::time(name, &times[0], "µs").beside_time("one hit", &times[1], Sense::Cost);
        bench.add(Row { aim, ..row.hash(ten.hash()) });
    }
    Ok(())
}

/// Ten dents all over the same part of the sheet, each with its own contact.
pub fn overlapping() -> Vec<Dent> {
    let dent = |i: usize| {
        let centre = [0.41 + 0.02 * i as f32, 0.5 + 0.05 * (1.9 * i as f32).sin()];
        Dent { centre, depth: 0.05 - 0.002 * i as f32, reach: Reach::Disc(0.35) }
    };
    (0..10).map(dent).collect()
}

/// Carried marks whose stamps cover the sheet.
pub fn carried(bench: &Bench) -> Result<()> {
    for (size, place) in [(Size::K30, "cache"), (Size::M1, "1m")] {
        let names = [(1, 1), (1, 3), (3, 1), (3, 3)].map(|(marks, k)| (marks, k, name(marks, k, place)));
        if !names.iter().any(|(.., name)| bench.wanted(name)) {
            continue;
        }
        let set = carried_set(size.vertices(), bench.tasks(2))?;
        let tasks = bench.tasks(1);
        let mut ours = Vec::new();
        for (marks, k, name) in names {
            let marks = carried_marks(&set, size.vertices(), marks, k);
            ours.push((name, Deformed::new(&set, InstanceOptions::default(), &marks, false, tasks)?));
        }
        // One pass over the vertices that an example of the whole sheet moves, which is all of them.
        let everything: Vec<(u32, glam::Vec3)> = crate::bench::reference::field(&set, &set.examples()[0]);
        let mut classic = Classic::new(set.mesh().positions(), &[everything], tasks);
        let entries = classic.entries();
        let mut contenders: Vec<Contender> = ours.iter_mut().map(|(_, d)| Contender::new(|| d.run())).collect();
        contenders.push(Contender::new(|| classic.run()));
        let times = interleaved(&bench.plan, &mut contenders);
        drop(contenders);
        let per_vertex: Vec<(Times, u64)> = ours
            .iter_mut()
            .zip(&times)
            .map(|((_, d), t)| {
                let hash = d.hash();
                (t.per(d.moved() as f64), hash)
            })
            .collect();
        let classic = times[times.len() - 1].per(entries as f64);
        for (i, (name, _)) in ours.iter().enumerate() {
            let (t, hash) = &per_vertex[i];
            let row = Row::time(name, t, "ns/vertex").beside_time("classic", &classic, Sense::Cost).hash(*hash);
            let aim = (i == 0).then_some(Aim::AtMost(if place == "1m" { 3.0 } else { 2.0 }));
            bench.add(Row { aim, ..row });
        }
        for (k, one, three) in [(1, 0, 2), (3, 1, 3)] {
            let row = Row::time(format!("{}_vs_one", name(3, k, place)), &per_vertex[three].0, "ns/vertex");
            let row = row.beside_time("one mark", &per_vertex[one].0, Sense::Cost);
            bench.add(row.aim(Aim::AtMost(2.5)));
        }
    }
    Ok(())
}

fn name(marks: usize, k: usize, place: &str) -> String {
    format!("carried_{marks}mark_k{k}_{place}")
}

/// Three examples that move the whole sheet and may be carried.
pub fn carried_set(vertices: usize, tasks: &dyn TaskSystem) -> Result<Arc<ExampleSet>> {
    let sheet = Sheet::new(vertices);
    let dents = [[0.5, 0.5], [0.45, 0.55], [0.55, 0.5]].map(Dent::whole);
    let examples = dents.iter().map(|d| sheet.example(d, Placement::Carried)).collect();
    let mut options = super::baked();
    // Anchored copies of them are not wanted, and a bumpy sheet is no mirror image of itself.
    options.mirror = false;
    Ok(Arc::new(ExampleSet::build(sheet.surface(), examples, options, tasks)?))
}

/// Up to ten marks near the middle, each of `k` examples in equal shares.
pub fn carried_marks(set: &ExampleSet, vertices: usize, count: usize, k: usize) -> Vec<Mark> {
    let sheet = Sheet::new(vertices);
    let near = (3..10).map(|i| [0.5 + 0.05 * (2.4 * i as f32).cos(), 0.5 + 0.05 * (2.4 * i as f32).sin()]);
    let at: Vec<[f32; 2]> = [[0.5, 0.5], [0.52, 0.47], [0.47, 0.53]].into_iter().chain(near).collect();
    let share = Pair::WHOLE / k as i16;
    let mut pairs = [Pair::NONE; 4];
    for (i, pair) in pairs.iter_mut().enumerate().take(k) {
        *pair = Pair::carried(i as u16, share, Mirror::NONE);
    }
    at[..count].iter().map(|c| Mark::new(sheet.vertex(*c), 0.9 * set.examples()[0].depth(), pairs)).collect()
}
