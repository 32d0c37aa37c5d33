/* Refines eigenvalues by Rayleigh quotients and bounds their errors. */
#include "modes/refine.h"
#include "base/base.h"
#include "network/apply.h"

#include <float.h>
#include <math.h>

/* Largest clusters whose vectors are compared in pairs; the second if there are zero modes in it. */
enum { CLUSTER_MAX = 32, PAIRS_MAX = SP_PAIRS_MAX };

double sp_lapack_error(const sp_network *net) {
    const double omega = sp_network_omega_bound(net);
    return (8 + sqrt((double)sp_network_dofs(net))) * DBL_EPSILON * omega * omega;
}

void sp_mode_residual(const sp_network *net, const double *e, double lambda, double *u, double *r) {
    const int64_t n = sp_network_dofs(net);
    for (int64_t k = 0; k < n; k++)
        u[k] = e[k] / sqrt(net->mass[k]);
    sp_network_apply(net, u, r);
    for (int64_t k = 0; k < n; k++)
        r[k] = r[k] / sqrt(net->mass[k]) - lambda * e[k];
}

/* Scratch vectors, [dofs]. */
typedef struct scratch {
    double *u, *ku;
} scratch;

/* u = M^-1/2 (e + sign f); returns u . M u. */
static double displacement(const sp_network *net, const double *e, const double *f, double sign, double *u) {
    const int64_t n = sp_network_dofs(net);
    double norm = 0;
    for (int64_t k = 0; k < n; k++) {
        u[k] = (e[k] + (f ? sign * f[k] : 0)) / sqrt(net->mass[k]);
        norm += net->mass[k] * u[k] * u[k];
    }
    return norm;
}

/* Rayleigh quotient with its rounding error, and the residual. */
static void rayleigh(const sp_network *net, const double *e, scratch s, sp_ritz *r) {
    const int64_t n = sp_network_dofs(net);
    double rounding, sum = 0;
    const double norm = displacement(net, e, NULL, 0, s.u);
    r->lambda = sp_network_energy2_bound(net, s.u, &rounding) / norm;
    /* the sum of n squares in norm has an error of about sqrt(n) roundings, n at worst */
    r->rounding = rounding / norm;
    r->error = rounding / norm + fabs(r->lambda) * DBL_EPSILON * (4 + sqrt((double)n));
    sp_network_apply(net, s.u, s.ku);
    for (int64_t k = 0; k < n; k++) {
        const double root = sqrt(net->mass[k]), rest = s.ku[k] / root - r->lambda * root * s.u[k];
        sum += rest * rest;
    }
    r->residual = sqrt(sum / norm);
}

/* Upper bound of |e . A f| = |E(e+f) - E(e-f)|/4 for two of the vectors. */
static double coupling(const sp_network *net, const double *e, const double *f, scratch s) {
    double rounding[2], energy[2];
    for (int q = 0; q < 2; q++) {
        displacement(net, e, f, q == 0 ? 1 : -1, s.u);
        energy[q] = sp_network_energy2_bound(net, s.u, &rounding[q]);
    }
    return 0.25 * (fabs(energy[0] - energy[1]) + rounding[0] + rounding[1]);
}

/* Vectors first .. last, whose eigenvalues LAPACK cannot separate; gap: distance to all others. */
typedef struct cluster {
    int64_t first, last;
    double gap;
} cluster;

/* Largest sum over the other members of upper bounds of |H_ab|, H = V^T A V: by the couplings of all pairs. */
static double sum_of_pairs(const sp_network *net, const double *vectors, const cluster *c, scratch s) {
    const int64_t n = sp_network_dofs(net), first = c->first, members = c->last - first + 1;
    double row[PAIRS_MAX] = {0}, most = 0;
    for (int64_t a = 0; a < members; a++)
        for (int64_t b = a + 1; b < members; b++) {
            const double shared = coupling(net, vectors + (first + a) * n, vectors + (first + b) * n, s);
            row[a] += shared;
            row[b] += shared;
        }
    for (int64_t a = 0; a < members; a++)
        most = fmax(most, row[a]);
    return most;
}

/* The same by the bounds of Cauchy and Schwarz, sqrt(H_aa H_bb), for a positive K. Good for zero modes alone. */
static double sum_of_roots(const cluster *c, const sp_ritz *ritz) {
    double most = 0, roots = 0;
    for (int64_t m = c->first; m <= c->last; m++)
        roots += sqrt(fmax(ritz[m].lambda, 0) + ritz[m].rounding);
    for (int64_t m = c->first; m <= c->last; m++) {
        const double own = sqrt(fmax(ritz[m].lambda, 0) + ritz[m].rounding);
        most = fmax(most, own * (roots - own));
    }
    return most;
}

static double row_sum(const sp_network *net, const double *vectors, const cluster *c, scratch s, const sp_ritz *ritz) {
    const double omega = sp_network_omega_bound(net), little = 1e-20 * omega * omega;
    const int64_t members = c->last - c->first + 1;
    if (members <= CLUSTER_MAX)
        return sum_of_pairs(net, vectors, c, s);
    if (net->prestress)
        return HUGE_VAL;
    const double roots = sum_of_roots(c, ritz);
    /* zero modes among soft ones need more */
    const bool soft = ritz[c->first].lambda < 1e-12 * omega * omega;
    return roots > little && soft && members <= PAIRS_MAX ? sum_of_pairs(net, vectors, c, s) : roots;
}

/* The eigenvalues of H = V^T A V are within |R|^2/gap of those of A, R = A V - V H (Kato and Temple). The diagonal of H
 * is within the sum of the other entries of a row of its eigenvalues. Without a gap the error is at most |R|
 * (Weyl). */
static void bound_cluster(const sp_network *net, const double *vectors, const cluster *c, scratch s, sp_ritz *ritz) {
    const double omega = sp_network_omega_bound(net), noise = 8 * DBL_EPSILON * omega * omega;
    double squares = 0;
    for (int64_t m = c->first; m <= c->last; m++)
        squares += (ritz[m].residual + noise) * (ritz[m].residual + noise);
    double bound = sqrt(squares);
    if (c->gap > 0)
        bound = fmin(bound, row_sum(net, vectors, c, s, ritz) + squares / c->gap);
    for (int64_t m = c->first; m <= c->last; m++)
        ritz[m].error += bound;
}

/* Distance between a cluster and all other eigenvalues. */
static double gap_of(const sp_network *net, const sp_refine_set *set, const double *values, double blur,
                     const cluster *c) {
    const double low = c->first > 0 ? values[c->first - 1] : set->below,
                 high = c->last + 1 < set->count ? values[c->last + 1] : set->above;
    const double gap = fmin(values[c->first] - low, high - values[c->last]) - blur;
    return isfinite(gap) ? gap : sp_network_omega_bound(net) * sp_network_omega_bound(net); /* there are no others */
}

sp_status sp_modes_refine(const sp_network *net, const sp_refine_set *set, sp_ritz *ritz, sp_error *err) {
    const int64_t n = sp_network_dofs(net), count = set->count;
    double blur = set->blur;
    scratch s = {sp_alloc((size_t)n, sizeof(double)), sp_alloc((size_t)n, sizeof(double))};
    double *values = sp_alloc((size_t)count, sizeof *values);
    sp_status status = SP_OK;
    if (!s.u || !s.ku || !values) {
        status = sp_fail_memory(err, (2 * (size_t)n + (size_t)count) * sizeof(double));
        goto out;
    }
    for (int64_t m = 0; m < count; m++) {
        rayleigh(net, set->vectors + m * n, s, &ritz[m]);
        values[m] = set->values ? set->values[m] : ritz[m].lambda;
        if (!set->values)
            blur = fmax(blur, set->blur + ritz[m].residual);
    }
    for (int64_t first = 0, last; first < count; first = last + 1) {
        for (last = first;
             last + 1 < count && (last + 1 < set->soft || values[last + 1] - values[last] <=
                                                              fmax(4 * blur, set->cluster * fabs(values[last + 1])));
             last++)
            ;
        cluster c = {first, last, 0};
        c.gap = gap_of(net, set, values, blur, &c);
        bound_cluster(net, set->vectors, &c, s, ritz);
    }
out:
    sp_free(values);
    sp_free(s.ku);
    sp_free(s.u);
    return status;
}
