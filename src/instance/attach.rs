//! Attached points (a lamp, a decal, a vertex of a collision mesh) are bound to the surface of a set's base mesh, and follow an
//! instance's dents without deforming the mesh.

use super::Instance;
use crate::base::error::Error;
use crate::base::math::{rotation_between, unit};
use crate::example::set::ExampleSet;
use crate::mesh::finite;
use crate::mesh::surface::closest;
use bytemuck::{Pod, Zeroable};
use glam::{Mat3, Quat, Vec3};

/// A point bound to the surface nearest to it. Plain data; belongs to the set that made it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Attachment {
    /// The triangle's vertices; all the same for a mesh without triangles.
    pub vertices: [u32; 3],
    /// Barycentric weights of the surface point; they sum to 1.
    pub weights: [f32; 3],
    /// The attached point at rest, in the mesh's space, m.
    pub point: [f32; 3],
}

/// Where an attached point is.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Pose {
    /// Position in the mesh's space, m.
    pub position: [f32; 3],
    /// Rotation since rest, a unit quaternion (x, y, z, w).
    pub rotation: [f32; 4],
}

impl ExampleSet {
    /// Binds a point to the nearest surface, or to the nearest vertex if the mesh has no triangles. The point keeps its
    /// distance from the surface and turns with it.
    ///
    /// The first call builds a spatial index of the triangles.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::InvalidArgument`] for a point too far away for f32; [`Error::OutOfMemory`].
    pub fn attach(&self, point: [f32; 3]) -> Result<Attachment, Error> {
        let p = finite(point, || "point".into())?;
        let vertex = self.nearest_vertex(point)?.vertex;
        let (vertices, weights) = match self.surface().nearest(p) {
            Some(t) => (t.vertices, closest(t.corners(), p).map(|w| w as f32)),
            None => ([vertex; 3], [1.0, 0.0, 0.0]),
        };
        Ok(Attachment { vertices, weights, point })
    }
}

impl Instance {
    /// Returns the position and rotation of an attached point on this instance. Hits that have not been folded yet do
    /// not count.
    ///
    /// # Errors
    /// [`Error::IndexOutOfRange`] or [`Error::NotFinite`] for an attachment that this set did not make.
    pub fn attached_pose(&self, a: &Attachment) -> Result<Pose, Error> {
        let mesh = self.example_set().mesh();
        for v in a.vertices {
            if v as usize >= mesh.positions().len() {
                return Err(Error::IndexOutOfRange {
                    name: "a vertex of the attachment".into(),
                    index: v.into(),
                    len: mesh.positions().len() as u64,
                });
            }
        }
        let point = finite(a.point, || "the attachment's point".into())?;
        let weights = finite(a.weights, || "the attachment's weights".into())?;
        let base = a.vertices.map(|v| mesh.positions()[v as usize]);
        let now = a.vertices.map(|v| self.vertex(v));
        let mix = |x: [Vec3; 3]| x[0] * weights.x + x[1] * weights.y + x[2] * weights.z;
        let rotation = if a.vertices[0] == a.vertices[1] {
            match (mesh.normals(), now[0].1) {
                (Some(n), Some(m)) => rotation_between(n[a.vertices[0] as usize], m),
                _ => Mat3::IDENTITY,
            }
        } else {
            turn(base, now.map(|n| n.0))
        };
        let surface = mix(base);
        let position = if weights.x == 1.0 && point == base[0] {
            now[0].0
        } else {
            let moved = mix([0, 1, 2].map(|i| now[i].0 - base[i]));
            point + moved + (rotation * (point - surface) - (point - surface))
        };
        Ok(Pose { position: position.to_array(), rotation: Quat::from_mat3(&rotation).normalize().to_array() })
    }
}

/// The rotation from one triangle's frame (first edge, normal) to another's; the identity if either has no area.
fn turn(from: [Vec3; 3], to: [Vec3; 3]) -> Mat3 {
    if from == to {
        return Mat3::IDENTITY;
    }
    let frame = |t: [Vec3; 3]| {
        let x = unit(t[1] - t[0])?;
        let z = unit((t[1] - t[0]).cross(t[2] - t[0]))?;
        Some(Mat3::from_cols(x, z.cross(x), z))
    };
    match (frame(from), frame(to)) {
        (Some(a), Some(b)) => b * a.transpose(),
        _ => Mat3::IDENTITY,
    }
}
