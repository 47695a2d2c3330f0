// Throws balls and boxes at a fixed body in Bullet, and writes what they leave. The lab starts it.
//
//     throw SET.crumple THROWS OUT
//
// A line of THROWS is: "ball" or "box", half of its width, its mass, the rate of steps, the seconds, the friction, the depth limit,
// its place, its velocity and its rotation (x y z w). OUT gets for each throw the first mark's vertex (or UINT32_MAX) and the
// displacement of every vertex.
#include "../../examples-c/bullet_contacts.hpp"

#include <BulletCollision/CollisionDispatch/btInternalEdgeUtility.h>

#include <cstdio>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

namespace {

struct Throw {
    std::string shape;
    float half, mass, hz, seconds, friction, depth_limit;
    float place[3], velocity[3], turn[4];

    bool read(std::istream &in) {
        in >> shape >> half >> mass >> hz >> seconds >> friction >> depth_limit;
        for (float &x : place) in >> x;
        for (float &x : velocity) in >> x;
        for (float &x : turn) in >> x;
        return bool(in);
    }
};

// Without this, a ball that sinks into a mesh is pushed away from edges inside of a smooth surface.
bool on_added(btManifoldPoint &point, const btCollisionObjectWrapper *a, int part_a, int index_a, const btCollisionObjectWrapper *b,
              int part_b, int index_b) {
    if (b->getCollisionShape()->getShapeType() == TRIANGLE_SHAPE_PROXYTYPE)
        btAdjustInternalEdgeContacts(point, b, a, part_b, index_b);
    else
        btAdjustInternalEdgeContacts(point, a, b, part_a, index_a);
    return true;
}

void run(const char *set_file, const char *list, const char *out_file) {
    crumple::Context context;
    const crumple::ExampleSet set = context.load_baked(set_file).value();
    const CrumpleExampleSetInfo info = set.info().value();
    std::vector<CrumpleVec3> rest(info.vertex_count), dented(info.vertex_count);
    std::vector<uint32_t> indices(size_t(info.triangle_count) * 3);
    CrumpleMeshCopyDef copy = crumple_mesh_copy_def_default();
    copy.positions = crumple::stream(rest);
    copy.indices = crumple::stream(indices);
    set.copy_mesh(copy).value();
    btTriangleIndexVertexArray triangles(int(info.triangle_count), reinterpret_cast<int *>(indices.data()), 3 * sizeof(uint32_t),
                                         int(info.vertex_count), &rest[0].x, sizeof(CrumpleVec3));
    btBvhTriangleMeshShape body_shape(&triangles, true);
    body_shape.setMargin(0);
    btTriangleInfoMap edges;
    btGenerateInternalEdgeInfo(&body_shape, &edges);
    gContactAddedCallback = on_added;

    std::ifstream in(list);
    std::ofstream out(out_file, std::ios::binary);
    for (std::string line; std::getline(in, line);) {
        Throw thrown;
        std::istringstream words(line);
        if (!thrown.read(words)) {
            std::fprintf(stderr, "this line has too few words: %s\n", line.c_str());
            std::exit(1);
        }
        CrumpleInstanceDef def = crumple_instance_def_default();
        def.set = set.id();
        def.depth_limit = thrown.depth_limit;
        crumple::Instance instance = context.create_instance(def).value();
        const crumple::Buffer buffer = instance.register_buffer(crumple::stream(dented)).value();

        btDefaultCollisionConfiguration configuration;
        btCollisionDispatcher dispatcher(&configuration);
        btDbvtBroadphase broadphase;
        btSequentialImpulseConstraintSolver solver;
        btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
        world.setGravity({0, 0, 0});
        btRigidBody body(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &body_shape));
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
            contacts.dent(body, instance.id());
            for (float time = 0; time < thrown.seconds; time += 1 / thrown.hz) world.stepSimulation(1 / thrown.hz, 0);
        }
        context.clear_contacts().value();
        world.removeRigidBody(&striker);
        world.removeRigidBody(&body);

        context.deform().value();
        const std::vector<CrumpleMark> marks = instance.marks().value();
        const uint32_t contact = marks.empty() ? UINT32_MAX : marks[0].contact;
        out.write(reinterpret_cast<const char *>(&contact), sizeof contact);
        for (size_t v = 0; v < dented.size(); ++v) {
            const float moved[3] = {dented[v].x - rest[v].x, dented[v].y - rest[v].y, dented[v].z - rest[v].z};
            out.write(reinterpret_cast<const char *>(moved), sizeof moved);
        }
    }
    if (context.contact_totals().value().refused != 0 || !out.flush()) {
        std::fprintf(stderr, "a hit was refused, or %s cannot be written\n", out_file);
        std::exit(1);
    }
}

} // namespace

int main(int argc, char **argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: throw SET.crumple THROWS OUT\n");
        return 2;
    }
    try {
        run(argv[1], argv[2], argv[3]);
    } catch (const crumple::Error &error) {
        std::fprintf(stderr, "%s: %s\n", crumple_result_name(error.result()), error.what());
        return 1;
    }
}
