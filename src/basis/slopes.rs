//! The slopes of a displacement field along the surface, as sparse linear operators.

use crate::base::lists::Lists;
use crate::base::math::tangent_basis;
use crate::mesh::Mesh;
use glam::{Mat3, Vec3};

/// For each vertex, how its neighbours' displacements make its two slopes.
#[derive(Debug, Default)]
pub(crate) struct Slopes(Lists<Entry>);

/// Neighbour (the lowest vertex at its position), and its weights along the two tangents, 1/m.
pub(crate) type Entry = (u32, [f32; 2]);

/// The most triangles around a position that count, so that the time does not grow with the square of the vertices where thousands
/// lie at one place.
const MOST: usize = 256;

impl Slopes {
    /// Least-squares gradients over the triangles around each vertex, nearer neighbours counting more. Triangles that face away
    /// from the vertex's normal, beyond a hard edge, do not count. A mesh without normals has none.
    pub(crate) fn of(mesh: &Mesh) -> Self {
        let Some(normals) = mesh.normals() else { return Slopes::default() };
        let (positions, weld) = (mesh.positions(), mesh.weld());
        let corners = || mesh.triangles().iter().zip(0..).flat_map(|(c, t)| c.map(|v| (weld[v as usize] as usize, t)));
        let around: Lists<u32> = Lists::new(weld.len(), corners);
        let mut out = Slopes::default();
        let (mut ring, mut entries): (Vec<u32>, Vec<Entry>) = (Vec::new(), Vec::new());
        for v in 0..positions.len() {
            let own = weld[v];
            ring.clear();
            for t in around.of(own as usize).iter().take(MOST) {
                let corners = mesh.triangles()[*t as usize];
                let [a, b, c] = corners.map(|i| positions[i as usize]);
                if (b - a).cross(c - a).dot(normals[v]) > 0.0 {
                    ring.extend(corners.map(|i| weld[i as usize]).iter().filter(|i| **i != own));
                }
            }
            ring.sort_unstable();
            ring.dedup();
            find_entries(positions, own, normals[v], &ring, &mut entries);
            out.0.push(&entries);
        }
        out
    }

    /// The entries of a vertex; none if there are no slopes.
    pub(crate) fn entries(&self, v: usize) -> &[Entry] {
        self.0.of(v)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Finds the entries of a vertex with this normal and these neighbours.
fn find_entries(positions: &[Vec3], own: u32, normal: Vec3, ring: &[u32], entries: &mut Vec<Entry>) {
    let frame = frame(normal);
    let at = |i: u32| {
        let e = positions[i as usize] - positions[own as usize];
        let (x, y) = (f64::from(e.dot(frame.x_axis)), f64::from(e.dot(frame.y_axis)));
        let weight = 1.0 / f64::from(e.length_squared()).max(1e-30);
        (x, y, weight)
    };
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y, w) in ring.iter().map(|i| at(*i)) {
        xx += w * x * x;
        xy += w * x * y;
        yy += w * y * y;
    }
    // Neighbours along one line tell the slope along it alone.
    let little = 1e-3 * (xx + yy);
    let (xx, yy) = (xx + little, yy + little);
    let determinant = xx * yy - xy * xy;
    entries.clear();
    if determinant > 0.0 {
        let mut own_weights = [0.0f64; 2];
        for i in ring {
            let (x, y, w) = at(*i);
            let slope = [w * (yy * x - xy * y) / determinant, w * (xx * y - xy * x) / determinant];
            own_weights[0] -= slope[0];
            own_weights[1] -= slope[1];
            entries.push((*i, slope.map(|s| s as f32)));
        }
        entries.push((own, own_weights.map(|s| s as f32)));
    }
    if entries.iter().any(|(_, s)| !s.iter().all(|x| x.is_finite())) {
        entries.clear();
    }
}

/// The tangents of a unit normal and the normal. A component of -0 counts as +0.
pub(crate) fn frame(normal: Vec3) -> Mat3 {
    tangent_basis(normal + Vec3::ZERO)
}
