// A ball and a box fall onto a hood in Jolt, at three rates of steps, and leave about the dent that the blow leaves.
//
//     jolt_crash HOOD.glb
#include "jolt_contacts.hpp"
#include "jolt_world.hpp"

#include <Jolt/Core/JobSystemThreadPool.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Collision/Shape/BoxShape.h>
#include <Jolt/Physics/Collision/Shape/SphereShape.h>

#include <cstdio>
#include <vector>

namespace {

constexpr float MASS = 6, SPEED = 6, SIZE = 0.09f; // kg, m/s, m

struct Hood {
    crumple::ExampleSet set;
    std::vector<CrumpleVec3> rest;
    JPH::ShapeRefC shape;

    Hood(crumple::Context &context, const char *file) : set(context.load_gltf(file).value()) {
        const CrumpleExampleSetInfo info = set.info().value();
        rest.resize(info.vertex_count);
        std::vector<uint32_t> indices(size_t(info.triangle_count) * 3);
        CrumpleMeshCopyDef copy = crumple_mesh_copy_def_default();
        copy.positions = crumple::stream(rest);
        copy.indices = crumple::stream(indices);
        set.copy_mesh(copy).value();
        shape = jolt_mesh(rest, indices);
    }

    float deepest(const std::vector<CrumpleVec3> &drawn) const {
        float deepest = 0;
        for (size_t v = 0; v < drawn.size(); ++v)
            deepest = std::max(deepest, std::hypot(std::hypot(drawn[v].x - rest[v].x, drawn[v].y - rest[v].y), drawn[v].z - rest[v].z));
        return deepest;
    }
};

// The depth that something leaves that falls at SPEED.
float thrown(crumple::Context &context, const Hood &hood, const JPH::ShapeRefC &shape, float hz) {
    crumple::Instance instance = context.create_instance(hood.set).value();
    std::vector<CrumpleVec3> drawn(hood.rest.size());
    const crumple::Buffer buffer = instance.register_buffer(crumple::stream(drawn)).value();
    JPH::TempAllocatorMalloc memory;
    JPH::JobSystemThreadPool jobs(JPH::cMaxPhysicsJobs, JPH::cMaxPhysicsBarriers, 1);
    JoltWorld world;
    JPH::PhysicsSystem &system = world.system;
    JoltContacts contacts(context, 1 / hz);
    system.SetContactListener(&contacts);
    JPH::BodyInterface &bodies = system.GetBodyInterface();
    using Settings = JPH::BodyCreationSettings;
    const auto still = JPH::EMotionType::Static, moving = JPH::EMotionType::Dynamic;
    const auto none = JPH::Quat::sIdentity();
    const auto under = bodies.CreateAndAddBody(Settings(hood.shape, JPH::RVec3::sZero(), none, still, 0), JPH::EActivation::DontActivate);
    contacts.dent(under, instance.id());
    Settings falling(shape, JPH::RVec3(0.1f, 0.15f, 0.6f), none, moving, 0);
    falling.mLinearVelocity = JPH::Vec3(0, 0, -SPEED);
    falling.mMotionQuality = JPH::EMotionQuality::LinearCast;
    falling.mRestitution = 0;
    falling.mOverrideMassProperties = JPH::EOverrideMassProperties::CalculateInertia;
    falling.mMassPropertiesOverride.mMass = MASS;
    bodies.CreateAndAddBody(falling, JPH::EActivation::Activate);
    for (int step = 0; step < int(hz / 2); ++step) {
        system.Update(1 / hz, 1, &memory, &jobs);
        contacts.step();
    }
    context.clear_contacts().value();
    context.deform().value();
    return hood.deepest(drawn);
}

// What a blow leaves that is told in one piece.
float told(crumple::Context &context, const Hood &hood) {
    crumple::Instance instance = context.create_instance(hood.set).value();
    std::vector<CrumpleVec3> drawn(hood.rest.size());
    const crumple::Buffer buffer = instance.register_buffer(crumple::stream(drawn)).value();
    CrumpleHitDef hit = crumple_hit_def_default();
    hit.point = {0.1f, 0.15f, 0.07f};
    hit.impulse = {0, 0, -MASS * SPEED};
    hit.striker.mass = MASS;
    hit.striker.velocity = {0, 0, -SPEED};
    instance.submit(hit).value();
    context.deform().value();
    return hood.deepest(drawn);
}

bool run(const char *file) {
    crumple::Context context;
    const Hood hood(context, file);
    const float expected = told(context, hood);
    std::printf("told the blow: %.1f mm\n", double(1000 * expected));
    const JPH::ShapeRefC ball = new JPH::SphereShape(SIZE), box = new JPH::BoxShape(JPH::Vec3(SIZE, SIZE, SIZE) * 0.5f);
    bool right = true;
    for (const float hz : {30.0f, 60.0f, 240.0f}) {
        const float a = thrown(context, hood, ball, hz), b = thrown(context, hood, box, hz);
        std::printf("%3.0f Hz: a ball %.1f mm, a box %.1f mm\n", double(hz), double(1000 * a), double(1000 * b));
        for (const float depth : {a, b}) right &= std::fabs(depth / expected - 1) < 0.1f;
    }
    if (!right) std::fprintf(stderr, "this is not so: every dent is within 10 %% of what the blow leaves\n");
    return right;
}

} // namespace

int main(int argc, char **argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: jolt_crash HOOD.glb\n");
        return 2;
    }
    const JoltTypes types;
    try {
        return run(argv[1]) ? 0 : 1;
    } catch (const crumple::Error &error) {
        std::fprintf(stderr, "%s: %s\n", crumple_result_name(error.result()), error.what());
        return 1;
    }
}
