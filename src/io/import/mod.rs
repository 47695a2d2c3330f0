//! Reads files into plain arrays: glTF morph targets, or a base OBJ with example OBJs.
//!
//! # glTF
//!
//! [`gltf_file`] and [`gltf_slice`] read glTF 2.0 (`.gltf` and `.glb`). Each morph target that is a dent becomes one example; a
//! [`Reading`] chooses the mesh or the nodes, and the targets. The base is the mesh with every target at weight zero.
//!
//! - All triangle primitives of a mesh are joined in file order; [`Imported::primitives`] keeps their ranges. Primitives with the
//!   same accessors share one range. Strips and fans become triangles. Primitives of points or lines are left out, unless the mesh
//!   has no others; then its vertices are read without triangles.
//! - Vertices of primitives without normals or tangents get computed ones if another primitive has them; if none has, they are
//!   `None` and computed later. Normals and tangents that are no numbers or have no length are computed too. A primitive that lacks
//!   a target does not move in it. The normal deltas of a target count only if every primitive that moves has some. Tangent deltas
//!   are not read: tangents follow the normals.
//! - Floats, and the bytes and shorts of KHR_mesh_quantization, are read. So is geometry that EXT_meshopt_compression or
//!   KHR_meshopt_compression packed. Draco's compression cannot hold morph targets: [`Error::Unsupported`].
//! - The custom attributes `_DEPTH_LIMIT` (in the file's unit) and `_STIFFNESS` (0 to 1), one number a vertex, are read
//!   ([`MeshData::depth_limits`](crate::MeshData::depth_limits)). Blender exports vertex attributes of these names.
//! - Names come from `mesh.extras.targetNames` and may be empty or repeat. Without that list they are the names of the targets'
//!   accessors, if all differ. A target without a name is called `target N`, counted from 0.
//! - Only geometry is read: images, materials, skins, cameras, animations and other meshes may be missing or broken. Buffers are
//!   read from the file's folder and below.
//!
//! Custom properties of the *mesh* (Blender: Object Data > Custom Properties, exported with
//! "Include > Custom Properties"; they are `mesh.extras` in the file) describe the examples:
//!
//! - `dents`: which targets are dents: names or [`Patterns`], as a list or a text with commas. The others are left alone.
//! - `impacts`: the contact and the blow of each example. It is a list of
//!   `{"name": …, "point": [x, y, z], "contact_vertex": i, "normal": [x, y, z], "impulse": [x, y, z], "duration": t,
//!   "striker": {"mass": m, "radius": r, "velocity": [x, y, z], "shape": "ball"}}`, or the same list as a JSON text. `point` and all
//!   vectors are in the mesh's own space and unit *as exported* (y up; exporters do not turn custom properties).
//!   `contact_vertex` is an index into the vertices of the mesh. One of `point` and `contact_vertex` is required; `point`
//!   takes precedence. `normal` points out of the body. `impulse` (N·s, on the body), `duration` (s) and the striker's
//!   mass (kg), radius at the contact (m) and velocity relative to the body before the touch (m/s), and its shape (ball,
//!   pole, corner or wall) are optional, each on its own ([`Blow`](crate::Blow)). Other keys are ignored. Impacts are matched to targets by name if all target
//!   names differ and all impacts are named, otherwise by order. A target without an impact has its contact at its
//!   deepest vertex.
//! - `targets` of a *scene*: `joined` if targets of one name are one example wherever they lie; see below.
//! - `crumple`, also of a node or a material: `rigid`, `glass` or `moving`, as [`Reading`] explains.
//!
//! # Bodies of parts
//!
//! With [`MeshChoice::Nodes`] the meshes of nodes are joined to one body: each lies where its node places it in the scene, or where
//! its skin does. Each node is a [`Part`]. If there are more than 63, the smallest belong to the part of a node above them.
//! Vertices of different nodes that lie within a millionth of the body's diagonal get one position, so that seams between parts
//! stay closed. Targets of one name are one example if their moved vertices lie near each other, as where a dent crosses a seam.
//! Those that lie apart are examples of their own, named after the part: exporters call the first key of every part "Key 1".
//! If several meshes have an impact for one example, the first counts.
//!
//! ```no_run
//! use crumple::{ExampleSet, Serial, SetOptions, import};
//! let all = import::Patterns::default();
//! let body = import::gltf_file("car.glb".as_ref(), import::MeshChoice::Nodes(all))?;
//! let parts = body.part_meshes();
//! let mut set = ExampleSet::build(body.mesh, body.examples, SetOptions::default(), &Serial)?;
//! for (part, mesh) in body.parts.iter().zip(parts) {
//!     println!("part {} is {}", set.add_lod(mesh, &Serial)?, part.name);
//! }
//! # Ok::<(), crumple::Error>(())
//! ```
//!
//! # OBJ
//!
//! [`obj_glb`] makes a GLB of a base and one OBJ per example, so that all of the above holds for OBJ too: objects and groups are
//! nodes, and materials are kept. [`obj_files`] reads such files.
//!
//! Files are not trusted. Lengths, offsets, counts and indices are checked before use, numbers must be finite, and
//! memory stays proportional to the size of the file. What is odd but harmless is in [`Imported::notes`].

use crate::base::error::Error;
use crate::example::data::ExampleData;
use crate::mesh::data::MeshData;
use serde_json::Value;
use std::ops::Range;

pub(crate) mod accessor;
pub(crate) mod body;
pub(crate) mod document;
mod extras;
mod join;
pub(crate) mod meshopt;
#[cfg(feature = "obj")]
mod mtl;
mod nodes;
mod notes;
#[cfg(feature = "obj")]
mod obj;
#[cfg(feature = "obj")]
mod obj_text;
pub(crate) mod piece;
pub(crate) mod primitives;
mod reading;
mod surface;
pub(crate) mod uri;
pub(crate) mod words;

pub use self::body::{gltf_file, gltf_slice, gltf_solids};
pub use self::extras::apply_extras;
#[cfg(feature = "obj")]
pub use self::obj::{obj_files, obj_glb, obj_slices};
pub use self::reading::{MeshChoice, Patterns, Reading};
pub use crate::io::glb::GlbFile;

/// The result of an importer: the arrays of an example set, and their places in the file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Imported {
    /// The mesh's name; may be empty. For OBJ, and for a body of nodes, the file's stem.
    pub name: String,
    /// The base mesh. Positions are in the mesh's own space, or in the scene's for a body of nodes, m.
    pub mesh: MeshData,
    /// One example per dent, in order. Displacements are [`Deltas::Sparse`](crate::Deltas::Sparse): vertices that do not move are
    /// left out.
    pub examples: Vec<ExampleData>,
    /// The primitives that were joined, in file order.
    pub primitives: Vec<PrimitiveRange>,
    /// The parts of a body of nodes, and primitives that are glass.
    pub parts: Vec<Part>,
    /// The world matrix of the lowest-numbered node that shows this mesh, as four columns. `None` if no node does, and
    /// for a body of nodes.
    pub node_transform: Option<[[f32; 4]; 4]>,
    /// What is odd in the file, and what was done about it: a sentence each, for people.
    pub notes: Vec<String>,
}

/// The place of one primitive of the file in the joined mesh.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PrimitiveRange {
    /// Its index among the primitives of the file's mesh.
    pub primitive: u32,
    /// The indices of its vertices.
    pub vertices: Range<usize>,
    /// The indices of its triangles, which refer to joined vertices.
    pub triangles: Range<usize>,
    /// The name of its material (`material N` if it has no name); `None` without a material.
    pub material: Option<String>,
}

/// The place of a node's mesh in the joined mesh of a body.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// The node's name; else its mesh's, that of the next node above it with a name, or `node N`. For a primitive that is glass, its
    /// material's name.
    pub name: String,
    /// What it does when it is hit.
    pub kind: PartKind,
    /// The indices of its vertices.
    pub vertices: Range<usize>,
    /// The indices of its triangles, which refer to joined vertices.
    pub triangles: Range<usize>,
}

/// What a part does when it is hit; see [`Reading`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PartKind {
    /// It dents.
    #[default]
    Dents,
    /// It never moves: the stiffness of its vertices is 1.
    Rigid,
    /// It follows dents around it, but hits on it leave no mark: make it rigid with
    /// [`Instance::set_rigid`](crate::Instance::set_rigid).
    Glass,
}

impl Imported {
    /// Returns the mesh of each part, for [`ExampleSet::add_lod`](crate::ExampleSet::add_lod) in this order: part 0 gets the
    /// number 1. Limits and stiffness are left out; they are the joined mesh's.
    pub fn part_meshes(&self) -> Vec<MeshData> {
        let mesh = |part: &Part| {
            let (own, first) = (part.vertices.clone(), part.vertices.start as u32);
            let triangles = &self.mesh.triangles[part.triangles.clone()];
            MeshData {
                positions: self.mesh.positions[own.clone()].to_vec(),
                normals: self.mesh.normals.as_ref().map(|normals| normals[own.clone()].to_vec()),
                tangents: self.mesh.tangents.as_ref().map(|tangents| tangents[own].to_vec()),
                triangles: triangles.iter().map(|t| t.map(|v| v - first)).collect(),
                ..MeshData::default()
            }
        };
        self.parts.iter().map(mesh).collect()
    }
}

pub(crate) fn malformed(what: impl Into<String>) -> Error {
    Error::Format { what: what.into() }
}

pub(crate) fn unsupported(what: impl Into<String>) -> Error {
    Error::Unsupported { what: what.into() }
}

/// A whole number, however it is written: JSON has one type of number, and some exporters write 9.0.
pub(crate) fn whole(value: &Value) -> Option<u64> {
    let written = value.as_f64().filter(|x| *x >= 0.0 && *x < 9e15 && x.fract() == 0.0);
    value.as_u64().or(written.map(|x| x as u64))
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
