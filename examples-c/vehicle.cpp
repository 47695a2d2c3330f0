// A car of eleven parts drives into a pole, and another car into its tail (rigid bodies: ODE). All parts share one list of marks.
// The bumper falls off when it is dented deep enough, the windshield breaks when it is hit, and a wheel gets out of line.
//
//     vehicle FOLDER [FRAMES]     writes FOLDER/frame_00.obj …, 5 frames or as many as you say
#include "ode_contacts.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace {

constexpr double STEP = 1.0 / 240, SECONDS = 1.6; // s
constexpr int ACROSS = 24, ALONG = 12, SPOKES = 24;
constexpr float HALF_WIDTH = 0.9f, SILL = 0.3f, WHEEL = 0.29f; // m
constexpr float DOWN = -0.35f;                     // from the centre of mass to the mesh's origin, m

void fact(bool holds, const char *what) {
    if (holds) return;
    std::fprintf(stderr, "this is not so: %s\n", what);
    std::exit(1);
}

// Parts of the car. Lods of the set have these numbers plus 1.
enum Part { BUMPER, GRILLE, HOOD, WINDSHIELD, ROOF, REAR_WINDOW, TRUNK, TAIL, REAR_BUMPER, LEFT, RIGHT, PARTS };

// When the bumper falls off, and when the wheel counts as out of line, m.
constexpr float BUMPER_HOLDS = 0.08f, WHEEL_HOLDS = 0.002f;

struct Mesh {
    std::vector<CrumpleVec3> positions;
    std::vector<uint32_t> indices;

    // A cylinder along y or z, with its centre at the origin.
    static Mesh cylinder(float radius, float length, bool upright) {
        Mesh made;
        for (uint32_t i = 0; i < 2 * SPOKES; ++i) {
            const float angle = 6.2831853f * float(i / 2) / SPOKES, along = i % 2 ? length / 2 : -length / 2;
            const float x = radius * std::cos(angle), y = radius * std::sin(angle);
            made.positions.push_back(upright ? CrumpleVec3{x, y, along} : CrumpleVec3{x, along, y});
            const uint32_t next = (i + 2) % (2 * SPOKES);
            if (i % 2 == 0) made.indices.insert(made.indices.end(), {i, next, i + 1, i + 1, next, next + 1});
            if (i >= 4) made.indices.insert(made.indices.end(), {i % 2, i - 2, i}); // the two ends
        }
        return made;
    }

    // A grid of rows by columns vertices, facing (b - a) x (c - a) of its first square.
    void grid(size_t rows, size_t columns, const std::vector<CrumpleVec3> &points) {
        positions = points;
        for (uint32_t r = 0; r + 1 < rows; ++r)
            for (uint32_t c = 0; c + 1 < columns; ++c) {
                const uint32_t a = r * uint32_t(columns) + c, b = a + uint32_t(columns);
                indices.insert(indices.end(), {a, b, b + 1, a, b + 1, a + 1});
            }
    }
};

// The car's outline from the front's lower edge over the roof to the rear's lower edge: x forward, z up, m.
constexpr std::array<std::array<float, 2>, 10> OUTLINE = {{{2.0f, SILL}, {2.05f, 0.6f}, {1.95f, 0.85f}, {0.9f, 0.95f}, {0.3f, 1.4f},
                                                           {-1.0f, 1.4f}, {-1.5f, 0.95f}, {-2.0f, 0.9f}, {-2.05f, 0.6f}, {-2.0f, SILL}}};

std::vector<Mesh> make_parts() {
    std::vector<Mesh> parts(PARTS);
    std::vector<std::array<float, 2>> top; // the outline above the sides
    for (size_t part = BUMPER; part <= REAR_BUMPER; ++part) {
        std::vector<CrumpleVec3> points;
        for (int i = 0; i <= ALONG; ++i) {
            const float t = float(i) / ALONG;
            const float x = OUTLINE[part][0] * (1 - t) + OUTLINE[part + 1][0] * t, z = OUTLINE[part][1] * (1 - t) + OUTLINE[part + 1][1] * t;
            for (int j = 0; j <= ACROSS; ++j) points.push_back({x, HALF_WIDTH * (2.0f * float(j) / ACROSS - 1), z});
            if (part >= HOOD && part <= TRUNK && (i > 0 || part == HOOD)) top.push_back({x, z});
        }
        parts[part].grid(ALONG + 1, ACROSS + 1, points);
    }
    for (const Part side : {LEFT, RIGHT}) {
        std::vector<CrumpleVec3> points;
        const float y = side == LEFT ? HALF_WIDTH : -HALF_WIDTH;
        for (const auto &column : top)
            for (int j = 0; j <= ALONG; ++j) {
                // The last row has the outline's own bits, so that it lies on the seam.
                const float t = float(side == LEFT ? ALONG - j : j) / ALONG;
                points.push_back({column[0], y, t == 1 ? column[1] : SILL + (column[1] - SILL) * t});
            }
        parts[side].grid(top.size(), ALONG + 1, points);
    }
    return parts;
}

// One set for all cars: the base mesh is all parts joined, and each part is a mesh of its own with the same positions.
crumple::ExampleSet make_set(crumple::Context &context, const std::vector<Mesh> &parts) {
    Mesh whole;
    for (const Mesh &part : parts) {
        const auto first = uint32_t(whole.positions.size());
        whole.positions.insert(whole.positions.end(), part.positions.begin(), part.positions.end());
        for (const uint32_t index : part.indices) whole.indices.push_back(first + index);
    }
    // Dents that an artist would make: front, hood, side, tail.
    struct Dent {
        CrumpleVec3 at, push;
        float radius;
    };
    const Dent dents[] = {{{2.05f, 0, 0.6f}, {-0.3f, 0, 0}, 0.8f},       {{2.05f, 0.5f, 0.6f}, {-0.2f, 0, 0}, 0.6f},
                          {{1.4f, 0, 0.9f}, {-0.03f, 0, -0.12f}, 0.5f},  {{0, HALF_WIDTH, 0.7f}, {0, -0.15f, 0}, 0.5f},
                          {{-2.05f, 0, 0.6f}, {0.25f, 0, 0.02f}, 0.7f}};
    std::vector<std::vector<CrumpleVec3>> targets;
    std::vector<CrumpleExampleDef> examples;
    for (const Dent &dent : dents) {
        targets.push_back(whole.positions);
        for (CrumpleVec3 &p : targets.back()) {
            const float x = p.x - dent.at.x, y = p.y - dent.at.y, z = p.z - dent.at.z;
            const float q = (x * x + y * y + z * z) / (dent.radius * dent.radius);
            if (q >= 1) continue;
            const float share = (1 - q) * (1 - q);
            p = {p.x + share * dent.push.x, p.y + share * dent.push.y, p.z + share * dent.push.z};
        }
    }
    for (size_t i = 0; i < targets.size(); ++i) {
        CrumpleExampleDef example = crumple_example_def_default();
        example.target_positions = crumple::input(targets[i]);
        example.contact_kind = CRUMPLE_CONTACT_KIND_POINT;
        example.contact_point = dents[i].at;
        examples.push_back(example);
    }
    const auto described = [](const Mesh &from) {
        CrumpleMeshDef to = crumple_mesh_def_default();
        to.vertex_count = uint32_t(from.positions.size());
        to.positions = crumple::input(from.positions);
        to.index_count = uint32_t(from.indices.size());
        to.indices = crumple::input(from.indices);
        return to;
    };
    const CrumpleMeshDef mesh = described(whole);
    CrumpleExampleSetDef def = crumple_example_set_def_default();
    def.mesh = &mesh;
    def.examples = examples.data();
    def.example_count = uint32_t(examples.size());
    crumple::ExampleSet set = context.create_example_set(def).value();
    for (size_t part = 0; part < parts.size(); ++part) {
        fact(set.add_lod(described(parts[part])).value() == part + 1, "parts are numbered in order");
    }
    return set;
}

// Writes Wavefront OBJ.
struct File {
    std::ofstream out;
    size_t written = 0; // vertices

    void object(const std::string &name, const char *material, const Mesh &mesh, const std::vector<CrumpleVec3> &world) {
        out << "o " << name << "\nusemtl " << material << '\n';
        for (const CrumpleVec3 &v : world) out << "v " << v.x << ' ' << v.y << ' ' << v.z << '\n';
        for (size_t i = 0; i < mesh.indices.size(); ++i)
            out << (i % 3 == 0 ? "f " : " ") << written + mesh.indices[i] + 1 << (i % 3 == 2 ? "\n" : "");
        written += world.size();
    }
};

// A part with its vertices and what shows them: the car or, once it has come off, the part itself.
struct Shown {
    std::vector<CrumpleVec3> vertices;
    crumple::Buffer buffer;
    dBodyID body = nullptr;
    bool gone = false;
};

struct Car {
    const char *name, *paint;
    const std::vector<Mesh> &meshes;
    dWorldID world;
    dSpaceID space;
    dBodyID body;
    crumple::Instance instance, bumper;
    std::array<CrumpleAttachment, 4> wheels{}; // the first is the front left one
    std::vector<Shown> shown{PARTS};
    uint64_t revision = 0; // of the damage, when what it holds was last compared
    bool straight = true;  // whether the front left wheel is in line

    Car(crumple::Context &context, OdeContacts &contacts, dWorldID world_, dSpaceID space_, const char *name_, const char *paint_,
        const crumple::ExampleSet &set, const std::vector<Mesh> &meshes_, double x, double angle, double speed)
        : name(name_), paint(paint_), meshes(meshes_), world(world_), space(space_), body(make_body(1200, 4.1, 1.8, 0.7)) {
        dMatrix3 rotation;
        dRFromAxisAndAngle(rotation, 0, 0, 1, angle);
        dBodySetRotation(body, rotation);
        dBodySetPosition(body, x, 0, 0.36);
        dBodySetLinearVel(body, speed * std::cos(angle), speed * std::sin(angle), 0);
        CrumpleInstanceDef def = crumple_instance_def_default();
        def.set = set.id();
        def.compliance = 2e-5f;   // m per N s: 10 000 N s leave 20 cm
        def.yield_impulse = 400;  // N s
        def.grow_time = 0.05f;    // s
        instance = context.create_instance(def).value();
        contacts.dent(dBodyGetFirstGeom(body), instance.id());
        for (const Part glass : {WINDSHIELD, REAR_WINDOW}) instance.set_part_rigid(glass + 1, true).value();
        for (uint32_t part = 0; part < PARTS; ++part) {
            shown[part].vertices.resize(meshes[part].positions.size());
            CrumpleHostBufferDef buffer = crumple_host_buffer_def_default();
            buffer.lod = part + 1;
            buffer.positions = crumple::stream(shown[part].vertices);
            shown[part].buffer = instance.register_buffer(buffer).value();
            shown[part].body = body;
        }
        for (size_t i = 0; i < wheels.size(); ++i) // where they are mounted
            wheels[i] = set.attach({i < 2 ? 1.5f : -1.4f, i % 2 ? -HALF_WIDTH : HALF_WIDTH, WHEEL}).value();
    }

    dBodyID make_body(double kg, double length, double width, double height) const {
        const dBodyID made = dBodyCreate(world);
        dMass mass;
        dMassSetBoxTotal(&mass, kg, length, width, height);
        dBodySetMass(made, &mass);
        dGeomSetBody(dCreateBox(space, length, width, height), made);
        return made;
    }

    // A stone: an impulse in the car's own space, at a point of the mesh.
    void strike(const CrumpleVec3 &point, const CrumpleVec3 &impulse) {
        const CrumpleHitResult told = instance.submit_impulse(point, impulse, 0).value();
        if (told.status != CRUMPLE_HIT_STATUS_RIGID) return;
        std::printf("%-6s  the windshield breaks\n", name);
        shown[WINDSHIELD].gone = true;
    }

    // How far a wheel's mount moved, m.
    float wheel_moved(const CrumpleAttachment &wheel) const {
        const CrumpleVec3 to = instance.attached_pose(wheel).value().position, from = wheel.point;
        return std::hypot(std::hypot(to.x - from.x, to.y - from.y), to.z - from.z);
    }

    // What the dents do to the car.
    void suffer(double time) {
        const float moved = wheel_moved(wheels[0]);
        if (straight && moved >= WHEEL_HOLDS) {
            straight = false;
            std::printf("%-6s  %.2f s: the wheel is %.1f mm out of line\n", name, time, 1000 * double(moved));
        }
        // To measure a part takes as long as to deform it.
        const uint64_t before = std::exchange(revision, instance.info().value().revision);
        if (before == revision || bumper || instance.measure_part(BUMPER + 1).value().deepest < BUMPER_HOLDS) return;
        // Off it comes, with its buffer and its dents, as a body of its own.
        bumper = instance.release_part(BUMPER + 1).value();
        const dBodyID off = make_body(12, 0.1, 1.8, 0.3);
        dVector3 at, speed;
        dBodyGetRelPointPos(body, 2.2, 0, 0.45 + DOWN, at);
        dBodyGetRelPointVel(body, 2.2, 0, 0.45 + DOWN, speed);
        dBodySetPosition(off, at[0], at[1], at[2] + 0.2);
        dBodySetQuaternion(off, dBodyGetQuaternion(body));
        dBodySetLinearVel(off, -0.5 * speed[0], 1.5, 2);
        shown[BUMPER].body = off;
        std::printf("%-6s  %.2f s: the bumper falls off\n", name, time);
    }

    void write(File &file) const {
        for (size_t part = 0; part < PARTS; ++part) {
            if (shown[part].gone) continue;
            const bool off = shown[part].body != body, glass = part == WINDSHIELD || part == REAR_WINDOW;
            std::vector<CrumpleVec3> points;
            for (const CrumpleVec3 &v : shown[part].vertices)
                points.push_back(placed(shown[part].body, off ? CrumpleVec3{v.x - 2.0f, v.y, v.z - 0.45f} : v, off ? 0 : DOWN));
            const bool plastic = part == BUMPER || part == REAR_BUMPER;
            file.object(name + ('_' + std::to_string(part)), glass ? "glass" : plastic ? "plastic" : paint, meshes[part], points);
        }
        static const Mesh tyre = Mesh::cylinder(WHEEL, 0.2f, false);
        for (size_t i = 0; i < wheels.size(); ++i) {
            // The wheel moves and turns as the place where it is mounted.
            const CrumplePose frame = instance.attached_pose(wheels[i]).value();
            std::vector<CrumpleVec3> points;
            for (const CrumpleVec3 &v : tyre.positions) {
                const CrumpleVec3 turned = rotated(frame.rotation, v), at = frame.position;
                points.push_back(placed(body, {at.x + turned.x, at.y + turned.y, at.z + turned.z}, DOWN));
            }
            file.object(name + ("_wheel_" + std::to_string(i)), "tyre", tyre, points);
        }
    }

    static CrumpleVec3 placed(dBodyID on, CrumpleVec3 v, float up) {
        dVector3 p;
        dBodyGetRelPointPos(on, v.x, v.y, v.z + up, p);
        return {float(p[0]), float(p[1]), float(p[2])};
    }

    static CrumpleVec3 rotated(CrumpleQuat q, CrumpleVec3 v) {
        const CrumpleVec3 t{2 * (q.y * v.z - q.z * v.y), 2 * (q.z * v.x - q.x * v.z), 2 * (q.x * v.y - q.y * v.x)};
        return {v.x + q.w * t.x + q.y * t.z - q.z * t.y, v.y + q.w * t.y + q.z * t.x - q.x * t.z,
                v.z + q.w * t.z + q.x * t.y - q.y * t.x};
    }
};

struct Scene {
    dWorldID world = dWorldCreate();
    dSpaceID space = dHashSpaceCreate(nullptr);
    dJointGroupID joints = dJointGroupCreate(0);
    dGeomID ground = dCreatePlane(space, 0, 0, 1, 0);
    OdeContacts contacts;

    explicit Scene(crumple::Context &context) : contacts(context) { dWorldSetGravity(world, 0, 0, -9.81); }
    ~Scene() {
        dJointGroupDestroy(joints);
        dSpaceDestroy(space);
        dWorldDestroy(world);
    }

    static void near(void *user, dGeomID a, dGeomID b) {
        auto &scene = *static_cast<Scene *>(user);
        if (dGeomGetBody(a) == dGeomGetBody(b)) return;
        std::array<dContactGeom, 8> found;
        const int count = dCollide(a, b, int(found.size()), found.data(), sizeof found[0]);
        for (int i = 0; i < count; ++i) {
            dContact contact{};
            contact.geom = found[size_t(i)];
            contact.surface.mode = dContactBounce;
            contact.surface.mu = a == scene.ground || b == scene.ground ? 0.05 : 0.4; // wheels roll
            contact.surface.bounce = 0.1;
            contact.surface.bounce_vel = 0.5;
            const dJointID joint = dJointCreateContact(scene.world, scene.joints, &contact);
            dJointAttach(joint, dGeomGetBody(a), dGeomGetBody(b));
            scene.contacts.add(joint, contact.geom);
        }
    }

    void step() {
        dSpaceCollide(space, this, near);
        dWorldStep(world, STEP);
        contacts.step(STEP);
        dJointGroupEmpty(joints);
    }
};

void run(const std::string &folder, int frames) {
    crumple::Context context;
    const std::vector<Mesh> meshes = make_parts();
    const crumple::ExampleSet set = make_set(context, meshes);
    Scene scene(context);
    const dGeomID pole = dCreateCylinder(scene.space, 0.15, 3);
    dGeomSetPosition(pole, 4, 0.65, 1.5);
    const Mesh shown_pole = Mesh::cylinder(0.15f, 1.8f, true);
    std::vector<std::unique_ptr<Car>> cars;
    const auto add = [&](const char *name, const char *paint, double x, double speed) {
        cars.push_back(std::make_unique<Car>(context, scene.contacts, scene.world, scene.space, name, paint, set, meshes, x, 0.0, speed));
    };
    add("first", "blue", 0.0, 12.0);
    add("second", "red", -12.0, 14.0);
    // A stone falls onto the first car's windshield. ODE's box is lower than the glass, so it is told here.
    int frame = 0;
    for (int step = 0; step * STEP <= SECONDS; ++step) {
        const double time = step * STEP;
        context.set_time(time).value();
        for (auto &car : cars) follow_body(car->instance, car->body, 0, 0, DOWN);
        scene.step();
        if (step == 200) cars[0]->strike({0.6f, 0, 1.2f}, {0, 0, -20});
        for (auto &car : cars) car->suffer(time);
        context.deform().value();
        if (time >= frame * SECONDS / (frames - 1) - 1e-9) {
            char name[32];
            std::snprintf(name, sizeof name, "/frame_%02d.obj", frame++);
            File file{std::ofstream(folder + name)};
            for (const auto &car : cars) car->write(file);
            std::vector<CrumpleVec3> world;
            for (const CrumpleVec3 &v : shown_pole.positions) world.push_back({v.x + 4, v.y + 0.65f, v.z + 0.9f});
            file.object("pole", "steel", shown_pole, world);
            fact(bool(file.out.flush()), "every frame was written");
        }
    }
    fact(frame == frames, "there are as many frames as asked for");

    const Car &first = *cars[0], &second = *cars[1];
    fact(bool(first.bumper), "the first car lost its bumper on the pole");
    fact(first.shown[WINDSHIELD].gone, "its windshield broke");
    const auto deepest = [](const Car &car, uint32_t from, uint32_t to) {
        float deepest = 0;
        for (uint32_t part = from; part <= to; ++part)
            deepest = std::fmax(deepest, car.instance.measure_part(part + 1).value().deepest);
        return deepest;
    };
    fact(deepest(first, TRUNK, RIGHT) > 0.05f, "its rear or side is dented by the second car");
    fact(deepest(second, BUMPER, HOOD) > 0.05f, "and the second car's front by the first");
    // Seams between parts that are on the car are closed: the last row of the grille is the first of the hood.
    for (size_t v = 0; v <= ACROSS; ++v) {
        const CrumpleVec3 a = first.shown[GRILLE].vertices[ALONG * (ACROSS + 1) + v], b = first.shown[HOOD].vertices[v];
        fact(a.x == b.x && a.y == b.y && a.z == b.z, "the seam is closed");
    }
    // How far the second car's front wheel's mount moved, and by how much it is turned.
    const CrumpleQuat q = second.instance.attached_pose(second.wheels[0]).value().rotation;
    const double turn = 2 * std::atan2(std::hypot(std::hypot(q.x, q.y), q.z), std::fabs(q.w)) * 180 / 3.14159265358979;
    const double moved = double(second.wheel_moved(second.wheels[0]));
    std::printf("the wheel moved by %.1f mm and turned by %.2f degrees\n", 1000 * moved, turn);
    fact(moved > 0.001 && turn > 0.1, "the wheel is out of line");
    const auto saved = context.save_damage().value();
    std::printf("the damage of both cars takes %zu bytes\n", saved.size());
    fact(saved.size() < 6000, "damage is small");
}

} // namespace

int main(int argc, char **argv) {
    const int frames = argc == 3 ? std::atoi(argv[2]) : 5;
    if (argc < 2 || argc > 3 || frames < 2 || frames > 99) {
        std::fprintf(stderr, "usage: vehicle FOLDER [2 to 99 FRAMES]\n");
        return 2;
    }
    dInitODE2(0);
    int status = 0;
    try {
        run(argv[1], frames);
    } catch (const crumple::Error &error) {
        std::fprintf(stderr, "%s: %s\n", crumple_result_name(error.result()), error.what());
        status = 1;
    }
    dCloseODE();
    return status;
}
