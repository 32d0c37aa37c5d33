#include "network/rows.h"

#include <string.h>

/* One row: the component along `along` of the relative displacement at the contact point, u_j - u_i minus, with arms,
 * (R_i theta_i + R_j theta_j) x n. */
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
    /* -(R theta x n) . along = -R theta . (n x along); in 2D only the third component of theta is there */
    const double turn[3] = {s->n[1] * along[2] - s->n[2] * along[1], s->n[2] * along[0] - s->n[0] * along[2],
                            s->n[0] * along[1] - s->n[1] * along[0]};
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
    for (int a = 0; net->dim == 3 && a < 3; a++) { /* the rows of the projector 1 - n n^T */
        double tangent[3];
        for (int b = 0; b < 3; b++)
            tangent[b] = (a == b) - s->n[a] * s->n[b];
        add_row(net, s, tangent, s->kt, arms, rows);
        add_row(net, s, tangent, s->kp, false, rows);
    }
}
