// Recordings through the C interface: the file's contents, and refused calls. The fixture tests/fixtures/sheet.crumplerec is the
// file that this program writes. When the format changes, run `cargo xtask test --only install --only ctest` and copy it from the
// build folder, target/ctest/release/tests-c.
#include "support.h"

static Sheet sheet;
static float vertices[VERTICES][6], elsewhere[VERTICES][3];
static float slow[VERTICES][3];

static long size_of_file(const char *path) {
    FILE *file = fopen(path, "rb");
    long size;
    if (!file) return -1;
    fseek(file, 0, SEEK_END);
    size = ftell(file);
    fclose(file);
    return size;
}

static CrumpleImpulseDef impulse_at(float x, float y, float strength) {
    CrumpleImpulseDef def = crumple_impulse_def_default();
    def.point = vec3(x, y, 0.07f);
    def.impulse = vec3(0, 0, -strength);
    def.duration = 0.01f;
    return def;
}

int main(int argc, char **argv) {
    const char *path = argc > 1 ? argv[1] : "sheet.crumplerec";
    CrumpleContext *context = make_context(1);
    CrumpleExampleSet set;
    CrumpleInstance body, other;
    CrumpleBuffer buffer, second;
    CrumpleHostBufferDef def = crumple_host_buffer_def_default();
    CrumpleMark marks[8];
    uint32_t count;
    unsigned char bytes[1024], changes[1024];
    size_t size, changes_size;
    long empty, begun, hit_size;
    remove(path);

    make_sheet(&sheet);
    sheet.def.options.vertex_mass = 0.5f;
    sheet.def.options.bake_tolerance = 1e-4f;
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "no recording runs", crumple_recording_end(context));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "context is null", crumple_recording_begin(NULL, path));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "path is null", crumple_recording_begin(context, NULL));
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "path is not UTF-8", crumple_recording_begin(context, "\xff\xfe"));
    FAILS(CRUMPLE_ERROR_IO, "no-such-folder", crumple_recording_begin(context, "no-such-folder/file"));

    // An empty context, then one with a set: the file holds it whole.
    OK(crumple_recording_begin(context, path));
    empty = size_of_file(path);
    OK(crumple_recording_end(context));
    OK(crumple_example_set_create(context, &sheet.def, &set));
    body = make_instance(context, set);
    CrumpleImpulseDef hit = impulse_at(0.1f, 0.1f, 1);
    OK(crumple_instance_submit_impulse(context, body, &hit, NULL));
    OK(crumple_recording_begin(context, path));
    begun = size_of_file(path);
    FACT(empty > 0 && empty < 100 && begun > VERTICES * 12);
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "runs already", crumple_recording_begin(context, path));

    // Every call is in the file when it returns.
    hit = impulse_at(-0.3f, -0.2f, 1.5f);
    OK(crumple_instance_submit_impulse(context, body, &hit, NULL));
    hit_size = size_of_file(path) - begun;
    FACT(hit_size > 40 && hit_size < 400);
    def.positions = stream_of(vertices, sizeof vertices, 0, sizeof vertices[0]);
    def.normals = stream_of(vertices, sizeof vertices, 12, sizeof vertices[0]);
    OK(crumple_buffer_register_host(context, body, &def, &buffer));
    OK(crumple_context_deform(context, NULL, 0, NULL));

    other = make_instance(context, set);
    def = crumple_host_buffer_def_default();
    def.positions = stream_of(elsewhere, sizeof elsewhere, 0, sizeof elsewhere[0]);
    OK(crumple_buffer_register_host(context, other, &def, &second));
    OK(crumple_instance_copy_damage(context, other, body));
    for (int frame = 0; frame < 20; ++frame) {
        hit = impulse_at(0.04f * (float)frame - 0.4f, 0.2f, 0.05f + 0.01f * (float)frame);
        hit.contact_id = 1 + (uint64_t)(frame / 10);
        OK(crumple_instance_submit_impulse(context, body, &hit, NULL));
        if (frame == 9) OK(crumple_instance_end_contact(context, body, 1));
        OK(crumple_context_deform(context, NULL, 0, NULL));
    }
    OK(crumple_instance_get_marks(context, body, marks, 8, &count));
    FACT(count == 4);
    FAILS(CRUMPLE_ERROR_DAMAGE_MISMATCH, "saved damage", crumple_instance_load_damage(context, other, "nonsense", 8));
    FAILS(CRUMPLE_ERROR_NOT_FINITE, "keep", crumple_instance_repair_damage(context, body, NAN));
    OK(crumple_instance_repair_damage(context, body, 0.5f));
    OK(crumple_context_deform(context, &buffer, 1, NULL));
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "runs already", crumple_recording_begin(context, path));
    OK(crumple_recording_end(context));

    // What comes after is not in it. Destroying a context ends its recording too, and a context cannot stop another's.
    begun = size_of_file(path);
    OK(crumple_instance_reset_damage(context, body));
    FACT(size_of_file(path) == begun);
    CrumpleContext *another = make_context(1);
    OK(crumple_recording_begin(context, path));
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "no recording runs", crumple_recording_end(another));
    OK(crumple_context_destroy(another));
    OK(crumple_recording_end(context));

    // The whole of it once more, so that the file is that of the fixture.
    OK(crumple_recording_begin(context, path));
    hit = impulse_at(0.1f, 0.1f, 1);
    OK(crumple_instance_submit_impulse(context, body, &hit, NULL));
    for (int frame = 0; frame < 20; ++frame) {
        hit = impulse_at(0.04f * (float)frame - 0.4f, 0.2f, 0.05f + 0.01f * (float)frame);
        hit.contact_id = 1 + (uint64_t)(frame / 10);
        OK(crumple_instance_submit_impulse(context, body, &hit, NULL));
        OK(crumple_context_deform(context, NULL, 0, NULL));
    }
    // Calls about many things, and a dent that is half grown.
    CrumpleInstanceDef slow_def = crumple_instance_def_default();
    slow_def.set = set;
    slow_def.grow_time = 1;
    CrumpleInstance many[2] = {body, body};
    OK(crumple_context_set_time(context, 2));
    OK(crumple_instance_create(context, &slow_def, &many[1]));
    def.positions = stream_of(slow, sizeof slow, 0, sizeof slow[0]);
    OK(crumple_buffer_register_host(context, many[1], &def, &second));
    CrumpleImpulseDef hits[2] = {impulse_at(0.3f, 0.3f, 1), impulse_at(-0.3f, 0.3f, 1)};
    OK(crumple_context_submit_impulses(context, many, hits, 2, NULL));
    hits[1].point.x = 90;
    FAILS(CRUMPLE_ERROR_CONTACT_TOO_FAR, "hit 1", crumple_context_submit_impulses(context, many, hits, 2, NULL));
    OK(crumple_context_save_damage(context, many, 2, bytes, sizeof bytes, &size));
    OK(crumple_context_set_time(context, 2.5));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    OK(crumple_instance_save_changes(context, body, 0, changes, sizeof changes, &changes_size));
    OK(crumple_instance_repair_around(context, body, vec3(0.3f, 0.3f, 0.07f), 0.2f, 0.5f));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    OK(crumple_context_load_damage(context, many, 2, bytes, size));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    FAILS(CRUMPLE_ERROR_NOT_FINITE, "keep", crumple_instance_repair_damage(context, body, NAN));
    OK(crumple_instance_get_marks(context, body, marks, 8, &count));
    OK(crumple_context_destroy(context));
    FACT(size_of_file(path) > begun / 2);
    printf("%u checks, all so\n", checks);
    return 0;
}
