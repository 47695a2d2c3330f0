// The one function that Rust's standard library takes from Windows' bcryptprimitives.dll, which Wine before version 9 lacks.
#include <windows.h>
// After it:
#include <ntsecapi.h>

BOOL WINAPI ProcessPrng(PBYTE data, SIZE_T length) { return RtlGenRandom(data, (ULONG)length); }
