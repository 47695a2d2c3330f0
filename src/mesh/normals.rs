//! Smooth vertex normals from triangles, weighted by corner angle and shared by all vertices at one position.

use super::vertex_blocks::BLOCK;
use glam::{DVec3, Vec3};

/// Returns one unit normal per vertex. Triangles without area are ignored. A vertex without other triangles gets zero.
/// `weld[v]` is the lowest vertex at the position of `v`.
///
/// Angle weights (Thürmer and Wüthrich, 1998) do not depend on how the surface is triangulated.
pub(crate) fn smooth(positions: &[Vec3], triangles: &[[u32; 3]], weld: &[u32]) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    add_corners(&mut sums, |v| positions[v as usize], triangles.iter().copied(), weld, |_| true);
    weld.iter().map(|w| normal(sums[*w as usize])).collect()
}

/// The unit normal along the sum of [`add_corners`] at one position. Zero if there is none.
pub(crate) fn normal(sum: DVec3) -> Vec3 {
    let l = sum.dot(sum).sqrt();
    if l > 1e-9 { (sum / l).as_vec3() } else { Vec3::ZERO }
}

/// Adds triangles' normals, weighted by the corner's angle, to the sums of those of their vertices whose `weld` is
/// `wanted`.
pub(crate) fn add_corners(
    sums: &mut [DVec3],
    position: impl Fn(u32) -> Vec3,
    triangles: impl Iterator<Item = [u32; 3]>,
    weld: &[u32],
    wanted: impl Fn(u32) -> bool,
) {
    for t in triangles {
        let at = t.map(|v| weld[v as usize]);
        let wanted = at.map(&wanted);
        if wanted == [false; 3] {
            continue;
        }
        let p = t.map(|v| position(v).as_dvec3());
        let n = (p[1] - p[0]).cross(p[2] - p[0]);
        let area = n.dot(n).sqrt();
        if !(area > 0.0 && area.is_finite()) {
            continue;
        }
        let n = n / area;
        for k in (0..3).filter(|k| wanted[*k]) {
            let (a, b) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
            let l = (a.dot(a) * b.dot(b)).sqrt();
            if l > 0.0 {
                sums[at[k] as usize] += n * libm::acos((a.dot(b) / l).clamp(-1.0, 1.0));
            }
        }
    }
}

/// For each block, the triangles that have a corner in it, or at the position of a vertex in it.
pub(crate) struct BlockTriangles {
    /// Where the triangles of each block end.
    ends: Vec<usize>,
    triangles: Vec<u32>,
}

impl BlockTriangles {
    pub(crate) fn new(triangles: &[[u32; 3]], weld: &[u32]) -> Self {
        let blocks = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| v / BLOCK as u32);
            let [d, e, f] = t.map(|v| weld[v as usize] / BLOCK as u32);
            let all = [a, b, c, d, e, f];
            (0..all.len()).filter(move |i| !all[..*i].contains(&all[*i])).map(move |i| all[i] as usize)
        };
        let mut ends = vec![0; weld.len().div_ceil(BLOCK) + 1];
        triangles.iter().flat_map(blocks).for_each(|b| ends[b + 1] += 1);
        (1..ends.len()).for_each(|b| ends[b] += ends[b - 1]);
        let mut all = vec![0; ends.last().copied().unwrap_or(0)];
        for (t, i) in triangles.iter().zip(0..) {
            for b in blocks(t) {
                all[ends[b]] = i;
                ends[b] += 1;
            }
        }
        BlockTriangles { ends, triangles: all }
    }

    /// The triangles of some blocks, increasing.
    pub(crate) fn of(&self, blocks: &[u32]) -> Vec<u32> {
        let start = |b: usize| if b == 0 { 0 } else { self.ends[b - 1] };
        let one = |b: u32| &self.triangles[start(b as usize)..self.ends[b as usize]];
        let mut all: Vec<u32> = blocks.iter().flat_map(|b| one(*b)).copied().collect();
        all.sort_unstable();
        all.dedup();
        all
    }
}
