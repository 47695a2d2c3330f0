// What the plugin knows: the device, contexts, buffers, and who may touch which of them.
//
// Two kinds of locks. World::mutex guards the tables and is held for a few instructions, never across a call of Unity's or
// Crumple's. A context's gate is held by whoever is inside that context: the main thread between crumple_unity_lock() and unlock,
// or the render thread while it records. Who wants both takes the gate first. The render event only tries a gate.
#ifndef CRUMPLE_UNITY_WORLD_HPP
#define CRUMPLE_UNITY_WORLD_HPP

#include "crumple_unity.h"
#include "library.hpp"
#include "unity_abi.h"

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace crumple_unity {

// A mutex that knows who is inside.
class Gate {
  public:
    // Waits; false: this thread is inside already.
    bool enter() {
        if (inside_ == std::this_thread::get_id()) return false;
        mutex_.lock();
        inside_ = std::this_thread::get_id();
        return true;
    }

    // False: somebody is inside, perhaps this thread.
    bool try_enter() {
        if (inside_ == std::this_thread::get_id() || !mutex_.try_lock()) return false;
        inside_ = std::this_thread::get_id();
        return true;
    }

    // False: this thread is not inside.
    bool leave() {
        if (inside_ != std::this_thread::get_id()) return false;
        inside_ = std::thread::id{};
        mutex_.unlock();
        return true;
    }

  private:
    std::mutex mutex_;
    std::atomic<std::thread::id> inside_{};
};

// Leaves a gate whatever happens.
struct Inside {
    Gate &gate;
    bool entered = true; // false: this thread was inside before
    ~Inside() {
        if (entered) gate.leave();
    }
};

// A vertex layout of Unity's as Crumple's streams.
struct Layout {
    CrumpleVulkanStream position{}, normal{}, tangent{};
};

// Fills `out`, or tells which attribute Crumple does not write, and what it does; empty: all is well.
std::string layout_of(const CrumpleUnityBufferDef &def, Layout &out);

struct Context {
    CrumpleContext *handle = nullptr;
    Gate gate;
    std::atomic<bool> in_flight{false}; // the device may be running frames of it
    // The rest belongs to whoever is inside the gate.
    bool gone = false;     // destroyed for the caller
    uint32_t device = 0;   // the device that is attached, by World::device_number; 0: none
    uint64_t recorded = 0; // the last frame, as Crumple counts
};

struct Buffer {
    std::shared_ptr<Context> context;
    CrumpleUnityBufferDef def{};
    Layout layout;
    uint32_t device = 0; // the device that native_buffer belongs to

    // Guarded by World::mutex.
    CrumpleUnityBufferInfo info{};
    CrumpleResult result = CRUMPLE_OK; // otherwise no event records it any more
    std::string error;
    bool wanted = true, gone = false;

    // Belongs to whoever is inside the context's gate.
    bool registered = false;
    CrumpleBuffer id{};
    VkBuffer vulkan = VK_NULL_HANDLE;
    size_t size = 0;
    VkBufferUsageFlags usage = 0;

    // The event's own, from one step to the next.
    unity::VulkanBuffer seen{};
    bool found = false;
};

struct World {
    std::mutex mutex;
    bool loaded = false;
    std::string library_error; // empty: it is there
    Library library;
    unity::Interfaces *interfaces = nullptr;
    unity::Graphics *graphics = nullptr;
    unity::GraphicsVulkan *vulkan = nullptr; // null: no Vulkan device
    unity::VulkanInstance instance{};
    int event_id = -1;
    uint32_t device_number = 0; // counts devices
    std::map<CrumpleContext *, std::shared_ptr<Context>> contexts;
    std::vector<std::shared_ptr<Context>> dying; // destroyed for the caller, with frames that the device may be running
    std::map<uint64_t, std::shared_ptr<Buffer>> buffers;
    uint64_t last_buffer = 0;
    std::string message; // of the last event that could do nothing

    // Held by an event, and by the end of a device, so that neither comes into the other.
    std::mutex event_mutex;
};

World &world();

// Why there is no device, empty if there is one; with World::mutex held.
std::string no_device(const World &w);

void UNITY_CALL on_render_event(int event_id);

} // namespace crumple_unity

#endif
