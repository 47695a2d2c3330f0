//! The checked base mesh with its seams, contact normals and bounds.

pub(crate) mod data;
pub(crate) mod field;
pub(crate) mod keep_out;
pub(crate) mod limits;
pub(crate) mod mirror;
pub(crate) mod nearest;
pub(crate) mod normals;
pub(crate) mod rim;
pub(crate) mod surface;
pub(crate) mod vertex_blocks;

use crate::base::array::Array;
use crate::base::error::Error;
use crate::base::error::reserve;
use crate::base::math::{Aabb, unit};
use crate::base::memory::may_fail;
use data::MeshData;
use glam::{DVec3, Vec3, Vec4};
use limits::Limits;
use normals::Surroundings;
use std::collections::HashMap;
use vertex_blocks::{BLOCK, block_range};

/// Largest coordinate accepted, m. Squares of larger ones could overflow f32.
pub(crate) const MAX_COORDINATE: f32 = 1e9;

/// The base mesh of an example set. Vertices keep the caller's order.
#[derive(Debug, Clone)]
pub struct Mesh {
    arrays: MeshArrays,
    limits: Limits,
    bounds: Aabb,
    block_bounds: Vec<Aabb>,
    seam_count: usize,
    repaired_normals: usize,
    degenerate_triangles: usize,
}

/// Cosine of the largest angle between a contact normal and the surface around it, 60 degrees.
const LIKE: f32 = 0.5;

/// The per-vertex and per-triangle arrays of a mesh.
#[derive(Debug, Clone, Default)]
pub(crate) struct MeshArrays {
    pub positions: Array<Vec3>,
    pub normals: Option<Array<Vec3>>,
    pub tangents: Option<Array<Vec4>>,
    pub triangles: Array<[u32; 3]>,
    /// The lowest vertex at the same position.
    pub weld: Array<u32>,
    /// Unit surface normals for contacts, smoothed over all vertices at one position. Present if `normals` is.
    pub contact_normals: Option<Array<Vec3>>,
}

impl Mesh {
    /// Checks `data` and computes what it lacks. Also returns the smooth normal of each vertex, which only building
    /// needs. It is zero at vertices without triangles.
    pub(crate) fn new(data: MeshData) -> Result<(Self, Vec<Vec3>), Error> {
        let n = data.positions.len();
        if n == 0 {
            return Err(Error::Mesh { what: "it has 0 vertices; at least 1 is needed".into() });
        }
        if n >= u32::MAX as usize {
            return Err(Error::Mesh { what: format!("it has {n} vertices; at most {} are possible", u32::MAX - 1) });
        }
        check_len("normals", data.normals.as_ref().map(Vec::len), n)?;
        check_len("tangents", data.tangents.as_ref().map(Vec::len), n)?;
        let mut positions = reserve(n, "base positions")?;
        for (i, p) in data.positions.iter().enumerate() {
            let p = finite(*p, || format!("positions[{i}]"))?;
            if p.abs().max_element() > MAX_COORDINATE {
                return Err(Error::invalid(&format!("positions[{i}]"), p, "within 1e9 m of the origin"));
            }
            // -0 becomes +0, so that coincident vertices have equal bits.
            positions.push(p + Vec3::ZERO);
        }
        for (i, t) in data.triangles.iter().enumerate() {
            if let Some(bad) = t.iter().find(|&&v| v as usize >= n) {
                return Err(Error::IndexOutOfRange {
                    name: format!("a vertex index of triangle {i}"),
                    index: u64::from(*bad),
                    len: n as u64,
                });
            }
        }
        let weld = weld(&positions)?;
        let limits = Limits::new(&data, &weld)?;
        let smooth = normals::smooth(&positions, &data.triangles, &weld);
        let mut repaired = 0;
        let vertex_normals = match data.normals {
            Some(given) => {
                let mut out = reserve(n, "base normals")?;
                for (i, v) in given.iter().enumerate() {
                    let v = finite(*v, || format!("normals[{i}]"))?;
                    out.push(unit(v).unwrap_or_else(|| {
                        repaired += 1;
                        unit(smooth[i]).unwrap_or(Vec3::Z)
                    }));
                }
                Some(out)
            }
            None if !data.triangles.is_empty() => {
                Some(smooth.iter().map(|v| if *v == Vec3::ZERO { Vec3::Z } else { *v }).collect())
            }
            None => None,
        };
        let surroundings = Surroundings::of(&positions, &data.triangles)?;
        let contact_normals =
            vertex_normals.as_ref().map(|given| contact_normals(&positions, &smooth, given, &weld, surroundings));
        let bad = data.tangents.iter().flatten().enumerate().find(|(_, t)| !t.iter().all(|x| x.is_finite()));
        if let Some((i, t)) = bad {
            return Err(Error::NotFinite { name: format!("tangents[{i}]"), value: format!("{t:?}") });
        }
        let tangents: Option<Vec<Vec4>> = data.tangents.map(|given| given.into_iter().map(Vec4::from_array).collect());
        let degenerate = data.triangles.iter().filter(|t| area_is_zero(&positions, **t)).count();
        let arrays = MeshArrays {
            positions: positions.into(),
            normals: vertex_normals.map(Array::from),
            tangents: tangents.map(Array::from),
            triangles: data.triangles.into(),
            weld: weld.into(),
            contact_normals: contact_normals.map(Array::from),
        };
        Ok((Self::of(arrays, limits, repaired, degenerate), smooth))
    }

    /// Makes a mesh from arrays as [`Mesh::new`] makes them. `degenerate_triangles` is the number of triangles without
    /// area.
    pub(crate) fn of(arrays: MeshArrays, limits: Limits, repaired_normals: usize, degenerate_triangles: usize) -> Self {
        let positions = &arrays.positions[..];
        let blocks = 0..positions.len().div_ceil(BLOCK);
        let block_bounds: Vec<Aabb> =
            blocks.map(|b| Aabb::of_slice(&positions[block_range(b, positions.len())])).collect();
        let mut bounds = Aabb::EMPTY;
        block_bounds.iter().for_each(|b| bounds.union(b));
        Self {
            bounds,
            block_bounds,
            seam_count: arrays.weld.iter().zip(0u32..).filter(|(w, v)| **w != *v).count(),
            arrays,
            limits,
            repaired_normals,
            degenerate_triangles,
        }
    }

    pub(crate) fn arrays(&self) -> &MeshArrays {
        &self.arrays
    }

    /// Removes the normals, as if there were no triangles to compute them from.
    pub(crate) fn without_normals(self) -> Self {
        let arrays = MeshArrays { normals: None, contact_normals: None, ..self.arrays };
        Mesh { arrays, ..self }
    }

    /// How far each vertex may move.
    pub(crate) fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Takes from another mesh the limits that this one lacks. `nearest` is a vertex of that mesh for each vertex.
    pub(crate) fn with_limits_of(mut self, from: &Mesh, nearest: &[u32]) -> Self {
        self.limits = self.limits.completed(&from.limits, nearest, &self.arrays.weld);
        self
    }

    /// Memory used, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let a = &self.arrays;
        let normals = a.normals.iter().chain(&a.contact_normals).map(Array::bytes).sum::<usize>();
        let tangents = a.tangents.as_ref().map_or(0, Array::bytes);
        a.positions.bytes() + a.weld.bytes() + normals + tangents + a.triangles.bytes() + self.limits.bytes()
    }

    /// Positions, m.
    pub fn positions(&self) -> &[Vec3] {
        &self.arrays.positions
    }

    /// Unit normals, given by the caller or computed. `None` if the mesh was given neither normals nor triangles.
    pub fn normals(&self) -> Option<&[Vec3]> {
        self.arrays.normals.as_deref()
    }

    /// The caller's tangents.
    pub fn tangents(&self) -> Option<&[Vec4]> {
        self.arrays.tangents.as_deref()
    }

    /// Triangles, three vertex indices each.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.arrays.triangles
    }

    /// Bounds of the base positions.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Bounds of the base positions of each block.
    pub(crate) fn block_bounds(&self) -> &[Aabb] {
        &self.block_bounds
    }

    /// Number of vertices at the same position as a lower vertex (UV seams, hard edges).
    pub fn seam_count(&self) -> usize {
        self.seam_count
    }

    /// For each vertex, the lowest vertex at the same position.
    pub fn weld(&self) -> &[u32] {
        &self.arrays.weld
    }

    /// Number of normals of length zero that were replaced by computed ones.
    pub fn repaired_normals(&self) -> usize {
        self.repaired_normals
    }

    /// Number of triangles without area. They are kept, but do not contribute to normals.
    pub fn degenerate_triangles(&self) -> usize {
        self.degenerate_triangles
    }

    /// The outward unit normal for a contact at `vertex`. It is smoothed over all vertices at that position, so hard
    /// edges have a single normal. A rib, a fold or a rear side, more than 60 degrees off the surface around it, has the normal of that
    /// surface. `None` if the mesh has neither normals nor triangles.
    pub fn contact_normal(&self, vertex: u32) -> Option<Vec3> {
        self.arrays.contact_normals.as_ref().map(|n| n[vertex as usize])
    }

    /// The normal of a vertex; its contact normal where the two are far apart.
    pub(crate) fn outward_normal(&self, vertex: u32) -> Option<Vec3> {
        let (own, around) = (self.normals()?[vertex as usize], self.contact_normal(vertex)?);
        Some(if own.dot(around) < LIKE { around } else { own })
    }
}

/// Contact normals: the smooth normal if the vertex has triangles, else the mean of the vertex normals at the position,
/// else +z. Where it is far off that of the surface around, that one.
fn contact_normals(
    positions: &[Vec3],
    smooth: &[Vec3],
    given: &[Vec3],
    weld: &[u32],
    mut surroundings: Surroundings,
) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; given.len()];
    for (v, n) in given.iter().enumerate() {
        sums[weld[v] as usize] += *n;
    }
    let own = |v: usize| unit(smooth[v]).or_else(|| unit(sums[weld[v] as usize])).unwrap_or(Vec3::Z);
    let outward = |v: usize| {
        let (own, around) = (own(v), surroundings.facing(positions[v]));
        around.map(DVec3::as_vec3).filter(|around| own.dot(*around) < LIKE).unwrap_or(own)
    };
    (0..given.len()).map(outward).collect()
}

/// For each vertex the lowest one at the same position. Zeros of either sign are different.
pub(crate) fn weld(positions: &[Vec3]) -> Result<Vec<u32>, Error> {
    let mut out = reserve(positions.len(), "seams")?;
    let mut first: HashMap<[u32; 3], u32> = HashMap::new();
    may_fail(|| first.try_reserve(positions.len()))
        .map_err(|_| Error::OutOfMemory { what: "seams".into(), bytes: positions.len() as u64 * 20 })?;
    for (v, p) in positions.iter().enumerate() {
        out.push(*first.entry(p.to_array().map(f32::to_bits)).or_insert(v as u32));
    }
    Ok(out)
}

fn area_is_zero(p: &[Vec3], t: [u32; 3]) -> bool {
    let [a, b, c] = t.map(|i| p[i as usize].as_dvec3());
    (b - a).cross(c - a).length_squared() == 0.0
}

fn check_len(name: &str, len: Option<usize>, n: usize) -> Result<(), Error> {
    match len {
        Some(l) if l != n => Err(Error::Mesh { what: format!("{l} {name} for {n} positions; there must be as many") }),
        _ => Ok(()),
    }
}

/// Returns `v` as a vector, or [`Error::NotFinite`] with `name`.
pub(crate) fn finite(v: [f32; 3], name: impl FnOnce() -> String) -> Result<Vec3, Error> {
    if v.iter().all(|x| x.is_finite()) {
        Ok(Vec3::from_array(v))
    } else {
        Err(Error::NotFinite { name: name(), value: format!("{v:?}") })
    }
}
