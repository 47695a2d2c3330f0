//! Joins pieces to one body, with its parts, and their targets to examples: those of one name are one dent, unless they lie apart.

use super::document::Document;
use super::extras::Impact;
use super::nodes::Nodes;
use super::piece::{Body, Piece, Target};
use super::surface::{perpendicular, smooth};
use super::words::cut;
use super::{Imported, Part, PartKind, unsupported, whole};
use crate::base::error::Error;
use crate::base::math::Aabb;
use crate::example::data::{Contact, Deltas, ExampleData};
use crate::example::set::MAX_MESHES;
use crate::mesh::data::MeshData;
use glam::Vec3;
use indexmap::IndexMap;
use rstar::RTree;
use std::cmp::{Ordering, Reverse};
use std::collections::{HashMap, HashSet};

/// Vertices of different nodes nearer than this share of the body's diagonal lie at one position: node matrices round.
const SAME: f32 = 1e-6;
/// How many of those that lie at one place are compared, so that thousands take no longer than in proportion.
const COMPARED: usize = 256;

/// The pieces of one part.
pub(super) struct Group<'d> {
    /// `None` for a mesh in its own space, which is no part.
    pub name: Option<String>,
    pub kind: PartKind,
    pub pieces: Vec<Piece<'d>>,
}

/// A body of these parts.
pub(super) fn joined<'d>(
    doc: &Document<'_>,
    groups: Vec<Group<'d>>,
    notes: &mut Vec<String>,
) -> Result<Body<'d>, Error> {
    let all = groups.iter().flat_map(|group| &group.pieces);
    let vertices: usize = all.map(|piece| piece.surface.data.positions.len()).sum();
    if vertices > u32::MAX as usize {
        return Err(unsupported(format!("{vertices} vertices in all parts; 32-bit indices reach {}", u32::MAX)));
    }
    let (mut meshes, mut primitives, mut moved) = (Vec::new(), Vec::new(), Vec::new());
    let (mut parts, mut glass) = (Vec::new(), Vec::new());
    let (mut pieces, mut next) = (Vec::new(), (0, 0));
    for group in groups {
        let first = next;
        for mut piece in group.pieces {
            piece.first_vertex = next.0;
            let mesh = piece.placed();
            for (primitive, kind) in piece.primitives.iter().zip(&piece.kinds) {
                let range = primitive.range(doc, next)?;
                if *kind == PartKind::Glass && (piece.kind != PartKind::Glass || group.name.is_none()) {
                    let name = range.material.clone().unwrap_or_else(|| primitive.name.clone());
                    let (vertices, triangles) = (range.vertices.clone(), range.triangles.clone());
                    glass.push(Part { name, kind: *kind, vertices, triangles });
                }
                primitives.push(range);
            }
            let targets = piece.placed_targets(mesh.normals.as_deref()).into_iter();
            moved.extend(targets.map(|target| Moved::of(target, &mesh, next.0, pieces.len())));
            next = (next.0 + mesh.positions.len(), next.1 + mesh.triangles.len());
            meshes.push(mesh);
            pieces.push(piece);
        }
        parts.extend(group.name.map(|name| Part {
            name,
            kind: group.kind,
            vertices: first.0..next.0,
            triangles: first.1..next.1,
        }));
    }
    parts.append(&mut glass);
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
    Ok(Body { pieces, imported: Imported { mesh, examples, primitives, parts, ..Imported::default() } })
}

/// The pieces by their parts. Each node is a part, unless there are more than a body can have: then the smallest nodes
/// belong to the part of the nearest node above them, or else to one for all others.
pub(super) fn grouped<'d>(
    pieces: Vec<Piece<'d>>,
    nodes: &Nodes<'_, '_>,
    notes: &mut Vec<String>,
) -> Result<Vec<Group<'d>>, Error> {
    let is_glass = |piece: &Piece<'_>| piece.kind != PartKind::Glass && piece.kinds.contains(&PartKind::Glass);
    let most = (MAX_MESHES - 1).saturating_sub(pieces.iter().filter(|piece| is_glass(piece)).count());
    if pieces.len() <= most {
        let alone = |piece: Piece<'d>| Group { name: Some(piece.name.clone()), kind: piece.kind, pieces: vec![piece] };
        return Ok(pieces.into_iter().map(alone).collect());
    }
    // The others are one part for each kind.
    let kinds: HashSet<u8> = pieces.iter().map(|piece| piece.kind as u8).collect();
    let kept = most.saturating_sub(kinds.len()).max(1);
    let mut by_size: Vec<usize> = (0..pieces.len()).collect();
    by_size.sort_by_key(|i| (Reverse(pieces[*i].surface.data.positions.len()), *i));
    by_size.truncate(kept);
    by_size.sort_unstable();
    let of_node: HashMap<usize, usize> =
        by_size.iter().enumerate().flat_map(|(g, i)| pieces[*i].nodes.iter().map(move |node| (*node, g))).collect();
    let nearest = nodes.inherited(None, |node, above: &Option<usize>| of_node.get(&node).copied().or(*above));
    let empty = |name: &str, kind: PartKind| Group { name: Some(name.to_owned()), kind, pieces: Vec::new() };
    let mut groups: Vec<Group<'d>> = by_size.iter().map(|i| empty(&pieces[*i].name, pieces[*i].kind)).collect();
    let (mut others, mut small, count) = ([None; 3], 0, pieces.len());
    for piece in pieces {
        let above = piece.nodes.first().and_then(|node| nearest[*node]).filter(|g| groups[*g].kind == piece.kind);
        let own = piece.nodes.first().and_then(|node| of_node.get(node)).is_some();
        small += usize::from(!own);
        let slot = &mut others[piece.kind as usize];
        let g = above.or(*slot).unwrap_or_else(|| {
            let name = ["others", "other rigid parts", "other glass"][piece.kind as usize];
            groups.push(empty(name, piece.kind));
            *slot.insert(groups.len() - 1)
        });
        groups[g].pieces.push(piece);
    }
    notes.push(format!(
        "{count} nodes have meshes, and a body has at most {most} parts: the {small} smallest belong to the part of the node above \
         them or to 'others'; choose nodes with --nodes"
    ));
    Ok(groups)
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

/// Targets of one name are one dent if their moved vertices are no further apart than this share of the larger one's extent.
/// Exporters give names such as "Key 1" to the targets of every part.
const ONE_DENT: f32 = 0.5;
/// How many targets of one name are compared with each, so that thousands take no longer than in proportion.
const TARGETS_COMPARED: usize = 256;

/// A target of a piece, by indices of the body's vertices.
struct Moved {
    target: Target,
    /// Of the vertices that it moves, before they move.
    bounds: Aabb,
    piece: usize,
}

impl Moved {
    /// The target of a piece whose placed mesh begins at vertex `first` of the body.
    fn of(mut target: Target, mesh: &MeshData, first: usize, piece: usize) -> Self {
        let mut bounds = Aabb::EMPTY;
        target.moved.iter().for_each(|(v, _)| bounds.add(Vec3::from(mesh.positions[*v as usize])));
        if let Some(Contact::Vertex(v)) = &mut target.impact.contact {
            *v += first as u32;
        }
        target.moved.iter_mut().chain(target.turned.iter_mut().flatten()).for_each(|(v, _)| *v += first as u32);
        Moved { target, bounds, piece }
    }

    /// Whether it and a target of the same name on another piece are one dent.
    fn is_one_with(&self, other: &Moved) -> bool {
        let gap = (self.bounds.min - other.bounds.max).max(other.bounds.min - self.bounds.max).max(Vec3::ZERO).length();
        gap <= ONE_DENT * self.bounds.diagonal().max(other.bounds.diagonal())
    }
}

/// The examples, in the order of the first target of each. `names` are those of the pieces. `joined`: targets of one name are one dent
/// wherever they lie.
fn examples(moved: Vec<Moved>, names: &[&str], joined: bool, notes: &mut Vec<String>) -> Vec<ExampleData> {
    let mut keys: HashMap<(usize, &str), usize> = HashMap::new();
    let mut same: IndexMap<(&str, usize), Vec<usize>> = IndexMap::new();
    for (i, Moved { target, piece, .. }) in moved.iter().enumerate() {
        // A piece may have several targets of one name. The first of each piece belong together, the second of each, and so on.
        let nth = keys.entry((*piece, &target.name)).and_modify(|n| *n += 1).or_insert(0);
        same.entry((&target.name, *nth)).or_default().push(i);
    }
    let mut apart = Vec::new();
    let dents: Vec<Vec<Vec<usize>>> = same.values().map(|targets| dents(&moved, targets, joined)).collect();
    let mut moved: Vec<Option<Moved>> = moved.into_iter().map(Some).collect();
    let mut out = Vec::new();
    for dents in dents {
        let several = dents.len() > 1;
        for (nth, dent) in dents.into_iter().enumerate() {
            let targets: Vec<Moved> = dent.into_iter().filter_map(|i| moved[i].take()).collect();
            let part = targets.first().map_or("", |target| names[target.piece]);
            let mut example = merged(targets.into_iter().map(|moved| moved.target));
            if several {
                if nth == 0 {
                    apart.push((example.name.clone(), part.to_owned()));
                }
                example.name = format!("{} ({part})", example.name);
            }
            out.push(example);
        }
    }
    if let Some((name, part)) = apart.first() {
        let more =
            if apart.len() == 1 { String::new() } else { format!("; so are those of {} more names", apart.len() - 1) };
        notes.push(format!(
            "the targets '{}' of '{}' and of other parts lie apart, so they are examples of their own{more}",
            cut(name),
            cut(part)
        ));
    }
    out
}

/// Targets of one name, by the dents that they are.
fn dents(moved: &[Moved], targets: &[usize], joined: bool) -> Vec<Vec<usize>> {
    let moving: Vec<usize> = targets.iter().copied().filter(|i| !moved[*i].target.moved.is_empty()).collect();
    if moving.len() < 2 || joined {
        return vec![if moving.is_empty() { targets[..1].to_vec() } else { moving }];
    }
    let mut root: Vec<usize> = (0..moving.len()).collect();
    fn find(root: &mut [usize], mut i: usize) -> usize {
        while root[i] != i {
            root[i] = root[root[i]];
            i = root[i];
        }
        i
    }
    for i in 0..moving.len() {
        for j in i.saturating_sub(TARGETS_COMPARED)..i {
            if moved[moving[i]].is_one_with(&moved[moving[j]]) {
                let (a, b) = (find(&mut root, i), find(&mut root, j));
                root[a.max(b)] = a.min(b);
            }
        }
    }
    let mut out: IndexMap<usize, Vec<usize>> = IndexMap::new();
    for (i, target) in moving.iter().enumerate() {
        out.entry(find(&mut root, i)).or_default().push(*target);
    }
    out.into_values().collect()
}

/// One example of targets on different pieces, in the order of the pieces. If several have a contact, the first counts.
fn merged(mut targets: impl Iterator<Item = Target>) -> ExampleData {
    let mut all = targets.next().unwrap_or_default();
    for target in targets {
        all.moved.extend(target.moved);
        all.turned = all.turned.zip(target.turned).map(|(mut turned, more)| {
            turned.extend(more);
            turned
        });
        if all.impact.contact.is_none() {
            all.impact = target.impact;
        }
    }
    let sparse = |list: Vec<(u32, [f32; 3])>| {
        let (indices, values) = list.into_iter().unzip();
        Deltas::Sparse { indices, values }
    };
    let Impact { contact, normal: contact_normal, blow } = all.impact;
    let (positions, normals) = (sparse(all.moved), all.turned.map(sparse));
    ExampleData { name: all.name, positions, normals, contact, contact_normal, blow }
}
