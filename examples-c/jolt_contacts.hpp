// Gives every contact of a Jolt physics system to Crumple. Copy this file into your game.
#ifndef JOLT_CONTACTS_HPP
#define JOLT_CONTACTS_HPP

#include <crumple.hpp>

#include <Jolt/Jolt.h>

#include <Jolt/Physics/Body/Body.h>
#include <Jolt/Physics/Collision/ContactListener.h>
#include <Jolt/Physics/Collision/EstimateCollisionResponse.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

// Give it to PhysicsSystem::SetContactListener(), and call step() after each PhysicsSystem::Update() of one collision step.
class JoltContacts : public JPH::ContactListener {
public:
    // seconds is the time of a step of the physics.
    JoltContacts(crumple::Context &context, float seconds) : context_(context), seconds_(seconds) {}

    // Lets a body dent. One that moves needs crumple::Instance::set_transform() before each update. Not during an update.
    void dent(JPH::BodyID body, CrumpleInstance instance) { instances_[body.GetIndexAndSequenceNumber()] = instance; }
    // Call it before a body or its instance goes.
    void forget(JPH::BodyID body) { instances_.erase(body.GetIndexAndSequenceNumber()); }

    void step() { context_.step_contacts(seconds_).value(); }

    void OnContactAdded(const JPH::Body &a, const JPH::Body &b, const JPH::ContactManifold &manifold, JPH::ContactSettings &) override {
        report(a, b, manifold);
    }
    void OnContactPersisted(const JPH::Body &a, const JPH::Body &b, const JPH::ContactManifold &manifold, JPH::ContactSettings &) override {
        report(a, b, manifold);
    }

private:
    // Jolt calls from its own threads, before the solver: velocities are those before the step, and there is no impulse yet. The
    // layer takes it that the bodies stop each other. How much mass is behind that is what Jolt's estimate tells.
    void report(const JPH::Body &a, const JPH::Body &b, const JPH::ContactManifold &manifold) {
        CrumpleContactPointDef point = crumple_contact_point_def_default();
        point.bodies[0] = instance_of(a);
        point.bodies[1] = instance_of(b);
        if (point.bodies[0].generation == 0 && point.bodies[1].generation == 0) return;
        JPH::CollisionEstimationResult estimate;
        JPH::EstimateCollisionResponse(a, b, manifold, estimate, 0, 0);
        const JPH::Vec3 normal = manifold.mWorldSpaceNormal; // from a to b
        float impulse = 0, weighted = 0;
        for (JPH::uint i = 0; i < estimate.mImpulses.size(); ++i) {
            impulse += estimate.mImpulses[i].mContactImpulse;
            weighted += estimate.mImpulses[i].mContactImpulse * approach(a, b, manifold, i);
        }
        if (impulse <= 0 || weighted <= 0) return;
        const uint64_t numbers[] = {a.GetID().GetIndexAndSequenceNumber(), b.GetID().GetIndexAndSequenceNumber()};
        point.pair = numbers[0] << 32 | numbers[1];
        point.normal = to_crumple(normal);
        point.masses[0] = mass_of(a);
        point.masses[1] = mass_of(b);
        point.inverse_mass = weighted / (impulse * impulse);
        point.has_velocity = true;
        CrumpleContactPointDef points[64];
        size_t count = 0;
        for (JPH::uint i = 0; i < manifold.mRelativeContactPointsOn1.size(); ++i) {
            const JPH::RVec3 on_a = manifold.GetWorldSpaceContactPointOn1(i), on_b = manifold.GetWorldSpaceContactPointOn2(i);
            // Jolt tells of points that are near. Those that do not meet within the step do not touch.
            if (JPH::Vec3(on_b - on_a).Dot(normal) > approach(a, b, manifold, i) * seconds_) continue;
            point.point = to_crumple(JPH::Vec3(on_a));
            point.velocity = to_crumple(b.GetPointVelocity(on_a) - a.GetPointVelocity(on_a));
            points[count++] = point;
        }
        // A callback must not throw; what is wrong is counted by the next report.
        if (count > 0 && !context_.report_contacts(points, count).ok()) JPH::Trace("Crumple: %s", crumple_last_error());
    }

    static float approach(const JPH::Body &a, const JPH::Body &b, const JPH::ContactManifold &manifold, JPH::uint i) {
        const JPH::RVec3 place = manifold.GetWorldSpaceContactPointOn1(i);
        return (a.GetPointVelocity(place) - b.GetPointVelocity(place)).Dot(manifold.mWorldSpaceNormal);
    }
    CrumpleInstance instance_of(const JPH::Body &body) const {
        const auto found = instances_.find(body.GetID().GetIndexAndSequenceNumber());
        return found == instances_.end() ? CrumpleInstance{} : found->second;
    }
    static float mass_of(const JPH::Body &body) {
        return body.IsDynamic() ? 1 / body.GetMotionProperties()->GetInverseMass() : INFINITY;
    }
    static CrumpleVec3 to_crumple(JPH::Vec3Arg v) { return {v.GetX(), v.GetY(), v.GetZ()}; }

    crumple::Context &context_;
    float seconds_;
    std::unordered_map<uint32_t, CrumpleInstance> instances_;
};

#endif
