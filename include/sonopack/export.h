#ifndef SONOPACK_EXPORT_H
#define SONOPACK_EXPORT_H
/* What a shared library shows. All other symbols are hidden. */

#if defined(__GNUC__)
#define SP_API __attribute__((visibility("default")))
#else
#define SP_API
#endif

/* What the libraries of this project share among themselves: shown by the linker, but in no installed header, and no
 * part of the interface. */
#define SP_SHARED SP_API

#endif
