//! Coarser meshes of a body: vertices of one cell of a grid become one of them. Crude, and closed where the mesh was.

use std::collections::{HashMap, HashSet};

use crumple::MeshData;
use glam::Vec3;

/// The mesh with one vertex for each cell (m) of a grid: the one nearest to the mean of its cell.
pub fn clustered(mesh: &MeshData, cell: f32) -> MeshData {
    let key = |p: &[f32; 3]| p.map(|x| (x / cell).floor() as i32);
    let mut cells: HashMap<[i32; 3], Vec<u32>> = HashMap::new();
    for (v, p) in mesh.positions.iter().enumerate() {
        cells.entry(key(p)).or_default().push(v as u32);
    }
    let at = |v: u32| Vec3::from(mesh.positions[v as usize]);
    let mut heads: Vec<(u32, Vec<u32>)> = cells
        .into_values()
        .map(|vs| {
            let mean = vs.iter().map(|v| at(*v)).sum::<Vec3>() / vs.len() as f32;
            let away = |v: &u32| (at(*v) - mean).length_squared();
            let head = vs.iter().copied().min_by(|a, b| away(a).total_cmp(&away(b)).then(a.cmp(b))).unwrap_or(vs[0]);
            (head, vs)
        })
        .collect();
    heads.sort_unstable_by_key(|(head, _)| *head);
    let mut new = vec![0u32; mesh.positions.len()];
    for (i, (_, vs)) in heads.iter().enumerate() {
        vs.iter().for_each(|v| new[*v as usize] = i as u32);
    }
    let mut seen = HashSet::new();
    let triangles = mesh.triangles.iter().map(|t| t.map(|v| new[v as usize])).filter(|t| {
        let mut sorted = *t;
        sorted.sort_unstable();
        sorted[0] != sorted[1] && sorted[1] != sorted[2] && seen.insert(sorted)
    });
    let triangles: Vec<[u32; 3]> = triangles.collect();
    MeshData {
        positions: heads.iter().map(|(h, _)| mesh.positions[*h as usize]).collect(),
        normals: mesh.normals.as_ref().map(|n| heads.iter().map(|(h, _)| n[*h as usize]).collect()),
        tangents: None,
        triangles,
        ..MeshData::default()
    }
}

/// Root mean square of a mesh's edges, m.
pub fn edge(mesh: &MeshData) -> f32 {
    let at = |v: u32| Vec3::from(mesh.positions[v as usize]);
    let squares = mesh.triangles.iter().flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
    let (sum, n) =
        squares.fold((0.0f64, 0u32), |(s, n), (a, b)| (s + f64::from((at(a) - at(b)).length_squared()), n + 1));
    (sum / f64::from(n.max(1))).sqrt() as f32
}
