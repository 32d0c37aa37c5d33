/* Runs a column with the model that its specification names: positions, velocities, densities and the report. */
#include "base/base.h"
#include "tapped/bsr.h"

static sp_status check_times(const sp_tapped_spec *c, int64_t n, const double *t, sp_error *err) {
    double last = c->taps * c->period, end = last * (1 + 1e-12);
    for (int64_t i = 0; i < n; i++)
        if (!(t[i] >= (i > 0 ? t[i - 1] : 0) && t[i] <= end))
            return sp_fail(err, SP_EINVAL, "time %lld, %.17g s: must be ascending, from 0 to %.17g s", (long long)i + 1,
                           t[i], last);
    return SP_OK;
}

/* ---- runs ------------------------------------------------------------------------------------------------------- */

static sp_tapped_solver *solver_of(const sp_tapped_spec *c) {
    switch (c->model) {
    case SP_TAPPED_LATTICE: return c->method == SP_TAPPED_EVENT ? sp_tapped_run_events : sp_tapped_run_ode;
    case SP_TAPPED_LONGWAVE: return sp_tapped_run_longwave;
    case SP_TAPPED_BSR: return c->bsr == SP_TAPPED_BSR_CONSERVATIVE ? sp_tapped_conservative : sp_tapped_literal;
    case SP_TAPPED_EQ35:
    case SP_TAPPED_EQ37: break;
    }
    return sp_tapped_refuse_printed;
}

/* A report with one entry for each of c->taps, as a solver expects it. */
static sp_status report_make(const sp_tapped_spec *c, sp_tapped_report *r, sp_error *err) {
    *r = (sp_tapped_report){.violated_at = NAN, .violated = -1};
    r->tap = sp_alloc((size_t)c->taps, sizeof *r->tap);
    if (!r->tap)
        return sp_fail_memory(err, (size_t)c->taps * sizeof *r->tap);
    r->taps = c->taps;
    for (int32_t k = 0; k < c->taps; k++)
        r->tap[k] = (sp_tapped_tap){.rest = NAN, .separation = INFINITY, .at = NAN};
    return SP_OK;
}

void sp_tapped_report_free(sp_tapped_report *r) {
    sp_free(r->tap);
    *r = (sp_tapped_report){.violated_at = NAN, .violated = -1};
}

static sp_status run(const sp_tapped_spec *spec, const sp_tapped_rows *rows, sp_tapped_report *report, sp_error *err) {
    sp_tapped_report made = {0};
    sp_tapped_spec own = *spec, *c = &own;
    own.taps = sp_tapped_taps(spec);
    sp_status status = sp_tapped_check(c, err);
    if (status == SP_OK)
        status = check_times(c, rows->n, rows->t, err);
    if (status == SP_OK)
        status = report_make(c, &made, err);
    if (status == SP_OK)
        status = solver_of(c)(c, rows, &made, err);
    if (status == SP_OK && report)
        *report = made;
    else
        sp_tapped_report_free(&made);
    return status;
}

typedef struct plain_rows {
    sp_tapped_row row;
    void *user;
} plain_rows;

static sp_status plain_row(double t, const double *y, const double *v, const double *rho, void *user, sp_error *err) {
    const plain_rows *to = user;
    (void)rho;
    return to->row(t, y, v, to->user, err);
}

sp_status sp_tapped_run(const sp_tapped_spec *c, int64_t n, const double *t, sp_tapped_row row, void *user,
                        sp_tapped_report *report, sp_error *err) {
    plain_rows to = {row, user};
    const sp_tapped_rows rows = {n, t, plain_row, &to};
    return run(c, &rows, report, err);
}

/* ---- density along the column, by the definition of each model -------------------------------------------------- */

typedef struct density_rows {
    const sp_tapped_spec *c;
    double *rho;
    sp_tapped_density_row row;
    void *user;
} density_rows;

/* Lattice: mass over the length that belongs to a particle. Neighbours share their distance in proportion to their
 * radii. The lowest particle has all the length down to the floor, the highest one radius upwards. The sum of rho times
 * length is then the mass of the column, and a column that just touches has m/2r everywhere, (42). Where neighbours
 * have passed each other the density is NAN. */
static void lattice_density(const density_rows *to, const double *y) {
    const int32_t n = to->c->particles;
    double low = y[0];
    for (int32_t i = 1; i <= n; i++) {
        double radius = sp_tapped_radius(to->c, i), high = y[i] + radius;
        if (i < n)
            high = y[i] + (y[i + 1] - y[i]) * radius / (radius + sp_tapped_radius(to->c, i + 1));
        to->rho[i - 1] = high > low ? sp_tapped_mass(to->c, i) / (high - low) : NAN;
        low = high;
    }
}

/* Long wave: rho = m/(h y_z), (41) along a label, with second-order differences for y_z. A single particle has no y_z
 * and gets m/h. */
static void longwave_density(const density_rows *to, const double *y) {
    const int32_t n = to->c->particles;
    for (int32_t i = 1; i <= n; i++) {
        double m = sp_tapped_mass(to->c, i), gap = 2 * sp_tapped_radius(to->c, i); /* h y_z */
        if (n == 2)
            gap = y[2] - y[1];
        else if (n > 2 && i == 1)
            gap = (4 * y[2] - 3 * y[1] - y[3]) / 2;
        else if (n > 2 && i == n)
            gap = (3 * y[n] - 4 * y[n - 1] + y[n - 2]) / 2;
        else if (n > 2)
            gap = (y[i + 1] - y[i - 1]) / 2;
        to->rho[i - 1] = gap > 0 ? m / gap : NAN;
    }
}

static sp_status density_row(double t, const double *y, const double *v, const double *rho, void *user, sp_error *err) {
    const density_rows *to = user;
    (void)v;
    if (!rho && to->c->model == SP_TAPPED_LONGWAVE)
        longwave_density(to, y);
    else if (!rho)
        lattice_density(to, y);
    return to->row(t, y, rho ? rho : to->rho, to->user, err);
}

sp_status sp_tapped_run_density(const sp_tapped_spec *c, int64_t n, const double *t, sp_tapped_density_row row,
                                void *user, sp_error *err) {
    density_rows to = {.c = c, .row = row, .user = user};
    const sp_tapped_rows rows = {n, t, density_row, &to};
    sp_status status = sp_tapped_check(c, err);
    if (status != SP_OK)
        return status;
    to.rho = sp_alloc((size_t)c->particles, sizeof *to.rho);
    status = to.rho ? run(c, &rows, NULL, err) : sp_fail_memory(err, (size_t)c->particles * sizeof *to.rho);
    sp_free(to.rho);
    return status;
}
