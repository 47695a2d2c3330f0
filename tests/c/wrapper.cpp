// The C++ owners: moves, releases, the order of destruction, errors with and without exceptions. The headers may be included twice and in any
// order, and need nothing before them.
#include <crumple.hpp>
#include <crumple.h>
#include <crumple.hpp>

extern "C" {
#include "support.h"
}

#include <cstring>
#include <memory>
#include <type_traits>
#include <vector>

static_assert(std::is_standard_layout_v<CrumpleExampleSetDef> && std::is_trivial_v<CrumpleExampleSetDef>);
static_assert(std::is_nothrow_move_constructible_v<crumple::Context> && !std::is_copy_constructible_v<crumple::Context>);
static_assert(std::is_nothrow_move_assignable_v<crumple::Instance> && !std::is_copy_assignable_v<crumple::Instance>);

int main() {
    auto sheet = std::make_unique<Sheet>();
    make_sheet(sheet.get());

    auto made = crumple::Context::create();
    FACT(made.ok() && made.result() == CRUMPLE_OK && made.message().empty());
    crumple::Context context = std::move(made).value();

    crumple::ExampleSet set = context.create_example_set(sheet->def).value();
    FACT(set && set.info().value().vertex_count == VERTICES);
    FACT(set.example(1).value().moved_vertices > 0);
    FACT(set.primitive(0).value().vertex_count == VERTICES);
    const auto nearest = set.nearest_vertex(vec3(0, 0, 1)).value();
    FACT(nearest.vertex == VERTICES / 2 && nearest.distance > 0.9f);
    std::vector<CrumpleVec3> base(VERTICES);
    CrumpleMeshCopyDef copy = crumple_mesh_copy_def_default();
    copy.positions = crumple::stream(base);
    set.copy_mesh(copy).value();
    FACT(std::memcmp(base.data(), sheet->positions, sizeof sheet->positions) == 0);

    crumple::Instance body = context.create_instance(set).value(), other = context.create_instance(set).value();
    std::vector<CrumpleVec3> positions(VERTICES), normals(VERTICES);
    crumple::Buffer buffer = body.register_buffer(crumple::stream(positions), crumple::stream(normals)).value();
    FACT(buffer.bounds().value().max.x == 0.5f);
    body.set_user_data(9).value();
    FACT(body.user_data().value() == 9 && buffer.info().value().instance_user_data == 9);
    const auto told = body.submit_displacement(vec3(0.1f, 0.1f, 0.07f), vec3(0, 0, -0.04f)).value();
    FACT(told.status == CRUMPLE_HIT_STATUS_MARKED);
    CrumpleHitDef impulse = crumple_hit_def_default();
    impulse.point = vec3(0.1f, 0.1f, 0.07f);
    impulse.impulse = vec3(0, 0, -1);
    impulse.duration = 0.01f;
    impulse.mass = 1;
    impulse.normal = vec3(0, 0, 1);
    impulse.striker = {2.5f, 0.1f, vec3(0, 0, -0.4f), CRUMPLE_STRIKER_SHAPE_BALL, {}};
    FACT(other.preview(impulse).value().status == CRUMPLE_HIT_STATUS_MARKED && other.marks().value().empty());
    FACT(body.end_contact(7).result() == CRUMPLE_ERROR_UNKNOWN_CONTACT);
    CrumpleContactPointDef touch = crumple_contact_point_def_default();
    touch.bodies[0] = body.id(), touch.normal = vec3(0, 0, 1), touch.point = vec3(0.3f, 0, 0.07f), touch.has_velocity = true;
    touch.velocity = vec3(0, 0, -5), touch.impulse = 0;
    context.report_contacts(&touch, 1).value();
    FACT(context.step_contacts(1.0f / 60).value().points == 1 && context.contact_hits().value().empty());
    FACT(body.end_contact(0).result() == CRUMPLE_ERROR_INVALID_ARGUMENT);
    FACT(context.deform().value().vertices_written == VERTICES);
    FACT(buffer.changes().value().size() == 1);
    CrumpleAabb box{};
    FACT(buffer.changed_triangles(&box).value().size() == 1 && box.max.x == 0.5f);
    FACT(body.marks().value().size() == 1 && other.marks().value().empty());
    const auto saved = body.save().value();
    other.load(saved).value();
    FACT(other.save().value() == saved);
    other.set_marks(body.marks().value()).value();
    other.repair(0).value();
    FACT(other.marks().value().empty());
    other.copy_damage(body.id()).value();
    FACT(other.info().value().mark_count == 1);
    const auto lamp = set.attach(vec3(0.1f, 0.1f, 0.2f)).value();
    FACT(body.attached_pose(lamp).value().position.z < lamp.point.z - 0.01f);

    // Many at once.
    const CrumpleInstance both[] = {body.id(), other.id()};
    CrumpleHitDef hits[] = {crumple_hit_def_default(), crumple_hit_def_default()};
    hits[0].kind = hits[1].kind = CRUMPLE_HIT_KIND_DISPLACEMENT;
    hits[0].point = hits[1].point = vec3(0.2f, 0, 0.07f);
    hits[0].displacement = hits[1].displacement = vec3(0, 0, -0.02f);
    FACT(context.submit(both, hits, 2).value()[1].status == CRUMPLE_HIT_STATUS_MARKED);
    impulse.impulse = vec3(0, 0, -0.001f);
    FACT(context.submit(both, &impulse, 1).value().size() == 1);
    context.deform().value();
    FACT(context.changed_buffers().value().size() == 1 && context.changed_buffers().value()[0].buffer.index == buffer.id().index);
    const auto all = context.save_damage().value();
    const uint64_t others = other.info().value().revision;
    other.load(body.save().value()).value();
    FACT(other.info().value().revision == body.info().value().revision);
    other.repair_around(vec3(0.2f, 0, 0.07f), 0.1f, 0).value();
    FACT(other.info().value().revision != body.info().value().revision);
    context.load_damage(all).value();
    FACT(other.info().value().revision == others);
    FACT(!context.load_damage(all, both, 1).ok());
    context.set_time(1).value();
    crumple::Context elsewhere = crumple::Context::create().value();
    crumple::ExampleSet there = set.share(elsewhere.get()).value();
    FACT(there.info().value().fingerprint == set.info().value().fingerprint);
    FACT(set.share(context.get()).result() == CRUMPLE_ERROR_INVALID_ARGUMENT);

    // Parts.
    crumple::ExampleSet sheets = context.create_example_set(sheet->def).value();
    CrumpleMeshDef half = sheet->mesh;
    half.vertex_count = SIDE * 2;
    half.index_count = (SIDE - 1) * 6;
    half.tangents = CrumpleInput{};
    const uint32_t part = sheets.add_lod(half).value();
    crumple::Instance whole = context.create_instance(sheets).value(), off = whole.release_part(part).value();
    FACT(off.submit_displacement(vec3(0, 0, 0.07f), vec3(0, 0, -0.04f)).value().contact_vertex < SIDE * 2);
    FACT(off.measure_part(part).value().deepest > off.measure_part(part).value().mean);
    FACT(off.measure_part(part).value().equivalent_depth > 0);
    whole.mount_part(off).value();
    FACT(!whole.mount_part(off).ok());
    whole.set_part_rigid(part, true).value();

    // Streams of interleaved vertices.
    struct Vertex {
        float position[3];
        float normal[3];
    };
    std::vector<Vertex> vertices(VERTICES);
    const CrumpleStream normal = crumple::stream(vertices, &Vertex::normal);
    FACT(normal.data == vertices.data() && normal.offset == 12 && normal.stride == 24 && normal.size == VERTICES * 24);
    crumple::Buffer interleaved = body.register_buffer(crumple::stream(vertices, &Vertex::position), normal).value();
    interleaved.reset();

    // Plans for a render graph.
    if (crumple_features() & CRUMPLE_FEATURE_VULKAN) {
        CrumpleVulkanBufferDef graph = crumple_vulkan_buffer_def_default();
        graph.buffer_size = graph.size = VERTICES * 12;
        graph.positions.stride = 12;
        graph.positions.format = 106; // VK_FORMAT_R32G32B32_SFLOAT
        const crumple::Buffer shown = body.register_graph_buffer(graph).value();
        const CrumpleGraphPlan plan = context.plan_graph().value();
        FACT(plan.dispatch_count == 1);
        const auto kernel = crumple::Context::graph_kernel(plan.dispatches[0].kernel).value();
        FACT(kernel.size() > 1000 && kernel[0] == 0x03 && kernel[1] == 0x02);
    }

    // Errors.
    const auto failed = body.submit_impulse(vec3(0, 0, 0), vec3(0, 0, -1), 0);
    FACT(!failed && failed.result() == CRUMPLE_ERROR_INVALID_ARGUMENT);
    FACT(failed.message().find("duration") != std::string::npos);
    FACT(body.submit_impulse(vec3(0, 0, 0), vec3(0, 0, -1), 0).value_or(CrumpleHitResult{}).mark.hits == 0);
    auto named = context.create_instance(set);
    FACT(named.take().info().ok());
#ifndef CRUMPLE_NO_EXCEPTIONS
    bool caught = false;
    try {
        context.load_gltf("no/such/file.glb").value();
    } catch (const crumple::Error &error) {
        caught = error.result() != CRUMPLE_OK && std::string(error.what()).find("crumple_example_set_load_gltf") == 0;
    }
    FACT(caught);
#else
    FACT(!context.load_gltf("no/such/file.glb").ok());
#endif

    // Owners move, and destroy what they own once.
    crumple::Instance moved = std::move(body);
    FACT(moved && !body && moved.info().ok()); // NOLINT: looks at what was moved from
    const CrumpleInstance id = moved.id();
    moved = std::move(other);
    FAILS(CRUMPLE_ERROR_INVALID_ID, "stale", crumple_instance_reset_damage(context.get(), id));
    FAILS(CRUMPLE_ERROR_INVALID_ID, "stale", crumple_buffer_invalidate(context.get(), buffer.id()));
    const CrumpleInstance handed = moved.release();
    FACT(!moved);
    OK(crumple_instance_destroy(context.get(), handed));
    const CrumpleExampleSet set_id = set.id();
    set.reset();
    FAILS(CRUMPLE_ERROR_INVALID_ID, "stale", crumple_example_set_destroy(context.get(), set_id));

    // An owner that outlives its context does nothing.
    crumple::ExampleSet late = context.create_example_set(sheet->def).value();
    crumple::Context taken = std::move(context);
    taken.reset();
    late.reset();
    std::printf("%u checks\n", checks);
    return 0;
}
