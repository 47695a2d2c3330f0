/* Linked into every program of a sanitizer run, so that LeakSanitizer reports leaks of Crumple and not of Vulkan drivers. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <link.h>
#include <stddef.h>
#include <string.h>

/*
 * Keeps Vulkan drivers loaded. LeakSanitizer looks for pointers when the program ends. The Vulkan loader has unloaded the drivers by
 * then, so memory that a driver's globals point to counts as leaked, and its stack names an unknown module.
 * Other libraries are unloaded as always.
 */
int dlclose(void *library) {
    struct link_map *map = NULL;
    if (dlinfo(library, RTLD_DI_LINKMAP, &map) == 0) {
        const char *slash = strrchr(map->l_name, '/');
        const char *name = slash != NULL ? slash + 1 : map->l_name;
        if (strncmp(name, "libvulkan_", 10) == 0 || strncmp(name, "libvk_", 6) == 0) {
            return 0;
        }
    }
    int (*next)(void *) = (int (*)(void *))dlsym(RTLD_NEXT, "dlclose");
    return next(library);
}

/*
 * LeakSanitizer's suppressions: leaks whose allocation has a frame in the module of a driver. A Vulkan object that we forget to
 * destroy is among them; the validation layer, under which stage "ctest" runs the same programs, reports those.
 */
const char *__lsan_default_suppressions(void) { return "leak:libvulkan_lvp.so\nleak:libvk_swiftshader.so\n"; }
