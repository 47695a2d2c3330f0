//! The vertices of a piece as the file holds them: which of them changed, and new accessors for those.

use super::vertices::{Rewrite, Vertices};
use crate::base::error::Error;
use crate::base::math::{to_f32, unit};
use crate::io::glb::{ARRAY_BUFFER, kind, set_bounds};
use crate::io::import::accessor::Accessor;
use crate::io::import::piece::{Offsets, Piece};
use crate::io::import::primitives::Primitive;
use crate::mesh::data::MeshData;
use ::gltf::json::accessor::{ComponentType, Type};
use ::gltf::json::mesh::Semantic;
use glam::{DMat3, DMat4, DVec3, Vec3, Vec4};
use serde_json::json;

/// Where a vertex stays, its normal and tangent stay too unless a component changes by more than this, 0.006 degrees: a displacement
/// may be shorter than the rounding of positions, and the slope of a carried dent fades out a little later than its depth.
const ROUNDING: f32 = 1e-4;

/// An attribute of a piece in its mesh's own space, and which vertices an export must write.
pub(super) struct Written<const N: usize> {
    pub values: Vec<[f32; N]>,
    pub changed: Vec<bool>,
}

impl<const N: usize> Written<N> {
    fn any(&self) -> bool {
        self.changed.contains(&true)
    }

    /// Adds an accessor for a primitive's vertices if any of them changed. Returns the attribute's name and the accessor's number.
    fn write(
        &self,
        to: &mut Rewrite<'_>,
        primitive: &Primitive<'_>,
        semantic: Semantic,
    ) -> Result<Option<(String, usize)>, Error> {
        let own = primitive.vertices();
        let (values, changed) = (&self.values[own.clone()], &self.changed[own]);
        if !changed.contains(&true) {
            return Ok(None);
        }
        let of = if N == 3 { Type::Vec3 } else { Type::Vec4 };
        let Some(old) = primitive.accessor(to.doc, semantic.clone(), of)? else { return Ok(None) };
        let is_position = semantic == Semantic::Positions;
        Ok(Some((semantic.to_string(), push_changed(to, &old, (values, changed), is_position))))
    }
}

/// What of a piece is written.
pub(super) struct Changes {
    pub positions: Written<3>,
    pub normals: Option<Written<3>>,
    pub tangents: Option<Written<4>>,
}

impl Changes {
    /// `rest` is the body at rest, `after` is what it became, and `shown` what the file adds to the piece by default.
    pub fn of(piece: &Piece<'_>, rest: &MeshData, after: &Vertices<'_>, shown: Option<&Offsets>) -> Self {
        let own = piece.first_vertex..piece.first_vertex + piece.surface.data.positions.len();
        let linear = DMat3::from_mat4(piece.to_body);
        let back = linear.inverse();
        let as_it_is = piece.to_body == DMat4::IDENTITY;
        let map = |m: DMat3, v: Vec3| m * v.as_dvec3();
        let surface = &piece.surface;

        let (at_rest, moved) = (&rest.positions[own.clone()], &after.positions[own.clone()]);
        let least = |v: usize| if moved[v] == at_rest[v] { ROUNDING } else { 0.0 };
        let added = |v: usize| shown.map_or([0.0; 3], |shown| shown.positions[v]);
        let turned = |v: usize| shown.map_or([0.0; 3], |shown| shown.normals[v]);
        let position = |(v, p): (usize, &[f32; 3])| {
            let p = match moved[v] == at_rest[v] {
                true => *p,
                false if as_it_is => moved[v],
                false => {
                    let by = Vec3::from(moved[v]).as_dvec3() - Vec3::from(at_rest[v]).as_dvec3();
                    to_f32(Vec3::from(*p).as_dvec3() + back * by)
                }
            };
            if added(v) == [0.0; 3] { p } else { sum(p, added(v)) }
        };
        let positions = Written {
            values: surface.data.positions.iter().enumerate().map(position).collect(),
            changed: (0..own.len()).map(|v| moved[v] != at_rest[v] || added(v) != [0.0; 3]).collect(),
        };

        let normals = surface.data.normals.as_ref().map(|normals| {
            let given = after.normals.map(|n| &n[own.clone()]);
            // An example set makes normals exactly this long.
            let at_rest = |v: usize| unit(Vec3::from(rest.normals.as_ref().map_or([0.0; 3], |n| n[own.start + v])));
            let turned_by = |v: usize, n: [f32; 3]| at_rest(v).map(|rest| (rest - Vec3::from(n)).abs().max_element());
            let is_new = |v: usize| given.is_some_and(|n| turned_by(v, n[v]).is_none_or(|by| by > least(v)));
            let normal = |(v, n): (usize, &[f32; 3])| {
                let n = match given.filter(|_| is_new(v)) {
                    Some(given) if as_it_is => given[v],
                    Some(given) => to_f32(map(linear.transpose(), Vec3::from(given[v])).normalize_or_zero()),
                    None => *n,
                };
                if turned(v) == [0.0; 3] {
                    n
                } else {
                    Vec3::from(sum(n, turned(v))).normalize_or(Vec3::from(n)).to_array()
                }
            };
            let changed = |v: usize| is_new(v) || turned(v) != [0.0; 3] || flagged(&surface.new_normals, v);
            Written {
                values: normals.iter().enumerate().map(normal).collect(),
                changed: (0..own.len()).map(changed).collect(),
            }
        });

        let tangents = surface.data.tangents.as_ref().map(|tangents| {
            let given = after.tangents.map(|t| &t[own.clone()]);
            let at_rest = |v: usize| rest.tangents.as_ref().map(|t| t[own.start + v]);
            let turned_by = |a: [f32; 4], b: [f32; 4]| (Vec4::from(a) - Vec4::from(b)).abs().max_element();
            let is_new =
                |v: usize| given.is_some_and(|t| at_rest(v).is_none_or(|rest| turned_by(rest, t[v]) > least(v)));
            let mirrored = linear.determinant() < 0.0;
            let tangent = |(v, t): (usize, &[f32; 4])| match given.filter(|_| is_new(v)).map(|t| t[v]) {
                Some(given) if as_it_is => given,
                Some([x, y, z, w]) => {
                    let [x, y, z] = to_f32((back * DVec3::from([x, y, z].map(f64::from))).normalize_or_zero());
                    [x, y, z, if mirrored { -w } else { w }]
                }
                None => *t,
            };
            Written {
                values: tangents.iter().enumerate().map(tangent).collect(),
                changed: (0..own.len()).map(|v| is_new(v) || flagged(&surface.new_tangents, v)).collect(),
            }
        });
        Changes { positions, normals, tangents }
    }

    /// Adds accessors for the attributes of a primitive that changed. Returns their names and numbers.
    pub fn write(&self, to: &mut Rewrite<'_>, primitive: &Primitive<'_>) -> Result<Vec<(String, usize)>, Error> {
        let mut list = Vec::from_iter(self.positions.write(to, primitive, Semantic::Positions)?);
        if let Some(normals) = &self.normals {
            list.extend(normals.write(to, primitive, Semantic::Normals)?);
        }
        let has_normals = primitive.attribute(Semantic::Normals).is_some();
        if let Some(tangents) = self.tangents.as_ref().filter(|_| has_normals) {
            list.extend(tangents.write(to, primitive, Semantic::Tangents)?);
        }
        Ok(list)
    }

    pub fn any(&self) -> bool {
        let (normals, tangents) = (&self.normals, &self.tangents);
        self.positions.any()
            || normals.as_ref().is_some_and(Written::any)
            || tangents.as_ref().is_some_and(Written::any)
    }
}

fn sum(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|k| a[k] + b[k])
}

fn flagged(list: &[bool], v: usize) -> bool {
    list.get(v).copied().unwrap_or(false)
}

/// Adds an accessor that holds the elements of the file's accessor `old` where nothing changed, and `values` elsewhere. Positions
/// become floats, with bounds; other quantised vectors stay so.
pub(super) fn push_changed<const N: usize>(
    Rewrite { doc, glb, .. }: &mut Rewrite<'_>,
    old: &Accessor<'_>,
    (values, changed): (&[[f32; N]], &[bool]),
    is_position: bool,
) -> usize {
    let is_float = old.component == ComponentType::F32;
    let mut bytes = Vec::with_capacity(values.len() * N * 4);
    for (i, (value, changed)) in values.iter().zip(changed).enumerate() {
        match old.stored(i).filter(|_| !changed && (is_float || !is_position)) {
            Some(stored) => bytes.extend_from_slice(stored),
            None if is_position => bytes.extend(value.iter().flat_map(|x| x.to_le_bytes())),
            None => bytes.extend(old.encoded(*value)),
        }
        // Elements of vertex attributes begin at multiples of four bytes.
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    let json = &doc.value["accessors"][old.index];
    let mut accessor = json!({ "count": values.len(), "type": kind::<N>() });
    for key in ["name", "extras"].into_iter().filter(|key| !json[key].is_null()) {
        accessor[key] = json[key].clone();
    }
    let view = glb.push_view(&bytes, Some(ARRAY_BUFFER));
    if is_position || is_float {
        accessor["componentType"] = 5126.into();
    } else {
        glb.root["bufferViews"][view]["byteStride"] = (bytes.len() / values.len().max(1)).into();
        accessor["componentType"] = json["componentType"].clone();
        accessor["normalized"] = json["normalized"].clone();
    }
    if is_position {
        set_bounds(&mut accessor, values.iter());
    }
    accessor["bufferView"] = view.into();
    glb.push("accessors", accessor)
}
