//! Small baked sets to begin fuzzing with.
use crumple::{Combine, Deltas, ExampleData, ExampleSet, MeshData, Placement, Serial, SetOptions, VertexMass};
use std::path::Path;

/// A sheet of `n` by `n` squares with a seam down the middle.
fn sheet(n: u32) -> MeshData {
    let mut mesh = MeshData::default();
    for half in 0..2u32 {
        let first = mesh.positions.len() as u32;
        for i in 0..=n / 2 {
            for j in 0..=n {
                mesh.positions.push([(half * (n / 2) + i) as f32 / n as f32, j as f32 / n as f32, 0.0]);
            }
        }
        for i in 0..n / 2 {
            for j in 0..n {
                let a = first + i * (n + 1) + j;
                mesh.triangles.extend([[a, a + n + 1, a + n + 2], [a, a + n + 2, a + 1]]);
            }
        }
    }
    mesh
}

fn dents(mesh: &MeshData, count: u32) -> Vec<ExampleData> {
    let dent = |k: u32| {
        let c = [0.2 + 0.3 * (k % 3) as f32, 0.3 + 0.4 * (k / 3) as f32];
        let field = |p: &[f32; 3]| {
            let w = (1.0 - ((p[0] - c[0]).powi(2) + (p[1] - c[1]).powi(2)) / 0.09).max(0.0);
            [0.02 * w * (p[0] - c[0]), 0.0, -0.05 * w * w * (1.0 + k as f32)]
        };
        ExampleData::new(format!("dent {k}"), Deltas::Full(mesh.positions.iter().map(field).collect()))
    };
    (0..count).map(dent).collect()
}

/// Writes them into a folder.
pub fn write(folder: &Path) {
    let small = SetOptions { stamp_resolution: 4, ..SetOptions::default() };
    let baked = SetOptions { tolerance: Some(1e-3), ..small.clone() };
    let mesh = sheet(12);
    let points = MeshData { positions: mesh.positions.clone(), ..MeshData::default() };
    let mut placed = dents(&mesh, 4);
    placed[0].placement = Placement::Anchored;
    placed[1].placement = Placement::Carried;
    placed[2].positions = Deltas::Sparse { indices: vec![], values: vec![] };
    let masses = vec![2.0; mesh.positions.len()];
    let tangents = MeshData { tangents: Some(vec![[1.0, 0.0, 0.0, 1.0]; mesh.positions.len()]), ..mesh.clone() };
    let sets = [
        (mesh.clone(), dents(&mesh, 2), small.clone()),
        (mesh.clone(), dents(&mesh, 2), baked.clone()),
        (tangents, placed, SetOptions { mass: VertexMass::PerVertex(masses), combine: Combine::Sum, ..baked.clone() }),
        (points.clone(), dents(&points, 1), SetOptions { combine: Combine::Deepest, strict: true, ..small.clone() }),
        (sheet(2), dents(&sheet(2), 1), SetOptions { mirror: false, tolerance: Some(1e-7), ..small }),
    ];
    for (i, (mesh, examples, options)) in sets.into_iter().enumerate() {
        let set = ExampleSet::build(mesh, examples, options, &Serial).expect("a seed");
        std::fs::write(folder.join(format!("set{i}.crumple")), set.save().expect("saved")).expect("written");
    }
}
