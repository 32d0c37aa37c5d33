#ifndef SONOPACK_VERSION_H
#define SONOPACK_VERSION_H
/* Version of the headers, and of the library at run time. */

#include <sonopack/export.h>

#define SONOPACK_VERSION "0.6.0"
/* Increased whenever the same scene and seed would give other numbers; part of a sample's name. Packings in three
 * dimensions have a number of their own. For smooth grains under gravity the name has the next number: version 0.6.0
 * and earlier ones took some that rest by their weight for rattlers. */
#define SONOPACK_ALGORITHM    3
#define SONOPACK_ALGORITHM_3D 4

#ifdef __cplusplus
extern "C" {
#endif

/* SONOPACK_VERSION when the library was built. */
SP_API const char *sp_version(void);

#ifdef __cplusplus
}
#endif
#endif
