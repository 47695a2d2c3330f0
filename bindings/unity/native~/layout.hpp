// Unity's vertex layouts as Crumple's streams.
#ifndef CRUMPLE_UNITY_LAYOUT_HPP
#define CRUMPLE_UNITY_LAYOUT_HPP

#include "crumple_unity.h"

#include <crumple_vulkan.h>

#include <string>

namespace crumple_unity {

struct Layout {
    CrumpleVulkanStream position{}, normal{}, tangent{};
};

struct Refused {
    CrumpleResult result = CRUMPLE_OK;
    std::string why;
};

// Fills `out`, or tells which attribute cannot be written and what could.
Refused layout_of(const CrumpleUnityBufferDef &def, Layout &out);

} // namespace crumple_unity

#endif
