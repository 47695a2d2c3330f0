// The library crumple, found in the folder of this one and opened at run time.
//
// It is not linked: in Unity's folder of plugins the file has no version in its name, a missing one should be told in words rather
// than by a plugin that does not load, and it must be the file that C# opens, since two copies would not know each other's ids.
#ifndef CRUMPLE_UNITY_LIBRARY_HPP
#define CRUMPLE_UNITY_LIBRARY_HPP

#include <crumple_vulkan.h>

#include <string>

namespace crumple_unity {

// Every function of Crumple that the plugin calls.
#define CRUMPLE_UNITY_FUNCTIONS(F) \
    F(crumple_last_error) \
    F(crumple_context_destroy) \
    F(crumple_vulkan_attach_def_default) \
    F(crumple_vulkan_attach) \
    F(crumple_vulkan_detach) \
    F(crumple_vulkan_buffer_def_default) \
    F(crumple_buffer_register_vulkan) \
    F(crumple_buffer_unregister) \
    F(crumple_vulkan_record) \
    F(crumple_vulkan_complete_frames) \
    F(crumple_buffer_get_changes)

struct Library {
#define CRUMPLE_UNITY_MEMBER(name) decltype(&::name) name = nullptr;
    CRUMPLE_UNITY_FUNCTIONS(CRUMPLE_UNITY_MEMBER)
#undef CRUMPLE_UNITY_MEMBER

    // Empty: it is there and has every function. Otherwise what is wrong and what would be right. C# compares the versions.
    std::string open();
};

} // namespace crumple_unity

#endif
