//! The repository's own meshes: files with morph targets, the lab's bodies, and the latter made finer.

use std::collections::HashMap;
use std::path::Path;

use anyhow::{Context, Result};
use crumple::import::{MeshChoice, gltf_file};
use crumple::{Contact, Deltas, ExampleData, MeshData};

use crate::scene;
use crate::truth::{Body, Truth};

/// A mesh and its examples, as a set is built from.
pub struct Real {
    pub name: String,
    pub mesh: MeshData,
    pub examples: Vec<ExampleData>,
}

/// Examples taken of each of the lab's bodies.
pub const EXAMPLES: usize = 24;

/// Every file with examples, and every body of the lab, as they are.
pub fn all() -> Result<Vec<Real>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets");
    let mut all = Vec::new();
    for file in ["demo/hood.glb", "demo/drum.glb", "solver/panel.glb", "solver/tube.glb"] {
        let path = root.join(file);
        let read = gltf_file(&path, MeshChoice::First).with_context(|| format!("reading {}", path.display()))?;
        let name = file.trim_start_matches("demo/").trim_end_matches(".glb").replace('/', "_");
        all.push(Real { name, mesh: read.mesh, examples: read.examples });
    }
    for body in Body::read_smooth()? {
        let examples = scene::examples(&body, EXAMPLES);
        all.push(Real { name: name(&body), mesh: scene::mesh(&body), examples });
    }
    Ok(all)
}

/// The lab's bodies.
pub fn bodies(quick: bool) -> Result<Vec<Body>> {
    if quick { Ok(vec![Body::read(Truth::Shots, "panel")?]) } else { Body::read_smooth() }
}

/// `shots_panel` and so on.
pub fn name(body: &Body) -> String {
    format!("{}_{}", body.truth.name(), body.name)
}

/// The body with triangles cut in four as often as brings it nearest to `vertices` (by ratio), in the order a renderer would
/// want: vertices as the triangles first use them. Vertices of the body become others: `Finer::vertex` tells which.
pub fn finer(body: &Body, vertices: usize) -> Finer {
    let each = (vertices as f64 / body.vertices.len() as f64).log(4.0).round().max(0.0) as usize;
    let mut parents: Vec<[u32; 2]> = (0..body.vertices.len() as u32).map(|v| [v, v]).collect();
    let mut triangles = body.triangles.clone();
    for _ in 0..each {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                parents.push([a, b]);
                parents.len() as u32 - 1
            })
        };
        let quarter = |[a, b, c]: [u32; 3]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, ab, bc], [ca, bc, c]]
        };
        triangles = triangles.into_iter().flat_map(quarter).collect();
    }
    let mut place = vec![u32::MAX; parents.len()];
    let mut used = 0;
    for v in triangles.iter_mut().flatten() {
        let slot = &mut place[*v as usize];
        if *slot == u32::MAX {
            *slot = used;
            used += 1;
        }
        *v = *slot;
    }
    // Vertices of no triangle come last.
    for slot in place.iter_mut().filter(|p| **p == u32::MAX) {
        *slot = used;
        used += 1;
    }
    Finer { parents, place, triangles }
}

/// How a finer mesh follows from a body's.
pub struct Finer {
    /// Of each vertex in the order of making, the two that it is the middle of; the body's own are their own parents.
    parents: Vec<[u32; 2]>,
    /// Where each of them is in the finished order.
    place: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

impl Finer {
    /// The body with its first examples.
    pub fn build(&self, body: &Body) -> (MeshData, Vec<ExampleData>) {
        let mut normals = self.values(&body.normals);
        for n in &mut normals {
            *n = glam::Vec3::from_array(*n).normalize_or(glam::Vec3::Z).to_array();
        }
        let mesh = MeshData {
            positions: self.values(&body.vertices),
            normals: Some(normals),
            tangents: None,
            triangles: self.triangles.clone(),
            ..MeshData::default()
        };
        let example = |i: &crate::truth::Impact| ExampleData {
            contact: Some(Contact::Vertex(self.place[i.contact_vertex as usize])),
            ..ExampleData::new(i.source.clone(), Deltas::Full(self.values(&i.field)))
        };
        (mesh, body.train.iter().take(EXAMPLES).map(example).collect())
    }

    /// One value a vertex of the body becomes one a vertex of the finer mesh, linear between.
    fn values(&self, coarse: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let mut made: Vec<[f32; 3]> = Vec::with_capacity(self.parents.len());
        for (v, [a, b]) in self.parents.iter().enumerate() {
            let value = if v < coarse.len() {
                coarse[v]
            } else {
                let (a, b) = (made[*a as usize], made[*b as usize]);
                [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]))
            };
            made.push(value);
        }
        let mut out = vec![[0.0; 3]; made.len()];
        for (value, place) in made.iter().zip(&self.place) {
            out[*place as usize] = *value;
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finer_body_is_the_same_body() {
        let body = Body::read(Truth::Shots, "tube").unwrap();
        let (mesh, examples) = finer(&body, 9_000).build(&body);
        // Each level adds a vertex an edge: vertices and edges and triangles of a tube sum to 0.
        let edges = body.vertices.len() + body.triangles.len();
        assert_eq!(mesh.positions.len(), body.vertices.len() + edges);
        assert_eq!(mesh.triangles.len(), 4 * body.triangles.len());
        for (example, impact) in examples.iter().zip(&body.train) {
            let Some(Contact::Vertex(v)) = example.contact else { panic!() };
            assert_eq!(mesh.positions[v as usize], impact.point);
            let Deltas::Full(field) = &example.positions else { panic!() };
            assert_eq!(field[v as usize], impact.displacement);
        }
    }
}
