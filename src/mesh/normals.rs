//! Smooth vertex normals from triangles, weighted by corner angle and shared by all vertices at one position; and which way the surface
//! faces around a place.

use super::vertex_blocks::BLOCK;
use crate::base::error::Error;
use crate::base::lists::Lists;
use crate::base::math::{Aabb, cells_around};
use crate::base::memory::may_fail;
use glam::{DVec3, IVec3, Vec3};
use std::collections::HashMap;

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

/// Which way the surface faces around places of a mesh: triangles by area, in the cells of a grid. Closed solids do not count, because
/// theirs cancel out: what counts is the skin on which they are mounted.
pub(crate) struct Surroundings {
    bounds: Aabb,
    /// Sums of the triangles' normals times twice their area, and of twice their area.
    cells: HashMap<IVec3, (DVec3, f64)>,
    /// The directions of the cells that were asked for.
    known: HashMap<IVec3, Option<DVec3>>,
}

impl Surroundings {
    /// Cells along the diagonal of the mesh. A place's surroundings are its cell and those around.
    const CELLS: f64 = 50.0;
    /// The least sum of normals as a share of that of areas.
    const LEAST: f64 = 0.1;

    /// # Errors
    /// [`Error::OutOfMemory`].
    pub(crate) fn of(positions: &[Vec3], triangles: &[[u32; 3]]) -> Result<Self, Error> {
        let mut out = Surroundings { bounds: Aabb::of_slice(positions), cells: HashMap::new(), known: HashMap::new() };
        let most = |count: usize| count.min((Self::CELLS as usize + 1).pow(3));
        let (cells, known) = (most(triangles.len()), most(positions.len()));
        may_fail(|| out.cells.try_reserve(cells).and_then(|()| out.known.try_reserve(known)))
            .map_err(|_| Error::OutOfMemory { what: "contact normals".into(), bytes: (cells + known) as u64 * 48 })?;
        for t in triangles {
            let [a, b, c] = t.map(|v| positions[v as usize].as_dvec3());
            let n = (b - a).cross(c - a);
            let cell = out.cell((a + b + c) / 3.0);
            let sums = out.cells.entry(cell).or_default();
            (sums.0, sums.1) = (sums.0 + n, sums.1 + n.length());
        }
        Ok(out)
    }

    fn cell(&self, place: DVec3) -> IVec3 {
        let size = (f64::from(self.bounds.diagonal()) / Self::CELLS).max(f64::MIN_POSITIVE);
        ((place - self.bounds.min.as_dvec3()) / size).floor().as_ivec3()
    }

    /// The unit direction in which the surface around a place faces. `None` if it faces all ways, or there is none.
    pub(crate) fn facing(&mut self, place: Vec3) -> Option<DVec3> {
        let cell = self.cell(place.as_dvec3());
        let cells = &self.cells;
        *self.known.entry(cell).or_insert_with(|| {
            let near = cells_around(cell).filter_map(|at| cells.get(&at));
            let (sum, area) = near.fold((DVec3::ZERO, 0.0), |(n, a), (m, b)| (n + *m, a + b));
            let length = sum.length();
            (length > Self::LEAST * area).then(|| sum / length)
        })
    }
}

/// For each block, the triangles that have a corner in it, or at the position of a vertex in it.
pub(crate) struct BlockTriangles(Lists<u32>);

impl BlockTriangles {
    pub(crate) fn new(triangles: &[[u32; 3]], weld: &[u32]) -> Self {
        let blocks = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| v / BLOCK as u32);
            let [d, e, f] = t.map(|v| weld[v as usize] / BLOCK as u32);
            let all = [a, b, c, d, e, f];
            (0..all.len()).filter(move |i| !all[..*i].contains(&all[*i])).map(move |i| all[i] as usize)
        };
        let all = || (0..).zip(triangles).flat_map(|(i, t)| blocks(t).map(move |b| (b, i)));
        BlockTriangles(Lists::new(weld.len().div_ceil(BLOCK), all))
    }

    /// The triangles of some blocks, increasing.
    pub(crate) fn of(&self, blocks: &[u32]) -> Vec<u32> {
        let mut all: Vec<u32> = blocks.iter().flat_map(|b| self.0.of(*b as usize)).copied().collect();
        all.sort_unstable();
        all.dedup();
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::mesh::data::MeshData;

    /// A box of the given size around `centre`: eight corners, faces outwards.
    fn solid(data: &mut MeshData, centre: Vec3, size: Vec3) {
        let first = data.positions.len() as u32;
        let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5;
        data.positions.extend((0..8).map(|i| (centre + corner(i) * size).to_array()));
        for [a, b, c, d] in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            data.triangles.extend([[a, b, c], [a, c, d]].map(|t| t.map(|v| first + v)));
        }
    }

    #[test]
    fn what_is_mounted_on_a_skin_faces_as_the_skin_does() {
        const SIDE: u32 = 61;
        let at = |i: u32| i as f32 / (SIDE - 1) as f32 - 0.5;
        let mut data = MeshData::default();
        data.positions.extend((0..SIDE * SIDE).map(|i| [at(i / SIDE), at(i % SIDE), 0.0]));
        let quads = (0..(SIDE - 1) * (SIDE - 1)).map(|i| i / (SIDE - 1) * SIDE + i % (SIDE - 1));
        data.triangles.extend(quads.flat_map(|v| [[v, v + SIDE, v + SIDE + 1], [v, v + SIDE + 1, v + 1]]));
        let skin = data.positions.len();
        solid(&mut data, Vec3::Z * 0.004, Vec3::new(0.04, 0.006, 0.006));
        let both = Mesh::new(data).unwrap().0;
        for v in 0..both.positions().len() {
            let normal = both.contact_normal(v as u32).unwrap();
            assert!(normal.dot(Vec3::Z) > 0.5, "vertex {v}: {normal}");
            assert!(v >= skin || normal == Vec3::Z);
        }
        // Alone it has its own.
        let mut alone = MeshData::default();
        solid(&mut alone, Vec3::ZERO, Vec3::ONE);
        let alone = Mesh::new(alone).unwrap().0;
        for (v, p) in alone.positions().iter().enumerate() {
            assert!(alone.contact_normal(v as u32).unwrap().dot(p.normalize()) > 0.99);
        }
    }
}
