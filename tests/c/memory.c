// How much memory loading takes, how often a hit allocates, that frames without hits and resting contacts allocate nothing, and that nothing
// is left of bodies that come and go.
#include "heap.h"
#include "support.h"

#include <crumple_contacts.h>

static Heap heap;
static Sheet sheet;
static unsigned char baked[1 << 20];
static size_t baked_size;

// The most memory of loading, as docs/reliability.md states it.
static void check_peaks(void) {
    CrumpleContext *context = make_context(1);
    CrumpleExampleSet set;
    CrumpleBytes ways[] = {CRUMPLE_BYTES_COPY, CRUMPLE_BYTES_KEEP};
    for (int way = 0; way < 2; ++way) {
        const size_t before = heap.peak = heap.bytes;
        OK(crumple_example_set_load_baked_memory(context, baked, baked_size, ways[way], &set));
        const size_t copy = way == 0 ? baked_size : 0;
        FACT(heap.peak - before <= copy + 70 * VERTICES + EXAMPLES * (18 << 10)); // each vertex is a node
    }
    OK(crumple_context_destroy(context));
}

// Frames without hits allocate nothing. Hits allocate, and where the marks are at their capacity nothing is left of it.
static void check_steady_frames(void) {
    static float vertices[VERTICES][10];
    CrumpleContext *context = make_context(1);
    CrumpleExampleSet set;
    OK(crumple_example_set_load_baked_memory(context, baked, baked_size, CRUMPLE_BYTES_COPY, &set));
    CrumpleInstanceDef def = crumple_instance_def_default();
    CrumpleInstance body;
    def.set = set;
    def.mark_capacity = 16;
    OK(crumple_instance_create(context, &def, &body));
    CrumpleBuffer buffer = make_buffer(context, body, host_def(vertices, VERTICES, 10));
    CrumpleBufferInfo changed[1];
    CrumpleRange ranges[16];
    CrumpleAabb bounds;
    uint32_t buffers, count;
    size_t most = 0;
    unsigned long all = 0;
    for (int frame = 0; frame < 600; ++frame) {
        CrumpleHitDef hit =
            displacement_at((float)(frame * 37 % 101) / 101 - 0.5f, (float)(frame * 61 % 103) / 103 - 0.5f, 0.02f);
        const unsigned long calls = heap.calls;
        OK(crumple_instance_submit_hit(context, body, &hit, NULL));
        OK(crumple_context_deform(context, NULL, 0, NULL));
        // The dent, and those near it that become wider.
        FACT(heap.calls <= calls + 40);
        all += heap.calls - calls;
        OK(crumple_context_get_changed_buffers(context, changed, 1, &buffers));
        FACT(buffers == 1);
        OK(crumple_buffer_get_changes(context, buffer, ranges, 16, &count, &bounds));
        if (frame < 300 && heap.bytes > most) most = heap.bytes;
        // Dents take as much as they have nodes.
        FACT(frame < 300 || heap.bytes <= most + most / 8);
    }
    // Most hits widen none.
    FACT(all <= 600 * 18);
    for (int frame = 0; frame < 100; ++frame) {
        const unsigned long calls = heap.calls;
        OK(crumple_context_deform(context, NULL, 0, NULL));
        OK(crumple_context_get_changed_buffers(context, changed, 1, &buffers));
        FACT(buffers == 0);
        OK(crumple_buffer_get_changes(context, buffer, ranges, 16, &count, &bounds));
        // Debug builds compare the buffers' memory, which takes a list.
        FACT(heap.calls <= calls + 1);
    }
    OK(crumple_context_destroy(context));
}

// A body is hit, saved, loaded, repaired and destroyed, again and again beside one that stays.
static void check_bodies_that_come_and_go(void) {
    static float vertices[2][VERTICES][3];
    CrumpleContext *context = make_context(1);
    CrumpleExampleSet set;
    unsigned char bytes[1024];
    size_t size, before = 0;
    OK(crumple_example_set_load_baked_memory(context, baked, baked_size, CRUMPLE_BYTES_COPY, &set));
    const CrumpleInstance stays = make_instance(context, set);
    make_buffer(context, stays, host_def(vertices[0], VERTICES, 3));
    for (int round = 0; round < 600; ++round) {
        const CrumpleHitDef hit = displacement_at((float)(round * 37 % 101) / 101 - 0.5f, 0.1f, 0.02f);
        const CrumpleInstance body = make_instance(context, set);
        make_buffer(context, body, host_def(vertices[1], VERTICES, 3));
        OK(crumple_instance_submit_hit(context, body, &hit, NULL));
        OK(crumple_context_deform(context, NULL, 0, NULL));
        OK(crumple_instance_save_damage(context, body, bytes, sizeof bytes, &size));
        OK(crumple_instance_load_damage(context, stays, bytes, size));
        OK(crumple_context_deform(context, NULL, 0, NULL));
        OK(crumple_instance_repair_around(context, stays, hit.point, 1, 0));
        OK(crumple_context_deform(context, NULL, 0, NULL));
        OK(crumple_instance_destroy(context, body));
        if (round == 299) before = heap.peak = heap.bytes;
        FACT(round < 300 || heap.bytes <= before);
    }
    OK(crumple_context_destroy(context));
}

// Once as many points came in a step, steps ask for no memory.
static void check_resting_contacts(void) {
    CrumpleContext *context = make_context(1);
    CrumpleExampleSet set;
    CrumpleContactPointDef points[100];
    unsigned long before = 0;
    OK(crumple_example_set_create(context, &sheet.def, &set));
    const CrumpleInstance body = make_instance(context, set);
    for (int i = 0; i < 100; ++i) {
        points[i] = crumple_contact_point_def_default();
        points[i].pair = (uint64_t)(i / 4);
        points[i].bodies[0] = body;
        points[i].point = vec3(0.01f * (float)(i % 4), 0, 0.075f);
        points[i].normal = vec3(0, 0, 1);
        points[i].has_velocity = true;
        points[i].velocity = vec3(0, 0, -0.16f);
        points[i].impulse = 0.3f;
    }
    for (int step = 0; step < 104; ++step) {
        if (step == 4) before = heap.calls;
        OK(crumple_context_report_contacts(context, points, 100));
        OK(crumple_context_step_contacts(context, 1.0f / 60, NULL));
    }
    FACT(heap.calls == before);
    OK(crumple_context_destroy(context));
}

int main(void) {
    if (!use_heap(&heap)) {
        printf("this build has no host allocator\n");
        return 0;
    }
    CrumpleContext *context = make_context(1);
    CrumpleExampleSet set;
    make_sheet(&sheet);
    OK(crumple_example_set_create(context, &sheet.def, &set));
    OK(crumple_example_set_save_baked(context, set, baked, sizeof baked, &baked_size));
    OK(crumple_context_destroy(context));
    check_peaks();
    check_steady_frames();
    check_bodies_that_come_and_go();
    check_resting_contacts();
    FACT(heap.blocks == 0);
    printf("%u checks\n", checks);
    return 0;
}
