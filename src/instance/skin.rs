//! Skinned meshes: Crumple dents the bind pose, and the engine skins the dented vertices. A hit on the posed mesh is
//! taken to the bind pose by the skin matrix of the vertex that it hits.

use super::inbox::Inbox;
use crate::base::error::Error;
use crate::base::math::to_f32;
use crate::select::hit::{Cause, Hit, Space};
use glam::{DMat3, DMat4, DVec3, Mat4, Vec3};

/// How an engine poses the vertices of a set's base mesh, as in glTF. A vertex at `p` is shown at the sum of
/// `weight * (matrix * p)` over its joints.
#[derive(Debug, Clone, Copy)]
pub struct Skin<'a> {
    /// For each vertex, up to four indices of `matrices`.
    pub joints: &'a [[u16; 4]],
    /// For each vertex, the weights of its joints, which sum to 1. A joint of weight 0 is unused.
    pub weights: &'a [[f32; 4]],
    /// For each joint, its affine transform from the bind pose to the pose: the joint's matrix times its inverse bind
    /// matrix.
    pub matrices: &'a [Mat4],
}

impl Inbox {
    /// Takes a hit on the posed mesh to the bind pose, for [`Inbox::submit`]. The vertex of the undented mesh that is
    /// nearest to the hit in the pose decides: its skin matrix maps the bind pose to the pose, and the inverse maps the
    /// hit. The result is in [`Space::Local`]. A hit in [`Space::World`] is on the posed mesh at the instance's
    /// transform. Each call visits every vertex.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for arrays of other lengths than the mesh has vertices, or a vertex whose skin matrix
    /// cannot be inverted; [`Error::IndexOutOfRange`] for a joint without a matrix; [`Error::NotFinite`].
    pub fn to_bind_pose(&self, skin: &Skin<'_>, hit: &Hit) -> Result<Hit, Error> {
        let params = self.params();
        let finite = |name: &str, v: [f32; 3]| crate::mesh::finite(v, || name.into()).map(|_| ());
        finite("point", hit.point)?;
        let point = params.local(hit.point, hit.space);
        let (vertex, matrix) = self.nearest_posed(skin, point)?;
        let inverse = matrix.inverse();
        if matrix.determinant() == 0.0 || !inverse.is_finite() {
            let name = format!("the skin matrix of vertex {vertex}");
            return Err(Error::invalid(&name, matrix, "invertible"));
        }
        let linear = DMat3::from_mat4(inverse);
        let cause = match hit.cause {
            Cause::Displacement(d) => {
                finite("displacement", d)?;
                let d = DVec3::from_array(d.map(f64::from));
                let local = if hit.space == Space::World { params.world_to_local * d } else { d };
                Cause::Displacement(to_f32(linear * local))
            }
            Cause::Impulse { blow, mass } => {
                let blow = blow.checked(str::to_owned)?;
                Cause::Impulse { blow: params.local_blow(&blow, hit.space).transformed(linear), mass }
            }
        };
        let point = to_f32(inverse.transform_point3(point));
        finite("point in the bind pose", point)?;
        Ok(Hit { point, cause, space: Space::Local, contact: hit.contact })
    }

    /// The vertex that is nearest to a point in the pose, and its skin matrix. The lowest index wins a tie.
    fn nearest_posed(&self, skin: &Skin<'_>, point: DVec3) -> Result<(usize, DMat4), Error> {
        let positions = self.example_set().mesh().positions();
        for (name, len) in [("skin.joints", skin.joints.len()), ("skin.weights", skin.weights.len())] {
            if len != positions.len() {
                let expected = format!("{}, the number of vertices", positions.len());
                return Err(Error::invalid(&format!("the length of {name}"), len, &expected));
            }
        }
        if let Some((at, m)) = skin.matrices.iter().enumerate().find(|(_, m)| !m.is_finite()) {
            return Err(Error::NotFinite { name: format!("skin.matrices[{at}]"), value: m.to_string() });
        }
        let point = point.as_vec3();
        let mut nearest = (f32::INFINITY, 0);
        for (v, p) in positions.iter().enumerate() {
            let mut posed = Vec3::ZERO;
            for (joint, weight) in skin.joints[v].iter().zip(skin.weights[v]).filter(|(_, w)| *w != 0.0) {
                let Some(matrix) = skin.matrices.get(usize::from(*joint)) else {
                    let (index, len) = (u64::from(*joint), skin.matrices.len() as u64);
                    return Err(Error::IndexOutOfRange { name: format!("a joint of vertex {v}"), index, len });
                };
                posed += matrix.transform_point3(*p) * weight;
            }
            let distance = (posed - point).length_squared();
            if distance < nearest.0 {
                nearest = (distance, v);
            }
        }
        let (distance, vertex) = nearest;
        let (joints, weights) = (skin.joints[vertex], skin.weights[vertex]);
        let total: f32 = weights.iter().sum();
        if distance == f32::INFINITY || (total - 1.0).abs() > 0.01 {
            let name = format!("the sum of the weights of vertex {vertex}");
            return Err(Error::invalid(&name, total, "1"));
        }
        let mut matrix = DMat4::ZERO;
        for (joint, weight) in joints.iter().zip(weights).filter(|(_, w)| *w != 0.0) {
            matrix += skin.matrices[usize::from(*joint)].as_dmat4() * f64::from(weight);
        }
        Ok((vertex, matrix))
    }
}
