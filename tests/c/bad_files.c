// Paths, texts and bytes of files through the C interface: bad_files GLB FOLDER. tests/import_broken.rs has what files may say wrongly.
#include "support.h"

#include <crumple_import.h>

static CrumpleContext *context;
static CrumpleExampleSet set;

static unsigned char *slurp(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    if (!file) {
        perror(path);
        exit(1);
    }
    FACT(fseek(file, 0, SEEK_END) == 0);
    *size = (size_t)ftell(file);
    rewind(file);
    unsigned char *bytes = malloc(*size);
    FACT(fread(bytes, 1, *size, file) == *size);
    fclose(file);
    return bytes;
}

static void gltf(const char *path, const char *folder) {
    CrumpleGltfDef def = crumple_gltf_def_default();
    CrumpleExampleSetInfo info;
    size_t size;
    unsigned char *bytes = slurp(path, &size);

    OK(crumple_example_set_load_gltf_memory(context, bytes, size, &def, &set));
    OK(crumple_example_set_get_info(context, set, &info));
    FACT(info.vertex_count > 0 && info.example_count > 0 && info.primitive_count > 0 && info.name != NULL);
    OK(crumple_example_set_destroy(context, set));
    def.path = path;
    OK(crumple_example_set_load_gltf(context, &def, &set));
    OK(crumple_example_set_destroy(context, set));

    // A body of its nodes.
    uint32_t part = 0;
    def.join_nodes = true;
    OK(crumple_example_set_load_gltf(context, &def, &set));
    OK(crumple_example_set_get_info(context, set, &info));
    OK(crumple_example_set_find_part(context, set, "Plate", &part));
    FACT(info.lod_count == 2 && part == 1);
    CrumplePart told;
    OK(crumple_example_set_get_part(context, set, part, &told));
    FACT(strcmp(told.name, "Plate") == 0 && told.kind == CRUMPLE_PART_KIND_DENTS);
    FACT(told.first_vertex == 0 && told.vertex_count == info.vertex_count);
    FACT(told.first_triangle == 0 && told.triangle_count == info.triangle_count);
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "part is 0", told, crumple_example_set_get_part(context, set, 0, &told));
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "1 to 1", told, crumple_example_set_get_part(context, set, 2, &told));
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "Plate", part, crumple_example_set_find_part(context, set, "Bumper", &part));
    OK(crumple_example_set_destroy(context, set));
    def.join_nodes = false;

    // Kinds of parts.
    def.join_nodes = true;
    def.glass = "Plate";
    OK(crumple_example_set_load_gltf(context, &def, &set));
    OK(crumple_example_set_get_part(context, set, 1, &told));
    FACT(told.kind == CRUMPLE_PART_KIND_GLASS);
    OK(crumple_example_set_destroy(context, set));
    def.glass = NULL;
    def.join_nodes = false;

    // Patterns, one a line.
    def.nodes = "!nothing of that name\nPl?te";
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "nothing of that name", set,
                  crumple_example_set_load_gltf(context, &def, &set));
    def.nodes = "Pl?te\r\n";
    OK(crumple_example_set_load_gltf(context, &def, &set));
    OK(crumple_example_set_destroy(context, set));
    def.nodes = NULL;
    def.targets = "no such target";
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "no such target", set,
                  crumple_example_set_load_gltf(context, &def, &set));
    def.targets = NULL;

    // Choosing a mesh.
    def.mesh_name = "no such mesh";
    FAILS_KEEPING(CRUMPLE_ERROR_FORMAT, "no such mesh", set, crumple_example_set_load_gltf(context, &def, &set));
    def.mesh_name = "\xff\xfe";
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "UTF-8", set, crumple_example_set_load_gltf(context, &def, &set));
    def.mesh_name = NULL;
    def.mesh_index = 1000;
    FAILS_KEEPING(CRUMPLE_ERROR_FORMAT, "1000", set, crumple_example_set_load_gltf(context, &def, &set));

    // Paths.
    def = crumple_gltf_def_default();
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "def.path", set, crumple_example_set_load_gltf(context, &def, &set));
    def.path = "no/such/file.glb";
    FAILS_KEEPING(CRUMPLE_ERROR_IO, "no/such/file.glb", set, crumple_example_set_load_gltf(context, &def, &set));
    def.path = folder;
    FAILS_KEEPING(CRUMPLE_ERROR_IO, folder, set, crumple_example_set_load_gltf(context, &def, &set));
    def.path = "";
    FAILS_KEEPING(CRUMPLE_ERROR_IO, "crumple_example_set_load_gltf", set, crumple_example_set_load_gltf(context, &def, &set));

    // Bytes: nothing behind the given size is read.
    FAILS_KEEPING(CRUMPLE_ERROR_FORMAT, "the file is empty", set,
                  crumple_example_set_load_gltf_memory(context, bytes, 0, &def, &set));
    unsigned char *cut = malloc(size - 1);
    memcpy(cut, bytes, size - 1);
    FAILS_KEEPING(CRUMPLE_ERROR_FORMAT, "bytes", set, crumple_example_set_load_gltf_memory(context, cut, size - 1, &def, &set));
    free(cut);
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "data", set,
                  crumple_example_set_load_gltf_memory(context, NULL, 10, &def, &set));
    free(bytes);
}

static void obj(const char *folder) {
    CrumpleObjDef def = crumple_obj_def_default();
    char base[1024], dent[1024];
    const char *paths[2] = {dent, NULL};
    FILE *file;
    snprintf(base, sizeof base, "%s/base.obj", folder);
    snprintf(dent, sizeof dent, "%s/dent.obj", folder);
    FACT((file = fopen(base, "w")) != NULL);
    fputs("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", file);
    fclose(file);
    FACT((file = fopen(dent, "w")) != NULL);
    fputs("v 0 0 -0.1\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", file);
    fclose(file);

    CrumpleExampleSetInfo info;
    CrumpleExampleInfo example;
    def.base_path = base;
    def.example_paths = paths;
    def.example_count = 1;
    OK(crumple_example_set_load_obj(context, &def, &set));
    OK(crumple_example_set_get_info(context, set, &info));
    OK(crumple_example_set_get_example(context, set, 0, &example));
    FACT(info.vertex_count == 4 && info.triangle_count == 2 && strcmp(example.name, "dent") == 0);
    OK(crumple_example_set_destroy(context, set));

    def.example_count = 2;
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "def.example_paths[1]", set, crumple_example_set_load_obj(context, &def, &set));
    paths[1] = "no/such.obj";
    FAILS_KEEPING(CRUMPLE_ERROR_IO, "no/such.obj", set, crumple_example_set_load_obj(context, &def, &set));
    def.example_paths = NULL;
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "def.example_paths", set, crumple_example_set_load_obj(context, &def, &set));
    def.base_path = NULL;
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "def.base_path", set, crumple_example_set_load_obj(context, &def, &set));
    def = crumple_obj_def_default();
    def.base_path = base;
    FAILS_KEEPING(CRUMPLE_ERROR_EXAMPLE_MISMATCH, "example", set, crumple_example_set_load_obj(context, &def, &set));
    def.struct_size = 1;
    FAILS_KEEPING(CRUMPLE_ERROR_STRUCT_SIZE, "crumple_obj_def_default", set, crumple_example_set_load_obj(context, &def, &set));
}

int main(int argc, char **argv) {
    CrumpleGltfDef gltf_def = crumple_gltf_def_default();
    CrumpleObjDef obj_def = crumple_obj_def_default();
    if (argc != 3) return 2;
    context = make_context(1);
    if (crumple_features() & CRUMPLE_FEATURE_GLTF)
        gltf(argv[1], argv[2]);
    else {
        gltf_def.path = argv[1];
        FAILS(CRUMPLE_ERROR_UNSUPPORTED, "gltf", crumple_example_set_load_gltf(context, &gltf_def, &set));
    }
    if (crumple_features() & CRUMPLE_FEATURE_OBJ)
        obj(argv[2]);
    else {
        obj_def.base_path = argv[1];
        FAILS(CRUMPLE_ERROR_UNSUPPORTED, "obj", crumple_example_set_load_obj(context, &obj_def, &set));
    }
    OK(crumple_context_destroy(context));
    printf("%u checks\n", checks);
    return 0;
}
