//! Example sets: loaded from baked files, told of, destroyed.

use super::boundary::succeeds;
use super::context::look_into;
use super::memory::Stream;
use super::prelude::*;
use super::store::SetEntry;
use super::types::{CrumpleAabb, CrumpleStream};
use crate::example::set::ExampleSet;
use std::sync::Arc;

/// Whether the bytes of a baked set are copied.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(dead_code)] // made by C
pub enum CrumpleBytes {
    /// The bytes are copied. Free them after the call.
    Copy = 0,
    /// The bytes are used in place. They must stay readable and unchanged until the set, all its instances and its
    /// shared copies are destroyed. Bytes whose address is not a multiple of 16 are copied.
    Keep = 1,
}

/// Facts about an example set. Counts and bounds are the base mesh's. Strings are valid until the set is destroyed.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleExampleSetInfo {
    /// Name of the mesh in its file, UTF-8; empty for a set built from arrays. Never null.
    pub name: *const c_char,
    /// Equal for equal sets, on any machine. Saved damage fits only sets with the same fingerprint.
    pub fingerprint: u64,
    pub memory_bytes: u64,
    pub vertex_count: u32,
    pub triangle_count: u32,
    pub example_count: u32,
    /// Stretches of the mesh with a material of their own, at least 1; see crumple_import.h.
    pub primitive_count: u32,
    /// Number of positions that several vertices share.
    pub seam_count: u32,
    /// No vertex moves further than this, m.
    pub depth_limit: f32,
    pub bounds: CrumpleAabb,
    /// World matrix of the first glTF node that shows the mesh, column-major; the identity if there is none.
    pub node_transform: [f32; 16],
    pub has_tangents: bool,
    /// Number of meshes: 1 + added levels of detail.
    pub lod_count: u32,
    /// Number of examples whose impulse or striker is known. From 1 on, the set predicts what a blow leaves.
    pub blow_count: u32,
    /// Median of the examples' field_error.
    pub field_error: f32,
    pub reserved: [u64; 2],
}

/// Where to copy a mesh: positions (m), unit normals, tangents, 3 * triangle_count indices. Absent ones are skipped.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleMeshCopyDef {
    pub struct_size: u32,
    /// Which mesh: 0 for the base mesh, or a number from crumple_example_set_add_lod(). Default 0.
    pub lod: u32,
    pub positions: CrumpleStream,
    pub normals: CrumpleStream,
    pub tangents: CrumpleStream,
    pub indices: CrumpleStream,
}

c_enums!(CrumpleBytes::Keep);
defs!(CrumpleMeshCopyDef);

/// Loads an example set from the size bytes of a .crumple file at data, written by "crumple bake" or
/// crumple_example_set_save_baked(). Loading builds nothing, but checks all bytes. Errors: CRUMPLE_ERROR_FORMAT
/// (damaged, cut short, or not a baked set), CRUMPLE_ERROR_UNSUPPORTED (another format version).
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
        let tasks = &context.tasks;
        let set = if keep { ExampleSet::load(bytes, tasks) } else { ExampleSet::load_copy(bytes, tasks) }?;
        insert_set(context, state, SetEntry::new(set), out)
    })
}

/// Like crumple_example_set_load_baked_memory(), but reads the file at path, UTF-8. Also returns CRUMPLE_ERROR_IO.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_load_baked(
    context: *mut CrumpleContext,
    path: *const c_char,
    out_set: *mut CrumpleExampleSet,
) -> CrumpleResult {
    exclusive("crumple_example_set_load_baked", context, |context, state| {
        let out = Out::new(out_set, "out_set")?;
        let path = required_string(path, "path")?;
        let set = ExampleSet::load_file(path, &context.tasks)?;
        insert_set(context, state, SetEntry::new(set), out)
    })
}

/// Gives a set an id.
pub(super) fn insert_set(
    context: &Context,
    state: &mut State,
    entry: SetEntry,
    out: Out<CrumpleExampleSet>,
) -> Result<(), Failure> {
    let set = &entry.set;
    for example in set.examples().iter().filter(|e| e.is_empty()) {
        context.log(CrumpleLogLevel::Warning, &format!("example '{}' moves no vertex", example.name()));
    }
    let (vertices, examples, bytes) = (set.vertex_count(), set.examples().len(), set.memory_bytes());
    let message = format!("example set: {vertices} vertices, {examples} examples, {bytes} bytes");
    context.log(CrumpleLogLevel::Info, &message);
    state.sets.reserve()?;
    let entry = Arc::new(entry);
    granted()?;
    out.answer(state.sets.insert(entry))
}

/// Returns whether an id is that of a set of the context. False while another thread is inside the context.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_is_valid(context: *mut CrumpleContext, set: CrumpleExampleSet) -> bool {
    succeeds(|| look_into(context, |state| state.sets.get(set, "set").map(drop)))
}

/// Destroys a set. Its id and the strings of its infos become invalid. Instances keep the set's memory and still work.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_destroy(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
) -> CrumpleResult {
    exclusive("crumple_example_set_destroy", context, |_, state| {
        state.sets.remove(set, "set")?;
        Ok(())
    })
}

fn median(mut errors: Vec<f32>) -> f32 {
    errors.sort_by(f32::total_cmp);
    errors[errors.len() / 2]
}

/// Returns facts about a set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_get_info(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    out_info: *mut CrumpleExampleSetInfo,
) -> CrumpleResult {
    exclusive("crumple_example_set_get_info", context, |_, state| {
        let out = Out::new(out_info, "out_info")?;
        let entry = state.sets.get(set, "set")?;
        let (set, mesh) = (&*entry.set, entry.set.mesh());
        out.answer(CrumpleExampleSetInfo {
            name: entry.name.as_ptr(),
            fingerprint: set.fingerprint(),
            memory_bytes: set.memory_bytes() as u64,
            vertex_count: set.vertex_count() as u32,
            triangle_count: mesh.triangles().len() as u32,
            example_count: set.examples().len() as u32,
            primitive_count: entry.primitives.len() as u32,
            seam_count: mesh.seam_count() as u32,
            depth_limit: set.depth_limit(),
            bounds: mesh.bounds().into(),
            node_transform: entry.node_transform,
            has_tangents: mesh.tangents().is_some(),
            lod_count: set.lod_count() as u32,
            blow_count: set.examples().iter().filter(|e| e.blow().total_impulse().is_some()).count() as u32,
            field_error: median(set.example_errors()),
            reserved: [0; 2],
        })
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn crumple_mesh_copy_def_default() -> CrumpleMeshCopyDef {
    zeroed()
}

/// Copies the base mesh or a level of detail into your memory, for your vertex and index buffers. If the set was built
/// without normals, they are the computed ones. CRUMPLE_ERROR_MESH: the mesh lacks the requested normals or tangents.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_copy_mesh(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    def: *const CrumpleMeshCopyDef,
) -> CrumpleResult {
    exclusive("crumple_example_set_copy_mesh", context, |_, state| {
        let def = self::def(def, "def")?;
        let set = &state.sets.get(set, "set")?.set;
        let mesh = set.lod_mesh(def.lod as usize)?;
        let n = mesh.positions().len();
        let [positions, normals, tangents, indices] = Stream::all([
            ("def.positions", def.positions, (12, n)),
            ("def.normals", def.normals, (12, n)),
            ("def.tangents", def.tangents, (16, n)),
            ("def.indices", def.indices, (4, mesh.triangles().len() * 3)),
        ])?;
        if normals.is_some() && mesh.normals().is_none() {
            return Err(Failure::mesh("it has no normals"));
        }
        if tangents.is_some() && mesh.tangents().is_none() {
            return Err(Failure::mesh("it has no tangents"));
        }
        positions.inspect(|s| s.write(mesh.positions()));
        normals.inspect(|s| s.write(mesh.normals().unwrap_or_default()));
        tangents.inspect(|s| s.write(mesh.tangents().unwrap_or_default()));
        indices.inspect(|s| s.write(mesh.triangles().as_flattened()));
        Ok(())
    })
}
