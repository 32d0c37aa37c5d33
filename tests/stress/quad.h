#ifndef STRESS_QUAD_H
#define STRESS_QUAD_H
/* Arithmetic of 113 bits, done by the compiler's own run-time library, and the few functions that are needed. */

#include <float.h>
#include <math.h>

#if LDBL_MANT_DIG >= 113
typedef long double quad;
#define STRESS_QUAD 1
#elif defined(__SIZEOF_FLOAT128__)
typedef __float128 quad;
#define STRESS_QUAD 1
#else
typedef long double quad; /* compiles, and the tests are skipped */
#define STRESS_QUAD 0
#endif

static inline quad quad_abs(quad x) { return x < 0 ? -x : x; }

/* Newton's iteration, from 53 bits to 106 to all. */
static inline quad quad_sqrt(quad x) {
    if (!(x > 0))
        return 0;
    quad root = (quad)sqrtl((long double)x);
    for (int k = 0; k < 3; k++)
        root = (root + x / root) / 2;
    return root;
}

/* sum over k of (-z)^k / (2k + first)!: cos(sqrt z) for first = 0, sin(sqrt z)/sqrt z for first = 1; hyperbolic ones
 * for z < 0. */
static inline quad quad_series(quad z, int first) {
    quad term = 1, sum = 1;
    for (int k = 1; quad_abs(term) > 1e-36L && k < 200; k++) {
        term *= -z / ((2 * k + first - 1) * (2 * k + first));
        sum += term;
    }
    return sum;
}

static inline quad quad_arctan_inverse(int n) {
    quad power = (quad)1 / n, sum = 0;
    for (int k = 0; quad_abs(power) > 1e-38L; k++) {
        sum += (k % 2 ? -power : power) / (2 * k + 1);
        power /= n * n;
    }
    return sum;
}

/* 2 pi by Machin's formula. */
static inline quad quad_turn(void) {
    static quad turn = 0;
    if (!(turn > 0))
        turn = 8 * (4 * quad_arctan_inverse(5) - quad_arctan_inverse(239));
    return turn;
}

/* x less whole turns: |x| up to 1e10 keeps 22 digits behind the point. */
static inline quad quad_reduced(quad x) {
    const quad turn = quad_turn();
    quad turns = x / turn;
    const long double whole = roundl((long double)turns);
    return x - (quad)whole * turn;
}
static inline quad quad_sin(quad x) {
    const quad y = quad_reduced(x);
    return y * quad_series(y * y, 1);
}
static inline quad quad_cos(quad x) {
    const quad y = quad_reduced(x);
    return quad_series(y * y, 0);
}

/* sin(sqrt(lambda) t)/sqrt(lambda) and cos(sqrt(lambda) t): whole functions of lambda, t for a floppy mode, growing for
 * a negative lambda. */
static inline quad quad_swing(quad lambda, quad t, int velocity) {
    const quad z = lambda * t * t;
    if (quad_abs(z) < 1)
        return velocity ? t * quad_series(z, 1) : quad_series(z, 0);
    if (lambda > 0) {
        const quad omega = quad_sqrt(lambda);
        return velocity ? quad_sin(omega * t) / omega : quad_cos(omega * t);
    }
    const long double rate = sqrtl((long double)-lambda), arg = rate * (long double)t;
    return (quad)(velocity ? sinhl(arg) / rate : coshl(arg));
}

#endif
