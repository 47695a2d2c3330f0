// Bodies, their damage and memory of the host, as far as C could get it wrong: arrays with strides and at odd addresses, bytes, pointers of
// plans, fields that no other language sets. Only registered bytes are written, and what changed is told. The tests of Python, C# and the C++
// header have the other calls.
#include "support.h"

#include <crumple_contacts.h>
#include <crumple_graph.h>
#include <crumple_parts.h>
#include <crumple_view.h>

static Sheet sheet;
static CrumpleContext *context;
static CrumpleExampleSet set;
static int warnings;

static float deepest(float (*positions)[3]) {
    float depth = 0;
    for (int v = 0; v < VERTICES; ++v) depth = fmaxf(depth, sheet.positions[v][2] - positions[v][2]);
    return depth;
}

static CrumpleInstanceInfo info_of(CrumpleInstance body) {
    CrumpleInstanceInfo info;
    OK(crumple_instance_get_info(context, body, &info));
    return info;
}

static void hit(CrumpleInstance body, float x, float y, float depth) {
    CrumpleHitDef def = displacement_at(x, y, depth);
    OK(crumple_instance_submit_hit(context, body, &def, NULL));
}

static CrumpleDeformReport deform(void) {
    CrumpleDeformReport report;
    OK(crumple_context_deform(context, NULL, 0, &report));
    return report;
}

static void marks_and_bytes(void) {
    static float vertices[VERTICES][3], copies[VERTICES][3];
    CrumpleInstance body = make_instance(context, set), copy = make_instance(context, set);
    CrumpleMark marks[16];
    CrumpleHitResult told, preview;
    unsigned char bytes[1024], repeated[1024];
    uint32_t count = 0;
    size_t size = 0, repeated_size = 0;
    make_buffer(context, body, host_def(vertices, VERTICES, 3));
    make_buffer(context, copy, host_def(copies, VERTICES, 3));
    for (int i = 0; i < 5; ++i) {
        CrumpleHitDef hit = displacement_at(0.15f * (float)i - 0.3f, 0.1f, 0.02f + 0.005f * (float)i);
        OK(crumple_instance_preview_hit(context, body, &hit, &preview));
        OK(crumple_instance_submit_hit(context, body, &hit, &told));
        FACT(memcmp(&told.mark, &preview.mark, sizeof told.mark) == 0 && told.expected_error > 0);
        FACT(told.status == CRUMPLE_HIT_STATUS_MARKED && told.target.z == hit.displacement.z && !told.clamped);
    }
    // Bytes at an odd address.
    OK(crumple_instance_save_damage(context, body, bytes + 1, sizeof bytes - 1, &size));
    OK(crumple_instance_load_damage(context, copy, bytes + 1, size));
    OK(crumple_instance_save_damage(context, copy, repeated, sizeof repeated, &repeated_size));
    FACT(size == 24 + 5 * 32 + 8 && repeated_size == size && memcmp(bytes + 1, repeated, size) == 0);
    OK(crumple_instance_get_marks(context, body, marks, 16, &count));
    OK(crumple_instance_set_marks(context, copy, marks, count));
    OK(crumple_instance_copy_damage(context, copy, copy));
    OK(crumple_instance_set_depth_limit(context, copy, 0.01f));
    deform();
    FACT(count == 5 && deepest(copies) <= 0.0100001f && deepest(vertices) > 0.02f);
    OK(crumple_instance_set_depth_limit(context, copy, 0)); // the set's
    deform();
    FACT(memcmp(vertices, copies, sizeof vertices) == 0);
    OK(crumple_instance_set_marks(context, copy, NULL, 0));
    FACT(info_of(copy).mark_count == 0 && info_of(copy).buffer_count == 1 && info_of(copy).memory_bytes > 0);
}

// Depth limits, stiffness and masses of vertices, in one array with strides.
static void arrays_of_vertices(void) {
    static float own[VERTICES][3];
    CrumpleMeshDef mesh = sheet.mesh;
    CrumpleExampleSetDef def = sheet.def;
    CrumpleInstanceDef instance_def = crumple_instance_def_default();
    CrumpleInstance body;
    CrumpleHitDef push = crumple_hit_def_default();
    CrumpleHitResult told;
    for (int v = 0; v < VERTICES; ++v) {
        own[v][0] = sheet.positions[v][0] < 0 ? 0.01f : INFINITY;
        own[v][1] = sheet.positions[v][1] > 0.2f ? 1.0f : 0.0f;
        own[v][2] = v == VERTICES / 2 ? 4.0f : 1.0f;
    }
    def.mesh = &mesh;
    mesh.depth_limits = input_of(own, sizeof own, sizeof own[0]);
    mesh.stiffness = input_of(&own[0][1], sizeof own - 4, sizeof own[0]);
    def.options.vertex_masses = input_of(&own[0][2], sizeof own - 8, sizeof own[0]);
    OK(crumple_example_set_create(context, &def, &instance_def.set));
    instance_def.yield_impulse = 1;
    instance_def.yield_displacement = 0.001f;
    OK(crumple_instance_create(context, &instance_def, &body));
    for (int i = 0; i < 4; ++i) {
        CrumpleHitDef hit = displacement_at(i % 2 ? -0.25f : 0.25f, i < 2 ? -0.25f : 0.25f, 0.05f);
        OK(crumple_instance_submit_hit(context, body, &hit, &told));
        FACT(told.status == (i < 2 ? CRUMPLE_HIT_STATUS_MARKED : CRUMPLE_HIT_STATUS_RIGID));
        FACT(i >= 2 || told.clamped == (i == 1));
    }
    push.impulse = vec3(0, 0, -8);
    push.duration = 0.01f;
    OK(crumple_instance_submit_hit(context, body, &push, &told)); // the middle: 4 kg
    FACT(told.contact_vertex == VERTICES / 2 && fabsf(told.target.z + 0.02f) < 1e-6f);
    push.impulse.z = -0.99f;
    OK(crumple_instance_submit_hit(context, body, &push, &told));
    FACT(told.status == CRUMPLE_HIT_STATUS_BELOW_YIELD && told.mark.hits == 0);
}

static void rules_and_growth(void) {
    static float vertices[VERTICES][3];
    CrumpleInstanceDef def = crumple_instance_def_default();
    CrumpleInstance body;
    CrumpleAttachment at;
    CrumplePose pose;
    def.set = set;
    def.blend_constant = 0.5f;
    for (int rule = CRUMPLE_RULE_MOST_DISPLACED; rule <= CRUMPLE_RULE_BLEND; ++rule) {
        def.rule = (CrumpleRule)rule;
        OK(crumple_instance_create(context, &def, &body));
        make_buffer(context, body, host_def(vertices, VERTICES, 3));
        hit(body, 0, 0, 0.04f);
        deform();
        FACT(fabsf(deepest(vertices) - 0.04f) < 1e-5f);
        OK(crumple_instance_destroy(context, body));
    }
    def.rule = CRUMPLE_RULE_MARKS;
    def.grow_time = 0.05f;
    OK(crumple_instance_create(context, &def, &body));
    OK(crumple_example_set_attach_point(context, set, vec3(0, 0, 0.075f), &at));
    for (int quarter = 0; quarter < 2; ++quarter) { // of the time in which the dent grows
        OK(crumple_context_set_time(context, 3 + 0.0125 * quarter));
        if (quarter == 0) hit(body, 0, 0, 0.04f);
        OK(crumple_instance_get_attached_pose(context, body, &at, &pose));
        FACT(fabsf(0.075f - pose.position.z - 0.01f * (float)quarter) < 1e-4f);
    }
}

// The sheet's first rows, with indices of 16 bits, are a level of detail and a part, which takes its buffer along. A level in another space is
// accepted with a warning.
static void levels_and_parts(void) {
    enum { FEW = 2 * SIDE, CORNERS = (SIDE - 1) * 6 };
    static float rows[FEW][3], fine[VERTICES][3], few[FEW][3];
    static uint16_t corners[CORNERS];
    CrumpleMeshDef mesh = sheet.mesh;
    CrumpleExampleSet own;
    CrumpleInstance bumper;
    uint32_t part = 0, strange = 0, shown = 7;
    memcpy(rows, sheet.positions, sizeof rows);
    for (int i = 0; i < CORNERS; ++i) corners[i] = (uint16_t)sheet.indices[i];
    mesh.vertex_count = FEW;
    mesh.positions = input_of(rows, sizeof rows, 12);
    mesh.tangents = input_of(NULL, 0, 0);
    mesh.index_count = CORNERS;
    mesh.index_type = CRUMPLE_INDEX_TYPE_U16;
    mesh.indices = input_of(corners, sizeof corners, 2);
    OK(crumple_example_set_create(context, &sheet.def, &own));
    OK(crumple_example_set_add_lod(context, own, &mesh, &part));
    FACT(part == 1 && warnings == 0);
    for (int v = 0; v < FEW; ++v) rows[v][1] += 22;
    OK(crumple_example_set_add_lod(context, own, &mesh, &strange));
    FACT(strange == 2 && warnings == 1);

    CrumpleInstance body = make_instance(context, own);
    CrumpleHostBufferDef def = host_def(few, FEW, 3);
    def.lod = part;
    CrumpleBuffer buffer = make_buffer(context, body, def);
    make_buffer(context, body, host_def(fine, VERTICES, 3));
    hit(body, 0.1f, -0.5f, 0.04f);
    deform();
    FACT(memcmp(few, fine, sizeof few) == 0 && memcmp(few, sheet.positions, sizeof few) != 0);
    OK(crumple_instance_set_view(context, body, 0, 1, 1, 1080, &shown));
    FACT(shown == 0);
    OK(crumple_instance_set_view(context, body, 1, 1e4f, 1, 1080, &shown));
    FACT(shown > 0);

    OK(crumple_instance_release_part(context, body, part, &bumper));
    hit(bumper, -0.3f, -0.5f, 0.04f);
    OK(crumple_context_deform(context, &buffer, 1, NULL));
    FACT(memcmp(few, fine, sizeof few) != 0);
    OK(crumple_instance_mount_part(context, body, bumper, true));
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "same instance", crumple_instance_mount_part(context, body, body, true));
    OK(crumple_instance_mount_part(context, body, bumper, false));
    OK(crumple_instance_destroy(context, bumper));
    FACT(!crumple_buffer_is_valid(context, buffer));
    OK(crumple_instance_destroy(context, body));
}

// Of a pair both bodies get the whole impulse, the second from the other side.
static void both_bodies_of_a_pair(void) {
    CrumpleInstanceDef def = crumple_instance_def_default();
    CrumpleInstance bodies[2];
    CrumpleContactPointDef point = crumple_contact_point_def_default();
    CrumpleContactReport report;
    CrumpleContactHit hits[2];
    uint32_t count = 7;
    def.set = set;
    def.compliance = 0.001f;
    for (int i = 0; i < 2; ++i) OK(crumple_instance_create(context, &def, &bodies[i]));
    point.pair = 5;
    memcpy(point.bodies, bodies, sizeof bodies);
    point.point = vec3(0.2f, 0, 0.075f);
    point.normal = vec3(0, 0, 1);
    point.has_velocity = true;
    point.velocity = vec3(0, 0, -5);
    point.impulse = 40;
    OK(crumple_context_report_contacts(context, &point, 1));
    OK(crumple_context_step_contacts(context, 1.0f / 60, &report));
    FACT(report.points == 1 && report.hits == 2 && report.begun == 2 && report.open == 2 && report.refusal == CRUMPLE_OK);
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "seconds", crumple_context_step_contacts(context, -1, NULL)); // which keeps the hits
    FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "hits has room for 1; 2", crumple_context_get_contact_hits(context, hits, 1, &count));
    OK(crumple_context_get_contact_hits(context, hits, 2, &count));
    FACT(count == 2 && hits[0].instance.index != hits[1].instance.index);
    for (int i = 0; i < 2; ++i) {
        FACT(hits[i].pair == 5 && hits[i].contact_id >> 63 == 1 && hits[i].point.x == 0.2f && hits[i].impulse.x == 0);
        FACT(hits[i].impulse.z == (hits[i].instance.index == bodies[0].index ? -40 : 40));
    }
}

typedef struct Vertex {
    float position[3], uv[2], normal[3], tangent[4];
    uint32_t colour;
} Vertex;

static CrumpleHostBufferDef interleaved(Vertex *vertices) {
    CrumpleHostBufferDef def = crumple_host_buffer_def_default();
    const size_t bytes = VERTICES * sizeof(Vertex);
    def.positions = stream_of(vertices, bytes, offsetof(Vertex, position), sizeof(Vertex));
    def.normals = stream_of(vertices, bytes, offsetof(Vertex, normal), sizeof(Vertex));
    def.tangents = stream_of(vertices, bytes, offsetof(Vertex, tangent), sizeof(Vertex));
    return def;
}

static void registered_bytes(void) {
    static Vertex vertices[VERTICES], second[VERTICES], third[VERTICES];
    static CrumpleRange triangles[INDICES / 3];
    CrumpleInstance body = make_instance(context, set);
    CrumpleRange ranges[8];
    CrumpleAabb bounds;
    uint32_t count = 0, written = 0;
    memset(vertices, 0xAB, sizeof vertices);
    CrumpleBuffer buffer = make_buffer(context, body, interleaved(vertices));
    OK(crumple_buffer_get_changes(context, buffer, NULL, 0, &count, &bounds));
    FACT(count == 0 && bounds.min.x == -0.5f && bounds.max.x == 0.5f);
    hit(body, -0.3f, -0.3f, 0.04f);
    CrumpleDeformReport report = deform();
    FACT(report.vertices_written == VERTICES && report.reserved[0] == 0);
    for (int v = 0; v < VERTICES; ++v) {
        const Vertex *at = &vertices[v];
        FACT(keeps(at->uv, sizeof at->uv) && keeps(&at->colour, sizeof at->colour));
        FACT(at->normal[2] > 0.5f && at->tangent[0] > 0.5f && at->tangent[3] == 1);
    }

    // Another hit writes what it touched, and says so.
    hit(body, 0.4f, -0.4f, 0.01f);
    report = deform();
    FACT(report.vertices_written > 0 && report.vertices_written < VERTICES && report.blocks_skipped > 0);
    OK(crumple_buffer_get_changes(context, buffer, NULL, 0, &count, NULL));
    FACT(count > 0 && count <= 8);
    if (count > 1) FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "ranges", crumple_buffer_get_changes(context, buffer, ranges, 1, &count, NULL));
    OK(crumple_buffer_get_changes(context, buffer, ranges, 8, &count, &bounds));
    for (uint32_t i = 0; i < count; ++i) written += ranges[i].count;
    FACT(written == report.vertices_written);
    OK(crumple_buffer_get_changed_triangles(context, buffer, NULL, 0, &count, NULL));
    FACT(count > 0 && count <= INDICES / 3);
    OK(crumple_buffer_get_changed_triangles(context, buffer, triangles, count, &count, &bounds));
    FACT(triangles[count - 1].first + triangles[count - 1].count <= INDICES / 3 && bounds.max.x <= 0.5f);

    // A second buffer of the same instance gets everything; the first is up to date. So does other memory.
    CrumpleBuffer other = make_buffer(context, body, interleaved(second));
    FACT(deform().vertices_written == VERTICES && memcmp(vertices[5].position, second[5].position, 12) == 0);
    memset(second, 0, sizeof second);
    OK(crumple_buffer_invalidate(context, other));
    FACT(deform().vertices_written == VERTICES && memcmp(vertices[5].position, second[5].position, 12) == 0);
    CrumpleHostBufferDef def = interleaved(third);
    OK(crumple_buffer_set_memory(context, other, &def));
    FACT(deform().vertices_written == VERTICES && memcmp(vertices[5].position, third[5].position, 12) == 0);
    OK(crumple_context_set_vertex_budget(context, 1));
    hit(body, 0.4f, -0.4f, 0.01f);
    FACT(deform().vertices_waiting > 0);
    OK(crumple_context_set_vertex_budget(context, 0));
    OK(crumple_instance_destroy(context, body));
}

// Buffers and bodies carry numbers of the host, and what changed is told with them.
static void whose(void) {
    static float mine[VERTICES][3], twin[VERTICES][3];
    CrumpleInstanceDef def = crumple_instance_def_default();
    CrumpleHostBufferDef buffer_def = host_def(mine, VERTICES, 3);
    CrumpleInstance body;
    CrumpleBufferInfo info, changed[2];
    uint64_t number = 0;
    uint32_t count = 9;
    def.set = set;
    def.user_data = 41;
    OK(crumple_instance_create(context, &def, &body));
    buffer_def.user_data = UINT64_MAX;
    CrumpleBuffer buffer = make_buffer(context, body, buffer_def), other = make_buffer(context, body, host_def(twin, VERTICES, 3));
    OK(crumple_instance_get_user_data(context, body, &number));
    FACT(number == 41);
    OK(crumple_instance_set_user_data(context, body, 42));
    OK(crumple_buffer_get_info(context, buffer, &info));
    FACT(info.buffer.index == buffer.index && info.instance.index == body.index && info.instance.generation == body.generation);
    FACT(info.user_data == UINT64_MAX && info.instance_user_data == 42 && info.lod == 0);
    deform();
    hit(body, 0, 0, 0.03f);
    deform();
    FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "buffers", crumple_context_get_changed_buffers(context, changed, 1, &count));
    OK(crumple_context_get_changed_buffers(context, changed, 2, &count));
    FACT(count == 2 && memcmp(&changed[0], &info, sizeof info) == 0);
    FACT(changed[1].buffer.index == other.index && changed[1].user_data == 0 && changed[1].instance_user_data == 42);
    deform();
    OK(crumple_context_get_changed_buffers(context, NULL, 0, &count));
    FACT(count == 0);
    buffer_def.user_data = 7; // comes with other memory
    OK(crumple_buffer_set_memory(context, buffer, &buffer_def));
    OK(crumple_buffer_get_info(context, buffer, &info));
    FACT(info.user_data == 7);
    OK(crumple_instance_destroy(context, body));
}

// The pointers of a plan. bindings/godot/project/tests/compute.gd executes such plans.
static void graphs(void) {
    CrumpleInstance body = make_instance(context, set);
    CrumpleVulkanBufferDef def = crumple_vulkan_buffer_def_default();
    CrumpleBuffer buffer;
    CrumpleGraphPlan plan;
    CrumpleRecordReport report;
    def.buffer = 77;
    def.buffer_size = def.size = VERTICES * 24;
    def.positions.stride = def.normals.stride = 24;
    def.normals.offset = 12;
    def.positions.format = def.normals.format = 106; // VK_FORMAT_R32G32B32_SFLOAT
    OK(crumple_buffer_register_graph(context, body, &def, &buffer));
    OK(crumple_graph_plan(context, &buffer, 1, &plan, &report));
    FACT(plan.upload_count == 1 && plan.freed_count == 0 && plan.dispatch_count == 1);
    FACT(report.vertices_written == VERTICES && report.bytes_copied == plan.uploads[0].size + plan.work_size);
    // The mesh is at the start of its storage.
    FACT(plan.uploads[0].offset == 0 && memcmp(plan.uploads[0].data, sheet.positions, sizeof sheet.positions) == 0);
    const uint32_t storage = plan.uploads[0].storage;
    FACT(plan.dispatches[0].storage == storage && plan.dispatches[0].buffer == 77);
    FACT(plan.dispatches[0].groups[0] == (VERTICES + 127) / 128 && plan.dispatches[0].groups[1] == 1);
    OK(crumple_buffer_unregister(context, buffer));
    OK(crumple_graph_plan(context, NULL, 0, &plan, NULL));
    FACT(plan.freed_count == 1 && plan.freed[0] == storage && plan.dispatch_count == 0);
}

static void count_warnings(CrumpleLogLevel level, const char *message, void *user) {
    FACT(strlen(message) > 0);
    *(int *)user += level == CRUMPLE_LOG_LEVEL_WARNING;
}

int main(void) {
    CrumpleContextDef def = crumple_context_def_default();
    def.threads = 2;
    def.log = count_warnings;
    def.log_user = &warnings;
    make_sheet(&sheet);
    OK(crumple_context_create(&def, &context));
    OK(crumple_example_set_create(context, &sheet.def, &set));
    marks_and_bytes();
    arrays_of_vertices();
    rules_and_growth();
    levels_and_parts();
    both_bodies_of_a_pair();
    registered_bytes();
    whose();
    if (crumple_features() & CRUMPLE_FEATURE_VULKAN) graphs();
    OK(crumple_context_destroy(context));
    printf("%u checks\n", checks);
    return 0;
}
