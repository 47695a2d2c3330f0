// Gives every contact of a Jolt physics system to Crumple. Copy this file into your game.
#ifndef JOLT_CONTACTS_HPP
#define JOLT_CONTACTS_HPP

#include <crumple.hpp>

#include <Jolt/Jolt.h>

#include <Jolt/Physics/Body/Body.h>
#include <Jolt/Physics/Collision/CastResult.h>
#include <Jolt/Physics/Collision/ContactListener.h>
#include <Jolt/Physics/Collision/EstimateCollisionResponse.h>
#include <Jolt/Physics/Collision/RayCast.h>
#include <Jolt/Physics/Collision/Shape/SphereShape.h>

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
        const Advance advance(a, b, manifold, seconds_);
        const JPH::Vec3 normal = manifold.mWorldSpaceNormal; // from a to b
        JPH::ContactManifold there = manifold;
        there.mBaseOffset -= advance.way;
        JPH::CollisionEstimationResult estimate;
        JPH::EstimateCollisionResponse(a, b, there, estimate, 0, 0);
        float impulse = 0, weighted = 0;
        for (JPH::uint i = 0; i < estimate.mImpulses.size(); ++i) {
            impulse += estimate.mImpulses[i].mContactImpulse;
            weighted -= estimate.mImpulses[i].mContactImpulse * advance.velocity(a, b, manifold.GetWorldSpaceContactPointOn1(i)).Dot(normal);
        }
        if (impulse <= 0 || weighted <= 0) return;
        const uint64_t numbers[] = {a.GetID().GetIndexAndSequenceNumber(), b.GetID().GetIndexAndSequenceNumber()};
        point.pair = numbers[0] << 32 | numbers[1];
        point.normal = to_crumple(normal);
        point.masses[0] = mass_of(a);
        point.masses[1] = mass_of(b);
        point.inverse_mass = weighted / (impulse * impulse);
        point.has_velocity = true;
        tell_shape(*a.GetShape(), point, 0);
        tell_shape(*b.GetShape(), point, 1);
        CrumpleContactPointDef points[64];
        size_t count = 0;
        for (JPH::uint i = 0; i < manifold.mRelativeContactPointsOn1.size(); ++i) {
            const JPH::RVec3 on_a = manifold.GetWorldSpaceContactPointOn1(i), on_b = manifold.GetWorldSpaceContactPointOn2(i);
            const JPH::Vec3 velocity = advance.velocity(a, b, on_a);
            // Jolt tells of points that are near. Those that do not meet within the step do not touch.
            if (JPH::Vec3(on_b - on_a).Dot(normal) > -velocity.Dot(normal) * seconds_) continue;
            point.point = to_crumple(JPH::Vec3(on_a));
            point.velocity = to_crumple(velocity);
            points[count++] = point;
        }
        // A callback must not throw; what is wrong is counted by the next report.
        if (count > 0 && !context_.report_contacts(points, count).ok()) JPH::Trace("Crumple: %s", crumple_last_error());
    }

    // Continuous collision detection tells of a contact before it moves the body there. Levers are right from where the body will be.
    struct Advance {
        JPH::Vec3 way = JPH::Vec3::sZero(); // of the body that is cast, relative to the other
        bool of_a;

        Advance(const JPH::Body &a, const JPH::Body &b, const JPH::ContactManifold &manifold, float seconds)
            : of_a(a.GetCenterOfMassPosition() == manifold.mBaseOffset) {
            const JPH::Body &cast = of_a ? a : b, &other = of_a ? b : a;
            if (!cast.IsDynamic() || cast.GetMotionProperties()->GetMotionQuality() != JPH::EMotionQuality::LinearCast) return;
            // From a point just inside the body at the contact, back to where that point is now.
            const JPH::Vec3 whole = (cast.GetLinearVelocity() - other.GetLinearVelocity()) * seconds;
            const JPH::Vec3 inside = manifold.mWorldSpaceNormal * (of_a ? -1e-3f : 1e-3f);
            const JPH::RRayCast back(manifold.GetWorldSpaceContactPointOn1(0) + inside, -whole);
            JPH::RayCastResult hit;
            if (cast.GetTransformedShape().CastRay(back, hit)) way = whole * hit.mFraction;
        }

        // Of b relative to a.
        JPH::Vec3 velocity(const JPH::Body &a, const JPH::Body &b, JPH::RVec3Arg place) const {
            return b.GetPointVelocity(of_a ? place : place - way) - a.GetPointVelocity(of_a ? place - way : place);
        }
    };

    // Examples tell what struck them, and a set predicts better if hits do, too.
    static void tell_shape(const JPH::Shape &shape, CrumpleContactPointDef &point, int side) {
        if (shape.GetSubType() != JPH::EShapeSubType::Sphere) return;
        point.shapes[side] = CRUMPLE_STRIKER_SHAPE_BALL;
        point.radii[side] = static_cast<const JPH::SphereShape &>(shape).GetRadius();
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
