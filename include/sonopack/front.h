#ifndef SONOPACK_FRONT_H
#define SONOPACK_FRONT_H
/* The first wave front of a signal. The input is plain arrays, so that simulations, chains, tapped columns and
 * laboratory traces share one definition (docs/physics.md, "The front"). */

#include <sonopack/status.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sp_front_options {
    double window;     /* last time used; <= 0: all */
    double rise;       /* fraction of the peak that marks the arrival; 0.1 */
    double prominence; /* the first peak is the first local maximum above this fraction of the largest value; 0.2 */
} sp_front_options;
SP_API sp_front_options sp_front_options_default(void);

/* The first front of a trace. */
typedef struct sp_front {
    double t10;        /* arrival: first time at `rise` of the peak, linearly interpolated [d/sqrt(E* / rho)] */
    double t_peak;     /* vertex of the parabola through the three points of the maximum [d/sqrt(E* / rho)] */
    double t_zero;     /* first zero crossing after the peak, linearly interpolated; NAN if there is none in the window
                          [d/sqrt(E* / rho)] */
    double amplitude;  /* height of that vertex [E* d^2] */
    double width;      /* t_zero - t10 [d/sqrt(E* / rho)] */
    int64_t crossings; /* upward crossings of rise x amplitude before the peak, including that at t10. Above 1, noise or
                          a precursor makes t10 early. 0 in fronts read from a store */
} sp_front;

/* Finds the first front. L: the largest value in the window. The first peak is the first local maximum above prominence
 * x L. A maximum counts once the signal has fallen 0.01 L below it inside the window, so that noise of 1e-3 of the peak
 * makes none; a plateau counts as its middle. t10 is the first time at rise x amplitude, t_zero the first time at or
 * below 0 after the peak. Negative swings and everything after t_zero are ignored.
 *
 * SP_EINVAL unless t ascends strictly, n >= 3 and all numbers are finite. SP_EREFUSED if there is no front: if the
 * signal is never positive, has no maximum inside the window, starts at or above rise x amplitude (subtract its
 * offset first), or falls so fast beside its first peak that the vertex is above twice the largest point, or before
 * t10. */
SP_API sp_status sp_front_find(int64_t n, const double *t, const double *f, const sp_front_options *opt, sp_front *out,
                               sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
