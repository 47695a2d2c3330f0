// Plans for a render graph through the C interface. tests/vulkan/graph.rs executes such plans.
#include "support.h"

#include <crumple_graph.h>

static Sheet sheet;

static CrumpleVulkanBufferDef interleaved(void) {
    CrumpleVulkanBufferDef def = crumple_vulkan_buffer_def_default();
    def.buffer = 77;
    def.buffer_size = def.size = VERTICES * 24;
    def.positions.stride = def.normals.stride = 24;
    def.normals.offset = 12;
    def.positions.format = def.normals.format = 106; // VK_FORMAT_R32G32B32_SFLOAT
    return def;
}

static void refusals(CrumpleContext *context, CrumpleInstance body) {
    CrumpleBuffer buffer, host;
    CrumpleGraphPlan plan;
    CrumpleVulkanBufferDef def = interleaved();
    size_t size;
    def.buffer_size -= 4;
    FAILS_KEEPING(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "buffer", buffer, crumple_buffer_register_graph(context, body, &def, &buffer));
    def = interleaved();
    memset(&def.positions, 0, sizeof def.positions);
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "def.positions is absent", crumple_buffer_register_graph(context, body, &def, &buffer));
    CrumpleInstanceDef classic_def = crumple_instance_def_default();
    CrumpleInstance classic;
    CrumpleInstanceInfo info;
    OK(crumple_instance_get_info(context, body, &info));
    classic_def.set = info.set;
    classic_def.rule = CRUMPLE_RULE_MOST_DISPLACED;
    OK(crumple_instance_create(context, &classic_def, &classic));
    def = interleaved();
    FAILS(CRUMPLE_ERROR_WRONG_RULE, "render graph", crumple_buffer_register_graph(context, classic, &def, &buffer));
    static float positions[VERTICES][3];
    CrumpleHostBufferDef host_def = crumple_host_buffer_def_default();
    host_def.positions = stream_of(positions, sizeof positions, 0, 12);
    OK(crumple_buffer_register_host(context, body, &host_def, &host));
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "buffers[0] is a host buffer; crumple_context_deform()", plan,
                  crumple_graph_plan(context, &host, 1, &plan, NULL));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "out_plan", crumple_graph_plan(context, NULL, 0, NULL, NULL));
    OK(crumple_buffer_unregister(context, host));
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "kernel is 36", size, crumple_graph_get_kernel(36, NULL, 0, &size));
}

static void plans(CrumpleContext *context, CrumpleInstance body) {
    CrumpleBuffer buffer;
    CrumpleBufferInfo changed;
    CrumpleGraphPlan plan;
    CrumpleRecordReport report;
    CrumpleRange range;
    CrumpleAabb bounds;
    CrumpleVulkanBufferDef def = interleaved();
    uint32_t count;
    OK(crumple_buffer_register_graph(context, body, &def, &buffer));
    OK(crumple_graph_plan(context, &buffer, 1, &plan, &report));
    FACT(plan.upload_count == 1 && plan.freed_count == 0 && plan.dispatch_count == 1);
    FACT(report.vertices_written == VERTICES && report.dispatches == 1);
    FACT(report.bytes_copied == plan.uploads[0].size + plan.work_size);
    FACT(plan.uploads[0].offset == 0 && plan.uploads[0].size <= plan.uploads[0].storage_size);
    // The mesh is at the start of its storage.
    FACT(memcmp(plan.uploads[0].data, sheet.positions, sizeof sheet.positions) == 0);
    FACT(plan.dispatches[0].storage == plan.uploads[0].storage && plan.dispatches[0].buffer == 77);
    FACT(sizeof plan.dispatches[0].constants == 32 && plan.dispatches[0].constants[7] == 0);
    FACT(plan.dispatches[0].groups[0] == (VERTICES + 127) / 128 && plan.dispatches[0].groups[1] == 1);

    uint32_t words[2], kernel = plan.dispatches[0].kernel;
    size_t size = 0;
    FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "data", crumple_graph_get_kernel(kernel, words, sizeof words, &size));
    void *code = malloc(size);
    OK(crumple_graph_get_kernel(kernel, code, size, &size));
    memcpy(words, code, sizeof words);
    FACT(words[0] == 0x07230203 && words[1] == 0x00010300);
    free(code);

    CrumpleHitDef hit = displacement_at(0, 0, 0.04f);
    OK(crumple_instance_submit_hit(context, body, &hit, NULL));
    OK(crumple_graph_plan(context, NULL, 0, &plan, &report));
    FACT(plan.dispatch_count == 1 && plan.work_size > 0 && report.vertices_written > 0);
    OK(crumple_context_get_changed_buffers(context, &changed, 1, &count));
    FACT(count == 1 && changed.buffer.index == buffer.index);
    OK(crumple_buffer_get_changes(context, buffer, &range, 1, &count, &bounds));
    FACT(count == 1 && range.count == report.vertices_written && bounds.max.z > 0.07f);

    OK(crumple_buffer_invalidate(context, buffer));
    OK(crumple_graph_plan(context, NULL, 0, &plan, &report));
    FACT(report.vertices_written == VERTICES && plan.upload_count == 0);
    uint32_t storage = plan.dispatches[0].storage;
    OK(crumple_buffer_unregister(context, buffer));
    OK(crumple_graph_plan(context, NULL, 0, &plan, NULL));
    FACT(plan.freed_count == 1 && plan.freed[0] == storage && plan.dispatch_count == 0);
}

int main(void) {
    CrumpleContext *context = make_context(1);
    CrumpleExampleSet set;
    make_sheet(&sheet);
    OK(crumple_example_set_create(context, &sheet.def, &set));
    CrumpleInstance body = make_instance(context, set);
    if (!(crumple_features() & CRUMPLE_FEATURE_VULKAN)) {
        size_t size;
        FAILS(CRUMPLE_ERROR_UNSUPPORTED, "vulkan", crumple_graph_get_kernel(0, NULL, 0, &size));
    } else {
        refusals(context, body);
        plans(context, body);
    }
    OK(crumple_context_destroy(context));
    printf("%u checks\n", checks);
    return 0;
}
