//! Reads a mesh and its examples from a file.

use crate::vertices::Vertices;
use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use crumple::{
    ExampleSet, MeshData, SetOptions, TaskSystem,
    glam::{Mat4, Vec3},
    import::{self, Imported, MeshChoice, PrimitiveRange},
};
use std::{
    io::Read,
    path::{Path, PathBuf},
    sync::Arc,
};

/// The choice of a file and of a mesh in it.
#[derive(Args)]
pub struct Input {
    /// A glTF or GLB file with morph targets, an OBJ file (also give --example), or a .crumple file from `crumple bake`
    pub file: PathBuf,
    /// Mesh of a glTF file, by name or by index from 0 [default: the first mesh with morph targets]
    #[arg(long, value_name = "NAME|INDEX")]
    pub mesh: Option<String>,
    /// Join the meshes of all nodes of a glTF file to one body, with a part for each node
    #[arg(long, conflicts_with = "mesh")]
    pub join: bool,
    /// Example for an OBJ base: the same mesh after a collision; repeat the option for more examples
    #[arg(long = "example", value_name = "OBJ")]
    pub examples: Vec<PathBuf>,
}

/// A file's mesh and its examples.
pub struct Source {
    pub set: Arc<ExampleSet>,
    pub name: String,
    pub primitives: usize,
    /// Names of the parts: of levels 1 and up. Empty if the file was not joined.
    pub parts: Vec<String>,
    /// Transform from the mesh's space to the scene's.
    pub transform: Option<Mat4>,
    kind: Kind,
}

pub enum Kind {
    Gltf {
        bytes: Vec<u8>,
        base_dir: PathBuf,
        mesh: Option<String>,
    },
    /// An OBJ, or a joined glTF.
    Joined(Box<Imported>),
    Baked,
}

impl Input {
    /// Builds the example set of the file, or loads it if the file is baked.
    pub fn load(&self, tasks: &dyn TaskSystem) -> Result<Source> {
        let shown = self.file.display();
        if self.is_baked()? {
            ensure!(
                self.mesh.is_none() && self.examples.is_empty() && !self.join,
                "{shown} is a baked set, which has one mesh and its own examples; remove --mesh, --join and --example"
            );
            let set = ExampleSet::load_file(&self.file, tasks).with_context(|| shown.to_string())?;
            let name = self.file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let (set, parts) = (Arc::new(set), Vec::new());
            return Ok(Source { set, name, primitives: 1, parts, transform: None, kind: Kind::Baked });
        }
        let (imported, kind) = self.import()?;
        let meshes = imported.part_meshes();
        let Imported { name, mesh, examples, primitives, parts, node_transform, .. } = imported;
        let mut set =
            ExampleSet::build(mesh, examples, SetOptions::default(), tasks).with_context(|| shown.to_string())?;
        for mesh in meshes {
            set.add_lod(mesh, tasks).with_context(|| shown.to_string())?;
        }
        Ok(Source {
            set: Arc::new(set),
            name,
            primitives: primitives.len(),
            parts: parts.into_iter().map(|part| part.name).collect(),
            transform: node_transform.map(|m| Mat4::from_cols_array_2d(&m)),
            kind,
        })
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
    pub fn import(&self) -> Result<(Imported, Kind)> {
        let shown = self.file.display();
        let is_obj = self.file.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"));
        let bytes = std::fs::read(&self.file).with_context(|| format!("cannot read {shown}"))?;
        if is_obj {
            ensure!(
                self.mesh.is_none() && !self.join,
                "--mesh and --join are for glTF files; {shown} is an OBJ, which is one mesh"
            );
            ensure!(
                !self.examples.is_empty(),
                "{shown} is an OBJ, which has no examples; give one or more with --example FILE.obj"
            );
            let imported = import::obj_files(&self.file, &self.examples).with_context(|| shown.to_string())?;
            Ok((imported.clone(), Kind::Joined(Box::new(imported))))
        } else {
            ensure!(
                self.examples.is_empty(),
                "--example needs an OBJ base; the examples of {shown} are its morph targets"
            );
            let text = bytes.trim_ascii_start();
            if !bytes.starts_with(b"glTF") && !text.starts_with(b"{") && !text.starts_with(b"\xef\xbb\xbf{") {
                bail!(
                    "{shown} holds no mesh: it is neither a GLB (it does not begin with 'glTF'), a glTF (a JSON object), a .crumple file, nor named .obj"
                );
            }
            let base_dir = self.file.parent().unwrap_or(Path::new("")).to_owned();
            if self.join {
                let imported = import::gltf_body(&bytes, Some(&base_dir)).with_context(|| shown.to_string())?;
                return Ok((imported.clone(), Kind::Joined(Box::new(imported))));
            }
            let imported =
                import::gltf_slice(&bytes, Some(&base_dir), choice(&self.mesh)).with_context(|| shown.to_string())?;
            Ok((imported, Kind::Gltf { bytes, base_dir, mesh: self.mesh.clone() }))
        }
    }
}

impl Source {
    /// The file as a GLB, with the mesh replaced by its deformed vertices.
    pub fn deformed_glb(&self, vertices: &Vertices) -> Result<Vec<u8>, crumple::Error> {
        let positions = &vertices.positions;
        let (normals, tangents) = (vertices.normals.as_deref(), vertices.tangents.as_deref());
        match &self.kind {
            Kind::Gltf { bytes, base_dir, mesh } => {
                crumple::export::deformed_glb(bytes, Some(base_dir), choice(mesh), positions, normals, tangents)
            }
            Kind::Joined(imported) => crumple::export::mesh_glb(imported, positions, normals, tangents),
            Kind::Baked => crumple::export::mesh_glb(&self.as_imported(), positions, normals, tangents),
        }
    }

    /// The mesh of a baked set, in the form that export takes.
    fn as_imported(&self) -> Imported {
        let mesh = self.set.mesh();
        let part = PrimitiveRange {
            primitive: 0,
            first_vertex: 0,
            vertex_count: self.set.vertex_count() as u32,
            first_triangle: 0,
            triangle_count: mesh.triangles().len() as u32,
            material: None,
        };
        Imported {
            name: self.name.clone(),
            mesh: MeshData {
                positions: mesh.positions().iter().map(|p| p.to_array()).collect(),
                triangles: mesh.triangles().to_vec(),
                ..MeshData::default()
            },
            texcoords: None,
            examples: Vec::new(),
            primitives: vec![part],
            parts: Vec::new(),
            node_transform: None,
        }
    }

    /// Unit vector in the mesh's space that points up in the scene; +y is up in glTF.
    pub fn up(&self) -> Vec3 {
        self.transform.map_or(Vec3::Y, |m| m.transpose().transform_vector3(Vec3::Y).normalize_or(Vec3::Y))
    }
}

/// Reads a number as an index and any other text as a name.
fn choice(mesh: &Option<String>) -> MeshChoice<'_> {
    match mesh {
        None => MeshChoice::First,
        Some(text) => text.parse().map_or(MeshChoice::Name(text), MeshChoice::Index),
    }
}
