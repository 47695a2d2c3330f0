//! The primitives of a glTF mesh: their vertices, triangles and morph targets.

use super::accessor::Accessor;
use super::document::Document;
use super::{PrimitiveRange, finite, malformed, unsupported};
use crate::base::error::Error;
use ::gltf::json::accessor::Type;
use ::gltf::json::mesh::{Mode, MorphTarget, Semantic};
use ::gltf::json::validation::Checked;
use ::gltf::json::{self, Index};
use std::collections::HashMap;

/// One primitive that is dented, and its place among the vertices of its mesh. The exporter also uses it, to write vertices back.
pub(crate) struct Primitive<'d> {
    pub index: usize,
    pub json: &'d json::mesh::Primitive,
    pub name: String,
    pub first_vertex: usize,
    pub vertex_count: usize,
    /// False if an earlier primitive has the same accessors and therefore the same vertices.
    pub owns_vertices: bool,
    pub first_triangle: usize,
    pub triangles: Vec<[u32; 3]>,
}

impl Primitive<'_> {
    pub fn attribute(&self, semantic: Semantic) -> Option<Index<json::Accessor>> {
        self.json.attributes.get(&Checked::Valid(semantic)).copied()
    }

    /// The indices of its vertices in its mesh.
    pub fn vertices(&self) -> std::ops::Range<usize> {
        self.first_vertex..self.first_vertex + self.vertex_count
    }

    pub fn material(&self) -> Option<usize> {
        self.json.material.map(|material| material.value())
    }

    /// An attribute with a value for each vertex. `None` if the primitive lacks it.
    pub fn accessor<'d>(
        &self,
        doc: &'d Document<'_>,
        semantic: Semantic,
        kind: Type,
    ) -> Result<Option<Accessor<'d>>, Error> {
        let name = format!("{} {}", self.name, semantic.to_string());
        let Some(index) = self.attribute(semantic) else { return Ok(None) };
        let accessor = Accessor::new(doc, index, &name, kind)?;
        self.same_count(&accessor, &name)?;
        Ok(Some(accessor))
    }

    pub fn positions<'d>(&self, doc: &'d Document<'_>) -> Result<Accessor<'d>, Error> {
        let Some(index) = self.attribute(Semantic::Positions) else {
            return Err(malformed(format!("{} has no POSITION", self.name)));
        };
        let accessor = Accessor::new(doc, index, &format!("{} POSITION", self.name), Type::Vec3)?;
        if !accessor.is_stored() {
            self.not_elsewhere(doc)?;
        }
        Ok(accessor)
    }

    fn same_count(&self, accessor: &Accessor<'_>, name: &str) -> Result<(), Error> {
        if accessor.count == self.vertex_count {
            return Ok(());
        }
        Err(malformed(format!("{name} has {} elements; POSITION has {}", accessor.count, self.vertex_count)))
    }

    /// Refuses a primitive whose data is in an extension.
    fn not_elsewhere(&self, doc: &Document<'_>) -> Result<(), Error> {
        if doc.uses_draco() {
            return Err(unsupported(format!(
                "{} is compressed with Draco, which holds no morph targets; export without it, or compress with meshoptimizer \
                 (gltfpack -c)",
                self.name
            )));
        }
        match doc.unknown_requirements().first() {
            Some(name) => Err(unsupported(format!(
                "{} has no positions of its own, and the file requires {name}, which is not read; export without it",
                self.name
            ))),
            None => Ok(()),
        }
    }

    /// Primitives with equal keys have the same vertices.
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
        let targets = self.json.targets.iter().flatten().map(|t| [value(t.positions), value(t.normals)]);
        (base.to_vec(), targets.collect())
    }

    /// Its place in the joined mesh, whose vertices and triangles of this mesh begin at `first`.
    pub fn range(&self, doc: &Document<'_>, first: (usize, usize)) -> Result<PrimitiveRange, Error> {
        let material = self.material().map(|m| {
            let name = doc.value["materials"][m]["name"].as_str();
            name.map_or_else(|| format!("material {m}"), str::to_owned)
        });
        // Any number of primitives may have one material.
        doc.budget.charge(material.as_ref().map_or(0, String::len), 1, &format!("the material of {}", self.name))?;
        let (vertices, triangles) = (first.0 + self.first_vertex, first.1 + self.first_triangle);
        Ok(PrimitiveRange {
            primitive: self.index as u32,
            vertices: vertices..vertices + self.vertex_count,
            triangles: triangles..triangles + self.triangles.len(),
            material,
        })
    }
}

/// What a target does to vertices of a mesh, by their indices. Zeros are left out.
#[derive(Default)]
pub(crate) struct TargetDeltas {
    pub positions: Vec<(u32, [f32; 3])>,
    /// Of the primitives that have some that can be used.
    pub normals: Vec<(u32, [f32; 3])>,
    /// Whether a primitive that moves has none.
    pub lacks_normals: bool,
    /// Whether some are no numbers.
    pub broken_normals: bool,
}

/// What a target does to the vertices of these primitives. One that lacks the target does not move.
pub(crate) fn deltas(doc: &Document<'_>, primitives: &[Primitive<'_>], target: usize) -> Result<TargetDeltas, Error> {
    let mut out = TargetDeltas::default();
    for primitive in primitives.iter().filter(|p| p.owns_vertices) {
        let Some(json) = primitive.json.targets.as_ref().and_then(|targets| targets.get(target)) else { continue };
        let MorphTarget { positions, normals, .. } = json;
        let read = |index: &Option<Index<json::Accessor>>, label: &str| {
            let Some(index) = index else { return Ok(None) };
            let name = format!("{} target {target} {label}", primitive.name);
            let accessor = Accessor::new(doc, *index, &name, Type::Vec3)?;
            primitive.same_count(&accessor, &name)?;
            Ok::<_, Error>(Some((accessor.nonzero()?, accessor)))
        };
        let of_mesh = |(i, v): (u32, [f32; 3])| (primitive.first_vertex as u32 + i, v);
        let before = (out.positions.len(), out.normals.len());
        if let Some((moved, accessor)) = read(positions, "POSITION")? {
            for (i, v) in &moved {
                finite(*v, || accessor.element_name(*i as usize))?;
            }
            out.positions.extend(moved.into_iter().map(of_mesh));
        }
        if let Some((turned, _)) = read(normals, "NORMAL")? {
            let is_broken = turned.iter().any(|(_, v)| v.iter().any(|x| !x.is_finite()));
            out.broken_normals |= is_broken;
            out.normals.extend(turned.into_iter().filter(|_| !is_broken).map(of_mesh));
        }
        // Exporters that do not compute normals of targets write zeros. A primitive that only shifts has none to change.
        out.lacks_normals |= out.positions.len() > before.0 && out.normals.len() == before.1;
    }
    Ok(out)
}

/// The number of targets of a mesh. Primitives may have fewer, although the specification says otherwise.
pub(crate) fn target_count(mesh: &json::Mesh) -> usize {
    mesh.primitives.iter().map(|p| p.targets.as_ref().map_or(0, Vec::len)).max().unwrap_or(0)
}

/// The triangle primitives of a mesh, placed one after the other. A mesh without triangles is one of points.
pub(crate) fn primitives<'d>(doc: &'d Document<'_>, mesh: usize) -> Result<Vec<Primitive<'d>>, Error> {
    let label = doc.mesh_label(mesh);
    let list = &doc.meshes.get(mesh, "mesh")?.primitives;
    let mode = |(index, primitive): (usize, &'d json::mesh::Primitive)| match primitive.mode {
        Checked::Valid(mode) => Ok((index, primitive, mode)),
        Checked::Invalid => {
            Err(malformed(format!("{label}, primitive {index} has an unknown mode; it must be 0 to 6")))
        }
    };
    let mut chosen = list.iter().enumerate().map(mode).collect::<Result<Vec<_>, Error>>()?;
    let is_surface = |mode: Mode| matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan);
    if chosen.iter().any(|(.., mode)| is_surface(*mode)) {
        chosen.retain(|(.., mode)| is_surface(*mode));
    }
    let mut out: Vec<Primitive<'d>> = Vec::new();
    let mut known = HashMap::new();
    let (mut vertices, mut triangles) = (0, 0);
    for (index, json, mode) in chosen {
        let mut primitive = Primitive {
            index,
            json,
            name: format!("{label}, primitive {index}"),
            first_vertex: vertices,
            vertex_count: 0,
            owns_vertices: true,
            first_triangle: triangles,
            triangles: Vec::new(),
        };
        primitive.vertex_count = primitive.positions(doc)?.count;
        primitive.first_vertex = *known.entry(primitive.key()).or_insert(vertices);
        primitive.owns_vertices = primitive.first_vertex == vertices;
        if primitive.owns_vertices {
            vertices += primitive.vertex_count;
        }
        if vertices > u32::MAX as usize {
            return Err(malformed(format!("{label} has over {} vertices, more than 32-bit indices reach", u32::MAX)));
        }
        if is_surface(mode) {
            primitive.triangles = self::triangles(doc, &primitive, mode)?;
        }
        triangles += primitive.triangles.len();
        out.push(primitive);
    }
    if out.is_empty() {
        return Err(malformed(format!("{label} has no primitives")));
    }
    Ok(out)
}

/// The triangles of a primitive, as indices of its mesh's vertices.
fn triangles(doc: &Document<'_>, primitive: &Primitive<'_>, mode: Mode) -> Result<Vec<[u32; 3]>, Error> {
    let name = &primitive.name;
    let corners: Vec<u32> = match primitive.json.indices {
        Some(index) => {
            let accessor = Accessor::of_indices(doc, index, &format!("{name} indices"))?;
            accessor.indices(primitive.vertex_count)?
        }
        None => {
            doc.budget.charge(primitive.vertex_count, 4, name)?;
            (0..primitive.vertex_count as u32).collect()
        }
    };
    let count = corners.len();
    if count < 3 || (mode == Mode::Triangles && !count.is_multiple_of(3)) {
        let right = if mode == Mode::Triangles { "a multiple of 3" } else { "at least 3" };
        return Err(malformed(format!("{name} has {count} triangle corners; there must be {right}")));
    }
    let first = primitive.first_vertex as u32;
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
