#ifndef SONOPACK_FRONT_H
#define SONOPACK_FRONT_H
/* The first wave front of a signal, from plain arrays only: simulations, chains, columns and laboratory traces share
 * this one definition (PHYSICS 6). */

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
sp_front_options sp_front_options_default(void);

typedef struct sp_front {
    double t10;       /* first time at `rise` of the peak's height, linearly interpolated */
    double t_peak;    /* of the parabola through the three points of the maximum */
    double t_zero;    /* first zero crossing after it, linearly interpolated; NAN if there is none in the window */
    double amplitude; /* height of that parabola */
    double width;     /* t_zero - t10 */
} sp_front;

/* t ascending, n >= 3, finite. SP_EREFUSED with the reason when there is no front. */
sp_status sp_front_find(int64_t n, const double *t, const double *f, const sp_front_options *opt, sp_front *out,
                        sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
