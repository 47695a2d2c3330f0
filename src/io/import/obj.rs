//! Reads a base OBJ and example OBJs as one base mesh and its examples.

use super::{Imported, PrimitiveRange, finite, malformed};
use crate::base::error::Error;
use crate::example::data::{Deltas, ExampleData};
use crate::mesh::data::MeshData;
use ::obj::{IndexTuple, ObjData, ObjError, SimplePolygon};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Reads a base OBJ and one OBJ per example.
///
/// The base's vertices are the distinct (position, texture coordinate, normal) triples of its face corners, in the
/// order in which the faces first use them. Polygons become fans of triangles. Without faces, the vertices are the `v`
/// lines in order. An example must have as many `v` lines as the base, and either the same faces in the same order or
/// none. Only its positions are read. Its name is its file's stem. Materials, groups and lines are not read.
///
/// ```
/// use crumple::import::obj_files;
/// # let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures");
/// let imported = obj_files(&folder.join("plate.obj"), &[folder.join("plate_dent.obj")])?;
/// assert_eq!(imported.examples[0].name, "plate_dent");
/// # Ok::<(), crumple::Error>(())
/// ```
///
/// # Errors
/// [`Error::Io`] if a file cannot be read; [`Error::Format`], [`Error::IndexOutOfRange`] and [`Error::NotFinite`] if it
/// is malformed; [`Error::ExampleMismatch`] if an example does not fit the base; [`Error::NoExamples`] if the list is
/// empty.
pub fn obj_files(base: &Path, examples: &[PathBuf]) -> Result<Imported, Error> {
    let load = |path: &Path| {
        let bytes =
            std::fs::read(path).map_err(|e| Error::Io { path: path.display().to_string(), message: e.to_string() })?;
        Ok((path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), bytes))
    };
    let base = load(base)?;
    // Only one example at a time is in memory.
    let mut builder = Builder::new(&base.0, &base.1)?;
    for path in examples {
        let (name, bytes) = load(path)?;
        builder.add(&name, &bytes)?;
    }
    builder.finish()
}

/// Reads the same from memory: (name, bytes) of the base and of each example.
///
/// # Errors
/// As [`obj_files`].
pub fn obj_slices(base: (&str, &[u8]), examples: &[(&str, &[u8])]) -> Result<Imported, Error> {
    let mut builder = Builder::new(base.0, base.1)?;
    for (name, bytes) in examples {
        builder.add(name, bytes)?;
    }
    builder.finish()
}

struct Builder {
    base: Parsed,
    /// The `v` line of each vertex.
    sources: Vec<u32>,
    imported: Imported,
}

impl Builder {
    fn new(name: &str, bytes: &[u8]) -> Result<Self, Error> {
        let base = Parsed::new(name, bytes)?;
        let (sources, imported) = unified(&base)?;
        Ok(Self { base, sources, imported })
    }

    fn add(&mut self, name: &str, bytes: &[u8]) -> Result<(), Error> {
        let example = Parsed::new(name, bytes)?;
        let (ours, theirs) = (&self.base.data.position, &example.data.position);
        let mismatch = |what| Error::ExampleMismatch { index: self.imported.examples.len(), name: name.into(), what };
        if ours.len() != theirs.len() {
            return Err(mismatch(format!("it has {} vertices (v lines); the base has {}", theirs.len(), ours.len())));
        }
        same_faces(&self.base.faces, &example.faces).map_err(mismatch)?;
        let (mut indices, mut values) = (Vec::new(), Vec::new());
        for (vertex, source) in (0..).zip(&self.sources) {
            let (a, b) = (ours[*source as usize], theirs[*source as usize]);
            let delta = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
            if delta != [0.0; 3] {
                indices.push(vertex);
                values.push(finite(delta, || format!("{name}: displacement of v line {}", source + 1))?);
            }
        }
        self.imported.examples.push(ExampleData::new(name, Deltas::Sparse { indices, values }));
        Ok(())
    }

    fn finish(self) -> Result<Imported, Error> {
        if self.imported.examples.is_empty() {
            return Err(Error::NoExamples {
                what: format!("'{}' came without example files; give at least one", self.base.name),
            });
        }
        Ok(self.imported)
    }
}

struct Parsed {
    name: String,
    data: ObjData,
    faces: Vec<SimplePolygon>,
}

impl Parsed {
    fn new(name: &str, bytes: &[u8]) -> Result<Self, Error> {
        let mut data = ObjData::load_buf(geometry_lines(bytes).as_bytes()).map_err(|e| describe(name, &e))?;
        if data.position.is_empty() {
            return Err(malformed(format!("{name}: no v lines; this is not an OBJ file with vertices")));
        }
        for (i, v) in data.position.iter().enumerate() {
            finite(*v, || format!("{name}: v line {}", i + 1))?;
        }
        for (i, v) in data.normal.iter().enumerate() {
            finite(*v, || format!("{name}: vn line {}", i + 1))?;
        }
        for (i, v) in data.texture.iter().enumerate() {
            finite(*v, || format!("{name}: vt line {}", i + 1))?;
        }
        let faces: Vec<_> = data.objects.drain(..).flat_map(|o| o.groups).flat_map(|g| g.polys).collect();
        let check = |what: &str, face: usize, index: usize, len: usize| match index < len {
            true => Ok(()),
            // The crate wraps an index that refers to before the first line; the error shows it as written.
            false => {
                let shown = if index > isize::MAX as usize { index as isize } else { index as isize + 1 };
                Err(malformed(format!("{name}: face {} uses {what} {shown}; there are {len}", face + 1)))
            }
        };
        for (f, face) in faces.iter().enumerate() {
            if face.0.len() < 3 {
                return Err(malformed(format!(
                    "{name}: face {} has {} corners; it must have at least 3",
                    f + 1,
                    face.0.len()
                )));
            }
            for IndexTuple(v, vt, vn) in &face.0 {
                check("v", f, *v, data.position.len())?;
                vt.map_or(Ok(()), |vt| check("vt", f, vt, data.texture.len()))?;
                vn.map_or(Ok(()), |vn| check("vn", f, vn, data.normal.len()))?;
            }
        }
        Ok(Self { name: name.into(), data, faces })
    }
}

/// The lines that define geometry, with words one space apart, continued lines joined and line numbers kept. The rest
/// (names, materials, comments, vendors' commands) may hold text that the crate's parser fails on.
fn geometry_lines(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let mut out = String::with_capacity(text.len());
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let mut words: Vec<&str> = line.split_whitespace().collect();
        let mut extra_lines = 0;
        while words.last().is_some_and(|w| w.ends_with('\\')) && matches!(words[0], "v" | "vt" | "vn" | "f") {
            let last = words.pop().unwrap_or_default().trim_end_matches('\\');
            words.extend((!last.is_empty()).then_some(last));
            words.extend(lines.next().into_iter().flat_map(str::split_whitespace));
            extra_lines += 1;
        }
        if let Some("v" | "vt" | "vn" | "f") = words.first().copied() {
            if words[0] == "vt" && words.len() == 2 {
                words.push("0");
            }
            for word in &words {
                out.push_str(word);
                out.push(' ');
            }
        }
        out.extend(std::iter::repeat_n('\n', 1 + extra_lines));
    }
    out
}

fn describe(name: &str, error: &ObjError) -> Error {
    // The crate counts lines from 0.
    malformed(match error {
        ObjError::MalformedFaceGroup { line_number, group } => {
            format!(
                "{name}: line {}: '{group}' is no face corner; it must be v, v/vt, v//vn or v/vt/vn",
                line_number + 1
            )
        }
        ObjError::ArgumentListFailure { line_number, list } => {
            format!("{name}: line {}: numbers are missing or unreadable: {list}", line_number + 1)
        }
        ObjError::ZeroVertexNumber { line_number } => {
            format!("{name}: line {}: a face uses v 0; indices start at 1", line_number + 1)
        }
        other => format!("{name}: {other}"),
    })
}

fn same_faces(base: &[SimplePolygon], example: &[SimplePolygon]) -> Result<(), String> {
    if example.is_empty() {
        return Ok(());
    }
    let corners = |face: &SimplePolygon| face.0.iter().map(|c| c.0 + 1).collect::<Vec<_>>();
    for (f, (ours, theirs)) in base.iter().zip(example).enumerate() {
        if !ours.0.iter().map(|c| c.0).eq(theirs.0.iter().map(|c| c.0)) {
            return Err(format!(
                "face {} has the corners {:?}; in the base it has {:?} (was the mesh reordered?)",
                f + 1,
                corners(theirs),
                corners(ours)
            ));
        }
    }
    if base.len() != example.len() {
        return Err(format!("it has {} faces; the base has {}", example.len(), base.len()));
    }
    Ok(())
}

fn unified(base: &Parsed) -> Result<(Vec<u32>, Imported), Error> {
    let data = &base.data;
    let too_many = || malformed(format!("{}: over {} vertices, more than 32-bit indices reach", base.name, u32::MAX));
    u32::try_from(data.position.len()).map_err(|_| too_many())?;
    let mut corners: Vec<IndexTuple> = Vec::new();
    let mut triangles = Vec::new();
    let mut known = HashMap::new();
    for face in &base.faces {
        let mut unify = |corner: &IndexTuple| {
            let index = *known.entry(*corner).or_insert_with(|| {
                corners.push(*corner);
                corners.len() - 1
            });
            u32::try_from(index).map_err(|_| too_many())
        };
        let face = face.0.iter().map(&mut unify).collect::<Result<Vec<u32>, Error>>()?;
        triangles.extend((1..face.len() - 1).map(|i| [face[0], face[i], face[i + 1]]));
    }
    if base.faces.is_empty() {
        corners = (0..data.position.len()).map(|v| IndexTuple(v, None, None)).collect();
    }
    let normals: Option<Vec<_>> = corners.iter().map(|c| c.2.map(|n| data.normal[n])).collect();
    // In OBJ v grows upwards from the lower edge, in glTF downwards from the upper edge.
    let texcoords: Option<Vec<_>> =
        corners.iter().map(|c| c.1.map(|t| [data.texture[t][0], 1.0 - data.texture[t][1]])).collect();
    let primitive = PrimitiveRange {
        primitive: 0,
        first_vertex: 0,
        vertex_count: corners.len() as u32,
        first_triangle: 0,
        triangle_count: u32::try_from(triangles.len()).map_err(|_| too_many())?,
        material: None,
    };
    let positions = corners.iter().map(|c| data.position[c.0]).collect();
    let sources = corners.iter().map(|c| c.0 as u32).collect();
    let imported = Imported {
        name: base.name.clone(),
        mesh: MeshData { positions, normals, triangles, ..MeshData::default() },
        texcoords,
        examples: Vec::new(),
        primitives: vec![primitive],
        parts: Vec::new(),
        node_transform: None,
    };
    Ok((sources, imported))
}
