#include "world.hpp"

namespace crumple_unity {

bool Gate::enter() {
    std::unique_lock<std::mutex> lock(mutex_);
    if (inside_ == std::this_thread::get_id()) return false;
    free_.wait(lock, [this] { return inside_ == std::thread::id{}; });
    inside_ = std::this_thread::get_id();
    return true;
}

bool Gate::try_enter() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (inside_ != std::thread::id{}) return false;
    inside_ = std::this_thread::get_id();
    return true;
}

bool Gate::leave() {
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (inside_ != std::this_thread::get_id()) return false;
        inside_ = {};
    }
    free_.notify_one();
    return true;
}

World &world() {
    static World only;
    return only;
}

namespace {

std::string name(unity::Renderer renderer) {
    switch (renderer) {
    case unity::Renderer::D3D11: return "Direct3D 11";
    case unity::Renderer::Null: return "none";
    case unity::Renderer::OpenGlEs3: return "OpenGL ES";
    case unity::Renderer::Metal: return "Metal";
    case unity::Renderer::OpenGlCore: return "OpenGL";
    case unity::Renderer::D3D12: return "Direct3D 12";
    case unity::Renderer::Vulkan: return "Vulkan";
    }
    return "number " + std::to_string(static_cast<int>(renderer));
}

} // namespace

CrumpleUnityState state_of(const World &w, std::string &why) {
    if (!w.loaded) {
        why = "Unity has not loaded crumple_unity as a plugin: tick \"Load on startup\" in its Plugin Inspector and restart";
        return CRUMPLE_UNITY_NOT_LOADED;
    }
    if (!w.library_error.empty()) {
        why = w.library_error;
        return CRUMPLE_UNITY_NO_LIBRARY;
    }
    if (!w.graphics || w.renderer != unity::Renderer::Vulkan) {
        why = "the renderer is " + name(w.renderer) + ": vertices are written on the device under Vulkan only, and on the CPU elsewhere";
        return CRUMPLE_UNITY_OTHER_RENDERER;
    }
    if (!w.device_here) {
        why = "there is no Vulkan device at the moment";
        return CRUMPLE_UNITY_NO_DEVICE;
    }
    why.clear();
    return CRUMPLE_UNITY_READY;
}

void say(World &w, std::string text) {
    if (!w.messages.empty() && w.messages.back() == text) return;
    if (w.messages.size() == 16) w.messages.pop_front();
    w.messages.push_back(std::move(text));
}

} // namespace crumple_unity
