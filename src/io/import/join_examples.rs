//! Joins the targets of pieces to examples: those of one name are one dent, unless they lie apart.

use super::words::cut;
use crate::base::math::Aabb;
use crate::example::data::{Contact, Deltas, ExampleData};
use crate::mesh::data::MeshData;
use glam::Vec3;
use std::collections::HashMap;

/// Targets of one name are one dent if their moved vertices are no further apart than this share of the larger one's extent.
/// Exporters give names such as "Key 1" to the targets of every part.
const ONE_DENT: f32 = 0.5;
/// How many targets of one name are compared with each, so that thousands take no longer than in proportion.
const COMPARED: usize = 256;

/// A target of a piece, as indices of the body's vertices.
pub(super) struct Moved {
    example: ExampleData,
    /// Of the vertices that it moves, before they move.
    bounds: Aabb,
    piece: usize,
}

impl Moved {
    /// The target of a piece whose placed mesh begins at vertex `first` of the body.
    pub(super) fn of(mut example: ExampleData, mesh: &MeshData, first: usize, piece: usize) -> Self {
        let mut bounds = Aabb::EMPTY;
        if let Deltas::Sparse { indices, .. } = &example.positions {
            indices.iter().for_each(|v| bounds.add(Vec3::from(mesh.positions[*v as usize])));
        }
        if let Some(Contact::Vertex(v)) = &mut example.contact {
            *v += first as u32;
        }
        for deltas in [Some(&mut example.positions), example.normals.as_mut()].into_iter().flatten() {
            if let Deltas::Sparse { indices, .. } = deltas {
                indices.iter_mut().for_each(|v| *v += first as u32);
            }
        }
        Moved { example, bounds, piece }
    }

    fn is_still(&self) -> bool {
        self.bounds.min.x > self.bounds.max.x
    }

    /// Whether it and a target of the same name on another piece are one dent.
    fn is_one_with(&self, other: &Moved) -> bool {
        let gap = (self.bounds.min - other.bounds.max).max(other.bounds.min - self.bounds.max).max(Vec3::ZERO).length();
        gap <= ONE_DENT * self.bounds.diagonal().max(other.bounds.diagonal())
    }
}

/// The examples, in the order of the first target of each. `names` are those of the pieces. `joined`: targets of one name are one dent
/// wherever they lie.
pub(super) fn examples(moved: Vec<Moved>, names: &[&str], joined: bool, notes: &mut Vec<String>) -> Vec<ExampleData> {
    let mut keys: HashMap<(usize, &str), usize> = HashMap::new();
    let mut known: HashMap<(&str, usize), usize> = HashMap::new();
    let mut same: Vec<Vec<usize>> = Vec::new();
    for (i, target) in moved.iter().enumerate() {
        // A piece may have several targets of one name. The first of each piece belong together, the second of each, and so on.
        let nth = keys.entry((target.piece, &target.example.name)).and_modify(|n| *n += 1).or_insert(0);
        let slot = *known.entry((&target.example.name, *nth)).or_insert(same.len());
        if slot == same.len() {
            same.push(Vec::new());
        }
        same[slot].push(i);
    }
    let mut apart = Vec::new();
    let dents: Vec<Vec<Vec<usize>>> = same.iter().map(|targets| dents(&moved, targets, joined)).collect();
    let mut moved: Vec<Option<Moved>> = moved.into_iter().map(Some).collect();
    let mut out = Vec::new();
    for dents in dents {
        let several = dents.len() > 1;
        for (nth, dent) in dents.into_iter().enumerate() {
            let targets: Vec<Moved> = dent.into_iter().filter_map(|i| moved[i].take()).collect();
            let part = targets.first().map_or("", |target| names[target.piece]);
            let mut example = merged(targets.into_iter().map(|target| target.example));
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
    let moving: Vec<usize> = targets.iter().copied().filter(|i| !moved[*i].is_still()).collect();
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
        for j in i.saturating_sub(COMPARED)..i {
            if moved[moving[i]].is_one_with(&moved[moving[j]]) {
                let (a, b) = (find(&mut root, i), find(&mut root, j));
                root[a.max(b)] = a.min(b);
            }
        }
    }
    let mut slots: HashMap<usize, usize> = HashMap::new();
    let mut out: Vec<Vec<usize>> = Vec::new();
    for (i, target) in moving.iter().enumerate() {
        let slot = *slots.entry(find(&mut root, i)).or_insert(out.len());
        if slot == out.len() {
            out.push(Vec::new());
        }
        out[slot].push(*target);
    }
    out
}

/// One example of targets on different pieces, in the order of the pieces. If several have a contact, the first counts.
fn merged(targets: impl Iterator<Item = ExampleData>) -> ExampleData {
    let join = |a: &mut Deltas, b: Deltas| {
        if let (Deltas::Sparse { indices, values }, Deltas::Sparse { indices: more, values: moved }) = (a, b) {
            indices.extend(more);
            values.extend(moved);
        }
    };
    let mut out: Option<ExampleData> = None;
    for target in targets {
        let Some(known) = &mut out else {
            out = Some(target);
            continue;
        };
        join(&mut known.positions, target.positions);
        match (&mut known.normals, target.normals) {
            (Some(normals), Some(more)) => join(normals, more),
            _ => known.normals = None,
        }
        if known.contact.is_none() {
            (known.contact, known.contact_normal) = (target.contact, target.contact_normal);
            known.blow = target.blow;
        }
    }
    out.unwrap_or_else(|| ExampleData::new("", Deltas::Sparse { indices: Vec::new(), values: Vec::new() }))
}
