#ifndef CRUMPLE_H
#define CRUMPLE_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#define CRUMPLE_VERSION_MAJOR 0
#define CRUMPLE_VERSION_MINOR 2
#define CRUMPLE_VERSION_PATCH 0
#define CRUMPLE_VERSION (((CRUMPLE_VERSION_MAJOR * 1000000) + (CRUMPLE_VERSION_MINOR * 1000)) + CRUMPLE_VERSION_PATCH)
#define CRUMPLE_FEATURE_GLTF 1
#define CRUMPLE_FEATURE_OBJ 2
#define CRUMPLE_FEATURE_HOST_ALLOCATOR 4
#define CRUMPLE_FEATURE_VULKAN 8
typedef enum CrumpleResult {
    CRUMPLE_OK = 0,
    CRUMPLE_ERROR_INVALID_ARGUMENT = 1,
    CRUMPLE_ERROR_NOT_FINITE = 2,
    CRUMPLE_ERROR_INDEX_OUT_OF_RANGE = 3,
    CRUMPLE_ERROR_MESH = 4,
    CRUMPLE_ERROR_EXAMPLE_MISMATCH = 5,
    CRUMPLE_ERROR_BUFFER_TOO_SMALL = 6,
    CRUMPLE_ERROR_MISALIGNED = 7,
    CRUMPLE_ERROR_CONTACT_TOO_FAR = 8,
    CRUMPLE_ERROR_UNSUPPORTED = 9,
    CRUMPLE_ERROR_FORMAT = 10,
    CRUMPLE_ERROR_IO = 11,
    CRUMPLE_ERROR_DAMAGE_MISMATCH = 12,
    CRUMPLE_ERROR_OUT_OF_MEMORY = 13,
    CRUMPLE_ERROR_WRONG_RULE = 14,
    CRUMPLE_ERROR_VULKAN = 15,
    CRUMPLE_ERROR_DEVICE_LOST = 16,
    CRUMPLE_ERROR_UNKNOWN_CONTACT = 17,
    CRUMPLE_ERROR_NULL_POINTER = 64,
    CRUMPLE_ERROR_STRUCT_SIZE = 65,
    CRUMPLE_ERROR_INVALID_ID = 66,
    CRUMPLE_ERROR_CONCURRENT_USE = 67,
    CRUMPLE_ERROR_INTERNAL = 68,
    CRUMPLE_ERROR_FRAMES_IN_FLIGHT = 69,
} CrumpleResult;
typedef enum CrumpleLogLevel {
    CRUMPLE_LOG_LEVEL_INFO = 0,
    CRUMPLE_LOG_LEVEL_WARNING = 1,
} CrumpleLogLevel;
typedef enum CrumpleBytes {
    CRUMPLE_BYTES_COPY = 0,
    CRUMPLE_BYTES_KEEP = 1,
} CrumpleBytes;
typedef enum CrumpleRule {
    CRUMPLE_RULE_MARKS = 0,
    CRUMPLE_RULE_MOST_DISPLACED = 1,
    CRUMPLE_RULE_BLEND = 2,
} CrumpleRule;
typedef enum CrumpleSelection {
    CRUMPLE_SELECTION_CLASSIC = 0,
    CRUMPLE_SELECTION_CLASSIC_UNCLAMPED = 1,
} CrumpleSelection;
typedef enum CrumpleHitKind {
    CRUMPLE_HIT_KIND_BLOW = 0,
    CRUMPLE_HIT_KIND_DISPLACEMENT = 1,
} CrumpleHitKind;
typedef enum CrumpleSpace {
    CRUMPLE_SPACE_LOCAL = 0,
    CRUMPLE_SPACE_WORLD = 1,
} CrumpleSpace;
typedef enum CrumpleStrikerShape {
    CRUMPLE_STRIKER_SHAPE_UNKNOWN = 0,
    CRUMPLE_STRIKER_SHAPE_BALL = 1,
    CRUMPLE_STRIKER_SHAPE_POLE = 2,
    CRUMPLE_STRIKER_SHAPE_CORNER = 3,
    CRUMPLE_STRIKER_SHAPE_WALL = 4,
} CrumpleStrikerShape;
typedef enum CrumpleHitStatus {
    CRUMPLE_HIT_STATUS_MARKED = 0,
    CRUMPLE_HIT_STATUS_BELOW_YIELD = 1,
    CRUMPLE_HIT_STATUS_NOTHING_REACHES = 2,
    CRUMPLE_HIT_STATUS_ACCUMULATED = 3,
    CRUMPLE_HIT_STATUS_RIGID = 4,
} CrumpleHitStatus;
typedef enum CrumpleImpulses {
    CRUMPLE_IMPULSES_PER_POINT = 0,
    CRUMPLE_IMPULSES_WHOLE_AT_EVERY_POINT = 1,
    CRUMPLE_IMPULSES_ZERO_IS_UNKNOWN = 2,
} CrumpleImpulses;
typedef enum CrumpleDirectionFormat {
    CRUMPLE_DIRECTION_FORMAT_FLOAT = 0,
    CRUMPLE_DIRECTION_FORMAT_OCTAHEDRAL = 1,
} CrumpleDirectionFormat;
typedef struct CrumpleContext CrumpleContext;
typedef void (*CrumpleLog)(CrumpleLogLevel level, const char *message, void *user);
typedef void (*CrumpleTask)(uint32_t index, void *task_data);
typedef void (*CrumpleParallelFor)(uint32_t count, CrumpleTask task, void *task_data, void *user);
typedef struct CrumpleTaskSystem {
    CrumpleParallelFor parallel_for;
    void *user;
    uint32_t workers;
} CrumpleTaskSystem;
typedef struct CrumpleContextDef {
    uint32_t struct_size;
    uint32_t threads;
    CrumpleLog log;
    void *log_user;
    CrumpleTaskSystem tasks;
} CrumpleContextDef;
typedef struct CrumpleExampleSet {
    uint32_t index;
    uint16_t generation;
    uint16_t context;
} CrumpleExampleSet;
typedef struct CrumpleVec3 {
    float x;
    float y;
    float z;
} CrumpleVec3;
typedef struct CrumpleAabb {
    CrumpleVec3 min;
    CrumpleVec3 max;
} CrumpleAabb;
typedef struct CrumpleExampleSetInfo {
    const char *name;
    uint64_t fingerprint;
    uint64_t memory_bytes;
    uint32_t vertex_count;
    uint32_t triangle_count;
    uint32_t example_count;
    uint32_t primitive_count;
    uint32_t seam_count;
    float depth_limit;
    CrumpleAabb bounds;
    float node_transform[16];
    bool has_tangents;
    uint32_t lod_count;
    uint32_t blow_count;
    float field_error;
    uint64_t reserved[2];
} CrumpleExampleSetInfo;
typedef struct CrumpleStream {
    void *data;
    size_t size;
    size_t offset;
    size_t stride;
} CrumpleStream;
typedef struct CrumpleMeshCopyDef {
    uint32_t struct_size;
    uint32_t lod;
    CrumpleStream positions;
    CrumpleStream normals;
    CrumpleStream tangents;
    CrumpleStream indices;
} CrumpleMeshCopyDef;
typedef struct CrumpleInstanceDef {
    uint32_t struct_size;
    uint32_t mark_capacity;
    CrumpleExampleSet set;
    uint64_t user_data;
    CrumpleRule rule;
    CrumpleSelection selection;
    float depth_limit;
    float yield_impulse;
    float yield_displacement;
    float max_contact_distance;
    float blend_constant;
    float compliance;
    float grow_time;
    float local_to_world[16];
} CrumpleInstanceDef;
typedef struct CrumpleInstance {
    uint32_t index;
    uint16_t generation;
    uint16_t context;
} CrumpleInstance;
typedef struct CrumpleInstanceInfo {
    CrumpleExampleSet set;
    uint64_t memory_bytes;
    uint32_t mark_count;
    uint32_t buffer_count;
    float depth_limit;
    uint32_t contact_count;
    uint64_t revision;
    uint32_t reserved[2];
} CrumpleInstanceInfo;
typedef struct CrumpleStriker {
    float mass;
    float radius;
    CrumpleVec3 velocity;
    CrumpleStrikerShape shape;
    uint32_t reserved[2];
} CrumpleStriker;
typedef struct CrumpleHitDef {
    uint32_t struct_size;
    CrumpleHitKind kind;
    CrumpleSpace space;
    CrumpleVec3 point;
    CrumpleVec3 displacement;
    CrumpleVec3 impulse;
    float duration;
    float mass;
    CrumpleVec3 normal;
    CrumpleStriker striker;
    uint64_t contact_id;
} CrumpleHitDef;
typedef struct CrumpleMark {
    uint32_t contact;
    float depth;
    uint64_t hits;
    uint16_t told;
    uint16_t striker;
    uint16_t direction[2];
    uint16_t strength;
    uint16_t mass;
    uint16_t radius;
    uint16_t reserved;
} CrumpleMark;
typedef struct CrumpleHitResult {
    CrumpleHitStatus status;
    uint32_t contact_vertex;
    float contact_distance;
    CrumpleVec3 target;
    CrumpleVec3 achieved;
    float expected_error;
    bool clamped;
    CrumpleMark mark;
    uint32_t reserved[7];
} CrumpleHitResult;
typedef struct CrumpleContactOptionsDef {
    uint32_t struct_size;
    CrumpleImpulses impulses;
    float gain;
    float min_speed;
    float min_energy;
    float dent_radius;
    float touch_time;
    float separation_time;
    uint32_t max_points;
    uint32_t max_touches;
} CrumpleContactOptionsDef;
typedef struct CrumpleContactPointDef {
    uint32_t struct_size;
    bool has_velocity;
    bool has_velocity_after;
    uint64_t pair;
    CrumpleInstance bodies[2];
    CrumpleVec3 point;
    CrumpleVec3 normal;
    CrumpleVec3 velocity;
    CrumpleVec3 velocity_after;
    float impulse;
    float masses[2];
    float inverse_mass;
    float radii[2];
    CrumpleStrikerShape shapes[2];
    float gain;
} CrumpleContactPointDef;
typedef struct CrumpleContactReport {
    uint64_t points;
    uint64_t hits;
    uint64_t begun;
    uint64_t ended;
    uint64_t open;
    uint64_t slow;
    uint64_t separating;
    uint64_t weak;
    uint64_t crowded;
    uint64_t refused;
    CrumpleResult refusal;
    uint32_t reserved[3];
} CrumpleContactReport;
typedef struct CrumpleHostBufferDef {
    uint32_t struct_size;
    uint32_t lod;
    uint64_t user_data;
    CrumpleStream positions;
    CrumpleStream normals;
    CrumpleStream tangents;
    CrumpleDirectionFormat normal_format;
    CrumpleDirectionFormat tangent_format;
} CrumpleHostBufferDef;
typedef struct CrumpleBuffer {
    uint32_t index;
    uint16_t generation;
    uint16_t context;
} CrumpleBuffer;
typedef struct CrumpleBufferInfo {
    CrumpleBuffer buffer;
    CrumpleInstance instance;
    uint64_t user_data;
    uint64_t instance_user_data;
    uint32_t lod;
    uint32_t reserved[3];
} CrumpleBufferInfo;
typedef struct CrumpleDeformReport {
    uint64_t vertices_written;
    uint64_t blocks_written;
    uint64_t blocks_skipped;
    uint64_t vertices_waiting;
    uint64_t reserved[3];
} CrumpleDeformReport;
typedef struct CrumpleRange {
    uint32_t first;
    uint32_t count;
} CrumpleRange;
#ifdef __cplusplus
extern "C" {
#endif // __cplusplus
uint32_t crumple_version(void);
const char *crumple_version_string(void);
uint64_t crumple_features(void);
const char *crumple_last_error(void);
const char *crumple_result_name(CrumpleResult result);
CrumpleContextDef crumple_context_def_default(void);
CrumpleResult crumple_context_create(const CrumpleContextDef *def, CrumpleContext **out_context);
CrumpleResult crumple_context_destroy(CrumpleContext *context);
CrumpleResult crumple_example_set_load_baked_memory(CrumpleContext *context, const void *data, size_t size,
                                                    CrumpleBytes bytes, CrumpleExampleSet *out_set);
CrumpleResult crumple_example_set_load_baked(CrumpleContext *context, const char *path, CrumpleExampleSet *out_set);
bool crumple_example_set_is_valid(CrumpleContext *context, CrumpleExampleSet set);
CrumpleResult crumple_example_set_destroy(CrumpleContext *context, CrumpleExampleSet set);
CrumpleResult crumple_example_set_get_info(CrumpleContext *context, CrumpleExampleSet set,
                                           CrumpleExampleSetInfo *out_info);
CrumpleMeshCopyDef crumple_mesh_copy_def_default(void);
CrumpleResult crumple_example_set_copy_mesh(CrumpleContext *context, CrumpleExampleSet set,
                                            const CrumpleMeshCopyDef *def);
CrumpleInstanceDef crumple_instance_def_default(void);
CrumpleResult crumple_instance_create(CrumpleContext *context, const CrumpleInstanceDef *def,
                                      CrumpleInstance *out_instance);
CrumpleResult crumple_instance_destroy(CrumpleContext *context, CrumpleInstance instance);
bool crumple_instance_is_valid(CrumpleContext *context, CrumpleInstance instance);
CrumpleResult crumple_instance_set_user_data(CrumpleContext *context, CrumpleInstance instance, uint64_t user_data);
CrumpleResult crumple_instance_get_user_data(CrumpleContext *context, CrumpleInstance instance, uint64_t *out_data);
CrumpleResult crumple_instance_get_info(CrumpleContext *context, CrumpleInstance instance,
                                        CrumpleInstanceInfo *out_info);
CrumpleResult crumple_instance_set_transform(CrumpleContext *context, CrumpleInstance instance,
                                             const float *local_to_world);
CrumpleResult crumple_instance_set_depth_limit(CrumpleContext *context, CrumpleInstance instance, float depth_limit);
CrumpleHitDef crumple_hit_def_default(void);
CrumpleResult crumple_instance_submit_hit(CrumpleContext *context, CrumpleInstance instance, const CrumpleHitDef *def,
                                          CrumpleHitResult *out_result);
CrumpleResult crumple_context_submit_hits(CrumpleContext *context, const CrumpleInstance *instances,
                                          const CrumpleHitDef *defs, uint32_t count, CrumpleHitResult *out_results);
CrumpleResult crumple_instance_preview_hit(CrumpleContext *context, CrumpleInstance instance, const CrumpleHitDef *def,
                                           CrumpleHitResult *out_result);
CrumpleContactOptionsDef crumple_contact_options_def_default(void);
CrumpleResult crumple_context_set_contact_options(CrumpleContext *context, const CrumpleContactOptionsDef *options);
CrumpleContactPointDef crumple_contact_point_def_default(void);
CrumpleResult crumple_context_report_contacts(CrumpleContext *context, const CrumpleContactPointDef *points,
                                              uint32_t count);
CrumpleResult crumple_context_step_contacts(CrumpleContext *context, float seconds, CrumpleContactReport *out_report);
CrumpleResult crumple_context_clear_contacts(CrumpleContext *context);
CrumpleResult crumple_instance_get_marks(CrumpleContext *context, CrumpleInstance instance, CrumpleMark *marks,
                                         uint32_t capacity, uint32_t *out_count);
CrumpleResult crumple_instance_set_marks(CrumpleContext *context, CrumpleInstance instance, const CrumpleMark *marks,
                                         uint32_t count);
CrumpleResult crumple_instance_save_damage(CrumpleContext *context, CrumpleInstance instance, void *data,
                                           size_t capacity, size_t *out_size);
CrumpleResult crumple_instance_load_damage(CrumpleContext *context, CrumpleInstance instance, const void *data,
                                           size_t size);
CrumpleResult crumple_context_save_damage(CrumpleContext *context, const CrumpleInstance *instances, uint32_t count,
                                          void *data, size_t capacity, size_t *out_size);
CrumpleResult crumple_context_load_damage(CrumpleContext *context, const CrumpleInstance *instances, uint32_t count,
                                          const void *data, size_t size);
CrumpleResult crumple_instance_repair_damage(CrumpleContext *context, CrumpleInstance instance, float keep);
CrumpleResult crumple_instance_repair_around(CrumpleContext *context, CrumpleInstance instance, CrumpleVec3 point,
                                             float radius, float keep);
CrumpleResult crumple_instance_reset_damage(CrumpleContext *context, CrumpleInstance instance);
CrumpleResult crumple_instance_copy_damage(CrumpleContext *context, CrumpleInstance instance, CrumpleInstance source);
CrumpleHostBufferDef crumple_host_buffer_def_default(void);
CrumpleResult crumple_buffer_register_host(CrumpleContext *context, CrumpleInstance instance,
                                           const CrumpleHostBufferDef *def, CrumpleBuffer *out_buffer);
CrumpleResult crumple_buffer_unregister(CrumpleContext *context, CrumpleBuffer buffer);
bool crumple_buffer_is_valid(CrumpleContext *context, CrumpleBuffer buffer);
CrumpleResult crumple_buffer_get_info(CrumpleContext *context, CrumpleBuffer buffer, CrumpleBufferInfo *out_info);
CrumpleResult crumple_buffer_invalidate(CrumpleContext *context, CrumpleBuffer buffer);
CrumpleResult crumple_buffer_set_memory(CrumpleContext *context, CrumpleBuffer buffer, const CrumpleHostBufferDef *def);
CrumpleResult crumple_context_deform(CrumpleContext *context, const CrumpleBuffer *buffers, uint32_t count,
                                     CrumpleDeformReport *out_report);
CrumpleResult crumple_context_get_changed_buffers(CrumpleContext *context, CrumpleBufferInfo *buffers,
                                                  uint32_t capacity, uint32_t *out_count);
CrumpleResult crumple_buffer_get_changes(CrumpleContext *context, CrumpleBuffer buffer, CrumpleRange *ranges,
                                         uint32_t capacity, uint32_t *out_count, CrumpleAabb *out_bounds);
#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus
#endif  /* CRUMPLE_H */
#ifndef CRUMPLE_BUILD_H
#define CRUMPLE_BUILD_H
typedef enum CrumpleContactKind {
    CRUMPLE_CONTACT_KIND_NONE = 0,
    CRUMPLE_CONTACT_KIND_VERTEX = 1,
    CRUMPLE_CONTACT_KIND_POINT = 2,
} CrumpleContactKind;
typedef enum CrumpleIndexType {
    CRUMPLE_INDEX_TYPE_U32 = 0,
    CRUMPLE_INDEX_TYPE_U16 = 1,
} CrumpleIndexType;
typedef struct CrumpleInput {
    const void *data;
    size_t size;
    size_t stride;
} CrumpleInput;
typedef struct CrumpleExampleDef {
    uint32_t struct_size;
    uint32_t delta_count;
    const char *name;
    CrumpleInput target_positions;
    CrumpleInput target_normals;
    CrumpleInput delta_indices;
    CrumpleInput position_deltas;
    CrumpleInput normal_deltas;
    CrumpleContactKind contact_kind;
    uint32_t contact_vertex;
    CrumpleVec3 contact_point;
    CrumpleVec3 contact_normal;
    CrumpleVec3 impulse;
    float duration;
    CrumpleStriker striker;
    bool has_contact_normal;
} CrumpleExampleDef;
typedef struct CrumpleMeshDef {
    uint32_t struct_size;
    uint32_t vertex_count;
    uint32_t index_count;
    CrumpleIndexType index_type;
    CrumpleInput positions;
    CrumpleInput normals;
    CrumpleInput tangents;
    CrumpleInput indices;
    CrumpleInput depth_limits;
    CrumpleInput stiffness;
} CrumpleMeshDef;
typedef struct CrumpleExampleSetOptions {
    float depth_limit;
    float drop_below;
    float vertex_mass;
    float basis_tolerance;
    float bake_tolerance;
    float bake_normal_tolerance;
    CrumpleInput vertex_masses;
    bool mirror;
    bool held_rims;
    bool whole_examples;
} CrumpleExampleSetOptions;
typedef struct CrumpleExampleSetDef {
    uint32_t struct_size;
    uint32_t example_count;
    const CrumpleMeshDef *mesh;
    const CrumpleExampleDef *examples;
    CrumpleExampleSetOptions options;
} CrumpleExampleSetDef;
typedef struct CrumpleCapsule {
    CrumpleVec3 a;
    CrumpleVec3 b;
    float radius;
} CrumpleCapsule;
typedef struct CrumpleExampleInfo {
    const char *name;
    uint32_t contact_vertex;
    uint32_t moved_vertices;
    CrumpleVec3 contact_point;
    CrumpleVec3 contact_normal;
    float depth;
    float max_depth;
    float support_radius;
    float field_error;
    uint64_t reserved;
} CrumpleExampleInfo;
typedef struct CrumpleDamageMapping {
    uint32_t kept;
    uint32_t moved;
    uint32_t too_far;
    uint32_t without_blows;
    float distance;
    uint32_t reserved[3];
} CrumpleDamageMapping;
#ifdef __cplusplus
extern "C" {
#endif // __cplusplus
CrumpleExampleDef crumple_example_def_default(void);
CrumpleExampleSetDef crumple_example_set_def_default(void);
CrumpleResult crumple_example_set_create(CrumpleContext *context, const CrumpleExampleSetDef *def,
                                         CrumpleExampleSet *out_set);
CrumpleMeshDef crumple_mesh_def_default(void);
CrumpleResult crumple_example_set_add_lod(CrumpleContext *context, CrumpleExampleSet set, const CrumpleMeshDef *mesh,
                                          uint32_t *out_lod);
CrumpleResult crumple_example_set_save_baked(CrumpleContext *context, CrumpleExampleSet set, void *data,
                                             size_t capacity, size_t *out_size);
CrumpleResult crumple_mesh_keep_out(const CrumpleMeshDef *mesh, const CrumpleCapsule *capsules, uint32_t capsule_count,
                                    const CrumpleMeshDef *meshes, uint32_t mesh_count, float *out_limits);
CrumpleResult crumple_example_set_get_example(CrumpleContext *context, CrumpleExampleSet set, uint32_t example,
                                              CrumpleExampleInfo *out_info);
CrumpleResult crumple_example_set_map_damage(CrumpleContext *context, CrumpleExampleSet set, CrumpleExampleSet old_set,
                                             const void *data, size_t size, float max_distance, void *mapped,
                                             size_t capacity, size_t *out_size, CrumpleDamageMapping *out_mapping);
#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus
#endif  /* CRUMPLE_BUILD_H */
#ifndef CRUMPLE_IMPORT_H
#define CRUMPLE_IMPORT_H
typedef struct CrumpleGltfDef {
    uint32_t struct_size;
    uint32_t mesh_index;
    const char *mesh_name;
    const char *path;
    bool join_nodes;
    float unit;
    const char *nodes;
    const char *targets;
    const char *rigid;
    const char *glass;
    const char *moving;
    CrumpleExampleSetOptions options;
} CrumpleGltfDef;
typedef struct CrumpleObjDef {
    uint32_t struct_size;
    uint32_t example_count;
    const char *base_path;
    const char *const *example_paths;
    CrumpleExampleSetOptions options;
} CrumpleObjDef;
typedef struct CrumplePrimitive {
    const char *material;
    uint32_t first_vertex;
    uint32_t vertex_count;
    uint32_t first_triangle;
    uint32_t triangle_count;
    uint32_t reserved[2];
} CrumplePrimitive;
#ifdef __cplusplus
extern "C" {
#endif // __cplusplus
CrumpleGltfDef crumple_gltf_def_default(void);
CrumpleResult crumple_example_set_load_gltf(CrumpleContext *context, const CrumpleGltfDef *def,
                                            CrumpleExampleSet *out_set);
CrumpleResult crumple_example_set_load_gltf_memory(CrumpleContext *context, const void *data, size_t size,
                                                   const CrumpleGltfDef *def, CrumpleExampleSet *out_set);
CrumpleObjDef crumple_obj_def_default(void);
CrumpleResult crumple_example_set_load_obj(CrumpleContext *context, const CrumpleObjDef *def,
                                           CrumpleExampleSet *out_set);
CrumpleResult crumple_example_set_get_primitive(CrumpleContext *context, CrumpleExampleSet set, uint32_t primitive,
                                                CrumplePrimitive *out_primitive);
CrumpleResult crumple_example_set_find_part(CrumpleContext *context, CrumpleExampleSet set, const char *name,
                                            uint32_t *out_lod);
#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus
#endif  /* CRUMPLE_IMPORT_H */
#ifndef CRUMPLE_PARTS_H
#define CRUMPLE_PARTS_H
typedef struct CrumpleAttachment {
    uint32_t vertices[3];
    float weights[3];
    CrumpleVec3 point;
    uint32_t reserved[3];
} CrumpleAttachment;
typedef struct CrumpleQuat {
    float x;
    float y;
    float z;
    float w;
} CrumpleQuat;
typedef struct CrumplePose {
    CrumpleVec3 position;
    CrumpleQuat rotation;
    uint32_t reserved[5];
} CrumplePose;
#ifdef __cplusplus
extern "C" {
#endif // __cplusplus
CrumpleResult crumple_instance_release_part(CrumpleContext *context, CrumpleInstance instance, uint32_t part,
                                            CrumpleInstance *out_part);
CrumpleResult crumple_instance_mount_part(CrumpleContext *context, CrumpleInstance instance, CrumpleInstance part,
                                          bool mounted);
CrumpleResult crumple_instance_set_part_rigid(CrumpleContext *context, CrumpleInstance instance, uint32_t part,
                                              bool rigid);
CrumpleResult crumple_instance_measure_part(CrumpleContext *context, CrumpleInstance instance, uint32_t lod,
                                            float *out_deepest, float *out_mean, float *out_equivalent_depth);
CrumpleResult crumple_example_set_attach_point(CrumpleContext *context, CrumpleExampleSet set, CrumpleVec3 point,
                                               CrumpleAttachment *out_attachment);
CrumpleResult crumple_instance_get_attached_pose(CrumpleContext *context, CrumpleInstance instance,
                                                 const CrumpleAttachment *attachment, CrumplePose *out_pose);
CrumpleResult crumple_example_set_find_nearest_vertex(CrumpleContext *context, CrumpleExampleSet set, CrumpleVec3 point,
                                                      uint32_t *out_vertex, float *out_distance);
CrumpleResult crumple_buffer_get_changed_triangles(CrumpleContext *context, CrumpleBuffer buffer, CrumpleRange *ranges,
                                                   uint32_t capacity, uint32_t *out_count, CrumpleAabb *out_bounds);
#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus
#endif  /* CRUMPLE_PARTS_H */
#ifndef CRUMPLE_CONTACTS_H
#define CRUMPLE_CONTACTS_H
typedef struct CrumpleContactHit {
    uint64_t pair;
    uint64_t contact_id;
    CrumpleInstance instance;
    CrumpleVec3 point;
    CrumpleVec3 impulse;
    CrumpleHitResult result;
} CrumpleContactHit;
#ifdef __cplusplus
extern "C" {
#endif // __cplusplus
CrumpleResult crumple_instance_end_contact(CrumpleContext *context, CrumpleInstance instance, uint64_t contact_id);
CrumpleResult crumple_instance_get_contact(CrumpleContext *context, CrumpleInstance instance, uint64_t contact_id,
                                           CrumpleHitResult *out_result);
CrumpleResult crumple_context_get_contact_hits(CrumpleContext *context, CrumpleContactHit *hits, uint32_t capacity,
                                               uint32_t *out_count);
CrumpleResult crumple_context_get_contact_totals(CrumpleContext *context, CrumpleContactReport *out_report);
#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus
#endif  /* CRUMPLE_CONTACTS_H */
#ifndef CRUMPLE_VIEW_H
#define CRUMPLE_VIEW_H
#ifdef __cplusplus
extern "C" {
#endif // __cplusplus
CrumpleResult crumple_context_set_time(CrumpleContext *context, double time);
CrumpleResult crumple_instance_set_view(CrumpleContext *context, CrumpleInstance instance, float pixels, float distance,
                                        float fov_y, float viewport_height, uint32_t *out_lod);
CrumpleResult crumple_context_set_vertex_budget(CrumpleContext *context, uint64_t vertices);
#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus
#endif  /* CRUMPLE_VIEW_H */
#ifndef CRUMPLE_HOST_H
#define CRUMPLE_HOST_H
typedef void *(*CrumpleAlloc)(size_t size, size_t align, void *user);
typedef void (*CrumpleFree)(void *pointer, size_t size, size_t align, void *user);
typedef struct CrumpleAllocatorDef {
    uint32_t struct_size;
    CrumpleAlloc alloc;
    CrumpleFree free;
    void *user;
} CrumpleAllocatorDef;
#ifdef __cplusplus
extern "C" {
#endif // __cplusplus
CrumpleAllocatorDef crumple_allocator_def_default(void);
CrumpleResult crumple_allocator_set(const CrumpleAllocatorDef *allocator);
CrumpleResult crumple_example_set_share(CrumpleContext *context, CrumpleExampleSet set, CrumpleContext *other,
                                        CrumpleExampleSet *out_set);
#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus
#endif  /* CRUMPLE_HOST_H */
#ifndef CRUMPLE_VULKAN_H
#define CRUMPLE_VULKAN_H
typedef enum CrumpleHandleType {
    CRUMPLE_HANDLE_TYPE_OPAQUE_FD = 0,
    CRUMPLE_HANDLE_TYPE_OPAQUE_WIN32 = 1,
} CrumpleHandleType;
typedef void (*CrumpleVulkanFunction)(void);
typedef struct CrumpleVulkanAttachDef {
    uint32_t struct_size;
    uint32_t queue_family;
    CrumpleVulkanFunction get_instance_proc_addr;
    void *instance;
    void *physical_device;
    void *device;
    const void *pipeline_cache;
    size_t pipeline_cache_size;
    uint32_t workgroup_size;
} CrumpleVulkanAttachDef;
typedef struct CrumpleVulkanStream {
    uint64_t offset;
    uint64_t stride;
    uint32_t format;
    uint32_t reserved;
} CrumpleVulkanStream;
typedef struct CrumpleVulkanBufferDef {
    uint32_t struct_size;
    uint32_t lod;
    uint64_t user_data;
    uint64_t buffer;
    uint64_t buffer_size;
    uint32_t usage;
    uint32_t queue_family;
    uint32_t before_stages;
    uint32_t before_access;
    uint32_t after_stages;
    uint32_t after_access;
    uint64_t offset;
    uint64_t size;
    CrumpleVulkanStream positions;
    CrumpleVulkanStream normals;
    CrumpleVulkanStream tangents;
    CrumpleVec3 scale;
    CrumpleVec3 bias;
} CrumpleVulkanBufferDef;
typedef struct CrumpleRecordReport {
    uint64_t vertices_written;
    uint64_t blocks_written;
    uint64_t blocks_skipped;
    uint64_t bytes_copied;
    uint32_t dispatches;
    uint32_t reserved0;
    uint64_t vertices_waiting;
    uint64_t reserved[3];
} CrumpleRecordReport;
typedef struct CrumpleVulkanOpenDef {
    uint32_t struct_size;
    uint32_t workgroup_size;
    CrumpleVulkanFunction get_instance_proc_addr;
    uint8_t device_uuid[16];
    const void *pipeline_cache;
    size_t pipeline_cache_size;
} CrumpleVulkanOpenDef;
typedef struct CrumpleVulkanImportDef {
    uint32_t struct_size;
    CrumpleHandleType handle_type;
    int64_t handle;
    uint64_t memory_size;
    uint32_t memory_type;
    uint32_t usage;
    uint64_t offset;
    uint64_t size;
    bool dedicated;
} CrumpleVulkanImportDef;
#ifdef __cplusplus
extern "C" {
#endif // __cplusplus
CrumpleVulkanAttachDef crumple_vulkan_attach_def_default(void);
CrumpleResult crumple_vulkan_attach(CrumpleContext *context, const CrumpleVulkanAttachDef *def);
CrumpleResult crumple_vulkan_detach(CrumpleContext *context);
CrumpleResult crumple_vulkan_get_pipeline_cache(CrumpleContext *context, void *data, size_t capacity, size_t *out_size);
CrumpleVulkanBufferDef crumple_vulkan_buffer_def_default(void);
CrumpleResult crumple_buffer_register_vulkan(CrumpleContext *context, CrumpleInstance instance,
                                             const CrumpleVulkanBufferDef *def, CrumpleBuffer *out_buffer);
CrumpleResult crumple_vulkan_record(CrumpleContext *context, void *command_buffer, uint64_t frame,
                                    const CrumpleBuffer *buffers, uint32_t count, CrumpleRecordReport *out_report);
CrumpleResult crumple_vulkan_complete_frames(CrumpleContext *context, uint64_t frame);
CrumpleResult crumple_vulkan_discard_frames(CrumpleContext *context, uint64_t frame);
CrumpleVulkanOpenDef crumple_vulkan_open_def_default(void);
CrumpleResult crumple_vulkan_open(CrumpleContext *context, const CrumpleVulkanOpenDef *def);
CrumpleVulkanImportDef crumple_vulkan_import_def_default(void);
CrumpleResult crumple_vulkan_import_buffer(CrumpleContext *context, const CrumpleVulkanImportDef *def,
                                           uint64_t *out_buffer);
CrumpleResult crumple_vulkan_unimport_buffer(CrumpleContext *context, uint64_t buffer);
CrumpleResult crumple_vulkan_import_semaphore(CrumpleContext *context, CrumpleHandleType handle_type, int64_t handle,
                                              uint64_t *out_semaphore);
CrumpleResult crumple_vulkan_submit(CrumpleContext *context, const CrumpleBuffer *buffers, uint32_t count,
                                    const uint64_t *waits, uint32_t wait_count, const uint64_t *signals,
                                    uint32_t signal_count, uint64_t *out_frame, CrumpleRecordReport *out_report);
CrumpleResult crumple_vulkan_wait_frame(CrumpleContext *context, uint64_t frame, uint64_t timeout, bool *out_done);
#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus
#endif  /* CRUMPLE_VULKAN_H */
#ifndef CRUMPLE_GRAPH_H
#define CRUMPLE_GRAPH_H
typedef struct CrumpleGraphUpload {
    uint32_t storage;
    uint32_t reserved;
    uint64_t storage_size;
    uint64_t offset;
    const void *data;
    size_t size;
} CrumpleGraphUpload;
typedef struct CrumpleGraphDispatch {
    uint32_t kernel;
    uint32_t storage;
    uint64_t buffer;
    uint32_t groups[2];
    uint32_t constants[8];
} CrumpleGraphDispatch;
typedef struct CrumpleGraphPlan {
    const uint32_t *freed;
    const CrumpleGraphUpload *uploads;
    const CrumpleGraphDispatch *dispatches;
    const void *work;
    size_t work_size;
    uint32_t freed_count;
    uint32_t upload_count;
    uint32_t dispatch_count;
    uint32_t reserved;
} CrumpleGraphPlan;
#ifdef __cplusplus
extern "C" {
#endif // __cplusplus
CrumpleResult crumple_graph_get_kernel(uint32_t kernel, void *data, size_t capacity, size_t *out_size);
CrumpleResult crumple_buffer_register_graph(CrumpleContext *context, CrumpleInstance instance,
                                            const CrumpleVulkanBufferDef *def, CrumpleBuffer *out_buffer);
CrumpleResult crumple_graph_plan(CrumpleContext *context, const CrumpleBuffer *buffers, uint32_t count,
                                 CrumpleGraphPlan *out_plan, CrumpleRecordReport *out_report);
#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus
#endif  /* CRUMPLE_GRAPH_H */
