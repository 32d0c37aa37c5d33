#ifndef SP_LINALG_VECTOR_H
#define SP_LINALG_VECTOR_H
/* Plain vectors of doubles. Sums are formed in the order of the elements. */

#include <math.h>
#include <stdint.h>

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
