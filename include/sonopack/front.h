#ifndef SONOPACK_FRONT_H
#define SONOPACK_FRONT_H
/* The first wave front of a signal, from plain arrays only: simulations, chains, columns and laboratory traces share
 * this one definition (docs/physics.md, "The front"). */

#include <sonopack/status.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sp_front_options {
    double window;     /* times above are ignored; <= 0: all */
    double rise;       /* 0.1: the fraction of the peak that marks arrival */
    double prominence; /* 0.2: the first peak is the first local maximum above this fraction of the largest value */
} sp_front_options;
SP_API sp_front_options sp_front_options_default(void);

typedef struct sp_front {
    double t10;        /* first time at `rise` of the peak's height, linearly interpolated */
    double t_peak;     /* of the parabola through the three points of the maximum */
    double t_zero;     /* first zero crossing after it, linearly interpolated; NAN if there is none in the window */
    double amplitude;  /* height of that parabola */
    double width;      /* t_zero - t10 */
    int64_t crossings; /* upward crossings of rise x amplitude before the peak, the one of t10 included: above 1, noise
                          or a precursor makes t10 early; 0 in what a store gives back */
} sp_front;

/* The rule. L: the largest value in the window, which must be positive. First peak: the first local maximum above
 * prominence x L, where a maximum counts once the signal has fallen 0.01 L below it (so noise of 1e-3 of the peak makes
 * none) inside the window; of a plateau the middle. t10: the first time at rise x amplitude. t_zero: the first time at
 * or below 0 after the peak. Swings below zero count for nothing, and neither does what comes after t_zero.
 *
 * t strictly ascending, n >= 3, everything finite, else SP_EINVAL. SP_EREFUSED with the reason when there is no front:
 * never positive, no maximum before the window ends, or a trace that starts at or above rise x amplitude already (an
 * offset must be subtracted first). */
SP_API sp_status sp_front_find(int64_t n, const double *t, const double *f, const sp_front_options *opt, sp_front *out,
                               sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
