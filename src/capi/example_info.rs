//! What an example is.

use super::check::{Out, item};
use super::context::{CrumpleContext, exclusive};
use super::result::CrumpleResult;
use super::types::{CrumpleExampleSet, CrumpleVec3};
use std::ffi::c_char;

/// Facts about an example. name is UTF-8, never null, and valid until the set is destroyed.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleExampleInfo {
    pub name: *const c_char,
    /// The vertex that was hit. If the example has no contact, the deepest vertex.
    pub contact_vertex: u32,
    /// Number of vertices that the example moves. 0: it has no effect.
    pub moved_vertices: u32,
    /// Where the example was hit, m.
    pub contact_point: CrumpleVec3,
    /// Outward unit normal at the contact; zero if unknown.
    pub contact_normal: CrumpleVec3,
    /// Displacement of the contact vertex, m.
    pub depth: f32,
    /// Displacement of the deepest vertex, m.
    pub max_depth: f32,
    /// Distance from the contact to the furthest vertex that moves noticeably, m.
    pub support_radius: f32,
    /// How well the others predict its displacements from its blow, or its contact's displacement: relative L2 error, 0 exact,
    /// 1 as wrong as no dent. Where it is large, one more example helps most.
    pub field_error: f32,
    pub reserved: u64,
}

/// Returns facts about the example with an index below example_count.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_get_example(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    example: u32,
    out_info: *mut CrumpleExampleInfo,
) -> CrumpleResult {
    exclusive("crumple_example_set_get_example", context, |_, state| {
        let out = Out::new(out_info, "out_info")?;
        let entry = state.sets.get(set, "set")?;
        let name = item(&entry.names, example, "example")?.as_ptr();
        let example_index = example as usize;
        let example = &entry.set.examples()[example_index];
        out.write(CrumpleExampleInfo {
            name,
            contact_vertex: example.contact_vertex(),
            moved_vertices: example.moved_vertices() as u32,
            contact_point: example.contact_point().into(),
            contact_normal: example.contact_normal().map(CrumpleVec3::from).unwrap_or_default(),
            depth: example.depth(),
            max_depth: example.max_depth(),
            support_radius: example.support_radius(),
            field_error: entry.set.example_errors()[example_index],
            reserved: 0,
        });
        Ok(())
    })
}
