// What only C can say wrongly: pointers, addresses, sizes, strides, ids, enumerators and texts. Of wrong values there is one of each kind,
// since tests/bad_input.rs has the others. Each has its result and its text, writes no output, and leaves the context usable.
#include "support.h"

#include <crumple_contacts.h>
#include <crumple_import.h>
#include <crumple_parts.h>

#include <float.h>

static Sheet sheet;
static CrumpleContext *context, *second;
static CrumpleExampleSet set;
static CrumpleInstance body;
static CrumpleBuffer buffer;
static float vertices[VERTICES][3];

// The context is as good as ever.
static void usable(void) {
    static float last;
    CrumpleHitDef hit = displacement_at(0.1f, 0.1f, 0.03f);
    CrumpleHitResult told;
    CrumpleDeformReport report;
    OK(crumple_instance_submit_hit(context, body, &hit, &told));
    FACT(told.status == CRUMPLE_HIT_STATUS_MARKED);
    OK(crumple_context_deform(context, &buffer, 1, &report));
    FACT(report.vertices_written > 0 && isfinite(vertices[told.contact_vertex][2]));
    OK(crumple_instance_reset_damage(context, body));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    FACT(last == 0 || last == vertices[told.contact_vertex][2]);
    last = vertices[told.contact_vertex][2];
}

#define BAD(expected, part, call) (FAILS(CRUMPLE_ERROR_##expected, part, call), usable())
#define BAD_KEEPING(expected, part, output, call)                                                                      \
    do {                                                                                                               \
        FAILS_KEEPING(CRUMPLE_ERROR_##expected, part, output, call);                                                   \
        usable();                                                                                                      \
    } while (0)

// An address that is not a multiple of four.
static void *crooked(void *pointer) {
    return (char *)pointer + 1;
}

// A number that is no enumerator.
#define SET_ENUM(field, number)                                                                                        \
    do {                                                                                                               \
        uint32_t number_ = (number);                                                                                   \
        memcpy(&(field), &number_, 4);                                                                                 \
    } while (0)

// A byte that is neither of the two.
#define SET_BOOL(field, number) memset(&(field), (number), 1)

static void contexts(void) {
    CrumpleContextDef def = crumple_context_def_default();
    CrumpleContext *out;
    BAD_KEEPING(NULL_POINTER, "def is null", out, crumple_context_create(NULL, &out));
    BAD(NULL_POINTER, "out_context is null", crumple_context_create(&def, NULL));
    BAD_KEEPING(MISALIGNED, "def", out, crumple_context_create(crooked(&def), &out));
    def.struct_size = 0;
    BAD_KEEPING(STRUCT_SIZE, "crumple_context_def_default", out, crumple_context_create(&def, &out));
    def.struct_size = sizeof def + 8;
    BAD_KEEPING(STRUCT_SIZE, "def.struct_size", out, crumple_context_create(&def, &out));
    def = crumple_context_def_default();
    def.threads = 1025;
    BAD_KEEPING(INVALID_ARGUMENT, "1025", out, crumple_context_create(&def, &out));
    BAD(NULL_POINTER, "context is null", crumple_context_destroy(NULL));
    CrumpleContext *gone = make_context(1);
    OK(crumple_context_destroy(gone));
    BAD(INVALID_ID, "destroyed", crumple_context_destroy(gone));
    BAD(INVALID_ID, "destroyed", crumple_context_deform(gone, NULL, 0, NULL));
    BAD(INVALID_ID, "never created", crumple_context_deform((CrumpleContext *)(void *)&def, NULL, 0, NULL));
}

static CrumpleExampleSet out_set;

static void bad_set(CrumpleResult expected, const char *part, const CrumpleExampleSetDef *def) {
    FAILS_KEEPING(expected, part, out_set, crumple_example_set_create(context, def, &out_set));
    usable();
}

#define BAD_SET(expected, part, change)                                                                                \
    do {                                                                                                               \
        CrumpleExampleSetDef def = sheet.def;                                                                          \
        CrumpleMeshDef mesh = sheet.mesh;                                                                              \
        CrumpleExampleDef example = sheet.examples[0];                                                                 \
        def.mesh = &mesh;                                                                                              \
        def.examples = &example;                                                                                       \
        def.example_count = 1;                                                                                         \
        change;                                                                                                        \
        bad_set(CRUMPLE_ERROR_##expected, part, &def);                                                                 \
    } while (0)

static void meshes(void) {
    BAD_SET(STRUCT_SIZE, "def.struct_size is 12", def.struct_size = 12);
    BAD_KEEPING(NULL_POINTER, "def is null", out_set, crumple_example_set_create(context, NULL, &out_set));
    BAD(NULL_POINTER, "out_set is null", crumple_example_set_create(context, &sheet.def, NULL));
    BAD_KEEPING(NULL_POINTER, "context is null", out_set, crumple_example_set_create(NULL, &sheet.def, &out_set));
    BAD_SET(STRUCT_SIZE, "def.mesh.struct_size is 4; it must be", mesh.struct_size = 4);
    BAD_SET(NULL_POINTER, "def.mesh is null", def.mesh = NULL);
    BAD_SET(NULL_POINTER, "def.mesh.positions", mesh.positions = input_of(NULL, 0, 0));
    BAD_SET(NULL_POINTER, "def.mesh.normals.data is null", mesh.normals.data = NULL);
    BAD_SET(MISALIGNED, "def.mesh.positions.data", mesh.positions.data = crooked(sheet.positions));
    BAD_SET(MISALIGNED, "def.mesh.normals.stride is 13", mesh.normals.stride = 13);
    BAD_SET(INVALID_ARGUMENT, "def.mesh.positions.stride is 8", mesh.positions.stride = 8);
    BAD_SET(INVALID_ARGUMENT, "0 never means tightly packed", mesh.tangents.stride = 0);
    BAD_SET(BUFFER_TOO_SMALL, "def.mesh.positions", mesh.positions.size -= 1);
    BAD_SET(BUFFER_TOO_SMALL, "def.mesh.positions", mesh.vertex_count = UINT32_MAX);
    BAD_SET(BUFFER_TOO_SMALL, "def.mesh.positions", mesh.positions.stride = SIZE_MAX & ~(size_t)3);
    BAD_SET(INVALID_ARGUMENT, "past the end of memory", mesh.positions.size = SIZE_MAX);
    static float limits[VERTICES];
    BAD_SET(BUFFER_TOO_SMALL, "def.mesh.depth_limits", mesh.depth_limits = input_of(limits, sizeof limits - 4, 4));
    BAD_SET(BUFFER_TOO_SMALL, "def.mesh.stiffness", mesh.stiffness = input_of(limits, sizeof limits - 4, 4));
    // Solids that dents must not enter.
    CrumpleCapsule capsule = {vec3(0, 0, 0), vec3(0, 0, 1), 0.1f};
    memset(limits, 0xAB, sizeof limits);
    BAD(NULL_POINTER, "mesh is null", crumple_mesh_keep_out(NULL, &capsule, 1, NULL, 0, limits));
    BAD(NULL_POINTER, "capsules is null", crumple_mesh_keep_out(&sheet.mesh, NULL, 1, NULL, 0, limits));
    BAD(NULL_POINTER, "out_limits is null", crumple_mesh_keep_out(&sheet.mesh, &capsule, 1, NULL, 0, NULL));
    CrumpleMeshDef solid = sheet.mesh;
    solid.positions.data = NULL;
    solid.positions.size = 0;
    BAD(NULL_POINTER, "meshes[0].positions", crumple_mesh_keep_out(&sheet.mesh, NULL, 0, &solid, 1, limits));
    solid.struct_size = 0;
    BAD(STRUCT_SIZE, "meshes[0].struct_size is 0", crumple_mesh_keep_out(&sheet.mesh, NULL, 0, &solid, 1, limits));
    FACT(keeps(limits, sizeof limits));
    // Triangles.
    BAD_SET(INVALID_ARGUMENT, "multiple of 3", mesh.index_count -= 1);
    BAD_SET(BUFFER_TOO_SMALL, "def.mesh.indices", mesh.index_count += 3);
    BAD_SET(NULL_POINTER, "def.mesh.indices", mesh.indices = input_of(NULL, 0, 0));
    BAD_SET(INVALID_ARGUMENT, "def.mesh.index_type is 9", SET_ENUM(mesh.index_type, 9));
    static uint16_t narrow[INDICES];
    for (int i = 0; i < INDICES; ++i) narrow[i] = (uint16_t)sheet.indices[i];
    BAD_SET(MISALIGNED, "def.mesh.indices.data", (mesh.index_type = CRUMPLE_INDEX_TYPE_U16, mesh.indices = input_of(crooked(narrow), sizeof narrow - 2, 2)));
    BAD_SET(MISALIGNED, "def.mesh.indices.stride is 3", (mesh.index_type = CRUMPLE_INDEX_TYPE_U16, mesh.indices = input_of(narrow, sizeof narrow, 3)));
    BAD_SET(BUFFER_TOO_SMALL, "def.mesh.indices", mesh.indices = input_of(narrow, sizeof narrow, 4));
    // Numbers that are none, in an array, in options and in an example, and one out of range.
    float held = sheet.targets[0][80][0];
    sheet.targets[0][80][0] = NAN;
    BAD_SET(NOT_FINITE, "target_positions[80]", (void)0);
    sheet.targets[0][80][0] = held;
    BAD_SET(NOT_FINITE, "def.options.depth_limit", def.options.depth_limit = NAN);
    BAD_SET(NOT_FINITE, "contact_point", (example.contact_kind = CRUMPLE_CONTACT_KIND_POINT, example.contact_point.y = NAN));
    BAD_SET(NOT_FINITE, "contact_normal", (example.has_contact_normal = true, example.contact_normal.y = NAN));
    BAD_SET(INVALID_ARGUMENT, "def.examples[0].striker.mass is -3", example.striker.mass = -3);
    BAD_SET(INVALID_ARGUMENT, "def.options.vertex_mass is -2", def.options.vertex_mass = -2);
    static float masses[VERTICES];
    for (int v = 0; v < VERTICES; ++v) masses[v] = 1;
    BAD_SET(BUFFER_TOO_SMALL, "vertex_masses", def.options.vertex_masses = input_of(masses, sizeof masses - 4, 4));
    BAD_SET(INVALID_ARGUMENT, "one of the two", (def.options.vertex_mass = 1, def.options.vertex_masses = input_of(masses, sizeof masses, 4)));
    // Any byte but 0 is true; each of the two is another set.
    uint64_t prints[4];
    for (int i = 0; i < 4; ++i) {
        CrumpleExampleSetDef odd = sheet.def;
        CrumpleExampleSetInfo info;
        CrumpleExampleSet made;
        SET_BOOL(odd.options.mirror, i == 1 ? 0 : i == 3 ? 0xAB : 1);
        SET_BOOL(odd.options.held_rims, i == 2 ? 0 : i == 3 ? 0x02 : 1);
        OK(crumple_example_set_create(context, &odd, &made));
        OK(crumple_example_set_get_info(context, made, &info));
        prints[i] = info.fingerprint;
        OK(crumple_example_set_destroy(context, made));
    }
    FACT(prints[0] == prints[3] && prints[0] != prints[1] && prints[0] != prints[2] && prints[1] != prints[2]);
}

static void examples(void) {
    static uint32_t indices[4] = {3, 10, 11, 500};
    static float deltas[4][3] = {{0, 0, -0.1f}, {0, 0, -0.1f}, {0, 0, -0.2f}, {0, 0, -0.1f}};
    CrumpleInput none = input_of(NULL, 0, 0);
    BAD_SET(EXAMPLE_MISMATCH, "example", def.example_count = 0);
    BAD_SET(NULL_POINTER, "def.examples is null", def.examples = NULL);
    BAD_SET(MISALIGNED, "def.examples", def.examples = crooked(&example));
    BAD_SET(STRUCT_SIZE, "def.examples[0].struct_size is 3", example.struct_size = 3);
    BAD_SET(NULL_POINTER, "neither target_positions nor", example.target_positions = none);
    BAD_SET(BUFFER_TOO_SMALL, "def.examples[0].target_positions", example.target_positions.size -= 12); // another vertex count
    BAD_SET(INVALID_ARGUMENT, "name is not UTF-8", example.name = "\xc3(");
    BAD_SET(INVALID_ARGUMENT, "def.examples[0].contact_kind is 5", SET_ENUM(example.contact_kind, 5));
    BAD_SET(INVALID_ARGUMENT, "needs the base mesh's normals", (example.target_normals = example.target_positions, mesh.normals = none));
    BAD_SET(INVALID_ARGUMENT, "one of the two forms", (example.delta_indices = input_of(indices, sizeof indices, 4), example.delta_count = 4));
#define SPARSE(change)                                                                                                 \
    (example.target_positions = none, example.delta_count = 4, example.delta_indices = input_of(indices, sizeof indices, 4), \
     example.position_deltas = input_of(deltas, sizeof deltas, 12), (void)(change))
    BAD_SET(NULL_POINTER, "the sparse form needs both", SPARSE(example.position_deltas = none));
    BAD_SET(NULL_POINTER, "the sparse form needs both", SPARSE(example.delta_indices = none));
    BAD_SET(BUFFER_TOO_SMALL, "def.examples[0].delta_indices", SPARSE(example.delta_count = 5));
    BAD_SET(INVALID_ARGUMENT, "target_normals belongs to the full form", SPARSE(example.target_normals = sheet.mesh.normals));
    BAD_SET(INVALID_ARGUMENT, "normal_deltas belongs to the sparse form", (example.delta_count = 4, example.normal_deltas = input_of(deltas, sizeof deltas, 12)));
    deltas[1][2] = NAN;
    BAD_SET(NOT_FINITE, "def.examples[0].position_deltas[1]", SPARSE(0));
    deltas[1][2] = -0.1f;
    usable();
}

// A set may be destroyed while an instance uses it; its id is stale then.
static void destroyed_sets(void) {
    CrumpleInstance one;
    CrumpleHitDef hit = displacement_at(0, 0, 0.04f);
    CrumpleHostBufferDef buffer_def = crumple_host_buffer_def_default();
    CrumpleBuffer its;
    CrumpleAttachment lamp;
    CrumpleInstanceDef again = crumple_instance_def_default();
    static float out[VERTICES][3];
    CrumpleExampleDef unnamed = sheet.examples[0];
    CrumpleExampleSetDef def = sheet.def;
    unnamed.name = NULL;
    def.examples = &unnamed;
    def.example_count = 1;
    OK(crumple_example_set_create(context, &def, &out_set));
    one = make_instance(context, out_set);
    buffer_def.positions = stream_of(out, sizeof out, 0, 12);
    OK(crumple_buffer_register_host(context, one, &buffer_def, &its));
    OK(crumple_example_set_destroy(context, out_set));
    OK(crumple_instance_submit_hit(context, one, &hit, NULL));
    OK(crumple_context_deform(context, &its, 1, NULL));
    again.set = out_set;
    BAD(INVALID_ID, "def.set is stale", crumple_instance_create(context, &again, &one));
    BAD_KEEPING(INVALID_ID, "set is stale", lamp, crumple_example_set_attach_point(context, out_set, vec3(0, 0, 0), &lamp));
    OK(crumple_buffer_unregister(context, its));
}

static void infos(void) {
    CrumpleExampleSetInfo info;
    CrumpleExampleInfo example;
    CrumplePrimitive primitive;
    CrumpleMeshCopyDef copy = crumple_mesh_copy_def_default();
    CrumpleAttachment lamp;
    CrumplePose frame;
    uint32_t vertex;
    float distance;
    static float out[VERTICES][4];
    static uint32_t triangles[INDICES];
    BAD(NULL_POINTER, "out_info", crumple_example_set_get_info(context, set, NULL));
    BAD_KEEPING(MISALIGNED, "out_info", info, crumple_example_set_get_info(context, set, crooked(&info)));
    BAD_KEEPING(INDEX_OUT_OF_RANGE, "example is 3; it must be below 3", example, crumple_example_set_get_example(context, set, 3, &example));
    BAD_KEEPING(INDEX_OUT_OF_RANGE, "primitive is 1", primitive, crumple_example_set_get_primitive(context, set, 1, &primitive));
    OK(crumple_example_set_find_nearest_vertex(context, set, vec3(0, 0, 0), NULL, NULL));
    memset(&distance, 0xAB, 4);
    BAD_KEEPING(NOT_FINITE, "point", vertex, crumple_example_set_find_nearest_vertex(context, set, vec3(0, NAN, 0), &vertex, &distance));
    FACT(keeps(&distance, 4));
    OK(crumple_example_set_attach_point(context, set, vec3(0, 0, 0), &lamp));
    BAD_KEEPING(NULL_POINTER, "attachment is null", frame, crumple_instance_get_attached_pose(context, body, NULL, &frame));
    CrumpleAttachment zeroed;
    memset(&zeroed, 0, sizeof zeroed);
    BAD_KEEPING(INVALID_ARGUMENT, "weights sum to 0", frame, crumple_instance_get_attached_pose(context, body, &zeroed, &frame));
    lamp.vertices[1] = VERTICES;
    BAD_KEEPING(INDEX_OUT_OF_RANGE, "attachment", frame, crumple_instance_get_attached_pose(context, body, &lamp, &frame));

    memset(out, 0xAB, sizeof out);
    memset(triangles, 0xAB, sizeof triangles);
    copy.struct_size = 0;
    BAD(STRUCT_SIZE, "crumple_mesh_copy_def_default", crumple_example_set_copy_mesh(context, set, &copy));
    copy = crumple_mesh_copy_def_default();
    OK(crumple_example_set_copy_mesh(context, set, &copy));
    copy.positions = stream_of(out, sizeof out, 0, 16);
    copy.indices = stream_of(triangles, sizeof triangles - 4, 0, 4);
    BAD(BUFFER_TOO_SMALL, "def.indices", crumple_example_set_copy_mesh(context, set, &copy));
    copy.indices = stream_of(triangles, sizeof triangles, 0, 4);
    copy.positions = stream_of(triangles, sizeof triangles, 0, 12);
    BAD(INVALID_ARGUMENT, "overlap", crumple_example_set_copy_mesh(context, set, &copy));
    FACT(keeps(out, sizeof out) && keeps(triangles, sizeof triangles));
}

static void ids(void) {
    CrumpleInstance null = {0, 0, 0}, invented = {77, 1, body.context}, gone = make_instance(context, set), foreign, wrong;
    CrumpleExampleSet foreign_set, null_set = {0, 0, 0};
    CrumpleBuffer null_buffer = {0, 0, 0};
    CrumpleInstanceDef def = crumple_instance_def_default();
    CrumpleInstanceInfo info;
    OK(crumple_instance_destroy(context, gone));
    OK(crumple_example_set_create(second, &sheet.def, &foreign_set));
    foreign = make_instance(second, foreign_set);
    wrong = body;
    wrong.generation += 1;
    BAD(INVALID_ID, "null instance", crumple_instance_reset_damage(context, null));
    BAD(INVALID_ID, "never was", crumple_instance_reset_damage(context, invented));
    BAD(INVALID_ID, "never was", crumple_instance_reset_damage(context, wrong));
    BAD(INVALID_ID, "stale", crumple_instance_reset_damage(context, gone));
    BAD(INVALID_ID, "another context", crumple_instance_reset_damage(context, foreign));
    BAD_KEEPING(INVALID_ID, "another context", info, crumple_instance_get_info(context, foreign, &info));
    BAD(INVALID_ID, "stale", crumple_instance_destroy(context, gone));
    BAD(INVALID_ID, "stale", crumple_instance_copy_damage(context, body, gone));
    BAD(INVALID_ID, "stale", crumple_instance_copy_damage(context, gone, body));
    BAD(INVALID_ID, "another context", crumple_instance_copy_damage(context, body, foreign));
    BAD(INVALID_ID, "null example set", crumple_example_set_destroy(context, null_set));
    BAD(INVALID_ID, "another context", crumple_example_set_destroy(context, foreign_set));
    BAD(INVALID_ID, "null buffer", crumple_buffer_unregister(context, null_buffer));
    BAD(INVALID_ID, "buffers[0]", crumple_context_deform(context, &null_buffer, 1, NULL));
    BAD_KEEPING(INVALID_ID, "def.set is the null example set", wrong, crumple_instance_create(context, &def, &wrong));
    def.set = foreign_set;
    BAD_KEEPING(INVALID_ID, "def.set is an id of another context", wrong, crumple_instance_create(context, &def, &wrong));
    // A place that was used again keeps its former ids apart.
    CrumpleInstance next = make_instance(context, set);
    FACT(next.index == gone.index && next.generation == gone.generation + 1);
    BAD(INVALID_ID, "stale", crumple_instance_reset_damage(context, gone));
    OK(crumple_instance_destroy(context, next));
    OK(crumple_instance_destroy(second, foreign));
    OK(crumple_example_set_destroy(second, foreign_set));
}

#define BAD_INSTANCE(expected, part, change)                                                                           \
    do {                                                                                                               \
        CrumpleInstanceDef def = crumple_instance_def_default();                                                       \
        CrumpleInstance out;                                                                                           \
        def.set = set;                                                                                                 \
        change;                                                                                                        \
        BAD_KEEPING(expected, part, out, crumple_instance_create(context, &def, &out));                                \
    } while (0)

static void instances(void) {
    BAD_INSTANCE(STRUCT_SIZE, "crumple_instance_def_default", def.struct_size = 4);
    BAD_INSTANCE(INVALID_ARGUMENT, "def.rule is 3", SET_ENUM(def.rule, 3));
    BAD_INSTANCE(INVALID_ARGUMENT, "def.selection is 2", SET_ENUM(def.selection, 2));
    BAD_INSTANCE(INVALID_ARGUMENT, "capacity", def.mark_capacity = 0);
    BAD_INSTANCE(INVALID_ARGUMENT, "def.depth_limit is -0.5", def.depth_limit = -0.5f);
    BAD_INSTANCE(INVALID_ARGUMENT, "transpose", def.local_to_world[3] = 1);
    BAD_INSTANCE(NOT_FINITE, "def.yield_impulse", def.yield_impulse = NAN);
    BAD_INSTANCE(NOT_FINITE, "def.local_to_world", def.local_to_world[13] = NAN);
    BAD(NOT_FINITE, "depth_limit", crumple_instance_set_depth_limit(context, body, NAN));
    BAD(NOT_FINITE, "keep", crumple_instance_repair_damage(context, body, NAN));
    float matrix[17] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    BAD(NULL_POINTER, "local_to_world", crumple_instance_set_transform(context, body, NULL));
    BAD(MISALIGNED, "local_to_world", crumple_instance_set_transform(context, body, crooked(matrix)));
    matrix[10] = NAN;
    BAD(NOT_FINITE, "local_to_world", crumple_instance_set_transform(context, body, matrix));
}

#define BAD_IMPULSE(expected, part, change)                                                                            \
    do {                                                                                                               \
        CrumpleHitDef def = crumple_hit_def_default();                                                         \
        def.impulse = vec3(0, 0, -1);                                                                                  \
        def.duration = 0.01f;                                                                                          \
        def.mass = 1;                                                                                                  \
        change;                                                                                                        \
        BAD_KEEPING(expected, part, told, crumple_instance_submit_hit(context, body, &def, &told));                         \
    } while (0)

static void hits(void) {
    CrumpleHitResult told;
    CrumpleHitDef push = displacement_at(0, 0, 0.01f);
    BAD_KEEPING(NULL_POINTER, "def is null", told, crumple_instance_submit_hit(context, body, NULL, &told));
    BAD(MISALIGNED, "out_result", crumple_instance_submit_hit(context, body, &push, crooked(&told)));
    BAD_IMPULSE(STRUCT_SIZE, "crumple_hit_def_default", def.struct_size += 4);
    BAD_IMPULSE(INVALID_ARGUMENT, "def.space is 2", SET_ENUM(def.space, 2));
    BAD_IMPULSE(INVALID_ARGUMENT, "def.kind is 2", SET_ENUM(def.kind, 2));
    BAD_IMPULSE(INVALID_ARGUMENT, "def.mass is -1", def.mass = -1);
    BAD_IMPULSE(CONTACT_TOO_FAR, "max_contact_distance", def.point = vec3(FLT_MAX, -FLT_MAX, FLT_MAX));
    BAD_IMPULSE(NOT_FINITE, "def.normal", def.normal.y = NAN);
    BAD_IMPULSE(NOT_FINITE, "def.point", (def.contact_id = 1, def.point.x = NAN));
    push = displacement_at(0, 0, 0.01f);
    push.struct_size = 0;
    BAD_KEEPING(STRUCT_SIZE, "crumple_hit_def_default", told, crumple_instance_submit_hit(context, body, &push, &told));
    BAD_KEEPING(NULL_POINTER, "context is null", told, crumple_instance_submit_hit(NULL, body, &push, &told));

    BAD(INVALID_ARGUMENT, "contact_id is 0", crumple_instance_end_contact(context, body, 0));
    BAD(NULL_POINTER, "context is null", crumple_instance_end_contact(NULL, body, 1));
}

static void damage(void) {
    CrumpleHitDef hit = displacement_at(0.1f, 0.1f, 0.03f), other_hit = displacement_at(-0.2f, 0.2f, 0.02f);
    CrumpleMark marks[4], bad;
    CrumpleExampleSet other_set;
    CrumpleInstance other;
    unsigned char bytes[512], changed[512];
    uint32_t count;
    size_t size;
    OK(crumple_instance_submit_hit(context, body, &hit, NULL));
    OK(crumple_instance_submit_hit(context, body, &other_hit, NULL));
    memset(marks, 0xAB, sizeof marks);
    FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "marks has room for 1; 2 are needed", crumple_instance_get_marks(context, body, marks, 1, &count));
    FACT(count == 2); // what is needed
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "marks is null", count, crumple_instance_get_marks(context, body, NULL, 2, &count));
    FAILS_KEEPING(CRUMPLE_ERROR_MISALIGNED, "marks", count, crumple_instance_get_marks(context, body, crooked(marks), 3, &count));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "out_count", crumple_instance_get_marks(context, body, marks, 4, NULL));
    FACT(keeps(marks, sizeof marks));
    memset(bytes, 0xAB, sizeof bytes);
    FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "96 are needed", crumple_instance_save_damage(context, body, bytes, 95, &size));
    FACT(size == 96);
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "data is null", size, crumple_instance_save_damage(context, body, NULL, 96, &size));
    FACT(keeps(bytes, sizeof bytes));
    OK(crumple_instance_get_marks(context, body, marks, 4, &count));
    OK(crumple_instance_save_damage(context, body, bytes, sizeof bytes, &size));
    FACT(count == 2 && size == 96);

    bad = marks[0];
    bad.contact = VERTICES;
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "contact", crumple_instance_set_marks(context, body, &bad, 1));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "marks", crumple_instance_set_marks(context, body, NULL, 1));
    FAILS(CRUMPLE_ERROR_MISALIGNED, "marks", crumple_instance_set_marks(context, body, crooked(marks), 1));

    // Saved bytes: nothing behind the given size is read.
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "data is null", crumple_instance_load_damage(context, body, NULL, 96));
    unsigned char *cut = malloc(size - 1);
    memcpy(cut, bytes, size - 1);
    FAILS(CRUMPLE_ERROR_DAMAGE_MISMATCH, "saved damage", crumple_instance_load_damage(context, body, cut, size - 1));
    free(cut);
    OK(crumple_instance_save_damage(context, body, changed, sizeof changed, &size));
    FACT(size == 96 && memcmp(bytes, changed, size) == 0); // nothing has changed so far
    OK(crumple_instance_reset_damage(context, body));
    CrumpleExampleSetDef def = sheet.def;
    def.example_count = 2;
    OK(crumple_example_set_create(context, &def, &other_set));
    other = make_instance(context, other_set);
    FAILS(CRUMPLE_ERROR_DAMAGE_MISMATCH, "example set", crumple_instance_load_damage(context, other, bytes, size));
    // Mapped to a changed set.
    CrumpleDamageMapping mapping;
    memset(changed, 0xAB, sizeof changed);
    BAD(INVALID_ID, "null example set", crumple_example_set_map_damage(context, other_set, (CrumpleExampleSet){0}, bytes, size, 0, changed, sizeof changed, &size, NULL));
    FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "mapped has room for 95",
          crumple_example_set_map_damage(context, set, set, bytes, size, 0, changed, 95, &size, &mapping));
    FACT(size == 96 && keeps(changed, sizeof changed));
    OK(crumple_example_set_map_damage(context, other_set, set, bytes, size, INFINITY, changed, sizeof changed, &size, &mapping));
    FACT(mapping.kept == 2 && mapping.moved + mapping.too_far + mapping.without_blows == 0 && mapping.distance == 0);
    OK(crumple_instance_load_damage(context, other, changed, size));
    OK(crumple_instance_destroy(context, other));
    OK(crumple_example_set_destroy(context, other_set));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    usable();
}

#define BAD_BUFFER(expected, part, change)                                                                             \
    do {                                                                                                               \
        CrumpleHostBufferDef def = crumple_host_buffer_def_default();                                                  \
        CrumpleBuffer out;                                                                                             \
        def.positions = stream_of(memory, sizeof memory, 0, 40);                                                       \
        def.normals = stream_of(memory, sizeof memory, 12, 40);                                                        \
        def.tangents = stream_of(memory, sizeof memory, 24, 40);                                                       \
        change;                                                                                                        \
        BAD_KEEPING(expected, part, out, crumple_buffer_register_host(context, body, &def, &out));                     \
        BAD(expected, part, crumple_buffer_set_memory(context, buffer, &def));                                    \
    } while (0)

static void buffers(void) {
    static float memory[VERTICES][10];
    CrumpleBuffer twice[3] = {buffer, buffer, buffer}, same;
    CrumpleDeformReport report;
    CrumpleAabb bounds;
    CrumpleRange ranges[1];
    uint32_t count;
    memset(memory, 0xAB, sizeof memory);
    BAD_BUFFER(STRUCT_SIZE, "crumple_host_buffer_def_default", def.struct_size = 0);
    BAD_BUFFER(NULL_POINTER, "def.positions", def.positions = stream_of(NULL, 0, 0, 0));
    BAD_BUFFER(NULL_POINTER, "def.normals.data is null", def.normals.data = NULL);
    BAD_BUFFER(MISALIGNED, "def.positions.data", def.positions.data = crooked(memory));
    BAD_BUFFER(MISALIGNED, "def.normals.offset is 10", def.normals.offset = 10);
    BAD_BUFFER(INVALID_ARGUMENT, "def.normals.stride is 0 bytes", def.normals.stride = 0);
    BAD_BUFFER(BUFFER_TOO_SMALL, "def.tangents", def.tangents.size -= 1);
    BAD_BUFFER(BUFFER_TOO_SMALL, "def.positions", def.positions.offset = SIZE_MAX & ~(size_t)3);
    BAD_BUFFER(BUFFER_TOO_SMALL, "def.positions", def.positions.stride = SIZE_MAX & ~(size_t)3);
    BAD_BUFFER(INVALID_ARGUMENT, "def.normals and def.positions overlap", def.normals.offset = 8);
    BAD_BUFFER(INVALID_ARGUMENT, "def.normal_format is 2", def.normal_format = (CrumpleDirectionFormat)2);
    BAD_BUFFER(INVALID_ARGUMENT, "def.tangent_format is 7", def.tangent_format = (CrumpleDirectionFormat)7);
    BAD_KEEPING(NULL_POINTER, "def is null", same, crumple_buffer_register_host(context, body, NULL, &same));
    FACT(keeps(memory, sizeof memory));

    // Of a mesh without tangents, and without anything.
    CrumpleExampleSetDef def = sheet.def;
    CrumpleMeshDef mesh = sheet.mesh;
    CrumpleHostBufferDef buffer_def = crumple_host_buffer_def_default();
    def.mesh = &mesh;
    mesh.tangents = mesh.normals = mesh.indices = input_of(NULL, 0, 0);
    mesh.index_count = 0;
    OK(crumple_example_set_create(context, &def, &out_set));
    CrumpleInstance bare = make_instance(context, out_set);
    buffer_def.positions = stream_of(memory, sizeof memory, 0, 40);
    buffer_def.normals = stream_of(memory, sizeof memory, 12, 40);
    BAD_KEEPING(MESH, "normals", same, crumple_buffer_register_host(context, bare, &buffer_def, &same));
    buffer_def.normals = stream_of(NULL, 0, 0, 0);
    CrumpleBuffer points;
    OK(crumple_buffer_register_host(context, bare, &buffer_def, &points));
    FAILS_KEEPING(CRUMPLE_ERROR_MESH, "no triangles; give it indices", count, crumple_buffer_get_changed_triangles(context, points, NULL, 0, &count, NULL));
    OK(crumple_instance_destroy(context, bare));
    OK(crumple_example_set_destroy(context, out_set));

    // Deforming.
    BAD_KEEPING(INVALID_ARGUMENT, "twice", report, crumple_context_deform(context, twice, 3, &report));
    BAD_KEEPING(NULL_POINTER, "buffers is null", report, crumple_context_deform(context, NULL, 1, &report));
    BAD_KEEPING(MISALIGNED, "buffers", report, crumple_context_deform(context, crooked(twice), 1, &report));
    BAD(MISALIGNED, "out_report", crumple_context_deform(context, &buffer, 1, crooked(&report)));
    OK(crumple_context_deform(context, twice, 0, &report)); // none
    FACT(report.vertices_written == 0 && report.blocks_skipped == 0);
    memset(&bounds, 0xAB, sizeof bounds);
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "ranges is null", count, crumple_buffer_get_changes(context, buffer, NULL, 1, &count, &bounds));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "out_count is null", crumple_buffer_get_changes(context, buffer, ranges, 1, NULL, &bounds));
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "ranges is null", count, crumple_buffer_get_changed_triangles(context, buffer, NULL, 1, &count, &bounds));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "out_count is null", crumple_buffer_get_changed_triangles(context, buffer, ranges, 1, NULL, &bounds));
    FACT(keeps(&bounds, sizeof bounds));
    usable();
}

int main(void) {
    make_sheet(&sheet);
    context = make_context(2);
    second = make_context(1);
    OK(crumple_example_set_create(context, &sheet.def, &set));
    body = make_instance(context, set);
    CrumpleHostBufferDef def = crumple_host_buffer_def_default();
    def.positions = stream_of(vertices, sizeof vertices, 0, 12);
    OK(crumple_buffer_register_host(context, body, &def, &buffer));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    usable();
    contexts();
    meshes();
    examples();
    destroyed_sets();
    infos();
    ids();
    instances();
    hits();
    damage();
    buffers();
    OK(crumple_context_destroy(second));
    OK(crumple_context_destroy(context));
    printf("%u checks\n", checks);
    return 0;
}
