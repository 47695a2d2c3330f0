//! Reads a mesh or a body of a glTF file, and its morph targets as examples.

use super::body::{self, meshes};
use super::document::Document;
use super::nodes::Nodes;
use super::primitives::primitives;
use super::reading::{MeshChoice, Reading};
use super::surface::Surface;
use super::{Imported, uri};
use crate::base::error::Error;
use crate::mesh::data::MeshData;
use crate::mesh::keep_out::Solid;
use glam::{Mat4, Vec3};
use std::path::Path;

/// Reads a mesh, or a body of the meshes of nodes, with its morph targets from a `.gltf` or `.glb` file. The [module](super)
/// describes what is read.
///
/// ```
/// use crumple::import::{MeshChoice, gltf_file};
/// # let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
/// let imported = gltf_file(&folder.join("tests/fixtures/two_materials.glb"), MeshChoice::First)?;
/// assert_eq!(imported.primitives.len(), 2);
/// for example in &imported.examples {
///     println!("{} was hit at {:?}", example.name, example.contact);
/// }
/// # Ok::<(), crumple::Error>(())
/// ```
///
/// # Errors
/// [`Error::Io`] if the file or one of its buffers cannot be read; [`Error::Unsupported`] for Draco's compression and other
/// versions; [`Error::NoSuchMesh`] and [`Error::NoExamples`], which list what the file has; [`Error::InvalidArgument`] for a pattern
/// that matches nothing; [`Error::Format`], [`Error::IndexOutOfRange`] and [`Error::NotFinite`], which name what is wrong in the
/// file.
pub fn gltf_file<'a>(path: &Path, reading: impl Into<Reading<'a>>) -> Result<Imported, Error> {
    let reading = reading.into();
    let imported = gltf_slice(&uri::read(path, None)?, path.parent(), &reading)?;
    Ok(match reading.mesh {
        MeshChoice::Nodes(_) => {
            Imported { name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), ..imported }
        }
        _ => imported,
    })
}

/// Reads the same from memory. Relative paths of external buffers start at `base_dir`; without it they are an error. A body of
/// nodes has no name.
///
/// # Errors
/// As [`gltf_file`].
pub fn gltf_slice<'a>(
    bytes: &[u8],
    base_dir: Option<&Path>,
    reading: impl Into<Reading<'a>>,
) -> Result<Imported, Error> {
    Ok(body::read(&Document::parse(bytes, base_dir)?, &reading.into())?.imported)
}

/// Reads every mesh of a glTF file as a solid in the space of a body's mesh. `body` is the [`Imported::node_transform`] of the
/// body, whose file shares its scene with this one: each solid is taken to where the lowest-numbered node that shows it
/// places it, and from there into the body's space. Relative paths of external buffers start at `base_dir`; without it they
/// are an error.
///
/// # Errors
/// Those of [`gltf_file`]; [`Error::NoSuchMesh`] for a file without meshes; [`Error::InvalidArgument`] for a `body` that has no
/// inverse.
pub fn gltf_solids(bytes: &[u8], base_dir: Option<&Path>, body: Option<[[f32; 4]; 4]>) -> Result<Vec<Solid>, Error> {
    let body = body.map_or(Mat4::IDENTITY, |columns| Mat4::from_cols_array_2d(&columns));
    let into_body = body.inverse();
    if !into_body.is_finite() {
        return Err(Error::invalid("the body's node transform", body, "a matrix with an inverse"));
    }
    let doc = Document::parse(bytes, base_dir)?;
    if doc.meshes.len() == 0 {
        return Err(Error::NoSuchMesh { wanted: "a solid".into(), available: meshes(&doc, Vec::new()) });
    }
    let nodes = Nodes::of(&doc)?;
    let solid = |mesh| {
        let surface = Surface::read(&doc, &primitives(&doc, mesh)?, &mut Vec::new())?;
        let MeshData { mut positions, triangles, .. } = surface.data;
        let placed =
            nodes.transform_of_mesh(mesh)?.map_or(Mat4::IDENTITY, |columns| Mat4::from_cols_array_2d(&columns));
        let to_body = into_body * placed;
        for p in positions.iter_mut().filter(|_| to_body != Mat4::IDENTITY) {
            *p = to_body.transform_point3(Vec3::from(*p)).to_array();
        }
        Ok(Solid::Mesh { positions, triangles })
    };
    (0..doc.meshes.len()).map(solid).collect()
}
