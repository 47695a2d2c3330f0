// A C++ program of somebody else's: the wrapper compiles, links, and its header is of the library's version.
#include <crumple.hpp>

#include <cstdio>

int main() {
    const unsigned header =
        CRUMPLE_VERSION_MAJOR * 1000000u + CRUMPLE_VERSION_MINOR * 1000u + CRUMPLE_VERSION_PATCH;
    std::printf("client: Crumple %s\n", crumple_version_string());
    return crumple_version() == header ? 0 : 1;
}
