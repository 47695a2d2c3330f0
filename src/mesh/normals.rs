//! Smooth vertex normals from triangles, weighted by corner angle and shared by all vertices at one position.

use glam::{DVec3, Vec3};

/// Returns one unit normal per vertex. Triangles without area are ignored. A vertex without other triangles gets zero.
/// `weld[v]` is the lowest vertex at the position of `v`.
///
/// Angle weights (Thürmer and Wüthrich, 1998) do not depend on how the surface is triangulated.
pub(crate) fn smooth(positions: &[Vec3], triangles: &[[u32; 3]], weld: &[u32]) -> Vec<Vec3> {
    smooth_where(positions, triangles, weld, |_| true)
}

/// Like [`smooth`], but only for vertices whose `weld` is `wanted`. Others get zero at little cost.
pub(crate) fn smooth_where(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    weld: &[u32],
    wanted: impl Fn(u32) -> bool,
) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for t in triangles {
        let at = t.map(|v| weld[v as usize]);
        let wanted = at.map(&wanted);
        if wanted == [false; 3] {
            continue;
        }
        let p = t.map(|i| positions[i as usize].as_dvec3());
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
    weld.iter()
        .map(|w| {
            let s = sums[*w as usize];
            let l = s.dot(s).sqrt();
            if l > 1e-9 { (s / l).as_vec3() } else { Vec3::ZERO }
        })
        .collect()
}
