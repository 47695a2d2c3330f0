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
    /// `new` returns what a value of the file becomes, or `None` if it stays.
    fn of(file: &[[f32; N]], new: impl Fn(usize, [f32; N]) -> Option<[f32; N]>) -> Self {
        let new: Vec<Option<[f32; N]>> = file.iter().enumerate().map(|(v, value)| new(v, *value)).collect();
        Written {
            changed: new.iter().map(Option::is_some).collect(),
            values: new.into_iter().zip(file).map(|(new, old)| new.unwrap_or(*old)).collect(),
        }
    }

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
        let (first, surface) = (piece.first_vertex, &piece.surface);
        let linear = DMat3::from_mat4(piece.to_body);
        let back = linear.inverse();
        let as_it_is = piece.to_body == DMat4::IDENTITY;
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let is_moved = |v: usize| after.positions[first + v] != rest.positions[first + v];
        let least = |v: usize| if is_moved(v) { 0.0 } else { ROUNDING };
        let added = |of: fn(&Offsets) -> &[[f32; 3]], v: usize| shown.map(|s| of(s)[v]).filter(|by| *by != [0.0; 3]);

        let positions = Written::of(&surface.data.positions, |v, p| {
            let (before, now) = (rest.positions[first + v], after.positions[first + v]);
            let place = || if as_it_is { now } else { to_f32(wide(p) + back * (wide(now) - wide(before))) };
            let moved = is_moved(v).then(place);
            added(|s| &s.positions, v).map(|by| sum(moved.unwrap_or(p), by)).or(moved)
        });

        let normal = |v: usize, n: [f32; 3]| {
            // An example set makes normals exactly this long.
            let at_rest = unit(Vec3::from(rest.normals.as_ref().map_or([0.0; 3], |n| n[first + v])));
            let turned_by = |n: [f32; 3]| at_rest.map(|rest| (rest - Vec3::from(n)).abs().max_element());
            let given = after.normals.map(|n| n[first + v]).filter(|n| turned_by(*n).is_none_or(|by| by > least(v)));
            let back = |n| if as_it_is { n } else { to_f32((linear.transpose() * wide(n)).normalize_or_zero()) };
            let new = given.map(back);
            let turned = |by| {
                let n = new.unwrap_or(n);
                Vec3::from(sum(n, by)).normalize_or(Vec3::from(n)).to_array()
            };
            added(|s| &s.normals, v).map(turned).or(new).or(flagged(&surface.new_normals, v).then_some(n))
        };
        let normals = surface.data.normals.as_ref().map(|normals| Written::of(normals, normal));

        let tangent = |v: usize, t: [f32; 4]| {
            let turned_by = |a: [f32; 4], b: [f32; 4]| (Vec4::from(a) - Vec4::from(b)).abs().max_element();
            let at_rest = rest.tangents.as_ref().map(|t| t[first + v]);
            let is_new = |t: &[f32; 4]| at_rest.is_none_or(|rest| turned_by(rest, *t) > least(v));
            let back = |given: [f32; 4]| {
                let [x, y, z, w] = given;
                if as_it_is {
                    return given;
                }
                let [x, y, z] = to_f32((back * wide([x, y, z])).normalize_or_zero());
                [x, y, z, if linear.determinant() < 0.0 { -w } else { w }]
            };
            let new = after.tangents.map(|t| t[first + v]).filter(is_new).map(back);
            new.or(flagged(&surface.new_tangents, v).then_some(t))
        };
        let tangents = surface.data.tangents.as_ref().map(|tangents| Written::of(tangents, tangent));
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
