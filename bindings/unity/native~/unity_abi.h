// What of Unity's plugin interface the plugin calls, as far as a program in C++ must know it: an independent declaration.
//
// Unity's own headers (IUnityInterface.h, IUnityGraphics.h, IUnityGraphicsVulkan.h) carry Unity's licence and are not here. This
// file was written from public facts about their binary interface: which functions stand at which place of a table, what they
// take, which members structs have and in which order, the numbers of enumerators and interfaces. Names are ours. Members that
// the plugin does not use are `Unused`. The asserts hold the sizes and places down on 64-bit machines, the only ones that the
// package is for.
#ifndef CRUMPLE_UNITY_ABI_H
#define CRUMPLE_UNITY_ABI_H

#include <vulkan/vulkan_core.h>

#include <cstddef>
#include <cstdint>

#if defined(_WIN32)
#define UNITY_CALL __stdcall
#else
#define UNITY_CALL
#endif

namespace unity {

using Unused = void(UNITY_CALL *)();

// --- The registry of interfaces that UnityPluginLoad() is given.

struct Id {
    unsigned long long high, low;
};

struct Interfaces {
    Unused get, put;
    void *(UNITY_CALL *get_by_numbers)(unsigned long long high, unsigned long long low); // null: there is no such interface
    Unused put_by_numbers;
};

// --- Which renderer runs, and when its device comes and goes.

constexpr Id GRAPHICS{0x7CBA0A9CA4DDB544, 0x8C5AD4926EB17B11};

enum class Renderer : int { Vulkan = 21 };

enum class DeviceEvent : int { Initialize = 0, Shutdown = 1, BeforeReset = 2, AfterReset = 3 };

using OnDeviceEvent = void(UNITY_CALL *)(DeviceEvent event);
// What CommandBuffer.IssuePluginEvent() calls, on the render thread.
using OnRenderEvent = void(UNITY_CALL *)(int event_id);

struct Graphics {
    Renderer(UNITY_CALL *renderer)(); // any thread
    void(UNITY_CALL *add_device_callback)(OnDeviceEvent callback);
    void(UNITY_CALL *remove_device_callback)(OnDeviceEvent callback);
    int(UNITY_CALL *reserve_event_ids)(int count); // the first of them
};

// --- Vulkan. The table that every version with Vulkan hands out; a later one adds functions that the plugin has no use for.

constexpr Id GRAPHICS_VULKAN{0x95355348D4EF4E11, 0x9789313DFCFFCC87};

struct VulkanInstance {
    VkPipelineCache pipeline_cache;
    VkInstance instance;
    VkPhysicalDevice physical_device;
    VkDevice device;
    VkQueue graphics_queue;
    PFN_vkGetInstanceProcAddr get_instance_proc_addr;
    unsigned queue_family;
    void *reserved[8];
};

struct VulkanMemory {
    VkDeviceMemory memory;
    VkDeviceSize offset, size;
    void *mapped; // null: the CPU does not see it
    VkMemoryPropertyFlags flags;
    unsigned type;
    void *reserved[4];
};

struct VulkanBuffer {
    VulkanMemory memory;
    VkBuffer buffer;
    size_t size; // bytes
    VkBufferUsageFlags usage;
    void *reserved[4];
};

struct Recording {
    VkCommandBuffer commands;
    VkCommandBufferLevel level;
    VkRenderPass render_pass;
    VkFramebuffer framebuffer;
    int subpass; // -1: outside a render pass
    unsigned long long current_frame;
    unsigned long long safe_frame; // the device is done with it and all before it
    void *reserved[4];
};

enum class Access : int { Observe = 0, Barrier = 1, Recreate = 2 };
enum class RenderPass : int { Any = 0, Inside = 1, Outside = 2 };
enum class QueueAccess : int { None = 0, Allow = 1 };

constexpr uint32_t AFTER_PREVIOUS_FRAME = 1u << 0; // EnsurePreviousFrameSubmission
constexpr uint32_t CHANGES_STATE = 1u << 3;        // ModifiesCommandBuffersState

struct EventConfig {
    RenderPass render_pass;
    QueueAccess queue;
    uint32_t flags;
};

struct GraphicsVulkan {
    Unused intercept_initialization, intercept_function;
    void(UNITY_CALL *configure_event)(int event_id, const EventConfig *config);
    VulkanInstance(UNITY_CALL *instance)();
    // False: there is nothing to record into. What it gave is void after the next access to a resource.
    bool(UNITY_CALL *recording)(Recording *out, QueueAccess queue);
    Unused access_texture, access_render_buffer, access_resolve_texture;
    // Marks a buffer as used in this frame and, with Access::Barrier, makes that use wait for what Unity did with it. May
    // record commands. False: no such buffer.
    bool(UNITY_CALL *access_buffer)(void *native, VkPipelineStageFlags stages, VkAccessFlags access, Access mode,
                                    VulkanBuffer *out);
    Unused ensure_outside, ensure_inside, access_queue, configure_swapchain, access_texture_by_id;
};

// --- Sizes and places.

static_assert(sizeof(void *) == 8, "the package is for 64-bit machines");
static_assert(sizeof(Interfaces) == 4 * 8 && offsetof(Interfaces, get_by_numbers) == 2 * 8);
static_assert(sizeof(Graphics) == 4 * 8 && offsetof(Graphics, reserve_event_ids) == 3 * 8);
static_assert(sizeof(VulkanInstance) == 120 && offsetof(VulkanInstance, device) == 24 &&
              offsetof(VulkanInstance, get_instance_proc_addr) == 40 && offsetof(VulkanInstance, queue_family) == 48);
static_assert(sizeof(VulkanMemory) == 72 && offsetof(VulkanMemory, flags) == 32);
static_assert(sizeof(VulkanBuffer) == 128 && offsetof(VulkanBuffer, buffer) == 72 && offsetof(VulkanBuffer, size) == 80 &&
              offsetof(VulkanBuffer, usage) == 88);
static_assert(sizeof(Recording) == 88 && offsetof(Recording, render_pass) == 16 && offsetof(Recording, subpass) == 32 &&
              offsetof(Recording, current_frame) == 40 && offsetof(Recording, safe_frame) == 48);
static_assert(sizeof(EventConfig) == 12 && offsetof(EventConfig, flags) == 8);
static_assert(sizeof(GraphicsVulkan) == 14 * 8 && offsetof(GraphicsVulkan, configure_event) == 2 * 8 &&
              offsetof(GraphicsVulkan, instance) == 3 * 8 && offsetof(GraphicsVulkan, recording) == 4 * 8 &&
              offsetof(GraphicsVulkan, access_buffer) == 8 * 8);

} // namespace unity

#endif
