/* Tables of sonopack sensitivity: one row for each contact, each grain, or the pressure. */
#include "cli/sensitivity.h"

#include "base/base.h"

enum { COLUMNS_MAX = 16 };

/* A row of numbers that grows. */
typedef struct row {
    int n;
    double at[COLUMNS_MAX];
} row;

static void put(row *r, double x) { r->at[r->n++] = x; }

/* A derivative by the logarithm of a parameter, and its error. */
static void put_partial(row *r, const sp_partials *d, int64_t k, double parameter) {
    if (d->n == 0)
        return;
    put(r, parameter * d->d[k]);
    put(r, parameter * d->error[k]);
}

static void columns_of(cli_writer *w, const sp_partials *d, const char *name, const char *error, const char *unit) {
    if (d->n > 0)
        cli_columns(w, SP_COLUMN_NUMBER, name, unit, error, unit, NULL);
}

static void place_columns(cli_writer *w, int dim) {
    static const char *const axes[] = {"x", "y", "z"};
    for (int a = 0; a < dim; a++)
        cli_columns(w, SP_COLUMN_NUMBER, axes[a], "d", NULL);
}

/* The middle of the line that a contact is drawn along. */
static void put_contact(row *r, const sp_network *net, int32_t k) {
    const sp_spring *s = &net->springs[k];
    put(r, s->contact);
    put(r, net->grain[s->i]);
    put(r, s->j < 0 ? s->j : net->grain[s->j]);
    for (int a = 0; a < net->dim; a++)
        put(r, net->x[3 * (int64_t)s->i + a] + (s->j < 0 ? 1 : 0.5) * net->length[k] * s->n[a]);
    put(r, s->kn);
    put(r, s->kt);
}

static sp_status contact_rows(const cli_file *file, const sp_gradient *g, const char *unit, cli_writer *w) {
    const sp_network *net = &file->network;
    cli_columns(w, SP_COLUMN_INTEGER, "contact", "", "i", "", "j", "", NULL);
    place_columns(w, net->dim);
    cli_columns(w, SP_COLUMN_NUMBER, "kn", "E* d", "kt", "E* d", NULL);
    columns_of(w, &g->kn, "by_kn", "by_kn_err", unit);
    columns_of(w, &g->kt, "by_kt", "by_kt_err", unit);
    for (int32_t k = 0; k < net->n_springs && w->status == SP_OK; k++) {
        row r = {0};
        put_contact(&r, net, k);
        put_partial(&r, &g->kn, k, net->springs[k].kn);
        put_partial(&r, &g->kt, k, net->springs[k].kt);
        w->status = sp_table_add_numbers(w->table, r.at, w->err);
    }
    return w->status;
}

static sp_status grain_rows(const cli_file *file, const sp_gradient *g, const char *unit, cli_writer *w) {
    static const char *const names[] = {"by_x", "by_y", "by_z"};
    const sp_network *net = &file->network;
    cli_columns(w, SP_COLUMN_INTEGER, "grain", "", NULL);
    place_columns(w, net->dim);
    cli_columns(w, SP_COLUMN_NUMBER, "r", "d", "mass", "rho d^3", NULL);
    columns_of(w, &g->mass, "by_mass", "by_mass_err", unit);
    columns_of(w, &g->radius, "by_radius", "by_radius_err", unit);
    for (int a = 0; a < net->dim && g->position.n > 0; a++)
        cli_columns(w, SP_COLUMN_NUMBER, names[a], unit, NULL);
    if (g->position.n > 0)
        cli_columns(w, SP_COLUMN_NUMBER, "by_position_err", unit, NULL);
    for (int32_t k = 0; k < net->n && w->status == SP_OK; k++) {
        const double mass = net->mass[(int64_t)k * net->dof];
        row r = {0};
        put(&r, net->grain[k]);
        for (int a = 0; a < net->dim; a++)
            put(&r, net->x[3 * (int64_t)k + a]);
        put(&r, net->r[k]);
        put(&r, mass);
        put_partial(&r, &g->mass, k, mass);
        put_partial(&r, &g->radius, k, net->r[k]);
        for (int a = 0; a < net->dim && g->position.n > 0; a++)
            put(&r, g->position.d[3 * (int64_t)k + a]);
        if (g->position.n > 0)
            put(&r, g->position.error[3 * (int64_t)k]);
        w->status = sp_table_add_numbers(w->table, r.at, w->err);
    }
    return w->status;
}

static sp_status pressure_row(const cli_file *file, const sp_gradient *g, const char *unit, cli_writer *w) {
    const double p = file->packing.pressure;
    cli_columns(w, SP_COLUMN_NUMBER, "p", "E*", "by_p", unit, "by_p_err", unit, NULL);
    return w->status == SP_OK ? sp_table_add_row(w->table, w->err, p, p * g->pressure.d[0], p * g->pressure.error[0])
                              : w->status;
}

sp_status sensitivity_table(const sensitivity_arguments *a, const cli_file *file, const sp_gradient *g, cli_writer *w) {
    const char *unit = sensitivity_unit(&a->of);
    if (a->by & (SP_BY_KN | SP_BY_KT))
        return contact_rows(file, g, unit, w);
    return a->by & SP_BY_PRESSURE ? pressure_row(file, g, unit, w) : grain_rows(file, g, unit, w);
}
