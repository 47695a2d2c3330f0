// Gives every contact of an ODE world to Crumple. Copy this file into your game.
#ifndef ODE_CONTACTS_HPP
#define ODE_CONTACTS_HPP

#include <crumple.hpp>

#include <ode/ode.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <unordered_map>
#include <vector>

// Moves an instance with its body. x, y, z is the origin of the mesh in the body's space. Call it before each step of the world.
inline void follow_body(crumple::Instance &instance, dBodyID body, dReal x = 0, dReal y = 0, dReal z = 0) {
    dVector3 at;
    dBodyGetRelPointPos(body, x, y, z, at);
    const dReal *r = dBodyGetRotation(body); // three rows of four
    const float transform[16] = {float(r[0]),  float(r[4]),  float(r[8]),  0, float(r[1]),  float(r[5]),  float(r[9]),  0,
                                 float(r[2]),  float(r[6]),  float(r[10]), 0, float(at[0]), float(at[1]), float(at[2]), 1};
    instance.set_transform(transform).value();
}

class OdeContacts {
public:
    explicit OdeContacts(crumple::Context &context) : context_(context) {}

    // Lets a geom dent. One that moves needs follow_body() before each step of the world.
    void dent(dGeomID geom, CrumpleInstance instance) { instances_[geom] = instance; }
    // Call it before a geom or its instance goes.
    void forget(dGeomID geom) { instances_.erase(geom); }

    // Call it in your near callback, for each contact joint: the velocities are then those before the step.
    void add(dJointID joint, const dContactGeom &contact) {
        const dGeomID a = contact.g1, b = contact.g2;
        if (instances_.count(a) + instances_.count(b) == 0) return;
        waiting_.emplace_back();
        Waiting &waiting = waiting_.back();
        dJointSetFeedback(joint, &waiting.feedback);
        CrumpleContactPointDef &point = waiting.point = crumple_contact_point_def_default();
        point.pair = uint64_t(std::min(number(a), number(b))) << 32 | std::max(number(a), number(b));
        point.bodies[0] = instance_of(a);
        point.bodies[1] = instance_of(b);
        point.point = to_crumple(contact.pos);
        const dReal out[] = {-contact.normal[0], -contact.normal[1], -contact.normal[2]}; // ODE's is from b to a
        point.normal = to_crumple(out);
        dVector3 va, vb;
        velocity(a, contact.pos, va);
        velocity(b, contact.pos, vb);
        const dReal relative[] = {vb[0] - va[0], vb[1] - va[1], vb[2] - va[2]};
        point.has_velocity = true;
        point.velocity = to_crumple(relative);
        point.masses[0] = mass_of(a);
        point.masses[1] = mass_of(b);
        tell_shape(a, point, 0);
        tell_shape(b, point, 1);
    }

    // Call it after dWorldStep() or dWorldQuickStep(), before you destroy the joints.
    void step(dReal seconds) {
        points_.clear();
        for (Waiting &waiting : waiting_) {
            const CrumpleVec3 n = waiting.point.normal;
            const dReal *force = waiting.feedback.f1; // on the joint's first body, which may be either
            waiting.point.impulse = float(std::fabs(force[0] * n.x + force[1] * n.y + force[2] * n.z) * seconds);
            points_.push_back(waiting.point);
        }
        waiting_.clear();
        context_.report_contacts(points_.data(), points_.size()).value();
        context_.step_contacts(float(seconds)).value();
    }

private:
    struct Waiting {
        CrumpleContactPointDef point;
        dJointFeedback feedback{};
    };

    // A number that the geom keeps.
    uint32_t number(dGeomID geom) { return numbers_.emplace(geom, uint32_t(numbers_.size())).first->second; }
    // Examples tell what struck them, and a set predicts better if hits do, too.
    static void tell_shape(dGeomID geom, CrumpleContactPointDef &point, int side) {
        if (dGeomGetClass(geom) != dSphereClass) return;
        point.shapes[side] = CRUMPLE_STRIKER_SHAPE_BALL;
        point.radii[side] = float(dGeomSphereGetRadius(geom));
    }
    CrumpleInstance instance_of(dGeomID geom) const {
        const auto found = instances_.find(geom);
        return found == instances_.end() ? CrumpleInstance{} : found->second;
    }
    static float mass_of(dGeomID geom) {
        const dBodyID body = dGeomGetBody(geom);
        if (!body || dBodyIsKinematic(body)) return INFINITY;
        dMass mass;
        dBodyGetMass(body, &mass);
        return float(mass.mass);
    }
    static void velocity(dGeomID geom, const dReal *at, dVector3 out) {
        out[0] = out[1] = out[2] = 0;
        if (const dBodyID body = dGeomGetBody(geom)) dBodyGetPointVel(body, at[0], at[1], at[2], out);
    }
    static CrumpleVec3 to_crumple(const dReal *v) { return {float(v[0]), float(v[1]), float(v[2])}; }

    crumple::Context &context_;
    std::unordered_map<dGeomID, CrumpleInstance> instances_;
    std::unordered_map<dGeomID, uint32_t> numbers_;
    std::deque<Waiting> waiting_; // joints keep pointers into it
    std::vector<CrumpleContactPointDef> points_;
};

#endif
