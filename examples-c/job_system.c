// Runs Crumple's work on the host's own threads, and checks that the results are bit-for-bit those of Crumple's threads.
#include <crumple_build.h>

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void check(CrumpleResult result) {
    if (result == CRUMPLE_OK) return;
    fprintf(stderr, "%s: %s\n", crumple_result_name(result), crumple_last_error());
    exit(1);
}

static void fact(int holds, const char *what) {
    if (holds) return;
    fprintf(stderr, "this is not so: %s\n", what);
    exit(1);
}

// --- The host's job system: a few threads that take the next index until none is left.

enum { WORKERS = 3 };

typedef struct Pool {
    pthread_t threads[WORKERS];
    pthread_mutex_t lock;
    pthread_cond_t work, done;
    CrumpleTask task;
    void *task_data;
    uint32_t next, count, running;
    unsigned long calls, tasks;
    int quit;
} Pool;

// Runs tasks until none is left. The caller holds the lock; it is released while a task runs.
static void run_tasks(Pool *pool) {
    while (pool->next < pool->count) {
        uint32_t index = pool->next++;
        CrumpleTask task = pool->task;
        void *task_data = pool->task_data;
        ++pool->running;
        ++pool->tasks;
        pthread_mutex_unlock(&pool->lock);
        task(index, task_data);
        pthread_mutex_lock(&pool->lock);
        if (--pool->running == 0 && pool->next == pool->count) pthread_cond_broadcast(&pool->done);
    }
}

static void *worker(void *user) {
    Pool *pool = user;
    pthread_mutex_lock(&pool->lock);
    while (!pool->quit) {
        run_tasks(pool);
        if (!pool->quit) pthread_cond_wait(&pool->work, &pool->lock);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

// The CrumpleParallelFor that Crumple calls.
static void parallel_for(uint32_t count, CrumpleTask task, void *task_data, void *user) {
    Pool *pool = user;
    pthread_mutex_lock(&pool->lock);
    ++pool->calls;
    pool->task = task;
    pool->task_data = task_data;
    pool->count = count;
    pool->next = 0;
    pthread_cond_broadcast(&pool->work);
    run_tasks(pool); // the calling thread helps
    while (pool->running > 0) pthread_cond_wait(&pool->done, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
}

static void start(Pool *pool) {
    memset(pool, 0, sizeof *pool);
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->work, NULL);
    pthread_cond_init(&pool->done, NULL);
    for (int i = 0; i < WORKERS; ++i) fact(pthread_create(&pool->threads[i], NULL, worker, pool) == 0, "a thread starts");
}

static void stop(Pool *pool) {
    pthread_mutex_lock(&pool->lock);
    pool->quit = 1;
    pthread_cond_broadcast(&pool->work);
    pthread_mutex_unlock(&pool->lock);
    for (int i = 0; i < WORKERS; ++i) pthread_join(pool->threads[i], NULL);
}

// --- The scene, deformed with either task system.

enum { SIDE = 129, VERTICES = SIDE * SIDE, INDICES = (SIDE - 1) * (SIDE - 1) * 6, EXAMPLES = 3, HITS = 40 };

static float base[VERTICES][3], targets[EXAMPLES][VERTICES][3];
static uint32_t indices[INDICES];

static void make_mesh(void) {
    static const float centres[EXAMPLES][3] = {{0, 0, 0.05f}, {0.25f, 0.2f, 0.03f}, {-0.2f, 0.25f, 0.08f}};
    for (int v = 0, i = 0; v < VERTICES; ++v) {
        float x = (float)(v % SIDE) / (SIDE - 1) - 0.5f, y = (float)(v / SIDE) / (SIDE - 1) - 0.5f;
        base[v][0] = x;
        base[v][1] = y;
        base[v][2] = 0.2f * (0.25f - x * x) + 0.1f * (0.25f - y * y);
        for (int e = 0; e < EXAMPLES; ++e) {
            float dx = x - centres[e][0], dy = y - centres[e][1], r = (dx * dx + dy * dy) / 0.04f;
            memcpy(targets[e][v], base[v], sizeof base[v]);
            if (r < 1) targets[e][v][2] -= centres[e][2] * (1 - r) * (1 - r);
        }
        if (v % SIDE < SIDE - 1 && v / SIDE < SIDE - 1) {
            uint32_t a = (uint32_t)v, quad[6] = {a, a + 1, a + SIDE, a + SIDE, a + 1, a + SIDE + 1};
            for (int k = 0; k < 6; ++k) indices[i++] = quad[k];
        }
    }
}

static void scene(CrumpleTaskSystem tasks, uint32_t threads, float (*vertices)[6]) {
    CrumpleContextDef context_def = crumple_context_def_default();
    context_def.threads = threads;
    context_def.tasks = tasks;
    CrumpleContext *context;
    check(crumple_context_create(&context_def, &context));
    CrumpleExampleDef examples[EXAMPLES];
    for (int e = 0; e < EXAMPLES; ++e) {
        examples[e] = crumple_example_def_default();
        examples[e].target_positions = (CrumpleInput){targets[e], sizeof targets[e], sizeof targets[e][0]};
    }
    CrumpleMeshDef mesh = crumple_mesh_def_default();
    mesh.vertex_count = VERTICES;
    mesh.positions = (CrumpleInput){base, sizeof base, sizeof base[0]};
    mesh.index_count = INDICES;
    mesh.indices = (CrumpleInput){indices, sizeof indices, sizeof indices[0]};
    CrumpleExampleSetDef set_def = crumple_example_set_def_default();
    set_def.mesh = &mesh;
    set_def.examples = examples;
    set_def.example_count = EXAMPLES;
    CrumpleExampleSet set;
    check(crumple_example_set_create(context, &set_def, &set));
    CrumpleInstanceDef instance_def = crumple_instance_def_default();
    instance_def.set = set;
    CrumpleInstance instance;
    check(crumple_instance_create(context, &instance_def, &instance));
    CrumpleHostBufferDef buffer_def = crumple_host_buffer_def_default();
    size_t bytes = sizeof(float[VERTICES][6]);
    buffer_def.positions = (CrumpleStream){vertices, bytes, 0, 24};
    buffer_def.normals = (CrumpleStream){vertices, bytes, 12, 24};
    CrumpleBuffer buffer;
    check(crumple_buffer_register_host(context, instance, &buffer_def, &buffer));
    for (int i = 0; i < HITS; ++i) {
        CrumpleHitDef hit = crumple_hit_def_default();
        hit.kind = CRUMPLE_HIT_KIND_DISPLACEMENT;
        hit.point = (CrumpleVec3){(float)(i * 37 % 100) / 100 - 0.5f, (float)(i * 61 % 100) / 100 - 0.5f, 0.07f};
        hit.displacement = (CrumpleVec3){0, 0, -0.001f * (float)(5 + i)};
        check(crumple_instance_submit_hit(context, instance, &hit, NULL));
        if (i % 10 == 9) check(crumple_context_deform(context, NULL, 0, NULL));
    }
    check(crumple_context_destroy(context));
}

int main(void) {
    static float own[VERTICES][6], single[VERTICES][6], hosts[VERTICES][6];
    CrumpleTaskSystem none = {0};
    Pool pool;
    make_mesh();
    scene(none, 4, own);
    scene(none, 1, single);
    start(&pool);
    CrumpleTaskSystem tasks = {parallel_for, &pool, WORKERS + 1};
    scene(tasks, 0, hosts);
    stop(&pool);
    printf("%lu tasks in %lu calls on the host's %d threads\n", pool.tasks, pool.calls, WORKERS + 1);
    fact(pool.tasks > 0, "the host's threads did the work");
    fact(memcmp(own, single, sizeof own) == 0, "four threads of Crumple's give the same bits as one");
    fact(memcmp(own, hosts, sizeof own) == 0, "the host's threads give the same bits as Crumple's");
    float deepest = 0;
    for (int v = 0; v < VERTICES; ++v) deepest = fmaxf(deepest, base[v][2] - hosts[v][2]);
    printf("the deepest of %d dents is %.1f mm\n", HITS, 1000 * deepest);
    fact(deepest > 0.03f, "there are dents");
    return 0;
}
