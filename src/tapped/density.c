/* Density along the column, by the definition of each model. */
#include "base/base.h"
#include "tapped/bsr.h"

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
static sp_status lattice_density(double t, const double *y, const double *v, void *user, sp_error *err) {
    const density_rows *to = user;
    const int32_t n = to->c->particles;
    double low = y[0];
    (void)v;
    for (int32_t i = 1; i <= n; i++) {
        double radius = sp_tapped_radius(to->c, i), high = y[i] + radius;
        if (i < n)
            high = y[i] + (y[i + 1] - y[i]) * radius / (radius + sp_tapped_radius(to->c, i + 1));
        to->rho[i - 1] = high > low ? sp_tapped_mass(to->c, i) / (high - low) : NAN;
        low = high;
    }
    return to->row(t, y, to->rho, to->user, err);
}

/* Long wave: rho = m/(h y_z), (41) along a label, with second-order differences for y_z. A single particle has no y_z
 * and gets m/h. */
static sp_status longwave_density(double t, const double *y, const double *v, void *user, sp_error *err) {
    const density_rows *to = user;
    const int32_t n = to->c->particles;
    (void)v;
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
    return to->row(t, y, to->rho, to->user, err);
}

static sp_status bsr_density(double t, const double *y, const double *v, const double *rho, void *user, sp_error *err) {
    const density_rows *to = user;
    (void)v;
    return to->row(t, y, rho, to->user, err);
}

/* The BSR models write densities with their rows. This function repeats the checks of sp_tapped_run. */
static sp_status run_bsr(const sp_tapped_spec *c, int64_t n, const double *t, density_rows *to, sp_error *err) {
    const sp_tapped_bsr_rows rows = {n, t, bsr_density, to};
    sp_tapped_report report = {0};
    sp_status status = sp_tapped_check_times(c, n, t, err);
    if (status == SP_OK)
        status = sp_tapped_report_make(c, &report, err);
    if (status == SP_OK)
        status = sp_tapped_run_bsr_rows(c, &rows, &report, err);
    sp_tapped_report_free(&report);
    return status;
}

sp_status sp_tapped_run_density(const sp_tapped_spec *spec, int64_t n, const double *t, sp_tapped_density_row row,
                                void *user, sp_error *err) {
    sp_tapped_spec own = *spec, *c = &own;
    own.taps = sp_tapped_taps(spec);
    density_rows to = {.c = c, .row = row, .user = user};
    sp_status status = sp_tapped_check(c, err);
    if (status != SP_OK)
        return status;
    if (c->model == SP_TAPPED_BSR)
        return run_bsr(c, n, t, &to, err);
    to.rho = sp_alloc((size_t)c->particles, sizeof *to.rho);
    if (!to.rho)
        return sp_fail_memory(err, (size_t)c->particles * sizeof *to.rho);
    status =
        sp_tapped_run(c, n, t, c->model == SP_TAPPED_LONGWAVE ? longwave_density : lattice_density, &to, NULL, err);
    sp_free(to.rho);
    return status;
}
