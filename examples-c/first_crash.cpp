// A ball falls onto a hood in Bullet, and the hood is dented.
//
//     first_crash HOOD.glb OUT.obj
#include "bullet_contacts.hpp"

#include <cstdio>
#include <fstream>
#include <vector>

namespace {

constexpr float STEP = 1.0f / 60; // s
constexpr float RADIUS = 0.09f, MASS = 6, SPEED = 6; // of the ball: m, kg, m/s

bool fact(bool holds, const char *what) {
    if (!holds) std::fprintf(stderr, "this is not so: %s\n", what);
    return holds;
}

bool run(const char *hood_file, const char *out_file) {
    // 1. Crumple: the hood with its examples, one body of it, and the vertices that you draw.
    crumple::Context context;
    const crumple::ExampleSet set = context.load_gltf(hood_file).value();
    const CrumpleExampleSetInfo info = set.info().value();
    std::vector<CrumpleVec3> rest(info.vertex_count), drawn(info.vertex_count);
    std::vector<uint32_t> indices(size_t(info.triangle_count) * 3);
    CrumpleMeshCopyDef copy = crumple_mesh_copy_def_default();
    copy.positions = crumple::stream(rest);
    copy.indices = crumple::stream(indices);
    set.copy_mesh(copy).value();
    crumple::Instance hood = context.create_instance(set).value();
    const crumple::Buffer buffer = hood.register_buffer(crumple::stream(drawn)).value();

    // 2. Bullet: the hood stands still, the ball is thrown down at it.
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    world.setGravity({0, 0, -9.81f});
    btTriangleIndexVertexArray triangles(int(info.triangle_count), reinterpret_cast<int *>(indices.data()), 3 * sizeof(uint32_t),
                                         int(info.vertex_count), &rest[0].x, sizeof(CrumpleVec3));
    btBvhTriangleMeshShape hood_shape(&triangles, true);
    btRigidBody hood_body(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &hood_shape));
    world.addRigidBody(&hood_body);
    btSphereShape ball_shape(RADIUS);
    btVector3 inertia;
    ball_shape.calculateLocalInertia(MASS, inertia);
    btRigidBody ball(btRigidBody::btRigidBodyConstructionInfo(MASS, nullptr, &ball_shape, inertia));
    ball.setWorldTransform(btTransform(btQuaternion::getIdentity(), {0.1f, 0.15f, 0.6f}));
    ball.setLinearVelocity({0, 0, -SPEED});
    // Without it a fast ball passes through the metal between two steps.
    ball.setCcdMotionThreshold(RADIUS / 2);
    ball.setCcdSweptSphereRadius(RADIUS);
    world.addRigidBody(&ball);

    // 3. The two together: every contact of the world goes to Crumple.
    bool right = true;
    {
        BulletContacts contacts(world, context);
        contacts.dent(hood_body, hood.id());
        for (int step = 0; step < 60; ++step) {
            world.stepSimulation(STEP, 0);
            context.deform().value(); // writes the vertices that changed
        }
        const CrumpleContactReport totals = context.contact_totals().value();
        std::printf("%llu contact points made %llu touches\n", static_cast<unsigned long long>(totals.points),
                    static_cast<unsigned long long>(totals.begun));
        right &= fact(totals.refused == 0, "no hit was refused");
    }

    // What the same blow leaves that is told in one piece.
    float deepest = 0;
    size_t at = 0;
    for (size_t v = 0; v < drawn.size(); ++v)
        if (const float depth = rest[v].z - drawn[v].z; depth > deepest) deepest = depth, at = v;
    std::printf("the dent is %.1f mm deep at (%.2f, %.2f)\n", double(1000 * deepest), double(rest[at].x), double(rest[at].y));
    right &= fact(deepest > 0.005f && deepest <= info.depth_limit, "there is a dent, within the depth limit");
    right &= fact(std::hypot(rest[at].x - 0.1f, rest[at].y - 0.15f) < 0.06f, "it is where the ball fell");

    // 4. The dented hood as a file.
    std::ofstream file(out_file);
    for (const CrumpleVec3 &v : drawn) file << "v " << v.x << ' ' << v.y << ' ' << v.z << '\n';
    for (size_t i = 0; i < indices.size(); i += 3)
        file << "f " << indices[i] + 1 << ' ' << indices[i + 1] + 1 << ' ' << indices[i + 2] + 1 << '\n';
    return right & fact(bool(file.flush()), "the file was written");
}

} // namespace

int main(int argc, char **argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: first_crash HOOD.glb OUT.obj\n");
        return 2;
    }
    try {
        return run(argv[1], argv[2]) ? 0 : 1;
    } catch (const crumple::Error &error) {
        std::fprintf(stderr, "%s: %s\n", crumple_result_name(error.result()), error.what());
        return 1;
    }
}
