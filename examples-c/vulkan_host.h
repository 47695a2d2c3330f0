// A minimal stand-in for an engine's Vulkan renderer: an instance, a device with one queue, and buffers. The Vulkan examples
// and tests share it. It does not use Crumple.
//
// CRUMPLE_VALIDATION=1 in the environment enables the Khronos validation layer with synchronization validation.
// host_close() then fails the program if the layer reported anything. Without a Vulkan driver, host_open() prints a message
// and exits with 77, which CTest counts as skipped; with CRUMPLE_REQUIRE_GPU=1 that is a failure.
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
    uint32_t queue_family; // supports graphics and compute
    VkQueue queue;
    VkCommandPool pool;
    char name[VK_MAX_PHYSICAL_DEVICE_NAME_SIZE];
    bool software; // the device is a CPU driver
    const char *const *extensions; // of the device, for host_open_device()
    uint32_t extension_count;
    VkDebugUtilsMessengerEXT messenger;
} Host;

// A buffer with its own memory.
typedef struct HostBuffer {
    VkBuffer buffer;
    VkDeviceMemory memory;
    VkDeviceSize size; // bytes
    VkBufferUsageFlags usage;
    void *data; // mapped memory; null for a buffer in device-local memory
} HostBuffer;

// Ends the program if a Vulkan call fails.
#define VK(call) host_check((call), #call, __FILE__, __LINE__)
void host_check(VkResult result, const char *call, const char *file, int line);

// Opens the first Vulkan device.
void host_open(Host *host);
// Creates the device, queue and pool; part of host_open(). After a lost device, it creates a new one on the same physical
// device.
void host_open_device(Host *host);
void host_close_device(Host *host);
// Closes everything. Ends the program if the validation layer reported anything.
void host_close(Host *host);

// Creates a buffer in mapped memory if seen_by_cpu, else in device-local memory.
HostBuffer host_buffer(const Host *host, VkDeviceSize size, VkBufferUsageFlags usage, bool seen_by_cpu);
void host_destroy_buffer(const Host *host, HostBuffer *buffer);
uint32_t host_memory_type(const Host *host, uint32_t allowed, VkMemoryPropertyFlags flags);

// Returns a primary command buffer in the recording state. Submit it once.
VkCommandBuffer host_begin(const Host *host);
// Ends and submits the command buffer, waits until the device is done, and frees it.
void host_run(const Host *host, VkCommandBuffer commands);
// Records a full barrier: everything recorded before it finishes before anything after it starts. Always correct, but slow;
// engines use narrower barriers.
void host_barrier(VkCommandBuffer commands);

#ifdef __cplusplus
}
#endif

#endif
