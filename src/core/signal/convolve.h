#ifndef SP_CONVOLVE_H
#define SP_CONVOLVE_H
/* Convolution of a tabulated response with a pulse. */

#include <sonopack/pulse.h>

typedef struct sp_response {
    int64_t n;
    double step;     /* times 0, step, ... */
    const double *g; /* [n] */
    int mirror;      /* G(-t) = mirror G(t): 1 or -1 for the undamped response of displacements or momenta; 0: no such
                        continuation, interpolation near t = 0 has values on one side only */
} sp_response;

/* How densely a convolution is summed: every `stride`-th value of the response, interpolated by polynomials of `points`
 * values, and Gauss's rule of `nodes` nodes on panels no longer than `panel`. */
typedef struct sp_quadrature {
    int stride, points, nodes;
    double panel;
} sp_quadrature;

/* F at n times, which the response reaches: from 0 to t - first of the pulse. */
sp_status sp_convolve(const sp_response *g, const sp_pulse *pulse, const sp_quadrature *rule, int32_t n,
                      const double *t, double *f, sp_error *err);

#endif
