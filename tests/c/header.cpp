// The headers are C++17, may be included twice and in any order, and need nothing before them.
#include <crumple.hpp>
#include <crumple.h>
#include <crumple.hpp>

#include <cstdio>
#include <type_traits>

static_assert(std::is_standard_layout_v<CrumpleExampleSetDef> && std::is_trivial_v<CrumpleExampleSetDef>);
static_assert(std::is_nothrow_move_constructible_v<crumple::Context> && !std::is_copy_constructible_v<crumple::Context>);
static_assert(std::is_nothrow_move_assignable_v<crumple::Instance> && !std::is_copy_assignable_v<crumple::Instance>);

int main() {
    std::printf("Crumple %s from C++\n", crumple_version_string());
    return crumple_version() == CRUMPLE_VERSION ? 0 : 1;
}
