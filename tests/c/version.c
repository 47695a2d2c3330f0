// The headers are C99, may be included twice and together, and are of the version of the library that runs.
#include <crumple_graph.h>
#include <crumple_host.h>
#include <crumple_import.h>
#include <crumple_parts.h>
#include <crumple.h>
#include <crumple_graph.h>

#include "support.h"

int main(void) {
    char text[64];
    FACT(crumple_version() == CRUMPLE_VERSION);
    FACT(CRUMPLE_VERSION == CRUMPLE_VERSION_MAJOR * 1000000 + CRUMPLE_VERSION_MINOR * 1000 + CRUMPLE_VERSION_PATCH);
    snprintf(text, sizeof text, "%d.%d.%d", CRUMPLE_VERSION_MAJOR, CRUMPLE_VERSION_MINOR, CRUMPLE_VERSION_PATCH);
    FACT(strcmp(text, crumple_version_string()) == 0);
    FACT((crumple_features() & ~(uint64_t)(CRUMPLE_FEATURE_GLTF | CRUMPLE_FEATURE_OBJ | CRUMPLE_FEATURE_HOST_ALLOCATOR |
                                                  CRUMPLE_FEATURE_VULKAN)) == 0);

    // Results have names, and the first text is empty.
    FACT(strcmp(crumple_last_error(), "") == 0);
    for (int result = CRUMPLE_ERROR_NULL_POINTER; result <= CRUMPLE_ERROR_INTERNAL; ++result)
        FACT(strncmp(crumple_result_name((CrumpleResult)result), "CRUMPLE_ERROR_", 14) == 0);
    FACT(strcmp(crumple_result_name((CrumpleResult)63), "unknown result") == 0);
    FACT(strcmp(crumple_result_name(CRUMPLE_ERROR_CONCURRENT_USE), "CRUMPLE_ERROR_CONCURRENT_USE") == 0);
    printf("Crumple %s, %u checks\n", crumple_version_string(), checks);
    return 0;
}
