#ifndef SONOPACK_SIGNAL_H
#define SONOPACK_SIGNAL_H
/* The force on the top wall after a short pulse at the bottom wall (Eqs. (1) to (4) of Somfai et al. 2005). */

#include <sonopack/network.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sp_signal_method { SP_SIGNAL_AUTO = 0, SP_SIGNAL_CHEBYSHEV, SP_SIGNAL_DENSE } sp_signal_method;

typedef struct sp_signal_options {
    sp_signal_method method;
    sp_source source;
    double until;     /* last time; > 0 */
    int32_t points;   /* equally spaced times 0 .. until, >= 2 */
    double tolerance; /* error asked for, as a fraction of the largest |F| of each signal: 1e-10 */
    int32_t threads;  /* for networks large enough to gain by them; the same numbers for any: 1 */
    /* where; NULL: the whole wall, normal. All signals come from one pass. */
    int32_t sources, detectors; /* numbers of places; 0 or 1 with NULL */
    const sp_place *from, *to;
} sp_signal_options;
sp_signal_options sp_signal_options_default(void);

typedef struct sp_signal {
    int32_t n;
    int32_t sources, detectors;
    double *t;               /* [n] */
    double *f;               /* [sources][detectors][n] */
    double *errors;          /* [sources][detectors] bound of the error of f, in units of f */
    double error;            /* the largest of them */
    double omega_max;        /* bound of the spectrum that was used */
    int32_t products;        /* matrix products (0 for dense) */
    sp_signal_method method; /* the one that was used */
} sp_signal;

const char *sp_signal_method_name(sp_signal_method method); /* "chebyshev"; NULL for none */

sp_signal sp_signal_none(void);
/* SP_EREFUSED if the error bound exceeds the tolerance. */
sp_status sp_signal_make(const sp_network *net, const sp_signal_options *opt, sp_signal *out, sp_error *err);
void sp_signal_free(sp_signal *s);

/* The time in which the first front certainly has passed: [0, 8 H + 40] at p = 1e-4, scaled with p^(-1/6). */
double sp_signal_window(double height, double pressure);

#ifdef __cplusplus
}
#endif
#endif
