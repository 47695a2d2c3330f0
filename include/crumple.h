// Crumple dents meshes.
//
// You give it a base mesh and a few examples (the same mesh after a collision, made by an artist or a solver), report
// impulses as your physics engine finds them, and it writes the deformed vertices into your own vertex buffers. All
// functions and types are described where they are declared; examples-c holds whole programs.
//
//
// The way through, in the order in which you meet it
//
//   1. Context          crumple_context_def_default, crumple_context_create
//                       threads, log, your own job system; crumple_allocator_set before that, if at all
//   2. Example sets     crumple_example_set_create (arrays), crumple_example_set_load_gltf, ..._load_gltf_memory, ..._load_obj
//                       while loading; one a mesh, shared by all its instances; made ready once, it is saved with
//                       crumple_example_set_save_baked (or "crumple bake") and loads at once from then on:
//                       crumple_example_set_load_baked_memory, crumple_example_set_load_baked
//   3. Looking inside   crumple_example_set_get_info, crumple_example_set_get_example, crumple_example_set_get_primitive,
//                       crumple_example_set_copy_mesh, crumple_example_set_find_nearest_vertex
//   4. Instances        crumple_instance_create, crumple_instance_set_transform, ..._depth_limit
//                       one a body in the scene; a few hundred bytes each
//   5. Hits             crumple_instance_submit_impulse, crumple_instance_submit_displacement, crumple_instance_end_contact
//                       from any thread, whenever the physics engine reports a contact
//   6. Damage           crumple_instance_get_marks, crumple_instance_set_marks, crumple_instance_save_damage, crumple_instance_load_damage,
//                       crumple_instance_repair_damage, crumple_instance_reset_damage, crumple_instance_copy_damage
//                       a short list of marks of 32 bytes: save it, send it over the network
//   7. Buffers          crumple_buffer_register_host, crumple_buffer_set_memory, crumple_buffer_invalidate
//                       your vertex memory, any strides
//   8. Deformation      crumple_context_deform once a frame, crumple_buffer_get_changes for what to upload and the new bounds
//   9. On the GPU       instead of 7 and 8: crumple_vulkan_attach, crumple_buffer_register_vulkan, and once a frame
//                       crumple_vulkan_record into your own VkCommandBuffer and crumple_vulkan_complete_frames; or, with memory
//                       shared instead of a command buffer: crumple_vulkan_open, ..._import_buffer, ..._submit
//  10. Attached points  crumple_example_set_attach_point, crumple_instance_get_attached_frame
//                       lamps, decals and collision vertices that follow the dents
//  11. Recordings       crumple_recording_begin, crumple_recording_end
//                       the calls of a context in a file, which "crumple replay" makes again: how a bug becomes a test
//
//
// Results. Every call that can fail returns a CrumpleResult and writes its outputs only when that is CRUMPLE_OK. The
// text of crumple_last_error() names what was wrong and what would be right. After an error nothing has changed and
// everything stays usable. No call aborts, prints, throws or leaves a signal; see "Memory" for the one exception.
// Every call may return CRUMPLE_ERROR_INTERNAL, a defect of the library.
//
// Ownership. What Crumple creates, it owns, and you hold an id of it: a small struct by value, zero is null. An id
// ends with its destroy or unregister call and is an error from then on, never a crash. Destroying
// an instance unregisters its buffers; an example set lives on for the instances that use it; destroying the context
// destroys everything in it. What you pass in, you own: defs, strings and arrays are read during the call and may be
// freed after it. Four things must live longer: the memory of registered buffers, what the callbacks of a context need,
// bytes that a set was told to keep, and an attached Vulkan device (or memory that was imported).
//
// Defs. Structs that end in Def come from their crumple_..._def_default function, which sets struct_size and the defaults;
// fill in what you need. By struct_size the library knows the version that you compiled against: of an earlier one with
// the same SONAME, what your def lacks is as the default. A size that no version had is an error.
//
// Threads. Calls are externally synchronised per context: two threads must not be inside the same context at once,
// and callbacks must not call back into it. One that does gets CRUMPLE_ERROR_CONCURRENT_USE, in every build. Excepted
// are crumple_instance_submit_impulse(), crumple_instance_submit_displacement() and crumple_instance_end_contact(), which any number of threads
// may call at any time, also while another thread deforms, and the functions that take no context. Different contexts
// know nothing of each other. The result never depends on the number of threads, nor on the order of the hits between
// two reads of the damage (with CRUMPLE_RULE_MARKS it does not depend on those reads either, until marks merge because
// there are more than mark_capacity; contacts in parts up to the rounding of a sum).
//
// Units. Metres, seconds, kilograms; impulses in newton seconds. Any handedness, any axis up. Each number says its
// unit. NaN and infinities are errors everywhere. Vertices are 32-bit floats, indices count from 0, enums are 32 bits
// wide (do not compile with -fshort-enums).
//
// Memory. Running out of it while your arrays are copied, or while room for what you create is made, is
// CRUMPLE_ERROR_OUT_OF_MEMORY. Working memory beyond that is not guarded: where the system, or your allocator, has
// none left for it, the process ends, as most programs do.
//
// Do not fork() a process with a live context and use it in the child.
//
// This file is generated from the library's source by `cargo xtask header`; do not edit it.

#ifndef CRUMPLE_H
#define CRUMPLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Major version of this header. Programs built against another major version do not fit.
#define CRUMPLE_VERSION_MAJOR 0

/// Minor version of this header. Before 1.0, programs built against another minor version do not fit.
#define CRUMPLE_VERSION_MINOR 1

/// Patch version of this header.
#define CRUMPLE_VERSION_PATCH 0

/// The three as one number, as crumple_version() gives it.
#define CRUMPLE_VERSION (((CRUMPLE_VERSION_MAJOR * 1000000) + (CRUMPLE_VERSION_MINOR * 1000)) + CRUMPLE_VERSION_PATCH)

/// Bit of crumple_features(): glTF 2.0 and GLB files can be loaded.
#define CRUMPLE_FEATURE_GLTF 1

/// Bit of crumple_features(): OBJ files can be loaded.
#define CRUMPLE_FEATURE_OBJ 2

/// Bit of crumple_features(): crumple_allocator_set() works.
#define CRUMPLE_FEATURE_HOST_ALLOCATOR 4

/// Bit of crumple_features(): crumple_vulkan_attach() works.
#define CRUMPLE_FEATURE_VULKAN 8

/// What every fallible call returns. After anything but CRUMPLE_OK no output was written, crumple_last_error() tells
/// what was wrong and what would be right, and everything stays usable.
typedef enum {
    /// The call did what it says.
    CRUMPLE_OK = 0,
    /// A value lies outside its range.
    CRUMPLE_ERROR_INVALID_ARGUMENT = 1,
    /// A number is NaN or infinite.
    CRUMPLE_ERROR_NOT_FINITE = 2,
    /// An index points past the end of what it indexes.
    CRUMPLE_ERROR_INDEX_OUT_OF_RANGE = 3,
    /// The base mesh cannot be used.
    CRUMPLE_ERROR_MESH = 4,
    /// An example does not fit the base mesh, or there is no example.
    CRUMPLE_ERROR_EXAMPLE_MISMATCH = 5,
    /// Memory is smaller than what must be read from it or written to it.
    CRUMPLE_ERROR_BUFFER_TOO_SMALL = 6,
    /// A pointer, an offset or a stride is not a multiple of the alignment it needs.
    CRUMPLE_ERROR_MISALIGNED = 7,
    /// A contact lies further from the body than the instance accepts: often a point in the wrong space.
    CRUMPLE_ERROR_CONTACT_TOO_FAR = 8,
    /// Valid input that this library, or this build of it, does not read.
    CRUMPLE_ERROR_UNSUPPORTED = 9,
    /// A file or saved bytes are malformed.
    CRUMPLE_ERROR_FORMAT = 10,
    /// The operating system refused to read or write a file.
    CRUMPLE_ERROR_IO = 11,
    /// Damage belongs to another example set or to another version.
    CRUMPLE_ERROR_DAMAGE_MISMATCH = 12,
    /// Memory ran out. Only memory whose size your counts decide is reported so; see "Memory" at the top of the
    /// header.
    CRUMPLE_ERROR_OUT_OF_MEMORY = 13,
    /// The call does not fit the instance's rule.
    CRUMPLE_ERROR_WRONG_RULE = 14,
    /// A call into the graphics driver failed.
    CRUMPLE_ERROR_VULKAN = 15,
    /// The graphics device is lost. Damage is not.
    CRUMPLE_ERROR_DEVICE_LOST = 16,
    /// A pointer is null that must not be.
    CRUMPLE_ERROR_NULL_POINTER = 64,
    /// The struct_size of a def is that of no version: take defs from their crumple_..._def_default function.
    CRUMPLE_ERROR_STRUCT_SIZE = 65,
    /// An id or a context is null, was destroyed, or belongs to another context; the text says which.
    CRUMPLE_ERROR_INVALID_ID = 66,
    /// Two threads were inside the same context at once, or a callback called back into it.
    CRUMPLE_ERROR_CONCURRENT_USE = 67,
    /// A defect of the library; the text is its message. Please report it.
    CRUMPLE_ERROR_INTERNAL = 68,
    /// Frames were recorded that crumple_vulkan_complete_frames() was not told of.
    CRUMPLE_ERROR_FRAMES_IN_FLIGHT = 69,
} CrumpleResult;

/// How much a log message matters.
typedef enum {
    /// What was done.
    CRUMPLE_LOG_LEVEL_INFO = 0,
    /// Something that works but is probably not what was meant.
    CRUMPLE_LOG_LEVEL_WARNING = 1,
} CrumpleLogLevel;

/// How the place where an example was hit is told.
typedef enum {
    /// Not told: its deepest vertex. The default.
    CRUMPLE_CONTACT_KIND_NONE = 0,
    /// A vertex of the base mesh.
    CRUMPLE_CONTACT_KIND_VERTEX = 1,
    /// A point in the mesh's space; its nearest vertex becomes the contact.
    CRUMPLE_CONTACT_KIND_POINT = 2,
} CrumpleContactKind;

/// Whether an example may be carried away from where it was made.
typedef enum {
    /// Anchored for hits close to its own contact that ask for about its own depth, carried for others. The default.
    CRUMPLE_PLACEMENT_AUTOMATIC = 0,
    /// Always where and as the artist made it: creases, frames, bumpers.
    CRUMPLE_PLACEMENT_ANCHORED = 1,
    /// Always carried to where the body was hit: sheet metal.
    CRUMPLE_PLACEMENT_CARRIED = 2,
} CrumplePlacement;

/// The type of triangle indices.
typedef enum {
    /// uint32_t, 4 bytes. The default.
    CRUMPLE_INDEX_TYPE_U32 = 0,
    /// uint16_t, 2 bytes.
    CRUMPLE_INDEX_TYPE_U16 = 1,
} CrumpleIndexType;

/// How the dents of several hits combine at a vertex. The direction is always that of their sum.
typedef enum {
    /// Energies add: depth grows as the root of the number of equal hits, as metal does. The default.
    CRUMPLE_COMBINE_ENERGIES = 0,
    /// Lengths add, up to the depth limit.
    CRUMPLE_COMBINE_SUM = 1,
    /// The deepest dent decides: stamping to a fixed position.
    CRUMPLE_COMBINE_DEEPEST = 2,
} CrumpleCombine;

/// What becomes of an example that moves apart vertices which share a position in the base mesh.
typedef enum {
    /// They stay together: each gets the mean of their displacements. The default.
    CRUMPLE_SEAMS_WELD = 0,
    /// They move apart, as the example says: a tear that the artist made.
    CRUMPLE_SEAMS_KEEP = 1,
} CrumpleSeams;

/// What becomes of the bytes that a set is loaded from.
typedef enum {
    /// They are copied: free them after the call.
    CRUMPLE_BYTES_COPY = 0,
    /// They are kept and used where they lie: a memory map, or an asset that stays loaded. They must stay readable and must
    /// not change until the set was destroyed and all its instances with it, or the context. Where they do not begin at a
    /// multiple of 16 bytes they are copied all the same; do not rely on that.
    CRUMPLE_BYTES_KEEP = 1,
} CrumpleBytes;

/// What hits do to an instance.
typedef enum {
    /// Hits leave marks: bounded, local, the same in any order, without memory per vertex. The default.
    CRUMPLE_RULE_MARKS = 0,
    /// The literature's rule "most displaced", for comparison: depends on the order of hits, needs memory per vertex,
    /// has no marks.
    CRUMPLE_RULE_MOST_DISPLACED = 1,
    /// The literature's rule "blend", with blend_constant.
    CRUMPLE_RULE_BLEND = 2,
} CrumpleRule;

/// How the examples for a hit are chosen.
typedef enum {
    /// CRUMPLE_SELECTION_NEAREST with marks, CRUMPLE_SELECTION_CLASSIC with the literature's rules. The default.
    CRUMPLE_SELECTION_OF_RULE = 0,
    /// The examples that say most of a hit's place, depth and lean, carried or anchored as each says. Marks only.
    CRUMPLE_SELECTION_NEAREST = 1,
    /// The literature's: the one example that moves the contact in the direction most like the target, weight at most
    /// 1.
    CRUMPLE_SELECTION_CLASSIC = 2,
    /// The same without a limit of the weight: diverges above 2. The literature's rules only, for comparison.
    CRUMPLE_SELECTION_CLASSIC_UNCLAMPED = 3,
} CrumpleSelection;

/// The space a hit is given in.
typedef enum {
    /// The mesh's own. The default.
    CRUMPLE_SPACE_LOCAL = 0,
    /// The world's: through the instance's transform.
    CRUMPLE_SPACE_WORLD = 1,
} CrumpleSpace;

/// What became of a hit.
typedef enum {
    /// It leaves a mark (with the literature's rules: a deformation).
    CRUMPLE_HIT_STATUS_MARKED = 0,
    /// It is weaker than the instance's yield threshold, or next to nothing.
    CRUMPLE_HIT_STATUS_BELOW_YIELD = 1,
    /// No example moves the contact in the direction asked for.
    CRUMPLE_HIT_STATUS_NOTHING_REACHES = 2,
} CrumpleHitStatus;

/// How a device hands memory or a semaphore to another one.
typedef enum {
    /// A file descriptor, VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT. It is duplicated: yours stays yours, to be closed when
    /// you like. Linux, Android and their kind.
    CRUMPLE_HANDLE_TYPE_OPAQUE_FD = 0,
    /// A HANDLE, VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_WIN32_BIT. Windows. Untested.
    CRUMPLE_HANDLE_TYPE_OPAQUE_WIN32 = 1,
} CrumpleHandleType;

/// Everything that Crumple knows. Opaque.
typedef struct CrumpleContext CrumpleContext;

/// Gives size bytes aligned to align (a power of two, at least 16), or null. Called from any thread, several at once.
/// Must not call Crumple, throw, or jump out.
typedef void *(*CrumpleAlloc)(size_t size, size_t align, void *user);

/// Takes back what CrumpleAlloc gave, with the same size and align. Called from any thread, several at once. Must not
/// call Crumple, throw, or jump out.
typedef void (*CrumpleFree)(void *pointer, size_t size, size_t align, void *user);

/// The host's allocator.
typedef struct {
    /// Bytes of this struct, from crumple_allocator_def_default().
    uint32_t struct_size;
    /// Gives memory. Required.
    CrumpleAlloc alloc;
    /// Takes memory back. Required.
    CrumpleFree free;
    /// Handed to both, untouched. May be null.
    void *user;
} CrumpleAllocatorDef;

/// Receives one message, UTF-8, without a line break at its end; the text is gone when the callback returns. Called
/// from the thread that called Crumple. Must not call Crumple with the same context, throw, or jump out.
typedef void (*CrumpleLog)(CrumpleLogLevel level, const char *message, void *user);

/// One task of a parallel-for, given to you to be run: index is 0 to count - 1, task_data what came with it.
typedef void (*CrumpleTask)(uint32_t index, void *task_data);

/// Your parallel-for: call task(index, task_data) once for every index below count, on any threads and in any order,
/// and return when all have returned. Tasks never block, never throw, and may run at once. What you forget is run
/// after you return, and an index that you run twice does nothing the second time. Called from the thread that called
/// Crumple. Must not throw or jump out. It may call crumple_instance_submit_impulse(), crumple_instance_submit_displacement() and
/// crumple_instance_end_contact(), nothing else of the same context.
typedef void (*CrumpleParallelFor)(uint32_t count, CrumpleTask task, void *task_data, void *user);

/// The host's job system. Zero everywhere: there is none, Crumple uses threads of its own.
typedef struct {
    /// Runs tasks. Null: Crumple uses threads of its own.
    CrumpleParallelFor parallel_for;
    /// Handed to parallel_for, untouched. May be null.
    void *user;
    /// How many threads may work at once; 0 counts as 1. Only decides how finely work is cut: never the result.
    uint32_t workers;
} CrumpleTaskSystem;

/// How a context works.
typedef struct {
    /// Bytes of this struct, from crumple_context_def_default().
    uint32_t struct_size;
    /// Threads that deform: 0 one for each core, 1 only the calling thread, up to 1024. Without meaning where tasks
    /// is set. Default 0.
    uint32_t threads;
    /// Receives messages. Null: none. Default null.
    CrumpleLog log;
    /// Handed to log, untouched.
    void *log_user;
    /// Your job system, instead of threads of Crumple's own. Default zero: none.
    CrumpleTaskSystem tasks;
} CrumpleContextDef;

/// An array that Crumple reads during the call and never keeps. Element i lies at data + i * stride; how many there
/// are and of what type is said where the array is used. Zero everywhere: the array is absent.
typedef struct {
    /// First element; aligned to its type (4 bytes, or 2 for 16-bit indices). Null: absent.
    const void *data;
    /// Readable bytes from data on; at least (count - 1) * stride + the bytes of one element.
    size_t size;
    /// Bytes from one element to the next: at least those of one element, a multiple of its alignment. 0 is an error,
    /// never "tightly packed".
    size_t stride;
} CrumpleInput;

/// A point or a vector. Its unit is named where it is used.
typedef struct {
    /// Along the mesh's (or the world's) first axis.
    float x;
    /// Along the second axis.
    float y;
    /// Along the third axis.
    float z;
} CrumpleVec3;

/// One example: the base mesh after a collision. Give target_positions, or delta_indices with position_deltas.
typedef struct {
    /// Bytes of this struct, from crumple_example_def_default().
    uint32_t struct_size;
    /// Number of moved vertices in delta_indices, position_deltas and normal_deltas. Without meaning for
    /// target_positions.
    uint32_t delta_count;
    /// Any UTF-8 text that ends with a zero, copied; need not be unique. Null: empty.
    const char *name;
    /// Full form: where every vertex of the base mesh goes: vertex_count times 3 floats, m, in the base's order.
    CrumpleInput target_positions;
    /// Full form: unit normals there: vertex_count times 3 floats. Absent: computed. Needs the base mesh's normals.
    CrumpleInput target_normals;
    /// Sparse form: indices of the moved vertices, strictly increasing: delta_count times uint32_t.
    CrumpleInput delta_indices;
    /// Sparse form: how far they move: delta_count times 3 floats, m.
    CrumpleInput position_deltas;
    /// Sparse form: how their unit normals change: delta_count times 3 floats. Absent: computed.
    CrumpleInput normal_deltas;
    /// How the place where the example was hit is told. Default CRUMPLE_CONTACT_KIND_NONE.
    CrumpleContactKind contact_kind;
    /// The vertex that was hit, for CRUMPLE_CONTACT_KIND_VERTEX.
    uint32_t contact_vertex;
    /// The point that was hit, m, in the mesh's space, for CRUMPLE_CONTACT_KIND_POINT.
    CrumpleVec3 contact_point;
    /// The surface's outward direction there, of any length but 0, where has_contact_normal is true.
    CrumpleVec3 contact_normal;
    /// Whether contact_normal is given; otherwise it is taken from the mesh. Default false.
    bool has_contact_normal;
    /// Whether it may be carried. Default CRUMPLE_PLACEMENT_AUTOMATIC.
    CrumplePlacement placement;
} CrumpleExampleDef;

/// How an example set is made ready. Part of the defs that make one, which carry its defaults.
typedef struct {
    /// No vertex ever moves further than this, m. 0: the deepest displacement of any example. Default 0.
    float depth_limit;
    /// Displacements of an example up to this length are dropped, m. 0: only exact zeros. Default 0.
    float drop_below;
    /// Mass of every vertex, kg, for impulses that bring none of their own. 0: not known. Default 0.
    float vertex_mass;
    /// Nodes along each side of the grid that a carried example is kept in: 4 to 128. Default 32; sharp creases want
    /// more. With a tolerance, at most.
    uint32_t stamp_resolution;
    /// How far an example of weight 1 may put a vertex off, m: displacements are kept as integers of 1 or 2 bytes that hold
    /// this, and carried examples on the coarsest grid that does. 0, the default: exact floats.
    float tolerance;
    /// With a tolerance: how far an example of weight 1 may turn a normal off, degrees; above 0 to 45. Default 1.
    float normal_tolerance;
    /// Mass of each vertex, kg: vertex_count floats, instead of vertex_mass. Default absent.
    CrumpleInput vertex_masses;
    /// How the dents of several hits combine. Default CRUMPLE_COMBINE_ENERGIES.
    CrumpleCombine combine;
    /// What becomes of examples that tear seams. Default CRUMPLE_SEAMS_WELD.
    CrumpleSeams seams;
    /// Whether carried examples may never be scaled above their own depth, as anchored ones never are. Default false.
    bool strict;
    /// Whether examples also serve mirrored, where the body is the same on both sides of a coordinate plane through the
    /// centre of its bounds. Default true.
    bool mirror;
    /// Whether carried dents fall to zero towards edges of the sheet that the examples show to be held. Default true.
    bool held_rims;
} CrumpleExampleSetOptions;

/// A base mesh and its examples, as arrays.
typedef struct {
    /// Bytes of this struct, from crumple_example_set_def_default().
    uint32_t struct_size;
    /// Vertices of the base mesh, at least 1. Their order is yours and is kept.
    uint32_t vertex_count;
    /// Positions: vertex_count times 3 floats, m. Any handedness, any axis up. Required.
    CrumpleInput positions;
    /// Unit normals: vertex_count times 3 floats. Absent: computed from the triangles, smooth across seams.
    CrumpleInput normals;
    /// Tangents as in glTF: vertex_count times 4 floats, xyz of unit length, w +1 or -1. Absent: none.
    CrumpleInput tangents;
    /// Triangles: index_count indices, three a triangle, counter-clockwise seen from outside. Absent: a cloud of
    /// points, which then needs normals.
    CrumpleInput indices;
    /// Number of indices, a multiple of 3.
    uint32_t index_count;
    /// Type of indices. Default CRUMPLE_INDEX_TYPE_U32.
    CrumpleIndexType index_type;
    /// The examples: example_count of them, each from crumple_example_def_default().
    const CrumpleExampleDef *examples;
    /// Number of examples, at least 1.
    uint32_t example_count;
    /// How the set is made ready.
    CrumpleExampleSetOptions options;
} CrumpleExampleSetDef;

/// A base mesh and its examples: immutable, shared by any number of instances. An id; zero is null. Compare ids field
/// by field; copy them freely; a stale or foreign id is an error, never a crash.
typedef struct {
    /// Place in the context, plus one; 0 is null.
    uint32_t index;
    /// Tells successive users of the place apart.
    uint16_t generation;
    /// Tells contexts apart.
    uint16_t context;
} CrumpleExampleSet;

/// Another mesh of a set's body, as arrays.
typedef struct {
    /// Bytes of this struct, from crumple_lod_def_default().
    uint32_t struct_size;
    /// Its vertices, at least 1. Their order is yours and is kept.
    uint32_t vertex_count;
    /// Positions: vertex_count times 3 floats, m, in the base mesh's space. Required.
    CrumpleInput positions;
    /// Unit normals: vertex_count times 3 floats. Absent: computed from the triangles, smooth across seams.
    CrumpleInput normals;
    /// Tangents as in glTF: vertex_count times 4 floats, xyz of unit length, w +1 or -1. Absent: none.
    CrumpleInput tangents;
    /// Triangles: index_count indices, three a triangle, counter-clockwise seen from outside. Absent: none.
    CrumpleInput indices;
    /// Number of indices, a multiple of 3.
    uint32_t index_count;
    /// Type of indices. Default CRUMPLE_INDEX_TYPE_U32.
    CrumpleIndexType index_type;
} CrumpleLodDef;

/// Which mesh of a glTF file, and how it is made ready.
typedef struct {
    /// Bytes of this struct, from crumple_gltf_def_default().
    uint32_t struct_size;
    /// Index of the mesh in the file, where mesh_name is null; UINT32_MAX: the first mesh that has morph targets.
    /// Default UINT32_MAX.
    uint32_t mesh_index;
    /// Name of the mesh, UTF-8. Null: mesh_index decides. Default null.
    const char *mesh_name;
    /// Path of the .glb or .gltf file, UTF-8, for crumple_example_set_load_gltf(). For
    /// crumple_example_set_load_gltf_memory() the folder that files named in it are relative to; null: such files are
    /// an error.
    const char *path;
    /// How the set is made ready. vertex_masses must be absent, or hold as many as the mesh has vertices.
    CrumpleExampleSetOptions options;
} CrumpleGltfDef;

/// A base OBJ and its examples, and how they are made ready.
typedef struct {
    /// Bytes of this struct, from crumple_obj_def_default().
    uint32_t struct_size;
    /// Number of example_paths, at least 1.
    uint32_t example_count;
    /// Path of the base mesh, UTF-8. Required.
    const char *base_path;
    /// Paths of the examples, UTF-8: the base mesh after a collision, with the same vertices in the same order.
    const char *const *example_paths;
    /// How the set is made ready.
    CrumpleExampleSetOptions options;
} CrumpleObjDef;

/// An array that Crumple writes. Element i lies at data + offset + i * stride. Positions and normals are 3 floats (12
/// bytes), tangents 4 (16 bytes), indices one uint32_t; Crumple touches those bytes and none between them, so that
/// several streams may be interleaved in one vertex buffer. Zero everywhere: the array is absent.
typedef struct {
    /// Begin of the memory, aligned to 4 bytes. Null: absent.
    void *data;
    /// Writable bytes from data on; at least offset + (count - 1) * stride + the bytes of one element.
    size_t size;
    /// Bytes from data to the first element, a multiple of 4.
    size_t offset;
    /// Bytes from one element to the next: at least those of one element, a multiple of 4. 0 is an error, never
    /// "tightly packed".
    size_t stride;
} CrumpleStream;

/// Where a set's mesh is copied to. Absent streams are left out.
typedef struct {
    /// Bytes of this struct, from crumple_mesh_copy_def_default().
    uint32_t struct_size;
    /// Which mesh: 0 the base mesh, else a number from crumple_example_set_add_lod(). Default 0.
    uint32_t lod;
    /// Positions: 3 floats a vertex, m.
    CrumpleStream positions;
    /// Unit normals: 3 floats a vertex.
    CrumpleStream normals;
    /// Tangents: 4 floats a vertex, xyz of unit length, w +1 or -1.
    CrumpleStream tangents;
    /// Triangles: 3 times triangle_count uint32_t.
    CrumpleStream indices;
} CrumpleMeshCopyDef;

/// A box along the mesh's axes, m.
typedef struct {
    /// Least coordinates, m.
    CrumpleVec3 min;
    /// Greatest coordinates, m.
    CrumpleVec3 max;
} CrumpleAabb;

/// What an example set holds. Strings live until the set is destroyed.
typedef struct {
    /// Name of the mesh in its file, UTF-8; empty for a set made from arrays. Never null.
    const char *name;
    /// Tells whether two sets are the same, on any machine; saved damage fits sets of one fingerprint.
    uint64_t fingerprint;
    /// Bytes of memory that the set takes.
    uint64_t memory_bytes;
    /// Vertices of the base mesh.
    uint32_t vertex_count;
    /// Triangles of the base mesh.
    uint32_t triangle_count;
    /// Examples.
    uint32_t example_count;
    /// Parts of the mesh with a material of their own; at least 1.
    uint32_t primitive_count;
    /// Positions that several vertices share.
    uint32_t seam_count;
    /// No vertex moves further than this, m.
    float depth_limit;
    /// Box around the base mesh, m.
    CrumpleAabb bounds;
    /// World matrix of the first node that shows the mesh, column-major; the identity where there is none.
    float node_transform[16];
    /// Whether the mesh has tangents.
    bool has_tangents;
    /// Meshes that show the damage: 1, the base mesh, and those of crumple_example_set_add_lod().
    uint32_t lod_count;
    /// Zero; room for later.
    uint64_t reserved[4];
} CrumpleExampleSetInfo;

/// What an example is. Strings live until the set is destroyed.
typedef struct {
    /// Its name, UTF-8. Never null.
    const char *name;
    /// The vertex that was hit, or its deepest.
    uint32_t contact_vertex;
    /// Vertices that it moves. 0: the example does nothing.
    uint32_t moved_vertices;
    /// Where it was hit, m.
    CrumpleVec3 contact_point;
    /// The surface's outward unit normal there; zero where it is not known.
    CrumpleVec3 contact_normal;
    /// How far the contact vertex moves, m.
    float depth;
    /// How far its deepest vertex moves, m.
    float max_depth;
    /// Distance from the contact to the furthest vertex that moves noticeably, m.
    float support_radius;
    /// Whether it may be carried.
    CrumplePlacement placement;
    /// Zero; room for later.
    uint64_t reserved[2];
} CrumpleExampleInfo;

/// A part of the mesh with a material of its own.
typedef struct {
    /// Name of its material, UTF-8; null where it has none. Lives until the set is destroyed.
    const char *material;
    /// First vertex.
    uint32_t first_vertex;
    /// Number of vertices.
    uint32_t vertex_count;
    /// First triangle; its first index is 3 times that.
    uint32_t first_triangle;
    /// Number of triangles.
    uint32_t triangle_count;
} CrumplePrimitive;

/// A body in the scene.
typedef struct {
    /// Bytes of this struct, from crumple_instance_def_default().
    uint32_t struct_size;
    /// How many examples one hit may mix: 1 to 4. Default 3.
    uint32_t examples_per_hit;
    /// The mesh and the examples. Required. The instance keeps what it needs of it alive.
    CrumpleExampleSet set;
    /// What hits do. Default CRUMPLE_RULE_MARKS.
    CrumpleRule rule;
    /// How examples are chosen. Default CRUMPLE_SELECTION_OF_RULE.
    CrumpleSelection selection;
    /// Marks kept, 1 to 65535, 32 bytes each. Above it the weakest mark gives its energy to its nearest neighbour.
    /// Default 64.
    uint32_t mark_capacity;
    /// No vertex moves further than this, m. 0: the set's limit. Default 0.
    float depth_limit;
    /// Impulses shorter than this leave no mark, N s. Default 0.
    float yield_impulse;
    /// Hits that would displace their contact by less than this leave no mark, m. Default 0.
    float yield_displacement;
    /// Contacts further than this from the nearest vertex are refused, m. 0: the body's diagonal. Default 0.
    float max_contact_distance;
    /// Constant of CRUMPLE_RULE_BLEND, 0 to 1. Default 0.
    float blend_constant;
    /// No vertex is wrong by more than this, m; see crumple_instance_set_tolerance(). Default 0: nothing is left out.
    float tolerance;
    /// From mesh to world space, column-major (element 4 * column + row); see crumple_instance_set_transform().
    /// Default the identity.
    float local_to_world[16];
} CrumpleInstanceDef;

/// One body in the scene: an example set, a transform, and the damage so far. An id; zero is null.
typedef struct {
    /// Place in the context, plus one; 0 is null.
    uint32_t index;
    /// Tells successive users of the place apart.
    uint16_t generation;
    /// Tells contexts apart.
    uint16_t context;
} CrumpleInstance;

/// What an instance is at the moment.
typedef struct {
    /// The id it was made with, which may be stale by now.
    CrumpleExampleSet set;
    /// Bytes of memory it takes, without the set and without your buffers.
    uint64_t memory_bytes;
    /// Marks, hits that wait among them. 0 with the literature's rules.
    uint32_t mark_count;
    /// Registered buffers.
    uint32_t buffer_count;
    /// No vertex moves further than this, m.
    float depth_limit;
    /// Open contacts, see crumple_instance_end_contact().
    uint32_t contact_count;
    /// Zero; room for later.
    uint32_t reserved[4];
} CrumpleInstanceInfo;

/// A hit by an impulse. The contact is displaced by impulse * duration / mass. Let duration be a constant of the
/// material, never the time step, and report a contact once, with its whole impulse, or in parts with a contact_id:
/// then dents do not depend on the frame rate.
typedef struct {
    /// Bytes of this struct, from crumple_impulse_def_default().
    uint32_t struct_size;
    /// The space of point and impulse. Default CRUMPLE_SPACE_LOCAL.
    CrumpleSpace space;
    /// Where it hit, m; its nearest vertex is the contact.
    CrumpleVec3 point;
    /// The impulse that the body received, N s.
    CrumpleVec3 impulse;
    /// How long it acted, s; above 0: a constant of the material, say 0.01, not the time step. Default 0: set it.
    float duration;
    /// Mass of the contact vertex, kg. 0: that of the set. Default 0.
    float mass;
    /// Which contact it is part of, any number of your own; hits of one contact make one dent, see
    /// crumple_instance_end_contact(). 0: none, a hit of its own. Default 0.
    uint64_t contact_id;
    /// Only tell what the hit would do, and leave nothing. Default false.
    bool preview;
} CrumpleImpulseDef;

/// A hit that should displace its contact so far: for engines with a mapping of their own. Free of the frame rate.
typedef struct {
    /// Bytes of this struct, from crumple_displacement_def_default().
    uint32_t struct_size;
    /// The space of point and displacement. Default CRUMPLE_SPACE_LOCAL.
    CrumpleSpace space;
    /// Where it hit, m; its nearest vertex is the contact.
    CrumpleVec3 point;
    /// How far the contact should move, m.
    CrumpleVec3 displacement;
    /// Which contact it is part of, as in CrumpleImpulseDef. Default 0.
    uint64_t contact_id;
    /// Only tell what the hit would do, and leave nothing. Default false.
    bool preview;
} CrumpleDisplacementDef;

/// An example that a hit is made of.
typedef struct {
    /// Its index in the set.
    uint32_t example;
    /// Its share of the dent; the shares of a hit sum to 1. Negative where it corrects others that overshoot.
    float share;
    /// What its displacements are multiplied with.
    float scale;
    /// Whether it stays where it was made; otherwise it is carried to the contact.
    bool anchored;
    /// The planes that it is mirrored in: 1 for x, 2 for y, 4 for z, added up.
    uint8_t mirror;
} CrumpleChosen;

/// An example, how it is placed, and its share of a dent.
typedef struct {
    /// Index of the example; 0xFFFF in an unused pair.
    uint16_t example;
    /// Low 12 bits: share of the dent, two's complement, 1024 being the whole. Bits 12, 13 and 14: the example is mirrored in
    /// x, y, z. Bit 15: it stays where it was made.
    uint16_t share;
} CrumplePair;

/// One dent: where, how deep, and made of which examples. Plain data of 32 bytes, the same on every machine: send it
/// over the network as it is (little-endian) to show the same dent there.
typedef struct {
    /// The vertex that was hit.
    uint32_t contact;
    /// Depth asked for at the contact, m; above 0.
    float depth;
    /// Strength squared, in units of 2^-32: 4294967296 for one hit; each hit that repeats the mark adds as much.
    uint64_t energy;
    /// One to four examples, the used ones first.
    CrumplePair pairs[4];
} CrumpleMark;

/// What a hit was turned into, and what of it could not be met.
typedef struct {
    /// What became of it.
    CrumpleHitStatus status;
    /// The vertex nearest to the point.
    uint32_t contact_vertex;
    /// Its distance from the point, m.
    float contact_distance;
    /// Displacement asked for at the contact, m, in the mesh's space.
    CrumpleVec3 target;
    /// Displacement that this hit alone brings there, m, in the mesh's space.
    CrumpleVec3 achieved;
    /// Number of chosen examples.
    uint32_t chosen_count;
    /// Whether the target was longer than the depth limit and was cut to it.
    bool clamped;
    /// The examples, the weightiest first.
    CrumpleChosen chosen[4];
    /// The mark it leaves; zero everywhere where it leaves none.
    CrumpleMark mark;
} CrumpleHitResult;

/// Memory for the deformed vertices of one instance, in the mesh's order and space.
typedef struct {
    /// Bytes of this struct, from crumple_host_buffer_def_default().
    uint32_t struct_size;
    /// The mesh whose vertices are written: 0 the base mesh, else a number from crumple_example_set_add_lod(). Counts of
    /// vertices are that mesh's. Default 0.
    uint32_t lod;
    /// Positions: 3 floats a vertex, m. Required.
    CrumpleStream positions;
    /// Unit normals: 3 floats a vertex. Absent: none are written.
    CrumpleStream normals;
    /// Tangents: 4 floats a vertex, xyz of unit length and orthogonal to the normal, w as in the base mesh. Absent:
    /// none are written.
    CrumpleStream tangents;
} CrumpleHostBufferDef;

/// Memory of yours that an instance's deformed vertices are written to. An id; zero is null.
typedef struct {
    /// Place in the context, plus one; 0 is null.
    uint32_t index;
    /// Tells successive users of the place apart.
    uint16_t generation;
    /// Tells contexts apart.
    uint16_t context;
} CrumpleBuffer;

/// What a deform did.
typedef struct {
    /// Vertices written, over all buffers.
    uint64_t vertices_written;
    /// Blocks of consecutive vertices written.
    uint64_t blocks_written;
    /// Blocks that were up to date already.
    uint64_t blocks_skipped;
    /// Examples of marks that tolerances left out of blocks written, see crumple_instance_set_tolerance().
    uint64_t parts_skipped;
    /// Zero; room for later.
    uint64_t reserved[4];
} CrumpleDeformReport;

/// Consecutive vertices.
typedef struct {
    /// First vertex.
    uint32_t first;
    /// Number of vertices.
    uint32_t count;
} CrumpleRange;

/// Any Vulkan function, as PFN_vkVoidFunction: (CrumpleVulkanFunction)vkGetInstanceProcAddr.
typedef void (*CrumpleVulkanFunction)(void);

/// Your Vulkan device, of Vulkan 1.1 or later. No extension and no feature needs to be enabled.
typedef struct {
    /// Bytes of this struct, from crumple_vulkan_attach_def_default().
    uint32_t struct_size;
    /// Family of the queue that command buffers are submitted to; one that can compute. Required. Default UINT32_MAX.
    uint32_t queue_family;
    /// vkGetInstanceProcAddr of the loader that the instance was made with. Every function is taken from it; Crumple never
    /// opens a Vulkan library of its own accord. Required.
    CrumpleVulkanFunction get_instance_proc_addr;
    /// The VkInstance. Required.
    void *instance;
    /// The VkPhysicalDevice. Required.
    void *physical_device;
    /// The VkDevice. Required.
    void *device;
    /// What crumple_vulkan_get_pipeline_cache() gave at an earlier run; read during the call. Data of another driver is not
    /// used. Default null: none.
    const void *pipeline_cache;
    /// Bytes at pipeline_cache.
    size_t pipeline_cache_size;
    /// Invocations a workgroup: 32, 64, 128 or 256, no more than the device can. Default 128.
    uint32_t workgroup_size;
} CrumpleVulkanAttachDef;

/// Where the values of one attribute lie. Zero everywhere: the attribute is absent.
typedef struct {
    /// Bytes from the range's begin to the first vertex's value; a multiple of 4.
    uint64_t offset;
    /// Bytes from one vertex's value to the next; a multiple of 4, at least those of one value.
    uint64_t stride;
    /// A VkFormat. Positions: R32G32B32_SFLOAT, R16G16B16A16_SFLOAT (the fourth is 1), R16G16B16A16_SNORM (see scale).
    /// Normals: R32G32B32_SFLOAT, R16G16B16A16_SNORM, R8G8B8A8_SNORM (the fourth is 0). Tangents: R32G32B32A32_SFLOAT,
    /// R16G16B16A16_SNORM, R8G8B8A8_SNORM.
    uint32_t format;
    /// Zero.
    uint32_t reserved;
} CrumpleVulkanStream;

/// A range of a VkBuffer for the deformed vertices of one instance, in the mesh's order and space.
typedef struct {
    /// Bytes of this struct, from crumple_vulkan_buffer_def_default().
    uint32_t struct_size;
    /// The mesh whose vertices are written: 0 the base mesh, else a number from crumple_example_set_add_lod(). Default 0.
    uint32_t lod;
    /// The VkBuffer, bound to memory: (uint64_t)handle. Required. Any number of ranges may lie in it; this field and the
    /// seven below it are then the same for each.
    uint64_t buffer;
    /// Bytes of the whole VkBuffer. Required.
    uint64_t buffer_size;
    /// The VkBufferUsageFlags that it was made with; VK_BUFFER_USAGE_STORAGE_BUFFER_BIT must be among them. Required.
    uint32_t usage;
    /// The queue family that owns it before and after what Crumple records; not the device's own: each recording that names
    /// one of its ranges then begins with an acquire and ends with a release of the whole VkBuffer, even where no vertex
    /// changed, and the release and acquire of that other queue are yours. Default VK_QUEUE_FAMILY_IGNORED: that of the
    /// device owns it, or it is shared (VK_SHARING_MODE_CONCURRENT).
    uint32_t queue_family;
    /// The VkPipelineStageFlags in which you used the VkBuffer last before a recording, anything in it, since barriers are of
    /// the whole: indices, copies into it, read-backs; not 0. Default VK_PIPELINE_STAGE_VERTEX_INPUT_BIT.
    uint32_t before_stages;
    /// The VkAccessFlags of that use. Default VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT.
    uint32_t before_access;
    /// The VkPipelineStageFlags in which you use it next, anything in it; not 0. Default VK_PIPELINE_STAGE_VERTEX_INPUT_BIT.
    uint32_t after_stages;
    /// The VkAccessFlags of that use. Default VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT.
    uint32_t after_access;
    /// Bytes before the range; a multiple of 4.
    uint64_t offset;
    /// Bytes of the range: nothing outside it is written. Ranges may interleave; values must not overlap. Required.
    uint64_t size;
    /// Positions, m. Required.
    CrumpleVulkanStream positions;
    /// Unit normals. Absent: none are written.
    CrumpleVulkanStream normals;
    /// Tangents: xyz of unit length and orthogonal to the normal, w as in the base mesh. Absent: none are written.
    CrumpleVulkanStream tangents;
    /// Of positions in R16G16B16A16_SNORM: a stored number s, -1 to 1, stands for s * scale + bias, m. What lies outside is
    /// held at the border, so take the mesh's bounds grown by the depth limit. Above 0. Default 1, 1, 1.
    CrumpleVec3 scale;
    /// See scale, m. Default 0, 0, 0.
    CrumpleVec3 bias;
} CrumpleVulkanBufferDef;

/// What was recorded.
typedef struct {
    /// Vertices that will be written, over all buffers.
    uint64_t vertices_written;
    /// Blocks of consecutive vertices that will be written. 0: nothing was recorded, but what queue families ask for.
    uint64_t blocks_written;
    /// Blocks that were up to date already.
    uint64_t blocks_skipped;
    /// Examples of marks that tolerances left out, see crumple_instance_set_tolerance().
    uint64_t parts_skipped;
    /// Bytes that the commands copy to the device, those of meshes seen for the first time among them.
    uint64_t bytes_copied;
    /// Dispatches: one for each VkBuffer, and one for each buffer of an instance with one of the literature's rules.
    uint32_t dispatches;
    /// Zero.
    uint32_t reserved0;
    /// Zero; room for later.
    uint64_t reserved[4];
} CrumpleRecordReport;

/// A Vulkan device that Crumple makes for itself, beside yours on the same physical device.
typedef struct {
    /// Bytes of this struct, from crumple_vulkan_open_def_default().
    uint32_t struct_size;
    /// As in CrumpleVulkanAttachDef. Default 128.
    uint32_t workgroup_size;
    /// vkGetInstanceProcAddr of a loader. Required; it stays loaded.
    CrumpleVulkanFunction get_instance_proc_addr;
    /// deviceUUID of your physical device (VkPhysicalDeviceIDProperties): memory can be shared within it alone. Zero
    /// everywhere: the first that can compute. Default zero.
    uint8_t device_uuid[16];
    /// As in CrumpleVulkanAttachDef. Default null.
    const void *pipeline_cache;
    /// Bytes at pipeline_cache.
    size_t pipeline_cache_size;
} CrumpleVulkanOpenDef;

/// A VkBuffer of your device, in memory that it exported. You made it with VkExternalMemoryBufferCreateInfo, and its memory with
/// VkExportMemoryAllocateInfo, both of the same type of handle.
typedef struct {
    /// Bytes of this struct, from crumple_vulkan_import_def_default().
    uint32_t struct_size;
    /// What handle is. Default CRUMPLE_HANDLE_TYPE_OPAQUE_FD.
    CrumpleHandleType handle_type;
    /// The handle of the memory. Required. Default -1.
    int64_t handle;
    /// allocationSize of the memory, bytes. Required.
    uint64_t memory_size;
    /// memoryTypeIndex of the memory. Required.
    uint32_t memory_type;
    /// VkBufferUsageFlags that the buffer was made with; VK_BUFFER_USAGE_STORAGE_BUFFER_BIT must be among them. Required.
    uint32_t usage;
    /// Where in the memory the buffer was bound, bytes. Default 0.
    uint64_t offset;
    /// The buffer's size, bytes. Required.
    uint64_t size;
    /// Whether the memory was allocated for this buffer alone (VkMemoryDedicatedAllocateInfo). Default false.
    bool dedicated;
} CrumpleVulkanImportDef;

/// A point bound to the surface nearest to it. Plain data: keep it, copy it, save it; it fits every instance of its
/// set.
typedef struct {
    /// The triangle's vertices; all the same for a mesh without triangles.
    uint32_t vertices[3];
    /// Barycentric weights of the surface point; they sum to 1.
    float weights[3];
    /// The attached point at rest, m, in the mesh's space.
    CrumpleVec3 point;
} CrumpleAttachment;

/// A rotation: a unit quaternion, x y z w, w the real part.
typedef struct {
    /// i part.
    float x;
    /// j part.
    float y;
    /// k part.
    float z;
    /// Real part.
    float w;
} CrumpleQuat;

/// Where an attached point is.
typedef struct {
    /// Position, m, in the mesh's space.
    CrumpleVec3 position;
    /// Rotation since rest.
    CrumpleQuat rotation;
} CrumpleFrame;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// The version of the library that runs: major * 1000000 + minor * 1000 + patch. Compare it with CRUMPLE_VERSION,
/// that of the header you compiled against. Never fails; any thread.
uint32_t crumple_version(void);

/// The version of the library that runs as text, such as "0.1.0". Lives for ever. Never fails; any thread.
const char *crumple_version_string(void);

/// What this build of the library can do: the CRUMPLE_FEATURE_ bits, or-ed. Bits unknown to you may be set. Never
/// fails; any thread.
uint64_t crumple_features(void);

/// What was wrong in the calling thread's last failed call, and what would be right, as UTF-8:
/// "crumple_instance_create: ...". Empty before the first failure; a call that succeeds leaves it. Valid until the
/// thread's next failed call. At most 1023 bytes. Never null, never fails; any thread, each has its own text.
const char *crumple_last_error(void);

/// The name of a result, such as "CRUMPLE_ERROR_FORMAT"; "unknown result" for a number that is none. Lives for ever.
/// Never fails; any thread.
const char *crumple_result_name(CrumpleResult result);

/// An allocator def without functions: set both. Never fails; any thread.
CrumpleAllocatorDef crumple_allocator_def_default(void);

/// Makes the library take all further memory from the host's functions, for the whole process; null goes back to the
/// system's. May be called at any time: each piece of memory returns to the functions it came from, so those must
/// stay callable until the last piece is back. Destroying all contexts returns all, except for a few kB a thread that
/// contexts with threads of Crumple's own leave to the next ones for the life of the process. At most 15 different
/// allocators in the life of a process.
///
/// Any thread. Errors: CRUMPLE_ERROR_UNSUPPORTED (a build without CRUMPLE_FEATURE_HOST_ALLOCATOR; see
/// crumple_features()), CRUMPLE_ERROR_STRUCT_SIZE, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_NULL_POINTER (a function
/// is missing), CRUMPLE_ERROR_INVALID_ARGUMENT (a sixteenth allocator).
CrumpleResult crumple_allocator_set(const CrumpleAllocatorDef *allocator);

/// The defaults: threads of Crumple's own, one for each core; no log. Never fails; any thread.
CrumpleContextDef crumple_context_def_default(void);

/// Creates a context. def is copied; what its callbacks need must live until the context is destroyed.
///
/// Any thread; contexts know nothing of each other. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED,
/// CRUMPLE_ERROR_STRUCT_SIZE, CRUMPLE_ERROR_INVALID_ARGUMENT (more than 1024 threads; 65535 contexts are alive),
/// CRUMPLE_ERROR_OUT_OF_MEMORY (the system starts no more threads).
CrumpleResult crumple_context_create(const CrumpleContextDef *def, CrumpleContext **out_context);

/// Destroys a context and everything made in it. Your own memory is never freed, and is not touched afterwards. Every
/// id of the context, and the context itself, is an error from then on.
///
/// No other call with this context may be running. Where a Vulkan device is attached, it must still be there. Errors:
/// CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID (destroyed already), CRUMPLE_ERROR_FRAMES_IN_FLIGHT (see
/// crumple_vulkan_complete_frames()), CRUMPLE_ERROR_CONCURRENT_USE. Nothing was destroyed then.
CrumpleResult crumple_context_destroy(CrumpleContext *context);

/// An example without anything: set its positions. Never fails; any thread.
CrumpleExampleDef crumple_example_def_default(void);

/// A set without anything: set its mesh and its examples. Never fails; any thread.
CrumpleExampleSetDef crumple_example_set_def_default(void);

/// Makes an example set from arrays, which are copied: free them afterwards. Takes a moment (it indexes the mesh and
/// samples every example), so load before the scene starts, on a context of its own thread if need be.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_STRUCT_SIZE
/// (of def or of an example), CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (an enumerator or a count, a
/// stride smaller than an element, an option out of range), CRUMPLE_ERROR_BUFFER_TOO_SMALL (an array has fewer bytes
/// than its count needs), CRUMPLE_ERROR_NOT_FINITE, CRUMPLE_ERROR_INDEX_OUT_OF_RANGE, CRUMPLE_ERROR_MESH (no
/// vertices), CRUMPLE_ERROR_EXAMPLE_MISMATCH (no example, or one that does not fit the mesh),
/// CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_example_set_create(CrumpleContext *context,
                                         const CrumpleExampleSetDef *def,
                                         CrumpleExampleSet *out_set);

/// A level of detail without anything: set its mesh. Never fails; any thread.
CrumpleLodDef crumple_lod_def_default(void);

/// Adds another mesh of the same body that shows the same damage, such as a level of detail or a collision proxy. The arrays
/// are copied. Its number, 1 for the first, is what CrumpleHostBufferDef.lod takes. Each of its vertices is bound to the nearest
/// point of the base surface and moves as that does; one that stands on a base vertex moves exactly as that one. Contacts, marks,
/// saved damage and the set's fingerprint stay those of the base mesh. All instances of the set know all of its levels, so
/// add them before the first instance is made.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_STRUCT_SIZE,
/// CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (the set has instances; an enumerator, a count, or a stride smaller
/// than an element), CRUMPLE_ERROR_BUFFER_TOO_SMALL (an array has fewer bytes than its count needs),
/// CRUMPLE_ERROR_NOT_FINITE, CRUMPLE_ERROR_INDEX_OUT_OF_RANGE, CRUMPLE_ERROR_MESH (no vertices),
/// CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_CONCURRENT_USE. The set is as it was then.
CrumpleResult crumple_example_set_add_lod(CrumpleContext *context,
                                          CrumpleExampleSet set,
                                          const CrumpleLodDef *def,
                                          uint32_t *out_lod);

/// Ends a set's id. Its memory lives on as long as instances use it, and they keep working. Strings that the set's
/// infos pointed to are gone.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_example_set_destroy(CrumpleContext *context, CrumpleExampleSet set);

/// The first mesh with morph targets, with default options; set the path. Never fails; any thread.
CrumpleGltfDef crumple_gltf_def_default(void);

/// Default options; set the paths. Never fails; any thread.
CrumpleObjDef crumple_obj_def_default(void);

/// Makes an example set from a glTF 2.0 or GLB file: a mesh with its morph targets, dense or sparse, all primitives
/// joined (see crumple_example_set_get_primitive()). Where the file has them, names come from mesh.extras.targetNames, contacts from
/// mesh.extras.impacts and placements from mesh.extras.placements. Numbers are those of the mesh's own space: scales and
/// rotations of nodes are not applied.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_IO, CRUMPLE_ERROR_FORMAT (malformed, or no such mesh: the text
/// lists those there are), CRUMPLE_ERROR_UNSUPPORTED (compressed with Draco or meshopt, or a build without
/// CRUMPLE_FEATURE_GLTF), CRUMPLE_ERROR_EXAMPLE_MISMATCH (no morph targets), and those of
/// crumple_example_set_create().
CrumpleResult crumple_example_set_load_gltf(CrumpleContext *context,
                                            const CrumpleGltfDef *def,
                                            CrumpleExampleSet *out_set);

/// The same from the bytes of a file: size bytes at data, read during the call only, of any alignment.
///
/// Externally synchronised. Errors: as for crumple_example_set_load_gltf().
CrumpleResult crumple_example_set_load_gltf_memory(CrumpleContext *context,
                                                   const void *data,
                                                   size_t size,
                                                   const CrumpleGltfDef *def,
                                                   CrumpleExampleSet *out_set);

/// Makes an example set from a base OBJ file and one OBJ file an example, which has the base's vertices in the base's
/// order and is named after its file. Polygons are cut into triangles.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_IO, CRUMPLE_ERROR_FORMAT, CRUMPLE_ERROR_UNSUPPORTED (a build
/// without CRUMPLE_FEATURE_OBJ), and those of crumple_example_set_create().
CrumpleResult crumple_example_set_load_obj(CrumpleContext *context,
                                           const CrumpleObjDef *def,
                                           CrumpleExampleSet *out_set);

/// Makes an example set from the size bytes of a .crumple file at data, which "crumple bake" or crumple_example_set_save_baked()
/// wrote: at once, since nothing is built or unpacked. bytes tells whether they are copied or kept, see CrumpleBytes.
/// Everything in them is checked: no file can make Crumple read or write what it should not. The set has one primitive, no
/// name and no node transform.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED (out_set),
/// CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (bytes is no enumerator), CRUMPLE_ERROR_FORMAT (damaged, cut
/// short, or no baked set), CRUMPLE_ERROR_UNSUPPORTED (of another version of the format, or a big-endian processor),
/// CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_CONCURRENT_USE. Nothing is kept then.
CrumpleResult crumple_example_set_load_baked_memory(CrumpleContext *context,
                                                    const void *data,
                                                    size_t size,
                                                    CrumpleBytes bytes,
                                                    CrumpleExampleSet *out_set);

/// The same from a file, which is read into memory: path is UTF-8.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_IO, CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ARGUMENT (path is
/// not UTF-8), and those of crumple_example_set_load_baked_memory().
CrumpleResult crumple_example_set_load_baked(CrumpleContext *context,
                                             const char *path,
                                             CrumpleExampleSet *out_set);

/// Saves an example set as the bytes of a .crumple file; the same bytes for the same set on every machine. data has room
/// for capacity bytes, of any alignment; with null and 0 only their number is told.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED (out_size),
/// CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_BUFFER_TOO_SMALL, CRUMPLE_ERROR_UNSUPPORTED (a big-endian processor),
/// CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_example_set_save_baked(CrumpleContext *context,
                                             CrumpleExampleSet set,
                                             void *data,
                                             size_t capacity,
                                             size_t *out_size);

/// Copies nothing; set the streams that you want. Never fails; any thread.
CrumpleMeshCopyDef crumple_mesh_copy_def_default(void);

/// Tells what a set holds.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_example_set_get_info(CrumpleContext *context,
                                           CrumpleExampleSet set,
                                           CrumpleExampleSetInfo *out_info);

/// Tells what an example is; example is below example_count.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_INDEX_OUT_OF_RANGE, CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_example_set_get_example(CrumpleContext *context,
                                              CrumpleExampleSet set,
                                              uint32_t example,
                                              CrumpleExampleInfo *out_info);

/// Tells which vertices and triangles a part of the mesh has; primitive is below primitive_count.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_INDEX_OUT_OF_RANGE, CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_example_set_get_primitive(CrumpleContext *context,
                                                CrumpleExampleSet set,
                                                uint32_t primitive,
                                                CrumplePrimitive *out_primitive);

/// Copies the base mesh, or a level of detail, into your memory: the vertex and index buffers to draw with, before the first dent. Normals
/// are computed ones where the set was made without.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_STRUCT_SIZE,
/// CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (a stride smaller than an element, streams that overlap),
/// CRUMPLE_ERROR_INDEX_OUT_OF_RANGE (def.lod), CRUMPLE_ERROR_BUFFER_TOO_SMALL, CRUMPLE_ERROR_MESH (normals or tangents of a
/// mesh that has none), CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_example_set_copy_mesh(CrumpleContext *context,
                                            CrumpleExampleSet set,
                                            const CrumpleMeshCopyDef *def);

/// Tells the vertex of the base mesh nearest to a point, m, in the mesh's space; of equally near ones the lowest.
/// Either output may be null; the distance is in m.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_NOT_FINITE, CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_example_set_find_nearest_vertex(CrumpleContext *context,
                                                      CrumpleExampleSet set,
                                                      CrumpleVec3 point,
                                                      uint32_t *out_vertex,
                                                      float *out_distance);

/// An instance with default rules; set its set. Never fails; any thread.
CrumpleInstanceDef crumple_instance_def_default(void);

/// Creates an undamaged instance: a few hundred bytes, and 8 for each 128 vertices.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_STRUCT_SIZE,
/// CRUMPLE_ERROR_INVALID_ID (def.set), CRUMPLE_ERROR_INVALID_ARGUMENT, CRUMPLE_ERROR_NOT_FINITE,
/// CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_instance_create(CrumpleContext *context,
                                      const CrumpleInstanceDef *def,
                                      CrumpleInstance *out_instance);

/// Ends an instance and unregisters its buffers, whose ids end too. Your memory stays as it is.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_instance_destroy(CrumpleContext *context, CrumpleInstance instance);

/// Tells what an instance is at the moment.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_instance_get_info(CrumpleContext *context,
                                        CrumpleInstance instance,
                                        CrumpleInstanceInfo *out_info);

/// Tells where an instance is: local_to_world points to 16 floats, column-major (element 4 * column + row, as in
/// glTF, OpenGL and Vulkan), translation in elements 12 to 14, m, last row 0 0 0 1. May scale and shear, but not
/// flatten. Only hits in CRUMPLE_SPACE_WORLD go through it, those submitted from then on; deformed vertices are
/// always in the mesh's own space.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_NOT_FINITE, CRUMPLE_ERROR_INVALID_ARGUMENT (it flattens, or the last row is another),
/// CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_instance_set_transform(CrumpleContext *context,
                                             CrumpleInstance instance,
                                             const float *local_to_world);

/// No vertex of the instance moves further than depth_limit, m, from the next crumple_context_deform() on; 0: the set's
/// limit. Damage that is there stays, and shows again when the limit is raised.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_NOT_FINITE,
/// CRUMPLE_ERROR_INVALID_ARGUMENT, CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_instance_set_depth_limit(CrumpleContext *context, CrumpleInstance instance, float depth_limit);

/// Lets vertices of the instance be wrong by up to tolerance, m, in the mesh's space, so that deforming it costs less:
/// displacements too short to matter are left out. 0: nothing is left out. Seams stay closed. It is rounded down to a power of
/// two times 1 m, so it may be set in each frame from crumple_pixel_tolerance(); where that changes, the next crumple_context_deform()
/// writes everything that is dented anew. Instances with one of the literature's rules ignore it.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_NOT_FINITE,
/// CRUMPLE_ERROR_INVALID_ARGUMENT (below 0), CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_instance_set_tolerance(CrumpleContext *context,
                                             CrumpleInstance instance,
                                             float tolerance);

/// The length, m, that covers so many pixels at a distance, m, before a camera with this vertical field of view, radians, and
/// viewport height, pixels: the tolerance for an instance whose nearest vertex is that far off. 0, which leaves out nothing, for
/// values that make no sense: negative, not a number, a field of view of half a turn or more, a height of 0. Never fails; any
/// thread.
float crumple_pixel_tolerance(float pixels,
                              float distance,
                              float fov_y,
                              float viewport_height);

/// An impulse of nothing, in the mesh's space; set its point, impulse and duration. Never fails; any thread.
CrumpleImpulseDef crumple_impulse_def_default(void);

/// A displacement of nothing, in the mesh's space; set its point and displacement. Never fails; any thread.
CrumpleDisplacementDef crumple_displacement_def_default(void);

/// Reports an impulse. Its examples are chosen at once; the mark it makes counts from the next call that reads damage
/// (crumple_context_deform(), crumple_instance_get_marks() and so on), whatever the order and the threads hits came from. A hit that
/// is too weak, or that no example answers, is no error: see status. out_result may be null. With a contact_id it
/// tells what the hit would do alone; see crumple_instance_end_contact() for what it does with the contact's other hits.
///
/// May be called from any thread at any time, also while other threads submit or deform; not while the instance or
/// the context is being destroyed. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED,
/// CRUMPLE_ERROR_STRUCT_SIZE, CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_NOT_FINITE, CRUMPLE_ERROR_INVALID_ARGUMENT (a
/// duration not above 0, a negative mass, or none known), CRUMPLE_ERROR_CONTACT_TOO_FAR (the point is further from
/// the body than the instance accepts), CRUMPLE_ERROR_WRONG_RULE (a contact_id with one of the literature's rules,
/// which cannot replace what they have deformed), CRUMPLE_ERROR_OUT_OF_MEMORY. Nothing is left behind then.
CrumpleResult crumple_instance_submit_impulse(CrumpleContext *context,
                                              CrumpleInstance instance,
                                              const CrumpleImpulseDef *def,
                                              CrumpleHitResult *out_result);

/// Reports a hit that should displace its contact so far. As crumple_instance_submit_impulse() in every other respect, its
/// threads and errors too.
CrumpleResult crumple_instance_submit_displacement(CrumpleContext *context,
                                                   CrumpleInstance instance,
                                                   const CrumpleDisplacementDef *def,
                                                   CrumpleHitResult *out_result);

/// Ends a contact of an instance: its dent stays as it is, and later hits with the same id begin another one.
///
/// A physics engine that reports one contact as many small impulses, one a step, gives all of them the same contact_id
/// (of its own choice, one for each contact point and touch, not 0) and ends the contact when the bodies part. They
/// make the one dent that the whole impulse in one report would have made, at any frame rate: while the contact is
/// open, displacements (impulse * duration / mass) add, the point is the mean of their points, weighted by the lengths
/// of their displacements, yield thresholds and depth limit hold for the sum, and the contact's one mark is replaced
/// as more hits come.
///
/// Counts from the next call that reads damage on, after all hits that have arrived by then: use an id again only after
/// that. An id that is not open is no error. Contacts also end when the instance's damage is set, loaded, copied
/// into, repaired or reset, and when more than 256 are open: the one hit longest ago ends then (of equals the lowest
/// id).
///
/// May be called from any thread at any time, as crumple_instance_submit_impulse(). Errors: CRUMPLE_ERROR_NULL_POINTER,
/// CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (contact_id is 0), CRUMPLE_ERROR_WRONG_RULE (one of the
/// literature's rules), CRUMPLE_ERROR_OUT_OF_MEMORY.
CrumpleResult crumple_instance_end_contact(CrumpleContext *context, CrumpleInstance instance, uint64_t contact_id);

/// Copies an instance's marks, sorted: the same hits give the same marks whatever their order. marks has room for
/// capacity of them; with null and 0 only their number is told.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_BUFFER_TOO_SMALL (capacity is smaller than the number of marks), CRUMPLE_ERROR_WRONG_RULE (the
/// literature's rules have no marks), CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_instance_get_marks(CrumpleContext *context,
                                         CrumpleInstance instance,
                                         CrumpleMark *marks,
                                         uint32_t capacity,
                                         uint32_t *out_count);

/// Replaces an instance's marks by count others, of the same set, forgets hits that wait and ends contacts. Null and
/// 0: none.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_INVALID_ARGUMENT (a mark that the set cannot have), CRUMPLE_ERROR_WRONG_RULE,
/// CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_CONCURRENT_USE. Nothing changes then.
CrumpleResult crumple_instance_set_marks(CrumpleContext *context,
                                         CrumpleInstance instance,
                                         const CrumpleMark *marks,
                                         uint32_t count);

/// Saves an instance's damage as bytes, with a version and the set's fingerprint; the same bytes for the same damage
/// on every machine. data has room for capacity bytes, of any alignment; with null and 0 only their number is told.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_BUFFER_TOO_SMALL, CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_instance_save_damage(CrumpleContext *context,
                                           CrumpleInstance instance,
                                           void *data,
                                           size_t capacity,
                                           size_t *out_size);

/// Replaces an instance's damage by size saved bytes, of any alignment, forgets hits that wait and ends contacts.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_DAMAGE_MISMATCH (of another set, version or rule, or cut short), CRUMPLE_ERROR_INVALID_ARGUMENT (a
/// mark that the set cannot have), CRUMPLE_ERROR_CONCURRENT_USE. Nothing changes then.
CrumpleResult crumple_instance_load_damage(CrumpleContext *context,
                                           CrumpleInstance instance,
                                           const void *data,
                                           size_t size);

/// Repairs an instance: every dent keeps this share of its depth, 0 (as new) to 1 (nothing repaired). Ends contacts.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_NOT_FINITE,
/// CRUMPLE_ERROR_INVALID_ARGUMENT, CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_instance_repair_damage(CrumpleContext *context, CrumpleInstance instance, float keep);

/// Makes an instance as new, forgets hits that wait and ends contacts.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_instance_reset_damage(CrumpleContext *context, CrumpleInstance instance);

/// Replaces the damage of instance by that of source, another instance with an equal set and the same kind of rule,
/// forgets hits that wait for instance and ends its contacts. From itself: nothing happens.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_DAMAGE_MISMATCH, CRUMPLE_ERROR_CONCURRENT_USE. Nothing changes then.
CrumpleResult crumple_instance_copy_damage(CrumpleContext *context, CrumpleInstance instance, CrumpleInstance source);

/// A buffer without memory; set its streams. Never fails; any thread.
CrumpleHostBufferDef crumple_host_buffer_def_default(void);

/// Registers memory of yours that crumple_context_deform() writes an instance's vertices to. An instance may have several,
/// such as the members of a ring, each of which gets what it lacks. Nothing is written yet; the first deform writes
/// every vertex. The memory is touched by crumple_context_deform() only, and must stay until the buffer is unregistered,
/// given other memory, or its instance or context is destroyed. Memory of different buffers must not overlap (debug
/// builds of the library check it).
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_STRUCT_SIZE,
/// CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (a stride smaller than an element, streams that overlap),
/// CRUMPLE_ERROR_INDEX_OUT_OF_RANGE (def.lod), CRUMPLE_ERROR_WRONG_RULE (def.lod above 0 for an instance with one of the
/// literature's rules), CRUMPLE_ERROR_BUFFER_TOO_SMALL, CRUMPLE_ERROR_MESH (normals or tangents of a mesh that has none),
/// CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_buffer_register_host(CrumpleContext *context,
                                           CrumpleInstance instance,
                                           const CrumpleHostBufferDef *def,
                                           CrumpleBuffer *out_buffer);

/// Forgets a buffer. The memory stays as it is, yours alone again; a VkBuffer once the frames that wrote it are done.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_buffer_unregister(CrumpleContext *context, CrumpleBuffer buffer);

/// Says that somebody else wrote to a buffer's memory, or that its contents were lost: the next deform, or recording, writes
/// every vertex.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_buffer_invalidate(CrumpleContext *context,
                                        CrumpleBuffer buffer);

/// Gives a buffer other memory, such as a newly mapped one, perhaps for another level of detail, and invalidates it.
///
/// Externally synchronised. Errors: as for crumple_buffer_register_host(), and CRUMPLE_ERROR_INVALID_ARGUMENT for a Vulkan
/// buffer; the buffer keeps its memory then.
CrumpleResult crumple_buffer_set_memory(CrumpleContext *context,
                                        CrumpleBuffer buffer,
                                        const CrumpleHostBufferDef *def);

/// Brings host buffers up to date: count ids at buffers, each once; with null and 0 all of the context. Writes only where
/// damage changed since a buffer was last written, in parallel over all of them, and is cheap where nothing did. Do
/// not read or write the buffers' memory meanwhile. An instance that nobody sees needs no deform: it catches up in
/// one, however many hits it took. out_report may be null.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_INVALID_ARGUMENT (a buffer twice, or one that crumple_vulkan_record() writes; in debug builds of the
/// library: memory of two buffers overlaps),
/// CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_CONCURRENT_USE. No vertex is written then.
CrumpleResult crumple_context_deform(CrumpleContext *context,
                                     const CrumpleBuffer *buffers,
                                     uint32_t count,
                                     CrumpleDeformReport *out_report);

/// Tells which vertices the last deform or recording that named a buffer wrote (increasing ranges, apart from each other),
/// and a box, m, around all of its vertices as they are now: what to upload, what to refit, what to cull with. The box of a
/// Vulkan buffer is never too small but may be too large, since the CPU does not see its vertices. ranges has room for
/// capacity of them; with null and 0 only their number is told. out_bounds may be null.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_BUFFER_TOO_SMALL (capacity is smaller than the number of ranges), CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_buffer_get_changes(CrumpleContext *context,
                                         CrumpleBuffer buffer,
                                         CrumpleRange *ranges,
                                         uint32_t capacity,
                                         uint32_t *out_count,
                                         CrumpleAabb *out_bounds);

/// A device without handles; set them and the queue family. Never fails; any thread.
CrumpleVulkanAttachDef crumple_vulkan_attach_def_default(void);

/// A range of no buffer, read as vertices before and after; set the buffer, its size and usage, the range and its streams.
/// Never fails; any thread.
CrumpleVulkanBufferDef crumple_vulkan_buffer_def_default(void);

/// Takes your Vulkan device: loads functions, some tenths of a millisecond. A context has one at a time. The handles must be
/// valid, belong together, and stay so until crumple_vulkan_detach() or crumple_context_destroy().
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_STRUCT_SIZE,
/// CRUMPLE_ERROR_INVALID_ARGUMENT (one is attached already, a queue family that is not there or cannot compute,
/// workgroup_size), CRUMPLE_ERROR_UNSUPPORTED (a device below Vulkan 1.1; a loader that lacks a function, which is named; a
/// build without CRUMPLE_FEATURE_VULKAN), CRUMPLE_ERROR_VULKAN, CRUMPLE_ERROR_DEVICE_LOST, CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_vulkan_attach(CrumpleContext *context,
                                    const CrumpleVulkanAttachDef *def);

/// Lets go of the Vulkan device, unregisters all Vulkan buffers, whose ids end, and destroys what Crumple made there. Damage
/// stays. After a loss of the device (CRUMPLE_ERROR_DEVICE_LOST): crumple_vulkan_complete_frames() with UINT64_MAX, since a lost
/// device runs nothing any more, this call, vkDestroyDevice, then attach the new one and register again.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (none
/// is attached), CRUMPLE_ERROR_FRAMES_IN_FLIGHT, CRUMPLE_ERROR_CONCURRENT_USE. Nothing changes then.
CrumpleResult crumple_vulkan_detach(CrumpleContext *context);

/// Gives what the driver would like to have again at the next start: hand it to crumple_vulkan_attach(). data has room for
/// capacity bytes, of any alignment; with null and 0 only their number is told, which may grow until all kinds of buffers were
/// registered.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED (out_size),
/// CRUMPLE_ERROR_INVALID_ARGUMENT (no device is attached), CRUMPLE_ERROR_BUFFER_TOO_SMALL, CRUMPLE_ERROR_VULKAN,
/// CRUMPLE_ERROR_DEVICE_LOST, CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_vulkan_get_pipeline_cache(CrumpleContext *context,
                                                void *data,
                                                size_t capacity,
                                                size_t *out_size);

/// Registers a range of a VkBuffer of yours that crumple_vulkan_record() writes an instance's vertices to. An instance may have
/// several, such as the members of a ring. Nothing is written yet; the first recording writes every vertex. The first range of a
/// mesh has its vertices and examples copied: into a staging buffer now, from there to the device by the next recording; other
/// instances and ranges share them. The VkBuffer must live until its last range is unregistered (or its instance, the device or
/// the context gone) and the frames that wrote it are done.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED (offsets and strides that are not
/// multiples of 4), CRUMPLE_ERROR_STRUCT_SIZE, CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (no device is attached, no
/// buffer, a usage without STORAGE_BUFFER, stages of 0, a format that is not one of those named, a stride smaller than a value,
/// attributes that overlap, a scale that is not above 0, another description of a VkBuffer that is registered already),
/// CRUMPLE_ERROR_NOT_FINITE, CRUMPLE_ERROR_BUFFER_TOO_SMALL, CRUMPLE_ERROR_INDEX_OUT_OF_RANGE (def.lod),
/// CRUMPLE_ERROR_WRONG_RULE (def.lod above 0 for an instance with one of the literature's rules), CRUMPLE_ERROR_UNSUPPORTED
/// (normals or tangents of a mesh that has none; more bytes than the device can bind), CRUMPLE_ERROR_OUT_OF_MEMORY,
/// CRUMPLE_ERROR_VULKAN, CRUMPLE_ERROR_DEVICE_LOST, CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_buffer_register_vulkan(CrumpleContext *context,
                                             CrumpleInstance instance,
                                             const CrumpleVulkanBufferDef *def,
                                             CrumpleBuffer *out_buffer);

/// Records what brings Vulkan buffers up to date: count ids at buffers, each once; with null and 0 all of the context. Hits
/// are folded; then, for the blocks that changed since each buffer was last written, there is a copy of a few bytes a block, a
/// barrier, one dispatch a VkBuffer, a barrier. Nothing is submitted, nothing waited for, and nothing allocated once as much has
/// changed in a frame, and as many frames were in flight, as ever will. What is read on the CPU is read by this call; damage
/// may change at once after it.
///
/// command_buffer is a VkCommandBuffer, primary or secondary, in the recording state, outside a render pass, of a pool of the
/// queue family that was attached and that no other thread uses meanwhile. It is submitted once, in the order of recording; not
/// simultaneously, not again. frame is your number of the frame, from 1 on; it never falls, and several recordings may have the
/// same one. out_report may be null.
///
/// Left changed in the command buffer: the compute pipeline, the compute descriptor sets 0 to 2, and the first 24 bytes of the
/// push constants of stage compute. Nothing else.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_INVALID_ARGUMENT (no device of yours is attached, a buffer twice or a host buffer, a frame that is done or
/// below the last), CRUMPLE_ERROR_UNSUPPORTED (more work than the device can bind), CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_VULKAN,
/// CRUMPLE_ERROR_DEVICE_LOST, CRUMPLE_ERROR_CONCURRENT_USE. Nothing was recorded then.
CrumpleResult crumple_vulkan_record(CrumpleContext *context,
                                    void *command_buffer,
                                    uint64_t frame,
                                    const CrumpleBuffer *buffers,
                                    uint32_t count,
                                    CrumpleRecordReport *out_report);

/// Says that the device is done with frame and all before it: what was submitted for them has completed, as a fence or
/// timeline semaphore says. What they used is used again, or freed. A number above the last recorded frame's counts as that.
/// Cheap; once a frame.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (no
/// device of yours is attached), CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_vulkan_complete_frames(CrumpleContext *context,
                                             uint64_t frame);

/// Says that what was recorded for frame and those after it will not be submitted: the buffers that it wrote are written
/// whole by their next recording.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (no
/// device of yours is attached), CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_vulkan_discard_frames(CrumpleContext *context,
                                            uint64_t frame);

/// Any device, by no loader; set that, and the UUID. Never fails; any thread.
CrumpleVulkanOpenDef crumple_vulkan_open_def_default(void);

/// No memory; set its handle, sizes, type and usage. Never fails; any thread.
CrumpleVulkanImportDef crumple_vulkan_import_def_default(void);

/// Makes a Vulkan device of Crumple's own, for engines that cannot hand out a command buffer but can share memory, perhaps with
/// another process: some milliseconds to tenths of a second. It takes the place of crumple_vulkan_attach(): buffers are
/// imported by crumple_vulkan_import_buffer(), registered by crumple_buffer_register_vulkan() and written by
/// crumple_vulkan_submit(). crumple_vulkan_detach() and crumple_context_destroy() wait for it, and destroy it.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_STRUCT_SIZE,
/// CRUMPLE_ERROR_INVALID_ARGUMENT (a device is attached already, workgroup_size), CRUMPLE_ERROR_UNSUPPORTED (no such device, which
/// names those there are; one that cannot import memory; a build without CRUMPLE_FEATURE_VULKAN), CRUMPLE_ERROR_VULKAN,
/// CRUMPLE_ERROR_DEVICE_LOST, CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_vulkan_open(CrumpleContext *context,
                                  const CrumpleVulkanOpenDef *def);

/// Makes a buffer of your device known to Crumple's own, and gives what stands for it as buffer of CrumpleVulkanBufferDef; that
/// def's buffer_size, usage, queue family, stages and accesses are not looked at then. On your queue, before each submission you
/// release the VkBuffer to VK_QUEUE_FAMILY_EXTERNAL, and afterwards you acquire it from there. The memory must live until
/// crumple_vulkan_unimport_buffer(), crumple_vulkan_detach() or crumple_context_destroy().
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_STRUCT_SIZE,
/// CRUMPLE_ERROR_INVALID_ARGUMENT (no device of crumple_vulkan_open(), a handle that is none or not of memory, a memory type that
/// the buffer cannot lie in, a usage without STORAGE_BUFFER), CRUMPLE_ERROR_BUFFER_TOO_SMALL (the memory),
/// CRUMPLE_ERROR_UNSUPPORTED (a handle of another system, or a buffer that the device cannot import),
/// CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_VULKAN, CRUMPLE_ERROR_DEVICE_LOST, CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_vulkan_import_buffer(CrumpleContext *context,
                                           const CrumpleVulkanImportDef *def,
                                           uint64_t *out_buffer);

/// Forgets an imported buffer that no range is registered of, and waits until the device is done with it.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ARGUMENT (no device of
/// crumple_vulkan_open(), no such buffer, ranges of it are registered), CRUMPLE_ERROR_VULKAN, CRUMPLE_ERROR_DEVICE_LOST,
/// CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_vulkan_unimport_buffer(CrumpleContext *context,
                                             uint64_t buffer);

/// Makes a binary semaphore of your device, exported with the same type of handle, known to Crumple's own, and gives its number
/// for crumple_vulkan_submit(). It lives until crumple_vulkan_detach() or crumple_context_destroy().
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ARGUMENT (no
/// device of crumple_vulkan_open(), handle_type, a handle that is none or not of a semaphore), CRUMPLE_ERROR_UNSUPPORTED (a driver
/// without external semaphores: order by fences and crumple_vulkan_wait_frame() then), CRUMPLE_ERROR_VULKAN, CRUMPLE_ERROR_DEVICE_LOST,
/// CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_vulkan_import_semaphore(CrumpleContext *context,
                                              CrumpleHandleType handle_type,
                                              int64_t handle,
                                              uint64_t *out_semaphore);

/// What crumple_vulkan_record() is for a device of Crumple's own: records what brings Vulkan buffers up to date, and submits
/// that. count ids at buffers, each once; with null and 0 all of the context. The device waits for wait_count semaphores at
/// waits before and signals signal_count at signals after, also where nothing changed; nothing is waited for by this call.
/// out_frame gets the number of the frame, for crumple_vulkan_wait_frame(). out_frame and out_report may be null.
///
/// Externally synchronised. Errors: those of crumple_vulkan_record(), and CRUMPLE_ERROR_INVALID_ARGUMENT where there is no device
/// of crumple_vulkan_open(), or no such semaphore. Nothing was submitted then.
CrumpleResult crumple_vulkan_submit(CrumpleContext *context,
                                    const CrumpleBuffer *buffers,
                                    uint32_t count,
                                    const uint64_t *waits,
                                    uint32_t wait_count,
                                    const uint64_t *signals,
                                    uint32_t signal_count,
                                    uint64_t *out_frame,
                                    CrumpleRecordReport *out_report);

/// Waits until Crumple's own device is done with a frame of crumple_vulkan_submit() and all before it, or for timeout
/// nanoseconds (UINT64_MAX: as long as it takes). out_done tells whether it is done. The context is in use meanwhile.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ARGUMENT (no device of
/// crumple_vulkan_open(), a frame that was not submitted), CRUMPLE_ERROR_VULKAN, CRUMPLE_ERROR_DEVICE_LOST,
/// CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_vulkan_wait_frame(CrumpleContext *context, uint64_t frame, uint64_t timeout, bool *out_done);

/// Binds a point, m, in the mesh's space, to the surface nearest to it: it will keep its distance from the surface
/// and turn with it.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_NOT_FINITE, CRUMPLE_ERROR_INVALID_ARGUMENT (further off than 1e9 m), CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_example_set_attach_point(CrumpleContext *context,
                                               CrumpleExampleSet set,
                                               CrumpleVec3 point,
                                               CrumpleAttachment *out_attachment);

/// Tells where an attached point is on a dented instance, hits that wait among them. Touches no buffer and reads
/// none.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_INDEX_OUT_OF_RANGE and CRUMPLE_ERROR_NOT_FINITE (an attachment of another set, or none),
/// CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_instance_get_attached_frame(CrumpleContext *context,
                                                  CrumpleInstance instance,
                                                  const CrumpleAttachment *attachment,
                                                  CrumpleFrame *out_frame);

/// Begins to write what is called with this context to a file, so that it can be played again: "crumple replay FILE" makes the
/// same calls in the same order without your engine, tells whether every result and every vertex is the same, and is how a bug
/// that you see becomes a test that we can run. The file, path (UTF-8), is made new; it first gets what there is: the example
/// sets, whole, the instances with their damage, the buffers. It grows by some hundred bytes a hit and a frame, written at once,
/// so that a crash loses nothing. Every buffer is written whole by the next deform, as after crumple_buffer_invalidate().
///
/// What Vulkan calls write is not compared, but made on the CPU; calls that are refused, other than hits, are noted with their
/// message. Hits wait for each other and for calls that take them meanwhile, so leave it off in what you ship, or keep it for when a
/// player asks.
///
/// Externally synchronised; hits may arrive meanwhile. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_INVALID_ARGUMENT (path is not UTF-8; a recording runs already; an instance has open contacts: end them first),
/// CRUMPLE_ERROR_IO, CRUMPLE_ERROR_UNSUPPORTED (a big-endian processor), CRUMPLE_ERROR_OUT_OF_MEMORY,
/// CRUMPLE_ERROR_CONCURRENT_USE. Nothing is recorded then.
CrumpleResult crumple_recording_begin(CrumpleContext *context,
                                      const char *path);

/// Ends a recording: the file is whole. crumple_context_destroy() does so too.
///
/// Externally synchronised; hits may arrive meanwhile. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_INVALID_ARGUMENT (no recording runs), CRUMPLE_ERROR_IO (the file could not be written to its end: what is there
/// can be replayed; the recording has ended), CRUMPLE_ERROR_CONCURRENT_USE.
CrumpleResult crumple_recording_end(CrumpleContext *context);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CRUMPLE_H */
