// Every call of a scenario is made with heaps of all sizes, from one that is full up to one that suffices: each time it says
// CRUMPLE_ERROR_OUT_OF_MEMORY and changes nothing, or succeeds. The scenario ends with the bytes that it has without limit.
#include "heap.h"
#include "support.h"

enum { HITS = 24, LARGEST = 1 << 16 };

static Sheet sheet;
static unsigned char baked[1 << 20], gltf[1 << 20];
static size_t baked_size, gltf_size;
static char baked_path[1024], base_path[1024], dent_path[1024];

typedef struct Scene {
    CrumpleContext *context;
    CrumpleExampleSet set;
    CrumpleInstance bodies[2];
    CrumpleBuffer buffers[2];
    CrumpleAttachment lamp;
    CrumpleFrame frame;
    float vertices[2][VERTICES][10];
    CrumpleMark marks[HITS];
    uint32_t mark_count;
    unsigned char damage[LARGEST], archive[LARGEST], changes[LARGEST];
    size_t damage_size, archive_size, changes_size;
    CrumpleRange ranges[16];
    uint32_t range_count, buffer_count;
    CrumpleBuffer changed[2];
    CrumpleExampleSet extra;
    uint32_t lod;
    int hits;
} Scene;

static CrumpleResult create_context(Scene *s) {
    CrumpleContextDef def = crumple_context_def_default();
    def.threads = 1;
    return crumple_context_create(&def, &s->context);
}

static CrumpleResult load_baked(Scene *s) {
    return crumple_example_set_load_baked_memory(s->context, baked, baked_size, CRUMPLE_BYTES_COPY, &s->set);
}

static CrumpleResult create_instance(Scene *s, int i) {
    CrumpleInstanceDef def = crumple_instance_def_default();
    def.set = s->set;
    def.mark_capacity = 16;
    return crumple_instance_create(s->context, &def, &s->bodies[i]);
}

static CrumpleResult load_baked_file(Scene *s) { return crumple_example_set_load_baked(s->context, baked_path, &s->extra); }
static CrumpleResult create_set(Scene *s) { return crumple_example_set_create(s->context, &sheet.def, &s->extra); }

static CrumpleResult add_lod(Scene *s) {
    CrumpleLodDef def = crumple_lod_def_default();
    def.mesh = sheet.def.mesh;
    return crumple_example_set_add_lod(s->context, s->extra, &def, &s->lod);
}

static CrumpleResult save_baked(Scene *s) {
    static unsigned char data[1 << 20];
    size_t size;
    return crumple_example_set_save_baked(s->context, s->extra, data, sizeof data, &size);
}

static CrumpleResult load_gltf(Scene *s) {
    CrumpleGltfDef def = crumple_gltf_def_default();
    return crumple_example_set_load_gltf_memory(s->context, gltf, gltf_size, &def, &s->extra);
}

static CrumpleResult load_obj(Scene *s) {
    CrumpleObjDef def = crumple_obj_def_default();
    const char *dents[] = {dent_path};
    def.base_path = base_path;
    def.example_paths = dents;
    def.example_count = 1;
    return crumple_example_set_load_obj(s->context, &def, &s->extra);
}

static CrumpleResult destroy_set(Scene *s) { return crumple_example_set_destroy(s->context, s->extra); }

static CrumpleResult create_first(Scene *s) { return create_instance(s, 0); }
static CrumpleResult create_second(Scene *s) { return create_instance(s, 1); }

static CrumpleResult register_buffer(Scene *s, int i) {
    CrumpleHostBufferDef def = crumple_host_buffer_def_default();
    def.positions = stream_of(s->vertices[i], sizeof s->vertices[i], 0, 40);
    def.normals = stream_of(s->vertices[i], sizeof s->vertices[i], 12, 40);
    def.tangents = stream_of(s->vertices[i], sizeof s->vertices[i], 24, 40);
    return crumple_buffer_register_host(s->context, s->bodies[i], &def, &s->buffers[i]);
}

static CrumpleResult register_first(Scene *s) { return register_buffer(s, 0); }
static CrumpleResult register_second(Scene *s) { return register_buffer(s, 1); }

static CrumpleResult hit(Scene *s) {
    CrumpleDisplacementDef def =
        displacement_at((float)(s->hits * 37 % 101) / 101 - 0.5f, (float)(s->hits * 61 % 103) / 103 - 0.5f, 0.02f);
    CrumpleResult result = crumple_instance_submit_displacement(s->context, s->bodies[0], &def, NULL);
    s->hits += result == CRUMPLE_OK;
    return result;
}

static CrumpleResult impulses(Scene *s) {
    CrumpleImpulseDef defs[4];
    CrumpleInstance bodies[4];
    for (int i = 0; i < 4; ++i) {
        defs[i] = crumple_impulse_def_default();
        defs[i].point = vec3(0.2f * (float)i - 0.3f, 0.1f, 0.07f);
        defs[i].impulse = vec3(0, 0, -1);
        defs[i].duration = 0.01f;
        defs[i].contact_id = (uint64_t)i / 2;
        bodies[i] = s->bodies[i % 2];
    }
    return crumple_context_submit_impulses(s->context, bodies, defs, 4, NULL);
}

static CrumpleResult end_contact(Scene *s) { return crumple_instance_end_contact(s->context, s->bodies[0], 1); }
static CrumpleResult deform(Scene *s) { return crumple_context_deform(s->context, NULL, 0, NULL); }

static CrumpleResult changed_buffers(Scene *s) {
    return crumple_context_get_changed_buffers(s->context, s->changed, 2, &s->buffer_count);
}

static CrumpleResult changed_ranges(Scene *s) {
    CrumpleAabb bounds;
    return crumple_buffer_get_changes(s->context, s->buffers[0], s->ranges, 16, &s->range_count, &bounds);
}

static CrumpleResult get_marks(Scene *s) {
    return crumple_instance_get_marks(s->context, s->bodies[0], s->marks, HITS, &s->mark_count);
}

static CrumpleResult set_marks(Scene *s) {
    return crumple_instance_set_marks(s->context, s->bodies[1], s->marks, s->mark_count);
}

static CrumpleResult save(Scene *s) {
    return crumple_instance_save_damage(s->context, s->bodies[0], s->damage, LARGEST, &s->damage_size);
}

static CrumpleResult load(Scene *s) {
    return crumple_instance_load_damage(s->context, s->bodies[1], s->damage, s->damage_size);
}

static CrumpleResult save_changes(Scene *s) {
    return crumple_instance_save_changes(s->context, s->bodies[0], 0, s->changes, LARGEST, &s->changes_size);
}

static CrumpleResult save_archive(Scene *s) {
    return crumple_context_save_damage(s->context, s->bodies, 2, s->archive, LARGEST, &s->archive_size);
}

static CrumpleResult load_archive(Scene *s) {
    return crumple_context_load_damage(s->context, s->bodies, 2, s->archive, s->archive_size);
}

static CrumpleResult copy(Scene *s) { return crumple_instance_copy_damage(s->context, s->bodies[1], s->bodies[0]); }

static CrumpleResult repair(Scene *s) {
    return crumple_instance_repair_around(s->context, s->bodies[0], vec3(0.2f, 0.2f, 0.07f), 0.2f, 0.5f);
}

static CrumpleResult attach(Scene *s) {
    return crumple_example_set_attach_point(s->context, s->set, vec3(0.1f, 0.1f, 0.07f), &s->lamp);
}

static CrumpleResult attached_frame(Scene *s) {
    return crumple_instance_get_attached_frame(s->context, s->bodies[0], &s->lamp, &s->frame);
}

static CrumpleResult get_info(Scene *s) {
    CrumpleInstanceInfo info;
    return crumple_instance_get_info(s->context, s->bodies[0], &info);
}

#define STEP(function) {#function, function}
static const struct Step {
    const char *name;
    CrumpleResult (*call)(Scene *);
} steps[] = {
    STEP(create_context),
    // Sets.
    STEP(create_set), STEP(add_lod), STEP(save_baked), STEP(destroy_set),
    STEP(load_gltf), STEP(destroy_set), STEP(load_obj), STEP(destroy_set), STEP(load_baked_file), STEP(destroy_set),
    STEP(load_baked),
    // Hits and frames.
    STEP(create_first), STEP(create_second), STEP(register_first), STEP(deform), STEP(hit), STEP(hit), STEP(hit),
    STEP(deform), STEP(changed_buffers), STEP(changed_ranges), STEP(register_second), STEP(impulses), STEP(impulses),
    STEP(end_contact), STEP(deform), STEP(hit), STEP(get_info), STEP(hit), STEP(hit), STEP(hit), STEP(get_marks),
    STEP(set_marks), STEP(save), STEP(load), STEP(hit), STEP(save_changes), STEP(attach), STEP(hit),
    STEP(attached_frame), STEP(deform),
    STEP(hit), STEP(impulses), STEP(deform), STEP(copy), STEP(repair), STEP(save), STEP(load), STEP(deform),
    // More marks than the capacity.
    STEP(hit), STEP(hit), STEP(hit), STEP(hit), STEP(hit), STEP(hit), STEP(hit), STEP(hit), STEP(hit), STEP(deform),
    STEP(save_archive), STEP(repair), STEP(load_archive), STEP(deform),
};

// Runs the scenario. If limited, each call is made with 1 KiB of memory left, which the error text needs, then with more and more, until it succeeds.
static void run(Scene *s, bool limited) {
    memset(s, 0, sizeof *s);
    for (size_t i = 0; i < sizeof steps / sizeof *steps; ++i) {
        const struct Step *step = &steps[i];
        const size_t before = heap.bytes;
        unsigned refused = 0;
        for (size_t room = 1024;; room += room / 64 + 61) {
            heap.limit = limited ? before + room : 0;
            heap.peak = heap.bytes;
            CrumpleResult result = step->call(s);
            const size_t kept = heap.bytes;
            FACT(result == CRUMPLE_OK || (limited && result == CRUMPLE_ERROR_OUT_OF_MEMORY));
            if (result == CRUMPLE_OK) break;
            FACT(step->call != destroy_set); // what frees memory needs none
            // Once more, so that what is left behind would grow.
            ++refused;
            FACT(step->call(s) == CRUMPLE_ERROR_OUT_OF_MEMORY && heap.bytes == kept);
        }
        heap.limit = 0;
        if (limited) printf("%-16s %5u times out of memory, then %8zu bytes at once\n", step->name, refused, heap.peak - before);
    }
}

static size_t read_file(const char *path, void *data, size_t capacity) {
    FILE *file = fopen(path, "rb");
    FACT(file != NULL);
    size_t size = fread(data, 1, capacity, file);
    FACT(size > 0 && size < capacity);
    fclose(file);
    return size;
}

// The most memory of loading, as docs/reliability.md states it.
static void check_peaks(void) {
    CrumpleContext *context = make_context(1);
    CrumpleExampleSet set;
    CrumpleBytes ways[] = {CRUMPLE_BYTES_COPY, CRUMPLE_BYTES_KEEP};
    for (int way = 0; way < 2; ++way) {
        const size_t before = heap.peak = heap.bytes;
        OK(crumple_example_set_load_baked_memory(context, baked, baked_size, ways[way], &set));
        const size_t copy = way == 0 ? baked_size : 0;
        FACT(heap.peak - before <= copy + (64 << 10) + EXAMPLES * (2 << 10));
    }
    OK(crumple_context_destroy(context));
}

// Frames without hits allocate nothing. Hits allocate, and where the marks are at their capacity nothing is left of it.
static void check_steady_frames(void) {
    static Scene s;
    memset(&s, 0, sizeof s);
    OK(create_context(&s));
    OK(load_baked(&s));
    OK(create_first(&s));
    OK(register_first(&s));
    size_t most = 0;
    for (int frame = 0; frame < 600; ++frame) {
        OK(hit(&s));
        OK(deform(&s));
        OK(changed_buffers(&s));
        FACT(s.buffer_count == 1);
        OK(changed_ranges(&s));
        if (frame < 300 && heap.bytes > most) most = heap.bytes;
        FACT(frame < 300 || heap.bytes <= most + 1024);
    }
    for (int frame = 0; frame < 100; ++frame) {
        const unsigned long calls = heap.calls;
        OK(deform(&s));
        OK(changed_buffers(&s));
        FACT(s.buffer_count == 0);
        OK(changed_ranges(&s));
        // Debug builds compare the buffers' memory, which takes a list.
        FACT(heap.calls <= calls + 1);
    }
    OK(crumple_context_destroy(s.context));
}

int main(int argc, char **argv) {
    static Scene wanted, seen;
    const char *fixtures = argc > 1 ? argv[1] : ".", *folder = argc > 2 ? argv[2] : ".";
    snprintf(base_path, sizeof base_path, "%s/plate.obj", fixtures);
    snprintf(dent_path, sizeof dent_path, "%s/plate_dent.obj", fixtures);
    snprintf(baked_path, sizeof baked_path, "%s/memory.crumple", folder);
    if (!use_heap()) {
        printf("this build has no host allocator\n");
        return 0;
    }

    char path[1100];
    snprintf(path, sizeof path, "%s/two_materials.glb", fixtures);
    gltf_size = read_file(path, gltf, sizeof gltf);
    CrumpleContext *context = make_context(1);
    CrumpleExampleSet set;
    make_sheet(&sheet);
    sheet.def.options.vertex_mass = 0.5f;
    OK(crumple_example_set_create(context, &sheet.def, &set));
    OK(crumple_example_set_save_baked(context, set, baked, sizeof baked, &baked_size));
    OK(crumple_context_destroy(context));
    FILE *file = fopen(baked_path, "wb");
    FACT(file && fwrite(baked, 1, baked_size, file) == baked_size && fclose(file) == 0);

    run(&wanted, false);
    run(&seen, true);
    FACT(memcmp(wanted.vertices, seen.vertices, sizeof wanted.vertices) == 0);
    FACT(wanted.archive_size == seen.archive_size && memcmp(wanted.archive, seen.archive, wanted.archive_size) == 0);
    OK(crumple_context_destroy(wanted.context));
    OK(crumple_context_destroy(seen.context));
    FACT(heap.blocks == 0);
    check_peaks();
    check_steady_frames();
    FACT(heap.blocks == 0);
    printf("%u checks\n", checks);
    return 0;
}
