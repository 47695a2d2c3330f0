// Loads a mesh with morph targets, hits it, and writes the dented mesh: dent_gltf IN.glb OUT.obj
#include <crumple_import.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

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

static void print_log(CrumpleLogLevel level, const char *message, void *user) {
    (void)user;
    printf("%s%s\n", level == CRUMPLE_LOG_LEVEL_WARNING ? "warning: " : "", message);
}

typedef struct Vertex {
    float position[3];
    float normal[3];
} Vertex;

static float distance(const float *a, const float *b) {
    float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return sqrtf(x * x + y * y + z * z);
}

static void write_obj(const char *path, const Vertex *vertices, uint32_t vertex_count, const uint32_t *indices,
                      uint32_t triangle_count) {
    FILE *file = fopen(path, "w");
    if (!file) {
        perror(path);
        exit(1);
    }
    for (uint32_t v = 0; v < vertex_count; ++v) {
        const Vertex *at = &vertices[v];
        fprintf(file, "v %g %g %g\nvn %g %g %g\n", at->position[0], at->position[1], at->position[2], at->normal[0],
                at->normal[1], at->normal[2]);
    }
    for (uint32_t t = 0; t < triangle_count; ++t) {
        uint32_t a = indices[3 * t] + 1, b = indices[3 * t + 1] + 1, c = indices[3 * t + 2] + 1;
        fprintf(file, "f %u//%u %u//%u %u//%u\n", a, a, b, b, c, c);
    }
    fact(fclose(file) == 0, "the file was written");
}

int main(int argc, char **argv) {
    if (argc != 3) {
        fprintf(stderr, "usage: dent_gltf IN.glb OUT.obj\n");
        return 2;
    }
    CrumpleContextDef context_def = crumple_context_def_default();
    context_def.log = print_log;
    CrumpleContext *context;
    check(crumple_context_create(&context_def, &context));

    // Load the file's first mesh with morph targets. Each target is an example.
    CrumpleGltfDef file = crumple_gltf_def_default();
    file.path = argv[1];
    CrumpleExampleSet set;
    check(crumple_example_set_load_gltf(context, &file, &set));

    CrumpleExampleSetInfo info;
    check(crumple_example_set_get_info(context, set, &info));
    printf("mesh '%s': %u vertices, %u triangles, %.1f MB, nothing moves further than %.1f mm\n", info.name,
           info.vertex_count, info.triangle_count, (double)info.memory_bytes / 1e6, 1000 * info.depth_limit);
    for (uint32_t i = 0; i < info.primitive_count; ++i) {
        CrumplePrimitive part;
        check(crumple_example_set_get_primitive(context, set, i, &part));
        printf("  material '%s': %u vertices\n", part.material ? part.material : "", part.vertex_count);
    }
    for (uint32_t i = 0; i < info.example_count; ++i) {
        CrumpleExampleInfo example;
        check(crumple_example_set_get_example(context, set, i, &example));
        printf("  example '%s': %.1f mm deep at vertex %u, %u vertices move\n", example.name, 1000 * example.depth,
               example.contact_vertex, example.moved_vertices);
    }

    // The vertex buffer that an engine would draw, in its own layout, filled from the base mesh.
    Vertex *base = calloc(info.vertex_count, sizeof *base), *vertices = calloc(info.vertex_count, sizeof *vertices);
    uint32_t *indices = calloc(info.triangle_count, 3 * sizeof *indices);
    size_t bytes = info.vertex_count * sizeof *vertices;
    CrumpleMeshCopyDef copy = crumple_mesh_copy_def_default();
    copy.positions = (CrumpleStream){base, bytes, offsetof(Vertex, position), sizeof(Vertex)};
    copy.normals = (CrumpleStream){base, bytes, offsetof(Vertex, normal), sizeof(Vertex)};
    copy.indices = (CrumpleStream){indices, info.triangle_count * 3 * sizeof *indices, 0, sizeof *indices};
    check(crumple_example_set_copy_mesh(context, set, &copy));

    CrumpleInstanceDef instance_def = crumple_instance_def_default();
    instance_def.set = set;
    CrumpleInstance instance;
    check(crumple_instance_create(context, &instance_def, &instance));
    CrumpleHostBufferDef buffer_def = crumple_host_buffer_def_default();
    buffer_def.positions = (CrumpleStream){vertices, bytes, offsetof(Vertex, position), sizeof(Vertex)};
    buffer_def.normals = (CrumpleStream){vertices, bytes, offsetof(Vertex, normal), sizeof(Vertex)};
    CrumpleBuffer buffer;
    check(crumple_buffer_register_host(context, instance, &buffer_def, &buffer));

    // Two hits, each 3 cm inwards, at the vertices a quarter and two thirds of the way through the mesh.
    uint32_t hit_vertices[2] = {info.vertex_count / 4, info.vertex_count / 3 * 2};
    for (int i = 0; i < 2; ++i) {
        const Vertex *at = &base[hit_vertices[i]];
        CrumpleHitDef hit = crumple_hit_def_default();
        hit.kind = CRUMPLE_HIT_KIND_DISPLACEMENT;
        hit.point = (CrumpleVec3){at->position[0], at->position[1], at->position[2]};
        hit.displacement = (CrumpleVec3){-0.03f * at->normal[0], -0.03f * at->normal[1], -0.03f * at->normal[2]};
        CrumpleHitResult told;
        check(crumple_instance_submit_hit(context, instance, &hit, &told));
        printf("hit at (%.2f, %.2f, %.2f): expected error %.2f\n", hit.point.x, hit.point.y, hit.point.z, told.expected_error);
        fact(told.status == CRUMPLE_HIT_STATUS_MARKED, "the hit left a mark");
    }

    CrumpleDeformReport report;
    check(crumple_context_deform(context, NULL, 0, &report));
    fact(report.vertices_written == info.vertex_count, "the first deform writes every vertex");
    check(crumple_context_deform(context, NULL, 0, &report));
    fact(report.vertices_written == 0, "the second has nothing to do");

    float deepest = 0;
    for (uint32_t v = 0; v < info.vertex_count; ++v) {
        float moved = distance(vertices[v].position, base[v].position);
        float zero[3] = {0, 0, 0}, length = distance(vertices[v].normal, zero);
        deepest = moved > deepest ? moved : deepest;
        fact(moved <= info.depth_limit * 1.00001f, "no vertex moves further than the depth limit");
        fact(fabsf(length - 1) < 1e-4f, "normals are of unit length");
    }
    for (int i = 0; i < 2; ++i) {
        float moved = distance(vertices[hit_vertices[i]].position, base[hit_vertices[i]].position);
        printf("vertex %u, which was hit, moved by %.1f mm\n", hit_vertices[i], 1000 * moved);
        fact(moved > 0.02f, "the body is dented where it was hit");
    }
    printf("deepest: %.1f mm; written: %s\n", 1000 * deepest, argv[2]);
    write_obj(argv[2], vertices, info.vertex_count, indices, info.triangle_count);

    check(crumple_context_destroy(context));
    free(base);
    free(vertices);
    free(indices);
    return 0;
}
