//! Coarser meshes of a body: vertices of one cell of a grid become one of them. Crude, and closed where the mesh was.

use std::collections::{HashMap, HashSet};
use std::hash::Hash;

use crumple::MeshData;
use glam::Vec3;

/// The mesh with one vertex for each cell (m) of a grid: the one nearest to the mean of its cell.
pub fn clustered(mesh: &MeshData, cell: f32) -> MeshData {
    clustered_by(mesh, cell, |_| (), |_| (), |_| true).0
}

/// The same where vertices of one cell stay apart if they are of different `solid`s, and become several vertices at one place if they
/// differ in `kind` only. What is not `outside` is left out where the outside comes to lie on it. Also returns the vertex of `mesh` that
/// each vertex has its normal from, in rising order.
pub fn clustered_by<S: Hash + Eq, K: Hash + Eq>(
    mesh: &MeshData,
    cell: f32,
    solid: impl Fn(u32) -> S,
    kind: impl Fn(u32) -> K,
    outside: impl Fn(u32) -> bool,
) -> (MeshData, Vec<u32>) {
    let key = |p: &[f32; 3]| p.map(|x| (x / cell).floor() as i32);
    let mut cells: HashMap<([i32; 3], S), Vec<u32>> = HashMap::new();
    for (v, p) in mesh.positions.iter().enumerate() {
        cells.entry((key(p), solid(v as u32))).or_default().push(v as u32);
    }
    let at = |v: u32| Vec3::from(mesh.positions[v as usize]);
    let nearest = |vs: &[u32], to: Vec3| {
        let away = |v: &u32| (at(*v) - to).length_squared();
        vs.iter().copied().min_by(|a, b| away(a).total_cmp(&away(b)).then(a.cmp(b))).unwrap_or(vs[0])
    };
    // The vertex that gives the normal, the one that gives the place, and all that become one.
    let mut heads: Vec<(u32, u32, Vec<u32>)> = Vec::new();
    for vs in cells.into_values() {
        let place = nearest(&vs, vs.iter().map(|v| at(*v)).sum::<Vec3>() / vs.len() as f32);
        let mut kinds: HashMap<K, Vec<u32>> = HashMap::new();
        vs.iter().for_each(|v| kinds.entry(kind(*v)).or_default().push(*v));
        heads.extend(kinds.into_values().map(|vs| (nearest(&vs, at(place)), place, vs)));
    }
    heads.sort_unstable_by_key(|(head, ..)| *head);
    let mut new = vec![0u32; mesh.positions.len()];
    let mut skin = HashSet::new();
    for (i, (head, place, vs)) in heads.iter().enumerate() {
        vs.iter().for_each(|v| new[*v as usize] = i as u32);
        if outside(*head) {
            skin.insert(*place);
        }
    }
    let mut seen = HashSet::new();
    let triangles = mesh.triangles.iter().map(|t| t.map(|v| new[v as usize])).filter(|t| {
        let places = t.map(|v| heads[v as usize].1);
        let [a, b, c] = places;
        let covered = !outside(heads[t[0] as usize].0) && places.iter().all(|place| skin.contains(place));
        let mut sorted = *t;
        sorted.sort_unstable();
        a != b && b != c && c != a && !covered && seen.insert(sorted)
    });
    let mut triangles: Vec<[u32; 3]> = triangles.collect();
    let mut used = vec![false; heads.len()];
    triangles.iter().flatten().for_each(|v| used[*v as usize] = true);
    let count = |next: &mut u32, used: &bool| Some(std::mem::replace(next, *next + u32::from(*used)));
    let place: Vec<u32> = used.iter().scan(0, count).collect();
    triangles.iter_mut().flatten().for_each(|v| *v = place[*v as usize]);
    let heads: Vec<_> = heads.into_iter().zip(used).filter_map(|(head, used)| used.then_some(head)).collect();
    let coarse = MeshData {
        positions: heads.iter().map(|(_, place, _)| mesh.positions[*place as usize]).collect(),
        normals: mesh.normals.as_ref().map(|n| heads.iter().map(|(h, ..)| n[*h as usize]).collect()),
        tangents: None,
        triangles,
        ..MeshData::default()
    };
    (coarse, heads.into_iter().map(|(head, ..)| head).collect())
}

/// Root mean square of a mesh's edges, m.
pub fn edge(mesh: &MeshData) -> f32 {
    let at = |v: u32| Vec3::from(mesh.positions[v as usize]);
    let squares = mesh.triangles.iter().flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
    let (sum, n) =
        squares.fold((0.0f64, 0u32), |(s, n), (a, b)| (s + f64::from((at(a) - at(b)).length_squared()), n + 1));
    (sum / f64::from(n.max(1))).sqrt() as f32
}
