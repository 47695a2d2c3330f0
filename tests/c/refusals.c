// The host's allocator refuses blocks: for each call, blocks in turn, alone and with all later ones. The call returns
// CRUMPLE_ERROR_OUT_OF_MEMORY and has changed nothing, or it succeeds with memory of the system's. The process goes on either way.
//
// `cargo xtask test --only repository` checks that each function of the headers is here, except those of Vulkan.
#define SHEET_SIDE 5 // sets are built thousands of times
#include "heap.h"
#include "support.h"

#include <crumple_contacts.h>
#include <crumple_graph.h>
#include <crumple_import.h>
#include <crumple_parts.h>
#include <crumple_view.h>

enum { ROOM = 1 << 16, HALF = SIDE * (SIDE + 1) / 2 };

static Heap heap;
static Sheet sheet;
// The sheet's lower rows, and the upper ones; the middle row is in both.
static CrumpleMeshDef halves[2];
static unsigned char baked[ROOM], glb[ROOM];
static size_t baked_size, glb_size;
static const char *baked_file, *glb_file, *obj_files[2];

static void make_plate(void) {
    make_sheet(&sheet);
    sheet.def.example_count = 1;
    sheet.examples[0].impulse = vec3(0, 0, -10);
    sheet.examples[0].striker.mass = 2;
    sheet.examples[0].striker.velocity = vec3(0, 0, -5);
    for (int half = 0; half < 2; ++half) {
        const size_t first = half ? SIDE * (SIDE / 2) : 0;
        halves[half] = sheet.mesh;
        halves[half].vertex_count = HALF;
        halves[half].index_count = INDICES / 2;
        halves[half].positions = input_of(sheet.positions[first], HALF * 12, 12);
        halves[half].normals = input_of(sheet.normals[first], HALF * 12, 12);
        halves[half].tangents = input_of(NULL, 0, 0);
    }
}

// Bakes the sheet with its halves.
static void bake(const char *folder) {
    CrumpleContext *context = make_context(1);
    CrumpleExampleSet set;
    uint32_t lod;
    baked_file = path_in(folder, "refusals.crumple");
    OK(crumple_example_set_create(context, &sheet.def, &set));
    for (int i = 0; i < 2; ++i) OK(crumple_example_set_add_lod(context, set, &halves[i], &lod));
    OK(crumple_example_set_save_baked(context, set, baked, sizeof baked, &baked_size));
    write_file(baked_file, baked, baked_size);
    OK(crumple_context_destroy(context));
}

// What there is before each call: a body with marks, an open contact and two buffers, another body, a part of a third, contact
// points that wait.
typedef struct World {
    CrumpleContext *context, *other;
    CrumpleExampleSet set;
    CrumpleInstance body, second, whole, part, made;
    CrumpleBuffer buffer, graph, created;
    CrumpleAttachment lamp;
    float vertices[VERTICES][3], more[VERTICES][3];
    unsigned char saved[1024], all[4096], bytes[ROOM];
    size_t saved_size, all_size, size;
    CrumpleMark marks[8];
    uint32_t mark_count, count;
} World;

static CrumpleHitDef hit_at(float x, float y, uint64_t contact_id) {
    CrumpleHitDef def = crumple_hit_def_default();
    def.point = vec3(x, y, 0.07f);
    def.impulse = vec3(0, 0, -6);
    def.contact_id = contact_id;
    return def;
}

static CrumpleContactPointDef point_of(CrumpleInstance body, uint64_t pair) {
    CrumpleContactPointDef def = crumple_contact_point_def_default();
    def.pair = pair;
    def.bodies[0] = body;
    def.point = vec3(0, 0, 0.075f);
    def.normal = vec3(0, 0, 1);
    def.has_velocity = true;
    def.velocity = vec3(0, 0, -5);
    def.impulse = 8;
    return def;
}

static CrumpleVulkanBufferDef graph_memory(void) {
    CrumpleVulkanBufferDef def = crumple_vulkan_buffer_def_default();
    def.buffer = 7;
    def.buffer_size = def.size = sizeof sheet.positions;
    def.positions.stride = 12;
    def.positions.format = 106; // VK_FORMAT_R32G32B32_SFLOAT
    return def;
}

static bool has(uint64_t feature) { return (crumple_features() & feature) != 0; }

static void make_world(World *w, bool empty) {
    memset(w, 0, sizeof *w);
    w->context = make_context(1);
    if (empty) return;
    w->other = make_context(1);
    OK(crumple_example_set_load_baked_memory(w->context, baked, baked_size, CRUMPLE_BYTES_KEEP, &w->set));
    w->body = make_instance(w->context, w->set);
    w->second = make_instance(w->context, w->set);
    w->whole = make_instance(w->context, w->set);
    OK(crumple_instance_release_part(w->context, w->whole, 1, &w->part));
    OK(crumple_example_set_attach_point(w->context, w->set, vec3(0.1f, 0.1f, 1), &w->lamp));
    w->buffer = make_buffer(w->context, w->body, host_def(w->vertices, VERTICES, 3));
    const CrumpleVulkanBufferDef graph = graph_memory();
    if (has(CRUMPLE_FEATURE_VULKAN)) OK(crumple_buffer_register_graph(w->context, w->body, &graph, &w->graph));
    for (int i = 0; i < 3; ++i) {
        const CrumpleHitDef hit = hit_at(0.25f * (float)(i - 1), 0, i == 2 ? 5 : 0);
        OK(crumple_instance_submit_hit(w->context, w->body, &hit, NULL));
    }
    OK(crumple_context_deform(w->context, NULL, 0, NULL));
    OK(crumple_instance_get_marks(w->context, w->body, w->marks, 8, &w->mark_count));
    FACT(w->mark_count > 0);
    OK(crumple_instance_save_damage(w->context, w->body, w->saved, sizeof w->saved, &w->saved_size));
    OK(crumple_context_save_damage(w->context, NULL, 0, w->all, sizeof w->all, &w->all_size));
    const CrumpleContactPointDef point = point_of(w->second, 1);
    OK(crumple_context_report_contacts(w->context, &point, 1));
    OK(crumple_context_step_contacts(w->context, 0.01f, NULL));
    OK(crumple_context_report_contacts(w->context, &point, 1));
}

// Whether the damage, and what there is, are those of make_world().
static void check_unchanged(World *w) {
    CrumpleInstanceInfo info;
    OK(crumple_instance_save_damage(w->context, w->body, w->bytes, sizeof w->bytes, &w->size));
    FACT(w->size == w->saved_size && memcmp(w->bytes, w->saved, w->size) == 0);
    OK(crumple_instance_get_info(w->context, w->body, &info));
    FACT(info.buffer_count == (has(CRUMPLE_FEATURE_VULKAN) ? 2 : 1) && info.contact_count == 1);
}

// --- The calls, in groups that may be repeated from their start.

typedef CrumpleResult (*Call)(World *w);

#define TRY(call)                                                                                                      \
    do {                                                                                                               \
        const CrumpleResult tried_ = (call);                                                                           \
        if (tried_ != CRUMPLE_OK) return tried_;                                                                       \
    } while (0)
#define THAT(condition) TRY((condition) ? CRUMPLE_OK : CRUMPLE_ERROR_INTERNAL)

static CrumpleResult contexts(World *w) {
    CrumpleContextDef def = crumple_context_def_default();
    CrumpleContext *context = NULL;
    (void)w;
    THAT(crumple_version() == CRUMPLE_VERSION && crumple_version_string() && crumple_features() < 16);
    THAT(crumple_last_error() && crumple_result_name(CRUMPLE_OK));
    def.threads = 1;
    TRY(crumple_context_create(&def, &context));
    return crumple_context_destroy(context);
}

static CrumpleResult create_set(World *w) { return crumple_example_set_create(w->context, &sheet.def, &w->set); }

static CrumpleResult load_baked(World *w) {
    TRY(crumple_example_set_load_baked_memory(w->context, baked, baked_size, CRUMPLE_BYTES_COPY, &w->set));
    return crumple_example_set_load_baked(w->context, baked_file, &w->set);
}

static CrumpleResult load_gltf(World *w) {
    CrumpleGltfDef def = crumple_gltf_def_default();
    def.path = glb_file;
    TRY(crumple_example_set_load_gltf(w->context, &def, &w->set));
    def.join_nodes = true;
    return crumple_example_set_load_gltf_memory(w->context, glb, glb_size, &def, &w->set);
}

static CrumpleResult load_obj(World *w) {
    CrumpleObjDef def = crumple_obj_def_default();
    def.base_path = obj_files[0];
    def.example_paths = &obj_files[1];
    def.example_count = 1;
    return crumple_example_set_load_obj(w->context, &def, &w->set);
}

static CrumpleResult add_lod(World *w) {
    CrumpleExampleSet fresh;
    TRY(crumple_example_set_load_baked_memory(w->context, baked, baked_size, CRUMPLE_BYTES_KEEP, &fresh));
    return crumple_example_set_add_lod(w->context, fresh, &halves[0], &w->count);
}

static CrumpleResult uses_of_a_set(World *w) {
    const CrumpleCapsule capsule = {vec3(0, 0, -1), vec3(0.4f, 0.4f, -1), 0.2f};
    float limits[VERTICES];
    CrumpleExampleSetInfo info;
    CrumpleExampleInfo example;
    CrumplePrimitive primitive;
    CrumplePart part;
    CrumpleAttachment at;
    CrumpleExampleSet shared;
    CrumpleMeshCopyDef copy = crumple_mesh_copy_def_default();
    copy.positions = stream_of(w->more, sizeof w->more, 0, 12);
    TRY(crumple_mesh_keep_out(&sheet.mesh, &capsule, 1, NULL, 0, limits));
    THAT(crumple_example_set_is_valid(w->context, w->set));
    TRY(crumple_example_set_get_info(w->context, w->set, &info));
    TRY(crumple_example_set_get_example(w->context, w->set, 0, &example));
    TRY(crumple_example_set_get_primitive(w->context, w->set, 0, &primitive));
    TRY(crumple_example_set_copy_mesh(w->context, w->set, &copy));
    TRY(crumple_example_set_find_nearest_vertex(w->context, w->set, vec3(0, 0, 1), &w->count, NULL));
    // A baked set has no names of parts.
    THAT(crumple_example_set_find_part(w->context, w->set, "wing", &w->count) == CRUMPLE_ERROR_INVALID_ARGUMENT);
    THAT(crumple_example_set_get_part(w->context, w->set, 1, &part) == CRUMPLE_ERROR_INVALID_ARGUMENT);
    TRY(crumple_example_set_attach_point(w->context, w->set, vec3(0, 0, 1), &at));
    return crumple_example_set_share(w->context, w->set, w->other, &shared);
}

static CrumpleResult create_and_register(World *w) {
    const CrumpleHostBufferDef memory = host_def(w->more, VERTICES, 3);
    CrumpleInstanceDef def = crumple_instance_def_default();
    def.set = w->set;
    TRY(crumple_instance_create(w->context, &def, &w->made));
    TRY(crumple_buffer_register_host(w->context, w->second, &memory, &w->created));
    return crumple_instance_release_part(w->context, w->second, 1, &w->made);
}

static CrumpleResult reads_of_an_instance(World *w) {
    const CrumpleHitDef hit = hit_at(0.1f, 0.1f, 0);
    uint64_t data;
    CrumpleInstanceInfo info;
    CrumpleHitResult result;
    CrumpleMark marks[8];
    CrumplePose pose;
    float deepest;
    THAT(crumple_instance_is_valid(w->context, w->body));
    TRY(crumple_instance_get_user_data(w->context, w->body, &data));
    TRY(crumple_instance_get_info(w->context, w->body, &info));
    TRY(crumple_instance_preview_hit(w->context, w->body, &hit, &result));
    TRY(crumple_instance_get_contact(w->context, w->body, 5, &result));
    TRY(crumple_instance_get_marks(w->context, w->body, marks, 8, &w->count));
    TRY(crumple_instance_measure_part(w->context, w->body, 0, &deepest, NULL, NULL));
    return crumple_instance_get_attached_pose(w->context, w->body, &w->lamp, &pose);
}

static CrumpleResult settings(World *w) {
    const float matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 2, 3, 4, 1};
    TRY(crumple_instance_set_user_data(w->context, w->body, 3));
    TRY(crumple_instance_set_transform(w->context, w->second, matrix));
    TRY(crumple_instance_set_depth_limit(w->context, w->second, 0.1f));
    TRY(crumple_instance_set_view(w->context, w->second, 0.5f, 10, 1, 1080, &w->count));
    TRY(crumple_instance_set_part_rigid(w->context, w->second, 1, true));
    TRY(crumple_context_set_vertex_budget(w->context, 100));
    return crumple_context_set_time(w->context, 1);
}

static CrumpleResult submit(World *w) {
    const CrumpleInstance bodies[2] = {w->second, w->second};
    const CrumpleHitDef hits[2] = {hit_at(0.1f, 0.1f, 9), hit_at(0.2f, 0.2f, 0)};
    CrumpleHitResult result;
    TRY(crumple_instance_submit_hit(w->context, w->second, hits, &result));
    return crumple_context_submit_hits(w->context, bodies, hits, 2, NULL);
}

static CrumpleResult contacts(World *w) {
    const CrumpleContactPointDef point = point_of(w->second, 2);
    CrumpleContactOptionsDef options = crumple_contact_options_def_default();
    CrumpleContactReport report;
    CrumpleContactHit hits[4];
    options.max_touches = 2048;
    TRY(crumple_context_set_contact_options(w->context, &options));
    TRY(crumple_context_report_contacts(w->context, &point, 1));
    TRY(crumple_context_step_contacts(w->context, 0.01f, &report));
    TRY(crumple_context_get_contact_hits(w->context, hits, 4, &w->count));
    TRY(crumple_context_get_contact_totals(w->context, &report));
    return crumple_context_clear_contacts(w->context);
}

static CrumpleResult saving(World *w) {
    CrumpleDamageMapping mapping;
    TRY(crumple_instance_save_damage(w->context, w->body, w->bytes, ROOM, &w->size));
    TRY(crumple_context_save_damage(w->context, NULL, 0, w->bytes, ROOM, &w->size));
    TRY(crumple_example_set_save_baked(w->context, w->set, w->bytes, ROOM, &w->size));
    return crumple_example_set_map_damage(w->context, w->set, w->set, w->saved, w->saved_size, 1, w->bytes, ROOM, &w->size, &mapping);
}

static CrumpleResult damage(World *w) {
    TRY(crumple_instance_set_marks(w->context, w->second, w->marks, w->mark_count));
    TRY(crumple_instance_repair_damage(w->context, w->second, 0.5f));
    TRY(crumple_instance_load_damage(w->context, w->second, w->saved, w->saved_size));
    TRY(crumple_instance_repair_around(w->context, w->second, vec3(0, 0, 0), 1, 0.5f));
    TRY(crumple_instance_copy_damage(w->context, w->second, w->body));
    TRY(crumple_instance_reset_damage(w->context, w->second));
    return crumple_context_load_damage(w->context, NULL, 0, w->all, w->all_size);
}

static CrumpleResult frames(World *w) {
    const CrumpleHitDef hit = hit_at(0.1f, 0.1f, 0);
    const CrumpleHostBufferDef memory = host_def(w->more, VERTICES, 3);
    CrumpleBufferInfo info, infos[4];
    CrumpleRange ranges[4];
    CrumpleAabb bounds;
    CrumpleDeformReport report;
    TRY(crumple_instance_submit_hit(w->context, w->second, &hit, NULL));
    TRY(crumple_context_deform(w->context, NULL, 0, &report));
    THAT(crumple_buffer_is_valid(w->context, w->buffer));
    TRY(crumple_buffer_get_info(w->context, w->buffer, &info));
    TRY(crumple_context_get_changed_buffers(w->context, infos, 4, &w->count));
    TRY(crumple_buffer_get_changes(w->context, w->buffer, ranges, 4, &w->count, &bounds));
    TRY(crumple_buffer_get_changed_triangles(w->context, w->buffer, ranges, 4, &w->count, NULL));
    TRY(crumple_buffer_invalidate(w->context, w->buffer));
    return crumple_buffer_set_memory(w->context, w->buffer, &memory);
}

static CrumpleResult graph(World *w) {
    const CrumpleVulkanBufferDef def = graph_memory();
    CrumpleGraphPlan plan;
    TRY(crumple_graph_get_kernel(0, w->bytes, ROOM, &w->size));
    TRY(crumple_buffer_register_graph(w->context, w->second, &def, &w->created));
    return crumple_graph_plan(w->context, NULL, 0, &plan, NULL);
}

static CrumpleResult mount_part(World *w) { return crumple_instance_mount_part(w->context, w->whole, w->part, true); }

// None of these may need memory, since a call that was made cannot be repeated.
static CrumpleResult ends(World *w) {
    TRY(crumple_instance_end_contact(w->context, w->body, 5));
    TRY(crumple_buffer_unregister(w->context, w->buffer));
    TRY(crumple_instance_destroy(w->context, w->second));
    return crumple_example_set_destroy(w->context, w->set);
}

static const struct {
    Call call;
    bool from_nothing; // whether it takes an empty context
    uint64_t needs;    // features
} calls[] = {
    {create_set, true, 0},
    {load_baked, true, 0},
    {load_gltf, true, CRUMPLE_FEATURE_GLTF},
    {load_obj, true, CRUMPLE_FEATURE_OBJ},
    {graph, false, CRUMPLE_FEATURE_VULKAN},
#define ANY(call) {call, false, 0}
    ANY(contexts), ANY(add_lod), ANY(uses_of_a_set), ANY(create_and_register), ANY(reads_of_an_instance), ANY(settings),
    ANY(submit), ANY(contacts), ANY(saving), ANY(damage), ANY(frames), ANY(mount_part), ANY(ends),
};

static unsigned long refusals, errors;

// Refuses the n-th block of a call, perhaps with all later ones. Returns false if the call needs fewer.
static bool refuse(Call call, bool from_nothing, unsigned long n, bool later) {
    static World world;
    make_world(&world, from_nothing);
    heap.refuse_in = n;
    heap.refuse_later = later;
    heap.refused = false;
    const CrumpleResult result = call(&world);
    heap.refuse_in = 0;
    FACT(result == CRUMPLE_OK || (heap.refused && result == CRUMPLE_ERROR_OUT_OF_MEMORY));
    if (result != CRUMPLE_OK) {
        if (!from_nothing) check_unchanged(&world);
        OK(call(&world));
        ++errors;
    }
    OK(crumple_context_destroy(world.context));
    if (world.other) OK(crumple_context_destroy(world.other));
    FACT(heap.blocks == 0);
    refusals += heap.refused;
    return heap.refused;
}

int main(int count, char **arguments) {
    FACT(count == 3);
    if (!has(CRUMPLE_FEATURE_HOST_ALLOCATOR)) {
        printf("this build has no host allocator\n");
        return 0;
    }
    glb_file = path_in(arguments[1], "two_materials.glb");
    glb_size = read_file(glb_file, glb, sizeof glb);
    obj_files[0] = path_in(arguments[1], "plate.obj");
    obj_files[1] = path_in(arguments[1], "plate_dent.obj");
    make_plate();
    bake(arguments[2]);
    const CrumpleAllocatorDef without = crumple_allocator_def_default();
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "alloc", crumple_allocator_set(&without));
    FACT(use_heap(&heap));
    for (size_t i = 0; i < sizeof calls / sizeof *calls; ++i) {
        if (calls[i].needs && !has(calls[i].needs)) continue;
        unsigned long n = 1;
        // Each of the first 48, then ever fewer: importers and builders of sets ask thousands of times.
        while (refuse(calls[i].call, calls[i].from_nothing, n, false)) n += 1 + n / 48;
        while (n > 1) refuse(calls[i].call, calls[i].from_nothing, n -= 1 + (n - 1) / 48, true);
    }
    printf("%lu refusals, %lu of them errors; %u checks\n", refusals, errors, checks);
    return 0;
}
