// Damage through the C interface: marks, bytes, contacts, rules and transforms arrive, and what is registered is written.
#include "support.h"

#include <crumple_contacts.h>
#include <crumple_parts.h>
#include <crumple_view.h>

static Sheet sheet;
static CrumpleContext *context;
static CrumpleExampleSet set;

typedef struct Vertex {
    float position[3], uv[2], normal[3], tangent[4];
    uint32_t colour;
} Vertex;

static float deepest(const Vertex *vertices) {
    float depth = 0;
    for (int v = 0; v < VERTICES; ++v) depth = fmaxf(depth, sheet.positions[v][2] - vertices[v].position[2]);
    return depth;
}

static CrumpleBuffer register_all(CrumpleInstance body, Vertex *vertices) {
    CrumpleHostBufferDef def = crumple_host_buffer_def_default();
    CrumpleBuffer buffer;
    size_t bytes = VERTICES * sizeof(Vertex);
    def.positions = stream_of(vertices, bytes, offsetof(Vertex, position), sizeof(Vertex));
    def.normals = stream_of(vertices, bytes, offsetof(Vertex, normal), sizeof(Vertex));
    def.tangents = stream_of(vertices, bytes, offsetof(Vertex, tangent), sizeof(Vertex));
    OK(crumple_buffer_register_host(context, body, &def, &buffer));
    return buffer;
}

typedef struct Packed {
    float position[3];
    uint16_t normal[2], tangent[2];
} Packed;

// Octahedral normals and tangents take four bytes each. tests/octahedral.rs checks what they hold.
static void octahedral(void) {
    static Packed packed[VERTICES];
    CrumpleInstance body = make_instance(context, set);
    CrumpleHostBufferDef def = crumple_host_buffer_def_default();
    CrumpleBuffer buffer;
    memset(packed, 0xAB, sizeof packed);
    def.positions = stream_of(packed, sizeof packed, offsetof(Packed, position), sizeof(Packed));
    def.normals = stream_of(packed, sizeof packed, offsetof(Packed, normal), sizeof(Packed));
    def.normal_format = CRUMPLE_DIRECTION_FORMAT_OCTAHEDRAL;
    OK(crumple_buffer_register_host(context, body, &def, &buffer));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    for (int v = 0; v < VERTICES; ++v) FACT(!keeps(packed[v].normal, 4) && keeps(packed[v].tangent, 4));
    def.tangents = stream_of(packed, sizeof packed, offsetof(Packed, tangent), sizeof(Packed));
    def.tangent_format = CRUMPLE_DIRECTION_FORMAT_OCTAHEDRAL;
    OK(crumple_buffer_set_memory(context, buffer, &def));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    for (int v = 0; v < VERTICES; ++v) FACT(!keeps(packed[v].tangent, 4));
    OK(crumple_instance_destroy(context, body));
}

// Only the registered bytes are written, each with its own attribute.
static void interleaved(void) {
    static Vertex vertices[VERTICES];
    CrumpleInstance body = make_instance(context, set);
    CrumpleBuffer buffer;
    CrumpleDeformReport report;
    static CrumpleRange triangles[INDICES / 3];
    CrumpleRange ranges[8];
    CrumpleAabb bounds;
    uint32_t count = 0, written = 0;
    memset(vertices, 0xAB, sizeof vertices);
    buffer = register_all(body, vertices);
    OK(crumple_buffer_get_changes(context, buffer, NULL, 0, &count, &bounds));
    FACT(count == 0 && bounds.min.x == -0.5f && bounds.max.x == 0.5f);
    CrumpleHitDef hit = displacement_at(-0.3f, -0.3f, 0.04f);
    OK(crumple_instance_submit_hit(context, body, &hit, NULL));
    OK(crumple_context_deform(context, &buffer, 1, &report));
    FACT(report.vertices_written == VERTICES && report.reserved[0] == 0);
    for (int v = 0; v < VERTICES; ++v) {
        const Vertex *at = &vertices[v];
        const float *n = at->normal, *t = at->tangent;
        FACT(keeps(at->uv, sizeof at->uv) && keeps(&at->colour, sizeof at->colour));
        FACT(fabsf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1) < 1e-5f);
        FACT(fabsf(t[0] * t[0] + t[1] * t[1] + t[2] * t[2] - 1) < 1e-5f && t[3] == 1);
        FACT(fabsf(n[0] * t[0] + n[1] * t[1] + n[2] * t[2]) < 1e-5f);
    }
    FACT(fabsf(deepest(vertices) - 0.04f) < 0.01f);

    // Another hit writes what it touched, and says so.
    hit = displacement_at(0.4f, -0.4f, 0.01f);
    OK(crumple_instance_submit_hit(context, body, &hit, NULL));
    OK(crumple_context_deform(context, NULL, 0, &report));
    FACT(report.vertices_written > 0 && report.vertices_written < VERTICES && report.blocks_skipped > 0);
    OK(crumple_buffer_get_changes(context, buffer, NULL, 0, &count, NULL));
    FACT(count > 0 && count <= 8);
    if (count > 1) FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "ranges", crumple_buffer_get_changes(context, buffer, ranges, 1, &count, NULL));
    OK(crumple_buffer_get_changes(context, buffer, ranges, 8, &count, &bounds));
    for (uint32_t i = 0; i < count; ++i) written += ranges[i].count;
    FACT(written == report.vertices_written);
    for (int v = 0; v < VERTICES; ++v) FACT(vertices[v].position[2] >= bounds.min.z && vertices[v].position[2] <= bounds.max.z);
    OK(crumple_buffer_get_changed_triangles(context, buffer, NULL, 0, &count, NULL));
    FACT(count > 0 && count <= INDICES / 3);
    OK(crumple_buffer_get_changed_triangles(context, buffer, triangles, count, &count, &bounds));
    FACT(triangles[count - 1].first + triangles[count - 1].count <= INDICES / 3 && bounds.max.x <= 0.5f);

    // A second buffer of the same instance gets everything; the first is up to date.
    static Vertex second[VERTICES];
    CrumpleBuffer other = register_all(body, second);
    OK(crumple_context_deform(context, NULL, 0, &report));
    FACT(report.vertices_written == VERTICES);
    for (int v = 0; v < VERTICES; ++v) FACT(memcmp(vertices[v].position, second[v].position, 12) == 0);
    memset(second, 0, sizeof second);
    OK(crumple_buffer_invalidate(context, other));
    OK(crumple_context_deform(context, NULL, 0, &report));
    FACT(report.vertices_written == VERTICES && memcmp(vertices[5].position, second[5].position, 12) == 0);

    // Other memory.
    static Vertex third[VERTICES];
    CrumpleHostBufferDef def = crumple_host_buffer_def_default();
    def.positions = stream_of(third, sizeof third, 0, sizeof third[0]);
    OK(crumple_buffer_set_memory(context, other, &def));
    OK(crumple_context_deform(context, NULL, 0, &report));
    FACT(report.vertices_written == VERTICES && memcmp(vertices[5].position, third[5].position, 12) == 0);

    // Within a budget of one vertex, one buffer is written at a time.
    OK(crumple_context_deform(context, NULL, 0, NULL));
    OK(crumple_context_set_vertex_budget(context, 1));
    OK(crumple_instance_submit_hit(context, body, &hit, NULL));
    OK(crumple_context_deform(context, NULL, 0, &report));
    FACT(report.vertices_written > 0 && report.vertices_waiting > 0);
    OK(crumple_context_deform(context, NULL, 0, &report));
    FACT(report.vertices_written > 0 && report.vertices_waiting == 0);
    for (int v = 0; v < VERTICES; ++v) FACT(memcmp(vertices[v].position, third[v].position, 12) == 0);
    OK(crumple_context_set_vertex_budget(context, 0));
    OK(crumple_buffer_unregister(context, other));
    OK(crumple_instance_destroy(context, body));
    FAILS(CRUMPLE_ERROR_INVALID_ID, "stale", crumple_context_deform(context, &buffer, 1, NULL));
}

static void marks_and_bytes(void) {
    static Vertex vertices[VERTICES], copies[VERTICES];
    CrumpleInstance body = make_instance(context, set), copy = make_instance(context, set);
    CrumpleMark marks[16], again[16];
    CrumpleInstanceInfo info;
    unsigned char bytes[1024], repeated[1024];
    uint32_t count = 0;
    size_t size = 0, repeated_size = 0;
    CrumpleHitResult told, preview;
    register_all(body, vertices);
    register_all(copy, copies);
    for (int i = 0; i < 5; ++i) {
        CrumpleHitDef hit = displacement_at(0.15f * (float)i - 0.3f, 0.1f, 0.02f + 0.005f * (float)i);
        OK(crumple_instance_preview_hit(context, body, &hit, &preview));
        OK(crumple_instance_submit_hit(context, body, &hit, &told));
        FACT(memcmp(&told.mark, &preview.mark, sizeof told.mark) == 0);
        FACT(told.status == CRUMPLE_HIT_STATUS_MARKED && told.expected_error > 0);
        FACT(told.target.z == hit.displacement.z && !told.clamped);
    }
    OK(crumple_instance_get_marks(context, body, NULL, 0, &count));
    FACT(count == 5);
    OK(crumple_instance_get_marks(context, body, marks, 16, &count));
    FACT(count == 5);

    // Marks over the wire.
    OK(crumple_instance_set_marks(context, copy, marks, count));
    OK(crumple_instance_get_marks(context, copy, again, 16, &count));
    FACT(count == 5 && memcmp(marks, again, 5 * sizeof marks[0]) == 0);
    OK(crumple_context_deform(context, NULL, 0, NULL));
    FACT(memcmp(vertices, copies, sizeof vertices) == 0);

    // Saved bytes, also to an odd address.
    OK(crumple_instance_save_damage(context, body, NULL, 0, &size));
    FACT(size == 24 + 5 * 32 + 8);
    OK(crumple_instance_save_damage(context, body, bytes + 1, sizeof bytes - 1, &size));
    OK(crumple_instance_reset_damage(context, copy));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    FACT(memcmp(copies[300].position, sheet.positions[300], 12) == 0);
    OK(crumple_instance_load_damage(context, copy, bytes + 1, size));
    OK(crumple_instance_save_damage(context, copy, repeated, sizeof repeated, &repeated_size));
    FACT(repeated_size == size && memcmp(bytes + 1, repeated, size) == 0);

    // Repair, copy, limits.
    OK(crumple_instance_repair_damage(context, copy, 0.5f));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    FACT(deepest(copies) < 0.6f * deepest(vertices) && deepest(copies) > 0.4f * deepest(vertices));
    OK(crumple_instance_copy_damage(context, copy, body));
    OK(crumple_instance_copy_damage(context, copy, copy));
    OK(crumple_instance_set_depth_limit(context, copy, 0.01f));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    FACT(deepest(copies) <= 0.0100001f && deepest(vertices) > 0.02f);
    OK(crumple_instance_set_depth_limit(context, copy, 0)); // the set's
    OK(crumple_context_deform(context, NULL, 0, NULL));
    FACT(memcmp(vertices, copies, sizeof vertices) == 0);
    OK(crumple_instance_set_marks(context, copy, NULL, 0));
    OK(crumple_instance_get_info(context, copy, &info));
    FACT(info.mark_count == 0 && info.buffer_count == 1 && info.memory_bytes > 0);
    OK(crumple_instance_destroy(context, body));
    OK(crumple_instance_destroy(context, copy));
}

// A mesh's depth limits and stiffness are arrays with strides, and the distance from solids is another depth limit.
// tests/limits.rs checks what they do.
static void limits_of_vertices(void) {
    static float own[VERTICES][2], kept_out[VERTICES]; // own: depth limit, stiffness
    const CrumpleCapsule bar = {vec3(-0.5f, -0.2f, -0.1f), vec3(0.5f, -0.2f, -0.1f), 0.08f};
    static const float corners[4][3] = {{0.1f, 0.1f, -0.2f}, {0.4f, 0.1f, -0.2f}, {0.1f, 0.4f, -0.2f}, {0.1f, 0.1f, 0}};
    static const uint16_t faces[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    CrumpleMeshDef mesh = sheet.mesh, solid = crumple_mesh_def_default();
    CrumpleExampleSetDef def = sheet.def;
    CrumpleExampleSet limited;
    CrumpleHitResult told;
    for (int v = 0; v < VERTICES; ++v) {
        own[v][0] = sheet.positions[v][0] < 0 ? 0.01f : INFINITY;
        own[v][1] = sheet.positions[v][1] > 0.2f ? 1.0f : 0.0f;
    }
    def.mesh = &mesh;
    mesh.depth_limits = input_of(own, sizeof own, sizeof own[0]);
    mesh.stiffness = input_of(&own[0][1], sizeof own - sizeof(float), sizeof own[0]);
    OK(crumple_example_set_create(context, &def, &limited));
    CrumpleInstance body = make_instance(context, limited);
    for (int i = 0; i < 4; ++i) {
        CrumpleHitDef hit = displacement_at(i % 2 ? -0.25f : 0.25f, i < 2 ? -0.25f : 0.25f, 0.05f);
        OK(crumple_instance_submit_hit(context, body, &hit, &told));
        FACT(told.status == (i < 2 ? CRUMPLE_HIT_STATUS_MARKED : CRUMPLE_HIT_STATUS_RIGID));
        FACT(i >= 2 || told.clamped == (i == 1));
    }
    OK(crumple_instance_destroy(context, body));
    OK(crumple_example_set_destroy(context, limited));

    solid.vertex_count = 4;
    solid.positions = input_of(corners, sizeof corners, sizeof corners[0]);
    solid.index_count = 12;
    solid.index_type = CRUMPLE_INDEX_TYPE_U16;
    solid.indices = input_of(faces, sizeof faces, sizeof faces[0]);
    OK(crumple_mesh_keep_out(&mesh, &bar, 1, &solid, 1, kept_out));
    for (int v = 0; v < VERTICES; ++v) {
        const float *p = sheet.positions[v], y = p[1] - bar.a.y, z = p[2] - bar.a.z;
        const float above = p[0] > 0.11f && p[1] > 0.11f && p[0] + p[1] < 0.45f ? p[2] : INFINITY;
        FACT(kept_out[v] <= own[v][0] && kept_out[v] <= sqrtf(y * y + z * z) - bar.radius && kept_out[v] <= above + 0.2f);
        FACT(kept_out[v] > 0);
    }
}

// A hit in the world's space is the hit in the mesh's that the transform makes of it.
static void spaces(void) {
    CrumpleInstance local = make_instance(context, set), world = make_instance(context, set);
    // A quarter turn about z, twice as large, moved by (10, 20, 30).
    const float matrix[16] = {0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, 10, 20, 30, 1};
    CrumpleHitDef hit = crumple_hit_def_default(), there;
    CrumpleHitResult told, told_there;
    OK(crumple_instance_set_transform(context, world, matrix));
    hit.point = vec3(0.25f, 0.125f, 0);
    hit.impulse = vec3(0.5f, 0, -2);
    hit.duration = 0.01f;
    hit.mass = 0.5f;
    there = hit;
    there.space = CRUMPLE_SPACE_WORLD;
    there.point = vec3(10 - 2 * 0.125f, 20 + 2 * 0.25f, 30);
    there.impulse = vec3(0, 1, -4);
    OK(crumple_instance_submit_hit(context, local, &hit, &told));
    OK(crumple_instance_submit_hit(context, world, &there, &told_there));
    FACT(told.contact_vertex == told_there.contact_vertex);
    FACT(fabsf(told.target.z - told_there.target.z) < 1e-7f && fabsf(told.target.x - 0.01f) < 1e-7f);
    FACT(memcmp(&told.mark, &told_there.mark, sizeof told.mark) == 0);
    OK(crumple_instance_destroy(context, local));
    OK(crumple_instance_destroy(context, world));
}

// Zeros are unknown: the impulse is then the striker's momentum. An example's blow has the same fields.
static void blows(void) {
    CrumpleExampleSetDef def = sheet.def;
    CrumpleExampleDef example = sheet.examples[0];
    CrumpleExampleSet made;
    CrumpleExampleSetInfo info;
    CrumpleInstance body = make_instance(context, set);
    CrumpleHitDef hit = crumple_hit_def_default();
    CrumpleHitResult told, momentum;
    FACT(hit.striker.mass == 0 && hit.striker.radius == 0 && hit.striker.velocity.z == 0 && hit.normal.z == 0);
    hit.point = vec3(0, 0, 0.075f);
    hit.duration = 0.01f;
    hit.mass = 1;
    OK(crumple_instance_submit_hit(context, body, &hit, &told));
    FACT(told.status == CRUMPLE_HIT_STATUS_BELOW_YIELD);
    hit.impulse = vec3(2.5f * 0.3f, 0, 2.5f * -1.1f);
    OK(crumple_instance_preview_hit(context, body, &hit, &told));
    hit.impulse = vec3(0, 0, 0);
    hit.normal = vec3(0, 0, 1);
    hit.striker.mass = 2.5f;
    hit.striker.velocity = vec3(0.3f, 0, -1.1f);
    OK(crumple_instance_preview_hit(context, body, &hit, &momentum));
    FACT(momentum.status == CRUMPLE_HIT_STATUS_MARKED && memcmp(&told.mark, &momentum.mark, sizeof told.mark) == 0);
    OK(crumple_instance_destroy(context, body));

    OK(crumple_example_set_get_info(context, set, &info));
    FACT(info.blow_count == 0);
    def.examples = &example;
    def.example_count = 1;
    hit.impulse = example.impulse = vec3(0, 0, -9);
    example.duration = 0.01f;
    example.striker.mass = 2.5f;
    example.striker.radius = 0.08f;
    example.striker.velocity = vec3(0, 0, -4);
    hit.striker = example.striker;
    OK(crumple_example_set_create(context, &def, &made));
    OK(crumple_example_set_get_info(context, made, &info));
    FACT(info.blow_count == 1);
    body = make_instance(context, made);
    OK(crumple_instance_submit_hit(context, body, &hit, &told));
    FACT(told.mark.told == 1 && fabsf(told.achieved.z + 0.05f) < 1e-4f);
    OK(crumple_instance_destroy(context, body));
    OK(crumple_example_set_destroy(context, made));
}

static void yield_and_mass(void) {
    CrumpleExampleSetDef def = sheet.def;
    CrumpleExampleSet heavy;
    CrumpleInstanceDef instance_def = crumple_instance_def_default();
    CrumpleInstance body;
    CrumpleHitDef hit = crumple_hit_def_default();
    CrumpleHitResult told;
    static float masses[VERTICES];
    for (int v = 0; v < VERTICES; ++v) masses[v] = v == VERTICES / 2 ? 4.0f : 1.0f;
    def.options.vertex_masses = input_of(masses, sizeof masses, 4);
    OK(crumple_example_set_create(context, &def, &heavy));
    instance_def.set = heavy;
    instance_def.yield_impulse = 1;
    instance_def.yield_displacement = 0.001f;
    OK(crumple_instance_create(context, &instance_def, &body));
    hit.impulse = vec3(0, 0, -8);
    hit.duration = 0.01f;
    OK(crumple_instance_submit_hit(context, body, &hit, &told)); // the middle: 4 kg
    FACT(told.contact_vertex == VERTICES / 2 && fabsf(told.target.z + 0.02f) < 1e-6f);
    hit.impulse.z = -0.99f;
    OK(crumple_instance_submit_hit(context, body, &hit, &told));
    FACT(told.status == CRUMPLE_HIT_STATUS_BELOW_YIELD && told.mark.hits == 0);
    OK(crumple_instance_destroy(context, body));
    OK(crumple_example_set_destroy(context, heavy));
}

// Hits with one contact id are one dent, whose result outlives it. tests/contacts.rs checks frame rates.
static void contacts(void) {
    CrumpleInstance body = make_instance(context, set);
    CrumpleHitDef push = displacement_at(0.1f, 0.1f, 0.01f);
    CrumpleInstanceInfo info;
    CrumpleHitResult whole;
    FACT(push.contact_id == 0);
    push.contact_id = UINT64_MAX;
    OK(crumple_instance_submit_hit(context, body, &push, NULL));
    OK(crumple_instance_submit_hit(context, body, &push, NULL));
    OK(crumple_instance_get_info(context, body, &info));
    FACT(info.mark_count == 1 && info.contact_count == 1);
    OK(crumple_instance_end_contact(context, body, UINT64_MAX));
    FAILS(CRUMPLE_ERROR_UNKNOWN_CONTACT, "contact_id is 5", crumple_instance_end_contact(context, body, 5));
    OK(crumple_instance_get_contact(context, body, UINT64_MAX, &whole));
    FACT(whole.status == CRUMPLE_HIT_STATUS_MARKED && fabsf(whole.target.z + 0.02f) < 1e-6f);
    FAILS_KEEPING(CRUMPLE_ERROR_UNKNOWN_CONTACT, "contact_id is 12", whole,
                  crumple_instance_get_contact(context, body, 12, &whole));
    OK(crumple_instance_get_info(context, body, &info));
    FACT(info.mark_count == 1 && info.contact_count == 0);
    OK(crumple_instance_destroy(context, body));
}

static void classic_rules(void) {
    static Vertex vertices[VERTICES];
    for (int rule = CRUMPLE_RULE_MOST_DISPLACED; rule <= CRUMPLE_RULE_BLEND; ++rule) {
        CrumpleInstanceDef def = crumple_instance_def_default();
        CrumpleInstance body;
        CrumpleHitDef hit = displacement_at(0, 0, 0.03f);
        CrumpleMark mark;
        uint32_t count = 7;
        def.set = set;
        def.rule = (CrumpleRule)rule;
        def.blend_constant = 0.5f;
        OK(crumple_instance_create(context, &def, &body));
        register_all(body, vertices);
        OK(crumple_instance_submit_hit(context, body, &hit, NULL));
        OK(crumple_context_deform(context, NULL, 0, NULL));
        FACT(fabsf(deepest(vertices) - 0.03f) < 1e-5f);
        FAILS(CRUMPLE_ERROR_WRONG_RULE, "Marks", crumple_instance_get_marks(context, body, &mark, 1, &count));
        FACT(count == 7);
        OK(crumple_instance_destroy(context, body));
    }
}

int main(void) {
    make_sheet(&sheet);
    context = make_context(2);
    OK(crumple_example_set_create(context, &sheet.def, &set));
    interleaved();
    octahedral();
    marks_and_bytes();
    limits_of_vertices();
    spaces();
    blows();
    yield_and_mass();
    contacts();
    classic_rules();
    OK(crumple_context_destroy(context));
    printf("%u checks\n", checks);
    return 0;
}
