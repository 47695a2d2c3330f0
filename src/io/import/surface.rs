//! The vertices of a mesh at rest, in its own space: what primitives lack is filled in, and what is broken is computed anew.

use super::document::Document;
use super::primitives::Primitive;
use crate::base::error::Error;
use crate::base::math::{tangent_basis, unit};
use crate::mesh::data::MeshData;
use crate::mesh::{normals, weld};
use ::gltf::json::accessor::Type;
use ::gltf::json::mesh::Semantic;
use glam::Vec3;
use std::collections::HashMap;

/// A mesh at rest.
pub(crate) struct Surface {
    /// There are normals if a primitive has them, and tangents if a primitive has both.
    pub data: MeshData,
    /// For each vertex whether the value above is not the file's, so that an export must write it. Empty: no vertex.
    pub new_normals: Vec<bool>,
    pub new_tangents: Vec<bool>,
}

impl Surface {
    /// Reads the mesh whose primitives these are.
    pub fn read(doc: &Document<'_>, primitives: &[Primitive<'_>], notes: &mut Vec<String>) -> Result<Self, Error> {
        let mut positions = Vec::new();
        for primitive in primitives.iter().filter(|p| p.owns_vertices) {
            positions.extend(primitive.positions(doc)?.floats::<3>()?);
        }
        let mut out = Surface {
            data: MeshData {
                positions,
                triangles: primitives.iter().flat_map(|p| p.triangles.iter().copied()).collect(),
                depth_limits: custom(doc, primitives, "DEPTH_LIMIT", f32::INFINITY)?,
                stiffness: custom(doc, primitives, "STIFFNESS", 0.0)?,
                ..MeshData::default()
            },
            new_normals: Vec::new(),
            new_tangents: Vec::new(),
        };
        let normals = attribute::<3>(doc, primitives, Semantic::Normals, Type::Vec3)?;
        let Some(normals) = normals else { return Ok(out) };
        out.take_normals(normals, primitives, notes)?;
        if let Some(tangents) = attribute::<4>(doc, primitives, Semantic::Tangents, Type::Vec4)? {
            out.take_tangents(tangents, primitives, notes);
        }
        Ok(out)
    }

    fn take_normals(
        &mut self,
        given: Vec<Option<[f32; 3]>>,
        primitives: &[Primitive<'_>],
        notes: &mut Vec<String>,
    ) -> Result<(), Error> {
        let is_good = |n: &Option<[f32; 3]>| n.is_some_and(|n| unit(Vec3::from(n)).is_some_and(Vec3::is_finite));
        let smooth =
            if given.iter().all(is_good) { Vec::new() } else { smooth(&self.data.positions, &self.data.triangles)? };
        let mut broken = vec![false; given.len()];
        let all = given.iter().enumerate().map(|(v, n)| match n {
            Some(n) if is_good(&Some(*n)) => *n,
            given => {
                broken[v] = given.is_some();
                smooth[v].try_normalize().unwrap_or(Vec3::Z).to_array()
            }
        });
        self.data.normals = Some(all.collect());
        self.new_normals = noted(broken, primitives, "normals", notes);
        Ok(())
    }

    fn take_tangents(&mut self, given: Vec<Option<[f32; 4]>>, primitives: &[Primitive<'_>], notes: &mut Vec<String>) {
        let normals = self.data.normals.as_deref().unwrap_or_default();
        let is_good = |t: &[f32; 4]| t[3].is_finite() && unit(Vec3::new(t[0], t[1], t[2])).is_some_and(Vec3::is_finite);
        let broken: Vec<bool> = given.iter().map(|t| t.is_some_and(|t| !is_good(&t))).collect();
        // A vertex without a usable tangent takes a neighbour's.
        let mut neighbours: HashMap<u32, [f32; 4]> = HashMap::new();
        for t in self.data.triangles.iter().filter(|t| t.iter().any(|v| broken[*v as usize])) {
            let Some(good) = t.iter().find_map(|v| given[*v as usize].filter(is_good)) else { continue };
            for v in t.iter().filter(|v| broken[**v as usize]) {
                neighbours.entry(*v).or_insert(good);
            }
        }
        let all = given.iter().zip(0..).map(|(t, v)| {
            let normal = Vec3::from(normals[v as usize]).normalize_or(Vec3::Z);
            let (along, w) = match (t.filter(is_good), neighbours.get(&v)) {
                (Some(tangent), _) => return tangent,
                (None, Some([x, y, z, w])) => (Vec3::new(*x, *y, *z), *w),
                (None, None) => (Vec3::ZERO, 1.0),
            };
            let along = along.reject_from_normalized(normal);
            if along.length() > 1e-3 { along.normalize().extend(w).to_array() } else { perpendicular(normal) }
        });
        self.data.tangents = Some(all.collect());
        self.new_tangents = noted(broken, primitives, "tangents", notes);
    }
}

/// Makes a note if values are broken. Returns which are.
fn noted(broken: Vec<bool>, primitives: &[Primitive<'_>], what: &str, notes: &mut Vec<String>) -> Vec<bool> {
    let count = broken.iter().filter(|b| **b).count();
    if let Some(first) = broken.iter().position(|b| *b) {
        let at = primitives.iter().find(|p| p.vertices().contains(&first)).map_or("", |p| &p.name);
        notes.push(format!(
            "{count} of {} {what} have no length or are no numbers and were computed anew; the first is in {at}",
            broken.len()
        ));
    }
    broken
}

/// Any tangent for a vertex with this normal.
pub(super) fn perpendicular(normal: Vec3) -> [f32; 4] {
    tangent_basis(normal.normalize_or(Vec3::Z)).x_axis.extend(1.0).to_array()
}

/// The normal of the surface at each vertex; zero where there is none.
pub(super) fn smooth(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Vec<Vec3>, Error> {
    let positions: Vec<Vec3> = positions.iter().map(|p| Vec3::from(*p) + Vec3::ZERO).collect();
    Ok(normals::smooth(&positions, triangles, &weld(&positions)?))
}

/// An attribute of all vertices, `None` at those of primitives that lack it. `None` if all lack it.
fn attribute<const N: usize>(
    doc: &Document<'_>,
    primitives: &[Primitive<'_>],
    semantic: Semantic,
    kind: Type,
) -> Result<Option<Vec<Option<[f32; N]>>>, Error> {
    let mut values = Vec::new();
    let mut any = false;
    for primitive in primitives.iter().filter(|p| p.owns_vertices) {
        // Tangents without normals are to be ignored: glTF 2.0, 3.7.2.1.
        let alone = semantic == Semantic::Tangents && primitive.attribute(Semantic::Normals).is_none();
        match primitive.accessor(doc, semantic.clone(), kind)?.filter(|_| !alone) {
            Some(accessor) => values.extend(accessor.values::<N>()?.into_iter().map(Some)),
            None => values.resize(values.len() + primitive.vertex_count, None),
        }
        any |= values.last().is_some_and(Option::is_some);
    }
    Ok(any.then_some(values))
}

/// A custom attribute with one number a vertex, whose name in the file begins with `_`. Primitives that lack it have `absent`.
fn custom(
    doc: &Document<'_>,
    primitives: &[Primitive<'_>],
    name: &str,
    absent: f32,
) -> Result<Option<Vec<f32>>, Error> {
    let values = attribute::<1>(doc, primitives, Semantic::Extras(name.into()), Type::Scalar)?;
    Ok(values.map(|values| values.into_iter().map(|x| x.map_or(absent, |[x]| x)).collect()))
}
