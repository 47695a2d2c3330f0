// What both tests use: a body in a vertex buffer laid out as Unity's meshes are, and its twin on the CPU that takes the same
// hits.
#ifndef CRUMPLE_UNITY_SCENE_HPP
#define CRUMPLE_UNITY_SCENE_HPP

#include "unity_host.hpp"

// Mesh.SetVertexBufferParams() with position, normal, tangent and texture coordinates.
struct Vertex {
    float position[3], normal[3], tangent[4], uv[2];
};

constexpr int FLOAT32 = 0, FLOAT16 = 1, UNORM8 = 2, SNORM8 = 3, SNORM16 = 5;
constexpr VkBufferUsageFlags RAW = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;

inline Sheet &sheet() {
    static Sheet only;
    if (only.def.struct_size == 0) make_sheet(&only);
    return only;
}

inline const std::vector<Vertex> &rest() {
    static std::vector<Vertex> vertices;
    for (int v = 0; vertices.size() < VERTICES; ++v) {
        Vertex vertex;
        memcpy(vertex.position, sheet().positions[v], sizeof vertex.position);
        memcpy(vertex.normal, sheet().normals[v], sizeof vertex.normal);
        memcpy(vertex.tangent, sheet().tangents[v], sizeof vertex.tangent);
        vertex.uv[0] = (float)v, vertex.uv[1] = -77;
        vertices.push_back(vertex);
    }
    return vertices;
}

struct Scene {
    CrumpleContext *context = nullptr;
    CrumpleExampleSet set{};
    CrumpleInstance body{}, twin{};
    CrumpleBuffer twin_buffer{};
    std::vector<Vertex> expected = rest();

    void open() {
        context = make_context(1);
        OK(crumple_example_set_create(context, &sheet().def, &set));
        body = make_instance(context, set);
        twin = make_instance(context, set);
        CrumpleHostBufferDef def = crumple_host_buffer_def_default();
        const size_t bytes = expected.size() * sizeof(Vertex);
        def.positions = stream_of(expected.data(), bytes, offsetof(Vertex, position), sizeof(Vertex));
        def.normals = stream_of(expected.data(), bytes, offsetof(Vertex, normal), sizeof(Vertex));
        def.tangents = stream_of(expected.data(), bytes, offsetof(Vertex, tangent), sizeof(Vertex));
        OK(crumple_buffer_register_host(context, twin, &def, &twin_buffer));
    }

    // No lock is needed for these.
    void hit(int i) const {
        const CrumpleHitDef def =
            displacement_at((float)(i * 37 % 101) / 101 - 0.5f, (float)(i * 61 % 103) / 103 - 0.5f, 0.02f);
        OK(crumple_instance_submit_hit(context, body, &def, NULL));
        OK(crumple_instance_submit_hit(context, twin, &def, NULL));
    }

    CrumpleUnityBufferDef buffer_def(NativeBuffer *native) const {
        CrumpleUnityBufferDef def{};
        def.struct_size = sizeof def;
        def.instance = body;
        def.native_buffer = native;
        def.vertex_count = VERTICES;
        def.stride = sizeof(Vertex);
        def.position = {FLOAT32, 3, offsetof(Vertex, position)};
        def.normal = {FLOAT32, 3, offsetof(Vertex, normal)};
        def.tangent = {FLOAT32, 4, offsetof(Vertex, tangent)};
        return def;
    }
};

// A software driver rounds as IEEE 754 says, and gives the CPU's very bits.
inline bool same(const Host &host, const void *seen, const std::vector<Vertex> &expected) {
    const size_t bytes = expected.size() * sizeof(Vertex);
    if (host.software) return memcmp(seen, expected.data(), bytes) == 0;
    const float *a = (const float *)seen, *b = (const float *)expected.data();
    for (size_t i = 0; i < bytes / sizeof *a; ++i)
        if (!(fabsf(a[i] - b[i]) < 1e-5f)) return false;
    return true;
}

#endif
