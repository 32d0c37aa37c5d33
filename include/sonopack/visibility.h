#ifndef SONOPACK_VISIBILITY_H
#define SONOPACK_VISIBILITY_H
/* Symbol visibility. Everything else in a shared library is hidden. */

#if defined(__GNUC__)
#define SP_API __attribute__((visibility("default")))
#else
#define SP_API
#endif

/* Symbols that the libraries of this project share with each other. They are visible to the linker but not declared in
 * installed headers, and are not part of the interface. */
#define SP_SHARED SP_API

#endif
