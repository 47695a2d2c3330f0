// What the tests share: a sheet with three examples, and checks that say what was expected.
#ifndef SUPPORT_H
#define SUPPORT_H

#include <crumple_build.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static unsigned checks;

#define FACT(condition)                                                                                                \
    do {                                                                                                               \
        ++checks;                                                                                                      \
        if (!(condition)) {                                                                                            \
            fprintf(stderr, "%s:%d: not so: %s (last error: %s)\n", __FILE__, __LINE__, #condition,                    \
                    crumple_last_error());                                                                             \
            exit(1);                                                                                                   \
        }                                                                                                              \
    } while (0)

// The call succeeds.
#define OK(call)                                                                                                       \
    do {                                                                                                               \
        CrumpleResult result_ = (call);                                                                                \
        ++checks;                                                                                                      \
        if (result_ != CRUMPLE_OK) {                                                                                   \
            fprintf(stderr, "%s:%d: %s\n  %s: %s\n", __FILE__, __LINE__, #call, crumple_result_name(result_),          \
                    crumple_last_error());                                                                             \
            exit(1);                                                                                                   \
        }                                                                                                              \
    } while (0)

// The call fails with this result, and the text has this in it.
#define FAILS(expected, part, call) fails((expected), (part), (call), #call, __FILE__, __LINE__)

static inline void fails(CrumpleResult expected, const char *part, CrumpleResult result, const char *call, const char *file,
                         int line) {
    ++checks;
    if (result != expected || !strstr(crumple_last_error(), part)) {
        fprintf(stderr, "%s:%d: %s\n  gives %s: %s\n  expected %s: ...%s...\n", file, line, call, crumple_result_name(result),
                crumple_last_error(), crumple_result_name(expected), part);
        exit(1);
    }
}

// The same, and the output keeps its bytes.
#define FAILS_KEEPING(expected, part, output, call)                                                                    \
    do {                                                                                                               \
        memset(&(output), 0xAB, sizeof(output));                                                                       \
        FAILS(expected, part, call);                                                                                   \
        FACT(keeps(&(output), sizeof(output)));                                                                        \
    } while (0)

static inline int keeps(const void *memory, size_t size) {
    const unsigned char *bytes = (const unsigned char *)memory;
    for (size_t i = 0; i < size; ++i)
        if (bytes[i] != 0xAB) return 0;
    return 1;
}

#ifndef SHEET_SIDE
#define SHEET_SIDE 25
#endif
enum { SIDE = SHEET_SIDE, VERTICES = SIDE * SIDE, INDICES = (SIDE - 1) * (SIDE - 1) * 6, EXAMPLES = 3 };

typedef struct Sheet {
    float positions[VERTICES][3], normals[VERTICES][3], tangents[VERTICES][4];
    float targets[EXAMPLES][VERTICES][3];
    uint32_t indices[INDICES];
    CrumpleExampleDef examples[EXAMPLES];
    CrumpleMeshDef mesh;
    CrumpleExampleSetDef def;
} Sheet;

static inline CrumpleInput input_of(const void *data, size_t size, size_t stride) {
    CrumpleInput input;
    input.data = data;
    input.size = size;
    input.stride = stride;
    return input;
}

static inline CrumpleStream stream_of(void *data, size_t size, size_t offset, size_t stride) {
    CrumpleStream stream;
    stream.data = data;
    stream.size = size;
    stream.offset = offset;
    stream.stride = stride;
    return stream;
}

static inline CrumpleVec3 vec3(float x, float y, float z) {
    CrumpleVec3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

// A crowned sheet of 1 m by 1 m, z up, with dents in three places.
static inline void make_sheet(Sheet *sheet) {
    static const float centres[EXAMPLES][3] = {{0, 0, 0.05f}, {0.25f, 0.2f, 0.03f}, {-0.2f, 0.25f, 0.08f}};
    int i = 0;
    for (int v = 0; v < VERTICES; ++v) {
        float x = (float)(v % SIDE) / (SIDE - 1) - 0.5f, y = (float)(v / SIDE) / (SIDE - 1) - 0.5f;
        float nx = 0.4f * x, ny = 0.2f * y, n = 1 / sqrtf(1 + nx * nx + ny * ny), t = 1 / sqrtf(1 + nx * nx);
        float position[3] = {x, y, 0.2f * (0.25f - x * x) + 0.1f * (0.25f - y * y)};
        float normal[3] = {nx * n, ny * n, n}, tangent[4] = {t, 0, -nx * t, 1};
        memcpy(sheet->positions[v], position, sizeof position);
        memcpy(sheet->normals[v], normal, sizeof normal);
        memcpy(sheet->tangents[v], tangent, sizeof tangent);
        for (int e = 0; e < EXAMPLES; ++e) {
            float dx = x - centres[e][0], dy = y - centres[e][1], r = (dx * dx + dy * dy) / 0.04f;
            if (r < 1) position[2] -= centres[e][2] * (1 - r) * (1 - r);
            memcpy(sheet->targets[e][v], position, sizeof position);
            position[2] = sheet->positions[v][2];
        }
        if (v % SIDE < SIDE - 1 && v / SIDE < SIDE - 1) {
            uint32_t a = (uint32_t)v, quad[6] = {a, a + 1, a + SIDE, a + SIDE, a + 1, a + SIDE + 1};
            for (int k = 0; k < 6; ++k) sheet->indices[i++] = quad[k];
        }
    }
    for (int e = 0; e < EXAMPLES; ++e) {
        sheet->examples[e] = crumple_example_def_default();
        sheet->examples[e].target_positions = input_of(sheet->targets[e], sizeof sheet->targets[e], 12);
        sheet->examples[e].name = "dent";
    }
    sheet->mesh = crumple_mesh_def_default();
    sheet->mesh.vertex_count = VERTICES;
    sheet->mesh.positions = input_of(sheet->positions, sizeof sheet->positions, 12);
    sheet->mesh.normals = input_of(sheet->normals, sizeof sheet->normals, 12);
    sheet->mesh.tangents = input_of(sheet->tangents, sizeof sheet->tangents, 16);
    sheet->mesh.index_count = INDICES;
    sheet->mesh.indices = input_of(sheet->indices, sizeof sheet->indices, 4);
    sheet->def = crumple_example_set_def_default();
    sheet->def.mesh = &sheet->mesh;
    sheet->def.examples = sheet->examples;
    sheet->def.example_count = EXAMPLES;
}

// A path in a folder, until eight more are asked for.
static inline const char *path_in(const char *folder, const char *name) {
    static char paths[8][4096];
    static int next;
    char *path = paths[next++ % 8];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static inline size_t read_file(const char *path, unsigned char *bytes, size_t room) {
    FILE *file = fopen(path, "rb");
    FACT(file != NULL);
    const size_t size = fread(bytes, 1, room, file);
    FACT(size > 0 && size < room && fclose(file) == 0);
    return size;
}

static inline void write_file(const char *path, const void *bytes, size_t size) {
    FILE *file = fopen(path, "wb");
    FACT(file && fwrite(bytes, 1, size, file) == size && fclose(file) == 0);
}

static inline CrumpleContext *make_context(uint32_t threads) {
    CrumpleContextDef def = crumple_context_def_default();
    def.threads = threads;
    CrumpleContext *context = NULL;
    OK(crumple_context_create(&def, &context));
    return context;
}

static inline CrumpleInstance make_instance(CrumpleContext *context, CrumpleExampleSet set) {
    CrumpleInstanceDef def = crumple_instance_def_default();
    def.set = set;
    CrumpleInstance instance;
    OK(crumple_instance_create(context, &def, &instance));
    return instance;
}

// Memory for vertices, interleaved: positions (3 floats), with normals (6), with tangents (10).
static inline CrumpleHostBufferDef host_def(void *memory, size_t vertices, size_t floats) {
    CrumpleHostBufferDef def = crumple_host_buffer_def_default();
    const size_t stride = 4 * floats, size = vertices * stride;
    def.positions = stream_of(memory, size, 0, stride);
    if (floats >= 6) def.normals = stream_of(memory, size, 12, stride);
    if (floats >= 10) def.tangents = stream_of(memory, size, 24, stride);
    return def;
}

static inline CrumpleBuffer make_buffer(CrumpleContext *context, CrumpleInstance instance, CrumpleHostBufferDef def) {
    CrumpleBuffer buffer;
    OK(crumple_buffer_register_host(context, instance, &def, &buffer));
    return buffer;
}

static inline CrumpleHitDef displacement_at(float x, float y, float depth) {
    CrumpleHitDef def = crumple_hit_def_default();
    def.kind = CRUMPLE_HIT_KIND_DISPLACEMENT;
    def.point = vec3(x, y, 0.07f);
    def.displacement = vec3(0, 0, -depth);
    return def;
}

#endif
