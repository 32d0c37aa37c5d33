/* Chooses the method by its estimated cost, a sum over all operations. The numbers of operations are exact or nearly
 * so. The nanoseconds were fitted to 84 (Chebyshev) and 20 timed signals of seven networks (30 grains to a lattice of
 * 2500; 2D, 3D, smooth and rough; 13 to 6000 over Omega, 101 and 1601 times, 1 and 16 pairs), which they reproduce
 * within factors of 0.6 to 1.25. All methods are limited by the same arithmetic, so other machines change all costs
 * alike. The chosen method therefore costs less than twice the best one. */
#include "signal/choose.h"

#include <math.h>

enum { SPARSE_DOFS = 4000, DENSE_DOFS = 20000 };

/* Size of the problem. */
typedef struct load {
    double n, springs, x, points, sources, detectors, pairs;
    bool spatial;
} load;

static load load_of(const sp_signal_problem *p, const sp_signal_options *o) {
    load l = {.n = p->dofs,
              .springs = p->springs,
              .x = p->omega * o->until,
              .points = o->points,
              .sources = o->from && o->sources > 0 ? o->sources : 1,
              .detectors = o->to && o->detectors > 0 ? o->detectors : 1,
              .spatial = p->dim == 3};
    l.pairs = l.sources * l.detectors;
    return l;
}

/* Each product carries two vectors: source and detector of a single pair, with half as many products, or two sources
 * (or detectors if these are fewer). Each pass needs Bessel functions of all orders at all times. */
static double chebyshev_cost(const load *l) {
    const double terms = l->x / 2 + 6 * cbrt(l->x) + 3,
                 passes = l->pairs > 1 ? ceil(fmin(l->sources, l->detectors) / 2) : 1;
    const double products = l->pairs > 1 ? terms * passes : terms / 2;
    const double product = (l->spatial ? 11.4 : 3.5) * l->springs + 0.42 * l->n + 114;
    return 1e4 + 37 * l->springs + products * product + passes * l->points * (38 + 0.18 * terms) +
           0.034 * l->pairs * l->points * terms;
}

/* All eigenvectors and their residuals, a sine for each mode and time, and for each pair the sum and the coupling of
 * modes. */
static double dense_cost(const load *l) {
    if (l->n > DENSE_DOFS)
        return HUGE_VAL;
    return 3.5e5 + l->n * (0.18 * l->n * l->n + 51 * l->n + 1.3 * l->springs + 10 * l->points +
                           l->pairs * (1.2 * l->points + 3.3 * l->n));
}

/* All modes in slices, since a tolerance below some percent needs nearly all. Small problems go to the dense solver. */
static double sparse_cost(const load *l) {
    if (l->n < SPARSE_DOFS)
        return HUGE_VAL;
    return l->n * (950 * l->n + l->pairs * (11.2 * l->points + 3.3 * l->n));
}

double sp_signal_problem_cost(sp_signal_method method, const sp_signal_problem *p, const sp_signal_options *o) {
    const load l = load_of(p, o);
    if (o->damping > 0 || o->front || p->carried)
        return method == (o->damping > 0 ? SP_SIGNAL_FABER : SP_SIGNAL_CHEBYSHEV) ? 1 : HUGE_VAL;
    switch (method) {
    case SP_SIGNAL_CHEBYSHEV: return chebyshev_cost(&l);
    case SP_SIGNAL_DENSE: return dense_cost(&l);
    case SP_SIGNAL_SPARSE: return sparse_cost(&l);
    default: return HUGE_VAL;
    }
}

double sp_signal_cost(sp_signal_method method, const sp_network *net, const sp_signal_options *o) {
    const sp_signal_problem p = {.dofs = (double)sp_network_dofs(net),
                                 .springs = net->n_springs,
                                 .omega = sp_network_omega_bound(net),
                                 .dim = net->dim,
                                 .carried = net->carried != NULL};
    return sp_signal_problem_cost(method, &p, o);
}

int sp_signal_choose(const sp_network *net, const sp_signal_options *o, sp_signal_method choice[SIGNAL_CHOICES]) {
    static const sp_signal_method all[SIGNAL_CHOICES] = {SP_SIGNAL_CHEBYSHEV, SP_SIGNAL_FABER, SP_SIGNAL_DENSE,
                                                         SP_SIGNAL_SPARSE};
    double cost[SIGNAL_CHOICES];
    int count = 0;
    for (int k = 0; k < SIGNAL_CHOICES; k++) {
        const double here = sp_signal_cost(all[k], net, o);
        if (!isfinite(here))
            continue;
        int at = count++;
        for (; at > 0 && cost[at - 1] > here; at--) {
            cost[at] = cost[at - 1];
            choice[at] = choice[at - 1];
        }
        cost[at] = here;
        choice[at] = all[k];
    }
    while (count > 1 && cost[count - 1] > fmax(1e10, 10 * cost[0]))
        count--;
    return count;
}
