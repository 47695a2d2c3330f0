// A library crumple of another version, or with LACKING of this one but with functions missing.
#include <stdint.h>
#ifdef LACKING
#include <crumple.h>
uint32_t crumple_version(void) { return CRUMPLE_VERSION; }
#else
uint32_t crumple_version(void);
uint32_t crumple_version(void) { return 9008007; }
#endif
