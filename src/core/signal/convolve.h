#ifndef SP_CONVOLVE_H
#define SP_CONVOLVE_H
/* Convolution of a sampled response with a pulse. */

#include <sonopack/pulse.h>

typedef struct sp_response {
    int64_t n;
    double step;     /* times 0, step, ... */
    const double *g; /* [n] */
    int mirror; /* G(-t) = mirror G(t): 1 or -1 for the undamped response to displacements or momenta. 0: unknown before
                   t = 0, so interpolation near 0 is one-sided */
} sp_response;

/* Accuracy of a convolution: every `stride`-th value of the response, interpolated by polynomials through `points`
 * values, and Gauss's rule with `nodes` nodes on panels no longer than `panel`. */
typedef struct sp_quadrature {
    int stride, points, nodes;
    double panel;
} sp_quadrature;

/* Length of a panel in which both the pulse and a response with frequencies up to omega are smooth for Gauss's rule. */
double sp_pulse_panel(const sp_pulse *p, double omega);

/* F at n times. The response must reach from 0 to t minus the start of the pulse. */
sp_status sp_convolve(const sp_response *g, const sp_pulse *pulse, const sp_quadrature *rule, int32_t n,
                      const double *t, double *f, sp_error *err);

#endif
