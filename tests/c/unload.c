// A host that unloads the library while threads of a context may still be ending: the library stays loaded.
#include <crumple.h>

#include <stdio.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
static void *load(const char *path) { return (void *)LoadLibraryA(path); }
static void unload(void *library) { FreeLibrary((HMODULE)library); }
static int is_loaded(const char *path) { return (void)path, GetModuleHandleA("crumple.dll") != NULL; }
static void find(void *library, const char *name, void *function) {
    FARPROC found = GetProcAddress((HMODULE)library, name);
    memcpy(function, &found, sizeof found);
}
#else
#include <dlfcn.h>
static void *load(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void unload(void *library) { dlclose(library); }
static int is_loaded(const char *path) { return dlopen(path, RTLD_NOW | RTLD_NOLOAD) != NULL; }
static void find(void *library, const char *name, void *function) {
    void *found = dlsym(library, name);
    memcpy(function, &found, sizeof found);
}
#endif

int main(int count, char **arguments) {
    CrumpleContextDef (*def_default)(void);
    CrumpleResult (*create)(const CrumpleContextDef *, CrumpleContext **);
    CrumpleResult (*destroy)(CrumpleContext *);
    if (count != 2) return 2;
    const char *path = arguments[1];
    for (int i = 0; i < 20; ++i) {
        void *library = load(path);
        if (!library) {
            fprintf(stderr, "%s does not load\n", path);
            return 1;
        }
        find(library, "crumple_context_def_default", &def_default);
        find(library, "crumple_context_create", &create);
        find(library, "crumple_context_destroy", &destroy);
        if (!def_default || !create || !destroy) {
            fprintf(stderr, "%s is not Crumple\n", path);
            return 1;
        }
        CrumpleContextDef def = def_default();
        CrumpleContext *context;
        def.threads = 4;
        if (create(&def, &context) != CRUMPLE_OK) return 1;
        if (destroy(context) != CRUMPLE_OK) return 1;
        unload(library);
        if (!is_loaded(path)) {
            fprintf(stderr, "the library was unloaded while its threads may be ending\n");
            return 1;
        }
    }
    return 0;
}
