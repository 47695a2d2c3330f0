//! Levels of detail: other meshes of the same body (coarser ones, a collision proxy) that show the same damage.
//!
//! Each vertex of another mesh is bound once to the nearest point of the base surface. It follows the nodes as that point does.

use crate::base::error::{Error, reserve};
use crate::base::tasks::{TaskSystem, map};
use crate::basis::Rows;
use crate::example::mesh_lod::MeshLod;
use crate::example::report::LodReport;
use crate::example::set::{ExampleSet, MAX_MESHES};
use crate::mesh::Mesh;
use crate::mesh::data::MeshData;
use crate::mesh::rim::Rim;
use crate::mesh::surface::{IndexedTriangle, SurfaceIndex, closest};
use glam::Vec3;
use std::sync::Arc;

/// Number of vertices that one task binds.
const CHUNK: usize = 512;
/// Triangles count as equally near if their squared distances differ by at most this share. Such triangles meet at a
/// hard edge.
const EQUALLY_NEAR: f32 = 1e-6;
/// At most as many equally near triangles are compared, so that the time does not grow with the square of the vertices where
/// thousands lie at one place.
const MOST: usize = 256;

impl ExampleSet {
    /// Adds another mesh that shows the same damage: a level of detail or a collision proxy. The mesh must be of the
    /// same body, in the same space (m). Returns its number for [`crate::DeformJob::lod`], 1 for the first. Marks,
    /// contacts, saved damage and the set's fingerprint remain those of the base mesh.
    ///
    /// Each vertex follows the nodes as the nearest point of the base surface does, or the nearest vertex if the base mesh has no
    /// triangles. A vertex at the position of a base vertex moves exactly like it. The level has no normals if the base mesh has none.
    ///
    /// # Errors
    /// Those of [`ExampleSet::build`] for the mesh; [`Error::InvalidArgument`] for more than 63 levels;
    /// [`Error::OutOfMemory`]. On an error nothing is added.
    pub fn add_lod(&mut self, mesh: MeshData, tasks: &dyn TaskSystem) -> Result<usize, Error> {
        let lod = self.lod_count();
        if lod >= MAX_MESHES {
            return Err(Error::invalid("the number of levels of detail", lod, &format!("at most {}", MAX_MESHES - 1)));
        }
        let (mesh, _) = Mesh::new(mesh).map_err(|e| match e {
            Error::Mesh { what } => Error::Mesh { what: format!("level of detail {lod}: {what}") },
            other => other,
        })?;
        let mesh = if self.mesh().normals().is_some() { mesh } else { mesh.without_normals() };
        let (bound, farthest) = bind(self, &mesh, tasks)?;
        let rows = Rows::of_other_mesh(&mesh, &self.base_lod().rows, |v| bound[v as usize], tasks);
        let nearest = |p: &Vec3| self.nearest_vertex(p.to_array()).map(|n| n.vertex);
        let mesh = if self.mesh().limits().is_empty() {
            mesh
        } else {
            let nearest = mesh.positions().iter().map(nearest).collect::<Result<Vec<_>, Error>>()?;
            mesh.with_limits_of(self.mesh(), &nearest)
        };
        let mut shown = MeshLod::new(mesh, Rim::default(), Vec::new());
        shown.rows = Arc::new(rows);
        let report = LodReport { vertices: shown.vertex_count(), bytes: shown.bytes(), farthest };
        self.push_lod(shown, report);
        Ok(lod)
    }
}

/// A point of the base surface: three base vertices and their shares.
type Bound = [(u32, f64); 3];

/// Binds every vertex to a point of the base surface, the same for all vertices at one position. Also returns the greatest
/// distance, m.
fn bind(set: &ExampleSet, mesh: &Mesh, tasks: &dyn TaskSystem) -> Result<(Vec<Bound>, f32), Error> {
    let surface = SurfaceIndex::new(set.mesh());
    let chunks = map(tasks, mesh.positions().chunks(CHUNK), |chunk| {
        chunk.iter().map(|p| bind_one(set, &surface, *p)).collect::<Result<Vec<_>, Error>>()
    });
    let mut all = reserve(mesh.positions().len(), "a level of detail's vertices")?;
    let mut farthest = 0.0f32;
    for chunk in chunks {
        for (bound, distance) in chunk? {
            all.push(bound);
            farthest = farthest.max(distance);
        }
    }
    Ok((all, farthest))
}

/// Binds the vertex at `p`. Also returns its distance, m. Among triangles that are equally near, up to rounding, the first counts.
fn bind_one(set: &ExampleSet, surface: &SurfaceIndex, p: Vec3) -> Result<(Bound, f32), Error> {
    let near = set.nearest_vertex(p.to_array())?;
    let at_vertex = ([(near.vertex, 1.0), (near.vertex, 0.0), (near.vertex, 0.0)], near.distance);
    if set.mesh().positions()[near.vertex as usize] == p {
        return Ok(at_vertex);
    }
    let mut nearest: Vec<(f32, &IndexedTriangle)> = Vec::new();
    for (d, t) in surface.by_distance(p) {
        if nearest.first().is_some_and(|n| d > n.0 * (1.0 + EQUALLY_NEAR) + f32::MIN_POSITIVE) || nearest.len() == MOST
        {
            break;
        }
        nearest.push((d, t));
    }
    let first = nearest.iter().min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.vertices.cmp(&b.1.vertices)));
    Ok(first.map_or(at_vertex, |(d, t)| {
        let weights = closest(t.corners(), p);
        ([0, 1, 2].map(|k| (t.vertices[k], weights[k])), d.sqrt())
    }))
}
