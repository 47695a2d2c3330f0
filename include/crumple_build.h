// Crumple: builds example sets from arrays, adds levels of detail to them, and saves them as baked sets.
//
// Games load baked sets (crumple.h). This header is for what makes them, and for bodies that are made at run time.
//
// This file is generated from the library's source by `cargo xtask header`; do not edit it.

#ifndef CRUMPLE_BUILD_H
#define CRUMPLE_BUILD_H

#include "crumple.h"

/// How an example's contact (the place where it was hit) is given.
typedef enum CrumpleContactKind {
    /// Not given: Crumple uses the example's deepest vertex. The default.
    CRUMPLE_CONTACT_KIND_NONE = 0,
    /// As a vertex of the base mesh.
    CRUMPLE_CONTACT_KIND_VERTEX = 1,
    /// As a point in the mesh's space. The vertex nearest to it becomes the contact.
    CRUMPLE_CONTACT_KIND_POINT = 2,
} CrumpleContactKind;

/// The type of triangle indices. CRUMPLE_INDEX_TYPE_U32 is the default.
typedef enum CrumpleIndexType {
    CRUMPLE_INDEX_TYPE_U32 = 0,
    CRUMPLE_INDEX_TYPE_U16 = 1,
} CrumpleIndexType;

/// An array that Crumple reads during the call. Element i is at data + i * stride. The field that uses it states count
/// and type. All fields zero: absent.
typedef struct CrumpleInput {
    /// First element, aligned to its type (4 bytes; 2 for 16-bit indices). Null: absent.
    const void *data;
    /// Readable bytes at data: at least (count - 1) * stride + the size of one element.
    size_t size;
    /// Bytes from one element to the next: at least the size of one element, a multiple of its alignment. Not 0.
    size_t stride;
} CrumpleInput;

/// An example: the base mesh after a collision. Set target_positions, or delta_indices and position_deltas.
typedef struct CrumpleExampleDef {
    uint32_t struct_size;
    /// Number of vertices in delta_indices, position_deltas and normal_deltas.
    uint32_t delta_count;
    /// UTF-8 text. It is copied and need not be unique. Null: empty.
    const char *name;
    /// Full form: the new position of every vertex, vertex_count times 3 floats, m, in the base mesh's order.
    CrumpleInput target_positions;
    /// Full form: the new unit normals, vertex_count times 3 floats. Absent: computed. Needs normals of the base mesh.
    CrumpleInput target_normals;
    /// Sparse form: indices of the moved vertices, strictly increasing, delta_count times uint32_t.
    CrumpleInput delta_indices;
    /// Sparse form: their displacements, delta_count times 3 floats, m.
    CrumpleInput position_deltas;
    /// Sparse form: the changes of their unit normals, delta_count times 3 floats. Absent: computed.
    CrumpleInput normal_deltas;
    CrumpleContactKind contact_kind;
    /// The vertex that was hit, for CRUMPLE_CONTACT_KIND_VERTEX.
    uint32_t contact_vertex;
    /// The point that was hit, m, in the mesh's space, for CRUMPLE_CONTACT_KIND_POINT.
    CrumpleVec3 contact_point;
    /// The surface's outward direction at the contact, of any length above 0. Used only if has_contact_normal is true.
    CrumpleVec3 contact_normal;
    /// The impulse on the body, N s. Default 0: unknown.
    CrumpleVec3 impulse;
    /// How long the impulse acted, s. Default 0: unknown.
    float duration;
    CrumpleStriker striker;
    /// Whether contact_normal is given. Default false: the mesh's normal is used.
    bool has_contact_normal;
} CrumpleExampleDef;

/// A mesh as arrays, which are copied.
typedef struct CrumpleMeshDef {
    uint32_t struct_size;
    /// Number of vertices, at least 1. Their order is kept.
    uint32_t vertex_count;
    /// Number of indices, a multiple of 3.
    uint32_t index_count;
    CrumpleIndexType index_type;
    /// Positions: vertex_count times 3 floats, m. Any handedness, any axis up. Required.
    CrumpleInput positions;
    /// Unit normals: vertex_count times 3 floats. Absent: computed from the triangles, smooth across seams.
    CrumpleInput normals;
    /// Tangents as in glTF: vertex_count times 4 floats, xyz of unit length, w +1 or -1. Absent: none.
    CrumpleInput tangents;
    /// Triangles: index_count indices, counter-clockwise seen from outside. Absent: a point cloud, which needs normals.
    CrumpleInput indices;
    /// How far each vertex may move: vertex_count floats, m, at least 0, INFINITY for no limit of its own. Rounded down by up to
    /// 1 in 128. The depth limits of the set and of the instance hold too. Absent: none; for a further mesh of a set, those
    /// of the nearest base vertices.
    CrumpleInput depth_limits;
    /// How much less than its dents each vertex moves: vertex_count floats, 0 (as the dents say) to 1 (not at all). Absent: 0;
    /// for a further mesh of a set, as the nearest base vertices.
    CrumpleInput stiffness;
} CrumpleMeshDef;

/// How an example set is built. The def that contains it sets its defaults.
typedef struct CrumpleExampleSetOptions {
    /// No vertex moves further than this, m. Default 0: three times the depth of the deepest example.
    float depth_limit;
    /// Displacements of an example up to this length are dropped, m. Default 0: drops only zeros.
    float drop_below;
    /// Mass of every vertex, kg, for impulses without a mass. It is a calibration constant in impulse * duration /
    /// mass, not the body's mass. Default 0: unknown.
    float vertex_mass;
    /// How far a vertex may be from where dents would put it, m: vertices follow a few of them, and more are added to these where
    /// vertices are wrong. Less takes more memory, and hits cost more. Default 0: as many as fit all bodies well.
    float basis_tolerance;
    /// Largest position error from quantisation at weight 1, m. Above 0, displacements are stored as integers of 1 or 2
    /// bytes. Default 0: exact floats. It changes the fingerprint; depth_limit and vertex_mass do not.
    float bake_tolerance;
    /// Largest error of a normal at weight 1, degrees, above 0 and up to 45. Unused if bake_tolerance is 0. Default 1.
    float bake_normal_tolerance;
    /// Mass of each vertex, kg: vertex_count floats, instead of vertex_mass. Default absent.
    CrumpleInput vertex_masses;
    /// Examples also count mirrored unless they contradict it, if the body is symmetric about a coordinate plane through the
    /// centre of its bounds. Default true.
    bool mirror;
    /// Dents fade to zero at boundary edges that no example moves. Default true.
    bool held_rims;
    /// Keep the examples whole in baked bytes too, as CRUMPLE_RULE_MOST_DISPLACED and CRUMPLE_RULE_BLEND need them. An
    /// example of a body of many vertices then takes ten times the memory. Default false.
    bool whole_examples;
} CrumpleExampleSetOptions;

/// A base mesh, at least one example, and the options of the set.
typedef struct CrumpleExampleSetDef {
    uint32_t struct_size;
    uint32_t example_count;
    /// The base mesh, from crumple_mesh_def_default(). Required.
    const CrumpleMeshDef *mesh;
    /// example_count defs, each from crumple_example_def_default().
    const CrumpleExampleDef *examples;
    CrumpleExampleSetOptions options;
} CrumpleExampleSetDef;

/// Everything within radius, m, of the segment between two points, m. Equal points make a ball.
typedef struct CrumpleCapsule {
    CrumpleVec3 a;
    CrumpleVec3 b;
    float radius;
} CrumpleCapsule;

/// Facts about an example. name is UTF-8, never null, and valid until the set is destroyed.
typedef struct CrumpleExampleInfo {
    const char *name;
    /// The vertex that was hit. If the example has no contact, the deepest vertex.
    uint32_t contact_vertex;
    /// Number of vertices that the example moves. 0: it has no effect.
    uint32_t moved_vertices;
    /// Where the example was hit, m.
    CrumpleVec3 contact_point;
    /// Outward unit normal at the contact; zero if unknown.
    CrumpleVec3 contact_normal;
    /// Displacement of the contact vertex, m.
    float depth;
    /// Displacement of the deepest vertex, m.
    float max_depth;
    /// Distance from the contact to the furthest vertex that moves noticeably, m.
    float support_radius;
    /// How well the others predict its displacements from its blow, or its contact's displacement: relative L2 error, 0 exact,
    /// 1 as wrong as no dent. Where it is large, one more example helps most.
    float field_error;
    uint64_t reserved;
} CrumpleExampleInfo;

/// What crumple_example_set_map_damage() did with the marks.
typedef struct CrumpleDamageMapping {
    /// Marks whose contact has a vertex at the same position in the new set.
    uint32_t kept;
    /// Marks that are now at another position, the nearest vertex.
    uint32_t moved;
    /// Marks left out because the nearest vertex is further than max_distance.
    uint32_t too_far;
    /// Marks left out because they tell a blow, and no example of the new set knows its own.
    uint32_t without_blows;
    /// The furthest that a mark moved, m.
    float distance;
    uint32_t reserved[3];
} CrumpleDamageMapping;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

CrumpleExampleDef crumple_example_def_default(void);
CrumpleExampleSetDef crumple_example_set_def_default(void);
/// Builds an example set from arrays. This indexes the mesh and samples every example, which takes time: build sets
/// while loading, or load baked ones. Errors: CRUMPLE_ERROR_MESH (no vertices), CRUMPLE_ERROR_EXAMPLE_MISMATCH (no
/// examples, or one that does not fit the mesh).
CrumpleResult crumple_example_set_create(CrumpleContext *context, const CrumpleExampleSetDef *def,
                                         CrumpleExampleSet *out_set);

CrumpleMeshDef crumple_mesh_def_default(void);
/// Adds a mesh of the same body, such as a level of detail or a collision proxy, in the base mesh's space. It shows the
/// same damage. Call this before the set's first instance is created. out_lod receives its number for the lod fields of
/// defs, 1 for the first. Each vertex is bound to the nearest point of the base surface and moves with it. A vertex at
/// the position of a base vertex moves exactly like that vertex. Contacts, marks, saved damage and the fingerprint
/// still refer to the base mesh. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (the set has instances), CRUMPLE_ERROR_MESH.
CrumpleResult crumple_example_set_add_lod(CrumpleContext *context, CrumpleExampleSet set, const CrumpleMeshDef *mesh,
                                          uint32_t *out_lod);

/// Writes an example set as the bytes of a .crumple file, equal on all machines.
CrumpleResult crumple_example_set_save_baked(CrumpleContext *context, CrumpleExampleSet set, void *data,
                                             size_t capacity, size_t *out_size);

/// Computes depth limits for a mesh, so that no dent moves a vertex into a solid, such as a roll cage or an engine: the
/// distance from the nearest of the capsules and closed meshes, 0 inside one, and at most the mesh's own limits. Of solids
/// the positions and indices are read. out_limits receives vertex_count floats, m; give them to the def as depth_limits.
/// Call it for each level of detail too. Error messages number the capsules before the meshes. CRUMPLE_ERROR_MESH: a solid
/// is not closed.
CrumpleResult crumple_mesh_keep_out(const CrumpleMeshDef *mesh, const CrumpleCapsule *capsules, uint32_t capsule_count,
                                    const CrumpleMeshDef *meshes, uint32_t mesh_count, float *out_limits);

/// Returns facts about the example with an index below example_count.
CrumpleResult crumple_example_set_get_example(CrumpleContext *context, CrumpleExampleSet set, uint32_t example,
                                              CrumpleExampleInfo *out_info);

/// Maps damage that was saved with old_set to set, another revision of it: a changed mesh, other examples. Each mark
/// goes to the nearest vertex, at most max_distance away, m (0 to infinity). A mark that does not fit is left out. data is
/// what crumple_instance_save_damage() or crumple_context_save_damage() gave; in the latter, damage of other sets stays
/// as it is. out_mapping may be null. Errors: CRUMPLE_ERROR_DAMAGE_MISMATCH (not old_set's, or another version, a
/// classic rule, or cut short), CRUMPLE_ERROR_INVALID_ARGUMENT (a mark that old_set cannot have, or max_distance).
CrumpleResult crumple_example_set_map_damage(CrumpleContext *context, CrumpleExampleSet set, CrumpleExampleSet old_set,
                                             const void *data, size_t size, float max_distance, void *mapped,
                                             size_t capacity, size_t *out_size, CrumpleDamageMapping *out_mapping);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CRUMPLE_BUILD_H */
