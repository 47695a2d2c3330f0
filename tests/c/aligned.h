// Memory of any alignment for the hosts' allocators of the tests.
#ifndef ALIGNED_H
#define ALIGNED_H

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

#endif
