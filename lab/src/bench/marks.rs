//! Bodies with several marks: what a frame of many hits costs beside one hit.

use anyhow::Result;
use crumple::{Hit, InstanceOptions};

use super::deformed::Deformed;
use super::measure::{Contender, interleaved};
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
    let marks = own_marks(&set)?;
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
