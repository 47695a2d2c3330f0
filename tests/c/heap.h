// A heap that counts, for crumple_allocator_set().
#ifndef HEAP_H
#define HEAP_H

#include "aligned.h"

#include <crumple_host.h>

#include <stdbool.h>

static struct Heap {
    long blocks;
    size_t bytes, peak;
    unsigned long calls;
} heap;

static void *host_alloc(size_t size, size_t align, void *user) {
    (void)user;
    ++heap.calls;
    void *memory = aligned_memory(size, align);
    if (!memory) return NULL;
    ++heap.blocks;
    heap.bytes += size;
    if (heap.bytes > heap.peak) heap.peak = heap.bytes;
    return memory;
}

static void host_free(void *pointer, size_t size, size_t align, void *user) {
    (void)align, (void)user;
    --heap.blocks;
    heap.bytes -= size;
    free_aligned(pointer);
}

// Gives the heap to Crumple. Returns false if the build of the library has no host allocator.
static bool use_heap(void) {
    CrumpleAllocatorDef def = crumple_allocator_def_default();
    def.alloc = host_alloc;
    def.free = host_free;
    return (crumple_features() & CRUMPLE_FEATURE_HOST_ALLOCATOR) && crumple_allocator_set(&def) == CRUMPLE_OK;
}

#endif
