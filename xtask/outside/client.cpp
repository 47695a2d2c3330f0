// A C++ program of somebody else's: the wrapper compiles, links and agrees with the library about the version.
#include <crumple.hpp>

#include <cstdio>

int main() {
    const bool same = crumple_version() == CRUMPLE_VERSION;
    std::printf("client: Crumple %s\n", crumple_version_string());
    return same ? 0 : 1;
}
