// Whose buffers and instances are, many things in one call, sets in two contexts, revisions, growth, repair around a point and parts through the C
// interface.
#include "support.h"

#include <crumple_host.h>
#include <crumple_parts.h>
#include <crumple_view.h>

static Sheet sheet;
static CrumpleContext *context;
static CrumpleExampleSet set;

static CrumpleInstance growing(float grow_time) {
    CrumpleInstanceDef def = crumple_instance_def_default();
    CrumpleInstance body;
    def.set = set;
    def.grow_time = grow_time;
    OK(crumple_instance_create(context, &def, &body));
    return body;
}

static CrumpleBuffer positions_of(CrumpleInstance body, float (*vertices)[3]) {
    CrumpleHostBufferDef def = crumple_host_buffer_def_default();
    CrumpleBuffer buffer;
    def.positions = stream_of(vertices, VERTICES * sizeof vertices[0], 0, sizeof vertices[0]);
    OK(crumple_buffer_register_host(context, body, &def, &buffer));
    return buffer;
}

static void whose(void) {
    static float mine[VERTICES][3], twin[VERTICES][3];
    CrumpleInstanceDef def = crumple_instance_def_default();
    CrumpleHostBufferDef buffer_def = crumple_host_buffer_def_default();
    CrumpleInstance body, null_body = {0, 0, 0};
    CrumpleExampleSet null_set = {0, 0, 0};
    CrumpleBuffer buffer, other, null_buffer = {0, 0, 0};
    CrumpleBufferInfo info, changed[2];
    CrumpleHitDef hit = displacement_at(0, 0, 0.03f);
    uint64_t number = 0;
    uint32_t count = 0;
    def.set = set;
    def.user_data = 41;
    OK(crumple_instance_create(context, &def, &body));
    buffer_def.positions = stream_of(mine, sizeof mine, 0, sizeof mine[0]);
    buffer_def.user_data = UINT64_MAX;
    OK(crumple_buffer_register_host(context, body, &buffer_def, &buffer));
    other = positions_of(body, twin);
    OK(crumple_instance_get_user_data(context, body, &number));
    FACT(number == 41);
    OK(crumple_instance_set_user_data(context, body, 42));
    OK(crumple_buffer_get_info(context, buffer, &info));
    FACT(info.buffer.index == buffer.index && info.instance.index == body.index && info.instance.generation == body.generation);
    FACT(info.user_data == UINT64_MAX && info.instance_user_data == 42 && info.lod == 0);

    OK(crumple_context_deform(context, NULL, 0, NULL));
    OK(crumple_instance_submit_hit(context, body, &hit, NULL));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    OK(crumple_context_get_changed_buffers(context, changed, 2, &count));
    FACT(count == 2 && memcmp(&changed[0], &info, sizeof info) == 0);
    FACT(changed[1].buffer.index == other.index && changed[1].user_data == 0 && changed[1].instance_user_data == 42);

    // Other memory comes with another number.
    buffer_def.user_data = 7;
    OK(crumple_buffer_set_memory(context, buffer, &buffer_def));
    OK(crumple_buffer_get_info(context, buffer, &info));
    FACT(info.user_data == 7);

    // What is valid, and that asking changes no error.
    FAILS(CRUMPLE_ERROR_INVALID_ID, "null buffer", crumple_buffer_get_info(context, null_buffer, &info));
    FACT(crumple_example_set_is_valid(context, set) && crumple_instance_is_valid(context, body) && crumple_buffer_is_valid(context, buffer));
    FACT(!crumple_example_set_is_valid(context, null_set) && !crumple_instance_is_valid(context, null_body));
    FACT(!crumple_buffer_is_valid(context, null_buffer) && !crumple_instance_is_valid(NULL, body));
    OK(crumple_buffer_unregister(context, other));
    FACT(!crumple_buffer_is_valid(context, other) && crumple_buffer_is_valid(context, buffer));
    OK(crumple_instance_destroy(context, body));
    FACT(!crumple_buffer_is_valid(context, buffer) && !crumple_instance_is_valid(context, body));
    FACT(strstr(crumple_last_error(), "null buffer") != NULL);
    FAILS(CRUMPLE_ERROR_INVALID_ID, "stale", crumple_instance_get_user_data(context, body, &number));
    FAILS(CRUMPLE_ERROR_INVALID_ID, "stale", crumple_instance_set_user_data(context, body, 1));
}

static uint64_t revision_of(CrumpleInstance body) {
    CrumpleInstanceInfo info;
    OK(crumple_instance_get_info(context, body, &info));
    return info.revision;
}

static void hits_and_buffers(void) {
    static float vertices[4][VERTICES][3];
    CrumpleInstance bodies[4], stale;
    CrumpleBuffer buffers[4];
    CrumpleBufferInfo changed[4];
    CrumpleHitDef hits[3];
    CrumpleHitResult results[3], alone;
    uint32_t count = 9;
    for (int i = 0; i < 4; ++i) {
        bodies[i] = growing(0);
        buffers[i] = positions_of(bodies[i], vertices[i]);
    }
    OK(crumple_context_get_changed_buffers(context, NULL, 0, &count));
    FACT(count == 0);
    OK(crumple_context_deform(context, NULL, 0, NULL));
    OK(crumple_context_get_changed_buffers(context, changed, 4, &count));
    FACT(count == 4 && changed[2].buffer.index == buffers[2].index && changed[2].buffer.generation == buffers[2].generation);

    for (int i = 0; i < 3; ++i) hits[i] = displacement_at(0.1f * (float)i, 0, 0.02f);
    OK(crumple_instance_preview_hit(context, bodies[3], &hits[2], &alone));
    // Two hits on one body; none on two.
    CrumpleInstance targets[3];
    targets[0] = targets[1] = bodies[1];
    targets[2] = bodies[3];
    OK(crumple_context_submit_hits(context, targets, hits, 3, results));
    FACT(memcmp(&results[2].mark, &alone.mark, sizeof alone.mark) == 0 && results[0].status == CRUMPLE_HIT_STATUS_MARKED);
    OK(crumple_context_deform(context, NULL, 0, NULL));
    FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "buffers", crumple_context_get_changed_buffers(context, changed, 1, &count));
    OK(crumple_context_get_changed_buffers(context, changed, 4, &count));
    FACT(count == 2 && changed[0].buffer.index == buffers[1].index && changed[1].buffer.index == buffers[3].index);
    OK(crumple_context_deform(context, NULL, 0, NULL));
    OK(crumple_context_get_changed_buffers(context, changed, 4, &count));
    FACT(count == 0);

    // All or none.
    uint64_t before = revision_of(bodies[1]);
    hits[2].displacement.z = NAN;
    memset(results, 0xAB, sizeof results);
    FAILS(CRUMPLE_ERROR_NOT_FINITE, "hit 2: def.displacement", crumple_context_submit_hits(context, targets, hits, 3, results));
    hits[2].struct_size = 3;
    FAILS(CRUMPLE_ERROR_STRUCT_SIZE, "hit 2: ", crumple_context_submit_hits(context, targets, hits, 3, results));
    hits[2] = hits[1];
    stale = growing(0);
    OK(crumple_instance_destroy(context, stale));
    targets[2] = stale;
    FAILS(CRUMPLE_ERROR_INVALID_ID, "instances[2]", crumple_context_submit_hits(context, targets, hits, 3, results));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "instances", crumple_context_submit_hits(context, NULL, hits, 3, results));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "defs", crumple_context_submit_hits(context, targets, NULL, 3, results));
    FACT(keeps(results, sizeof results) && revision_of(bodies[1]) == before);
    OK(crumple_context_submit_hits(context, NULL, NULL, 0, NULL));

    for (int i = 0; i < 4; ++i) OK(crumple_instance_destroy(context, bodies[i]));
}

static void bytes_of_all(void) {
    CrumpleInstance bodies[3], reversed[3];
    unsigned char bytes[4096];
    size_t size = 0, again = 0;
    uint64_t revisions[3];
    for (int i = 0; i < 3; ++i) {
        CrumpleHitDef hit = displacement_at(0.1f * (float)i, 0.1f, 0.01f * (float)(i + 1));
        bodies[i] = growing(0);
        OK(crumple_instance_submit_hit(context, bodies[i], &hit, NULL));
        revisions[i] = revision_of(bodies[i]);
        reversed[2 - i] = bodies[i];
    }
    OK(crumple_context_save_damage(context, NULL, 0, NULL, 0, &size));
    FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "data", crumple_context_save_damage(context, bodies, 3, bytes, 16, &again));
    OK(crumple_context_save_damage(context, bodies, 3, bytes, sizeof bytes, &again));
    FACT(size == again && size == 16 + 3 * (8 + 24 + 32 + 8) + 8);
    OK(crumple_context_load_damage(context, reversed, 3, bytes, size));
    for (int i = 0; i < 3; ++i) FACT(revision_of(bodies[i]) == revisions[2 - i]);
    FAILS(CRUMPLE_ERROR_DAMAGE_MISMATCH, "3 instances; 2", crumple_context_load_damage(context, bodies, 2, bytes, size));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "data", crumple_context_load_damage(context, bodies, 3, NULL, size));
    for (int i = 0; i < 3; ++i) FACT(revision_of(bodies[i]) == revisions[2 - i]);
    for (int i = 0; i < 3; ++i) OK(crumple_instance_destroy(context, bodies[i]));
}

static void two_contexts(void) {
    CrumpleContextDef def = crumple_context_def_default();
    CrumpleContext *other;
    CrumpleExampleSet there, own;
    CrumpleExampleSetInfo info, same;
    CrumpleInstanceDef instance_def = crumple_instance_def_default();
    CrumpleInstance body;
    uint32_t number;
    def.threads = 1;
    OK(crumple_context_create(&def, &other));
    OK(crumple_example_set_create(context, &sheet.def, &own));
    OK(crumple_example_set_share(context, own, other, &there));
    OK(crumple_example_set_get_info(other, there, &info));
    OK(crumple_example_set_get_info(context, own, &same));
    FACT(info.fingerprint == same.fingerprint && info.name != same.name);
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "shared", crumple_example_set_add_lod(context, own, &sheet.mesh, &number));
    FAILS(CRUMPLE_ERROR_INVALID_ID, "another context", crumple_example_set_share(context, there, other, &there));
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "context itself", crumple_example_set_share(context, own, context, &there));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "context", crumple_example_set_share(context, own, NULL, &there));
    OK(crumple_example_set_destroy(context, own));
    instance_def.set = there;
    OK(crumple_instance_create(other, &instance_def, &body));
    CrumpleHitDef hit = displacement_at(0, 0.1f, 0.03f);
    OK(crumple_instance_submit_hit(other, body, &hit, NULL));
    OK(crumple_context_destroy(other));
}

static void repair_and_growth(void) {
    CrumpleInstance body = growing(0.05f);
    CrumpleHitDef hit = displacement_at(0, 0, 0.04f);
    CrumpleAttachment at;
    CrumplePose pose;
    CrumpleInstanceInfo info;
    CrumpleVec3 point = vec3(0, 0, 0.075f);
    OK(crumple_example_set_attach_point(context, set, point, &at));
    OK(crumple_context_set_time(context, 3));
    OK(crumple_instance_submit_hit(context, body, &hit, NULL));
    OK(crumple_instance_get_attached_pose(context, body, &at, &pose)); // the dent begins
    FACT(fabsf(point.z - pose.position.z) < 1e-6f);
    OK(crumple_context_set_time(context, 3.0125));
    OK(crumple_instance_get_attached_pose(context, body, &at, &pose));
    FACT(fabsf(point.z - pose.position.z - 0.01f) < 1e-4f);
    FAILS(CRUMPLE_ERROR_NOT_FINITE, "time", crumple_context_set_time(context, INFINITY));
    OK(crumple_instance_repair_around(context, body, vec3(0.2f, 0, 0.07f), 0.1f, 0));
    OK(crumple_instance_get_info(context, body, &info));
    FACT(info.mark_count == 1);
    OK(crumple_instance_repair_around(context, body, point, 0.1f, 0));
    OK(crumple_instance_get_info(context, body, &info));
    FACT(info.mark_count == 0);
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "radius", crumple_instance_repair_around(context, body, point, 0, 0));
    point.x = NAN;
    FAILS(CRUMPLE_ERROR_NOT_FINITE, "point", crumple_instance_repair_around(context, body, point, 1, 0));
    OK(crumple_instance_destroy(context, body));
}

// The sheet's first rows are a part, which comes off with its buffer, goes on again, and becomes glass.
static void parts(void) {
    static float vertices[2 * SIDE][3];
    CrumpleMeshDef rows = sheet.mesh;
    CrumpleExampleSet body_set;
    CrumpleHostBufferDef buffer_def = crumple_host_buffer_def_default();
    CrumpleBuffer buffer;
    CrumpleInstance bumper = {0, 0, 0};
    CrumpleHitDef hit = displacement_at(0, -0.5f, 0.03f);
    CrumpleHitResult told;
    uint32_t part;
    float deepest, mean, equivalent;
    rows.vertex_count = 2 * SIDE;
    rows.index_count = (SIDE - 1) * 6;
    rows.tangents = input_of(NULL, 0, 0);
    OK(crumple_example_set_create(context, &sheet.def, &body_set));
    OK(crumple_example_set_add_lod(context, body_set, &rows, &part));
    CrumpleInstance body = make_instance(context, body_set);
    buffer_def.lod = part;
    buffer_def.positions = stream_of(vertices, sizeof vertices, 0, sizeof vertices[0]);
    OK(crumple_buffer_register_host(context, body, &buffer_def, &buffer));

    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "part is 0", crumple_instance_release_part(context, body, 0, &bumper));
    FAILS(CRUMPLE_ERROR_INDEX_OUT_OF_RANGE, "3", crumple_instance_release_part(context, body, 3, &bumper));
    FACT(bumper.index == 0);
    OK(crumple_instance_release_part(context, body, part, &bumper));
    OK(crumple_instance_submit_hit(context, bumper, &hit, &told));
    FACT(told.status == CRUMPLE_HIT_STATUS_MARKED && told.contact_vertex < 2 * SIDE);
    OK(crumple_context_deform(context, &buffer, 1, NULL));
    OK(crumple_instance_measure_part(context, bumper, part, &deepest, &mean, &equivalent));
    FACT(deepest > mean && mean > 0 && equivalent > 0);
    FACT(sheet.positions[told.contact_vertex][2] - vertices[told.contact_vertex][2] > 0.02f);
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "off", crumple_instance_release_part(context, body, part, &bumper));

    OK(crumple_instance_mount_part(context, body, bumper, true));
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "off the body", crumple_instance_mount_part(context, body, bumper, true));
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "same instance", crumple_instance_mount_part(context, body, body, true));
    OK(crumple_instance_mount_part(context, body, bumper, false));
    OK(crumple_instance_destroy(context, bumper));
    FAILS(CRUMPLE_ERROR_INVALID_ID, "stale", crumple_buffer_invalidate(context, buffer));
    OK(crumple_instance_destroy(context, body));
    body = make_instance(context, body_set);
    OK(crumple_instance_set_part_rigid(context, body, part, true));
    OK(crumple_instance_submit_hit(context, body, &hit, &told));
    FACT(told.status == CRUMPLE_HIT_STATUS_RIGID && told.mark.hits == 0);
    OK(crumple_instance_destroy(context, body));
    OK(crumple_example_set_destroy(context, body_set));
}

int main(void) {
    CrumpleContextDef def = crumple_context_def_default();
    def.threads = 2;
    make_sheet(&sheet);
    OK(crumple_context_create(&def, &context));
    OK(crumple_example_set_create(context, &sheet.def, &set));
    whose();
    hits_and_buffers();
    bytes_of_all();
    two_contexts();
    repair_and_growth();
    parts();
    OK(crumple_context_destroy(context));
    printf("%u checks\n", checks);
    return 0;
}
