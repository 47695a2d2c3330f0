// The plugin and the Vulkan device come and go. Unity calls all of this one call at a time, so only it changes the plugin's state
// and the device, and may look at them without World::mutex.
#include "world.hpp"

#include <exception>

namespace crumple_unity {

World &world() {
    static World only;
    return only;
}

std::string no_device(const World &w) {
    if (!w.loaded)
        return "Unity has not loaded crumple_unity as a plugin: tick \"Load on startup\" in its Plugin Inspector and restart";
    if (!w.library_error.empty()) return w.library_error;
    if (!w.vulkan)
        return "Unity has no Vulkan device: vertices are written on the device under Vulkan only, and on the CPU elsewhere";
    return {};
}

namespace {

// The device's frames end here: Unity is about to destroy it, so nothing is submitted any more. A lost device runs none.
void wait_idle(const unity::VulkanInstance &instance) {
    const auto wait =
        reinterpret_cast<PFN_vkDeviceWaitIdle>(instance.get_instance_proc_addr(instance.instance, "vkDeviceWaitIdle"));
    if (wait) wait(instance.device);
}

void end_device() {
    World &w = world();
    const std::lock_guard<std::mutex> no_event(w.event_mutex);
    std::vector<std::shared_ptr<Context>> contexts, dying;
    std::vector<std::shared_ptr<Buffer>> buffers;
    {
        const std::lock_guard<std::mutex> lock(w.mutex);
        if (!w.vulkan) return;
        for (const auto &entry : w.contexts) contexts.push_back(entry.second);
        for (const auto &entry : w.buffers) {
            Buffer &buffer = *entry.second;
            buffers.push_back(entry.second);
            buffer.wanted = false;
            if (buffer.result != CRUMPLE_OK) continue;
            buffer.result = CRUMPLE_ERROR_DEVICE_LOST;
            buffer.error = "the graphics device that the buffer belonged to is gone: register the mesh's new one";
        }
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

// Unity may tell of a device twice, and of another one without a word of the end of the first.
void start_device() {
    World &w = world();
    if (!w.library_error.empty()) return;
    unity::GraphicsVulkan *vulkan = nullptr;
    if (w.graphics->renderer() == unity::Renderer::Vulkan)
        vulkan = static_cast<unity::GraphicsVulkan *>(
            w.interfaces->get_by_numbers(unity::GRAPHICS_VULKAN.high, unity::GRAPHICS_VULKAN.low));
    unity::VulkanInstance instance{};
    if (vulkan) instance = vulkan->instance();
    if (w.vulkan && w.instance.device == instance.device) return;
    end_device();
    if (!instance.device || !instance.get_instance_proc_addr) return;
    const unity::EventConfig config{unity::RenderPass::Outside, unity::QueueAccess::None,
                                    unity::AFTER_PREVIOUS_FRAME | unity::CHANGES_STATE};
    vulkan->configure_event(w.event_id, &config);
    const std::lock_guard<std::mutex> lock(w.mutex);
    w.vulkan = vulkan;
    w.instance = instance;
    ++w.device_number;
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

} // namespace
} // namespace crumple_unity

using namespace crumple_unity;

extern "C" CRUMPLE_UNITY_API void UNITY_CALL UnityPluginLoad(unity::Interfaces *interfaces) {
    try {
        World &w = world();
        if (w.loaded) return;
        auto *graphics =
            static_cast<unity::Graphics *>(interfaces->get_by_numbers(unity::GRAPHICS.high, unity::GRAPHICS.low));
        if (!graphics) return;
        std::string error = w.library.open();
        const int event_id = graphics->reserve_event_ids(1);
        {
            const std::lock_guard<std::mutex> lock(w.mutex);
            w.library_error = std::move(error);
            w.interfaces = interfaces;
            w.graphics = graphics;
            w.event_id = event_id;
            w.loaded = true;
        }
        graphics->add_device_callback(&on_device_event);
        start_device(); // where the device was there before the plugin, no event tells of it
    } catch (const std::exception &) {
        // Memory ran out: not loaded.
    }
}

extern "C" CRUMPLE_UNITY_API void UNITY_CALL UnityPluginUnload() {
    try {
        World &w = world();
        if (!w.loaded) return;
        w.graphics->remove_device_callback(&on_device_event);
        end_device();
        const std::lock_guard<std::mutex> lock(w.mutex);
        w.loaded = false;
    } catch (const std::exception &) {
        // Memory ran out; what is still there ends with the process.
    }
}
