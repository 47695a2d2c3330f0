//! Makes a glTF of a base OBJ and example OBJs, so that everything else reads and writes glTF only.

use super::body::gltf_slice;
use super::obj_text::{Corner, Face, ObjText};
use super::reading::{MeshChoice, Patterns};
use super::surface::smooth;
use super::words::quoted;
use super::{Imported, finite, mtl, uri};
use crate::base::error::Error;
use crate::io::glb::{Glb, GlbFile, new_root, set_bounds};
use bytemuck::cast_slice;
use glam::Vec3;
use indexmap::{IndexMap, IndexSet};
use serde_json::{Value, json};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// Reads a base OBJ and one OBJ per example as one body without parts; see [`obj_glb`].
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
/// As [`obj_glb`].
pub fn obj_files(base: &Path, examples: &[PathBuf]) -> Result<Imported, Error> {
    let imported = read(obj_glb(base, examples)?)?;
    Ok(Imported { name: stem(base), ..imported })
}

/// Reads the same from memory: (name, bytes) of the base and of each example. Materials have their names only.
///
/// # Errors
/// As [`obj_glb`].
pub fn obj_slices(base: (&str, &[u8]), examples: &[(&str, &[u8])]) -> Result<Imported, Error> {
    let mut builder = Builder::new(base.0, base.1)?;
    for (name, bytes) in examples {
        builder.add(name, bytes)?;
    }
    let imported = read(builder.finish(None)?)?;
    Ok(Imported { name: base.0.to_owned(), ..imported })
}

fn read(converted: GlbFile) -> Result<Imported, Error> {
    let imported = gltf_slice(&converted.glb, None, MeshChoice::Nodes(Patterns::default()))?;
    Ok(Imported { notes: [converted.notes, imported.notes].concat(), parts: Vec::new(), ..imported })
}

/// Makes a GLB of a base OBJ and one OBJ per example: the examples are its morph targets.
///
/// Each object, and each group of an object that has several, is a node; faces of one material are a primitive. The vertices of a
/// primitive are the distinct (position, texture coordinate, normal) triples of its face corners, in the order in which its faces
/// first use them. Polygons become triangles: fans where they are convex, else by ear clipping. Without faces, the vertices are the
/// `v` lines in order. Colours after positions become `COLOR_0`. Materials come from the MTL files that the OBJ names, if they lie
/// in its folder or below; images stay in other files, relative to the OBJ. Without `vn` lines there are normals only for faces of a smoothing group; glTF shows the others flat.
///
/// An example must have as many `v` lines as the base, in the same order. Only its positions are read. Its name is its file's stem.
///
/// # Errors
/// [`Error::Io`] if an OBJ cannot be read; [`Error::Format`] and [`Error::NotFinite`], which name the line, if it is malformed;
/// [`Error::ExampleMismatch`] if an example does not fit the base; [`Error::NoExamples`] if the list is empty.
pub fn obj_glb(base: &Path, examples: &[PathBuf]) -> Result<GlbFile, Error> {
    let mut builder = Builder::new(&stem(base), &uri::read(base, None)?)?;
    for path in examples {
        builder.add(&stem(path), &uri::read(path, None)?)?;
    }
    builder.finish(Some(base.parent().unwrap_or(Path::new(""))))
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// The displacements of one example: each moved `v` line, from 0.
struct Example {
    name: String,
    moved: HashMap<u32, [f32; 3]>,
}

/// The faces of each group of each object, by their numbers, in the order in which the file uses them.
type Objects<'f> = IndexMap<usize, IndexMap<usize, Vec<&'f Face>>>;

struct Builder {
    base: ObjText,
    examples: Vec<Example>,
    notes: Vec<String>,
}

impl Builder {
    fn new(name: &str, bytes: &[u8]) -> Result<Self, Error> {
        let mut base = ObjText::parse(name, bytes)?;
        let notes = std::mem::take(&mut base.notes);
        Ok(Self { base, examples: Vec::new(), notes })
    }

    fn add(&mut self, name: &str, bytes: &[u8]) -> Result<(), Error> {
        let example = ObjText::parse(name, bytes)?;
        let (ours, theirs) = (&self.base.positions, &example.positions);
        if ours.len() != theirs.len() {
            return Err(Error::ExampleMismatch {
                index: self.examples.len(),
                name: name.into(),
                what: format!(
                    "it has {} vertices (v lines); the base has {}: export both with the order of vertices kept",
                    theirs.len(),
                    ours.len()
                ),
            });
        }
        if !same_surface(&self.base.faces, &example.faces) {
            self.notes.push(format!(
                "the faces of '{name}' use other vertices than those of the base; if its dent looks torn, export both with the \
                 order of vertices kept"
            ));
        }
        let mut moved = HashMap::new();
        for (i, (a, b)) in (0..).zip(ours.iter().zip(theirs)) {
            let delta = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
            if delta != [0.0; 3] {
                moved.insert(i, finite(delta, || format!("{name}: displacement of v line {}", i + 1))?);
            }
        }
        self.examples.push(Example { name: name.into(), moved });
        Ok(())
    }

    /// `folder` has the MTL files.
    fn finish(mut self, folder: Option<&Path>) -> Result<GlbFile, Error> {
        if self.examples.is_empty() {
            return Err(Error::NoExamples {
                what: format!("'{}' came without example files; give at least one", self.base.name),
            });
        }
        let materials = self.materials(folder);
        // Each file is one blow, wherever it dents.
        let scene = json!({ "nodes": [], "extras": { "targets": "joined" } });
        let mut glb = Glb::new(new_root(scene, json!([])));
        glb.root["meshes"] = json!([]);
        let numbers = self.write_materials(&mut glb, &materials);
        for (object, groups) in self.objects() {
            let several = groups.len() > 1;
            let names = |group: usize| if several { &self.base.groups[group] } else { &self.base.objects[object] };
            let mut children = Vec::new();
            for (group, faces) in groups {
                let own = Some(names(group)).filter(|name| !name.is_empty()).unwrap_or(&self.base.groups[group]);
                let name = if own.is_empty() { &self.base.name } else { own };
                let mesh = self.mesh(&mut glb, name, &faces, &numbers)?;
                children.push(glb.push("nodes", json!({ "name": name, "mesh": mesh })));
            }
            let top = if several && object > 0 {
                let name = &self.base.objects[object];
                vec![glb.push("nodes", json!({ "name": name, "children": children }))]
            } else {
                children
            };
            let listed = glb.root["scenes"][0]["nodes"].as_array_mut();
            listed.into_iter().for_each(|list| list.extend(top.iter().map(|node| Value::from(*node))));
        }
        Ok(GlbFile { glb: glb.finish()?, notes: self.notes })
    }

    fn objects(&self) -> Objects<'_> {
        let mut out = Objects::new();
        for face in &self.base.faces {
            out.entry(face.object).or_default().entry(face.group).or_default().push(face);
        }
        if out.is_empty() {
            // A cloud of points.
            out.entry(0).or_default().entry(0).or_default();
        }
        out
    }

    /// Writes a mesh with a primitive for each material, and lines as primitives of their own.
    fn mesh(&self, glb: &mut Glb, name: &str, faces: &[&Face], materials: &[Option<usize>]) -> Result<usize, Error> {
        let mut kinds: IndexMap<(bool, usize), Vec<&Face>> = IndexMap::new();
        for face in faces {
            kinds.entry((face.is_line, face.material)).or_default().push(face);
        }
        if kinds.is_empty() {
            kinds.insert((false, 0), Vec::new());
        }
        let smooth = faces.iter().any(|face| face.smooth && !face.is_line).then(|| self.smooth()).transpose()?;
        let mut primitives = Vec::new();
        for ((is_line, material), faces) in kinds {
            let mut primitive = self.primitive(glb, is_line, &faces, smooth.as_deref());
            if let Some(material) = materials[material] {
                primitive["material"] = material.into();
            }
            primitives.push(primitive);
        }
        let names: Vec<&str> = self.examples.iter().map(|example| example.name.as_str()).collect();
        Ok(glb.push("meshes", json!({ "name": name, "primitives": primitives, "extras": { "targetNames": names } })))
    }

    fn primitive(&self, glb: &mut Glb, is_line: bool, faces: &[&Face], smooth: Option<&[Vec3]>) -> Value {
        let base = &self.base;
        // The vertices, and whether the first face that uses each is smooth.
        let mut corners: IndexMap<Corner, bool> = IndexMap::new();
        let mut indices: Vec<u32> = Vec::new();
        for face in faces {
            let mut vertex = |corner: &Corner| {
                let entry = corners.entry(*corner);
                let number = entry.index() as u32;
                entry.or_insert(face.smooth);
                number
            };
            let own: Vec<u32> = face.corners.iter().map(&mut vertex).collect();
            if is_line {
                indices.extend(own.windows(2).flatten());
            } else {
                let at: Vec<[f32; 3]> = face.corners.iter().map(|c| base.positions[c.v as usize]).collect();
                indices.extend(triangulated(&at).into_iter().map(|i| own[i]));
            }
        }
        if base.faces.is_empty() {
            corners = (0..base.positions.len() as u32).map(|v| (Corner { v, vt: None, vn: None }, false)).collect();
        }
        let of = |corner: &Corner| corner.v as usize;
        let positions: Vec<[f32; 3]> = corners.keys().map(|c| base.positions[of(c)]).collect();
        let mut attributes = json!({ "POSITION": glb.push_attribute(&positions, true) });
        let normal = |(corner, is_smooth): (&Corner, &bool)| match (corner.vn, smooth) {
            (Some(n), _) => Some(base.normals[n as usize]),
            (None, Some(smooth)) if *is_smooth => Some(smooth[of(corner)].to_array()),
            (None, _) => None,
        };
        if !is_line && corners.iter().any(|corner| normal(corner).is_some()) {
            let normals: Vec<[f32; 3]> = corners.iter().map(|corner| normal(corner).unwrap_or_default()).collect();
            attributes["NORMAL"] = glb.push_attribute(&normals, false).into();
        }
        if corners.keys().any(|corner| corner.vt.is_some()) {
            // In OBJ v grows upwards from the lower edge, in glTF downwards from the upper edge.
            let uv = |t: u32| [base.texcoords[t as usize][0], 1.0 - base.texcoords[t as usize][1]];
            let texcoords: Vec<[f32; 2]> = corners.keys().map(|c| c.vt.map_or([0.0, 1.0], uv)).collect();
            attributes["TEXCOORD_0"] = glb.push_attribute(&texcoords, false).into();
        }
        if let Some(colours) = &base.colours {
            let colours: Vec<[f32; 3]> = corners.keys().map(|c| colours[of(c)]).collect();
            attributes["COLOR_0"] = glb.push_attribute(&colours, false).into();
        }
        let mut primitive = json!({ "attributes": attributes });
        if indices.is_empty() {
            primitive["mode"] = 0.into();
        } else {
            if is_line {
                primitive["mode"] = 1.into();
            }
            primitive["indices"] = glb.push_indices(&indices).into();
        }
        let targets = self.examples.iter().map(|example| {
            let moved = (0u32..).zip(corners.keys()).filter_map(|(i, c)| Some((i, *example.moved.get(&c.v)?)));
            json!({ "POSITION": push_sparse(glb, corners.len(), moved.collect()) })
        });
        primitive["targets"] = targets.collect();
        primitive
    }

    /// The normal of the surface at each `v` line.
    fn smooth(&self) -> Result<Vec<Vec3>, Error> {
        let mut triangles = Vec::new();
        for face in self.base.faces.iter().filter(|face| !face.is_line) {
            let at: Vec<[f32; 3]> = face.corners.iter().map(|c| self.base.positions[c.v as usize]).collect();
            let corners: Vec<u32> = triangulated(&at).into_iter().map(|i| face.corners[i].v).collect();
            triangles.extend_from_slice(corners.as_chunks::<3>().0);
        }
        smooth(&self.base.positions, &triangles)
    }

    /// The materials of the libraries by name.
    fn materials(&mut self, folder: Option<&Path>) -> HashMap<String, tobj::Material> {
        let mut all = HashMap::new();
        let Some(folder) = folder else { return all };
        let why = |error| match error {
            Error::Io { message, .. } => message,
            other => other.to_string(),
        };
        for library in std::mem::take(&mut self.base.libraries) {
            // One name with spaces, or several names.
            let words: Vec<&str> = library.split_whitespace().collect();
            let is_one = words.len() < 2 || beside(folder, &library).is_ok();
            for name in if is_one { vec![library.as_str()] } else { words } {
                match beside(folder, name).map_err(why).and_then(|bytes| mtl::library(&bytes)) {
                    // The first library that has a material counts.
                    Ok(materials) => materials.into_iter().for_each(|(name, material)| {
                        all.entry(name).or_insert(material);
                    }),
                    Err(why) => self.notes.push(format!(
                        "the materials of {} cannot be read, so they keep their names only: {why}",
                        quoted(name)
                    )),
                }
            }
        }
        let used: HashSet<usize> = self.base.faces.iter().map(|face| face.material).filter(|m| *m > 0).collect();
        let unknown = used.iter().filter(|m| !all.contains_key(&self.base.materials[**m])).min();
        if let Some(first) = unknown.filter(|_| !all.is_empty()) {
            let name = quoted(&self.base.materials[*first]);
            self.notes
                .push(format!("no MTL file of '{}' has the material {name}; it keeps its name only", self.base.name));
        }
        all
    }

    /// Writes the materials that faces use. Returns the number of each.
    fn write_materials(&self, glb: &mut Glb, known: &HashMap<String, tobj::Material>) -> Vec<Option<usize>> {
        let used: HashSet<usize> = self.base.faces.iter().map(|face| face.material).collect();
        let mut textures = IndexSet::new();
        let mut numbers = vec![None; self.base.materials.len()];
        for (number, name) in self.base.materials.iter().enumerate().skip(1).filter(|(i, _)| used.contains(i)) {
            // Images and textures have the numbers of their uris.
            let mut texture = |uri: String| {
                let (number, is_new) = textures.insert_full(uri.clone());
                if is_new {
                    glb.push("images", json!({ "uri": uri }));
                    glb.push("textures", json!({ "source": number }));
                }
                number
            };
            let material = mtl::material(name, known.get(name), &mut texture);
            numbers[number] = Some(glb.push("materials", material));
        }
        numbers
    }
}

/// Reads a file beside the OBJ or below. Of a path that leads elsewhere, as on the machine that wrote it, only the name is used.
fn beside(folder: &Path, name: &str) -> Result<Vec<u8>, Error> {
    let name = name.replace('\\', "/");
    let last = name.rsplit('/').next().unwrap_or_default();
    let read = |path: &str| uri::read_file(Some(folder), path, "the MTL file", None);
    let is_below = !name.starts_with('/') && name.get(1..2) != Some(":") && !uri::leaves_folder(&name);
    match if is_below { read(&name) } else { read(last) } {
        Err(_) if is_below && last != name => read(last),
        result => result,
    }
}

/// Whether two lists of faces are the same surface. Polygons may be cut into triangles, and along other diagonals: then most edges
/// are the same all the same. An example without faces is the same surface.
fn same_surface(base: &[Face], example: &[Face]) -> bool {
    let edges = |faces: &[Face]| -> HashSet<[u32; 2]> {
        let around = |face: &Face| {
            let corners: Vec<u32> = face.corners.iter().map(|c| c.v).collect();
            let next = corners.iter().cycle().skip(1);
            corners.iter().zip(next).map(|(a, b)| [*a.min(b), *a.max(b)]).collect::<Vec<_>>()
        };
        faces.iter().filter(|face| !face.is_line).flat_map(around).collect()
    };
    if example.is_empty() || base.is_empty() {
        return true;
    }
    let (ours, theirs) = (edges(base), edges(example));
    2 * ours.intersection(&theirs).count() >= ours.len().min(theirs.len())
}

/// The corners of a polygon's triangles: a fan if that turns no triangle over, else by ear clipping.
fn triangulated(corners: &[[f32; 3]]) -> Vec<usize> {
    let n = corners.len();
    let fan = || (1..n - 1).flat_map(|i| [0, i, i + 1]).collect::<Vec<usize>>();
    if n == 3 {
        return fan();
    }
    let at = |i: usize| Vec3::from(corners[i]).as_dvec3();
    let area = |t: [usize; 3]| (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0]));
    let normal = (1..n - 1).map(|i| area([0, i, i + 1])).sum::<glam::DVec3>();
    if (1..n - 1).all(|i| area([0, i, i + 1]).dot(normal) >= 0.0) {
        return fan();
    }
    let wide: Vec<[f64; 3]> = corners.iter().map(|c| c.map(f64::from)).collect();
    let (mut flat, mut triangles) = (Vec::new(), Vec::<usize>::new());
    if earcut::utils3d::project3d_to_2d(&wide, n, &mut flat) {
        earcut::Earcut::new().earcut(flat.iter().copied(), &[] as &[usize], &mut triangles);
    }
    // A polygon without area, or one that crosses itself.
    if triangles.len() != 3 * (n - 2) {
        return fan();
    }
    for t in triangles.as_chunks_mut::<3>().0.iter_mut().filter(|t| area(**t).dot(normal) < 0.0) {
        t.swap(1, 2);
    }
    triangles
}

/// Adds an accessor that is zero except at `moved`, sorted by vertex.
fn push_sparse(glb: &mut Glb, count: usize, moved: Vec<(u32, [f32; 3])>) -> usize {
    let (indices, values): (Vec<u32>, Vec<[f32; 3]>) = moved.into_iter().unzip();
    let mut accessor = json!({ "componentType": 5126, "count": count, "type": "VEC3" });
    // The vertices that do not move count too.
    set_bounds(&mut accessor, values.iter().chain((values.len() < count).then_some(&[0.0; 3])));
    if !values.is_empty() {
        accessor["sparse"] = json!({
            "count": values.len(),
            "indices": { "bufferView": glb.push_view(cast_slice(&indices), None), "componentType": 5125 },
            "values": { "bufferView": glb.push_view(cast_slice(&values), None) },
        });
    }
    glb.push("accessors", accessor)
}
