// What an engine with a Vulkan renderer has already, as small as can be: an instance, a device with one queue, buffers. The
// Vulkan examples and tests share it; nothing in it is about Crumple.
//
// With CRUMPLE_VALIDATION=1 in the environment the Khronos validation layer watches, synchronization included, and
// host_close() fails the program if it said anything. Where there is no Vulkan driver host_open() says so and ends the
// program with 77, which CTest counts as skipped; with CRUMPLE_REQUIRE_GPU=1 that is a failure.
#ifndef VULKAN_HOST_H
#define VULKAN_HOST_H

#include <vulkan/vulkan.h>

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct Host {
    VkInstance instance;
    VkPhysicalDevice physical_device;
    VkDevice device;
    uint32_t queue_family; // draws and computes
    VkQueue queue;
    VkCommandPool pool;
    char name[VK_MAX_PHYSICAL_DEVICE_NAME_SIZE];
    bool software; // the device is this machine's processor
    VkDebugUtilsMessengerEXT messenger;
} Host;

// A buffer with memory of its own.
typedef struct HostBuffer {
    VkBuffer buffer;
    VkDeviceMemory memory;
    VkDeviceSize size; // bytes
    VkBufferUsageFlags usage;
    void *data; // where the CPU sees it; null for a buffer in the device's own memory
} HostBuffer;

// Ends the program where a call of Vulkan fails.
#define VK(call) host_check((call), #call, __FILE__, __LINE__)
void host_check(VkResult result, const char *call, const char *file, int line);

// The first device there is.
void host_open(Host *host);
// The rest, which host_open() does too: after a lost device, a new one of the same physical device.
void host_open_device(Host *host);
void host_close_device(Host *host);
// Ends the program if the validation layer had anything to say.
void host_close(Host *host);

// Memory that the CPU sees too, or the device's own.
HostBuffer host_buffer(const Host *host, VkDeviceSize size, VkBufferUsageFlags usage, bool seen_by_cpu);
void host_destroy_buffer(const Host *host, HostBuffer *buffer);
uint32_t host_memory_type(const Host *host, uint32_t allowed, VkMemoryPropertyFlags flags);

// A primary command buffer in the recording state, to be submitted once.
VkCommandBuffer host_begin(const Host *host);
// Ends, submits, waits until the device is done, and frees it.
void host_run(const Host *host, VkCommandBuffer commands);
// Everything recorded so far comes before everything recorded from here on. Correct anywhere, and slow: engines know better.
void host_barrier(VkCommandBuffer commands);

#ifdef __cplusplus
}
#endif

#endif
