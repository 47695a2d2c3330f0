// A car of parts drives into a pole, and another car into its side (rigid bodies: ODE). All parts of a car share one list of dents.
// The bumper falls off when it is dented deep enough, panes break when what holds them is bent, and wheels get out of line.
//
//     vehicle CAR.glb FOLDER     writes FOLDER/frame_0.obj …
#include "ode_world.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace {

constexpr int STEPS = 360, STEPS_A_FRAME = 4, STEPS_A_FILE = 120;
constexpr double STEP = 1.0 / 240; // s
// Of a car: its mass, kg, and the height of its centre of mass, m. y is up, and the car looks to z.
constexpr float MASS = 1200, HEIGHT = 0.5f;
// In contacts bodies give way as crumple zones do: like a spring and a damper of this frequency, Hz, and damping ratio.
constexpr double GIVE = 3, DAMPING = 0.7;
// The bumper and panes hold until they have moved this far, m.
constexpr float BUMPER_HOLDS = 0.1f, PANE_HOLDS = 0.012f;
constexpr double POLE_X = 0.35, POLE_RADIUS = 0.13, POLE_HEIGHT = 1.2; // m

void fact(bool holds, const char *what) {
    if (holds) return;
    std::fprintf(stderr, "this is not so: %s\n", what);
    std::exit(1);
}

CrumpleVec3 operator+(CrumpleVec3 a, CrumpleVec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
CrumpleVec3 operator-(CrumpleVec3 a, CrumpleVec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
CrumpleVec3 operator*(float s, CrumpleVec3 v) { return {s * v.x, s * v.y, s * v.z}; }
float length(CrumpleVec3 v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }
CrumpleVec3 middle(CrumpleAabb box) { return 0.5f * (box.min + box.max); }

CrumpleVec3 rotated(CrumpleQuat q, CrumpleVec3 v) {
    const CrumpleVec3 t{2 * (q.y * v.z - q.z * v.y), 2 * (q.z * v.x - q.x * v.z), 2 * (q.x * v.y - q.y * v.x)};
    return v + q.w * t + CrumpleVec3{q.y * t.z - q.z * t.y, q.z * t.x - q.x * t.z, q.x * t.y - q.y * t.x};
}

// What all cars share. The file says which parts are panes and wheels: "glass" and "rigid".
struct Model {
    crumple::ExampleSet set;
    std::vector<CrumplePart> parts; // by their numbers, which are those of lods: from 1 on
    std::vector<CrumplePrimitive> primitives;
    std::vector<uint32_t> indices; // of all parts

    Model(crumple::Context &context, const char *path) {
        CrumpleGltfDef def = crumple_gltf_def_default();
        def.path = path;
        def.join_nodes = true;
        set = context.load_gltf(def).value();
        const CrumpleExampleSetInfo info = set.info().value();
        parts.resize(info.lod_count);
        for (uint32_t i = 1; i < info.lod_count; ++i) parts[i] = set.part(i).value();
        for (uint32_t i = 0; i < info.primitive_count; ++i) primitives.push_back(set.primitive(i).value());
        indices.resize(3 * size_t(info.triangle_count));
        CrumpleMeshCopyDef copy = crumple_mesh_copy_def_default();
        copy.indices = crumple::stream(indices);
        set.copy_mesh(copy).value();
    }
};

void touches(dContact &contact, int count) {
    const dGeomID a = contact.geom.g1, b = contact.geom.g2;
    contact.surface.mode = dContactApprox1; // Coulomb's friction
    contact.surface.mu = 0.3;
    if (dGeomGetClass(a) == dPlaneClass || dGeomGetClass(b) == dPlaneClass) { // wheels roll ahead and grip sideways
        contact.surface.mode |= dContactMu2 | dContactFDir1;
        contact.surface.mu = 0;
        contact.surface.mu2 = 0.8;
        dBodyVectorToWorld(dGeomGetBody(a) ? dGeomGetBody(a) : dGeomGetBody(b), 0, 0, 1, contact.fdir1);
    } else {
        const double rate = 6.2831853 * GIVE, push = STEP * MASS * rate * rate / count, damp = 2 * DAMPING * MASS * rate / count;
        contact.surface.mode |= dContactSoftERP | dContactSoftCFM;
        contact.surface.soft_erp = push / (push + damp);
        contact.surface.soft_cfm = 1 / (push + damp);
    }
}

// What a geom is, and what it meets: bodies of cars meet obstacles; wheels, and what has fallen off, meet the ground.
enum Bits : unsigned long { NONE = 0, GROUND = 1, OBSTACLE = 2 };

dGeomID add(dGeomID geom, dBodyID body, Bits is, Bits meets) {
    dGeomSetBody(geom, body);
    dGeomSetCategoryBits(geom, is);
    dGeomSetCollideBits(geom, meets);
    return geom;
}

dBodyID make_body(dWorldID world, double kg, CrumpleVec3 size, const dReal *at, const dReal *turn, const dReal *speed) {
    const dBodyID made = dBodyCreate(world);
    dMass mass;
    dMassSetBoxTotal(&mass, kg, size.x, size.y, size.z);
    dBodySetMass(made, &mass);
    dBodySetPosition(made, at[0], at[1], at[2]);
    dBodySetQuaternion(made, turn);
    dBodySetLinearVel(made, speed[0], speed[1], speed[2]);
    return made;
}

// A part of one car. A pane has no vertices of its own: it is a piece of another part.
struct Part {
    std::vector<CrumpleVec3> vertices; // Crumple writes them
    crumple::Buffer buffer;
    dBodyID body = nullptr;            // what it moves with: the car's or, once it has come off, its own
    CrumpleVec3 origin{0, -HEIGHT, 0}; // of the mesh, in the body's space, m
    CrumpleAttachment mount{};         // of a wheel
    bool broken = false;               // of a pane
};

struct Car {
    const char *name, *paint;
    const Model &model;
    OdeWorld &scene;
    dBodyID body;
    crumple::Instance instance, bumper;
    std::vector<Part> parts;
    uint64_t revision = 0; // of the damage when parts were last measured

    Car(crumple::Context &context, OdeWorld &scene_, const Model &model_, const char *name_, const char *paint_, float x, float z,
        double angle, double speed)
        : name(name_), paint(paint_), model(model_), scene(scene_) {
        const dReal at[] = {x, HEIGHT, z}, ahead[] = {speed * std::sin(angle), 0, speed * std::cos(angle)};
        dQuaternion turn;
        dQFromAxisAndAngle(turn, 0, 1, 0, angle);
        body = make_body(scene.world, MASS, {1.8f, 1.4f, 4.4f}, at, turn, ahead);
        CrumpleInstanceDef def = crumple_instance_def_default();
        def.set = model.set.id();
        def.grow_time = 0.04f; // s
        instance = context.create_instance(def).value();
        const auto box = [&](double width, double height, double length, double y, double z) {
            const dGeomID geom = add(dCreateBox(scene.space, width, height, length), body, OBSTACLE, OBSTACLE);
            dGeomSetOffsetPosition(geom, 0, y - HEIGHT, z);
            scene.contacts.dent(geom, instance.id());
        };
        box(1.76, 0.65, 4.4, 0.55, -0.05); // the lower body
        box(1.2, 0.5, 2.0, 1.13, -0.4);    // the greenhouse
        parts.resize(model.parts.size());
        for (uint32_t i = 1; i < parts.size(); ++i) {
            Part &part = parts[i];
            const CrumplePartKind kind = model.parts[i].kind;
            if (kind == CRUMPLE_PART_KIND_GLASS) {
                instance.set_part_rigid(i, true).value(); // hits on it leave no dent
                continue;
            }
            part.body = body;
            part.vertices.resize(model.parts[i].vertex_count);
            CrumpleHostBufferDef buffer = crumple_host_buffer_def_default();
            buffer.lod = i;
            buffer.positions = crumple::stream(part.vertices);
            part.buffer = instance.register_buffer(buffer).value();
            if (kind != CRUMPLE_PART_KIND_RIGID) continue;
            const CrumpleVec3 hub = middle(part.buffer.bounds().value());
            dGeomSetOffsetPosition(add(dCreateSphere(scene.space, hub.y), body, NONE, GROUND), hub.x, hub.y - HEIGHT, hub.z);
            part.mount = model.set.attach({0.5f * hub.x, hub.y, hub.z}).value(); // on the chassis
        }
    }

    float deepest(uint32_t part) const { return instance.measure_part(part).value().deepest; }

    // What the dents do to the car. To measure a part takes as long as to deform it.
    void suffer(double time) {
        const uint64_t before = std::exchange(revision, instance.info().value().revision);
        if (revision == before) return;
        dBodySetLinearDamping(body, 1.2 * STEP); // who has crashed brakes
        dBodySetAngularDamping(body, 1.5 * STEP);
        for (uint32_t i = 1; i < parts.size(); ++i) {
            if (model.parts[i].kind != CRUMPLE_PART_KIND_GLASS || parts[i].broken || deepest(i) < PANE_HOLDS) continue;
            parts[i].broken = true;
            std::printf("%-6s  %.2f s: a pane breaks, part %u\n", name, time, i);
        }
        const uint32_t off = model.set.find_part("bumper_front").value();
        if (bumper || deepest(off) < BUMPER_HOLDS) return;
        std::printf("%-6s  %.2f s: the bumper falls off\n", name, time);
        // It takes its buffer and its dents along, and becomes a body of its own.
        bumper = instance.release_part(off).value();
        const CrumpleAabb box = parts[off].buffer.bounds().value();
        const CrumpleVec3 size = box.max - box.min, centre = middle(box);
        dVector3 at, falls;
        dBodyGetRelPointPos(body, centre.x, centre.y - HEIGHT, centre.z, at);
        dBodyVectorToWorld(body, 0.5, 0.4, -0.3, falls);
        parts[off].body = make_body(scene.world, 12, size, at, dBodyGetQuaternion(body), falls);
        parts[off].origin = -1.0f * centre;
        add(dCreateBox(scene.space, size.x, size.y, size.z), parts[off].body, NONE, GROUND);
    }

    // Writes Wavefront OBJ behind so many vertices, and returns how many there are then.
    size_t write(std::ofstream &file, size_t written) const {
        for (size_t i = 1; i < parts.size(); ++i) {
            const CrumplePart &from = model.parts[i];
            if (from.kind == CRUMPLE_PART_KIND_GLASS) continue;
            const bool wheel = from.kind == CRUMPLE_PART_KIND_RIGID; // moves and turns as its mount does
            const CrumplePose pose = wheel ? instance.attached_pose(parts[i].mount).value() : CrumplePose{{}, {0, 0, 0, 1}, {}};
            file << "o " << name << '_' << from.name << "\ns 1\n";
            for (const CrumpleVec3 &v : parts[i].vertices) {
                const CrumpleVec3 p = parts[i].origin + pose.position + rotated(pose.rotation, v - parts[i].mount.point);
                dVector3 world;
                dBodyGetRelPointPos(parts[i].body, p.x, p.y, p.z, world);
                file << "v " << world[0] << ' ' << world[1] << ' ' << world[2] << '\n';
            }
            for (const CrumplePrimitive &primitive : model.primitives) {
                const uint32_t first = primitive.first_triangle;
                if (first < from.first_triangle || first >= from.first_triangle + from.triangle_count) continue;
                std::string material = primitive.material;
                if (material == "paint") material = paint;
                for (size_t pane = 1; pane < parts.size(); ++pane)
                    if (parts[pane].broken && model.parts[pane].first_triangle == first) material = "glass_broken";
                file << "usemtl " << material;
                for (size_t k = 3 * size_t(first); k < 3 * size_t(first + primitive.triangle_count); ++k)
                    file << (k % 3 == 0 ? "\nf " : " ") << written + 1 + model.indices[k] - from.first_vertex;
                file << '\n';
            }
            written += parts[i].vertices.size();
        }
        return written;
    }
};

// Writes a pole of 24 sides, and returns the number of its vertices.
size_t write_pole(std::ofstream &file) {
    file << "o pole\nusemtl steel\n";
    for (int i = 0; i < 48; ++i) {
        const double angle = 0.2617994 * i, x = POLE_X + POLE_RADIUS * std::sin(angle), z = POLE_RADIUS * std::cos(angle);
        file << "v " << x << ' ' << (i < 24 ? 0 : POLE_HEIGHT) << ' ' << z << '\n';
    }
    for (int i = 1; i <= 24; ++i) file << "f " << i << ' ' << i % 24 + 1 << ' ' << i % 24 + 25 << ' ' << i + 24 << '\n';
    file << "f";
    for (int i = 25; i <= 48; ++i) file << ' ' << i; // the lid
    file << '\n';
    return 48;
}

void run(const char *path, const std::string &folder) {
    crumple::Context context;
    const Model model(context, path);
    OdeWorld scene(context, -9.81, 0, touches);
    add(dCreatePlane(scene.space, 0, 1, 0, 0), nullptr, GROUND, NONE);
    const dGeomID pole = add(dCreateCylinder(scene.space, POLE_RADIUS, POLE_HEIGHT), nullptr, OBSTACLE, OBSTACLE);
    const dQuaternion upright = {0.70710678, 0.70710678, 0, 0};
    dGeomSetQuaternion(pole, upright);
    dGeomSetPosition(pole, POLE_X, POLE_HEIGHT / 2, 0);
    Car first(context, scene, model, "first", "paint", 0, -3.5f, 0, 5.5);
    Car second(context, scene, model, "second", "paint_red", 7, -2.7f, -1.5707963, 6.5);
    for (int step = 0; step <= STEPS; ++step) {
        for (Car *car : {&first, &second}) follow_body(car->instance, car->body, 0, -HEIGHT, 0);
        scene.step(STEP);
        if (step % STEPS_A_FRAME != 0) continue;
        context.set_time(step * STEP).value();
        context.deform().value();
        for (Car *car : {&first, &second}) car->suffer(step * STEP);
        if (step % STEPS_A_FILE != 0) continue;
        std::ofstream file(folder + "/frame_" + std::to_string(step / STEPS_A_FILE) + ".obj");
        second.write(file, first.write(file, write_pole(file)));
        fact(bool(file.flush()), "every frame was written");
    }

    const auto part = [&](const char *name) { return model.set.find_part(name).value(); };
    const uint32_t windscreen = part("glass"); // panes are named after their material, and this one is the first
    fact(bool(first.bumper), "the first car lost its bumper at the pole");
    fact(first.parts[windscreen].broken, "its windscreen broke");
    const CrumpleAttachment &mount = first.parts[part("wheel_front_left")].mount;
    const CrumplePose pose = first.instance.attached_pose(mount).value();
    const float moved = length(pose.position - mount.point);
    const float turned = 2 * std::asin(length({pose.rotation.x, pose.rotation.y, pose.rotation.z})) * 57.29578f;
    std::printf("its wheel moved by %.1f mm and turned by %.1f degrees\n", double(1000 * moved), double(turned));
    fact(moved > 0.01f && turned > 3, "its wheel is out of line");
    fact(first.deepest(part("door_front_left")) > 0.05f, "the second car dented its door");
    fact(second.deepest(part("bumper_front")) > 0.03f, "and its own front");
    fact(!second.bumper && !second.parts[windscreen].broken, "but lost neither bumper nor windscreen");
    const auto saved = context.save_damage().value();
    std::printf("the damage of both cars takes %zu bytes\n", saved.size());
    fact(saved.size() < 1000, "damage is small");
    fact(context.contact_totals().value().refused == 0, "no hit was refused");
}

} // namespace

int main(int argc, char **argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: vehicle CAR.glb FOLDER\n");
        return 2;
    }
    try {
        run(argv[1], argv[2]);
    } catch (const crumple::Error &error) {
        std::fprintf(stderr, "%s: %s\n", crumple_result_name(error.result()), error.what());
        return 1;
    }
    return 0;
}
