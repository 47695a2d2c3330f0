// Levels of detail and tolerances through the C interface.
#include "support.h"

#include <crumple_view.h>

enum { COARSE = 13, COARSE_VERTICES = COARSE * COARSE, COARSE_INDICES = (COARSE - 1) * (COARSE - 1) * 6 };

static Sheet sheet;
static float coarse[COARSE_VERTICES][3], coarse_normals[COARSE_VERTICES][3];
static uint16_t coarse_indices[COARSE_INDICES];

// Every second row and column of the sheet.
static CrumpleMeshDef every_second(void) {
    CrumpleMeshDef def = crumple_mesh_def_default();
    int n = 0;
    for (int v = 0; v < COARSE_VERTICES; ++v) {
        int from = v / COARSE * 2 * SIDE + v % COARSE * 2;
        memcpy(coarse[v], sheet.positions[from], 12);
        memcpy(coarse_normals[v], sheet.normals[from], 12);
        if (v % COARSE < COARSE - 1 && v / COARSE < COARSE - 1) {
            int quad[6] = {v, v + 1, v + COARSE, v + COARSE, v + 1, v + COARSE + 1};
            for (int k = 0; k < 6; ++k) coarse_indices[n++] = (uint16_t)quad[k];
        }
    }
    def.vertex_count = COARSE_VERTICES;
    def.positions = input_of(coarse, sizeof coarse, 12);
    def.normals = input_of(coarse_normals, sizeof coarse_normals, 12);
    def.indices = input_of(coarse_indices, sizeof coarse_indices, 2);
    def.index_count = COARSE_INDICES;
    def.index_type = CRUMPLE_INDEX_TYPE_U16;
    return def;
}

static CrumpleBuffer register_level(CrumpleContext *context, CrumpleInstance body, uint32_t lod, float (*positions)[3], size_t count) {
    CrumpleHostBufferDef def = crumple_host_buffer_def_default();
    CrumpleBuffer buffer;
    FACT(def.lod == 0);
    def.lod = lod;
    def.positions = stream_of(positions, count * 12, 0, 12);
    OK(crumple_buffer_register_host(context, body, &def, &buffer));
    return buffer;
}

static void levels(CrumpleContext *context) {
    CrumpleExampleSet set;
    CrumpleExampleSetInfo info;
    CrumpleMeshDef def = every_second(), bad;
    uint32_t lod = 0;
    OK(crumple_example_set_create(context, &sheet.def, &set));
    bad = def;
    bad.struct_size = 3;
    FAILS_KEEPING(CRUMPLE_ERROR_STRUCT_SIZE, "crumple_mesh_def_default", lod, crumple_example_set_add_lod(context, set, &bad, &lod));
    bad = def;
    bad.positions.size = 100;
    FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "mesh.positions", crumple_example_set_add_lod(context, set, &bad, &lod));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "out_lod", crumple_example_set_add_lod(context, set, &def, NULL));
    OK(crumple_example_set_add_lod(context, set, &def, &lod));
    FACT(lod == 1);
    OK(crumple_example_set_get_info(context, set, &info));
    FACT(info.lod_count == 2);

    static float copy[COARSE_VERTICES][3];
    CrumpleMeshCopyDef mesh = crumple_mesh_copy_def_default();
    mesh.lod = 1;
    mesh.positions = stream_of(copy, sizeof copy, 0, 12);
    OK(crumple_example_set_copy_mesh(context, set, &mesh));
    FACT(memcmp(copy, coarse, sizeof copy) == 0);
    mesh.lod = 2;
    FAILS(CRUMPLE_ERROR_INDEX_OUT_OF_RANGE, "below 2", crumple_example_set_copy_mesh(context, set, &mesh));

    CrumpleInstance body = make_instance(context, set);
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "before the first instance", crumple_example_set_add_lod(context, set, &def, &lod));
    static float fine[VERTICES][3], few[COARSE_VERTICES][3];
    CrumpleBuffer base = register_level(context, body, 0, fine, VERTICES), level = register_level(context, body, 1, few, COARSE_VERTICES);
    CrumpleHostBufferDef third = crumple_host_buffer_def_default();
    third.lod = 2;
    third.positions = stream_of(fine, sizeof fine, 0, 12);
    FAILS(CRUMPLE_ERROR_INDEX_OUT_OF_RANGE, "below 2", crumple_buffer_register_host(context, body, &third, &base));
    CrumpleHitDef hit = displacement_at(0.1f, 0.1f, 0.04f);
    OK(crumple_instance_submit_hit(context, body, &hit, NULL));
    CrumpleDeformReport report;
    OK(crumple_context_deform(context, &level, 1, &report));
    FACT(report.vertices_written == COARSE_VERTICES);
    OK(crumple_context_deform(context, NULL, 0, &report));
    FACT(report.vertices_written == VERTICES);
    int moved = 0;
    for (int v = 0; v < COARSE_VERTICES; ++v) {
        FACT(memcmp(few[v], fine[v / COARSE * 2 * SIDE + v % COARSE * 2], 12) == 0);
        moved += memcmp(few[v], coarse[v], 12) != 0;
    }
    FACT(moved > 3);

    uint32_t shown = 7;
    OK(crumple_instance_set_view(context, body, 1, 1e4f, 1, 1080, &shown));
    FACT(shown == 1);
    OK(crumple_instance_set_view(context, body, 0, 1, 1, 1080, &shown));
    FACT(shown == 0);
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "fov_y", crumple_instance_set_view(context, body, 1, 1, 4, 1080, NULL));
}

static void count_warnings(CrumpleLogLevel level, const char *message, void *user) {
    (void)message;
    *(int *)user += level == CRUMPLE_LOG_LEVEL_WARNING;
}

// A level of detail of another body, or in another space, is accepted with a warning.
static void far_off(void) {
    int warnings = 0;
    CrumpleContextDef context_def = crumple_context_def_default();
    CrumpleContext *context;
    CrumpleExampleSet set;
    CrumpleMeshDef def = every_second();
    uint32_t lod;
    context_def.log = count_warnings;
    context_def.log_user = &warnings;
    OK(crumple_context_create(&context_def, &context));
    OK(crumple_example_set_create(context, &sheet.def, &set));
    OK(crumple_example_set_add_lod(context, set, &def, &lod));
    FACT(warnings == 0);
    for (int v = 0; v < COARSE_VERTICES; ++v) coarse[v][1] += 22;
    OK(crumple_example_set_add_lod(context, set, &def, &lod));
    FACT(warnings == 1);
    OK(crumple_context_destroy(context));
}

int main(void) {
    make_sheet(&sheet);
    CrumpleContext *context = make_context(1);
    levels(context);
    OK(crumple_context_destroy(context));
    far_off();
    printf("%u checks\n", checks);
    return 0;
}
