// Memory that an engine's device exported, written by a device of Crumple's own; bad input on the way there.
#include "vulkan_export.h"

#include <unistd.h>

int main(void) {
    CrumpleContext *context = make_context(1);
    CrumpleExampleSet set;
    CrumpleBuffer buffer;
    CrumpleRecordReport report;
    uint64_t imported = 7, frame = 7, semaphore = 7;
    bool done = false;
    Host host;
    host_open(&host);
    open_exporting_device(&host);
    make_sheet(&sheet);
    OK(crumple_example_set_create(context, &sheet.def, &set));
    CrumpleInstance body = make_instance(context, set);
    CrumpleVulkanImportDef import;
    HostBuffer vertices = make_exported(&host, &import);

    // Nothing of it without a device of Crumple's own.
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "crumple_vulkan_open", imported,
                  crumple_vulkan_import_buffer(context, &import, &imported));
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "crumple_vulkan_open", frame,
                  crumple_vulkan_submit(context, NULL, 0, NULL, 0, NULL, 0, &frame, NULL));
    CrumpleVulkanAttachDef theirs = vulkan_def(&host);
    OK(crumple_vulkan_attach(context, &theirs));
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "crumple_vulkan_open", imported,
                  crumple_vulkan_import_buffer(context, &import, &imported));
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "crumple_vulkan_open", done,
                  crumple_vulkan_wait_frame(context, 0, 0, &done));

    // The same physical device, told by its UUID.
    VkPhysicalDeviceIDProperties ids = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES};
    VkPhysicalDeviceProperties2 properties = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &ids};
    vkGetPhysicalDeviceProperties2(host.physical_device, &properties);
    CrumpleVulkanOpenDef own = crumple_vulkan_open_def_default();
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "attached already", crumple_vulkan_open(context, &own));
    OK(crumple_vulkan_detach(context));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "get_instance_proc_addr", crumple_vulkan_open(context, &own));
    own.get_instance_proc_addr = (CrumpleVulkanFunction)vkGetInstanceProcAddr;
    memcpy(own.device_uuid, ids.deviceUUID, sizeof own.device_uuid);
    own.workgroup_size = 64;
    OK(crumple_vulkan_open(context, &own));
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "attached already", crumple_vulkan_attach(context, &theirs));

    CrumpleVulkanImportDef bad = import;
    bad.handle = -1;
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "open file descriptor", imported,
                  crumple_vulkan_import_buffer(context, &bad, &imported));
    bad.handle = 1LL << 40;
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "open file descriptor", imported,
                  crumple_vulkan_import_buffer(context, &bad, &imported));
    bad = import;
    bad.memory_size = 64;
    FAILS_KEEPING(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "imported memory", imported,
                  crumple_vulkan_import_buffer(context, &bad, &imported));
    FAILS_KEEPING(CRUMPLE_ERROR_NULL_POINTER, "out_semaphore", semaphore,
                  crumple_vulkan_import_semaphore(context, CRUMPLE_HANDLE_TYPE_OPAQUE_FD, -1, NULL));
    semaphore = 7; // -1 is none, and some drivers have no external semaphores at all
    FACT(crumple_vulkan_import_semaphore(context, CRUMPLE_HANDLE_TYPE_OPAQUE_FD, -1, &semaphore) != CRUMPLE_OK);
    FACT(semaphore == 7);

    CrumpleVulkanBufferDef def = buffer_def(&vertices);
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "crumple_vulkan_import_buffer", buffer,
                  crumple_buffer_register_vulkan(context, body, &def, &buffer));
    OK(crumple_vulkan_import_buffer(context, &import, &imported));
    def.buffer = imported;
    def.usage = 0; // not looked at
    OK(crumple_buffer_register_vulkan(context, body, &def, &buffer));
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "1 ranges", crumple_vulkan_unimport_buffer(context, imported));
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "crumple_vulkan_attach", crumple_vulkan_complete_frames(context, 1));
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "crumple_vulkan_attach",
          crumple_vulkan_record(context, &host, 1, NULL, 0, NULL));
    FAILS_KEEPING(CRUMPLE_ERROR_INVALID_ARGUMENT, "semaphore is 99", frame,
                  crumple_vulkan_submit(context, NULL, 0, (uint64_t[]){99}, 1, NULL, 0, &frame, NULL));

    for (uint64_t round = 1; round <= 4; ++round) {
        if (round != 3) {
            CrumpleHitDef hit = displacement_at(0.1f * (float)round - 0.2f, 0.15f, 0.02f);
            OK(crumple_instance_submit_hit(context, body, &hit, NULL));
        }
        pass(&host, &vertices, false);
        OK(crumple_vulkan_submit(context, NULL, 0, NULL, 0, NULL, 0, &frame, &report));
        FACT(frame == round && (report.vertices_written > 0) == (round != 3));
        OK(crumple_vulkan_wait_frame(context, frame, UINT64_MAX, &done));
        FACT(done);
        pass(&host, &vertices, true);
        expect_vertices(&host, &vertices, context, body);
    }
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "frame is 9", crumple_vulkan_wait_frame(context, 9, 0, &done));
    OK(crumple_buffer_unregister(context, buffer));
    OK(crumple_vulkan_unimport_buffer(context, imported));
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "buffer is", crumple_vulkan_unimport_buffer(context, imported));

    // Imported again, and left to the end of the context.
    OK(crumple_vulkan_import_buffer(context, &import, &imported));
    def.buffer = imported;
    OK(crumple_buffer_register_vulkan(context, body, &def, &buffer));
    OK(crumple_vulkan_submit(context, &buffer, 1, NULL, 0, NULL, 0, NULL, NULL));
    OK(crumple_context_destroy(context));
    close((int)import.handle);
    host_destroy_buffer(&host, &vertices);
    host_close(&host);
    printf("%u checks\n", checks);
    return 0;
}
