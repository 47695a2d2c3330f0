// Damage through the C interface: marks, saving, repair, copies, limits, rules, transforms, what is written and what is not.
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

// The triangles with a vertex in these ranges, and a box around these vertices.
static void changed_triangles(CrumpleBuffer buffer, const Vertex *vertices, const CrumpleRange *written, uint32_t written_count) {
    static CrumpleRange ranges[INDICES / 3];
    bool told[INDICES / 3] = {false};
    CrumpleAabb box;
    uint32_t count = 0;
    OK(crumple_buffer_get_changed_triangles(context, buffer, NULL, 0, &count, NULL));
    FACT(count > 0 && count <= INDICES / 3);
    OK(crumple_buffer_get_changed_triangles(context, buffer, ranges, count, &count, &box));
    for (uint32_t i = 0; i < count; ++i)
        for (uint32_t t = 0; t < ranges[i].count; ++t) told[ranges[i].first + t] = true;
    for (int t = 0; t < INDICES / 3; ++t) {
        bool changed = false;
        for (int k = 0; k < 3; ++k)
            for (uint32_t r = 0; r < written_count; ++r)
                changed = changed || sheet.indices[3 * t + k] - written[r].first < written[r].count;
        FACT(told[t] == changed);
    }
    for (uint32_t r = 0; r < written_count; ++r)
        for (uint32_t v = written[r].first; v < written[r].first + written[r].count; ++v) {
            FACT(vertices[v].position[2] >= box.min.z && vertices[v].position[2] <= box.max.z);
            FACT(sheet.positions[v][0] >= box.min.x && sheet.positions[v][1] <= box.max.y);
        }
}

typedef struct Packed {
    float position[3];
    uint16_t normal[2], tangent[2];
} Packed;

// The unit vector that two numbers of 0 to 1 stand for.
static void unfold(double x, double y, double *v) {
    x = x * 2 - 1, y = y * 2 - 1;
    const double z = 1 - fabs(x) - fabs(y), folded = z < 0 ? -z : 0;
    v[0] = x < 0 ? x + folded : x - folded;
    v[1] = y < 0 ? y + folded : y - folded;
    v[2] = z;
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; ++i) v[i] /= length;
}

static int near_to(const double *a, const float *b) {
    return fabs(a[0] - b[0]) < 2e-4 && fabs(a[1] - b[1]) < 2e-4 && fabs(a[2] - b[2]) < 2e-4;
}

// Octahedral normals and tangents are the floats of another buffer, packed.
static void octahedral(void) {
    static Vertex floats[VERTICES];
    static Packed packed[VERTICES];
    CrumpleInstance body = make_instance(context, set);
    CrumpleHostBufferDef def = crumple_host_buffer_def_default();
    CrumpleBuffer buffer;
    unsigned turned = 0;
    register_all(body, floats);
    def.positions = stream_of(packed, sizeof packed, offsetof(Packed, position), sizeof(Packed));
    def.normals = stream_of(packed, sizeof packed, offsetof(Packed, normal), sizeof(Packed));
    def.tangents = stream_of(packed, sizeof packed, offsetof(Packed, tangent), sizeof(Packed));
    def.normal_format = def.tangent_format = CRUMPLE_DIRECTION_FORMAT_OCTAHEDRAL;
    OK(crumple_buffer_register_host(context, body, &def, &buffer));
    CrumpleHitDef hit = displacement_at(0.1f, 0.05f, 0.04f);
    OK(crumple_instance_submit_hit(context, body, &hit, NULL));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    for (int v = 0; v < VERTICES; ++v) {
        double normal[3], tangent[3];
        const double side = packed[v].tangent[1] / 65535.0 * 2 - 1;
        unfold(packed[v].normal[0] / 65535.0, packed[v].normal[1] / 65535.0, normal);
        unfold(packed[v].tangent[0] / 65535.0, fabs(side), tangent);
        FACT(near_to(normal, floats[v].normal) && near_to(tangent, floats[v].tangent));
        FACT((side > 0) == (floats[v].tangent[3] >= 0));
        FACT(memcmp(packed[v].position, floats[v].position, sizeof packed[v].position) == 0);
        turned += floats[v].normal[2] < 0.999f;
    }
    FACT(turned > 10);
    OK(crumple_instance_destroy(context, body));
}

// Only the registered bytes are written, normals are of unit length, tangents at right angles to them.
static void interleaved(void) {
    static Vertex vertices[VERTICES];
    CrumpleInstance body = make_instance(context, set);
    CrumpleBuffer buffer;
    CrumpleDeformReport report;
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
    changed_triangles(buffer, vertices, ranges, count);

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
    OK(crumple_context_deform(context, NULL, 0, NULL));
    FACT(memcmp(vertices, copies, sizeof vertices) == 0);
    OK(crumple_instance_set_depth_limit(context, copy, 0.01f));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    FACT(deepest(copies) <= 0.0100001f && deepest(vertices) > 0.02f);
    OK(crumple_instance_set_depth_limit(context, copy, 0));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    FACT(memcmp(vertices, copies, sizeof vertices) == 0);
    OK(crumple_instance_set_marks(context, copy, NULL, 0));
    OK(crumple_instance_get_info(context, copy, &info));
    FACT(info.mark_count == 0 && info.buffer_count == 1 && info.memory_bytes > 0);
    OK(crumple_instance_repair_damage(context, body, 0));
    OK(crumple_instance_destroy(context, body));
    OK(crumple_instance_destroy(context, copy));
}

// Vertices with limits of their own: no dent is deeper there than they allow, whatever hits them.
static void vertex_limits(void) {
    static Vertex vertices[VERTICES];
    static float own[VERTICES][2]; // depth limit, stiffness
    CrumpleExampleSetDef def = sheet.def;
    CrumpleMeshDef mesh = sheet.mesh;
    CrumpleExampleSet limited;
    def.mesh = &mesh;
    CrumpleHitResult told;
    for (int v = 0; v < VERTICES; ++v) {
        own[v][0] = sheet.positions[v][0] < 0 ? 0.01f : INFINITY;
        own[v][1] = sheet.positions[v][1] > 0.2f ? 1.0f : 0.0f;
    }
    mesh.depth_limits = input_of(own, sizeof own, sizeof own[0]);
    mesh.stiffness = input_of(&own[0][1], sizeof own - sizeof(float), sizeof own[0]);
    OK(crumple_example_set_create(context, &def, &limited));
    CrumpleInstance body = make_instance(context, limited);
    CrumpleBuffer buffer = register_all(body, vertices);
    for (int i = 0; i < 81; ++i) {
        float x = 0.1f * (float)(i % 9) - 0.4f, y = 0.1f * (float)(i / 9) - 0.4f;
        CrumpleHitDef hit = displacement_at(x, y, 0.05f);
        OK(crumple_instance_submit_hit(context, body, &hit, &told));
        const float *contact = own[told.contact_vertex];
        FACT((told.status == CRUMPLE_HIT_STATUS_RIGID) == (contact[1] == 1));
        if (contact[1] == 0) FACT(told.status == CRUMPLE_HIT_STATUS_MARKED && told.clamped == (contact[0] < 0.05f));
    }
    OK(crumple_context_deform(context, &buffer, 1, NULL));
    for (int v = 0; v < VERTICES; ++v) {
        const float *p = vertices[v].position, *q = sheet.positions[v];
        float moved = sqrtf((p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]) + (p[2] - q[2]) * (p[2] - q[2]));
        FACT(moved <= own[v][0] + 1e-7f && (own[v][1] == 0 || moved == 0));
    }
    FACT(deepest(vertices) > 0.04f);
    OK(crumple_instance_destroy(context, body));
    OK(crumple_example_set_destroy(context, limited));
}

// No dent moves a vertex into a roll cage: a bar under the sheet and a box of twelve triangles.
static void kept_out(void) {
    static Vertex vertices[VERTICES];
    static float limits[VERTICES];
    const CrumpleCapsule bar = {vec3(-0.5f, -0.2f, -0.1f), vec3(0.5f, -0.2f, -0.1f), 0.08f};
    const float low[3] = {0.1f, 0.1f, -0.2f}, high[3] = {0.4f, 0.4f, 0.02f};
    float corners[8][3];
    for (int i = 0; i < 8; ++i)
        for (int k = 0; k < 3; ++k) corners[i][k] = (i >> k & 1) != 0 ? high[k] : low[k];
    const uint16_t faces[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    CrumpleMeshDef box = crumple_mesh_def_default();
    box.vertex_count = 8;
    box.positions = input_of(corners, sizeof corners, sizeof corners[0]);
    box.index_count = 36;
    box.index_type = CRUMPLE_INDEX_TYPE_U16;
    box.indices = input_of(faces, sizeof faces, sizeof faces[0]);
    CrumpleExampleSetDef def = sheet.def;
    CrumpleMeshDef mesh = sheet.mesh;
    OK(crumple_mesh_keep_out(&mesh, &bar, 1, &box, 1, limits));
    def.mesh = &mesh;
    mesh.depth_limits = input_of(limits, sizeof limits, sizeof limits[0]);
    CrumpleExampleSet limited;
    OK(crumple_example_set_create(context, &def, &limited));
    CrumpleInstance body = make_instance(context, limited);
    CrumpleBuffer buffer = register_all(body, vertices);
    for (int i = 0; i < 81; ++i) {
        CrumpleHitDef hit = displacement_at(0.1f * (float)(i % 9) - 0.4f, 0.1f * (float)(i / 9) - 0.4f, 0.2f);
        OK(crumple_instance_submit_hit(context, body, &hit, NULL));
    }
    OK(crumple_context_deform(context, &buffer, 1, NULL));
    for (int v = 0; v < VERTICES; ++v) {
        const float *p = vertices[v].position;
        const float y = p[1] - bar.a.y, z = p[2] - bar.a.z;
        FACT(sqrtf(y * y + z * z) > 0.0799f);
        FACT(p[0] < low[0] || p[0] > high[0] || p[1] < low[1] || p[1] > high[1] || p[2] > high[2] - 1e-4f);
    }
    FACT(deepest(vertices) > 0.02f);

    // Limits that the mesh has are only made less.
    OK(crumple_mesh_keep_out(&mesh, NULL, 0, NULL, 0, limits));
    limits[7] = 0.001f;
    OK(crumple_mesh_keep_out(&mesh, &bar, 1, NULL, 0, limits));
    FACT(limits[7] == 0.001f);
    OK(crumple_instance_destroy(context, body));
    OK(crumple_example_set_destroy(context, limited));
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

// Zeros are unknown: the impulse is then the striker's momentum. Without both, nothing happens.
static void strikers(void) {
    CrumpleInstance body = make_instance(context, set);
    CrumpleHitDef hit = crumple_hit_def_default();
    CrumpleHitResult explicit, momentum;
    FACT(hit.striker.mass == 0 && hit.striker.radius == 0 && hit.striker.velocity.z == 0 && hit.normal.z == 0);
    hit.point = vec3(0.1f, 0.1f, 0);
    hit.duration = 0.01f;
    hit.mass = 1;
    OK(crumple_instance_submit_hit(context, body, &hit, &explicit));
    FACT(explicit.status == CRUMPLE_HIT_STATUS_BELOW_YIELD);
    hit.impulse = vec3(2.5f * 0.3f, 0, 2.5f * -1.1f);
    OK(crumple_instance_preview_hit(context, body, &hit, &explicit));
    hit.impulse = vec3(0, 0, 0);
    hit.normal = vec3(0, 0, 1);
    hit.striker.mass = 2.5f;
    hit.striker.velocity = vec3(0.3f, 0, -1.1f);
    OK(crumple_instance_preview_hit(context, body, &hit, &momentum));
    FACT(momentum.status == CRUMPLE_HIT_STATUS_MARKED);
    FACT(memcmp(&explicit.target, &momentum.target, sizeof explicit.target) == 0);
    FACT(memcmp(&explicit.mark, &momentum.mark, sizeof explicit.mark) == 0);
    OK(crumple_instance_destroy(context, body));
}

// A set whose example knows its blow predicts that blow, and keeps it in baked bytes.
static void blows(void) {
    static unsigned char bytes[1 << 20], repeated[1 << 20];
    CrumpleExampleSetDef def = sheet.def;
    CrumpleExampleDef example = sheet.examples[0];
    CrumpleExampleSet made[2];
    CrumpleExampleSetInfo info;
    CrumpleHitDef hit = crumple_hit_def_default();
    CrumpleHitResult told[2];
    size_t size, repeated_size;
    FACT(example.impulse.z == 0 && example.duration == 0 && example.striker.mass == 0);
    def.examples = &example;
    def.example_count = 1;
    OK(crumple_example_set_create(context, &def, &made[0]));
    OK(crumple_example_set_get_info(context, made[0], &info));
    FACT(info.blow_count == 0);
    OK(crumple_example_set_destroy(context, made[0]));
    hit.impulse = example.impulse = vec3(0, 0, -9);
    example.duration = 0.01f;
    example.striker.mass = 2.5f;
    example.striker.radius = 0.08f;
    example.striker.velocity = vec3(0, 0, -4);
    hit.striker = example.striker;
    hit.point = vec3(0, 0, 0.075f);
    OK(crumple_example_set_create(context, &def, &made[0]));
    OK(crumple_example_set_save_baked(context, made[0], bytes, sizeof bytes, &size));
    OK(crumple_example_set_load_baked_memory(context, bytes, size, CRUMPLE_BYTES_COPY, &made[1]));
    OK(crumple_example_set_save_baked(context, made[1], repeated, sizeof repeated, &repeated_size));
    FACT(size == repeated_size && memcmp(bytes, repeated, size) == 0);
    for (int i = 0; i < 2; ++i) {
        OK(crumple_example_set_get_info(context, made[i], &info));
        FACT(info.blow_count == 1);
        CrumpleInstance body = make_instance(context, made[i]);
        OK(crumple_instance_submit_hit(context, body, &hit, &told[i]));
        FACT(told[i].mark.told == 1 && fabsf(told[i].achieved.z + 0.05f) < 1e-4f);
        OK(crumple_instance_destroy(context, body));
        OK(crumple_example_set_destroy(context, made[i]));
    }
    FACT(memcmp(&told[0].mark, &told[1].mark, sizeof told[0].mark) == 0);
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
    hit.mass = 2;
    OK(crumple_instance_submit_hit(context, body, &hit, &told));
    FACT(fabsf(told.target.z + 0.04f) < 1e-6f);
    hit.impulse.z = -0.99f;
    OK(crumple_instance_submit_hit(context, body, &hit, &told));
    FACT(told.status == CRUMPLE_HIT_STATUS_BELOW_YIELD && told.mark.hits == 0);
    OK(crumple_instance_destroy(context, body));
    OK(crumple_example_set_destroy(context, heavy));
}

// One contact in one report, in eight at 240 Hz, and in two at 30 Hz: the same dent.
static void contacts(void) {
    static Vertex vertices[3][VERTICES];
    const int parts[3] = {1, 8, 2};
    float depths[3];
    for (int way = 0; way < 3; ++way) {
        CrumpleInstance body = make_instance(context, set);
        CrumpleBuffer buffer = register_all(body, vertices[way]);
        CrumpleHitDef hit = crumple_hit_def_default();
        CrumpleInstanceInfo info;
        CrumpleHitResult told;
        FACT(hit.contact_id == 0);
        hit.point = vec3(0.1f, 0.1f, 0);
        hit.impulse = vec3(0, 0, -4.0f / (float)parts[way]);
        hit.duration = 0.01f;
        hit.mass = 1;
        hit.contact_id = UINT64_MAX;
        for (int i = 0; i < parts[way]; ++i) {
            OK(crumple_instance_submit_hit(context, body, &hit, &told));
            FACT(fabsf(told.target.z + 0.04f / (float)parts[way]) < 1e-6f); // what it would do alone
            OK(crumple_context_deform(context, &buffer, 1, NULL));
            OK(crumple_instance_get_info(context, body, &info));
            FACT(info.mark_count == 1 && info.contact_count == 1);
        }
        OK(crumple_instance_end_contact(context, body, hit.contact_id));
        FAILS(CRUMPLE_ERROR_UNKNOWN_CONTACT, "contact_id is 5", crumple_instance_end_contact(context, body, 5));
        OK(crumple_context_deform(context, &buffer, 1, NULL));
        OK(crumple_instance_get_info(context, body, &info));
        FACT(info.mark_count == 1 && info.contact_count == 0);
        depths[way] = deepest(vertices[way]);
        // Ended, the same id is another contact; and the two kinds of hit have the same ids.
        CrumpleHitDef push = displacement_at(0.1f, 0.1f, 0.02f);
        push.contact_id = hit.contact_id;
        OK(crumple_instance_submit_hit(context, body, &push, NULL));
        OK(crumple_instance_get_info(context, body, &info));
        FACT(info.mark_count == 2 && info.contact_count == 1);
        OK(crumple_instance_reset_damage(context, body));
        OK(crumple_instance_get_info(context, body, &info));
        FACT(info.mark_count == 0 && info.contact_count == 0);
        OK(crumple_instance_destroy(context, body));
    }
    FACT(depths[0] > 0.03f && fabsf(depths[1] - depths[0]) < 1e-6f && fabsf(depths[2] - depths[0]) < 1e-6f);
}

// Five frames, each with a contact of its own: a body without a buffer keeps the damage that a body with one shows. More hits
// than marks are kept, so that it also counts when marks merge.
static void visibility(void) {
    static Vertex vertices[VERTICES];
    CrumpleInstanceDef def = crumple_instance_def_default();
    CrumpleInstance body[2];
    unsigned char saved[2][256];
    size_t size[2];
    CrumpleHitResult whole;
    def.set = set;
    def.mark_capacity = 2;
    for (int i = 0; i < 2; ++i) OK(crumple_instance_create(context, &def, &body[i]));
    register_all(body[0], vertices);
    for (int frame = 0; frame < 5; ++frame) {
        for (int i = 0; i < 2; ++i) {
            CrumpleHitDef push = displacement_at(0.1f * (float)(frame % 3), 0.1f, 0.01f);
            push.contact_id = 11;
            OK(crumple_instance_submit_hit(context, body[i], &push, NULL));
            OK(crumple_instance_submit_hit(context, body[i], &push, NULL));
            if (frame == 0) {
                OK(crumple_instance_get_contact(context, body[i], 11, &whole));
                FACT(whole.status == CRUMPLE_HIT_STATUS_MARKED && fabsf(whole.target.z + 0.02f) < 1e-6f);
            }
            OK(crumple_instance_end_contact(context, body[i], 11));
        }
        OK(crumple_context_deform(context, NULL, 0, NULL));
    }
    OK(crumple_instance_get_contact(context, body[0], 11, &whole));
    FACT(whole.status == CRUMPLE_HIT_STATUS_MARKED && fabsf(whole.target.z + 0.02f) < 1e-6f); // it ended
    FAILS_KEEPING(CRUMPLE_ERROR_UNKNOWN_CONTACT, "contact_id is 12", whole,
                  crumple_instance_get_contact(context, body[0], 12, &whole));
    for (int i = 0; i < 2; ++i) OK(crumple_instance_save_damage(context, body[i], saved[i], sizeof saved[i], &size[i]));
    FACT(size[0] == size[1] && memcmp(saved[0], saved[1], size[0]) == 0);
    for (int i = 0; i < 2; ++i) OK(crumple_instance_destroy(context, body[i]));
}

static void classic_rules(void) {
    static Vertex vertices[VERTICES];
    for (int rule = CRUMPLE_RULE_MOST_DISPLACED; rule <= CRUMPLE_RULE_BLEND; ++rule) {
        CrumpleInstanceDef def = crumple_instance_def_default();
        CrumpleInstance body, marked = make_instance(context, set);
        CrumpleHitDef hit = displacement_at(0, 0, 0.03f);
        CrumpleMark mark;
        CrumpleInstanceInfo info;
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
        FAILS(CRUMPLE_ERROR_WRONG_RULE, "Marks", crumple_instance_set_marks(context, body, NULL, 0));
        FAILS(CRUMPLE_ERROR_DAMAGE_MISMATCH, "kind", crumple_instance_copy_damage(context, body, marked));
        OK(crumple_instance_get_info(context, body, &info));
        FACT(info.mark_count == 0 && info.contact_count == 0);
        hit.contact_id = 1;
        FAILS(CRUMPLE_ERROR_WRONG_RULE, "contact id", crumple_instance_submit_hit(context, body, &hit, NULL));
        FAILS(CRUMPLE_ERROR_WRONG_RULE, "Marks", crumple_instance_end_contact(context, body, 1));
        OK(crumple_instance_destroy(context, body));
        OK(crumple_instance_destroy(context, marked));
    }
}

// How far the vertices of a set's body are from an example's, m, after a hit; with the example turned half round about z, if it is said.
static float off_after(CrumpleExampleSet of, const CrumpleHitDef *hit, int example, bool turned) {
    static Vertex vertices[VERTICES];
    float off = 0;
    CrumpleHitResult told;
    CrumpleInstance body = make_instance(context, of);
    register_all(body, vertices);
    OK(crumple_instance_submit_hit(context, body, hit, &told));
    FACT(told.status == CRUMPLE_HIT_STATUS_MARKED);
    OK(crumple_context_deform(context, NULL, 0, NULL));
    for (int v = 0; v < VERTICES; ++v) {
        const float *ought = sheet.targets[example][turned ? VERTICES - 1 - v : v];
        off = fmaxf(off, fabsf(vertices[v].position[2] - ought[2]));
    }
    OK(crumple_instance_destroy(context, body));
    return off;
}

// A hit as an example was made leaves that example.
static void own_hits(void) {
    const float hits[EXAMPLES][3] = {{0, 0, 0.05f}, {0.25f, 0.2f, 0.03f}, {-0.2f, 0.25f, 0.08f}};
    for (int e = 0; e < EXAMPLES; ++e) {
        CrumpleHitDef hit = displacement_at(hits[e][0], hits[e][1], hits[e][2]);
        FACT(off_after(set, &hit, e, false) < 0.005f * hits[e][2]);
    }
}

// The sheet is the same on both sides: the second dent, at (0.25, 0.2), also counts mirrored, at (-0.25, -0.2).
static void mirrored(void) {
    for (int on = 0; on < 2; ++on) {
        CrumpleExampleSetDef def = sheet.def;
        CrumpleExampleSet made;
        CrumpleHitDef hit = displacement_at(-0.25f, -0.2f, 0.03f);
        FACT(def.options.mirror && def.options.held_rims); // the defaults
        def.options.mirror = on;
        OK(crumple_example_set_create(context, &def, &made));
        FACT((off_after(made, &hit, 1, true) < 0.005f * 0.03f) == on);
        OK(crumple_example_set_destroy(context, made));
    }
}

static void attached(void) {
    CrumpleInstance body = make_instance(context, set);
    CrumpleAttachment lamp;
    CrumplePose rest, frame;
    OK(crumple_example_set_attach_point(context, set, vec3(0.05f, 0.02f, 0.2f), &lamp));
    OK(crumple_instance_get_attached_pose(context, body, &lamp, &rest));
    FACT(fabsf(rest.position.z - 0.2f) < 1e-6f && fabsf(rest.rotation.w - 1) < 1e-6f);
    CrumpleHitDef hit = displacement_at(0, 0, 0.05f);
    OK(crumple_instance_submit_hit(context, body, &hit, NULL));
    OK(crumple_instance_get_attached_pose(context, body, &lamp, &frame)); // counts at once
    FACT(frame.position.z < rest.position.z - 0.03f && frame.rotation.w < 1);
    OK(crumple_instance_destroy(context, body));
}

int main(void) {
    make_sheet(&sheet);
    context = make_context(2);
    OK(crumple_example_set_create(context, &sheet.def, &set));
    interleaved();
    octahedral();
    marks_and_bytes();
    vertex_limits();
    kept_out();
    spaces();
    strikers();
    blows();
    yield_and_mass();
    contacts();
    visibility();
    classic_rules();
    own_hits();
    mirrored();
    attached();
    OK(crumple_context_destroy(context));
    printf("%u checks\n", checks);
    return 0;
}
