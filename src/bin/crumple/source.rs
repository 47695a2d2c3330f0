//! Reads a mesh and its examples from a file.

use crate::picture::{self, Coat};
use crate::table::plain;
use crate::units;
use crate::vertices::Vertices;
use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use crumple::export::{self, GlbFile};
use crumple::glam::{Mat3, Mat4, Vec3};
use crumple::import::{self, Imported, MeshChoice, PartKind, Patterns, Reading};
use crumple::{BasisOptions, ExampleSet, Instance, SetOptions, TaskSystem};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A contact further than this from the nearest vertex causes a warning; a share of the body's diagonal.
pub const FAR_OFF: f32 = 0.1;

/// The choice of a file, and of what in it dents.
#[derive(Args)]
pub struct Input {
    /// A glTF or GLB file with morph targets, an OBJ file (also give --example), or a .crumple file from `crumple bake`
    pub file: PathBuf,
    /// Mesh of a glTF file, by name or by index from 0 [default: the first mesh whose morph targets move it]
    #[arg(long, value_name = "NAME|INDEX", conflicts_with_all = ["join", "nodes"])]
    mesh: Option<String>,
    /// Join the meshes of all nodes, but those of other scenes, to one body, with a part for each node
    #[arg(long)]
    join: bool,
    /// Join the meshes of the nodes whose name, or a name above them, matches; repeat the option for more. In patterns * stands
    /// for any text, ? for any character, and ! before one takes names out again
    #[arg(long, value_name = "PATTERN")]
    nodes: Vec<String>,
    /// Nodes or materials that never move; hits on them leave no mark
    #[arg(long, value_name = "PATTERN")]
    rigid: Vec<String>,
    /// Nodes or materials that break instead: they follow dents around them, but hits on them leave no mark
    #[arg(long, value_name = "PATTERN")]
    glass: Vec<String>,
    /// Nodes that move on their own, such as wheels and doors that open: they are no part of the body and never dent
    #[arg(long, value_name = "PATTERN")]
    moving: Vec<String>,
    /// Morph targets that are dents; the others stay in the file [default: all]
    #[arg(long, value_name = "PATTERN")]
    targets: Vec<String>,
    /// The file's unit of length, such as cm or 0.01 [default: m]
    #[arg(long, value_name = "LENGTH", value_parser = units::unit)]
    unit: Option<f32>,
    /// Example for an OBJ base: the same mesh after a collision; repeat the option for more examples
    #[arg(long = "example", value_name = "OBJ")]
    examples: Vec<PathBuf>,
    /// How far a vertex may be from where its dents would put it: vertices follow a few of them, the nodes, of which more are added
    /// where vertices are wrong. Less takes more memory, and hits cost more
    #[arg(long, value_name = "LENGTH", value_parser = units::length)]
    pub basis: Option<f32>,
}

/// A file's mesh and its examples.
pub struct Source {
    pub set: Arc<ExampleSet>,
    /// What else the file tells; its mesh and examples are in the set.
    pub about: Imported,
    /// How the materials of a body of parts look, and the index of each vertex's. Empty for other bodies.
    pub coats: (Vec<Coat>, Vec<f32>),
    /// Numbers of the set's meshes that are glass.
    glass: Vec<usize>,
    file: Option<File>,
}

/// A glTF, or an OBJ as a glTF, and what of it is read.
pub struct File {
    bytes: Vec<u8>,
    base_dir: PathBuf,
    reading: Reading,
}

impl Input {
    /// How vertices follow nodes, if that was asked for.
    pub fn basis(&self) -> Option<BasisOptions> {
        self.basis.map(BasisOptions::new)
    }

    /// Builds the example set of the file, or loads it if the file is baked.
    pub fn load(&self, tasks: &dyn TaskSystem) -> Result<Source> {
        let shown = self.file.display();
        if self.is_baked()? {
            let patterns = [&self.nodes, &self.rigid, &self.glass, &self.moving, &self.targets];
            let chooses = self.mesh.is_some() || self.join || patterns.iter().any(|list| !list.is_empty());
            ensure!(
                !chooses && self.examples.is_empty() && self.unit.is_none() && self.basis.is_none(),
                "{shown} is a baked set, which has one mesh and its own examples; give these options to `crumple bake`"
            );
            let set = Arc::new(ExampleSet::load_file(&self.file, tasks).with_context(|| shown.to_string())?);
            let about = Imported {
                name: self.stem(),
                notes: vec![
                    "a baked set has no materials, texture coordinates or nodes; apply its source file to keep them"
                        .into(),
                ],
                ..Imported::default()
            };
            return Ok(Source { set, about, coats: Default::default(), glass: Vec::new(), file: None });
        }
        let (mut about, file) = self.import()?;
        let meshes = about.part_meshes();
        let (mesh, examples) = (std::mem::take(&mut about.mesh), std::mem::take(&mut about.examples));
        let options = SetOptions { basis: self.basis(), ..SetOptions::default() };
        let mut set = ExampleSet::build(mesh, examples, options, tasks).with_context(|| shown.to_string())?;
        let mut glass = Vec::new();
        // Only hits on glass need to know a part.
        for (_, mesh) in about.parts.iter().zip(meshes).filter(|(part, _)| part.kind == PartKind::Glass) {
            glass.push(set.add_lod(mesh, tasks).with_context(|| shown.to_string())?);
        }
        let coats = match about.parts.len() {
            0 | 1 => Default::default(),
            _ => picture::coats(&file.bytes, &about.primitives, set.vertex_count()),
        };
        Ok(Source { set: Arc::new(set), about, coats, glass, file: Some(file) })
    }

    fn stem(&self) -> String {
        self.file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Whether the file was written by `crumple bake`.
    pub fn is_baked(&self) -> Result<bool> {
        let mut start = Vec::new();
        let file = std::fs::File::open(&self.file);
        let read = file.and_then(|f| f.take(8).read_to_end(&mut start));
        read.with_context(|| format!("cannot read {}", self.file.display()))?;
        Ok(ExampleSet::is_saved(&start))
    }

    /// Reads a glTF, GLB or OBJ file.
    pub fn import(&self) -> Result<(Imported, File)> {
        let shown = self.file.display();
        let is_obj = self.file.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"));
        let joins = self.join || !self.nodes.is_empty();
        let mut file = File {
            bytes: std::fs::read(&self.file).with_context(|| format!("cannot read {shown}"))?,
            base_dir: self.file.parent().unwrap_or(Path::new("")).to_owned(),
            reading: Reading {
                mesh: match &self.mesh {
                    _ if joins || is_obj => MeshChoice::Nodes(Patterns::new(&self.nodes)),
                    None => MeshChoice::First,
                    // A number is an index.
                    Some(text) => text.parse().map_or_else(|_| MeshChoice::Name(text.clone()), MeshChoice::Index),
                },
                targets: Patterns::new(&self.targets),
                rigid: Patterns::new(&self.rigid),
                glass: Patterns::new(&self.glass),
                moving: Patterns::new(&self.moving),
                unit: self.unit.unwrap_or(1.0),
            },
        };
        let mut notes = Vec::new();
        if is_obj {
            ensure!(
                self.mesh.is_none(),
                "--mesh is for glTF files; the objects of {shown}, an OBJ, are nodes: choose them with --nodes"
            );
            ensure!(
                !self.examples.is_empty(),
                "{shown} is an OBJ, which has no examples; give one or more with --example FILE.obj"
            );
            let converted = import::obj_glb(&self.file, &self.examples).with_context(|| shown.to_string())?;
            (file.bytes, notes) = (converted.glb, converted.notes);
        } else {
            ensure!(
                self.examples.is_empty(),
                "--example needs an OBJ base; the examples of {shown} are its morph targets"
            );
            let text = file.bytes.trim_ascii_start();
            // UTF-8 or UTF-16, with or without a mark.
            let starts: [&[u8]; 6] = [b"{", b"\xef\xbb\xbf", b"\xff\xfe{\0", b"\xfe\xff\0{", b"\0{", b"glTF"];
            if !starts.iter().any(|start| text.starts_with(start)) {
                bail!(
                    "{shown} holds no mesh: it is neither a GLB (it does not begin with 'glTF'), a glTF (a JSON object), a .crumple file, nor named .obj"
                );
            }
        }
        let read = import::gltf_slice(&file.bytes, Some(&file.base_dir), &file.reading);
        let mut imported = read.with_context(|| shown.to_string())?;
        if joins || is_obj {
            imported.name = self.stem();
        }
        if is_obj && !joins {
            imported.parts.retain(|part| part.kind == PartKind::Glass);
        }
        imported.notes.splice(0..0, notes);
        Ok((imported, file))
    }
}

impl Source {
    /// The file as a GLB, with the mesh replaced by its deformed vertices.
    pub fn deformed_glb(&self, vertices: &Vertices) -> Result<GlbFile, crumple::Error> {
        let Vertices { positions, normals, tangents } = vertices;
        let (normals, tangents) = (normals.as_deref(), tangents.as_deref());
        if let Some(file) = &self.file {
            let folder = Some(file.base_dir.as_path());
            return export::deformed_glb(&file.bytes, folder, &file.reading, positions, normals, tangents);
        }
        let triangles = self.set.mesh().triangles();
        let glb = export::mesh_glb(&self.about.name, triangles, positions, normals, tangents)?;
        Ok(GlbFile { glb, notes: Vec::new() })
    }

    /// Makes hits on glass leave no mark.
    pub fn spare_glass(&self, instance: &mut Instance) -> Result<(), crumple::Error> {
        self.glass.iter().try_for_each(|part| instance.set_rigid(*part, true))
    }

    /// Transform from the mesh's space to the scene's.
    pub fn transform(&self) -> Option<Mat4> {
        self.about.node_transform.map(|columns| Mat4::from_cols_array_2d(&columns))
    }

    /// Unit vector in the mesh's space that points up in the scene; +y is up in glTF.
    pub fn up(&self) -> Vec3 {
        self.transform().map_or(Vec3::Y, |m| m.transpose().transform_vector3(Vec3::Y).normalize_or(Vec3::Y))
    }

    /// How many times larger the node shows the mesh than its own space has it; 1 if no node shows it.
    pub fn scale(&self) -> f32 {
        let scale = self.transform().map_or(1.0, |m| Mat3::from_mat4(m).determinant().abs().cbrt());
        if (scale - 1.0).abs() < 1e-4 || scale <= 0.0 { 1.0 } else { scale }
    }
}

/// Appends notes to a report, each behind `label`. Lists are cut.
pub fn write_notes(text: &mut String, label: &str, notes: &[String]) {
    const SHOWN: usize = 6;
    for note in notes.iter().take(SHOWN) {
        text.push_str(&format!("{label}{}.\n", plain(note)));
    }
    if notes.len() > SHOWN {
        text.push_str(&format!("{label}{} more remarks on the file.\n", notes.len() - SHOWN));
    }
}
