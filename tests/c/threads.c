// Two threads inside one context: all calls but hits are refused, and errors are each thread's own. src/capi/thread_tests.rs lets many
// threads hit at once, src/capi/tasks.rs has hosts that run tasks carelessly.
#include "support.h"

#include <crumple_contacts.h>

#include <pthread.h>

static Sheet sheet;
static CrumpleContext *context;
static CrumpleInstance body;

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t changed = PTHREAD_COND_INITIALIZER;
static int inside, leave = 1;

// A host whose parallel-for calls back, and waits until it is told to go on.
static void waiting_parallel_for(uint32_t count, CrumpleTask task, void *task_data, void *user) {
    CrumpleInstanceInfo info;
    FACT(user == &inside);
    FAILS_KEEPING(CRUMPLE_ERROR_CONCURRENT_USE, "callback", info, crumple_instance_get_info(context, body, &info));
    for (uint32_t i = 0; i < count; ++i) task(i, task_data);
    pthread_mutex_lock(&lock);
    inside = 1;
    pthread_cond_broadcast(&changed);
    while (!leave) pthread_cond_wait(&changed, &lock);
    pthread_mutex_unlock(&lock);
}

static void *deform(void *user) {
    CrumpleHitDef def = displacement_at(NAN, 0, 0.01f);
    FAILS(CRUMPLE_ERROR_NOT_FINITE, "point", crumple_instance_submit_hit(context, body, &def, NULL));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    return user;
}

int main(void) {
    static float vertices[VERTICES][3];
    CrumpleContextDef def = crumple_context_def_default();
    CrumpleExampleSet set;
    CrumpleHitDef hit = displacement_at(0, 0, 0.01f);
    CrumpleInstanceInfo info;
    pthread_t id;
    make_sheet(&sheet);
    def.tasks.parallel_for = waiting_parallel_for;
    def.tasks.user = &inside;
    def.tasks.workers = 4;
    OK(crumple_context_create(&def, &context));
    OK(crumple_example_set_create(context, &sheet.def, &set));
    body = make_instance(context, set);
    make_buffer(context, body, host_def(vertices, VERTICES, 3));

    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "contact_id", crumple_instance_end_contact(context, body, 0));
    inside = leave = 0;
    FACT(pthread_create(&id, NULL, deform, NULL) == 0);
    pthread_mutex_lock(&lock);
    while (!inside) pthread_cond_wait(&changed, &lock);
    pthread_mutex_unlock(&lock);
    FACT(strstr(crumple_last_error(), "contact_id"));
    FAILS_KEEPING(CRUMPLE_ERROR_CONCURRENT_USE, "another thread", info, crumple_instance_get_info(context, body, &info));
    FAILS(CRUMPLE_ERROR_CONCURRENT_USE, "another thread", crumple_context_deform(context, NULL, 0, NULL));
    FAILS(CRUMPLE_ERROR_CONCURRENT_USE, "another thread", crumple_context_destroy(context));
    OK(crumple_instance_submit_hit(context, body, &hit, NULL)); // which is allowed
    pthread_mutex_lock(&lock);
    leave = 1;
    pthread_cond_broadcast(&changed);
    pthread_mutex_unlock(&lock);
    pthread_join(id, NULL);
    OK(crumple_instance_get_info(context, body, &info));
    FACT(info.mark_count == 1);
    OK(crumple_context_destroy(context));
    printf("%u checks\n", checks);
    return 0;
}
