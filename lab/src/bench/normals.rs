//! What normals cost on top of positions, and octahedral ones beside floats.

use std::sync::Arc;

use anyhow::Result;
use crumple::{ExampleSet, InstanceOptions, SetOptions};

use super::deformed::Deformed;
use super::measure::{Contender, interleaved};
use super::report::{Aim, Row, Sense};
use super::sheet::{Dent, Sheet, own_marks};
use super::{Bench, Size, baked};

/// One mark over all of the sheet, on one thread.
pub fn run(bench: &Bench) -> Result<()> {
    let sheet = Sheet::new(if bench.quick { Size::K64 } else { Size::M1 }.vertices());
    let options = SetOptions { mirror: false, ..baked() };
    let examples = vec![sheet.example(&Dent::whole([0.5; 2]))];
    let set = Arc::new(ExampleSet::build(sheet.surface(), examples, options, bench.tasks(2))?);
    let marks = own_marks(&set)?;
    let make = |normals| Deformed::new(&set, InstanceOptions::default(), &marks, normals, bench.tasks(1));
    let (mut with, mut without) = (make(true)?, make(false)?);
    let mut packed = make(false)?.with_octahedral_normals()?;
    let mut contenders =
        [Contender::new(|| with.run()), Contender::new(|| without.run()), Contender::new(|| packed.run())];
    let times = interleaved(&bench.plan, &mut contenders);
    drop(contenders);
    let row = Row::time("normals", &times[0], "ms").beside_time("positions", &times[1], Sense::Cost);
    bench.add(row.aim(Aim::AtMost(1.9)).hash(with.hash()));
    let row = Row::time("normals_octahedral", &times[2], "ms").beside_time("normals", &times[0], Sense::Cost);
    bench.add(row.hash(packed.hash()));
    Ok(())
}
