//! Example sets from files.

use super::check::{CEnum, Def, MadeBy, Out, array, def, enumerator, string, write_array};
use super::context::{Context, CrumpleContext, State, exclusive, recorded};
use super::recording::Log;
use super::result::{CrumpleResult, Failure};
use super::set::{CrumpleExampleSetOptions, default_options, insert_set};
#[cfg(any(feature = "gltf", feature = "obj"))]
use super::set::{add_set, c_string, read_options};
use super::set_info::CrumplePrimitive;
use super::tasks::Quiet;
use super::types::CrumpleExampleSet;
use crate::ExampleSet;
use std::ffi::{c_char, c_void};
use std::mem::MaybeUninit;

/// Which mesh of a glTF file, and how it is made ready.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleGltfDef {
    /// Bytes of this struct, from crumple_gltf_def_default().
    pub struct_size: u32,
    /// Index of the mesh in the file, where mesh_name is null; UINT32_MAX: the first mesh that has morph targets.
    /// Default UINT32_MAX.
    pub mesh_index: u32,
    /// Name of the mesh, UTF-8. Null: mesh_index decides. Default null.
    pub mesh_name: *const c_char,
    /// Path of the .glb or .gltf file, UTF-8, for crumple_example_set_load_gltf(). For
    /// crumple_example_set_load_gltf_memory() the folder that files named in it are relative to; null: such files are
    /// an error.
    pub path: *const c_char,
    /// How the set is made ready. vertex_masses must be absent, or hold as many as the mesh has vertices.
    pub options: CrumpleExampleSetOptions,
}

/// A base OBJ and its examples, and how they are made ready.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleObjDef {
    /// Bytes of this struct, from crumple_obj_def_default().
    pub struct_size: u32,
    /// Number of example_paths, at least 1.
    pub example_count: u32,
    /// Path of the base mesh, UTF-8. Required.
    pub base_path: *const c_char,
    /// Paths of the examples, UTF-8: the base mesh after a collision, with the same vertices in the same order.
    pub example_paths: *const *const c_char,
    /// How the set is made ready.
    pub options: CrumpleExampleSetOptions,
}

// SAFETY: `repr(C)`, starts with its size, and any bytes are a value of it.
unsafe impl Def for CrumpleGltfDef {
    const DEFAULT: MadeBy<Self> = ("crumple_gltf_def_default", crumple_gltf_def_default);
}

// SAFETY: as above.
unsafe impl Def for CrumpleObjDef {
    const DEFAULT: MadeBy<Self> = ("crumple_obj_def_default", crumple_obj_def_default);
}

/// The first mesh with morph targets, with default options; set the path. Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_gltf_def_default() -> CrumpleGltfDef {
    CrumpleGltfDef {
        struct_size: size_of::<CrumpleGltfDef>() as u32,
        mesh_index: u32::MAX,
        mesh_name: std::ptr::null(),
        path: std::ptr::null(),
        options: default_options(),
    }
}

/// Default options; set the paths. Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_obj_def_default() -> CrumpleObjDef {
    CrumpleObjDef {
        struct_size: size_of::<CrumpleObjDef>() as u32,
        example_count: 0,
        base_path: std::ptr::null(),
        example_paths: std::ptr::null(),
        options: default_options(),
    }
}

/// Makes an example set from a glTF 2.0 or GLB file: a mesh with its morph targets, dense or sparse, all primitives
/// joined (see crumple_example_set_get_primitive()). Where the file has them, names come from mesh.extras.targetNames, contacts from
/// mesh.extras.impacts and placements from mesh.extras.placements. Numbers are those of the mesh's own space: scales and
/// rotations of nodes are not applied.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_IO, CRUMPLE_ERROR_FORMAT (malformed, or no such mesh: the text
/// lists those there are), CRUMPLE_ERROR_UNSUPPORTED (compressed with Draco or meshopt, or a build without
/// CRUMPLE_FEATURE_GLTF), CRUMPLE_ERROR_EXAMPLE_MISMATCH (no morph targets), and those of
/// crumple_example_set_create().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_load_gltf(
    context: *mut CrumpleContext,
    def: *const CrumpleGltfDef,
    out_set: *mut CrumpleExampleSet,
) -> CrumpleResult {
    recorded("crumple_example_set_load_gltf", context, |context, state, log| {
        // SAFETY: the caller's.
        let (def, out) = unsafe { (self::def(def, "def")?, Out::new(out_set, "out_set")?) };
        // SAFETY: the caller's.
        let path = required(unsafe { string(def.path, "def.path") }?, "def.path")?;
        #[cfg(feature = "gltf")]
        {
            // SAFETY: the caller's.
            let choice = unsafe { mesh_choice(&def) }?;
            let imported = crate::io::import::gltf_file(path.as_ref(), choice)?;
            // SAFETY: the caller's.
            unsafe { add_imported((context, state, log), imported, &def.options, out) }
        }
        #[cfg(not(feature = "gltf"))]
        {
            let _ = (context, state, log, path, out);
            Err(not_built("gltf"))
        }
    })
}

/// The same from the bytes of a file: size bytes at data, read during the call only, of any alignment.
///
/// Externally synchronised. Errors: as for crumple_example_set_load_gltf().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_load_gltf_memory(
    context: *mut CrumpleContext,
    data: *const c_void,
    size: usize,
    def: *const CrumpleGltfDef,
    out_set: *mut CrumpleExampleSet,
) -> CrumpleResult {
    recorded("crumple_example_set_load_gltf_memory", context, |context, state, log| {
        // SAFETY: the caller's.
        let (def, out) = unsafe { (self::def(def, "def")?, Out::new(out_set, "out_set")?) };
        // SAFETY: the caller's.
        let bytes = unsafe { array(data.cast::<u8>(), size, "data") }?;
        #[cfg(feature = "gltf")]
        {
            // SAFETY: the caller's.
            let (choice, folder) = unsafe { (mesh_choice(&def)?, string(def.path, "def.path")?) };
            let imported = crate::io::import::gltf_slice(bytes, folder.map(std::path::Path::new), choice)?;
            // SAFETY: the caller's.
            unsafe { add_imported((context, state, log), imported, &def.options, out) }
        }
        #[cfg(not(feature = "gltf"))]
        {
            let _ = (context, state, log, def, bytes, out);
            Err(not_built("gltf"))
        }
    })
}

/// Makes an example set from a base OBJ file and one OBJ file an example, which has the base's vertices in the base's
/// order and is named after its file. Polygons are cut into triangles.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_IO, CRUMPLE_ERROR_FORMAT, CRUMPLE_ERROR_UNSUPPORTED (a build
/// without CRUMPLE_FEATURE_OBJ), and those of crumple_example_set_create().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_load_obj(
    context: *mut CrumpleContext,
    def: *const CrumpleObjDef,
    out_set: *mut CrumpleExampleSet,
) -> CrumpleResult {
    recorded("crumple_example_set_load_obj", context, |context, state, log| {
        // SAFETY: the caller's.
        let (def, out) = unsafe { (self::def(def, "def")?, Out::new(out_set, "out_set")?) };
        // SAFETY: the caller's.
        let base = required(unsafe { string(def.base_path, "def.base_path") }?, "def.base_path")?;
        // SAFETY: the caller's.
        let paths = unsafe { array(def.example_paths, def.example_count as usize, "def.example_paths") }?;
        let mut examples = crate::base::error::reserve(paths.len(), "def.example_paths")?;
        for (i, &path) in paths.iter().enumerate() {
            let name = format!("def.example_paths[{i}]");
            // SAFETY: the caller's.
            examples.push(std::path::PathBuf::from(required(unsafe { string(path, &name) }?, &name)?));
        }
        #[cfg(feature = "obj")]
        {
            let imported = crate::io::import::obj_files(base.as_ref(), &examples)?;
            // SAFETY: the caller's.
            unsafe { add_imported((context, state, log), imported, &def.options, out) }
        }
        #[cfg(not(feature = "obj"))]
        {
            let _ = (context, state, log, base, examples, out);
            Err(not_built("obj"))
        }
    })
}

/// What becomes of the bytes that a set is loaded from.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrumpleBytes {
    /// They are copied: free them after the call.
    Copy = 0,
    /// They are kept and used where they lie: a memory map, or an asset that stays loaded. They must stay readable and must
    /// not change until the set was destroyed and all its instances with it, or the context. Where they do not begin at a
    /// multiple of 16 bytes they are copied all the same; do not rely on that.
    Keep = 1,
}

impl CEnum for CrumpleBytes {
    const ALL: &'static [Self] = &[Self::Copy, Self::Keep];
}

/// Makes an example set from the size bytes of a .crumple file at data, which "crumple bake" or crumple_example_set_save_baked()
/// wrote: at once, since nothing is built or unpacked. bytes tells whether they are copied or kept, see CrumpleBytes.
/// Everything in them is checked: no file can make Crumple read or write what it should not. The set has one primitive, no
/// name and no node transform.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED (out_set),
/// CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (bytes is no enumerator), CRUMPLE_ERROR_FORMAT (damaged, cut
/// short, or no baked set), CRUMPLE_ERROR_UNSUPPORTED (of another version of the format, or a big-endian processor),
/// CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_CONCURRENT_USE. Nothing is kept then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_load_baked_memory(
    context: *mut CrumpleContext,
    data: *const c_void,
    size: usize,
    bytes: MaybeUninit<CrumpleBytes>,
    out_set: *mut CrumpleExampleSet,
) -> CrumpleResult {
    recorded("crumple_example_set_load_baked_memory", context, |context, state, log| {
        // SAFETY: the caller's.
        let out = unsafe { Out::new(out_set, "out_set") }?;
        let keep = enumerator(bytes, "bytes")? == CrumpleBytes::Keep;
        // SAFETY: the caller's; kept bytes stay as they are for as long as the set lives.
        let bytes: &'static [u8] = unsafe { array(data.cast::<u8>(), size, "data") }?;
        state.sets.reserve::<CrumpleExampleSet>()?;
        let tasks = Quiet(context.tasks());
        let set = if keep { ExampleSet::load(bytes, &tasks) } else { ExampleSet::load_copy(bytes, &tasks) }?;
        add_baked((context, state, log), set, out);
        Ok(())
    })
}

/// The same from a file, which is read into memory: path is UTF-8.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_IO, CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ARGUMENT (path is
/// not UTF-8), and those of crumple_example_set_load_baked_memory().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_load_baked(
    context: *mut CrumpleContext,
    path: *const c_char,
    out_set: *mut CrumpleExampleSet,
) -> CrumpleResult {
    recorded("crumple_example_set_load_baked", context, |context, state, log| {
        // SAFETY: the caller's.
        let out = unsafe { Out::new(out_set, "out_set") }?;
        // SAFETY: the caller's.
        let path = required(unsafe { string(path, "path") }?, "path")?;
        state.sets.reserve::<CrumpleExampleSet>()?;
        let set = ExampleSet::load_file(path, &Quiet(context.tasks()))?;
        add_baked((context, state, log), set, out);
        Ok(())
    })
}

/// Saves an example set as the bytes of a .crumple file; the same bytes for the same set on every machine. data has room
/// for capacity bytes, of any alignment; with null and 0 only their number is told.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED (out_size),
/// CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_BUFFER_TOO_SMALL, CRUMPLE_ERROR_UNSUPPORTED (a big-endian processor),
/// CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_save_baked(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    data: *mut c_void,
    capacity: usize,
    out_size: *mut usize,
) -> CrumpleResult {
    exclusive("crumple_example_set_save_baked", context, |_, state| {
        // SAFETY: the caller's.
        let out = unsafe { Out::new(out_size, "out_size") }?;
        let set = &state.sets.get(set, "set")?.set;
        let size = if data.is_null() && capacity == 0 {
            set.saved_bytes()
        } else {
            let bytes = set.save()?;
            // SAFETY: the caller's.
            unsafe { write_array(&bytes, data.cast::<u8>(), capacity, "data") }?;
            bytes.len()
        };
        out.write(size);
        Ok(())
    })
}

fn add_baked(of: (&Context, &mut State, &mut Log<'_>), set: ExampleSet, out: Out<CrumpleExampleSet>) {
    let whole = CrumplePrimitive::new(0..set.vertex_count() as u32, 0..set.mesh().triangles().len() as u32);
    insert_set(of, set, (c"".into(), vec![whole], Vec::new(), None), out);
}

fn required<'a>(text: Option<&'a str>, name: &str) -> Result<&'a str, Failure> {
    text.ok_or_else(|| Failure::new(CrumpleResult::CrumpleErrorNullPointer, format!("{name} is null")))
}

#[cfg(not(all(feature = "gltf", feature = "obj", feature = "vulkan")))]
pub(super) fn not_built(feature: &str) -> Failure {
    let message = format!("this build cannot: build the library with the feature {feature}");
    Failure::new(CrumpleResult::CrumpleErrorUnsupported, message)
}

#[cfg(feature = "gltf")]
unsafe fn mesh_choice(def: &CrumpleGltfDef) -> Result<crate::io::import::MeshChoice<'_>, Failure> {
    use crate::io::import::MeshChoice;
    // SAFETY: the caller's.
    Ok(match (unsafe { string(def.mesh_name, "def.mesh_name") }?, def.mesh_index) {
        (Some(name), _) => MeshChoice::Name(name),
        (None, u32::MAX) => MeshChoice::First,
        (None, index) => MeshChoice::Index(index as usize),
    })
}

#[cfg(any(feature = "gltf", feature = "obj"))]
unsafe fn add_imported(
    of: (&Context, &mut State, &mut Log<'_>),
    imported: crate::io::import::Imported,
    options: &CrumpleExampleSetOptions,
    out: Out<CrumpleExampleSet>,
) -> Result<(), Failure> {
    // SAFETY: the caller's.
    let options = unsafe { read_options(options, imported.mesh.positions.len()) }?;
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
    add_set(of, (imported.mesh, imported.examples, options), file, out)
}
