#include "library.hpp"

#if defined(_WIN32)
#define WIN32_LEAN_AND_MEAN
#include <windows.h>
#else
#include <dlfcn.h>
#endif

namespace crumple_unity {
namespace {

#if defined(_WIN32)
const char *const FILE_NAME = "crumple.dll";
#else
const char *const FILE_NAME = "libcrumple.so";
#endif

void here() {} // its address tells which file it is in

#if defined(_WIN32)
std::string folder() {
    HMODULE self = nullptr;
    char path[4 * MAX_PATH];
    const DWORD flags = GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT;
    if (!GetModuleHandleExA(flags, reinterpret_cast<LPCSTR>(&here), &self)) return {};
    const DWORD length = GetModuleFileNameA(self, path, sizeof path);
    const std::string name(path, length < sizeof path ? length : 0);
    return name.substr(0, name.find_last_of("\\/") + 1);
}

void *load(const std::string &path, std::string &why) {
    void *found = reinterpret_cast<void *>(LoadLibraryA(path.c_str()));
    if (!found) why = "Windows error " + std::to_string(GetLastError());
    return found;
}

void *find(void *library, const char *name) {
    return reinterpret_cast<void *>(GetProcAddress(static_cast<HMODULE>(library), name));
}
#else
std::string folder() {
    Dl_info self;
    if (dladdr(reinterpret_cast<void *>(&here), &self) == 0 || !self.dli_fname) return {};
    const std::string name = self.dli_fname;
    return name.substr(0, name.find_last_of('/') + 1);
}

void *load(const std::string &path, std::string &why) {
    void *found = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!found) why = dlerror();
    return found;
}

void *find(void *library, const char *name) { return dlsym(library, name); }
#endif

} // namespace

std::string Library::open() {
    std::string why;
    const std::string beside = folder() + FILE_NAME;
    void *library = load(beside, why);
    if (!library)
        return beside + " cannot be loaded (" + why + "): put the library of this package's version and of this machine's kind there";

#define CRUMPLE_UNITY_FIND(name)                                                                                                 \
    name = reinterpret_cast<decltype(name)>(find(library, #name));                                                               \
    if (!name) return beside + " has no " #name ": take it and crumple_unity from one archive";
    CRUMPLE_UNITY_FUNCTIONS(CRUMPLE_UNITY_FIND)
#undef CRUMPLE_UNITY_FIND
    return {};
}

} // namespace crumple_unity
