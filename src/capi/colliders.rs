//! Buffers that colliders use.

use super::check::{Out, write_array};
use super::context::{CrumpleContext, exclusive};
use super::deform::c_ranges;
use super::result::{CrumpleResult, Failure};
use super::store::Memory;
use super::types::{CrumpleAabb, CrumpleBuffer, CrumpleRange};

/// Returns the triangles with a vertex that crumple_buffer_get_changes() returns, as increasing ranges that do not
/// overlap, in the order of the mesh's indices. out_bounds, which may be null, receives a box around those vertices
/// before and now, m, for the partial refit of a collider; zeros without changes.
/// Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (not a host buffer), CRUMPLE_ERROR_MESH (a mesh without indices).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_buffer_get_changed_triangles(
    context: *mut CrumpleContext,
    buffer: CrumpleBuffer,
    ranges: *mut CrumpleRange,
    capacity: u32,
    out_count: *mut u32,
    out_bounds: *mut CrumpleAabb,
) -> CrumpleResult {
    exclusive("crumple_buffer_get_changed_triangles", context, |_, state| {
        let outs = (Out::new(out_count, "out_count")?, Out::optional(out_bounds, "out_bounds")?);
        let entry = state.buffers.get(buffer, "buffer")?;
        let Memory::Host(_, tracker) = &entry.memory else {
            let what = "buffer is not a host buffer; register one of the collider's level of detail";
            return Err(Failure::invalid(what));
        };
        let set = state.instances.get(entry.owner, "instance")?.instance.example_set();
        let triangles = set.lod_mesh(entry.lod)?.triangles();
        if triangles.is_empty() {
            let what = format!("the mesh of level of detail {} has no triangles; give it indices", entry.lod);
            return Err(Failure::new(CrumpleResult::CrumpleErrorMesh, what));
        }
        let found = c_ranges(&tracker.changed_triangles(triangles))?;
        write_array(&found, ranges, capacity as usize, "ranges", outs.0)?;
        outs.1.write(tracker.changed_bounds().map_or_else(CrumpleAabb::default, CrumpleAabb::from));
        Ok(())
    })
}
