#ifndef SP_ROOTS_H
#define SP_ROOTS_H

#include <stdint.h>
#include <string.h>

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
