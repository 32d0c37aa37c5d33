/* Tables of a column: trajectories, states and energies of each tap, and the comparison of models. */
#include "tapped/tapped_table.h"
#include "base/base.h"
#include "tapped/column.h"

#include <stdio.h>
#include <string.h>

/* A table under construction. */
typedef struct maker {
    const sp_tapped_spec *c;
    sp_tapped_watcher watcher;
    sp_table *t;
    int64_t n;            /* number of times at which the run writes rows */
    double *time, *cells; /* [n]; the values of one row */
    int64_t seen;         /* rows written so far */
    double begin, share;  /* progress: part of the work before this run; share of this run */
} maker;

/* Counts a row and reports the progress. */
static sp_status count_row(maker *m, sp_error *err) {
    m->seen++;
    const double share = m->begin + m->share * (double)m->seen / (double)m->n;
    if (m->watcher.watch && !m->watcher.watch(share, m->watcher.user))
        return sp_fail(err, SP_EINTERRUPTED, "stopped at row %lld of %lld: nothing is written", (long long)m->seen,
                       (long long)m->n);
    return SP_OK;
}

static sp_status add_cells(maker *m, sp_error *err) {
    const sp_status status = sp_table_add_numbers(m->t, m->cells, err);
    return status == SP_OK ? count_row(m, err) : status;
}

/* ---- size and times --------------------------------------------------------------------------------------------- */

/* A value takes up to two cells of 8 bytes, because the capacity for rows doubles, and up to 24 characters of text. */
static const double bytes_a_value = 40;

static sp_status check_size(const sp_tapped_spec *c, double rows, double columns, sp_error *err) {
    const double bytes = bytes_a_value * rows * columns + (double)sizeof(sp_tapped_tap) * c->taps,
                 most = 0.5 * sp_memory_limit();
    if (bytes <= most)
        return SP_OK;
    return sp_fail(err, SP_ENOMEM,
                   "column.%s: %.6g rows of %.0f columns need about %.3g GB, the limit is %.3g GB: use a longer "
                   "column.step, fewer column.taps or fewer column.particles",
                   c->output == SP_TAPPED_STROBE || c->output == SP_TAPPED_ENERGY ? "taps" : "step", rows, columns,
                   1e-9 * bytes, 1e-9 * most);
}

static sp_status make_times(maker *m, double rows, double columns, sp_error *err) {
    sp_status status = check_size(m->c, rows, columns, err);
    if (status != SP_OK)
        return status;
    m->n = (int64_t)rows;
    m->time = sp_alloc((size_t)m->n, sizeof *m->time);
    return m->time ? SP_OK : sp_fail_memory(err, (size_t)m->n * sizeof *m->time);
}

/* Multiples of the step, up to the end of the last tap. */
static sp_status step_times(maker *m, double columns, sp_error *err) {
    const sp_tapped_spec *c = m->c;
    const double end = c->taps * c->period, step = c->step > 0 ? c->step : 0.01 * c->period;
    const sp_status status = make_times(m, floor(end / step * (1 + 1e-12)) + 1, columns, err);
    for (int64_t k = 0; k < m->n && status == SP_OK; k++)
        m->time[k] = fmin((double)k * step, end);
    return status;
}

/* .99T, 1.99T, ... */
static sp_status strobe_times(maker *m, double columns, sp_error *err) {
    const sp_status status = make_times(m, m->c->taps, columns, err);
    for (int64_t k = 0; k < m->n && status == SP_OK; k++)
        m->time[k] = ((double)k + 0.99) * m->c->period;
    return status;
}

/* ---- columns ---------------------------------------------------------------------------------------------------- */

/* One column, or with `each` the columns name<first> .. name<N>. */
typedef struct heading {
    const char *name, *unit;
    sp_column_kind kind;
    bool each;
    int32_t first;
} heading;

static sp_status add_headings(maker *m, size_t n, const heading *of, sp_error *err) {
    sp_status status = SP_OK;
    for (size_t k = 0; k < n && status == SP_OK; k++)
        status = of[k].each ? sp_tapped_add_particles(m->c, of[k].name, of[k].first, of[k].unit, m->t, err)
                            : sp_table_add_column(m->t, of[k].name, of[k].unit, of[k].kind, err);
    if (status != SP_OK)
        return status;
    m->cells = sp_alloc((size_t)m->t->columns, sizeof *m->cells);
    return m->cells ? SP_OK : sp_fail_memory(err, (size_t)m->t->columns * sizeof *m->cells);
}

/* ---- rows of a run ---------------------------------------------------------------------------------------------- */

static sp_status run(maker *m, sp_tapped_row row, sp_error *err) {
    sp_tapped_report report = {0};
    sp_status status = sp_tapped_run(m->c, m->n, m->time, row, m, &report, err);
    if (status == SP_OK)
        status = sp_tapped_comment_report(m->c, &report, m->t, err);
    sp_tapped_report_free(&report);
    return status;
}

static sp_status trajectory_row(double t, const double *y, const double *v, void *user, sp_error *err) {
    maker *m = user;
    (void)v;
    m->cells[0] = t;
    memcpy(m->cells + 1, y, ((size_t)m->c->particles + 1) * sizeof *y);
    return add_cells(m, err);
}

static sp_status trajectory(maker *m, sp_error *err) {
    static const heading headings[] = {{"t", "s", SP_COLUMN_NUMBER, false, 0}, {"y", "cm", SP_COLUMN_NUMBER, true, 0}};
    sp_status status = step_times(m, m->c->particles + 2.0, err);
    if (status == SP_OK)
        status = add_headings(m, sizeof headings / sizeof *headings, headings, err);
    return status == SP_OK ? run(m, trajectory_row, err) : status;
}

static sp_status strobe_row(double t, const double *y, const double *v, void *user, sp_error *err) {
    maker *m = user;
    const size_t n = (size_t)m->c->particles;
    (void)v;
    m->cells[0] = (double)(m->seen + 1);
    m->cells[1] = t;
    memcpy(m->cells + 2, y + 1, n * sizeof *y);
    m->cells[n + 2] = sp_tapped_density(m->c, y);
    return add_cells(m, err);
}

/* The density before the first tap, for comparison with those after taps. */
static sp_status comment_initial_density(maker *m, sp_error *err) {
    const size_t n = (size_t)m->c->particles;
    sp_tapped_state s;
    sp_status status = sp_tapped_state_make(m->c, &s, err);
    if (status != SP_OK)
        return status;
    double *y = sp_alloc(2 * n + 1, sizeof *y);
    if (y) {
        sp_tapped_positions(m->c, &s, y + 1, y + 1 + n);
        status = sp_table_add_comment(m->t, err, "initial_density = %.17g", sp_tapped_density(m->c, y));
    } else
        status = sp_fail_memory(err, (2 * n + 1) * sizeof *y);
    sp_free(y);
    sp_tapped_state_free(&s);
    return status;
}

static sp_status strobe(maker *m, sp_error *err) {
    static const heading headings[] = {{"tap", "", SP_COLUMN_INTEGER, false, 0},
                                       {"t", "s", SP_COLUMN_NUMBER, false, 0},
                                       {"y", "cm", SP_COLUMN_NUMBER, true, 1},
                                       {"density", "g/cm", SP_COLUMN_NUMBER, false, 0}};
    sp_status status = strobe_times(m, m->c->particles + 3.0, err);
    if (status == SP_OK)
        status = add_headings(m, sizeof headings / sizeof *headings, headings, err);
    if (status == SP_OK)
        status = comment_initial_density(m, err);
    return status == SP_OK ? run(m, strobe_row, err) : status;
}

static sp_status density_row(double t, const double *y, const double *rho, void *user, sp_error *err) {
    maker *m = user;
    const size_t n = (size_t)m->c->particles;
    m->cells[0] = t;
    memcpy(m->cells + 1, y + 1, n * sizeof *y);
    memcpy(m->cells + 1 + n, rho, n * sizeof *rho);
    return add_cells(m, err);
}

static sp_status density(maker *m, sp_error *err) {
    static const heading headings[] = {{"t", "s", SP_COLUMN_NUMBER, false, 0},
                                       {"y", "cm", SP_COLUMN_NUMBER, true, 1},
                                       {"rho", "g/cm", SP_COLUMN_NUMBER, true, 1}};
    sp_status status = step_times(m, 2.0 * m->c->particles + 1, err);
    if (status == SP_OK)
        status = add_headings(m, sizeof headings / sizeof *headings, headings, err);
    return status == SP_OK ? sp_tapped_run_density(m->c, m->n, m->time, density_row, m, err) : status;
}

/* ---- energies of the taps --------------------------------------------------------------------------------------- */

static sp_status energy_row(double t, const double *y, const double *v, void *user, sp_error *err) {
    (void)t, (void)y, (void)v;
    return count_row(user, err);
}

static sp_status energy_rows(maker *m, const sp_tapped_report *r, sp_error *err) {
    sp_status status = sp_tapped_comment_report(m->c, r, m->t, err);
    char number[SP_NUMBER_TEXT];
    if (status == SP_OK)
        status = sp_table_add_comment(m->t, err, "initial_energy = %s", sp_number_text(r->initial_energy, number));
    for (int32_t k = 0; k < r->taps && status == SP_OK; k++) {
        const sp_tapped_tap *tap = &r->tap[k];
        status = sp_table_add_row(m->t, err, (int64_t)k + 1, tap->work, tap->dissipated, tap->energy, tap->residual,
                                  tap->rest, tap->separation, tap->at, (int64_t)tap->contact);
    }
    return status;
}

static sp_status energy(maker *m, sp_error *err) {
    static const heading headings[] = {
        {"tap", "", SP_COLUMN_INTEGER, false, 0},          {"work", "erg", SP_COLUMN_NUMBER, false, 0},
        {"dissipated", "erg", SP_COLUMN_NUMBER, false, 0}, {"energy", "erg", SP_COLUMN_NUMBER, false, 0},
        {"residual", "", SP_COLUMN_NUMBER, false, 0},      {"rest", "s", SP_COLUMN_NUMBER, false, 0},
        {"separation", "cm", SP_COLUMN_NUMBER, false, 0},  {"separation_time", "s", SP_COLUMN_NUMBER, false, 0},
        {"contact", "", SP_COLUMN_INTEGER, false, 0}};
    if (m->c->model != SP_TAPPED_LATTICE)
        return sp_fail_key(err, SP_EINVAL, "column.output",
                           " = \"energy\": column.model must be \"lattice\": the continua have no energy "
                           "balance of contacts");
    sp_tapped_report report = {0};
    sp_status status = strobe_times(m, 9, err);
    if (status == SP_OK)
        status = add_headings(m, sizeof headings / sizeof *headings, headings, err);
    if (status == SP_OK)
        status = sp_tapped_run(m->c, m->n, m->time, energy_row, m, &report, err);
    if (status == SP_OK)
        status = energy_rows(m, &report, err);
    sp_tapped_report_free(&report);
    return status;
}

/* ---- comparison of the models ----------------------------------------------------------------------------------- */

enum { LONGWAVE, BSR, CONTINUA };

typedef struct comparison {
    maker *m;
    double *lattice;                         /* [n][N] */
    double *mean[CONTINUA], *most[CONTINUA]; /* [n] */
    int which;                               /* index of the current model */
} comparison;

static sp_status lattice_row(double t, const double *y, const double *v, void *user, sp_error *err) {
    comparison *k = user;
    const size_t n = (size_t)k->m->c->particles;
    (void)t, (void)v;
    memcpy(k->lattice + (size_t)k->m->seen * n, y + 1, n * sizeof *y);
    return count_row(k->m, err);
}

static sp_status continuum_row(double t, const double *y, const double *v, void *user, sp_error *err) {
    comparison *k = user;
    const size_t n = (size_t)k->m->c->particles, row = (size_t)k->m->seen;
    double sum = 0, most = 0;
    (void)t, (void)v;
    for (size_t i = 0; i < n; i++) {
        const double difference = fabs(y[i + 1] - k->lattice[row * n + i]);
        sum += difference;
        most = fmax(most, difference);
    }
    k->mean[k->which][row] = sum / (double)n;
    k->most[k->which][row] = most;
    return count_row(k->m, err);
}

/* Runs the three models, each of which counts as a third of the work. */
static sp_status run_models(comparison *k, sp_error *err) {
    static const char *const names[] = {"longwave", "bsr"};
    maker *m = k->m;
    sp_tapped_spec c = *m->c;
    sp_tapped_report report = {0};
    c.model = SP_TAPPED_LATTICE;
    c.bsr = SP_TAPPED_BSR_CONSERVATIVE;
    m->share = 1.0 / 3;
    sp_status status = sp_tapped_run(&c, m->n, m->time, lattice_row, k, &report, err);
    if (status == SP_OK)
        status = sp_tapped_comment_report(&c, &report, m->t, err);
    sp_tapped_report_free(&report);
    for (k->which = 0; k->which < CONTINUA && status == SP_OK; k->which++) {
        m->begin += m->share;
        m->seen = 0;
        c.model = k->which == LONGWAVE ? SP_TAPPED_LONGWAVE : SP_TAPPED_BSR;
        status = sp_tapped_run(&c, m->n, m->time, continuum_row, k, &report, err);
        if (status == SP_OK && report.time_step > 0)
            status = sp_table_add_comment(m->t, err, "time_step_%s = %.17g", names[k->which], report.time_step);
        sp_tapped_report_free(&report);
    }
    return status;
}

/* Summary over time: the mean of the means, or the largest of the maxima. */
static sp_status add_summary(const comparison *k, const char *name, const double *values, sp_error *err) {
    double sum = 0, most = 0;
    for (int64_t row = 0; row < k->m->n; row++) {
        sum += values[row];
        most = fmax(most, values[row]);
    }
    const bool largest = strncmp(name, "max_", 4) == 0;
    return sp_table_add_comment(k->m->t, err, "%s over time = %.17g", name, largest ? most : sum / (double)k->m->n);
}

static sp_status comparison_rows(const comparison *k, sp_error *err) {
    static const char *const names[] = {"mean_longwave", "max_longwave", "mean_bsr", "max_bsr"};
    const double *const columns[] = {k->mean[LONGWAVE], k->most[LONGWAVE], k->mean[BSR], k->most[BSR]};
    sp_status status = sp_table_add_comment(
        k->m->t, err, "mean and largest |y_i - y_i of the lattice| over the particles, at equal times");
    if (status == SP_OK)
        status = sp_table_add_column(k->m->t, "t", "s", SP_COLUMN_NUMBER, err);
    for (int j = 0; j < 4 && status == SP_OK; j++)
        status = sp_table_add_column(k->m->t, names[j], "cm", SP_COLUMN_NUMBER, err);
    for (int j = 0; j < 4 && status == SP_OK; j++)
        status = add_summary(k, names[j], columns[j], err);
    for (int64_t row = 0; row < k->m->n && status == SP_OK; row++)
        status = sp_table_add_row(k->m->t, err, k->m->time[row], columns[0][row], columns[1][row], columns[2][row],
                                  columns[3][row]);
    return status;
}

static sp_status compare(maker *m, sp_error *err) {
    comparison k = {.m = m};
    sp_status status = step_times(m, m->c->particles + 5.0, err);
    if (status != SP_OK)
        return status;
    const size_t rows = (size_t)m->n, n = (size_t)m->c->particles;
    k.lattice = sp_alloc(rows * (n + 2 * CONTINUA), sizeof *k.lattice);
    if (!k.lattice)
        return sp_fail_memory(err, rows * (n + 2 * CONTINUA) * sizeof *k.lattice);
    for (int w = 0; w < CONTINUA; w++) {
        k.mean[w] = k.lattice + rows * (n + 2 * (size_t)w);
        k.most[w] = k.mean[w] + rows;
    }
    status = run_models(&k, err);
    if (status == SP_OK)
        status = comparison_rows(&k, err);
    sp_free(k.lattice);
    return status;
}

/* ---- the whole -------------------------------------------------------------------------------------------------- */

static bool is_diagram(const sp_tapped_spec *c) {
    return c->output == SP_TAPPED_LYAPUNOV || c->output == SP_TAPPED_BIFURCATION;
}

static sp_status add_comments(const maker *m, sp_error *err) {
    sp_status status = sp_tapped_comment_spec(m->c, m->t, err);
    return status == SP_OK ? sp_tapped_comment_model(m->c, m->t, err) : status;
}

static sp_status diagram(maker *m, int threads, sp_error *err) {
    if (m->c->model != SP_TAPPED_LATTICE || m->c->method != SP_TAPPED_EVENT)
        return sp_fail_key(err, SP_EINVAL, "column.output",
                           " = \"%s\": column.model must be \"lattice\" and column.method \"event\": only "
                           "these provide the map from tap to tap and its derivative",
                           m->c->output == SP_TAPPED_LYAPUNOV ? "lyapunov" : "bifurcation");
    sp_status status = sp_tapped_diagram(m->c, threads, m->watcher, m->t, err);
    return status == SP_OK ? add_comments(m, err) : status;
}

static sp_status make(maker *m, sp_error *err) {
    sp_status status = add_comments(m, err);
    if (status != SP_OK)
        return status;
    switch (m->c->output) {
    case SP_TAPPED_STROBE: return strobe(m, err);
    case SP_TAPPED_ENERGY: return energy(m, err);
    case SP_TAPPED_DENSITY: return density(m, err);
    case SP_TAPPED_COMPARE: return compare(m, err);
    default: return trajectory(m, err);
    }
}

sp_status sp_tapped_table_watched(const sp_tapped_spec *c, int threads, sp_tapped_watcher watcher, sp_table *out,
                                  sp_error *err) {
    sp_table t = sp_table_none();
    sp_tapped_spec own = *c;
    own.taps = sp_tapped_taps(c);
    maker m = {.c = &own, .watcher = watcher, .t = &t, .share = 1};
    sp_status status = sp_tapped_check(c, err);
    if (status == SP_OK)
        status = is_diagram(c) ? diagram(&m, threads, err) : make(&m, err);
    if (status == SP_OK)
        *out = t;
    else
        sp_table_free(&t);
    sp_free(m.time);
    sp_free(m.cells);
    return status;
}

sp_status sp_tapped_table(const sp_tapped_spec *c, int threads, sp_table *out, sp_error *err) {
    return sp_tapped_table_watched(c, threads, (sp_tapped_watcher){NULL, NULL}, out, err);
}
