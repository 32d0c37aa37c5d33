/* Applies K spring by spring, without assembling it, and computes energies. */
#include "network/apply.h"
#include "network/spring.h"

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

static ALWAYS_INLINE void apply_body(shape s, const sp_network *net, const double *restrict u, double *restrict out) {
    const int stride = (s.dim + s.rotations) * s.lanes;
    const sp_spring *c = net->springs;
    for (int32_t k = 0; k < net->n_bulk; k++, c++) {
        const ptrdiff_t i = (ptrdiff_t)c->i * stride, j = (ptrdiff_t)c->j * stride;
        add_spring(s, c, s.carried ? &net->carried[k] : NULL, u + i, u + j, out + i, out + j);
    }
    for (int32_t k = net->n_bulk; k < net->n_springs; k++, c++) {
        const ptrdiff_t i = (ptrdiff_t)c->i * stride;
        add_spring(s, c, s.carried ? &net->carried[k] : NULL, u + i, NULL, out + i, NULL);
    }
}

static void apply_carried(int lanes, bool transposed, const sp_network *net, const double *restrict u,
                          double *restrict out) {
    const bool space = net->dim == 3;
    if (lanes == 1 && !transposed)
        space ? apply_body((shape){3, 3, 1, true, true, false}, net, u, out)
              : apply_body((shape){2, 1, 1, true, true, false}, net, u, out);
    else if (lanes == 1)
        space ? apply_body((shape){3, 3, 1, true, true, true}, net, u, out)
              : apply_body((shape){2, 1, 1, true, true, true}, net, u, out);
    else
        space ? apply_body((shape){3, 3, 2, true, true, false}, net, u, out)
              : apply_body((shape){2, 1, 2, true, true, false}, net, u, out);
}

static ALWAYS_INLINE void apply_shapes(int lanes, bool prestress, const sp_network *net, const double *restrict u,
                                       double *restrict out) {
    switch (10 * net->dim + net->dof) {
    case 11: apply_body((shape){1, 0, lanes, false, false, false}, net, u, out); break;
    case 22: apply_body((shape){2, 0, lanes, prestress, false, false}, net, u, out); break;
    case 23: apply_body((shape){2, 1, lanes, prestress, false, false}, net, u, out); break;
    case 33: apply_body((shape){3, 0, lanes, prestress, false, false}, net, u, out); break;
    case 36: apply_body((shape){3, 3, lanes, prestress, false, false}, net, u, out); break;
    default: break;
    }
}

void sp_network_apply(const sp_network *net, const double *u, double *out) {
    memset(out, 0, (size_t)sp_network_dofs(net) * sizeof *out);
    if (net->carried)
        apply_carried(1, false, net, u, out);
    else if (net->prestress)
        apply_shapes(1, true, net, u, out);
    else
        apply_shapes(1, false, net, u, out);
}

void sp_network_apply_transposed(const sp_network *net, const double *u, double *out) {
    if (!net->carried) {
        sp_network_apply(net, u, out);
        return;
    }
    memset(out, 0, (size_t)sp_network_dofs(net) * sizeof *out);
    apply_carried(1, true, net, u, out);
}

void sp_network_add_pair(const sp_network *net, const double *restrict u, double *restrict out) {
    if (net->carried)
        apply_carried(2, false, net, u, out);
    else if (net->prestress)
        apply_shapes(2, true, net, u, out);
    else
        apply_shapes(2, false, net, u, out);
}

/* Compensated sum (Neumaier 1974). */
typedef struct exact_sum {
    double sum, lost;
} exact_sum;

static inline void sum_add(exact_sum *s, double x) {
    const double t = s->sum + x;
    s->lost += fabs(s->sum) >= fabs(x) ? (s->sum - t) + x : (x - t) + s->sum;
    s->sum = t;
}

/* Sizes of the terms that add up to a stretch. They determine its rounding error. */
static void stretch_size(const sp_network *net, const sp_spring *c, const double *ui, const double *uj, double *normal,
                         double *side) {
    const int dim = net->dim, rotations = net->dof - net->dim;
    double n = 0, all = 0, turn = 0;
    for (int a = 0; a < dim; a++) {
        const double d = fabs((uj ? uj[a] : 0) - ui[a]);
        n += fabs(c->n[a]) * d;
        all += d;
    }
    for (int a = 0; a < rotations; a++)
        turn += c->ri * fabs(ui[dim + a]) + (uj ? c->rj * fabs(uj[dim + a]) : 0);
    *normal = n;
    *side = 2 * all + 2 * turn;
}

/* Contribution of the tangential force at rest to u^T K u, which depends on the symmetric part only. magnitude: size of
 * the terms. stiffness: upper bound of the coefficients of squared displacements. */
typedef struct carried_energy {
    double value, magnitude, stiffness;
} carried_energy;

static carried_energy energy_of_carried(const sp_network *net, const sp_spring *c, const sp_carried *held,
                                        const double *ui, const double *uj, const stretch *e) {
    const double *n = c->n, *f = held->ft, size = length3(f);
    carried_energy out = {0, 0, 3 * size * (fabs(held->turn) + 1 / c->ri)};
    if (net->dim == 2) {
        out.value = -held->turn * (f[1] * n[0] - f[0] * n[1]) * e->transverse[0][0] * e->normal[0];
        out.magnitude = fabs(out.value);
        return out;
    }
    double side[3];
    cross3(n, f, side);
    double half = 0, tilt = 0, twist = 0, lever = 0, arm[3];
    for (int a = 0; a < 3; a++) {
        arm[a] = c->ri * ui[3 + a] + (uj ? c->rj * uj[3 + a] : 0);
        half += 0.5 * n[a] * (ui[3 + a] + (uj ? uj[3 + a] : 0));
        tilt += f[a] * e->transverse[a][0];
        twist += side[a] * e->transverse[a][0] + f[a] * arm[a];
    }
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, g = (a + 2) % 3;
        lever += arm[a] * (f[b] * e->transverse[g][0] - f[g] * e->transverse[b][0]);
    }
    out.value = half * twist + held->turn * (lever - tilt * e->normal[0]);
    out.magnitude = fabs(half * twist) + held->turn * (fabs(lever) + fabs(tilt * e->normal[0]));
    return out;
}

double sp_network_energy2_bound(const sp_network *net, const double *u, double *rounding) {
    const shape s = {net->dim, net->dof - net->dim, 1, net->prestress, false, false};
    exact_sum energy = {0, 0};
    double magnitude = 0, sizes = 0;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *c = &net->springs[k];
        const double *ui = u + (ptrdiff_t)c->i * net->dof, *uj = c->j >= 0 ? u + (ptrdiff_t)c->j * net->dof : NULL;
        const stretch e = stretch_of(s, c, ui, uj);
        double side = 0, transverse = 0, normal_size, side_size;
        for (int a = 0; a < 3; a++) {
            side += e.tangential[a][0] * e.tangential[a][0];
            transverse += e.transverse[a][0] * e.transverse[a][0];
        }
        side *= s.rotations ? c->kt : 0;
        const double along = c->kn * (e.normal[0] * e.normal[0]);
        sum_add(&energy, along);
        sum_add(&energy, side);
        sum_add(&energy, c->kp * transverse);
        stretch_size(net, c, ui, uj, &normal_size, &side_size);
        magnitude += along + side + fabs(c->kp) * transverse;
        sizes += c->kn * normal_size * normal_size + (c->kt + fabs(c->kp)) * side_size * side_size;
        if (net->carried) {
            const carried_energy more = energy_of_carried(net, c, &net->carried[k], ui, uj, &e);
            sum_add(&energy, more.value);
            magnitude += more.magnitude;
            sizes += more.stiffness * (normal_size * normal_size + side_size * side_size);
        }
    }
    /* Each stretch is off by at most 3 roundings of its terms. Cauchy-Schwarz over the springs bounds the cross
     * term. */
    if (rounding)
        *rounding = DBL_EPSILON * (4 * magnitude + 4 * sqrt(magnitude * sizes) + 9 * DBL_EPSILON * sizes);
    return energy.sum + energy.lost;
}

double sp_network_energy2(const sp_network *net, const double *u) { return sp_network_energy2_bound(net, u, NULL); }
