// Baked sets: saved, loaded from memory and from a file, kept and copied, damaged: baked FOLDER
#include "support.h"

static CrumpleContext *context;
static Sheet sheet;

static CrumpleExampleSet make(void) {
    CrumpleExampleSet set;
    make_sheet(&sheet);
    sheet.def.options.bake_tolerance = 1e-4f;
    OK(crumple_example_set_create(context, &sheet.def, &set));
    return set;
}

static unsigned char *save(CrumpleExampleSet set, size_t *size) {
    unsigned char *bytes;
    size_t again;
    OK(crumple_example_set_save_baked(context, set, NULL, 0, size));
    // Of exactly this size and at a multiple of 16.
    bytes = malloc(*size);
    FACT(bytes != NULL);
    FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "data", crumple_example_set_save_baked(context, set, bytes, *size - 1, &again));
    FACT(again == *size);
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "data", again, crumple_example_set_save_baked(context, set, NULL, *size, &again));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "out_size", crumple_example_set_save_baked(context, set, bytes, *size, NULL));
    OK(crumple_example_set_save_baked(context, set, bytes, *size, &again));
    FACT(again == *size);
    return bytes;
}

// tests/format.rs checks that loaded sets give the saved one's bits.
static void same(CrumpleExampleSet a, CrumpleExampleSet b) {
    CrumpleExampleSetInfo info, other;
    CrumpleExampleInfo example, other_example;
    OK(crumple_example_set_get_info(context, a, &info));
    OK(crumple_example_set_get_info(context, b, &other));
    FACT(info.fingerprint == other.fingerprint && info.depth_limit == other.depth_limit);
    OK(crumple_example_set_get_example(context, a, 1, &example));
    OK(crumple_example_set_get_example(context, b, 1, &other_example));
    FACT(strcmp(example.name, other_example.name) == 0);
}

static void loading(const char *folder) {
    CrumpleExampleSet set = make(), loaded;
    size_t size;
    unsigned char *bytes = save(set, &size), *shifted = malloc(size + 1);
    char path[4096];
    FILE *file;

    OK(crumple_example_set_load_baked_memory(context, bytes, size, CRUMPLE_BYTES_KEEP, &loaded));
    same(set, loaded);
    OK(crumple_example_set_destroy(context, loaded));

    memcpy(shifted + 1, bytes, size);
    OK(crumple_example_set_load_baked_memory(context, shifted + 1, size, CRUMPLE_BYTES_COPY, &loaded));
    free(shifted);
    same(set, loaded);
    OK(crumple_example_set_destroy(context, loaded));

    snprintf(path, sizeof path, "%s/sheet.crumple", folder);
    file = fopen(path, "wb");
    FACT(file != NULL && fwrite(bytes, 1, size, file) == size && fclose(file) == 0);
    OK(crumple_example_set_load_baked(context, path, &loaded));
    same(set, loaded);
    OK(crumple_example_set_destroy(context, loaded));
    remove(path);
    FAILS_KEEPING(CRUMPLE_ERROR_IO, "sheet.crumple", loaded, crumple_example_set_load_baked(context, path, &loaded));
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "path", loaded, crumple_example_set_load_baked(context, NULL, &loaded));
    // What the test first_dent loads.
    snprintf(path, sizeof path, "%s/first_dent.crumple", folder);
    file = fopen(path, "wb");
    FACT(file != NULL && fwrite(bytes, 1, size, file) == size && fclose(file) == 0);
    OK(crumple_example_set_destroy(context, set));
    free(bytes);
}

// Kept bytes are needed as long as instances are, not only as long as the id.
static void lifetimes(void) {
    CrumpleExampleSet set = make(), loaded;
    CrumpleInstance instance;
    size_t size;
    unsigned char *bytes = save(set, &size);
    OK(crumple_example_set_destroy(context, set));
    OK(crumple_example_set_load_baked_memory(context, bytes, size, CRUMPLE_BYTES_KEEP, &loaded));
    instance = make_instance(context, loaded);
    OK(crumple_example_set_destroy(context, loaded));
    CrumpleHitDef hit = displacement_at(0.1f, 0.05f, 0.04f);
    OK(crumple_instance_submit_hit(context, instance, &hit, NULL));
    OK(crumple_instance_destroy(context, instance));
    // Nothing looks at them any more, which valgrind and the sanitizers would tell.
    memset(bytes, 0xCD, size);
    free(bytes);
}

static void bad_bytes(void) {
    CrumpleExampleSet set = make(), loaded;
    size_t size;
    unsigned char *bytes = save(set, &size), *copy;
    OK(crumple_example_set_destroy(context, set));
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "data", loaded,
                  crumple_example_set_load_baked_memory(context, NULL, size, CRUMPLE_BYTES_COPY, &loaded));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "out_set",
          crumple_example_set_load_baked_memory(context, bytes, size, CRUMPLE_BYTES_COPY, NULL));
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "bytes", loaded,
                  crumple_example_set_load_baked_memory(context, bytes, size, (CrumpleBytes)7, &loaded));
    FAILS_KEEPING(CRUMPLE_ERROR_FORMAT, "0 bytes", loaded,
                  crumple_example_set_load_baked_memory(context, NULL, 0, CRUMPLE_BYTES_KEEP, &loaded));
    // Exactly as long as it says, so that a read past the end is seen.
    copy = malloc(size - 1);
    memcpy(copy, bytes, size - 1);
    FAILS_KEEPING(CRUMPLE_ERROR_FORMAT, "crumple_example_set_load_baked_memory", loaded,
                  crumple_example_set_load_baked_memory(context, copy, size - 1, CRUMPLE_BYTES_KEEP, &loaded));
    free(copy);
    OK(crumple_example_set_load_baked_memory(context, bytes, size, CRUMPLE_BYTES_COPY, &loaded));
    free(bytes);
}

int main(int count, char **arguments) {
    FACT(count == 2);
    context = make_context(2);
    loading(arguments[1]);
    lifetimes();
    bad_bytes();
    OK(crumple_context_destroy(context));
    printf("%u checks\n", checks);
    return 0;
}
