// What the tests of shared memory need: a host's device that exports memory, and a buffer of it.
#ifndef VULKAN_EXPORT_H
#define VULKAN_EXPORT_H

#include "vulkan_support.h"

// The same host with another device, which can export memory.
static void open_exporting_device(Host *host) {
    host_close_device(host);
    host->extension = VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME;
    host_open_device(host);
}

// A buffer that the CPU sees, in memory of its own that is exported; def is what Crumple must know of it.
static HostBuffer make_exported(const Host *host, CrumpleVulkanImportDef *def) {
    HostBuffer made = {.size = GUARD + RANGE + GUARD, .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT};
    const VkExternalMemoryHandleTypeFlagBits type = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT;
    const VkExternalMemoryBufferCreateInfo external = {.sType = VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO,
                                                       .handleTypes = type};
    const VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .pNext = &external, .size = made.size, .usage = made.usage};
    VK(vkCreateBuffer(host->device, &info, NULL, &made.buffer));
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(host->device, made.buffer, &needs);
    const VkMemoryDedicatedAllocateInfo dedicated = {.sType = VK_STRUCTURE_TYPE_MEMORY_DEDICATED_ALLOCATE_INFO,
                                                     .buffer = made.buffer};
    const VkExportMemoryAllocateInfo export = {
        .sType = VK_STRUCTURE_TYPE_EXPORT_MEMORY_ALLOCATE_INFO, .pNext = &dedicated, .handleTypes = type};
    const VkMemoryPropertyFlags flags = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    const VkMemoryAllocateInfo memory = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                         .pNext = &export,
                                         .allocationSize = needs.size,
                                         .memoryTypeIndex = host_memory_type(host, needs.memoryTypeBits, flags)};
    VK(vkAllocateMemory(host->device, &memory, NULL, &made.memory));
    VK(vkBindBufferMemory(host->device, made.buffer, made.memory, 0));
    VK(vkMapMemory(host->device, made.memory, 0, VK_WHOLE_SIZE, 0, &made.data));
    memset(made.data, 0xAB, (size_t)made.size);
    const PFN_vkGetMemoryFdKHR get = (PFN_vkGetMemoryFdKHR)vkGetDeviceProcAddr(host->device, "vkGetMemoryFdKHR");
    const VkMemoryGetFdInfoKHR which = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_GET_FD_INFO_KHR, .memory = made.memory, .handleType = type};
    int fd = -1;
    VK(get(host->device, &which, &fd));
    *def = crumple_vulkan_import_def_default();
    def->handle = fd;
    def->memory_size = needs.size;
    def->memory_type = memory.memoryTypeIndex;
    def->usage = made.usage;
    def->size = made.size;
    def->dedicated = true;
    return made;
}

// Tells Crumple's own device which one is the host's.
static void device_uuid(const Host *host, uint8_t uuid[16]) {
    VkPhysicalDeviceIDProperties ids = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES};
    VkPhysicalDeviceProperties2 properties = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &ids};
    vkGetPhysicalDeviceProperties2(host->physical_device, &properties);
    memcpy(uuid, ids.deviceUUID, sizeof ids.deviceUUID);
}

// Gives the buffer to the other device, or takes it back.
static void pass(const Host *host, const HostBuffer *buffer, bool back) {
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
