// The host of examples-c/vulkan_host.h for C#: what an engine written in C++ does below its managed code.
#include "vulkan_host.h"

#include <stdlib.h>
#include <string.h>

typedef struct Shared {
    Host host;
    HostBuffer vertices;
} Shared;

// A device, and a buffer of so many bytes that the CPU sees too.
Shared *shared_open(uint64_t size) {
    Shared *shared = calloc(1, sizeof *shared);
    if (!shared) abort();
    host_open(&shared->host);
    shared->vertices = host_buffer(&shared->host, size, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, true);
    memset(shared->vertices.data, 0xAB, (size_t)size);
    return shared;
}

// Ends the program where the validation layer had anything to say.
void shared_close(Shared *shared) {
    host_destroy_buffer(&shared->host, &shared->vertices);
    host_close(&shared->host);
    free(shared);
}

void *shared_loader(void) { return (void *)vkGetInstanceProcAddr; }
void *shared_instance(Shared *shared) { return shared->host.instance; }
void *shared_physical_device(Shared *shared) { return shared->host.physical_device; }
void *shared_device(Shared *shared) { return shared->host.device; }
uint32_t shared_family(Shared *shared) { return shared->host.queue_family; }
uint64_t shared_buffer(Shared *shared) { return (uint64_t)shared->vertices.buffer; }
void *shared_data(Shared *shared) { return shared->vertices.data; }
void *shared_begin(Shared *shared) { return host_begin(&shared->host); }
// Submits, and waits.
void shared_run(Shared *shared, void *commands) { host_run(&shared->host, (VkCommandBuffer)commands); }
