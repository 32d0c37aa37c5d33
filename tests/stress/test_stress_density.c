/* Densities of states of hard networks against the spectrum in quadruple precision: counts and exact histograms within
 * their bounds, the smooth density of all frequencies within its own, and that of random vectors as often within its
 * standard error as chance allows. */
#include "spectrum/moments.h"
#include "stress/exact.h"
#include "stress/networks.h"
#include "stress/record.h"

#include <sonopack/spectrum.h>

enum { BINS = 37, EVERY = 3 };

static int exact_below(const exact *x, double omega) {
    int count = 0;
    while (count < x->n && x->lambda[count] <= (quad)omega * omega)
        count++;
    return count;
}

/* The row that is worst against its bound stands for all. */
static void compare_counts(stress_record *r, const char *network, const char *method, const sp_dos *d, const exact *x) {
    double error = 0, reported = 0, ratio = -1, before = (double)(d->zero.total - d->zero.rattlers);
    for (int b = 0; b < d->bins; b++) {
        const double below = exact_below(x, d->edge[b + 1]), width = d->edge[b + 1] - d->edge[b];
        const double off[] = {fabs(d->cumulative[b] + (double)(d->zero.total - d->zero.rattlers) - below),
                              fabs(d->density[b] * width - (below - before))},
                     bound[] = {d->cumulative_error[b], d->density_error[b] * width + 1e-12 * x->n};
        for (int q = 0; q < 2; q++) {
            const double here = off[q] > 0 ? off[q] / bound[q] : 0; /* infinite without a bound */
            if (!(here <= ratio)) {
                ratio = here;
                error = off[q];
                reported = bound[q];
            }
        }
        before = below;
    }
    stress_agree(r, network, method, "histogram", error, reported, x->n);
}

/* T_k of twice the angle psi, sin(psi) = omega/Omega, from the square of the sine. */
static void chebyshev(int64_t moments, quad square, quad *t) {
    const quad c = 1 - 2 * square;
    t[0] = 1;
    t[1] = c;
    for (int64_t k = 2; k < moments; k++)
        t[k] = 2 * c * t[k - 1] - t[k - 2];
}

/* The smooth density at the middle of each bin; zero: with the zero modes. */
static void exact_smooth(const exact *x, const sp_dos *d, bool zero, double *out) {
    const size_t n = (size_t)d->moments;
    RELEASED double *g = calloc(n, sizeof *g);
    RELEASED quad *t = calloc(n, sizeof *t), *mu = calloc(n, sizeof *mu);
    const quad omega = d->omega_max;
    sp_moments_jackson(d->moments, g);
    for (int m = zero ? 0 : (int)(d->zero.total - d->zero.rattlers); m < x->n; m++) {
        chebyshev(d->moments, x->lambda[m] / (omega * omega), t);
        for (size_t k = 0; k < n; k++)
            mu[k] += t[k];
    }
    for (int b = 0; b < d->bins; b++) {
        const quad s = (quad)(0.5 * (d->edge[b] + d->edge[b + 1])) / omega;
        quad sum = g[0] * mu[0];
        chebyshev(d->moments, s * s, t);
        for (size_t k = 1; k < n; k++)
            sum += 2 * g[k] * mu[k] * t[k];
        out[b] = (double)(4 * sum / (quad_turn() * omega * quad_sqrt(1 - s * s)));
    }
}

static void compare_smooth(stress_record *r, const char *network, const sp_dos *d, const exact *x) {
    double right[BINS], error = 0, reported = 1, largest = 0;
    exact_smooth(x, d, false, right);
    for (int b = 0; b < d->bins; b++) {
        const double off = fabs(d->smooth[b] - right[b]);
        largest = fmax(largest, right[b]);
        if (!(off / d->smooth_error[b] <= error / reported)) {
            error = off;
            reported = d->smooth_error[b];
        }
    }
    stress_agree(r, network, "exact", "smooth", error, reported, largest);
}

/* How often the density of random vectors is within one and three of its standard errors. */
typedef struct hits {
    int compared, one, three;
} hits;

static void compare_random(const sp_dos *d, const exact *x, hits *h) {
    double right[BINS], largest = 0;
    exact_smooth(x, d, true, right);
    for (int b = 0; b < d->bins; b++)
        largest = fmax(largest, right[b]);
    for (int b = 0; b < d->bins; b++) {
        const double off = fabs(d->smooth[b] - right[b]) - 1e-9 * largest; /* rounding is no matter of chance */
        h->compared++;
        h->one += off <= d->smooth_error[b];
        h->three += off <= 3 * d->smooth_error[b];
    }
}

static sp_status run_one(stress_record *r, const char *network, const sp_network *net, sp_dos_method method,
                         const char *name, sp_dos *d) {
    sp_dos_options o = sp_dos_options_default();
    sp_error err = {0};
    o.method = method;
    o.norm = SP_DOS_MODES;
    o.bins = BINS;
    o.vectors = method == SP_DOS_COUNT ? 2 : 0;
    const sp_status status = sp_dos_make(net, &o, d, &err);
    if (status != SP_OK)
        stress_refuse(r, network, name, "density", status, &err);
    return status;
}

static void run(stress_record *r, const char *network, const sp_network *net, hits *h) {
    static const sp_dos_method methods[] = {SP_DOS_EXACT, SP_DOS_COUNT, SP_DOS_KPM};
    static const char *const names[] = {"exact", "count", "kpm"};
    FREED(exact) x = exact_solve(net);
    for (int q = 0; q < 3; q++) {
        FREED(sp_dos) d = sp_dos_none();
        if (run_one(r, network, net, methods[q], names[q], &d) != SP_OK)
            continue;
        if (methods[q] == SP_DOS_KPM)
            compare_random(&d, &x, h);
        else
            compare_counts(r, network, names[q], &d, &x);
        if (methods[q] == SP_DOS_EXACT)
            compare_smooth(r, network, &d, &x);
    }
}

TEST(test_hard_networks) {
    if (!STRESS_QUAD)
        skip();
    stress_record r = stress_open();
    hits h = {0};
    for (int k = 0; k < STRESS_CASES; k += EVERY) {
        FREED(sp_network) net = stress_cases[k].make(stress_cases[k].value, 1);
        run(&r, stress_cases[k].name, &net, &h);
    }
    stress_close(&r);
    print_message("random vectors: %d densities, %.3f within one standard error, %.3f within three\n", h.compared,
                  (double)h.one / h.compared, (double)h.three / h.compared);
    assert_true(r.agreed > 20 && h.compared > 300);
    assert_int_equal(r.wrong, 0);
    /* 0.68 and 0.997 for independent values; those of one network are not */
    assert_true(h.one > 0.55 * h.compared && h.one < 0.85 * h.compared);
    assert_true(h.three > 0.97 * h.compared);
}

RUN_TESTS(NULL, NULL)
