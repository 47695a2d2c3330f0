// The C interface. Each function names itself in its errors and lets no exception out.
#include "world.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <exception>

using namespace crumple_unity;

namespace {

thread_local char last_error[1024];

CrumpleResult refuse(CrumpleResult result, const char *function, const char *why) {
    std::snprintf(last_error, sizeof last_error, "crumple_unity_%s: %s", function, why);
    return result;
}

CrumpleResult refuse(CrumpleResult result, const char *function, const std::string &why) {
    return refuse(result, function, why.c_str());
}

uint32_t copy(const std::string &text, char *out, uint32_t capacity) {
    const uint32_t length = std::min(static_cast<uint32_t>(text.size()), capacity - 1);
    std::memcpy(out, text.data(), length);
    out[length] = 0;
    return length + 1;
}

// Runs a body that may throw bad_alloc.
template <class Body> CrumpleResult guarded(const char *function, Body body) {
    try {
        return body(world());
    } catch (const std::exception &) {
        return refuse(CRUMPLE_ERROR_OUT_OF_MEMORY, function, "memory ran out");
    }
}

std::shared_ptr<Context> context_of(World &w, CrumpleContext *handle) {
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

// Runs a body with a buffer that can be recorded, with World::mutex held.
template <class Body> CrumpleResult with_buffer(const char *function, uint64_t number, Body body) {
    return guarded(function, [=](World &w) {
        const std::lock_guard<std::mutex> lock(w.mutex);
        const auto found = w.buffers.find(number);
        if (found == w.buffers.end()) return unknown_buffer(function, number);
        Buffer &buffer = *found->second;
        if (buffer.result != CRUMPLE_OK) return refuse(buffer.result, function, buffer.error);
        body(buffer);
        return CRUMPLE_OK;
    });
}

} // namespace

extern "C" {

uint32_t crumple_unity_version(void) { return CRUMPLE_VERSION; }

const char *crumple_unity_last_error(void) { return last_error; }

uint32_t crumple_unity_device(char *why, uint32_t capacity) {
    World &w = world();
    const std::lock_guard<std::mutex> lock(w.mutex);
    if (w.vulkan) return w.device_number;
    try {
        if (why && capacity > 0) copy(no_device(w), why, capacity);
    } catch (const std::exception &) {
        why[0] = 0; // memory ran out
    }
    return 0;
}

CrumpleUnityEvent crumple_unity_event(int32_t *out_id) {
    World &w = world();
    const std::lock_guard<std::mutex> lock(w.mutex);
    if (!w.loaded) return nullptr;
    *out_id = w.event_id;
    return &on_render_event;
}

uint32_t crumple_unity_pending(void) {
    World &w = world();
    const std::lock_guard<std::mutex> lock(w.mutex);
    if (!w.vulkan) return 0;
    size_t pending = w.dying.size();
    for (const auto &entry : w.contexts) pending += entry.second->in_flight ? 1 : 0;
    for (const auto &entry : w.buffers) pending += entry.second->wanted ? 1 : 0;
    return static_cast<uint32_t>(pending);
}

uint32_t crumple_unity_take_message(char *text, uint32_t capacity) {
    World &w = world();
    const std::lock_guard<std::mutex> lock(w.mutex);
    if (w.message.empty() || capacity == 0) return 0;
    const uint32_t length = copy(w.message, text, capacity);
    w.message.clear();
    return length;
}

CrumpleResult crumple_unity_add_context(CrumpleContext *handle) {
    return guarded("add_context", [=](World &w) {
        auto context = std::make_shared<Context>();
        context->handle = handle;
        const std::lock_guard<std::mutex> lock(w.mutex);
        const std::string why = no_device(w);
        if (!why.empty()) return refuse(CRUMPLE_ERROR_UNSUPPORTED, "add_context", why);
        if (!handle || !w.contexts.emplace(handle, std::move(context)).second)
            return refuse(CRUMPLE_ERROR_INVALID_ARGUMENT, "add_context", "the context is null, or known already");
        return CRUMPLE_OK;
    });
}

CrumpleResult crumple_unity_destroy_context(CrumpleContext *handle) {
    return guarded("destroy_context", [=](World &w) {
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
    return guarded("lock", [=](World &w) {
        const std::shared_ptr<Context> context = context_of(w, handle);
        if (!context) return unknown_context("lock");
        if (!context->gate.enter()) return refuse(CRUMPLE_ERROR_CONCURRENT_USE, "lock", "this thread holds the lock already");
        if (!context->gone) return CRUMPLE_OK;
        context->gate.leave();
        return unknown_context("lock");
    });
}

CrumpleResult crumple_unity_unlock(CrumpleContext *handle) {
    return guarded("unlock", [=](World &w) {
        const std::shared_ptr<Context> context = context_of(w, handle);
        if (!context) return unknown_context("unlock");
        if (!context->gate.leave()) return refuse(CRUMPLE_ERROR_CONCURRENT_USE, "unlock", "this thread does not hold the lock");
        return CRUMPLE_OK;
    });
}

CrumpleResult crumple_unity_register_buffer(CrumpleContext *handle, const CrumpleUnityBufferDef *def, uint64_t *out_buffer) {
    return guarded("register_buffer", [=](World &w) {
        const char *const function = "register_buffer";
        if (!def || !out_buffer || !def->native_buffer)
            return refuse(CRUMPLE_ERROR_NULL_POINTER, function,
                          "def, out_buffer or def.native_buffer is null; a mesh without a vertex buffer on the device gives null");
        auto buffer = std::make_shared<Buffer>();
        std::string why = layout_of(*def, buffer->layout);
        buffer->def = *def;
        const std::lock_guard<std::mutex> lock(w.mutex);
        const auto context = w.contexts.find(handle);
        if (context == w.contexts.end()) return unknown_context(function);
        if (why.empty()) why = no_device(w);
        if (!why.empty()) return refuse(CRUMPLE_ERROR_UNSUPPORTED, function, why);
        buffer->context = context->second;
        buffer->device = w.device_number;
        w.buffers.emplace(w.last_buffer + 1, std::move(buffer));
        *out_buffer = ++w.last_buffer;
        return CRUMPLE_OK;
    });
}

CrumpleResult crumple_unity_unregister_buffer(uint64_t number) {
    return guarded("unregister_buffer", [=](World &w) {
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
    return with_buffer("want", number, [](Buffer &buffer) { buffer.wanted = true; });
}

CrumpleResult crumple_unity_buffer_info(uint64_t number, CrumpleUnityBufferInfo *out_info) {
    return with_buffer("buffer_info", number, [=](const Buffer &buffer) { *out_info = buffer.info; });
}

} // extern "C"
