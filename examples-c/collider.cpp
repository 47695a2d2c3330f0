// A ball dents a plate in Bullet, and the plate's collider follows by a partial refit. A second, small ball then comes to rest in
// the dent. Without the refit it falls through the plate: its triangles have left the boxes of the collider's tree.
//
//     collider
#include "bullet_contacts.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

namespace {

constexpr float STEP = 1.0f / 240, WIDTH = 1.2f; // s, m
constexpr int FINE = 96, COARSE = 21;            // squares along a side of the mesh that is drawn and of the collider

void fact(bool holds, const char *what) {
    if (holds) return;
    std::fprintf(stderr, "this is not so: %s\n", what);
    std::exit(1);
}

// A plate of n by n squares in the plane z = 0.
struct Grid {
    std::vector<CrumpleVec3> positions;
    std::vector<uint32_t> indices;

    explicit Grid(int n) {
        for (int i = 0; i <= n; ++i)
            for (int j = 0; j <= n; ++j) {
                const auto at = [&](int k) { return WIDTH * (float(k) / float(n) - 0.5f); };
                positions.push_back({at(j), at(i), 0});
                if (i == n || j == n) continue;
                const auto a = uint32_t(i * (n + 1) + j), b = a + uint32_t(n) + 1;
                indices.insert(indices.end(), {a, a + 1, b + 1, a, b + 1, b});
            }
    }
    CrumpleMeshDef def() const {
        CrumpleMeshDef mesh = crumple_mesh_def_default();
        mesh.vertex_count = uint32_t(positions.size());
        mesh.positions = crumple::input(positions);
        mesh.index_count = uint32_t(indices.size());
        mesh.indices = crumple::input(indices);
        return mesh;
    }
};

// The plate with one example, a dent 7 cm deep in its middle. Its level of detail 1 is the collider.
crumple::ExampleSet make_set(crumple::Context &context, const Grid &fine, const Grid &coarse) {
    std::vector<CrumpleVec3> target = fine.positions;
    for (CrumpleVec3 &p : target) {
        const float q = (p.x * p.x + p.y * p.y) / (0.3f * 0.3f);
        if (q < 1) p.z = -0.07f * (1 - q) * (1 - q);
    }
    CrumpleExampleDef example = crumple_example_def_default();
    example.target_positions = crumple::input(target);
    const CrumpleMeshDef mesh = fine.def();
    CrumpleExampleSetDef def = crumple_example_set_def_default();
    def.mesh = &mesh;
    def.examples = &example;
    def.example_count = 1;
    crumple::ExampleSet set = context.create_example_set(def).value();
    set.add_lod(coarse.def()).value();
    return set;
}

btVector3 to_bullet(const CrumpleVec3 &v) { return {v.x, v.y, v.z}; }

// Bullet reads the vertices where Crumple writes them.
struct Collider {
    std::vector<CrumpleVec3> vertices;
    btTriangleIndexVertexArray triangles;
    btVector3 corner; // of a box that no dent leaves
    std::unique_ptr<btBvhTriangleMeshShape> shape;

    Collider(const Grid &grid, float depth_limit)
        : vertices(grid.positions), corner(WIDTH / 2 + depth_limit, WIDTH / 2 + depth_limit, depth_limit) {
        btIndexedMesh mesh;
        mesh.m_numTriangles = int(grid.indices.size() / 3);
        mesh.m_triangleIndexBase = reinterpret_cast<const unsigned char *>(grid.indices.data());
        mesh.m_triangleIndexStride = 3 * sizeof(uint32_t);
        mesh.m_numVertices = int(vertices.size());
        mesh.m_vertexBase = reinterpret_cast<const unsigned char *>(vertices.data());
        mesh.m_vertexStride = sizeof(CrumpleVec3);
        mesh.m_vertexType = PHY_FLOAT;
        triangles.addIndexedMesh(mesh);
        build();
    }

    // The tree counts in shares of the box.
    void build() {
        shape = std::make_unique<btBvhTriangleMeshShape>(&triangles, true, -corner, corner);
        shape->setMargin(0);
        // A partial refit updates the boxes of the tree's parts, and only this way of looking begins with them.
        shape->getOptimizedBvh()->setTraversalMode(btQuantizedBvh::TRAVERSAL_STACKLESS_CACHE_FRIENDLY);
    }
};

struct Scene {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    std::unique_ptr<btRigidBody> plate;

    explicit Scene(Collider &collider) {
        world.setGravity({0, 0, -9.81f});
        plate = std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, collider.shape.get()));
        plate->setFriction(0.5f);
        world.addRigidBody(plate.get());
    }
    ~Scene() { world.removeRigidBody(plate.get()); }

    // Throws a ball for some seconds and takes it away. Returns where it ended.
    btVector3 throw_ball(float radius, float mass, const btVector3 &start, float seconds) {
        btSphereShape sphere(radius);
        btVector3 inertia;
        sphere.calculateLocalInertia(mass, inertia);
        btRigidBody ball(btRigidBody::btRigidBodyConstructionInfo(mass, nullptr, &sphere, inertia));
        ball.setWorldTransform(btTransform(btQuaternion::getIdentity(), start));
        ball.setDamping(0.3f, 0.9f);
        ball.setActivationState(DISABLE_DEACTIVATION);
        world.addRigidBody(&ball);
        for (float time = 0; time < seconds; time += STEP) world.stepSimulation(STEP, 0);
        world.removeRigidBody(&ball);
        return ball.getWorldTransform().getOrigin();
    }
};

// Distance from a point to a triangle mesh whose triangles are small, m: to the nearest of 45 points of each.
float distance_to(const std::vector<CrumpleVec3> &vertices, const std::vector<uint32_t> &indices, const btVector3 &point) {
    float nearest = WIDTH;
    for (size_t i = 0; i < indices.size(); i += 3) {
        const btVector3 a = to_bullet(vertices[indices[i]]);
        const btVector3 ab = to_bullet(vertices[indices[i + 1]]) - a, ac = to_bullet(vertices[indices[i + 2]]) - a;
        for (int u = 0; u <= 8; ++u)
            for (int v = 0; u + v <= 8; ++v) nearest = std::min(nearest, (a + ab * (float(u) / 8) + ac * (float(v) / 8)).distance(point));
    }
    return nearest;
}

// Median time of some runs, in microseconds. What prepare does is not counted.
template <class Prepare, class Run>
double microseconds(Prepare &&prepare, Run &&run) {
    std::vector<double> times;
    for (int i = 0; i < 101; ++i) {
        prepare();
        const auto start = std::chrono::steady_clock::now();
        run();
        times.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count());
    }
    std::nth_element(times.begin(), times.begin() + 50, times.end());
    return times[50];
}

void run() {
    crumple::Context context;
    const Grid fine(FINE), coarse(COARSE);
    const crumple::ExampleSet set = make_set(context, fine, coarse);
    CrumpleInstanceDef def = crumple_instance_def_default();
    def.set = set.id();
    def.compliance = 0.0025f; // m per N s
    crumple::Instance instance = context.create_instance(def).value();
    Collider collider(coarse, set.info().value().depth_limit);
    std::vector<CrumpleVec3> drawn(fine.positions);
    const crumple::Buffer drawn_buffer = instance.register_buffer(crumple::stream(drawn)).value();
    CrumpleHostBufferDef proxy = crumple_host_buffer_def_default();
    proxy.lod = 1;
    proxy.positions = crumple::stream(collider.vertices);
    const crumple::Buffer buffer = instance.register_buffer(proxy).value();
    context.deform().value();
    Scene scene(collider);

    // The first ball: its contacts make one dent.
    const btVector3 place(0.1f, 0.05f, 0);
    {
        BulletContacts contacts(scene.world, context);
        contacts.dent(*scene.plate, instance.id());
        scene.throw_ball(0.15f, 5, place + btVector3(0, 0, 0.9f), 0.6f);
    }
    context.deform().value();
    CrumpleAabb box;
    const std::vector<CrumpleRange> ranges = buffer.changed_triangles(&box).value();
    uint32_t changed = 0;
    for (const CrumpleRange &range : ranges) changed += range.count;
    std::printf("the dent is %.1f mm deep; %u of %zu triangles changed\n", double(-1000 * box.min.z), changed, coarse.indices.size() / 3);
    // 5 kg at 3.6 m/s are 18 N s, and each leaves 2.5 mm.
    fact(box.min.z < -0.042f && box.min.z > -0.049f, "the first ball left a dent of 45 mm");

    const auto throw_second = [&] {
        const btVector3 end = scene.throw_ball(0.015f, 0.1f, place + btVector3(0.02f, 0.01f, 0.05f), 3);
        std::printf("the second ball ends at (%.3f, %.3f, %.3f)\n", double(end.x()), double(end.y()), double(end.z()));
        return distance_to(drawn, fine.indices, end) - 0.015f;
    };
    fact(throw_second() > 0.1f, "without a refit the second ball falls through the dent");
    collider.shape->partialRefitTree(to_bullet(box.min), to_bullet(box.max));
    const float gap = throw_second();
    std::printf("%.2f mm from the dented metal\n", double(1000 * gap));
    fact(std::fabs(gap) < 0.002f, "after the refit it lies on the dented metal");

    // What following costs, beside a new collider.
    const CrumpleBuffer only = buffer.id();
    const auto repaired = [&] {
        instance.repair(0).value();
        context.deform(&only, 1).value();
    };
    const double deform = microseconds(repaired, [&] {
        instance.submit_impulse({0.1f, 0.05f, 0}, {0, 0, -25}, 0.01f).value();
        context.deform(&only, 1).value();
    });
    const auto nothing = [] {};
    const double triangles = microseconds(nothing, [&] { buffer.changed_triangles(&box).value(); });
    const double partial = microseconds(nothing, [&] { collider.shape->partialRefitTree(to_bullet(box.min), to_bullet(box.max)); });
    const double refit = microseconds(nothing, [&] { collider.shape->refitTree(-collider.corner, collider.corner); });
    Collider other(coarse, set.info().value().depth_limit);
    const double whole = microseconds(nothing, [&] { other.build(); });
    std::printf("a hit and a deform %.1f us, the list of triangles %.1f us, the partial refit %.1f us\n", deform, triangles, partial);
    std::printf("instead of that refit: of the whole tree %.1f us, a new collider %.1f us\n", refit, whole);
}

} // namespace

int main() {
    try {
        run();
    } catch (const crumple::Error &error) {
        std::fprintf(stderr, "%s: %s\n", crumple_result_name(error.result()), error.what());
        return 1;
    }
}
