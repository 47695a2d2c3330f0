// A sheet of metal as a set, and the static mesh that an importer could have made of it: other order, seams split, other axes, cm.
#pragma once

#include "CrumpleBody.h"
#include "CrumpleComponent.h"
#include "CrumpleModule.h"
#include "CrumpleSet.h"
#include "StandinEngine.h"

#include "crumple_import.h"

#include <cstdio>
#include <cstdlib>
#include <vector>

#define FACT(Condition) fact((Condition), #Condition, __FILE__, __LINE__)
inline void fact(bool holds, const char* what, const char* file, int line) {
    if (holds) return;
    std::fprintf(stderr, "%s:%d: this is not so: %s\n", file, line, what);
    for (const StandinMessage& each : StandinTakeLog()) std::fprintf(stderr, "  log: %ls\n", each.Text.c_str());
    std::exit(1);
}

/// A mesh in a set's space: m.
struct Mesh {
    std::vector<CrumpleVec3> positions, normals;
    std::vector<uint32_t> indices;
};

constexpr int side = 41;

/// 1 m by 1 m, y up: as glTF has it.
inline Mesh make_sheet() {
    Mesh mesh;
    for (int v = 0; v < side * side; ++v) {
        const float x = float(v % side) / (side - 1) - 0.5f, z = float(v / side) / (side - 1) - 0.5f;
        mesh.positions.push_back({x, 0.1f * x, z});
        mesh.normals.push_back({-0.0995037f, 0.9950372f, 0});
        if (v % side < side - 1 && v / side < side - 1) {
            const uint32_t a = uint32_t(v), n = side;
            for (uint32_t i : {a, a + n, a + 1, a + 1, a + n, a + n + 1}) mesh.indices.push_back(i);
        }
    }
    return mesh;
}

/// A .crumple file of the sheet, with one example: 5 cm deep in the middle.
inline TArray<uint8> make_set(const Mesh& mesh) {
    std::vector<CrumpleVec3> dented = mesh.positions;
    for (CrumpleVec3& p : dented) {
        const float r = (p.x * p.x + p.z * p.z) / 0.04f;
        if (r < 1) p.y -= 0.05f * (1 - r) * (1 - r);
    }
    const CrumpleContextDef context_def = crumple_context_def_default();
    CrumpleContext* context = nullptr;
    FACT(crumple_context_create(&context_def, &context) == CRUMPLE_OK);
    const auto input = [](const auto& all) { return CrumpleInput{all.data(), all.size() * sizeof all[0], sizeof all[0]}; };
    CrumpleExampleDef example = crumple_example_def_default();
    example.target_positions = input(dented);
    CrumpleMeshDef arrays = crumple_mesh_def_default();
    arrays.vertex_count = uint32_t(mesh.positions.size());
    arrays.positions = input(mesh.positions);
    arrays.normals = input(mesh.normals);
    arrays.index_count = uint32_t(mesh.indices.size());
    arrays.indices = input(mesh.indices);
    CrumpleExampleSetDef def = crumple_example_set_def_default();
    def.mesh = &arrays;
    def.examples = &example;
    def.example_count = 1;
    CrumpleExampleSet set;
    FACT(crumple_example_set_create(context, &def, &set) == CRUMPLE_OK);
    size_t size = 0;
    FACT(crumple_example_set_save_baked(context, set, nullptr, 0, &size) == CRUMPLE_OK);
    TArray<uint8> bytes;
    bytes.SetNum(int32(size));
    FACT(crumple_example_set_save_baked(context, set, bytes.GetData(), size, &size) == CRUMPLE_OK);
    FACT(crumple_context_destroy(context) == CRUMPLE_OK);
    return bytes;
}

/// x, y, z of a y-up file in Unreal. Written out here, apart from the plugin's own conversion.
inline FVector3f to_unreal(const CrumpleVec3& p, float scale) { return {scale * p.x, scale * p.z, scale * p.y}; }

/// Backwards, every seventh vertex twice, in two sections with a material each.
inline UStaticMesh* import(const Mesh& mesh) {
    UStaticMesh* made = NewObject<UStaticMesh>();
    made->StandinName = FString(TEXT("Sheet"));
    made->Standin = std::make_unique<FStaticMeshRenderData>();
    auto lod = std::make_unique<FStaticMeshLODResources>();
    std::vector<uint32_t> first(mesh.positions.size()), second(mesh.positions.size());
    std::vector<uint32_t> order;
    for (uint32_t v = uint32_t(mesh.positions.size()); v-- > 0;) {
        first[v] = second[v] = uint32_t(order.size());
        order.push_back(v);
        if (v % 7 == 0) {
            second[v] = uint32_t(order.size());
            order.push_back(v);
        }
    }
    auto& buffers = lod->VertexBuffers;
    buffers.StaticMeshVertexBuffer.Init(uint32(order.size()), 2);
    for (uint32_t v = 0; v < order.size(); ++v) {
        const FVector3f normal = to_unreal(mesh.normals[order[v]], 1);
        // Any that is across the normal.
        const FVector3f axis = std::fabs(normal.Y) < 0.9f ? FVector3f(0, 1, 0) : FVector3f(1, 0, 0);
        const FVector3f tangent = FVector3f::CrossProduct(axis, normal).GetSafeNormal();
        const float sign = v % 2 ? 1.0f : -1.0f;
        buffers.PositionVertexBuffer.Standin.Add(to_unreal(mesh.positions[order[v]], 100));
        buffers.StaticMeshVertexBuffer.SetVertexTangents(v, tangent, FVector3f::CrossProduct(normal, tangent) * sign, normal);
        buffers.StaticMeshVertexBuffer.SetVertexUV(v, 0, {float(v), 0.25f});
        buffers.StaticMeshVertexBuffer.SetVertexUV(v, 1, {0.5f, float(v)});
    }
    // Mirrored with the axes, so turned.
    for (size_t i = 0; i < mesh.indices.size(); i += 3)
        for (size_t corner : {i, i + 2, i + 1}) {
            const uint32_t v = mesh.indices[corner];
            lod->IndexBuffer.Standin.Add(i % 2 ? first[v] : second[v]);
        }
    const uint32 half = uint32(mesh.indices.size()) / 6;
    lod->Sections = {{0, 0, half}, {1, 3 * half, uint32(mesh.indices.size()) / 3 - half}};
    made->Standin->LODResources.Standin.push_back(std::move(lod));
    return made;
}

/// The same damage without the plugin: a context, an instance and crumple_context_deform() of our own.
class Oracle {
public:
    Oracle(const TArray<uint8>& bytes, const UStaticMesh& static_mesh) {
        const CrumpleContextDef context_def = crumple_context_def_default();
        FACT(crumple_context_create(&context_def, &context) == CRUMPLE_OK);
        CrumpleExampleSet set;
        if (std::memcmp(bytes.GetData(), "glTF", 4) == 0) {
            const CrumpleGltfDef def = crumple_gltf_def_default();
            FACT(crumple_example_set_load_gltf_memory(context, bytes.GetData(), size_t(bytes.Num()), &def, &set) == CRUMPLE_OK);
        } else {
            FACT(crumple_example_set_load_baked_memory(context, bytes.GetData(), size_t(bytes.Num()), CRUMPLE_BYTES_COPY, &set) == CRUMPLE_OK);
        }
        const auto& buffers = static_mesh.Standin->LODResources[0].VertexBuffers;
        const uint32 count = buffers.PositionVertexBuffer.GetNumVertices();
        std::vector<CrumpleVec3> positions, normals;
        for (uint32 v = 0; v < count; ++v) {
            const FVector p(buffers.PositionVertexBuffer.VertexPosition(v));
            const FVector4f n = buffers.StaticMeshVertexBuffer.VertexTangentZ(v), t = buffers.StaticMeshVertexBuffer.VertexTangentX(v);
            positions.push_back({float(p.X / 100), float(p.Z / 100), float(p.Y / 100)});
            const FVector3f unit = FVector3f(n.X, n.Y, n.Z).GetSafeNormal(), along = FVector3f(t.X, t.Y, t.Z).GetSafeNormal();
            normals.push_back({unit.X, unit.Z, unit.Y});
            // Mirrored: the sign of the bitangent turns.
            vertices.push_back({positions.back(), {along.X, along.Z, along.Y, -n.W}, normals.back(), -n.W});
        }
        CrumpleMeshDef lod = crumple_mesh_def_default();
        lod.vertex_count = count;
        lod.positions = {positions.data(), positions.size() * 12, 12};
        lod.normals = {normals.data(), normals.size() * 12, 12};
        lod.tangents = {vertices[0].tangent, (count - 1) * sizeof(Vertex) + 16, sizeof(Vertex)};
        uint32_t level = 0;
        FACT(crumple_example_set_add_lod(context, set, &lod, &level) == CRUMPLE_OK);
        CrumpleInstanceDef def = crumple_instance_def_default();
        def.set = set;
        def.compliance = 0.02f;
        FACT(crumple_instance_create(context, &def, &instance) == CRUMPLE_OK);
        CrumpleHostBufferDef buffer = crumple_host_buffer_def_default();
        const size_t size = vertices.size() * sizeof(Vertex);
        buffer.lod = level;
        buffer.positions = {vertices.data(), size, offsetof(Vertex, position), sizeof(Vertex)};
        buffer.tangents = {vertices.data(), size, offsetof(Vertex, tangent), sizeof(Vertex)};
        buffer.normals = {vertices.data(), size, offsetof(Vertex, normal), sizeof(Vertex)};
        CrumpleBuffer id;
        FACT(crumple_buffer_register_host(context, instance, &buffer, &id) == CRUMPLE_OK);
    }
    Oracle(const Oracle&) = delete;
    ~Oracle() { crumple_context_destroy(context); }

    /// m and N s, in the set's space.
    void hit(CrumpleVec3 point, CrumpleVec3 impulse) {
        CrumpleHitDef def = crumple_hit_def_default();
        def.point = point;
        def.impulse = impulse;
        FACT(crumple_instance_submit_hit(context, instance, &def, nullptr) == CRUMPLE_OK);
    }

    /// The marks of a component.
    void load(UCrumpleComponent& of) {
        TArray<uint8> damage;
        FACT(of.SaveDamage(damage));
        FACT(crumple_instance_load_damage(context, instance, damage.GetData(), size_t(damage.Num())) == CRUMPLE_OK);
    }

    /// Whether the bytes of a vertex buffer of the plugin's are these vertices'. exact: to the bit.
    bool shows(const std::vector<uint8>& bytes, bool exact = true) {
        FACT(crumple_context_deform(context, nullptr, 0, nullptr) == CRUMPLE_OK);
        const FCrumpleLayout layout{uint32(vertices.size())};
        FACT(bytes.size() >= layout.Size());
        for (uint32 v = 0; v < vertices.size(); ++v) {
            float seen[11], wanted[11];
            std::memcpy(seen, &bytes[12 * v], 12);
            std::memcpy(seen + 3, &bytes[layout.BasisBegin() + 32 * v], 32);
            std::memcpy(wanted, &vertices[v], sizeof wanted);
            for (int k = 0; k < 11; ++k)
                if (exact ? std::memcmp(&seen[k], &wanted[k], 4) != 0 : !(std::fabs(seen[k] - wanted[k]) < 1e-5f)) {
                    std::fprintf(stderr, "vertex %u, float %d: %.9g for %.9g\n", v, k, double(seen[k]), double(wanted[k]));
                    return false;
                }
        }
        return true;
    }

    /// How far the deepest vertex has moved, m.
    float deepest(const std::vector<CrumpleVec3>& rest) {
        FACT(crumple_context_deform(context, nullptr, 0, nullptr) == CRUMPLE_OK);
        float most = 0;
        for (size_t v = 0; v < rest.size(); ++v) most = std::max(most, rest[v].y - vertices[v].position.y);
        return most;
    }

    struct Vertex {
        CrumpleVec3 position;
        float tangent[4];
        CrumpleVec3 normal;
        float sign;
    };
    std::vector<Vertex> vertices;
    CrumpleContext* context = nullptr;
    CrumpleInstance instance{};
};

/// An actor with a static mesh component, and Crumple's on it, playing.
struct Scene {
    AActor* actor = NewObject<AActor>();
    UStaticMeshComponent* target = NewObject<UStaticMeshComponent>();
    UCrumpleComponent* crumple = NewObject<UCrumpleComponent>();

    Scene(UStaticMesh* mesh, UCrumpleSet* set, const FTransform& transform = {}, bool gpu = false) {
        target->StandinMesh = mesh;
        target->StandinTransform = transform;
        for (int slot = 0; slot < 2; ++slot) target->SetMaterial(slot, NewObject<UMaterial>());
        crumple->Set = set;
        crumple->bUseGPU = gpu;
        crumple->StandinName = FString(TEXT("Panel"));
        StandinWorld::Play(*actor, *target);
        StandinWorld::Play(*actor, *crumple);
    }

    /// Plays until what touches it no longer counts as what stood there when play began.
    void settle() const {
        for (int step = 0; step < 8; ++step) StandinWorld::Frame();
    }

    /// As Unreal tells of a contact: cm, kg cm/s.
    void collide(FVector point, FVector impulse, UPrimitiveComponent* by = nullptr, FVector normal = {}) {
        FHitResult hit;
        hit.ImpactPoint = point;
        hit.ImpactNormal = normal;
        target->OnComponentHit.Broadcast(target, actor, by, impulse, hit);
    }

    /// A ball that simulates, kg and cm/s.
    static UPrimitiveComponent* ball(float mass, FVector velocity) {
        UPrimitiveComponent* made = NewObject<UPrimitiveComponent>();
        made->StandinMass = mass;
        made->StandinVelocity = velocity;
        return made;
    }
};

inline UCrumpleSet* asset(TArray<uint8> bytes) {
    UCrumpleSet* made = NewObject<UCrumpleSet>();
    made->StandinName = FString(TEXT("SheetSet"));
    made->SetBytes(std::move(bytes));
    return made;
}

inline bool said(const std::vector<StandinMessage>& log, const TCHAR* part) {
    for (const StandinMessage& each : log)
        if (each.Text.find(part) != std::wstring::npos) return true;
    return false;
}

/// The module between its startup and its shutdown.
struct Module {
    std::unique_ptr<IModuleInterface> held = FModuleManager::Make();
    Module() {
        FModuleManager::Loaded = held.get();
        held->StartupModule();
    }
    ~Module() {
        held->ShutdownModule();
        FModuleManager::Loaded = nullptr;
    }
};

/// hood.glb, and a static mesh of it.
struct Hood {
    Mesh mesh;
    explicit Hood(const TArray<uint8>& glb) {
        const CrumpleContextDef context_def = crumple_context_def_default();
        CrumpleContext* context = nullptr;
        FACT(crumple_context_create(&context_def, &context) == CRUMPLE_OK);
        const CrumpleGltfDef def = crumple_gltf_def_default();
        CrumpleExampleSet set;
        FACT(crumple_example_set_load_gltf_memory(context, glb.GetData(), size_t(glb.Num()), &def, &set) == CRUMPLE_OK);
        CrumpleExampleSetInfo info;
        FACT(crumple_example_set_get_info(context, set, &info) == CRUMPLE_OK);
        mesh.positions.resize(info.vertex_count);
        mesh.normals.resize(info.vertex_count);
        mesh.indices.resize(3 * info.triangle_count);
        CrumpleMeshCopyDef copy = crumple_mesh_copy_def_default();
        copy.positions = {mesh.positions.data(), mesh.positions.size() * 12, 0, 12};
        copy.normals = {mesh.normals.data(), mesh.normals.size() * 12, 0, 12};
        copy.indices = {mesh.indices.data(), mesh.indices.size() * 4, 0, 4};
        FACT(crumple_example_set_copy_mesh(context, set, &copy) == CRUMPLE_OK);
        FACT(crumple_context_destroy(context) == CRUMPLE_OK);
    }
};
