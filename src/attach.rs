//! Attached points: a lamp, a decal, a vertex of a collision mesh, that follow the dents without the mesh being touched.

use crate::examples::ExampleSet;
use crate::math::{rotation_between, unit};
use crate::mesh::finite;
use crate::{Error, Instance};
use bytemuck::{Pod, Zeroable};
use glam::{Mat3, Quat, Vec3};
use rstar::{AABB, PointDistance, RTree, RTreeObject};

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
pub struct Frame {
    /// Position in the mesh's space, m.
    pub position: [f32; 3],
    /// Rotation since rest, a unit quaternion (x, y, z, w).
    pub rotation: [f32; 4],
}

impl ExampleSet {
    /// Binds a point to the nearest surface (the nearest vertex where the mesh has no triangles). It keeps its distance
    /// from the surface and turns with it.
    ///
    /// The first call builds a spatial index of the triangles.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::InvalidArgument`] for a point too far off for f32.
    pub fn attach(&self, point: [f32; 3]) -> Result<Attachment, Error> {
        let p = finite(point, || "point".into())?;
        let vertex = self.nearest_vertex(point)?.vertex;
        let single = Attachment { vertices: [vertex; 3], weights: [1.0, 0.0, 0.0], point };
        Ok(match self.triangles().nearest_neighbor(point) {
            Some(t) => Attachment { vertices: t.vertices, weights: closest(t.corners(), p).map(|w| w as f32), point },
            None => single,
        })
    }

    /// The base mesh's triangles by place, indexed at the first call.
    pub(crate) fn triangles(&self) -> &RTree<IndexedTriangle> {
        self.triangle_index.get_or_init(|| {
            let mesh = self.mesh();
            let corner = |v: u32| mesh.positions()[v as usize].to_array();
            RTree::bulk_load(
                mesh.triangles().iter().map(|t| IndexedTriangle { corners: t.map(corner), vertices: *t }).collect(),
            )
        })
    }
}

impl Instance {
    /// Position and rotation of an attached point on this instance. Hits that have not been folded yet do not count.
    ///
    /// # Errors
    /// [`Error::IndexOutOfRange`] or [`Error::NotFinite`] for an attachment that is not the set's.
    pub fn attached_frame(&self, a: &Attachment) -> Result<Frame, Error> {
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
        let now = a.vertices.map(|v| crate::deform::displaced(self, v as usize));
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
        Ok(Frame { position: position.to_array(), rotation: Quat::from_mat3(&rotation).normalize().to_array() })
    }
}

/// Rotation that takes one triangle's frame (first edge, normal) to another's; none where either has no area.
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

/// A triangle in the spatial index.
#[derive(Debug, Clone, Copy)]
pub(crate) struct IndexedTriangle {
    corners: [[f32; 3]; 3],
    pub(crate) vertices: [u32; 3],
}

impl IndexedTriangle {
    pub(crate) fn corners(&self) -> [Vec3; 3] {
        self.corners.map(Vec3::from_array)
    }
}

impl RTreeObject for IndexedTriangle {
    type Envelope = AABB<[f32; 3]>;
    fn envelope(&self) -> Self::Envelope {
        AABB::from_points(&self.corners)
    }
}

impl PointDistance for IndexedTriangle {
    fn distance_2(&self, point: &[f32; 3]) -> f32 {
        let (c, p) = (self.corners(), Vec3::from_array(*point));
        let w = closest(c, p);
        let at = |k: usize| c[k].as_dvec3() * w[k];
        (at(0) + at(1) + at(2) - p.as_dvec3()).length_squared() as f32
    }
}

/// Barycentric weights of the point of a triangle that is closest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
pub(crate) fn closest(triangle: [Vec3; 3], p: Vec3) -> [f64; 3] {
    let ([a, b, c], p) = (triangle.map(|v| v.as_dvec3()), p.as_dvec3());
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3 {
        let v = d1 / (d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6 {
        let w = d2 / (d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    let (e, f) = (d4 - d3, d5 - d6);
    if va <= 0.0 && e >= 0.0 && f >= 0.0 && e + f > 0.0 {
        let w = e / (e + f);
        return [0.0, 1.0 - w, w];
    }
    let sum = va + vb + vc;
    if sum > 0.0 { [va / sum, vb / sum, vc / sum] } else { [1.0, 0.0, 0.0] }
}
