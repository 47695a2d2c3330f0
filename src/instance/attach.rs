//! Attached points (a lamp, a decal, a vertex of a collision mesh) follow the dents without deforming the mesh.

use super::Instance;
use super::attachment::{Attachment, Pose};
use crate::base::error::Error;
use crate::base::math::{rotation_between, unit};
use crate::deform::evaluate::vertex;
use crate::mesh::finite;
use glam::{Mat3, Quat, Vec3};

impl Instance {
    /// Returns the position and rotation of an attached point on this instance. Hits that have not been folded yet do
    /// not count.
    ///
    /// # Errors
    /// [`Error::IndexOutOfRange`] or [`Error::NotFinite`] for an attachment that this set did not make.
    pub fn attached_pose(&self, a: &Attachment) -> Result<Pose, Error> {
        let view = self.view();
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
        let now = a.vertices.map(|v| vertex(&view, self.example_set().base_lod(), v as usize));
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
