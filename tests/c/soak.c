// Random hits, frames, saves, loads, repairs, and bodies that come and go, for as long as is asked:
//
//   soak [SECONDS [BODIES [SEED]]]
//
// It fails if the memory grows, or if a body's vertices are not those that a new body gets from its marks. `cargo xtask soak` runs it.
#include "heap.h"
#include "support.h"

#include <time.h>

enum { MOST_BODIES = 1000 };

static Heap heap;
static Sheet sheet;
static float vertices[MOST_BODIES + 1][VERTICES][10];
static CrumpleInstance bodies[MOST_BODIES];

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static CrumpleInstance make_body(CrumpleContext *context, CrumpleExampleSet set, unsigned at) {
    CrumpleInstance body = make_instance(context, set);
    make_buffer(context, body, host_def(vertices[at], VERTICES, 10));
    return body;
}

// A new body that is given the marks has the same vertices and the same bytes of damage.
static void compare_with_replay(CrumpleContext *context, CrumpleExampleSet set, unsigned at) {
    static CrumpleMark marks[4096];
    static unsigned char one[1 << 18], other[1 << 18];
    size_t one_size, other_size;
    uint32_t count;
    OK(crumple_instance_get_marks(context, bodies[at], marks, 4096, &count));
    CrumpleInstance fresh = make_body(context, set, MOST_BODIES);
    OK(crumple_instance_set_marks(context, fresh, marks, count));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    FACT(memcmp(vertices[at], vertices[MOST_BODIES], sizeof vertices[at]) == 0);
    OK(crumple_instance_save_damage(context, bodies[at], one, sizeof one, &one_size));
    OK(crumple_instance_save_damage(context, fresh, other, sizeof other, &other_size));
    FACT(one_size == other_size && memcmp(one, other, one_size) == 0);
    OK(crumple_instance_destroy(context, fresh));
}

int main(int argc, char **argv) {
    static unsigned char damage[1 << 18];
    const double wanted = argc > 1 ? atof(argv[1]) : 2;
    const unsigned count = argc > 2 ? (unsigned)atoi(argv[2]) : 16;
    if (argc > 3) dice_state = strtoull(argv[3], NULL, 10);
    FACT(wanted > 0 && count > 0 && count <= MOST_BODIES);
    use_heap(&heap);
    make_sheet(&sheet);
    CrumpleContext *context = make_context(1);
    CrumpleExampleSet set;
    OK(crumple_example_set_create(context, &sheet.def, &set));
    for (unsigned i = 0; i < count; ++i) bodies[i] = make_body(context, set, i);

    unsigned long long frames = 0, hits = 0, replays = 0, made = count;
    size_t first_half = 0, second_half = 0, size;
    const double begin = seconds();
    double now = begin;
    for (; now - begin < wanted; ++frames, now = seconds()) {
        for (unsigned i = dice(4); i > 0; --i, ++hits) {
            CrumpleHitDef def = random_displacement();
            OK(crumple_instance_submit_hit(context, bodies[dice(count)], &def, NULL));
        }
        OK(crumple_context_deform(context, NULL, 0, NULL));
        const unsigned at = dice(count);
        if (dice(50) == 0) {
            const CrumpleVec3 point = vec3((float)dice(100) / 100 - 0.5f, (float)dice(100) / 100 - 0.5f, 0.07f);
            OK(crumple_instance_repair_around(context, bodies[at], point, 0.2f, (float)dice(2) / 2));
        }
        if (dice(100) == 0) {
            OK(crumple_instance_save_damage(context, bodies[at], damage, sizeof damage, &size));
            OK(crumple_instance_load_damage(context, bodies[dice(count)], damage, size));
        }
        if (dice(500) == 0) {
            OK(crumple_instance_destroy(context, bodies[at]));
            bodies[at] = make_body(context, set, at);
            ++made;
        }
        if (dice(1000) == 0) {
            compare_with_replay(context, set, at);
            ++replays;
        }
        size_t *half = now - begin < wanted / 2 ? &first_half : &second_half;
        if (heap.bytes > *half) *half = heap.bytes;
    }
    for (unsigned i = 0; i < count; ++i) compare_with_replay(context, set, i);
    printf("%u bodies, %.0f s, %llu hits, %llu frames, %llu bodies made, %llu compared with a replay of their marks\n", count,
           now - begin, hits, frames, made, replays + count);
    printf("bytes at most: first half %zu, second half %zu\n", first_half, second_half);
    // Short runs have not seen the bodies with the most marks in their first half.
    if (wanted >= 60) FACT(second_half <= first_half + first_half / 20);
    OK(crumple_context_destroy(context));
    FACT(heap.blocks == 0);
    return 0;
}
