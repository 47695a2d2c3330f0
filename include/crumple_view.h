// Crumple: how finely, and how soon, instances are shown.
//
// This file is generated from the library's source by `cargo xtask header`; do not edit it.

#ifndef CRUMPLE_VIEW_H
#define CRUMPLE_VIEW_H

#include "crumple.h"

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// Sets the time, s, for instances with a grow_time. Call it once a frame before deforming. When a dent appears, changes or
/// is repaired, its vertices and attached points move evenly to their new places during grow_time. Marks change at once,
/// and so does damage that is set, loaded, copied or reset.
CrumpleResult crumple_context_set_time(CrumpleContext *context, double time);

/// Chooses the level of detail of an instance for a camera. pixels is the error that you accept on screen, such as 0.5.
/// out_lod receives the level to show, the coarsest whose mean edge covers at most 16 * pixels; 0 without levels. Under a
/// vertex budget, near instances wait less than distant ones. distance is from the camera to the nearest point of the
/// instance, m, in the mesh's space; fov_y is the vertical field of view, radians; viewport_height is in pixels. out_lod
/// may be null. Call it every frame. Not for sets whose further meshes are parts of the body.
CrumpleResult crumple_instance_set_view(CrumpleContext *context, CrumpleInstance instance, float pixels, float distance,
                                        float fov_y, float viewport_height, uint32_t *out_lod);

/// Limits how many vertices a deform, recording, submit or plan writes, for frames with more hits than time. 0, which a
/// context begins with: no limit. A buffer is written whole or not at all, and at least one is written. Buffers with many
/// vertices, that have waited long, or that are near (crumple_instance_set_view()) come first. The others follow in later
/// calls, with the same vertices. A buffer that was never written does not wait.
CrumpleResult crumple_context_set_vertex_budget(CrumpleContext *context, uint64_t vertices);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CRUMPLE_VIEW_H */
