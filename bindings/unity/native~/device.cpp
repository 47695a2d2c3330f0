// The plugin and the Vulkan device come and go.
#include "world.hpp"

#include <algorithm>
#include <exception>

namespace crumple_unity {

void start_device() {
    World &w = world();
    unity::Graphics *graphics;
    int event_id;
    {
        const std::lock_guard<std::mutex> lock(w.mutex);
        if (!w.loaded || !w.graphics || !w.library_error.empty()) return;
        graphics = w.graphics, event_id = w.event_id;
    }
    const unity::Renderer renderer = graphics->renderer();
    auto *vulkan = renderer != unity::Renderer::Vulkan
                       ? nullptr
                       : static_cast<unity::GraphicsVulkan *>(
                             w.interfaces->get_by_numbers(unity::GRAPHICS_VULKAN.high, unity::GRAPHICS_VULKAN.low));
    unity::VulkanInstance instance{};
    if (vulkan) instance = vulkan->instance();
    const bool usable = vulkan && instance.device && instance.get_instance_proc_addr;
    bool told_twice, another;
    {
        const std::lock_guard<std::mutex> lock(w.mutex);
        w.renderer = renderer;
        if (renderer == unity::Renderer::Vulkan && !usable) say(w, "the renderer is Vulkan, but Unity gives no Vulkan device to plugins");
        told_twice = w.device_here && usable && w.instance.device == instance.device;
        another = w.device_here && !told_twice;
    }
    if (told_twice) return;
    if (another) end_device();
    if (!usable) return;
    const unity::EventConfig config{unity::RenderPass::Outside, unity::QueueAccess::None,
                                    unity::AFTER_PREVIOUS_FRAME | unity::CHANGES_STATE};
    vulkan->configure_event(event_id, &config);
    const std::lock_guard<std::mutex> lock(w.mutex);
    w.vulkan = vulkan;
    w.instance = instance;
    w.device_here = true;
    ++w.device_number;
}

namespace {

// The device's frames end here: Unity is about to destroy it, so nothing is submitted any more. A lost device runs none.
void wait_idle(const unity::VulkanInstance &instance) {
    const auto wait =
        reinterpret_cast<PFN_vkDeviceWaitIdle>(instance.get_instance_proc_addr(instance.instance, "vkDeviceWaitIdle"));
    if (wait) wait(instance.device);
}

} // namespace

void end_device() {
    World &w = world();
    const std::lock_guard<std::mutex> no_event(w.event_mutex);
    std::vector<std::shared_ptr<Context>> contexts, dying;
    std::vector<std::shared_ptr<Buffer>> buffers;
    {
        const std::lock_guard<std::mutex> lock(w.mutex);
        if (!w.device_here) return;
        for (const auto &entry : w.contexts) contexts.push_back(entry.second);
        for (const auto &entry : w.buffers) {
            buffers.push_back(entry.second);
            CrumpleUnityBufferInfo &info = entry.second->info;
            info.wanted = 0;
            if (info.state == CRUMPLE_UNITY_BUFFER_FAILED) continue;
            info.state = CRUMPLE_UNITY_BUFFER_LOST;
            info.result = CRUMPLE_ERROR_DEVICE_LOST;
            entry.second->error = "the graphics device that the buffer belonged to is gone: register the mesh's new one";
        }
        w.device_here = false;
        w.vulkan = nullptr;
    }
    wait_idle(w.instance);
    for (const auto &shared : contexts) {
        Context &context = *shared;
        const Inside inside{context.gate, context.gate.enter()}; // or this thread holds it, and waits for nobody
        if (context.device != 0 && !context.gone) {
            w.library.crumple_vulkan_complete_frames(context.handle, UINT64_MAX);
            w.library.crumple_vulkan_detach(context.handle);
        }
        context.device = 0;
        context.in_flight = false;
        for (const auto &buffer : buffers)
            if (buffer->context == shared) buffer->registered = false;
    }
    // Last, since a context may have come to these while the loop waited for it.
    {
        const std::lock_guard<std::mutex> lock(w.mutex);
        dying.swap(w.dying);
    }
    for (const auto &context : dying) {
        w.library.crumple_vulkan_complete_frames(context->handle, UINT64_MAX);
        w.library.crumple_context_destroy(context->handle);
    }
}

void UNITY_CALL on_device_event(unity::DeviceEvent event) {
    try {
        switch (event) {
        case unity::DeviceEvent::Initialize:
        case unity::DeviceEvent::AfterReset: return start_device();
        case unity::DeviceEvent::Shutdown:
        case unity::DeviceEvent::BeforeReset: return end_device();
        }
    } catch (const std::exception &) {
        // Memory ran out before anything had changed.
    }
}

} // namespace crumple_unity

using namespace crumple_unity;

extern "C" CRUMPLE_UNITY_API void UNITY_CALL UnityPluginLoad(unity::Interfaces *interfaces) {
    try {
        World &w = world();
        {
            const std::lock_guard<std::mutex> lock(w.mutex);
            if (w.loaded) return say(w, "UnityPluginLoad was called twice; the first call holds. Is crumple_unity in the project twice?");
            if (!interfaces) return say(w, "UnityPluginLoad was called without interfaces");
        }
        std::string error = w.library.open();
        auto *graphics =
            static_cast<unity::Graphics *>(interfaces->get_by_numbers(unity::GRAPHICS.high, unity::GRAPHICS.low));
        const int event_id = graphics ? graphics->reserve_event_ids(1) : -1;
        {
            const std::lock_guard<std::mutex> lock(w.mutex);
            w.library_error = std::move(error);
            w.interfaces = interfaces;
            w.graphics = graphics;
            w.event_id = event_id;
            w.loaded = true;
        }
        if (!graphics) return;
        graphics->add_device_callback(&on_device_event);
        start_device(); // where the device was there before the plugin, no event tells of it
    } catch (const std::exception &) {
        // Memory ran out: not loaded.
    }
}

extern "C" CRUMPLE_UNITY_API void UNITY_CALL UnityPluginUnload() {
    try {
        World &w = world();
        unity::Graphics *graphics;
        {
            const std::lock_guard<std::mutex> lock(w.mutex);
            if (!w.loaded) return;
            graphics = w.graphics;
        }
        if (graphics) graphics->remove_device_callback(&on_device_event);
        end_device();
        const std::lock_guard<std::mutex> lock(w.mutex);
        w.loaded = false;
        w.graphics = nullptr;
        w.interfaces = nullptr;
        w.renderer = unity::Renderer::Null;
        w.event_id = -1;
    } catch (const std::exception &) {
        // Memory ran out; what is still there ends with the process.
    }
}
