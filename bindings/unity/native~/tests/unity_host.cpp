#include "unity_host.hpp"

#include <dlfcn.h>

#include <algorithm>

// --- The plugin's file.

void Plugin::open(const char *path) {
    file_ = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!file_) fprintf(stderr, "%s\n", dlerror());
    FACT(file_);
#define PLUGIN_FIND(name)                                                                                                        \
    name = reinterpret_cast<decltype(name)>(dlsym(file_, "crumple_unity_" #name));                                               \
    FACT(name);
    PLUGIN_FUNCTIONS(PLUGIN_FIND)
#undef PLUGIN_FIND
    load = reinterpret_cast<decltype(load)>(dlsym(file_, "UnityPluginLoad"));
    unload = reinterpret_cast<decltype(unload)>(dlsym(file_, "UnityPluginUnload"));
    FACT(load && unload);
}

void Plugin::close() {
    FACT(dlclose(file_) == 0);
    *this = {};
}

CrumpleUnityState Plugin::state_is(const char *part) const {
    char text[512] = "untouched";
    const CrumpleUnityState found = state(text, sizeof text);
    if (!strstr(text, part)) fprintf(stderr, "state %d: %s\n", (int)found, text);
    FACT(strstr(text, part) && (found == CRUMPLE_UNITY_READY) == (text[0] == 0));
    return found;
}

std::string Plugin::message() const {
    char text[512];
    const uint32_t length = take_message(text, sizeof text);
    FACT(length == 0 || length == strlen(text) + 1);
    return length == 0 ? std::string() : text;
}

CrumpleUnityBufferInfo Plugin::info(uint64_t buffer) const {
    CrumpleUnityBufferInfo found{};
    found.struct_size = sizeof found;
    OK(buffer_info(buffer, &found));
    return found;
}

std::string Plugin::error(uint64_t buffer) const {
    char text[1024];
    OK(buffer_error(buffer, text, sizeof text));
    return text;
}

// --- The tables. Unity's functions take no "this".

static UnityHost *playing;

static void *UNITY_CALL get_interface(unsigned long long high, unsigned long long low);

static unity::Renderer UNITY_CALL renderer() { return playing->renderer; }

static void UNITY_CALL add_callback(unity::OnDeviceEvent callback) {
    FACT(!playing->callback);
    playing->callback = callback;
    ++playing->callbacks;
}

static void UNITY_CALL remove_callback(unity::OnDeviceEvent callback) {
    FACT(playing->callback == callback);
    playing->callback = nullptr;
    --playing->callbacks;
}

static int UNITY_CALL reserve(int count) {
    const int first = 1000 + playing->reserved;
    playing->reserved += count;
    return first;
}

static void UNITY_CALL configure(int event_id, const unity::EventConfig *config) {
    FACT(event_id >= 1000 && event_id < 1000 + playing->reserved);
    FACT(config->render_pass == unity::RenderPass::Outside && config->queue == unity::QueueAccess::None);
    FACT(config->flags & unity::CHANGES_STATE); // compute bindings change
    playing->configured.insert(event_id);
}

// A loader whose device can be lost.
static PFN_vkGetDeviceProcAddr real_get_device;
static PFN_vkAllocateMemory real_allocate;

static VKAPI_ATTR VkResult VKAPI_CALL allocate(VkDevice device, const VkMemoryAllocateInfo *info,
                                               const VkAllocationCallbacks *callbacks, VkDeviceMemory *memory) {
    const bool lost = playing->lost_in && strcmp(playing->lost_in, "vkAllocateMemory") == 0;
    return lost ? VK_ERROR_DEVICE_LOST : real_allocate(device, info, callbacks, memory);
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL get_device(VkDevice device, const char *name) {
    const PFN_vkVoidFunction found = real_get_device(device, name);
    if (strcmp(name, "vkAllocateMemory") != 0) return found;
    real_allocate = (PFN_vkAllocateMemory)found;
    return (PFN_vkVoidFunction)allocate;
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL get_instance(VkInstance instance, const char *name) {
    const PFN_vkVoidFunction found = vkGetInstanceProcAddr(instance, name);
    if (strcmp(name, "vkGetDeviceProcAddr") != 0) return found;
    real_get_device = (PFN_vkGetDeviceProcAddr)found;
    return (PFN_vkVoidFunction)get_device;
}

static unity::VulkanInstance UNITY_CALL instance() {
    unity::VulkanInstance told{};
    told.instance = playing->host.instance;
    told.physical_device = playing->host.physical_device;
    told.device = playing->host.device;
    told.graphics_queue = playing->host.queue;
    told.get_instance_proc_addr = get_instance;
    told.queue_family = playing->host.queue_family;
    return told;
}

static bool UNITY_CALL recording(unity::Recording *out, unity::QueueAccess queue) { return playing->recording(out, queue); }

static bool UNITY_CALL access_buffer(void *native, VkPipelineStageFlags stages, VkAccessFlags access, unity::Access mode,
                                     unity::VulkanBuffer *out) {
    return playing->access_buffer(native, stages, access, mode, out);
}

static void UNITY_CALL unexpected() {
    fprintf(stderr, "the plugin called a function that it has no use for\n");
    exit(1);
}

static unity::Interfaces the_interfaces{unexpected, unexpected, get_interface, unexpected};
static unity::Graphics the_graphics{renderer, add_callback, remove_callback, reserve};
static unity::GraphicsVulkan the_vulkan{unexpected, unexpected, configure,     instance,   recording,  unexpected, unexpected,
                                        unexpected, access_buffer, unexpected, unexpected, unexpected, unexpected, unexpected};

static void *UNITY_CALL get_interface(unsigned long long high, unsigned long long low) {
    if (high == unity::GRAPHICS.high && low == unity::GRAPHICS.low) return playing->gives_graphics ? &the_graphics : nullptr;
    FACT(high == unity::GRAPHICS_VULKAN.high && low == unity::GRAPHICS_VULKAN.low);
    return playing->gives_vulkan ? &the_vulkan : nullptr;
}

UnityHost::UnityHost() { playing = this; }

unity::Interfaces *UnityHost::interfaces() { return &the_interfaces; }

void UnityHost::tell(unity::DeviceEvent event) const {
    if (callback) callback(event);
}

// --- Buffers.

NativeBuffer *UnityHost::make_buffer(const void *bytes, size_t size, VkBufferUsageFlags usage) {
    NativeBuffer *made = new NativeBuffer;
    buffers_.insert(made);
    renew(made, bytes, size, usage);
    return made;
}

void UnityHost::renew(NativeBuffer *native, const void *bytes, size_t size, VkBufferUsageFlags usage) {
    if (native->vk.buffer) host_destroy_buffer(&host, &native->vk);
    const VkBufferUsageFlags copies = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    native->vk = host_buffer(&host, size, usage | copies | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, false);
    HostBuffer staging = host_buffer(&host, size, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, true);
    memcpy(staging.data, bytes, size);
    VkCommandBuffer commands = host_begin(&host);
    const VkBufferCopy all = {0, 0, size};
    vkCmdCopyBuffer(commands, staging.buffer, native->vk.buffer, 1, &all);
    host_run(&host, commands);
    host_destroy_buffer(&host, &staging);
    native->stages = VK_PIPELINE_STAGE_TRANSFER_BIT;
    native->access = VK_ACCESS_TRANSFER_WRITE_BIT;
}

void UnityHost::destroy_buffer(NativeBuffer *native) {
    FACT(buffers_.erase(native) == 1);
    host_destroy_buffer(&host, &native->vk);
    delete native;
}

bool UnityHost::knows(const void *native) const {
    return std::any_of(buffers_.begin(), buffers_.end(), [native](const NativeBuffer *known) { return known == native; });
}

static void use(VkCommandBuffer commands, NativeBuffer *native, VkPipelineStageFlags stages, VkAccessFlags access) {
    const VkBufferMemoryBarrier barrier = {VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER,
                                           nullptr,
                                           native->access,
                                           access,
                                           VK_QUEUE_FAMILY_IGNORED,
                                           VK_QUEUE_FAMILY_IGNORED,
                                           native->vk.buffer,
                                           0,
                                           VK_WHOLE_SIZE};
    vkCmdPipelineBarrier(commands, native->stages, stages, 0, 0, nullptr, 1, &barrier, 0, nullptr);
    native->stages = stages;
    native->access = access;
}

// A command buffer that was told of before is over: recording into it would be an error that the validation layer names.
bool UnityHost::access_buffer(void *pointer, VkPipelineStageFlags stages, VkAccessFlags access, unity::Access mode,
                              unity::VulkanBuffer *out) {
    FACT(in_event_ && mode == unity::Access::Barrier);
    if (!knows(pointer)) return false;
    NativeBuffer *native = static_cast<NativeBuffer *>(pointer);
    ++native->accesses;
    if (gives_commands) {
        VK(vkEndCommandBuffer(now_.commands.back()));
        now_.commands.push_back(begin_commands());
        use(now_.commands.back(), native, stages, access);
    }
    *out = {};
    out->memory.memory = native->vk.memory;
    out->buffer = native->vk.buffer;
    out->size = native->vk.size;
    out->usage = native->vk.usage;
    return true;
}

bool UnityHost::recording(unity::Recording *out, unity::QueueAccess queue) {
    FACT(in_event_ && queue == unity::QueueAccess::None);
    if (!gives_commands) return false;
    *out = {};
    out->commands = now_.commands.back();
    out->level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    out->subpass = inside_render_pass ? 0 : -1;
    out->current_frame = frame;
    out->safe_frame = safe;
    return true;
}

// --- Frames.

VkCommandBuffer UnityHost::begin_commands() {
    const VkCommandBufferAllocateInfo info = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, host.pool,
                                              VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
    const VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, nullptr,
                                            VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT, nullptr};
    VkCommandBuffer commands;
    VK(vkAllocateCommandBuffers(host.device, &info, &commands));
    VK(vkBeginCommandBuffer(commands, &begin));
    return commands;
}

void UnityHost::retire(bool all) {
    while (!in_flight_.empty()) {
        Frame &oldest = in_flight_.front();
        const bool must = all || in_flight_.size() >= FRAMES_IN_FLIGHT;
        if (must) VK(vkWaitForFences(host.device, 1, &oldest.done, VK_TRUE, UINT64_MAX));
        else if (vkGetFenceStatus(host.device, oldest.done) != VK_SUCCESS) return;
        safe = oldest.number;
        vkFreeCommandBuffers(host.device, host.pool, static_cast<uint32_t>(oldest.commands.size()), oldest.commands.data());
        vkDestroyFence(host.device, oldest.done, nullptr);
        in_flight_.pop_front();
    }
}

void UnityHost::begin_frame() {
    retire(false);
    ++frame;
    const VkFenceCreateInfo fence = {VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr, 0};
    now_ = {frame, {begin_commands()}, VK_NULL_HANDLE};
    VK(vkCreateFence(host.device, &fence, nullptr, &now_.done));
}

void UnityHost::event(CrumpleUnityEvent run, int id) {
    in_event_ = true;
    run(id);
    in_event_ = false;
}

void UnityHost::read(NativeBuffer *native, const HostBuffer &into) {
    const VkCommandBuffer commands = now_.commands.back();
    const VkBufferCopy all = {0, 0, native->vk.size};
    const VkMemoryBarrier to_cpu = {VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_TRANSFER_WRITE_BIT, VK_ACCESS_HOST_READ_BIT};
    use(commands, native, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT);
    vkCmdCopyBuffer(commands, native->vk.buffer, into.buffer, 1, &all);
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &to_cpu, 0, nullptr, 0, nullptr);
}

void UnityHost::end_frame() {
    VK(vkEndCommandBuffer(now_.commands.back()));
    VkSubmitInfo submit = {};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.commandBufferCount = static_cast<uint32_t>(now_.commands.size());
    submit.pCommandBuffers = now_.commands.data();
    VK(vkQueueSubmit(host.queue, 1, &submit, now_.done));
    in_flight_.push_back(now_);
}

void UnityHost::wait_idle() { retire(true); }

void UnityHost::drop_frames() {
    VK(vkDeviceWaitIdle(host.device));
    retire(true);
    frame = safe = 0;
}
