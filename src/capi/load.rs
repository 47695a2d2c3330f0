//! Example sets from files.

use super::c_enum::c_enums;
use super::check::{Out, array, def, defs, enumerator, required_string, write_array, zeroed};
#[cfg(feature = "gltf")]
use super::check::{boolean, string};
use super::context::{Context, CrumpleContext, exclusive};
use super::result::{CrumpleResult, Failure};
use super::set::{CrumpleExampleSetOptions, default_options, insert_set};
#[cfg(feature = "gltf")]
use super::set::{c_string, read_options};
use super::store::State;
use super::tasks::Quiet;
use super::types::{CrumpleExampleSet, CrumplePrimitive};
use crate::example::set::ExampleSet;
use std::ffi::{c_char, c_void};
use std::mem::MaybeUninit;

/// Which mesh of a glTF file to load, and the options of the set.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleGltfDef {
    pub struct_size: u32,
    /// Index of the mesh in the file, used if mesh_name is null. Default UINT32_MAX: the first mesh with morph targets.
    pub mesh_index: u32,
    /// Name of the mesh, UTF-8. Default null: mesh_index decides.
    pub mesh_name: *const c_char,
    /// Path of the .glb or .gltf file, UTF-8. For crumple_example_set_load_gltf_memory(): the folder of other files
    /// that the glTF refers to. If it is null there, a glTF that refers to files is an error.
    pub path: *const c_char,
    pub options: CrumpleExampleSetOptions,
    /// Whether to join the meshes of all nodes to one body, each where its node places it. Default false. Each node with a
    /// mesh then is a part: lods 1 and up, in the order of the nodes; see crumple_example_set_find_part(). Morph targets of
    /// the same name are one example. mesh_index and mesh_name are not used.
    pub join_nodes: MaybeUninit<bool>,
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
    /// Paths of the examples, UTF-8. Each has the vertices of the base mesh in the same order.
    pub example_paths: *const *const c_char,
    pub options: CrumpleExampleSetOptions,
}

defs!(CrumpleGltfDef, CrumpleObjDef);

/// Returns a def for the first mesh with morph targets, with default options. Set the path.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_gltf_def_default() -> CrumpleGltfDef {
    CrumpleGltfDef { mesh_index: u32::MAX, options: default_options(), ..zeroed() }
}

/// Returns a def with default options. Set the paths.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_obj_def_default() -> CrumpleObjDef {
    CrumpleObjDef { options: default_options(), ..zeroed() }
}

/// Builds an example set from a glTF 2.0 or GLB file: a mesh with its morph targets. Primitives are joined in their
/// order; see crumple_example_set_get_primitive(). mesh.extras has the examples' names (targetNames), contacts
/// (impacts) and placements. Coordinates are in the mesh's own space, and node transforms are not applied, unless
/// join_nodes is set. Errors: CRUMPLE_ERROR_IO, CRUMPLE_ERROR_FORMAT (malformed, or no such mesh),
/// CRUMPLE_ERROR_UNSUPPORTED (Draco or meshopt compression, more than 63 parts, or a build without
/// CRUMPLE_FEATURE_GLTF), CRUMPLE_ERROR_EXAMPLE_MISMATCH (no morph targets), and those of crumple_example_set_create().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_load_gltf(
    context: *mut CrumpleContext,
    def: *const CrumpleGltfDef,
    out_set: *mut CrumpleExampleSet,
) -> CrumpleResult {
    exclusive("crumple_example_set_load_gltf", context, |context, state| {
        let (def, out) = (self::def(def, "def")?, Out::new(out_set, "out_set")?);
        let path = required_string(def.path, "def.path")?;
        #[cfg(feature = "gltf")]
        {
            let all = crate::io::import::Patterns::default();
            let imported = crate::io::import::gltf_file(path.as_ref(), mesh_choice(&def, &all)?)?;
            add_imported(context, state, imported, &def.options, out)
        }
        #[cfg(not(feature = "gltf"))]
        {
            let _ = (context, state, path, out);
            Err(Failure::not_built("gltf"))
        }
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
    exclusive("crumple_example_set_load_gltf_memory", context, |context, state| {
        let (def, out) = (self::def(def, "def")?, Out::new(out_set, "out_set")?);
        let bytes = array(data.cast::<u8>(), size, "data")?;
        #[cfg(feature = "gltf")]
        {
            let all = crate::io::import::Patterns::default();
            let folder = string(def.path, "def.path")?.map(std::path::Path::new);
            let imported = crate::io::import::gltf_slice(bytes, folder, mesh_choice(&def, &all)?)?;
            add_imported(context, state, imported, &def.options, out)
        }
        #[cfg(not(feature = "gltf"))]
        {
            let _ = (context, state, def, bytes, out);
            Err(Failure::not_built("gltf"))
        }
    })
}

/// Builds an example set from a base OBJ file and one OBJ file per example. Examples are named after their files.
/// Vertices are the file's v lines in their order. Polygons are triangulated. Errors: CRUMPLE_ERROR_IO,
/// CRUMPLE_ERROR_FORMAT, CRUMPLE_ERROR_UNSUPPORTED (a build without CRUMPLE_FEATURE_OBJ), and those of
/// crumple_example_set_create().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_load_obj(
    context: *mut CrumpleContext,
    def: *const CrumpleObjDef,
    out_set: *mut CrumpleExampleSet,
) -> CrumpleResult {
    exclusive("crumple_example_set_load_obj", context, |context, state| {
        let (def, out) = (self::def(def, "def")?, Out::new(out_set, "out_set")?);
        let base = required_string(def.base_path, "def.base_path")?;
        let paths = array(def.example_paths, def.example_count as usize, "def.example_paths")?;
        let mut examples = crate::base::error::reserve(paths.len(), "def.example_paths")?;
        for (i, &path) in paths.iter().enumerate() {
            let name = format!("def.example_paths[{i}]");
            examples.push(std::path::PathBuf::from(required_string(path, &name)?));
        }
        #[cfg(feature = "obj")]
        {
            let imported = crate::io::import::obj_files(base.as_ref(), &examples)?;
            add_imported(context, state, imported, &def.options, out)
        }
        #[cfg(not(feature = "obj"))]
        {
            let _ = (context, state, base, examples, out);
            Err(Failure::not_built("obj"))
        }
    })
}

/// Whether the bytes of a baked set are copied.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(dead_code)] // made by C
pub enum CrumpleBytes {
    /// The bytes are copied. Free them after the call.
    Copy = 0,
    /// The bytes are used in place. They must stay readable and unchanged until the set and all its instances are
    /// destroyed, or the context is; if the set is shared, in all its contexts. Bytes whose address is not a multiple of
    /// 16 are copied.
    Keep = 1,
}

c_enums!(CrumpleBytes::Keep);

/// Loads an example set from the size bytes of a .crumple file at data, written by "crumple bake" or
/// crumple_example_set_save_baked(). Loading builds nothing and is fast. All bytes are validated. The set has one
/// primitive, no name and no node transform. Errors: CRUMPLE_ERROR_FORMAT (damaged, cut short, or not a baked set),
/// CRUMPLE_ERROR_UNSUPPORTED (another format version).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_load_baked_memory(
    context: *mut CrumpleContext,
    data: *const c_void,
    size: usize,
    bytes: MaybeUninit<CrumpleBytes>,
    out_set: *mut CrumpleExampleSet,
) -> CrumpleResult {
    exclusive("crumple_example_set_load_baked_memory", context, |context, state| {
        let out = Out::new(out_set, "out_set")?;
        let keep = enumerator(bytes, "bytes")? == CrumpleBytes::Keep;
        let bytes: &'static [u8] = array(data.cast::<u8>(), size, "data")?;
        state.sets.reserve::<CrumpleExampleSet>()?;
        let tasks = Quiet(context.tasks());
        let set = if keep { ExampleSet::load(bytes, &tasks) } else { ExampleSet::load_copy(bytes, &tasks) }?;
        add_baked(context, state, set, out);
        Ok(())
    })
}

/// Like crumple_example_set_load_baked_memory(), but reads a file into memory. path is UTF-8. Also returns
/// CRUMPLE_ERROR_IO.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_load_baked(
    context: *mut CrumpleContext,
    path: *const c_char,
    out_set: *mut CrumpleExampleSet,
) -> CrumpleResult {
    exclusive("crumple_example_set_load_baked", context, |context, state| {
        let out = Out::new(out_set, "out_set")?;
        let path = required_string(path, "path")?;
        state.sets.reserve::<CrumpleExampleSet>()?;
        let set = ExampleSet::load_file(path, &Quiet(context.tasks()))?;
        add_baked(context, state, set, out);
        Ok(())
    })
}

/// Writes an example set as the bytes of a .crumple file, equal on all machines. data has capacity bytes of any
/// alignment; see "Arrays" at the top.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_save_baked(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    data: *mut c_void,
    capacity: usize,
    out_size: *mut usize,
) -> CrumpleResult {
    exclusive("crumple_example_set_save_baked", context, |_, state| {
        let out = Out::new(out_size, "out_size")?;
        let set = &state.sets.get(set, "set")?.set;
        if data.is_null() && capacity == 0 {
            out.write(set.saved_bytes());
            return Ok(());
        }
        write_array(&set.save()?, data.cast::<u8>(), capacity, "data", out)
    })
}

fn add_baked(context: &Context, state: &mut State, set: ExampleSet, out: Out<CrumpleExampleSet>) {
    let whole = CrumplePrimitive::new(0..set.vertex_count() as u32, 0..set.mesh().triangles().len() as u32);
    insert_set(context, state, set, (c"".into(), vec![whole], Vec::new(), None), out);
}

#[cfg(feature = "gltf")]
unsafe fn mesh_choice<'d>(
    def: &'d CrumpleGltfDef,
    all: &'d crate::io::import::Patterns,
) -> Result<crate::io::import::MeshChoice<'d>, Failure> {
    use crate::io::import::MeshChoice;
    if boolean(def.join_nodes) {
        return Ok(MeshChoice::Nodes(all));
    }
    Ok(match (string(def.mesh_name, "def.mesh_name")?, def.mesh_index) {
        (Some(name), _) => MeshChoice::Name(name),
        (None, u32::MAX) => MeshChoice::First,
        (None, index) => MeshChoice::Index(index as usize),
    })
}

#[cfg(feature = "gltf")]
unsafe fn add_imported(
    context: &Context,
    state: &mut State,
    imported: crate::io::import::Imported,
    options: &CrumpleExampleSetOptions,
    out: Out<CrumpleExampleSet>,
) -> Result<(), Failure> {
    let options = read_options(options, imported.mesh.positions.len())?;
    let (parts, meshes) = (imported.parts.clone(), imported.part_meshes());
    let text = |name: &Option<String>| name.as_deref().map(c_string);
    let materials: Vec<_> = imported.primitives.iter().map(|p| text(&p.material)).collect();
    let primitives = imported.primitives.iter().zip(&materials).map(|(p, material)| CrumplePrimitive {
        material: material.as_ref().map_or(std::ptr::null(), |m| m.as_ptr()),
        ..CrumplePrimitive::new(
            p.first_vertex..p.first_vertex + p.vertex_count,
            p.first_triangle..p.first_triangle + p.triangle_count,
        )
    });
    let primitives = primitives.collect();
    let materials = materials.into_iter().flatten().collect();
    let transform = imported.node_transform.map(|m| *bytemuck::cast_ref(&m));
    let file = (c_string(&imported.name), primitives, materials, transform);
    state.sets.reserve::<CrumpleExampleSet>()?;
    let tasks = Quiet(context.tasks());
    let mut set = ExampleSet::build(imported.mesh, imported.examples, options, &tasks)?;
    for mesh in meshes {
        set.add_lod(mesh, &tasks)?;
    }
    let id = insert_set(context, state, set, file, out);
    state.sets.get_mut(id, "set")?.parts = parts.into_iter().map(|part| part.name).collect();
    Ok(())
}
