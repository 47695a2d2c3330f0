//! Reads files into plain arrays: glTF morph targets, or a base OBJ with example OBJs.
//!
//! # glTF
//!
//! [`gltf_file`] and [`gltf_slice`] read glTF 2.0 (`.gltf` and `.glb`). Each morph target of the chosen mesh becomes
//! one example. The base is the mesh with every target at weight zero.
//!
//! - All triangle primitives of the mesh are joined in file order; [`Imported::primitives`] keeps their ranges.
//!   Primitives with the same accessors share one range. Strips and fans become triangles. Primitives of points or
//!   lines are left out.
//! - Normals and tangents are kept if every primitive has them. Otherwise they are `None` and computed later. The same
//!   holds for the normal deltas of a target. Tangent deltas are not read: tangents follow the normals.
//! - The custom attributes `_DEPTH_LIMIT` (m) and `_STIFFNESS` (0 to 1), one number a vertex, are read if every primitive has them
//!   ([`MeshData::depth_limits`](crate::MeshData::depth_limits)). Blender exports vertex attributes of these names.
//! - Names come from `mesh.extras.targetNames` and may be empty or repeat. A target without a name is called
//!   `target N`, counted from 0.
//! - Only geometry is read: images, materials, skins, cameras and animations may be missing or broken. Other files may
//!   be anywhere that a relative path leads to, including through `..`, as glTF allows.
//! - Compressed geometry (Draco, meshopt) and quantised positions give [`Error::Unsupported`], which names them.
//!
//! Two custom properties of the *mesh* (Blender: Object Data > Custom Properties, exported with
//! "Include > Custom Properties"; they are `mesh.extras` in the file) describe the examples:
//!
//! - `impacts`: the contact and the blow of each example. It is a list of
//!   `{"name": …, "point": [x, y, z], "contact_vertex": i, "normal": [x, y, z], "impulse": [x, y, z], "duration": t,
//!   "striker": {"mass": m, "radius": r, "velocity": [x, y, z]}}`, or the same list as a JSON text. `point` (m) and all
//!   vectors are in the mesh's own space *as exported* (y up; exporters do not turn custom properties).
//!   `contact_vertex` is an index into the joined vertices. One of `point` and `contact_vertex` is required; `point`
//!   takes precedence. `normal` points out of the body. `impulse` (N·s, on the body), `duration` (s) and the striker's
//!   mass (kg), radius at the contact (m) and velocity relative to the body before the touch (m/s) are optional, each
//!   on its own ([`Blow`](crate::Blow)). Other keys are ignored. Impacts are matched to targets by name if all target
//!   names differ and all impacts are named, otherwise by order. A target without an impact has its contact at its
//!   deepest vertex.
//! - `placements`: whether an example is `anchored` (stays where it was made), `carried` (moves to the hit) or
//!   `automatic`. It is one word for all (`"anchored"`), words in target order (`"anchored, carried"` or a list), or a
//!   map `{"target name": "anchored"}`. Targets that a map omits are automatic. A list or a map may be a text of JSON.
//!
//! [`gltf_body_file`] joins the meshes of all nodes to one body of parts.
//!
//! # OBJ
//!
//! [`obj_files`] reads a base and one OBJ per example. All must have as many `v` lines and the same faces, in the same
//! order, as solvers and sculpting tools write them.
//!
//! Files are not trusted. Lengths, offsets, counts and indices are checked before use, numbers must be finite, and
//! memory stays proportional to the size of the file.

use crate::base::error::Error;
use crate::example::data::ExampleData;
use crate::mesh::data::MeshData;
use std::ops::Range;

#[cfg(feature = "gltf")]
mod accessor;
#[cfg(feature = "gltf")]
mod body;
#[cfg(feature = "gltf")]
pub(crate) mod document;
#[cfg(feature = "gltf")]
mod extras;
#[cfg(feature = "gltf")]
pub(crate) mod gltf;
#[cfg(feature = "gltf")]
mod nodes;
#[cfg(feature = "obj")]
mod obj;
#[cfg(feature = "gltf")]
pub(crate) mod uri;

#[cfg(feature = "gltf")]
pub use self::body::{gltf_body, gltf_body_file};
#[cfg(feature = "gltf")]
pub use self::extras::apply_extras;
#[cfg(feature = "gltf")]
pub use self::gltf::{gltf_file, gltf_slice, gltf_solids};
#[cfg(feature = "obj")]
pub use self::obj::{obj_files, obj_slices};

/// The result of an importer: the arrays of an example set, and their places in the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The mesh's name; may be empty. For OBJ the file's stem.
    pub name: String,
    /// The base mesh. Positions are in the mesh's own space, m.
    pub mesh: MeshData,
    /// One texture coordinate per vertex, u to the right and v *down* from the upper left corner, as in glTF. Only for
    /// OBJ, and only if every face corner has one. `None` for glTF, whose [export](crate::io::export::deformed_glb)
    /// keeps them in the file.
    pub texcoords: Option<Vec<[f32; 2]>>,
    /// One example per morph target or example file, in order. Displacements are
    /// [`Deltas::Sparse`](crate::Deltas::Sparse): vertices that do not move are left out.
    pub examples: Vec<ExampleData>,
    /// The primitives that were joined, in file order. One for OBJ.
    pub primitives: Vec<PrimitiveRange>,
    /// The parts of a body that [`gltf_body`] read; empty otherwise.
    pub parts: Vec<Part>,
    /// The world matrix of the lowest-numbered node that shows this mesh, as four columns. `None` if no node does, and
    /// for OBJ.
    pub node_transform: Option<[[f32; 4]; 4]>,
}

/// The place of one primitive of the file in the joined mesh.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PrimitiveRange {
    /// Its index among the primitives of the file's mesh.
    pub primitive: u32,
    /// Its first vertex.
    pub first_vertex: u32,
    /// The number of its vertices.
    pub vertex_count: u32,
    /// Its first triangle. Triangles refer to joined vertices.
    pub first_triangle: u32,
    /// The number of its triangles.
    pub triangle_count: u32,
    /// The name of its material (`material N` if it has no name); `None` without a material.
    pub material: Option<String>,
}

/// The place of one node's mesh in the joined mesh of a body.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// The node's name, or its mesh's if it has none, or `node N`.
    pub name: String,
    /// Its first vertex.
    pub first_vertex: u32,
    /// The number of its vertices.
    pub vertex_count: u32,
    /// Its first triangle. Triangles refer to joined vertices.
    pub first_triangle: u32,
    /// The number of its triangles.
    pub triangle_count: u32,
}

impl Part {
    /// The indices of its vertices in the joined mesh.
    pub fn vertices(&self) -> Range<usize> {
        self.first_vertex as usize..(self.first_vertex + self.vertex_count) as usize
    }
}

impl Imported {
    /// Returns the mesh of each part, for [`ExampleSet::add_lod`](crate::ExampleSet::add_lod) in this order: part 0 gets the
    /// number 1. Limits and stiffness are left out; they are the joined mesh's.
    pub fn part_meshes(&self) -> Vec<MeshData> {
        let mesh = |part: &Part| {
            let own = part.vertices();
            let first = part.first_triangle as usize;
            let triangles = &self.mesh.triangles[first..first + part.triangle_count as usize];
            MeshData {
                positions: self.mesh.positions[own.clone()].to_vec(),
                normals: self.mesh.normals.as_ref().map(|normals| normals[own.clone()].to_vec()),
                tangents: self.mesh.tangents.as_ref().map(|tangents| tangents[own].to_vec()),
                triangles: triangles.iter().map(|t| t.map(|v| v - part.first_vertex)).collect(),
                ..MeshData::default()
            }
        };
        self.parts.iter().map(mesh).collect()
    }
}

/// The mesh of a file to read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MeshChoice<'a> {
    /// The first with morph targets.
    #[default]
    First,
    /// By its index in the file.
    Index(usize),
    /// By its name; the first of that name.
    Name(&'a str),
}

pub(crate) fn malformed(what: impl Into<String>) -> Error {
    Error::Format { what: what.into() }
}

#[cfg(feature = "gltf")]
pub(crate) fn unsupported(what: impl Into<String>) -> Error {
    Error::Unsupported { what: what.into() }
}

/// Returns an `Err` that names the first component that is NaN or infinite.
pub(crate) fn finite<const N: usize>(value: [f32; N], name: impl FnOnce() -> String) -> Result<[f32; N], Error> {
    match value.iter().position(|x| !x.is_finite()) {
        None => Ok(value),
        Some(i) => Err(Error::NotFinite {
            name: format!("{}.{}", name(), ["x", "y", "z", "w"][i.min(3)]),
            value: value[i].to_string(),
        }),
    }
}
