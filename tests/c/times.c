// How long hits and frames take on the CPU, one thread on one core: the median, the tail and the longest of very many.
//
//   times [FRAMES]
//
// `cargo xtask soak --frames N` runs it with an optimised library.
#include "support.h"
#include "times.h"

enum { BODIES = 16, FLOATS = 10, WARM_UP = 3000 };

static Sheet sheet;
static float vertices[BODIES][VERTICES][FLOATS];
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
        CrumpleHostBufferDef def = crumple_host_buffer_def_default();
        CrumpleBuffer buffer;
        def.positions = stream_of(vertices[i], sizeof vertices[i], 0, 4 * FLOATS);
        def.normals = stream_of(vertices[i], sizeof vertices[i], 12, 4 * FLOATS);
        def.tangents = stream_of(vertices[i], sizeof vertices[i], 24, 4 * FLOATS);
        OK(crumple_buffer_register_host(context, bodies[i], &def, &buffer));
    }
    for (unsigned long long i = 0; i < warm_up + frames; ++i) {
        if (i == warm_up) start_measuring(&hit), start_measuring(&frame), start_measuring(&idle);
        const CrumpleInstance body = bodies[dice(BODIES)];
        const CrumpleDisplacementDef def = random_displacement();
        begin_time(&hit.times);
        OK(crumple_instance_submit_displacement(context, body, &def, NULL));
        end_call(&hit);
        begin_time(&frame.times);
        OK(crumple_context_deform(context, NULL, 0, NULL));
        end_call(&frame);
        begin_time(&idle.times);
        OK(crumple_context_deform(context, NULL, 0, NULL));
        end_call(&idle);
        // Bodies are repaired now and then, so that there are bodies with few marks too.
        if (dice(2000) == 0) OK(crumple_instance_reset_damage(context, body));
    }
    printf("CPU: %d bodies of %d vertices, frames: %llu\n\n", BODIES, VERTICES, frames);
    print_header();
    print_call(&hit), print_call(&frame), print_call(&idle);
    OK(crumple_context_destroy(context));
    return 0;
}
