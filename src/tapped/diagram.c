/* Bifurcation and Lyapunov diagrams over a parameter, computed in parallel. Each point starts afresh, so that it
 * depends on its parameter alone. */
#include "base/base.h"
#include "base/pool.h"
#include "tapped/events.h"
#include "tapped/tapped_table.h"

#include <stdatomic.h>
#include <string.h>

static const char *const units[] = {"cm", "s", "Hz", ""};

typedef struct diagram {
    const sp_tapped_spec *c;
    sp_tapped_watcher watcher;
    int32_t points, rows_per_point; /* rows_per_point: rows of `values` numbers for each point */
    int32_t values;
    double *value;         /* [points][rows_per_point][values] */
    sp_status *status;     /* [points] */
    bool *violated;        /* [points]: whether ordering (1) was violated */
    sp_error *first_error; /* the first failure */
    atomic_int next, done, failed;
    atomic_bool stop;
} diagram;

static double *parameter_of(sp_tapped_spec *c) {
    return c->parameter == SP_TAPPED_BY_AMPLITUDE   ? &c->amplitude
           : c->parameter == SP_TAPPED_BY_PERIOD    ? &c->period
           : c->parameter == SP_TAPPED_BY_FREQUENCY ? &c->frequency
                                                    : &c->e;
}

static sp_tapped_spec spec_at(const sp_tapped_spec *c, int32_t point) {
    sp_tapped_spec own = *c;
    if (c->points > 1)
        *parameter_of(&own) = c->from + (c->to - c->from) * point / (c->points - 1);
    else if (c->from != 0)
        *parameter_of(&own) = c->from;
    return own;
}

static double parameter_at(const sp_tapped_spec *c, int32_t point) {
    sp_tapped_spec own = spec_at(c, point);
    return *parameter_of(&own);
}

/* Stores the positions at (k - 0.01) T. */
typedef struct recorder {
    int32_t n;
    double *to;
} recorder;

static sp_status record_row(double t, const double *y, const double *v, const double *rho, void *user, sp_error *err) {
    recorder *k = user;
    (void)t, (void)v, (void)rho, (void)err;
    memcpy(k->to, y + 1, (size_t)k->n * sizeof(double));
    k->to += k->n;
    return SP_OK;
}

static sp_status bifurcate(const sp_tapped_spec *c, double *value, bool *violated, sp_error *err) {
    sp_event_run r;
    recorder k = {c->particles, value};
    const double moment = 0.99 * c->period;
    const sp_tapped_rows rows = {1, &moment, record_row, &k};
    sp_status status = sp_event_run_make(c, 0, NULL, &r, err);
    if (status == SP_OK)
        sp_lattice_start(&r.l);
    for (int32_t i = 0; status == SP_OK && i < c->transient + c->taps; i++) {
        r.rows = i < c->transient ? NULL : &rows;
        r.next = 0;
        status = sp_event_run_tap(&r, 0, err);
    }
    *violated = r.report->violated >= 0;
    sp_event_run_free(&r);
    return status;
}

static sp_status make_point(diagram *d, int32_t point, sp_error *err) {
    sp_tapped_spec c = spec_at(d->c, point);
    double *value = d->value + (size_t)point * (size_t)d->rows_per_point * (size_t)d->values;
    if (c.output == SP_TAPPED_BIFURCATION)
        return bifurcate(&c, value, &d->violated[point], err);
    sp_tapped_exponent found;
    sp_status status = sp_tapped_lyapunov(&c, &found, err);
    if (status == SP_OK) {
        value[0] = found.lambda, value[1] = found.error, value[2] = found.cycle;
        d->violated[point] = found.violated;
    }
    return status;
}

static void work(void *data, int part, int parts) {
    diagram *d = data;
    (void)parts;
    for (int32_t point; !atomic_load(&d->stop) && (point = atomic_fetch_add(&d->next, 1)) < d->points;) {
        sp_error err = {0};
        d->status[point] = make_point(d, point, &err);
        if (d->status[point] == SP_EINTERRUPTED || d->status[point] == SP_ENOMEM) {
            atomic_store(&d->stop, true);
            return;
        }
        if (d->status[point] != SP_OK && atomic_fetch_add(&d->failed, 1) == 0)
            *d->first_error = err;
        int done = atomic_fetch_add(&d->done, 1) + 1;
        if (part == 0 && d->watcher.watch && !d->watcher.watch((double)done / d->points, d->watcher.user))
            atomic_store(&d->stop, true);
    }
}

static sp_status check_range(const sp_tapped_spec *c, sp_error *err) {
    const char *name = sp_tapped_parameter_name(c->parameter);
    if (c->points == 1 && c->to > c->from)
        return sp_fail_key(err, SP_EINVAL, "column.points",
                           " = 1: must be 2 or more to go from column.from to column.to");
    if (c->points > 1 && !(c->from < c->to))
        return sp_fail_key(err, SP_EINVAL, "column.to",
                           " = %.17g: must be above column.from = %.17g for %d points of column.%s", c->to, c->from,
                           c->points, name);
    for (int32_t end = 0; end < 2; end++) {
        sp_tapped_spec own = spec_at(c, end * (c->points - 1));
        sp_status status = sp_tapped_check(&own, err);
        if (status != SP_OK) {
            (void)sp_fail_prefix(err, "column.%s: %s = %.17g", end == 0 ? "from" : "to", name,
                                 parameter_at(c, end * (c->points - 1)));
            return status;
        }
    }
    return SP_OK;
}

static sp_status add_columns(const diagram *d, sp_table *t, sp_error *err) {
    const sp_tapped_spec *c = d->c;
    sp_status status = sp_table_add_column(t, "parameter", units[c->parameter], SP_COLUMN_NUMBER, err);
    if (c->output == SP_TAPPED_LYAPUNOV) {
        if (status == SP_OK)
            status = sp_table_add_column(t, "lambda", "1/tap", SP_COLUMN_NUMBER, err);
        if (status == SP_OK)
            status = sp_table_add_column(t, "error", "1/tap", SP_COLUMN_NUMBER, err);
        return status == SP_OK ? sp_table_add_column(t, "cycle", "taps", SP_COLUMN_INTEGER, err) : status;
    }
    if (status == SP_OK)
        status = sp_table_add_column(t, "tap", "", SP_COLUMN_INTEGER, err);
    return status == SP_OK ? sp_tapped_add_particles(c, "y", 1, "cm", t, err) : status;
}

static sp_status add_point(const diagram *d, int32_t point, double *row, sp_table *t, sp_error *err) {
    sp_status status = SP_OK;
    const double *value = d->value + (size_t)point * (size_t)d->rows_per_point * (size_t)d->values;
    bool made = d->status[point] == SP_OK, exponents = d->c->output == SP_TAPPED_LYAPUNOV;
    int32_t at = exponents ? 1 : 2;
    row[0] = parameter_at(d->c, point);
    for (int32_t k = 0; status == SP_OK && k < (made ? d->rows_per_point : 1); k++) {
        row[1] = d->c->transient + k + 1;
        for (int32_t i = 0; i < d->values; i++)
            row[at + i] = made ? value[k * d->values + i] : exponents && i == 2 ? 0 : NAN;
        status = sp_table_add_numbers(t, row, err);
    }
    return status;
}

static sp_status comment_violations(const diagram *d, sp_table *t, sp_error *err) {
    int32_t count = 0, first = -1;
    char value[SP_NUMBER_TEXT];
    for (int32_t k = 0; k < d->points; k++)
        if (d->violated[k]) {
            count++;
            first = first < 0 ? k : first;
        }
    if (count == 0)
        return SP_OK;
    return sp_table_add_comment(t, err,
                                "warning: ordering (1) violated at %d of %d points, first at %s = %s: centres passed "
                                "each other, beyond which no contact law holds; a larger column.stiffness prevents it",
                                count, d->points, sp_tapped_parameter_name(d->c->parameter),
                                sp_number_text(parameter_at(d->c, first), value));
}

static sp_status write_table(const diagram *d, sp_table *t, sp_error *err) {
    double *row = sp_alloc((size_t)d->values + 2, sizeof *row);
    sp_status status = row ? add_columns(d, t, err) : sp_fail_memory(err, (size_t)d->values * sizeof *row);
    int failed = atomic_load(&d->failed);
    if (status == SP_OK && failed > 0)
        status = sp_table_add_comment(t, err, "%d points could not be made (nan); the first: %s", failed,
                                      d->first_error->text);
    if (status == SP_OK)
        status = comment_violations(d, t, err);
    for (int32_t k = 0; status == SP_OK && k < d->points; k++)
        status = add_point(d, k, row, t, err);
    sp_free(row);
    return status;
}

static sp_status run_points(diagram *d, int threads, sp_error *err) {
    sp_pool *pool = NULL;
    sp_status status = sp_pool_make(threads < d->points ? threads : d->points, &pool, err);
    if (status != SP_OK)
        return status;
    sp_pool_run(pool, work, d);
    sp_pool_free(pool);
    for (int32_t k = 0; k < d->points; k++)
        if (d->status[k] == SP_ENOMEM) /* says nothing about the point */
            return sp_fail_memory(err, 0);
    if (atomic_load(&d->stop))
        return sp_fail(err, SP_EINTERRUPTED, "stopped after %d of %d points", atomic_load(&d->done), d->points);
    if (atomic_load(&d->failed) == d->points) {
        *err = *d->first_error;
        return err->status;
    }
    return SP_OK;
}

sp_status sp_tapped_diagram(const sp_tapped_spec *spec, int threads, sp_tapped_watcher watcher, sp_table *out,
                            sp_error *err) {
    sp_tapped_spec c = *spec;
    c.taps = sp_tapped_taps(spec);
    sp_error first_error = {0};
    bool exponents = c.output == SP_TAPPED_LYAPUNOV;
    diagram d = {.c = &c, .watcher = watcher, .points = c.points, .first_error = &first_error};
    d.rows_per_point = exponents ? 1 : c.taps;
    d.values = exponents ? 3 : c.particles;
    sp_status status = check_range(&c, err);
    double bytes = (double)d.points * d.rows_per_point * (d.values + 2.0) * 2 * sizeof(double);
    if (status == SP_OK && bytes > 0.5 * sp_memory_limit())
        status =
            sp_fail_key(err, SP_EINVAL, "column.points",
                        " = %d, column.taps = %d: a table of %.3g bytes; must be smaller", d.points, c.taps, bytes);
    if (status != SP_OK)
        return status;
    d.value = sp_alloc((size_t)d.points * (size_t)d.rows_per_point * (size_t)d.values, sizeof *d.value);
    d.status = sp_alloc((size_t)d.points, sizeof *d.status);
    d.violated = sp_alloc((size_t)d.points, sizeof *d.violated);
    status = d.value && d.status && d.violated ? run_points(&d, threads, err) : sp_fail_memory(err, (size_t)bytes);
    if (status == SP_OK)
        status = write_table(&d, out, err);
    sp_free(d.value);
    sp_free(d.status);
    sp_free(d.violated);
    return status;
}
