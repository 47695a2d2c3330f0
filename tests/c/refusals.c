// The host's allocator refuses blocks: for each call, blocks in turn, alone and with all later ones. The call returns
// CRUMPLE_ERROR_OUT_OF_MEMORY and has changed nothing, or it succeeds with memory of the system's. The process goes on either way.
//
// `cargo xtask test --only repository` checks that each function of the headers is here, except those of Vulkan.
#include "aligned.h"
#include "support.h"

#include <crumple_contacts.h>
#include <crumple_graph.h>
#include <crumple_host.h>
#include <crumple_import.h>
#include <crumple_parts.h>
#include <crumple_view.h>

// A heap that refuses its n-th block, or all from it on.
static struct {
    long blocks;
    unsigned long until; // blocks to give before the first that is refused
    bool counts, refuses_later, refused;
} heap;

static void *host_alloc(size_t size, size_t align, void *user) {
    (void)user;
    if (heap.counts) {
        if (heap.until == 0) {
            heap.refused = true;
            heap.counts = heap.refuses_later;
            return NULL;
        }
        --heap.until;
    }
    void *memory = aligned_memory(size, align);
    if (memory) ++heap.blocks;
    return memory;
}

static void host_free(void *pointer, size_t size, size_t align, void *user) {
    (void)size, (void)align, (void)user;
    --heap.blocks;
    free_aligned(pointer);
}

enum { EDGE = 5, POINTS = EDGE * EDGE, CORNERS = (EDGE - 1) * (EDGE - 1) * 6, ROOM = 1 << 16 };

// A plate with one example, whose halves are further meshes.
static struct {
    float positions[POINTS][3], normals[POINTS][3], target[POINTS][3];
    uint32_t corners[CORNERS];
    CrumpleMeshDef mesh, halves[2];
    CrumpleExampleDef example;
    CrumpleExampleSetDef def;
    unsigned char baked[ROOM];
    size_t baked_size;
    const char *file, *glb, *obj[2];
    unsigned char glb_bytes[ROOM];
    size_t glb_size;
} plate;

static void make_plate(void) {
    int i = 0;
    for (int v = 0; v < POINTS; ++v) {
        const float position[3] = {(float)(v % EDGE), (float)(v / EDGE), 0}, up[3] = {0, 0, 1};
        memcpy(plate.positions[v], position, sizeof position);
        memcpy(plate.normals[v], up, sizeof up);
        memcpy(plate.target[v], position, sizeof position);
        if (v % EDGE == EDGE - 1 || v / EDGE == EDGE - 1) continue;
        const uint32_t a = (uint32_t)v, quad[6] = {a, a + 1, a + EDGE, a + EDGE, a + 1, a + EDGE + 1};
        memcpy(plate.corners + i, quad, sizeof quad);
        i += 6;
    }
    plate.target[POINTS / 2][2] = -0.5f;
    plate.target[POINTS / 2 + 1][2] = -0.2f;
    plate.mesh = crumple_mesh_def_default();
    plate.mesh.vertex_count = POINTS;
    plate.mesh.index_count = CORNERS;
    plate.mesh.positions = input_of(plate.positions, sizeof plate.positions, 12);
    plate.mesh.normals = input_of(plate.normals, sizeof plate.normals, 12);
    plate.mesh.indices = input_of(plate.corners, sizeof plate.corners, 4);
    // The lower rows, and the upper ones; the middle row is in both.
    for (int half = 0; half < 2; ++half) {
        CrumpleMeshDef *mesh = &plate.halves[half];
        *mesh = plate.mesh;
        mesh->vertex_count = EDGE * (EDGE + 1) / 2;
        mesh->index_count = CORNERS / 2;
        const size_t first = half ? EDGE * (EDGE / 2) : 0;
        mesh->positions = input_of(plate.positions[first], mesh->vertex_count * 12, 12);
        mesh->normals = input_of(plate.normals[first], mesh->vertex_count * 12, 12);
    }
    plate.example = crumple_example_def_default();
    plate.example.name = "dent";
    plate.example.target_positions = input_of(plate.target, sizeof plate.target, 12);
    plate.example.impulse = vec3(0, 0, -10);
    plate.example.striker.mass = 2;
    plate.example.striker.velocity = vec3(0, 0, -5);
    plate.def = crumple_example_set_def_default();
    plate.def.mesh = &plate.mesh;
    plate.def.examples = &plate.example;
    plate.def.example_count = 1;
}

static void write_file(const char *path, const void *bytes, size_t size) {
    FILE *file = fopen(path, "wb");
    FACT(file && fwrite(bytes, 1, size, file) == size && fclose(file) == 0);
}

static void read_glb(const char *path) {
    FILE *file = fopen(path, "rb");
    FACT(file);
    plate.glb_size = fread(plate.glb_bytes, 1, ROOM, file);
    FACT(plate.glb_size > 0 && plate.glb_size < ROOM && fclose(file) == 0);
    plate.glb = path;
}

// What there is before each call: a body with marks, an open contact and two buffers, another body, a part of a third, contact
// points that wait.
typedef struct World {
    CrumpleContext *context, *other;
    CrumpleExampleSet set;
    CrumpleInstance body, second, whole, part, made;
    CrumpleBuffer buffer, graph, created;
    CrumpleAttachment lamp;
    float vertices[POINTS][3], more[POINTS][3];
    unsigned char saved[1024], all[4096], bytes[ROOM];
    size_t saved_size, all_size, size;
    CrumpleMark marks[8];
    uint32_t mark_count, count;
} World;

static CrumpleHitDef hit_at(float x, float y, uint64_t contact_id) {
    CrumpleHitDef def = crumple_hit_def_default();
    def.point = vec3(x, y, 0);
    def.impulse = vec3(0, 0, -6);
    def.contact_id = contact_id;
    return def;
}

static CrumpleContactPointDef point_of(CrumpleInstance body, uint64_t pair) {
    CrumpleContactPointDef def = crumple_contact_point_def_default();
    def.pair = pair;
    def.bodies[0] = body;
    def.point = vec3(1, 1, 0);
    def.normal = vec3(0, 0, 1);
    def.has_velocity = true;
    def.velocity = vec3(0, 0, -5);
    def.impulse = 8;
    return def;
}

static CrumpleHostBufferDef host_memory(float (*vertices)[3]) {
    CrumpleHostBufferDef def = crumple_host_buffer_def_default();
    def.positions = stream_of(vertices, sizeof plate.positions, 0, 12);
    return def;
}

static CrumpleVulkanBufferDef graph_memory(void) {
    CrumpleVulkanBufferDef def = crumple_vulkan_buffer_def_default();
    def.buffer = 7;
    def.buffer_size = def.size = sizeof plate.positions;
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
    OK(crumple_example_set_load_baked_memory(w->context, plate.baked, plate.baked_size, CRUMPLE_BYTES_KEEP, &w->set));
    w->body = make_instance(w->context, w->set);
    w->second = make_instance(w->context, w->set);
    w->whole = make_instance(w->context, w->set);
    OK(crumple_instance_release_part(w->context, w->whole, 1, &w->part));
    OK(crumple_example_set_attach_point(w->context, w->set, vec3(2, 2, 1), &w->lamp));
    const CrumpleHostBufferDef host = host_memory(w->vertices);
    OK(crumple_buffer_register_host(w->context, w->body, &host, &w->buffer));
    const CrumpleVulkanBufferDef graph = graph_memory();
    if (has(CRUMPLE_FEATURE_VULKAN)) OK(crumple_buffer_register_graph(w->context, w->body, &graph, &w->graph));
    for (int i = 0; i < 3; ++i) {
        const CrumpleHitDef hit = hit_at((float)i, 2, i == 2 ? 5 : 0);
        OK(crumple_instance_submit_hit(w->context, w->body, &hit, NULL));
    }
    OK(crumple_context_deform(w->context, NULL, 0, NULL));
    OK(crumple_instance_get_marks(w->context, w->body, w->marks, 8, &w->mark_count));
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

typedef CrumpleResult (*Call)(World *w);

#define CALL(name, ...)                                                                                                \
    static CrumpleResult name(World *w) {                                                                              \
        (void)w;                                                                                                       \
        __VA_ARGS__                                                                                                    \
    }

// crumple.h
CALL(version, return crumple_version() == CRUMPLE_VERSION && crumple_version_string() && crumple_features() < 16 &&
                             crumple_last_error() && crumple_result_name(CRUMPLE_OK)
                         ? CRUMPLE_OK
                         : CRUMPLE_ERROR_INTERNAL;)
CALL(context_create, CrumpleContext *context = NULL; CrumpleContextDef def = crumple_context_def_default();
     def.threads = 1; CrumpleResult result = crumple_context_create(&def, &context);
     return result ? result : crumple_context_destroy(context);)
CALL(load_memory, return crumple_example_set_load_baked_memory(w->context, plate.baked, plate.baked_size, CRUMPLE_BYTES_COPY,
                                                                &w->set);)
CALL(load_file, return crumple_example_set_load_baked(w->context, plate.file, &w->set);)
CALL(set_is_valid, return crumple_example_set_is_valid(w->context, w->set) ? CRUMPLE_OK : CRUMPLE_ERROR_INTERNAL;)
CALL(set_destroy, return crumple_example_set_destroy(w->context, w->set);)
CALL(set_info, CrumpleExampleSetInfo info; return crumple_example_set_get_info(w->context, w->set, &info);)
CALL(copy_mesh, CrumpleMeshCopyDef def = crumple_mesh_copy_def_default();
     def.positions = stream_of(w->more, sizeof w->more, 0, 12); return crumple_example_set_copy_mesh(w->context, w->set, &def);)
CALL(instance_create, CrumpleInstanceDef def = crumple_instance_def_default(); def.set = w->set;
     return crumple_instance_create(w->context, &def, &w->made);)
CALL(instance_destroy, return crumple_instance_destroy(w->context, w->second);)
CALL(instance_is_valid, return crumple_instance_is_valid(w->context, w->body) ? CRUMPLE_OK : CRUMPLE_ERROR_INTERNAL;)
CALL(set_user_data, return crumple_instance_set_user_data(w->context, w->body, 3);)
CALL(get_user_data, uint64_t data; return crumple_instance_get_user_data(w->context, w->body, &data);)
CALL(instance_info, CrumpleInstanceInfo info; return crumple_instance_get_info(w->context, w->body, &info);)
CALL(set_transform, const float m[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 2, 3, 4, 1};
     return crumple_instance_set_transform(w->context, w->second, m);)
CALL(set_depth_limit, return crumple_instance_set_depth_limit(w->context, w->second, 0.1f);)
CALL(submit_hit, CrumpleHitResult result; const CrumpleHitDef def = hit_at(1, 1, 9);
     return crumple_instance_submit_hit(w->context, w->second, &def, &result);)
CALL(submit_hits, CrumpleInstance bodies[2] = {w->second, w->second}; CrumpleHitDef defs[2] = {hit_at(1, 1, 0), hit_at(2, 2, 0)};
     return crumple_context_submit_hits(w->context, bodies, defs, 2, NULL);)
CALL(preview_hit, CrumpleHitResult result; const CrumpleHitDef def = hit_at(1, 1, 0);
     return crumple_instance_preview_hit(w->context, w->body, &def, &result);)
CALL(end_contact, return crumple_instance_end_contact(w->context, w->body, 5);)
CALL(get_contact, CrumpleHitResult result; return crumple_instance_get_contact(w->context, w->body, 5, &result);)
CALL(contact_options, CrumpleContactOptionsDef def = crumple_contact_options_def_default(); def.max_touches = 2048;
     return crumple_context_set_contact_options(w->context, &def);)
CALL(report_contacts, const CrumpleContactPointDef point = point_of(w->second, 2);
     return crumple_context_report_contacts(w->context, &point, 1);)
CALL(step_contacts, CrumpleContactReport report; return crumple_context_step_contacts(w->context, 0.01f, &report);)
CALL(contact_hits, CrumpleContactHit hits[4]; return crumple_context_get_contact_hits(w->context, hits, 4, &w->count);)
CALL(contact_totals, CrumpleContactReport report; return crumple_context_get_contact_totals(w->context, &report);)
CALL(clear_contacts, return crumple_context_clear_contacts(w->context);)
CALL(get_marks, CrumpleMark marks[8]; return crumple_instance_get_marks(w->context, w->body, marks, 8, &w->count);)
CALL(set_marks, return crumple_instance_set_marks(w->context, w->second, w->marks, w->mark_count);)
CALL(save_damage, return crumple_instance_save_damage(w->context, w->body, w->bytes, sizeof w->bytes, &w->size);)
CALL(load_damage, return crumple_instance_load_damage(w->context, w->second, w->saved, w->saved_size);)
CALL(save_all, return crumple_context_save_damage(w->context, NULL, 0, w->bytes, sizeof w->bytes, &w->size);)
CALL(load_all, return crumple_context_load_damage(w->context, NULL, 0, w->all, w->all_size);)
CALL(repair, return crumple_instance_repair_damage(w->context, w->second, 0.5f);)
CALL(repair_around, return crumple_instance_repair_around(w->context, w->second, vec3(1, 1, 0), 1, 0.5f);)
CALL(reset, return crumple_instance_reset_damage(w->context, w->second);)
CALL(copy_damage, return crumple_instance_copy_damage(w->context, w->second, w->body);)
CALL(register_host, const CrumpleHostBufferDef def = host_memory(w->more);
     return crumple_buffer_register_host(w->context, w->body, &def, &w->created);)
CALL(unregister, return crumple_buffer_unregister(w->context, w->buffer);)
CALL(buffer_is_valid, return crumple_buffer_is_valid(w->context, w->buffer) ? CRUMPLE_OK : CRUMPLE_ERROR_INTERNAL;)
CALL(buffer_info, CrumpleBufferInfo info; return crumple_buffer_get_info(w->context, w->buffer, &info);)
CALL(invalidate, return crumple_buffer_invalidate(w->context, w->buffer);)
CALL(set_memory, const CrumpleHostBufferDef def = host_memory(w->more);
     return crumple_buffer_set_memory(w->context, w->buffer, &def);)
CALL(deform, const CrumpleHitDef def = hit_at(1, 1, 0); CrumpleDeformReport report;
     CrumpleResult result = crumple_instance_submit_hit(w->context, w->second, &def, NULL);
     return result ? result : crumple_context_deform(w->context, NULL, 0, &report);)
CALL(changed_buffers, CrumpleBufferInfo infos[4];
     return crumple_context_get_changed_buffers(w->context, infos, 4, &w->count);)
CALL(changes, CrumpleRange ranges[4]; CrumpleAabb bounds;
     return crumple_buffer_get_changes(w->context, w->buffer, ranges, 4, &w->count, &bounds);)
// crumple_build.h
CALL(create_set, return crumple_example_set_create(w->context, &plate.def, &w->set);)
CALL(add_lod, uint32_t lod; CrumpleResult result = crumple_example_set_load_baked_memory(
         w->context, plate.baked, plate.baked_size, CRUMPLE_BYTES_KEEP, &w->set);
     return result ? result : crumple_example_set_add_lod(w->context, w->set, &plate.halves[0], &lod);)
CALL(save_baked, return crumple_example_set_save_baked(w->context, w->set, w->bytes, sizeof w->bytes, &w->size);)
CALL(keep_out, const CrumpleCapsule capsule = {vec3(1, 1, -1), vec3(3, 3, -1), 0.2f}; float limits[POINTS];
     return crumple_mesh_keep_out(&plate.mesh, &capsule, 1, NULL, 0, limits);)
CALL(example_info, CrumpleExampleInfo info; return crumple_example_set_get_example(w->context, w->set, 0, &info);)
CALL(map_damage, CrumpleDamageMapping mapping;
     return crumple_example_set_map_damage(w->context, w->set, w->set, w->saved, w->saved_size, 1, w->bytes, sizeof w->bytes,
                                           &w->size, &mapping);)
// crumple_import.h
CALL(load_gltf, CrumpleGltfDef def = crumple_gltf_def_default(); def.path = plate.glb;
     return crumple_example_set_load_gltf(w->context, &def, &w->set);)
CALL(load_gltf_memory, CrumpleGltfDef def = crumple_gltf_def_default(); def.join_nodes = true;
     return crumple_example_set_load_gltf_memory(w->context, plate.glb_bytes, plate.glb_size, &def, &w->set);)
CALL(load_obj, CrumpleObjDef def = crumple_obj_def_default(); def.base_path = plate.obj[0]; def.example_paths = &plate.obj[1];
     def.example_count = 1; return crumple_example_set_load_obj(w->context, &def, &w->set);)
CALL(primitive, CrumplePrimitive info; return crumple_example_set_get_primitive(w->context, w->set, 0, &info);)
CALL(find_part, uint32_t lod; CrumpleResult result = crumple_example_set_find_part(w->context, w->set, "wing", &lod);
     return result == CRUMPLE_ERROR_INVALID_ARGUMENT ? CRUMPLE_OK : result;)
CALL(get_part, CrumplePart part; CrumpleResult result = crumple_example_set_get_part(w->context, w->set, 1, &part);
     return result == CRUMPLE_ERROR_INVALID_ARGUMENT ? CRUMPLE_OK : result;)
// crumple_parts.h
CALL(release_part, return crumple_instance_release_part(w->context, w->second, 1, &w->made);)
CALL(mount_part, return crumple_instance_mount_part(w->context, w->whole, w->part, true);)
CALL(part_rigid, return crumple_instance_set_part_rigid(w->context, w->second, 1, true);)
CALL(measure_part, float deepest; return crumple_instance_measure_part(w->context, w->body, 0, &deepest, NULL, NULL);)
CALL(attach_point, CrumpleAttachment at; return crumple_example_set_attach_point(w->context, w->set, vec3(1, 1, 1), &at);)
CALL(attached_pose, CrumplePose pose; return crumple_instance_get_attached_pose(w->context, w->body, &w->lamp, &pose);)
CALL(nearest_vertex, return crumple_example_set_find_nearest_vertex(w->context, w->set, vec3(1, 1, 1), &w->count, NULL);)
CALL(changed_triangles, CrumpleRange ranges[4];
     return crumple_buffer_get_changed_triangles(w->context, w->buffer, ranges, 4, &w->count, NULL);)
// crumple_view.h
CALL(set_time, return crumple_context_set_time(w->context, 1);)
CALL(set_view, uint32_t lod; return crumple_instance_set_view(w->context, w->second, 0.5f, 10, 1, 1080, &lod);)
CALL(vertex_budget, return crumple_context_set_vertex_budget(w->context, 100);)
// crumple_host.h
CALL(share, CrumpleExampleSet set; return crumple_example_set_share(w->context, w->set, w->other, &set);)
// crumple_graph.h
CALL(graph_kernel, return crumple_graph_get_kernel(0, w->bytes, sizeof w->bytes, &w->size);)
CALL(register_graph, const CrumpleVulkanBufferDef def = graph_memory();
     return crumple_buffer_register_graph(w->context, w->second, &def, &w->created);)
CALL(graph_plan, CrumpleGraphPlan plan; return crumple_graph_plan(w->context, NULL, 0, &plan, NULL);)

static const struct {
    const char *name;
    Call call;
    uint64_t needs;    // features
    bool from_nothing; // whether it takes an empty context
} calls[] = {
#define EACH(name) {#name, name, 0, false}
#define EACH_OF(feature, name) {#name, name, CRUMPLE_FEATURE_##feature, false}
#define EACH_LOAD(feature, name) {#name, name, feature, true}
    EACH(version), EACH(context_create), EACH_LOAD(0, load_memory), EACH_LOAD(0, load_file), EACH(set_is_valid), EACH(set_destroy),
    EACH(set_info), EACH(copy_mesh), EACH(instance_create), EACH(instance_destroy), EACH(instance_is_valid),
    EACH(set_user_data), EACH(get_user_data), EACH(instance_info), EACH(set_transform), EACH(set_depth_limit),
    EACH(submit_hit), EACH(submit_hits), EACH(preview_hit), EACH(end_contact), EACH(get_contact), EACH(contact_options),
    EACH(report_contacts), EACH(step_contacts), EACH(contact_hits), EACH(contact_totals), EACH(clear_contacts),
    EACH(get_marks), EACH(set_marks), EACH(save_damage), EACH(load_damage), EACH(save_all), EACH(load_all), EACH(repair),
    EACH(repair_around), EACH(reset), EACH(copy_damage), EACH(register_host), EACH(unregister), EACH(buffer_is_valid),
    EACH(buffer_info), EACH(invalidate), EACH(set_memory), EACH(deform), EACH(changed_buffers), EACH(changes),
    EACH_LOAD(0, create_set), EACH(add_lod), EACH(save_baked), EACH(keep_out), EACH(example_info), EACH(map_damage),
    EACH_LOAD(CRUMPLE_FEATURE_GLTF, load_gltf), EACH_LOAD(CRUMPLE_FEATURE_GLTF, load_gltf_memory),
    EACH_LOAD(CRUMPLE_FEATURE_OBJ, load_obj), EACH(primitive), EACH(find_part), EACH(get_part), EACH(release_part), EACH(mount_part),
    EACH(part_rigid), EACH(measure_part), EACH(attach_point), EACH(attached_pose), EACH(nearest_vertex),
    EACH(changed_triangles), EACH(set_time), EACH(set_view),
    EACH(vertex_budget), EACH(share), EACH_OF(VULKAN, graph_kernel), EACH_OF(VULKAN, register_graph),
    EACH_OF(VULKAN, graph_plan),
};

static unsigned long refusals, errors;

// Refuses the n-th block of a call, perhaps with all later ones. Returns false if the call needs fewer.
static bool refuse(Call call, bool from_nothing, unsigned long n, bool later) {
    static World world;
    make_world(&world, from_nothing);
    heap.until = n;
    heap.refuses_later = later;
    heap.refused = false;
    heap.counts = true;
    const CrumpleResult result = call(&world);
    heap.counts = false;
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
    if (!has(CRUMPLE_FEATURE_HOST_ALLOCATOR)) {
        printf("this build has no host allocator\n");
        return 0;
    }
    FACT(count == 3);
    static char paths[3][512];
    static const char flat[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", bent[] = "v 0 0 -1\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    make_plate();
    read_glb(arguments[1]);
    for (int i = 0; i < 3; ++i)
        snprintf(paths[i], sizeof paths[i], "%s/refusals_%d.%s", arguments[2], i, i == 0 ? "crumple" : "obj");
    plate.file = paths[0];
    write_file(plate.obj[0] = paths[1], flat, sizeof flat - 1);
    write_file(plate.obj[1] = paths[2], bent, sizeof bent - 1);
    CrumpleContext *context = make_context(1);
    CrumpleExampleSet set;
    uint32_t lod;
    OK(crumple_example_set_create(context, &plate.def, &set));
    OK(crumple_example_set_add_lod(context, set, &plate.halves[0], &lod));
    OK(crumple_example_set_add_lod(context, set, &plate.halves[1], &lod));
    OK(crumple_example_set_save_baked(context, set, plate.baked, sizeof plate.baked, &plate.baked_size));
    write_file(plate.file, plate.baked, plate.baked_size);
    OK(crumple_context_destroy(context));
    CrumpleAllocatorDef def = crumple_allocator_def_default();
    def.alloc = host_alloc;
    def.free = host_free;
    OK(crumple_allocator_set(&def));
    for (size_t i = 0; i < sizeof calls / sizeof *calls; ++i) {
        if (calls[i].needs && !has(calls[i].needs)) continue;
        unsigned long n = 0;
        // Each of the first 32, then ever fewer: importers and builders of sets ask thousands of times.
        while (refuse(calls[i].call, calls[i].from_nothing, n, false)) n += 1 + n / 32;
        while (n > 0) refuse(calls[i].call, calls[i].from_nothing, n -= 1 + n / 32, true);
    }
    printf("%lu refusals, %lu of them errors; %u checks\n", refusals, errors, checks);
    return 0;
}
