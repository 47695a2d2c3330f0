// Crumple: writes deformed vertices in passes of your own render graph.
//
// Register vertex buffers with crumple_buffer_register_graph. Once a frame, crumple_graph_plan returns what to upload and to
// dispatch, with kernels of crumple_graph_get_kernel. Crumple calls no graphics library.
//
// This file is generated from the library's source by `cargo xtask header`; do not edit it.

#ifndef CRUMPLE_GRAPH_H
#define CRUMPLE_GRAPH_H

#include "crumple_vulkan.h"

/// Bytes to copy into a storage of the render graph.
typedef struct CrumpleGraphUpload {
    /// Number of the storage. Create a storage buffer of storage_size bytes for a number that is new to you.
    uint32_t storage;
    uint32_t reserved;
    uint64_t storage_size;
    /// Where the bytes go, from the start of the storage.
    uint64_t offset;
    const void *data;
    /// Bytes at data.
    size_t size;
} CrumpleGraphUpload;

/// A compute dispatch of the render graph.
typedef struct CrumpleGraphDispatch {
    /// Number of the kernel; see crumple_graph_get_kernel().
    uint32_t kernel;
    /// Number of the storage to bind.
    uint32_t storage;
    /// The vertex buffer to bind: the buffer field of its CrumpleVulkanBufferDef.
    uint64_t buffer;
    /// Workgroups along x and y. Use 1 along z.
    uint32_t groups[2];
    /// The push constants, 32 bytes. Kernels read the first 28; some engines take multiples of 16 only.
    uint32_t constants[8];
} CrumpleGraphDispatch;

/// The passes of a frame. All pointers are valid until the next crumple_graph_plan() of the context.
typedef struct CrumpleGraphPlan {
    /// Numbers of storages that you may destroy once earlier frames are complete. Ignore those that you do not know.
    const uint32_t *freed;
    /// Copies that you do before the dispatches, in any case.
    const CrumpleGraphUpload *uploads;
    /// Dispatches in any order; they write different vertices.
    const CrumpleGraphDispatch *dispatches;
    /// The work of the frame, for all dispatches.
    const void *work;
    /// Bytes at work. 0 if there are no dispatches.
    size_t work_size;
    uint32_t freed_count;
    uint32_t upload_count;
    uint32_t dispatch_count;
    uint32_t reserved;
} CrumpleGraphPlan;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// Returns a compute shader for a render graph that takes SPIR-V, such as Godot's RenderingDevice. It is SPIR-V 1.3
/// with the entry point "main". Make a pipeline of it when a dispatch first names its number.
///
/// All kernels have 32 bytes of push constants and three storage buffers: a storage (set 0, binding 0, read), the work
/// (set 0, binding 1, read) and your vertex buffer from its first byte on (set 1, binding 0, read and written). Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (a kernel that no dispatch names).
CrumpleResult crumple_graph_get_kernel(uint32_t kernel, void *data, size_t capacity, size_t *out_size);

/// Registers a range of a vertex buffer of your render graph, like crumple_buffer_register_vulkan() but without a Vulkan
/// device. def->buffer is any number of yours, which dispatches name. usage, queue_family, stages and accesses are
/// ignored. The first range of a mesh adds uploads to the next plan. Errors: those of crumple_buffer_register_vulkan(),
/// and CRUMPLE_ERROR_WRONG_RULE (a classic rule).
CrumpleResult crumple_buffer_register_graph(CrumpleContext *context, CrumpleInstance instance,
                                            const CrumpleVulkanBufferDef *def, CrumpleBuffer *out_buffer);

/// Plans the passes that write the deformed vertices of count buffers of crumple_buffer_register_graph(), or of all of
/// them if buffers is null and count 0: for the blocks that changed, one dispatch per vertex buffer. Call it once a
/// frame, do the uploads, bind and dispatch. If you drop the dispatches, call crumple_buffer_invalidate() for their
/// buffers. out_report may be null. CRUMPLE_ERROR_INVALID_ARGUMENT: a buffer twice, or another kind of buffer.
CrumpleResult crumple_graph_plan(CrumpleContext *context, const CrumpleBuffer *buffers, uint32_t count,
                                 CrumpleGraphPlan *out_plan, CrumpleRecordReport *out_report);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CRUMPLE_GRAPH_H */
