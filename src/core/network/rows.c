/* Springs as rows of coefficients. */
#include "network/rows.h"

#include "base/vector.h"

#include <string.h>

/* Adds a row for one component of the relative displacement at the contact point: along . (u_j - u_i), minus, with
 * arms, along . ((R_i theta_i + R_j theta_j) x n). */
static void add_row(const sp_network *net, const sp_spring *s, const double along[3], double k, bool arms,
                    sp_rows *rows) {
    const int dim = net->dim, dof = net->dof, q = rows->count;
    if (k == 0)
        return;
    rows->count++;
    rows->k[q] = k;
    for (int a = 0; a < dim; a++) {
        rows->b[q][a] = -along[a];
        rows->gap[q][a] = along[a];
        if (s->j >= 0)
            rows->b[q][dof + a] = along[a];
    }
    if (!arms)
        return;
    /* -(R theta x n) . along = -R theta . (n x along); 2D has the third component of theta only */
    double turn[3];
    cross3(s->n, along, turn);
    for (int a = 0; a < dof - dim; a++) {
        const double t = dim == 2 ? turn[2] : turn[a];
        rows->b[q][dim + a] = -s->ri * t;
        if (s->j >= 0)
            rows->b[q][dof + dim + a] = -s->rj * t;
    }
}

void sp_network_rows(const sp_network *net, const sp_spring *s, sp_rows *rows) {
    memset(rows, 0, sizeof *rows);
    rows->width = s->j >= 0 ? 2 * net->dof : net->dof;
    const bool arms = net->dof > net->dim;
    add_row(net, s, s->n, s->kn, false, rows);
    if (net->dim == 2) {
        const double tangent[3] = {-s->n[1], s->n[0], 0};
        add_row(net, s, tangent, s->kt, arms, rows);
        add_row(net, s, tangent, s->kp, false, rows);
    }
    for (int a = 0; net->dim == 3 && a < 3; a++) { /* rows of the projector 1 - n n^T */
        double tangent[3];
        for (int b = 0; b < 3; b++)
            tangent[b] = (a == b) - s->n[a] * s->n[b];
        add_row(net, s, tangent, s->kt, arms, rows);
        add_row(net, s, tangent, s->kp, false, rows);
    }
}

/* Row for along . (u_j - u_i). */
static void translate(const sp_network *net, const sp_spring *s, const double along[3], double *row, double *gap) {
    for (int a = 0; a < net->dim; a++) {
        row[a] -= along[a];
        gap[a] += along[a];
        if (s->j >= 0)
            row[net->dof + a] += along[a];
    }
}

/* Row for along . (arm_i theta_i + arm_j theta_j) in 3D. */
static void rotate(const sp_network *net, const sp_spring *s, const double along[3], double arm_i, double arm_j,
                   double *row) {
    for (int a = 0; a < 3; a++) {
        row[net->dim + a] += arm_i * along[a];
        if (s->j >= 0)
            row[net->dof + net->dim + a] += arm_j * along[a];
    }
}

/* The formulas of network/spring.h as rows: a displacement along right[q] adds a force along left[q]. */
static void turns_3d(const sp_network *net, const sp_spring *s, const sp_carried *held, sp_turns *t) {
    const double *n = s->n, *f = held->ft;
    double half[3], down[3], tilt[3], side[3], across[3];
    cross3(n, f, across);
    for (int a = 0; a < 3; a++) {
        half[a] = 0.5 * across[a];
        tilt[a] = -held->turn * f[a];
        side[a] = held->turn * across[a];
        down[a] = 0.5 * f[a];
    }
    translate(net, s, half, t->left[0], t->left_gap[0]);
    rotate(net, s, down, s->ri, s->rj, t->left[0]);
    rotate(net, s, n, 1, 1, t->right[0]);
    t->count = 1;
    if (held->turn == 0)
        return;
    translate(net, s, n, t->left[1], t->left_gap[1]);
    translate(net, s, tilt, t->right[1], t->right_gap[1]);
    rotate(net, s, n, s->ri, s->rj, t->left[2]);
    translate(net, s, side, t->right[2], t->right_gap[2]);
    t->count = 3;
}

void sp_network_turns(const sp_network *net, int32_t k, sp_turns *t) {
    memset(t, 0, sizeof *t);
    if (!net->carried)
        return;
    const sp_spring *s = &net->springs[k];
    const sp_carried *held = &net->carried[k];
    t->width = s->j >= 0 ? 2 * net->dof : net->dof;
    if (net->dim == 3) {
        turns_3d(net, s, held, t);
    } else if (held->turn != 0) {
        const double tilt = -held->turn * (held->ft[1] * s->n[0] - held->ft[0] * s->n[1]);
        const double tangent[3] = {-tilt * s->n[1], tilt * s->n[0], 0};
        translate(net, s, s->n, t->left[0], t->left_gap[0]);
        translate(net, s, tangent, t->right[0], t->right_gap[0]);
        t->count = 1;
    }
}
