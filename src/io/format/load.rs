//! Makes a set from a file.

use super::check;
use super::layout::{AnchoredRecord, ExampleRecord, Id, MeshRecord, SetRecord, wrong};
use super::read::{File, length_of};
use crate::base::array::{Array, FileBytes};
use crate::base::error::Error;
use crate::base::tasks::TaskSystem;
use crate::base::tasks::map;
use crate::basis::{Rows, TILE};
use crate::example::blocks::{DeltaBlocks, Head, Steps};
use crate::example::blow::{Blow, Striker, StrikerShape};
use crate::example::example::Example;
use crate::example::mesh_lod::MeshLod;
use crate::example::options::{SetOptions, VertexMass, check_options};
use crate::example::report::{LodReport, SetReport};
use crate::example::rule::LearnedRule;
use crate::example::set::{ExampleSet, MAX_MESHES, Parts, check_order, deepest};
use crate::mesh::limits::{Halves, Limits, half, whole};
use crate::mesh::mirror::Mirror;
use crate::mesh::nearest::{LEAF, Leaf, VertexIndex};
use crate::mesh::rim::Rim;
use crate::mesh::vertex_blocks::BLOCK;
use crate::mesh::{MAX_COORDINATE, Mesh, MeshArrays};
use bytemuck::{Pod, cast_slice};
use glam::Vec3;
use std::sync::Arc;

/// Makes the set from a file's bytes.
pub(super) fn set(bytes: &FileBytes, tasks: &dyn TaskSystem) -> Result<ExampleSet, Error> {
    let file = File::read(bytes, tasks)?;
    let record = *one::<SetRecord>(&file.array(Id::Set, 0)?, Id::Set)?;
    if !(1..=MAX_MESHES as u32).contains(&record.meshes) {
        return Err(wrong("the number of meshes", record.meshes, format!("1 to {MAX_MESHES}")));
    }
    // The nodes are the last mesh.
    file.check_meshes(record.meshes + 1)?;
    if !(1..u32::from(u16::MAX)).contains(&record.examples) {
        return Err(wrong("the number of examples", record.examples, "1 to 65534"));
    }
    let count = record.examples as usize;
    let records: Array<ExampleRecord> = file.array_of(Id::Examples, 0, count)?;
    let vertices = one::<MeshRecord>(&file.array(Id::Mesh, 0)?, Id::Mesh)?.vertices as usize;
    let options = options(&record, &file, vertices)?;
    let steps = options.tolerance.map_or(Steps::EXACT, |t| Steps::new(t, options.normal_tolerance));
    if !(steps.position.is_finite() && steps.normal > 0.0) {
        return Err(wrong("the tolerance", record.tolerance, "such that its steps are floats"));
    }
    // Levels of detail follow nodes and have no examples.
    let base = mesh_lod(&file, 0, if options.whole_examples { count } else { 0 }, steps)?;
    let lods = (1..record.meshes).map(|k| mesh_lod(&file, k, 0, steps)).collect::<Result<Vec<_>, _>>()?;
    let nodes = mesh_lod(&file, record.meshes, count, steps)?;
    let bodies = || [&base].into_iter().chain(&lods);
    check_all(bodies().chain([&nodes]), tasks)?;
    let rows = (0..).zip(bodies()).map(|(k, lod)| rows(&file, k, &lod.mesh, &nodes)).collect::<Result<Vec<_>, _>>()?;
    let lods = (1..).zip(lods).map(|(k, lod)| {
        let farthest = one::<MeshRecord>(&file.array(Id::Mesh, k)?, Id::Mesh)?.farthest;
        check::between("the greatest distance of a level of detail", farthest, 0.0, f32::MAX)?;
        let report = LodReport { vertices: lod.vertex_count(), bytes: lod.bytes(), farthest };
        Ok((lod, report))
    });
    let lods = lods.collect::<Result<Vec<_>, Error>>()?;
    let examples = examples(&file, &records, &base, options.tolerance.unwrap_or(0.0))?;
    if deepest(&examples) == 0.0 {
        return Err(wrong("the deepest displacement of all examples", 0, "above 0"));
    }
    let planes = Mirror::from_bits(record.planes);
    if record.planes != planes.bits() || planes != Mirror::NONE && !options.mirror {
        return Err(wrong("the mirror planes", record.planes, "0 to 7; 0 where mirroring is off"));
    }
    let order: Array<u32> = file.array(Id::SourceOrder, 0)?;
    if !order.is_empty() {
        check_order(&order, base.vertex_count()).map_err(|(v, expected)| wrong("section source order", v, expected))?;
    }
    check::between("the widest weld", record.widest_weld, 0.0, f32::INFINITY)?;
    let mut set = ExampleSet::assemble(Parts {
        index: index(&file, &base.mesh)?,
        base,
        lods,
        examples,
        options,
        fingerprint: record.fingerprint,
        report: SetReport {
            mirror_planes: planes,
            welded: record.welded as usize,
            widest_weld: record.widest_weld,
            ..SetReport::default()
        },
        source_order: (!order.is_empty()).then_some(order),
    });
    set.follow(nodes, rows, None);
    let rule: Array<u8> = file.array(Id::Rule, 0)?;
    set.set_rule(LearnedRule::from_bytes(&set.rule_source(&set.nodes().lod), &rule)?);
    Ok(set)
}

/// How mesh `k` follows nodes.
fn rows(file: &File<'_>, k: u32, mesh: &Mesh, nodes: &MeshLod) -> Result<Rows, Error> {
    let nodes_of_tiles: Array<u32> = file.array(Id::TileNodes, k)?;
    let (tiles, weights) = (mesh.positions().len().div_ceil(TILE), TILE * nodes_of_tiles.len());
    let (slopes, units) = if mesh.normals().is_some() { (2 * weights, TILE * tiles) } else { (0, 0) };
    let rows = Rows {
        tiles: file.array_of(Id::Tiles, k, tiles)?,
        nodes: nodes_of_tiles,
        weights: file.array_of(Id::Weights, k, weights)?,
        slopes: file.array_of(Id::Slopes, k, slopes)?,
        slope_units: file.array_of(Id::SlopeUnits, k, units)?,
    };
    check::rows(&rows, mesh.weld(), nodes.vertex_count())?;
    Ok(rows)
}

/// The vertex index. Whatever its arrays hold, queries return vertices of the mesh.
fn index(file: &File<'_>, mesh: &Mesh) -> Result<VertexIndex, Error> {
    let vertices = mesh.positions().len();
    // Only one of the vertices at one position is in the tree.
    let leaves = (vertices - mesh.seam_count()).div_ceil(LEAF);
    let leaves: Array<Leaf> = file.array_of(Id::IndexLeaves, 0, leaves)?;
    check::leaves(&leaves, vertices)?;
    VertexIndex::of(file.array(Id::IndexInner, 0)?, leaves).ok_or_else(check::no_tree)
}

fn one<T: Pod>(array: &Array<T>, id: Id) -> Result<&T, Error> {
    if let [one] = &array[..] { Ok(one) } else { Err(length_of(id, array.len(), 1)) }
}

fn flag(name: &str, x: u8) -> Result<bool, Error> {
    match x {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(wrong(name, x, "0 or 1")),
    }
}

fn options(r: &SetRecord, file: &File<'_>, vertices: usize) -> Result<SetOptions, Error> {
    let masses: Array<f32> = file.array(Id::Masses, 0)?;
    if r.zero != [0; 3] {
        return Err(wrong("bytes 53 to 55 of section set", format!("{:?}", r.zero), "0"));
    }
    if (r.mass_kind == 2) == masses.is_empty() {
        return Err(length_of(Id::Masses, masses.len(), if r.mass_kind == 2 { vertices } else { 0 }));
    }
    let given = |x: f32| (x.to_bits() != 0).then_some(x);
    let options = SetOptions {
        depth_limit: given(r.depth_limit),
        mass: match r.mass_kind {
            0 => VertexMass::None,
            1 => VertexMass::Uniform(r.mass),
            2 => VertexMass::PerVertex(masses.to_vec()),
            other => return Err(wrong("the kind of mass", other, "0 to 2")),
        },
        drop_below: r.drop_below,
        tolerance: given(r.tolerance),
        normal_tolerance: r.normal_tolerance,
        mirror: flag("mirror", r.mirror)?,
        held_rims: flag("held rims", r.held_rims)?,
        basis: None,
        whole_examples: flag("whether examples are whole", r.whole_examples)?,
    };
    check_options(&options, vertices).map_err(|e| Error::Format { what: format!("baked set: {e}") })?;
    Ok(options)
}

/// A mesh with everything that belongs to it. Only the lengths of its arrays are checked.
fn mesh_lod(file: &File<'_>, k: u32, examples: usize, steps: Steps) -> Result<MeshLod, Error> {
    let record = *one::<MeshRecord>(&file.array(Id::Mesh, k)?, Id::Mesh)?;
    let n = record.vertices as usize;
    if n == 0 || record.vertices == u32::MAX {
        return Err(wrong("the number of vertices", n, "1 to 4294967294"));
    }
    let positions = file.array_of(Id::Positions, k, n)?;
    let normals: Option<Array<Vec3>> = file.some_of(Id::Normals, k, n)?;
    let contacts = if normals.is_some() { n } else { 0 };
    let contact_normals: Array<Vec3> = file.array_of(Id::ContactNormals, k, contacts)?;
    let arrays = MeshArrays {
        positions,
        tangents: file.some_of(Id::Tangents, k, n)?,
        triangles: file.array(Id::Triangles, k)?,
        weld: file.array_of(Id::Weld, k, n)?,
        contact_normals: normals.is_some().then_some(contact_normals),
        normals,
    };
    let limits =
        Limits::of(limits(file, (Id::DepthLimits, k), (n, f32::INFINITY))?, limits(file, (Id::Gives, k), (n, 1.0))?);
    let mesh = Mesh::of(arrays, limits, record.repaired_normals as usize, record.degenerate_triangles as usize);
    let rim = Rim {
        blocks: file.array(Id::RimBlocks, k)?,
        windows: file.array(Id::RimWindows, k)?,
        held: file.array(Id::RimHeld, k)?,
    };
    Ok(MeshLod::new(mesh, rim, anchored(file, k, examples, steps)?))
}

/// The numbers of a mesh with `n` vertices, each 0 to `most`.
fn limits(file: &File<'_>, (id, k): (Id, u32), (n, most): (usize, f32)) -> Result<Array<Halves>, Error> {
    let all: Array<Halves> = file.some_of(id, k, n.div_ceil(BLOCK))?.unwrap_or_default();
    // Of numbers that are not negative, the bits sort as the numbers do.
    match all.as_flattened().iter().find(|h| **h > half(most)) {
        Some(h) => Err(wrong(format!("a number of section {}", id.name()), whole(*h), format!("0 to {most}"))),
        None => Ok(all),
    }
}

/// The blocks of each example.
fn anchored(file: &File<'_>, k: u32, examples: usize, steps: Steps) -> Result<Vec<Arc<DeltaBlocks>>, Error> {
    let records: Array<AnchoredRecord> = file.array_of(Id::Anchored, k, examples)?;
    let heads = file.range(Id::Heads, k, size_of::<Head>())?;
    let words = file.range(Id::Words, k, size_of::<u64>())?;
    let (mut head, mut word) = (heads.start, words.start);
    let mut out = crate::base::error::reserve(examples, "examples")?;
    for r in records.iter() {
        let after = |at: usize, count: u32, size: usize| at.saturating_add((count as usize).saturating_mul(size));
        let ends = (after(head, r.heads, size_of::<Head>()), after(word, r.words, size_of::<u64>()));
        if ends.0 > heads.end || ends.1 > words.end {
            let value = format!("{} heads and {} words", r.heads, r.words);
            return Err(wrong("an element of section anchored", value, "what sections heads and words still hold"));
        }
        out.push(Arc::new(DeltaBlocks {
            steps,
            heads: file.part(head..ends.0, Id::Heads)?,
            words: file.part(word..ends.1, Id::Words)?,
        }));
        (head, word) = ends;
    }
    if (head, word) != (heads.end, words.end) {
        return Err(wrong("the sum of section anchored", "less than sections heads and words", "all of them"));
    }
    Ok(out)
}

/// Checks, in tasks, everything whose size grows with the file.
fn check_all<'m>(meshes: impl Iterator<Item = &'m MeshLod>, tasks: &dyn TaskSystem) -> Result<(), Error> {
    type Check<'a> = Box<dyn FnOnce() -> Result<(), Error> + Send + 'a>;
    let mut checks: Vec<Check<'_>> = Vec::new();
    for lod in meshes {
        let a = lod.mesh.arrays();
        let n = lod.vertex_count();
        checks.push(Box::new(move || check::numbers("section positions", cast_slice(&a.positions), MAX_COORDINATE)));
        checks.push(Box::new(move || check::units("section normals", a.normals.as_deref().unwrap_or_default())));
        checks.push(Box::new(move || {
            check::units("section contact normals", a.contact_normals.as_deref().unwrap_or_default())
        }));
        checks.push(Box::new(move || check::indices("section triangles", a.triangles.as_flattened(), n)));
        checks.push(Box::new(move || {
            check::indices("section weld", &a.weld, n)?;
            check::weld(&a.weld, &a.positions)?;
            let limits = lod.mesh.limits();
            let differ = |(v, w): &(usize, &u32)| {
                let (v, w) = (*v as u32, **w);
                limits.depth(v) != limits.depth(w) || limits.give(v) != limits.give(w)
            };
            match a.weld.iter().enumerate().filter(|_| !limits.is_empty()).find(differ) {
                Some((v, w)) => Err(wrong(
                    format!("the limits of vertex {v}"),
                    limits.depth(v as u32),
                    format!("those of vertex {w}"),
                )),
                None => Ok(()),
            }
        }));
        checks.push(Box::new(move || {
            check::numbers("section tangents", cast_slice(a.tangents.as_deref().unwrap_or_default()), f32::MAX)
        }));
        checks.push(Box::new(move || check::rim(&lod.rim, n)));
        for (i, anchored) in lod.anchored.iter().enumerate() {
            checks.push(Box::new(move || check::anchored(anchored, n, &format!("example {i}"))));
        }
    }
    // Returns the first error in order, whichever task finished first.
    map(tasks, checks, |check| check()).into_iter().collect()
}

fn examples(file: &File<'_>, records: &[ExampleRecord], lod: &MeshLod, tolerance: f32) -> Result<Vec<Example>, Error> {
    let names: Array<u8> = file.array(Id::Names, 0)?;
    let mut names = &names[..];
    let mut out = crate::base::error::reserve(records.len(), "examples")?;
    for (i, r) in records.iter().enumerate() {
        let name;
        (name, names) = names
            .split_at_checked(r.name as usize)
            .ok_or_else(|| wrong(format!("the length of the name of example {i}"), r.name, names.len()))?;
        let name = std::str::from_utf8(name).map_err(|e| {
            wrong(format!("the name of example {i}"), format!("wrong at byte {}", e.valid_up_to()), "UTF-8")
        })?;
        out.push(example(i, r, (lod, tolerance), (name, lod.anchored.get(i).cloned()))?);
    }
    if !names.is_empty() {
        return Err(wrong("the rest of section names", format!("{} bytes", names.len()), "empty"));
    }
    Ok(out)
}

fn example(
    i: usize,
    r: &ExampleRecord,
    (lod, tolerance): (&MeshLod, f32),
    (name, whole): (&str, Option<Arc<DeltaBlocks>>),
) -> Result<Example, Error> {
    let of = |what: &str| format!("{what} of example {i}");
    let positions = lod.mesh.positions();
    let Some(contact_point) = positions.get(r.contact_vertex as usize).copied() else {
        return Err(wrong(of("the contact"), r.contact_vertex, format!("below {}", positions.len())));
    };
    let max_depth = r.max_depth;
    check::between(of("the longest displacement"), max_depth, 0.0, check::MAX_DISPLACEMENT)?;
    let contact_delta = Vec3::from_array(r.contact_displacement);
    let depth = contact_delta.length();
    let stored = whole.as_ref().map_or(contact_delta, |whole| whole.delta(r.contact_vertex));
    let off = contact_delta.distance(stored);
    if off.is_nan() || off > tolerance * 1.001 {
        return Err(wrong(
            of("the displacement of the contact"),
            contact_delta,
            "what is stored of it, to the tolerance",
        ));
    }
    if (r.moved > 0) != (max_depth > 0.0) || r.moved as usize > positions.len() {
        return Err(wrong(of("the number of moved vertices"), r.moved, "0 only where none moves, at most all"));
    }
    if (r.moved > 0) != (depth > 0.0) {
        return Err(wrong(of("the displacement of the contact"), depth, "above 0 m where any vertex moves, else 0"));
    }
    let contact_normal = Vec3::from_array(r.contact_normal);
    let contact_normal = (contact_normal != Vec3::ZERO).then_some(contact_normal);
    check::units(&of("the contact normal"), contact_normal.as_slice())?;
    check::between(of("the support radius"), r.support_radius, 0.0, f32::MAX)?;
    let blow = blow(i, r)?;
    Ok(Example {
        name: name.to_owned(),
        contact_vertex: r.contact_vertex,
        contact_point,
        contact_normal,
        contact_delta,
        blow,
        depth,
        max_depth,
        support_radius: r.support_radius,
        moved: r.moved as usize,
        whole,
        followed: None,
    })
}

/// What is known of the blow of example `i`.
fn blow(i: usize, example: &ExampleRecord) -> Result<Blow, Error> {
    let r = &example.blow;
    let Some(shape) = StrikerShape::ALL.get(example.shape as usize) else {
        return Err(wrong(format!("the striker's shape of example {i}"), example.shape, "0 to 4"));
    };
    let number = |x: f32| (!x.is_nan()).then_some(x);
    let vector = |v: [f32; 3]| (!v.iter().all(|x| x.is_nan())).then_some(v);
    let blow = Blow {
        impulse: vector(r.impulse),
        duration: number(r.duration),
        normal: vector(r.normal),
        striker: Striker {
            mass: number(r.striker_mass),
            velocity: vector(r.striker_velocity),
            radius: number(r.striker_radius),
            shape: *shape,
        },
    };
    let name = |part: &str| format!("blow.{part} of example {i}");
    blow.checked(name).map_err(|e| Error::Format { what: format!("baked set: {e}") })?;
    check::units(&name("normal"), blow.normal.map(Vec3::from_array).as_slice())?;
    // Not normalised again, so that the set is saved as the same bytes.
    Ok(blow)
}
