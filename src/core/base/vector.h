#ifndef SP_BASE_VECTOR_H
#define SP_BASE_VECTOR_H
/* Vectors of three components, and of any number: sums are formed in the order of the elements. */

#include "base/clones.h"

#include <math.h>
#include <stdint.h>

static ALWAYS_INLINE double dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static ALWAYS_INLINE double length3(const double a[3]) { return sqrt(dot3(a, a)); }

static ALWAYS_INLINE void cross3(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static inline double sp_dot(int64_t n, const double *a, const double *b) {
    double sum = 0;
    for (int64_t k = 0; k < n; k++)
        sum += a[k] * b[k];
    return sum;
}

static inline double sp_norm(int64_t n, const double *a) { return sqrt(sp_dot(n, a, a)); }

/* Largest |a[k]|; 0 for n = 0. */
static inline double sp_largest(int64_t n, const double *a) {
    double largest = 0;
    for (int64_t k = 0; k < n; k++)
        largest = fmax(largest, fabs(a[k]));
    return largest;
}

#endif
