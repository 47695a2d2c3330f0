// The device is lost while a frame is recorded: an error says so, damage survives, and another device gets the same vertices as if
// nothing had been. vulkan_faults.c loses it in every call.
#include "vulkan_support.h"

enum { HITS = 12 };

static void hit(CrumpleContext *context, CrumpleInstance body, int i) {
    CrumpleHitDef def =
        displacement_at((float)(i * 37 % 101) / 101 - 0.5f, (float)(i * 61 % 103) / 103 - 0.5f, 0.02f);
    OK(crumple_instance_submit_hit(context, body, &def, NULL));
}

int main(void) {
    CrumpleContext *context = make_context(1);
    CrumpleExampleSet set;
    CrumpleBuffer buffer, stale;
    CrumpleMark marks[HITS], after[HITS];
    CrumpleRecordReport report;
    uint32_t count, count_after;
    Host host;
    host_open(&host);
    make_sheet(&sheet);
    OK(crumple_example_set_create(context, &sheet.def, &set));
    CrumpleInstance body = make_instance(context, set);
    HostBuffer vertices = make_vertices(&host);
    CrumpleVulkanAttachDef vulkan = vulkan_def(&host);
    CrumpleVulkanBufferDef def = buffer_def(&vertices);
    for (int i = 0; i < HITS / 2; ++i) hit(context, body, i);
    OK(crumple_vulkan_attach(context, &vulkan));

    OK(crumple_buffer_register_vulkan(context, body, &def, &buffer));
    run_frame(&host, context, 1);
    expect_vertices(&host, &vertices, context, body);

    // Lost while recording the second frame, which needs memory of its own, since the first is in flight.
    for (int i = HITS / 2; i < HITS; ++i) hit(context, body, i);
    VkCommandBuffer commands = host_begin(&host);
    lost_in = "vkCreateBuffer";
    FAILS_KEEPING(CRUMPLE_ERROR_DEVICE_LOST, lost_in, report,
                  crumple_vulkan_record(context, commands, 2, NULL, 0, &report));
    OK(crumple_instance_get_marks(context, body, marks, HITS, &count));
    FACT(count == HITS);

    // What is documented: a lost device runs nothing any more; let go of it, and take another.
    FAILS(CRUMPLE_ERROR_FRAMES_IN_FLIGHT, "frame 1", crumple_vulkan_detach(context));
    OK(crumple_vulkan_complete_frames(context, UINT64_MAX));
    OK(crumple_vulkan_detach(context));
    FAILS(CRUMPLE_ERROR_INVALID_ID, "buffer", crumple_buffer_unregister(context, buffer));
    stale = buffer;
    host_destroy_buffer(&host, &vertices);
    host_close_device(&host);
    lost_in = NULL;
    host_open_device(&host);
    vertices = make_vertices(&host);
    vulkan = vulkan_def(&host);
    def = buffer_def(&vertices);
    OK(crumple_vulkan_attach(context, &vulkan));
    OK(crumple_buffer_register_vulkan(context, body, &def, &buffer));
    FACT(memcmp(&buffer, &stale, sizeof buffer) != 0);
    report = run_frame(&host, context, 1); // a new device counts its frames anew
    FACT(report.dispatches == 1 && report.blocks_skipped == 0);
    expect_vertices(&host, &vertices, context, body);
    OK(crumple_instance_get_marks(context, body, after, HITS, &count_after));
    FACT(count_after == count && memcmp(marks, after, sizeof marks) == 0);

    // A context that never saw a device has the same.
    CrumpleContext *other = make_context(1);
    OK(crumple_example_set_create(other, &sheet.def, &set));
    CrumpleInstance twin = make_instance(other, set);
    for (int i = 0; i < HITS; ++i) hit(other, twin, i);
    expect_vertices(&host, &vertices, other, twin);
    OK(crumple_context_destroy(other));

    OK(crumple_vulkan_complete_frames(context, 1));
    OK(crumple_context_destroy(context));
    host_destroy_buffer(&host, &vertices);
    host_close(&host);
    printf("%u checks\n", checks);
    return 0;
}
