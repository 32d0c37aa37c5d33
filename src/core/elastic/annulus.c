/* Moduli of a packing between two rings by what its rings feel when the inner one grows or turns. The displacement u of
 * the grains solves K u = -B^T k d, with the displacements d that a ring has at its contacts. */
#include "base/base.h"
#include "base/vector.h"
#include "elastic/equilibrium.h"
#include "elastic/strain.h"
#include "packing/geometry.h"

#include <math.h>
#include <sonopack/elastic.h>

/* GROW, GROW_OUTER: a ring's radius by 1. TURN: the inner ring by an angle of 1. */
enum { GROW, GROW_OUTER, TURN, MOTIONS };

typedef struct annulus {
    sp_equilibrium e;
    double radius[2];                                        /* of the inner and the outer ring */
    double *u, *w;                                           /* [MOTIONS][n] displacements, and weights of residuals */
    double *f, *rest, *size;                                 /* [n] each */
    double force[MOTIONS][MOTIONS], error[MOTIONS][MOTIONS]; /* a: conjugate to motion a, of motion b; 2D layer */
    double residual;
} annulus;

/* What a motion stretches of a spring before the grains move: along n, or across it. A normal depends on the place of
 * its grain alone, so that no force at rest turns. Returns the stiffness, 0: it does nothing to this spring. */
static double stretch(const annulus *g, int motion, const sp_spring *s, bool *across, double *out) {
    *across = motion == TURN;
    if (s->j != (motion == GROW_OUTER ? SP_TOP : SP_BOTTOM))
        return 0;
    *out = motion == TURN ? -g->radius[0] : sp_packing_wall_side(s->j); /* counterclockwise is -t at the inner ring */
    return *across ? s->kt : s->kn;
}

/* The same stretch per displacement of the grain: row of B, of width dof. */
static void row_of(const sp_network *net, const sp_spring *s, bool across, double row[3]) {
    row[0] = across ? s->n[1] : -s->n[0];
    row[1] = across ? -s->n[0] : -s->n[1];
    row[2] = across && net->dof > net->dim ? -s->ri : 0;
}

/* f = -B^T k d of a motion. Returns |k d|. */
static double load(const annulus *g, int motion, double *f) {
    const sp_network *net = g->e.net;
    double squares = 0;
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        f[k] = 0;
    for (int32_t k = net->n_bulk; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        double own = 0, row[3];
        bool across;
        const double force = stretch(g, motion, s, &across, &own) * own;
        squares += force * force;
        row_of(net, s, across, row);
        for (int a = 0; a < net->dof; a++)
            f[(int64_t)s->i * net->dof + a] -= force * row[a];
    }
    return sqrt(squares);
}

/* The force conjugate to motion a, sum of d_a k (d_b + B u_b); *size: the sum of absolute values. */
static double force_of(const annulus *g, int a, int b, double *size) {
    const sp_network *net = g->e.net;
    const double *u = g->u + b * sp_network_dofs(net);
    double sum = 0;
    *size = 0;
    for (int32_t k = net->n_bulk; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        double own = 0, other = 0, row[3];
        bool across, crosses;
        const double stiffness = stretch(g, a, s, &across, &own);
        row_of(net, s, across, row);
        if (stretch(g, b, s, &crosses, &other) == 0 || across != crosses)
            other = 0;
        double size_of = fabs(other);
        for (int c = 0; c < net->dof; c++) {
            other += row[c] * u[(int64_t)s->i * net->dof + c];
            size_of += fabs(row[c] * u[(int64_t)s->i * net->dof + c]);
        }
        sum += stiffness * own * other;
        *size += fabs(stiffness * own) * size_of;
    }
    return sum;
}

/* Solves for one motion, and for the weights that a residual has in its force. */
static sp_status solve(annulus *g, int motion, sp_error *err) {
    const int64_t n = sp_network_dofs(g->e.net);
    const double scale = load(g, motion, g->f), norm = sp_norm(n, g->f);
    double residual = 0, *u = g->u + motion * n;
    sp_status status = sp_equilibrium_solve(&g->e, g->f, scale, u, &residual, err);
    if (status != SP_OK || norm == 0)
        return status;
    if (!(residual < 1e-8 * norm))
        return sp_equilibrium_refuse(&g->e, "moduli by the rings", norm, g->f, u, err);
    g->residual = fmax(g->residual, residual / norm);
    return g->e.net->carried ? sp_equilibrium_weights(&g->e, g->f, scale, g->w + motion * n, err) : SP_OK;
}

/* A force is off by w_a . (K u_b - f_b) and by rounding; a factor 2 covers the second order. */
static void find_forces(annulus *g, int b) {
    const sp_network *net = g->e.net;
    const int64_t n = sp_network_dofs(net);
    const double noise = sp_strain_noise(net);
    load(g, b, g->f);
    sp_equilibrium_residual(&g->e, g->f, g->u + b * n, g->rest);
    sp_strain_rounding(net, -1, g->u + b * n, g->size, NULL);
    for (int a = 0; a < MOTIONS; a++) {
        double off = 0, size;
        for (int64_t k = 0; k < n; k++)
            off += fabs(g->w[a * n + k]) * (fabs(g->rest[k]) + noise * (g->size[k] + fabs(g->f[k])));
        g->force[a][b] = force_of(g, a, b, &size);
        g->error[a][b] = 2 * off + noise * size;
    }
}

/* Lame's solution, with K + G from the outer ring, and G from the difference of the rings. */
static void set_moduli(const annulus *g, sp_ring_moduli *m) {
    const double a = g->radius[0], b = g->radius[1], share = b * b / (a * a) - 1;
    const double over[2] = {1 / (2 * M_PI), -a / (2 * M_PI * b)}; /* of growth by a part of a */
    const double sum_error = 0.5 * share * fabs(over[1]) * g->error[GROW_OUTER][GROW];
    m->p_inner = over[0] * g->force[GROW][GROW];
    m->p_outer = over[1] * g->force[GROW_OUTER][GROW];
    m->shear = 0.5 * (m->p_inner - m->p_outer);
    m->error_shear = 0.5 * (over[0] * g->error[GROW][GROW] + fabs(over[1]) * g->error[GROW_OUTER][GROW]);
    m->bulk = 0.5 * share * m->p_outer - m->shear;
    m->error_bulk = sum_error + m->error_shear;
    const bool turns = g->force[TURN][TURN] > g->error[TURN][TURN];
    const double by_torque = share / (4 * M_PI * b * b);
    m->torque = turns ? g->force[TURN][TURN] : 0;
    m->shear_turn = turns ? by_torque * m->torque : NAN;
    m->error_shear_turn = turns ? by_torque * g->error[TURN][TURN] : NAN;
    m->residual = g->residual;
}

sp_status sp_ring_moduli_make(const sp_network *net, sp_ring_moduli *out, sp_error *err) {
    const size_t n = (size_t)sp_network_dofs(net), size = (3 + 2 * MOTIONS) * n;
    annulus g = {.radius = {0.5 * net->box[0] - net->box[1], 0.5 * net->box[0]}};
    if (net->cell != SP_CELL_RING)
        return sp_fail(err, SP_EREFUSED, "moduli by the rings: the cell is a %s, must be a ring",
                       sp_cell_names[net->cell]);
    double *work = sp_alloc(size, sizeof *work);
    sp_status status = work ? sp_equilibrium_make(net, &g.e, err) : sp_fail_memory(err, size * sizeof *work);
    if (status == SP_OK) {
        g.f = work;
        g.rest = work + n;
        g.size = work + 2 * n;
        g.u = work + 3 * n;
        g.w = net->carried ? g.u + MOTIONS * n : g.u;
    }
    for (int a = 0; a < MOTIONS && status == SP_OK; a++)
        status = solve(&g, a, err);
    for (int b = 0; b < MOTIONS && status == SP_OK; b++)
        find_forces(&g, b);
    if (status == SP_OK)
        set_moduli(&g, out);
    sp_equilibrium_free(&g.e);
    sp_free(work);
    return status;
}
