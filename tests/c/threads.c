// Hits from eight threads at once, while another deforms; and two threads inside one context.
#include "support.h"

#include <pthread.h>

enum { THREADS = 8, HITS = 300, BODIES = 3 };

static Sheet sheet;
static CrumpleContext *context;
static CrumpleInstance bodies[BODIES];
static volatile int running;

static CrumpleHitDef hit(int i) {
    CrumpleHitDef def = displacement_at((float)(i * 37 % 101) / 101 - 0.5f, (float)(i * 61 % 103) / 103 - 0.5f,
                                                 0.005f + 0.0001f * (float)(i % 300));
    return def;
}

static void *submitter(void *user) {
    int first = *(int *)user;
    for (int i = first; i < THREADS * HITS; i += THREADS) {
        CrumpleHitDef def = hit(i);
        CrumpleHitResult told;
        OK(crumple_instance_submit_hit(context, bodies[i % BODIES], &def, &told));
        if (i % 50 == 0) { // errors are each thread's own
            def.displacement.x = NAN;
            FAILS(CRUMPLE_ERROR_NOT_FINITE, "displacement", crumple_instance_submit_hit(context, bodies[0], &def, &told));
        }
    }
    return NULL;
}

static float vertices[BODIES][VERTICES][3];

static void *deformer(void *user) {
    (void)user;
    while (running) OK(crumple_context_deform(context, NULL, 0, NULL));
    return NULL;
}

static size_t save(CrumpleInstance instance, unsigned char *bytes, size_t capacity) {
    size_t size = 0;
    OK(crumple_instance_save_damage(context, instance, NULL, 0, &size));
    FACT(size <= capacity);
    OK(crumple_instance_save_damage(context, instance, bytes, capacity, &size));
    return size;
}

// Saves every body's damage after all hits from `threads` threads, with or without a deform meanwhile.
static size_t scene(int threads, int deform, unsigned char (*saved)[65536 * 4]) {
    CrumpleExampleSet set;
    pthread_t ids[THREADS], deform_id;
    int firsts[THREADS];
    size_t size = 0;
    context = make_context(2);
    OK(crumple_example_set_create(context, &sheet.def, &set));
    for (int b = 0; b < BODIES; ++b) {
        CrumpleInstanceDef def = crumple_instance_def_default();
        CrumpleHostBufferDef buffer_def = crumple_host_buffer_def_default();
        CrumpleBuffer buffer;
        def.set = set;
        def.mark_capacity = 4096; // never reached: no merging, so neither order nor moment matters
        OK(crumple_instance_create(context, &def, &bodies[b]));
        buffer_def.positions = stream_of(vertices[b], sizeof vertices[b], 0, 12);
        OK(crumple_buffer_register_host(context, bodies[b], &buffer_def, &buffer));
    }
    running = 1;
    if (deform) FACT(pthread_create(&deform_id, NULL, deformer, NULL) == 0);
    for (int t = 0; t < THREADS; ++t) firsts[t] = t;
    if (threads == 1)
        for (int t = 0; t < THREADS; ++t) submitter(&firsts[t]);
    else {
        for (int t = 0; t < THREADS; ++t) FACT(pthread_create(&ids[t], NULL, submitter, &firsts[t]) == 0);
        for (int t = 0; t < THREADS; ++t) pthread_join(ids[t], NULL);
    }
    running = 0;
    if (deform) pthread_join(deform_id, NULL);
    OK(crumple_context_deform(context, NULL, 0, NULL));
    for (int b = 0; b < BODIES; ++b) size += save(bodies[b], saved[b], sizeof saved[b]);
    OK(crumple_context_destroy(context));
    return size;
}

// --- Two threads inside.

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t changed = PTHREAD_COND_INITIALIZER;
static int inside, leave;

// A host whose parallel-for waits until it is told to go on.
static void waiting_parallel_for(uint32_t count, CrumpleTask task, void *task_data, void *user) {
    (void)user;
    for (uint32_t i = 0; i < count; ++i) task(i, task_data);
    pthread_mutex_lock(&lock);
    inside = 1;
    pthread_cond_broadcast(&changed);
    while (!leave) pthread_cond_wait(&changed, &lock);
    pthread_mutex_unlock(&lock);
}

static void *deform_once(void *user) {
    (void)user;
    OK(crumple_context_deform(context, NULL, 0, NULL));
    return NULL;
}

static void two_inside(void) {
    CrumpleContextDef def = crumple_context_def_default();
    CrumpleExampleSet set;
    CrumpleBuffer buffer;
    CrumpleHostBufferDef buffer_def = crumple_host_buffer_def_default();
    CrumpleHitDef one = hit(1);
    CrumpleInstanceInfo info;
    pthread_t id;
    leave = 1;
    def.tasks.parallel_for = waiting_parallel_for;
    def.tasks.workers = 4;
    OK(crumple_context_create(&def, &context));
    OK(crumple_example_set_create(context, &sheet.def, &set));
    bodies[0] = make_instance(context, set);
    buffer_def.positions = stream_of(vertices[0], sizeof vertices[0], 0, 12);
    OK(crumple_buffer_register_host(context, bodies[0], &buffer_def, &buffer));

    inside = leave = 0;
    FACT(pthread_create(&id, NULL, deform_once, NULL) == 0);
    pthread_mutex_lock(&lock);
    while (!inside) pthread_cond_wait(&changed, &lock);
    pthread_mutex_unlock(&lock);
    FAILS_KEEPING(CRUMPLE_ERROR_CONCURRENT_USE, "another thread", info, crumple_instance_get_info(context, bodies[0], &info));
    FAILS(CRUMPLE_ERROR_CONCURRENT_USE, "another thread", crumple_context_deform(context, NULL, 0, NULL));
    FAILS(CRUMPLE_ERROR_CONCURRENT_USE, "another thread", crumple_context_destroy(context));
    OK(crumple_instance_submit_hit(context, bodies[0], &one, NULL)); // which is allowed
    pthread_mutex_lock(&lock);
    leave = 1;
    pthread_cond_broadcast(&changed);
    pthread_mutex_unlock(&lock);
    pthread_join(id, NULL);
    OK(crumple_instance_get_info(context, bodies[0], &info));
    FACT(info.mark_count == 1);
    OK(crumple_context_destroy(context));
}

int main(void) {
    static unsigned char one[BODIES][65536 * 4], many[BODIES][65536 * 4];
    make_sheet(&sheet);
    size_t expected = scene(1, 0, one);
    for (int round = 0; round < 3; ++round) {
        memset(many, 0, sizeof many);
        FACT(scene(THREADS, round > 0, many) == expected);
        FACT(memcmp(one, many, sizeof one) == 0);
    }
    two_inside();
    printf("%zu bytes of damage from %d threads are those of one; %u checks\n", expected, THREADS, checks);
    return 0;
}
