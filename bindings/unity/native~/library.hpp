// The library crumple, found in the folder of this one and opened at run time.
//
// It is not linked: in Unity's folder of plugins the file has no version in its name, a missing or wrong one should be told in
// words rather than by a plugin that does not load, and it must be the file that C# opens, since two copies would not know each
// other's ids.
#ifndef CRUMPLE_UNITY_LIBRARY_HPP
#define CRUMPLE_UNITY_LIBRARY_HPP

#include <crumple.h>

#include <string>

namespace crumple_unity {

// Every function of crumple.h that the shim calls.
#define CRUMPLE_UNITY_FUNCTIONS(F)                                                                                               \
    F(crumple_version)                                                                                                           \
    F(crumple_features)                                                                                                          \
    F(crumple_last_error)                                                                                                        \
    F(crumple_context_destroy)                                                                                                   \
    F(crumple_default_vulkan_def)                                                                                                \
    F(crumple_attach_vulkan)                                                                                                     \
    F(crumple_detach_vulkan)                                                                                                     \
    F(crumple_default_vulkan_buffer_def)                                                                                         \
    F(crumple_register_vulkan_buffer)                                                                                            \
    F(crumple_unregister_buffer)                                                                                                 \
    F(crumple_record_deform)                                                                                                     \
    F(crumple_complete_frames)                                                                                                   \
    F(crumple_get_buffer_changes)

struct Library {
#define CRUMPLE_UNITY_MEMBER(name) decltype(&::name) name = nullptr;
    CRUMPLE_UNITY_FUNCTIONS(CRUMPLE_UNITY_MEMBER)
#undef CRUMPLE_UNITY_MEMBER

    // Empty: it is there, has every function, and fits the header. Otherwise what is wrong and what would be right.
    std::string open();
};

} // namespace crumple_unity

#endif
