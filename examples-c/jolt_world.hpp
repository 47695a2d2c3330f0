// What a program with Jolt Physics needs before its first step, as small as it can be: Jolt itself, one layer for all bodies, and meshes.
#ifndef JOLT_WORLD_HPP
#define JOLT_WORLD_HPP

#include <crumple.hpp>

#include <Jolt/Jolt.h>

#include <Jolt/Core/Factory.h>
#include <Jolt/Physics/Collision/BroadPhase/BroadPhaseLayer.h>
#include <Jolt/Physics/Collision/Shape/MeshShape.h>
#include <Jolt/Physics/PhysicsSystem.h>
#include <Jolt/RegisterTypes.h>

#include <vector>

// Jolt's types, as long as this lives.
struct JoltTypes {
    JoltTypes() {
        JPH::RegisterDefaultAllocator();
        JPH::Factory::sInstance = new JPH::Factory();
        JPH::RegisterTypes();
    }
    ~JoltTypes() {
        JPH::UnregisterTypes();
        delete JPH::Factory::sInstance;
    }
    JoltTypes(const JoltTypes &) = delete;
    JoltTypes &operator=(const JoltTypes &) = delete;
};

// A world of few bodies, each of which may touch each other. Layers must outlive the system.
struct JoltWorld {
    struct OneLayer final : JPH::BroadPhaseLayerInterface {
        JPH::uint GetNumBroadPhaseLayers() const override { return 1; }
        JPH::BroadPhaseLayer GetBroadPhaseLayer(JPH::ObjectLayer) const override { return JPH::BroadPhaseLayer(0); }
#if defined(JPH_EXTERNAL_PROFILE) || defined(JPH_PROFILE_ENABLED)
        const char *GetBroadPhaseLayerName(JPH::BroadPhaseLayer) const override { return "all"; }
#endif
    };
    OneLayer layer;
    JPH::ObjectVsBroadPhaseLayerFilter every_layer;
    JPH::ObjectLayerPairFilter every_pair;
    JPH::PhysicsSystem system;

    JoltWorld() {
        system.Init(16, 0, 64, 1024, layer, every_layer, every_pair);
        system.SetGravity(JPH::Vec3::sZero());
    }
};

inline JPH::ShapeRefC jolt_mesh(const std::vector<CrumpleVec3> &vertices, const std::vector<uint32_t> &indices) {
    JPH::VertexList corners;
    JPH::IndexedTriangleList triangles;
    for (const CrumpleVec3 &v : vertices) corners.push_back(JPH::Float3(v.x, v.y, v.z));
    for (size_t i = 0; i < indices.size(); i += 3)
        triangles.push_back(JPH::IndexedTriangle(indices[i], indices[i + 1], indices[i + 2], 0));
    return JPH::MeshShapeSettings(corners, triangles).Create().Get();
}

#endif
