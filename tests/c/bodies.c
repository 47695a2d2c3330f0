// Bodies and their damage, as far as C could get it wrong: arrays with strides and at odd addresses, bytes, fields that no other language
// sets. The tests of Python, C# and the C++ header have the other calls.
#include "support.h"

#include <crumple_contacts.h>
#include <crumple_parts.h>
#include <crumple_view.h>

static Sheet sheet;
static CrumpleContext *context;
static CrumpleExampleSet set;

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
    OK(crumple_context_deform(context, NULL, 0, NULL));
    FACT(count == 5 && deepest(copies) <= 0.0100001f && deepest(vertices) > 0.02f);
    OK(crumple_instance_set_depth_limit(context, copy, 0)); // the set's
    OK(crumple_context_deform(context, NULL, 0, NULL));
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
    CrumpleHitDef hit = displacement_at(0, 0, 0.04f);
    CrumpleMark mark;
    CrumpleAttachment at;
    CrumplePose pose;
    uint32_t count = 7;
    def.set = set;
    def.blend_constant = 0.5f;
    for (int rule = CRUMPLE_RULE_MOST_DISPLACED; rule <= CRUMPLE_RULE_BLEND; ++rule) {
        def.rule = (CrumpleRule)rule;
        OK(crumple_instance_create(context, &def, &body));
        make_buffer(context, body, host_def(vertices, VERTICES, 3));
        OK(crumple_instance_submit_hit(context, body, &hit, NULL));
        OK(crumple_context_deform(context, NULL, 0, NULL));
        FACT(fabsf(deepest(vertices) - 0.04f) < 1e-5f);
        FAILS(CRUMPLE_ERROR_WRONG_RULE, "Marks", crumple_instance_get_marks(context, body, &mark, 1, &count));
        FACT(count == 7);
        OK(crumple_instance_destroy(context, body));
    }
    def.rule = CRUMPLE_RULE_MARKS;
    def.grow_time = 0.05f;
    OK(crumple_instance_create(context, &def, &body));
    OK(crumple_example_set_attach_point(context, set, vec3(0, 0, 0.075f), &at));
    for (int quarter = 0; quarter < 2; ++quarter) { // of the time in which the dent grows
        OK(crumple_context_set_time(context, 3 + 0.0125 * quarter));
        if (quarter == 0) OK(crumple_instance_submit_hit(context, body, &hit, NULL));
        OK(crumple_instance_get_attached_pose(context, body, &at, &pose));
        FACT(fabsf(0.075f - pose.position.z - 0.01f * (float)quarter) < 1e-4f);
    }
    OK(crumple_instance_repair_around(context, body, vec3(0.2f, 0, 0.07f), 0.1f, 0));
    FACT(info_of(body).mark_count == 1);
    OK(crumple_instance_repair_around(context, body, vec3(0, 0, 0.075f), 0.1f, 0));
    FACT(info_of(body).mark_count == 0);
}

// The sheet's first rows are a part, which takes its buffer along.
static void parts(void) {
    static float vertices[2 * SIDE][3];
    CrumpleMeshDef rows = sheet.mesh;
    CrumpleExampleSet body_set;
    CrumpleInstance bumper = {0, 0, 0};
    CrumpleHitDef hit = displacement_at(0, -0.5f, 0.03f);
    CrumpleHitResult told;
    uint32_t part;
    rows.vertex_count = 2 * SIDE;
    rows.index_count = (SIDE - 1) * 6;
    rows.tangents = input_of(NULL, 0, 0);
    OK(crumple_example_set_create(context, &sheet.def, &body_set));
    OK(crumple_example_set_add_lod(context, body_set, &rows, &part));
    CrumpleInstance body = make_instance(context, body_set);
    CrumpleHostBufferDef def = host_def(vertices, 2 * SIDE, 3);
    def.lod = part;
    CrumpleBuffer buffer = make_buffer(context, body, def);
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "part is 0", crumple_instance_release_part(context, body, 0, &bumper));
    FACT(bumper.index == 0);
    OK(crumple_instance_release_part(context, body, part, &bumper));
    OK(crumple_instance_submit_hit(context, bumper, &hit, &told));
    FACT(told.status == CRUMPLE_HIT_STATUS_MARKED && told.contact_vertex < 2 * SIDE);
    OK(crumple_context_deform(context, &buffer, 1, NULL));
    FACT(sheet.positions[told.contact_vertex][2] - vertices[told.contact_vertex][2] > 0.02f);
    OK(crumple_instance_mount_part(context, body, bumper, true));
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "same instance", crumple_instance_mount_part(context, body, body, true));
    OK(crumple_instance_mount_part(context, body, bumper, false));
    OK(crumple_instance_destroy(context, bumper));
    FACT(!crumple_buffer_is_valid(context, buffer));
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

int main(void) {
    make_sheet(&sheet);
    context = make_context(2);
    OK(crumple_example_set_create(context, &sheet.def, &set));
    marks_and_bytes();
    arrays_of_vertices();
    rules_and_growth();
    parts();
    both_bodies_of_a_pair();
    OK(crumple_context_destroy(context));
    printf("%u checks\n", checks);
    return 0;
}
