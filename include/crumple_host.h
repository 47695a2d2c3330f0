// Crumple: the host's allocator, and example sets in several contexts.
//
// This file is generated from the library's source by `cargo xtask header`; do not edit it.

#ifndef CRUMPLE_HOST_H
#define CRUMPLE_HOST_H

#include "crumple.h"

/// Returns size bytes aligned to align (a power of two, at least 16), or null. Must be thread-safe. Must not call
/// Crumple, throw or longjmp out.
typedef void *(*CrumpleAlloc)(size_t size, size_t align, void *user);

/// Frees memory from CrumpleAlloc; size and align are the values it was allocated with. Must be thread-safe. Must not
/// call Crumple, throw or longjmp out.
typedef void (*CrumpleFree)(void *pointer, size_t size, size_t align, void *user);

/// The host's allocator. Both functions are required.
typedef struct CrumpleAllocatorDef {
    uint32_t struct_size;
    CrumpleAlloc alloc;
    CrumpleFree free;
    /// Passed to both. May be null.
    void *user;
} CrumpleAllocatorDef;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

CrumpleAllocatorDef crumple_allocator_def_default(void);
/// Makes the library allocate from your functions, in the whole process, at any time. Null restores the system's
/// allocator. Each block is freed by the functions that allocated it, so they must stay callable. Destroying all
/// contexts frees all blocks, except for a few kB per thread of Crumple's own, kept until process exit. If alloc returns
/// null, the call returns CRUMPLE_ERROR_OUT_OF_MEMORY and changes nothing, or completes with a block of the system's
/// allocator. Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (more than 15 different allocators in a process), CRUMPLE_ERROR_UNSUPPORTED (a build
/// without CRUMPLE_FEATURE_HOST_ALLOCATOR).
CrumpleResult crumple_allocator_set(const CrumpleAllocatorDef *allocator);

/// Gives a set to another context too, without a copy, such as one that loads levels on another thread. Destroying the
/// set in one does not affect the other. Both contexts are in use during the call. Add levels of detail before.
/// CRUMPLE_ERROR_INVALID_ARGUMENT: other is context.
CrumpleResult crumple_example_set_share(CrumpleContext *context, CrumpleExampleSet set, CrumpleContext *other,
                                        CrumpleExampleSet *out_set);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CRUMPLE_HOST_H */
