#ifndef SP_INFERENCE_DESIGN_PROBLEM_H
#define SP_INFERENCE_DESIGN_PROBLEM_H
/* Parts of design: the packing made of changed grains, the objective with its gradient, and the set of factors that are
 * allowed. */

#include <sonopack/design.h>
#include <sonopack/sensitivity.h>

typedef struct sp_design_problem {
    const sp_packing *p;
    const sp_design_options *opt;
    double *weight;         /* [n] of the grains in the total that is kept; 0: rattlers, which stay as they are */
    double total;           /* sum of the weights */
    double scale;           /* BAND: energy of the start */
    const sp_packing *from; /* RADIUS: where a compression begins; NULL: p */
} sp_design_problem;

/* What is made as large as possible: ln t_10 and its like, whose gradient [n] by the factors may be NULL. `value` and
 * `error` as in sp_design_step. made: if not NULL, the packing of these factors; free it. */
typedef struct sp_design_value {
    double objective, value, error;
} sp_design_value;
sp_status sp_design_evaluate(const sp_design_problem *d, const double *factor, double *gradient, sp_design_value *out,
                             sp_packing *made, sp_error *err);

/* The energy of a signal between two frequencies, 1/pi times the integral of |F(omega)|^2 (the integral of F^2 over all
 * of them), and its derivatives by the values: weight [n]. scratch [n]. */
double sp_design_band(int32_t n, double spacing, const double *f, double low, double high, double *scratch,
                      double *weight);

/* Replaces factors by the nearest that are allowed: within the limits, and with the total, if it is kept. */
void sp_design_project(const sp_design_problem *d, double *factor);
/* The allowed factors that g makes largest in g . factor; returns the multiplier of the total (0 if it is free). */
double sp_design_extreme(const sp_design_problem *d, const double *g, double *factor);

#endif
