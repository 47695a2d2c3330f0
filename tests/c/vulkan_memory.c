// A recording without changes allocates nothing, and what recordings allocate is freed. The vertices are those of
// crumple_context_deform().
#include "heap.h"
#include "vulkan_support.h"

static Heap heap;

enum { BODIES = 300, HITS = 4, BODY = VERTICES * 12 };

static CrumpleContext *context;
static CrumpleInstance bodies[BODIES];
static HostBuffer vertices;
static float wanted[BODIES][VERTICES][3];
static CrumpleBuffer on_host[BODIES];

static CrumpleResult register_body(int i) {
    CrumpleVulkanBufferDef def = buffer_def(&vertices);
    CrumpleBuffer buffer;
    def.offset = (uint64_t)i * BODY;
    def.size = BODY;
    def.positions = vulkan_stream(0, VK_FORMAT_R32G32B32_SFLOAT);
    def.positions.stride = 12;
    memset(&def.normals, 0, sizeof def.normals);
    memset(&def.tangents, 0, sizeof def.tangents);
    return crumple_buffer_register_vulkan(context, bodies[i], &def, &buffer);
}

int main(void) {
    Host host;
    CrumpleExampleSet set;
    if (!use_heap(&heap)) {
        printf("this build has no host allocator\n");
        return 0;
    }
    host_open(&host);
    make_sheet(&sheet);
    context = make_context(1);
    OK(crumple_example_set_create(context, &sheet.def, &set));
    for (int i = 0; i < BODIES; ++i) {
        bodies[i] = make_instance(context, set);
        on_host[i] = make_buffer(context, bodies[i], host_def(wanted[i], VERTICES, 3));
    }
    vertices = host_buffer(&host, BODIES * BODY, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, true);

    const CrumpleVulkanAttachDef attach = vulkan_def(&host);
    OK(crumple_vulkan_attach(context, &attach));
    for (int i = 0; i < BODIES; ++i) OK(register_body(i));
    for (uint64_t frame = 1; frame <= HITS; ++frame) {
        // The first recording writes every vertex. The others write what more and more hits changed.
        for (int i = 0; i < BODIES && frame > 1; ++i) {
            const CrumpleHitDef def = random_displacement();
            OK(crumple_instance_submit_hit(context, bodies[i], &def, NULL));
        }
        VkCommandBuffer commands = host_begin(&host);
        OK(crumple_vulkan_record(context, commands, frame, NULL, 0, NULL));
        host_run(&host, commands);
        OK(crumple_context_deform(context, on_host, BODIES, NULL));
        if (host.software) FACT(memcmp(vertices.data, wanted, sizeof wanted) == 0);
        // A frame without changes needs no memory.
        commands = host_begin(&host);
        const unsigned long calls = heap.calls;
        OK(crumple_vulkan_record(context, commands, frame, NULL, 0, NULL));
        FACT(heap.calls == calls);
        host_run(&host, commands);
        OK(crumple_vulkan_complete_frames(context, frame));
    }
    OK(crumple_context_destroy(context));
    FACT(heap.blocks == 0);
    host_destroy_buffer(&host, &vertices);
    host_close(&host);
    printf("%u checks\n", checks);
    return 0;
}
