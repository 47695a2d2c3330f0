// Levels of detail and tolerances through the C interface.
#include "support.h"

#include <crumple_view.h>

enum { FEW = 2 * SIDE, CORNERS = (SIDE - 1) * 6 };

static Sheet sheet;
static float rows[FEW][3];
static uint16_t corners[CORNERS];

// The first rows of the sheet, with indices of 16 bits.
static CrumpleMeshDef first_rows(void) {
    CrumpleMeshDef def = sheet.mesh;
    memcpy(rows, sheet.positions, sizeof rows);
    for (int i = 0; i < CORNERS; ++i) corners[i] = (uint16_t)sheet.indices[i];
    def.vertex_count = FEW;
    def.positions = input_of(rows, sizeof rows, 12);
    def.tangents = input_of(NULL, 0, 0);
    def.indices = input_of(corners, sizeof corners, 2);
    def.index_count = CORNERS;
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
    CrumpleMeshDef def = first_rows(), bad;
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

    static float copy[FEW][3];
    CrumpleMeshCopyDef mesh = crumple_mesh_copy_def_default();
    mesh.lod = 1;
    mesh.positions = stream_of(copy, sizeof copy, 0, 12);
    OK(crumple_example_set_copy_mesh(context, set, &mesh));
    FACT(memcmp(copy, rows, sizeof copy) == 0);
    mesh.lod = 2;
    FAILS(CRUMPLE_ERROR_INDEX_OUT_OF_RANGE, "below 2", crumple_example_set_copy_mesh(context, set, &mesh));

    CrumpleInstance body = make_instance(context, set);
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "before the first instance", crumple_example_set_add_lod(context, set, &def, &lod));
    static float fine[VERTICES][3], few[FEW][3];
    CrumpleBuffer base = register_level(context, body, 0, fine, VERTICES), level = register_level(context, body, 1, few, FEW);
    CrumpleHostBufferDef third = crumple_host_buffer_def_default();
    third.lod = 2;
    third.positions = stream_of(fine, sizeof fine, 0, 12);
    FAILS(CRUMPLE_ERROR_INDEX_OUT_OF_RANGE, "below 2", crumple_buffer_register_host(context, body, &third, &base));
    CrumpleHitDef hit = displacement_at(0.1f, -0.5f, 0.04f);
    OK(crumple_instance_submit_hit(context, body, &hit, NULL));
    CrumpleDeformReport report;
    OK(crumple_context_deform(context, &level, 1, &report));
    FACT(report.vertices_written == FEW);
    OK(crumple_context_deform(context, NULL, 0, &report));
    FACT(report.vertices_written == VERTICES);
    FACT(memcmp(few, fine, sizeof few) == 0 && memcmp(few, rows, sizeof few) != 0);

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
    CrumpleMeshDef def = first_rows();
    uint32_t lod;
    context_def.log = count_warnings;
    context_def.log_user = &warnings;
    OK(crumple_context_create(&context_def, &context));
    OK(crumple_example_set_create(context, &sheet.def, &set));
    OK(crumple_example_set_add_lod(context, set, &def, &lod));
    FACT(warnings == 0);
    for (int v = 0; v < FEW; ++v) rows[v][1] += 22;
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
