//! Example sets: loaded from baked files, shared, destroyed.

use super::boundary::{granted, succeeds};
use super::c_enum::c_enums;
use super::check::{Out, array, enumerator, required_string};
use super::context::{Context, CrumpleContext, CrumpleLogLevel, exclusive, look_into};
use super::primitive::{CrumplePrimitive, c_string};
use super::result::{CrumpleResult, Failure};
use super::store::{SetEntry, State};
use super::tasks::Quiet;
use super::types::CrumpleExampleSet;
use crate::example::set::ExampleSet;
use std::ffi::{CString, c_char, c_void};
use std::mem::MaybeUninit;
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

c_enums!(CrumpleBytes::Keep);

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
        state.sets.reserve::<CrumpleExampleSet>()?;
        let tasks = Quiet(context.tasks());
        let set = if keep { ExampleSet::load(bytes, &tasks) } else { ExampleSet::load_copy(bytes, &tasks) }?;
        add_baked(context, state, set, out)
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
        state.sets.reserve::<CrumpleExampleSet>()?;
        let set = ExampleSet::load_file(path, &Quiet(context.tasks()))?;
        add_baked(context, state, set, out)
    })
}

fn add_baked(
    context: &Context,
    state: &mut State,
    set: ExampleSet,
    out: Out<CrumpleExampleSet>,
) -> Result<(), Failure> {
    let whole = CrumplePrimitive::new(0..set.vertex_count() as u32, 0..set.mesh().triangles().len() as u32);
    insert_set(context, state, set, (c"".into(), vec![whole], Vec::new(), None), out).map(drop)
}

/// Gives a set an id, for which there is room.
pub(super) fn insert_set(
    context: &Context,
    state: &mut State,
    set: ExampleSet,
    (name, primitives, materials, node_transform): (CString, Vec<CrumplePrimitive>, Vec<CString>, Option<[f32; 16]>),
    out: Out<CrumpleExampleSet>,
) -> Result<CrumpleExampleSet, Failure> {
    let names = set.examples().iter().map(|e| c_string(e.name())).collect();
    for example in set.examples().iter().filter(|e| e.is_empty()) {
        context.log(CrumpleLogLevel::Warning, &format!("example '{}' moves no vertex", example.name()));
    }
    context.log(
        CrumpleLogLevel::Info,
        &format!(
            "example set: {} vertices, {} examples, {} bytes",
            set.vertex_count(),
            set.examples().len(),
            set.memory_bytes()
        ),
    );
    let parts = Vec::new();
    let entry = SetEntry { set: Arc::new(set), name, names, primitives, materials, node_transform, parts };
    granted()?;
    let id = state.sets.insert(entry);
    out.write(id);
    Ok(id)
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
