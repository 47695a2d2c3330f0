// Crumple dents meshes.
//
// You give it a base mesh and a few examples (the same mesh after a collision, made by an artist or a solver) and report
// impulses from your physics engine. It writes the deformed vertices into your own vertex buffers.
//
// The steps, in order (examples-c has whole programs):
//   1. Context        crumple_context_create: threads, log, your own job system
//   2. Example sets   crumple_example_set_load_baked: one per mesh, shared by all its instances. "crumple bake" makes
//                     the file from glTF or OBJ, and so do crumple_import.h and crumple_build.h
//   3. Instances      crumple_instance_create, ..._set_transform: one per body in the scene
//   4. Hits           crumple_context_report_contacts for every contact point of the physics engine, and
//                     crumple_context_step_contacts once a step; or single hits: crumple_instance_submit_hit
//   5. Damage         crumple_instance_get_marks, ..._save_damage, ..._load_damage, ..._repair_damage: a short list of
//                     marks, to save or to send over the network
//   6. Deformation    crumple_buffer_register_host for your vertex memory; once a frame crumple_context_deform, then
//                     crumple_context_get_changed_buffers and crumple_buffer_get_changes for uploads and bounds
//
// What few need is in headers of its own, which include this one:
//   crumple_build.h     example sets from arrays, levels of detail, baking, damage for a changed mesh
//   crumple_import.h    example sets from glTF and OBJ files
//   crumple_parts.h     parts that come off; lamps and other points that follow the surface; colliders
//   crumple_contacts.h  several hits as one contact; the hits that contact points became, for sounds and scores
//   crumple_view.h      tolerances, vertex budgets, levels of detail by distance; dents that take time to appear
//   crumple_vulkan.h    deformation in your VkCommandBuffer, or on a Vulkan device of Crumple's own
//   crumple_graph.h     deformation in passes of your own render graph
//   crumple_host.h      your allocator; sets in several contexts
//
// Results. Calls that can fail return a CrumpleResult, and crumple_last_error() returns the message. A failed call changes
// nothing, and everything stays usable. Outputs are written only on success, except for counts (see "Arrays"). No call
// prints, throws or raises a signal.
//
// Every call may return CRUMPLE_ERROR_INVALID_ARGUMENT, ..._NOT_FINITE, ..._INDEX_OUT_OF_RANGE, ..._BUFFER_TOO_SMALL,
// ..._MISALIGNED, ..._NULL_POINTER, ..._STRUCT_SIZE, ..._INVALID_ID, ..._CONCURRENT_USE, ..._OUT_OF_MEMORY and ..._INTERNAL
// for the causes at CrumpleResult. A call's comment adds only other errors and causes.
//
// Ownership. Crumple owns what it creates; you hold an id, a small struct by value. An id of zeros is null. Compare ids
// field by field. An id is invalid after its destroy or unregister call; using it is an error, never a crash. An id
// belongs to one context. Destroying an instance unregisters its buffers. Instances keep their destroyed example set
// alive. Destroying a context destroys everything in it. You own what you pass in: defs, strings and arrays are read
// during the call and may be freed after it. Four things must live longer: memory of registered buffers, data that a
// context's callbacks use, bytes passed with CRUMPLE_BYTES_KEEP, and an attached Vulkan device or imported memory.
//
// Defs. A struct whose name ends in Def comes from its crumple_..._def_default function, which sets struct_size and the
// defaults. Then set the fields that you need. struct_size identifies your header version; a size other than the
// library's is an error. Reserved fields are zero.
//
// Arrays. A call that fills an array takes its capacity and writes the count needed to out_count or out_size, also when
// it returns CRUMPLE_ERROR_BUFFER_TOO_SMALL. Pass null with capacity 0 to get only the count. Byte arrays may have any
// alignment.
//
// Threads. Two threads must not use one context at the same time, and callbacks must not call back into it. Either
// returns CRUMPLE_ERROR_CONCURRENT_USE, in every build. Contexts are independent. "Any thread" at a function means that
// any thread may call it at any time, except while the instance or context is being destroyed. So may functions without a
// context argument. Do not use a context in the child of a fork().
//
// Reads. Hits are pending until the instance's damage is next read: by a deform or recording of one of its buffers or of
// all buffers, and by the calls that return, save, repair, measure or take apart its damage. The result does not depend
// on the number of threads or on the order of hits between two reads. With CRUMPLE_RULE_MARKS it does not depend on when
// reads happen, with three exceptions: marks merge above mark_capacity, contacts end when more than 256 are open, and the
// hits of one contact are summed with rounding.
//
// Units. Metres, seconds, kilograms, newton seconds, in the mesh's space and in world space. If your world is in
// centimetres, multiply by 0.01 what you pass: points, translations of transforms, radii, velocities, and impulses in
// kg cm/s. Any handedness and any up axis. Vertices are 32-bit floats, or octahedral where a def says so. Indices start at
// 0. Enums are 32 bits wide (do not compile with -fshort-enums).
//
// Words. A contact is where a body is hit, a vertex of its mesh; hits with one contact_id are one contact. Contact points
// come from a physics engine; those that leave one dent are a touch. A part is a piece of a body that can come off.
//
// Memory. Frames without hits allocate nothing. Without memory for an array whose size depends on your input, such as
// vertices, a file or a list of hits, a call returns CRUMPLE_ERROR_OUT_OF_MEMORY and changes nothing. Your allocator
// (crumple_host.h) may refuse any block. The process aborts only if the system's allocator refuses a small one.
//
// This file is generated from the library's source by `cargo xtask header`; do not edit it.

#ifndef CRUMPLE_H
#define CRUMPLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// The version of this header. Libraries of another major or, before 1.0, minor version do not fit.
#define CRUMPLE_VERSION_MAJOR 0
#define CRUMPLE_VERSION_MINOR 2
#define CRUMPLE_VERSION_PATCH 0
/// The version of this header as one number, in the format of crumple_version().
#define CRUMPLE_VERSION (((CRUMPLE_VERSION_MAJOR * 1000000) + (CRUMPLE_VERSION_MINOR * 1000)) + CRUMPLE_VERSION_PATCH)
/// Bits of crumple_features(): what the library was built with.
#define CRUMPLE_FEATURE_GLTF 1
#define CRUMPLE_FEATURE_OBJ 2
#define CRUMPLE_FEATURE_HOST_ALLOCATOR 4
#define CRUMPLE_FEATURE_VULKAN 8

/// The result of a call. See "Results" at the top.
typedef enum CrumpleResult {
    CRUMPLE_OK = 0,
    /// A number outside its range, no enumerator, a stride that is too small, streams that overlap, text that is not
    /// UTF-8, or a call that is not allowed in the current state.
    CRUMPLE_ERROR_INVALID_ARGUMENT = 1,
    CRUMPLE_ERROR_NOT_FINITE = 2,
    CRUMPLE_ERROR_INDEX_OUT_OF_RANGE = 3,
    /// The base mesh cannot be used.
    CRUMPLE_ERROR_MESH = 4,
    /// An example does not fit the base mesh, or there is no example.
    CRUMPLE_ERROR_EXAMPLE_MISMATCH = 5,
    /// An array has fewer bytes or elements than the call needs.
    CRUMPLE_ERROR_BUFFER_TOO_SMALL = 6,
    /// A pointer, offset or stride is not a multiple of its alignment.
    CRUMPLE_ERROR_MISALIGNED = 7,
    /// A hit is further from the body than max_contact_distance. Often its point is in the wrong space.
    CRUMPLE_ERROR_CONTACT_TOO_FAR = 8,
    /// The input is valid, but this library or this build does not support it.
    CRUMPLE_ERROR_UNSUPPORTED = 9,
    /// A file is malformed, or bytes in memory are.
    CRUMPLE_ERROR_FORMAT = 10,
    /// The system refused to read or write a file.
    CRUMPLE_ERROR_IO = 11,
    /// The damage belongs to another example set, rule or version.
    CRUMPLE_ERROR_DAMAGE_MISMATCH = 12,
    CRUMPLE_ERROR_OUT_OF_MEMORY = 13,
    /// The call does not work with the instance's rule.
    CRUMPLE_ERROR_WRONG_RULE = 14,
    CRUMPLE_ERROR_VULKAN = 15,
    /// The Vulkan device is lost. Damage is not lost.
    CRUMPLE_ERROR_DEVICE_LOST = 16,
    /// A contact id that no hit has, or that was ended.
    CRUMPLE_ERROR_UNKNOWN_CONTACT = 17,
    CRUMPLE_ERROR_NULL_POINTER = 64,
    /// The struct_size of a def is wrong. Start from the def's crumple_..._def_default function.
    CRUMPLE_ERROR_STRUCT_SIZE = 65,
    /// An id is null or of another context, or its object or the context was destroyed.
    CRUMPLE_ERROR_INVALID_ID = 66,
    /// Two threads used one context at once, or a callback called back into its context.
    CRUMPLE_ERROR_CONCURRENT_USE = 67,
    /// A defect of the library. Please report it with the text of crumple_last_error().
    CRUMPLE_ERROR_INTERNAL = 68,
    /// Recorded frames were not reported to crumple_vulkan_complete_frames().
    CRUMPLE_ERROR_FRAMES_IN_FLIGHT = 69,
} CrumpleResult;

/// The severity of a log message.
typedef enum CrumpleLogLevel {
    CRUMPLE_LOG_LEVEL_INFO = 0,
    /// Something that works but is probably a mistake.
    CRUMPLE_LOG_LEVEL_WARNING = 1,
} CrumpleLogLevel;

/// Whether the bytes of a baked set are copied.
typedef enum CrumpleBytes {
    /// The bytes are copied. Free them after the call.
    CRUMPLE_BYTES_COPY = 0,
    /// The bytes are used in place. They must stay readable and unchanged until the set, all its instances and its
    /// shared copies are destroyed. Bytes whose address is not a multiple of 16 are copied.
    CRUMPLE_BYTES_KEEP = 1,
} CrumpleBytes;

/// How hits damage an instance.
typedef enum CrumpleRule {
    /// Each hit leaves a mark. The number of marks is bounded and the order of hits does not matter. The default.
    CRUMPLE_RULE_MARKS = 0,
    /// The classic rule "most displaced" of the paper, for comparison. The order of hits matters. The instance has
    /// no marks and needs memory for each vertex, and a set with whole examples: one that was made here, or baked with
    /// CrumpleExampleSetOptions::whole_examples.
    CRUMPLE_RULE_MOST_DISPLACED = 1,
    /// The classic rule "blend", which uses blend_constant. Otherwise like CRUMPLE_RULE_MOST_DISPLACED.
    CRUMPLE_RULE_BLEND = 2,
} CrumpleRule;

/// How a classic rule selects the example for a hit.
typedef enum CrumpleSelection {
    /// The one example that moves the contact vertex most nearly in the target's direction, with a weight of at most 1. The
    /// default.
    CRUMPLE_SELECTION_CLASSIC = 0,
    /// Without the weight limit. Diverges at weights above 2.
    CRUMPLE_SELECTION_CLASSIC_UNCLAMPED = 1,
} CrumpleSelection;

/// How a hit is given.
typedef enum CrumpleHitKind {
    /// As a blow: by its impulse, or by the mass and velocity of the striker. If the set has examples with blows
    /// (blow_count), it predicts the displacement of the contact: give as much of the blow as the engine knows. Otherwise
    /// the displacement is impulse * the instance's compliance, or impulse * duration / mass. The default.
    CRUMPLE_HIT_KIND_BLOW = 0,
    /// As the displacement of the contact, for engines with their own impulse-to-depth mapping. The dent does not depend
    /// on the frame rate. The fields of blows are unused.
    CRUMPLE_HIT_KIND_DISPLACEMENT = 1,
} CrumpleHitKind;

/// The space that a hit is given in.
typedef enum CrumpleSpace {
    /// The mesh's own space. The default.
    CRUMPLE_SPACE_LOCAL = 0,
    /// World space. The instance's transform maps it to the mesh's space.
    CRUMPLE_SPACE_WORLD = 1,
} CrumpleSpace;

/// The shape of what strikes, at the contact.
typedef enum CrumpleStrikerShape {
    /// The default.
    CRUMPLE_STRIKER_SHAPE_UNKNOWN = 0,
    /// A ball, or anything round.
    CRUMPLE_STRIKER_SHAPE_BALL = 1,
    /// A pole, an edge, or anything long.
    CRUMPLE_STRIKER_SHAPE_POLE = 2,
    /// A corner of a box.
    CRUMPLE_STRIKER_SHAPE_CORNER = 3,
    /// A wall, or any flat face.
    CRUMPLE_STRIKER_SHAPE_WALL = 4,
} CrumpleStrikerShape;

/// What became of a hit.
typedef enum CrumpleHitStatus {
    /// It leaves a mark. With a classic rule, it deforms the instance.
    CRUMPLE_HIT_STATUS_MARKED = 0,
    /// It is below a yield threshold, or its target is shorter than a millionth of the depth limit.
    CRUMPLE_HIT_STATUS_BELOW_YIELD = 1,
    /// No example tells of a dent there.
    CRUMPLE_HIT_STATUS_NOTHING_REACHES = 2,
    /// Alone it would leave no mark, but it adds to its contact.
    CRUMPLE_HIT_STATUS_ACCUMULATED = 3,
    /// Its contact cannot move: it is in a rigid part, such as glass, or its own depth limit is 0 or its stiffness 1. It
    /// leaves no mark.
    CRUMPLE_HIT_STATUS_RIGID = 4,
} CrumpleHitStatus;

/// What the impulses of contact points mean, which differs among physics engines.
typedef enum CrumpleImpulses {
    /// Each point has its own impulse: Bullet, PhysX, rapier, ODE. A point whose impulse is 0 did not push. The default.
    CRUMPLE_IMPULSES_PER_POINT = 0,
    /// Each point has the impulse of the whole pair in the step. It is divided among the pair's points.
    CRUMPLE_IMPULSES_WHOLE_AT_EVERY_POINT = 1,
    /// Each point has its own impulse, but 0 means that it is unknown: Godot Physics reports 0 in the step of impact.
    CRUMPLE_IMPULSES_ZERO_IS_UNKNOWN = 2,
} CrumpleImpulses;

/// The format of normals or tangents in memory of the CPU.
typedef enum CrumpleDirectionFormat {
    /// 3 floats for a normal, 4 for a tangent. The default.
    CRUMPLE_DIRECTION_FORMAT_FLOAT = 0,
    /// Octahedral as in Godot: two uint16_t, 4 bytes in all, with the bits of a Vulkan buffer's R16G16_UNORM.
    /// docs/integration.md has the formula.
    CRUMPLE_DIRECTION_FORMAT_OCTAHEDRAL = 1,
} CrumpleDirectionFormat;

/// A context holds example sets, instances and buffers. Opaque.
typedef struct CrumpleContext CrumpleContext;

/// Receives one message, UTF-8, without a line break at its end. The text is valid only during the callback. Runs on
/// the thread that called Crumple. Must not call the same context, throw or longjmp out.
typedef void (*CrumpleLog)(CrumpleLogLevel level, const char *message, void *user);

/// A task of a parallel-for. Call it with an index below count and with the task_data of CrumpleParallelFor.
typedef void (*CrumpleTask)(uint32_t index, void *task_data);

/// Your parallel-for. Calls task(index, task_data) once for each index below count, on any threads and in any order,
/// and returns when all calls have returned. Tasks may run concurrently, and do not block or throw. Crumple runs any
/// index that you skip, and ignores repeated ones. Runs on the thread that called Crumple; must not throw or longjmp
/// out. With the same context it may call only functions for any thread; see "Threads".
typedef void (*CrumpleParallelFor)(uint32_t count, CrumpleTask task, void *task_data, void *user);

/// The host's job system. All fields zero: Crumple uses its own threads.
typedef struct CrumpleTaskSystem {
    CrumpleParallelFor parallel_for;
    void *user;
    /// Number of threads that can work at the same time; 0 counts as 1. It affects how work is split, never the result.
    uint32_t workers;
} CrumpleTaskSystem;

/// Options of a context.
typedef struct CrumpleContextDef {
    uint32_t struct_size;
    /// Threads that deform, up to 1024. 0: one per core. 1: only the calling thread. Unused with tasks. Default 0.
    uint32_t threads;
    /// Receives messages. Default null: none.
    CrumpleLog log;
    void *log_user;
    CrumpleTaskSystem tasks;
} CrumpleContextDef;

/// A base mesh with its examples: immutable, shared by any number of instances. An id; zero is null.
typedef struct CrumpleExampleSet {
    uint32_t index;
    uint16_t generation;
    uint16_t context;
} CrumpleExampleSet;

/// A point or a vector.
typedef struct CrumpleVec3 {
    float x;
    float y;
    float z;
} CrumpleVec3;

/// An axis-aligned box, m.
typedef struct CrumpleAabb {
    CrumpleVec3 min;
    CrumpleVec3 max;
} CrumpleAabb;

/// Facts about an example set. Counts and bounds are the base mesh's. Strings are valid until the set is destroyed.
typedef struct CrumpleExampleSetInfo {
    /// Name of the mesh in its file, UTF-8; empty for a set built from arrays. Never null.
    const char *name;
    /// Equal for equal sets, on any machine. Saved damage fits only sets with the same fingerprint.
    uint64_t fingerprint;
    uint64_t memory_bytes;
    uint32_t vertex_count;
    uint32_t triangle_count;
    uint32_t example_count;
    /// Stretches of the mesh with a material of their own, at least 1; see crumple_import.h.
    uint32_t primitive_count;
    /// Number of positions that several vertices share.
    uint32_t seam_count;
    /// No vertex moves further than this, m.
    float depth_limit;
    CrumpleAabb bounds;
    /// World matrix of the first glTF node that shows the mesh, column-major; the identity if there is none.
    float node_transform[16];
    bool has_tangents;
    /// Number of meshes: 1 + added levels of detail.
    uint32_t lod_count;
    /// Number of examples whose impulse or striker is known. From 1 on, the set predicts what a blow leaves.
    uint32_t blow_count;
    /// Median of the examples' field_error.
    float field_error;
    uint64_t reserved[2];
} CrumpleExampleSetInfo;

/// An array that Crumple writes. Element i is at data + offset + i * stride. Positions and normals are 3 floats,
/// tangents 4 floats, indices one uint32_t, unless the def has another format. Bytes between elements are not touched, so
/// streams may be interleaved. All fields zero: absent.
typedef struct CrumpleStream {
    /// Start of the memory, aligned to 4 bytes. Null: absent.
    void *data;
    /// Writable bytes at data: at least offset + (count - 1) * stride + the size of one element.
    size_t size;
    /// Bytes from data to the first element, a multiple of 4.
    size_t offset;
    /// Bytes from one element to the next: at least the size of one element, a multiple of 4. 0 is an error.
    size_t stride;
} CrumpleStream;

/// Where to copy a mesh: positions (m), unit normals, tangents, 3 * triangle_count indices. Absent ones are skipped.
typedef struct CrumpleMeshCopyDef {
    uint32_t struct_size;
    /// Which mesh: 0 for the base mesh, or a number from crumple_example_set_add_lod(). Default 0.
    uint32_t lod;
    CrumpleStream positions;
    CrumpleStream normals;
    CrumpleStream tangents;
    CrumpleStream indices;
} CrumpleMeshCopyDef;

/// Options of an instance.
typedef struct CrumpleInstanceDef {
    uint32_t struct_size;
    /// Most marks kept, 1 to 65535. Above, the weakest mark merges into the nearest. Default 64.
    uint32_t mark_capacity;
    /// The example set, which the instance keeps alive. Required.
    CrumpleExampleSet set;
    /// Any number of yours, such as an entity or a pointer. Default 0.
    uint64_t user_data;
    CrumpleRule rule;
    /// How a classic rule selects an example. CRUMPLE_RULE_MARKS needs the default.
    CrumpleSelection selection;
    /// No vertex moves further than this, m. Default 0: the set's limit.
    float depth_limit;
    /// Impulses shorter than this leave no mark, N s, in the space of the hit. Default 0.
    float yield_impulse;
    /// Hits with a target displacement shorter than this leave no mark, m, in the mesh's space. Default 0.
    float yield_displacement;
    /// Hits further than this from the nearest vertex are errors, m, in the mesh's space. Default 0: the diagonal of
    /// the bounds, or the depth limit if larger.
    float max_contact_distance;
    /// Constant of CRUMPLE_RULE_BLEND, 0 to 1. Default 0.
    float blend_constant;
    /// How far a blow of 1 N s moves its contact, m per N s, if the set's blow_count is 0. duration and mass of hits
    /// are then unused. Default 0: duration / mass.
    float compliance;
    /// How long a dent takes to appear, to deepen or to be repaired, s; see crumple_context_set_time() in crumple_view.h. Default 0: none.
    float grow_time;
    /// Transform; see crumple_instance_set_transform(). Default the identity.
    float local_to_world[16];
} CrumpleInstanceDef;

/// A body in the scene: an example set, a transform and the damage. An id; zero is null.
typedef struct CrumpleInstance {
    uint32_t index;
    uint16_t generation;
    uint16_t context;
} CrumpleInstance;

/// The state of an instance. Pending hits are included.
typedef struct CrumpleInstanceInfo {
    /// The set that it was created with. The id is invalid if the set was destroyed.
    CrumpleExampleSet set;
    /// Memory of the instance, bytes, without the set, and without what is kept for its buffers.
    uint64_t memory_bytes;
    /// Number of marks; 0 with a classic rule.
    uint32_t mark_count;
    uint32_t buffer_count;
    /// No vertex moves further than this, m.
    float depth_limit;
    /// Number of open contacts; see crumple_contacts.h.
    uint32_t contact_count;
    /// A hash of the marks: equal marks have equal revisions, on all machines. 0 without marks.
    uint64_t revision;
    uint32_t reserved[2];
} CrumpleInstanceInfo;

/// What struck a body, as far as it is known. 0 is unknown, which costs accuracy.
typedef struct CrumpleStriker {
    /// Mass, kg; against a body that is free to move, the reduced mass m1 m2 / (m1 + m2).
    float mass;
    /// Radius of its surface at the contact, m: small for a corner, large for a flat face.
    float radius;
    /// Its velocity relative to the struck body before they touch, m/s.
    CrumpleVec3 velocity;
    CrumpleStrikerShape shape;
    uint32_t reserved[2];
} CrumpleStriker;

/// A hit. Report a blow once with its whole impulse, or as several hits with the same contact_id.
typedef struct CrumpleHitDef {
    uint32_t struct_size;
    CrumpleHitKind kind;
    /// The space of point and of all vectors. Default CRUMPLE_SPACE_LOCAL.
    CrumpleSpace space;
    /// Where the body was hit, m. The nearest vertex becomes the contact.
    CrumpleVec3 point;
    /// For CRUMPLE_HIT_KIND_DISPLACEMENT: the target displacement of the contact, m.
    CrumpleVec3 displacement;
    /// The impulse on the body, N s. Default 0: striker.mass * striker.velocity. If that is 0 too, there is no mark.
    CrumpleVec3 impulse;
    /// How long the impulse acted, s: a constant of the material such as 0.01, not the time step. Required if the set's
    /// blow_count is 0 and the instance has no compliance.
    float duration;
    /// Mass of the contact vertex, kg, for impulse * duration / mass. Default 0: the set's mass for that vertex.
    float mass;
    /// Contact normal, out of the body, of any length. Default 0: unknown.
    CrumpleVec3 normal;
    CrumpleStriker striker;
    /// The contact that the hit belongs to; see crumple_contacts.h. Default 0: none.
    uint64_t contact_id;
} CrumpleHitDef;

/// One dent. Plain data, 32 bytes, little-endian, equal on all machines: send or save it as is. Logarithms are to the base of 2, in units
/// of 1/500, from 2^-64 on (docs/model.md, "Marks").
typedef struct CrumpleMark {
    /// The vertex that was hit.
    uint32_t contact;
    /// Depth at the contact, m, above 0.
    float depth;
    /// Number of hits of this depth that it stands for, fixed point 32.32: 4294967296 for one hit.
    uint64_t hits;
    /// What the hit told: 0 the displacement of its contact, 1 its blow.
    uint16_t told;
    /// Shape of the striker of a blow, as CrumpleStrikerShape.
    uint16_t striker;
    /// Direction of the displacement or of the striker, octahedral: 0 to 65534 for -1 to 1.
    uint16_t direction[2];
    /// Logarithm of a blow's energy, J. This and what follows is 0 for a displacement.
    uint16_t strength;
    /// Logarithm of the striker's mass, kg.
    uint16_t mass;
    /// Logarithm of the striker's radius, m.
    uint16_t radius;
    /// 0.
    uint16_t reserved;
} CrumpleMark;

/// The effect of a hit. If its status is not CRUMPLE_HIT_STATUS_MARKED, achieved, expected_error and mark are zero.
typedef struct CrumpleHitResult {
    CrumpleHitStatus status;
    /// The vertex nearest to the point.
    uint32_t contact_vertex;
    /// Distance of that vertex from the point, m.
    float contact_distance;
    /// Target displacement of the contact, before it is clamped, m, in the mesh's space.
    CrumpleVec3 target;
    /// Displacement of the contact by this hit alone, m, in the mesh's space.
    CrumpleVec3 achieved;
    /// Expected error of the dent relative to its size (L2): 0 exact, 1 as wrong as no dent. Where it is large, one more
    /// example helps.
    float expected_error;
    /// Whether the target was longer than the depth limit and was cut to it.
    bool clamped;
    /// The mark. All zero if the hit leaves none.
    CrumpleMark mark;
    uint32_t reserved[7];
} CrumpleHitResult;

/// Options of a context's contacts. A touch is what leaves one dent: points of one pair that lie near each other, from the
/// step in which they first push until the bodies separate or touch_time is over.
typedef struct CrumpleContactOptionsDef {
    uint32_t struct_size;
    /// What the impulses of points mean. Default CRUMPLE_IMPULSES_PER_POINT.
    CrumpleImpulses impulses;
    /// Factor of the energy of every blow, at least 0. Default 1: what the physics says.
    float gain;
    /// Points that approach more slowly than this leave nothing, m/s. Default -1: a quarter of the speed of the set's slowest
    /// example, at least 0.5 m/s, which is above what gravity adds in a step of 1/30 s.
    float min_speed;
    /// Touches of less energy than this leave nothing, J. Default -1: a sixteenth of the energy of the set's weakest example.
    float min_energy;
    /// Points of a pair that are nearer to each other than this are one touch, m, in the mesh's space. Default -1: half of the median
    /// support radius of the set's examples.
    float dent_radius;
    /// How long a touch lasts at most, s, above 0. Bodies that push longer begin another one, if they are fast enough. Default
    /// 0.1.
    float touch_time;
    /// A touch ends when its pair was not reported for longer than this, s, at least 0. Default 0.05.
    float separation_time;
    /// The most points between two steps, 1 to 16777216. Default 65536.
    uint32_t max_points;
    /// The most touches at a time, 1 to 65536. Beyond it, the oldest ends early. Default 1024.
    uint32_t max_touches;
} CrumpleContactOptionsDef;

/// A point at which two bodies touch in a step of the physics. Vectors are in world space; keep the instances' transforms
/// up to date. Give the impulse, or the velocity and what the bodies weigh; best all of them:
///
///   known                  impulse J    approach speed v    energy of the blow
///   impulse and velocity   given        given               J v / 2
///   impulse and masses     given        J / m               J J / 2 m
///   velocity and masses    m v          given               m v v / 2
///   impulse alone          given        unknown             the set's law of impulses
///
/// m is the reduced mass: 1 / inverse_mass if given, else m_a m_b / (m_a + m_b), which is the mass of the free body if
/// nothing moves the other. Without a velocity, a body on which others rest looks struck: give velocities.
typedef struct CrumpleContactPointDef {
    uint32_t struct_size;
    /// Whether velocity is known. Default false.
    bool has_velocity;
    /// Whether velocity_after is known. Default false: the bodies stop each other.
    bool has_velocity_after;
    /// The two bodies as one number, the same in every step in which they touch.
    uint64_t pair;
    /// The bodies a and b. Default null: a body that does not dent.
    CrumpleInstance bodies[2];
    /// Where they touch, m.
    CrumpleVec3 point;
    /// From a to b: out of a. Required; any length above 0.
    CrumpleVec3 normal;
    /// Velocity of b relative to a at the point, before the step, m/s.
    CrumpleVec3 velocity;
    /// The same after the step, for points without an impulse.
    CrumpleVec3 velocity_after;
    /// Length of the normal impulse of the step, N s. Default -1: the reduced mass times the change of the approach speed.
    float impulse;
    /// Masses of a and b, kg; INFINITY for a static or kinematic body. Default 0: unknown.
    float masses[2];
    /// Inverse of the effective mass of the two at the point along the normal, with rotation, 1/kg. Default 0: 1/m_a +
    /// 1/m_b.
    float inverse_mass;
    /// Radii of the surfaces of a and b at the point, m: small for a corner, large for a flat face. Default 0: unknown.
    float radii[2];
    /// Shapes of a and b at the point. Default unknown.
    CrumpleStrikerShape shapes[2];
    /// Factor of the point's energy, for the materials of the pair, at least 0. Default 1.
    float gain;
} CrumpleContactPointDef;

/// What steps of a context's contacts did.
typedef struct CrumpleContactReport {
    uint64_t points;
    uint64_t hits;
    /// Touches that began, that ended, and that are open after the step.
    uint64_t begun;
    uint64_t ended;
    uint64_t open;
    /// Points that approached too slowly: resting, rolling and sliding bodies.
    uint64_t slow;
    /// Points that pushed while the bodies separated. If all do so, normal or velocity points the wrong way.
    uint64_t separating;
    /// Touches that ended with too little energy for a dent.
    uint64_t weak;
    /// Touches that ended early because there were too many.
    uint64_t crowded;
    /// Hits that instances refused.
    uint64_t refused;
    /// Why the first of them was refused; CRUMPLE_OK if none was.
    CrumpleResult refusal;
    uint32_t reserved[3];
} CrumpleContactReport;

/// Memory for the deformed vertices of one instance, in the mesh's order and space.
typedef struct CrumpleHostBufferDef {
    uint32_t struct_size;
    /// Which mesh: 0 for the base mesh, or a number from crumple_example_set_add_lod(). Default 0.
    uint32_t lod;
    /// Any number of yours. Default 0.
    uint64_t user_data;
    /// Positions, m. Required.
    CrumpleStream positions;
    /// Unit normals in normal_format. Absent: not written.
    CrumpleStream normals;
    /// Tangents in tangent_format: xyz of unit length and orthogonal to the normal, w as in the mesh. Absent: not
    /// written.
    CrumpleStream tangents;
    CrumpleDirectionFormat normal_format;
    CrumpleDirectionFormat tangent_format;
} CrumpleHostBufferDef;

/// Registered memory of yours that receives an instance's deformed vertices. An id; zero is null.
typedef struct CrumpleBuffer {
    uint32_t index;
    uint16_t generation;
    uint16_t context;
} CrumpleBuffer;

/// What a buffer shows.
typedef struct CrumpleBufferInfo {
    CrumpleBuffer buffer;
    CrumpleInstance instance;
    /// The user_data of the buffer's def, and of the instance.
    uint64_t user_data;
    uint64_t instance_user_data;
    /// Which mesh of the set.
    uint32_t lod;
    uint32_t reserved[3];
} CrumpleBufferInfo;

/// The work done by a deform. A block is a run of up to 128 consecutive vertices.
typedef struct CrumpleDeformReport {
    uint64_t vertices_written;
    uint64_t blocks_written;
    /// Blocks that were up to date.
    uint64_t blocks_skipped;
    /// Vertices that wait for a later call; see crumple_context_set_vertex_budget().
    uint64_t vertices_waiting;
    uint64_t reserved[3];
} CrumpleDeformReport;

/// A range of vertices or triangles.
typedef struct CrumpleRange {
    uint32_t first;
    uint32_t count;
} CrumpleRange;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// Returns the version of the running library: major * 1000000 + minor * 1000 + patch. Compare it with CRUMPLE_VERSION.
uint32_t crumple_version(void);

/// Returns the version of the running library as text, such as "0.2.0". The text stays valid for ever.
const char *crumple_version_string(void);

/// Returns the CRUMPLE_FEATURE_ bits of this build, combined with or. Ignore bits that you do not know.
uint64_t crumple_features(void);

/// Returns the message of the calling thread's last failed call, UTF-8: "crumple_instance_create: ...". It names the
/// wrong value and what would be right. Empty before the first failure; calls that succeed leave it unchanged. Valid
/// until the thread's next failed call; at most 1023 bytes, never null.
const char *crumple_last_error(void);

/// Returns the name of a result, such as "CRUMPLE_ERROR_FORMAT", or "unknown result". The text stays valid for ever.
const char *crumple_result_name(CrumpleResult result);

CrumpleContextDef crumple_context_def_default(void);
/// Creates a context. Any thread may call this. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (more than 1024 threads, or
/// 65535 contexts alive), CRUMPLE_ERROR_OUT_OF_MEMORY (the system cannot start the threads).
CrumpleResult crumple_context_create(const CrumpleContextDef *def, CrumpleContext **out_context);

/// Destroys a context and everything in it, but neither frees nor touches your own memory. No other call may be running
/// with this context. An attached Vulkan device must still exist. CRUMPLE_ERROR_FRAMES_IN_FLIGHT: nothing was
/// destroyed; see crumple_vulkan_complete_frames().
CrumpleResult crumple_context_destroy(CrumpleContext *context);

/// Loads an example set from the size bytes of a .crumple file at data, written by "crumple bake" or
/// crumple_example_set_save_baked(). Loading builds nothing, but checks all bytes. Errors: CRUMPLE_ERROR_FORMAT
/// (damaged, cut short, or not a baked set), CRUMPLE_ERROR_UNSUPPORTED (another format version).
CrumpleResult crumple_example_set_load_baked_memory(CrumpleContext *context, const void *data, size_t size,
                                                    CrumpleBytes bytes, CrumpleExampleSet *out_set);

/// Like crumple_example_set_load_baked_memory(), but reads the file at path, UTF-8. Also returns CRUMPLE_ERROR_IO.
CrumpleResult crumple_example_set_load_baked(CrumpleContext *context, const char *path, CrumpleExampleSet *out_set);

/// Returns whether an id is that of a set of the context. False while another thread is inside the context.
bool crumple_example_set_is_valid(CrumpleContext *context, CrumpleExampleSet set);

/// Destroys a set. Its id and the strings of its infos become invalid. Instances keep the set's memory and still work.
CrumpleResult crumple_example_set_destroy(CrumpleContext *context, CrumpleExampleSet set);

/// Returns facts about a set.
CrumpleResult crumple_example_set_get_info(CrumpleContext *context, CrumpleExampleSet set,
                                           CrumpleExampleSetInfo *out_info);

CrumpleMeshCopyDef crumple_mesh_copy_def_default(void);
/// Copies the base mesh or a level of detail into your memory, for your vertex and index buffers. If the set was built
/// without normals, they are the computed ones. CRUMPLE_ERROR_MESH: the mesh lacks the requested normals or tangents.
CrumpleResult crumple_example_set_copy_mesh(CrumpleContext *context, CrumpleExampleSet set,
                                            const CrumpleMeshCopyDef *def);

CrumpleInstanceDef crumple_instance_def_default(void);
/// Creates an undamaged instance.
CrumpleResult crumple_instance_create(CrumpleContext *context, const CrumpleInstanceDef *def,
                                      CrumpleInstance *out_instance);

/// Destroys an instance and unregisters its buffers. Your memory keeps its contents.
CrumpleResult crumple_instance_destroy(CrumpleContext *context, CrumpleInstance instance);

/// Returns whether an id is that of an instance of the context. Any thread.
bool crumple_instance_is_valid(CrumpleContext *context, CrumpleInstance instance);

/// Sets the user_data of an instance. A released part begins with that of its body.
CrumpleResult crumple_instance_set_user_data(CrumpleContext *context, CrumpleInstance instance, uint64_t user_data);

/// Returns the user_data of an instance.
CrumpleResult crumple_instance_get_user_data(CrumpleContext *context, CrumpleInstance instance, uint64_t *out_data);

/// Returns the state of an instance.
CrumpleResult crumple_instance_get_info(CrumpleContext *context, CrumpleInstance instance,
                                        CrumpleInstanceInfo *out_info);

/// Sets the transform: local_to_world points to 16 floats, column-major (element 4 * column + row, as in glTF and
/// Vulkan), translation in elements 12 to 14, m, last row 0 0 0 1. It may scale and shear, but must be invertible. Hits
/// in CRUMPLE_SPACE_WORLD use its inverse at the time of the call, without translation for vectors. Any thread.
CrumpleResult crumple_instance_set_transform(CrumpleContext *context, CrumpleInstance instance,
                                             const float *local_to_world);

/// Limits how far a vertex moves, m, from the next deform or recording on. 0: the set's limit. Marks are kept, and
/// their full depth returns when the limit is raised.
CrumpleResult crumple_instance_set_depth_limit(CrumpleContext *context, CrumpleInstance instance, float depth_limit);

CrumpleHitDef crumple_hit_def_default(void);
/// Submits a hit. The call selects the examples. The next read of the damage applies the mark (see "Reads" at the top).
/// A hit that is too weak, or that no example fits, is not an error; see out_result->status. out_result may be null.
/// With a contact_id, it describes this hit alone. Any thread. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (a negative
/// duration, mass or radius; no duration, or no mass in def and set, where they are needed),
/// CRUMPLE_ERROR_CONTACT_TOO_FAR, CRUMPLE_ERROR_WRONG_RULE (a contact_id with a classic rule).
CrumpleResult crumple_instance_submit_hit(CrumpleContext *context, CrumpleInstance instance, const CrumpleHitDef *def,
                                          CrumpleHitResult *out_result);

/// Submits count hits, each to the instance at the same index: all, or none, and the message names the first wrong one.
/// out_results is null, or has room for count results. Otherwise like crumple_instance_submit_hit().
CrumpleResult crumple_context_submit_hits(CrumpleContext *context, const CrumpleInstance *instances,
                                          const CrumpleHitDef *defs, uint32_t count, CrumpleHitResult *out_results);

/// Returns what crumple_instance_submit_hit() would, without leaving a mark. out_result is required. Any thread.
CrumpleResult crumple_instance_preview_hit(CrumpleContext *context, CrumpleInstance instance, const CrumpleHitDef *def,
                                           CrumpleHitResult *out_result);

CrumpleContactOptionsDef crumple_contact_options_def_default(void);
/// Changes the options of the context's contacts. Touches that last go on with them. Any thread.
CrumpleResult crumple_context_set_contact_options(CrumpleContext *context, const CrumpleContactOptionsDef *options);

CrumpleContactPointDef crumple_contact_point_def_default(void);
/// Takes contact points of the current step of the physics: all, or none if one is wrong. Report every point of every
/// pair, also of bodies that rest or slide, and call crumple_context_step_contacts() after the step. A touch leaves one
/// dent, at any rate of steps. Bodies that rest, roll, slide or jitter leave none. Two instances share the energy of a
/// blow, and the one that gives way more easily takes more. Any thread. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (names the
/// point and its field; also more than max_points since the last step), CRUMPLE_ERROR_WRONG_RULE (a classic rule).
CrumpleResult crumple_context_report_contacts(CrumpleContext *context, const CrumpleContactPointDef *points,
                                              uint32_t count);

/// Ends a step of the physics that lasted so many seconds. It turns the points reported since the last call into hits,
/// which the next read of the damage applies; crumple_context_get_contact_hits() in crumple_contacts.h returns them. Call
/// it once after each step, also if nothing touched. These hits have contact ids of 2^63 and above; give smaller ids to
/// your own. out_report may be null. Any thread.
CrumpleResult crumple_context_step_contacts(CrumpleContext *context, float seconds, CrumpleContactReport *out_report);

/// Ends all touches and forgets the points that wait, as after loading a saved game. Dents stay. Any thread.
CrumpleResult crumple_context_clear_contacts(CrumpleContext *context);

/// Copies an instance's marks, sorted, so that the order of hits does not matter. CRUMPLE_ERROR_WRONG_RULE: classic
/// rules have no marks.
CrumpleResult crumple_instance_get_marks(CrumpleContext *context, CrumpleInstance instance, CrumpleMark *marks,
                                         uint32_t capacity, uint32_t *out_count);

/// Replaces an instance's marks with count marks of the same set. Discards pending hits and ends contacts. Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (a mark that the set cannot have), CRUMPLE_ERROR_WRONG_RULE.
CrumpleResult crumple_instance_set_marks(CrumpleContext *context, CrumpleInstance instance, const CrumpleMark *marks,
                                         uint32_t count);

/// Saves an instance's damage as bytes that are equal on all machines, with a version and the set's fingerprint.
CrumpleResult crumple_instance_save_damage(CrumpleContext *context, CrumpleInstance instance, void *data,
                                           size_t capacity, size_t *out_size);

/// Replaces an instance's damage with the size bytes of saved damage at data. Discards pending hits and ends contacts.
/// Errors: CRUMPLE_ERROR_DAMAGE_MISMATCH (another set, version or rule, cut short, or with a changed bit: it has a
/// checksum), CRUMPLE_ERROR_INVALID_ARGUMENT (a mark that the set cannot have).
CrumpleResult crumple_instance_load_damage(CrumpleContext *context, CrumpleInstance instance, const void *data,
                                           size_t size);

/// Saves the damage of count instances together, or of all instances of the context by increasing index if instances is
/// null and count 0.
CrumpleResult crumple_context_save_damage(CrumpleContext *context, const CrumpleInstance *instances, uint32_t count,
                                          void *data, size_t capacity, size_t *out_size);

/// Replaces the damage of count instances, or of all, with bytes of crumple_context_save_damage() for instances of the same
/// sets in the same order. Otherwise like crumple_instance_load_damage() for each of them. After an error no instance has
/// changed. CRUMPLE_ERROR_DAMAGE_MISMATCH: also another number of instances.
CrumpleResult crumple_context_load_damage(CrumpleContext *context, const CrumpleInstance *instances, uint32_t count,
                                          const void *data, size_t size);

/// Repairs an instance. Every dent keeps a share of its depth, keep: 0 (as new) to 1 (unchanged). Ends contacts.
CrumpleResult crumple_instance_repair_damage(CrumpleContext *context, CrumpleInstance instance, float keep);

/// Repairs an instance around a point of the mesh's space, m, as with a hammer. A dent whose contact is at the point keeps
/// a share of its depth, keep (0 to 1). Dents further away keep more, and those at radius, m, all of it. A dent is
/// repaired as a whole, also where it reaches beyond the radius. Ends contacts. CRUMPLE_ERROR_WRONG_RULE: a classic rule.
CrumpleResult crumple_instance_repair_around(CrumpleContext *context, CrumpleInstance instance, CrumpleVec3 point,
                                             float radius, float keep);

/// Removes all damage of an instance. Discards pending hits and ends contacts.
CrumpleResult crumple_instance_reset_damage(CrumpleContext *context, CrumpleInstance instance);

/// Replaces an instance's damage with that of source, which needs an equal set and the same kind of rule. Discards
/// pending hits and ends contacts. If source is the instance itself, nothing happens. CRUMPLE_ERROR_DAMAGE_MISMATCH:
/// another set or rule.
CrumpleResult crumple_instance_copy_damage(CrumpleContext *context, CrumpleInstance instance, CrumpleInstance source);

CrumpleHostBufferDef crumple_host_buffer_def_default(void);
/// Registers your memory for an instance's deformed vertices. The first deform writes every vertex. An instance may
/// have several buffers, such as a ring. Only crumple_context_deform() touches the memory, which must exist until the
/// buffer is unregistered or gets other memory, or its instance or context is destroyed, and must not overlap that of
/// other buffers. Errors: CRUMPLE_ERROR_MESH (normals or tangents that the mesh lacks), CRUMPLE_ERROR_WRONG_RULE (lod above
/// 0 with a classic rule).
CrumpleResult crumple_buffer_register_host(CrumpleContext *context, CrumpleInstance instance,
                                           const CrumpleHostBufferDef *def, CrumpleBuffer *out_buffer);

/// Unregisters a buffer. You may then free its memory, or its VkBuffer once the frames that wrote it are complete.
CrumpleResult crumple_buffer_unregister(CrumpleContext *context, CrumpleBuffer buffer);

/// Returns whether an id is that of a buffer of the context. False while another thread is inside the context.
bool crumple_buffer_is_valid(CrumpleContext *context, CrumpleBuffer buffer);

/// Returns what a buffer shows.
CrumpleResult crumple_buffer_get_info(CrumpleContext *context, CrumpleBuffer buffer, CrumpleBufferInfo *out_info);

/// Declares a buffer's contents lost or overwritten. The next deform or recording writes every vertex.
CrumpleResult crumple_buffer_invalidate(CrumpleContext *context, CrumpleBuffer buffer);

/// Gives a host buffer other memory, perhaps for another level of detail, and invalidates it. Errors: those of
/// crumple_buffer_register_host(), and CRUMPLE_ERROR_INVALID_ARGUMENT (not a host buffer).
CrumpleResult crumple_buffer_set_memory(CrumpleContext *context, CrumpleBuffer buffer, const CrumpleHostBufferDef *def);

/// Writes what changed since the last write of count host buffers, or of all host buffers of the context if buffers is
/// null and count 0, in parallel. With null and 0 it also applies the pending hits of instances without a buffer, so that
/// damage does not depend on which bodies are visible. Nobody else may read or write the memory during the call. out_report may be null. CRUMPLE_ERROR_INVALID_ARGUMENT (no vertex was written): a
/// buffer twice, not a host buffer, or overlapping memory in debug builds.
CrumpleResult crumple_context_deform(CrumpleContext *context, const CrumpleBuffer *buffers, uint32_t count,
                                     CrumpleDeformReport *out_report);

/// Returns the buffers that the last crumple_context_deform() and the last recording or submit wrote to, by increasing
/// index, and whose they are.
CrumpleResult crumple_context_get_changed_buffers(CrumpleContext *context, CrumpleBufferInfo *buffers,
                                                  uint32_t capacity, uint32_t *out_count);

/// Returns the vertices written by the last deform or recording that named the buffer or all buffers, as increasing ranges
/// that do not overlap. out_bounds, which may be null, receives the bounds of all vertices, m; they may be too large for a
/// buffer on a device. Use both for uploads, refits and culling.
CrumpleResult crumple_buffer_get_changes(CrumpleContext *context, CrumpleBuffer buffer, CrumpleRange *ranges,
                                         uint32_t capacity, uint32_t *out_count, CrumpleAabb *out_bounds);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CRUMPLE_H */
