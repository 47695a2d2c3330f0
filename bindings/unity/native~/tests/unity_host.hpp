// Plays Unity's side of its plugin interface over a real Vulkan device: loads the plugin from its file, hands out the tables,
// tells of devices, keeps several frames in flight, and checks that the plugin keeps to what Unity's documentation asks of it.
#ifndef CRUMPLE_UNITY_HOST_HPP
#define CRUMPLE_UNITY_HOST_HPP

#include "../crumple_unity.h"
#include "../unity_abi.h"

#include "support.h"
#include "vulkan_host.h"

#include <deque>
#include <set>
#include <string>
#include <vector>

// The exports, as C# finds them: by name.
struct Plugin {
#define PLUGIN_FUNCTIONS(F)                                                                                                      \
    F(version) F(last_error) F(state) F(device) F(event) F(pending) F(take_message) F(add_context) F(destroy_context) F(lock)    \
    F(unlock) F(register_buffer) F(unregister_buffer) F(want) F(buffer_info) F(buffer_error)
#define PLUGIN_MEMBER(name) decltype(&crumple_unity_##name) name = nullptr;
    PLUGIN_FUNCTIONS(PLUGIN_MEMBER)
#undef PLUGIN_MEMBER
    void(UNITY_CALL *load)(unity::Interfaces *) = nullptr;
    void(UNITY_CALL *unload)() = nullptr;

    void open(const char *path);
    void close();
    CrumpleUnityState state_is(const char *part) const; // its text has this in it
    std::string message() const;                        // the oldest one, or nothing
    CrumpleUnityBufferInfo info(uint64_t buffer) const;
    std::string error(uint64_t buffer) const;

  private:
    void *file_ = nullptr;
};

// What GraphicsBuffer.GetNativeBufferPtr() points to, and what the renderer keeps in mind of its use.
struct NativeBuffer {
    HostBuffer vk{};
    VkPipelineStageFlags stages = VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT;
    VkAccessFlags access = 0;
    unsigned accesses = 0;
};

class UnityHost {
  public:
    enum { FRAMES_IN_FLIGHT = 3 };

    Host host{};
    unity::Renderer renderer = unity::Renderer::Vulkan;
    bool gives_graphics = true, gives_vulkan = true;
    bool gives_commands = true, inside_render_pass = false; // of an event
    const char *lost_in = nullptr; // a function of the device that answers VK_ERROR_DEVICE_LOST
    int callbacks = 0;
    unsigned long long frame = 0, safe = 0;

    UnityHost();
    unity::Interfaces *interfaces();
    void tell(unity::DeviceEvent event) const;

    NativeBuffer *make_buffer(const void *bytes, size_t size, VkBufferUsageFlags usage);
    // The same native buffer gets another VkBuffer, as when a mesh is uploaded anew.
    void renew(NativeBuffer *native, const void *bytes, size_t size, VkBufferUsageFlags usage);
    void destroy_buffer(NativeBuffer *native);
    bool knows(const void *native) const;

    void begin_frame();
    void event(CrumpleUnityEvent callback, int id);
    // What a draw is to the renderer: it waits for the last use that it knows of, and reads. The bytes lie in `into` once the
    // frame is safe.
    void read(NativeBuffer *native, const HostBuffer &into);
    void end_frame();
    void wait_idle(); // all frames become safe
    void drop_frames(); // of a device that is about to go: their command buffers, without a word of their end

    // Called through the tables.
    bool access_buffer(void *native, VkPipelineStageFlags stages, VkAccessFlags access, unity::Access mode, unity::VulkanBuffer *out);
    bool recording(unity::Recording *out, unity::QueueAccess queue);

    unity::OnDeviceEvent callback = nullptr;
    std::set<int> configured;
    int reserved = 0;

  private:
    struct Frame {
        unsigned long long number;
        std::vector<VkCommandBuffer> commands;
        VkFence done;
    };

    VkCommandBuffer begin_commands();
    void retire(bool all);

    Frame now_{};
    std::deque<Frame> in_flight_;
    std::set<NativeBuffer *> buffers_;
    bool in_event_ = false;
};

#endif
