//! Levels of detail: other meshes of the same body (coarser ones, a collision proxy) that show the same damage.
//!
//! Carried examples work on any mesh. Anchored examples belong to the base mesh: each vertex of another mesh is bound
//! once to the nearest point of the base surface. It moves like that point, by linear interpolation.

use crate::base::error::{Error, reserve};
use crate::base::math::{rotation_between, unit};
use crate::base::tasks::{TaskSystem, map};
use crate::example::blocks::{DeltaBlocks, Steps};
use crate::example::mesh_lod::MeshLod;
use crate::example::report::LodReport;
use crate::example::set::{ExampleSet, MAX_MESHES};
use crate::mesh::Mesh;
use crate::mesh::data::MeshData;
use crate::mesh::surface::{IndexedTriangle, SurfaceIndex, closest};
use glam::{DVec3, Vec3};
use std::sync::Arc;

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
    /// Carried examples are applied directly. Anchored examples are interpolated at the nearest point of the base
    /// surface, or taken from the nearest vertex if the base mesh has no triangles. A vertex at the position of a base
    /// vertex moves exactly like it. A vertex between unmoved base vertices does not move. In a set with a tolerance,
    /// interpolated displacements are rounded again, so they are wrong by at most two tolerances. Vertices at one
    /// position stay together, whatever [`crate::Seams`] is. The level has no normals if the base mesh has none.
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
        let bound = bind(self, &mesh, tasks);
        if !indexed {
            self.forget_surface();
        }
        let (bound, farthest) = bound?;
        let of_base = &self.base_lod().anchored;
        let tolerance = self.options().tolerance;
        let transferred = map(tasks, of_base, |a| transfer(self.mesh(), a, &mesh, &bound, tolerance));
        let mut anchored = reserve(of_base.len(), "a level of detail's examples")?;
        for ready in transferred {
            anchored.push(Arc::new(ready?));
        }
        let nearest = |p: &Vec3| self.nearest_vertex(p.to_array()).map(|n| n.vertex);
        let mesh = if self.mesh().limits().is_empty() {
            mesh
        } else {
            let nearest = mesh.positions().iter().map(nearest).collect::<Result<Vec<_>, Error>>()?;
            mesh.with_limits_of(self.mesh(), &nearest)
        };
        let rim = self.rim().on(self.mesh(), &mesh, tasks);
        let shown = MeshLod::new(mesh, rim, anchored);
        let report = LodReport { vertices: shown.vertex_count(), bytes: shown.bytes(), farthest };
        let rows = self.rows_on(&shown, tasks);
        self.push_lod(shown, report, rows);
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

    fn mix(&self, of: &[Vec3]) -> DVec3 {
        let at = |k: usize| of[self.vertices[k] as usize].as_dvec3() * self.weights[k];
        at(0) + at(1) + at(2)
    }
}

/// The points on the base surface that a vertex follows.
#[derive(Debug, Clone, Copy)]
struct Bound {
    /// Source of displacements. The same for all vertices at one position.
    at: Corners,
    /// Source of changes of the normal. Among equally near points, the one whose normal agrees best with the vertex's.
    facing: Corners,
    distance: f32,
}

/// At most as many equally near candidates are compared, so that the time does not grow with the square of the vertices where
/// thousands lie at one place.
const MOST: usize = 256;

/// Binds every vertex. Also returns the greatest distance, m.
fn bind(set: &ExampleSet, mesh: &Mesh, tasks: &dyn TaskSystem) -> Result<(Vec<Bound>, f32), Error> {
    let positions = mesh.positions();
    let surface = set.surface()?;
    let mut copies: Vec<(u32, u32)> = set.mesh().weld().iter().copied().zip(0..).collect();
    copies.sort_unstable();
    let chunks = map(tasks, (0..positions.len()).step_by(CHUNK), |from| {
        let range = from..(from + CHUNK).min(positions.len());
        let bound = range.map(|v| bind_one(set, surface, &copies, positions[v], mesh.normals().map(|n| n[v])));
        bound.collect::<Result<Vec<_>, Error>>()
    });
    let mut all = reserve(positions.len(), "a level of detail's vertices")?;
    for chunk in chunks {
        all.extend(chunk?);
    }
    let farthest = all.iter().map(|b| b.distance).fold(0.0, f32::max);
    Ok((all, farthest))
}

/// Binds the vertex at `p`. `copies` has, for each base vertex, the lowest vertex at its position and the vertex
/// itself, sorted.
fn bind_one(
    set: &ExampleSet,
    surface: &SurfaceIndex,
    copies: &[(u32, u32)],
    p: Vec3,
    normal: Option<Vec3>,
) -> Result<Bound, Error> {
    let base = set.mesh();
    let agrees = |c: &Corners| match (normal, base.normals()) {
        (Some(n), Some(normals)) => c.mix(normals).dot(n.as_dvec3()),
        _ => 0.0,
    };
    // The first is kept if both agree equally well.
    let best = |a: Corners, b: Corners| if agrees(&b) > agrees(&a) { b } else { a };
    let near = set.nearest_vertex(p.to_array())?;
    if base.positions()[near.vertex as usize] == p || surface.is_empty() {
        let at = Corners::vertex(near.vertex);
        let from = copies.partition_point(|c| c.0 < near.vertex);
        let here = copies[from..].iter().take_while(|c| c.0 == near.vertex).take(MOST).map(|c| Corners::vertex(c.1));
        return Ok(Bound { at, facing: here.fold(at, best), distance: near.distance });
    }
    let mut nearest: Vec<(f32, &IndexedTriangle)> = Vec::new();
    for (d, t) in surface.by_distance(p) {
        // The iterator's order is exact only up to rounding. The list is sorted below.
        if nearest.first().is_some_and(|n| d > n.0 * (1.0 + EQUALLY_NEAR) + f32::MIN_POSITIVE) {
            break;
        }
        nearest.push((d, t));
        if nearest.len() == MOST {
            break;
        }
    }
    nearest.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.vertices.cmp(&b.1.vertices)));
    let corners = |t: &IndexedTriangle| Corners { vertices: t.vertices, weights: closest(t.corners(), p) };
    // There is at least one triangle.
    let Some((d, first)) = nearest.first() else {
        return Ok(Bound {
            at: Corners::vertex(near.vertex),
            facing: Corners::vertex(near.vertex),
            distance: near.distance,
        });
    };
    let at = corners(first);
    let facing = nearest.iter().map(|(_, t)| corners(t)).fold(at, best);
    Ok(Bound { at, facing, distance: d.sqrt() })
}

/// Interpolates one example for another mesh.
fn transfer(
    base: &Mesh,
    example: &DeltaBlocks,
    mesh: &Mesh,
    bound: &[Bound],
    tolerance: Option<f32>,
) -> Result<DeltaBlocks, Error> {
    let (n, steps): (usize, Steps) = (base.positions().len(), example.steps);
    let zeros = |n: usize| -> Result<Vec<Vec3>, Error> {
        let mut v = reserve(n, "an example's displacements")?;
        v.resize(n, Vec3::ZERO);
        Ok(v)
    };
    let (mut deltas, mut changes) = (zeros(n)?, zeros(n)?);
    for (v, d, c) in example.iter() {
        deltas[v as usize] = d;
        changes[v as usize] = c;
    }
    let mut moved = reserve(bound.len(), "an example's displacements")?;
    moved.extend(bound.iter().map(|b| {
        let d = b.at.mix(&deltas).as_vec3();
        steps.displacement(d, tolerance.unwrap_or(0.0)) + Vec3::ZERO
    }));
    let turned = match (base.normals(), mesh.normals()) {
        (Some(from), Some(normals)) => {
            let mut turned = reserve(bound.len(), "an example's changes of normals")?;
            turned.extend(
                bound.iter().zip(normals).map(|(b, n)| steps.normal_change(turn(&b.facing, from, &changes, *n))),
            );
            Some(turned)
        }
        _ => None,
    };
    Ok(DeltaBlocks::new(&moved, turned.as_deref(), steps))
}

/// The change of unit normal `n` if it turns like the base normal at `at`.
fn turn(at: &Corners, base: &[Vec3], changes: &[Vec3], n: Vec3) -> Vec3 {
    let change = at.mix(changes);
    if change == DVec3::ZERO {
        return Vec3::ZERO;
    }
    let before = at.mix(base);
    if before.as_vec3() == n {
        return change.as_vec3();
    }
    match (unit(before.as_vec3()), unit((before + change).as_vec3())) {
        (Some(a), Some(b)) => rotation_between(a, b) * n - n,
        _ => Vec3::ZERO,
    }
}
