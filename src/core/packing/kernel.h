#ifndef SP_KERNEL_H
#define SP_KERNEL_H
/* The two loops that take most of the time of a compression: over pairs and over grains. Each call handles a part of
 * them. Parts may run in parallel, and the result does not depend on their number. */

#include "packing/dynamics.h"

#include <stdint.h>
#include <string.h>

enum { BLOCK = 128 }; /* pairs per call; a multiple of the widest vector */

/* Writes the forces of the pairs [first, first + count) of the inner list to their rows. first and count are multiples
 * of 8, and count is at most BLOCK. Open pairs get zero force and lose their tangential force. Returns the largest rate
 * of a grain in one of them alone, times SINGLE_CONTACT (see dynamics.single). */
double sp_kernel_pairs_2d(const dynamics *d, double dt_past, int32_t first, int32_t count);
double sp_kernel_pairs_3d(const dynamics *d, double dt_past, int32_t first, int32_t count);
/* Like sp_kernel_pairs_2d, one by one, for contacts with a loading history (mindlin.h). Open pairs forget it. */
double sp_history_pairs(const dynamics *d, double dt_past, int32_t first, int32_t count);

/* Largest squared speed and largest sum of the rates of a grain's contacts (see dynamics) in a part of the grains. */
typedef struct kernel_maxima {
    double v2, rate;
} kernel_maxima;

/* Adds up the force rows of the grains [first, last) and moves these grains by dt. */
kernel_maxima sp_kernel_move_2d(const dynamics *d, double dt, int32_t first, int32_t last);
kernel_maxima sp_kernel_move_3d(const dynamics *d, double dt, int32_t first, int32_t last);

/* x^(-1/4) for normal x > 0, within 1.1 ulp. Square roots dominate the cost of a contact, and this gives two of them
 * without using the divider. A guess from the exponent, with |h| = |1 - x u^4| < 0.124, is improved by two steps of
 * third order, each leaving 15/32 h^3, and one of second order. */
static inline double inverse_fourth_root(double x) {
    uint64_t bits;
    double u;
    memcpy(&bits, &x, sizeof bits);
    bits = 0x4feb031000000000u - (bits >> 2);
    memcpy(&u, &bits, sizeof u);
    for (int step = 0; step < 2; step++) {
        double u2 = u * u, h = 1.0 - x * (u2 * u2);
        u += u * h * (0.25 + 0.15625 * h);
    }
    double u2 = u * u;
    return u + 0.25 * u * (1.0 - x * (u2 * u2));
}

#endif
