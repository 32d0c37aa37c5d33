/* The scattered ones of the hard networks again, some 240 degrees of freedom large: the sparse solver against the dense
 * one, whose frequencies hold against quadruple precision, and signals against the recurrence in long double. */
#include "extended.h"
#include "stress/networks.h"
#include "stress/record.h"

#include <sonopack/modes.h>

enum { CELLS = 9, POINTS = 31 };

static sp_status dense_of(const sp_network *net, bool vectors, sp_modes *m, sp_error *err) {
    const sp_modes_options o = {.vectors = vectors, .source = SP_SOURCE_IMPULSE};
    return sp_modes_dense(net, &o, m, err);
}

/* The worst row stands for all. */
static void compare_modes(stress_record *r, const char *network, const char *method, const char *what,
                          const sp_modes *s, const sp_modes *d) {
    double ratio = -1, error = 0, reported = 1;
    for (int64_t k = 0; k < s->n; k++) {
        const int64_t row = s->first + k;
        const double off = fabs(s->omega[k] - d->omega[row]), bound = s->error[k] + d->error[row];
        if (!(off <= ratio * bound)) {
            ratio = off / bound;
            error = off;
            reported = bound;
        }
    }
    stress_agree(r, network, method, what, error, reported, d->omega[d->n - 1]);
}

static bool has_walls(const sp_network *net) {
    RELEASED double *scratch = calloc((size_t)sp_network_dofs(net), sizeof *scratch);
    sp_error err = {0};
    const bool walls = sp_network_source(net, SP_SOURCE_IMPULSE, scratch, &err) == SP_OK &&
                       sp_network_detector(net, scratch, &err) == SP_OK;
    return walls;
}

/* Frequencies alone take another reduction, and the soft ones another solver, than those with vectors. */
static void compare_dense(stress_record *r, const char *network, const sp_network *net, const sp_modes *d) {
    FREED(sp_modes) v = sp_modes_none();
    sp_error err = {0};
    if (!has_walls(net))
        return;
    const sp_status status = dense_of(net, true, &v, &err);
    if (status == SP_OK)
        compare_modes(r, network, "dense", "frequencies", d, &v);
    else
        stress_refuse(r, network, "dense", "vectors", status, &err);
}

static void run_modes(stress_record *r, const char *network, const sp_network *net) {
    const sp_modes_options o = {.vectors = false, .source = SP_SOURCE_IMPULSE};
    FREED(sp_modes) d = sp_modes_none();
    sp_error err = {0};
    sp_status status = dense_of(net, false, &d, &err);
    if (status != SP_OK) {
        stress_refuse(r, network, "dense", "all", status, &err);
        return;
    }
    compare_dense(r, network, net, &d);
    const int64_t n = d.n - d.n_rattler;
    const double *omega = d.omega + d.n_rattler, gap = 1e-4 * omega[n - 1];
    int64_t low = n / 3, high = n / 2;
    while (low < n - 2 && !(omega[low - 1] > 0 && omega[low] - omega[low - 1] > gap))
        low++;
    high = high > low ? high : low + 1;
    while (high < n - 1 && omega[high] - omega[high - 1] <= gap)
        high++;
    const struct {
        const char *name;
        sp_modes_range range;
    } parts[] = {{"all", sp_modes_range_all()},
                 {"lowest 40", sp_modes_range_lowest(40)},
                 {"band", sp_modes_range_band((omega[low - 1] + omega[low]) / 2, (omega[high - 1] + omega[high]) / 2)}};
    for (int q = 0; q < 3; q++) {
        FREED(sp_modes) m = sp_modes_none();
        status = sp_modes_sparse(net, &o, &parts[q].range, &m, &err);
        if (status != SP_OK)
            stress_refuse(r, network, "sparse", parts[q].name, status, &err);
        else
            compare_modes(r, network, "sparse", parts[q].name, &m, &d);
        if (status == SP_OK && q == 0)
            stress_agree(r, network, "sparse", "count", fabs((double)(m.n - d.n)), 0, 1);
        if (status == SP_OK && q == 2) /* the limits are far from modes, or a mode on the edge is told */
            stress_agree(r, network, "sparse", "count", fabs((double)(m.n - (high - low))), (double)m.on_edge, 1);
    }
}

static void run_signals(stress_record *r, const char *network, const sp_network *net, double length, double tolerance) {
    double t[POINTS], f[POINTS], peak = 0;
    sp_signal_options o = sp_signal_options_default();
    sp_error err = {0};
    char what[64];
    if (!has_walls(net))
        return;
    snprintf(what, sizeof what, "impulse, T = %.0e, tolerance %.0e", length, tolerance);
    o.until = length / net->omega_bound;
    o.points = POINTS;
    o.tolerance = tolerance;
    for (int l = 0; l < POINTS; l++)
        t[l] = l < POINTS - 1 ? o.until * l / (POINTS - 1) : o.until;
    extended_signal(net, SP_SOURCE_IMPULSE, POINTS, t, f);
    for (int l = 0; l < POINTS; l++)
        peak = fmax(peak, fabs(f[l]));
    static const sp_signal_method all[] = {SP_SIGNAL_AUTO,   SP_SIGNAL_CHEBYSHEV, SP_SIGNAL_DENSE,
                                           SP_SIGNAL_SPARSE, SP_SIGNAL_FABER,     SP_SIGNAL_LAX_WENDROFF};
    for (size_t q = 0; q < sizeof all / sizeof *all; q++) {
        FREED(sp_signal) s = sp_signal_none();
        double worst = 0;
        o.method = all[q];
        if ((o.method == SP_SIGNAL_LAX_WENDROFF || o.method == SP_SIGNAL_SPARSE) && tolerance < 1e-6)
            continue; /* once is enough of what takes long */
        const sp_status status = sp_signal_make(net, &o, &s, &err);
        if (status != SP_OK) {
            stress_refuse(r, network, sp_signal_method_name(o.method), what, status, &err);
            continue;
        }
        for (int l = 0; l < POINTS; l++)
            worst = fmax(worst, fabs(s.f[l] - f[l]));
        stress_agree(r, network, sp_signal_method_name(s.method), what, worst, s.errors[0], peak > 0 ? peak : 1);
    }
}

/* Those whose motion grows are left to the small networks. */
static bool chosen(const stress_case *c) {
    return c->make != stress_unstable && c->make != stress_slowly_unstable && c->make != stress_chain &&
           c->make != stress_chains && c->make != stress_weak_link && c->make != stress_one_grain &&
           c->make != stress_pressure && c->make != stress_smooth && c->make != stress_prestressed &&
           c->make != stress_lattice && c->make != stress_scattered_prestress;
}

TEST(test_large) {
    stress_record r = stress_open();
    stress_cells = CELLS;
    for (int k = 0; k < STRESS_CASES; k++) {
        const stress_case *c = &stress_cases[k];
        char name[96];
        if (!chosen(c))
            continue;
        FREED(sp_network) net = c->make(c->value, 1);
        snprintf(name, sizeof name, "%s, %d dof", c->name, (int)sp_network_dofs(&net));
        run_modes(&r, name, &net);
        run_signals(&r, name, &net, 300, 1e-6);
        run_signals(&r, name, &net, 100, 1e-9);
    }
    stress_close(&r);
    assert_int_equal(r.wrong, 0);
}

RUN_TESTS(NULL, NULL)
