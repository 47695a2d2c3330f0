//! Examples of a sheet, against the classic kernel and against a copy.

use std::sync::Arc;

use anyhow::Result;
use crumple::{ExampleSet, InstanceOptions, MeshData, SetOptions};

use super::deformed::Deformed;
use super::measure::{Contender, interleaved};
use super::report::{Aim, Row, Sense};
use super::sheet::{Dent, Reach, Sheet, own_marks};
use super::sheets::{Measured, Sheets, of};
use super::{Bench, Size, baked};

/// Sizes, and on how many threads.
const CASES: [(Size, usize); 3] = [(Size::K64, 1), (Size::M1, 1), (Size::M10, 2)];

pub fn one_example(bench: &Bench) -> Result<()> {
    for (size, threads) in CASES {
        if bench.quick && size == Size::M10 {
            continue;
        }
        for (suffix, reach) in [("", Reach::Whole), ("_local", Reach::FIFTH)] {
            let case = format!("{}_t{threads}{suffix}", size.name());
            let name = format!("deform_1ex_{case}");
            if !bench.wanted(&name) {
                continue;
            }
            let sheets = Sheets::build(size.vertices(), &[Dent { reach, ..Dent::whole([0.5; 2]) }], bench.tasks(2))?;
            let measured = sheets.measure(bench, &[threads])?;
            let aim = match (reach, size) {
                (Reach::Whole, Size::K64) => Some(1.0),
                (Reach::Whole, _) => Some(1.4),
                _ => None,
            };
            for m in measured.iter().filter(|m| m.is_ours()) {
                rows(bench, &name, m, &measured, aim);
            }
        }
    }
    Ok(())
}

fn rows(bench: &Bench, name: &str, m: &Measured, all: &[Measured], aim: Option<f64>) {
    for (suffix, reference, aim) in [("", "classic", aim), ("_memcpy", "memcpy", None)] {
        let row = Row::time(format!("{name}{suffix}"), &m.times, "ms");
        let row = row.beside_time(reference, of(all, reference, m.threads), Sense::Cost).hash(m.hash);
        bench.add(Row { aim: aim.map(Aim::AtMost), ..row });
    }
}

/// Four overlapping examples, against four passes of the kernel.
pub fn four_examples(bench: &Bench) -> Result<()> {
    let dents = [[0.3, 0.4], [0.6, 0.3], [0.5, 0.7], [0.7, 0.6]].map(Dent::whole);
    let sheets = Sheets::build(Size::M1.vertices(), &dents, bench.tasks(2))?;
    let measured = sheets.measure(bench, &[1])?;
    for m in measured.iter().filter(|m| m.is_ours()) {
        let row = Row::time("deform_4ex_1m_t1", &m.times, "ms");
        let row = row.beside_time("classic x 4", of(&measured, "classic", 1), Sense::Speed).hash(m.hash);
        bench.add(row.aim(Aim::AtLeast(3.0)));
    }
    Ok(())
}

/// One example with limits of every vertex, against the same without: limits that no dent meets, limits that dents meet, and
/// a stiffness.
pub fn limits(bench: &Bench) -> Result<()> {
    let size = if bench.quick { Size::K64 } else { Size::M1 };
    let (sheet, dent) = (Sheet::new(size.vertices()), Dent::whole([0.5; 2]));
    let all = |x: f32| Some(vec![x; sheet.len()]);
    let meshes = [
        ("none", sheet.points()),
        ("unmet", MeshData { depth_limits: all(2.0 * dent.depth), ..sheet.points() }),
        ("met", MeshData { depth_limits: all(0.2 * dent.depth), ..sheet.points() }),
        ("stiffness", MeshData { stiffness: all(0.5), ..sheet.points() }),
    ];
    let mut methods = Vec::new();
    for (name, mesh) in meshes {
        let examples = vec![sheet.example(&dent)];
        let options = SetOptions { mirror: false, ..baked() };
        let set = Arc::new(ExampleSet::build(mesh, examples, options, bench.tasks(2))?);
        methods
            .push((name, Deformed::new(&set, InstanceOptions::default(), &own_marks(&set)?, false, bench.tasks(1))?));
    }
    let mut contenders: Vec<Contender> = methods.iter_mut().map(|(_, m)| Contender::new(|| m.run())).collect();
    let times = interleaved(&bench.plan, &mut contenders);
    drop(contenders);
    for ((name, method), own) in methods.iter_mut().zip(&times).skip(1) {
        let row = Row::time(format!("limits_{name}_{}_t1", size.name()), own, "ms");
        bench.add(row.beside_time("no limits", &times[0], Sense::Cost).hash(method.hash()));
    }
    Ok(())
}
