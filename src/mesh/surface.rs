//! The nearest point on a mesh's triangles.

use super::Mesh;
use glam::Vec3;
use rstar::{AABB, PointDistance, RTree, RTreeObject};

/// A spatial index of a mesh's triangles.
#[derive(Debug)]
pub(crate) struct SurfaceIndex(RTree<IndexedTriangle>);

impl SurfaceIndex {
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let corner = |v: u32| mesh.positions()[v as usize].to_array();
        let triangles = mesh.triangles().iter().map(|t| IndexedTriangle { corners: t.map(corner), vertices: *t });
        SurfaceIndex(RTree::bulk_load(triangles.collect()))
    }

    /// The triangle nearest to a point. `None` if there are no triangles.
    pub(crate) fn nearest(&self, p: Vec3) -> Option<&IndexedTriangle> {
        self.0.nearest_neighbor(p.to_array())
    }

    /// The triangles and their squared distances (m²) from a point, nearest first. The order is exact up to rounding.
    pub(crate) fn by_distance(&self, p: Vec3) -> impl Iterator<Item = (f32, &IndexedTriangle)> {
        let p = p.to_array();
        self.0.nearest_neighbor_iter(p).map(move |t| (t.distance_2(&p), t))
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

/// Barycentric weights of the triangle's closest point to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
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
