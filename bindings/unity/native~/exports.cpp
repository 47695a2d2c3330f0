// The C interface. Each function names itself in its errors and lets no exception out.
#include "world.hpp"

#include <algorithm>
#include <cstring>
#include <exception>

using namespace crumple_unity;

namespace {

thread_local char last_error[1024];

CrumpleResult refuse(CrumpleResult result, const char *function, const std::string &why) {
    const std::string text = std::string("crumple_unity_") + function + ": " + why;
    const size_t length = std::min(text.size(), sizeof last_error - 1);
    std::memcpy(last_error, text.data(), length);
    last_error[length] = 0;
    return result;
}

uint32_t copy(const std::string &text, char *out, uint32_t capacity) {
    if (!out || capacity == 0) return 0;
    const uint32_t length = std::min(static_cast<uint32_t>(text.size()), capacity - 1);
    std::memcpy(out, text.data(), length);
    out[length] = 0;
    return length + 1;
}

CrumpleResult out_of_memory(const char *function) {
    std::strcpy(last_error, "crumple_unity_");
    std::strcat(last_error, function);
    std::strcat(last_error, ": memory ran out");
    return CRUMPLE_ERROR_OUT_OF_MEMORY;
}

// Runs a body that may throw bad_alloc.
template <class Body> CrumpleResult guarded(const char *function, Body body) {
    try {
        return body();
    } catch (const std::exception &) {
        return out_of_memory(function);
    }
}

std::shared_ptr<Context> context_of(CrumpleContext *handle) {
    World &w = world();
    const std::lock_guard<std::mutex> lock(w.mutex);
    const auto found = w.contexts.find(handle);
    return found == w.contexts.end() ? nullptr : found->second;
}

CrumpleResult unknown_context(const char *function) {
    return refuse(CRUMPLE_ERROR_INVALID_ID, function,
                  "the context is not known: crumple_unity_add_context() makes it so, crumple_unity_destroy_context() ends it");
}

CrumpleResult unknown_buffer(const char *function, uint64_t buffer) {
    return refuse(CRUMPLE_ERROR_INVALID_ID, function,
                  "there is no buffer " + std::to_string(buffer) + "; it was unregistered, or its context destroyed");
}

} // namespace

extern "C" {

uint32_t crumple_unity_version(void) { return CRUMPLE_VERSION; }

const char *crumple_unity_last_error(void) { return last_error; }

CrumpleUnityState crumple_unity_state(char *text, uint32_t capacity) {
    try {
        World &w = world();
        std::string why;
        const std::lock_guard<std::mutex> lock(w.mutex);
        const CrumpleUnityState state = state_of(w, why);
        copy(why, text, capacity);
        return state;
    } catch (const std::exception &) {
        return CRUMPLE_UNITY_NO_DEVICE;
    }
}

uint32_t crumple_unity_device(void) {
    World &w = world();
    const std::lock_guard<std::mutex> lock(w.mutex);
    return w.device_number;
}

CrumpleUnityEvent crumple_unity_event(int32_t *out_id) {
    World &w = world();
    const std::lock_guard<std::mutex> lock(w.mutex);
    if (!w.loaded || !w.graphics) return nullptr;
    if (out_id) *out_id = w.event_id;
    return &on_render_event;
}

uint32_t crumple_unity_pending(void) {
    World &w = world();
    const std::lock_guard<std::mutex> lock(w.mutex);
    if (!w.device_here) return 0;
    size_t pending = w.dying.size();
    for (const auto &entry : w.contexts) pending += entry.second->in_flight ? 1 : 0;
    for (const auto &entry : w.buffers) pending += entry.second->info.wanted ? 1 : 0;
    return static_cast<uint32_t>(pending);
}

uint32_t crumple_unity_take_message(char *text, uint32_t capacity) {
    World &w = world();
    const std::lock_guard<std::mutex> lock(w.mutex);
    if (w.messages.empty() || !text || capacity == 0) return 0;
    const uint32_t length = copy(w.messages.front(), text, capacity);
    w.messages.pop_front();
    return length;
}

CrumpleResult crumple_unity_add_context(CrumpleContext *handle) {
    return guarded("add_context", [=] {
        if (!handle) return refuse(CRUMPLE_ERROR_NULL_POINTER, "add_context", "context is null");
        auto context = std::make_shared<Context>();
        context->handle = handle;
        World &w = world();
        std::string why;
        const std::lock_guard<std::mutex> lock(w.mutex);
        const CrumpleUnityState state = state_of(w, why);
        if (state == CRUMPLE_UNITY_NOT_LOADED || state == CRUMPLE_UNITY_NO_LIBRARY)
            return refuse(CRUMPLE_ERROR_UNSUPPORTED, "add_context", why);
        if (!w.contexts.emplace(handle, std::move(context)).second)
            return refuse(CRUMPLE_ERROR_INVALID_ARGUMENT, "add_context", "the context is known already");
        return CRUMPLE_OK;
    });
}

CrumpleResult crumple_unity_destroy_context(CrumpleContext *handle) {
    return guarded("destroy_context", [=] {
        World &w = world();
        std::shared_ptr<Context> context;
        {
            const std::lock_guard<std::mutex> lock(w.mutex);
            const auto found = w.contexts.find(handle);
            if (found == w.contexts.end()) return unknown_context("destroy_context");
            context = found->second;
            w.contexts.erase(found);
            for (auto buffer = w.buffers.begin(); buffer != w.buffers.end();) {
                buffer->second->gone = buffer->second->gone || buffer->second->context == context;
                buffer = buffer->second->gone ? w.buffers.erase(buffer) : std::next(buffer);
            }
        }
        context->gate.enter();
        const Inside inside{context->gate}; // also where this thread held it: nobody can give it back any more
        context->gone = true;
        if (w.library.crumple_context_destroy(handle) == CRUMPLE_ERROR_FRAMES_IN_FLIGHT) {
            const std::lock_guard<std::mutex> lock(w.mutex);
            w.dying.push_back(context);
        }
        return CRUMPLE_OK;
    });
}

CrumpleResult crumple_unity_lock(CrumpleContext *handle) {
    return guarded("lock", [=] {
        const std::shared_ptr<Context> context = context_of(handle);
        if (!context) return unknown_context("lock");
        if (!context->gate.enter()) return refuse(CRUMPLE_ERROR_CONCURRENT_USE, "lock", "this thread holds the lock already");
        if (!context->gone) return CRUMPLE_OK;
        context->gate.leave();
        return unknown_context("lock");
    });
}

CrumpleResult crumple_unity_unlock(CrumpleContext *handle) {
    return guarded("unlock", [=] {
        const std::shared_ptr<Context> context = context_of(handle);
        if (!context) return unknown_context("unlock");
        if (!context->gate.leave()) return refuse(CRUMPLE_ERROR_CONCURRENT_USE, "unlock", "this thread does not hold the lock");
        return CRUMPLE_OK;
    });
}

CrumpleResult crumple_unity_register_buffer(CrumpleContext *handle, const CrumpleUnityBufferDef *def, uint64_t *out_buffer) {
    return guarded("register_buffer", [=] {
        const char *const function = "register_buffer";
        if (!def || !out_buffer) return refuse(CRUMPLE_ERROR_NULL_POINTER, function, def ? "out_buffer is null" : "def is null");
        if (def->struct_size != sizeof *def)
            return refuse(CRUMPLE_ERROR_STRUCT_SIZE, function,
                          "def.struct_size is " + std::to_string(def->struct_size) + ", here it is " + std::to_string(sizeof *def));
        if (!def->native_buffer)
            return refuse(CRUMPLE_ERROR_NULL_POINTER, function, "def.native_buffer is null: the mesh has no vertex buffer on the device");
        auto buffer = std::make_shared<Buffer>();
        const Refused refused = layout_of(*def, buffer->layout);
        if (refused.result != CRUMPLE_OK) return refuse(refused.result, function, refused.why);
        buffer->def = *def;
        buffer->info.struct_size = sizeof buffer->info;
        buffer->info.wanted = 1;
        World &w = world();
        std::string why;
        const std::lock_guard<std::mutex> lock(w.mutex);
        const auto context = w.contexts.find(handle);
        if (context == w.contexts.end()) return unknown_context(function);
        if (state_of(w, why) != CRUMPLE_UNITY_READY) return refuse(CRUMPLE_ERROR_UNSUPPORTED, function, why);
        buffer->context = context->second;
        buffer->device = w.device_number;
        w.buffers.emplace(w.last_buffer + 1, std::move(buffer));
        *out_buffer = ++w.last_buffer;
        return CRUMPLE_OK;
    });
}

CrumpleResult crumple_unity_unregister_buffer(uint64_t number) {
    return guarded("unregister_buffer", [=] {
        World &w = world();
        std::shared_ptr<Buffer> buffer;
        {
            const std::lock_guard<std::mutex> lock(w.mutex);
            const auto found = w.buffers.find(number);
            if (found == w.buffers.end()) return unknown_buffer("unregister_buffer", number);
            buffer = found->second;
            buffer->gone = true; // an event that is on its way leaves it alone
            w.buffers.erase(found);
        }
        Context &context = *buffer->context;
        const Inside inside{context.gate, context.gate.enter()};
        // Where the instance went first, its buffers went with it; that is no error.
        if (buffer->registered && !context.gone) w.library.crumple_buffer_unregister(context.handle, buffer->id);
        buffer->registered = false;
        return CRUMPLE_OK;
    });
}

CrumpleResult crumple_unity_want(uint64_t number) {
    return guarded("want", [=] {
        World &w = world();
        const std::lock_guard<std::mutex> lock(w.mutex);
        const auto found = w.buffers.find(number);
        if (found == w.buffers.end()) return unknown_buffer("want", number);
        CrumpleUnityBufferInfo &info = found->second->info;
        if (info.state == CRUMPLE_UNITY_BUFFER_FAILED || info.state == CRUMPLE_UNITY_BUFFER_LOST)
            return refuse(static_cast<CrumpleResult>(info.result), "want", found->second->error);
        info.wanted = 1;
        return CRUMPLE_OK;
    });
}

CrumpleResult crumple_unity_buffer_info(uint64_t number, CrumpleUnityBufferInfo *out_info) {
    return guarded("buffer_info", [=] {
        if (!out_info) return refuse(CRUMPLE_ERROR_NULL_POINTER, "buffer_info", "out_info is null");
        if (out_info->struct_size != sizeof *out_info)
            return refuse(CRUMPLE_ERROR_STRUCT_SIZE, "buffer_info",
                          "out_info.struct_size is " + std::to_string(out_info->struct_size) + ", here it is " + std::to_string(sizeof *out_info));
        World &w = world();
        const std::lock_guard<std::mutex> lock(w.mutex);
        const auto found = w.buffers.find(number);
        if (found == w.buffers.end()) return unknown_buffer("buffer_info", number);
        *out_info = found->second->info;
        return CRUMPLE_OK;
    });
}

CrumpleResult crumple_unity_buffer_error(uint64_t number, char *text, uint32_t capacity) {
    return guarded("buffer_error", [=] {
        if (!text || capacity == 0) return refuse(CRUMPLE_ERROR_NULL_POINTER, "buffer_error", "text is null");
        World &w = world();
        const std::lock_guard<std::mutex> lock(w.mutex);
        const auto found = w.buffers.find(number);
        if (found == w.buffers.end()) return unknown_buffer("buffer_error", number);
        copy(found->second->error, text, capacity);
        return CRUMPLE_OK;
    });
}

} // extern "C"
