// The host's allocator: what was given comes back, with its size and alignment; running out is an error, not a crash.
#include "support.h"

#include <crumple_host.h>
#include <crumple_parts.h>

#include <pthread.h>

enum { MAGIC = 0x5AFE };

// Like FACT, for functions that run on several threads.
#define MUST(condition) ((condition) ? (void)0 : (fprintf(stderr, "not so: %s\n", #condition), exit(1)))

typedef struct Heap {
    unsigned magic;
    long blocks;
    size_t bytes, peak, limit;
    unsigned long calls;
} Heap;

// Before each block, so that free can check what it is told.
typedef struct Head {
    size_t size, align;
    void *raw;
    Heap *heap;
} Head;

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

static void *host_alloc(size_t size, size_t align, void *user) {
    Heap *heap = user;
    MUST(heap->magic == MAGIC && size > 0 && align >= 16 && (align & (align - 1)) == 0);
    if (heap->limit != 0 && size > heap->limit) return NULL;
    char *raw = malloc(size + align + sizeof(Head));
    MUST(raw != NULL);
    uintptr_t at = ((uintptr_t)raw + sizeof(Head) + align - 1) / align * align;
    Head *head = (Head *)at - 1;
    head->size = size;
    head->align = align;
    head->raw = raw;
    head->heap = heap;
    memset((void *)at, 0xCD, size);
    pthread_mutex_lock(&lock);
    ++heap->blocks;
    ++heap->calls;
    heap->bytes += size;
    if (heap->bytes > heap->peak) heap->peak = heap->bytes;
    pthread_mutex_unlock(&lock);
    return (void *)at;
}

static void host_free(void *pointer, size_t size, size_t align, void *user) {
    Heap *heap = user;
    Head *head = (Head *)pointer - 1;
    MUST(heap->magic == MAGIC && head->heap == heap && head->size == size && head->align == align);
    memset(pointer, 0xDD, size);
    pthread_mutex_lock(&lock);
    --heap->blocks;
    heap->bytes -= size;
    pthread_mutex_unlock(&lock);
    free(head->raw);
}

static CrumpleAllocatorDef allocator_of(Heap *heap) {
    CrumpleAllocatorDef def = crumple_allocator_def_default();
    heap->magic = MAGIC;
    def.alloc = host_alloc;
    def.free = host_free;
    def.user = heap;
    return def;
}

static Sheet sheet;

// Makes one of everything, uses it, and leaves an error behind.
static CrumpleContext *use_all(void) {
    static float vertices[VERTICES][3];
    CrumpleContext *context = make_context(1);
    CrumpleExampleSet set, second;
    CrumpleBuffer buffer;
    CrumpleHostBufferDef buffer_def = crumple_host_buffer_def_default();
    CrumpleAttachment lamp;
    CrumplePose frame;
    unsigned char bytes[4096];
    size_t size;
    OK(crumple_example_set_create(context, &sheet.def, &set));
    OK(crumple_example_set_create(context, &sheet.def, &second));
    OK(crumple_example_set_destroy(context, second));
    CrumpleInstance body = make_instance(context, set), other = make_instance(context, set);
    buffer_def.positions = stream_of(vertices, sizeof vertices, 0, 12);
    OK(crumple_buffer_register_host(context, body, &buffer_def, &buffer));
    for (int i = 0; i < 100; ++i) {
        CrumpleHitDef hit = displacement_at(0.009f * (float)i - 0.45f, 0.3f - 0.006f * (float)i, 0.03f);
        OK(crumple_instance_submit_hit(context, body, &hit, NULL));
    }
    OK(crumple_context_deform(context, NULL, 0, NULL));
    OK(crumple_instance_save_damage(context, body, bytes, sizeof bytes, &size));
    OK(crumple_instance_load_damage(context, other, bytes, size));
    OK(crumple_example_set_attach_point(context, set, vec3(0, 0, 1), &lamp));
    OK(crumple_instance_get_attached_pose(context, other, &lamp, &frame));
    OK(crumple_instance_destroy(context, other));
    FAILS(CRUMPLE_ERROR_INVALID_ID, "stale", crumple_instance_reset_damage(context, other));
    return context;
}

int main(void) {
    static Heap first, second, third; // the last is used until the process ends
    CrumpleAllocatorDef def = allocator_of(&first), other = allocator_of(&second), threaded = allocator_of(&third);
    make_sheet(&sheet);
    if (!(crumple_features() & CRUMPLE_FEATURE_HOST_ALLOCATOR)) {
        FAILS(CRUMPLE_ERROR_UNSUPPORTED, "host-allocator", crumple_allocator_set(&def));
        printf("this build has no host allocator\n");
        return 0;
    }
    // Bad defs change nothing.
    def.alloc = NULL;
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "alloc", crumple_allocator_set(&def));
    def = allocator_of(&first);
    def.free = NULL;
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "free", crumple_allocator_set(&def));
    def = allocator_of(&first);
    def.struct_size -= 1;
    FAILS(CRUMPLE_ERROR_STRUCT_SIZE, "allocator.struct_size", crumple_allocator_set(&def));
    def = allocator_of(&first);

    // Memory of the system's allocator is alive while hooks come and go.
    CrumpleContext *before = use_all();
    OK(crumple_allocator_set(&def));
    CrumpleContext *during = use_all();
    FACT(first.blocks > 0 && first.calls > 100);
    OK(crumple_context_destroy(before));
    OK(crumple_allocator_set(&other));
    CrumpleContext *after = use_all();
    OK(crumple_context_destroy(during));
    FACT(first.blocks == 0 && first.bytes == 0 && second.blocks > 0);
    OK(crumple_allocator_set(NULL));
    OK(crumple_context_destroy(after));
    FACT(second.blocks == 0 && second.bytes == 0);

    // Nothing is left behind, however often.
    OK(crumple_allocator_set(&def));
    for (int i = 0; i < 20; ++i) {
        OK(crumple_context_destroy(use_all()));
        FACT(first.blocks == 0 && first.bytes == 0);
    }
    printf("%lu allocations, at most %zu bytes at once, all came back\n", first.calls, first.peak);

    // Threads of the library's own leave a little to the next ones, which does not grow.
    size_t most = 0;
    CrumpleExampleSet set;
    OK(crumple_allocator_set(&threaded));
    for (int i = 0; i < 60; ++i) {
        CrumpleContext *context = make_context(3);
        OK(crumple_example_set_create(context, &sheet.def, &set));
        OK(crumple_context_destroy(context));
        if (i < 20) most = third.bytes > most ? third.bytes : most;
        FACT(i < 20 || third.bytes <= most + 16384);
    }
    printf("after contexts with threads %zu bytes are left, at most %zu\n", third.bytes, most);
    OK(crumple_allocator_set(&def));

    // No memory for what the caller's counts ask for: an error, and the context goes on.
    CrumpleContext *context = make_context(1);
    CrumpleExampleSetDef large = sheet.def;
    CrumpleMeshDef mesh = sheet.mesh;
    large.mesh = &mesh;
    enum { MANY = 100000 };
    float(*cloud)[3] = calloc(MANY, sizeof *cloud);
    for (int i = 0; i < MANY; ++i) cloud[i][0] = (float)i, cloud[i][2] = 1;
    mesh.vertex_count = MANY;
    mesh.positions = mesh.normals = input_of(cloud, MANY * sizeof *cloud, 12);
    mesh.tangents = input_of(NULL, 0, 0);
    mesh.indices = input_of(NULL, 0, 0);
    mesh.index_count = 0;
    second.limit = 256 * 1024;
    OK(crumple_allocator_set(&other));
    FAILS_KEEPING(CRUMPLE_ERROR_OUT_OF_MEMORY, "1200000 bytes", set, crumple_example_set_create(context, &large, &set));
    OK(crumple_allocator_set(&def));
    OK(crumple_example_set_create(context, &sheet.def, &set));
    OK(crumple_context_destroy(context));
    FACT(second.blocks == 0);
    free(cloud);

    // Fifteen different allocators, and the first again.
    static Heap heaps[16];
    for (int i = 0; i < 12; ++i) {
        CrumpleAllocatorDef one = allocator_of(&heaps[i]);
        OK(crumple_allocator_set(&one));
    }
    CrumpleAllocatorDef last = allocator_of(&heaps[15]);
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "15 different allocators", crumple_allocator_set(&last));
    OK(crumple_allocator_set(&def));
    OK(crumple_allocator_set(NULL));
    printf("%u checks\n", checks);
    return 0;
}
