//! Random scenes: a bent sheet with examples, and frames with hits on it.

use std::sync::Arc;

use arbitrary::Unstructured;
use crumple::{
    BasisOptions, Contact, Deltas, ExampleData, ExampleSet, Hit, Instance, InstanceOptions, Mark, MeshData, Serial,
    SetOptions,
};

use crate::seeds;

/// A node at every position, so that vertices are where marks say, up to rounding.
pub const EVERY_NODE: BasisOptions = BasisOptions { tolerance: 1e9, rounds: 0, nodes: usize::MAX };

/// A number from `low` to `high`.
fn between(bytes: &mut Unstructured<'_>, low: f32, high: f32) -> arbitrary::Result<f32> {
    Ok(low + (high - low) * f32::from(bytes.arbitrary::<u16>()?) / 65535.0)
}

fn vector(bytes: &mut Unstructured<'_>, size: f32) -> arbitrary::Result<[f32; 3]> {
    Ok([between(bytes, -size, size)?, between(bytes, -size, size)?, between(bytes, -size, size)?])
}

/// A bent sheet with a seam, in a unit of 1 mm to 1 km.
fn mesh(bytes: &mut Unstructured<'_>, unit: f32) -> arbitrary::Result<MeshData> {
    let mut mesh = seeds::sheet([2, 6, 12, 16][bytes.choose_index(4)?]);
    let (along, across) = (between(bytes, -1.0, 1.0)?, between(bytes, -1.0, 1.0)?);
    for p in &mut mesh.positions {
        p[2] = along * p[0] * p[0] + across * p[0] * p[1];
        *p = p.map(|x| x * unit);
    }
    let n = mesh.positions.len();
    mesh.normals = bytes.ratio(1, 2)?.then(|| vec![[0.0, 0.0, 1.0]; n]);
    if mesh.normals.is_some() && bytes.ratio(1, 2)? {
        mesh.tangents = Some(vec![[1.0, 0.0, 0.0, -1.0]; n]);
    }
    Ok(mesh)
}

fn example(bytes: &mut Unstructured<'_>, mesh: &MeshData, unit: f32) -> arbitrary::Result<ExampleData> {
    let contact = bytes.choose_index(mesh.positions.len())?;
    let (centre, radius) = (mesh.positions[contact], unit * between(bytes, 0.05, 0.6)?);
    let push = vector(bytes, 0.2 * unit)?;
    let mut field: Vec<[f32; 3]> = Vec::new();
    for p in &mesh.positions {
        let d = [0, 1, 2].map(|k| (p[k] - centre[k]) / radius);
        let w = (1.0 - d.iter().map(|x| x * x).sum::<f32>()).max(0.0);
        field.push(push.map(|x| x * w * w));
    }
    let mut example = ExampleData::new("dent", Deltas::Full(field));
    example.contact = bytes.ratio(1, 2)?.then_some(Contact::Vertex(contact as u32));
    Ok(example)
}

/// A body without damage, and the unit of its lengths, m. `None` if its examples are not a set.
fn body(bytes: &mut Unstructured<'_>) -> arbitrary::Result<Option<(Instance, f32)>> {
    let unit = [1.0, 1e-3, 1e3, 0.1][bytes.choose_index(4)?];
    let mesh = mesh(bytes, unit)?;
    let count = bytes.int_in_range(1..=6)?;
    let examples = (0..count).map(|_| example(bytes, &mesh, unit)).collect::<Result<Vec<_>, _>>()?;
    let options = SetOptions {
        mirror: bytes.arbitrary()?,
        held_rims: bytes.arbitrary()?,
        whole_examples: true,
        basis: bytes.ratio(1, 2)?.then_some(EVERY_NODE),
        tolerance: if bytes.arbitrary()? { Some(unit * [1e-6, 1e-4, 1e-2][bytes.choose_index(3)?]) } else { None },
        depth_limit: if bytes.arbitrary()? { Some(unit * between(bytes, 0.001, 0.5)?) } else { None },
        ..SetOptions::default()
    };
    let capacity = bytes.int_in_range(1..=16)?;
    let Ok(set) = ExampleSet::build(mesh, examples, options, &Serial) else { return Ok(None) };
    let options = InstanceOptions { capacity, ..InstanceOptions::default() };
    Ok(Some((Instance::new(Arc::new(set), options).expect("options"), unit)))
}

/// Makes a body and calls `frame` with it after the hits of each frame. Returns the body as it is after the last. `None` if
/// there is none, or the bytes end before.
pub fn play(bytes: &mut Unstructured<'_>, mut frame: impl FnMut(&mut Instance)) -> Option<Instance> {
    let (mut body, unit) = body(bytes).ok()??;
    let set = body.example_set().clone();
    let hits = |bytes: &mut Unstructured<'_>, body: &mut Instance| {
        for _ in 0..bytes.int_in_range(0..=6)? {
            let at = set.mesh().positions()[bytes.choose_index(set.vertex_count())?].to_array();
            let jitter = vector(bytes, 0.01 * unit)?;
            let hit = Hit::displacement([0, 1, 2].map(|k| at[k] + jitter[k]), vector(bytes, 0.3 * unit)?);
            body.submit(&hit).expect("a hit near the surface");
        }
        if bytes.ratio(1, 16)? {
            // As after many more hits.
            let times = [2, 100, 100_000_000][bytes.choose_index(3)?];
            let marks = body.marks().expect("marks").iter();
            let more: Vec<_> = marks.map(|m| Mark { energy: m.energy.saturating_mul(times), ..*m }).collect();
            body.set_marks(&more).expect("valid marks");
        }
        if bytes.ratio(1, 8)? {
            body.repair(between(bytes, 0.0, 1.0)?).expect("a share");
        }
        Ok::<_, arbitrary::Error>(())
    };
    for _ in 0..bytes.int_in_range(1..=3).ok()? {
        hits(bytes, &mut body).ok()?;
        frame(&mut body);
    }
    Some(body)
}
