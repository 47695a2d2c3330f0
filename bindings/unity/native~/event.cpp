// The event on Unity's render thread: what is wanted is recorded into Unity's command buffer.
#include "world.hpp"

#include <algorithm>
#include <exception>

namespace crumple_unity {
namespace {

// Unity draws from the buffer and knows that the plugin writes it in a compute shader. Naming both uses on both sides asks nothing
// of what Unity keeps in mind between its own barriers.
constexpr VkPipelineStageFlags STAGES = VK_PIPELINE_STAGE_VERTEX_INPUT_BIT | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
constexpr VkAccessFlags ACCESS = VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT | VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT;

// One event. Its vectors are kept, so that frames allocate nothing.
struct Event {
    std::vector<std::shared_ptr<Buffer>> wanted;
    std::vector<std::shared_ptr<Context>> contexts, dying;
    std::vector<Buffer *> mine;
    std::vector<CrumpleBuffer> ids;
    unity::GraphicsVulkan *vulkan = nullptr;
    uint32_t device = 0;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    uint64_t frame = 0, done = 0; // as Crumple counts: from 1 on

    bool gather(World &w, int event_id);
    bool access(World &w);
    void run(World &w, Context &context);
    bool attach(World &w, Context &context);
    bool ready(World &w, Buffer &buffer);
    void record(World &w, Context &context);
    void want_again(World &w);
    void clear();
};

void fail(World &w, Buffer &buffer, CrumpleResult result, std::string why) {
    const std::lock_guard<std::mutex> lock(w.mutex);
    if (result == CRUMPLE_ERROR_CONCURRENT_USE) { // somebody is inside who took no lock: as if he had
        buffer.wanted = true;
        return;
    }
    buffer.result = result;
    buffer.error = std::move(why);
    buffer.wanted = false;
}

// Takes note of what is there and what is wanted. Answers whether there is anything to do.
bool Event::gather(World &w, int event_id) {
    const std::lock_guard<std::mutex> lock(w.mutex);
    if (!w.vulkan || event_id != w.event_id) return false;
    vulkan = w.vulkan;
    device = w.device_number;
    wanted.reserve(w.buffers.size()); // what can fail comes first
    for (const auto &entry : w.buffers) {
        Buffer &buffer = *entry.second;
        if (!buffer.wanted || buffer.device != device) continue;
        buffer.wanted = false; // a hit that comes from here on wants it anew
        wanted.push_back(entry.second);
    }
    for (const auto &entry : w.contexts) contexts.push_back(entry.second);
    dying = w.dying;
    return !wanted.empty() || !dying.empty() ||
           std::any_of(contexts.begin(), contexts.end(), [](const auto &context) { return context->in_flight.load(); });
}

// Everything of Unity's: the buffers first, since each access ends what was told of the command buffer. No lock is held.
bool Event::access(World &w) {
    for (const auto &buffer : wanted) {
        buffer->seen = {};
        buffer->found = vulkan->access_buffer(buffer->def.native_buffer, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                                              VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT, unity::Access::Barrier,
                                              &buffer->seen);
    }
    unity::Recording recording{};
    const char *why = nullptr;
    if (!vulkan->recording(&recording, unity::QueueAccess::None) || !recording.commands)
        why = "Unity has no command buffer for the event: issue it with CommandBuffer.IssuePluginEvent in a rendered frame";
    else if (recording.subpass >= 0)
        why = "the event came inside a render pass, where nothing can be computed: issue it before the camera draws";
    if (why) {
        const std::lock_guard<std::mutex> lock(w.mutex);
        w.message = why;
        return false;
    }
    commands = recording.commands;
    frame = recording.current_frame + 1;
    // A frame that is recorded now is not done, whatever a fresh counter says.
    done = recording.current_frame == 0 ? 0 : std::min<uint64_t>(recording.safe_frame, recording.current_frame - 1) + 1;
    return true;
}

bool Event::attach(World &w, Context &context) {
    if (context.device == device) return true;
    CrumpleVulkanAttachDef def = w.library.crumple_vulkan_attach_def_default();
    def.get_instance_proc_addr = reinterpret_cast<CrumpleVulkanFunction>(w.instance.get_instance_proc_addr);
    def.instance = w.instance.instance;
    def.physical_device = w.instance.physical_device;
    def.device = w.instance.device;
    def.queue_family = w.instance.queue_family;
    const CrumpleResult result = w.library.crumple_vulkan_attach(context.handle, &def);
    if (result == CRUMPLE_OK) {
        context.device = device;
        return true;
    }
    for (Buffer *buffer : mine) fail(w, *buffer, result, w.library.crumple_last_error());
    return false;
}

// Brings a buffer's registration in line with what Unity says that it is. Answers whether it can be recorded.
bool Event::ready(World &w, Buffer &buffer) {
    const unity::VulkanBuffer &seen = buffer.seen;
    if (!buffer.found || seen.buffer == VK_NULL_HANDLE) {
        fail(w, buffer, CRUMPLE_ERROR_INVALID_ID,
             "Unity knows no Vulkan buffer by this pointer: take it from Mesh.GetVertexBuffer() after the mesh was uploaded, "
             "and unregister it first when the mesh goes");
        return false;
    }
    if (!(seen.usage & VK_BUFFER_USAGE_STORAGE_BUFFER_BIT)) {
        fail(w, buffer, CRUMPLE_ERROR_UNSUPPORTED,
             "the mesh's vertex buffer was made for usage " + std::to_string(seen.usage) +
                 ", without VK_BUFFER_USAGE_STORAGE_BUFFER_BIT (32): "
                 "set Mesh.vertexBufferTarget |= GraphicsBuffer.Target.Raw before Mesh.GetVertexBuffer()");
        return false;
    }
    const bool same = buffer.vulkan == seen.buffer && buffer.size == seen.size && buffer.usage == seen.usage;
    if (buffer.registered && same) return true;
    if (buffer.registered) w.library.crumple_buffer_unregister(buffer.context->handle, buffer.id);
    buffer.registered = false;
    CrumpleVulkanBufferDef def = w.library.crumple_vulkan_buffer_def_default();
    def.lod = buffer.def.lod;
    def.buffer = (uint64_t)seen.buffer;
    def.buffer_size = seen.size;
    def.usage = seen.usage;
    def.before_stages = def.after_stages = STAGES;
    def.before_access = def.after_access = ACCESS;
    def.size = uint64_t{buffer.def.vertex_count} * buffer.def.stride;
    def.positions = buffer.layout.position;
    def.normals = buffer.layout.normal;
    def.tangents = buffer.layout.tangent;
    const CrumpleResult result =
        w.library.crumple_buffer_register_vulkan(buffer.context->handle, buffer.def.instance, &def, &buffer.id);
    if (result != CRUMPLE_OK) {
        fail(w, buffer, result, w.library.crumple_last_error());
        return false;
    }
    buffer.registered = true;
    buffer.vulkan = seen.buffer, buffer.size = seen.size, buffer.usage = seen.usage;
    return true;
}

void Event::record(World &w, Context &context) {
    mine.erase(std::remove_if(mine.begin(), mine.end(), [&](Buffer *buffer) { return !ready(w, *buffer); }), mine.end());
    if (mine.empty()) return;
    ids.clear();
    for (Buffer *buffer : mine) ids.push_back(buffer->id);
    const CrumpleResult result = w.library.crumple_vulkan_record(context.handle, commands, frame, ids.data(),
                                                                 static_cast<uint32_t>(ids.size()), nullptr);
    if (result != CRUMPLE_OK) {
        const std::string why = w.library.crumple_last_error();
        for (Buffer *buffer : mine) fail(w, *buffer, result, why);
        return;
    }
    context.recorded = frame;
    context.in_flight = true;
    for (Buffer *buffer : mine) {
        uint32_t ranges;
        CrumpleAabb bounds;
        const bool known =
            w.library.crumple_buffer_get_changes(context.handle, buffer->id, nullptr, 0, &ranges, &bounds) == CRUMPLE_OK;
        const std::lock_guard<std::mutex> lock(w.mutex);
        ++buffer->info.recordings;
        if (known) buffer->info.bounds = bounds;
    }
}

// Inside the context's gate.
void Event::run(World &w, Context &context) {
    mine.clear();
    {
        const std::lock_guard<std::mutex> lock(w.mutex);
        for (const auto &buffer : wanted)
            if (buffer->context.get() == &context && !buffer->gone) mine.push_back(buffer.get());
    }
    if (context.device == device && context.in_flight) {
        w.library.crumple_vulkan_complete_frames(context.handle, done);
        if (context.recorded <= done) context.in_flight = false;
    }
    if (!context.gone && !mine.empty() && attach(w, context)) record(w, context);
}

// Nothing could be recorded: the next event tries again.
void Event::want_again(World &w) {
    const std::lock_guard<std::mutex> lock(w.mutex);
    for (const auto &buffer : wanted)
        if (buffer->result == CRUMPLE_OK) buffer->wanted = true;
}

void Event::clear() {
    wanted.clear();
    contexts.clear();
    dying.clear();
    mine.clear();
}

void run_event(World &w, Event &event) {
    if (!event.access(w)) return event.want_again(w);
    for (const auto &context : event.contexts) {
        if (context->gate.try_enter()) {
            const Inside inside{context->gate};
            event.run(w, *context);
            continue;
        }
        // The main thread is inside, and may be for long: the render thread goes on.
        const std::lock_guard<std::mutex> lock(w.mutex);
        for (const auto &buffer : event.wanted)
            if (buffer->context == context) buffer->wanted = true;
    }
    for (const auto &context : event.dying) {
        if (!context->gate.try_enter()) continue;
        const Inside inside{context->gate};
        event.run(w, *context);
        if (w.library.crumple_context_destroy(context->handle) == CRUMPLE_ERROR_FRAMES_IN_FLIGHT) continue;
        const std::lock_guard<std::mutex> lock(w.mutex);
        w.dying.erase(std::remove(w.dying.begin(), w.dying.end(), context), w.dying.end());
    }
}

} // namespace

void UNITY_CALL on_render_event(int event_id) {
    static Event event; // one at a time, by event_mutex
    World &w = world();
    const std::unique_lock<std::mutex> only(w.event_mutex, std::try_to_lock);
    if (!only) return; // the device is ending
    try {
        if (event.gather(w, event_id)) run_event(w, event);
    } catch (const std::exception &) {
        event.want_again(w); // memory ran out; the next event may have some
    }
    event.clear();
}

} // namespace crumple_unity
