#ifndef SONOPACK_VERSION_H
#define SONOPACK_VERSION_H
/* Version of the headers, and of the library at run time. */

#include <sonopack/visibility.h>

#define SONOPACK_VERSION "0.12.0"
/* Increased whenever the same scene and seed would give other numbers; part of a sample's name. */
#define SONOPACK_ALGORITHM 8

#ifdef __cplusplus
extern "C" {
#endif

/* SONOPACK_VERSION when the library was built. */
SP_API const char *sp_version(void);

#ifdef __cplusplus
}
#endif
#endif
