// Every Vulkan call that can fail does so once, in turn, with each error that drivers return: the call of Crumple says so and changes
// nothing, the same call succeeds afterwards, and the vertices are those of crumple_context_deform(). A device that stays lost can be
// detached, the CPU goes on with the same bits, and another device gets the same vertices.
#include "vulkan_support.h"

static VkResult fault;                // what the failing call returns
static unsigned calls, fail_at;       // fail_at: the call that fails, counted from 1; 0: none
static bool stays_lost, failed;       // stays_lost: all calls after it fail too
static const char *failed_in;

static bool fails_now(const char *name) {
    ++calls;
    if (fail_at == 0 || (stays_lost ? calls < fail_at : calls != fail_at)) return false;
    if (!failed) failed_in = name;
    failed = true;
    return true;
}

// The calls that can fail: names, parameters and arguments.
#define CALLS(EACH)                                                                                                    \
    EACH(vkCreateInstance, (const VkInstanceCreateInfo *i, Callbacks c, VkInstance *o), (i, c, o))                     \
    EACH(vkEnumeratePhysicalDevices, (VkInstance d, uint32_t *n, VkPhysicalDevice *o), (d, n, o))                      \
    EACH(vkEnumerateDeviceExtensionProperties, (VkPhysicalDevice d, const char *l, uint32_t *n, VkExtensionProperties *o), (d, l, n, o)) \
    EACH(vkCreateDevice, (VkPhysicalDevice d, const VkDeviceCreateInfo *i, Callbacks c, VkDevice *o), (d, i, c, o))    \
    EACH(vkCreateBuffer, (VkDevice d, const VkBufferCreateInfo *i, Callbacks c, VkBuffer *o), (d, i, c, o))            \
    EACH(vkAllocateMemory, (VkDevice d, const VkMemoryAllocateInfo *i, Callbacks c, VkDeviceMemory *o), (d, i, c, o))  \
    EACH(vkBindBufferMemory, (VkDevice d, VkBuffer b, VkDeviceMemory m, VkDeviceSize o), (d, b, m, o))                 \
    EACH(vkMapMemory, (VkDevice d, VkDeviceMemory m, VkDeviceSize o, VkDeviceSize s, VkMemoryMapFlags f, void **p), (d, m, o, s, f, p)) \
    EACH(vkFlushMappedMemoryRanges, (VkDevice d, uint32_t n, const VkMappedMemoryRange *r), (d, n, r))                 \
    EACH(vkCreateDescriptorSetLayout, (VkDevice d, const VkDescriptorSetLayoutCreateInfo *i, Callbacks c, VkDescriptorSetLayout *o), (d, i, c, o)) \
    EACH(vkCreateDescriptorPool, (VkDevice d, const VkDescriptorPoolCreateInfo *i, Callbacks c, VkDescriptorPool *o), (d, i, c, o)) \
    EACH(vkAllocateDescriptorSets, (VkDevice d, const VkDescriptorSetAllocateInfo *i, VkDescriptorSet *o), (d, i, o))  \
    EACH(vkCreatePipelineLayout, (VkDevice d, const VkPipelineLayoutCreateInfo *i, Callbacks c, VkPipelineLayout *o), (d, i, c, o)) \
    EACH(vkCreatePipelineCache, (VkDevice d, const VkPipelineCacheCreateInfo *i, Callbacks c, VkPipelineCache *o), (d, i, c, o)) \
    EACH(vkGetPipelineCacheData, (VkDevice d, VkPipelineCache p, size_t *s, void *o), (d, p, s, o))                    \
    EACH(vkCreateShaderModule, (VkDevice d, const VkShaderModuleCreateInfo *i, Callbacks c, VkShaderModule *o), (d, i, c, o)) \
    EACH(vkCreateComputePipelines, (VkDevice d, VkPipelineCache p, uint32_t n, const VkComputePipelineCreateInfo *i, Callbacks c, VkPipeline *o), (d, p, n, i, c, o)) \
    EACH(vkCreateCommandPool, (VkDevice d, const VkCommandPoolCreateInfo *i, Callbacks c, VkCommandPool *o), (d, i, c, o)) \
    EACH(vkAllocateCommandBuffers, (VkDevice d, const VkCommandBufferAllocateInfo *i, VkCommandBuffer *o), (d, i, o))  \
    EACH(vkBeginCommandBuffer, (VkCommandBuffer b, const VkCommandBufferBeginInfo *i), (b, i))                         \
    EACH(vkEndCommandBuffer, (VkCommandBuffer b), (b))                                                                 \
    EACH(vkCreateFence, (VkDevice d, const VkFenceCreateInfo *i, Callbacks c, VkFence *o), (d, i, c, o))               \
    EACH(vkResetFences, (VkDevice d, uint32_t n, const VkFence *f), (d, n, f))                                         \
    EACH(vkGetFenceStatus, (VkDevice d, VkFence f), (d, f))                                                            \
    EACH(vkWaitForFences, (VkDevice d, uint32_t n, const VkFence *f, VkBool32 all, uint64_t t), (d, n, f, all, t))     \
    EACH(vkQueueSubmit, (VkQueue q, uint32_t n, const VkSubmitInfo *s, VkFence f), (q, n, s, f))

typedef const VkAllocationCallbacks *Callbacks;
static PFN_vkGetDeviceProcAddr device_functions;

#define FAULTY(name, parameters, arguments)                                                                            \
    static PFN_##name real_##name;                                                                                     \
    static VKAPI_ATTR VkResult VKAPI_CALL faulty_##name parameters {                                                   \
        return fails_now(#name) ? fault : real_##name arguments;                                                       \
    }
CALLS(FAULTY)

static PFN_vkVoidFunction faulty(const char *name, PFN_vkVoidFunction found) {
#define WRAP(function, parameters, arguments)                                                                          \
    if (found && strcmp(name, #function) == 0) {                                                                       \
        real_##function = (PFN_##function)found;                                                                       \
        return (PFN_vkVoidFunction)faulty_##function;                                                                  \
    }
    CALLS(WRAP)
    return found;
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL faulty_get_device(VkDevice device, const char *name) {
    return faulty(name, device_functions(device, name));
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL faulty_get_instance(VkInstance instance, const char *name) {
    PFN_vkVoidFunction found = vkGetInstanceProcAddr(instance, name);
    if (!found || strcmp(name, "vkGetDeviceProcAddr") != 0) return faulty(name, found);
    device_functions = (PFN_vkGetDeviceProcAddr)found;
    return (PFN_vkVoidFunction)faulty_get_device;
}

// --- The scenario, on the host's device or on one of Crumple's own.

enum { HITS = 4 };

typedef struct Scene {
    Host host;
    CrumpleContext *context;
    CrumpleInstance body;
    CrumpleBuffer buffer;
    HostBuffer vertices;
    CrumpleVulkanImportDef import;
    uint64_t imported, frame;
    bool own, passed; // passed: the buffer belongs to the other device
} Scene;

static void hit(Scene *s, int i) {
    CrumpleHitDef def = displacement_at(0.1f * (float)i - 0.2f, 0.15f, 0.02f);
    OK(crumple_instance_submit_hit(s->context, s->body, &def, NULL));
}

static CrumpleResult attach(Scene *s) {
    if (s->own) {
        CrumpleVulkanOpenDef def = crumple_vulkan_open_def_default();
        device_uuid(&s->host, def.device_uuid);
        def.get_instance_proc_addr = (CrumpleVulkanFunction)faulty_get_instance;
        return crumple_vulkan_open(s->context, &def);
    }
    CrumpleVulkanAttachDef def = vulkan_def(&s->host);
    def.get_instance_proc_addr = (CrumpleVulkanFunction)faulty_get_instance;
    return crumple_vulkan_attach(s->context, &def);
}

static CrumpleResult import_buffer(Scene *s) {
    return s->own ? crumple_vulkan_import_buffer(s->context, &s->import, &s->imported) : CRUMPLE_OK;
}

static CrumpleResult register_buffer(Scene *s) {
    CrumpleVulkanBufferDef def = buffer_def(&s->vertices);
    if (s->own) def.buffer = s->imported;
    return crumple_buffer_register_vulkan(s->context, s->body, &def, &s->buffer);
}

// What fails to be recorded leaves nothing in the command buffer, which runs here all the same.
static CrumpleResult frame(Scene *s) {
    CrumpleResult result;
    if (s->own) {
        if (!s->passed) pass(&s->host, &s->vertices, false);
        s->passed = true;
        return crumple_vulkan_submit(s->context, NULL, 0, NULL, 0, NULL, 0, &s->frame, NULL);
    }
    VkCommandBuffer commands = host_begin(&s->host);
    result = crumple_vulkan_record(s->context, commands, s->frame + 1, NULL, 0, NULL);
    s->frame += result == CRUMPLE_OK;
    host_run(&s->host, commands);
    return result;
}

static CrumpleResult wait(Scene *s) {
    bool done = false;
    if (!s->own) return crumple_vulkan_complete_frames(s->context, s->frame);
    CrumpleResult result = crumple_vulkan_wait_frame(s->context, s->frame, UINT64_MAX, &done);
    if (result != CRUMPLE_OK) return result;
    FACT(done);
    pass(&s->host, &s->vertices, true);
    s->passed = false;
    return result;
}

static CrumpleResult pipeline_cache(Scene *s) {
    static unsigned char data[1 << 22];
    size_t size;
    return crumple_vulkan_get_pipeline_cache(s->context, data, sizeof data, &size);
}

static CrumpleResult (*const steps[])(Scene *) = {
    attach, import_buffer, register_buffer, frame, wait, frame, wait, pipeline_cache, frame, frame, wait,
};
enum { STEPS = sizeof steps / sizeof *steps };

static void begin(Scene *s, bool own) {
    CrumpleExampleSet set;
    memset(s, 0, sizeof *s);
    s->own = own;
    host_open(&s->host);
    if (own) {
        open_exporting_device(&s->host);
        s->vertices = make_exported(&s->host, true, &s->import);
    } else {
        s->vertices = make_vertices(&s->host);
    }
    s->context = make_context(1);
    OK(crumple_example_set_create(s->context, &sheet.def, &set));
    s->body = make_instance(s->context, set);
    calls = fail_at = 0;
    failed = false;
}

static void end(Scene *s) {
    OK(crumple_context_destroy(s->context));
    if (s->own) close((int)s->import.handle);
    host_destroy_buffer(&s->host, &s->vertices);
    host_close(&s->host);
}

static CrumpleResult expected(void) {
    return fault == VK_ERROR_DEVICE_LOST ? CRUMPLE_ERROR_DEVICE_LOST : CRUMPLE_ERROR_OUT_OF_MEMORY;
}

static void check_result(CrumpleResult result) {
    if (failed && result != expected()) fprintf(stderr, "%s fails with %d\n", failed_in, (int)fault);
    FACT(result == (failed ? expected() : CRUMPLE_OK));
}

// Each step fails at its first Vulkan call, then at its second, and so on, until it makes no more.
static unsigned fail_and_repeat(bool own, VkResult with) {
    Scene s;
    unsigned faults = 0;
    begin(&s, own);
    fault = with;
    stays_lost = false;
    for (int step = 0; step < STEPS; ++step) {
        if (steps[step] == frame) hit(&s, step % HITS);
        for (unsigned n = 1;; ++n) {
            calls = 0;
            fail_at = n;
            failed = false;
            CrumpleResult result = steps[step](&s);
            fail_at = 0;
            check_result(result);
            if (!failed) break;
            ++faults;
        }
        if (steps[step] == wait) expect_vertices(&s.host, &s.vertices, s.context, s.body);
    }
    end(&s);
    return faults;
}

// The vertices of the CPU for a body with so many hits, in a context that never had a device.
static void hit_alone(int hits, float (*positions)[3]) {
    CrumpleExampleSet set;
    Scene plain;
    plain.context = make_context(1);
    OK(crumple_example_set_create(plain.context, &sheet.def, &set));
    plain.body = make_instance(plain.context, set);
    for (int i = 0; i < hits; ++i) hit(&plain, i);
    make_buffer(plain.context, plain.body, host_def(positions, VERTICES, 3));
    OK(crumple_context_deform(plain.context, NULL, 0, NULL));
    OK(crumple_context_destroy(plain.context));
}

// The device is lost at the n-th call and stays so. Returns whether there was such a call.
static bool lose(bool own, unsigned n) {
    static float wanted[VERTICES][3], seen[VERTICES][3];
    Scene s;
    begin(&s, own);
    fault = VK_ERROR_DEVICE_LOST;
    stays_lost = true;
    fail_at = n;
    int hits = 0;
    for (int step = 0; step < STEPS && !failed; ++step) {
        if (steps[step] == frame) hit(&s, hits++);
        check_result(steps[step](&s));
    }
    const bool lost = failed;
    if (lost) {
        (void)crumple_vulkan_complete_frames(s.context, UINT64_MAX); // no device, or Crumple's own: an error
        (void)crumple_vulkan_detach(s.context);
        FACT(!crumple_buffer_is_valid(s.context, s.buffer));
        make_buffer(s.context, s.body, host_def(seen, VERTICES, 3));
        OK(crumple_context_deform(s.context, NULL, 0, NULL));
        hit_alone(hits, wanted);
        FACT(memcmp(wanted, seen, sizeof wanted) == 0);
    }
    fail_at = 0;
    if (lost && !own) {
        host_destroy_buffer(&s.host, &s.vertices);
        host_close_device(&s.host);
        host_open_device(&s.host);
        s.vertices = make_vertices(&s.host);
        s.frame = 0; // a new device counts its frames anew
        OK(attach(&s));
        OK(register_buffer(&s));
        OK(frame(&s));
        OK(wait(&s));
        expect_vertices(&s.host, &s.vertices, s.context, s.body);
    }
    end(&s);
    return lost;
}

int main(void) {
    static const VkResult errors[] = {VK_ERROR_DEVICE_LOST, VK_ERROR_OUT_OF_HOST_MEMORY, VK_ERROR_OUT_OF_DEVICE_MEMORY};
    make_sheet(&sheet);
    for (int own = 0; own < 2; ++own) {
        unsigned faults = 0, lost = 0;
        for (int i = 0; i < 3; ++i) faults += fail_and_repeat(own, errors[i]);
        while (lose(own, lost + 1)) ++lost;
        FACT(faults > 0 && lost > 0);
        printf("%s device: %u faults, lost at each of %u calls\n", own ? "its own" : "the host's", faults, lost);
    }
    printf("%u checks\n", checks);
    return 0;
}
