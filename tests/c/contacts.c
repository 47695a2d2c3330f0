// Contact points of a physics engine: counters and hits come back, what rests costs no memory, wrong points are refused whole.
#include "heap.h"
#include "support.h"

#include <crumple_contacts.h>

static Sheet sheet;
static CrumpleContext *context;
static CrumpleExampleSet set;

static const float STEP = 1.0f / 60;

static CrumpleInstance body(void) {
    CrumpleInstanceDef def = crumple_instance_def_default();
    CrumpleInstance made;
    def.set = set;
    def.compliance = 0.001f;
    OK(crumple_instance_create(context, &def, &made));
    return made;
}

static CrumpleContactPointDef point_at(CrumpleInstance on, uint64_t pair, float x, float speed, float impulse) {
    CrumpleContactPointDef point = crumple_contact_point_def_default();
    point.pair = pair;
    point.bodies[0] = on;
    point.point = vec3(x, 0, 0.075f);
    point.normal = vec3(0, 0, 1);
    point.has_velocity = true;
    point.velocity = vec3(0, 0, -speed);
    point.impulse = impulse;
    return point;
}

static uint32_t marks_of(CrumpleInstance on) {
    uint32_t count;
    OK(crumple_instance_get_marks(context, on, NULL, 0, &count));
    return count;
}

// The counters of steps and their totals. tests/contact_layer.rs checks what contacts leave.
static void a_manifold_is_one_blow(void) {
    CrumpleInstance on = body();
    CrumpleContactPointDef four[4];
    CrumpleContactReport report, totals;
    for (int i = 0; i < 4; ++i) four[i] = point_at(on, 2, 0.01f * (float)(i - 1) - 0.005f, 5, 10);
    OK(crumple_context_report_contacts(context, four, 4));
    OK(crumple_context_step_contacts(context, STEP, &report));
    FACT(report.points == 4 && report.hits == 1 && report.begun == 1 && report.open == 1 && report.refused == 0 && report.refusal == CRUMPLE_OK);
    OK(crumple_context_step_contacts(context, 1, &report));
    FACT(report.points == 0 && report.ended == 1 && report.open == 0);
    OK(crumple_context_step_contacts(context, STEP, NULL));
    OK(crumple_context_get_contact_totals(context, &totals));
    FACT(totals.points == 4 && totals.hits == 1 && totals.ended == 1 && marks_of(on) == 1);
}

// After a step the host asks for its hits. A step that fails keeps those of the step before.
static void each_hit_is_told(void) {
    CrumpleInstance a = body(), b = body();
    CrumpleContactPointDef both = point_at(a, 5, 0, 5, 40), one = point_at(b, 6, 0.2f, 5, 20);
    CrumpleContactHit hits[3];
    CrumpleContactReport report;
    CrumpleHitResult touch;
    uint32_t count = 7;
    both.bodies[1] = b;
    OK(crumple_context_report_contacts(context, &both, 1));
    OK(crumple_context_report_contacts(context, &one, 1));
    OK(crumple_context_step_contacts(context, STEP, &report));
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "seconds", crumple_context_step_contacts(context, -1, NULL));
    OK(crumple_context_get_contact_hits(context, NULL, 0, &count));
    FACT(count == 3 && report.hits == 3);
    FAILS(CRUMPLE_ERROR_BUFFER_TOO_SMALL, "hits has room for 2; 3", crumple_context_get_contact_hits(context, hits, 2, &count));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "out_count", crumple_context_get_contact_hits(context, hits, 3, NULL));
    OK(crumple_context_get_contact_hits(context, hits, 3, &count));
    int on_a = 0, on_b = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const CrumpleContactHit *hit = &hits[i];
        const bool first = hit->instance.index == a.index, shared = hit->pair == 5;
        FACT(shared ? first || hit->instance.index == b.index : hit->pair == 6 && hit->instance.index == b.index);
        FACT(hit->contact_id >> 63 == 1);
        // No example bulges, so what comes from below leaves nothing.
        FACT(hit->result.status == (hit->impulse.z < 0 ? CRUMPLE_HIT_STATUS_MARKED : CRUMPLE_HIT_STATUS_ACCUMULATED));
        FACT(hit->point.x == (shared ? 0 : 0.2f) && hit->point.z == 0.075f && hit->impulse.x == 0);
        // Both get the whole impulse, b from the other side.
        FACT(hit->impulse.z == (shared ? first ? -40 : 40 : -20));
        OK(crumple_instance_get_contact(context, hit->instance, hit->contact_id, &touch));
        FACT(fabsf(touch.target.z - hit->result.target.z) < 1e-6f);
        on_a += first, on_b += !first;
    }
    FACT(on_a == 1 && on_b == 2);
    OK(crumple_context_step_contacts(context, STEP, &report));
    OK(crumple_context_get_contact_hits(context, hits, 3, &count));
    FACT(report.hits == 0 && count == 0);
    OK(crumple_context_clear_contacts(context));
}

// Once as many points came in a step, steps ask for no memory.
static void what_rests_costs_no_allocation(bool counts) {
    CrumpleInstance rests = body();
    CrumpleContactPointDef points[100];
    unsigned long before = 0;
    for (int i = 0; i < 100; ++i) points[i] = point_at(rests, 100 + (uint64_t)(i / 4), 0.01f * (float)(i % 4), 0.16f, 0.3f);
    for (int step = 0; step < 104; ++step) {
        if (step == 4) before = heap.calls;
        OK(crumple_context_report_contacts(context, points, 100));
        OK(crumple_context_step_contacts(context, STEP, NULL));
    }
    FACT(!counts || heap.calls == before);
}

static void wrong_points_are_refused_whole(void) {
    CrumpleInstance on = body();
    CrumpleContactPointDef points[2];
    CrumpleContactReport report;
    points[0] = points[1] = point_at(on, 4, 0, 5, 40);
#define WRONG(expected, part, change)                                                                                  \
    do {                                                                                                               \
        CrumpleContactPointDef kept = points[1];                                                                       \
        change;                                                                                                        \
        FAILS(CRUMPLE_ERROR_##expected, part, crumple_context_report_contacts(context, points, 2));                    \
        points[1] = kept;                                                                                              \
    } while (0)
    WRONG(STRUCT_SIZE, "points[1].def.struct_size", points[1].struct_size = 3);
    WRONG(NOT_FINITE, "points[1].velocity", points[1].velocity.x = NAN);
    WRONG(INVALID_ARGUMENT, "points[1].masses[0]", points[1].masses[0] = -2);
    WRONG(INVALID_ID, "points[1].bodies[1]", points[1].bodies[1].index = 1000);
#undef WRONG
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "points", crumple_context_report_contacts(context, NULL, 1));
    OK(crumple_context_report_contacts(context, NULL, 0));
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "seconds", crumple_context_step_contacts(context, 0, &report));
    FAILS(CRUMPLE_ERROR_NULL_POINTER, "out_report", crumple_context_get_contact_totals(context, NULL));
    OK(crumple_context_step_contacts(context, STEP, &report));
    FACT(report.points == 0 && marks_of(on) == 0);

    // What waits is forgotten.
    OK(crumple_context_report_contacts(context, points, 1));
    OK(crumple_context_clear_contacts(context));
    OK(crumple_context_step_contacts(context, STEP, &report));
    FACT(report.points == 0 && marks_of(on) == 0);

    // The most points of a step, and a body that went away.
    CrumpleContactOptionsDef options = crumple_contact_options_def_default();
    options.max_points = 1;
    OK(crumple_context_set_contact_options(context, &options));
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "max_points", crumple_context_report_contacts(context, points, 2));
    OK(crumple_context_report_contacts(context, points, 1));
    OK(crumple_instance_destroy(context, on));
    OK(crumple_context_step_contacts(context, STEP, &report));
    FACT(report.points == 1 && report.hits == 0);
    options.gain = -1;
    FAILS(CRUMPLE_ERROR_INVALID_ARGUMENT, "gain", crumple_context_set_contact_options(context, &options));
}

int main(void) {
    CrumpleContextDef def = crumple_context_def_default();
    bool counts = use_heap();
    def.threads = 1;
    make_sheet(&sheet);
    OK(crumple_context_create(&def, &context));
    OK(crumple_example_set_create(context, &sheet.def, &set));
    a_manifold_is_one_blow();
    each_hit_is_told();
    what_rests_costs_no_allocation(counts);
    wrong_points_are_refused_whole();
    OK(crumple_context_destroy(context));
    printf("%u checks\n", checks);
    return 0;
}
