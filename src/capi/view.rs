//! How finely, and how soon, instances are shown.

use super::prelude::*;
use crate::base::error::Error;

/// Sets the time, s, for instances with a grow_time. Call it once a frame before deforming. When a dent appears, changes or
/// is repaired, its vertices and attached points move evenly to their new places during grow_time. Marks change at once,
/// and so does damage that is set, loaded, copied or reset.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_set_time(context: *mut CrumpleContext, time: f64) -> CrumpleResult {
    exclusive("crumple_context_set_time", context, |_, state| {
        if !time.is_finite() {
            return Err(Error::NotFinite { name: "time".into(), value: time.to_string() }.into());
        }
        state.time = time;
        for (_, entry) in state.instances.iter_mut() {
            entry.instance.set_time(time)?;
        }
        Ok(())
    })
}

/// Chooses the level of detail of an instance for a camera. pixels is the error that you accept on screen, such as 0.5.
/// out_lod receives the level to show, the coarsest whose mean edge covers at most 16 * pixels; 0 without levels. Under a
/// vertex budget, near instances wait less than distant ones. distance is from the camera to the nearest point of the
/// instance, m, in the mesh's space; fov_y is the vertical field of view, radians; viewport_height is in pixels. out_lod
/// may be null. Call it every frame. Not for sets whose further meshes are parts of the body.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_instance_set_view(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    pixels: f32,
    distance: f32,
    fov_y: f32,
    viewport_height: f32,
    out_lod: *mut u32,
) -> CrumpleResult {
    exclusive("crumple_instance_set_view", context, |_, state| {
        let out = Out::optional(out_lod, "out_lod")?;
        out.answer(state.body(instance)?.set_view(pixels, distance, fov_y, viewport_height)? as u32)
    })
}

/// Limits how many vertices a deform, recording, submit or plan writes, for frames with more hits than time. 0, which a
/// context begins with: no limit. A buffer is written whole or not at all, and at least one is written. Buffers with many
/// vertices, that have waited long, or that are near (crumple_instance_set_view()) come first. The others follow in later
/// calls, with the same vertices. A buffer that was never written does not wait.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_set_vertex_budget(
    context: *mut CrumpleContext,
    vertices: u64,
) -> CrumpleResult {
    exclusive("crumple_context_set_vertex_budget", context, |_, state| {
        state.vertex_budget = if vertices == 0 { u64::MAX } else { vertices };
        Ok(())
    })
}
