// Gives every contact of a Bullet world to Crumple. Copy this file into your game.
#ifndef BULLET_CONTACTS_HPP
#define BULLET_CONTACTS_HPP

#include <crumple.hpp>

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

// Uses the world's two tick callbacks and its user info. Outlives no step of the world.
class BulletContacts {
public:
    BulletContacts(btDynamicsWorld &world, crumple::Context &context) : world_(world), context_(context) {
        world.setInternalTickCallback(before_step, this, true);
        world.setInternalTickCallback(after_step, this, false);
    }
    ~BulletContacts() {
        world_.setInternalTickCallback(nullptr, nullptr, true);
        world_.setInternalTickCallback(nullptr, nullptr, false);
    }
    BulletContacts(const BulletContacts &) = delete;
    BulletContacts &operator=(const BulletContacts &) = delete;

    // Lets a body dent. A body that moves needs crumple::Instance::set_transform() before each step of the world.
    void dent(const btCollisionObject &body, CrumpleInstance instance) { instances_[&body] = instance; }
    // Call it before a body or its instance goes.
    void forget(const btCollisionObject &body) { instances_.erase(&body); }

private:
    struct Motion {
        btVector3 linear, angular, centre;
    };

    // Bullet's contacts come with the velocities after the solver, and a blow needs those before it.
    static void before_step(btDynamicsWorld *world, btScalar) {
        auto &self = *static_cast<BulletContacts *>(world->getWorldUserInfo());
        self.motions_.clear();
        for (int i = 0; i < world->getNumCollisionObjects(); ++i)
            if (const auto *body = btRigidBody::upcast(world->getCollisionObjectArray()[i]))
                self.motions_[body] = {body->getLinearVelocity(), body->getAngularVelocity(), body->getWorldTransform().getOrigin()};
    }

    static void after_step(btDynamicsWorld *world, btScalar seconds) {
        auto &self = *static_cast<BulletContacts *>(world->getWorldUserInfo());
        self.points_.clear();
        btDispatcher &dispatcher = *world->getDispatcher();
        for (int i = 0; i < dispatcher.getNumManifolds(); ++i) self.add(*dispatcher.getManifoldByIndexInternal(i));
        self.context_.report_contacts(self.points_.data(), self.points_.size()).value();
        self.context_.step_contacts(seconds).value();
    }

    void add(const btPersistentManifold &manifold) {
        const btCollisionObject *a = manifold.getBody0(), *b = manifold.getBody1();
        if (instances_.count(a) + instances_.count(b) == 0) return;
        CrumpleContactPointDef point = crumple_contact_point_def_default();
        point.bodies[0] = instance_of(a);
        point.bodies[1] = instance_of(b);
        const auto number = [](const btCollisionObject *body) { return uint64_t(uint32_t(body->getBroadphaseHandle()->getUid())); };
        point.pair = std::min(number(a), number(b)) << 32 | std::max(number(a), number(b));
        point.masses[0] = mass_of(a);
        point.masses[1] = mass_of(b);
        point.has_velocity = true;
        tell_shape(*a->getCollisionShape(), point, 0);
        tell_shape(*b->getCollisionShape(), point, 1);
        for (int i = 0; i < manifold.getNumContacts(); ++i) {
            const btManifoldPoint &contact = manifold.getContactPoint(i);
            // Points that do not touch yet push too, if the bodies would meet within the step.
            if (contact.getAppliedImpulse() <= 0) continue;
            btVector3 place = contact.getPositionWorldOnB();
            // Continuous collision detection gives the centre of the swept sphere instead of its surface.
            if (contact.m_localPointA.fuzzyZero()) place -= contact.m_normalWorldOnB * a->getCcdSweptSphereRadius();
            point.point = to_crumple(place);
            point.normal = to_crumple(-contact.m_normalWorldOnB); // Bullet's is from body 1 to body 0
            point.velocity = to_crumple(velocity_at(b, place) - velocity_at(a, place));
            point.impulse = float(contact.getAppliedImpulse());
            points_.push_back(point);
        }
    }

    // Examples tell what struck them, and a set predicts better if hits do, too.
    static void tell_shape(const btCollisionShape &shape, CrumpleContactPointDef &point, int side) {
        if (shape.getShapeType() != SPHERE_SHAPE_PROXYTYPE) return;
        point.shapes[side] = CRUMPLE_STRIKER_SHAPE_BALL;
        point.radii[side] = float(static_cast<const btSphereShape &>(shape).getRadius());
    }
    CrumpleInstance instance_of(const btCollisionObject *body) const {
        const auto found = instances_.find(body);
        return found == instances_.end() ? CrumpleInstance{} : found->second;
    }
    static float mass_of(const btCollisionObject *object) {
        const auto *body = btRigidBody::upcast(object);
        return body && body->getInvMass() > 0 ? float(1 / body->getInvMass()) : INFINITY;
    }
    btVector3 velocity_at(const btCollisionObject *body, const btVector3 &place) const {
        const auto found = motions_.find(body);
        if (found == motions_.end()) return btVector3(0, 0, 0);
        return found->second.linear + found->second.angular.cross(place - found->second.centre);
    }
    static CrumpleVec3 to_crumple(const btVector3 &v) { return {float(v.x()), float(v.y()), float(v.z())}; }

    btDynamicsWorld &world_;
    crumple::Context &context_;
    std::unordered_map<const btCollisionObject *, CrumpleInstance> instances_;
    std::unordered_map<const btCollisionObject *, Motion> motions_;
    std::vector<CrumpleContactPointDef> points_;
};

#endif
