// How long hits and frames take on the CPU, one thread on one core: the median, the tail and the longest of very many. And how long
// it takes to load many marks.
//
//   times [FRAMES]
//
// `cargo xtask soak --frames N` runs it with an optimised library.
#include "support.h"
#include "times.h"

enum { BODIES = 16, FLOATS = 10, WARM_UP = 3000 };

static Sheet sheet;
static float vertices[BODIES][VERTICES][FLOATS];

// Loads more and more marks that differ in their depths: all at one vertex, or spread over the sheet.
static void load_marks(CrumpleContext *context, CrumpleExampleSet set, int most) {
    static CrumpleMark marks[4096];
    CrumpleInstanceDef def = crumple_instance_def_default();
    CrumpleInstance body;
    uint32_t count;
    def.set = set;
    def.mark_capacity = 4096;
    OK(crumple_instance_create(context, &def, &body));
    const CrumpleHitDef hit = displacement_at(0, 0, 0.02f);
    OK(crumple_instance_submit_hit(context, body, &hit, NULL));
    OK(crumple_instance_get_marks(context, body, marks, 4096, &count));
    printf("\n| marks | ms, at one place | ms, spread |\n|---|---|---|\n");
    for (int n = 64; n <= most; n *= 4) {
        double times[2];
        for (int spread = 0; spread < 2; ++spread) {
            for (int i = 0; i < n; ++i) {
                marks[i] = marks[0];
                marks[i].depth = 0.01f + 1e-6f * (float)i;
                marks[i].contact = spread ? (uint32_t)(i % VERTICES) : VERTICES / 2;
            }
            const double begin = own_seconds();
            OK(crumple_instance_set_marks(context, body, marks, (uint32_t)n));
            times[spread] = own_seconds() - begin;
            OK(crumple_instance_get_marks(context, body, NULL, 0, &count));
            FACT(count == (uint32_t)n);
        }
        printf("| %d | %.2f | %.2f |\n", n, 1e3 * times[0], 1e3 * times[1]);
    }
}

int main(int argc, char **argv) {
    static Call hit = {.name = "hit"}, frame = {.name = "frame after a hit"}, idle = {.name = "frame without hits"};
    const unsigned long long frames = argc > 1 ? strtoull(argv[1], NULL, 10) : 1000, warm_up = frames < WARM_UP ? frames : WARM_UP;
    FACT(frames > 0);
    make_sheet(&sheet);
    CrumpleContext *context = make_context(1);
    CrumpleExampleSet set;
    CrumpleInstance bodies[BODIES];
    OK(crumple_example_set_create(context, &sheet.def, &set));
    for (int i = 0; i < BODIES; ++i) {
        bodies[i] = make_instance(context, set);
        make_buffer(context, bodies[i], host_def(vertices[i], VERTICES, FLOATS));
    }
    for (unsigned long long i = 0; i < warm_up + frames; ++i) {
        if (i == warm_up) start_measuring(&hit), start_measuring(&frame), start_measuring(&idle);
        const CrumpleInstance body = bodies[dice(BODIES)];
        const CrumpleHitDef def = random_displacement();
        begin_call(&hit);
        OK(crumple_instance_submit_hit(context, body, &def, NULL));
        end_call(&hit);
        begin_call(&frame);
        OK(crumple_context_deform(context, NULL, 0, NULL));
        end_call(&frame);
        begin_call(&idle);
        OK(crumple_context_deform(context, NULL, 0, NULL));
        end_call(&idle);
        // Bodies are repaired now and then, so that there are bodies with few marks too.
        if (dice(2000) == 0) OK(crumple_instance_reset_damage(context, body));
    }
    printf("CPU: %d bodies of %d vertices, frames: %llu\n\n", BODIES, VERTICES, frames);
    print_calls((const Call *const[]){&hit, &frame, &idle}, 3);
    load_marks(context, set, frames < 10000 ? 256 : 4096);
    OK(crumple_context_destroy(context));
    return 0;
}
