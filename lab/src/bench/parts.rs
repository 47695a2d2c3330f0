//! A body of twelve parts against the same vertices as one mesh.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Result, bail, ensure};
use crumple::{Contact, Deltas, ExampleData, ExampleSet, Hit, MeshData, Serial};

use super::Bench;
use super::baked;
use super::crowd::Crowd;
use super::deformed::hash;
use super::measure::{Contender, interleaved, timed};
use super::report::{Aim, Row, Sense};
use super::sheet::{Dent, Reach, Sheet};

const PARTS: usize = 12;
const VERTICES: usize = 60_000;

/// Repairs a body, then times a hit from its submission to all vertices.
fn hit(body: &mut Crowd, hit: &Hit) -> Duration {
    body.instances[0].reset();
    body.deform(&Serial);
    timed(|| {
        body.instances[0].submit(hit).unwrap_or_else(|e| panic!("{e}"));
        body.instances[0].fold();
        body.deform(&Serial);
    })
}

/// The vertices of each part: whole rows of the sheet. The last row of a part is the first of the next.
fn rows(columns: usize, rows: usize) -> Vec<Range<usize>> {
    let edge = |part: usize| part * (rows - 1) / PARTS;
    (0..PARTS).map(|part| edge(part) * columns..(edge(part + 1) + 1) * columns).collect()
}

fn piece(whole: &MeshData, own: &Range<usize>) -> MeshData {
    let inside = |t: &&[u32; 3]| t.iter().all(|v| own.contains(&(*v as usize)));
    MeshData {
        positions: whole.positions[own.clone()].to_vec(),
        triangles: whole.triangles.iter().filter(inside).map(|t| t.map(|v| v - own.start as u32)).collect(),
        ..MeshData::default()
    }
}

pub fn run(bench: &Bench) -> Result<()> {
    let sheet = Sheet::new(VERTICES);
    let (whole, columns) = (sheet.surface(), sheet.vertex([1.0, 0.0]) as usize + 1);
    let rows = rows(columns, sheet.len() / columns);
    let parts: Vec<MeshData> = rows.iter().map(|own| piece(&whole, own)).collect();
    // The base mesh is all parts joined, so vertices on seams are there twice.
    let mut joined = MeshData::default();
    for part in &parts {
        let first = joined.positions.len() as u32;
        joined.positions.extend(&part.positions);
        joined.triangles.extend(part.triangles.iter().map(|t| t.map(|v| first + v)));
    }
    let dent = Dent { reach: Reach::FIFTH, ..Dent::whole([0.5; 2]) };
    let example = sheet.example(&dent);
    let Deltas::Sparse { indices, values } = example.positions else { bail!("the dent covers the sheet") };
    let moved: HashMap<usize, [f32; 3]> = indices.into_iter().map(|v| v as usize).zip(values).collect();
    let joined_moves =
        rows.iter().cloned().flatten().enumerate().filter_map(|(v, of)| Some((v as u32, *moved.get(&of)?)));
    let (indices, values) = joined_moves.unzip();
    let centre = whole.positions[sheet.vertex(dent.centre) as usize];
    let example =
        ExampleData { positions: Deltas::Sparse { indices, values }, contact: Some(Contact::Point(centre)), ..example };
    let mut set = ExampleSet::build(joined.clone(), vec![example], baked(), bench.tasks(2))?;
    for part in &parts {
        set.add_lod(part.clone(), bench.tasks(2))?;
    }
    let set = Arc::new(set);
    let (mut one, mut many) = (Crowd::new(&set, 1, 0..1)?, Crowd::new(&set, 1, 1..PARTS + 1)?);
    let push = Hit::displacement(centre, [0.0, 0.0, -0.04]);
    let mut contenders = [Contender::new(|| hit(&mut many, &push)), Contender::new(|| hit(&mut one, &push))];
    let times = interleaved(&bench.plan, &mut contenders);
    drop(contenders);
    ensure!(one.positions() == many.positions(), "the parts do not have the vertices of the whole");
    let row = Row::time("parts_12", &times[0], "µs").beside_time("one mesh", &times[1], Sense::Cost);
    bench.add(row.aim(Aim::AtMost(1.2)).hash(hash(&many.positions())));
    Ok(())
}
