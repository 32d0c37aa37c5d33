#ifndef SONOPACK_VERSION_H
#define SONOPACK_VERSION_H
/* Version of the headers, and of the library at run time. */

#include <sonopack/visibility.h>

#define SONOPACK_VERSION "0.7.0"
/* Increased whenever the same scene and seed would give other numbers; part of a sample's name. Packings in three
 * dimensions have a number of their own; that of smooth grains with a weight is added to either. */
#define SONOPACK_ALGORITHM         3
#define SONOPACK_ALGORITHM_3D      4
#define SONOPACK_ALGORITHM_RESTING 100

#ifdef __cplusplus
extern "C" {
#endif

/* SONOPACK_VERSION when the library was built. */
SP_API const char *sp_version(void);

#ifdef __cplusplus
}
#endif
#endif
