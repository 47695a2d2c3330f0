// The host for programs in C#: what the stand-ins of Unity's API need of a renderer, as a library.
#include "unity_host.hpp"

#define EXPORT extern "C" __attribute__((visibility("default")))

static UnityHost unity_host;
static Plugin plugin;

EXPORT void unity_host_open(const char *path) {
    host_open(&unity_host.host);
    plugin.open(path);
    plugin.load(unity_host.interfaces());
    FACT(plugin.state_is("") == CRUMPLE_UNITY_READY);
}

EXPORT void unity_host_close() {
    unity_host.tell(unity::DeviceEvent::Shutdown);
    plugin.unload();
    unity_host.drop_frames();
    host_close(&unity_host.host);
}

// GraphicsBuffer.GetNativeBufferPtr() of a vertex buffer with these bytes; raw: with GraphicsBuffer.Target.Raw.
EXPORT void *unity_host_make_buffer(const void *bytes, uint32_t size, int raw) {
    return unity_host.make_buffer(bytes, size, raw ? VK_BUFFER_USAGE_STORAGE_BUFFER_BIT : 0);
}

EXPORT void unity_host_destroy_buffer(void *native) {
    unity_host.wait_idle();
    if (unity_host.knows(native)) unity_host.destroy_buffer(static_cast<NativeBuffer *>(native));
}

// A frame of the renderer; with a callback, its event.
EXPORT void unity_host_frame(CrumpleUnityEvent callback, int event_id) {
    unity_host.begin_frame();
    if (callback) unity_host.event(callback, event_id);
    unity_host.end_frame();
}

// The bytes that the next frame's draws fetch.
EXPORT void unity_host_read(void *native, void *into) {
    NativeBuffer *buffer = static_cast<NativeBuffer *>(native);
    HostBuffer seen = host_buffer(&unity_host.host, buffer->vk.size, VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);
    unity_host.begin_frame();
    unity_host.read(buffer, seen);
    unity_host.end_frame();
    unity_host.wait_idle();
    memcpy(into, seen.data, seen.size);
    host_destroy_buffer(&unity_host.host, &seen);
}

EXPORT void unity_host_end_device() {
    unity_host.tell(unity::DeviceEvent::Shutdown);
    unity_host.drop_frames();
    unity_host.destroy_all_buffers();
    host_close_device(&unity_host.host);
}

EXPORT void unity_host_begin_device() {
    host_open_device(&unity_host.host);
    unity_host.tell(unity::DeviceEvent::Initialize);
}

EXPORT uint32_t unity_host_pending() { return plugin.pending(); }
