// The lab's throws in Jolt.
#include "../../examples-c/jolt_contacts.hpp"
#include "throws.hpp"

#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemSingleThreaded.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Collision/Shape/BoxShape.h>
#include <Jolt/Physics/Collision/Shape/MeshShape.h>
#include <Jolt/Physics/Collision/Shape/SphereShape.h>
#include <Jolt/Physics/PhysicsSystem.h>
#include <Jolt/RegisterTypes.h>

namespace {

struct OneBroadLayer final : JPH::BroadPhaseLayerInterface {
    JPH::uint GetNumBroadPhaseLayers() const override { return 1; }
    JPH::BroadPhaseLayer GetBroadPhaseLayer(JPH::ObjectLayer) const override { return JPH::BroadPhaseLayer(0); }
#if defined(JPH_EXTERNAL_PROFILE) || defined(JPH_PROFILE_ENABLED)
    const char *GetBroadPhaseLayerName(JPH::BroadPhaseLayer) const override { return "all"; }
#endif
};

class Jolt {
public:
    explicit Jolt(const Surface &surface) {
        JPH::VertexList vertices;
        JPH::IndexedTriangleList triangles;
        for (const CrumpleVec3 &v : surface.vertices) vertices.push_back(JPH::Float3(v.x, v.y, v.z));
        for (size_t i = 0; i < surface.indices.size(); i += 3)
            triangles.push_back(JPH::IndexedTriangle(surface.indices[i], surface.indices[i + 1], surface.indices[i + 2], 0));
        shape_ = JPH::MeshShapeSettings(vertices, triangles).Create().Get();
    }

    void strike(const Throw &thrown, crumple::Context &context, CrumpleInstance instance) {
        const OneBroadLayer layer;
        const JPH::ObjectVsBroadPhaseLayerFilter every_layer;
        const JPH::ObjectLayerPairFilter every_pair;
        JPH::PhysicsSystem system;
        system.Init(16, 0, 64, 1024, layer, every_layer, every_pair);
        system.SetGravity(JPH::Vec3::sZero());
        JoltContacts contacts(context, 1 / thrown.hz);
        system.SetContactListener(&contacts);
        JPH::BodyInterface &bodies = system.GetBodyInterface();
        JPH::BodyCreationSettings still(shape_, JPH::RVec3::sZero(), JPH::Quat::sIdentity(), JPH::EMotionType::Static, 0);
        still.mFriction = thrown.friction; // Jolt takes the root of the product
        contacts.dent(bodies.CreateAndAddBody(still, JPH::EActivation::DontActivate), instance);
        JPH::ShapeRefC shape;
        if (thrown.shape == "ball")
            shape = new JPH::SphereShape(thrown.half);
        else
            shape = new JPH::BoxShape(JPH::Vec3::sReplicate(thrown.half));
        const JPH::Vec3 place(thrown.place[0], thrown.place[1], thrown.place[2]);
        const JPH::Quat turn(thrown.turn[0], thrown.turn[1], thrown.turn[2], thrown.turn[3]);
        JPH::BodyCreationSettings striker(shape, JPH::RVec3(place), turn, JPH::EMotionType::Dynamic, 0);
        striker.mLinearVelocity = JPH::Vec3(thrown.velocity[0], thrown.velocity[1], thrown.velocity[2]);
        striker.mLinearDamping = striker.mAngularDamping = 0;
        striker.mMotionQuality = JPH::EMotionQuality::LinearCast;
        striker.mFriction = thrown.friction;
        striker.mRestitution = 0;
        striker.mAllowSleeping = false;
        striker.mOverrideMassProperties = JPH::EOverrideMassProperties::CalculateInertia;
        striker.mMassPropertiesOverride.mMass = thrown.mass;
        bodies.CreateAndAddBody(striker, JPH::EActivation::Activate);
        for (float time = 0; time < thrown.seconds; time += 1 / thrown.hz) {
            system.Update(1 / thrown.hz, 1, &memory_, &jobs_);
            contacts.step();
        }
    }

private:
    JPH::ShapeRefC shape_;
    JPH::TempAllocatorMalloc memory_;
    JPH::JobSystemSingleThreaded jobs_{JPH::cMaxPhysicsJobs};
};

} // namespace

int main(int argc, char **argv) {
    JPH::RegisterDefaultAllocator();
    JPH::Factory::sInstance = new JPH::Factory();
    JPH::RegisterTypes();
    const int status = throws_main<Jolt>(argc, argv);
    JPH::UnregisterTypes();
    delete JPH::Factory::sInstance;
    return status;
}
