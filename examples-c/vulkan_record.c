// Crumple in a Vulkan renderer, from attaching your device to drawing the dented vertices.
//
// Your engine keeps its instance, device, queues, buffers and command buffers; vulkan_host.h stands for it here. Once a
// frame, outside a render pass, Crumple records into a command buffer that you are recording anyway: a small copy, a
// barrier, one dispatch per VkBuffer and a barrier. It submits nothing, waits for nothing, and never opens libvulkan.
//
//     CRUMPLE_VALIDATION=1 vulkan_record        runs under the Khronos validation layer
#include "vulkan_host.h"

#include <crumple_build.h>
#include <crumple_vulkan.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    SIDE = 65,
    VERTICES = SIDE * SIDE,
    INDICES = (SIDE - 1) * (SIDE - 1) * 6,
    NEIGHBOURS = 100, // vertices of other meshes, before and after ours in the same VkBuffer
    FRAMES = 8,
    FRAMES_IN_FLIGHT = 2
};

// Any struct works if its members start at multiples of 4 bytes. Crumple writes positions, normals and tangents at the offsets
// and in the formats that you give, and nothing between them. It does not touch uv.
typedef struct Vertex {
    float position[3], normal[3], uv[2];
} Vertex;

static Vertex uploaded[NEIGHBOURS + VERTICES + NEIGHBOURS];
static float dented[VERTICES][3];
static uint32_t indices[INDICES];

// A frame in flight: the CPU prepares one while the device works on another.
typedef struct Frame {
    uint64_t number; // 0: not used yet
    VkCommandBuffer commands;
    VkFence done;
    HostBuffer seen;           // the whole vertex buffer, read back
    float expected[VERTICES][6]; // position and normal, as the CPU computes them
} Frame;

static Frame frames[FRAMES_IN_FLIGHT];

#define CHECK(call) check((call), #call)
static void check(CrumpleResult result, const char *call) {
    if (result == CRUMPLE_OK) return;
    // An engine handles CRUMPLE_ERROR_DEVICE_LOST here. Damage is on the CPU and survives. Call
    // crumple_vulkan_complete_frames(context, UINT64_MAX) and crumple_vulkan_detach(), create a new VkDevice, attach it and
    // register the buffers again.
    fprintf(stderr, "%s: %s: %s\n", call, crumple_result_name(result), crumple_last_error());
    exit(1);
}

#define FACT(condition) fact((condition), #condition)
static void fact(bool holds, const char *what) {
    if (holds) return;
    fprintf(stderr, "this is not so: %s\n", what);
    exit(1);
}

// A sheet of 1 m by 1 m, and the same sheet with a dent of 5 cm in its middle.
static void make_mesh(void) {
    for (int v = 0; v < NEIGHBOURS + VERTICES + NEIGHBOURS; ++v)
        for (int k = 0; k < 3; ++k) uploaded[v].position[k] = uploaded[v].normal[k] = -77;
    for (int v = 0, i = 0; v < VERTICES; ++v) {
        const float u = (float)(v % SIDE) / (SIDE - 1), w = (float)(v / SIDE) / (SIDE - 1), x = u - 0.5f, y = w - 0.5f;
        const float r = (x * x + y * y) / 0.04f, depth = r < 1 ? 0.05f * (1 - r) * (1 - r) : 0;
        uploaded[NEIGHBOURS + v] = (Vertex){{x, y, 0}, {0, 0, 1}, {u, w}};
        dented[v][0] = x, dented[v][1] = y, dented[v][2] = -depth;
        if (v % SIDE < SIDE - 1 && v / SIDE < SIDE - 1) {
            const uint32_t a = (uint32_t)v, quad[6] = {a, a + 1, a + SIDE, a + SIDE, a + 1, a + SIDE + 1};
            for (int k = 0; k < 6; ++k) indices[i++] = quad[k];
        }
    }
}

static CrumpleExampleSet make_set(CrumpleContext *context) {
    const Vertex *vertices = uploaded + NEIGHBOURS;
    CrumpleExampleDef example = crumple_example_def_default();
    example.target_positions = (CrumpleInput){dented, sizeof dented, sizeof dented[0]};
    CrumpleMeshDef mesh = crumple_mesh_def_default();
    mesh.vertex_count = VERTICES;
    mesh.positions = (CrumpleInput){vertices->position, (VERTICES - 1) * sizeof(Vertex) + 12, sizeof(Vertex)};
    mesh.normals = (CrumpleInput){vertices->normal, (VERTICES - 1) * sizeof(Vertex) + 12, sizeof(Vertex)};
    mesh.index_count = INDICES;
    mesh.indices = (CrumpleInput){indices, sizeof indices, sizeof indices[0]};
    CrumpleExampleSetDef def = crumple_example_set_def_default();
    def.mesh = &mesh;
    def.examples = &example;
    def.example_count = 1;
    def.options.vertex_mass = 0.5f; // kg
    CrumpleExampleSet set;
    CHECK(crumple_example_set_create(context, &def, &set));
    return set;
}

// The engine's vertex buffer, in device-local memory, filled once by a copy. Crumple only requires
// VK_BUFFER_USAGE_STORAGE_BUFFER_BIT.
static HostBuffer make_vertex_buffer(const Host *host) {
    const VkBufferUsageFlags usage = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                     VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
    const VkBufferCopy all = {0, 0, sizeof uploaded};
    HostBuffer vertices = host_buffer(host, sizeof uploaded, usage, false);
    HostBuffer staging = host_buffer(host, sizeof uploaded, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, true);
    memcpy(staging.data, uploaded, sizeof uploaded);
    VkCommandBuffer commands = host_begin(host);
    vkCmdCopyBuffer(commands, staging.buffer, vertices.buffer, 1, &all);
    host_barrier(commands);
    host_run(host, commands);
    host_destroy_buffer(host, &staging);
    return vertices;
}

// A device that rounds as IEEE 754 requires gives the same bits as the CPU. Software drivers do. Other devices may round
// divisions differently, by a few units in the last place.
static bool same(const Host *host, const float *a, const float *b, int count) {
    if (host->software) return memcmp(a, b, (size_t)count * sizeof *a) == 0;
    for (int k = 0; k < count; ++k)
        if (!(fabsf(a[k] - b[k]) < 1e-5f)) return false;
    return true;
}

// Checks what a frame wrote to the vertex buffer.
static void look(const Host *host, const Frame *frame) {
    const Vertex *seen = (const Vertex *)frame->seen.data, *mesh = seen + NEIGHBOURS;
    for (int v = 0; v < VERTICES; ++v) {
        FACT(same(host, mesh[v].position, frame->expected[v], 3));
        FACT(same(host, mesh[v].normal, frame->expected[v] + 3, 3));
        FACT(memcmp(mesh[v].uv, uploaded[NEIGHBOURS + v].uv, sizeof mesh[v].uv) == 0);
    }
    FACT(memcmp(seen, uploaded, NEIGHBOURS * sizeof *seen) == 0);
    FACT(memcmp(mesh + VERTICES, uploaded + NEIGHBOURS + VERTICES, NEIGHBOURS * sizeof *seen) == 0);
}

int main(void) {
    Host host;
    host_open(&host);
    make_mesh();
    HostBuffer vertices = make_vertex_buffer(&host);

    // 1. Load as you would without a GPU: a context, an example set, a body in the scene.
    CrumpleContextDef context_def = crumple_context_def_default();
    CrumpleContext *context;
    CHECK(crumple_context_create(&context_def, &context));
    const CrumpleExampleSet set = make_set(context);
    CrumpleInstanceDef instance_def = crumple_instance_def_default();
    instance_def.set = set;
    CrumpleInstance body, twin; // the twin takes the same hits and is deformed on the CPU, for comparison
    CHECK(crumple_instance_create(context, &instance_def, &body));
    CHECK(crumple_instance_create(context, &instance_def, &twin));

    // 2. Attach your device: Vulkan 1.1, no extensions, no features. Registering buffers creates a few pipelines. That is faster
    // if vulkan.pipeline_cache has the data that crumple_vulkan_get_pipeline_cache() returned in an earlier run.
    CrumpleVulkanAttachDef vulkan = crumple_vulkan_attach_def_default();
    vulkan.get_instance_proc_addr = (CrumpleVulkanFunction)vkGetInstanceProcAddr; // or volk's, or SDL's
    vulkan.instance = host.instance;
    vulkan.physical_device = host.physical_device;
    vulkan.device = host.device;
    vulkan.queue_family = host.queue_family; // the family of the queue that you submit the command buffers to
    CHECK(crumple_vulkan_attach(context, &vulkan));

    // 3. Register the range with the body's vertices, with one call per body. Bodies may share one VkBuffer: a frame's changes
    // to all of them are then one dispatch. You own the VkBuffer; destroy it after the frames that used it are complete.
    CrumpleVulkanBufferDef def = crumple_vulkan_buffer_def_default();
    def.buffer = (uint64_t)vertices.buffer;
    def.buffer_size = vertices.size;
    def.usage = vertices.usage;
    def.offset = NEIGHBOURS * sizeof(Vertex);
    def.size = VERTICES * sizeof(Vertex);
    def.positions = (CrumpleVulkanStream){offsetof(Vertex, position), sizeof(Vertex), VK_FORMAT_R32G32B32_SFLOAT, 0};
    def.normals = (CrumpleVulkanStream){offsetof(Vertex, normal), sizeof(Vertex), VK_FORMAT_R32G32B32_SFLOAT, 0};
    // The stages and accesses that use the buffer before and after Crumple writes it. Crumple's two barriers use them. The
    // default for both is the vertex input of your draws. Here, a copy at the end of every frame also reads the buffer.
    def.before_stages |= VK_PIPELINE_STAGE_TRANSFER_BIT;
    def.before_access |= VK_ACCESS_TRANSFER_READ_BIT;
    def.after_stages |= VK_PIPELINE_STAGE_TRANSFER_BIT;
    def.after_access |= VK_ACCESS_TRANSFER_READ_BIT;
    CrumpleBuffer buffer;
    CHECK(crumple_buffer_register_vulkan(context, body, &def, &buffer));

    static float on_cpu[VERTICES][6];
    CrumpleHostBufferDef host_def = crumple_host_buffer_def_default();
    host_def.positions = (CrumpleStream){on_cpu, sizeof on_cpu, 0, sizeof on_cpu[0]};
    host_def.normals = (CrumpleStream){on_cpu, sizeof on_cpu, 12, sizeof on_cpu[0]};
    CrumpleBuffer on_cpu_buffer;
    CHECK(crumple_buffer_register_host(context, twin, &host_def, &on_cpu_buffer));

    for (Frame *frame = frames; frame < frames + FRAMES_IN_FLIGHT; ++frame) {
        const VkFenceCreateInfo fence = {VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, NULL, 0};
        const VkCommandBufferAllocateInfo info = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, NULL, host.pool,
                                                  VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
        VK(vkCreateFence(host.device, &fence, NULL, &frame->done));
        VK(vkAllocateCommandBuffers(host.device, &info, &frame->commands));
        frame->seen = host_buffer(&host, vertices.size, VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);
    }

    // 4. The frame loop. Number your frames from 1; numbers never decrease.
    for (uint64_t number = 1; number <= FRAMES; ++number) {
        Frame *frame = &frames[number % FRAMES_IN_FLIGHT];

        // Like every renderer, wait until the device is done with the frame that last used this slot. Then tell Crumple, which
        // keeps a small buffer for each frame in flight and can now reuse that one.
        if (frame->number != 0) {
            VK(vkWaitForFences(host.device, 1, &frame->done, VK_TRUE, UINT64_MAX));
            VK(vkResetFences(host.device, 1, &frame->done));
            CHECK(crumple_vulkan_complete_frames(context, frame->number));
            look(&host, frame);
        }
        frame->number = number;

        // Your physics engine may report contacts at any time and from any thread. Here: 1.5 N s downwards in frames 3 and 6.
        const bool hit_now = number == 3 || number == 6;
        if (hit_now) {
            CrumpleHitDef hit = crumple_hit_def_default();
            hit.point = (CrumpleVec3){number == 3 ? 0.2f : -0.15f, 0.1f, 0};
            hit.impulse = (CrumpleVec3){0, 0, -1.5f};
            hit.duration = 0.01f;
            CHECK(crumple_instance_submit_hit(context, body, &hit, NULL));
            CHECK(crumple_instance_submit_hit(context, twin, &hit, NULL));
        }

        const VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, NULL,
                                                VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT, NULL};
        VK(vkBeginCommandBuffer(frame->commands, &begin));

        // Null and 0: all registered Vulkan buffers. A secondary command buffer also works. If nothing was hit, nothing is
        // recorded. Afterwards bind your own compute pipeline again: the compute state has changed.
        CrumpleRecordReport report;
        CHECK(crumple_vulkan_record(context, frame->commands, number, NULL, 0, &report));
        FACT(report.dispatches == (number == 1 || hit_now ? 1 : 0));
        FACT(number != 1 || (report.vertices_written == VERTICES && report.blocks_skipped == 0));
        FACT(!hit_now || (report.blocks_written > 0 && report.blocks_skipped > 0));

        // Here you would begin your render pass and draw from the buffer (vulkan_render.cpp does). This program copies.
        const VkBufferCopy all = {0, 0, vertices.size};
        vkCmdCopyBuffer(frame->commands, vertices.buffer, frame->seen.buffer, 1, &all);
        const VkMemoryBarrier to_cpu = {VK_STRUCTURE_TYPE_MEMORY_BARRIER, NULL, VK_ACCESS_TRANSFER_WRITE_BIT,
                                        VK_ACCESS_HOST_READ_BIT};
        vkCmdPipelineBarrier(frame->commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &to_cpu, 0,
                             NULL, 0, NULL);
        VK(vkEndCommandBuffer(frame->commands));
        const VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO, NULL, 0, NULL, NULL, 1, &frame->commands, 0, NULL};
        VK(vkQueueSubmit(host.queue, 1, &submit, frame->done));

        // The same on the CPU. crumple_context_deform() writes only host buffers, crumple_vulkan_record() only Vulkan buffers.
        CHECK(crumple_context_deform(context, NULL, 0, NULL));
        memcpy(frame->expected, on_cpu, sizeof on_cpu);
    }

    // 5. Shut down in this order: wait for the device, tell Crumple, destroy the context, then the buffers and the device.
    VK(vkDeviceWaitIdle(host.device));
    CHECK(crumple_vulkan_complete_frames(context, FRAMES));
    for (Frame *frame = frames; frame < frames + FRAMES_IN_FLIGHT; ++frame) look(&host, frame);
    float deepest = 0;
    for (int v = 0; v < VERTICES; ++v) deepest = fminf(deepest, on_cpu[v][2]);
    FACT(deepest < -0.025f && deepest > -0.035f); // 1.5 N s * 10 ms / 0.5 kg = 30 mm
    size_t cache_size;
    CHECK(crumple_vulkan_get_pipeline_cache(context, NULL, 0, &cache_size));
    printf("%s: %d frames, deepest %.1f mm, %d vertices as on the CPU; %zu bytes of pipeline cache\n", host.name, FRAMES,
           -1000 * deepest, VERTICES, cache_size);
    CHECK(crumple_context_destroy(context));
    for (Frame *frame = frames; frame < frames + FRAMES_IN_FLIGHT; ++frame) {
        vkDestroyFence(host.device, frame->done, NULL);
        host_destroy_buffer(&host, &frame->seen);
    }
    host_destroy_buffer(&host, &vertices);
    host_close(&host);
    return 0;
}
