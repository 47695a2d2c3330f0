//! Reads a glTF mesh and its morph targets as one base mesh and its examples.

use super::accessor::Accessor;
use super::document::Document;
use super::nodes::Nodes;
use super::{Imported, MeshChoice, PrimitiveRange, extras, malformed, unsupported, uri};
use crate::base::error::Error;
use crate::example::data::{Deltas, ExampleData};
use crate::mesh::data::MeshData;
use crate::mesh::keep_out::Solid;
use ::gltf::json::accessor::Type;
use ::gltf::json::mesh::{Mode, MorphTarget, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use ::gltf::json::{self, Index};
use glam::{Mat4, Vec3};
use std::path::Path;

/// Reads a mesh and its morph targets from a `.gltf` or `.glb` file. The [module](super) describes what is read.
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
/// [`Error::Io`] if the file or one of its buffers cannot be read; [`Error::Unsupported`] for compressed or quantised
/// geometry, other required extensions and other versions; [`Error::NoSuchMesh`] and [`Error::NoExamples`], which list
/// what the file has; [`Error::Format`], [`Error::IndexOutOfRange`] and [`Error::NotFinite`], which name what is wrong
/// in the file.
pub fn gltf_file(path: &Path, mesh: MeshChoice<'_>) -> Result<Imported, Error> {
    gltf_slice(&uri::read(path, None)?, path.parent(), mesh)
}

/// Reads the same from memory. Relative paths of external buffers start at `base_dir`; without it they are an error.
///
/// # Errors
/// As [`gltf_file`].
pub fn gltf_slice(bytes: &[u8], base_dir: Option<&Path>, mesh: MeshChoice<'_>) -> Result<Imported, Error> {
    let doc = Document::parse(bytes, base_dir)?;
    let mesh = choose(&doc, mesh)?;
    let targets = target_count(&doc, mesh)?;
    if targets == 0 {
        let what = format!("{} has no morph targets; {}", doc.mesh_label(mesh), with_targets(&doc));
        return Err(Error::NoExamples { what });
    }
    let parts = parts(&doc, mesh)?;
    let base = base(&doc, &parts)?;
    let value = &doc.value["meshes"][mesh];
    let names = extras::names(value, targets)?;
    let impacts = extras::impacts(value, &names, base.positions.len())?;
    let placements = extras::placements(value, &names)?;
    let mut examples = Vec::with_capacity(targets);
    for (i, ((name, impact), placement)) in names.into_iter().zip(impacts).zip(placements).enumerate() {
        let extras::Impact { contact, normal: contact_normal, blow } = impact;
        let (positions, normals) = deltas(&doc, &parts, i)?;
        examples.push(ExampleData { name, positions, normals, contact, contact_normal, blow, placement });
    }
    Ok(Imported {
        name: doc.root.meshes[mesh].name.clone().unwrap_or_default(),
        primitives: parts.iter().map(|p| range(&doc, p)).collect::<Result<_, _>>()?,
        node_transform: Nodes::of(&doc).transform_of_mesh(mesh)?,
        texcoords: None,
        mesh: base,
        examples,
        parts: Vec::new(),
    })
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
    if doc.root.meshes.is_empty() {
        return Err(Error::NoSuchMesh { wanted: "a solid".into(), available: all_meshes(&doc) });
    }
    let nodes = Nodes::of(&doc);
    let solid = |mesh| {
        let MeshData { mut positions, triangles, .. } = base(&doc, &parts(&doc, mesh)?)?;
        let placed =
            nodes.transform_of_mesh(mesh)?.map_or(Mat4::IDENTITY, |columns| Mat4::from_cols_array_2d(&columns));
        let to_body = into_body * placed;
        for p in positions.iter_mut().filter(|_| to_body != Mat4::IDENTITY) {
            *p = to_body.transform_point3(Vec3::from(*p)).to_array();
        }
        Ok(Solid::Mesh { positions, triangles })
    };
    (0..doc.root.meshes.len()).map(solid).collect()
}

/// One triangle primitive and its place in the joined mesh. The exporter also uses it, to write vertices back.
pub(crate) struct Part<'d> {
    pub index: usize,
    pub primitive: &'d Primitive,
    name: String,
    pub first_vertex: usize,
    pub vertex_count: usize,
    /// False if an earlier part has the same accessors and therefore the same vertices.
    pub owns_vertices: bool,
    first_triangle: usize,
    triangles: Vec<[u32; 3]>,
}

impl Part<'_> {
    pub fn attribute(&self, semantic: Semantic) -> Option<Index<json::Accessor>> {
        self.primitive.attributes.get(&Checked::Valid(semantic)).copied()
    }

    /// Parts with equal keys have the same vertices.
    fn key(&self) -> (Vec<Option<usize>>, Vec<[Option<usize>; 2]>) {
        let value = |i: Option<Index<json::Accessor>>| i.map(|i| i.value());
        let base = [
            Semantic::Positions,
            Semantic::Normals,
            Semantic::Tangents,
            Semantic::Extras("DEPTH_LIMIT".into()),
            Semantic::Extras("STIFFNESS".into()),
        ]
        .map(|s| value(self.attribute(s)));
        let targets = self.primitive.targets.iter().flatten().map(|t| [value(t.positions), value(t.normals)]);
        (base.to_vec(), targets.collect())
    }
}

/// The index of the chosen mesh.
pub(crate) fn choose(doc: &Document<'_>, choice: MeshChoice<'_>) -> Result<usize, Error> {
    let meshes = &doc.root.meshes;
    let (found, wanted) = match choice {
        MeshChoice::First => {
            let found = (0..meshes.len())
                .find(|m| meshes[*m].primitives.iter().any(|p| p.targets.iter().flatten().next().is_some()));
            return found.ok_or_else(|| Error::NoExamples { what: with_targets(doc) });
        }
        MeshChoice::Index(i) => ((i < meshes.len()).then_some(i), i.to_string()),
        MeshChoice::Name(name) => (meshes.iter().position(|m| m.name.as_deref() == Some(name)), format!("'{name}'")),
    };
    found.ok_or_else(|| Error::NoSuchMesh { wanted, available: all_meshes(doc) })
}

fn all_meshes(doc: &Document<'_>) -> String {
    match doc.root.meshes.len() {
        0 => "no meshes".into(),
        n => (0..n).map(|m| doc.mesh_label(m)).collect::<Vec<_>>().join(", "),
    }
}

fn with_targets(doc: &Document<'_>) -> String {
    let has =
        |m: &usize| doc.root.meshes[*m].primitives.iter().any(|p| p.targets.as_ref().is_some_and(|t| !t.is_empty()));
    let some: Vec<String> = (0..doc.root.meshes.len()).filter(has).map(|m| doc.mesh_label(m)).collect();
    if some.is_empty() {
        return format!("no mesh of the file has morph targets (it has {})", all_meshes(doc));
    }
    format!("the file's meshes with morph targets are {}", some.join(", "))
}

/// The number of targets, on which all primitives of a mesh must agree.
pub(super) fn target_count(doc: &Document<'_>, mesh: usize) -> Result<usize, Error> {
    let count = |p: &Primitive| p.targets.as_ref().map_or(0, Vec::len);
    let primitives = &doc.root.meshes[mesh].primitives;
    let first = primitives.first().map_or(0, count);
    match primitives.iter().position(|p| count(p) != first) {
        None => Ok(first),
        Some(i) => Err(malformed(format!(
            "{}: primitive 0 has {first} morph targets and primitive {i} has {}; all must have as many",
            doc.mesh_label(mesh),
            count(&primitives[i])
        ))),
    }
}

/// The triangle primitives of a mesh, placed one after the other.
pub(crate) fn parts<'d>(doc: &'d Document<'_>, mesh: usize) -> Result<Vec<Part<'d>>, Error> {
    let mut parts: Vec<Part<'d>> = Vec::new();
    let mut known = std::collections::HashMap::new();
    let (mut vertices, mut triangles) = (0, 0);
    for (index, primitive) in doc.root.meshes[mesh].primitives.iter().enumerate() {
        let name = format!("{}, primitive {index}", doc.mesh_label(mesh));
        let Checked::Valid(mode) = primitive.mode else {
            return Err(malformed(format!("{name} has an unknown mode; it must be 0 to 6")));
        };
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            continue;
        }
        let mut part = Part {
            index,
            primitive,
            name,
            first_vertex: vertices,
            vertex_count: 0,
            owns_vertices: true,
            first_triangle: triangles,
            triangles: Vec::new(),
        };
        part.vertex_count = positions(doc, &part)?.count;
        part.first_vertex = *known.entry(part.key()).or_insert(vertices);
        part.owns_vertices = part.first_vertex == vertices;
        if part.owns_vertices {
            vertices += part.vertex_count;
        }
        if vertices > u32::MAX as usize {
            return Err(malformed(format!(
                "{} has over {} vertices, more than 32-bit indices reach",
                doc.mesh_label(mesh),
                u32::MAX
            )));
        }
        part.triangles = self::triangles(doc, &part, mode)?;
        triangles += part.triangles.len();
        parts.push(part);
    }
    if parts.is_empty() {
        return Err(unsupported(format!(
            "{} has no triangles; primitives of points and lines are not dented",
            doc.mesh_label(mesh)
        )));
    }
    Ok(parts)
}

fn positions<'d>(doc: &'d Document<'_>, part: &Part<'_>) -> Result<Accessor<'d>, Error> {
    let Some(index) = part.attribute(Semantic::Positions) else {
        return Err(malformed(format!("{} has no POSITION", part.name)));
    };
    Accessor::new(doc, index, &format!("{} POSITION", part.name), Type::Vec3)
}

/// The triangles of a part, as indices of joined vertices.
fn triangles(doc: &Document<'_>, part: &Part<'_>, mode: Mode) -> Result<Vec<[u32; 3]>, Error> {
    let corners: Vec<u32> = match part.primitive.indices {
        Some(index) => {
            Accessor::new(doc, index, &format!("{} indices", part.name), Type::Scalar)?.indices(part.vertex_count)?
        }
        None => {
            doc.budget.charge(part.vertex_count, 4, &part.name)?;
            (0..part.vertex_count as u32).collect()
        }
    };
    let count = corners.len();
    if count < 3 || (mode == Mode::Triangles && !count.is_multiple_of(3)) {
        let right = if mode == Mode::Triangles { "a multiple of 3" } else { "at least 3" };
        return Err(malformed(format!("{} has {count} triangle corners; there must be {right}", part.name)));
    }
    let first = part.first_vertex as u32;
    let joined = |t: [u32; 3]| t.map(|i| i + first);
    let c = &corners;
    // The vertex orders of the glTF 2.0 specification, 3.7.2.1.
    Ok(match mode {
        Mode::TriangleStrip => (0..count - 2)
            .map(|i| [c[i], c[i + 1 + i % 2], c[i + 2 - i % 2]])
            // Strips repeat a vertex to jump to another place.
            .filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
            .map(joined)
            .collect(),
        Mode::TriangleFan => (0..count - 2).map(|i| joined([c[i + 1], c[i + 2], c[0]])).collect(),
        _ => c.as_chunks::<3>().0.iter().copied().map(joined).collect(),
    })
}

pub(super) fn base(doc: &Document<'_>, parts: &[Part<'_>]) -> Result<MeshData, Error> {
    let mut positions = Vec::new();
    for part in parts.iter().filter(|p| p.owns_vertices) {
        positions.extend(self::positions(doc, part)?.floats::<3>()?);
    }
    Ok(MeshData {
        positions,
        normals: attribute::<3>(doc, parts, Semantic::Normals, "NORMAL", Type::Vec3)?,
        tangents: attribute::<4>(doc, parts, Semantic::Tangents, "TANGENT", Type::Vec4)?,
        triangles: parts.iter().flat_map(|p| p.triangles.iter().copied()).collect(),
        depth_limits: custom(doc, parts, "DEPTH_LIMIT")?,
        stiffness: custom(doc, parts, "STIFFNESS")?,
    })
}

/// A custom attribute with one number a vertex, whose name in the file begins with `_`.
fn custom(doc: &Document<'_>, parts: &[Part<'_>], name: &str) -> Result<Option<Vec<f32>>, Error> {
    let mut values = Vec::new();
    for part in parts.iter().filter(|p| p.owns_vertices) {
        let Some(index) = part.attribute(Semantic::Extras(name.into())) else { return Ok(None) };
        let name = format!("{} _{name}", part.name);
        let accessor = Accessor::of_numbers(doc, index, &name)?;
        same_count(&accessor, part, &name)?;
        values.extend(accessor.scalars()?);
    }
    Ok(Some(values))
}

/// An attribute of all vertices; `None` if a part lacks it.
fn attribute<const N: usize>(
    doc: &Document<'_>,
    parts: &[Part<'_>],
    semantic: Semantic,
    label: &str,
    kind: Type,
) -> Result<Option<Vec<[f32; N]>>, Error>
where
    [f32; N]: ::gltf::accessor::Item,
{
    let mut values = Vec::new();
    for part in parts.iter().filter(|p| p.owns_vertices) {
        let Some(index) = part.attribute(semantic.clone()) else { return Ok(None) };
        let name = format!("{} {label}", part.name);
        let accessor = Accessor::new(doc, index, &name, kind)?;
        same_count(&accessor, part, &name)?;
        values.extend(accessor.floats::<N>()?);
    }
    Ok(Some(values))
}

/// The displacements and normal deltas of one target. There are normal deltas only if each part that moves has them.
pub(super) fn deltas(doc: &Document<'_>, parts: &[Part<'_>], target: usize) -> Result<(Deltas, Option<Deltas>), Error> {
    let mut positions = (Vec::new(), Vec::new());
    let mut normals = Some((Vec::new(), Vec::new()));
    for part in parts.iter().filter(|p| p.owns_vertices) {
        let Some(morph) = part.primitive.targets.as_ref().and_then(|t| t.get(target)) else {
            return Err(malformed(format!("{} has no target {target}", part.name)));
        };
        let MorphTarget { positions: p, normals: n, .. } = morph;
        normals = normals.filter(|_| n.is_some() || p.is_none());
        append(doc, part, *p, &format!("target {target} POSITION"), &mut positions)?;
        if let Some(normals) = &mut normals {
            append(doc, part, *n, &format!("target {target} NORMAL"), normals)?;
        }
    }
    let any_normals =
        parts.iter().filter_map(|p| p.primitive.targets.as_ref()?.get(target)).any(|t| t.normals.is_some());
    let sparse = |(indices, values)| Deltas::Sparse { indices, values };
    Ok((sparse(positions), normals.filter(|_| any_normals).map(sparse)))
}

fn append(
    doc: &Document<'_>,
    part: &Part<'_>,
    index: Option<Index<json::Accessor>>,
    label: &str,
    out: &mut (Vec<u32>, Vec<[f32; 3]>),
) -> Result<(), Error> {
    let Some(index) = index else { return Ok(()) };
    let name = format!("{} {label}", part.name);
    let accessor = Accessor::new(doc, index, &name, Type::Vec3)?;
    same_count(&accessor, part, &name)?;
    let (indices, values) = accessor.nonzero()?;
    out.0.extend(indices.into_iter().map(|i| i + part.first_vertex as u32));
    out.1.extend(values);
    Ok(())
}

fn same_count(accessor: &Accessor<'_>, part: &Part<'_>, name: &str) -> Result<(), Error> {
    if accessor.count == part.vertex_count {
        return Ok(());
    }
    Err(malformed(format!("{name} has {} elements; POSITION has {}", accessor.count, part.vertex_count)))
}

pub(super) fn range(doc: &Document<'_>, part: &Part<'_>) -> Result<PrimitiveRange, Error> {
    let material = part.primitive.material.map(|m| {
        let name = doc.value["materials"][m.value()]["name"].as_str();
        name.map_or_else(|| format!("material {}", m.value()), str::to_owned)
    });
    // Any number of primitives may have one material.
    doc.budget.charge(material.as_ref().map_or(0, String::len), 1, &format!("the material of {}", part.name))?;
    Ok(PrimitiveRange {
        primitive: part.index as u32,
        first_vertex: part.first_vertex as u32,
        vertex_count: part.vertex_count as u32,
        first_triangle: part.first_triangle as u32,
        triangle_count: part.triangles.len() as u32,
        material,
    })
}
