// What the programs of the lab's throws share: each throws balls and boxes at a fixed body in one engine, and writes what they leave. The
// lab starts them.
//
//     bullet|jolt SET.crumple THROWS OUT
//
// A line of THROWS is: "ball" or "box", half of its width, its mass, the rate of steps, the seconds, the friction, the depth limit,
// its place, its velocity and its rotation (x y z w). OUT gets for each throw the first mark's vertex (or UINT32_MAX) and the
// displacement of every vertex.
#ifndef THROWS_HPP
#define THROWS_HPP

#include <crumple.hpp>

#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

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

// The mesh of the body, which the engines read while they live.
struct Surface {
    std::vector<CrumpleVec3> vertices;
    std::vector<uint32_t> indices;

    explicit Surface(const crumple::ExampleSet &set) {
        const CrumpleExampleSetInfo info = set.info().value();
        vertices.resize(info.vertex_count);
        indices.resize(size_t(info.triangle_count) * 3);
        CrumpleMeshCopyDef copy = crumple_mesh_copy_def_default();
        copy.positions = crumple::stream(vertices);
        copy.indices = crumple::stream(indices);
        set.copy_mesh(copy).value();
    }
};

// Throws each of the list. An Engine is made of a Surface, and strikes an instance: strike(throw, context, instance).
template <class Engine> bool throw_all(const char *set_file, const char *list, const char *out_file) {
    crumple::Context context;
    const crumple::ExampleSet set = context.load_baked(set_file).value();
    const Surface rest(set);
    std::vector<CrumpleVec3> dented(rest.vertices.size());
    Engine engine(rest);

    std::ifstream in(list);
    std::ofstream out(out_file, std::ios::binary);
    for (std::string line; std::getline(in, line);) {
        Throw thrown;
        std::istringstream words(line);
        if (!thrown.read(words)) {
            std::fprintf(stderr, "this line has too few words: %s\n", line.c_str());
            return false;
        }
        CrumpleInstanceDef def = crumple_instance_def_default();
        def.set = set.id();
        def.depth_limit = thrown.depth_limit;
        crumple::Instance instance = context.create_instance(def).value();
        const crumple::Buffer buffer = instance.register_buffer(crumple::stream(dented)).value();
        engine.strike(thrown, context, instance.id());
        context.clear_contacts().value();
        context.deform().value();
        const std::vector<CrumpleMark> marks = instance.marks().value();
        const uint32_t contact = marks.empty() ? UINT32_MAX : marks[0].contact;
        out.write(reinterpret_cast<const char *>(&contact), sizeof contact);
        for (size_t v = 0; v < dented.size(); ++v) {
            const CrumpleVec3 &from = rest.vertices[v];
            const float moved[3] = {dented[v].x - from.x, dented[v].y - from.y, dented[v].z - from.z};
            out.write(reinterpret_cast<const char *>(moved), sizeof moved);
        }
    }
    if (context.contact_totals().value().refused == 0 && out.flush()) return true;
    std::fprintf(stderr, "a hit was refused, or %s cannot be written\n", out_file);
    return false;
}

template <class Engine> int throws_main(int argc, char **argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: %s SET.crumple THROWS OUT\n", argv[0]);
        return 2;
    }
    try {
        return throw_all<Engine>(argv[1], argv[2], argv[3]) ? 0 : 1;
    } catch (const crumple::Error &error) {
        std::fprintf(stderr, "%s: %s\n", crumple_result_name(error.result()), error.what());
        return 1;
    }
}

#endif
