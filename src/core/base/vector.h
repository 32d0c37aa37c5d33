#ifndef SP_BASE_VECTOR_H
#define SP_BASE_VECTOR_H
/* Vectors of three components. */

#include "base/clones.h"

#include <math.h>

static ALWAYS_INLINE double dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static ALWAYS_INLINE double length3(const double a[3]) { return sqrt(dot3(a, a)); }

static ALWAYS_INLINE void cross3(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

#endif
