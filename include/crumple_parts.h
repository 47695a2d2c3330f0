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
typedef struct CrumpleFrame {
    /// Position, m, in the mesh's space.
    CrumpleVec3 position;
    CrumpleQuat rotation;
    uint32_t reserved[5];
} CrumpleFrame;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// Takes a part off a body: mesh part of the set, a number from crumple_example_set_add_lod(). The base mesh is then the
/// whole body, and each part has vertices at the positions of base vertices. out_part receives an instance of its own
/// with the same options, transform and damage, and the body's buffers of the mesh become that instance's. Hits on it
/// land only on the part. Hits on the body land only on what is left. The call indexes the base mesh. Errors:
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

/// Measures how far the vertices of mesh lod have moved, m: the furthest, and their mean. out_energy receives the depth of
/// one hit that has the energy of all marks whose contact is on the mesh, m; it grows with every hit. Dents count in full
/// while they grow, so all are equal on all machines. Takes about as long as a deform of
/// the whole mesh. Any output may be null.
CrumpleResult crumple_instance_measure_part(CrumpleContext *context, CrumpleInstance instance, uint32_t lod,
                                            float *out_deepest, float *out_mean, float *out_energy);

/// Binds a point in the mesh's space, m, to the nearest surface. The point keeps its distance from the surface and
/// rotates with it. CRUMPLE_ERROR_INVALID_ARGUMENT: the point is further away than 1e9 m.
CrumpleResult crumple_example_set_attach_point(CrumpleContext *context, CrumpleExampleSet set, CrumpleVec3 point,
                                               CrumpleAttachment *out_attachment);

/// Returns the position of an attached point on the dented instance, pending hits included. It needs no buffer. Errors:
/// CRUMPLE_ERROR_INDEX_OUT_OF_RANGE or CRUMPLE_ERROR_INVALID_ARGUMENT (an attachment of another set, or one not from
/// crumple_example_set_attach_point()).
CrumpleResult crumple_instance_get_attached_frame(CrumpleContext *context, CrumpleInstance instance,
                                                  const CrumpleAttachment *attachment, CrumpleFrame *out_frame);

/// Finds the vertex of the base mesh nearest to a point in the mesh's space, m. The lowest index wins a tie. Either
/// output may be null. out_distance is in m.
CrumpleResult crumple_example_set_find_nearest_vertex(CrumpleContext *context, CrumpleExampleSet set, CrumpleVec3 point,
                                                      uint32_t *out_vertex, float *out_distance);

/// Returns the triangles with a vertex that crumple_buffer_get_changes() returns, as increasing ranges that do not
/// overlap, in the order of the mesh's indices. out_bounds, which may be null, receives a box around those vertices
/// before and now, m, for the partial refit of a collider; zeros without changes. The time is linear in the triangles.
/// Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (not a host buffer), CRUMPLE_ERROR_MESH (a mesh without indices).
CrumpleResult crumple_buffer_get_changed_triangles(CrumpleContext *context, CrumpleBuffer buffer, CrumpleRange *ranges,
                                                   uint32_t capacity, uint32_t *out_count, CrumpleAabb *out_bounds);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CRUMPLE_PARTS_H */
