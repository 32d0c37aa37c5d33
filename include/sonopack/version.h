#ifndef SONOPACK_VERSION_H
#define SONOPACK_VERSION_H
#define SONOPACK_VERSION "0.1.0"
/* Raised whenever the same scene and seed would give other numbers: part of a sample's name. */
#define SONOPACK_ALGORITHM 3
#endif
