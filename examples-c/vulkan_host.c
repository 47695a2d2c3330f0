#include "vulkan_host.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const LAYER = "VK_LAYER_KHRONOS_validation";
static unsigned messages;

void host_check(VkResult result, const char *call, const char *file, int line) {
    if (result == VK_SUCCESS) return;
    fprintf(stderr, "%s:%d: %s gives VkResult %d\n", file, line, call, (int)result);
    exit(1);
}

static bool set(const char *variable) {
    const char *value = getenv(variable);
    return value && strcmp(value, "1") == 0;
}

static void left_out(const char *why) {
    if (set("CRUMPLE_REQUIRE_GPU")) {
        fprintf(stderr, "%s, and CRUMPLE_REQUIRE_GPU=1\n", why);
        exit(1);
    }
    printf("left out: %s\n", why);
    exit(77);
}

static VKAPI_ATTR VkBool32 VKAPI_CALL said(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                           VkDebugUtilsMessageTypeFlagsEXT type,
                                           const VkDebugUtilsMessengerCallbackDataEXT *data, void *user) {
    (void)severity, (void)type, (void)user;
    ++messages;
    fprintf(stderr, "validation: %s\n", data->pMessage);
    return VK_FALSE;
}

static void open_instance(Host *host) {
    const bool validated = set("CRUMPLE_VALIDATION");
    const char *extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    const VkValidationFeatureEnableEXT enabled = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    const VkValidationFeaturesEXT features = {.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                              .enabledValidationFeatureCount = 1,
                                              .pEnabledValidationFeatures = &enabled};
    const VkApplicationInfo application = {
        .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .pApplicationName = "Crumple example", .apiVersion = VK_API_VERSION_1_1};
    VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application};
    if (validated) {
        info.pNext = &features;
        info.enabledLayerCount = 1;
        info.ppEnabledLayerNames = &LAYER;
        info.enabledExtensionCount = 2;
        info.ppEnabledExtensionNames = extensions;
    }
    const VkResult result = vkCreateInstance(&info, NULL, &host->instance);
    if (result == VK_ERROR_INCOMPATIBLE_DRIVER) left_out("there is no Vulkan driver");
    if (result == VK_ERROR_LAYER_NOT_PRESENT) {
        fprintf(stderr, "CRUMPLE_VALIDATION=1, but there is no %s\n", LAYER);
        exit(1);
    }
    VK(result);
    if (!validated) return;
    const VkDebugUtilsMessengerCreateInfoEXT listener = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
        .pfnUserCallback = said};
    const PFN_vkCreateDebugUtilsMessengerEXT create =
        (PFN_vkCreateDebugUtilsMessengerEXT)vkGetInstanceProcAddr(host->instance, "vkCreateDebugUtilsMessengerEXT");
    VK(create(host->instance, &listener, NULL, &host->messenger));
}

void host_open(Host *host) {
    memset(host, 0, sizeof *host);
    open_instance(host);
    uint32_t count = 1;
    const VkResult result = vkEnumeratePhysicalDevices(host->instance, &count, &host->physical_device);
    if (count == 0) left_out("Vulkan finds no device");
    if (result != VK_INCOMPLETE) VK(result); // VK_INCOMPLETE: there are more devices; the first is enough
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(host->physical_device, &properties);
    memcpy(host->name, properties.deviceName, sizeof host->name);
    host->software = properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
    host_open_device(host);
}

void host_open_device(Host *host) {
    const VkQueueFlags wanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    VkQueueFamilyProperties families[16];
    uint32_t count = 16, family = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(host->physical_device, &count, families);
    while (family < count && (families[family].queueFlags & wanted) != wanted) ++family;
    if (family == count) left_out("no queue of the first Vulkan device draws and computes");
    host->queue_family = family;
    const float priority = 1;
    const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                           .queueFamilyIndex = family,
                                           .queueCount = 1,
                                           .pQueuePriorities = &priority};
    const VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                     .queueCreateInfoCount = 1,
                                     .pQueueCreateInfos = &queue,
                                     .enabledExtensionCount = host->extension_count,
                                     .ppEnabledExtensionNames = host->extensions};
    VK(vkCreateDevice(host->physical_device, &info, NULL, &host->device));
    vkGetDeviceQueue(host->device, family, 0, &host->queue);
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                          .queueFamilyIndex = family};
    VK(vkCreateCommandPool(host->device, &pool, NULL, &host->pool));
}

void host_close_device(Host *host) {
    vkDestroyCommandPool(host->device, host->pool, NULL);
    vkDestroyDevice(host->device, NULL);
    host->device = NULL;
}

void host_close(Host *host) {
    host_close_device(host);
    if (host->messenger) {
        const PFN_vkDestroyDebugUtilsMessengerEXT destroy =
            (PFN_vkDestroyDebugUtilsMessengerEXT)vkGetInstanceProcAddr(host->instance, "vkDestroyDebugUtilsMessengerEXT");
        destroy(host->instance, host->messenger, NULL);
    }
    vkDestroyInstance(host->instance, NULL);
    if (messages == 0) return;
    fprintf(stderr, "the validation layer said %u things\n", messages);
    exit(1);
}

uint32_t host_memory_type(const Host *host, uint32_t allowed, VkMemoryPropertyFlags flags) {
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(host->physical_device, &memory);
    for (uint32_t type = 0; type < memory.memoryTypeCount; ++type)
        if ((allowed >> type & 1) && (memory.memoryTypes[type].propertyFlags & flags) == flags) return type;
    fprintf(stderr, "%s has no memory with flags %u among types %#x\n", host->name, (unsigned)flags, (unsigned)allowed);
    exit(1);
}

HostBuffer host_buffer(const Host *host, VkDeviceSize size, VkBufferUsageFlags usage, bool seen_by_cpu) {
    HostBuffer made = {.size = size, .usage = usage};
    const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size, .usage = usage};
    VK(vkCreateBuffer(host->device, &info, NULL, &made.buffer));
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(host->device, made.buffer, &needs);
    const VkMemoryPropertyFlags flags = seen_by_cpu ? VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT
                                                    : VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    const VkMemoryAllocateInfo memory = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                         .allocationSize = needs.size,
                                         .memoryTypeIndex = host_memory_type(host, needs.memoryTypeBits, flags)};
    VK(vkAllocateMemory(host->device, &memory, NULL, &made.memory));
    VK(vkBindBufferMemory(host->device, made.buffer, made.memory, 0));
    if (seen_by_cpu) VK(vkMapMemory(host->device, made.memory, 0, VK_WHOLE_SIZE, 0, &made.data));
    return made;
}

void host_destroy_buffer(const Host *host, HostBuffer *buffer) {
    vkDestroyBuffer(host->device, buffer->buffer, NULL);
    vkFreeMemory(host->device, buffer->memory, NULL);
    memset(buffer, 0, sizeof *buffer);
}

VkCommandBuffer host_begin(const Host *host) {
    const VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                              .commandPool = host->pool,
                                              .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                              .commandBufferCount = 1};
    const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                            .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    VkCommandBuffer commands;
    VK(vkAllocateCommandBuffers(host->device, &info, &commands));
    VK(vkBeginCommandBuffer(commands, &begin));
    return commands;
}

void host_run(const Host *host, VkCommandBuffer commands) {
    const VkSubmitInfo submit = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands};
    VK(vkEndCommandBuffer(commands));
    VK(vkQueueSubmit(host->queue, 1, &submit, VK_NULL_HANDLE));
    VK(vkQueueWaitIdle(host->queue));
    vkFreeCommandBuffers(host->device, host->pool, 1, &commands);
}

void host_barrier(VkCommandBuffer commands) {
    const VkMemoryBarrier everything = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                        .srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
                                        .dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT};
    const VkPipelineStageFlags all = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    vkCmdPipelineBarrier(commands, all, all | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &everything, 0, NULL, 0, NULL);
}
