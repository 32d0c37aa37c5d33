#ifndef SP_FORWARD_H
#define SP_FORWARD_H
/* The doubled pass of a signal from one source to one detector, with what is needed to run it backwards: vectors at
 * some steps, and when each field reaches each block. */

#include "sensitivity/nodes.h"
#include "signal/pass.h"

#include <sonopack/sensitivity.h>

enum { FORWARD_SNAPSHOTS = 4, FORWARD_STRIDE = 4 };

typedef struct forward {
    const sp_network *net;
    bool velocity;
    double omega, norm_a, norm_b; /* upper bound of the frequencies; norms of source and detector */
    double power;                 /* F(t) becomes s^power F(t sqrt(s)) if all springs are multiplied by s */
    double *gap[2];               /* [springs][3] of source and detector (sp_place_gaps) */
    sp_source source;
    sp_operator op;
    sparse_row from, to;
    pass p;
    int64_t capacity;  /* moments */
    int32_t *since[2]; /* [blocks] first step with each field in a block */
    struct snapshot {
        int64_t step;
        double *u, *v;
    } kept[FORWARD_SNAPSHOTS];
    int64_t every; /* steps between snapshots */
    int newest;
} forward;

/* terms: an upper limit of the number of moments; every: about how many steps lie between two snapshots. */
sp_status sp_forward_make(const sp_network *net, const sp_sensitivity_options *opt, int64_t terms, int64_t every,
                          forward *out, sp_error *err);
void sp_forward_free(forward *f);
/* Advances until at least `terms` moments are known. */
sp_status sp_forward_extend(forward *f, int64_t terms, sp_error *err);
/* The state at the first kept step >= least; SP_EFAILED if the pass has not come that far. */
sp_status sp_forward_state(const forward *f, int64_t least, struct snapshot *out, sp_error *err);
/* Sum of weight x moment, and an upper bound of its error (remainder and rounding). */
double sp_forward_sum(const forward *f, const sp_moment_weights *w, double last, double *error);
/* SP_EREFUSED if the motion grows. */
sp_status sp_forward_check(const forward *f, sp_error *err);

/* ---- what gradients of signals and of fronts share -------------------------------------------------------------- */

sp_status sp_functional_check(const sp_network *net, const sp_sensitivity_options *opt, sp_error *err);
/* More moments than any functional of times up to `last` needs. */
int64_t sp_functional_terms(double omega, double last);
/* Value and gradient of one functional; extends the forward pass as needed. */
sp_status sp_functional_gradient(forward *f, const sp_sensitivity_options *opt, const sp_nodes *nodes, sp_gradient *out,
                                 sp_error *err);

#endif
