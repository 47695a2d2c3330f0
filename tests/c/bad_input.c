// What only C can say wrongly: pointers, addresses, sizes, strides, ids, enumerators and texts; of wrong numbers there is one for each
// way in which they are read. tests/bad_input.rs has the others, tests/gpu/refusals.rs those of buffers of devices. Each is refused with its
// result and a text that names it, writes no output, and leaves the context usable.
#include "support.h"

#include <crumple_contacts.h>
#include <crumple_graph.h>
#include <crumple_host.h>
#include <crumple_import.h>
#include <crumple_parts.h>
#include <crumple_view.h>

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
static void *crooked(void *pointer) { return (char *)pointer + 1; }

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
    def.struct_size = sizeof def + 8;
    BAD_KEEPING(STRUCT_SIZE, "crumple_context_def_default", out, crumple_context_create(&def, &out));
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
    BAD_KEEPING(NULL_POINTER, "def is null", out_set, crumple_example_set_create(context, NULL, &out_set));
    BAD(NULL_POINTER, "out_set is null", crumple_example_set_create(context, &sheet.def, NULL));
    BAD_SET(STRUCT_SIZE, "def.struct_size is 12", def.struct_size = 12);
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
    BAD_SET(INVALID_ARGUMENT, "past the end of memory", mesh.positions.size = SIZE_MAX);
    // Triangles.
    BAD_SET(INVALID_ARGUMENT, "multiple of 3", mesh.index_count -= 1);
    BAD_SET(NULL_POINTER, "def.mesh.indices", mesh.indices = input_of(NULL, 0, 0));
    BAD_SET(INVALID_ARGUMENT, "def.mesh.index_type is 9", SET_ENUM(mesh.index_type, 9));
    BAD_SET(MISALIGNED, "def.mesh.indices.data", (mesh.index_type = CRUMPLE_INDEX_TYPE_U16, mesh.indices = input_of(crooked(sheet.indices), 2 * INDICES, 2)));
    // Numbers: in an array, in options and in an example.
    float held = sheet.targets[0][80][0];
    sheet.targets[0][80][0] = NAN;
    BAD_SET(NOT_FINITE, "target_positions[80]", (void)0);
    sheet.targets[0][80][0] = held;
    BAD_SET(INVALID_ARGUMENT, "def.options.vertex_mass is -2", def.options.vertex_mass = -2);
    BAD_SET(INVALID_ARGUMENT, "one of the two", (def.options.vertex_mass = 1, def.options.vertex_masses = input_of(vertices, sizeof vertices, 4)));
    // Any byte but 0 is true; each of the two is another set.
    uint64_t prints[4];
    for (int i = 0; i < 4; ++i) {
        CrumpleExampleSetDef odd = sheet.def;
        CrumpleExampleSetInfo info;
        SET_BOOL(odd.options.mirror, i == 1 ? 0 : i == 3 ? 0xAB : 1);
        SET_BOOL(odd.options.held_rims, i == 2 ? 0 : i == 3 ? 0x02 : 1);
        OK(crumple_example_set_create(context, &odd, &out_set));
        OK(crumple_example_set_get_info(context, out_set, &info));
        prints[i] = info.fingerprint;
        OK(crumple_example_set_destroy(context, out_set));
    }
    FACT(prints[0] == prints[3] && prints[0] != prints[1] && prints[0] != prints[2] && prints[1] != prints[2]);
}

static void examples(void) {
    static uint32_t indices[4] = {3, 10, 11, 500};
    static float deltas[4][3] = {{0, 0, -0.1f}, {0, 0, NAN}};
    CrumpleInput none = input_of(NULL, 0, 0), sparse = input_of(indices, sizeof indices, 4), full = sheet.examples[0].target_positions;
    BAD_SET(EXAMPLE_MISMATCH, "example", def.example_count = 0);
    BAD_SET(NULL_POINTER, "def.examples is null", def.examples = NULL);
    BAD_SET(MISALIGNED, "def.examples", def.examples = crooked(&example));
    BAD_SET(STRUCT_SIZE, "def.examples[0].struct_size is 3", example.struct_size = 3);
    BAD_SET(NULL_POINTER, "neither target_positions nor", example.target_positions = none);
    BAD_SET(BUFFER_TOO_SMALL, "def.examples[0].target_positions", example.target_positions.size -= 12); // another vertex count
    BAD_SET(INVALID_ARGUMENT, "name is not UTF-8", example.name = "\xc3(");
    BAD_SET(INVALID_ARGUMENT, "def.examples[0].contact_kind is 5", SET_ENUM(example.contact_kind, 5));
    BAD_SET(INVALID_ARGUMENT, "needs the base mesh's normals", (example.target_normals = full, mesh.normals = none));
    BAD_SET(INVALID_ARGUMENT, "one of the two forms", (example.delta_indices = sparse, example.delta_count = 4));
#define SPARSE(change)                                                                                                 \
    (example.target_positions = none, example.delta_count = 4, example.delta_indices = sparse,                         \
     example.position_deltas = input_of(deltas, sizeof deltas, 12), (void)(change))
    BAD_SET(NULL_POINTER, "the sparse form needs both", SPARSE(example.position_deltas = none));
    BAD_SET(NOT_FINITE, "def.examples[0].position_deltas[1]", SPARSE(0));
}

static void sets(void) {
    static float out[VERTICES][4], limits[VERTICES];
    static uint32_t triangles[INDICES];
    CrumpleExampleSetInfo info;
    CrumpleExampleInfo example;
    CrumplePrimitive primitive;
    CrumpleMeshDef mesh = sheet.mesh;
    CrumpleMeshCopyDef copy = crumple_mesh_copy_def_default();
    CrumpleAttachment lamp;
    CrumplePose frame;
    CrumpleCapsule capsule = {vec3(0, 0, 0), vec3(0, 0, 1), 0.1f};
    uint32_t number;
    BAD(NULL_POINTER, "out_info", crumple_example_set_get_info(context, set, NULL));
    BAD_KEEPING(MISALIGNED, "out_info", info, crumple_example_set_get_info(context, set, crooked(&info)));
    BAD_KEEPING(INDEX_OUT_OF_RANGE, "example is 3; it must be below 3", example, crumple_example_set_get_example(context, set, 3, &example));
    BAD_KEEPING(INDEX_OUT_OF_RANGE, "primitive is 1", primitive, crumple_example_set_get_primitive(context, set, 1, &primitive));
    BAD_KEEPING(NOT_FINITE, "point", lamp, crumple_example_set_attach_point(context, set, vec3(NAN, 0, 0), &lamp));
    BAD_KEEPING(NULL_POINTER, "attachment is null", frame, crumple_instance_get_attached_pose(context, body, NULL, &frame));

    memset(out, 0xAB, sizeof out);
    memset(triangles, 0xAB, sizeof triangles);
    copy.struct_size = 0;
    BAD(STRUCT_SIZE, "crumple_mesh_copy_def_default", crumple_example_set_copy_mesh(context, set, &copy));
    copy = crumple_mesh_copy_def_default();
    OK(crumple_example_set_copy_mesh(context, set, &copy));
    copy.lod = 1;
    BAD(INDEX_OUT_OF_RANGE, "below 1", crumple_example_set_copy_mesh(context, set, &copy));
    copy.lod = 0;
    copy.positions = stream_of(out, sizeof out, 0, 16);
    copy.indices = stream_of(triangles, sizeof triangles - 4, 0, 4);
    BAD(BUFFER_TOO_SMALL, "def.indices", crumple_example_set_copy_mesh(context, set, &copy));
    copy.indices = stream_of(triangles, sizeof triangles, 0, 4);
    copy.positions = stream_of(triangles, sizeof triangles, 0, 12);
    BAD(INVALID_ARGUMENT, "overlap", crumple_example_set_copy_mesh(context, set, &copy));
    FACT(keeps(out, sizeof out) && keeps(triangles, sizeof triangles));

    // Levels of detail, and solids that dents must not enter.
    BAD(NULL_POINTER, "out_lod", crumple_example_set_add_lod(context, set, &mesh, NULL));
    BAD_KEEPING(INVALID_ARGUMENT, "before the first instance", number, crumple_example_set_add_lod(context, set, &mesh, &number));
    memset(limits, 0xAB, sizeof limits);
    BAD(NULL_POINTER, "mesh is null", crumple_mesh_keep_out(NULL, &capsule, 1, NULL, 0, limits));
    BAD(NULL_POINTER, "out_limits is null", crumple_mesh_keep_out(&mesh, &capsule, 1, NULL, 0, NULL));
    mesh.positions = input_of(NULL, 0, 0);
    BAD(NULL_POINTER, "meshes[0].positions", crumple_mesh_keep_out(&sheet.mesh, NULL, 0, &mesh, 1, limits));
    FACT(keeps(limits, sizeof limits));
}

static void ids(void) {
    CrumpleInstance null = {0, 0, 0}, invented = {77, 1, body.context}, gone = make_instance(context, set), foreign, out;
    CrumpleExampleSet foreign_set, null_set = {0, 0, 0};
    CrumpleBuffer null_buffer = {0, 0, 0}, its;
    CrumpleInstanceDef def = crumple_instance_def_default();
    CrumpleInstanceInfo info;
    OK(crumple_instance_destroy(context, gone));
    OK(crumple_example_set_create(second, &sheet.def, &foreign_set));
    foreign = make_instance(second, foreign_set);
    BAD(INVALID_ID, "null instance", crumple_instance_reset_damage(context, null));
    BAD(INVALID_ID, "never was", crumple_instance_reset_damage(context, invented));
    BAD(INVALID_ID, "stale", crumple_instance_reset_damage(context, gone));
    BAD(INVALID_ID, "stale", crumple_instance_copy_damage(context, gone, body));
    BAD(INVALID_ID, "another context", crumple_instance_copy_damage(context, body, foreign));
    BAD_KEEPING(INVALID_ID, "another context", info, crumple_instance_get_info(context, foreign, &info));
    BAD(INVALID_ID, "another context", crumple_example_set_destroy(context, foreign_set));
    BAD_KEEPING(INVALID_ID, "another context", out_set, crumple_example_set_share(context, foreign_set, second, &out_set));
    BAD_KEEPING(INVALID_ARGUMENT, "context itself", out_set, crumple_example_set_share(context, set, context, &out_set));
    BAD_KEEPING(NULL_POINTER, "context", out_set, crumple_example_set_share(context, set, NULL, &out_set));
    BAD(INVALID_ID, "buffers[0]", crumple_context_deform(context, &null_buffer, 1, NULL));
    BAD_KEEPING(INVALID_ID, "def.set is the null example set", out, crumple_instance_create(context, &def, &out));
    def.set = foreign_set;
    BAD_KEEPING(INVALID_ID, "def.set is an id of another context", out, crumple_instance_create(context, &def, &out));
    // A set may be destroyed while an instance uses it; its id is stale then.
    OK(crumple_example_set_create(context, &sheet.def, &def.set));
    CrumpleInstance user = make_instance(context, def.set);
    OK(crumple_example_set_destroy(context, def.set));
    BAD_KEEPING(INVALID_ID, "def.set is stale", out, crumple_instance_create(context, &def, &out));
    // A place that was used again keeps its former ids apart, and a body takes its buffers along.
    FACT(user.index == gone.index && user.generation == gone.generation + 1);
    its = make_buffer(context, user, host_def(sheet.targets[1], VERTICES, 3));
    OK(crumple_context_deform(context, &its, 1, NULL));
    OK(crumple_instance_destroy(context, user));
    BAD(INVALID_ID, "stale", crumple_context_deform(context, &its, 1, NULL));
    OK(crumple_instance_destroy(second, foreign));
    OK(crumple_example_set_destroy(second, foreign_set));

    // What is valid; asking changes no error.
    FACT(crumple_example_set_is_valid(context, set) && crumple_instance_is_valid(context, body) && crumple_buffer_is_valid(context, buffer));
    FACT(!crumple_example_set_is_valid(context, null_set) && !crumple_instance_is_valid(context, null));
    FACT(!crumple_buffer_is_valid(context, null_buffer) && !crumple_instance_is_valid(NULL, body));
    FACT(!crumple_buffer_is_valid(context, its) && !crumple_instance_is_valid(context, user));
    FAILS(CRUMPLE_ERROR_UNKNOWN_CONTACT, "contact_id is 5", crumple_instance_end_contact(context, body, 5));
    FACT(!crumple_instance_is_valid(context, gone) && strstr(crumple_last_error(), "contact_id is 5"));
}

#define BAD_INSTANCE(expected, part, change)                                                                           \
    do {                                                                                                               \
        CrumpleInstanceDef def = crumple_instance_def_default();                                                       \
        CrumpleInstance out;                                                                                           \
        def.set = set;                                                                                                 \
        change;                                                                                                        \
        BAD_KEEPING(expected, part, out, crumple_instance_create(context, &def, &out));                                \
    } while (0)

#define BAD_HIT(expected, part, change)                                                                                \
    do {                                                                                                               \
        CrumpleHitDef def = displacement_at(0, 0, 0.01f);                                                              \
        change;                                                                                                        \
        BAD_KEEPING(expected, part, told, crumple_instance_submit_hit(context, body, &def, &told));                    \
        BAD(expected, "hit 1: " part, crumple_context_submit_hits(context, bodies, (CrumpleHitDef[]){push, def}, 2, NULL)); \
    } while (0)

static void instances_and_hits(void) {
    const CrumpleInstance bodies[2] = {body, body}, stale[2] = {body, {0, 0, 0}};
    const CrumpleHitDef push = displacement_at(0, 0, 0.01f), both[2] = {push, push};
    float matrix[17] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    CrumpleHitResult told;
    BAD_INSTANCE(STRUCT_SIZE, "crumple_instance_def_default", def.struct_size = 4);
    BAD_INSTANCE(INVALID_ARGUMENT, "def.rule is 3", SET_ENUM(def.rule, 3));
    BAD_INSTANCE(INVALID_ARGUMENT, "def.selection is 2", SET_ENUM(def.selection, 2));
    BAD_INSTANCE(INVALID_ARGUMENT, "transpose", def.local_to_world[3] = 1);
    BAD(NOT_FINITE, "time", crumple_context_set_time(context, INFINITY));
    BAD(NULL_POINTER, "local_to_world", crumple_instance_set_transform(context, body, NULL));
    BAD(MISALIGNED, "local_to_world", crumple_instance_set_transform(context, body, crooked(matrix)));
    matrix[10] = NAN;
    BAD(NOT_FINITE, "local_to_world", crumple_instance_set_transform(context, body, matrix));

    BAD_KEEPING(NULL_POINTER, "def is null", told, crumple_instance_submit_hit(context, body, NULL, &told));
    BAD(MISALIGNED, "out_result", crumple_instance_submit_hit(context, body, &push, crooked(&told)));
    BAD(NULL_POINTER, "instances", crumple_context_submit_hits(context, NULL, both, 2, NULL));
    BAD(NULL_POINTER, "defs", crumple_context_submit_hits(context, bodies, NULL, 2, NULL));
    BAD(INVALID_ID, "instances[1]", crumple_context_submit_hits(context, stale, both, 2, NULL));
    OK(crumple_context_submit_hits(context, NULL, NULL, 0, NULL));
    BAD_HIT(STRUCT_SIZE, "def.struct_size", def.struct_size += 4);
    BAD_HIT(INVALID_ARGUMENT, "def.space is 2", SET_ENUM(def.space, 2));
    BAD_HIT(INVALID_ARGUMENT, "def.kind is 2", SET_ENUM(def.kind, 2));
    BAD_HIT(NOT_FINITE, "def.point", def.point.x = NAN);
    BAD(INVALID_ARGUMENT, "contact_id is 0", crumple_instance_end_contact(context, body, 0));
    BAD_KEEPING(UNKNOWN_CONTACT, "contact_id is 12", told, crumple_instance_get_contact(context, body, 12, &told));
}

#define BAD_POINTS(expected, part, change)                                                                             \
    do {                                                                                                               \
        CrumpleContactPointDef points[2] = {crumple_contact_point_def_default(), crumple_contact_point_def_default()}; \
        points[0].bodies[0] = points[1].bodies[0] = body;                                                              \
        points[0].normal = points[1].normal = vec3(0, 0, 1);                                                           \
        points[0].impulse = points[1].impulse = 1;                                                                     \
        change;                                                                                                        \
        BAD(expected, part, crumple_context_report_contacts(context, points, 2));                                      \
    } while (0)

// Wrong points are refused whole. tests/contact_layer.rs has the numbers that are wrong.
static void contact_points(void) {
    CrumpleContactReport report;
    CrumpleContactHit hits[1];
    CrumpleContactOptionsDef options = crumple_contact_options_def_default();
    BAD_POINTS(STRUCT_SIZE, "points[1].def.struct_size", points[1].struct_size = 3);
    BAD_POINTS(INVALID_ID, "points[1].bodies[1]", points[1].bodies[1].index = 1000);
    BAD(NULL_POINTER, "points", crumple_context_report_contacts(context, NULL, 1));
    OK(crumple_context_report_contacts(context, NULL, 0));
    BAD_KEEPING(INVALID_ARGUMENT, "seconds", report, crumple_context_step_contacts(context, -1, &report));
    BAD(NULL_POINTER, "out_count", crumple_context_get_contact_hits(context, hits, 1, NULL));
    OK(crumple_context_step_contacts(context, 1, &report));
    FACT(report.points == 0);
    options.struct_size = 3;
    BAD(STRUCT_SIZE, "crumple_contact_options_def_default", crumple_context_set_contact_options(context, &options));
}

// Arrays that the caller gets: how many are needed is told, and nothing is written where there is no room for all.
static void damage(void) {
    CrumpleHitDef hit = displacement_at(0.1f, 0.1f, 0.03f), other = displacement_at(-0.2f, 0.2f, 0.02f);
    CrumpleMark marks[4], bad;
    unsigned char bytes[512], again[512];
    uint32_t count;
    size_t size;
    OK(crumple_instance_submit_hit(context, body, &hit, NULL));
    OK(crumple_instance_submit_hit(context, body, &other, NULL));
    memset(marks, 0xAB, sizeof marks);
    FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "marks has room for 1; 2 are needed", crumple_instance_get_marks(context, body, marks, 1, &count));
    FACT(count == 2);
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "marks is null", count, crumple_instance_get_marks(context, body, NULL, 2, &count));
    FAILS_KEEPING(CRUMPLE_ERROR_MISALIGNED, "marks", count, crumple_instance_get_marks(context, body, crooked(marks), 3, &count));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "out_count", crumple_instance_get_marks(context, body, marks, 4, NULL));
    memset(bytes, 0xAB, sizeof bytes);
    FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "96 are needed", crumple_instance_save_damage(context, body, bytes, 95, &size));
    FACT(size == 96);
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "data is null", size, crumple_instance_save_damage(context, body, NULL, 96, &size));
    FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "data", crumple_context_save_damage(context, &body, 1, bytes, 16, &size));
    FACT(keeps(marks, sizeof marks) && keeps(bytes, sizeof bytes));
    OK(crumple_instance_get_marks(context, body, marks, 4, &count));
    OK(crumple_instance_save_damage(context, body, bytes, sizeof bytes, &size));
    FACT(count == 2 && size == 96);

    bad = marks[0];
    bad.contact = VERTICES;
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "contact", crumple_instance_set_marks(context, body, &bad, 1));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "marks", crumple_instance_set_marks(context, body, NULL, 1));
    // Nothing behind the given size is read.
    unsigned char *cut = malloc(size - 1);
    memcpy(cut, bytes, size - 1);
    FAILS(CRUMPLE_ERROR_DAMAGE_MISMATCH, "saved damage", crumple_instance_load_damage(context, body, cut, size - 1));
    free(cut);
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "data is null", crumple_instance_load_damage(context, body, NULL, 96));
    memset(again, 0xAB, sizeof again);
    FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "mapped has room for 95",
          crumple_example_set_map_damage(context, set, set, bytes, size, 0, again, 95, &size, NULL));
    FACT(size == 96 && keeps(again, sizeof again));
    OK(crumple_instance_save_damage(context, body, again, sizeof again, &size));
    FACT(size == 96 && memcmp(bytes, again, size) == 0); // nothing has changed so far
    OK(crumple_instance_reset_damage(context, body));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    usable();
}

#define BAD_BUFFER(expected, part, change)                                                                             \
    do {                                                                                                               \
        CrumpleHostBufferDef def = host_def(memory, VERTICES, 10);                                                     \
        CrumpleBuffer out;                                                                                             \
        change;                                                                                                        \
        BAD_KEEPING(expected, part, out, crumple_buffer_register_host(context, body, &def, &out));                     \
        BAD(expected, part, crumple_buffer_set_memory(context, buffer, &def));                                         \
    } while (0)

static void buffers(void) {
    static float memory[VERTICES][10];
    CrumpleBuffer twice[3] = {buffer, buffer, buffer}, out;
    CrumpleDeformReport report;
    CrumpleAabb bounds;
    CrumpleRange ranges[1];
    uint32_t count;
    memset(memory, 0xAB, sizeof memory);
    BAD_KEEPING(NULL_POINTER, "def is null", out, crumple_buffer_register_host(context, body, NULL, &out));
    BAD_BUFFER(STRUCT_SIZE, "crumple_host_buffer_def_default", def.struct_size = 0);
    BAD_BUFFER(NULL_POINTER, "def.positions", def.positions = stream_of(NULL, 0, 0, 0));
    BAD_BUFFER(NULL_POINTER, "def.normals.data is null", def.normals.data = NULL);
    BAD_BUFFER(MISALIGNED, "def.positions.data", def.positions.data = crooked(memory));
    BAD_BUFFER(MISALIGNED, "def.normals.offset is 10", def.normals.offset = 10);
    BAD_BUFFER(BUFFER_TOO_SMALL, "def.tangents", def.tangents.size -= 1);
    BAD_BUFFER(INVALID_ARGUMENT, "def.normals and def.positions overlap", def.normals.offset = 8);
    BAD_BUFFER(INVALID_ARGUMENT, "def.normal_format is 2", SET_ENUM(def.normal_format, 2));
    CrumpleHostBufferDef def = host_def(memory, VERTICES, 3);
    def.lod = 1;
    BAD_KEEPING(INDEX_OUT_OF_RANGE, "below 1", out, crumple_buffer_register_host(context, body, &def, &out));

    // Of a mesh without tangents, and without anything.
    CrumpleExampleSetDef bare_def = sheet.def;
    CrumpleMeshDef mesh = sheet.mesh;
    bare_def.mesh = &mesh;
    mesh.tangents = mesh.normals = mesh.indices = input_of(NULL, 0, 0);
    mesh.index_count = 0;
    OK(crumple_example_set_create(context, &bare_def, &out_set));
    CrumpleInstance bare = make_instance(context, out_set);
    def = host_def(memory, VERTICES, 6);
    BAD_KEEPING(MESH, "normals", out, crumple_buffer_register_host(context, bare, &def, &out));
    FACT(keeps(memory, sizeof memory));
    CrumpleBuffer points = make_buffer(context, bare, host_def(memory, VERTICES, 3));
    FAILS_KEEPING(CRUMPLE_ERROR_MESH, "no triangles; give it indices", count, crumple_buffer_get_changed_triangles(context, points, NULL, 0, &count, NULL));
    OK(crumple_instance_destroy(context, bare));
    OK(crumple_example_set_destroy(context, out_set));

    // Deforming, and what changed.
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
}

// Plans for render graphs. tests/vulkan/graph.rs has what else is refused.
static void graphs(void) {
    CrumpleVulkanBufferDef def = crumple_vulkan_buffer_def_default();
    CrumpleBuffer out;
    CrumpleGraphPlan plan;
    size_t size;
    if (!(crumple_features() & CRUMPLE_FEATURE_VULKAN)) {
        BAD(UNSUPPORTED, "vulkan", crumple_graph_get_kernel(0, NULL, 0, &size));
        return;
    }
    BAD_KEEPING(INVALID_ARGUMENT, "def.positions is absent", out, crumple_buffer_register_graph(context, body, &def, &out));
    BAD_KEEPING(INVALID_ARGUMENT, "buffers[0] is a host buffer; crumple_context_deform()", plan, crumple_graph_plan(context, &buffer, 1, &plan, NULL));
    BAD(NULL_POINTER, "out_plan", crumple_graph_plan(context, NULL, 0, NULL, NULL));
    BAD_KEEPING(INVALID_ARGUMENT, "kernel is 36", size, crumple_graph_get_kernel(36, NULL, 0, &size));
}

int main(void) {
    make_sheet(&sheet);
    context = make_context(2);
    second = make_context(1);
    OK(crumple_example_set_create(context, &sheet.def, &set));
    body = make_instance(context, set);
    buffer = make_buffer(context, body, host_def(vertices, VERTICES, 3));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    usable();
    contexts();
    meshes();
    examples();
    sets();
    ids();
    instances_and_hits();
    contact_points();
    damage();
    buffers();
    graphs();
    OK(crumple_context_destroy(second));
    OK(crumple_context_destroy(context));
    printf("%u checks\n", checks);
    return 0;
}
