/* Products of displacements at springs, and what stiffnesses and normals take of them. */
#include "sensitivity/products.h"

#include "base/base.h"
#include "base/vector.h"

void sp_products_free(sp_products *p) {
    sp_free(p->at);
    sp_free(p->error);
    sp_free(p->mass);
    sp_free(p->mass_error);
    sp_free(p->pull);
    *p = (sp_products){0};
}

sp_status sp_products_make(const sp_network *net, bool whole, sp_products *out, sp_error *err) {
    const size_t springs = (size_t)net->n_springs, n = (size_t)net->n;
    sp_products p = {.net = net, .whole = whole, .size = net->dof};
    p.width = whole ? p.size * (p.size + 1) / 2 : 2;
    p.at = sp_alloc(springs, (size_t)p.width * sizeof *p.at);
    p.error = sp_alloc(springs, 2 * sizeof *p.error);
    p.mass = sp_alloc(n, sizeof *p.mass);
    p.mass_error = sp_alloc(n, sizeof *p.mass_error);
    p.pull = whole ? sp_alloc(springs, 3 * sizeof *p.pull) : NULL;
    if (!p.at || !p.error || !p.mass || !p.mass_error || (whole && !p.pull)) {
        sp_products_free(&p);
        return sp_fail_memory(err, springs * (size_t)(p.width + 5) * sizeof(double));
    }
    *out = p;
    return SP_OK;
}

void sp_products_local(const sp_network *net, const sp_spring *s, const double *u, double out[SP_LOCAL_MAX]) {
    const double *ui = u + (int64_t)s->i * net->dof, *uj = s->j < 0 ? NULL : u + (int64_t)s->j * net->dof;
    for (int a = 0; a < net->dof; a++) {
        const double other = uj ? uj[a] : 0;
        out[a] = a < net->dim ? other - ui[a] : s->ri * ui[a] + s->rj * other;
    }
}

void sp_products_across(const sp_network *net, const double n[3], const double x[SP_LOCAL_MAX], double out[3]) {
    out[0] = out[1] = out[2] = 0;
    if (net->dof == net->dim)
        return;
    if (net->dim == 2) {
        out[0] = n[0] * x[1] - n[1] * x[0] - x[2];
        return;
    }
    double turn[3];
    cross3(x + 3, n, turn);
    const double along = dot3(n, x);
    for (int a = 0; a < 3; a++)
        out[a] = x[a] - along * n[a] - turn[a];
}

double sp_products_along(const sp_network *net, const double n[3], const double x[SP_LOCAL_MAX]) {
    double sum = 0;
    for (int a = 0; a < net->dim; a++)
        sum += n[a] * x[a];
    return sum;
}

void sp_products_add(sp_products *p, int32_t k, double weight, const double x[SP_LOCAL_MAX],
                     const double y[SP_LOCAL_MAX]) {
    const double *n = p->net->springs[k].n;
    double *at = p->at + (int64_t)k * p->width;
    if (p->whole) {
        for (int a = 0; a < p->size; a++)
            for (int b = a; b < p->size; b++)
                *at++ += 0.5 * weight * (x[a] * y[b] + x[b] * y[a]);
        return;
    }
    double tx[3], ty[3];
    sp_products_across(p->net, n, x, tx);
    sp_products_across(p->net, n, y, ty);
    at[0] += weight * sp_products_along(p->net, n, x) * sp_products_along(p->net, n, y);
    at[1] += weight * dot3(tx, ty);
}

/* The whole products of a spring as a symmetric matrix. */
typedef struct matrix {
    double at[SP_LOCAL_MAX][SP_LOCAL_MAX];
} matrix;

static matrix matrix_of(const sp_products *p, int32_t k) {
    const double *at = p->at + (int64_t)k * p->width;
    matrix m = {{{0}}};
    for (int a = 0; a < p->size; a++)
        for (int b = a; b < p->size; b++)
            m.at[a][b] = m.at[b][a] = *at++;
    return m;
}

/* Sums over translations: n . P . n, and the trace. */
static void contract(const matrix *m, int dim, int first, const double n[3], double *along, double *trace) {
    *along = *trace = 0;
    for (int a = 0; a < dim; a++) {
        *trace += m->at[first + a][first + a];
        for (int b = 0; b < dim; b++)
            *along += n[a] * m->at[first + a][first + b] * n[b];
    }
}

/* (P_dw x n), contracted: sum over a, b, c of e_abc P[d_a][w_b] n_c. */
static void twist(const matrix *m, double out[3]) {
    for (int c = 0; c < 3; c++) {
        const int a = (c + 1) % 3, b = (c + 2) % 3;
        out[c] = m->at[a][3 + b] - m->at[b][3 + a];
    }
}

sp_stiffness_partials sp_products_stiffness(const sp_products *p, int32_t k) {
    const sp_network *net = p->net;
    const double *n = net->springs[k].n, *at = p->at + (int64_t)k * p->width;
    if (!p->whole)
        return (sp_stiffness_partials){at[0], at[1], 0};
    const matrix m = matrix_of(p, k);
    double along, trace, along_turn, trace_turn, t[3];
    contract(&m, net->dim, 0, n, &along, &trace);
    sp_stiffness_partials out = {.kn = along, .kp = trace - along};
    if (net->dof == 3 && net->dim == 2)
        out.kt = out.kp - 2 * (n[0] * m.at[1][2] - n[1] * m.at[0][2]) + m.at[2][2];
    if (net->dof == 6) {
        contract(&m, 3, 3, n, &along_turn, &trace_turn);
        twist(&m, t);
        out.kt = out.kp - 2 * dot3(t, n) + trace_turn - along_turn;
    }
    return out;
}

void sp_products_turn(const sp_products *p, int32_t k, double out[3]) {
    const sp_network *net = p->net;
    const sp_spring *s = &net->springs[k];
    const matrix m = matrix_of(p, k);
    double t[3];
    out[0] = out[1] = out[2] = 0;
    if (net->dof == 6)
        twist(&m, t);
    for (int a = 0; a < net->dim; a++) {
        double along = 0, turned = 0;
        for (int b = 0; b < net->dim; b++) {
            along += m.at[a][b] * s->n[b];
            turned += net->dof == 6 ? m.at[3 + a][3 + b] * s->n[b] : 0;
        }
        out[a] = 2 * (s->kn - s->kt - s->kp) * along;
        if (net->dof == 6)
            out[a] -= 2 * s->kt * (t[a] + turned);
    }
    if (net->dim == 2 && net->dof == 3) {
        out[0] -= 2 * s->kt * m.at[1][2];
        out[1] += 2 * s->kt * m.at[0][2];
    }
}

double sp_products_mobility(const sp_network *net, const sp_spring *s, bool tangential) {
    double sum = 0;
    for (int end = 0; end < 2; end++) {
        const int32_t grain = end == 0 ? s->i : s->j;
        if (grain < 0)
            continue;
        const double arm = end == 0 ? s->ri : s->rj, *mass = net->mass + (int64_t)grain * net->dof;
        sum += 1 / mass[0] + (tangential && net->dof > net->dim ? arm * arm / mass[net->dim] : 0);
    }
    return sum;
}
