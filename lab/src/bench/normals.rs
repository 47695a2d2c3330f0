//! What normals cost on top of positions, and octahedral ones beside floats.

use anyhow::Result;
use crumple::{InstanceOptions, Placement};

use super::deformed::Deformed;
use super::marks::{carried_marks, carried_set};
use super::measure::{Contender, interleaved};
use super::report::{Aim, Row, Sense};
use super::sheet::{Dent, Sheet, own_marks};
use super::{Bench, Size, baked};

/// One mark, K = 1, over all of the sheet, on one thread.
pub fn run(bench: &Bench) -> Result<()> {
    let size = if bench.quick { Size::K64 } else { Size::M1 };
    let mut cases = Vec::new();
    if bench.wanted("normals_anchored") {
        let (sheet, dent) = (Sheet::new(size.vertices()), Dent::whole([0.5; 2]));
        let examples = vec![sheet.example(&dent, Placement::Anchored)];
        let options = crumple::SetOptions { mirror: false, ..baked() };
        let set = crumple::ExampleSet::build(sheet.surface(), examples, options, bench.tasks(2))?;
        let marks = own_marks(&set);
        cases.push(("normals_anchored".to_owned(), set.into(), marks));
    }
    if bench.wanted("normals_carried") {
        let set = carried_set(size.vertices(), bench.tasks(2))?;
        let marks = carried_marks(&set, size.vertices(), 1, 1);
        cases.push(("normals_carried".to_owned(), set, marks));
    }
    for (name, set, marks) in cases {
        let make = |normals| Deformed::new(&set, InstanceOptions::default(), &marks, normals, bench.tasks(1));
        let (mut with, mut without) = (make(true)?, make(false)?);
        let mut packed = make(false)?.with_octahedral_normals()?;
        let mut contenders =
            [Contender::new(|| with.run()), Contender::new(|| without.run()), Contender::new(|| packed.run())];
        let times = interleaved(&bench.plan, &mut contenders);
        drop(contenders);
        let packed_name = format!("{name}_octahedral");
        let row = Row::time(name, &times[0], "ms").beside_time("positions", &times[1], Sense::Cost);
        bench.add(row.aim(Aim::AtMost(1.9)).hash(with.hash()));
        let row = Row::time(packed_name, &times[2], "ms").beside_time("normals", &times[0], Sense::Cost);
        bench.add(row.hash(packed.hash()));
    }
    Ok(())
}
