// What the Vulkan tests share: a sheet's vertices in a VkBuffer.
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

#endif
