// The lab's throws in Bullet.
#include "../../examples-c/bullet_contacts.hpp"
#include "throws.hpp"

#include <BulletCollision/CollisionDispatch/btInternalEdgeUtility.h>

#include <memory>

namespace {

// Without this, a ball that sinks into a mesh is pushed away from edges inside of a smooth surface.
bool on_added(btManifoldPoint &point, const btCollisionObjectWrapper *a, int part_a, int index_a, const btCollisionObjectWrapper *b,
              int part_b, int index_b) {
    if (b->getCollisionShape()->getShapeType() == TRIANGLE_SHAPE_PROXYTYPE)
        btAdjustInternalEdgeContacts(point, b, a, part_b, index_b);
    else
        btAdjustInternalEdgeContacts(point, a, b, part_a, index_a);
    return true;
}

class Bullet {
public:
    explicit Bullet(const Surface &surface)
        : vertices_(surface.vertices), indices_(surface.indices.begin(), surface.indices.end()),
          triangles_(int(indices_.size() / 3), indices_.data(), 3 * sizeof(int), int(vertices_.size()), &vertices_[0].x, sizeof(CrumpleVec3)),
          shape_(&triangles_, true) {
        shape_.setMargin(0);
        btGenerateInternalEdgeInfo(&shape_, &edges_);
        gContactAddedCallback = on_added;
    }

    void strike(const Throw &thrown, crumple::Context &context, CrumpleInstance instance) {
        btDefaultCollisionConfiguration configuration;
        btCollisionDispatcher dispatcher(&configuration);
        btDbvtBroadphase broadphase;
        btSequentialImpulseConstraintSolver solver;
        btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
        world.setGravity({0, 0, 0});
        btRigidBody body(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &shape_));
        body.setFriction(thrown.friction);
        body.setCollisionFlags(body.getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
        world.addRigidBody(&body);
        std::unique_ptr<btConvexInternalShape> shape;
        if (thrown.shape == "ball")
            shape = std::make_unique<btSphereShape>(thrown.half);
        else
            shape = std::make_unique<btBoxShape>(btVector3(thrown.half, thrown.half, thrown.half));
        btVector3 inertia;
        shape->calculateLocalInertia(thrown.mass, inertia);
        btRigidBody striker(btRigidBody::btRigidBodyConstructionInfo(thrown.mass, nullptr, shape.get(), inertia));
        striker.setWorldTransform(btTransform({thrown.turn[0], thrown.turn[1], thrown.turn[2], thrown.turn[3]},
                                              {thrown.place[0], thrown.place[1], thrown.place[2]}));
        striker.setLinearVelocity({thrown.velocity[0], thrown.velocity[1], thrown.velocity[2]});
        striker.setFriction(1); // Bullet multiplies the two
        striker.setActivationState(DISABLE_DEACTIVATION);
        striker.setCcdMotionThreshold(thrown.half / 2);
        striker.setCcdSweptSphereRadius(thrown.half);
        world.addRigidBody(&striker);
        {
            BulletContacts contacts(world, context);
            contacts.dent(body, instance);
            for (float time = 0; time < thrown.seconds; time += 1 / thrown.hz) world.stepSimulation(1 / thrown.hz, 0);
        }
        world.removeRigidBody(&striker);
        world.removeRigidBody(&body);
    }

private:
    std::vector<CrumpleVec3> vertices_;
    std::vector<int> indices_;
    btTriangleIndexVertexArray triangles_;
    btBvhTriangleMeshShape shape_;
    btTriangleInfoMap edges_;
};

} // namespace

int main(int argc, char **argv) { return throws_main<Bullet>(argc, argv); }
