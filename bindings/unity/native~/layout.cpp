#include "layout.hpp"

#include <vulkan/vulkan_core.h>

#include <iterator>

namespace crumple_unity {
namespace {

// UnityEngine.Rendering.VertexAttributeFormat, by its numbers.
const char *const FORMATS[] = {"Float32", "Float16", "UNorm8", "SNorm8", "UNorm16", "SNorm16",
                               "UInt8",   "SInt8",   "UInt16", "SInt16", "UInt32",  "SInt32"};
constexpr int FLOAT32 = 0, FLOAT16 = 1, SNORM8 = 3, SNORM16 = 5;

// What Crumple writes of an attribute.
struct Kind {
    int format, dimension;
    VkFormat vulkan;
    int bytes;
};

constexpr Kind POSITIONS[] = {{FLOAT32, 3, VK_FORMAT_R32G32B32_SFLOAT, 12}, {FLOAT16, 4, VK_FORMAT_R16G16B16A16_SFLOAT, 8}};
constexpr Kind NORMALS[] = {{FLOAT32, 3, VK_FORMAT_R32G32B32_SFLOAT, 12},
                            {SNORM16, 4, VK_FORMAT_R16G16B16A16_SNORM, 8},
                            {SNORM8, 4, VK_FORMAT_R8G8B8A8_SNORM, 4}};
constexpr Kind TANGENTS[] = {{FLOAT32, 4, VK_FORMAT_R32G32B32A32_SFLOAT, 16},
                             {SNORM16, 4, VK_FORMAT_R16G16B16A16_SNORM, 8},
                             {SNORM8, 4, VK_FORMAT_R8G8B8A8_SNORM, 4}};

std::string name(int format, int dimension) {
    const bool known = format >= 0 && format < static_cast<int>(std::size(FORMATS));
    return (known ? std::string(FORMATS[format]) : "VertexAttributeFormat " + std::to_string(format)) + " x " + std::to_string(dimension);
}

template <size_t N>
Refused stream_of(const char *what, const CrumpleUnityAttribute &attribute, uint32_t stride, const Kind (&kinds)[N],
                  CrumpleVulkanStream &out) {
    if (attribute.dimension == 0) return {};
    const Kind *found = nullptr;
    std::string all;
    for (const Kind &kind : kinds) {
        if (kind.format == attribute.format && kind.dimension == attribute.dimension) found = &kind;
        all += (all.empty() ? "" : ", ") + name(kind.format, kind.dimension);
    }
    const std::string subject = "the mesh's " + std::string(what);
    if (!found)
        return {CRUMPLE_ERROR_UNSUPPORTED, subject + " are " + name(attribute.format, attribute.dimension) + "; Crumple writes " + all};
    if (attribute.offset < 0 || static_cast<uint64_t>(attribute.offset) + static_cast<uint64_t>(found->bytes) > stride)
        return {CRUMPLE_ERROR_INVALID_ARGUMENT, subject + " at byte " + std::to_string(attribute.offset) + " of a vertex do not fit its " +
                                                    std::to_string(stride) + " bytes"};
    if (attribute.offset % 4 != 0)
        return {CRUMPLE_ERROR_UNSUPPORTED,
                subject + " begin at byte " + std::to_string(attribute.offset) + " of a vertex, not a multiple of 4"};
    out.offset = static_cast<uint64_t>(attribute.offset);
    out.stride = stride;
    out.format = found->vulkan;
    return {};
}

} // namespace

Refused layout_of(const CrumpleUnityBufferDef &def, Layout &out) {
    if (def.vertex_count == 0) return {CRUMPLE_ERROR_INVALID_ARGUMENT, "vertex_count is 0; it is Mesh.vertexCount"};
    if (def.position.dimension == 0) return {CRUMPLE_ERROR_INVALID_ARGUMENT, "the mesh has no positions in this vertex stream"};
    Layout made;
    Refused refused = stream_of("positions", def.position, def.stride, POSITIONS, made.position);
    if (refused.result == CRUMPLE_OK) refused = stream_of("normals", def.normal, def.stride, NORMALS, made.normal);
    if (refused.result == CRUMPLE_OK) refused = stream_of("tangents", def.tangent, def.stride, TANGENTS, made.tangent);
    if (refused.result == CRUMPLE_OK && def.stride % 4 != 0)
        refused = {CRUMPLE_ERROR_UNSUPPORTED, "the mesh's vertices have " + std::to_string(def.stride) + " bytes, not a multiple of 4"};
    if (refused.result == CRUMPLE_OK) out = made;
    return refused;
}

} // namespace crumple_unity
