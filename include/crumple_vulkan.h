// Crumple: writes deformed vertices by a Vulkan device instead of the CPU.
//
// With your device: crumple_vulkan_attach, crumple_buffer_register_vulkan, and once a frame crumple_vulkan_record into your
// VkCommandBuffer and crumple_vulkan_complete_frames. With a device of Crumple's own, which shares memory with yours:
// crumple_vulkan_open, crumple_vulkan_import_buffer, crumple_buffer_register_vulkan, and once a frame crumple_vulkan_submit.
//
// Every call with a context may also return CRUMPLE_ERROR_VULKAN and CRUMPLE_ERROR_DEVICE_LOST.
//
// This file is generated from the library's source by `cargo xtask header`; do not edit it.

#ifndef CRUMPLE_VULKAN_H
#define CRUMPLE_VULKAN_H

#include "crumple.h"

/// The type of a handle to shared memory or to a semaphore.
typedef enum CrumpleHandleType {
    /// A file descriptor, VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT. Crumple duplicates it; you close yours. Linux
    /// and Android.
    CRUMPLE_HANDLE_TYPE_OPAQUE_FD = 0,
    /// A HANDLE, VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_WIN32_BIT. Windows. Untested.
    CRUMPLE_HANDLE_TYPE_OPAQUE_WIN32 = 1,
} CrumpleHandleType;

/// Any Vulkan function, like PFN_vkVoidFunction. Cast to it: (CrumpleVulkanFunction)vkGetInstanceProcAddr.
typedef void (*CrumpleVulkanFunction)(void);

/// Your Vulkan device, Vulkan 1.1 or later: a VkInstance, a VkPhysicalDevice and a VkDevice, all required. No extension
/// or feature needs to be enabled.
typedef struct CrumpleVulkanAttachDef {
    uint32_t struct_size;
    /// Family of the queue that executes the command buffers, with compute. Required. Default UINT32_MAX (invalid).
    uint32_t queue_family;
    /// vkGetInstanceProcAddr of the instance's loader. Crumple gets every function from it and never opens a Vulkan
    /// library. Required.
    CrumpleVulkanFunction get_instance_proc_addr;
    void *instance;
    void *physical_device;
    void *device;
    /// Data of crumple_vulkan_get_pipeline_cache() from an earlier run, read during the call. Data of another driver is
    /// ignored. Default null.
    const void *pipeline_cache;
    /// Bytes at pipeline_cache.
    size_t pipeline_cache_size;
    /// Invocations per workgroup: 32, 64 or 128, within the device's limit. Default 128. Where an
    /// invocation writes two vertices, workgroups have at most 64.
    uint32_t workgroup_size;
} CrumpleVulkanAttachDef;

/// Where the values of one attribute are stored. All fields zero: absent.
typedef struct CrumpleVulkanStream {
    /// Bytes from the start of the range to the first value, a multiple of 4.
    uint64_t offset;
    /// Bytes from one value to the next: at least the size of a value, a multiple of 4.
    uint64_t stride;
    /// A VkFormat. Positions: R32G32B32_SFLOAT, R16G16B16A16_SFLOAT (w is 1), R16G16B16A16_SNORM (see
    /// CrumpleVulkanBufferDef.scale). Normals: R32G32B32_SFLOAT, R16G16B16A16_SNORM, R8G8B8A8_SNORM (w is 0),
    /// R16G16_UNORM (octahedral, see CRUMPLE_DIRECTION_FORMAT_OCTAHEDRAL). Tangents: R32G32B32A32_SFLOAT,
    /// R16G16B16A16_SNORM, R8G8B8A8_SNORM, R16G16_UNORM (octahedral).
    uint32_t format;
    uint32_t reserved;
} CrumpleVulkanStream;

/// A range of a VkBuffer for the deformed vertices of one instance, in the mesh's order and space. Fields without a
/// comment are as in CrumpleHostBufferDef.
typedef struct CrumpleVulkanBufferDef {
    uint32_t struct_size;
    uint32_t lod;
    uint64_t user_data;
    /// The VkBuffer, bound to memory: (uint64_t)handle. Required. One VkBuffer may hold any number of ranges; their
    /// buffer_size, usage, queue_family and four stage and access fields must be equal.
    uint64_t buffer;
    /// Bytes of the whole VkBuffer. Required.
    uint64_t buffer_size;
    /// VkBufferUsageFlags of the VkBuffer. They must include VK_BUFFER_USAGE_STORAGE_BUFFER_BIT. Required.
    uint32_t usage;
    /// The other queue family that owns the VkBuffer. Default VK_QUEUE_FAMILY_IGNORED: the attached queue family owns
    /// it, or it is VK_SHARING_MODE_CONCURRENT. With another owner, each recording that includes one of its ranges
    /// begins with an acquire and ends with a release of the whole VkBuffer, even without changes. You record the
    /// matching release and acquire on the other queue.
    uint32_t queue_family;
    /// VkPipelineStageFlags of your last uses of the VkBuffer before a recording, not 0. Barriers cover the whole
    /// VkBuffer, so include the stages of index reads, copies and read-backs. Default
    /// VK_PIPELINE_STAGE_VERTEX_INPUT_BIT.
    uint32_t before_stages;
    /// VkAccessFlags of those uses. Default VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT.
    uint32_t before_access;
    /// VkPipelineStageFlags of your next uses of anything in the VkBuffer, not 0. Default
    /// VK_PIPELINE_STAGE_VERTEX_INPUT_BIT.
    uint32_t after_stages;
    /// VkAccessFlags of those uses. Default VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT.
    uint32_t after_access;
    /// Start of the range, bytes, a multiple of 4.
    uint64_t offset;
    /// Bytes of the range. Nothing outside is written. Ranges may interleave, but values must not overlap. Required.
    uint64_t size;
    CrumpleVulkanStream positions;
    CrumpleVulkanStream normals;
    CrumpleVulkanStream tangents;
    /// For positions in R16G16B16A16_SNORM: a stored value s in -1 to 1 means s * scale + bias, m. Positions outside
    /// that range are clamped, so it must cover the mesh's bounds grown by the depth limit. Above 0. Default 1, 1, 1.
    CrumpleVec3 scale;
    CrumpleVec3 bias;
} CrumpleVulkanBufferDef;

/// The recorded work. Fields without a comment are as in CrumpleDeformReport.
typedef struct CrumpleRecordReport {
    uint64_t vertices_written;
    /// Blocks that will be written. 0: only queue-family transfers were recorded, if any.
    uint64_t blocks_written;
    uint64_t blocks_skipped;
    /// Bytes that the commands copy to the device, including meshes used for the first time.
    uint64_t bytes_copied;
    /// Dispatches: one per VkBuffer, and one per buffer of an instance with a classic rule.
    uint32_t dispatches;
    uint32_t reserved0;
    uint64_t vertices_waiting;
    uint64_t reserved[3];
} CrumpleRecordReport;

/// A Vulkan device that Crumple creates beside yours, on the same physical device. Fields without a comment are as in
/// CrumpleVulkanAttachDef.
typedef struct CrumpleVulkanOpenDef {
    uint32_t struct_size;
    uint32_t workgroup_size;
    /// vkGetInstanceProcAddr of a loader that stays loaded. Required.
    CrumpleVulkanFunction get_instance_proc_addr;
    /// deviceUUID of your physical device (VkPhysicalDeviceIDProperties). Devices with equal UUIDs can share memory.
    /// Default zero: the first device that supports compute.
    uint8_t device_uuid[16];
    const void *pipeline_cache;
    /// Bytes at pipeline_cache.
    size_t pipeline_cache_size;
} CrumpleVulkanOpenDef;

/// A VkBuffer of your device that Crumple imports. Create it with VkExternalMemoryBufferCreateInfo, and its memory with
/// VkExportMemoryAllocateInfo, both with handle_type (default CRUMPLE_HANDLE_TYPE_OPAQUE_FD). offset is where the
/// VkBuffer starts in the memory (default 0) and size is its size, bytes. usage is as in CrumpleVulkanBufferDef.
typedef struct CrumpleVulkanImportDef {
    uint32_t struct_size;
    CrumpleHandleType handle_type;
    /// Handle of the memory. Required. Default -1.
    int64_t handle;
    /// allocationSize of the memory, bytes. Required.
    uint64_t memory_size;
    /// memoryTypeIndex of the memory. Required.
    uint32_t memory_type;
    uint32_t usage;
    uint64_t offset;
    uint64_t size;
    /// Whether the memory is dedicated to this buffer (VkMemoryDedicatedAllocateInfo). Default false.
    bool dedicated;
} CrumpleVulkanImportDef;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

CrumpleVulkanAttachDef crumple_vulkan_attach_def_default(void);
/// Attaches your Vulkan device, one per context. The handles must be valid,
/// belong together, and live until crumple_vulkan_detach() or crumple_context_destroy(). Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (a device is already attached, a queue family that does not exist or lacks compute, a
/// bad workgroup_size), CRUMPLE_ERROR_UNSUPPORTED (below Vulkan 1.1, or a loader that lacks a function).
CrumpleResult crumple_vulkan_attach(CrumpleContext *context, const CrumpleVulkanAttachDef *def);

/// Detaches the Vulkan device. Unregisters all Vulkan buffers and destroys Crumple's objects on the device. Damage
/// stays. After CRUMPLE_ERROR_DEVICE_LOST, call crumple_vulkan_complete_frames() with UINT64_MAX, then this, then
/// vkDestroyDevice. Then attach the new device and register the buffers again. CRUMPLE_ERROR_FRAMES_IN_FLIGHT: nothing
/// changed.
CrumpleResult crumple_vulkan_detach(CrumpleContext *context);

/// Returns pipeline cache data for the next run's crumple_vulkan_attach(). The size may grow until you have registered
/// every kind of buffer.
CrumpleResult crumple_vulkan_get_pipeline_cache(CrumpleContext *context, void *data, size_t capacity, size_t *out_size);

CrumpleVulkanBufferDef crumple_vulkan_buffer_def_default(void);
/// Registers a range of a VkBuffer for an instance's deformed vertices. The first recording writes every vertex. An
/// instance may have several ranges, such as a ring. The first range of a mesh copies the mesh and its examples to a
/// staging buffer, and the next recording copies them to the device; all instances and ranges share them. The VkBuffer
/// must exist until its last range is unregistered and the frames that wrote it are complete. Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (no device, stages of 0, an unsupported format, overlapping attributes, a scale not
/// above 0, a VkBuffer already registered with other values), CRUMPLE_ERROR_WRONG_RULE (lod above 0 with a classic
/// rule), CRUMPLE_ERROR_UNSUPPORTED (normals or tangents that the mesh lacks; more bytes than the device can bind).
CrumpleResult crumple_buffer_register_vulkan(CrumpleContext *context, CrumpleInstance instance,
                                             const CrumpleVulkanBufferDef *def, CrumpleBuffer *out_buffer);

/// Records commands that write the deformed vertices of count Vulkan buffers, or of all Vulkan buffers of the context
/// if buffers is null and count 0. For the blocks that changed it records a copy of a few bytes per block, a barrier,
/// one dispatch per VkBuffer and a barrier. It submits nothing, waits for nothing, and does not allocate in steady
/// state. You may change damage right after the call.
///
/// command_buffer is a VkCommandBuffer in the recording state, outside a render pass, of the attached queue family,
/// whose pool no other thread uses. Submit it once, and submit recordings in the order in which they were recorded.
/// frame is your frame number: it starts at 1 and never decreases; recordings may share one. out_report may be null.
///
/// The commands change only the compute pipeline, compute descriptor sets 0 to 2 and the first 28 bytes of push
/// constants for compute. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (no device of crumple_vulkan_attach(), a buffer twice,
/// a host buffer, a frame that is complete or below the last), CRUMPLE_ERROR_UNSUPPORTED (more work than the device can
/// bind). Nothing was recorded.
CrumpleResult crumple_vulkan_record(CrumpleContext *context, void *command_buffer, uint64_t frame,
                                    const CrumpleBuffer *buffers, uint32_t count, CrumpleRecordReport *out_report);

/// Declares that the device has completed frame and all earlier ones, as a fence or timeline semaphore tells you. Their
/// resources are reused or freed. Call it once a frame. A number above the last recorded frame counts as
/// that frame.
CrumpleResult crumple_vulkan_complete_frames(CrumpleContext *context, uint64_t frame);

/// Declares that recordings of frame and later frames will not be submitted. The next recording writes every vertex of
/// their buffers.
CrumpleResult crumple_vulkan_discard_frames(CrumpleContext *context, uint64_t frame);

CrumpleVulkanOpenDef crumple_vulkan_open_def_default(void);
/// Creates a Vulkan device of Crumple's own, for engines that can share memory but cannot hand out a command buffer.
/// It may take long. Use it instead of crumple_vulkan_attach(): import buffers, register them,
/// and write them with crumple_vulkan_submit(). crumple_vulkan_detach() and crumple_context_destroy() wait for the
/// device and destroy it. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (a device is already attached, a bad workgroup_size),
/// CRUMPLE_ERROR_UNSUPPORTED (no such device, or one that cannot import memory).
CrumpleResult crumple_vulkan_open(CrumpleContext *context, const CrumpleVulkanOpenDef *def);

CrumpleVulkanImportDef crumple_vulkan_import_def_default(void);
/// Imports a buffer of your device into Crumple's device. Use out_buffer as the buffer field of CrumpleVulkanBufferDef;
/// its buffer_size, usage, queue_family, stages and accesses are then ignored. Before each submit, release the VkBuffer
/// to VK_QUEUE_FAMILY_EXTERNAL on your queue. Acquire it afterwards. The memory must exist until
/// crumple_vulkan_unimport_buffer(), crumple_vulkan_detach() or crumple_context_destroy(). Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (no device of crumple_vulkan_open(), a bad handle, an unsuitable memory type or
/// usage), CRUMPLE_ERROR_UNSUPPORTED (a handle type of another system, or a buffer that the device cannot import).
CrumpleResult crumple_vulkan_import_buffer(CrumpleContext *context, const CrumpleVulkanImportDef *def,
                                           uint64_t *out_buffer);

/// Releases an imported buffer once the device is done with it. CRUMPLE_ERROR_INVALID_ARGUMENT: it still has ranges.
CrumpleResult crumple_vulkan_unimport_buffer(CrumpleContext *context, uint64_t buffer);

/// Imports a binary semaphore of your device, exported with this handle type. Pass out_semaphore to
/// crumple_vulkan_submit(). It lives until crumple_vulkan_detach() or crumple_context_destroy(). Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (no device of crumple_vulkan_open(), a bad handle), CRUMPLE_ERROR_UNSUPPORTED (a
/// driver without external semaphores; use fences and crumple_vulkan_wait_frame()).
CrumpleResult crumple_vulkan_import_semaphore(CrumpleContext *context, CrumpleHandleType handle_type, int64_t handle,
                                              uint64_t *out_semaphore);

/// Like crumple_vulkan_record(), but submits the work to Crumple's own device. The device first waits for the
/// wait_count semaphores at waits, and last signals the signal_count semaphores at signals, even without changes. The
/// call itself does not wait. out_frame receives the frame number for crumple_vulkan_wait_frame(). out_frame and
/// out_report may be null. After an error nothing was submitted.
CrumpleResult crumple_vulkan_submit(CrumpleContext *context, const CrumpleBuffer *buffers, uint32_t count,
                                    const uint64_t *waits, uint32_t wait_count, const uint64_t *signals,
                                    uint32_t signal_count, uint64_t *out_frame, CrumpleRecordReport *out_report);

/// Waits until Crumple's own device has completed a frame and all earlier ones, at most timeout nanoseconds
/// (UINT64_MAX: no limit). out_done receives whether the frame is complete. The context is in use while the call waits.
/// CRUMPLE_ERROR_INVALID_ARGUMENT: the frame was not submitted.
CrumpleResult crumple_vulkan_wait_frame(CrumpleContext *context, uint64_t frame, uint64_t timeout, bool *out_done);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CRUMPLE_VULKAN_H */
