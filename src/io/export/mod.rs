//! Writes deformed meshes to GLB files.
//!
//! [`deformed_glb`] rewrites a glTF: it replaces the vertices of one mesh and keeps everything else. [`mesh_glb`]
//! writes a new file, for instance for a mesh from an OBJ file.
//!
//! ```
//! use crumple::export::deformed_glb;
//! use crumple::import::{MeshChoice, gltf_slice};
//! # let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/two_materials.glb");
//! # let source = std::fs::read(path).unwrap();
//! let imported = gltf_slice(&source, None, MeshChoice::First)?;
//! let lifted: Vec<[f32; 3]> = imported.mesh.positions.iter().map(|[x, y, z]| [*x, y + 1.0, *z]).collect();
//! let normals = imported.mesh.normals.as_deref();
//! let glb = deformed_glb(&source, None, MeshChoice::First, &lifted, normals, None)?;
//! assert!(glb.starts_with(b"glTF"));
//! # Ok::<(), crumple::Error>(())
//! ```

use crate::base::error::Error;
use crate::io::import::{Imported, MeshChoice};
use std::path::Path;
use vertices::Vertices;

mod compact;
mod fresh;
mod glb;
mod rewrite;
mod vertices;

/// Rewrites a glTF (`.glb` or `.gltf`) with a mesh's deformed vertices. Returns a GLB that needs no other file.
///
/// `positions` (m), unit `normals` and `tangents` (xyz unit, w +1 or -1) are in the order of the joined vertices that
/// the [import](crate::io::import) of the same mesh gives. Without `normals` or `tangents`, those of the file are kept.
///
/// The mesh's morph targets are removed, with their weights, names, impacts, placements and the animation of their
/// weights. Everything else is kept: node tree, materials, texture coordinates, skins, cameras, other meshes (also
/// those that share data with this one), extras, unknown extensions. Buffers and images in other files are embedded.
/// Data that nothing uses any more is dropped, unless the file uses extensions that this library does not know, since
/// these may refer to it.
///
/// # Errors
/// [`Error::InvalidArgument`] for a wrong number of vertices, [`Error::NotFinite`] for NaN and infinities, the errors
/// of [`gltf_slice`](crate::io::import::gltf_slice) for a file that it cannot read, and [`Error::Io`] for a missing
/// image.
pub fn deformed_glb(
    source: &[u8],
    base_dir: Option<&Path>,
    mesh: MeshChoice<'_>,
    positions: &[[f32; 3]],
    normals: Option<&[[f32; 3]]>,
    tangents: Option<&[[f32; 4]]>,
) -> Result<Vec<u8>, Error> {
    rewrite::deformed(source, base_dir, mesh, |count| Vertices::checked(count, positions, normals, tangents))
}

/// Writes a new GLB with one mesh: the deformed vertices, the triangles, and the texture coordinates if there are any.
///
/// Materials are kept by name only. A mesh without triangles becomes points. The arguments are those of
/// [`deformed_glb`].
///
/// # Errors
/// [`Error::InvalidArgument`] for a wrong number of vertices, [`Error::NotFinite`] for NaN and infinities.
pub fn mesh_glb(
    imported: &Imported,
    positions: &[[f32; 3]],
    normals: Option<&[[f32; 3]]>,
    tangents: Option<&[[f32; 4]]>,
) -> Result<Vec<u8>, Error> {
    let vertices = Vertices::checked(imported.mesh.positions.len(), positions, normals, tangents)?;
    fresh::mesh(imported, vertices)
}
