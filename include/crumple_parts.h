// Crumple: bodies whose parts come off, points that move with the surface, such as lamps, and colliders.
//
// This file is generated from the library's source by `cargo xtask header`; do not edit it.

#ifndef CRUMPLE_PARTS_H
#define CRUMPLE_PARTS_H

#include "crumple.h"

/// A point bound to the nearest surface. Plain data: you may copy or save it. It works with every instance of its set.
typedef struct CrumpleAttachment {
    /// Vertices of the triangle. All three are equal if the mesh has no triangles.
    uint32_t vertices[3];
    /// Barycentric weights of the surface point; they sum to 1.
    float weights[3];
    /// The attached point on the undamaged mesh, m, in the mesh's space.
    CrumpleVec3 point;
    uint32_t reserved[3];
} CrumpleAttachment;

/// A rotation as a unit quaternion.
typedef struct CrumpleQuat {
    float x;
    float y;
    float z;
    float w;
} CrumpleQuat;

/// The position of an attached point, and its rotation relative to the undamaged mesh.
typedef struct CrumplePose {
    /// Position, m, in the mesh's space.
    CrumpleVec3 position;
    CrumpleQuat rotation;
    uint32_t reserved[5];
} CrumplePose;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// Takes a part off a body. part is the number of a mesh of the set (crumple_example_set_add_lod()) whose vertices lie at
/// positions of base vertices; the base mesh is the whole body. out_part receives a new instance with the same options,
/// transform and damage. The body's buffers of that mesh become the new instance's. Hits on the new instance reach only
/// the part, and hits on the body only what is left of it. The call indexes the base mesh. Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (0, a part that is off already, the last part, a mesh without base vertices of its own),
/// CRUMPLE_ERROR_WRONG_RULE.
CrumpleResult crumple_instance_release_part(CrumpleContext *context, CrumpleInstance instance, uint32_t part,
                                            CrumpleInstance *out_part);

/// Puts a released part on its body again, or with false takes it off. It keeps its damage, instance and buffers. Hits on
/// the body, and the ends of their contacts, also reach the parts that are on it; other changes of damage do not. The call
/// indexes the base mesh. CRUMPLE_ERROR_INVALID_ARGUMENT: not a part of this body, or one that is on, or off, already.
CrumpleResult crumple_instance_mount_part(CrumpleContext *context, CrumpleInstance instance, CrumpleInstance part,
                                          bool mounted);

/// Makes a part rigid, such as glass, or no longer. Hits on it leave no mark; their status is CRUMPLE_HIT_STATUS_RIGID. To
/// keep its vertices in place too, register no buffer for it. Errors as for crumple_instance_release_part().
CrumpleResult crumple_instance_set_part_rigid(CrumpleContext *context, CrumpleInstance instance, uint32_t part,
                                              bool rigid);

/// Measures how far the vertices of mesh lod have moved, m: the furthest, and their mean. out_equivalent_depth receives the
/// depth of the single hit that does as much damage as all marks whose contact is on the mesh, m; it grows with every hit.
/// Growing dents count in full, so the results are equal on all machines. The call computes every vertex of the mesh. Any
/// output may be null.
CrumpleResult crumple_instance_measure_part(CrumpleContext *context, CrumpleInstance instance, uint32_t lod,
                                            float *out_deepest, float *out_mean, float *out_equivalent_depth);

/// Binds a point in the mesh's space, m, to the nearest surface. The point keeps its distance from the surface and
/// rotates with it. CRUMPLE_ERROR_INVALID_ARGUMENT: the point is further away than 1e9 m.
CrumpleResult crumple_example_set_attach_point(CrumpleContext *context, CrumpleExampleSet set, CrumpleVec3 point,
                                               CrumpleAttachment *out_attachment);

/// Returns the pose of an attached point on the dented instance, pending hits included. It needs no buffer. Errors:
/// CRUMPLE_ERROR_INDEX_OUT_OF_RANGE or CRUMPLE_ERROR_INVALID_ARGUMENT (an attachment of another set, or one not from
/// crumple_example_set_attach_point()).
CrumpleResult crumple_instance_get_attached_pose(CrumpleContext *context, CrumpleInstance instance,
                                                 const CrumpleAttachment *attachment, CrumplePose *out_pose);

/// Finds the vertex of the base mesh nearest to a point in the mesh's space, m. The lowest index wins a tie. Either
/// output may be null. out_distance is in m.
CrumpleResult crumple_example_set_find_nearest_vertex(CrumpleContext *context, CrumpleExampleSet set, CrumpleVec3 point,
                                                      uint32_t *out_vertex, float *out_distance);

/// Returns the triangles with a vertex that crumple_buffer_get_changes() returns, as increasing ranges that do not
/// overlap, in the order of the mesh's indices. out_bounds, which may be null, receives a box around those vertices
/// before and now, m, for the partial refit of a collider; zeros without changes.
/// Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (not a host buffer), CRUMPLE_ERROR_MESH (a mesh without indices).
CrumpleResult crumple_buffer_get_changed_triangles(CrumpleContext *context, CrumpleBuffer buffer, CrumpleRange *ranges,
                                                   uint32_t capacity, uint32_t *out_count, CrumpleAabb *out_bounds);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CRUMPLE_PARTS_H */
