//! Changes vertices in a glTF and removes the targets that are dents, by editing the JSON.

use super::attributes::{Changes, push_changed};
use super::targets::Kept;
use super::vertices::{Rewrite, Vertices};
use super::{compact, images, targets};
use crate::base::error::Error;
use crate::base::math::Aabb;
use crate::io::glb::{Glb, GlbFile, remove_within};
use crate::io::import::Reading;
use crate::io::import::accessor::Accessor;
use crate::io::import::body;
use crate::io::import::document::Document;
use crate::io::import::piece::{Body, Piece};
use crate::io::import::primitives::{Primitive, target_count};
use ::gltf::json::accessor::Type;
use ::gltf::json::mesh::Semantic;
use ::gltf::json::validation::Checked;
use glam::Vec3;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;

pub(super) fn deformed(
    source: &[u8],
    base_dir: Option<&Path>,
    reading: &Reading,
    vertices: Vertices<'_>,
) -> Result<GlbFile, Error> {
    let doc = Document::parse(source, base_dir)?;
    let Body { pieces, imported } = body::read(&doc, reading)?;
    vertices.check(imported.mesh.positions.len())?;
    let mut to = Rewrite { doc: &doc, glb: Glb::new(doc.value.clone()), notes: Vec::new() };
    let change = |piece: &Piece<'_>| {
        let shown = piece.shown_offsets(&doc)?;
        Ok(Changes::of(piece, &imported.mesh, &vertices, shown.as_ref()))
    };
    let changes = pieces.iter().map(change).collect::<Result<Vec<Changes>, Error>>()?;
    let meshes = assigned(&mut to, &pieces, &changes);
    let mut kept = Kept::default();
    for ((piece, changes), mesh) in pieces.iter().zip(&changes).zip(meshes) {
        if changes.any() {
            replace_vertices(&mut to, (piece, mesh), changes)?;
            follow(&mut to, (piece, mesh), changes);
        }
        let targets = target_count(doc.meshes.get(piece.mesh, "mesh")?);
        if !piece.dents.is_empty() {
            let keep: Vec<bool> = (0..targets).map(|target| !piece.dents.contains(&target)).collect();
            piece.nodes.iter().for_each(|node| drop(kept.nodes.insert(*node, keep.clone())));
            kept.meshes.insert(mesh, keep);
        }
    }
    targets::drop(&mut to, &kept);
    images::embed(&mut to);
    let glb = compact::write(&mut to)?;
    Ok(GlbFile { glb, notes: to.notes })
}

/// The mesh that each piece is written to. A mesh that several nodes show is copied for those whose vertices differ; nodes that are no
/// part of the body keep the file's.
fn assigned(to: &mut Rewrite<'_>, pieces: &[Piece<'_>], changes: &[Changes]) -> Vec<usize> {
    let mut others: HashMap<usize, usize> = HashMap::new();
    for mesh in to.doc.nodes.iter().filter_map(|node| node.mesh) {
        *others.entry(mesh.value()).or_default() += 1;
    }
    for piece in pieces {
        *others.entry(piece.mesh).or_default() -= piece.nodes.len();
    }
    // For each mesh whether the file's own is taken, and the one of pieces that did not change.
    let mut taken: HashMap<usize, (bool, Option<usize>)> =
        others.into_iter().map(|(mesh, others)| (mesh, (others > 0, None))).collect();
    let mut out = vec![0; pieces.len()];
    let is_changed = |i: &usize| changes[*i].any();
    let unchanged_first = (0..pieces.len()).filter(|i| !is_changed(i)).chain((0..pieces.len()).filter(is_changed));
    for i in unchanged_first {
        let mesh = pieces[i].mesh;
        let (is_taken, unchanged) = taken.entry(mesh).or_default();
        out[i] = match unchanged {
            Some(known) if !changes[i].any() => *known,
            _ if *is_taken => to.glb.push("meshes", to.doc.value["meshes"][mesh].clone()),
            _ => mesh,
        };
        *is_taken = true;
        if !changes[i].any() {
            *unchanged = Some(out[i]);
        }
        for node in pieces[i].nodes.iter().filter(|_| out[i] != mesh) {
            to.glb.root["nodes"][*node]["mesh"] = out[i].into();
        }
    }
    out
}

/// Gives the primitives of a piece new accessors where vertices changed. The old ones stay for other users.
fn replace_vertices(to: &mut Rewrite<'_>, (piece, mesh): (&Piece<'_>, usize), changes: &Changes) -> Result<(), Error> {
    let mut known: HashMap<usize, Vec<(String, usize)>> = HashMap::new();
    for primitive in &piece.primitives {
        let accessors = match known.entry(primitive.first_vertex) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(slot) => slot.insert(changes.write(to, primitive)?),
        };
        let json = &mut to.glb.root["meshes"][mesh]["primitives"][primitive.index];
        for (semantic, accessor) in &*accessors {
            json["attributes"][semantic] = (*accessor).into();
        }
        // An optional compressed copy of the vertices would take precedence over the new ones.
        if let Some(json) = json.as_object_mut().filter(|_| !accessors.is_empty()) {
            remove_within(json, "extensions", &["KHR_draco_mesh_compression"]);
        }
    }
    Ok(())
}

/// Moves the lines and points of a mesh with the vertices that they share: those of the same accessor, or at the same positions.
fn follow(to: &mut Rewrite<'_>, (piece, mesh): (&Piece<'_>, usize), changes: &Changes) {
    let doc = to.doc;
    let Ok(json) = doc.meshes.get(piece.mesh, "mesh") else { return };
    let is_dented = |index: usize| piece.primitives.iter().any(|primitive| primitive.index == index);
    let others: Vec<usize> = (0..json.primitives.len()).filter(|index| !is_dented(*index)).collect();
    if others.is_empty() || !changes.positions.changed.contains(&true) {
        return;
    }
    let old: Vec<[f32; 3]> =
        piece.primitives.iter().filter(|p| p.owns_vertices).flat_map(|p| file_positions(doc, p)).collect();
    let bits = |p: &[f32; 3]| p.map(|x| (x + 0.0).to_bits());
    let mut new: HashMap<[u32; 3], [f32; 3]> = HashMap::new();
    let mut dent = Aabb::EMPTY;
    for (v, p) in old.iter().enumerate() {
        new.entry(bits(p)).or_insert(changes.positions.values[v]);
        if changes.positions.changed[v] {
            dent.add(Vec3::from(*p));
        }
    }
    // Lines drawn beside the surface lie a little off it.
    let near = Vec3::splat(0.01 * Aabb::of_slice(bytemuck::cast_slice(&old)).diagonal());
    let dent = Aabb { min: dent.min - near, max: dent.max + near };
    let mut left = 0;
    for index in others {
        let attributes = &json.primitives[index].attributes;
        let Some(accessor) = attributes.get(&Checked::Valid(Semantic::Positions)) else { continue };
        let same = |primitive: &&Primitive<'_>| primitive.attribute(Semantic::Positions) == Some(*accessor);
        if let Some(twin) = piece.primitives.iter().find(same) {
            let primitives = &mut to.glb.root["meshes"][mesh]["primitives"];
            primitives[index]["attributes"]["POSITION"] = primitives[twin.index]["attributes"]["POSITION"].clone();
            continue;
        }
        let Ok(own) = Accessor::new(doc, *accessor, "lines", Type::Vec3) else { continue };
        let Ok(before) = own.floats::<3>() else { continue };
        let after: Vec<[f32; 3]> = before.iter().map(|p| new.get(&bits(p)).copied().unwrap_or(*p)).collect();
        let inside = |p: &&[f32; 3]| Vec3::from(**p).clamp(dent.min, dent.max) == Vec3::from(**p);
        left += before.iter().filter(inside).filter(|p| !new.contains_key(&bits(p))).count();
        let changed: Vec<bool> = before.iter().zip(&after).map(|(a, b)| a != b).collect();
        if changed.contains(&true) {
            let number = push_changed(to, &own, (&after, &changed), true);
            to.glb.root["meshes"][mesh]["primitives"][index]["attributes"]["POSITION"] = number.into();
        }
    }
    if left > 0 {
        to.notes.push(format!(
            "{left} vertices of lines or points in {} lie at no vertex of its triangles and stay where they were",
            doc.mesh_label(piece.mesh)
        ));
    }
}

fn file_positions(doc: &Document<'_>, primitive: &Primitive<'_>) -> Vec<[f32; 3]> {
    // They have been read before.
    primitive.positions(doc).and_then(|accessor| accessor.floats::<3>()).unwrap_or_default()
}
