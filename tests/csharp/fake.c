// A library with Crumple's name that is not the right one: of the version that VERSION says, or without that function.
#include <stdint.h>

#ifdef VERSION
uint32_t crumple_version(void) { return VERSION; }
#else
uint32_t something_else(void) { return 1; }
#endif
