// Thousands of bodies share one example set. A frame hits some of them and deforms the few that are visible.
#include <crumple_build.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { SIDE = 65, VERTICES = SIDE * SIDE, INDICES = (SIDE - 1) * (SIDE - 1) * 6 };
enum { INSTANCES = 5000, SEEN = 50, HITS = 20000 };

static float base[VERTICES][3], dented[VERTICES][3];
static float vertices[SEEN][VERTICES][3];
static uint32_t indices[INDICES];
static CrumpleInstance instances[INSTANCES];
static CrumpleBuffer buffers[SEEN];

static void check(CrumpleResult result) {
    if (result == CRUMPLE_OK) return;
    fprintf(stderr, "%s: %s\n", crumple_result_name(result), crumple_last_error());
    exit(1);
}

static void fact(int holds, const char *what) {
    if (holds) return;
    fprintf(stderr, "this is not so: %s\n", what);
    exit(1);
}

static double milliseconds(clock_t since) {
    return 1e3 * (double)(clock() - since) / CLOCKS_PER_SEC;
}

static float unit_random(void) {
    static uint32_t state = 12345;
    state = state * 1664525u + 1013904223u;
    return (float)(state >> 8) / (float)(1 << 24);
}

int main(void) {
    for (int v = 0, i = 0; v < VERTICES; ++v) {
        float x = (float)(v % SIDE) / (SIDE - 1) - 0.5f, y = (float)(v / SIDE) / (SIDE - 1) - 0.5f;
        float r = (x * x + y * y) / 0.03f;
        base[v][0] = dented[v][0] = x;
        base[v][1] = dented[v][1] = y;
        base[v][2] = 0;
        dented[v][2] = r < 1 ? -0.05f * (1 - r) * (1 - r) : 0;
        if (v % SIDE < SIDE - 1 && v / SIDE < SIDE - 1) {
            uint32_t a = (uint32_t)v, quad[6] = {a, a + 1, a + SIDE, a + SIDE, a + 1, a + SIDE + 1};
            for (int k = 0; k < 6; ++k) indices[i++] = quad[k];
        }
    }
    CrumpleContextDef context_def = crumple_context_def_default();
    CrumpleContext *context;
    check(crumple_context_create(&context_def, &context));
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
    CrumpleExampleSet set;
    check(crumple_example_set_create(context, &set_def, &set));
    CrumpleExampleSetInfo set_info;
    check(crumple_example_set_get_info(context, set, &set_info));

    clock_t start = clock();
    CrumpleInstanceDef instance_def = crumple_instance_def_default();
    instance_def.set = set;
    for (int i = 0; i < INSTANCES; ++i) check(crumple_instance_create(context, &instance_def, &instances[i]));
    printf("%d instances created in %.1f ms\n", INSTANCES, milliseconds(start));
    check(crumple_example_set_destroy(context, set)); // the instances keep its memory

    // Only a few bodies are visible. Only those have buffers.
    for (int i = 0; i < SEEN; ++i) {
        CrumpleHostBufferDef def = crumple_host_buffer_def_default();
        def.positions = (CrumpleStream){vertices[i], sizeof vertices[i], 0, sizeof vertices[i][0]};
        check(crumple_buffer_register_host(context, instances[i], &def, &buffers[i]));
    }

    start = clock();
    for (int i = 0; i < HITS; ++i) {
        CrumpleHitDef hit = crumple_hit_def_default();
        hit.kind = CRUMPLE_HIT_KIND_DISPLACEMENT;
        hit.point = (CrumpleVec3){unit_random() - 0.5f, unit_random() - 0.5f, 0};
        hit.displacement = (CrumpleVec3){0, 0, -0.01f - 0.03f * unit_random()};
        check(crumple_instance_submit_hit(context, instances[i % INSTANCES], &hit, NULL));
    }
    double time = milliseconds(start);
    printf("%d hits submitted in %.1f ms: %.2f us each\n", HITS, time, 1e3 * time / HITS);

    start = clock();
    CrumpleDeformReport report;
    check(crumple_context_deform(context, buffers, SEEN, &report));
    time = milliseconds(start);
    printf("%d instances seen, %llu vertices written in %.1f ms (of all cores)\n", SEEN,
           (unsigned long long)report.vertices_written, time);
    fact(report.vertices_written == (uint64_t)SEEN * VERTICES, "the first deform writes every vertex of what is seen");

    // After one more hit, only the blocks that it touched are written.
    CrumpleHitDef hit = crumple_hit_def_default();
    hit.kind = CRUMPLE_HIT_KIND_DISPLACEMENT;
    hit.point = (CrumpleVec3){0.3f, 0.3f, 0};
    hit.displacement = (CrumpleVec3){0, 0, -0.02f};
    check(crumple_instance_submit_hit(context, instances[7], &hit, NULL));
    start = clock();
    check(crumple_context_deform(context, buffers, SEEN, &report));
    printf("one more hit: %llu vertices written in %.2f ms\n", (unsigned long long)report.vertices_written,
           milliseconds(start));
    fact(report.vertices_written > 0 && report.vertices_written < VERTICES, "one hit writes a part of one instance");

    uint64_t memory = 0, marks = 0;
    for (int i = 0; i < INSTANCES; ++i) {
        CrumpleInstanceInfo info;
        check(crumple_instance_get_info(context, instances[i], &info));
        memory += info.memory_bytes;
        marks += info.mark_count;
    }
    double kilobyte = 1024;
    printf("memory: %.1f kB for the set, %.2f kB for each instance with %.1f marks\n",
           (double)set_info.memory_bytes / kilobyte, (double)memory / INSTANCES / kilobyte, (double)marks / INSTANCES);
    fact(marks == HITS + 1, "every hit left a mark");
    fact(memory / INSTANCES < 2 * sizeof dented, "an instance takes less memory than a copy of its positions and normals");
    for (int i = 0; i < SEEN; ++i)
        for (int v = 0; v < VERTICES; ++v)
            fact(fabsf(vertices[i][v][2]) <= 0.066668f, "no vertex moves further than 4/3 of the deepest example");
    check(crumple_context_destroy(context));
    return 0;
}
