// The plugin's life as Unity gives it: loaded before the device, frames in flight, a context in use by the main thread, a mesh
// that is uploaded anew, a lost device and the next one, the main thread and the render thread at once, unloading with frames on
// the device.
//
//     unity_frames libcrumple_unity.so
#include "scene.hpp"

#include <atomic>
#include <thread>

static UnityHost unity_host;
static Plugin plugin;
static CrumpleUnityEvent event;
static int event_id;

// One frame: the event where there is something to do, and what the frame's draws read.
static void frame(NativeBuffer *native, const HostBuffer *into) {
    unity_host.begin_frame();
    if (plugin.pending() > 0) unity_host.event(event, event_id);
    if (into) unity_host.read(native, *into);
    unity_host.end_frame();
}

static HostBuffer seen_buffer() {
    return host_buffer(&unity_host.host, rest().size() * sizeof(Vertex), VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);
}

static void deform_twin(Scene &scene) {
    OK(plugin.lock(scene.context));
    OK(crumple_context_deform(scene.context, &scene.twin_buffer, 1, NULL));
    OK(plugin.unlock(scene.context));
}

// Twelve frames, three of them in flight; each is what the CPU makes of the same hits.
static void lockstep(Scene &scene, NativeBuffer *native, uint64_t buffer, int first_hit) {
    enum { FRAMES = 12 };
    std::vector<HostBuffer> seen;
    std::vector<std::vector<Vertex>> expected;
    const uint64_t before = plugin.info(buffer).recordings;
    uint64_t hits = 0;
    for (int i = 0; i < FRAMES; ++i) {
        if (i == 2 || i == 4 || i == 5) {
            scene.hit(first_hit + i);
            OK(plugin.want(buffer));
            ++hits;
        }
        seen.push_back(seen_buffer());
        frame(native, &seen.back());
        deform_twin(scene);
        expected.push_back(scene.expected);
        const CrumpleUnityBufferInfo info = plugin.info(buffer);
        FACT(info.state == CRUMPLE_UNITY_BUFFER_RECORDED && !info.wanted);
        for (const Vertex &vertex : scene.expected)
            FACT(vertex.position[2] >= info.bounds.min.z && vertex.position[2] <= info.bounds.max.z);
    }
    FACT(plugin.info(buffer).recordings >= before + hits && plugin.info(buffer).recordings <= before + hits + 1);
    unity_host.wait_idle();
    for (int i = 0; i < FRAMES; ++i) {
        FACT(same(unity_host.host, seen[(size_t)i].data, expected[(size_t)i]));
        host_destroy_buffer(&unity_host.host, &seen[(size_t)i]);
    }
    frame(native, nullptr); // learns that all are done
    FACT(plugin.pending() == 0);
    const unsigned accesses = native->accesses;
    unity_host.begin_frame();
    unity_host.event(event, event_id); // nothing to do: Unity is not even asked
    unity_host.event(event, event_id + 1);
    unity_host.end_frame();
    FACT(native->accesses == accesses);
}

static void look(Scene &scene, NativeBuffer *native) {
    HostBuffer seen = seen_buffer();
    frame(native, &seen);
    unity_host.wait_idle();
    deform_twin(scene);
    FACT(same(unity_host.host, seen.data, scene.expected));
    host_destroy_buffer(&unity_host.host, &seen);
}

// While the main thread is inside the context, an event leaves it alone and does not wait.
static void locked(Scene &scene, NativeBuffer *native, uint64_t buffer) {
    const uint64_t before = plugin.info(buffer).recordings;
    scene.hit(50);
    OK(plugin.want(buffer));
    OK(plugin.lock(scene.context));
    std::thread render([&] { frame(native, nullptr); });
    render.join(); // here it would never end if it waited
    FACT(plugin.info(buffer).recordings == before && plugin.info(buffer).wanted && plugin.pending() > 0);
    frame(native, nullptr); // and in this very thread, as without a render thread
    FACT(plugin.info(buffer).recordings == before);
    OK(plugin.unlock(scene.context));
    look(scene, native);
    FACT(plugin.info(buffer).recordings == before + 1);
}

// No command buffer, or a render pass: what was wanted stays so.
static void no_commands(Scene &scene, NativeBuffer *native, uint64_t buffer) {
    scene.hit(60);
    OK(plugin.want(buffer));
    const uint64_t before = plugin.info(buffer).recordings;
    unity_host.gives_commands = false;
    frame(native, nullptr);
    frame(native, nullptr);
    FACT(plugin.message().find("no command buffer") != std::string::npos && plugin.message().empty()); // said once
    unity_host.gives_commands = true;
    unity_host.inside_render_pass = true;
    frame(native, nullptr);
    FACT(plugin.message().find("inside a render pass") != std::string::npos);
    unity_host.inside_render_pass = false;
    FACT(plugin.info(buffer).recordings == before && plugin.info(buffer).wanted);
    look(scene, native);
}

// The main thread submits hits, deforms and registers while the render thread runs events.
static void at_once(Scene &scene, NativeBuffer *native, uint64_t buffer) {
    std::atomic<bool> over{false};
    std::atomic<int> frames{0};
    std::thread render([&] {
        while (!over) {
            unity_host.begin_frame();
            unity_host.event(event, event_id);
            unity_host.end_frame();
            ++frames;
        }
    });
    for (int i = 0; i < 60; ++i) {
        const int then = frames;
        scene.hit(100 + i);
        OK(plugin.want(buffer));
        deform_twin(scene);
        if (i % 8 == 0) {
            const CrumpleUnityBufferDef def = scene.buffer_def(native);
            OK(plugin.unregister_buffer(buffer));
            OK(plugin.register_buffer(scene.context, &def, &buffer));
        }
        while (i % 16 == 0 && frames < then + 2) std::this_thread::yield();
    }
    over = true;
    render.join();
    OK(plugin.want(buffer));
    look(scene, native);
    OK(plugin.unregister_buffer(buffer));
}

static bool lives(const Scene &scene) {
    CrumpleInstanceInfo info;
    return crumple_instance_get_info(scene.context, scene.body, &info) == CRUMPLE_OK;
}

// A frame that the device is still said to run keeps a destroyed context until it is safe.
static void destroyed_in_flight() {
    Scene scene;
    scene.open();
    NativeBuffer *native = unity_host.make_buffer(rest().data(), rest().size() * sizeof(Vertex), RAW);
    const CrumpleUnityBufferDef def = scene.buffer_def(native);
    uint64_t buffer;
    OK(plugin.add_context(scene.context));
    OK(plugin.register_buffer(scene.context, &def, &buffer));
    unity_host.begin_frame();
    unity_host.event(event, event_id);
    OK(plugin.destroy_context(scene.context));
    FACT(plugin.pending() == 1 && lives(scene));
    unity_host.event(event, event_id); // the same frame: not safe yet
    FACT(plugin.pending() == 1 && lives(scene));
    unity_host.end_frame();
    unity_host.wait_idle();
    frame(native, nullptr);
    FACT(plugin.pending() == 0 && !lives(scene));
    frame(native, nullptr);
    unity_host.wait_idle();
    unity_host.destroy_buffer(native);
}

int main(int count, char **arguments) {
    FACT(count == 2);
    plugin.open(arguments[1]);
    FACT(plugin.version() == CRUMPLE_VERSION && plugin.device() == 0 && plugin.pending() == 0);
    FACT(plugin.state_is("Load on startup") == CRUMPLE_UNITY_NOT_LOADED && !plugin.event(&event_id));

    // Loaded on startup: there is no device yet.
    unity_host.renderer = unity::Renderer::Null;
    plugin.load(unity_host.interfaces());
    FACT(plugin.state_is("the renderer is none") == CRUMPLE_UNITY_OTHER_RENDERER);
    host_open(&unity_host.host);
    unity_host.renderer = unity::Renderer::Vulkan;
    unity_host.tell(unity::DeviceEvent::Initialize);
    FACT(plugin.state_is("") == CRUMPLE_UNITY_READY && plugin.device() == 1);
    event = plugin.event(&event_id);
    FACT(event && event_id == 1000 && unity_host.configured.count(event_id) == 1);
    event(event_id); // no context: nothing
    unity_host.tell(unity::DeviceEvent::Initialize); // told twice: nothing
    FACT(plugin.device() == 1);

    // Loaded twice: the first holds.
    plugin.load(unity_host.interfaces());
    FACT(unity_host.callbacks == 1 && plugin.message().find("called twice") != std::string::npos);

    Scene scene;
    scene.open();
    NativeBuffer *native = unity_host.make_buffer(rest().data(), rest().size() * sizeof(Vertex), RAW);
    CrumpleUnityBufferDef def = scene.buffer_def(native);
    uint64_t buffer;
    OK(plugin.add_context(scene.context));
    OK(plugin.register_buffer(scene.context, &def, &buffer));
    FACT(plugin.info(buffer).state == CRUMPLE_UNITY_BUFFER_NEW && plugin.pending() == 1);
    lockstep(scene, native, buffer, 0);
    locked(scene, native, buffer);
    no_commands(scene, native, buffer);

    // The mesh is uploaded anew: another VkBuffer stands behind the same pointer, and gets every vertex.
    unity_host.wait_idle();
    unity_host.renew(native, rest().data(), rest().size() * sizeof(Vertex), RAW | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT);
    OK(plugin.want(buffer));
    look(scene, native);

    // The device is lost with a frame in flight: damage is not. The next device counts frames from the beginning.
    scene.hit(70);
    OK(plugin.want(buffer));
    frame(native, nullptr);
    unity_host.tell(unity::DeviceEvent::Shutdown);
    FACT(plugin.state_is("no Vulkan device") == CRUMPLE_UNITY_NO_DEVICE && plugin.pending() == 0);
    FACT(plugin.info(buffer).state == CRUMPLE_UNITY_BUFFER_LOST);
    FACT(plugin.want(buffer) == CRUMPLE_ERROR_DEVICE_LOST && strstr(plugin.last_error(), "register the mesh's new one"));
    unity_host.tell(unity::DeviceEvent::Shutdown); // told twice: nothing
    event(event_id);                               // came late: nothing
    unity_host.drop_frames();
    unity_host.destroy_buffer(native);
    host_close_device(&unity_host.host);
    host_open_device(&unity_host.host);
    unity_host.tell(unity::DeviceEvent::Initialize);
    FACT(plugin.state_is("") == CRUMPLE_UNITY_READY && plugin.device() == 2);
    native = unity_host.make_buffer(rest().data(), rest().size() * sizeof(Vertex), RAW);
    def = scene.buffer_def(native);
    OK(plugin.unregister_buffer(buffer));
    OK(plugin.register_buffer(scene.context, &def, &buffer));
    lockstep(scene, native, buffer, 80);
    at_once(scene, native, buffer);
    destroyed_in_flight();

    // A reset is an end and a beginning too. The end waits for the main thread where that is inside a context.
    OK(plugin.lock(scene.context));
    unity_host.tell(unity::DeviceEvent::BeforeReset); // this thread is: it waits for nobody
    OK(plugin.unlock(scene.context));
    FACT(plugin.state_is("no Vulkan device") == CRUMPLE_UNITY_NO_DEVICE);
    FACT(plugin.register_buffer(scene.context, &def, &buffer) == CRUMPLE_ERROR_UNSUPPORTED);
    unity_host.tell(unity::DeviceEvent::AfterReset);
    FACT(plugin.state_is("") == CRUMPLE_UNITY_READY && plugin.device() == 3);
    OK(plugin.register_buffer(scene.context, &def, &buffer));
    OK(plugin.want(buffer));
    frame(native, nullptr);

    // Destroyed with a frame in flight, and unloaded with another one; then the device goes.
    Scene other;
    other.open();
    NativeBuffer *others = unity_host.make_buffer(rest().data(), rest().size() * sizeof(Vertex), RAW);
    const CrumpleUnityBufferDef other_def = other.buffer_def(others);
    uint64_t other_buffer;
    OK(plugin.add_context(other.context));
    OK(plugin.register_buffer(other.context, &other_def, &other_buffer));
    scene.hit(90);
    OK(plugin.want(buffer));
    frame(native, nullptr);
    OK(plugin.destroy_context(other.context));
    plugin.unload();
    FACT(plugin.state_is("Load on startup") == CRUMPLE_UNITY_NOT_LOADED && unity_host.callbacks == 0 && !lives(other) && lives(scene));
    plugin.unload(); // once more: nothing
    event(event_id);
    OK(plugin.destroy_context(scene.context));
    FACT(!lives(scene));
    plugin.close();
    unity_host.drop_frames();
    unity_host.destroy_buffer(native);
    unity_host.destroy_buffer(others);
    printf("%s: %u checks\n", unity_host.host.name, checks);
    host_close(&unity_host.host);
    return 0;
}
