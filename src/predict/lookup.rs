//! The point nearest to a place, and the partners of points in mirror images.

use crate::mesh::mirror::Mirror;
use glam::Vec3;

/// The index of the point nearest to `place`; the first of equally near ones.
pub(super) fn nearest(points: &[Vec3], place: Vec3) -> usize {
    let mut best = (f32::INFINITY, 0);
    for (i, p) in points.iter().enumerate() {
        let d = (*p - place).length_squared();
        if d < best.0 {
            best = (d, i);
        }
    }
    best.1
}

/// For each point the point nearest to its mirror image.
pub(super) fn partners(points: &[Vec3], mirror: Mirror, centre: Vec3) -> Vec<u32> {
    points.iter().map(|p| nearest(points, mirror.point(*p, centre)) as u32).collect()
}
