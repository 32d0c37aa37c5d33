/* Refines eigenvalues by Rayleigh quotients, bounds their errors, and tells zero modes from soft ones. */
#include "modes/refine.h"

#include "base/base.h"
#include "linalg/eigen.h"
#include "network/apply.h"
#include "network/rows.h"

#include <float.h>
#include <math.h>
#include <string.h>

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

/* ---- zero modes -------------------------------------------------------------------------------------------------- */

/* omega of a zero mode over the largest frequency. With prestress energies are differences, not sums of squares. */
static const double ZERO = 1e-8, ZERO_PRESTRESS = 1e-7;

static double zero_frequency(const sp_network *net) {
    return (net->prestress ? ZERO_PRESTRESS : ZERO) * sp_network_omega_bound(net);
}

double sp_zero_limit(const sp_network *net) { return zero_frequency(net) * zero_frequency(net); }

sp_zero_modes sp_zeros_sum(const sp_network *net, const sp_null_motions *known, int64_t mechanisms) {
    sp_zero_modes z = {.rattlers = (int64_t)net->rattlers * net->dof,
                       .spins = known->spins,
                       .rigid = known->rigid,
                       .mechanisms = mechanisms,
                       .below = zero_frequency(net)};
    z.total = z.rattlers + z.spins + z.rigid + z.mechanisms;
    return z;
}

/* Without prestress K is positive: q motions whose energies add up to less than the limit prove q eigenvalues below it
 * (minimum and maximum principle), however near they are to others. */
static int64_t count_by_energy(int64_t count, const sp_ritz *ritz, double limit) {
    int64_t zeros = 0;
    double sum = 0;
    for (; zeros < count; zeros++) {
        sum += fmax(ritz[zeros].lambda, 0) + ritz[zeros].rounding;
        if (sum > limit)
            break;
    }
    return zeros;
}

/* With prestress by the error of each eigenvalue. Null motions have eigenvalue zero whatever the error. */
static int64_t count_by_error(int64_t count, const sp_ritz *ritz, int64_t known, double limit) {
    int64_t zeros = 0;
    while (zeros < count &&
           fabs(ritz[zeros].lambda) <= fmax(limit - ritz[zeros].error, zeros < known ? ritz[zeros].error : 0))
        zeros++;
    return zeros;
}

sp_status sp_zeros_count(const sp_network *net, int64_t count, const sp_ritz *ritz, int64_t known, int64_t *zeros,
                         sp_error *err) {
    const double limit = sp_zero_limit(net);
    const int64_t found =
        net->prestress ? count_by_error(count, ritz, known, limit) : count_by_energy(count, ritz, limit);
    for (int64_t k = found; k < count; k++) {
        const double lambda = ritz[k].lambda, error = ritz[k].error;
        if (lambda < -fmax(error, limit))
            return sp_fail(err, SP_EREFUSED,
                           "omega^2 = %.6g of a mode is negative: the network is unstable (prestress)", lambda);
        if (!(lambda - error > limit))
            return sp_fail(
                err, SP_EREFUSED,
                "it cannot be decided whether a mode of omega^2 = %.6g, known to %.2g, is a zero mode (below %.3g)",
                lambda, error, limit);
    }
    *zeros = found;
    return SP_OK;
}

int64_t sp_zeros_near(int64_t count, const double *values, double blur, double above) {
    int64_t near = 0; /* the last gap that is wide enough to part clusters at all */
    if (count == 0 || values[0] > 8 * blur)
        return 0;
    for (int64_t k = 1; k <= count; k++) {
        const double gap = (k < count ? values[k] : above) - values[k - 1];
        if (gap > 8 * blur && (near == 0 || k <= SP_PAIRS_MAX))
            near = k;
        if (near > 0 && (gap > 1e4 * blur || k > SP_PAIRS_MAX))
            break;
    }
    return near > 0 ? near : count;
}

/* ---- zero modes and soft modes mixed ---------------------------------------------------------------------------- */

enum { ROWS = 512 }; /* stretches per product */

/* Some of the stretches by each vector, plain and times the stiffness. */
typedef struct stretches {
    int64_t count;
    int filled;
    double *plain, *stiff; /* [count][ROWS] */
    double *part;          /* [count][count] sums over these stretches */
    double *h;             /* [count][count] over all of them */
} stretches;

static void add_up(stretches *w) {
    const int64_t entries = w->count * w->count;
    for (int64_t c = 0; c < w->count; c++) /* the last ones may be old */
        for (int q = w->filled; q < ROWS; q++)
            w->plain[c * ROWS + q] = w->stiff[c * ROWS + q] = 0;
    sp_project(ROWS, w->count, w->plain, (int)w->count, w->stiff, w->part);
    for (int64_t k = 0; k < entries; k++)
        w->h[k] += w->part[k];
    w->filled = 0;
}

static void add_spring(const sp_network *net, const sp_spring *s, const double *vectors, stretches *w) {
    const int64_t n = sp_network_dofs(net);
    sp_rows rows;
    sp_network_rows(net, s, &rows);
    for (int q = 0; q < rows.count; q++) {
        for (int64_t c = 0; c < w->count; c++) {
            double sum = 0;
            for (int a = 0; a < rows.width; a++) {
                const int64_t at = (int64_t)(a < net->dof ? s->i : s->j) * net->dof + a % net->dof;
                sum += rows.b[q][a] * vectors[c * n + at] / sqrt(net->mass[at]);
            }
            w->plain[c * ROWS + w->filled] = sum;
            w->stiff[c * ROWS + w->filled] = rows.k[q] * sum;
        }
        if (++w->filled == ROWS)
            add_up(w);
    }
}

/* vectors <- linear combinations of them with the coefficients h [count][count]. */
static sp_status combine(int64_t n, int64_t count, const double *h, double *vectors, sp_error *err) {
    double *turned = sp_alloc((size_t)count, (size_t)n * sizeof *turned);
    if (!turned)
        return sp_fail_memory(err, (size_t)(count * n) * sizeof *turned);
    for (int64_t c = 0; c < count; c++)
        for (int64_t q = 0; q < count; q++) {
            const double *from = vectors + q * n, share = h[c * count + q];
            double *to = turned + c * n;
            for (int64_t k = 0; k < n; k++)
                to[k] += share * from[k];
        }
    memcpy(vectors, turned, (size_t)(count * n) * sizeof *turned);
    sp_free(turned);
    return SP_OK;
}

/* Makes the vectors those of the eigenvectors of V^T A V, softest first. This is a sum over springs: sums of products
 * of small stretches, where V . (A V) would lose what is small. */
static sp_status turn(const sp_network *net, int64_t count, double *vectors, sp_error *err) {
    const size_t many = (size_t)count;
    stretches w = {.count = count,
                   .plain = sp_alloc(many, ROWS * sizeof(double)),
                   .stiff = sp_alloc(many, ROWS * sizeof(double)),
                   .part = sp_alloc(many * many, sizeof(double)),
                   .h = sp_alloc(many * many, sizeof(double))};
    double *values = sp_alloc(many, sizeof *values);
    sp_status status = w.plain && w.stiff && w.part && w.h && values
                           ? SP_OK
                           : sp_fail_memory(err, many * (2 * many + 2 * ROWS) * sizeof(double));
    for (int32_t q = 0; q < net->n_springs && status == SP_OK; q++)
        add_spring(net, &net->springs[q], vectors, &w);
    if (status == SP_OK) {
        add_up(&w);
        status = sp_eigen_all(count, w.h, values, err);
    }
    if (status == SP_OK)
        status = combine(sp_network_dofs(net), count, w.h, vectors, err);
    sp_free(w.plain);
    sp_free(w.stiff);
    sp_free(w.part);
    sp_free(w.h);
    sp_free(values);
    return status;
}

sp_status sp_zeros_part(const sp_network *net, int64_t count, double *vectors, sp_error *err) {
    const int64_t n = sp_network_dofs(net);
    double sum = 0, rounding;
    double *u = sp_alloc((size_t)n, sizeof *u);
    if (!u)
        return sp_fail_memory(err, (size_t)n * sizeof *u);
    for (int64_t c = 0; c < count; c++) {
        for (int64_t k = 0; k < n; k++)
            u[k] = vectors[c * n + k] / sqrt(net->mass[k]);
        sum += fabs(sp_network_energy2_bound(net, u, &rounding));
    }
    sp_free(u);
    return count < 2 || sum <= 0.1 * sp_zero_limit(net) ? SP_OK : turn(net, count, vectors, err);
}
