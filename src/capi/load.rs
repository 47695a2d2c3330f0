//! Example sets from files.
#![cfg_attr(not(feature = "obj"), allow(unused_imports, unused_variables))]

use super::boundary::built_with;
use super::build::{CrumpleExampleSetOptions, default_options, read_options};
use super::check::item;
use super::prelude::*;
use super::set::insert_set;
use super::store::{CrumplePart, CrumplePartKind, CrumplePrimitive, SetEntry, c_string};
use crate::base::error::reserve;
use crate::example::set::ExampleSet;
#[cfg(feature = "gltf")]
use crate::io::import::{self, MeshChoice, PartKind, Patterns, Reading};
use std::ffi::CStr;
use std::path::{Path, PathBuf};

/// Which mesh of a glTF file to load, and the options of the set.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleGltfDef {
    pub struct_size: u32,
    /// Index of the mesh in the file, used if mesh_name is null. Default UINT32_MAX: the first mesh whose morph targets move it.
    pub mesh_index: u32,
    /// Name of the mesh, UTF-8. Default null: mesh_index decides.
    pub mesh_name: *const c_char,
    /// Path of the .glb or .gltf file, UTF-8. For crumple_example_set_load_gltf_memory(): the folder of other files
    /// that the glTF refers to. If it is null there, a glTF that refers to files is an error.
    pub path: *const c_char,
    /// Whether to join the meshes of all nodes, but those of other scenes, to one body, each where its node places it. Default
    /// false. Each node with a mesh then is a part: lods 1 and up, in the order of the nodes; see
    /// crumple_example_set_get_part(). If there are more than 63, the smallest belong to the part of a node above them. Behind
    /// these come the panes: a primitive with a glass material is a part too, a piece of its node's, named after the material.
    /// Morph targets of the same name are one example if they lie near each other. mesh_index and mesh_name are not used.
    pub join_nodes: MaybeUninit<bool>,
    /// Length of the file's unit, m. Default 1.
    pub unit: f32,
    /// Patterns of names, UTF-8, one a line: * stands for any text, ? for any character, upper and lower case are the same,
    /// and ! at the start takes names out. The nodes to join; a name above a node's counts too. Default null: join_nodes
    /// decides.
    pub nodes: *const c_char,
    /// Patterns of the morph targets that are dents. Default null: mesh.extras.dents, or else all.
    pub targets: *const c_char,
    /// Patterns of nodes or materials that never move. Hits on them leave no mark.
    pub rigid: *const c_char,
    /// Patterns of nodes or materials that are glass: parts that follow dents around them. Hits on them leave marks until
    /// crumple_instance_set_part_rigid() is called for the part.
    pub glass: *const c_char,
    /// Patterns of nodes that move on their own, such as wheels: they are no part of a joined body.
    pub moving: *const c_char,
    pub options: CrumpleExampleSetOptions,
}

/// A base OBJ file, its example files, and the options of the set.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleObjDef {
    pub struct_size: u32,
    /// Number of example_paths, at least 1.
    pub example_count: u32,
    /// Path of the base mesh, UTF-8. Required.
    pub base_path: *const c_char,
    /// Paths of the examples, UTF-8. Each has the v lines of the base mesh in the same order.
    pub example_paths: *const *const c_char,
    pub options: CrumpleExampleSetOptions,
}

defs!(CrumpleGltfDef, CrumpleObjDef);

#[unsafe(no_mangle)]
pub extern "C" fn crumple_gltf_def_default() -> CrumpleGltfDef {
    CrumpleGltfDef { mesh_index: u32::MAX, options: default_options(), unit: 1.0, ..zeroed() }
}

/// Builds an example set from a glTF 2.0 or GLB file: a mesh with its morph targets. Primitives are joined in their
/// order; see crumple_example_set_get_primitive(). mesh.extras has the examples' names (targetNames), contacts
/// (impacts) and placements. Coordinates are in the mesh's own space, and node transforms are not applied, unless nodes
/// are joined. What is odd in the file is logged as warnings. Errors: CRUMPLE_ERROR_IO, CRUMPLE_ERROR_FORMAT (malformed,
/// or no such mesh), CRUMPLE_ERROR_UNSUPPORTED (Draco's compression, or a build without CRUMPLE_FEATURE_GLTF),
/// CRUMPLE_ERROR_EXAMPLE_MISMATCH (no morph targets), and those of crumple_example_set_create().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_load_gltf(
    context: *mut CrumpleContext,
    def: *const CrumpleGltfDef,
    out_set: *mut CrumpleExampleSet,
) -> CrumpleResult {
    built_with!("gltf", exclusive, "crumple_example_set_load_gltf", context, |context, state| {
        let (def, out) = (self::def(def, "def")?, Out::new(out_set, "out_set")?);
        let path = required_string(def.path, "def.path")?;
        let imported = import::gltf_file(path.as_ref(), reading(&def)?)?;
        add_imported(context, state, imported, &def.options, out)
    })
}

/// Like crumple_example_set_load_gltf(), but reads the file from the size bytes at data, of any alignment.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_load_gltf_memory(
    context: *mut CrumpleContext,
    data: *const c_void,
    size: usize,
    def: *const CrumpleGltfDef,
    out_set: *mut CrumpleExampleSet,
) -> CrumpleResult {
    built_with!("gltf", exclusive, "crumple_example_set_load_gltf_memory", context, |context, state| {
        let (def, out) = (self::def(def, "def")?, Out::new(out_set, "out_set")?);
        let bytes = array(data.cast::<u8>(), size, "data")?;
        let folder = string(def.path, "def.path")?.map(Path::new);
        let imported = import::gltf_slice(bytes, folder, reading(&def)?)?;
        add_imported(context, state, imported, &def.options, out)
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn crumple_obj_def_default() -> CrumpleObjDef {
    CrumpleObjDef { options: default_options(), ..zeroed() }
}

/// Builds an example set from a base OBJ file and one OBJ file per example. Examples are named after their files. Each
/// must have the base's v lines in the base's order. The set's vertices are the distinct corners of the base's faces, in the
/// order in which they are used, or its v lines if it has no faces. Polygons are triangulated. What is odd in the files is
/// logged as warnings. Errors: CRUMPLE_ERROR_IO, CRUMPLE_ERROR_FORMAT, CRUMPLE_ERROR_UNSUPPORTED (a build without
/// CRUMPLE_FEATURE_OBJ), and those of crumple_example_set_create().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_load_obj(
    context: *mut CrumpleContext,
    def: *const CrumpleObjDef,
    out_set: *mut CrumpleExampleSet,
) -> CrumpleResult {
    built_with!("obj", exclusive, "crumple_example_set_load_obj", context, |context, state| {
        let (def, out) = (self::def(def, "def")?, Out::new(out_set, "out_set")?);
        let base = required_string(def.base_path, "def.base_path")?;
        let paths = array(def.example_paths, def.example_count as usize, "def.example_paths")?;
        let mut examples = reserve(paths.len(), "def.example_paths")?;
        for (i, &path) in paths.iter().enumerate() {
            examples.push(PathBuf::from(required_string(path, &format!("def.example_paths[{i}]"))?));
        }
        let imported = import::obj_files(base.as_ref(), &examples)?;
        add_imported(context, state, imported, &def.options, out)
    })
}

#[cfg(feature = "gltf")]
unsafe fn patterns(text: *const c_char, name: &str) -> Result<Patterns, Failure> {
    Ok(Patterns::new(string(text, name)?.unwrap_or_default().lines().filter(|line| !line.is_empty())))
}

#[cfg(feature = "gltf")]
unsafe fn reading(def: &CrumpleGltfDef) -> Result<Reading, Failure> {
    let nodes = patterns(def.nodes, "def.nodes")?;
    Ok(Reading {
        mesh: match (string(def.mesh_name, "def.mesh_name")?, def.mesh_index) {
            _ if boolean(def.join_nodes) || !nodes.is_empty() => MeshChoice::Nodes(nodes),
            (Some(name), _) => MeshChoice::Name(name.to_owned()),
            (None, u32::MAX) => MeshChoice::First,
            (None, index) => MeshChoice::Index(index as usize),
        },
        targets: patterns(def.targets, "def.targets")?,
        rigid: patterns(def.rigid, "def.rigid")?,
        glass: patterns(def.glass, "def.glass")?,
        moving: patterns(def.moving, "def.moving")?,
        unit: def.unit,
    })
}

#[cfg(feature = "gltf")]
unsafe fn add_imported(
    context: &Context,
    state: &mut State,
    imported: import::Imported,
    options: &CrumpleExampleSetOptions,
    out: Out<CrumpleExampleSet>,
) -> Result<(), Failure> {
    let options = read_options(options, imported.mesh.positions.len())?;
    for note in &imported.notes {
        context.log(CrumpleLogLevel::Warning, note);
    }
    let meshes = imported.part_meshes();
    let mut set = ExampleSet::build(imported.mesh, imported.examples, options, &context.tasks)?;
    for mesh in meshes {
        set.add_lod(mesh, &context.tasks)?;
    }
    let mut entry = SetEntry { name: c_string(&imported.name), ..SetEntry::new(set) };
    let mut texts = Vec::new();
    let mut text = |text: &str| {
        texts.push(c_string(text));
        texts[texts.len() - 1].as_ptr()
    };
    let primitives = imported.primitives.iter().map(|p| CrumplePrimitive {
        material: p.material.as_deref().map_or(std::ptr::null(), &mut text),
        first_vertex: p.vertices.start as u32,
        vertex_count: p.vertices.len() as u32,
        first_triangle: p.triangles.start as u32,
        triangle_count: p.triangles.len() as u32,
        reserved: [0; 2],
    });
    entry.primitives = primitives.collect();
    let parts = imported.parts.iter().map(|p| CrumplePart {
        name: text(&p.name),
        kind: match p.kind {
            PartKind::Dents => CrumplePartKind::Dents,
            PartKind::Rigid => CrumplePartKind::Rigid,
            PartKind::Glass => CrumplePartKind::Glass,
        },
        first_vertex: p.vertices.start as u32,
        vertex_count: p.vertices.len() as u32,
        first_triangle: p.triangles.start as u32,
        triangle_count: p.triangles.len() as u32,
        reserved: [0; 3],
    });
    entry.parts = parts.collect();
    entry.texts = texts;
    if let Some(columns) = &imported.node_transform {
        entry.node_transform = *bytemuck::cast_ref(columns);
    }
    insert_set(context, state, entry, out)
}

/// Returns the vertices and triangles of the primitive with an index below primitive_count.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_get_primitive(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    primitive: u32,
    out_primitive: *mut CrumplePrimitive,
) -> CrumpleResult {
    exclusive("crumple_example_set_get_primitive", context, |_, state| {
        let out = Out::new(out_primitive, "out_primitive")?;
        out.answer(*item(&state.sets.get(set, "set")?.primitives, primitive, "primitive")?)
    })
}

/// Returns the number of a part by its name, that of its node, or of the node's mesh if the node has none: a lod, 1 and up. The
/// first of that name. Only for sets that were loaded with join_nodes; baked sets keep the numbers, not the names.
/// CRUMPLE_ERROR_INVALID_ARGUMENT: no such part.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_find_part(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    name: *const c_char,
    out_lod: *mut u32,
) -> CrumpleResult {
    exclusive("crumple_example_set_find_part", context, |_, state| {
        let (name, out) = (required_string(name, "name")?, Out::new(out_lod, "out_lod")?);
        let parts = &state.sets.get(set, "set")?.parts;
        let names = || parts.iter().map(|part| CStr::from_ptr(part.name));
        let at = names().position(|part| part.to_bytes() == name.as_bytes()).ok_or_else(|| {
            let names: Vec<_> = names().map(|part| part.to_string_lossy()).collect();
            Failure::invalid(format!("name is '{name}'; it must be one of the set's {} parts: {names:?}", parts.len()))
        })?;
        out.answer(at as u32 + 1)
    })
}

/// Returns the name, the kind and the sizes of a part: a lod from 1 to lod_count - 1. Only for sets that were loaded with
/// join_nodes. CRUMPLE_ERROR_INVALID_ARGUMENT: no such part.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_get_part(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    part: u32,
    out_part: *mut CrumplePart,
) -> CrumpleResult {
    exclusive("crumple_example_set_get_part", context, |_, state| {
        let out = Out::new(out_part, "out_part")?;
        let parts = &state.sets.get(set, "set")?.parts;
        let found = (part as usize).checked_sub(1).and_then(|at| parts.get(at));
        let part = found.ok_or_else(|| {
            Failure::invalid(format!("part is {part}; it must be one of the set's parts, 1 to {}", parts.len()))
        })?;
        out.answer(*part)
    })
}
