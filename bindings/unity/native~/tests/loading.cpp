// What is wrong before there is a Vulkan device, and what the plugin says of it: a library that does not fit, other renderers,
// layouts.
//
//     unity_loading libcrumple_unity.so NONE/libcrumple_unity.so OLD/libcrumple_unity.so PART/libcrumple_unity.so
//
// In the folder NONE there is no library crumple, in OLD one of another version, in PART one that lacks a function.
#include "scene.hpp"

static UnityHost unity_host;
static Plugin plugin;
static int event_id;

// The call fails with this result, and this is in its text.
static void refused(CrumpleResult expected, const char *part, CrumpleResult result) {
    if (result != expected || !strstr(plugin.last_error(), part))
        fprintf(stderr, "%s: %s, expected %s\n", crumple_result_name(result), plugin.last_error(), part);
    FACT(result == expected && strstr(plugin.last_error(), part));
}

// A library that does not fit is named before anything is called.
static void libraries(char **paths) {
    const char *const said[] = {"libcrumple.so cannot be loaded", "is version 9.8.7, but crumple_unity was made for 0.2.0",
                                "has no crumple_features"};
    for (int i = 0; i < 3; ++i) {
        plugin.open(paths[i]);
        plugin.load(unity_host.interfaces());
        FACT(plugin.state_is(said[i]) == CRUMPLE_UNITY_NO_LIBRARY);
        CrumpleContext *context = make_context(1);
        refused(CRUMPLE_ERROR_UNSUPPORTED, said[i], plugin.add_context(context));
        OK(crumple_context_destroy(context));
        FACT(plugin.event(&event_id) && plugin.device() == 0);
        plugin.event(nullptr)(event_id);
        plugin.unload();
        plugin.close();
    }
}

static void renderers() {
    const struct {
        unity::Renderer renderer;
        const char *said;
    } others[] = {{unity::Renderer::D3D11, "Direct3D 11"},  {unity::Renderer::D3D12, "Direct3D 12"},
                  {unity::Renderer::Metal, "Metal"},        {unity::Renderer::OpenGlCore, "OpenGL:"},
                  {unity::Renderer::OpenGlEs3, "OpenGL ES"}, {static_cast<unity::Renderer>(26), "number 26"}};
    for (const auto &other : others) {
        unity_host.renderer = other.renderer;
        plugin.load(unity_host.interfaces());
        FACT(plugin.state_is(other.said) == CRUMPLE_UNITY_OTHER_RENDERER && plugin.device() == 0);
        plugin.unload();
    }
    unity_host.renderer = unity::Renderer::Vulkan;
    unity_host.gives_vulkan = false;
    plugin.load(unity_host.interfaces());
    FACT(plugin.state_is("no Vulkan device") == CRUMPLE_UNITY_NO_DEVICE);
    FACT(plugin.message().find("gives no Vulkan device") != std::string::npos);
    plugin.unload();
    unity_host.gives_vulkan = true;
    plugin.load(unity_host.interfaces()); // before host_open_device(): a table, but no device
    FACT(plugin.state_is("no Vulkan device") == CRUMPLE_UNITY_NO_DEVICE && plugin.device() == 0);
    plugin.unload();
    plugin.message();
    unity_host.gives_graphics = false;
    plugin.load(unity_host.interfaces());
    FACT(plugin.state_is("the renderer is none") == CRUMPLE_UNITY_OTHER_RENDERER && !plugin.event(&event_id));
    plugin.unload();
    unity_host.gives_graphics = true;
    plugin.load(nullptr);
    FACT(plugin.message().find("without interfaces") != std::string::npos && plugin.state_is("startup") == CRUMPLE_UNITY_NOT_LOADED);
}

// Layouts that Crumple does not write are named, with those that it does.
static void layouts() {
    Scene scene;
    scene.open();
    NativeBuffer native;
    uint64_t buffer = 77;
    const auto trial = [&](CrumpleResult expected, const char *part, void (*spoil)(CrumpleUnityBufferDef &)) {
        CrumpleUnityBufferDef def = scene.buffer_def(&native);
        spoil(def);
        refused(expected, part, plugin.register_buffer(scene.context, &def, &buffer));
        FACT(buffer == 77);
    };
    using Def = CrumpleUnityBufferDef;
    const CrumpleResult unsupported = CRUMPLE_ERROR_UNSUPPORTED, invalid = CRUMPLE_ERROR_INVALID_ARGUMENT;
    trial(unsupported, "positions are SNorm16 x 4; Crumple writes Float32 x 3, Float16 x 4",
          [](Def &d) { d.position.format = SNORM16, d.position.dimension = 4; });
    trial(unsupported, "normals are UNorm8 x 4; Crumple writes Float32 x 3, SNorm16 x 4, SNorm8 x 4",
          [](Def &d) { d.normal.format = UNORM8, d.normal.dimension = 4; });
    trial(unsupported, "tangents are Float32 x 3; Crumple writes Float32 x 4", [](Def &d) { d.tangent.dimension = 3; });
    trial(unsupported, "VertexAttributeFormat 12 x 3", [](Def &d) { d.position.format = 12; });
    trial(unsupported, "VertexAttributeFormat -1 x 3", [](Def &d) { d.position.format = -1; });
    trial(unsupported, "normals begin at byte 14", [](Def &d) { d.normal.offset = 14; });
    trial(unsupported, "have 50 bytes, not a multiple of 4", [](Def &d) { d.stride = 50; });
    trial(invalid, "tangents at byte 36 of a vertex do not fit its 48", [](Def &d) { d.tangent.offset = 36; });
    trial(invalid, "normals at byte -4", [](Def &d) { d.normal.offset = -4; });
    trial(invalid, "no positions in this vertex stream", [](Def &d) { d.position.dimension = 0; });
    trial(invalid, "vertex_count is 0", [](Def &d) { d.vertex_count = 0; });
    trial(CRUMPLE_ERROR_NULL_POINTER, "native_buffer is null", [](Def &d) { d.native_buffer = nullptr; });
    trial(CRUMPLE_ERROR_STRUCT_SIZE, "struct_size is 5, here it is 72", [](Def &d) { d.struct_size = 5; });
    // No layout is wrong any more: there is no device.
    const CrumpleUnityBufferDef def = scene.buffer_def(&native);
    OK(plugin.add_context(scene.context));
    refused(unsupported, "the renderer is Direct3D 12", plugin.register_buffer(scene.context, &def, &buffer));
    OK(plugin.destroy_context(scene.context));
}

int main(int count, char **arguments) {
    FACT(count == 5);
    libraries(arguments + 2);
    plugin.open(arguments[1]);
    renderers();
    unity_host.renderer = unity::Renderer::D3D12;
    plugin.load(unity_host.interfaces());
    layouts();
    plugin.unload();
    plugin.close();
    printf("%u checks\n", checks);
    return 0;
}
