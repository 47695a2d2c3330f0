//! Writes deformed meshes to GLB files.
//!
//! [`deformed_glb`] rewrites a glTF: it changes the vertices that moved and keeps everything else. [`mesh_glb`]
//! writes a new file, for a mesh that comes from no file.
//!
//! ```
//! use crumple::export::deformed_glb;
//! use crumple::import::{MeshChoice, gltf_slice};
//! # let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/two_materials.glb");
//! # let source = std::fs::read(path).unwrap();
//! let imported = gltf_slice(&source, None, MeshChoice::First)?;
//! let lifted: Vec<[f32; 3]> = imported.mesh.positions.iter().map(|[x, y, z]| [*x, y + 1.0, *z]).collect();
//! let normals = imported.mesh.normals.as_deref();
//! let exported = deformed_glb(&source, None, MeshChoice::First, &lifted, normals, None)?;
//! assert!(exported.glb.starts_with(b"glTF"));
//! # Ok::<(), crumple::Error>(())
//! ```

use crate::base::error::Error;
use crate::io::glb::{Glb, new_root};
use crate::io::import::Reading;
use serde_json::json;
use std::path::Path;
use vertices::Vertices;

mod attributes;
mod compact;
mod images;
mod rewrite;
mod targets;
mod vertices;

pub use crate::io::glb::GlbFile;

/// Rewrites a glTF (`.glb` or `.gltf`) with the deformed vertices of a mesh, or of a body of nodes.
///
/// `positions` (m), unit `normals` and `tangents` (xyz unit, w +1 or -1) are in the order of the joined vertices that
/// the [import](crate::io::import) with the same reading gives. Without `normals` or `tangents`, those of the file are kept.
///
/// Where a vertex is as the import gave it (normals: of unit length), the file's bytes stay. Only attributes that a primitive has are
/// written: one without normals stays without, and glTF shows it flat. Quantised normals and tangents stay quantised; quantised
/// positions of a primitive that moved become floats. Lines and points follow the vertices whose accessor or positions they share.
///
/// A dent that the file shows by default, by the weight of its target, stays in the shape that is written.
///
/// The morph targets that are dents are removed, with their weights, names, impacts, placements and animation. Other targets stay,
/// and so does everything else: node tree, materials, texture coordinates, skins, cameras, other meshes (also those that share data
/// with this one), extras, unknown extensions. Nodes that share a mesh get meshes of their own where their dents differ. Buffers and
/// images in other files are embedded. Images that cannot be read keep their uri. Geometry that was packed by meshoptimizer is
/// written plainly. Data that nothing uses any more is dropped, unless the file uses extensions that this library does not know,
/// since these may refer to it.
///
/// # Errors
/// [`Error::InvalidArgument`] for a wrong number of vertices, [`Error::NotFinite`] for NaN and infinities, and the errors
/// of [`gltf_slice`](crate::io::import::gltf_slice) for a file that it cannot read.
pub fn deformed_glb(
    source: &[u8],
    base_dir: Option<&Path>,
    reading: impl Into<Reading>,
    positions: &[[f32; 3]],
    normals: Option<&[[f32; 3]]>,
    tangents: Option<&[[f32; 4]]>,
) -> Result<GlbFile, Error> {
    rewrite::deformed(source, base_dir, &reading.into(), Vertices { positions, normals, tangents })
}

/// Writes a new GLB with one mesh: the deformed vertices and the triangles. A mesh without triangles becomes points.
///
/// # Errors
/// [`Error::InvalidArgument`] for a mesh without vertices or attributes of different lengths, [`Error::IndexOutOfRange`] for a corner
/// of a triangle that is no vertex, [`Error::NotFinite`] for NaN and infinities.
pub fn mesh_glb(
    name: &str,
    triangles: &[[u32; 3]],
    positions: &[[f32; 3]],
    normals: Option<&[[f32; 3]]>,
    tangents: Option<&[[f32; 4]]>,
) -> Result<Vec<u8>, Error> {
    let count = positions.len();
    Vertices { positions, normals, tangents }.check(count)?;
    if count == 0 || count > u32::MAX as usize {
        return Err(Error::invalid("positions.len()", count, &format!("from 1 to {}", u32::MAX)));
    }
    let corners = triangles.as_flattened();
    if let Some(at) = corners.iter().position(|v| *v as usize >= count) {
        let name = format!("triangles[{}][{}]", at / 3, at % 3);
        return Err(Error::IndexOutOfRange { name, index: corners[at].into(), len: count as u64 });
    }
    let node = if name.is_empty() { json!({ "mesh": 0 }) } else { json!({ "mesh": 0, "name": name }) };
    let mut glb = Glb::new(new_root(json!({ "nodes": [0] }), json!([node])));
    let mut attributes = json!({ "POSITION": glb.push_attribute(positions, true) });
    if let Some(normals) = normals {
        attributes["NORMAL"] = glb.push_attribute(normals, false).into();
    }
    if let Some(tangents) = tangents {
        attributes["TANGENT"] = glb.push_attribute(tangents, false).into();
    }
    let mut primitive = json!({ "attributes": attributes });
    if corners.is_empty() {
        primitive["mode"] = 0.into();
    } else {
        primitive["indices"] = glb.push_indices(corners).into();
    }
    glb.root["meshes"] = json!([{ "name": name, "primitives": [primitive] }]);
    glb.finish()
}
