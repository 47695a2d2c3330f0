// Drives the plugin's functions on a real Vulkan device: dents in a vertex buffer laid out as Unity lays out meshes, compared with
// the CPU's; the lock; a lost device; a context that is destroyed while the device runs its frame. The few functions of Unity's that
// the plugin calls are here, as far as it needs them. What Unity does beyond that is not tested.
#include "crumple_unity.h"
#include "unity_abi.h"

#include "support.h"
#include "vulkan_host.h"

#include <thread>
#include <vector>

extern "C" void UNITY_CALL UnityPluginLoad(unity::Interfaces *interfaces);
extern "C" void UNITY_CALL UnityPluginUnload();

// Mesh.SetVertexBufferParams() with position, normal, tangent and texture coordinates.
struct Vertex {
    float position[3], normal[3], tangent[4], uv[2];
};

static Host host;
static HostBuffer mesh;
static VkCommandBuffer commands; // null outside a frame
static unsigned long long frame, safe;
static unity::OnDeviceEvent device_event;
static CrumpleUnityEvent render_event;
static int event_id;

static void UNITY_CALL unused() {}

static unity::Graphics graphics{
    [] { return unity::Renderer::Vulkan; },
    [](unity::OnDeviceEvent callback) { device_event = callback; },
    [](unity::OnDeviceEvent) { device_event = nullptr; },
    [](int) { return 1000; },
};

static unity::VulkanInstance UNITY_CALL instance() {
    unity::VulkanInstance found{};
    found.instance = host.instance;
    found.physical_device = host.physical_device;
    found.device = host.device;
    found.get_instance_proc_addr = vkGetInstanceProcAddr;
    found.queue_family = host.queue_family;
    return found;
}

static bool UNITY_CALL recording(unity::Recording *out, unity::QueueAccess) {
    *out = {};
    out->commands = commands;
    out->subpass = -1;
    out->current_frame = frame;
    out->safe_frame = safe;
    return commands != nullptr;
}

static bool UNITY_CALL access_buffer(void *native, VkPipelineStageFlags, VkAccessFlags, unity::Access, unity::VulkanBuffer *out) {
    *out = {};
    out->buffer = mesh.buffer;
    out->size = mesh.size;
    out->usage = mesh.usage;
    return native == &mesh;
}

static unity::GraphicsVulkan vulkan{
    unused, unused, [](int, const unity::EventConfig *) {}, instance, recording, unused, unused,
    unused, access_buffer, unused, unused, unused, unused, unused,
};

static void *UNITY_CALL interface_of(unsigned long long high, unsigned long long) {
    return high == unity::GRAPHICS.high ? static_cast<void *>(&graphics) : static_cast<void *>(&vulkan);
}

static unity::Interfaces interfaces{unused, unused, interface_of, unused};

struct Scene {
    CrumpleContext *context = make_context(1);
    CrumpleExampleSet set{};
    CrumpleInstance body{};
    CrumpleBuffer cpu{};
    std::vector<Vertex> expected{VERTICES};
    uint64_t buffer = 0;

    // The body is written into `mesh` by the plugin, and into `expected` by the CPU.
    Scene() {
        static Sheet sheet;
        make_sheet(&sheet);
        OK(crumple_example_set_create(context, &sheet.def, &set));
        body = make_instance(context, set);
        CrumpleHostBufferDef def = crumple_host_buffer_def_default();
        const size_t bytes = VERTICES * sizeof(Vertex);
        def.positions = stream_of(expected.data(), bytes, offsetof(Vertex, position), sizeof(Vertex));
        def.normals = stream_of(expected.data(), bytes, offsetof(Vertex, normal), sizeof(Vertex));
        def.tangents = stream_of(expected.data(), bytes, offsetof(Vertex, tangent), sizeof(Vertex));
        OK(crumple_buffer_register_host(context, body, &def, &cpu));
        OK(crumple_unity_add_context(context));
        register_mesh();
    }

    CrumpleResult register_as(int normal_format) {
        CrumpleUnityBufferDef def{};
        def.instance = body;
        def.native_buffer = &mesh;
        def.vertex_count = VERTICES;
        def.stride = sizeof(Vertex);
        def.position = {0, 3, offsetof(Vertex, position)};
        def.normal = {normal_format, 3, offsetof(Vertex, normal)};
        def.tangent = {0, 4, offsetof(Vertex, tangent)};
        return crumple_unity_register_buffer(context, &def, &buffer);
    }

    void register_mesh() { OK(register_as(0)); }

    void hit(float x, float y) const {
        const CrumpleHitDef def = displacement_at(x, y, 0.02f);
        OK(crumple_instance_submit_hit(context, body, &def, NULL));
        OK(crumple_unity_want(buffer));
    }

    uint64_t recordings() const {
        CrumpleUnityBufferInfo info;
        OK(crumple_unity_buffer_info(buffer, &info));
        return info.recordings;
    }

    // A software driver rounds as IEEE 754 says, and gives the CPU's very bits.
    void check() {
        OK(crumple_unity_lock(context));
        OK(crumple_context_deform(context, NULL, 0, NULL));
        OK(crumple_unity_unlock(context));
        const float *seen = (const float *)mesh.data, *right = expected[0].position;
        for (size_t i = 0; i < VERTICES * sizeof(Vertex) / sizeof *seen; ++i)
            FACT(host.software ? memcmp(&seen[i], &right[i], sizeof *seen) == 0 : fabsf(seen[i] - right[i]) < 1e-5f);
        CrumpleUnityBufferInfo info;
        OK(crumple_unity_buffer_info(buffer, &info));
        for (const Vertex &vertex : expected)
            FACT(vertex.position[2] >= info.bounds.min.z && vertex.position[2] <= info.bounds.max.z);
    }
};

// A frame with the event where one is due, which the device has done when this returns.
static void run_frame() {
    ++frame;
    commands = host_begin(&host);
    if (crumple_unity_pending() > 0) render_event(event_id);
    const VkMemoryBarrier to_cpu = {VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_SHADER_WRITE_BIT, VK_ACCESS_HOST_READ_BIT};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &to_cpu, 0, nullptr, 0, nullptr);
    host_run(&host, commands);
    commands = nullptr;
    safe = frame;
}

static void open_mesh() {
    mesh = host_buffer(&host, VERTICES * sizeof(Vertex), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, true);
    memset(mesh.data, 0, mesh.size);
}

// The device goes with everything on it; the next one counts frames from the beginning.
static void lose_device(Scene &scene) {
    device_event(unity::DeviceEvent::Shutdown);
    FACT(crumple_unity_device(nullptr, 0) == 0 && crumple_unity_pending() == 0);
    FACT(crumple_unity_want(scene.buffer) == CRUMPLE_ERROR_DEVICE_LOST);
    host_destroy_buffer(&host, &mesh);
    host_close_device(&host);
    host_open_device(&host);
    open_mesh();
    frame = safe = 0;
    device_event(unity::DeviceEvent::Initialize);
    FACT(crumple_unity_device(nullptr, 0) == 2);
    OK(crumple_unity_unregister_buffer(scene.buffer));
    scene.register_mesh();
}

// While the main thread is inside the context, the render thread leaves it alone and does not wait.
static void locked(const Scene &scene) {
    const uint64_t before = scene.recordings();
    OK(crumple_unity_lock(scene.context));
    FACT(crumple_unity_lock(scene.context) == CRUMPLE_ERROR_CONCURRENT_USE);
    std::thread render(run_frame);
    render.join(); // here it would never end if it waited
    FACT(scene.recordings() == before && crumple_unity_pending() > 0);
    OK(crumple_unity_unlock(scene.context));
    run_frame();
    FACT(scene.recordings() == before + 1);
}

int main(void) {
    char text[256];
    host_open(&host);
    open_mesh();
    FACT(crumple_unity_version() == CRUMPLE_VERSION);
    FACT(crumple_unity_device(text, sizeof text) == 0 && strstr(text, "Load on startup"));
    UnityPluginLoad(&interfaces);
    FACT(crumple_unity_device(text, sizeof text) == 1);
    render_event = crumple_unity_event(&event_id);
    FACT(render_event && event_id == 1000);
    {
        Scene scene;
        FACT(scene.register_as(2) == CRUMPLE_ERROR_UNSUPPORTED && strstr(crumple_unity_last_error(), "normals are VertexAttributeFormat 2 x 3; Crumple writes"));
        render_event(event_id); // outside a frame nothing can be recorded
        FACT(crumple_unity_take_message(text, sizeof text) > 0 && strstr(text, "no command buffer"));
        run_frame();
        scene.check();
        scene.hit(0, 0);
        run_frame();
        scene.check();
        run_frame();
        FACT(scene.recordings() == 2 && crumple_unity_pending() == 0); // nothing was hit
        lose_device(scene);
        run_frame();
        scene.check();
        scene.hit(0.2f, 0.1f);
        locked(scene);
        scene.check();

        // The device is not known to be done with the frame: the context is kept until it is.
        scene.hit(-0.2f, 0.1f);
        const unsigned long long done = safe;
        run_frame();
        safe = done;
        OK(crumple_unity_destroy_context(scene.context));
        FACT(crumple_unity_pending() == 1);
        run_frame();
        run_frame();
        FACT(crumple_unity_pending() == 0);
    }
    Scene scene;
    run_frame();
    scene.check();
    UnityPluginUnload();
    FACT(!device_event && crumple_unity_device(nullptr, 0) == 0);
    OK(crumple_unity_destroy_context(scene.context));
    host_destroy_buffer(&host, &mesh);
    printf("%s: %u checks\n", host.name, checks);
    host_close(&host);
    return 0;
}
