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

/// Number of vertices that one task binds.
const CHUNK: usize = 512;
/// Triangles count as equally near if their squared distances differ by at most this share. Such triangles meet at a
/// hard edge.
const EQUALLY_NEAR: f32 = 1e-6;

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
        let indexed = self.surface_is_indexed();
        let rows = rows_of(self, &self.base_lod().rows, &mesh, tasks);
        if !indexed {
            self.forget_surface();
        }
        let (rows, farthest) = rows?;
        let nearest = |p: &Vec3| self.nearest_vertex(p.to_array()).map(|n| n.vertex);
        let mesh = if self.mesh().limits().is_empty() {
            mesh
        } else {
            let nearest = mesh.positions().iter().map(nearest).collect::<Result<Vec<_>, Error>>()?;
            mesh.with_limits_of(self.mesh(), &nearest)
        };
        let mut shown = MeshLod::new(mesh, Rim::default(), Vec::new());
        shown.rows = std::sync::Arc::new(rows);
        let report = LodReport { vertices: shown.vertex_count(), bytes: shown.bytes(), farthest };
        self.push_lod(shown, report);
        Ok(lod)
    }
}

/// A point on a base triangle: corners and barycentric weights.
#[derive(Debug, Clone, Copy)]
struct Corners {
    vertices: [u32; 3],
    weights: [f64; 3],
}

impl Corners {
    fn vertex(v: u32) -> Self {
        Corners { vertices: [v; 3], weights: [1.0, 0.0, 0.0] }
    }
}

/// At most as many equally near triangles are compared, so that the time does not grow with the square of the vertices where
/// thousands lie at one place.
const MOST: usize = 256;

/// How the vertices of another mesh follow the nodes, where the base mesh has these rows, and the greatest distance of a vertex from
/// the base surface, m.
pub(super) fn rows_of(
    set: &ExampleSet,
    base: &Rows,
    mesh: &Mesh,
    tasks: &dyn TaskSystem,
) -> Result<(Rows, f32), Error> {
    let (bound, farthest) = bind(set, mesh, tasks)?;
    let at = |v: u32| {
        let Corners { vertices, weights } = bound[v as usize];
        [0, 1, 2].map(|k| (vertices[k], weights[k]))
    };
    Ok((Rows::of_other_mesh(mesh, base, at, tasks), farthest))
}

/// Binds every vertex to a point of the base surface, the same for all vertices at one position. Also returns the greatest
/// distance, m.
fn bind(set: &ExampleSet, mesh: &Mesh, tasks: &dyn TaskSystem) -> Result<(Vec<Corners>, f32), Error> {
    let positions = mesh.positions();
    let surface = set.surface()?;
    let chunks = map(tasks, (0..positions.len()).step_by(CHUNK), |from| {
        let range = from..(from + CHUNK).min(positions.len());
        range.map(|v| bind_one(set, surface, positions[v])).collect::<Result<Vec<_>, Error>>()
    });
    let mut all = reserve(positions.len(), "a level of detail's vertices")?;
    let mut farthest = 0.0f32;
    for (corners, distance) in chunks.into_iter().collect::<Result<Vec<_>, Error>>()?.into_iter().flatten() {
        all.push(corners);
        farthest = farthest.max(distance);
    }
    Ok((all, farthest))
}

/// Binds the vertex at `p`. Also returns its distance, m. Among triangles that are equally near, up to rounding, the first counts.
fn bind_one(set: &ExampleSet, surface: &SurfaceIndex, p: Vec3) -> Result<(Corners, f32), Error> {
    let near = set.nearest_vertex(p.to_array())?;
    if set.mesh().positions()[near.vertex as usize] == p || surface.is_empty() {
        return Ok((Corners::vertex(near.vertex), near.distance));
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
    Ok(first.map_or((Corners::vertex(near.vertex), near.distance), |(d, t)| {
        (Corners { vertices: t.vertices, weights: closest(t.corners(), p) }, d.sqrt())
    }))
}
