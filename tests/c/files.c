// Paths, texts and bytes of files: files FIXTURES FOLDER. What files may say wrongly is in tests/format.rs, import_broken.rs and import_obj.rs.
#include "support.h"

#include <crumple_import.h>

static CrumpleContext *context;
static CrumpleExampleSet set; // out_set of calls that fail
static const char *folder, *fixtures;

// The loaded set is the saved one, and is destroyed.
static void same(uint64_t fingerprint, CrumpleExampleSet loaded) {
    CrumpleExampleSetInfo info;
    OK(crumple_example_set_get_info(context, loaded, &info));
    FACT(info.fingerprint == fingerprint && info.example_count == EXAMPLES);
    OK(crumple_example_set_destroy(context, loaded));
}

static void baked(void) {
    static Sheet sheet;
    CrumpleExampleSet saved, loaded;
    CrumpleExampleSetInfo info;
    size_t size, again;
    make_sheet(&sheet);
    sheet.def.options.bake_tolerance = 1e-4f;
    OK(crumple_example_set_create(context, &sheet.def, &saved));
    OK(crumple_example_set_get_info(context, saved, &info));
    OK(crumple_example_set_save_baked(context, saved, NULL, 0, &size));
    // Of exactly this size and at a multiple of 16, and at an odd address.
    unsigned char *bytes = malloc(size), *shifted = malloc(size + 1);
    FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "data", crumple_example_set_save_baked(context, saved, bytes, size - 1, &again));
    FACT(again == size);
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "data", again, crumple_example_set_save_baked(context, saved, NULL, size, &again));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "out_size", crumple_example_set_save_baked(context, saved, bytes, size, NULL));
    OK(crumple_example_set_save_baked(context, saved, bytes, size, &again));
    FACT(again == size);
    OK(crumple_example_set_destroy(context, saved));

    memcpy(shifted + 1, bytes, size);
    OK(crumple_example_set_load_baked_memory(context, shifted + 1, size, CRUMPLE_BYTES_COPY, &loaded));
    free(shifted);
    same(info.fingerprint, loaded);
    const char *path = path_in(folder, "first_dent.crumple"); // the test first_dent loads it too
    write_file(path, bytes, size);
    OK(crumple_example_set_load_baked(context, path, &loaded));
    same(info.fingerprint, loaded);
    FAILS_KEEPING(CRUMPLE_ERROR_IO, "nowhere", set, crumple_example_set_load_baked(context, path_in(folder, "nowhere"), &set));
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "path", set, crumple_example_set_load_baked(context, NULL, &set));

    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "data", set, crumple_example_set_load_baked_memory(context, NULL, size, CRUMPLE_BYTES_COPY, &set));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "out_set", crumple_example_set_load_baked_memory(context, bytes, size, CRUMPLE_BYTES_COPY, NULL));
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "bytes", set, crumple_example_set_load_baked_memory(context, bytes, size, (CrumpleBytes)7, &set));
    FAILS_KEEPING(CRUMPLE_ERROR_FORMAT, "0 bytes", set, crumple_example_set_load_baked_memory(context, NULL, 0, CRUMPLE_BYTES_KEEP, &set));
    // Kept bytes are needed as long as instances are, not only as long as the id. After that nothing looks at them, which valgrind and the
    // sanitizers would tell.
    OK(crumple_example_set_load_baked_memory(context, bytes, size, CRUMPLE_BYTES_KEEP, &loaded));
    CrumpleInstance instance = make_instance(context, loaded);
    same(info.fingerprint, loaded);
    CrumpleHitDef hit = displacement_at(0.1f, 0.05f, 0.04f);
    OK(crumple_instance_submit_hit(context, instance, &hit, NULL));
    OK(crumple_instance_destroy(context, instance));
    memset(bytes, 0xCD, size);
    free(bytes);
}

static void gltf(void) {
    static unsigned char bytes[1 << 16];
    const char *path = path_in(fixtures, "two_materials.glb");
    const size_t size = read_file(path, bytes, sizeof bytes);
    CrumpleGltfDef def = crumple_gltf_def_default();
    CrumpleExampleSet loaded;
    CrumpleExampleSetInfo info;
    CrumplePart told;
    uint32_t part = 0;
    OK(crumple_example_set_load_gltf_memory(context, bytes, size, &def, &loaded));
    OK(crumple_example_set_get_info(context, loaded, &info));
    FACT(info.vertex_count > 0 && info.example_count > 0 && info.primitive_count > 0 && info.name != NULL);
    // Nothing behind the given size is read.
    unsigned char *cut = malloc(size - 1);
    memcpy(cut, bytes, size - 1);
    FAILS_KEEPING(CRUMPLE_ERROR_FORMAT, "bytes", set, crumple_example_set_load_gltf_memory(context, cut, size - 1, &def, &set));
    free(cut);
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "data", set, crumple_example_set_load_gltf_memory(context, NULL, 10, &def, &set));

    // A body of its nodes. Patterns are one a line.
    def.path = path;
    def.nodes = "Pl?te\r\n";
    def.glass = "Plate";
    OK(crumple_example_set_load_gltf(context, &def, &loaded));
    OK(crumple_example_set_get_info(context, loaded, &info));
    OK(crumple_example_set_find_part(context, loaded, "Plate", &part));
    FACT(info.lod_count == 2 && part == 1);
    OK(crumple_example_set_get_part(context, loaded, part, &told));
    FACT(strcmp(told.name, "Plate") == 0 && told.kind == CRUMPLE_PART_KIND_GLASS);
    FACT(told.first_vertex == 0 && told.vertex_count == info.vertex_count);
    FACT(told.first_triangle == 0 && told.triangle_count == info.triangle_count);
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "part is 0", told, crumple_example_set_get_part(context, loaded, 0, &told));
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "1 to 1", told, crumple_example_set_get_part(context, loaded, 2, &told));
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "Plate", part, crumple_example_set_find_part(context, loaded, "Bumper", &part));

    def = crumple_gltf_def_default();
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "def.path", set, crumple_example_set_load_gltf(context, &def, &set));
    def.path = folder;
    FAILS_KEEPING(CRUMPLE_ERROR_IO, folder, set, crumple_example_set_load_gltf(context, &def, &set));
    def.path = path;
    def.mesh_name = "\xff\xfe";
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "UTF-8", set, crumple_example_set_load_gltf(context, &def, &set));
}

static void obj(void) {
    CrumpleObjDef def = crumple_obj_def_default();
    CrumpleExampleSet loaded;
    CrumpleExampleSetInfo info;
    CrumpleExampleInfo example;
    const char *paths[2] = {path_in(fixtures, "plate_dent.obj"), NULL};
    def.base_path = path_in(fixtures, "plate.obj");
    def.example_paths = paths;
    def.example_count = 1;
    OK(crumple_example_set_load_obj(context, &def, &loaded));
    OK(crumple_example_set_get_info(context, loaded, &info));
    OK(crumple_example_set_get_example(context, loaded, 0, &example));
    FACT(info.vertex_count > 0 && info.triangle_count > 0 && strcmp(example.name, "plate_dent") == 0);
    def.example_count = 2;
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "def.example_paths[1]", set, crumple_example_set_load_obj(context, &def, &set));
    def.example_paths = NULL;
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "def.example_paths", set, crumple_example_set_load_obj(context, &def, &set));
    def.base_path = NULL;
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "def.base_path", set, crumple_example_set_load_obj(context, &def, &set));
    def.struct_size = 1;
    FAILS_KEEPING(CRUMPLE_ERROR_STRUCT_SIZE, "crumple_obj_def_default", set, crumple_example_set_load_obj(context, &def, &set));
}

int main(int count, char **arguments) {
    CrumpleGltfDef gltf_def = crumple_gltf_def_default();
    CrumpleObjDef obj_def = crumple_obj_def_default();
    FACT(count == 3);
    gltf_def.path = obj_def.base_path = fixtures = arguments[1];
    folder = arguments[2];
    context = make_context(1);
    baked();
    if (crumple_features() & CRUMPLE_FEATURE_GLTF)
        gltf();
    else
        FAILS(CRUMPLE_ERROR_UNSUPPORTED, "gltf", crumple_example_set_load_gltf(context, &gltf_def, &set));
    if (crumple_features() & CRUMPLE_FEATURE_OBJ)
        obj();
    else
        FAILS(CRUMPLE_ERROR_UNSUPPORTED, "obj", crumple_example_set_load_obj(context, &obj_def, &set));
    OK(crumple_context_destroy(context));
    printf("%u checks\n", checks);
    return 0;
}
