// Whatever an engine hands to the Vulkan calls by mistake gets an error that names it, changes nothing, and all goes on. Layouts of
// buffers that are refused are in tests/gpu/refusals.rs, other devices and recordings in tests/vulkan/errors.rs.
#include "vulkan_support.h"

#include <crumple_parts.h>

#include <pthread.h>

static Host host;
static CrumpleContext *context;
static CrumpleInstance body;
static HostBuffer vertices;

static void unattached(void) {
    CrumpleVulkanBufferDef def = buffer_def(&vertices);
    CrumpleBuffer buffer;
    size_t size;
    const char *why = "no Vulkan device is attached; crumple_vulkan_attach()";
    const CrumpleResult invalid = CRUMPLE_ERROR_INVALID_ARGUMENT;
    FAILS(invalid, why, crumple_buffer_register_vulkan(context, body, &def, &buffer));
    FAILS(invalid, why, crumple_vulkan_record(context, &host, 1, NULL, 0, NULL));
    FAILS(invalid, why, crumple_vulkan_complete_frames(context, 1));
    FAILS(invalid, why, crumple_vulkan_discard_frames(context, 1));
    FAILS(invalid, why, crumple_vulkan_get_pipeline_cache(context, NULL, 0, &size));
    FAILS(invalid, why, crumple_vulkan_detach(context));
}

static void devices(void) {
    const CrumpleResult null = CRUMPLE_ERROR_NULL_POINTER, invalid = CRUMPLE_ERROR_INVALID_ARGUMENT;
    const CrumpleVulkanAttachDef good = vulkan_def(&host);
    CrumpleVulkanAttachDef def = crumple_vulkan_attach_def_default();
    FAILS(null, "def.", crumple_vulkan_attach(context, &def));
    def = good;
#define REFUSED(result, part)                                                                                          \
    do {                                                                                                               \
        FAILS(result, part, crumple_vulkan_attach(context, &def));                                                     \
        def = good;                                                                                                    \
    } while (0)
    def.get_instance_proc_addr = NULL;
    REFUSED(null, "def.get_instance_proc_addr");
    FAILS(null, "context", crumple_vulkan_attach(NULL, &good));
    FAILS(null, "def", crumple_vulkan_attach(context, NULL));
    def.instance = NULL;
    REFUSED(null, "def.instance");
    def.physical_device = NULL;
    REFUSED(null, "def.physical_device");
    def.device = NULL;
    REFUSED(null, "def.device");
    def.pipeline_cache_size = 8;
    REFUSED(null, "def.pipeline_cache");
    def.struct_size -= 4;
    REFUSED(CRUMPLE_ERROR_STRUCT_SIZE, "crumple_vulkan_attach_def_default");
    def.queue_family = UINT32_MAX; // as the default is
    REFUSED(invalid, "4294967295");
#undef REFUSED
    absent = "vkCmdDispatch";
    FAILS(CRUMPLE_ERROR_UNSUPPORTED, absent, crumple_vulkan_attach(context, &good));
    absent = NULL;

    // Cached data of another driver, or cut short, is not used, and is no error.
    const unsigned char rubbish[40] = {32, 0, 0, 0, 1};
    def.pipeline_cache = rubbish;
    def.pipeline_cache_size = sizeof rubbish;
    OK(crumple_vulkan_attach(context, &def));
    FAILS(invalid, "attached already", crumple_vulkan_attach(context, &good));

    unsigned char *cache;
    size_t size = 0, again = 0;
    OK(crumple_vulkan_get_pipeline_cache(context, NULL, 0, &size));
    FACT(size >= 32 && (cache = (unsigned char *)malloc(size)) != NULL);
    FAILS(null, "out_size", crumple_vulkan_get_pipeline_cache(context, cache, size, NULL));
    FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "data", crumple_vulkan_get_pipeline_cache(context, cache, size - 1, &again));
    OK(crumple_vulkan_get_pipeline_cache(context, cache, size, &again));
    FACT(again == size && cache[0] == 32); // the length of a Vulkan pipeline cache's header
    OK(crumple_vulkan_detach(context));
    def.pipeline_cache = cache;
    def.pipeline_cache_size = size;
    OK(crumple_vulkan_attach(context, &def));
    free(cache);
}

static void buffers(void) {
    const CrumpleResult invalid = CRUMPLE_ERROR_INVALID_ARGUMENT, small = CRUMPLE_ERROR_BUFFER_TOO_SMALL;
    const CrumpleVulkanBufferDef good = buffer_def(&vertices);
    CrumpleVulkanBufferDef def = good;
    CrumpleBuffer buffer;
#define REFUSED(result, part)                                                                                          \
    do {                                                                                                               \
        FAILS_KEEPING(result, part, buffer, crumple_buffer_register_vulkan(context, body, &def, &buffer));             \
        def = good;                                                                                                    \
    } while (0)
    const CrumpleInstance nobody = {0};
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "def", crumple_buffer_register_vulkan(context, body, NULL, &buffer));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "out_buffer", crumple_buffer_register_vulkan(context, body, &good, NULL));
    FAILS(CRUMPLE_ERROR_INVALID_ID, "instance", crumple_buffer_register_vulkan(context, nobody, &good, &buffer));
    def.struct_size = 0;
    REFUSED(CRUMPLE_ERROR_STRUCT_SIZE, "crumple_vulkan_buffer_def_default");
    def.buffer = 0;
    REFUSED(invalid, "VkBuffer");
    def.buffer_size = 0;
    REFUSED(invalid, "size");
    def.lod = 3;
    REFUSED(CRUMPLE_ERROR_INDEX_OUT_OF_RANGE, "3");

    // A range and a stream that are too large, a format by its number, and a scale that is none.
    def.offset = UINT64_MAX - 3;
    REFUSED(small, "buffer");
    def.positions = (CrumpleVulkanStream){0, 0, 0, 0};
    REFUSED(invalid, "positions");
    def.tangents.offset = (uint64_t)1 << 40;
    REFUSED(small, "tangent");
    def.positions.format = VK_FORMAT_R32G32_SFLOAT;
    REFUSED(invalid, "R32G32_SFLOAT");
    def.positions.format = 123456789;
    REFUSED(invalid, "123456789");
    def.positions.format = VK_FORMAT_R16G16B16A16_SNORM;
    def.scale.z = NAN;
    REFUSED(CRUMPLE_ERROR_NOT_FINITE, "scale");
    def.bias.x = INFINITY;
    REFUSED(CRUMPLE_ERROR_NOT_FINITE, "bias");

    // Another description of the same VkBuffer.
    OK(crumple_buffer_register_vulkan(context, body, &good, &buffer));
    CrumpleBuffer other;
    def.usage |= VK_BUFFER_USAGE_INDEX_BUFFER_BIT;
    FAILS(invalid, "INDEX_BUFFER", crumple_buffer_register_vulkan(context, body, &def, &other));
    def = good;
    def.after_access = VK_ACCESS_INDEX_READ_BIT;
    FAILS(invalid, "INDEX_READ", crumple_buffer_register_vulkan(context, body, &def, &other));

#undef REFUSED

    // A Vulkan buffer is no host buffer, and the other way round.
    CrumpleHostBufferDef host_def = crumple_host_buffer_def_default();
    host_def.positions = stream_of(sheet.targets[0], sizeof sheet.targets[0], 0, 12);
    FAILS(invalid, "not a host buffer", crumple_buffer_set_memory(context, buffer, &host_def));
    uint32_t triangles = 0;
    FAILS(invalid, "buffer is not a host buffer", crumple_buffer_get_changed_triangles(context, buffer, NULL, 0, &triangles, NULL));
    FAILS(invalid, "buffers[0] is a Vulkan buffer", crumple_context_deform(context, &buffer, 1, NULL));
    OK(crumple_buffer_register_host(context, body, &host_def, &other));
    FAILS(invalid, "buffers[0] is a host buffer", crumple_vulkan_record(context, &host, 1, &other, 1, NULL));
    OK(crumple_buffer_unregister(context, other));
    OK(crumple_buffer_unregister(context, buffer));
    FAILS(CRUMPLE_ERROR_INVALID_ID, "buffer", crumple_buffer_unregister(context, buffer));
}

static void hit(float x, float y, float depth) {
    CrumpleHitDef def = displacement_at(x, y, depth);
    OK(crumple_instance_submit_hit(context, body, &def, NULL));
}

static void recordings(void) {
    const CrumpleResult invalid = CRUMPLE_ERROR_INVALID_ARGUMENT;
    const CrumpleVulkanBufferDef def = buffer_def(&vertices);
    CrumpleRecordReport report;
    CrumpleBuffer buffer, stale;
    OK(crumple_buffer_register_vulkan(context, body, &def, &stale));
    OK(crumple_buffer_unregister(context, stale));
    OK(crumple_buffer_register_vulkan(context, body, &def, &buffer));
    const CrumpleBuffer twice[2] = {buffer, buffer}, null = {0, 0, 0};
    hit(0, 0, 0.03f);

    VkCommandBuffer commands = host_begin(&host);
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "command_buffer", report,
                  crumple_vulkan_record(context, NULL, 1, NULL, 0, &report));
    FAILS_KEEPING(invalid, "frame is 0", report, crumple_vulkan_record(context, commands, 0, NULL, 0, &report));
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ID, "buffers[0]", report,
                  crumple_vulkan_record(context, commands, 1, &stale, 1, &report));
    FAILS(CRUMPLE_ERROR_INVALID_ID, "buffers[0]", crumple_vulkan_record(context, commands, 1, &null, 1, NULL));
    FAILS(invalid, "twice", crumple_vulkan_record(context, commands, 1, twice, 2, NULL));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "buffers", crumple_vulkan_record(context, commands, 1, NULL, 2, NULL));
    host_run(&host, commands);
    FACT(keeps(vertices.data, (size_t)vertices.size)); // nothing was recorded

    // After all that it works.
    report = run_frame(&host, context, 7);
    FACT(report.dispatches == 1 && report.blocks_skipped == 0);
    expect_vertices(&host, &vertices, context, body);

    // What was not submitted is written again, whole.
    hit(0.2f, 0.2f, 0.02f);
    OK(crumple_vulkan_complete_frames(context, 7));
    commands = host_begin(&host);
    FAILS(invalid, "frame is 7", crumple_vulkan_record(context, commands, 7, NULL, 0, NULL));
    OK(crumple_vulkan_record(context, commands, 8, NULL, 0, &report));
    FACT(report.dispatches == 1 && report.blocks_skipped > 0);
    OK(crumple_vulkan_discard_frames(context, 8));
    VK(vkResetCommandPool(host.device, host.pool, 0));
    report = run_frame(&host, context, 9);
    FACT(report.dispatches == 1 && report.blocks_skipped == 0);
    expect_vertices(&host, &vertices, context, body);

    // A frame in flight keeps the context and the device.
    FAILS(CRUMPLE_ERROR_FRAMES_IN_FLIGHT, "frame 9", crumple_context_destroy(context));
    FAILS(CRUMPLE_ERROR_FRAMES_IN_FLIGHT, "frame 9", crumple_vulkan_detach(context));
    OK(crumple_vulkan_complete_frames(context, 8));
    FAILS(CRUMPLE_ERROR_FRAMES_IN_FLIGHT, "frame 9", crumple_context_destroy(context));
    OK(crumple_vulkan_complete_frames(context, 9));
    OK(crumple_vulkan_record(context, &host, 10, NULL, 0, &report)); // nothing changed: nothing is touched
    FACT(report.blocks_written == 0 && report.dispatches == 0);
    OK(crumple_buffer_unregister(context, buffer));
}

// --- Two threads record at once.

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t changed = PTHREAD_COND_INITIALIZER;
static int inside, leave;

// Holds the recording thread up inside crumple_vulkan_record().
static void hold_up(VkCommandBuffer commands) {
    (void)commands;
    pthread_mutex_lock(&lock);
    inside = 1;
    pthread_cond_broadcast(&changed);
    while (!leave) pthread_cond_wait(&changed, &lock);
    pthread_mutex_unlock(&lock);
}

static void *record(void *commands) {
    OK(crumple_vulkan_record(context, commands, 20, NULL, 0, NULL));
    return NULL;
}

static void threads(void) {
    const CrumpleResult concurrent = CRUMPLE_ERROR_CONCURRENT_USE;
    const CrumpleVulkanBufferDef def = buffer_def(&vertices);
    CrumpleBuffer buffer;
    pthread_t other;
    OK(crumple_buffer_register_vulkan(context, body, &def, &buffer));
    VkCommandBuffer commands = host_begin(&host);
    dispatching = hold_up;
    FACT(pthread_create(&other, NULL, record, commands) == 0);
    pthread_mutex_lock(&lock);
    while (!inside) pthread_cond_wait(&changed, &lock);
    pthread_mutex_unlock(&lock);
    FAILS(concurrent, "crumple_vulkan_record", crumple_vulkan_record(context, commands, 21, NULL, 0, NULL));
    FAILS(concurrent, "crumple_vulkan_complete_frames", crumple_vulkan_complete_frames(context, 20));
    FAILS(concurrent, "crumple_vulkan_detach", crumple_vulkan_detach(context));
    FAILS(concurrent, "crumple_buffer_unregister", crumple_buffer_unregister(context, buffer));
    FAILS(concurrent, "crumple_context_destroy", crumple_context_destroy(context));
    hit(-0.2f, 0.1f, 0.025f); // hits may come at any time
    pthread_mutex_lock(&lock);
    leave = 1;
    pthread_cond_broadcast(&changed);
    pthread_mutex_unlock(&lock);
    pthread_join(other, NULL);
    dispatching = NULL;
    host_run(&host, commands);
    OK(crumple_vulkan_complete_frames(context, 20));
    run_frame(&host, context, 21);
    expect_vertices(&host, &vertices, context, body);
    OK(crumple_vulkan_complete_frames(context, 21));
}

int main(void) {
    CrumpleExampleSet set;
    host_open(&host);
    vertices = make_vertices(&host);
    make_sheet(&sheet);
    context = make_context(1);
    OK(crumple_example_set_create(context, &sheet.def, &set));
    body = make_instance(context, set);
    unattached();
    devices();
    buffers();
    recordings();
    threads();
    CrumpleContext *gone = context;
    OK(crumple_context_destroy(context));
    FAILS(CRUMPLE_ERROR_INVALID_ID, "context", crumple_vulkan_record(gone, &host, 30, NULL, 0, NULL));
    host_destroy_buffer(&host, &vertices);
    host_close(&host);
    printf("%u checks\n", checks);
    return 0;
}
