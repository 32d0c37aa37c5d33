/* Tables of displacements: of a mode, or at a time after a pulse. */
#include "cli/motion.h"

#include "base/base.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *const places[] = {"x", "y", "z"}, *const components[] = {"ux", "uy", "uz", "rx", "ry", "rz"};
static const char *const kinds[] = {"snapshot", "mode"};

/* Name of the column of component a. In 2D the only rotation is about z. */
static const char *component(const sp_network *net, int a) {
    return components[a >= net->dim && net->dim == 2 ? 5 : a];
}

static void add_columns(const cli_motion *m, cli_writer *w) {
    const sp_network *net = m->net;
    cli_columns(w, SP_COLUMN_INTEGER, "grain", "", NULL);
    for (int a = 0; a < net->dim; a++)
        cli_columns(w, SP_COLUMN_NUMBER, places[a], "d", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "radius", "d", NULL);
    for (int a = 0; a < net->dof; a++) {
        const char *unit = a < net->dim ? (m->mode ? "1/sqrt(rho d^3)" : "d") : m->mode ? "1/sqrt(rho d^5)" : "rad";
        cli_columns(w, SP_COLUMN_NUMBER, component(net, a), unit, NULL);
    }
}

static void add_comments(const cli_motion *m, cli_writer *w) {
    cli_comment(w, "motion = %s", kinds[m->mode]);
    cli_comment(w, "packing = %016" PRIx64, sp_packing_hash(m->packing));
    cli_value(w, "threshold", m->made.threshold);
    cli_comment(w, "prestress = %d", m->made.prestress);
    cli_comment(w, "sliding_free = %d", m->made.sliding_free);
    if (m->mode) {
        cli_comment(w, "mode = %lld", (long long)m->number);
        cli_value(w, "omega", m->omega);
        cli_value(w, "omega_error", m->omega_error);
        cli_value(w, "vector_error", m->error);
        cli_comment(w, "u = M^(-1/2) e with |e| = 1; vector_error is a bound of |e - exact|");
    } else {
        cli_value(w, "t", m->t);
        cli_comment(w, "source = %s", cli_source_names[m->source]);
        cli_value(w, "error", m->error);
        cli_comment(w, "displacements after a pulse of unit strength; error is a bound of all of them, and over d of "
                       "all rotations");
    }
    cli_comment(w, "rattlers = %d, which are left out", m->net->rattlers);
}

static sp_status add_grain(const cli_motion *m, int32_t i, sp_table *t, sp_error *err) {
    double row[16];
    int at = 0;
    row[at++] = m->net->grain[i];
    for (int a = 0; a < m->net->dim; a++)
        row[at++] = m->net->x[3 * (int64_t)i + a];
    row[at++] = m->net->r[i];
    for (int a = 0; a < m->net->dof; a++)
        row[at++] = m->u[(int64_t)i * m->net->dof + a];
    return sp_table_add_numbers(t, row, err);
}

sp_status cli_motion_table(const cli_motion *m, sp_table *t, sp_error *err) {
    cli_writer w = {.table = t, .err = err, .status = SP_OK};
    if (m->made.tangential != SP_SPRINGS_CONSTANT)
        return sp_fail_key(err, SP_EREFUSED, "network.tangential",
                           ": must be \"constant\" for a table of displacements, which cannot say otherwise");
    add_columns(m, &w);
    add_comments(m, &w);
    for (int32_t i = 0; i < m->net->n && w.status == SP_OK; i++)
        w.status = add_grain(m, i, t, err);
    return w.status;
}

sp_status cli_motion_write(const cli_common *common, const cli_motion *m, const char *path, sp_error *err) {
    cli_common there = *common;
    sp_table t = sp_table_none();
    there.output = path;
    there.format_given = false;
    sp_status status = cli_motion_table(m, &t, err);
    if (status == SP_OK)
        status = cli_write_table(&there, &t, err);
    sp_table_free(&t);
    return status;
}

/* ---- reading ---------------------------------------------------------------------------------------------------- */

static sp_status need_number(const char *path, const sp_table *t, const char *key, double *out, sp_error *err) {
    if (sp_table_get_number(t, key, out))
        return SP_OK;
    return sp_fail(err, SP_EFORMAT, "%s: no comment `%s = NUMBER', must be a table of displacements", path, key);
}

static sp_status check_origin(const char *path, const sp_packing *p, const sp_table *t, const char *kind,
                              sp_error *err) {
    const char *motion = sp_table_get_text(t, "motion"), *packing = sp_table_get_text(t, "packing");
    char own[20];
    snprintf(own, sizeof own, "%016" PRIx64, sp_packing_hash(p));
    const int radius = sp_table_find_column(t, "radius");
    if (radius >= 0 && t->column[radius].unit[0] && strcmp(t->column[radius].unit, "d") != 0)
        return sp_fail(err, SP_EFORMAT, "%s: its lengths are in %s, must be in d: a table without --units si", path,
                       t->column[radius].unit);
    if (!motion || !packing)
        return sp_fail(err, SP_EFORMAT, "%s: no comments `motion' and `packing', must be a table of displacements",
                       path);
    if (strcmp(motion, kind) != 0)
        return sp_fail(err, SP_EFORMAT, "%s: motion = %.60s, must be %s", path, motion, kind);
    if (strcmp(packing, own) != 0)
        return sp_fail(err, SP_EFORMAT, "%s: displacements of another packing, %.60s; must be %s", path, packing, own);
    return SP_OK;
}

sp_status cli_motion_head(const char *path, const sp_packing *p, const sp_table *t, cli_motion *m, sp_error *err) {
    double prestress = 0, sliding_free = 0, number = 0;
    sp_status status = check_origin(path, p, t, kinds[m->mode], err);
    m->made = sp_network_options_default();
    if (status == SP_OK)
        status = need_number(path, t, "threshold", &m->made.threshold, err);
    if (status == SP_OK)
        status = need_number(path, t, "prestress", &prestress, err);
    if (status == SP_OK)
        status = need_number(path, t, "sliding_free", &sliding_free, err);
    if (status == SP_OK)
        status = need_number(path, t, m->mode ? "mode" : "t", m->mode ? &number : &m->t, err);
    if (status == SP_OK && m->mode)
        status = need_number(path, t, "omega", &m->omega, err);
    if (status == SP_OK && !(number >= 0 && number < 1e15 && m->omega >= 0))
        status = sp_fail(err, SP_EFORMAT, "%s: mode = %g, omega = %g; must be 0 or more", path, number, m->omega);
    m->made.prestress = prestress != 0;
    m->made.sliding_free = sliding_free != 0;
    m->number = (int64_t)number;
    return status;
}

sp_status cli_motion_field(const char *path, const sp_network *net, const sp_table *t, double *u, sp_error *err) {
    int column[6];
    const int grain = sp_table_find_column(t, "grain");
    for (int a = 0; a < net->dof; a++) {
        column[a] = sp_table_find_column(t, component(net, a));
        if (column[a] < 0 || grain < 0)
            return sp_fail(err, SP_EFORMAT, "%s: no column %s", path, grain < 0 ? "grain" : component(net, a));
    }
    if (t->rows != net->n)
        return sp_fail(err, SP_EFORMAT, "%s: %lld rows, must be one for each of the %d grains of the network", path,
                       (long long)t->rows, net->n);
    for (int32_t i = 0; i < net->n; i++) {
        if (sp_table_number(t, i, grain) != net->grain[i])
            return sp_fail(err, SP_EFORMAT, "%s: row %d is of grain %g, must be %d", path, i + 1,
                           sp_table_number(t, i, grain), net->grain[i]);
        for (int a = 0; a < net->dof; a++) {
            const double x = u[(int64_t)i * net->dof + a] = sp_table_number(t, i, column[a]);
            if (!isfinite(x))
                return sp_fail(err, SP_EFORMAT, "%s: %s of grain %d is not a finite number", path, component(net, a),
                               net->grain[i]);
        }
    }
    return SP_OK;
}

void cli_motion_of_mode(const sp_network *net, const double *e, double *u) {
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        u[k] = e[k] / sqrt(net->mass[k]);
}
