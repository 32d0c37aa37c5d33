#ifndef SONOPACK_VERSION_H
#define SONOPACK_VERSION_H
/* The version of these headers, and that of the library that runs. */

#include <sonopack/export.h>

#define SONOPACK_VERSION "0.1.0"
/* Raised whenever the same scene and seed would give other numbers: part of a sample's name. */
#define SONOPACK_ALGORITHM 3

#ifdef __cplusplus
extern "C" {
#endif

/* SONOPACK_VERSION as it was when the library was built. */
SP_API const char *sp_version(void);

#ifdef __cplusplus
}
#endif
#endif
