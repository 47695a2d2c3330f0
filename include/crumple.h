// Crumple dents meshes.
//
// You give it a base mesh and a few examples (the same mesh after a collision, made by an artist or a solver) and report
// impulses from your physics engine. It writes the deformed vertices into your own vertex buffers. examples-c has whole
// programs.
//
// The steps, in order:
//   1. Context          crumple_context_create: threads, log, your own job system; crumple_allocator_set
//   2. Example sets     crumple_example_set_create (arrays), ..._load_gltf, ..._load_gltf_memory, ..._load_obj
//                       one per mesh, shared by all its instances; once built, save it with
//                       crumple_example_set_save_baked (or "crumple bake") and load that: ..._load_baked
//   3. Instances        crumple_instance_create, crumple_instance_set_transform
//                       one per body in the scene; a few hundred bytes each
//   4. Hits             crumple_instance_submit_impulse, ..._submit_displacement, ..._end_contact
//                       from any thread, whenever the physics engine reports a contact; or give it every contact point:
//                       crumple_context_report_contacts, and crumple_context_step_contacts once a step
//   5. Damage           crumple_instance_get_marks, ..._set_marks, ..._save_damage, ..._load_damage, ..._repair_damage
//                       a short list of marks of 32 bytes; save it, or send it over the network
//   6. Deformation      crumple_buffer_register_host for your vertex memory, with any strides; once a frame
//                       crumple_context_deform, then crumple_context_get_changed_buffers, and
//                       crumple_buffer_get_changes of each for uploads and bounds
//   7. On the GPU       instead of 6: crumple_vulkan_attach, crumple_buffer_register_vulkan, and once a frame
//                       crumple_vulkan_record into your VkCommandBuffer and crumple_vulkan_complete_frames;
//                       to share memory instead of a command buffer: crumple_vulkan_open, ..._import_buffer, ..._submit;
//                       in passes of your own render graph: crumple_buffer_register_graph, crumple_graph_plan
//   8. Attached points  crumple_example_set_attach_point, crumple_instance_get_attached_frame: lamps, collision vertices
//   9. No more than     crumple_instance_set_view: the level of detail, or the tolerance, that a distance allows;
//      a scene needs    crumple_context_set_vertex_budget: the most vertices to write in a frame
//  10. Bodies of parts  crumple_example_set_add_lod for each part; crumple_instance_release_part, ..._mount_part
//
// Results. Calls that can fail return a CrumpleResult, and crumple_last_error() returns the message. Calls that return
// something else cannot fail. A failed call changes nothing, and everything stays usable. Outputs are written only on
// success, except for counts (see "Arrays"). No call prints, throws, raises a signal or aborts the process (but see
// "Memory").
//
// Every call may return these errors, for the causes on the right. A call's comment adds only other errors and causes:
//   CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED    a pointer argument, or an array in a def
//   CRUMPLE_ERROR_STRUCT_SIZE                               a def with a wrong struct_size
//   CRUMPLE_ERROR_INVALID_ID                                a null, destroyed or foreign id, a destroyed context
//   CRUMPLE_ERROR_INVALID_ARGUMENT                          an enumerator, a number outside its range, a small stride,
//                                                           overlapping streams, text that is not UTF-8, a Vulkan call
//                                                           without its attached device
//   CRUMPLE_ERROR_NOT_FINITE                                NaN or infinity
//   CRUMPLE_ERROR_INDEX_OUT_OF_RANGE                        an index or a lod that is not below its count
//   CRUMPLE_ERROR_BUFFER_TOO_SMALL                          an array with too few bytes or elements
//   CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_CONCURRENT_USE, CRUMPLE_ERROR_INTERNAL
//   CRUMPLE_ERROR_VULKAN, CRUMPLE_ERROR_DEVICE_LOST         a call that uses a Vulkan device
//
// Ownership. Crumple owns what it creates; you hold an id, a small struct by value. An id of zeros is null. Compare ids
// field by field. An id is invalid after its destroy or unregister call; using it is an error, never a crash. An id
// belongs to one context; crumple_example_set_share() gives a set to another. Destroying an instance unregisters its
// buffers. Instances keep their destroyed example set alive. Destroying a context destroys everything in it. You own
// what you pass in: defs, strings and arrays are read during the call and may be freed after it. Four things must live
// longer: memory of registered buffers, data that a context's callbacks use, bytes passed with CRUMPLE_BYTES_KEEP, and
// an attached Vulkan device or imported memory.
//
// Defs. A struct whose name ends in Def comes from its crumple_..._def_default function, which sets struct_size and the
// defaults. Then set the fields that you need. struct_size identifies your header version; a size other than the
// library's is an error. Reserved fields are zero.
//
// Arrays. A call that fills an array takes its capacity and writes the count needed to out_count or out_size, also when
// it returns CRUMPLE_ERROR_BUFFER_TOO_SMALL. Pass null with capacity 0 to get only the count.
//
// Threads. Calls are externally synchronised per context: two threads must not use one context at the same time, and
// callbacks must not call back into it. Either returns CRUMPLE_ERROR_CONCURRENT_USE, in every build. Two kinds of
// functions may be called from any thread at any time: those without a context argument, and crumple_context_submit_...,
// crumple_instance_submit_..., ..._preview_..., ..._end_contact and ..._set_transform. Contexts are
// independent.
//
// Reads. Hits are pending until the instance's damage is next read. These calls read it: a deform, record, submit or plan of
// one of its buffers or of all buffers; ..._get_info(), ..._get_marks(), ..._get_contact(), ..._save_damage(),
// ..._repair_...(), ..._copy_damage() for its source, ..._get_attached_frame(), and ..._release_part(), ..._mount_part() and ..._measure_part(). The result
// does not depend on the number of threads or on the order of hits between two reads. With CRUMPLE_RULE_MARKS it does
// not depend on when reads happen, with three exceptions: marks merge above mark_capacity, contacts end when more than
// 256 are open, and the hits of one contact are summed with rounding.
//
// Units. Metres, seconds, kilograms, newton seconds. Any handedness and any up axis. Vertices in memory of the CPU
// are 32-bit floats, or octahedral where a def says so. Indices start at 0. Enums are 32 bits wide (do not compile with
// -fshort-enums).
//
// Memory. Without memory for an array whose size depends on your input, such as vertices, displacements, a file or a list
// of hits, a call returns CRUMPLE_ERROR_OUT_OF_MEMORY and changes nothing. Without memory for something smaller, or for
// what a parser or a search tree allocates, the process aborts. Frames without hits allocate nothing.
//
// Do not fork() a process with a live context and use the context in the child.
//
// This file is generated from the library's source by `cargo xtask header`; do not edit it.

#ifndef CRUMPLE_H
#define CRUMPLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Major version of this header. Libraries of another major version are incompatible.
#define CRUMPLE_VERSION_MAJOR 0
/// Minor version of this header. Before 1.0, libraries of another minor version are incompatible.
#define CRUMPLE_VERSION_MINOR 1

#define CRUMPLE_VERSION_PATCH 0
/// The version of this header as one number, in the format of crumple_version().
#define CRUMPLE_VERSION (((CRUMPLE_VERSION_MAJOR * 1000000) + (CRUMPLE_VERSION_MINOR * 1000)) + CRUMPLE_VERSION_PATCH)
/// Bit of crumple_features(): the library loads glTF 2.0 and GLB files.
#define CRUMPLE_FEATURE_GLTF 1
/// Bit of crumple_features(): the library loads OBJ files.
#define CRUMPLE_FEATURE_OBJ 2
/// Bit of crumple_features(): crumple_allocator_set() works.
#define CRUMPLE_FEATURE_HOST_ALLOCATOR 4
/// Bit of crumple_features(): crumple_vulkan_attach() works.
#define CRUMPLE_FEATURE_VULKAN 8
/// The result of a call. See "Results" at the top.
typedef enum {
    CRUMPLE_OK = 0,
    /// A value is outside its range, or the call is not allowed in the current state.
    CRUMPLE_ERROR_INVALID_ARGUMENT = 1,
    /// A number is NaN or infinite.
    CRUMPLE_ERROR_NOT_FINITE = 2,
    /// An index is not below its count.
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
    /// The operating system refused to read or write a file.
    CRUMPLE_ERROR_IO = 11,
    /// The damage belongs to another example set, rule or version.
    CRUMPLE_ERROR_DAMAGE_MISMATCH = 12,
    /// Memory ran out. See "Memory" at the top.
    CRUMPLE_ERROR_OUT_OF_MEMORY = 13,
    /// The call does not work with the instance's rule.
    CRUMPLE_ERROR_WRONG_RULE = 14,
    /// A Vulkan function failed.
    CRUMPLE_ERROR_VULKAN = 15,
    /// The Vulkan device is lost. Damage is not lost.
    CRUMPLE_ERROR_DEVICE_LOST = 16,
    /// A required pointer is null.
    CRUMPLE_ERROR_NULL_POINTER = 64,
    /// The struct_size of a def is wrong. Start from the def's crumple_..._def_default function.
    CRUMPLE_ERROR_STRUCT_SIZE = 65,
    /// An id is null or of another context, or an id or a context was destroyed.
    CRUMPLE_ERROR_INVALID_ID = 66,
    /// Two threads used one context at once, or a callback called back into its context.
    CRUMPLE_ERROR_CONCURRENT_USE = 67,
    /// A defect of the library. Please report it with the text of crumple_last_error().
    CRUMPLE_ERROR_INTERNAL = 68,
    /// Recorded frames were not reported to crumple_vulkan_complete_frames().
    CRUMPLE_ERROR_FRAMES_IN_FLIGHT = 69,
} CrumpleResult;

/// The severity of a log message.
typedef enum {
    CRUMPLE_LOG_LEVEL_INFO = 0,
    /// Something that works but is probably a mistake.
    CRUMPLE_LOG_LEVEL_WARNING = 1,
} CrumpleLogLevel;

/// How an example's contact (the place where it was hit) is given.
typedef enum {
    /// Not given: Crumple uses the example's deepest vertex. The default.
    CRUMPLE_CONTACT_KIND_NONE = 0,
    /// As a vertex of the base mesh.
    CRUMPLE_CONTACT_KIND_VERTEX = 1,
    /// As a point in the mesh's space. The vertex nearest to it becomes the contact.
    CRUMPLE_CONTACT_KIND_POINT = 2,
} CrumpleContactKind;

/// Whether an example stays where it was made (anchored) or moves to where the body was hit (carried).
typedef enum {
    /// Anchored if the hit is within a tenth of support_radius of the example's contact and 0.9 to 1 times as deep, or
    /// if the set's examples predict each other better anchored there. Otherwise carried. The default.
    CRUMPLE_PLACEMENT_AUTOMATIC = 0,
    /// Always anchored: for creases, frames, bumpers.
    CRUMPLE_PLACEMENT_ANCHORED = 1,
    /// Always carried: for sheet metal.
    CRUMPLE_PLACEMENT_CARRIED = 2,
} CrumplePlacement;

/// The type of triangle indices. CRUMPLE_INDEX_TYPE_U32 is the default.
typedef enum {
    CRUMPLE_INDEX_TYPE_U32 = 0,
    CRUMPLE_INDEX_TYPE_U16 = 1,
} CrumpleIndexType;

/// What happens when an example moves apart vertices that share a base position.
typedef enum {
    /// The vertices stay together: each gets the mean of their displacements. The default.
    CRUMPLE_SEAMS_WELD = 0,
    /// The vertices move apart as in the example, for tears that the artist made.
    CRUMPLE_SEAMS_KEEP = 1,
} CrumpleSeams;

/// Whether the bytes of a baked set are copied.
typedef enum {
    /// The bytes are copied. Free them after the call.
    CRUMPLE_BYTES_COPY = 0,
    /// The bytes are used in place. They must stay readable and unchanged until the set and all its instances are
    /// destroyed, or the context is; if the set is shared, in all its contexts. Bytes whose address is not a multiple of
    /// 16 are copied.
    CRUMPLE_BYTES_KEEP = 1,
} CrumpleBytes;

/// How hits damage an instance.
typedef enum {
    /// Each hit leaves a mark. Memory is bounded and the order of hits does not matter. The default.
    CRUMPLE_RULE_MARKS = 0,
    /// The classic rule "most displaced" of the paper, for comparison. The order of hits matters. The instance has
    /// no marks and needs memory for each vertex.
    CRUMPLE_RULE_MOST_DISPLACED = 1,
    /// The classic rule "blend", which uses blend_constant. Otherwise like CRUMPLE_RULE_MOST_DISPLACED.
    CRUMPLE_RULE_BLEND = 2,
} CrumpleRule;

/// How a classic rule selects the example for a hit.
typedef enum {
    /// The one example that moves the contact vertex most nearly in the target's direction, with a weight of at most 1. The
    /// default.
    CRUMPLE_SELECTION_CLASSIC = 0,
    /// Without the weight limit. Diverges at weights above 2.
    CRUMPLE_SELECTION_CLASSIC_UNCLAMPED = 1,
} CrumpleSelection;

/// The space that a hit is given in.
typedef enum {
    /// The mesh's own space. The default.
    CRUMPLE_SPACE_LOCAL = 0,
    /// World space. The instance's transform maps it to the mesh's space.
    CRUMPLE_SPACE_WORLD = 1,
} CrumpleSpace;

/// What became of a hit.
typedef enum {
    /// It leaves a mark. With a classic rule, it deforms the instance.
    CRUMPLE_HIT_STATUS_MARKED = 0,
    /// It is below a yield threshold, or its target is shorter than a millionth of the depth limit.
    CRUMPLE_HIT_STATUS_BELOW_YIELD = 1,
    /// No example moves the contact vertex towards the target.
    CRUMPLE_HIT_STATUS_NOTHING_REACHES = 2,
    /// Alone it would leave no mark, but it adds to its contact.
    CRUMPLE_HIT_STATUS_ACCUMULATED = 3,
    /// Its contact cannot move: it is in a rigid part, such as glass, or its own depth limit is 0 or its stiffness 1. It
    /// leaves no mark.
    CRUMPLE_HIT_STATUS_RIGID = 4,
} CrumpleHitStatus;

/// What the impulses of contact points mean, which differs among physics engines.
typedef enum {
    /// Each point has its own impulse: Bullet, PhysX, rapier, ODE. A point whose impulse is 0 did not push. The default.
    CRUMPLE_IMPULSES_PER_POINT = 0,
    /// Each point has the impulse of the whole pair in the step. It is divided among the pair's points.
    CRUMPLE_IMPULSES_WHOLE_AT_EVERY_POINT = 1,
    /// Each point has its own impulse, but 0 means that it is unknown: Godot Physics reports 0 in the step of impact.
    CRUMPLE_IMPULSES_ZERO_IS_UNKNOWN = 2,
} CrumpleImpulses;

/// The format of normals or tangents in memory of the CPU.
typedef enum {
    /// 3 floats for a normal, 4 for a tangent. The default.
    CRUMPLE_DIRECTION_FORMAT_FLOAT = 0,
    /// Octahedral as in Godot: two uint16_t of 4 bytes in all, like a Vulkan buffer's R16G16_UNORM. A normal v is stored
    /// as x and y, times 65535, rounded towards zero:
    ///
    /// - n = v / (|v.x| + |v.y| + |v.z|)
    /// - a = n.z >= 0 ? n.x : (1 - |n.y|) * (n.x >= 0 ? 1 : -1)
    /// - b = n.z >= 0 ? n.y : (1 - |n.x|) * (n.y >= 0 ? 1 : -1)
    /// - x = a * 0.5 + 0.5
    /// - y = b * 0.5 + 0.5
    ///
    /// A tangent is stored as x and t if its w is 0 or above, else as x and 1 - t, where t = max(y, 1 / 32767) * 0.5 +
    /// 0.5. Of its numbers (0, 65535) becomes (65535, 65535), which stands for the same tangent.
    CRUMPLE_DIRECTION_FORMAT_OCTAHEDRAL = 1,
} CrumpleDirectionFormat;

/// The type of a handle to shared memory or to a semaphore.
typedef enum {
    /// A file descriptor, VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT. Crumple duplicates it; you close yours. Linux
    /// and Android.
    CRUMPLE_HANDLE_TYPE_OPAQUE_FD = 0,
    /// A HANDLE, VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_WIN32_BIT. Windows. Untested.
    CRUMPLE_HANDLE_TYPE_OPAQUE_WIN32 = 1,
} CrumpleHandleType;

/// A context holds example sets, instances and buffers. Opaque.
typedef struct CrumpleContext CrumpleContext;

/// Returns size bytes aligned to align (a power of two, at least 16), or null. Must be thread-safe. Must not call
/// Crumple, throw or longjmp out.
typedef void *(*CrumpleAlloc)(size_t size, size_t align, void *user);

/// Frees memory from CrumpleAlloc; size and align are the values it was allocated with. Must be thread-safe. Must not
/// call Crumple, throw or longjmp out.
typedef void (*CrumpleFree)(void *pointer, size_t size, size_t align, void *user);

/// The host's allocator. Both functions are required.
typedef struct {
    uint32_t struct_size;
    CrumpleAlloc alloc;
    CrumpleFree free;
    /// Passed to both. May be null.
    void *user;
} CrumpleAllocatorDef;

/// Receives one message, UTF-8, without a line break at its end. The text is valid only during the callback. Runs on
/// the thread that called Crumple. Must not call the same context, throw or longjmp out.
typedef void (*CrumpleLog)(CrumpleLogLevel level, const char *message, void *user);

/// A task of a parallel-for. Call it with an index below count and with the task_data of CrumpleParallelFor.
typedef void (*CrumpleTask)(uint32_t index, void *task_data);

/// Your parallel-for. Calls task(index, task_data) once for each index below count, on any threads and in any order,
/// and returns when all calls have returned. Tasks may run concurrently, and do not block or throw. Crumple runs any
/// index that you skip, and ignores repeated ones. This function runs on the thread that called Crumple. It must not
/// throw or longjmp out. With the same context it may call only functions allowed at any time; see "Threads".
typedef void (*CrumpleParallelFor)(uint32_t count, CrumpleTask task, void *task_data, void *user);

/// The host's job system. All fields zero: Crumple uses its own threads.
typedef struct {
    CrumpleParallelFor parallel_for;
    void *user;
    /// Number of threads that can work at the same time; 0 counts as 1. It affects how work is split, never the result.
    uint32_t workers;
} CrumpleTaskSystem;

/// Options of a context.
typedef struct {
    uint32_t struct_size;
    /// Threads that deform, up to 1024. 0: one per core. 1: only the calling thread. Unused with tasks. Default 0.
    uint32_t threads;
    /// Receives messages. Default null: none.
    CrumpleLog log;
    void *log_user;
    CrumpleTaskSystem tasks;
} CrumpleContextDef;

/// An array that Crumple reads during the call. Element i is at data + i * stride. The field that uses it states count
/// and type. All fields zero: absent.
typedef struct {
    /// First element, aligned to its type (4 bytes; 2 for 16-bit indices). Null: absent.
    const void *data;
    /// Readable bytes at data: at least (count - 1) * stride + the size of one element.
    size_t size;
    /// Bytes from one element to the next: at least the size of one element, a multiple of its alignment. Not 0.
    size_t stride;
} CrumpleInput;

/// A point or a vector.
typedef struct {
    float x;
    float y;
    float z;
} CrumpleVec3;

/// What struck a body, as far as it is known. 0 is unknown, which costs accuracy.
typedef struct {
    /// kg.
    float mass;
    /// Radius of its surface at the contact, m: small for a corner, large for a flat face.
    float radius;
    /// Velocity relative to the struck body before the touch, m/s.
    CrumpleVec3 velocity;
} CrumpleStriker;

/// An example: the base mesh after a collision. Set target_positions, or delta_indices and position_deltas.
typedef struct {
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
    CrumplePlacement placement;
} CrumpleExampleDef;

/// A mesh as arrays, which are copied. The def that contains it sets its defaults.
typedef struct {
    /// Number of vertices, at least 1. Their order is kept.
    uint32_t vertex_count;
    /// Number of indices, a multiple of 3.
    uint32_t index_count;
    /// Positions: vertex_count times 3 floats, m. Any handedness, any axis up. Required.
    CrumpleInput positions;
    /// Unit normals: vertex_count times 3 floats. Absent: computed from the triangles, smooth across seams.
    CrumpleInput normals;
    /// Tangents as in glTF: vertex_count times 4 floats, xyz of unit length, w +1 or -1. Absent: none.
    CrumpleInput tangents;
    /// Triangles: index_count indices, counter-clockwise seen from outside. Absent: a point cloud, which needs normals.
    CrumpleInput indices;
    CrumpleIndexType index_type;
    /// How far each vertex may move: vertex_count floats, m, at least 0, INFINITY for no limit of its own. Rounded down by up to
    /// 1 in 128. The depth limits of the set and of the instance hold too. Absent: none; for a further mesh of a set, those
    /// of the nearest base vertices.
    CrumpleInput depth_limits;
    /// How much less than its dents each vertex moves: vertex_count floats, 0 (as the dents say) to 1 (not at all). Absent: 0;
    /// for a further mesh of a set, as the nearest base vertices.
    CrumpleInput stiffness;
} CrumpleMeshDef;

/// How an example set is built. The def that contains it sets its defaults.
typedef struct {
    /// No vertex moves further than this, m. Default 0: the depth of the deepest example.
    float depth_limit;
    /// Displacements of an example up to this length are dropped, m. Default 0: drops only zeros.
    float drop_below;
    /// Mass of every vertex, kg, for impulses without a mass. It is a calibration constant in impulse * duration /
    /// mass, not the body's mass. Default 0: unknown.
    float vertex_mass;
    /// Nodes along each side of the grid that stores a carried example: 4 to 128. Default 32; sharp creases need more.
    /// If bake_tolerance is above 0, this is the maximum.
    uint32_t stamp_resolution;
    /// Largest position error from quantisation at weight 1, m. Above 0, displacements are stored as integers of 1 or 2
    /// bytes, and carried examples on the coarsest grid within the error. Default 0: exact floats. It changes the
    /// fingerprint; depth_limit and vertex_mass do not.
    float bake_tolerance;
    /// Largest error of a normal at weight 1, degrees, above 0 and up to 45. Unused if bake_tolerance is 0. Default 1.
    float bake_normal_tolerance;
    /// Mass of each vertex, kg: vertex_count floats, instead of vertex_mass. Default absent.
    CrumpleInput vertex_masses;
    CrumpleSeams seams;
    /// Also use mirrored copies of the examples if the body is symmetric about a coordinate plane through the centre of
    /// its bounds. Default true.
    bool mirror;
    /// Fade carried dents to zero at boundary edges that no example moves. Default true.
    bool held_rims;
} CrumpleExampleSetOptions;

/// A base mesh, at least one example, and the options of the set.
typedef struct {
    uint32_t struct_size;
    uint32_t example_count;
    CrumpleMeshDef mesh;
    /// example_count defs, each from crumple_example_def_default().
    const CrumpleExampleDef *examples;
    CrumpleExampleSetOptions options;
} CrumpleExampleSetDef;

/// A base mesh with its examples: immutable, shared by any number of instances. An id; zero is null.
typedef struct {
    uint32_t index;
    uint16_t generation;
    uint16_t context;
} CrumpleExampleSet;

/// Another mesh of a set's body, such as a level of detail, in the base mesh's space.
typedef struct {
    uint32_t struct_size;
    CrumpleMeshDef mesh;
} CrumpleLodDef;

/// Everything within radius, m, of the segment between two points, m. Equal points make a ball.
typedef struct {
    CrumpleVec3 a;
    CrumpleVec3 b;
    float radius;
} CrumpleCapsule;

/// Which mesh of a glTF file to load, and the options of the set.
typedef struct {
    uint32_t struct_size;
    /// Index of the mesh in the file, used if mesh_name is null. Default UINT32_MAX: the first mesh whose morph targets move it.
    uint32_t mesh_index;
    /// Name of the mesh, UTF-8. Default null: mesh_index decides.
    const char *mesh_name;
    /// Path of the .glb or .gltf file, UTF-8. For crumple_example_set_load_gltf_memory(): the folder of other files
    /// that the glTF refers to. If it is null there, a glTF that refers to files is an error.
    const char *path;
    CrumpleExampleSetOptions options;
    /// Whether to join the meshes of all nodes, but those of other scenes, to one body, each where its node places it. Default
    /// false. Each node with a mesh then is a part: lods 1 and up, in the order of the nodes; see
    /// crumple_example_set_find_part(). If there are more than 63, the smallest belong to the part of a node above them. Morph
    /// targets of the same name are one example if they lie near each other. mesh_index and mesh_name are not used.
    bool join_nodes;
    /// Length of the file's unit, m. Default 1.
    float unit;
    /// Patterns of names, UTF-8, one a line: * stands for any text, ? for any character, upper and lower case are the same,
    /// and ! at the start takes names out. The nodes to join; a name above a node's counts too. Default null: join_nodes
    /// decides.
    const char *nodes;
    /// Patterns of the morph targets that are dents. Default null: mesh.extras.dents, or else all.
    const char *targets;
    /// Patterns of nodes or materials that never move. Hits on them leave no mark.
    const char *rigid;
    /// Patterns of nodes or materials that are glass: parts that follow dents around them. Hits on them leave marks until
    /// crumple_instance_set_part_rigid() is called for the part.
    const char *glass;
    /// Patterns of nodes that move on their own, such as wheels: they are no part of a joined body.
    const char *moving;
} CrumpleGltfDef;

/// A base OBJ file, its example files, and the options of the set.
typedef struct {
    uint32_t struct_size;
    /// Number of example_paths, at least 1.
    uint32_t example_count;
    /// Path of the base mesh, UTF-8. Required.
    const char *base_path;
    /// Paths of the examples, UTF-8. Each has the v lines of the base mesh in the same order.
    const char *const *example_paths;
    CrumpleExampleSetOptions options;
} CrumpleObjDef;

/// An array that Crumple writes. Element i is at data + offset + i * stride. Positions and normals are 3 floats,
/// tangents 4 floats, indices one uint32_t, unless the def has another format. Bytes between elements are not touched, so
/// streams may be interleaved. All fields zero: absent.
typedef struct {
    /// Start of the memory, aligned to 4 bytes. Null: absent.
    void *data;
    /// Writable bytes at data: at least offset + (count - 1) * stride + the size of one element.
    size_t size;
    /// Bytes from data to the first element, a multiple of 4.
    size_t offset;
    /// Bytes from one element to the next: at least the size of one element, a multiple of 4. 0 is an error.
    size_t stride;
} CrumpleStream;

/// Where to copy a mesh: positions (m), unit normals, tangents and 3 * triangle_count indices. Absent streams are
/// skipped.
typedef struct {
    uint32_t struct_size;
    /// Which mesh: 0 for the base mesh, or a number from crumple_example_set_add_lod(). Default 0.
    uint32_t lod;
    CrumpleStream positions;
    CrumpleStream normals;
    CrumpleStream tangents;
    CrumpleStream indices;
} CrumpleMeshCopyDef;

/// An axis-aligned box, m.
typedef struct {
    CrumpleVec3 min;
    CrumpleVec3 max;
} CrumpleAabb;

/// Facts about an example set. Counts and bounds are the base mesh's. Strings are valid until the set is destroyed.
typedef struct {
    /// Name of the mesh in its file, UTF-8; empty for a set built from arrays. Never null.
    const char *name;
    /// Equal for equal sets, on any machine. Saved damage fits only sets with the same fingerprint.
    uint64_t fingerprint;
    uint64_t memory_bytes;
    uint32_t vertex_count;
    uint32_t triangle_count;
    uint32_t example_count;
    /// Parts of the mesh with their own material, at least 1.
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
    /// Number of examples that know their blow. From 1 on, the set predicts what an impulse leaves.
    uint32_t blow_count;
    /// Median error of the displacements around an example, and of its depth, when the other examples predict them:
    /// relative, 0 is perfect. Negative if unknown.
    float field_error;
    float depth_error;
    uint64_t reserved[2];
} CrumpleExampleSetInfo;

/// Facts about an example. name is UTF-8, never null, and valid until the set is destroyed.
typedef struct {
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
    CrumplePlacement placement;
    /// Error of its displacements, and of its depth, when the other examples predict them: relative, 0 is perfect.
    /// Negative if unknown. Where they are large, one more example helps most.
    float field_error;
    float depth_error;
    uint64_t reserved;
} CrumpleExampleInfo;

/// A part of the mesh with its own material. material is its name (UTF-8, valid until the set is destroyed) or null.
typedef struct {
    const char *material;
    uint32_t first_vertex;
    uint32_t vertex_count;
    /// First triangle. Its first index is 3 * first_triangle.
    uint32_t first_triangle;
    uint32_t triangle_count;
    uint32_t reserved[2];
} CrumplePrimitive;

/// Options of an instance.
typedef struct {
    uint32_t struct_size;
    /// Most examples that one hit may combine: 1 to 4. Default 3.
    uint32_t examples_per_hit;
    /// The example set, which the instance keeps alive. Required.
    CrumpleExampleSet set;
    CrumpleRule rule;
    /// How a classic rule selects an example. CRUMPLE_RULE_MARKS needs the default.
    CrumpleSelection selection;
    /// Most marks kept, 1 to 65535, 32 bytes each. Above, the weakest mark merges into the nearest. Default 64.
    uint32_t mark_capacity;
    /// No vertex moves further than this, m. Default 0: the set's limit.
    float depth_limit;
    /// Impulses shorter than this leave no mark, N s, in the hit's space. Default 0.
    float yield_impulse;
    /// Hits with a target displacement shorter than this leave no mark, m, in the mesh's space. Default 0.
    float yield_displacement;
    /// Hits further than this from the nearest vertex are errors, m, in the mesh's space. Default 0: the diagonal of
    /// the bounds, or the depth limit if larger.
    float max_contact_distance;
    /// Constant of CRUMPLE_RULE_BLEND, 0 to 1. Default 0.
    float blend_constant;
    /// Largest position error, m; see crumple_instance_set_tolerance(). Default 0: none.
    float tolerance;
    /// How far a blow of 1 N s moves its contact, m per N s, if no example of the set knows its blow. duration and mass of
    /// impulses are then unused. Default 0: duration / mass.
    float compliance;
    /// How long a dent takes to appear, to deepen or to be repaired, s; see crumple_context_set_time(). Default 0: none.
    float grow_time;
    /// Transform; see crumple_instance_set_transform(). Default the identity.
    float local_to_world[16];
} CrumpleInstanceDef;

/// A body in the scene: an example set, a transform and the damage. An id; zero is null.
typedef struct {
    uint32_t index;
    uint16_t generation;
    uint16_t context;
} CrumpleInstance;

/// The state of an instance. Pending hits are included.
typedef struct {
    /// The set that it was created with. The id is invalid if the set was destroyed.
    CrumpleExampleSet set;
    /// Memory of the instance, bytes, without the set and without your buffers.
    uint64_t memory_bytes;
    /// Number of marks; 0 with a classic rule.
    uint32_t mark_count;
    uint32_t buffer_count;
    float depth_limit;
    /// Number of open contacts; see crumple_instance_end_contact().
    uint32_t contact_count;
    /// Number for the marks: equal marks have equal revisions, on all machines. 0 without marks.
    uint64_t revision;
    uint32_t reserved[2];
} CrumpleInstanceInfo;

/// A hit given as a blow. point and vectors are in the given space (default CRUMPLE_SPACE_LOCAL). Give impulse, or mass
/// and velocity of the striker. Report a contact once with its whole impulse, or in parts with a contact_id. If any
/// example of the set knows its blow, the set predicts the displacement of the contact: give as much of the blow as the
/// engine knows. Otherwise the displacement is impulse * the instance's compliance, or impulse * duration / mass.
typedef struct {
    uint32_t struct_size;
    CrumpleSpace space;
    /// Where the body was hit, m. The nearest vertex becomes the contact.
    CrumpleVec3 point;
    /// The impulse on the body, N s. Default 0: striker.mass * striker.velocity. If that is 0 too, there is no mark.
    CrumpleVec3 impulse;
    /// How long the impulse acted, s: a constant of the material such as 0.01, not the time step. Required if no example
    /// knows its blow and the instance has no compliance.
    float duration;
    /// Mass of the contact vertex, kg, for impulse * duration / mass. Default 0: the set's mass for that vertex.
    float mass;
    /// Contact normal, out of the body, of any length. Default 0: unknown.
    CrumpleVec3 normal;
    CrumpleStriker striker;
    /// The contact that the hit is part of; see crumple_instance_end_contact(). Default 0: none.
    uint64_t contact_id;
} CrumpleImpulseDef;

/// A hit given as the desired contact displacement, for engines with their own impulse-to-depth mapping. The dent does
/// not depend on the frame rate. Fields without a comment are as in CrumpleImpulseDef.
typedef struct {
    uint32_t struct_size;
    CrumpleSpace space;
    CrumpleVec3 point;
    /// Target displacement of the contact, m.
    CrumpleVec3 displacement;
    uint64_t contact_id;
} CrumpleDisplacementDef;

/// An example that a hit uses.
typedef struct {
    uint32_t example;
    /// Share of the dent; shares of a hit sum to 1. Negative if it corrects overshoot of the others.
    float share;
    /// Factor that multiplies the example's displacements.
    float scale;
    /// Whether the example is anchored. Otherwise it is carried to the contact.
    bool anchored;
    /// Mirrored coordinates, as bits: 1 for x, 2 for y, 4 for z.
    uint8_t mirror;
    uint16_t reserved;
} CrumpleChosen;

/// An example, how it is placed, and its share of a dent.
typedef struct {
    /// Index of the example; 0xFFFF in an unused pair.
    uint16_t example;
    /// Low 12 bits: share of the dent, two's complement; 1024 is the whole dent. Bits 12, 13 and 14: the example is
    /// mirrored in x, y and z. Bit 15: the example is anchored.
    uint16_t share;
} CrumplePair;

/// One dent: contact, depth and examples. Plain data, 32 bytes, little-endian, equal on all machines: send or save it
/// as is.
typedef struct {
    /// The vertex that was hit.
    uint32_t contact;
    /// Requested depth at the contact, m, above 0.
    float depth;
    /// Energy in hits of this depth, in units of 2^-32: 4294967296 for one hit. Hits that repeat the mark add to it.
    uint64_t energy;
    /// Up to four examples. Used pairs come first.
    CrumplePair pairs[4];
} CrumpleMark;

/// The effect of a hit. If its status is not CRUMPLE_HIT_STATUS_MARKED, achieved, chosen and mark are zero.
typedef struct {
    CrumpleHitStatus status;
    /// The vertex nearest to the point.
    uint32_t contact_vertex;
    /// Distance of that vertex from the point, m.
    float contact_distance;
    /// Target displacement of the contact, before it is clamped, m, in the mesh's space.
    CrumpleVec3 target;
    /// Displacement of the contact by this hit alone, m, in the mesh's space.
    CrumpleVec3 achieved;
    uint32_t chosen_count;
    /// Whether the target was longer than the depth limit and was cut to it.
    bool clamped;
    /// The examples, the largest share first.
    CrumpleChosen chosen[4];
    /// The mark. All zero if the hit leaves none.
    CrumpleMark mark;
    uint64_t reserved[4];
} CrumpleHitResult;

/// Options of a context's contacts.
typedef struct {
    uint32_t struct_size;
    /// What the impulses of points mean. Default CRUMPLE_IMPULSES_PER_POINT.
    CrumpleImpulses impulses;
    /// Factor of the energy of every blow, at least 0. Default 1: what the physics says.
    float gain;
    /// Points that approach more slowly leave nothing, m/s. Default -1: a quarter of the speed of the set's slowest
    /// example, at least 0.5 m/s, which is above what gravity adds in a step of 1/30 s.
    float min_speed;
    /// Touches of less energy leave nothing, J. Default -1: a sixteenth of the energy of the set's weakest example.
    float min_energy;
    /// Points of a pair that are nearer to each other make one dent, m, in the mesh's space. Default -1: half of the median
    /// support radius of the set's examples.
    float dent_radius;
    /// How long a touch lasts at most, s, above 0. What pushes longer makes another dent, if it is fast enough. Default 0.1.
    float touch_time;
    /// A touch whose pair was not reported for longer than this has ended, s, at least 0. Default 0.05.
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
typedef struct {
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
    /// How easily the two move at the point along the normal, with rotation, 1/kg. Default 0: 1/m_a + 1/m_b.
    float inverse_mass;
    /// Radii of the surfaces of a and b at the point, m: small for a corner, large for a flat face. Default 0: unknown.
    float radii[2];
    /// Factor of the point's energy, for the materials of the pair, at least 0. Default 1.
    float gain;
} CrumpleContactPointDef;

/// What steps of a context's contacts did.
typedef struct {
    /// Points that were reported.
    uint64_t points;
    /// Hits that instances got.
    uint64_t hits;
    /// Touches that began.
    uint64_t begun;
    /// Touches that ended.
    uint64_t ended;
    /// Touches that last.
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

/// A hit that the last step of contacts brought to an instance, for sounds, sparks and scores. If both bodies dent, each
/// has one.
typedef struct {
    /// The pair whose points made the hit.
    uint64_t pair;
    /// The touch that the hit is a part of; see crumple_instance_get_contact().
    uint64_t contact_id;
    CrumpleInstance instance;
    /// Where the instance was hit, m, in world space.
    CrumpleVec3 point;
    /// The impulse on the instance, N s, in world space.
    CrumpleVec3 impulse;
    /// The effect of this hit alone.
    CrumpleHitResult result;
} CrumpleContactHit;

/// What crumple_example_set_map_damage() did with the marks.
typedef struct {
    /// Marks whose contact has a vertex at the same position in the new set.
    uint32_t kept;
    /// Marks that are now at another position, the nearest vertex.
    uint32_t moved;
    /// Marks left out because the nearest vertex is further than max_distance.
    uint32_t too_far;
    /// Marks left out because an example of theirs is missing in the new set.
    uint32_t without_example;
    /// The furthest that a mark moved, m.
    float distance;
    /// How many examples are missing that marks need, and the first of them: its index in the old set. 0xFFFFFFFF: none.
    uint32_t missing_examples;
    uint32_t first_missing_example;
} CrumpleDamageMapping;

/// Memory for the deformed vertices of one instance, in the mesh's order and space.
typedef struct {
    uint32_t struct_size;
    /// Which mesh: 0 for the base mesh, or a number from crumple_example_set_add_lod(). Default 0.
    uint32_t lod;
    /// Positions, m. Required.
    CrumpleStream positions;
    /// Unit normals in normal_format. Absent: not written.
    CrumpleStream normals;
    /// Tangents in tangent_format: xyz of unit length and orthogonal to the normal, w as in the mesh. Absent: not
    /// written.
    CrumpleStream tangents;
    /// Format of normals. Default CRUMPLE_DIRECTION_FORMAT_FLOAT.
    CrumpleDirectionFormat normal_format;
    /// Format of tangents. Default CRUMPLE_DIRECTION_FORMAT_FLOAT.
    CrumpleDirectionFormat tangent_format;
} CrumpleHostBufferDef;

/// Registered memory of yours that receives an instance's deformed vertices. An id; zero is null.
typedef struct {
    uint32_t index;
    uint16_t generation;
    uint16_t context;
} CrumpleBuffer;

/// The work done by a deform. A block is a run of up to 128 consecutive vertices.
typedef struct {
    uint64_t vertices_written;
    uint64_t blocks_written;
    /// Blocks that were up to date.
    uint64_t blocks_skipped;
    /// Examples of marks skipped by tolerances; see crumple_instance_set_tolerance().
    uint64_t parts_skipped;
    /// Vertices that wait for a later call; see crumple_context_set_vertex_budget().
    uint64_t vertices_waiting;
    uint64_t reserved[3];
} CrumpleDeformReport;

/// A range of vertices or triangles.
typedef struct {
    uint32_t first;
    uint32_t count;
} CrumpleRange;

/// Any Vulkan function, like PFN_vkVoidFunction. Cast to it: (CrumpleVulkanFunction)vkGetInstanceProcAddr.
typedef void (*CrumpleVulkanFunction)(void);

/// Your Vulkan device, Vulkan 1.1 or later: a VkInstance, a VkPhysicalDevice and a VkDevice, all required. No extension
/// or feature needs to be enabled.
typedef struct {
    uint32_t struct_size;
    /// Family of the queue that executes the command buffers, with compute. Required. Default UINT32_MAX (invalid).
    uint32_t queue_family;
    /// vkGetInstanceProcAddr of the instance's loader. Crumple gets every function from it and never opens a Vulkan
    /// library. Required.
    CrumpleVulkanFunction get_instance_proc_addr;
    void *instance;
    void *physical_device;
    void *device;
    /// Data of crumple_vulkan_get_pipeline_cache() from an earlier run, read during the call. Data of another driver is
    /// ignored. Default null.
    const void *pipeline_cache;
    /// Bytes at pipeline_cache.
    size_t pipeline_cache_size;
    /// Invocations per workgroup: 32, 64, 128 or 256, within the device's limit. Default 128.
    uint32_t workgroup_size;
} CrumpleVulkanAttachDef;

/// Where the values of one attribute are stored. All fields zero: absent.
typedef struct {
    /// Bytes from the start of the range to the first value, a multiple of 4.
    uint64_t offset;
    /// Bytes from one value to the next: at least the size of a value, a multiple of 4.
    uint64_t stride;
    /// A VkFormat. Positions: R32G32B32_SFLOAT, R16G16B16A16_SFLOAT (w is 1), R16G16B16A16_SNORM (see
    /// CrumpleVulkanBufferDef.scale). Normals: R32G32B32_SFLOAT, R16G16B16A16_SNORM, R8G8B8A8_SNORM (w is 0),
    /// R16G16_UNORM (octahedral, see CRUMPLE_DIRECTION_FORMAT_OCTAHEDRAL). Tangents: R32G32B32A32_SFLOAT,
    /// R16G16B16A16_SNORM, R8G8B8A8_SNORM, R16G16_UNORM (octahedral).
    uint32_t format;
    uint32_t reserved;
} CrumpleVulkanStream;

/// A range of a VkBuffer for the deformed vertices of one instance, in the mesh's order and space. Fields without a
/// comment are as in CrumpleHostBufferDef.
typedef struct {
    uint32_t struct_size;
    uint32_t lod;
    /// The VkBuffer, bound to memory: (uint64_t)handle. Required. One VkBuffer may hold any number of ranges; their
    /// buffer_size, usage, queue_family and four stage and access fields must be equal.
    uint64_t buffer;
    /// Bytes of the whole VkBuffer. Required.
    uint64_t buffer_size;
    /// VkBufferUsageFlags of the VkBuffer. They must include VK_BUFFER_USAGE_STORAGE_BUFFER_BIT. Required.
    uint32_t usage;
    /// The other queue family that owns the VkBuffer. Default VK_QUEUE_FAMILY_IGNORED: the attached queue family owns
    /// it, or it is VK_SHARING_MODE_CONCURRENT. With another owner, each recording that includes one of its ranges
    /// begins with an acquire and ends with a release of the whole VkBuffer, even without changes. You record the
    /// matching release and acquire on the other queue.
    uint32_t queue_family;
    /// VkPipelineStageFlags of your last uses of the VkBuffer before a recording, not 0. Barriers cover the whole
    /// VkBuffer, so include the stages of index reads, copies and read-backs. Default
    /// VK_PIPELINE_STAGE_VERTEX_INPUT_BIT.
    uint32_t before_stages;
    /// VkAccessFlags of those uses. Default VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT.
    uint32_t before_access;
    /// VkPipelineStageFlags of your next uses of anything in the VkBuffer, not 0. Default
    /// VK_PIPELINE_STAGE_VERTEX_INPUT_BIT.
    uint32_t after_stages;
    /// VkAccessFlags of those uses. Default VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT.
    uint32_t after_access;
    /// Start of the range, bytes, a multiple of 4.
    uint64_t offset;
    /// Bytes of the range. Nothing outside is written. Ranges may interleave, but values must not overlap. Required.
    uint64_t size;
    CrumpleVulkanStream positions;
    CrumpleVulkanStream normals;
    CrumpleVulkanStream tangents;
    /// For positions in R16G16B16A16_SNORM: a stored value s in -1 to 1 means s * scale + bias, m. Positions outside
    /// that range are clamped, so it must cover the mesh's bounds grown by the depth limit. Above 0. Default 1, 1, 1.
    CrumpleVec3 scale;
    CrumpleVec3 bias;
} CrumpleVulkanBufferDef;

/// The recorded work. Fields without a comment are as in CrumpleDeformReport.
typedef struct {
    uint64_t vertices_written;
    /// Blocks that will be written. 0: only queue-family transfers were recorded, if any.
    uint64_t blocks_written;
    uint64_t blocks_skipped;
    uint64_t parts_skipped;
    /// Bytes that the commands copy to the device, including meshes used for the first time.
    uint64_t bytes_copied;
    /// Dispatches: one per VkBuffer, and one per buffer of an instance with a classic rule.
    uint32_t dispatches;
    uint32_t reserved0;
    uint64_t vertices_waiting;
    uint64_t reserved[3];
} CrumpleRecordReport;

/// A Vulkan device that Crumple creates beside yours, on the same physical device. Fields without a comment are as in
/// CrumpleVulkanAttachDef.
typedef struct {
    uint32_t struct_size;
    uint32_t workgroup_size;
    /// vkGetInstanceProcAddr of a loader that stays loaded. Required.
    CrumpleVulkanFunction get_instance_proc_addr;
    /// deviceUUID of your physical device (VkPhysicalDeviceIDProperties). Devices with equal UUIDs can share memory.
    /// Default zero: the first device that supports compute.
    uint8_t device_uuid[16];
    const void *pipeline_cache;
    /// Bytes at pipeline_cache.
    size_t pipeline_cache_size;
} CrumpleVulkanOpenDef;

/// A VkBuffer of your device that Crumple imports. Create it with VkExternalMemoryBufferCreateInfo, and its memory with
/// VkExportMemoryAllocateInfo, both with handle_type (default CRUMPLE_HANDLE_TYPE_OPAQUE_FD). offset is where the
/// VkBuffer starts in the memory (default 0) and size is its size, bytes. usage is as in CrumpleVulkanBufferDef.
typedef struct {
    uint32_t struct_size;
    CrumpleHandleType handle_type;
    /// Handle of the memory. Required. Default -1.
    int64_t handle;
    /// allocationSize of the memory, bytes. Required.
    uint64_t memory_size;
    /// memoryTypeIndex of the memory. Required.
    uint32_t memory_type;
    uint32_t usage;
    uint64_t offset;
    uint64_t size;
    /// Whether the memory is dedicated to this buffer (VkMemoryDedicatedAllocateInfo). Default false.
    bool dedicated;
} CrumpleVulkanImportDef;

/// Bytes to copy into a storage of the render graph.
typedef struct {
    /// Number of the storage. Create a storage buffer of storage_size bytes for a number that is new to you.
    uint32_t storage;
    uint32_t reserved;
    uint64_t storage_size;
    /// Where the bytes go, from the start of the storage.
    uint64_t offset;
    const void *data;
    /// Bytes at data.
    size_t size;
} CrumpleGraphUpload;

/// A compute dispatch of the render graph.
typedef struct {
    /// Number of the kernel; see crumple_graph_get_kernel().
    uint32_t kernel;
    /// Number of the storage to bind.
    uint32_t storage;
    /// The vertex buffer to bind: the buffer field of its CrumpleVulkanBufferDef.
    uint64_t buffer;
    /// Workgroups along x and y. Use 1 along z.
    uint32_t groups[2];
    /// The push constants, 32 bytes. Kernels read the first 28; some engines take multiples of 16 only.
    uint32_t constants[8];
} CrumpleGraphDispatch;

/// The passes of a frame. All pointers are valid until the next crumple_graph_plan() of the context.
typedef struct {
    /// Numbers of storages that you may destroy once earlier frames are complete. Ignore those that you do not know.
    const uint32_t *freed;
    /// Copies that you do before the dispatches, in any case.
    const CrumpleGraphUpload *uploads;
    /// Dispatches in any order; they write different vertices.
    const CrumpleGraphDispatch *dispatches;
    /// The work of the frame, for all dispatches.
    const void *work;
    /// Bytes at work. 0 if there are no dispatches.
    size_t work_size;
    uint32_t freed_count;
    uint32_t upload_count;
    uint32_t dispatch_count;
    uint32_t reserved;
} CrumpleGraphPlan;

/// A point bound to the nearest surface. Plain data: you may copy or save it. It works with every instance of its set.
typedef struct {
    /// Vertices of the triangle. All three are equal if the mesh has no triangles.
    uint32_t vertices[3];
    /// Barycentric weights of the surface point; they sum to 1.
    float weights[3];
    /// The attached point on the undamaged mesh, m, in the mesh's space.
    CrumpleVec3 point;
    uint32_t reserved[3];
} CrumpleAttachment;

/// A rotation as a unit quaternion.
typedef struct {
    float x;
    float y;
    float z;
    float w;
} CrumpleQuat;

/// The position of an attached point, and its rotation relative to the undamaged mesh.
typedef struct {
    /// Position, m, in the mesh's space.
    CrumpleVec3 position;
    CrumpleQuat rotation;
    uint32_t reserved[5];
} CrumpleFrame;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// Returns the version of the running library: major * 1000000 + minor * 1000 + patch. Compare it with CRUMPLE_VERSION.
uint32_t crumple_version(void);

/// Returns the version of the running library as text, such as "0.1.0". The text stays valid for ever.
const char *crumple_version_string(void);

/// Returns the CRUMPLE_FEATURE_ bits of this build, combined with or. Ignore bits that you do not know.
uint64_t crumple_features(void);

/// Returns the message of the calling thread's last failed call, as UTF-8: "crumple_instance_create: ...". It names the
/// wrong value and what would be right. It is empty before the first failure; calls that succeed leave it unchanged.
/// The text stays valid until the thread's next failed call. It has at most 1023 bytes and is never null.
const char *crumple_last_error(void);

/// Returns the name of a result, such as "CRUMPLE_ERROR_FORMAT", or "unknown result". The text stays valid for ever.
const char *crumple_result_name(CrumpleResult result);

/// Returns a def without functions. Set both.
CrumpleAllocatorDef crumple_allocator_def_default(void);

/// Makes the library allocate from your functions, in the whole process. Null restores the system's allocator. You may
/// call this at any time. Each block is freed by the functions that allocated it, so they must stay callable.
/// Destroying all contexts frees all blocks, except for a few kB per thread of Crumple's own, kept until process exit.
/// A process can use at most 15 different allocators. Builds without CRUMPLE_FEATURE_HOST_ALLOCATOR return
/// CRUMPLE_ERROR_UNSUPPORTED.
CrumpleResult crumple_allocator_set(const CrumpleAllocatorDef *allocator);

/// Returns the default options: one thread per core, no log.
CrumpleContextDef crumple_context_def_default(void);

/// Creates a context. Data that its callbacks use must live until the context is destroyed. Any thread may call this.
/// Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (more than 1024 threads, or 65535 contexts alive),
/// CRUMPLE_ERROR_OUT_OF_MEMORY (the system cannot start the threads).
CrumpleResult crumple_context_create(const CrumpleContextDef *def, CrumpleContext **out_context);

/// Destroys a context and everything in it. It neither frees nor touches your own memory. The context and its ids
/// become invalid. No other call may be running with this context. An attached Vulkan device must still exist.
/// CRUMPLE_ERROR_FRAMES_IN_FLIGHT: nothing was destroyed; see crumple_vulkan_complete_frames().
CrumpleResult crumple_context_destroy(CrumpleContext *context);

/// Returns a def without positions. Set them.
CrumpleExampleDef crumple_example_def_default(void);

/// Returns a def without mesh and examples. Set them.
CrumpleExampleSetDef crumple_example_set_def_default(void);

/// Builds an example set from arrays. This indexes the mesh and samples every example, which takes time: build sets
/// while loading, or load baked ones. Errors: CRUMPLE_ERROR_MESH (no vertices), CRUMPLE_ERROR_EXAMPLE_MISMATCH (no
/// examples, or one that does not fit the mesh).
CrumpleResult crumple_example_set_create(CrumpleContext *context, const CrumpleExampleSetDef *def,
                                         CrumpleExampleSet *out_set);

/// Returns a def without mesh. Set it.
CrumpleLodDef crumple_lod_def_default(void);

/// Adds a mesh that shows the same damage, such as a level of detail or a collision proxy. Call this before the set's
/// first instance is created. out_lod receives its number for the lod fields of defs, 1 for the first. Each vertex is
/// bound to the nearest point of the base surface and moves with it. A vertex at the position of a base vertex moves
/// exactly like that vertex. Contacts, marks, saved damage and the fingerprint still refer to the base mesh. Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (the set has instances), CRUMPLE_ERROR_MESH.
CrumpleResult crumple_example_set_add_lod(CrumpleContext *context, CrumpleExampleSet set, const CrumpleLodDef *def,
                                          uint32_t *out_lod);

/// Gives a set to another context too, without a copy, such as one that loads levels on another thread. The contexts stay
/// as independent as they were. Destroying the set in one of them does not affect the others. Both
/// contexts are in use during the call. Add levels of detail before. CRUMPLE_ERROR_INVALID_ARGUMENT: other is context.
CrumpleResult crumple_example_set_share(CrumpleContext *context, CrumpleExampleSet set, CrumpleContext *other,
                                        CrumpleExampleSet *out_set);

/// Destroys a set. Its id and the strings of its infos become invalid. Instances keep the set's memory and still work.
CrumpleResult crumple_example_set_destroy(CrumpleContext *context, CrumpleExampleSet set);

/// Computes depth limits for a mesh, so that no dent moves a vertex into a solid, such as a roll cage or an engine: the
/// distance from the nearest of the capsules and closed meshes, 0 inside one, and at most the mesh's own limits. Of solids
/// the positions and indices are read. out_limits receives vertex_count floats, m; give them to the def as depth_limits.
/// Call it for each level of detail too. Error messages number the capsules before the meshes. CRUMPLE_ERROR_MESH: a solid
/// is not closed.
CrumpleResult crumple_mesh_keep_out(const CrumpleMeshDef *mesh, const CrumpleCapsule *capsules, uint32_t capsule_count,
                                    const CrumpleMeshDef *meshes, uint32_t mesh_count, float *out_limits);

/// Returns a def for the first mesh whose morph targets move it, with default options. Set the path.
CrumpleGltfDef crumple_gltf_def_default(void);

/// Returns a def with default options. Set the paths.
CrumpleObjDef crumple_obj_def_default(void);

/// Builds an example set from a glTF 2.0 or GLB file: a mesh with its morph targets. Primitives are joined in their
/// order; see crumple_example_set_get_primitive(). mesh.extras has the examples' names (targetNames), contacts
/// (impacts) and placements. Coordinates are in the mesh's own space, and node transforms are not applied, unless nodes
/// are joined. What is odd in the file is logged as warnings. Errors: CRUMPLE_ERROR_IO, CRUMPLE_ERROR_FORMAT (malformed,
/// or no such mesh), CRUMPLE_ERROR_UNSUPPORTED (Draco's compression, or a build without CRUMPLE_FEATURE_GLTF),
/// CRUMPLE_ERROR_EXAMPLE_MISMATCH (no morph targets), and those of crumple_example_set_create().
CrumpleResult crumple_example_set_load_gltf(CrumpleContext *context, const CrumpleGltfDef *def,
                                            CrumpleExampleSet *out_set);

/// Like crumple_example_set_load_gltf(), but reads the file from the size bytes at data, of any alignment.
CrumpleResult crumple_example_set_load_gltf_memory(CrumpleContext *context, const void *data, size_t size,
                                                   const CrumpleGltfDef *def, CrumpleExampleSet *out_set);

/// Builds an example set from a base OBJ file and one OBJ file per example. Examples are named after their files. Each
/// must have the base's v lines in the base's order. The set's vertices are the distinct corners of the base's faces, in the
/// order in which they are used, or its v lines if it has no faces. Polygons are triangulated. What is odd in the files is
/// logged as warnings. Errors: CRUMPLE_ERROR_IO, CRUMPLE_ERROR_FORMAT, CRUMPLE_ERROR_UNSUPPORTED (a build without
/// CRUMPLE_FEATURE_OBJ), and those of crumple_example_set_create().
CrumpleResult crumple_example_set_load_obj(CrumpleContext *context, const CrumpleObjDef *def,
                                           CrumpleExampleSet *out_set);

/// Loads an example set from the size bytes of a .crumple file at data, written by "crumple bake" or
/// crumple_example_set_save_baked(). Loading builds nothing and is fast. All bytes are validated. The set has one
/// primitive, no name and no node transform. Errors: CRUMPLE_ERROR_FORMAT (damaged, cut short, or not a baked set),
/// CRUMPLE_ERROR_UNSUPPORTED (another format version).
CrumpleResult crumple_example_set_load_baked_memory(CrumpleContext *context, const void *data, size_t size,
                                                    CrumpleBytes bytes, CrumpleExampleSet *out_set);

/// Like crumple_example_set_load_baked_memory(), but reads a file into memory. path is UTF-8. Also returns
/// CRUMPLE_ERROR_IO.
CrumpleResult crumple_example_set_load_baked(CrumpleContext *context, const char *path, CrumpleExampleSet *out_set);

/// Writes an example set as the bytes of a .crumple file, equal on all machines. data has capacity bytes of any
/// alignment; see "Arrays" at the top.
CrumpleResult crumple_example_set_save_baked(CrumpleContext *context, CrumpleExampleSet set, void *data,
                                             size_t capacity, size_t *out_size);

/// Returns a def without streams. Set those that you need.
CrumpleMeshCopyDef crumple_mesh_copy_def_default(void);

/// Returns facts about a set.
CrumpleResult crumple_example_set_get_info(CrumpleContext *context, CrumpleExampleSet set,
                                           CrumpleExampleSetInfo *out_info);

/// Returns facts about the example with an index below example_count.
CrumpleResult crumple_example_set_get_example(CrumpleContext *context, CrumpleExampleSet set, uint32_t example,
                                              CrumpleExampleInfo *out_info);

/// Returns the vertices and triangles of the part with an index below primitive_count.
CrumpleResult crumple_example_set_get_primitive(CrumpleContext *context, CrumpleExampleSet set, uint32_t primitive,
                                                CrumplePrimitive *out_primitive);

/// Returns the number of a part by the name of its node, or of the node's mesh if the node has none: a lod, 1 and up. The
/// first of that name. Only for sets that were loaded with join_nodes; baked sets keep the numbers, not the names.
/// CRUMPLE_ERROR_INVALID_ARGUMENT: no such part.
CrumpleResult crumple_example_set_find_part(CrumpleContext *context, CrumpleExampleSet set, const char *name,
                                            uint32_t *out_lod);

/// Copies the base mesh or a level of detail into your memory, for your vertex and index buffers. If the set was built
/// without normals, they are the computed ones. CRUMPLE_ERROR_MESH: the mesh lacks the requested normals or tangents.
CrumpleResult crumple_example_set_copy_mesh(CrumpleContext *context, CrumpleExampleSet set,
                                            const CrumpleMeshCopyDef *def);

/// Finds the vertex of the base mesh nearest to a point in the mesh's space, m. The lowest index wins a tie. Either
/// output may be null. out_distance is in m.
CrumpleResult crumple_example_set_find_nearest_vertex(CrumpleContext *context, CrumpleExampleSet set, CrumpleVec3 point,
                                                      uint32_t *out_vertex, float *out_distance);

/// Returns the default options. Set the example set.
CrumpleInstanceDef crumple_instance_def_default(void);

/// Creates an undamaged instance: a few hundred bytes, plus 8 bytes per 128 vertices.
CrumpleResult crumple_instance_create(CrumpleContext *context, const CrumpleInstanceDef *def,
                                      CrumpleInstance *out_instance);

/// Destroys an instance and unregisters its buffers. Your memory keeps its contents.
CrumpleResult crumple_instance_destroy(CrumpleContext *context, CrumpleInstance instance);

/// Returns the state of an instance.
CrumpleResult crumple_instance_get_info(CrumpleContext *context, CrumpleInstance instance,
                                        CrumpleInstanceInfo *out_info);

/// Sets the transform of an instance: local_to_world points to 16 floats, column-major (element 4 * column + row, as in
/// glTF and Vulkan), translation in elements 12 to 14, m, last row 0 0 0 1. It may scale and shear, but must be
/// invertible. Hits in CRUMPLE_SPACE_WORLD use the inverse of the transform at the time of the call: in full for
/// points, without translation for impulses and displacements. Deformed vertices are in the mesh's space. May be called
/// from any thread at any time.
CrumpleResult crumple_instance_set_transform(CrumpleContext *context, CrumpleInstance instance,
                                             const float *local_to_world);

/// Limits how far a vertex moves, m. The next deform or recording applies it. 0: the set's limit. Marks are kept, and
/// their full depth returns when the limit is raised.
CrumpleResult crumple_instance_set_depth_limit(CrumpleContext *context, CrumpleInstance instance, float depth_limit);

/// Sets the time, s, for instances with a grow_time. Call it once a frame before deforming. What is shown of a dent that
/// appears, changes or is repaired goes evenly to where its mark puts it, from the time that was set when the change was
/// read (see "Reads" at the top). Marks change at once; vertices and attached points follow. Damage that is set, loaded,
/// copied or reset is shown at once. Costs nothing if no dent grows.
CrumpleResult crumple_context_set_time(CrumpleContext *context, double time);

/// Allows an error of up to tolerance in vertex positions, m, in the mesh's space. Deforming then skips small
/// displacements and is cheaper. 0: none are skipped. Seams stay closed. The value is rounded down to a power of two in
/// metres, so that you may set it from crumple_pixel_tolerance() every frame. When the rounded value changes, the next
/// deform writes every dented block. Classic rules ignore it.
CrumpleResult crumple_instance_set_tolerance(CrumpleContext *context, CrumpleInstance instance, float tolerance);

/// Chooses how finely to show an instance where errors of so many pixels do not matter, such as 0.5. out_lod receives
/// the level of detail to show: the coarsest whose edges cover at most 16 times as many pixels in the mean. For a set
/// without levels of detail it sets the tolerance to as many pixels; with levels, a tolerance saves nothing more, and is
/// set to 0. distance, m, in the mesh's space: from the camera to the nearest point of the instance. fov_y, radians: the
/// vertical field of view. viewport_height: pixels. Cheap; call it every frame. out_lod may be null. Not for sets whose
/// further meshes are parts of the body.
CrumpleResult crumple_instance_set_view(CrumpleContext *context, CrumpleInstance instance, float pixels, float distance,
                                        float fov_y, float viewport_height, uint32_t *out_lod);

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
/// while they grow, and tolerance leaves out nothing, so all are equal on all machines. Takes about as long as a deform of
/// the whole mesh. Any output may be null.
CrumpleResult crumple_instance_measure_part(CrumpleContext *context, CrumpleInstance instance, uint32_t lod,
                                            float *out_deepest, float *out_mean, float *out_energy);

/// Returns the length, m, that covers a number of pixels at a distance, m, for a camera with this vertical field of
/// view, radians, and viewport height, pixels. Use it as the tolerance of an instance whose nearest vertex is at that
/// distance. Returns 0 for invalid arguments: negative or NaN, a field of view of 0 or at least pi, a height of 0.
float crumple_pixel_tolerance(float pixels, float distance, float fov_y, float viewport_height);

/// Returns a zero impulse in the mesh's space. Set point and impulse, and what else is known.
CrumpleImpulseDef crumple_impulse_def_default(void);

/// Returns a zero displacement in the mesh's space. Set point and displacement.
CrumpleDisplacementDef crumple_displacement_def_default(void);

/// Submits a hit. The call selects the examples. The next read of the damage applies the mark (see "Reads" at the top).
/// A hit that is too weak, or that no example fits, is not an error; see out_result->status. out_result may be null.
/// With a contact_id, it describes this hit alone. May be called from any thread at any time, except while the instance
/// or context is being destroyed. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (a negative duration, mass or radius; no
/// duration, or no mass in def and set, where they are needed), CRUMPLE_ERROR_CONTACT_TOO_FAR, CRUMPLE_ERROR_WRONG_RULE
/// (a contact_id with a classic rule).
CrumpleResult crumple_instance_submit_impulse(CrumpleContext *context, CrumpleInstance instance,
                                              const CrumpleImpulseDef *def, CrumpleHitResult *out_result);

/// Like crumple_instance_submit_impulse(), but for a displacement.
CrumpleResult crumple_instance_submit_displacement(CrumpleContext *context, CrumpleInstance instance,
                                                   const CrumpleDisplacementDef *def, CrumpleHitResult *out_result);

/// Submits count hits, each to the instance at the same index. Either all are submitted, or none and the message names
/// the first wrong one. out_results is null, or has room for count results. Otherwise like
/// crumple_instance_submit_impulse().
CrumpleResult crumple_context_submit_impulses(CrumpleContext *context, const CrumpleInstance *instances,
                                              const CrumpleImpulseDef *defs, uint32_t count,
                                              CrumpleHitResult *out_results);

/// Like crumple_context_submit_impulses(), but for displacements.
CrumpleResult crumple_context_submit_displacements(CrumpleContext *context, const CrumpleInstance *instances,
                                                   const CrumpleDisplacementDef *defs, uint32_t count,
                                                   CrumpleHitResult *out_results);

/// Computes the result of crumple_instance_submit_impulse() without leaving a mark. out_result is required. May be
/// called from any thread at any time.
CrumpleResult crumple_instance_preview_impulse(CrumpleContext *context, CrumpleInstance instance,
                                               const CrumpleImpulseDef *def, CrumpleHitResult *out_result);

/// Like crumple_instance_preview_impulse(), but for a displacement.
CrumpleResult crumple_instance_preview_displacement(CrumpleContext *context, CrumpleInstance instance,
                                                    const CrumpleDisplacementDef *def, CrumpleHitResult *out_result);

/// Ends a contact. Its dent stays; later hits with the same id begin a new contact. Use contacts if your physics engine
/// reports one contact as many small impulses. Give each of these hits the same contact_id, any number but 0, and end
/// the contact when the bodies separate. Together they make the dent of the whole impulse, at any frame rate: their
/// impulses or displacements add up, and the place is the mean of their points, weighted by these. Yield thresholds and
/// depth limit apply to the sum. A contact has one mark, which is replaced as hits arrive.
///
/// Ending an unknown id is not an error. Contacts also end when the instance's damage is set, loaded, copied to it,
/// repaired or reset. At most 256 are open per instance; above that, the one hit longest ago ends. May be called from
/// any thread at any time. CRUMPLE_ERROR_WRONG_RULE: a classic rule.
CrumpleResult crumple_instance_end_contact(CrumpleContext *context, CrumpleInstance instance, uint64_t contact_id);

/// Returns the result of a contact, all its hits taken as one. The contact is open, or among the 256 of the instance
/// that ended last. The status is CRUMPLE_HIT_STATUS_BELOW_YIELD if there is no such contact or the sum is too weak.
/// CRUMPLE_ERROR_WRONG_RULE: a classic rule.
CrumpleResult crumple_instance_get_contact(CrumpleContext *context, CrumpleInstance instance, uint64_t contact_id,
                                           CrumpleHitResult *out_result);

/// Returns the default options.
CrumpleContactOptionsDef crumple_contact_options_def_default(void);

/// Returns a point of which nothing is known. Set pair, bodies, point and normal, and what else is known.
CrumpleContactPointDef crumple_contact_point_def_default(void);

/// Changes the options of the context's contacts. Touches that last go on with them. Any thread may call it at any time.
CrumpleResult crumple_context_set_contact_options(CrumpleContext *context, const CrumpleContactOptionsDef *options);

/// Takes contact points of the current step of the physics: all, or none if one is wrong. Report every point of every pair,
/// also of bodies that rest or slide, and call crumple_context_step_contacts() after the step: all points of one place make
/// one dent, at any rate of steps, and what rests, rolls, slides or jitters makes none. Two instances share the energy of
/// a blow by how they give way. May be called from any thread at any time, except while an instance of the points or the
/// context is being destroyed. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (names the point and its part; also more than max_points
/// since the last step), CRUMPLE_ERROR_WRONG_RULE (an instance with a classic rule).
CrumpleResult crumple_context_report_contacts(CrumpleContext *context, const CrumpleContactPointDef *points,
                                              uint32_t count);

/// Ends a step of the physics that lasted so many seconds: turns the points reported since the last call into hits. Call it
/// once after each step, also if nothing touched. The next read of the damage applies the hits. Their contact ids are 2^63
/// and above; give other ids to your own hits. out_report may be null. Any thread may call it at any time.
CrumpleResult crumple_context_step_contacts(CrumpleContext *context, float seconds, CrumpleContactReport *out_report);

/// Returns the hits that the last crumple_context_step_contacts() brought to instances, in no particular order. Ask after each
/// step; there are at most as many as its report's hits. hits has room for capacity hits; see "Arrays" at the top. Any thread may
/// call it at any time.
CrumpleResult crumple_context_get_contact_hits(CrumpleContext *context, CrumpleContactHit *hits, uint32_t capacity,
                                               uint32_t *out_count);

/// Returns the sums of all steps' reports; open is that of the last step. Any thread may call it at any time.
CrumpleResult crumple_context_get_contact_totals(CrumpleContext *context, CrumpleContactReport *out_report);

/// Ends all touches and forgets the points that wait, as after loading a saved game. Dents stay. Any thread may call it at
/// any time.
CrumpleResult crumple_context_clear_contacts(CrumpleContext *context);

/// Copies an instance's marks to an array of capacity marks; see "Arrays" at the top. The marks are sorted, so that the
/// order of hits does not matter. CRUMPLE_ERROR_WRONG_RULE: classic rules have no marks.
CrumpleResult crumple_instance_get_marks(CrumpleContext *context, CrumpleInstance instance, CrumpleMark *marks,
                                         uint32_t capacity, uint32_t *out_count);

/// Replaces an instance's marks with count marks of the same set. Discards pending hits and ends contacts. Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (a mark that the set cannot have), CRUMPLE_ERROR_WRONG_RULE.
CrumpleResult crumple_instance_set_marks(CrumpleContext *context, CrumpleInstance instance, const CrumpleMark *marks,
                                         uint32_t count);

/// Saves an instance's damage as bytes that are equal on all machines. They include a version and the set's
/// fingerprint. data has capacity bytes of any alignment; see "Arrays" at the top.
CrumpleResult crumple_instance_save_damage(CrumpleContext *context, CrumpleInstance instance, void *data,
                                           size_t capacity, size_t *out_size);

/// Replaces an instance's damage with saved damage: size bytes at data, of any alignment. Discards pending hits and ends
/// contacts. Errors: CRUMPLE_ERROR_DAMAGE_MISMATCH (another set, version or rule, or cut short),
/// CRUMPLE_ERROR_INVALID_ARGUMENT (a mark that the set cannot have).
CrumpleResult crumple_instance_load_damage(CrumpleContext *context, CrumpleInstance instance, const void *data,
                                           size_t size);

/// Saves the damage of count instances, or of all instances of the context by increasing index if instances is null and
/// count 0, as one piece of bytes. data has capacity bytes of any alignment; see "Arrays" at the top.
CrumpleResult crumple_context_save_damage(CrumpleContext *context, const CrumpleInstance *instances, uint32_t count,
                                          void *data, size_t capacity, size_t *out_size);

/// Replaces the damage of count instances, or of all, with that of crumple_context_save_damage(), which was given
/// instances of the same sets in the same order. Otherwise like crumple_instance_load_damage() for each of them; after
/// an error no instance has changed. CRUMPLE_ERROR_DAMAGE_MISMATCH: also another number of instances.
CrumpleResult crumple_context_load_damage(CrumpleContext *context, const CrumpleInstance *instances, uint32_t count,
                                          const void *data, size_t size);

/// Maps damage that was saved with old_set to set, another revision of it: a changed mesh, other examples. Each mark goes
/// to the nearest vertex, at most max_distance away, m (0 to infinity). An example is the one of the same name; of several
/// with one name, the n-th, if both sets have as many. A mark that does not fit is left out as a whole. data is what
/// crumple_instance_save_damage() or crumple_context_save_damage() gave; in the latter, damage of other sets stays as it
/// is. mapped has capacity bytes; see "Arrays" at the top. out_mapping may be null. Errors: CRUMPLE_ERROR_DAMAGE_MISMATCH
/// (not old_set's, or another version, a classic rule, or cut short), CRUMPLE_ERROR_INVALID_ARGUMENT (a mark
/// that old_set cannot have, or max_distance).
CrumpleResult crumple_example_set_map_damage(CrumpleContext *context, CrumpleExampleSet set, CrumpleExampleSet old_set,
                                             const void *data, size_t size, float max_distance, void *mapped,
                                             size_t capacity, size_t *out_size, CrumpleDamageMapping *out_mapping);

/// Repairs an instance. Every dent keeps this share of its depth: 0 (as new) to 1 (unchanged). Ends contacts.
CrumpleResult crumple_instance_repair_damage(CrumpleContext *context, CrumpleInstance instance, float keep);

/// Repairs an instance around a point, as with a hammer. A dent whose contact is at the point keeps this share of its
/// depth, 0 to 1. The share rises smoothly to 1 for contacts at radius. point and radius are in the mesh's space, m. A
/// dent is repaired as a whole, also where it reaches beyond the radius. Ends contacts. CRUMPLE_ERROR_WRONG_RULE: a
/// classic rule.
CrumpleResult crumple_instance_repair_around(CrumpleContext *context, CrumpleInstance instance, CrumpleVec3 point,
                                             float radius, float keep);

/// Removes all damage of an instance. Discards pending hits and ends contacts.
CrumpleResult crumple_instance_reset_damage(CrumpleContext *context, CrumpleInstance instance);

/// Replaces an instance's damage with that of source, which needs an equal set and the same kind of rule. Discards the
/// instance's pending hits and ends its contacts. Copying an instance to itself does nothing.
/// CRUMPLE_ERROR_DAMAGE_MISMATCH: another set or rule.
CrumpleResult crumple_instance_copy_damage(CrumpleContext *context, CrumpleInstance instance, CrumpleInstance source);

/// Returns a def without streams. Set them.
CrumpleHostBufferDef crumple_host_buffer_def_default(void);

/// Registers your memory for an instance's deformed vertices. The first deform writes every vertex. An instance may
/// have several buffers, such as a ring; each is updated separately. Only crumple_context_deform() touches the memory.
/// It must exist until the buffer is unregistered or gets other memory, or its instance or context is destroyed. Memory
/// of different buffers must not overlap; debug builds of the library check this. While an instance with eight dents or
/// more is being hit, the library holds 24 bytes a vertex for each of its buffers. Errors: CRUMPLE_ERROR_MESH (normals or
/// tangents that the mesh lacks), CRUMPLE_ERROR_WRONG_RULE (lod above 0 with a classic rule).
CrumpleResult crumple_buffer_register_host(CrumpleContext *context, CrumpleInstance instance,
                                           const CrumpleHostBufferDef *def, CrumpleBuffer *out_buffer);

/// Unregisters a buffer. You may then free its memory, or its VkBuffer once the frames that wrote it are complete.
CrumpleResult crumple_buffer_unregister(CrumpleContext *context, CrumpleBuffer buffer);

/// Declares a buffer's contents lost or overwritten. The next deform or recording writes every vertex.
CrumpleResult crumple_buffer_invalidate(CrumpleContext *context, CrumpleBuffer buffer);

/// Gives a host buffer other memory, perhaps for another level of detail, and invalidates it. After an error the buffer
/// keeps its memory. Errors: those of crumple_buffer_register_host(), and CRUMPLE_ERROR_INVALID_ARGUMENT (not a
/// host buffer).
CrumpleResult crumple_buffer_set_memory(CrumpleContext *context, CrumpleBuffer buffer, const CrumpleHostBufferDef *def);

/// Limits how many vertices one crumple_context_deform(), crumple_vulkan_record(), ..._submit() or crumple_graph_plan()
/// writes, for frames with more hits than time. 0, as at first: no limit. A buffer is written whole or not at all. The
/// buffers whose waiting would be seen most come first, by the vertices to write, the calls that they have waited, and
/// how near they are as their tolerances tell; see crumple_instance_set_view(). The others follow in later calls, with
/// the same vertices. A buffer that does not show its instance yet never waits, and every call writes at least one
/// buffer.
CrumpleResult crumple_context_set_vertex_budget(CrumpleContext *context, uint64_t vertices);

/// Writes the deformed vertices of count host buffers, or of all host buffers of the context if buffers is null and
/// count 0. It writes only what changed since the last write of each buffer, in parallel over all of them, and is cheap
/// without changes. With null and 0 it also applies the pending hits of instances without a buffer, so that damage does
/// not depend on which bodies are visible. Nobody else may read or write the memory during the call. out_report may be
/// null. CRUMPLE_ERROR_INVALID_ARGUMENT (no vertex was written): a buffer twice, not a host buffer, or overlapping
/// memory in debug builds.
CrumpleResult crumple_context_deform(CrumpleContext *context, const CrumpleBuffer *buffers, uint32_t count,
                                     CrumpleDeformReport *out_report);

/// Returns the buffers that the last crumple_context_deform() and the last recording or submit wrote to, by increasing
/// index, so that you need not ask each. buffers has room for capacity ids; see "Arrays" at the top.
CrumpleResult crumple_context_get_changed_buffers(CrumpleContext *context, CrumpleBuffer *buffers, uint32_t capacity,
                                                  uint32_t *out_count);

/// Returns the vertices written by the last deform or recording that included the buffer, by id or with null and 0.
/// They are increasing ranges that do not overlap. Also returns the bounds of all its vertices, m, which may be too
/// large for a buffer on a device. Use them for uploads, refits and culling. ranges has room for capacity ranges; see
/// "Arrays" at the top. out_bounds may be null.
CrumpleResult crumple_buffer_get_changes(CrumpleContext *context, CrumpleBuffer buffer, CrumpleRange *ranges,
                                         uint32_t capacity, uint32_t *out_count, CrumpleAabb *out_bounds);

/// Returns the triangles with a vertex that crumple_buffer_get_changes() returns, in the order of the indices of the
/// buffer's mesh, as increasing ranges that do not overlap. out_bounds receives a box around those vertices as they were
/// before and as they are now, m, for the partial refit of a collider; zeros without changes. It may be null. ranges has
/// room for capacity ranges; see "Arrays" at the top. The time is linear in the triangles. Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (not a host buffer), CRUMPLE_ERROR_MESH (a mesh without indices).
CrumpleResult crumple_buffer_get_changed_triangles(CrumpleContext *context, CrumpleBuffer buffer, CrumpleRange *ranges,
                                                   uint32_t capacity, uint32_t *out_count, CrumpleAabb *out_bounds);

/// Returns a def without handles. Set them and the queue family.
CrumpleVulkanAttachDef crumple_vulkan_attach_def_default(void);

/// Returns a def for a vertex buffer without its handle. Set buffer, buffer_size, usage, size and streams.
CrumpleVulkanBufferDef crumple_vulkan_buffer_def_default(void);

/// Attaches your Vulkan device, one per context. It takes some tenths of a millisecond. The handles must be valid,
/// belong together, and live until crumple_vulkan_detach() or crumple_context_destroy(). Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (a device is already attached, a queue family that does not exist or lacks compute, a
/// bad workgroup_size), CRUMPLE_ERROR_UNSUPPORTED (below Vulkan 1.1, a loader that lacks a function, or a build without
/// CRUMPLE_FEATURE_VULKAN).
CrumpleResult crumple_vulkan_attach(CrumpleContext *context, const CrumpleVulkanAttachDef *def);

/// Detaches the Vulkan device. Unregisters all Vulkan buffers and destroys Crumple's objects on the device. Damage
/// stays. After CRUMPLE_ERROR_DEVICE_LOST, call crumple_vulkan_complete_frames() with UINT64_MAX, then this, then
/// vkDestroyDevice. Then attach the new device and register the buffers again. CRUMPLE_ERROR_FRAMES_IN_FLIGHT: nothing
/// changed.
CrumpleResult crumple_vulkan_detach(CrumpleContext *context);

/// Returns pipeline cache data for the next run's crumple_vulkan_attach(). data has capacity bytes of any alignment;
/// see "Arrays" at the top. The size may grow until you have registered every kind of buffer.
CrumpleResult crumple_vulkan_get_pipeline_cache(CrumpleContext *context, void *data, size_t capacity, size_t *out_size);

/// Registers a range of a VkBuffer for an instance's deformed vertices. The first recording writes every vertex. An
/// instance may have several ranges, such as a ring. The first range of a mesh copies the mesh and its examples to a
/// staging buffer, and the next recording copies them to the device; all instances and ranges share them. The VkBuffer
/// must exist until its last range is unregistered and the frames that wrote it are complete. Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (no device, stages of 0, an unsupported format, overlapping attributes, a scale not
/// above 0, a VkBuffer already registered with other values), CRUMPLE_ERROR_WRONG_RULE (lod above 0 with a classic
/// rule), CRUMPLE_ERROR_UNSUPPORTED (normals or tangents that the mesh lacks; more bytes than the device can bind).
CrumpleResult crumple_buffer_register_vulkan(CrumpleContext *context, CrumpleInstance instance,
                                             const CrumpleVulkanBufferDef *def, CrumpleBuffer *out_buffer);

/// Records commands that write the deformed vertices of count Vulkan buffers, or of all Vulkan buffers of the context
/// if buffers is null and count 0. For the blocks that changed it records a copy of a few bytes per block, a barrier,
/// one dispatch per VkBuffer and a barrier. It submits nothing, waits for nothing, and does not allocate in steady
/// state. You may change damage right after the call.
///
/// command_buffer is a VkCommandBuffer in the recording state, outside a render pass, of the attached queue family,
/// whose pool no other thread uses. Submit it once, and submit recordings in the order in which they were recorded.
/// frame is your frame number: it starts at 1 and never decreases; recordings may share one. out_report may be null.
///
/// The commands change only the compute pipeline, compute descriptor sets 0 to 2 and the first 28 bytes of push
/// constants for compute. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (no device of crumple_vulkan_attach(), a buffer twice,
/// a host buffer, a frame that is complete or below the last), CRUMPLE_ERROR_UNSUPPORTED (more work than the device can
/// bind). Nothing was recorded.
CrumpleResult crumple_vulkan_record(CrumpleContext *context, void *command_buffer, uint64_t frame,
                                    const CrumpleBuffer *buffers, uint32_t count, CrumpleRecordReport *out_report);

/// Declares that the device has completed frame and all earlier ones, as a fence or timeline semaphore tells you. Their
/// resources are reused or freed. Call it once a frame; it is cheap. A number above the last recorded frame counts as
/// that frame.
CrumpleResult crumple_vulkan_complete_frames(CrumpleContext *context, uint64_t frame);

/// Declares that recordings of frame and later frames will not be submitted. The next recording writes every vertex of
/// their buffers.
CrumpleResult crumple_vulkan_discard_frames(CrumpleContext *context, uint64_t frame);

/// Returns a def for any physical device. Set the loader and the UUID.
CrumpleVulkanOpenDef crumple_vulkan_open_def_default(void);

/// Returns a def without memory. Set handle, sizes, memory type and usage.
CrumpleVulkanImportDef crumple_vulkan_import_def_default(void);

/// Creates a Vulkan device of Crumple's own, for engines that can share memory but cannot hand out a command buffer.
/// Takes milliseconds to tenths of a second. Use it instead of crumple_vulkan_attach(): import buffers, register them,
/// and write them with crumple_vulkan_submit(). crumple_vulkan_detach() and crumple_context_destroy() wait for the
/// device and destroy it. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (a device is already attached, a bad workgroup_size),
/// CRUMPLE_ERROR_UNSUPPORTED (no such device, one that cannot import memory, or a build without
/// CRUMPLE_FEATURE_VULKAN).
CrumpleResult crumple_vulkan_open(CrumpleContext *context, const CrumpleVulkanOpenDef *def);

/// Imports a buffer of your device into Crumple's device. Use out_buffer as the buffer field of CrumpleVulkanBufferDef;
/// its buffer_size, usage, queue_family, stages and accesses are then ignored. Before each submit, release the VkBuffer
/// to VK_QUEUE_FAMILY_EXTERNAL on your queue. Acquire it afterwards. The memory must exist until
/// crumple_vulkan_unimport_buffer(), crumple_vulkan_detach() or crumple_context_destroy(). Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (no device of crumple_vulkan_open(), a bad handle, an unsuitable memory type or
/// usage), CRUMPLE_ERROR_UNSUPPORTED (a handle type of another system, or a buffer that the device cannot import).
CrumpleResult crumple_vulkan_import_buffer(CrumpleContext *context, const CrumpleVulkanImportDef *def,
                                           uint64_t *out_buffer);

/// Releases an imported buffer once the device is done with it. CRUMPLE_ERROR_INVALID_ARGUMENT: it still has ranges.
CrumpleResult crumple_vulkan_unimport_buffer(CrumpleContext *context, uint64_t buffer);

/// Imports a binary semaphore of your device, exported with this handle type. Pass out_semaphore to
/// crumple_vulkan_submit(). It lives until crumple_vulkan_detach() or crumple_context_destroy(). Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (no device of crumple_vulkan_open(), a bad handle), CRUMPLE_ERROR_UNSUPPORTED (a
/// driver without external semaphores; use fences and crumple_vulkan_wait_frame()).
CrumpleResult crumple_vulkan_import_semaphore(CrumpleContext *context, CrumpleHandleType handle_type, int64_t handle,
                                              uint64_t *out_semaphore);

/// Like crumple_vulkan_record(), but submits the work to Crumple's own device. The device first waits for the
/// wait_count semaphores at waits, and last signals the signal_count semaphores at signals, even without changes. The
/// call itself does not wait. out_frame receives the frame number for crumple_vulkan_wait_frame(). out_frame and
/// out_report may be null. After an error nothing was submitted.
CrumpleResult crumple_vulkan_submit(CrumpleContext *context, const CrumpleBuffer *buffers, uint32_t count,
                                    const uint64_t *waits, uint32_t wait_count, const uint64_t *signals,
                                    uint32_t signal_count, uint64_t *out_frame, CrumpleRecordReport *out_report);

/// Waits until Crumple's own device has completed a frame and all earlier ones, at most timeout nanoseconds
/// (UINT64_MAX: no limit). out_done receives whether the frame is complete. The context is in use while the call waits.
/// CRUMPLE_ERROR_INVALID_ARGUMENT: the frame was not submitted.
CrumpleResult crumple_vulkan_wait_frame(CrumpleContext *context, uint64_t frame, uint64_t timeout, bool *out_done);

/// Returns a compute shader for a render graph that takes SPIR-V, such as Godot's RenderingDevice. It is SPIR-V 1.3 with
/// the entry point "main". Make a pipeline of it when a dispatch first names its number. data has capacity bytes of any
/// alignment; see "Arrays" at the top.
///
/// All kernels have 32 bytes of push constants and three storage buffers: a storage (set 0, binding 0, read), the work
/// (set 0, binding 1, read) and your vertex buffer from its first byte on (set 1, binding 0, read and written). Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (a kernel that no dispatch names), CRUMPLE_ERROR_UNSUPPORTED (a build without
/// CRUMPLE_FEATURE_VULKAN).
CrumpleResult crumple_graph_get_kernel(uint32_t kernel, void *data, size_t capacity, size_t *out_size);

/// Registers a range of a vertex buffer of your render graph, like crumple_buffer_register_vulkan() but without a Vulkan
/// device. def->buffer is any number of yours, which dispatches name. usage, queue_family, stages and accesses are
/// ignored. The first range of a mesh adds uploads to the next plan. Errors: those of crumple_buffer_register_vulkan(),
/// and CRUMPLE_ERROR_WRONG_RULE (a classic rule).
CrumpleResult crumple_buffer_register_graph(CrumpleContext *context, CrumpleInstance instance,
                                            const CrumpleVulkanBufferDef *def, CrumpleBuffer *out_buffer);

/// Plans the passes that write the deformed vertices of count buffers of crumple_buffer_register_graph(), or of all of
/// them if buffers is null and count 0: for the blocks that changed, one dispatch per vertex buffer. Call it once a
/// frame, do the uploads, bind and dispatch. If you drop the dispatches, call crumple_buffer_invalidate() for their
/// buffers. out_report may be null. CRUMPLE_ERROR_INVALID_ARGUMENT: a buffer twice, or another kind of buffer.
CrumpleResult crumple_graph_plan(CrumpleContext *context, const CrumpleBuffer *buffers, uint32_t count,
                                 CrumpleGraphPlan *out_plan, CrumpleRecordReport *out_report);

/// Binds a point in the mesh's space, m, to the nearest surface. The point keeps its distance from the surface and
/// rotates with it. CRUMPLE_ERROR_INVALID_ARGUMENT: the point is further away than 1e9 m.
CrumpleResult crumple_example_set_attach_point(CrumpleContext *context, CrumpleExampleSet set, CrumpleVec3 point,
                                               CrumpleAttachment *out_attachment);

/// Returns the position of an attached point on the dented instance, pending hits included. It needs no buffer. Errors:
/// CRUMPLE_ERROR_INDEX_OUT_OF_RANGE or CRUMPLE_ERROR_INVALID_ARGUMENT (an attachment of another set, or one not from
/// crumple_example_set_attach_point()).
CrumpleResult crumple_instance_get_attached_frame(CrumpleContext *context, CrumpleInstance instance,
                                                  const CrumpleAttachment *attachment, CrumpleFrame *out_frame);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CRUMPLE_H */
