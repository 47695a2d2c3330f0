// Blocks of several allocators: each goes back to the one it came from, with its size and alignment (heap.h), and nothing is left behind.
// refusals.c lets them run out.
#include "heap.h"
#include "support.h"

#include <pthread.h>

static Sheet sheet;
static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;

static void lock(bool take) { take ? pthread_mutex_lock(&mutex) : pthread_mutex_unlock(&mutex); }

// Makes one of everything, uses it, and leaves an error behind.
static CrumpleContext *use_all(void) {
    static float vertices[VERTICES][3];
    CrumpleContext *context = make_context(1);
    CrumpleExampleSet set, second;
    unsigned char bytes[4096];
    size_t size;
    OK(crumple_example_set_create(context, &sheet.def, &set));
    OK(crumple_example_set_create(context, &sheet.def, &second));
    OK(crumple_example_set_destroy(context, second));
    CrumpleInstance body = make_instance(context, set), other = make_instance(context, set);
    make_buffer(context, body, host_def(vertices, VERTICES, 3));
    for (int i = 0; i < 100; ++i) {
        CrumpleHitDef hit = displacement_at(0.009f * (float)i - 0.45f, 0.3f - 0.006f * (float)i, 0.03f);
        OK(crumple_instance_submit_hit(context, body, &hit, NULL));
    }
    OK(crumple_context_deform(context, NULL, 0, NULL));
    OK(crumple_instance_save_damage(context, body, bytes, sizeof bytes, &size));
    OK(crumple_instance_load_damage(context, other, bytes, size));
    OK(crumple_instance_destroy(context, other));
    FAILS(CRUMPLE_ERROR_INVALID_ID, "stale", crumple_instance_reset_damage(context, other));
    return context;
}

int main(void) {
    static Heap heaps[16];
    Heap *first = &heaps[0], *second = &heaps[1], *threaded = &heaps[2];
    CrumpleAllocatorDef def = allocator_of(first), other = allocator_of(second);
    make_sheet(&sheet);
    if (!(crumple_features() & CRUMPLE_FEATURE_HOST_ALLOCATOR)) {
        FAILS(CRUMPLE_ERROR_UNSUPPORTED, "host-allocator", crumple_allocator_set(&def));
        printf("this build has no host allocator\n");
        return 0;
    }
    // Bad defs change nothing.
    def.free = NULL;
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "free", crumple_allocator_set(&def));
    def = allocator_of(first);
    def.struct_size -= 1;
    FAILS(CRUMPLE_ERROR_STRUCT_SIZE, "allocator.struct_size", crumple_allocator_set(&def));
    def = allocator_of(first);

    // Memory of the system's allocator is alive while hooks come and go.
    CrumpleContext *before = use_all();
    OK(crumple_allocator_set(&def));
    CrumpleContext *during = use_all();
    FACT(first->blocks > 0 && first->calls > 100);
    OK(crumple_context_destroy(before));
    OK(crumple_allocator_set(&other));
    CrumpleContext *after = use_all();
    OK(crumple_context_destroy(during));
    FACT(first->blocks == 0 && first->bytes == 0 && second->blocks > 0);
    OK(crumple_allocator_set(NULL));
    OK(crumple_context_destroy(after));
    FACT(second->blocks == 0 && second->bytes == 0);

    // Threads of the library's own leave a little to the next ones, which does not grow.
    size_t most = 0;
    CrumpleExampleSet set;
    threaded->lock = lock;
    FACT(use_heap(threaded));
    for (int i = 0; i < 60; ++i) {
        CrumpleContext *context = make_context(3);
        OK(crumple_example_set_create(context, &sheet.def, &set));
        OK(crumple_context_destroy(context));
        if (i < 20) most = threaded->bytes > most ? threaded->bytes : most;
        FACT(i < 20 || threaded->bytes <= most + 16384);
    }
    printf("after contexts with threads %zu bytes are left, at most %zu\n", threaded->bytes, most);

    // Fifteen different allocators, and the first again.
    for (int i = 3; i < 15; ++i) FACT(use_heap(&heaps[i]));
    FACT(!use_heap(&heaps[15]) && strstr(crumple_last_error(), "15 different allocators"));
    OK(crumple_allocator_set(&def));
    OK(crumple_allocator_set(NULL));
    printf("%u checks\n", checks);
    return 0;
}
