// What a program with ODE needs around ode_contacts.hpp, as small as it can be: a world that makes contacts and takes steps.
#ifndef ODE_WORLD_HPP
#define ODE_WORLD_HPP

#include "ode_contacts.hpp"

#include <array>
#include <functional>
#include <utility>

struct OdeWorld {
    int open = dInitODE2(0);
    dWorldID world = dWorldCreate();
    dSpaceID space = dHashSpaceCreate(nullptr);
    dJointGroupID joints = dJointGroupCreate(0);
    OdeContacts contacts;
    std::function<void(dContact &contact, int count)> surface; // fills in a contact, which is one of so many of its two geoms

    OdeWorld(crumple::Context &context, double gravity_y, double gravity_z, std::function<void(dContact &, int)> surface_)
        : contacts(context), surface(std::move(surface_)) {
        dWorldSetGravity(world, 0, gravity_y, gravity_z);
    }
    ~OdeWorld() {
        dJointGroupDestroy(joints);
        dSpaceDestroy(space);
        dWorldDestroy(world);
        dCloseODE();
    }
    OdeWorld(const OdeWorld &) = delete;
    OdeWorld &operator=(const OdeWorld &) = delete;

    void step(double seconds) {
        dSpaceCollide(space, this, near);
        dWorldStep(world, seconds);
        contacts.step(seconds);
        dJointGroupEmpty(joints);
    }

private:
    static void near(void *user, dGeomID a, dGeomID b) {
        auto &self = *static_cast<OdeWorld *>(user);
        if (dGeomGetBody(a) == dGeomGetBody(b)) return;
        std::array<dContactGeom, 16> found;
        const int count = dCollide(a, b, int(found.size()), found.data(), sizeof found[0]);
        for (int i = 0; i < count; ++i) {
            dContact contact{};
            contact.geom = found[size_t(i)];
            self.surface(contact, count);
            const dJointID joint = dJointCreateContact(self.world, self.joints, &contact);
            dJointAttach(joint, dGeomGetBody(a), dGeomGetBody(b));
            self.contacts.add(joint, contact.geom);
        }
    }
};

#endif
