// The shortest way to a dent: first_dent BODY.crumple loads a set of "crumple bake" and dents it at the top of its bounds.
#include <crumple.h>

#include <stdio.h>
#include <stdlib.h>

#define OK(call) if ((call) != CRUMPLE_OK) return fprintf(stderr, "%s\n", crumple_last_error()), 1

int main(int count, char **arguments) {
    CrumpleContextDef context_def = crumple_context_def_default();
    CrumpleContext *context;
    CrumpleExampleSet set;
    CrumpleExampleSetInfo info;
    OK(crumple_context_create(&context_def, &context));
    OK(crumple_example_set_load_baked(context, count > 1 ? arguments[1] : "hood.crumple", &set));
    OK(crumple_example_set_get_info(context, set, &info));

    CrumpleInstanceDef body_def = crumple_instance_def_default();
    CrumpleInstance body;
    body_def.set = set;
    OK(crumple_instance_create(context, &body_def, &body));

    float(*vertices)[3] = malloc(info.vertex_count * sizeof *vertices); // or your mapped vertex buffer, with any stride
    CrumpleHostBufferDef buffer_def = crumple_host_buffer_def_default();
    CrumpleBuffer buffer;
    buffer_def.positions = (CrumpleStream){vertices, info.vertex_count * sizeof *vertices, 0, sizeof *vertices};
    OK(crumple_buffer_register_host(context, body, &buffer_def, &buffer));

    CrumpleHitDef hit = crumple_hit_def_default(); // 3 cm deep; or its impulse and striker, as the physics engine knows them
    CrumpleHitResult told;
    hit.kind = CRUMPLE_HIT_KIND_DISPLACEMENT;
    hit.point = (CrumpleVec3){(info.bounds.min.x + info.bounds.max.x) / 2, (info.bounds.min.y + info.bounds.max.y) / 2, info.bounds.max.z};
    hit.displacement = (CrumpleVec3){0, 0, -0.03f};
    OK(crumple_instance_submit_hit(context, body, &hit, &told));
    OK(crumple_context_deform(context, NULL, 0, NULL));
    float now = vertices[told.contact_vertex][2];
    printf("vertex %u is now at z = %.3f m\n", told.contact_vertex, now);
    OK(crumple_context_destroy(context));
    free(vertices);
    return now > info.bounds.max.z - 0.02f;
}
