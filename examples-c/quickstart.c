// A sheet of metal, one example of a dent in its middle, and a hit somewhere else.
#include <crumple_build.h>

#include <math.h>
#include <stdio.h>

enum { SIDE = 41, VERTICES = SIDE * SIDE, INDICES = (SIDE - 1) * (SIDE - 1) * 6 };

static float base[VERTICES][3], dented[VERTICES][3], vertices[VERTICES][6];
static uint32_t indices[INDICES];

static int check(CrumpleResult result) {
    if (result != CRUMPLE_OK)
        fprintf(stderr, "%s: %s\n", crumple_result_name(result), crumple_last_error());
    return result == CRUMPLE_OK;
}

int main(void) {
    // 1. The base mesh, 1 m by 1 m, and the same mesh after a collision: 5 cm deep in the middle.
    for (int v = 0, i = 0; v < VERTICES; ++v) {
        float x = (float)(v % SIDE) / (SIDE - 1) - 0.5f, y = (float)(v / SIDE) / (SIDE - 1) - 0.5f;
        float r = sqrtf(x * x + y * y) / 0.2f, depth = r < 1 ? 0.05f * (1 - r * r) * (1 - r * r) : 0;
        base[v][0] = dented[v][0] = x;
        base[v][1] = dented[v][1] = y;
        dented[v][2] = -depth;
        if (v % SIDE < SIDE - 1 && v / SIDE < SIDE - 1) {
            uint32_t a = (uint32_t)v, quad[6] = {a, a + 1, a + SIDE, a + SIDE, a + 1, a + SIDE + 1};
            for (int k = 0; k < 6; ++k) indices[i++] = quad[k];
        }
    }

    // 2. A context, an example set, and a body in the scene.
    CrumpleContextDef context_def = crumple_context_def_default();
    CrumpleContext *context;
    if (!check(crumple_context_create(&context_def, &context))) return 1;

    CrumpleExampleDef example = crumple_example_def_default();
    example.target_positions = (CrumpleInput){dented, sizeof dented, sizeof dented[0]};
    CrumpleMeshDef mesh = crumple_mesh_def_default();
    mesh.vertex_count = VERTICES;
    mesh.positions = (CrumpleInput){base, sizeof base, sizeof base[0]};
    mesh.index_count = INDICES;
    mesh.indices = (CrumpleInput){indices, sizeof indices, sizeof indices[0]};
    CrumpleExampleSetDef set_def = crumple_example_set_def_default();
    set_def.mesh = &mesh;
    set_def.examples = &example;
    set_def.example_count = 1;
    set_def.options.vertex_mass = 0.5f; // kg
    CrumpleExampleSet set;
    if (!check(crumple_example_set_create(context, &set_def, &set))) return 1;

    CrumpleInstanceDef instance_def = crumple_instance_def_default();
    instance_def.set = set;
    CrumpleInstance instance;
    if (!check(crumple_instance_create(context, &instance_def, &instance))) return 1;

    // 3. Your vertex buffer: position and normal interleaved, 24 bytes a vertex.
    CrumpleHostBufferDef buffer_def = crumple_host_buffer_def_default();
    buffer_def.positions = (CrumpleStream){vertices, sizeof vertices, 0, sizeof vertices[0]};
    buffer_def.normals = (CrumpleStream){vertices, sizeof vertices, 12, sizeof vertices[0]};
    CrumpleBuffer buffer;
    if (!check(crumple_buffer_register_host(context, instance, &buffer_def, &buffer))) return 1;

    // 4. A contact from your physics engine: 2 N s downwards in 10 ms, 25 cm from the middle.
    CrumpleHitDef hit = crumple_hit_def_default();
    hit.point = (CrumpleVec3){0.25f, 0, 0};
    hit.impulse = (CrumpleVec3){0, 0, -2};
    hit.duration = 0.01f;
    CrumpleHitResult told;
    if (!check(crumple_instance_submit_hit(context, instance, &hit, &told))) return 1;

    // 5. Once a frame.
    if (!check(crumple_context_deform(context, NULL, 0, NULL))) return 1;
    const float *contact = vertices[told.contact_vertex];
    printf("vertex %u at (%.2f, %.2f) is dented by %.1f mm\n", told.contact_vertex, contact[0], contact[1], -1000 * contact[2]);
    crumple_context_destroy(context);
    return fabsf(contact[2] + 0.04f) < 1e-4f ? 0 : 1;
}
