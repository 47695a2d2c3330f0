#include "world.hpp"

namespace crumple_unity {
namespace {

// What Crumple writes of an attribute. Formats are numbers of UnityEngine.Rendering.VertexAttributeFormat.
struct Kind {
    int format, dimension;
    VkFormat vulkan;
    const char *name;
};

constexpr int FLOAT32 = 0, FLOAT16 = 1, SNORM8 = 3, SNORM16 = 5;
constexpr Kind POSITIONS[] = {{FLOAT32, 3, VK_FORMAT_R32G32B32_SFLOAT, "Float32 x 3"},
                              {FLOAT16, 4, VK_FORMAT_R16G16B16A16_SFLOAT, "Float16 x 4"}};
constexpr Kind NORMALS[] = {{FLOAT32, 3, VK_FORMAT_R32G32B32_SFLOAT, "Float32 x 3"},
                            {SNORM16, 4, VK_FORMAT_R16G16B16A16_SNORM, "SNorm16 x 4"},
                            {SNORM8, 4, VK_FORMAT_R8G8B8A8_SNORM, "SNorm8 x 4"}};
constexpr Kind TANGENTS[] = {{FLOAT32, 4, VK_FORMAT_R32G32B32A32_SFLOAT, "Float32 x 4"},
                             {SNORM16, 4, VK_FORMAT_R16G16B16A16_SNORM, "SNorm16 x 4"},
                             {SNORM8, 4, VK_FORMAT_R8G8B8A8_SNORM, "SNorm8 x 4"}};

template <size_t N>
std::string stream_of(const char *what, const CrumpleUnityAttribute &attribute, uint32_t stride, const Kind (&kinds)[N],
                      CrumpleVulkanStream &out) {
    if (attribute.dimension == 0) return {};
    std::string names;
    for (const Kind &kind : kinds) {
        if (kind.format == attribute.format && kind.dimension == attribute.dimension) {
            out.offset = static_cast<uint64_t>(attribute.offset);
            out.stride = stride;
            out.format = kind.vulkan;
            return {};
        }
        names += (names.empty() ? "" : ", ") + std::string(kind.name);
    }
    return "the mesh's " + std::string(what) + " are VertexAttributeFormat " + std::to_string(attribute.format) + " x " +
           std::to_string(attribute.dimension) + "; Crumple writes " + names;
}

} // namespace

std::string layout_of(const CrumpleUnityBufferDef &def, Layout &out) {
    std::string why = stream_of("positions", def.position, def.stride, POSITIONS, out.position);
    if (why.empty()) why = stream_of("normals", def.normal, def.stride, NORMALS, out.normal);
    if (why.empty()) why = stream_of("tangents", def.tangent, def.stride, TANGENTS, out.tangent);
    return why;
}

} // namespace crumple_unity
