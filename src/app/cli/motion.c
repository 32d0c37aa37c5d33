/* Tables of the displacements of a mode. */
#include "cli/motion.h"

#include "base/base.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

static const char *const places[] = {"x", "y", "z"}, *const components[] = {"ux", "uy", "uz", "rx", "ry", "rz"};

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
    for (int a = 0; a < net->dof; a++)
        cli_columns(w, SP_COLUMN_NUMBER, component(net, a), a < net->dim ? "1/sqrt(rho d^3)" : "1/sqrt(rho d^5)", NULL);
}

static void add_comments(const cli_motion *m, cli_writer *w) {
    cli_comment(w, "motion = mode");
    cli_comment(w, "packing = %016" PRIx64, sp_packing_hash(m->packing));
    cli_value(w, "threshold", m->made.threshold);
    cli_comment(w, "prestress = %d", m->made.prestress);
    cli_comment(w, "sliding_free = %d", m->made.sliding_free);
    cli_comment(w, "mode = %lld", (long long)m->number);
    cli_value(w, "omega", m->omega);
    cli_value(w, "omega_error", m->omega_error);
    cli_value(w, "vector_error", m->error);
    cli_comment(w, "u = M^(-1/2) e with |e| = 1; vector_error is a bound of |e - exact|");
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

static sp_status fill_table(const cli_motion *m, sp_table *t, sp_error *err) {
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
    sp_status status = fill_table(m, &t, err);
    if (status == SP_OK)
        status = cli_write_table(&there, &t, err);
    sp_table_free(&t);
    return status;
}

void cli_motion_of_mode(const sp_network *net, const double *e, double *u) {
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        u[k] = e[k] / sqrt(net->mass[k]);
}
