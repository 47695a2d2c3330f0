// Windows: the library stays loaded when a host unloads it, since threads of a context may still be ending. On Linux a flag of the file does
// this, at which `cargo xtask test --only install` looks.
#include <crumple.h>

#include <string.h>
#include <windows.h>

#define FIND(library, name)                                                                                            \
    do {                                                                                                               \
        FARPROC found_ = GetProcAddress(library, "crumple_" #name);                                                    \
        if (!found_) return 1;                                                                                         \
        memcpy(&name, &found_, sizeof found_);                                                                         \
    } while (0)

int main(int count, char **arguments) {
    CrumpleContextDef (*context_def_default)(void);
    CrumpleResult (*context_create)(const CrumpleContextDef *, CrumpleContext **), (*context_destroy)(CrumpleContext *);
    for (int i = 0; i < 20; ++i) {
        HMODULE library = LoadLibraryA(arguments[count - 1]);
        if (!library) return 1;
        FIND(library, context_def_default);
        FIND(library, context_create);
        FIND(library, context_destroy);
        CrumpleContextDef def = context_def_default();
        CrumpleContext *context;
        def.threads = 4;
        if (context_create(&def, &context) != CRUMPLE_OK || context_destroy(context) != CRUMPLE_OK) return 1;
        FreeLibrary(library);
        if (!GetModuleHandleA("crumple.dll")) return 1;
    }
    return 0;
}
