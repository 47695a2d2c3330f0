// A host's allocator for crumple_allocator_set(): it counts its blocks, checks what comes back, and refuses what it is told to.
#ifndef HEAP_H
#define HEAP_H

#include <crumple_host.h>

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#ifdef _WIN32
#include <malloc.h>
static inline void *aligned_memory(size_t size, size_t align) { return _aligned_malloc(size, align); }
static inline void free_aligned(void *memory) { _aligned_free(memory); }
#else
static inline void *aligned_memory(size_t size, size_t align) {
    void *memory = NULL;
    return posix_memalign(&memory, align, size) == 0 ? memory : NULL;
}
static inline void free_aligned(void *memory) { free(memory); }
#endif

// Like FACT, for functions that run on several threads.
#define MUST(condition) ((condition) ? (void)0 : (fprintf(stderr, "not so: %s\n", #condition), exit(1)))

typedef struct Heap {
    long blocks;
    size_t bytes, peak;
    unsigned long calls;
    unsigned long refuse_in; // the block that is refused, counted from 1; 0: none
    bool refuse_later;       // all blocks after it too
    bool refused;
    void (*lock)(bool take); // null where one thread allocates
} Heap;

// Before each block, so that free can check what it is told. Nothing lies between a block's end and that of its memory.
typedef struct Head {
    size_t size, align;
    Heap *heap;
} Head;
enum { HEAD = 64 };

static inline size_t before_block(size_t align) { return align > HEAD ? align : HEAD; }

static inline void count_block(Heap *heap, long blocks, size_t bytes) {
    if (heap->lock) heap->lock(true);
    heap->blocks += blocks;
    heap->bytes += bytes; // may wrap around
    heap->calls += blocks > 0;
    if (heap->bytes > heap->peak) heap->peak = heap->bytes;
    if (heap->lock) heap->lock(false);
}

static inline void *host_alloc(size_t size, size_t align, void *user) {
    Heap *heap = (Heap *)user;
    MUST(size > 0 && align >= 16 && (align & (align - 1)) == 0);
    if (heap->refuse_in > 0 && --heap->refuse_in == 0) {
        heap->refused = true;
        heap->refuse_in = heap->refuse_later;
        return NULL;
    }
    char *raw = (char *)aligned_memory(before_block(align) + size, align);
    if (!raw) return NULL;
    const Head head = {size, align, heap};
    *(Head *)(void *)raw = head;
    count_block(heap, 1, size);
    return raw + before_block(align);
}

static inline void host_free(void *block, size_t size, size_t align, void *user) {
    Heap *heap = (Heap *)user;
    Head *head = (Head *)(void *)((char *)block - before_block(align));
    MUST(head->size == size && head->align == align && head->heap == heap);
    head->heap = NULL;
    count_block(heap, -1, (size_t)0 - size);
    free_aligned(head);
}

static inline CrumpleAllocatorDef allocator_of(Heap *heap) {
    CrumpleAllocatorDef def = crumple_allocator_def_default();
    def.alloc = host_alloc;
    def.free = host_free;
    def.user = heap;
    return def;
}

// Makes Crumple use the heap. Returns false if the build of the library has no host allocator.
static inline bool use_heap(Heap *heap) {
    const CrumpleAllocatorDef def = allocator_of(heap);
    return (crumple_features() & CRUMPLE_FEATURE_HOST_ALLOCATOR) && crumple_allocator_set(&def) == CRUMPLE_OK;
}

#endif
