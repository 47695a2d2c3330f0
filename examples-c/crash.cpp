// A rigid-body engine (ODE) drops drums, a hood and a ball. Its contacts become dents.
//
//     crash HOOD.glb DRUM.glb FOLDER        writes FOLDER/frame_00.obj …
#include "ode_world.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

namespace {

using Vec = std::array<double, 3>;
constexpr double STEP = 1.0 / 240, SECONDS = 1.8; // s
constexpr int FRAMES = 6;

Vec operator-(const Vec &a, const Vec &b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double length(const Vec &a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }
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

void bounces(dContact &contact, int) {
    contact.surface.mode = dContactBounce;
    contact.surface.mu = 0.6;
    contact.surface.bounce = 0.1;
    contact.surface.bounce_vel = 0.5;
}

// A body of the scene. ODE simulates it as a rigid body; Crumple dents it.
struct Body {
    std::string name;
    const Model &model;
    dBodyID body;
    crumple::Instance instance;
    std::vector<Vertex> vertices;
    crumple::Buffer buffer;

    Body(crumple::Context &context, dWorldID world, std::string name_, const Model &model_, Vec position, Vec axis, double angle)
        : name(std::move(name_)), model(model_), body(dBodyCreate(world)), vertices(model.base.size()) {
        dBodySetPosition(body, position[0], position[1], position[2]);
        dMatrix3 rotation;
        dRFromAxisAndAngle(rotation, axis[0], axis[1], axis[2], angle);
        dBodySetRotation(body, rotation);
        CrumpleInstanceDef def = crumple_instance_def_default();
        def.set = model.set.id();
        def.compliance = 3.3e-4f; // m per N s: of the drum, whose examples do not know their blows
        instance = context.create_instance(def).value();
        buffer = instance
                     .register_buffer(crumple::stream(&vertices[0].position, vertices.size(), sizeof(Vertex)),
                                      crumple::stream(&vertices[0].normal, vertices.size(), sizeof(Vertex)))
                     .value();
    }

    void add(OdeWorld &scene, dGeomID geom) {
        dGeomSetBody(geom, body);
        scene.contacts.dent(geom, instance.id());
    }

    // Checks the dents against what the library knows of them.
    void check() const {
        const std::vector<CrumpleMark> marks = instance.marks().value();
        size_t deepest = 0;
        double depth = 0;
        for (size_t v = 0; v < vertices.size(); ++v) {
            const double moved = length(from_crumple(vertices[v].position) - from_crumple(model.base[v]));
            fact(moved <= model.info.depth_limit * 1.00001, name + ": no vertex moves further than the depth limit");
            if (moved > depth) depth = moved, deepest = v;
        }
        double away = INFINITY;
        for (const CrumpleMark &mark : marks)
            away = std::fmin(away, length(from_crumple(model.base[deepest]) - from_crumple(model.base[mark.contact])));
        const dReal *at = dBodyGetPosition(body);
        std::printf("%-6s  ends at (%.2f, %.2f, %.2f) with %zu dents, %.1f mm deep\n", name.c_str(), at[0], at[1], at[2], marks.size(),
                    1000 * depth);
        fact(depth > 0.002, name + ": the dents can be seen");
        fact(away < 0.15, name + ": the deepest vertex is near a contact");
        fact(marks.size() < 24, name + ": a body that comes to rest gets no more dents");
        fact(std::isfinite(at[0]) && at[2] > -0.5 && at[2] < 5, name + " lies on the ground");
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

void run(const char *hood_file, const char *drum_file, const std::string &folder) {
    crumple::Context context;
    const Model hood(context, hood_file), drum(context, drum_file);
    OdeWorld scene(context, 0, -9.81, bounces);
    dWorldSetERP(scene.world, 0.2);
    dWorldSetCFM(scene.world, 1e-6);
    dCreatePlane(scene.space, 0, 0, 1, 0);

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
        bodies.back()->add(scene, dCreateCylinder(scene.space, 0.3, 0.9));
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
    bodies.back()->add(scene, dCreateTriMesh(scene.space, triangles, nullptr, nullptr, nullptr));

    context.deform().value();
    int frame = 0;
    for (int step = 0; step * STEP <= SECONDS; ++step) {
        const double time = step * STEP;
        for (auto &body : bodies) follow_body(body->instance, body->body);
        scene.step(STEP);
        context.deform().value();
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
    for (const auto &body : bodies) body->check();
    const CrumpleContactReport totals = context.contact_totals().value();
    std::printf("%llu contact points, %llu touches, %llu points at rest\n", static_cast<unsigned long long>(totals.points),
                static_cast<unsigned long long>(totals.begun), static_cast<unsigned long long>(totals.slow));
    fact(totals.refused == 0, "no hit was refused");
    dGeomTriMeshDataDestroy(triangles);
}

} // namespace

int main(int argc, char **argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: crash HOOD.glb DRUM.glb FOLDER\n");
        return 2;
    }
    try {
        run(argv[1], argv[2], argv[3]);
    } catch (const crumple::Error &error) {
        std::fprintf(stderr, "%s: %s\n", crumple_result_name(error.result()), error.what());
        return 1;
    }
    return 0;
}
