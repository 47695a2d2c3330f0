// The lab's throws in Jolt.
#include "../../examples-c/jolt_contacts.hpp"
#include "../../examples-c/jolt_world.hpp"
#include "throws.hpp"

#include <Jolt/Core/JobSystemSingleThreaded.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Collision/Shape/BoxShape.h>
#include <Jolt/Physics/Collision/Shape/SphereShape.h>

namespace {

class Jolt {
public:
    explicit Jolt(const Surface &surface) : shape_(jolt_mesh(surface.vertices, surface.indices)) {}

    void strike(const Throw &thrown, crumple::Context &context, CrumpleInstance instance) {
        JoltWorld world;
        JPH::PhysicsSystem &system = world.system;
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
    const JoltTypes types;
    return throws_main<Jolt>(argc, argv);
}
