//! Reads files into plain arrays: glTF morph targets, or a base OBJ with example OBJs.
//!
//! # glTF
//!
//! [`gltf_file`] and [`gltf_slice`] read glTF 2.0 (`.gltf` and `.glb`). Each morph target of the chosen
//! mesh becomes one example; the base is the mesh with every target at weight zero.
//!
//! - All triangle primitives of the mesh are joined in file order; [`Imported::primitives`] keeps their
//!   ranges. Primitives that use the very same accessors share one range. Strips and fans become
//!   triangles; primitives of points or lines are left out.
//! - Normals and tangents are kept when every primitive has them, and are `None` (computed later) when
//!   one lacks them; the same holds for the normal deltas of a target. Tangent deltas are not read:
//!   tangents follow the normals.
//! - Names come from `mesh.extras.targetNames` and may be empty or repeat; a target without one is called
//!   `target N`, counted from 0.
//! - Only geometry is read: images, materials, skins, cameras and animations may be missing or broken. Other files may
//!   be anywhere that a relative path reaches, `..` included, as glTF allows.
//! - Compressed geometry (Draco, meshopt) and quantised positions are named in [`Error::Unsupported`].
//!
//! Two custom properties of the *mesh* (Blender: Object Data > Custom Properties, exported with
//! "Include > Custom Properties"; they are `mesh.extras` in the file) describe the examples:
//!
//! - `impacts`: the contact of each example. It is a list of
//!   `{"name": …, "point": [x, y, z], "contact_vertex": i, "normal": [x, y, z]}`, or the same list as a JSON
//!   text. `point` (m) is in the mesh's own space *as exported* (y up; exporters do not turn custom
//!   properties) and takes precedence over `contact_vertex`, an index into the joined vertices; one of the two
//!   is required. `normal` is optional and points out of the body. Impacts are matched to targets by name when all target
//!   names differ and all impacts are named, otherwise by order. The contact of other targets is their deepest vertex.
//! - `placements`: whether an example is `anchored` (stays where it was made), `carried` (moves to the hit) or `automatic`. It is
//!   one word for all (`"anchored"`), words by target order (`"anchored, carried"` or a list), or a map
//!   `{"target name": "anchored"}`; targets that a map omits are automatic.
//!
//! # OBJ
//!
//! [`obj_files`] reads a base and one OBJ an example, all with the same `v` lines and faces in the same order, as
//! solvers and sculpting tools write them.
//!
//! Files are not trusted: lengths, offsets, counts and indices are checked before they are used, numbers must be finite,
//! and memory stays in proportion to the file.

use crate::base::error::Error;
use crate::example::data::ExampleData;
use crate::mesh::data::MeshData;

#[cfg(feature = "gltf")]
mod accessor;
#[cfg(feature = "gltf")]
pub(crate) mod document;
#[cfg(feature = "gltf")]
mod extras;
#[cfg(feature = "gltf")]
pub(crate) mod gltf;
#[cfg(feature = "obj")]
mod obj;
#[cfg(feature = "gltf")]
pub(crate) mod uri;

#[cfg(feature = "gltf")]
pub use self::gltf::{gltf_file, gltf_slice};
#[cfg(feature = "obj")]
pub use self::obj::{obj_files, obj_slices};

/// The result of an importer: the arrays of an example set, and where they were in the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The mesh's name; may be empty. The file's stem for OBJ.
    pub name: String,
    /// The base mesh. Positions in the mesh's own space, m.
    pub mesh: MeshData,
    /// One texture coordinate a vertex, u to the right and v *down* from the upper left corner, as in glTF. OBJ
    /// only, and only when every face corner has one; `None` for glTF, whose
    /// [export](crate::io::export::deformed_glb) keeps them in the file.
    pub texcoords: Option<Vec<[f32; 2]>>,
    /// One example a morph target or example file, in order. Displacements are
    /// [`Deltas::Sparse`](crate::Deltas::Sparse): vertices that do not move are left out.
    pub examples: Vec<ExampleData>,
    /// The parts that were joined, in file order. One part for OBJ.
    pub primitives: Vec<PrimitiveRange>,
    /// The world matrix of the lowest-numbered node that shows this mesh, as four columns; `None` when no node does, and for OBJ.
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
    /// Its first triangle. The triangles' indices are into the joined vertices.
    pub first_triangle: u32,
    /// The number of its triangles.
    pub triangle_count: u32,
    /// The name of its material (`material N` where it has none), or `None` without a material.
    pub material: Option<String>,
}

/// Which mesh of a file to read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MeshChoice<'a> {
    /// The first that has morph targets.
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

/// `Err` that names the first component that is NaN or infinite.
pub(crate) fn finite<const N: usize>(value: [f32; N], name: impl FnOnce() -> String) -> Result<[f32; N], Error> {
    match value.iter().position(|x| !x.is_finite()) {
        None => Ok(value),
        Some(i) => Err(Error::NotFinite {
            name: format!("{}.{}", name(), ["x", "y", "z", "w"][i.min(3)]),
            value: value[i].to_string(),
        }),
    }
}
