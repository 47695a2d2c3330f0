// A program that is compiled and linked as Microsoft's tools do it, without their C runtime: it has none here. ALL is every function
// of the headers.
#include <crumple_build.h>
#include <crumple_contacts.h>
#include <crumple_graph.h>
#include <crumple_host.h>
#include <crumple_import.h>
#include <crumple_parts.h>
#include <crumple_view.h>

static const void *const all[] = {ALL};

int start(void) {
    CrumpleContextDef def = crumple_context_def_default();
    CrumpleContext *context;
    for (unsigned i = 0; i < sizeof all / sizeof all[0]; ++i) {
        if (!all[i]) return 1;
    }
    if (crumple_version() != CRUMPLE_VERSION) return 2;
    if (crumple_context_create(&def, &context) != CRUMPLE_OK) return 3;
    return crumple_context_destroy(context) == CRUMPLE_OK ? 42 : 4;
}
