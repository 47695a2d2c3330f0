// Hosts whose job system does not do what it promised: indices forgotten, run twice, run late, wild; callbacks that call back.
#include "support.h"

#include <pthread.h>

typedef struct Late {
    CrumpleTask task;
    void *task_data;
    uint32_t count;
} Late;

static CrumpleContext *context;
static CrumpleInstance body;
static int mode;
static pthread_t late_threads[4096];
static int late_count;

static void *run_late(void *user) {
    Late late = *(Late *)user;
    free(user);
    for (uint32_t i = 0; i < late.count + 3; ++i) late.task(i, late.task_data);
    return NULL;
}

static void careless(uint32_t count, CrumpleTask task, void *task_data, void *user) {
    CrumpleInstanceInfo info;
    FACT(user == &mode);
    switch (mode) {
    case 0: // forgets every third, runs the rest twice, and some that there are not
        for (uint32_t i = 0; i < count; ++i)
            if (i % 3 != 0) task(i, task_data), task(i, task_data);
        task(count, task_data);
        task(UINT32_MAX, task_data);
        break;
    case 1: // does nothing
        break;
    case 2: // returns before its threads are done, which run everything, and more
        for (int t = 0; t < 4 && late_count < 4096; ++t) {
            Late *late = malloc(sizeof *late);
            late->task = task;
            late->task_data = task_data;
            late->count = count;
            FACT(pthread_create(&late_threads[late_count++], NULL, run_late, late) == 0);
        }
        break;
    case 3: // calls back
        FAILS_KEEPING(CRUMPLE_ERROR_CONCURRENT_USE, "callback", info, crumple_instance_get_info(context, body, &info));
        for (uint32_t i = count; i-- > 0;) task(i, task_data);
        break;
    }
}

static int logged;

static void log_and_call_back(CrumpleLogLevel level, const char *message, void *user) {
    CrumpleExampleSet set = {1, 1, 1};
    FACT(level == CRUMPLE_LOG_LEVEL_INFO || level == CRUMPLE_LOG_LEVEL_WARNING);
    FACT(strlen(message) > 0 && user == &logged);
    FAILS(CRUMPLE_ERROR_CONCURRENT_USE, "callback", crumple_example_set_destroy(context, set));
    ++logged;
}

static void scene(const Sheet *sheet, CrumpleContextDef def, float (*vertices)[6]) {
    CrumpleExampleSet set;
    CrumpleBuffer buffer;
    CrumpleHostBufferDef buffer_def = crumple_host_buffer_def_default();
    size_t bytes = VERTICES * 24;
    memset(vertices, 0, bytes);
    OK(crumple_context_create(&def, &context));
    OK(crumple_example_set_create(context, &sheet->def, &set));
    body = make_instance(context, set);
    buffer_def.positions = stream_of(vertices, bytes, 0, 24);
    buffer_def.normals = stream_of(vertices, bytes, 12, 24);
    OK(crumple_buffer_register_host(context, body, &buffer_def, &buffer));
    for (int i = 0; i < 12; ++i) {
        CrumpleHitDef hit = displacement_at(0.07f * (float)i - 0.4f, 0.05f * (float)i - 0.3f, 0.01f);
        OK(crumple_instance_submit_hit(context, body, &hit, NULL));
        OK(crumple_context_deform(context, NULL, 0, NULL));
    }
    // Late callers may come as long as the context lives.
    while (late_count > 0) pthread_join(late_threads[--late_count], NULL);
    OK(crumple_context_destroy(context));
}

int main(void) {
    static Sheet sheet;
    static float expected[VERTICES][6], vertices[VERTICES][6];
    CrumpleContextDef def = crumple_context_def_default();
    make_sheet(&sheet);
    def.threads = 1;
    def.log = log_and_call_back;
    def.log_user = &logged;
    scene(&sheet, def, expected);
    FACT(logged > 0);
    def.tasks.parallel_for = careless;
    def.tasks.user = &mode;
    def.tasks.workers = 3;
    for (mode = 0; mode < 4; ++mode) {
        scene(&sheet, def, vertices);
        FACT(memcmp(expected, vertices, sizeof expected) == 0);
    }
    printf("%u checks\n", checks);
    return 0;
}
