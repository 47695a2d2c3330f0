//! A flat sheet and smooth bowls in it: where the right answer is known in closed form.

use std::sync::Arc;

use anyhow::Result;
use crumple::{Contact, Deltas, ExampleData, ExampleSet, MeshData, Serial, SetOptions};

use crate::truth::Field;

/// 1 m by 1 m around the origin, `n` by `n` squares, facing +z.
pub fn sheet(n: usize) -> MeshData {
    let at = |i: usize| i as f32 / n as f32 - 0.5;
    let positions: Vec<[f32; 3]> =
        (0..=n).flat_map(|i| (0..=n).map(move |j| [i, j])).map(|[i, j]| [at(i), at(j), 0.0]).collect();
    let id = |i: usize, j: usize| (i * (n + 1) + j) as u32;
    let square =
        |i: usize, j: usize| [[id(i, j), id(i + 1, j), id(i + 1, j + 1)], [id(i, j), id(i + 1, j + 1), id(i, j + 1)]];
    MeshData {
        normals: Some(vec![[0.0, 0.0, 1.0]; positions.len()]),
        tangents: None,
        triangles: (0..n).flat_map(|i| (0..n).flat_map(move |j| square(i, j))).collect(),
        positions,
        ..MeshData::default()
    }
}

/// A dent around `at` that ends smoothly at `radius`: along `direction` (its length is the depth), and `pull` times the
/// distance towards the middle.
#[derive(Debug, Clone, Copy)]
pub struct Bowl {
    pub at: [f64; 2],
    pub radius: f64,
    pub direction: [f64; 3],
    pub pull: f64,
}

impl Bowl {
    pub fn new(at: [f64; 2], radius: f64, depth: f64) -> Self {
        Self { at, radius, direction: [0.0, 0.0, -depth], pull: 0.0 }
    }

    /// Its displacements of these positions, m.
    pub fn field(&self, positions: &[[f32; 3]]) -> Field {
        let one = |p: &[f32; 3]| {
            let r = [f64::from(p[0]) - self.at[0], f64::from(p[1]) - self.at[1], 0.0];
            let q = (r[0] * r[0] + r[1] * r[1]) / (self.radius * self.radius);
            let w = if q < 1.0 { (1.0 - q) * (1.0 - q) } else { 0.0 };
            [0, 1, 2].map(|k| (w * (self.direction[k] - self.pull * r[k])) as f32)
        };
        positions.iter().map(one).collect()
    }

    pub fn example(&self, mesh: &MeshData) -> ExampleData {
        ExampleData {
            contact: Some(Contact::Point([self.at[0] as f32, self.at[1] as f32, 0.0])),
            ..ExampleData::new("bowl", Deltas::Full(self.field(&mesh.positions)))
        }
    }
}

/// A set of bowls in a sheet of `n` by `n` squares.
pub fn set(n: usize, bowls: &[Bowl], options: SetOptions) -> Result<Arc<ExampleSet>> {
    let mesh = sheet(n);
    let examples = bowls.iter().map(|b| b.example(&mesh)).collect();
    Ok(Arc::new(ExampleSet::build(mesh, examples, options, &Serial)?))
}
