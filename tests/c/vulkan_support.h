// What the Vulkan tests share: a sheet's vertices in a VkBuffer, which a device may export.
#ifndef VULKAN_SUPPORT_H
#define VULKAN_SUPPORT_H

#include "support.h"
#include "vulkan_host.h"

#include <crumple_vulkan.h>

// Position, normal, tangent.
enum { FLOATS = 10, STRIDE = FLOATS * 4, GUARD = 4096, RANGE = VERTICES * STRIDE };

static CrumpleVulkanAttachDef vulkan_def(const Host *host) {
    CrumpleVulkanAttachDef def = crumple_vulkan_attach_def_default();
    def.get_instance_proc_addr = (CrumpleVulkanFunction)vkGetInstanceProcAddr;
    def.instance = host->instance;
    def.physical_device = host->physical_device;
    def.device = host->device;
    def.queue_family = host->queue_family;
    return def;
}

// --- A sheet in a VkBuffer that the CPU sees, with a guard before it and one behind it.

static Sheet sheet;

static inline HostBuffer make_vertices(const Host *host) {
    HostBuffer vertices = host_buffer(host, GUARD + RANGE + GUARD, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, true);
    memset(vertices.data, 0xAB, (size_t)vertices.size);
    return vertices;
}

static CrumpleVulkanStream vulkan_stream(uint64_t offset, VkFormat format) {
    CrumpleVulkanStream stream = {0};
    stream.offset = offset;
    stream.stride = STRIDE;
    stream.format = (uint32_t)format;
    return stream;
}

static CrumpleVulkanBufferDef buffer_def(const HostBuffer *vertices) {
    CrumpleVulkanBufferDef def = crumple_vulkan_buffer_def_default();
    def.buffer = (uint64_t)vertices->buffer;
    def.buffer_size = vertices->size;
    def.usage = vertices->usage;
    def.before_stages = def.after_stages = VK_PIPELINE_STAGE_HOST_BIT;
    def.before_access = def.after_access = VK_ACCESS_HOST_READ_BIT;
    def.offset = GUARD;
    def.size = RANGE;
    def.positions = vulkan_stream(0, VK_FORMAT_R32G32B32_SFLOAT);
    def.normals = vulkan_stream(12, VK_FORMAT_R32G32B32_SFLOAT);
    def.tangents = vulkan_stream(24, VK_FORMAT_R32G32B32A32_SFLOAT);
    return def;
}

// The vertices are those that crumple_context_deform() gives, bit for bit (on a device that rounds as IEEE 754 says), and nothing
// beside them was written.
static inline void expect_vertices(const Host *host, const HostBuffer *vertices, CrumpleContext *context, CrumpleInstance instance) {
    static float wanted[VERTICES][FLOATS];
    const unsigned char *bytes = (const unsigned char *)vertices->data;
    CrumpleBuffer buffer = make_buffer(context, instance, host_def(wanted, VERTICES, FLOATS));
    OK(crumple_context_deform(context, &buffer, 1, NULL));
    OK(crumple_buffer_unregister(context, buffer));
    FACT(keeps(bytes, GUARD) && keeps(bytes + GUARD + RANGE, GUARD));
    if (host->software) FACT(memcmp(bytes + GUARD, wanted, sizeof wanted) == 0);
    bool near = true;
    for (int i = 0; i < VERTICES * FLOATS; ++i) {
        float seen;
        memcpy(&seen, bytes + GUARD + 4 * i, 4);
        near = near && fabsf(seen - wanted[i / FLOATS][i % FLOATS]) < 1e-5f;
    }
    FACT(near);
}

// Records one frame, and waits until the device has done it.
static inline CrumpleRecordReport run_frame(const Host *host, CrumpleContext *context, uint64_t frame) {
    CrumpleRecordReport report;
    VkCommandBuffer commands = host_begin(host);
    OK(crumple_vulkan_record(context, commands, frame, NULL, 0, &report));
    host_run(host, commands);
    return report;
}

#ifdef SHARES_FILE_DESCRIPTORS
#include <unistd.h>

// Whether the driver exports semaphores.
static inline bool exports_semaphores(const Host *host) {
    const VkPhysicalDeviceExternalSemaphoreInfo info = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_EXTERNAL_SEMAPHORE_INFO,
                                                        .handleType = VK_EXTERNAL_SEMAPHORE_HANDLE_TYPE_OPAQUE_FD_BIT};
    VkExternalSemaphoreProperties found = {.sType = VK_STRUCTURE_TYPE_EXTERNAL_SEMAPHORE_PROPERTIES};
    vkGetPhysicalDeviceExternalSemaphoreProperties(host->physical_device, &info, &found);
    return (found.externalSemaphoreFeatures & VK_EXTERNAL_SEMAPHORE_FEATURE_EXPORTABLE_BIT) != 0;
}

// The same host with another device, which can export memory, and semaphores if the driver does.
static inline void open_exporting_device(Host *host) {
    static const char *const extensions[] = {VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME, VK_KHR_EXTERNAL_SEMAPHORE_FD_EXTENSION_NAME};
    host_close_device(host);
    host->extensions = extensions;
    host->extension_count = exports_semaphores(host) ? 2 : 1;
    host_open_device(host);
}

// A buffer that the CPU sees, in exported memory that is dedicated to it or begins before it; def is what Crumple must know of it.
static inline HostBuffer make_exported(const Host *host, bool dedicated, CrumpleVulkanImportDef *def) {
    HostBuffer made = {.size = GUARD + RANGE + GUARD, .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT};
    const VkExternalMemoryHandleTypeFlagBits type = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT;
    const VkExternalMemoryBufferCreateInfo external = {.sType = VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO,
                                                       .handleTypes = type};
    const VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .pNext = &external, .size = made.size, .usage = made.usage};
    VK(vkCreateBuffer(host->device, &info, NULL, &made.buffer));
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(host->device, made.buffer, &needs);
    const VkDeviceSize offset = dedicated ? 0 : (GUARD + needs.alignment - 1) / needs.alignment * needs.alignment;
    const VkMemoryDedicatedAllocateInfo alone = {.sType = VK_STRUCTURE_TYPE_MEMORY_DEDICATED_ALLOCATE_INFO, .buffer = made.buffer};
    const VkExportMemoryAllocateInfo export = {
        .sType = VK_STRUCTURE_TYPE_EXPORT_MEMORY_ALLOCATE_INFO, .pNext = dedicated ? &alone : NULL, .handleTypes = type};
    const VkMemoryPropertyFlags flags = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    const VkMemoryAllocateInfo memory = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                         .pNext = &export,
                                         .allocationSize = offset + needs.size,
                                         .memoryTypeIndex = host_memory_type(host, needs.memoryTypeBits, flags)};
    VK(vkAllocateMemory(host->device, &memory, NULL, &made.memory));
    VK(vkBindBufferMemory(host->device, made.buffer, made.memory, offset));
    VK(vkMapMemory(host->device, made.memory, offset, VK_WHOLE_SIZE, 0, &made.data));
    memset(made.data, 0xAB, (size_t)made.size);
    const PFN_vkGetMemoryFdKHR get = (PFN_vkGetMemoryFdKHR)vkGetDeviceProcAddr(host->device, "vkGetMemoryFdKHR");
    const VkMemoryGetFdInfoKHR which = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_GET_FD_INFO_KHR, .memory = made.memory, .handleType = type};
    int fd = -1;
    VK(get(host->device, &which, &fd));
    *def = crumple_vulkan_import_def_default();
    def->handle = fd;
    def->memory_size = offset + needs.size;
    def->offset = offset;
    def->memory_type = memory.memoryTypeIndex;
    def->usage = made.usage;
    def->size = made.size;
    def->dedicated = dedicated;
    return made;
}

// Tells Crumple's own device which one is the host's.
static inline void device_uuid(const Host *host, uint8_t uuid[16]) {
    VkPhysicalDeviceIDProperties ids = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES};
    VkPhysicalDeviceProperties2 properties = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &ids};
    vkGetPhysicalDeviceProperties2(host->physical_device, &properties);
    memcpy(uuid, ids.deviceUUID, sizeof ids.deviceUUID);
}

// Gives the buffer to the other device, or takes it back.
static inline void pass(const Host *host, const HostBuffer *buffer, bool back) {
    const VkBufferMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
        .dstAccessMask = VK_ACCESS_MEMORY_READ_BIT,
        .srcQueueFamilyIndex = back ? VK_QUEUE_FAMILY_EXTERNAL : host->queue_family,
        .dstQueueFamilyIndex = back ? host->queue_family : VK_QUEUE_FAMILY_EXTERNAL,
        .buffer = buffer->buffer,
        .size = VK_WHOLE_SIZE,
    };
    const VkPipelineStageFlags all = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    VkCommandBuffer commands = host_begin(host);
    vkCmdPipelineBarrier(commands, all, all, 0, 0, NULL, 1, &barrier, 0, NULL);
    host_run(host, commands);
}
#endif

#endif
