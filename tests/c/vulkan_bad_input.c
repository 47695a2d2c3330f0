// Whatever an engine hands to the Vulkan calls by mistake gets an error that names it, changes nothing, and all goes on. Layouts of
// buffers that are refused are in tests/gpu/refusals.rs, other devices and recordings in tests/vulkan/errors.rs. Recordings without changes allocate nothing, and nothing is left behind.
#include "heap.h"
#include "vulkan_support.h"

#include <crumple_parts.h>

static Heap heap;
static Host host;
static CrumpleContext *context;
static CrumpleInstance body;
static HostBuffer vertices;

static const CrumpleResult INVALID = CRUMPLE_ERROR_INVALID_ARGUMENT, NULL_POINTER = CRUMPLE_ERROR_NULL_POINTER;

static void unattached(void) {
    CrumpleVulkanBufferDef def = buffer_def(&vertices);
    CrumpleBuffer buffer;
    size_t size;
    const char *why = "no Vulkan device is attached; crumple_vulkan_attach()";
    FAILS(INVALID, why, crumple_buffer_register_vulkan(context, body, &def, &buffer));
    FAILS(INVALID, why, crumple_vulkan_record(context, &host, 1, NULL, 0, NULL));
    FAILS(INVALID, why, crumple_vulkan_complete_frames(context, 1));
    FAILS(INVALID, why, crumple_vulkan_discard_frames(context, 1));
    FAILS(INVALID, why, crumple_vulkan_get_pipeline_cache(context, NULL, 0, &size));
    FAILS(INVALID, why, crumple_vulkan_detach(context));
}

static void devices(void) {
    const CrumpleVulkanAttachDef good = vulkan_def(&host);
    CrumpleVulkanAttachDef def;
    FAILS(NULL_POINTER, "context", crumple_vulkan_attach(NULL, &good));
    FAILS(NULL_POINTER, "def", crumple_vulkan_attach(context, NULL));
#define REFUSED(result, part, change)                                                                                  \
    do {                                                                                                               \
        def = good;                                                                                                    \
        change;                                                                                                        \
        FAILS(result, part, crumple_vulkan_attach(context, &def));                                                     \
    } while (0)
    REFUSED(NULL_POINTER, "def.", def = crumple_vulkan_attach_def_default());
    REFUSED(NULL_POINTER, "def.get_instance_proc_addr", def.get_instance_proc_addr = NULL);
    REFUSED(NULL_POINTER, "def.pipeline_cache", def.pipeline_cache_size = 8);
    REFUSED(CRUMPLE_ERROR_STRUCT_SIZE, "crumple_vulkan_attach_def_default", def.struct_size -= 4);
#undef REFUSED

    OK(crumple_vulkan_attach(context, &good));
    FAILS(INVALID, "attached already", crumple_vulkan_attach(context, &good));
    unsigned char *cache;
    size_t size = 0, again = 0;
    OK(crumple_vulkan_get_pipeline_cache(context, NULL, 0, &size));
    FACT(size >= 32 && (cache = (unsigned char *)malloc(size)) != NULL);
    FAILS(NULL_POINTER, "out_size", crumple_vulkan_get_pipeline_cache(context, cache, size, NULL));
    FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "data", crumple_vulkan_get_pipeline_cache(context, cache, size - 1, &again));
    OK(crumple_vulkan_get_pipeline_cache(context, cache, size, &again));
    FACT(again == size && cache[0] == 32); // the length of a Vulkan pipeline cache's header
    OK(crumple_vulkan_detach(context));
    def = good;
    def.pipeline_cache = cache;
    def.pipeline_cache_size = size;
    OK(crumple_vulkan_attach(context, &def));
    free(cache);
}

static void buffers(void) {
    const CrumpleVulkanBufferDef good = buffer_def(&vertices);
    CrumpleVulkanBufferDef def;
    CrumpleBuffer buffer, other;
    const CrumpleInstance nobody = {0};
    FAILS(NULL_POINTER, "def", crumple_buffer_register_vulkan(context, body, NULL, &buffer));
    FAILS(NULL_POINTER, "out_buffer", crumple_buffer_register_vulkan(context, body, &good, NULL));
    FAILS(CRUMPLE_ERROR_INVALID_ID, "instance", crumple_buffer_register_vulkan(context, nobody, &good, &buffer));
#define REFUSED(result, part, change)                                                                                  \
    do {                                                                                                               \
        def = good;                                                                                                    \
        change;                                                                                                        \
        FAILS_KEEPING(result, part, other, crumple_buffer_register_vulkan(context, body, &def, &other));               \
    } while (0)
    REFUSED(CRUMPLE_ERROR_STRUCT_SIZE, "crumple_vulkan_buffer_def_default", def.struct_size = 0);
    REFUSED(INVALID, "positions", memset(&def.positions, 0, sizeof def.positions));
    REFUSED(INVALID, "123456789", def.positions.format = 123456789);
    REFUSED(CRUMPLE_ERROR_NOT_FINITE, "scale", def.scale.z = NAN);
    REFUSED(CRUMPLE_ERROR_NOT_FINITE, "bias", def.bias.x = INFINITY);
    // Another description of the same VkBuffer.
    OK(crumple_buffer_register_vulkan(context, body, &good, &buffer));
    REFUSED(INVALID, "INDEX_BUFFER", def.usage |= VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
    REFUSED(INVALID, "INDEX_READ", def.after_access = VK_ACCESS_INDEX_READ_BIT);
#undef REFUSED

    // A Vulkan buffer is no host buffer, and the other way round.
    CrumpleHostBufferDef host_memory = host_def(sheet.targets[0], VERTICES, 3);
    uint32_t triangles = 0;
    FAILS(INVALID, "not a host buffer", crumple_buffer_set_memory(context, buffer, &host_memory));
    FAILS(INVALID, "buffer is not a host buffer", crumple_buffer_get_changed_triangles(context, buffer, NULL, 0, &triangles, NULL));
    FAILS(INVALID, "buffers[0] is a Vulkan buffer", crumple_context_deform(context, &buffer, 1, NULL));
    other = make_buffer(context, body, host_memory);
    FAILS(INVALID, "buffers[0] is a host buffer", crumple_vulkan_record(context, &host, 1, &other, 1, NULL));
    OK(crumple_buffer_unregister(context, other));
    OK(crumple_buffer_unregister(context, buffer));
    FAILS(CRUMPLE_ERROR_INVALID_ID, "buffer", crumple_buffer_unregister(context, buffer));
}

static void recordings(void) {
    const CrumpleVulkanBufferDef def = buffer_def(&vertices);
    CrumpleRecordReport report;
    CrumpleBuffer buffer;
    OK(crumple_buffer_register_vulkan(context, body, &def, &buffer));
    const CrumpleBuffer twice[2] = {buffer, buffer}, null = {0, 0, 0};
    CrumpleHitDef hit = displacement_at(0, 0, 0.03f);
    OK(crumple_instance_submit_hit(context, body, &hit, NULL));
    VkCommandBuffer commands = host_begin(&host);
    FAILS_KEEPING(NULL_POINTER, "command_buffer", report, crumple_vulkan_record(context, NULL, 1, NULL, 0, &report));
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ID, "buffers[0]", report, crumple_vulkan_record(context, commands, 1, &null, 1, &report));
    FAILS(INVALID, "twice", crumple_vulkan_record(context, commands, 1, twice, 2, NULL));
    FAILS(NULL_POINTER, "buffers", crumple_vulkan_record(context, commands, 1, NULL, 2, NULL));
    host_run(&host, commands);
    FACT(keeps(vertices.data, (size_t)vertices.size)); // nothing was recorded
    report = run_frame(&host, context, 7);
    FACT(report.dispatches == 1 && report.blocks_skipped == 0);
    expect_vertices(&host, &vertices, context, body);

    // What was not submitted is written again, whole.
    OK(crumple_instance_submit_hit(context, body, &hit, NULL));
    OK(crumple_vulkan_complete_frames(context, 7));
    commands = host_begin(&host);
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
    const unsigned long calls = heap.calls;
    OK(crumple_vulkan_record(context, &host, 10, NULL, 0, &report)); // nothing changed: nothing is touched or allocated
    FACT(report.blocks_written == 0 && report.dispatches == 0 && heap.calls == calls);
    OK(crumple_buffer_unregister(context, buffer));
}

// --- Shared memory needs a device of Crumple's own, which takes no frames of the host. vulkan_faults.c writes it and waits.

#ifdef SHARES_FILE_DESCRIPTORS
#include <fcntl.h>

// A semaphore of the host's; id is that of Crumple's device which is the same.
static VkSemaphore make_semaphore(uint64_t *id) {
    const VkExternalSemaphoreHandleTypeFlagBits type = VK_EXTERNAL_SEMAPHORE_HANDLE_TYPE_OPAQUE_FD_BIT;
    const VkExportSemaphoreCreateInfo export = {.sType = VK_STRUCTURE_TYPE_EXPORT_SEMAPHORE_CREATE_INFO, .handleTypes = type};
    const VkSemaphoreCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, .pNext = &export};
    const PFN_vkGetSemaphoreFdKHR get = (PFN_vkGetSemaphoreFdKHR)vkGetDeviceProcAddr(host.device, "vkGetSemaphoreFdKHR");
    VkSemaphoreGetFdInfoKHR which = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_GET_FD_INFO_KHR, .handleType = type};
    int fd = -1;
    VK(vkCreateSemaphore(host.device, &info, NULL, &which.semaphore));
    VK(get(host.device, &which, &fd));
    OK(crumple_vulkan_import_semaphore(context, CRUMPLE_HANDLE_TYPE_OPAQUE_FD, fd, id));
    FACT(close(fd) == 0); // which is still the host's
    return which.semaphore;
}

// The host signals, Crumple waits and signals, the host waits.
static void written_between_semaphores(const HostBuffer *exported) {
    uint64_t ready_id, done_id, frame;
    const VkSemaphore ready = make_semaphore(&ready_id), done = make_semaphore(&done_id);
    const VkPipelineStageFlags stages = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    const VkSubmitInfo before = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .signalSemaphoreCount = 1, .pSignalSemaphores = &ready};
    const VkSubmitInfo after = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .waitSemaphoreCount = 1, .pWaitSemaphores = &done, .pWaitDstStageMask = &stages};
    for (int round = 0; round < 3; ++round) {
        const CrumpleHitDef hit = displacement_at(0.1f * (float)round, 0.1f, 0.03f);
        OK(crumple_instance_submit_hit(context, body, &hit, NULL));
        VK(vkQueueSubmit(host.queue, 1, &before, VK_NULL_HANDLE));
        OK(crumple_vulkan_submit(context, NULL, 0, &ready_id, 1, &done_id, 1, &frame, NULL));
        VK(vkQueueSubmit(host.queue, 1, &after, VK_NULL_HANDLE));
        VK(vkQueueWaitIdle(host.queue)); // the host's queue alone
        expect_vertices(&host, exported, context, body);
    }
    bool is_done = false;
    OK(crumple_vulkan_wait_frame(context, frame, UINT64_MAX, &is_done));
    FACT(is_done);
    vkDestroySemaphore(host.device, ready, NULL);
    vkDestroySemaphore(host.device, done, NULL);
}

static void shared_memory(void) {
    const char *opens = "crumple_vulkan_open", *attach = "crumple_vulkan_attach";
    CrumpleVulkanOpenDef own = crumple_vulkan_open_def_default();
    CrumpleVulkanAttachDef theirs = vulkan_def(&host);
    CrumpleVulkanImportDef import, bad;
    CrumpleBuffer buffer;
    uint64_t imported, frame, semaphore = 7;
    bool done = false;
    HostBuffer exported = make_exported(&host, false, &import);
    FAILS_KEEPING(INVALID, opens, imported, crumple_vulkan_import_buffer(context, &import, &imported));
    FAILS_KEEPING(INVALID, opens, frame, crumple_vulkan_submit(context, NULL, 0, NULL, 0, NULL, 0, &frame, NULL));
    OK(crumple_vulkan_attach(context, &theirs));
    FAILS_KEEPING(INVALID, opens, imported, crumple_vulkan_import_buffer(context, &import, &imported));
    FAILS_KEEPING(INVALID, opens, done, crumple_vulkan_wait_frame(context, 0, 0, &done));
    FAILS(INVALID, "attached already", crumple_vulkan_open(context, &own));
    OK(crumple_vulkan_detach(context));
    FAILS(NULL_POINTER, "get_instance_proc_addr", crumple_vulkan_open(context, &own));
    own.get_instance_proc_addr = (CrumpleVulkanFunction)vkGetInstanceProcAddr;
    memset(own.device_uuid, 0xEE, sizeof own.device_uuid);
    FAILS(CRUMPLE_ERROR_UNSUPPORTED, host.name, crumple_vulkan_open(context, &own));
    device_uuid(&host, own.device_uuid);
    own.workgroup_size = 64;
    OK(crumple_vulkan_open(context, &own));
    FAILS(INVALID, "attached already", crumple_vulkan_attach(context, &theirs));

#define REFUSED(result, part, change)                                                                                  \
    do {                                                                                                               \
        bad = import;                                                                                                  \
        change;                                                                                                        \
        FAILS_KEEPING(result, part, imported, crumple_vulkan_import_buffer(context, &bad, &imported));                 \
    } while (0)
    int pipes[2];
    const int root = open("/", O_RDONLY), small = open("/proc/self/cmdline", O_RDONLY);
    FACT(pipe(pipes) == 0 && root >= 0 && small >= 0);
    REFUSED(INVALID, "open file descriptor", bad.handle = 1LL << 40);
    REFUSED(INVALID, "open file descriptor", bad.handle = -1);
    REFUSED(INVALID, "pipe", bad.handle = pipes[0]);
    REFUSED(INVALID, "folder", bad.handle = root);
    REFUSED(INVALID, "a file of", bad.handle = small);
    REFUSED(CRUMPLE_ERROR_UNSUPPORTED, "file descriptors", bad.handle_type = CRUMPLE_HANDLE_TYPE_OPAQUE_WIN32);
    REFUSED(INVALID, "memory type", bad.memory_type = 31);
    REFUSED(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "imported memory", bad.size = UINT64_MAX);
    REFUSED(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "imported memory", bad.offset = bad.memory_size);
    REFUSED(CRUMPLE_ERROR_MISALIGNED, "offset", bad.offset = 1);
    REFUSED(INVALID, "size", bad.size = 0);
    REFUSED(INVALID, "STORAGE_BUFFER", bad.usage = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
#undef REFUSED
    close(pipes[0]), close(pipes[1]), close(root), close(small);
    FAILS(NULL_POINTER, "out_semaphore", crumple_vulkan_import_semaphore(context, CRUMPLE_HANDLE_TYPE_OPAQUE_FD, -1, NULL));
    // -1 is none, and some drivers have no external semaphores at all.
    FACT(crumple_vulkan_import_semaphore(context, CRUMPLE_HANDLE_TYPE_OPAQUE_FD, -1, &semaphore) != CRUMPLE_OK && semaphore == 7);
    CrumpleVulkanBufferDef def = buffer_def(&exported);
    FAILS_KEEPING(INVALID, "crumple_vulkan_import_buffer", buffer, crumple_buffer_register_vulkan(context, body, &def, &buffer));
    OK(crumple_vulkan_import_buffer(context, &import, &imported));
    def.buffer = imported;
    def.usage = 0; // not looked at
    OK(crumple_buffer_register_vulkan(context, body, &def, &buffer));
    FAILS(INVALID, "1 ranges", crumple_vulkan_unimport_buffer(context, imported));
    FAILS(INVALID, attach, crumple_vulkan_complete_frames(context, 1));
    FAILS(INVALID, attach, crumple_vulkan_record(context, &host, 1, NULL, 0, NULL));
    FAILS_KEEPING(INVALID, "semaphore is 99", frame, crumple_vulkan_submit(context, NULL, 0, (uint64_t[]){99}, 1, NULL, 0, &frame, NULL));
    FAILS(INVALID, "frame is 9", crumple_vulkan_wait_frame(context, 9, 0, &done));

    pass(&host, &exported, false);
    if (exports_semaphores(&host)) written_between_semaphores(&exported);
    OK(crumple_buffer_unregister(context, buffer));
    OK(crumple_vulkan_unimport_buffer(context, imported));
    FAILS(INVALID, "buffer is", crumple_vulkan_unimport_buffer(context, imported));
    OK(crumple_vulkan_import_buffer(context, &import, &imported)); // left to the end of the context
    FACT(close((int)import.handle) == 0); // which is still the host's
    host_destroy_buffer(&host, &exported);
}
#endif

int main(void) {
    CrumpleExampleSet set;
    const bool counts = use_heap(&heap);
    host_open(&host);
#ifdef SHARES_FILE_DESCRIPTORS
    open_exporting_device(&host);
#endif
    vertices = make_vertices(&host);
    make_sheet(&sheet);
    context = make_context(1);
    OK(crumple_example_set_create(context, &sheet.def, &set));
    body = make_instance(context, set);
    unattached();
    devices();
    buffers();
    recordings();
    OK(crumple_vulkan_detach(context));
#ifdef SHARES_FILE_DESCRIPTORS
    shared_memory();
#endif
    CrumpleContext *gone = context;
    OK(crumple_context_destroy(context));
    FAILS(CRUMPLE_ERROR_INVALID_ID, "context", crumple_vulkan_record(gone, &host, 30, NULL, 0, NULL));
    FACT(!counts || (heap.calls > 0 && heap.blocks == 0));
    host_destroy_buffer(&host, &vertices);
    host_close(&host);
    printf("%u checks\n", checks);
    return 0;
}
