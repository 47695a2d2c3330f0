//! Joins pieces to one body, with its parts.

use super::document::Document;
use super::join_examples::{Moved, examples};
use super::nodes::Nodes;
use super::piece::{Body, Piece};
use super::reading::Mark;
use super::surface::{perpendicular, smooth};
use super::{Imported, Part, PartKind, PrimitiveRange, unsupported, whole};
use crate::base::error::Error;
use crate::base::math::Aabb;
use crate::example::set::MAX_MESHES;
use crate::mesh::data::MeshData;
use glam::Vec3;
use rstar::RTree;
use std::cmp::{Ordering, Reverse};
use std::collections::HashSet;

/// Vertices of different nodes nearer than this share of the body's diagonal lie at one position: node matrices round.
const SAME: f32 = 1e-6;
/// How many of those that lie at one place are compared, so that thousands take no longer than in proportion.
const COMPARED: usize = 256;

/// A mesh in its own space, as a body without parts.
pub(super) fn alone<'d>(doc: &Document<'_>, piece: Piece<'d>, notes: &mut Vec<String>) -> Result<Body<'d>, Error> {
    joined(doc, (vec![piece], Vec::new()), notes)
}

/// The pieces in the order of their parts, as a body of parts.
pub(super) fn body<'d>(
    doc: &Document<'_>,
    nodes: &Nodes<'_, '_>,
    pieces: Vec<Piece<'d>>,
    notes: &mut Vec<String>,
) -> Result<Body<'d>, Error> {
    joined(doc, grouped(pieces, nodes, notes)?, notes)
}

/// A part: its name, its mark, and the number of its pieces.
struct Group {
    name: String,
    mark: Mark,
    pieces: usize,
}

fn joined<'d>(
    doc: &Document<'_>,
    (mut pieces, groups): (Vec<Piece<'d>>, Vec<Group>),
    notes: &mut Vec<String>,
) -> Result<Body<'d>, Error> {
    let vertices: usize = pieces.iter().map(|piece| piece.surface.data.positions.len()).sum();
    if vertices > u32::MAX as usize {
        return Err(unsupported(format!("{vertices} vertices in all parts; 32-bit indices reach {}", u32::MAX)));
    }
    let (mut meshes, mut primitives, mut glass, mut moved) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut first = (0, 0);
    for (i, piece) in pieces.iter_mut().enumerate() {
        piece.first_vertex = first.0;
        let mesh = piece.placed();
        for (primitive, mark) in piece.primitives.iter().zip(&piece.marks) {
            let range = primitive.range(doc, first)?;
            if *mark == Mark::Glass && (piece.mark != Mark::Glass || groups.is_empty()) {
                glass.push(Part {
                    name: range.material.clone().unwrap_or_else(|| primitive.name.clone()),
                    kind: PartKind::Glass,
                    ..part(&range)
                });
            }
            primitives.push(range);
        }
        let examples = piece.placed_examples(mesh.normals.as_deref());
        moved.extend(examples.into_iter().map(|example| Moved::of(example, &mesh, first.0, i)));
        first = (first.0 + mesh.positions.len(), first.1 + mesh.triangles.len());
        meshes.push(mesh);
    }
    let mut parts = parts(&meshes, groups);
    parts.extend(glass);
    if parts.len() >= MAX_MESHES {
        let what = format!(
            "{} parts; a body has at most {}: mark whole nodes as glass instead of materials, or choose fewer (--nodes)",
            parts.len(),
            MAX_MESHES - 1
        );
        return Err(unsupported(what));
    }
    let names: Vec<&str> = pieces.iter().map(|piece| piece.name.as_str()).collect();
    // An OBJ example is one file, so one blow, wherever it dents.
    let scene = whole(&doc.value["scene"]).unwrap_or(0) as usize;
    let joined = doc.value["scenes"][scene]["extras"]["targets"] == "joined";
    let examples = examples(moved, &names, joined, notes);
    let mut mesh = concatenated(meshes)?;
    close_seams(&mut mesh.positions, &pieces);
    let (name, node_transform, notes) = (String::new(), None, Vec::new());
    Ok(Body { pieces, imported: Imported { name, mesh, examples, primitives, parts, node_transform, notes } })
}

fn part(range: &PrimitiveRange) -> Part {
    let PrimitiveRange { first_vertex, vertex_count, first_triangle, triangle_count, .. } = *range;
    Part { name: String::new(), kind: PartKind::Dents, first_vertex, vertex_count, first_triangle, triangle_count }
}

fn parts(meshes: &[MeshData], groups: Vec<Group>) -> Vec<Part> {
    let mut meshes = meshes.iter();
    let (mut first_vertex, mut first_triangle) = (0, 0);
    let part = |Group { name, mark, pieces }: Group| {
        let (mut vertex_count, mut triangle_count) = (0, 0);
        for mesh in meshes.by_ref().take(pieces) {
            vertex_count += mesh.positions.len() as u32;
            triangle_count += mesh.triangles.len() as u32;
        }
        let kind = match mark {
            Mark::Dents => PartKind::Dents,
            Mark::Glass => PartKind::Glass,
            Mark::Rigid | Mark::Moving => PartKind::Rigid,
        };
        let part = Part { name, kind, first_vertex, vertex_count, first_triangle, triangle_count };
        (first_vertex, first_triangle) = (first_vertex + vertex_count, first_triangle + triangle_count);
        part
    };
    groups.into_iter().map(part).collect()
}

/// The pieces in the order of their parts. Each node is a part, unless there are more than a body can have: then the smallest nodes
/// belong to the part of the nearest node above them, or else to one for all others.
fn grouped<'d>(
    pieces: Vec<Piece<'d>>,
    nodes: &Nodes<'_, '_>,
    notes: &mut Vec<String>,
) -> Result<(Vec<Piece<'d>>, Vec<Group>), Error> {
    let is_glass = |piece: &Piece<'_>| piece.mark != Mark::Glass && piece.marks.contains(&Mark::Glass);
    let most = (MAX_MESHES - 1).saturating_sub(pieces.iter().filter(|piece| is_glass(piece)).count());
    let group = |piece: &Piece<'_>| Group { name: piece.name.clone(), mark: piece.mark, pieces: 1 };
    if pieces.len() <= most {
        let groups = pieces.iter().map(group).collect();
        return Ok((pieces, groups));
    }
    // The others are one part for each mark.
    let marks: HashSet<u8> = pieces.iter().map(|piece| piece.mark as u8).collect();
    let kept = most.saturating_sub(marks.len()).max(1);
    let mut by_size: Vec<usize> = (0..pieces.len()).collect();
    by_size.sort_by_key(|i| (Reverse(pieces[*i].surface.data.positions.len()), *i));
    by_size.truncate(kept);
    by_size.sort_unstable();
    let of_node: std::collections::HashMap<usize, usize> =
        by_size.iter().enumerate().flat_map(|(g, i)| pieces[*i].nodes.iter().map(move |node| (*node, g))).collect();
    let nearest = nodes.inherited(None, |node, above: &Option<usize>| of_node.get(&node).copied().or(*above));
    let mut groups: Vec<Group> = by_size.iter().map(|i| group(&pieces[*i])).collect();
    let (mut of_piece, mut small) = (Vec::with_capacity(pieces.len()), 0);
    let mut others = [None; 3];
    for piece in &pieces {
        let above = piece.nodes.first().and_then(|node| nearest[*node]).filter(|g| groups[*g].mark == piece.mark);
        let own = piece.nodes.first().and_then(|node| of_node.get(node)).is_some();
        small += usize::from(!own);
        let slot = &mut others[piece.mark.min(Mark::Rigid) as usize];
        let g = above.or(*slot).unwrap_or_else(|| {
            let name = ["others", "other glass", "other rigid parts"][piece.mark.min(Mark::Rigid) as usize];
            groups.push(Group { name: name.into(), mark: piece.mark, pieces: 0 });
            *slot.insert(groups.len() - 1)
        });
        of_piece.push(g);
    }
    notes.push(format!(
        "{} nodes have meshes, and a body has at most {most} parts: the {small} smallest belong to the part of the node above them \
         or to 'others'; choose nodes with --nodes",
        pieces.len()
    ));
    for (g, group) in groups.iter_mut().enumerate() {
        group.pieces = of_piece.iter().filter(|of| **of == g).count();
    }
    let mut ordered: Vec<(usize, Piece<'d>)> = of_piece.into_iter().zip(pieces).collect();
    ordered.sort_by_key(|(g, _)| *g);
    Ok((ordered.into_iter().map(|(_, piece)| piece).collect(), groups))
}

/// The arrays of all meshes. What a mesh lacks and another has is filled in.
fn concatenated(meshes: Vec<MeshData>) -> Result<MeshData, Error> {
    let has = |of: fn(&MeshData) -> bool| meshes.iter().any(of);
    let mut all = MeshData {
        normals: has(|mesh| mesh.normals.is_some()).then(Vec::new),
        tangents: has(|mesh| mesh.tangents.is_some()).then(Vec::new),
        depth_limits: has(|mesh| mesh.depth_limits.is_some()).then(Vec::new),
        stiffness: has(|mesh| mesh.stiffness.is_some()).then(Vec::new),
        ..MeshData::default()
    };
    for mesh in meshes {
        let (first, count) = (all.positions.len() as u32, mesh.positions.len());
        if let Some(normals) = &mut all.normals {
            match &mesh.normals {
                Some(own) => normals.extend(own),
                None => {
                    let smooth = smooth(&mesh.positions, &mesh.triangles)?.into_iter();
                    normals.extend(smooth.map(|n| n.try_normalize().unwrap_or(Vec3::Z).to_array()));
                }
            }
            if let Some(tangents) = &mut all.tangents {
                let own = &normals[first as usize..];
                tangents.extend(
                    mesh.tangents.unwrap_or_else(|| own.iter().map(|n| perpendicular(Vec3::from(*n))).collect()),
                );
            }
        }
        if let Some(limits) = &mut all.depth_limits {
            limits.extend(mesh.depth_limits.unwrap_or_else(|| vec![f32::INFINITY; count]));
        }
        if let Some(stiffness) = &mut all.stiffness {
            stiffness.extend(mesh.stiffness.unwrap_or_else(|| vec![0.0; count]));
        }
        all.positions.extend(mesh.positions);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    Ok(all)
}

/// Gives vertices of different pieces that lie at the same place the bits of the first piece's.
fn close_seams(positions: &mut [[f32; 3]], pieces: &[Piece<'_>]) {
    if pieces.len() < 2 {
        return;
    }
    let diagonal = Aabb::of_slice(bytemuck::cast_slice(positions)).diagonal();
    let mut earlier: RTree<[f32; 3]> = RTree::new();
    let mut inserted = HashSet::new();
    for piece in pieces {
        let own = &mut positions[piece.first_vertex..][..piece.surface.data.positions.len()];
        for p in own.iter_mut() {
            let near = earlier.locate_within_distance(*p, (SAME * diagonal).powi(2)).take(COMPARED);
            // The nearest; among equally near the least, so that the tree's shape does not matter.
            let distance = |q: &[f32; 3]| (Vec3::from(*q) - Vec3::from(*p)).length_squared();
            let least = |a: &&[f32; 3], b: &&[f32; 3]| {
                distance(a).total_cmp(&distance(b)).then(a.partial_cmp(b).unwrap_or(Ordering::Equal))
            };
            if let Some(nearest) = near.min_by(least) {
                *p = *nearest;
            }
        }
        own.iter().filter(|p| inserted.insert(p.map(f32::to_bits))).for_each(|p| earlier.insert(*p));
    }
}
