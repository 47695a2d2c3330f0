// A rigid-body engine (ODE) drops drums, a hood and a ball. The impulses of its contacts become dents where the contacts are.
//
//     crash HOOD.glb DRUM.glb FOLDER        writes FOLDER/frame_00.obj …
#include <crumple.hpp>

#include <ode/ode.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace {

using Vec = std::array<double, 3>;
constexpr double STEP = 1.0 / 240, WINDOW = 1.0 / 30, SECONDS = 1.8; // s
constexpr int FRAMES = 6;

Vec operator+(const Vec &a, const Vec &b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vec operator-(const Vec &a, const Vec &b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec operator*(const Vec &a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }
double length(const Vec &a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }
CrumpleVec3 to_crumple(const Vec &a) { return {float(a[0]), float(a[1]), float(a[2])}; }
Vec from_crumple(const CrumpleVec3 &a) { return {a.x, a.y, a.z}; }

void fact(bool holds, const std::string &what) {
    if (holds) return;
    std::fprintf(stderr, "this is not so: %s\n", what.c_str());
    std::exit(1);
}

struct Vertex {
    CrumpleVec3 position, normal;
};

// A mesh with examples, shared by all bodies that use it.
struct Model {
    crumple::ExampleSet set;
    CrumpleExampleSetInfo info;
    std::vector<CrumpleVec3> base;
    std::vector<uint32_t> indices;

    Model(crumple::Context &context, const char *path) {
        CrumpleGltfDef def = crumple_gltf_def_default();
        def.path = path;
        def.options.vertex_mass = 30; // kg: 100 N s in 10 ms give a dent of 33 mm
        set = context.load_gltf(def).value();
        info = set.info().value();
        base.resize(info.vertex_count);
        indices.resize(size_t(info.triangle_count) * 3);
        CrumpleMeshCopyDef copy = crumple_mesh_copy_def_default();
        copy.positions = crumple::stream(base);
        copy.indices = crumple::stream(indices);
        set.copy_mesh(copy).value();
    }
};

// The sum of one contact's impulses in one time window, in the body's own space.
struct Push {
    double since = 0;
    Vec impulse{}, weighted_point{};
    double weight = 0;
};

// A body of the scene. ODE simulates it as a rigid body; Crumple dents it.
struct Body {
    std::string name;
    const Model &model;
    dBodyID body;
    crumple::Instance instance;
    std::vector<Vertex> vertices;
    crumple::Buffer buffer;
    std::map<dGeomID, Push> pushes;
    int dents = 0;

    Body(crumple::Context &context, dWorldID world, std::string name_, const Model &model_, Vec position, Vec axis, double angle)
        : name(std::move(name_)), model(model_), body(dBodyCreate(world)), vertices(model.base.size()) {
        dBodySetData(body, this);
        dBodySetPosition(body, position[0], position[1], position[2]);
        dMatrix3 rotation;
        dRFromAxisAndAngle(rotation, axis[0], axis[1], axis[2], angle);
        dBodySetRotation(body, rotation);
        CrumpleInstanceDef def = crumple_instance_def_default();
        def.set = model.set.id();
        def.yield_impulse = 12; // N s: resting contacts make no dents
        instance = context.create_instance(def).value();
        buffer = instance
                     .register_buffer(crumple::stream(&vertices[0].position, vertices.size(), sizeof(Vertex)),
                                      crumple::stream(&vertices[0].normal, vertices.size(), sizeof(Vertex)))
                     .value();
    }

    void pushed(dGeomID by, const dReal *world_point, const dReal *world_force, double time) {
        dVector3 point, force;
        dBodyGetPosRelPoint(body, world_point[0], world_point[1], world_point[2], point);
        dBodyVectorFromWorld(body, world_force[0], world_force[1], world_force[2], force);
        const Vec impulse = Vec{force[0], force[1], force[2]} * STEP;
        Push &push = pushes[by];
        if (push.weight == 0) push.since = time;
        push.impulse = push.impulse + impulse;
        push.weighted_point = push.weighted_point + Vec{point[0], point[1], point[2]} * length(impulse);
        push.weight += length(impulse);
    }

    // Submits each finished time window as a hit, and checks that the dent is where the contact was.
    void settle(crumple::Context &context, double time) {
        for (auto at = pushes.begin(); at != pushes.end();) {
            const Push push = at->second;
            if (time - push.since < WINDOW) {
                ++at;
                continue;
            }
            at = pushes.erase(at);
            if (push.weight <= 0) continue;
            const Vec point = push.weighted_point * (1 / push.weight);
            const auto told = instance.submit_impulse(to_crumple(point), to_crumple(push.impulse), 0.01f).value();
            if (told.status == CRUMPLE_HIT_STATUS_MARKED) look(context, told, push, time);
        }
    }

    void look(crumple::Context &context, const CrumpleHitResult &told, const Push &push, double time) {
        const std::vector<Vertex> before = vertices;
        const CrumpleBuffer only = buffer.id();
        context.deform(&only, 1).value();
        size_t deepest = 0;
        double depth = 0;
        for (size_t v = 0; v < vertices.size(); ++v) {
            const double moved = length(from_crumple(vertices[v].position) - from_crumple(before[v].position));
            if (moved > depth) depth = moved, deepest = v;
            const double total = length(from_crumple(vertices[v].position) - from_crumple(model.base[v]));
            fact(total <= model.info.depth_limit * 1.00001, name + ": no vertex moves further than the depth limit");
        }
        const Vec contact = from_crumple(model.base[told.contact_vertex]);
        const double away = length(from_crumple(model.base[deepest]) - contact);
        std::printf("%5.2f s  %-6s  %6.1f N s at (%5.2f, %5.2f, %5.2f): %5.1f mm asked, deepest change %5.1f mm, %3.0f mm away\n",
                    time, name.c_str(), length(push.impulse), contact[0], contact[1], contact[2],
                    1000 * length(from_crumple(told.target)), 1000 * depth, 1000 * away);
        if (dents++ == 0) {
            fact(depth > 0.002, name + ": the first dent can be seen");
            fact(away < 0.15, name + ": the deepest vertex of the first dent is near the contact");
        }
    }

    void write(std::ofstream &file, size_t &written) const {
        file << "o " << name << '\n';
        for (const Vertex &v : vertices) {
            dVector3 p;
            dBodyGetRelPointPos(body, v.position.x, v.position.y, v.position.z, p);
            file << "v " << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
        }
        for (size_t i = 0; i < model.indices.size(); i += 3) {
            file << 'f';
            for (size_t k = 0; k < 3; ++k) file << ' ' << written + model.indices[i + k] + 1;
            file << '\n';
        }
        written += vertices.size();
    }
};

struct Contact {
    dGeomID a, b;
    dContact contact;
    dJointFeedback feedback;
};

struct Scene {
    dWorldID world = dWorldCreate();
    dSpaceID space = dHashSpaceCreate(nullptr);
    dJointGroupID joints = dJointGroupCreate(0);
    std::vector<std::unique_ptr<Contact>> contacts;

    Scene() {
        dWorldSetGravity(world, 0, 0, -9.81);
        dWorldSetERP(world, 0.2);
        dWorldSetCFM(world, 1e-6);
        dCreatePlane(space, 0, 0, 1, 0);
    }
    ~Scene() {
        dJointGroupDestroy(joints);
        dSpaceDestroy(space);
        dWorldDestroy(world);
    }

    static void near(void *user, dGeomID a, dGeomID b) {
        auto &scene = *static_cast<Scene *>(user);
        if (dGeomGetBody(a) == dGeomGetBody(b)) return;
        std::array<dContactGeom, 16> found;
        const int count = dCollide(a, b, int(found.size()), found.data(), sizeof found[0]);
        for (int i = 0; i < count; ++i) {
            auto contact = std::make_unique<Contact>();
            contact->a = a;
            contact->b = b;
            contact->contact = {};
            contact->contact.geom = found[size_t(i)];
            contact->contact.surface.mode = dContactBounce;
            contact->contact.surface.mu = 0.6;
            contact->contact.surface.bounce = 0.1;
            contact->contact.surface.bounce_vel = 0.5;
            const dJointID joint = dJointCreateContact(scene.world, scene.joints, &contact->contact);
            dJointAttach(joint, dGeomGetBody(a), dGeomGetBody(b));
            dJointSetFeedback(joint, &contact->feedback);
            scene.contacts.push_back(std::move(contact));
        }
    }

    void step(double time) {
        dSpaceCollide(space, this, near);
        dWorldStep(world, STEP);
        for (const auto &contact : contacts) {
            const dBodyID a = dGeomGetBody(contact->a), b = dGeomGetBody(contact->b);
            const dReal *point = contact->contact.geom.pos;
            const auto tell = [&](dBodyID hit, dGeomID by, const dReal *force) {
                if (auto *body = hit ? static_cast<Body *>(dBodyGetData(hit)) : nullptr) body->pushed(by, point, force, time);
            };
            tell(a, contact->b, contact->feedback.f1);
            tell(b, contact->a, contact->feedback.f2);
        }
        contacts.clear();
        dJointGroupEmpty(joints);
    }
};

void run(const char *hood_file, const char *drum_file, const std::string &folder) {
    crumple::Context context;
    const Model hood(context, hood_file), drum(context, drum_file);
    Scene scene;

    // A bollard and a ball. They have no mesh and are never dented.
    const dGeomID bollard = dCreateBox(scene.space, 0.15, 0.15, 0.5);
    dGeomSetPosition(bollard, 0, 0, 0.25);
    const dBodyID ball = dBodyCreate(scene.world);
    dMass mass;
    dMassSetSphereTotal(&mass, 25, 0.12);
    dBodySetMass(ball, &mass);
    dBodySetPosition(ball, 2.0, 0.1, 2.5);
    dGeomSetBody(dCreateSphere(scene.space, 0.12), ball);

    std::vector<std::unique_ptr<Body>> bodies;
    const auto add_drum = [&](const char *name, Vec position, Vec axis, double angle) {
        bodies.push_back(std::make_unique<Body>(context, scene.world, name, drum, position, axis, angle));
        dMassSetCylinderTotal(&mass, 20, 3, 0.3, 0.9);
        dBodySetMass(bodies.back()->body, &mass);
        dGeomSetBody(dCreateCylinder(scene.space, 0.3, 0.9), bodies.back()->body);
    };
    add_drum("drum 1", {0.02, 0.05, 1.9}, {1, 0, 0}, 1.62); // on its side, above the bollard
    add_drum("drum 2", {0.3, 0.0, 3.3}, {0.2, 1, 0}, 0.9);  // onto drum 1

    // The hood collides with its own triangles.
    std::vector<float> flat;
    for (const CrumpleVec3 &p : hood.base) flat.insert(flat.end(), {p.x, p.y, p.z});
    const dTriMeshDataID triangles = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildSingle(triangles, flat.data(), 3 * sizeof(float), int(hood.base.size()), hood.indices.data(),
                                int(hood.indices.size()), 3 * sizeof(uint32_t));
    bodies.push_back(std::make_unique<Body>(context, scene.world, "hood", hood, Vec{2.0, 0, 0.9}, Vec{0, 1, 0}, 0.15));
    dMassSetBoxTotal(&mass, 15, 1.2, 0.9, 0.09);
    dBodySetMass(bodies.back()->body, &mass);
    dGeomSetBody(dCreateTriMesh(scene.space, triangles, nullptr, nullptr, nullptr), bodies.back()->body);

    context.deform().value();
    int frame = 0;
    for (int step = 0; step * STEP <= SECONDS; ++step) {
        const double time = step * STEP;
        scene.step(time);
        for (auto &body : bodies) body->settle(context, time);
        if (time >= frame * SECONDS / (FRAMES - 1) - 1e-9) {
            char name[32];
            std::snprintf(name, sizeof name, "/frame_%02d.obj", frame++);
            std::ofstream file(folder + name);
            size_t written = 0;
            for (auto &body : bodies) body->write(file, written);
            fact(bool(file.flush()), "the frame " + folder + name + " was written");
        }
    }
    fact(frame == FRAMES, "every frame was written");
    for (const auto &body : bodies) {
        const dReal *at = dBodyGetPosition(body->body);
        std::printf("%-6s  ends at (%.2f, %.2f, %.2f) with %d dents\n", body->name.c_str(), at[0], at[1], at[2], body->dents);
        fact(body->dents > 0, body->name + " is dented");
        fact(std::isfinite(at[0]) && at[2] > -0.5 && at[2] < 5, body->name + " lies on the ground");
    }
    dGeomTriMeshDataDestroy(triangles);
}

} // namespace

int main(int argc, char **argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: crash HOOD.glb DRUM.glb FOLDER\n");
        return 2;
    }
    dInitODE2(0);
    int status = 0;
    try {
        run(argv[1], argv[2], argv[3]);
    } catch (const crumple::Error &error) {
        std::fprintf(stderr, "%s: %s\n", crumple_result_name(error.result()), error.what());
        status = 1;
    }
    dCloseODE();
    return status;
}
