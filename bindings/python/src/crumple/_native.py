# Generated from the headers in include by `cargo xtask header`; do not edit it. They document what is declared here.
import ctypes as c
from enum import IntEnum
from typing import Any

VERSION_MAJOR = 0
VERSION_MINOR = 2
VERSION_PATCH = 0
VERSION = (((VERSION_MAJOR * 1000000) + (VERSION_MINOR * 1000)) + VERSION_PATCH)
FEATURE_GLTF = 1
FEATURE_OBJ = 2
FEATURE_HOST_ALLOCATOR = 4
FEATURE_VULKAN = 8


class CrumpleResult(IntEnum):
    """The result of a call. See "Results" at the top."""

    OK = 0
    ERROR_INVALID_ARGUMENT = 1
    ERROR_NOT_FINITE = 2
    ERROR_INDEX_OUT_OF_RANGE = 3
    ERROR_MESH = 4
    ERROR_EXAMPLE_MISMATCH = 5
    ERROR_BUFFER_TOO_SMALL = 6
    ERROR_MISALIGNED = 7
    ERROR_CONTACT_TOO_FAR = 8
    ERROR_UNSUPPORTED = 9
    ERROR_FORMAT = 10
    ERROR_IO = 11
    ERROR_DAMAGE_MISMATCH = 12
    ERROR_OUT_OF_MEMORY = 13
    ERROR_WRONG_RULE = 14
    ERROR_VULKAN = 15
    ERROR_DEVICE_LOST = 16
    ERROR_UNKNOWN_CONTACT = 17
    ERROR_NULL_POINTER = 64
    ERROR_STRUCT_SIZE = 65
    ERROR_INVALID_ID = 66
    ERROR_CONCURRENT_USE = 67
    ERROR_INTERNAL = 68
    ERROR_FRAMES_IN_FLIGHT = 69


class CrumpleLogLevel(IntEnum):
    """The severity of a log message."""

    INFO = 0
    WARNING = 1


class CrumpleBytes(IntEnum):
    """Whether the bytes of a baked set are copied."""

    COPY = 0
    KEEP = 1


class CrumpleRule(IntEnum):
    """How hits damage an instance."""

    MARKS = 0
    MOST_DISPLACED = 1
    BLEND = 2


class CrumpleSelection(IntEnum):
    """How a classic rule selects the example for a hit."""

    CLASSIC = 0
    CLASSIC_UNCLAMPED = 1


class CrumpleHitKind(IntEnum):
    """How a hit is given."""

    BLOW = 0
    DISPLACEMENT = 1


class CrumpleSpace(IntEnum):
    """The space that a hit is given in."""

    LOCAL = 0
    WORLD = 1


class CrumpleStrikerShape(IntEnum):
    """The shape of what strikes, at the contact."""

    UNKNOWN = 0
    BALL = 1
    POLE = 2
    CORNER = 3
    WALL = 4


class CrumpleHitStatus(IntEnum):
    """What became of a hit."""

    MARKED = 0
    BELOW_YIELD = 1
    NOTHING_REACHES = 2
    ACCUMULATED = 3
    RIGID = 4


class CrumpleImpulses(IntEnum):
    """What the impulses of contact points mean, which differs among physics engines."""

    PER_POINT = 0
    WHOLE_AT_EVERY_POINT = 1
    ZERO_IS_UNKNOWN = 2


class CrumpleDirectionFormat(IntEnum):
    """The format of normals or tangents in memory of the CPU."""

    FLOAT = 0
    OCTAHEDRAL = 1


CrumpleLog = c.CFUNCTYPE(None, c.c_uint32, c.c_char_p, c.c_void_p)


CrumpleTask = c.CFUNCTYPE(None, c.c_uint32, c.c_void_p)


CrumpleParallelFor = c.CFUNCTYPE(None, c.c_uint32, CrumpleTask, c.c_void_p, c.c_void_p)


class CrumpleTaskSystem(c.Structure):
    _fields_ = [
        ("parallel_for", CrumpleParallelFor),
        ("user", c.c_void_p),
        ("workers", c.c_uint32),
    ]


class CrumpleContextDef(c.Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("threads", c.c_uint32),
        ("log", CrumpleLog),
        ("log_user", c.c_void_p),
        ("tasks", CrumpleTaskSystem),
    ]


class CrumpleExampleSet(c.Structure):
    _fields_ = [
        ("index", c.c_uint32),
        ("generation", c.c_uint16),
        ("context", c.c_uint16),
    ]


class CrumpleVec3(c.Structure):
    _fields_ = [
        ("x", c.c_float),
        ("y", c.c_float),
        ("z", c.c_float),
    ]


class CrumpleAabb(c.Structure):
    _fields_ = [
        ("min", CrumpleVec3),
        ("max", CrumpleVec3),
    ]


class CrumpleExampleSetInfo(c.Structure):
    _fields_ = [
        ("name", c.c_char_p),
        ("fingerprint", c.c_uint64),
        ("memory_bytes", c.c_uint64),
        ("vertex_count", c.c_uint32),
        ("triangle_count", c.c_uint32),
        ("example_count", c.c_uint32),
        ("primitive_count", c.c_uint32),
        ("seam_count", c.c_uint32),
        ("depth_limit", c.c_float),
        ("bounds", CrumpleAabb),
        ("node_transform", c.c_float * 16),
        ("has_tangents", c.c_bool),
        ("lod_count", c.c_uint32),
        ("blow_count", c.c_uint32),
        ("field_error", c.c_float),
        ("reserved", c.c_uint64 * 2),
    ]


class CrumpleStream(c.Structure):
    _fields_ = [
        ("data", c.c_void_p),
        ("size", c.c_size_t),
        ("offset", c.c_size_t),
        ("stride", c.c_size_t),
    ]


class CrumpleMeshCopyDef(c.Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("lod", c.c_uint32),
        ("positions", CrumpleStream),
        ("normals", CrumpleStream),
        ("tangents", CrumpleStream),
        ("indices", CrumpleStream),
    ]


class CrumpleInstanceDef(c.Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("mark_capacity", c.c_uint32),
        ("set", CrumpleExampleSet),
        ("user_data", c.c_uint64),
        ("rule", c.c_uint32),
        ("selection", c.c_uint32),
        ("depth_limit", c.c_float),
        ("yield_impulse", c.c_float),
        ("yield_displacement", c.c_float),
        ("max_contact_distance", c.c_float),
        ("blend_constant", c.c_float),
        ("compliance", c.c_float),
        ("grow_time", c.c_float),
        ("local_to_world", c.c_float * 16),
    ]


class CrumpleInstance(c.Structure):
    _fields_ = [
        ("index", c.c_uint32),
        ("generation", c.c_uint16),
        ("context", c.c_uint16),
    ]


class CrumpleInstanceInfo(c.Structure):
    _fields_ = [
        ("set", CrumpleExampleSet),
        ("memory_bytes", c.c_uint64),
        ("mark_count", c.c_uint32),
        ("buffer_count", c.c_uint32),
        ("depth_limit", c.c_float),
        ("contact_count", c.c_uint32),
        ("revision", c.c_uint64),
        ("reserved", c.c_uint32 * 2),
    ]


class CrumpleStriker(c.Structure):
    _fields_ = [
        ("mass", c.c_float),
        ("radius", c.c_float),
        ("velocity", CrumpleVec3),
        ("shape", c.c_uint32),
        ("reserved", c.c_uint32 * 2),
    ]


class CrumpleHitDef(c.Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("kind", c.c_uint32),
        ("space", c.c_uint32),
        ("point", CrumpleVec3),
        ("displacement", CrumpleVec3),
        ("impulse", CrumpleVec3),
        ("duration", c.c_float),
        ("mass", c.c_float),
        ("normal", CrumpleVec3),
        ("striker", CrumpleStriker),
        ("contact_id", c.c_uint64),
    ]


class CrumpleMark(c.Structure):
    _fields_ = [
        ("contact", c.c_uint32),
        ("depth", c.c_float),
        ("hits", c.c_uint64),
        ("told", c.c_uint16),
        ("striker", c.c_uint16),
        ("direction", c.c_uint16 * 2),
        ("strength", c.c_uint16),
        ("mass", c.c_uint16),
        ("radius", c.c_uint16),
        ("reserved", c.c_uint16),
    ]


class CrumpleHitResult(c.Structure):
    _fields_ = [
        ("status", c.c_uint32),
        ("contact_vertex", c.c_uint32),
        ("contact_distance", c.c_float),
        ("target", CrumpleVec3),
        ("achieved", CrumpleVec3),
        ("expected_error", c.c_float),
        ("clamped", c.c_bool),
        ("mark", CrumpleMark),
        ("reserved", c.c_uint32 * 7),
    ]


class CrumpleContactOptionsDef(c.Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("impulses", c.c_uint32),
        ("gain", c.c_float),
        ("min_speed", c.c_float),
        ("min_energy", c.c_float),
        ("dent_radius", c.c_float),
        ("touch_time", c.c_float),
        ("separation_time", c.c_float),
        ("max_points", c.c_uint32),
        ("max_touches", c.c_uint32),
    ]


class CrumpleContactPointDef(c.Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("has_velocity", c.c_bool),
        ("has_velocity_after", c.c_bool),
        ("pair", c.c_uint64),
        ("bodies", CrumpleInstance * 2),
        ("point", CrumpleVec3),
        ("normal", CrumpleVec3),
        ("velocity", CrumpleVec3),
        ("velocity_after", CrumpleVec3),
        ("impulse", c.c_float),
        ("masses", c.c_float * 2),
        ("inverse_mass", c.c_float),
        ("radii", c.c_float * 2),
        ("shapes", c.c_uint32 * 2),
        ("gain", c.c_float),
    ]


class CrumpleContactReport(c.Structure):
    _fields_ = [
        ("points", c.c_uint64),
        ("hits", c.c_uint64),
        ("begun", c.c_uint64),
        ("ended", c.c_uint64),
        ("open", c.c_uint64),
        ("slow", c.c_uint64),
        ("separating", c.c_uint64),
        ("weak", c.c_uint64),
        ("crowded", c.c_uint64),
        ("refused", c.c_uint64),
        ("refusal", c.c_uint32),
        ("reserved", c.c_uint32 * 3),
    ]


class CrumpleHostBufferDef(c.Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("lod", c.c_uint32),
        ("user_data", c.c_uint64),
        ("positions", CrumpleStream),
        ("normals", CrumpleStream),
        ("tangents", CrumpleStream),
        ("normal_format", c.c_uint32),
        ("tangent_format", c.c_uint32),
    ]


class CrumpleBuffer(c.Structure):
    _fields_ = [
        ("index", c.c_uint32),
        ("generation", c.c_uint16),
        ("context", c.c_uint16),
    ]


class CrumpleBufferInfo(c.Structure):
    _fields_ = [
        ("buffer", CrumpleBuffer),
        ("instance", CrumpleInstance),
        ("user_data", c.c_uint64),
        ("instance_user_data", c.c_uint64),
        ("lod", c.c_uint32),
        ("reserved", c.c_uint32 * 3),
    ]


class CrumpleDeformReport(c.Structure):
    _fields_ = [
        ("vertices_written", c.c_uint64),
        ("blocks_written", c.c_uint64),
        ("blocks_skipped", c.c_uint64),
        ("vertices_waiting", c.c_uint64),
        ("reserved", c.c_uint64 * 3),
    ]


class CrumpleRange(c.Structure):
    _fields_ = [
        ("first", c.c_uint32),
        ("count", c.c_uint32),
    ]


class CrumpleContactKind(IntEnum):
    """How an example's contact (the place where it was hit) is given."""

    NONE = 0
    VERTEX = 1
    POINT = 2


class CrumpleIndexType(IntEnum):
    """The type of triangle indices. CRUMPLE_INDEX_TYPE_U32 is the default."""

    U32 = 0
    U16 = 1


class CrumpleInput(c.Structure):
    _fields_ = [
        ("data", c.c_void_p),
        ("size", c.c_size_t),
        ("stride", c.c_size_t),
    ]


class CrumpleExampleDef(c.Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("delta_count", c.c_uint32),
        ("name", c.c_char_p),
        ("target_positions", CrumpleInput),
        ("target_normals", CrumpleInput),
        ("delta_indices", CrumpleInput),
        ("position_deltas", CrumpleInput),
        ("normal_deltas", CrumpleInput),
        ("contact_kind", c.c_uint32),
        ("contact_vertex", c.c_uint32),
        ("contact_point", CrumpleVec3),
        ("contact_normal", CrumpleVec3),
        ("impulse", CrumpleVec3),
        ("duration", c.c_float),
        ("striker", CrumpleStriker),
        ("has_contact_normal", c.c_bool),
    ]


class CrumpleMeshDef(c.Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("vertex_count", c.c_uint32),
        ("index_count", c.c_uint32),
        ("index_type", c.c_uint32),
        ("positions", CrumpleInput),
        ("normals", CrumpleInput),
        ("tangents", CrumpleInput),
        ("indices", CrumpleInput),
        ("depth_limits", CrumpleInput),
        ("stiffness", CrumpleInput),
    ]


class CrumpleExampleSetOptions(c.Structure):
    _fields_ = [
        ("depth_limit", c.c_float),
        ("drop_below", c.c_float),
        ("vertex_mass", c.c_float),
        ("basis_tolerance", c.c_float),
        ("bake_tolerance", c.c_float),
        ("bake_normal_tolerance", c.c_float),
        ("vertex_masses", CrumpleInput),
        ("mirror", c.c_bool),
        ("held_rims", c.c_bool),
        ("whole_examples", c.c_bool),
    ]


class CrumpleExampleSetDef(c.Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("example_count", c.c_uint32),
        ("mesh", c.POINTER(CrumpleMeshDef)),
        ("examples", c.POINTER(CrumpleExampleDef)),
        ("options", CrumpleExampleSetOptions),
    ]


class CrumpleCapsule(c.Structure):
    _fields_ = [
        ("a", CrumpleVec3),
        ("b", CrumpleVec3),
        ("radius", c.c_float),
    ]


class CrumpleExampleInfo(c.Structure):
    _fields_ = [
        ("name", c.c_char_p),
        ("contact_vertex", c.c_uint32),
        ("moved_vertices", c.c_uint32),
        ("contact_point", CrumpleVec3),
        ("contact_normal", CrumpleVec3),
        ("depth", c.c_float),
        ("max_depth", c.c_float),
        ("support_radius", c.c_float),
        ("field_error", c.c_float),
        ("reserved", c.c_uint64),
    ]


class CrumpleDamageMapping(c.Structure):
    _fields_ = [
        ("kept", c.c_uint32),
        ("moved", c.c_uint32),
        ("too_far", c.c_uint32),
        ("without_blows", c.c_uint32),
        ("distance", c.c_float),
        ("reserved", c.c_uint32 * 3),
    ]


class CrumplePartKind(IntEnum):
    """What a part of a body does when it is hit."""

    DENTS = 0
    RIGID = 1
    GLASS = 2


class CrumpleGltfDef(c.Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("mesh_index", c.c_uint32),
        ("mesh_name", c.c_char_p),
        ("path", c.c_char_p),
        ("join_nodes", c.c_bool),
        ("unit", c.c_float),
        ("nodes", c.c_char_p),
        ("targets", c.c_char_p),
        ("rigid", c.c_char_p),
        ("glass", c.c_char_p),
        ("moving", c.c_char_p),
        ("options", CrumpleExampleSetOptions),
    ]


class CrumpleObjDef(c.Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("example_count", c.c_uint32),
        ("base_path", c.c_char_p),
        ("example_paths", c.POINTER(c.c_char_p)),
        ("options", CrumpleExampleSetOptions),
    ]


class CrumplePrimitive(c.Structure):
    _fields_ = [
        ("material", c.c_char_p),
        ("first_vertex", c.c_uint32),
        ("vertex_count", c.c_uint32),
        ("first_triangle", c.c_uint32),
        ("triangle_count", c.c_uint32),
        ("reserved", c.c_uint32 * 2),
    ]


class CrumplePart(c.Structure):
    _fields_ = [
        ("name", c.c_char_p),
        ("kind", c.c_uint32),
        ("first_vertex", c.c_uint32),
        ("vertex_count", c.c_uint32),
        ("first_triangle", c.c_uint32),
        ("triangle_count", c.c_uint32),
        ("reserved", c.c_uint32 * 3),
    ]


class CrumpleAttachment(c.Structure):
    _fields_ = [
        ("vertices", c.c_uint32 * 3),
        ("weights", c.c_float * 3),
        ("point", CrumpleVec3),
        ("reserved", c.c_uint32 * 3),
    ]


class CrumpleQuat(c.Structure):
    _fields_ = [
        ("x", c.c_float),
        ("y", c.c_float),
        ("z", c.c_float),
        ("w", c.c_float),
    ]


class CrumplePose(c.Structure):
    _fields_ = [
        ("position", CrumpleVec3),
        ("rotation", CrumpleQuat),
        ("reserved", c.c_uint32 * 5),
    ]


class CrumpleContactHit(c.Structure):
    _fields_ = [
        ("pair", c.c_uint64),
        ("contact_id", c.c_uint64),
        ("instance", CrumpleInstance),
        ("point", CrumpleVec3),
        ("impulse", CrumpleVec3),
        ("result", CrumpleHitResult),
    ]


CrumpleAlloc = c.CFUNCTYPE(c.c_void_p, c.c_size_t, c.c_size_t, c.c_void_p)


CrumpleFree = c.CFUNCTYPE(None, c.c_void_p, c.c_size_t, c.c_size_t, c.c_void_p)


class CrumpleAllocatorDef(c.Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("alloc", CrumpleAlloc),
        ("free", CrumpleFree),
        ("user", c.c_void_p),
    ]


class CrumpleHandleType(IntEnum):
    """The type of a handle to shared memory or to a semaphore."""

    OPAQUE_FD = 0
    OPAQUE_WIN32 = 1


CrumpleVulkanFunction = c.CFUNCTYPE(None)


class CrumpleVulkanAttachDef(c.Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("queue_family", c.c_uint32),
        ("get_instance_proc_addr", CrumpleVulkanFunction),
        ("instance", c.c_void_p),
        ("physical_device", c.c_void_p),
        ("device", c.c_void_p),
        ("pipeline_cache", c.c_void_p),
        ("pipeline_cache_size", c.c_size_t),
        ("workgroup_size", c.c_uint32),
    ]


class CrumpleVulkanStream(c.Structure):
    _fields_ = [
        ("offset", c.c_uint64),
        ("stride", c.c_uint64),
        ("format", c.c_uint32),
        ("reserved", c.c_uint32),
    ]


class CrumpleVulkanBufferDef(c.Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("lod", c.c_uint32),
        ("user_data", c.c_uint64),
        ("buffer", c.c_uint64),
        ("buffer_size", c.c_uint64),
        ("usage", c.c_uint32),
        ("queue_family", c.c_uint32),
        ("before_stages", c.c_uint32),
        ("before_access", c.c_uint32),
        ("after_stages", c.c_uint32),
        ("after_access", c.c_uint32),
        ("offset", c.c_uint64),
        ("size", c.c_uint64),
        ("positions", CrumpleVulkanStream),
        ("normals", CrumpleVulkanStream),
        ("tangents", CrumpleVulkanStream),
        ("scale", CrumpleVec3),
        ("bias", CrumpleVec3),
    ]


class CrumpleRecordReport(c.Structure):
    _fields_ = [
        ("vertices_written", c.c_uint64),
        ("blocks_written", c.c_uint64),
        ("blocks_skipped", c.c_uint64),
        ("bytes_copied", c.c_uint64),
        ("dispatches", c.c_uint32),
        ("reserved0", c.c_uint32),
        ("vertices_waiting", c.c_uint64),
        ("reserved", c.c_uint64 * 3),
    ]


class CrumpleVulkanOpenDef(c.Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("workgroup_size", c.c_uint32),
        ("get_instance_proc_addr", CrumpleVulkanFunction),
        ("device_uuid", c.c_uint8 * 16),
        ("pipeline_cache", c.c_void_p),
        ("pipeline_cache_size", c.c_size_t),
    ]


class CrumpleVulkanImportDef(c.Structure):
    _fields_ = [
        ("struct_size", c.c_uint32),
        ("handle_type", c.c_uint32),
        ("handle", c.c_int64),
        ("memory_size", c.c_uint64),
        ("memory_type", c.c_uint32),
        ("usage", c.c_uint32),
        ("offset", c.c_uint64),
        ("size", c.c_uint64),
        ("dedicated", c.c_bool),
    ]


class CrumpleGraphUpload(c.Structure):
    _fields_ = [
        ("storage", c.c_uint32),
        ("reserved", c.c_uint32),
        ("storage_size", c.c_uint64),
        ("offset", c.c_uint64),
        ("data", c.c_void_p),
        ("size", c.c_size_t),
    ]


class CrumpleGraphDispatch(c.Structure):
    _fields_ = [
        ("kernel", c.c_uint32),
        ("storage", c.c_uint32),
        ("buffer", c.c_uint64),
        ("groups", c.c_uint32 * 2),
        ("constants", c.c_uint32 * 8),
    ]


class CrumpleGraphPlan(c.Structure):
    _fields_ = [
        ("freed", c.POINTER(c.c_uint32)),
        ("uploads", c.POINTER(CrumpleGraphUpload)),
        ("dispatches", c.POINTER(CrumpleGraphDispatch)),
        ("work", c.c_void_p),
        ("work_size", c.c_size_t),
        ("freed_count", c.c_uint32),
        ("upload_count", c.c_uint32),
        ("dispatch_count", c.c_uint32),
        ("reserved", c.c_uint32),
    ]


FUNCTIONS: dict[str, tuple[Any, list[Any]]] = {
    "crumple_version": (c.c_uint32, []),
    "crumple_version_string": (c.c_char_p, []),
    "crumple_features": (c.c_uint64, []),
    "crumple_last_error": (c.c_char_p, []),
    "crumple_result_name": (c.c_char_p, [c.c_uint32]),
    "crumple_context_def_default": (CrumpleContextDef, []),
    "crumple_context_create": (c.c_uint32, [c.POINTER(CrumpleContextDef), c.POINTER(c.c_void_p)]),
    "crumple_context_destroy": (c.c_uint32, [c.c_void_p]),
    "crumple_example_set_load_baked_memory": (c.c_uint32, [c.c_void_p, c.c_void_p, c.c_size_t, c.c_uint32, c.POINTER(CrumpleExampleSet)]),
    "crumple_example_set_load_baked": (c.c_uint32, [c.c_void_p, c.c_char_p, c.POINTER(CrumpleExampleSet)]),
    "crumple_example_set_is_valid": (c.c_bool, [c.c_void_p, CrumpleExampleSet]),
    "crumple_example_set_destroy": (c.c_uint32, [c.c_void_p, CrumpleExampleSet]),
    "crumple_example_set_get_info": (c.c_uint32, [c.c_void_p, CrumpleExampleSet, c.POINTER(CrumpleExampleSetInfo)]),
    "crumple_mesh_copy_def_default": (CrumpleMeshCopyDef, []),
    "crumple_example_set_copy_mesh": (c.c_uint32, [c.c_void_p, CrumpleExampleSet, c.POINTER(CrumpleMeshCopyDef)]),
    "crumple_instance_def_default": (CrumpleInstanceDef, []),
    "crumple_instance_create": (c.c_uint32, [c.c_void_p, c.POINTER(CrumpleInstanceDef), c.POINTER(CrumpleInstance)]),
    "crumple_instance_destroy": (c.c_uint32, [c.c_void_p, CrumpleInstance]),
    "crumple_instance_is_valid": (c.c_bool, [c.c_void_p, CrumpleInstance]),
    "crumple_instance_set_user_data": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.c_uint64]),
    "crumple_instance_get_user_data": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.POINTER(c.c_uint64)]),
    "crumple_instance_get_info": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.POINTER(CrumpleInstanceInfo)]),
    "crumple_instance_set_transform": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.POINTER(c.c_float)]),
    "crumple_instance_set_depth_limit": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.c_float]),
    "crumple_hit_def_default": (CrumpleHitDef, []),
    "crumple_instance_submit_hit": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.POINTER(CrumpleHitDef), c.POINTER(CrumpleHitResult)]),
    "crumple_context_submit_hits": (c.c_uint32, [c.c_void_p, c.POINTER(CrumpleInstance), c.POINTER(CrumpleHitDef), c.c_uint32, c.POINTER(CrumpleHitResult)]),
    "crumple_instance_preview_hit": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.POINTER(CrumpleHitDef), c.POINTER(CrumpleHitResult)]),
    "crumple_contact_options_def_default": (CrumpleContactOptionsDef, []),
    "crumple_context_set_contact_options": (c.c_uint32, [c.c_void_p, c.POINTER(CrumpleContactOptionsDef)]),
    "crumple_contact_point_def_default": (CrumpleContactPointDef, []),
    "crumple_context_report_contacts": (c.c_uint32, [c.c_void_p, c.POINTER(CrumpleContactPointDef), c.c_uint32]),
    "crumple_context_step_contacts": (c.c_uint32, [c.c_void_p, c.c_float, c.POINTER(CrumpleContactReport)]),
    "crumple_context_clear_contacts": (c.c_uint32, [c.c_void_p]),
    "crumple_instance_get_marks": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.POINTER(CrumpleMark), c.c_uint32, c.POINTER(c.c_uint32)]),
    "crumple_instance_set_marks": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.POINTER(CrumpleMark), c.c_uint32]),
    "crumple_instance_save_damage": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.c_void_p, c.c_size_t, c.POINTER(c.c_size_t)]),
    "crumple_instance_load_damage": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.c_void_p, c.c_size_t]),
    "crumple_context_save_damage": (c.c_uint32, [c.c_void_p, c.POINTER(CrumpleInstance), c.c_uint32, c.c_void_p, c.c_size_t, c.POINTER(c.c_size_t)]),
    "crumple_context_load_damage": (c.c_uint32, [c.c_void_p, c.POINTER(CrumpleInstance), c.c_uint32, c.c_void_p, c.c_size_t]),
    "crumple_instance_repair_damage": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.c_float]),
    "crumple_instance_repair_around": (c.c_uint32, [c.c_void_p, CrumpleInstance, CrumpleVec3, c.c_float, c.c_float]),
    "crumple_instance_reset_damage": (c.c_uint32, [c.c_void_p, CrumpleInstance]),
    "crumple_instance_copy_damage": (c.c_uint32, [c.c_void_p, CrumpleInstance, CrumpleInstance]),
    "crumple_host_buffer_def_default": (CrumpleHostBufferDef, []),
    "crumple_buffer_register_host": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.POINTER(CrumpleHostBufferDef), c.POINTER(CrumpleBuffer)]),
    "crumple_buffer_unregister": (c.c_uint32, [c.c_void_p, CrumpleBuffer]),
    "crumple_buffer_is_valid": (c.c_bool, [c.c_void_p, CrumpleBuffer]),
    "crumple_buffer_get_info": (c.c_uint32, [c.c_void_p, CrumpleBuffer, c.POINTER(CrumpleBufferInfo)]),
    "crumple_buffer_invalidate": (c.c_uint32, [c.c_void_p, CrumpleBuffer]),
    "crumple_buffer_set_memory": (c.c_uint32, [c.c_void_p, CrumpleBuffer, c.POINTER(CrumpleHostBufferDef)]),
    "crumple_context_deform": (c.c_uint32, [c.c_void_p, c.POINTER(CrumpleBuffer), c.c_uint32, c.POINTER(CrumpleDeformReport)]),
    "crumple_context_get_changed_buffers": (c.c_uint32, [c.c_void_p, c.POINTER(CrumpleBufferInfo), c.c_uint32, c.POINTER(c.c_uint32)]),
    "crumple_buffer_get_changes": (c.c_uint32, [c.c_void_p, CrumpleBuffer, c.POINTER(CrumpleRange), c.c_uint32, c.POINTER(c.c_uint32), c.POINTER(CrumpleAabb)]),
    "crumple_example_def_default": (CrumpleExampleDef, []),
    "crumple_example_set_def_default": (CrumpleExampleSetDef, []),
    "crumple_example_set_create": (c.c_uint32, [c.c_void_p, c.POINTER(CrumpleExampleSetDef), c.POINTER(CrumpleExampleSet)]),
    "crumple_mesh_def_default": (CrumpleMeshDef, []),
    "crumple_example_set_add_lod": (c.c_uint32, [c.c_void_p, CrumpleExampleSet, c.POINTER(CrumpleMeshDef), c.POINTER(c.c_uint32)]),
    "crumple_example_set_save_baked": (c.c_uint32, [c.c_void_p, CrumpleExampleSet, c.c_void_p, c.c_size_t, c.POINTER(c.c_size_t)]),
    "crumple_mesh_keep_out": (c.c_uint32, [c.POINTER(CrumpleMeshDef), c.POINTER(CrumpleCapsule), c.c_uint32, c.POINTER(CrumpleMeshDef), c.c_uint32, c.POINTER(c.c_float)]),
    "crumple_example_set_get_example": (c.c_uint32, [c.c_void_p, CrumpleExampleSet, c.c_uint32, c.POINTER(CrumpleExampleInfo)]),
    "crumple_example_set_map_damage": (c.c_uint32, [c.c_void_p, CrumpleExampleSet, CrumpleExampleSet, c.c_void_p, c.c_size_t, c.c_float, c.c_void_p, c.c_size_t, c.POINTER(c.c_size_t), c.POINTER(CrumpleDamageMapping)]),
    "crumple_gltf_def_default": (CrumpleGltfDef, []),
    "crumple_example_set_load_gltf": (c.c_uint32, [c.c_void_p, c.POINTER(CrumpleGltfDef), c.POINTER(CrumpleExampleSet)]),
    "crumple_example_set_load_gltf_memory": (c.c_uint32, [c.c_void_p, c.c_void_p, c.c_size_t, c.POINTER(CrumpleGltfDef), c.POINTER(CrumpleExampleSet)]),
    "crumple_obj_def_default": (CrumpleObjDef, []),
    "crumple_example_set_load_obj": (c.c_uint32, [c.c_void_p, c.POINTER(CrumpleObjDef), c.POINTER(CrumpleExampleSet)]),
    "crumple_example_set_get_primitive": (c.c_uint32, [c.c_void_p, CrumpleExampleSet, c.c_uint32, c.POINTER(CrumplePrimitive)]),
    "crumple_example_set_find_part": (c.c_uint32, [c.c_void_p, CrumpleExampleSet, c.c_char_p, c.POINTER(c.c_uint32)]),
    "crumple_example_set_get_part": (c.c_uint32, [c.c_void_p, CrumpleExampleSet, c.c_uint32, c.POINTER(CrumplePart)]),
    "crumple_instance_release_part": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.c_uint32, c.POINTER(CrumpleInstance)]),
    "crumple_instance_mount_part": (c.c_uint32, [c.c_void_p, CrumpleInstance, CrumpleInstance, c.c_bool]),
    "crumple_instance_set_part_rigid": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.c_uint32, c.c_bool]),
    "crumple_instance_measure_part": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.c_uint32, c.POINTER(c.c_float), c.POINTER(c.c_float), c.POINTER(c.c_float)]),
    "crumple_example_set_attach_point": (c.c_uint32, [c.c_void_p, CrumpleExampleSet, CrumpleVec3, c.POINTER(CrumpleAttachment)]),
    "crumple_instance_get_attached_pose": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.POINTER(CrumpleAttachment), c.POINTER(CrumplePose)]),
    "crumple_example_set_find_nearest_vertex": (c.c_uint32, [c.c_void_p, CrumpleExampleSet, CrumpleVec3, c.POINTER(c.c_uint32), c.POINTER(c.c_float)]),
    "crumple_buffer_get_changed_triangles": (c.c_uint32, [c.c_void_p, CrumpleBuffer, c.POINTER(CrumpleRange), c.c_uint32, c.POINTER(c.c_uint32), c.POINTER(CrumpleAabb)]),
    "crumple_instance_end_contact": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.c_uint64]),
    "crumple_instance_get_contact": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.c_uint64, c.POINTER(CrumpleHitResult)]),
    "crumple_context_get_contact_hits": (c.c_uint32, [c.c_void_p, c.POINTER(CrumpleContactHit), c.c_uint32, c.POINTER(c.c_uint32)]),
    "crumple_context_get_contact_totals": (c.c_uint32, [c.c_void_p, c.POINTER(CrumpleContactReport)]),
    "crumple_context_set_time": (c.c_uint32, [c.c_void_p, c.c_double]),
    "crumple_instance_set_view": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.c_float, c.c_float, c.c_float, c.c_float, c.POINTER(c.c_uint32)]),
    "crumple_context_set_vertex_budget": (c.c_uint32, [c.c_void_p, c.c_uint64]),
    "crumple_allocator_def_default": (CrumpleAllocatorDef, []),
    "crumple_allocator_set": (c.c_uint32, [c.POINTER(CrumpleAllocatorDef)]),
    "crumple_example_set_share": (c.c_uint32, [c.c_void_p, CrumpleExampleSet, c.c_void_p, c.POINTER(CrumpleExampleSet)]),
    "crumple_vulkan_attach_def_default": (CrumpleVulkanAttachDef, []),
    "crumple_vulkan_attach": (c.c_uint32, [c.c_void_p, c.POINTER(CrumpleVulkanAttachDef)]),
    "crumple_vulkan_detach": (c.c_uint32, [c.c_void_p]),
    "crumple_vulkan_get_pipeline_cache": (c.c_uint32, [c.c_void_p, c.c_void_p, c.c_size_t, c.POINTER(c.c_size_t)]),
    "crumple_vulkan_buffer_def_default": (CrumpleVulkanBufferDef, []),
    "crumple_buffer_register_vulkan": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.POINTER(CrumpleVulkanBufferDef), c.POINTER(CrumpleBuffer)]),
    "crumple_vulkan_record": (c.c_uint32, [c.c_void_p, c.c_void_p, c.c_uint64, c.POINTER(CrumpleBuffer), c.c_uint32, c.POINTER(CrumpleRecordReport)]),
    "crumple_vulkan_complete_frames": (c.c_uint32, [c.c_void_p, c.c_uint64]),
    "crumple_vulkan_discard_frames": (c.c_uint32, [c.c_void_p, c.c_uint64]),
    "crumple_vulkan_open_def_default": (CrumpleVulkanOpenDef, []),
    "crumple_vulkan_open": (c.c_uint32, [c.c_void_p, c.POINTER(CrumpleVulkanOpenDef)]),
    "crumple_vulkan_import_def_default": (CrumpleVulkanImportDef, []),
    "crumple_vulkan_import_buffer": (c.c_uint32, [c.c_void_p, c.POINTER(CrumpleVulkanImportDef), c.POINTER(c.c_uint64)]),
    "crumple_vulkan_unimport_buffer": (c.c_uint32, [c.c_void_p, c.c_uint64]),
    "crumple_vulkan_import_semaphore": (c.c_uint32, [c.c_void_p, c.c_uint32, c.c_int64, c.POINTER(c.c_uint64)]),
    "crumple_vulkan_submit": (c.c_uint32, [c.c_void_p, c.POINTER(CrumpleBuffer), c.c_uint32, c.POINTER(c.c_uint64), c.c_uint32, c.POINTER(c.c_uint64), c.c_uint32, c.POINTER(c.c_uint64), c.POINTER(CrumpleRecordReport)]),
    "crumple_vulkan_wait_frame": (c.c_uint32, [c.c_void_p, c.c_uint64, c.c_uint64, c.POINTER(c.c_bool)]),
    "crumple_graph_get_kernel": (c.c_uint32, [c.c_uint32, c.c_void_p, c.c_size_t, c.POINTER(c.c_size_t)]),
    "crumple_buffer_register_graph": (c.c_uint32, [c.c_void_p, CrumpleInstance, c.POINTER(CrumpleVulkanBufferDef), c.POINTER(CrumpleBuffer)]),
    "crumple_graph_plan": (c.c_uint32, [c.c_void_p, c.POINTER(CrumpleBuffer), c.c_uint32, c.POINTER(CrumpleGraphPlan), c.POINTER(CrumpleRecordReport)]),
}


def declare(library: Any) -> None:
    """Tells ctypes the results and parameters of every function of the library."""
    for name, (result, parameters) in FUNCTIONS.items():
        function = getattr(library, name)
        function.restype = result
        function.argtypes = parameters
