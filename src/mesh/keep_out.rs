//! Depth limits that keep dents out of solids, such as a roll cage or an engine.
//!
//! The limit of a vertex is its distance from the nearest solid. A displacement that is no longer cannot enter one, in
//! whatever direction it goes.

use super::data::MeshData;
use super::rim::boundary;
use super::surface::{SurfaceIndex, closest};
use super::{Mesh, finite};
use crate::base::error::{Error, at_least_zero};
use crate::base::tasks::{TaskSystem, map};
use glam::{DVec3, Vec3};

/// Vertices that one task looks at.
const CHUNK: usize = 512;
/// Room for the rounding of a vertex's position, as a share of its largest coordinate.
const ROUNDING: f32 = 8.0 * f32::EPSILON;

/// A body that dents must not enter, in the mesh's space.
#[derive(Debug, Clone, PartialEq)]
pub enum Solid {
    /// Everything within `radius` (m, at least 0) of the segment between two points (m).
    Capsule {
        /// One end, m.
        a: [f32; 3],
        /// The other end, m. Equal ends make a ball.
        b: [f32; 3],
        /// m.
        radius: f32,
    },
    /// A closed surface.
    Mesh {
        /// m.
        positions: Vec<[f32; 3]>,
        /// Three indices each. Each edge belongs to at least two triangles.
        triangles: Vec<[u32; 3]>,
    },
}

/// What [`MeshData::keep_out`] did.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct KeepOutReport {
    /// Number of vertices whose limit became less.
    pub limited: usize,
    /// Number of vertices inside a solid, or on it. Their limit is 0.
    pub inside: usize,
}

impl MeshData {
    /// Lowers [`MeshData::depth_limits`] so that no dent moves a vertex into a solid: the limit of a vertex is at most its
    /// distance from the nearest solid. Vertices inside one get the limit 0. Edges between vertices may still cut
    /// through a solid that is smaller than the triangles. Call it for each level of detail too. `tasks` runs the work.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::InvalidArgument`], [`Error::Mesh`] naming the solid. After an error nothing has changed.
    pub fn keep_out(&mut self, solids: &[Solid], tasks: &dyn TaskSystem) -> Result<KeepOutReport, Error> {
        let ready = solids.iter().enumerate().map(|(i, s)| Ready::new(i, s)).collect::<Result<Vec<_>, Error>>()?;
        let mut points = Vec::with_capacity(self.positions.len());
        for (v, p) in self.positions.iter().enumerate() {
            points.push(finite(*p, || format!("positions[{v}]"))?);
        }
        let mut limits = self.depth_limits.clone().unwrap_or_else(|| vec![f32::INFINITY; points.len()]);
        if limits.len() != points.len() {
            let what = format!("{} depth_limits for {} positions; there must be as many", limits.len(), points.len());
            return Err(Error::Mesh { what });
        }
        let distance = |p: &Vec3| {
            let d = ready.iter().map(|s| s.distance(*p)).fold(f64::INFINITY, f64::min) as f32;
            (d - ROUNDING * (d + p.abs().max_element())).max(0.0)
        };
        let found = map(tasks, points.chunks(CHUNK), |chunk| chunk.iter().map(distance).collect::<Vec<_>>());
        let mut report = KeepOutReport::default();
        for (limit, distance) in limits.iter_mut().zip(found.into_iter().flatten()) {
            report.inside += usize::from(distance == 0.0);
            report.limited += usize::from(distance < *limit);
            *limit = limit.min(distance);
        }
        self.depth_limits = Some(limits);
        Ok(report)
    }
}

/// A solid that was checked.
enum Ready {
    Capsule { a: DVec3, b: DVec3, radius: f64 },
    Mesh(Box<Mesh>, SurfaceIndex),
}

impl Ready {
    fn new(i: usize, solid: &Solid) -> Result<Self, Error> {
        match solid {
            Solid::Capsule { a, b, radius } => {
                at_least_zero(&format!("radius of solid {i}"), *radius, "m")?;
                let a = finite(*a, || format!("a of solid {i}"))?.as_dvec3();
                let b = finite(*b, || format!("b of solid {i}"))?.as_dvec3();
                Ok(Ready::Capsule { a, b, radius: f64::from(*radius) })
            }
            Solid::Mesh { positions, triangles } => {
                let data =
                    MeshData { positions: positions.clone(), triangles: triangles.clone(), ..MeshData::default() };
                let (mesh, _) = Mesh::new(data)?;
                let welded = mesh.triangles().iter().map(|t| t.map(|v| mesh.weld()[v as usize]));
                let open = boundary(welded, mesh.weld().len()).len();
                if open > 0 || triangles.is_empty() {
                    let what =
                        format!("solid {i} has {} triangles and {open} open edges; it must be closed", triangles.len());
                    return Err(Error::Mesh { what });
                }
                let index = SurfaceIndex::new(&mesh);
                Ok(Ready::Mesh(Box::new(mesh), index))
            }
        }
    }

    /// Distance of a point from the solid, m; 0 inside.
    fn distance(&self, p: Vec3) -> f64 {
        match self {
            Ready::Capsule { a, b, radius } => {
                let (p, ab) = (p.as_dvec3(), *b - *a);
                let square = ab.length_squared();
                let t = if square > 0.0 { ((p - *a).dot(ab) / square).clamp(0.0, 1.0) } else { 0.0 };
                (p.distance(*a + ab * t) - radius).max(0.0)
            }
            Ready::Mesh(mesh, index) => {
                let b = mesh.bounds();
                if p.cmpge(b.min).all() && p.cmple(b.max).all() && winding(mesh, p).abs() > 0.5 {
                    return 0.0;
                }
                index.nearest(p).map_or(f64::INFINITY, |t| {
                    let (corners, w) = (t.corners(), closest(t.corners(), p));
                    (0..3).map(|k| corners[k].as_dvec3() * w[k]).sum::<DVec3>().distance(p.as_dvec3())
                })
            }
        }
    }
}

/// How often the surface goes around a point (van Oosterom and Strackee, 1983).
fn winding(mesh: &Mesh, p: Vec3) -> f64 {
    let angle = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions()[v as usize].as_dvec3() - p.as_dvec3());
        let [x, y, z] = [a, b, c].map(DVec3::length);
        libm::atan2(a.dot(b.cross(c)), x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y)
    };
    mesh.triangles().iter().map(angle).sum::<f64>() / std::f64::consts::TAU
}
