#ifndef SP_ROOTS_H
#define SP_ROOTS_H

#include <stdint.h>
#include <string.h>

/* x^(-1/4) for normal x > 0, within 1.1 ulp. Square roots are most of a contact's cost, and this gives two of them
 * without the divider: a guess from the exponent, good to h = |1 - x u^4| < 0.124, then two steps of third order, each
 * leaving 15/32 h^3, the last of second order. */
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
