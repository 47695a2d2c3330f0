// How long recording takes on the CPU, one thread on one core: the median, the tail and the longest of very many.
//
//   vulkan_times [FRAMES]
//
// `cargo xtask soak --frames N` runs it with an optimised library. Recordings are thrown away: the device would take most of the time,
// and a software driver the caches too. Crumple does not see it.
#include "times.h"
#include "vulkan_support.h"

enum { BODIES = 16, WARM_UP = 3000, IN_FLIGHT = 2 };

int main(int argc, char **argv) {
    static Call hit = {.name = "hit"}, frame = {.name = "recording after a hit"}, idle = {.name = "recording without hits"};
    const unsigned long long frames = argc > 1 ? strtoull(argv[1], NULL, 10) : 1000, warm_up = frames < WARM_UP ? frames : WARM_UP;
    FACT(frames > 0);
    Host host;
    host_open(&host);
    make_sheet(&sheet);
    CrumpleContext *context = make_context(1);
    const CrumpleVulkanAttachDef attach = vulkan_def(&host);
    OK(crumple_vulkan_attach(context, &attach));
    CrumpleExampleSet set;
    CrumpleInstance bodies[BODIES];
    HostBuffer vertices[BODIES];
    OK(crumple_example_set_create(context, &sheet.def, &set));
    for (int i = 0; i < BODIES; ++i) {
        bodies[i] = make_instance(context, set);
        vertices[i] = make_vertices(&host);
        const CrumpleVulkanBufferDef def = buffer_def(&vertices[i]);
        CrumpleBuffer buffer;
        OK(crumple_buffer_register_vulkan(context, bodies[i], &def, &buffer));
    }
    uint64_t number = 1;
    run_frame(&host, context, number);
    const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    VkCommandBuffer commands = host_begin(&host);
    for (unsigned long long i = 0; i < warm_up + frames; ++i) {
        if (i == warm_up) start_measuring(&hit), start_measuring(&frame), start_measuring(&idle);
        const CrumpleInstance body = bodies[dice(BODIES)];
        const CrumpleHitDef def = random_displacement();
        CrumpleRecordReport report;
        begin_call(&hit);
        OK(crumple_instance_submit_hit(context, body, &def, NULL));
        end_call(&hit);
        ++number;
        if (number > IN_FLIGHT) OK(crumple_vulkan_complete_frames(context, number - IN_FLIGHT));
        begin_call(&frame);
        OK(crumple_vulkan_record(context, commands, number, NULL, 0, &report));
        end_call(&frame);
        begin_call(&idle);
        OK(crumple_vulkan_record(context, commands, number, NULL, 0, &report));
        end_call(&idle);
        VK(vkEndCommandBuffer(commands));
        VK(vkBeginCommandBuffer(commands, &begin)); // forgets what was recorded
        if (dice(2000) == 0) OK(crumple_instance_reset_damage(context, body));
    }
    VK(vkEndCommandBuffer(commands));
    printf("Vulkan on %s: %d bodies of %d vertices, frames: %llu\n\n", host.name, BODIES, VERTICES, frames);
    print_calls((const Call *const[]){&hit, &frame, &idle}, 3);
    OK(crumple_vulkan_complete_frames(context, UINT64_MAX));
    OK(crumple_context_destroy(context));
    for (int i = 0; i < BODIES; ++i) host_destroy_buffer(&host, &vertices[i]);
    host_close(&host);
    return 0;
}
