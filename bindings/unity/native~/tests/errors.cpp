// What can be wrong on a Vulkan device, and what the plugin says of it: buffers, ids, and who meets whom.
//
//     unity_errors libcrumple_unity.so
#include "scene.hpp"

#include <crumple_vulkan.h>

#include <atomic>
#include <cstdlib>
#include <new>
#include <string>
#include <thread>

#include <dlfcn.h>
#include <unistd.h>

#ifndef __SANITIZE_ADDRESS__ // which has its own memory
// The plugin's memory comes from here, as that of everything else in the process: its so manieth request fails. Below 0: none.
static thread_local int requests_left = -1;

static bool plugin_asks(void *from) {
    Dl_info info;
    return dladdr(from, &info) != 0 && info.dli_fname && strstr(info.dli_fname, "libcrumple_unity");
}

__attribute__((noinline)) void *operator new(size_t size) {
    const bool counts = requests_left >= 0 && plugin_asks(__builtin_return_address(0));
    void *memory = counts && requests_left-- == 0 ? nullptr : malloc(size ? size : 1);
    if (!memory) throw std::bad_alloc();
    return memory;
}
__attribute__((noinline)) void operator delete(void *memory) noexcept { free(memory); }
__attribute__((noinline)) void operator delete(void *memory, size_t) noexcept { free(memory); }
#endif

static UnityHost unity_host;
static Plugin plugin;
static CrumpleUnityEvent event;
static int event_id;

// The call fails with this result, and this is in its text.
static void refused(CrumpleResult expected, const char *part, CrumpleResult result) {
    if (result != expected || !strstr(plugin.last_error(), part))
        fprintf(stderr, "%s: %s, expected %s\n", crumple_result_name(result), plugin.last_error(), part);
    FACT(result == expected && strstr(plugin.last_error(), part));
}

static void frame() {
    unity_host.begin_frame();
    unity_host.event(event, event_id);
    unity_host.end_frame();
}

// Registers, runs an event, and answers what it said of the buffer.
static std::string failure(const Scene &scene, const CrumpleUnityBufferDef &def, CrumpleResult expected) {
    uint64_t buffer;
    OK(plugin.register_buffer(scene.context, &def, &buffer));
    frame();
    const CrumpleUnityBufferInfo info = plugin.info(buffer);
    const std::string why = plugin.error(buffer);
    if (info.result != expected) fprintf(stderr, "%s: %s\n", crumple_result_name((CrumpleResult)info.result), why.c_str());
    FACT(info.state == CRUMPLE_UNITY_BUFFER_FAILED && info.result == expected && !info.wanted);
    refused(expected, why.c_str(), plugin.want(buffer));
    OK(plugin.unregister_buffer(buffer));
    return why;
}

static bool has(const std::string &text, const char *part) { return text.find(part) != std::string::npos; }

// What only the device can tell.
static void buffers(const Scene &scene, NativeBuffer *native) {
    const size_t bytes = rest().size() * sizeof(Vertex);
    NativeBuffer *plain = unity_host.make_buffer(rest().data(), bytes, 0);
    NativeBuffer *small = unity_host.make_buffer(rest().data(), bytes - 4, RAW);
    int not_a_buffer = 0;
    FACT(has(failure(scene, scene.buffer_def(plain), CRUMPLE_ERROR_UNSUPPORTED), "vertexBufferTarget |= GraphicsBuffer.Target.Raw"));
    FACT(has(failure(scene, scene.buffer_def(small), CRUMPLE_ERROR_BUFFER_TOO_SMALL),
             "has 29996 bytes, but 625 vertices of 48 bytes need 30000"));
    CrumpleUnityBufferDef def = scene.buffer_def(native);
    def.native_buffer = &not_a_buffer;
    FACT(has(failure(scene, def, CRUMPLE_ERROR_INVALID_ID), "knows no Vulkan buffer"));
    def = scene.buffer_def(native);
    def.instance = CrumpleInstance{};
    FACT(has(failure(scene, def, CRUMPLE_ERROR_INVALID_ID), "crumple_buffer_register_vulkan: "));
    def = scene.buffer_def(native);
    def.vertex_count = 600; // Mesh.vertexCount of another mesh
    FACT(has(failure(scene, def, CRUMPLE_ERROR_BUFFER_TOO_SMALL), "crumple_buffer_register_vulkan: "));
    def = scene.buffer_def(native);
    def.lod = 3;
    FACT(has(failure(scene, def, CRUMPLE_ERROR_INDEX_OUT_OF_RANGE), "level of detail is 3"));

    // The component's body was destroyed, but nobody told the plugin: an error, and others go on.
    uint64_t orphan, healthy;
    CrumpleInstance passing = make_instance(scene.context, scene.set);
    NativeBuffer *another = unity_host.make_buffer(rest().data(), bytes, RAW);
    def = scene.buffer_def(another);
    def.instance = passing;
    const CrumpleUnityBufferDef good = scene.buffer_def(native);
    OK(plugin.register_buffer(scene.context, &def, &orphan));
    frame();
    FACT(plugin.info(orphan).state == CRUMPLE_UNITY_BUFFER_RECORDED);
    OK(plugin.lock(scene.context));
    OK(crumple_instance_destroy(scene.context, passing));
    OK(plugin.unlock(scene.context));
    OK(plugin.want(orphan));
    frame();
    FACT(plugin.info(orphan).state == CRUMPLE_UNITY_BUFFER_FAILED && plugin.info(orphan).result == CRUMPLE_ERROR_INVALID_ID);
    OK(plugin.register_buffer(scene.context, &good, &healthy));
    frame();
    FACT(plugin.info(healthy).state == CRUMPLE_UNITY_BUFFER_RECORDED);
    OK(plugin.unregister_buffer(orphan)); // its registration ended with the instance

    // The other formats that are written.
    CrumpleUnityBufferDef packed = scene.buffer_def(another);
    packed.stride = 16;
    packed.position = {FLOAT16, 4, 0};
    packed.normal = {SNORM8, 4, 8};
    packed.tangent = {SNORM8, 4, 12};
    uint64_t small_one;
    OK(plugin.register_buffer(scene.context, &packed, &small_one));
    frame();
    FACT(plugin.info(small_one).state == CRUMPLE_UNITY_BUFFER_RECORDED);

    OK(plugin.unregister_buffer(healthy));
    OK(plugin.unregister_buffer(small_one));
    unity_host.wait_idle();
    unity_host.destroy_buffer(plain);
    unity_host.destroy_buffer(small);
    unity_host.destroy_buffer(another);
}

// A context that Crumple itself refuses to attach: somebody else attached it.
static void attached_by_another() {
    Scene scene;
    scene.open();
    CrumpleVulkanAttachDef vulkan = crumple_vulkan_attach_def_default();
    vulkan.get_instance_proc_addr = (CrumpleVulkanFunction)vkGetInstanceProcAddr;
    vulkan.instance = unity_host.host.instance;
    vulkan.physical_device = unity_host.host.physical_device;
    vulkan.device = unity_host.host.device;
    vulkan.queue_family = unity_host.host.queue_family;
    OK(crumple_vulkan_attach(scene.context, &vulkan));
    OK(plugin.add_context(scene.context));
    NativeBuffer *native = unity_host.make_buffer(rest().data(), rest().size() * sizeof(Vertex), RAW);
    FACT(has(failure(scene, scene.buffer_def(native), CRUMPLE_ERROR_INVALID_ARGUMENT), "crumple_vulkan_attach: "));
    OK(plugin.destroy_context(scene.context));
    unity_host.wait_idle();
    unity_host.destroy_buffer(native);
}

// A driver says that the device is lost before Unity does: no failure of the buffer's, since the next device may come.
static void lost_in_an_event(const Scene &scene, NativeBuffer *native) {
    uint64_t buffer;
    const CrumpleUnityBufferDef def = scene.buffer_def(native);
    unity_host.tell(unity::DeviceEvent::Shutdown);
    unity_host.tell(unity::DeviceEvent::Initialize);
    OK(plugin.register_buffer(scene.context, &def, &buffer));
    unity_host.lost_in = "vkAllocateMemory";
    frame();
    unity_host.lost_in = nullptr;
    FACT(plugin.info(buffer).state == CRUMPLE_UNITY_BUFFER_LOST && plugin.info(buffer).result == CRUMPLE_ERROR_DEVICE_LOST);
    refused(CRUMPLE_ERROR_DEVICE_LOST, "the device is lost", plugin.want(buffer));
    OK(plugin.unregister_buffer(buffer));
}

static void ids(const Scene &scene, NativeBuffer *native) {
    CrumpleContext *stranger = make_context(1);
    const CrumpleUnityBufferDef def = scene.buffer_def(native);
    CrumpleUnityBufferInfo info{};
    uint64_t buffer;
    char text[8];
    const CrumpleResult unknown = CRUMPLE_ERROR_INVALID_ID, null = CRUMPLE_ERROR_NULL_POINTER;
    refused(null, "context is null", plugin.add_context(nullptr));
    refused(CRUMPLE_ERROR_INVALID_ARGUMENT, "known already", plugin.add_context(scene.context));
    refused(unknown, "not known", plugin.lock(stranger));
    refused(unknown, "not known", plugin.unlock(stranger));
    refused(unknown, "not known", plugin.destroy_context(stranger));
    refused(unknown, "not known", plugin.register_buffer(stranger, &def, &buffer));
    refused(null, "def is null", plugin.register_buffer(scene.context, nullptr, &buffer));
    refused(null, "out_buffer is null", plugin.register_buffer(scene.context, &def, nullptr));
    OK(crumple_context_destroy(stranger));
    OK(plugin.lock(scene.context));
    refused(CRUMPLE_ERROR_CONCURRENT_USE, "holds the lock already", plugin.lock(scene.context));
    std::thread([&] { refused(CRUMPLE_ERROR_CONCURRENT_USE, "does not hold", plugin.unlock(scene.context)); }).join();
    OK(plugin.unlock(scene.context));
    refused(CRUMPLE_ERROR_CONCURRENT_USE, "does not hold", plugin.unlock(scene.context));
    refused(unknown, "no buffer 4000", plugin.want(4000));
    refused(unknown, "no buffer 4000", plugin.unregister_buffer(4000));
    info.struct_size = sizeof info;
    refused(unknown, "no buffer 4000", plugin.buffer_info(4000, &info));
    refused(unknown, "no buffer 4000", plugin.buffer_error(4000, text, sizeof text));
    refused(null, "text is null", plugin.buffer_error(1, nullptr, 8));
    refused(null, "out_info is null", plugin.buffer_info(1, nullptr));
    info.struct_size = 3;
    refused(CRUMPLE_ERROR_STRUCT_SIZE, "struct_size is 3, here it is 48", plugin.buffer_info(1, &info));

    // Texts are cut, never more.
    memset(text, 'x', sizeof text);
    unity_host.tell(unity::DeviceEvent::Shutdown);
    FACT(plugin.state(text, 4) == CRUMPLE_UNITY_NO_DEVICE && strcmp(text, "the") == 0 && text[4] == 'x');
    FACT(plugin.state(nullptr, 0) == CRUMPLE_UNITY_NO_DEVICE && plugin.take_message(nullptr, 0) == 0);
    refused(CRUMPLE_ERROR_UNSUPPORTED, "no Vulkan device", plugin.register_buffer(scene.context, &def, &buffer));
    unity_host.tell(unity::DeviceEvent::Initialize);
}

// Whether a thread of ours waits for something.
static bool asleep(pid_t thread) {
    char text[256] = "";
    FILE *file = fopen(("/proc/self/task/" + std::to_string(thread) + "/stat").c_str(), "r");
    if (!file) return false;
    const size_t length = fread(text, 1, sizeof text - 1, file);
    fclose(file);
    const char *name_end = length ? strrchr(text, ')') : nullptr;
    return name_end && name_end[2] == 'S';
}

#ifndef __SANITIZE_ADDRESS__
// Each request for memory fails once: the call says so, nothing has changed, and the next one works.
template <class Call> static void without_memory(const char *name, Call call) {
    for (int request = 0;; ++request) {
        requests_left = request;
        const CrumpleResult result = call();
        requests_left = -1;
        if (result == CRUMPLE_OK) {
            FACT(request > 0);
            return;
        }
        FACT(result == CRUMPLE_ERROR_OUT_OF_MEMORY && strcmp(plugin.last_error(), name) == 0);
    }
}

static void memory(const Scene &scene, NativeBuffer *native) {
    const CrumpleUnityBufferDef def = scene.buffer_def(native);
    uint64_t buffer = 0;
    CrumpleContext *context = make_context(1);
    without_memory("crumple_unity_add_context: memory ran out", [&] { return plugin.add_context(context); });
    OK(plugin.destroy_context(context));
    without_memory("crumple_unity_register_buffer: memory ran out", [&] { return plugin.register_buffer(scene.context, &def, &buffer); });
    OK(plugin.unregister_buffer(buffer));

    // An event needs memory when there are more buffers than ever before, and then they stay wanted.
    std::vector<uint64_t> many(64);
    for (uint64_t &each : many) OK(plugin.register_buffer(scene.context, &def, &each));
    unity_host.begin_frame();
    requests_left = 0;
    unity_host.event(event, event_id);
    requests_left = -1;
    unity_host.end_frame();
    for (uint64_t each : many) {
        FACT(plugin.info(each).state == CRUMPLE_UNITY_BUFFER_NEW && plugin.info(each).wanted);
        OK(plugin.unregister_buffer(each));
    }
    requests_left = 0;
    plugin.state(nullptr, 0);
    requests_left = 0;
    unity_host.tell(unity::DeviceEvent::Shutdown);
    requests_left = -1;
    unity_host.tell(unity::DeviceEvent::Shutdown);
    unity_host.tell(unity::DeviceEvent::Initialize);
    FACT(plugin.state_is("") == CRUMPLE_UNITY_READY);
}
#endif

// A context that is destroyed while others wait for it, a device that ends while the main thread is inside, and one that is
// another without a word of the first one's end.
static void meetings(Scene &scene, NativeBuffer *native) {
    Scene passing;
    passing.open();
    OK(plugin.add_context(passing.context));
    OK(plugin.lock(passing.context));
    std::atomic<pid_t> waiter{0};
    std::thread waits([&] {
        waiter = gettid();
        refused(CRUMPLE_ERROR_INVALID_ID, "not known", plugin.lock(passing.context));
    });
    while (waiter == 0 || !asleep(waiter)) std::this_thread::yield();
    OK(plugin.destroy_context(passing.context)); // by the thread that is inside
    waits.join();

    // Inside without the lock: Crumple notices, and the event leaves the buffer for the next one.
    CrumpleContextDef talkative = crumple_context_def_default();
    talkative.log = [](CrumpleLogLevel, const char *, void *) { frame(); };
    OK(crumple_context_create(&talkative, &passing.context));
    OK(plugin.add_context(passing.context));
    OK(crumple_example_set_create(passing.context, &sheet().def, &passing.set));
    passing.body = make_instance(passing.context, passing.set);
    const CrumpleUnityBufferDef passing_def = passing.buffer_def(native);
    uint64_t buffer;
    OK(plugin.register_buffer(passing.context, &passing_def, &buffer));
    CrumpleExampleSet another;
    OK(crumple_example_set_create(passing.context, &sheet().def, &another));
    FACT(plugin.info(buffer).state == CRUMPLE_UNITY_BUFFER_NEW && plugin.info(buffer).wanted);
    frame();
    FACT(plugin.info(buffer).state == CRUMPLE_UNITY_BUFFER_RECORDED);
    OK(plugin.destroy_context(passing.context));

    const CrumpleUnityBufferDef def = scene.buffer_def(native);
    OK(plugin.register_buffer(scene.context, &def, &buffer));
    frame();
    OK(plugin.lock(scene.context));
    std::thread device([] { unity_host.tell(unity::DeviceEvent::Shutdown); });
    while (plugin.state(nullptr, 0) == CRUMPLE_UNITY_READY) std::this_thread::yield();
    event(event_id); // the device is ending: nothing, and nobody waits
    OK(crumple_context_deform(scene.context, &scene.twin_buffer, 1, NULL));
    OK(plugin.unlock(scene.context));
    device.join();
    OK(plugin.unregister_buffer(buffer));

    unity_host.wait_idle();
    unity_host.tell(unity::DeviceEvent::Initialize);
    const uint32_t number = plugin.device();
    OK(plugin.register_buffer(scene.context, &def, &buffer));
    const VkDevice real = unity_host.host.device;
    unity_host.host.device = nullptr;
    unity_host.tell(unity::DeviceEvent::Initialize); // another device: none
    FACT(plugin.state_is("no Vulkan device") == CRUMPLE_UNITY_NO_DEVICE && plugin.info(buffer).state == CRUMPLE_UNITY_BUFFER_LOST);
    unity_host.host.device = real;
    unity_host.tell(unity::DeviceEvent::Initialize);
    FACT(plugin.device() == number + 1 && has(plugin.message(), "gives no Vulkan device"));
    unity_host.tell(static_cast<unity::DeviceEvent>(9)); // one that we do not know
}

int main(int count, char **arguments) {
    FACT(count == 2);
    plugin.open(arguments[1]);
    host_open(&unity_host.host);
    plugin.load(unity_host.interfaces()); // the device was there first: no event tells of it
    FACT(plugin.state_is("") == CRUMPLE_UNITY_READY);
    event = plugin.event(&event_id);
    Scene scene;
    scene.open();
    OK(plugin.add_context(scene.context));
    NativeBuffer *native = unity_host.make_buffer(rest().data(), rest().size() * sizeof(Vertex), RAW);
    buffers(scene, native);
    attached_by_another();
    lost_in_an_event(scene, native);
    ids(scene, native);
    meetings(scene, native);
#ifndef __SANITIZE_ADDRESS__
    memory(scene, native);
#endif
    FACT(plugin.message().empty());
    OK(plugin.destroy_context(scene.context));
    unity_host.tell(unity::DeviceEvent::Shutdown);
    plugin.unload();
    plugin.close();
    unity_host.drop_frames();
    unity_host.destroy_buffer(native);
    printf("%s: %u checks\n", unity_host.host.name, checks);
    host_close(&unity_host.host);
    return 0;
}
