/* Checks the physics of a packing, from positions, radii and the contact law alone. */
#include "base/base.h"
#include "packing/contact.h"

#include <math.h>
#include <sonopack/packing.h>
#include <stdlib.h>
#include <string.h>

static void image(const sp_packing *p, int32_t i, int32_t j, double d[3]) {
    for (int a = 0; a < 3; a++) {
        d[a] = p->x[3 * (size_t)j + (size_t)a] - p->x[3 * (size_t)i + (size_t)a];
        if (a < p->dim - 1)
            d[a] -= p->box[a] * nearbyint(d[a] / p->box[a]);
    }
}

/* Overlap from the positions, and the largest deviation of the stored normal from theirs. */
static double true_overlap(const sp_packing *p, const sp_contact *c, double *turn) {
    const int up = p->dim - 1;
    double d[3] = {0, 0, 0}, r2 = 0;
    *turn = 0;
    if (c->j >= 0) {
        image(p, c->i, c->j, d);
    } else {
        double y = p->x[3 * (size_t)c->i + (size_t)up];
        d[up] = c->j == SP_BOTTOM ? -y : p->box[up] - y;
    }
    for (int a = 0; a < 3; a++)
        r2 += d[a] * d[a];
    for (int a = 0; a < 3; a++)
        *turn = fmax(*turn, fabs(d[a] / sqrt(r2) - c->n[a]));
    return p->r[c->i] + (c->j >= 0 ? p->r[c->j] : 0) - sqrt(r2);
}

static double stiffness_of(const sp_packing *p, const sp_contact *c) {
    return c->j >= 0 ? contact_stiffness(p->r[c->i], p->r[c->j]) : contact_wall_stiffness(p->r[c->i], p->wall);
}

/* Errors of each contact by itself. */
static void audit_contacts(const sp_packing *p, double small, sp_audit *a) {
    double deepest = 0;
    for (int32_t c = 0; c < p->n_contacts; c++)
        deepest = fmax(deepest, p->contacts[c].overlap);
    for (int32_t c = 0; c < p->n_contacts; c++) {
        const sp_contact *k = &p->contacts[c];
        double turn, overlap = true_overlap(p, k, &turn);
        double hertz = contact_force(stiffness_of(p, k), k->overlap);
        double ft = sqrt(k->ft[0] * k->ft[0] + k->ft[1] * k->ft[1] + k->ft[2] * k->ft[2]);
        a->geometry_residual = fmax(a->geometry_residual, fmax(turn, fabs(overlap - k->overlap) / deepest));
        a->law_residual = fmax(a->law_residual, fabs(hertz - k->fn) / fmax(k->fn, small));
        a->coulomb_excess = fmax(a->coulomb_excess, (ft - p->friction * k->fn) / fmax(p->friction * k->fn, small));
    }
}

/* force[6 i ..]: net force on grain i, then the sum of n x ft, which is the net torque over R. */
static void sum_on_grains(const sp_packing *p, double *force, double wall[2]) {
    for (int32_t c = 0; c < p->n_contacts; c++) {
        const sp_contact *k = &p->contacts[c];
        const double *n = k->n, *ft = k->ft;
        const double turn[3] = {n[1] * ft[2] - n[2] * ft[1], n[2] * ft[0] - n[0] * ft[2], n[0] * ft[1] - n[1] * ft[0]};
        for (int a = 0; a < 3; a++) {
            double f = ft[a] - k->fn * n[a];
            force[6 * (size_t)k->i + (size_t)a] += f;
            force[6 * (size_t)k->i + 3 + (size_t)a] += turn[a];
            if (k->j >= 0) {
                force[6 * (size_t)k->j + (size_t)a] -= f;
                force[6 * (size_t)k->j + 3 + (size_t)a] += turn[a];
            }
        }
        if (k->j < 0)
            wall[k->j == SP_BOTTOM ? 0 : 1] += k->fn;
    }
}

static double length(const double *v) { return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

static sp_status audit_balance(const sp_packing *p, const uint8_t *rattler, double unit, sp_audit *a, sp_error *err) {
    double *force = sp_alloc((size_t)p->n * 6, sizeof *force), wall[2] = {0, 0};
    if (!force)
        return sp_fail_memory(err, (size_t)p->n * 6 * sizeof *force);
    sum_on_grains(p, force, wall);
    for (size_t i = 0; i < (size_t)p->n; i++) {
        if (rattler[i])
            continue;
        a->force_residual = fmax(a->force_residual, length(force + 6 * i) / unit);
        a->torque_residual = fmax(a->torque_residual, length(force + 6 * i + 3) / unit);
    }
    for (int side = 0; side < 2; side++)
        a->wall_residual = fmax(a->wall_residual, fabs(wall[side] / (p->pressure * sp_packing_wall_area(p)) - 1.0));
    sp_free(force);
    return SP_OK;
}

/* ---- pairs that overlap but are not listed ------------------------------------------------------------------ */

typedef struct by_height {
    double y;
    int32_t i;
} by_height;

static int compare_heights(const void *a, const void *b) {
    const by_height *p = a, *q = b;
    return (p->y > q->y) - (p->y < q->y);
}

static bool listed(const sp_packing *p, int32_t i, int32_t j) {
    int32_t low = 0, high = p->n_contacts; /* pairs come first, ordered by (i, j) */
    while (low < high) {
        int32_t mid = low + (high - low) / 2;
        const sp_contact *c = &p->contacts[mid];
        if (c->j >= 0 && (c->i < i || (c->i == i && c->j < j)))
            low = mid + 1;
        else
            high = mid;
    }
    return low < p->n_contacts && p->contacts[low].i == i && p->contacts[low].j == j;
}

/* Sweeps upwards: only grains up to the largest diameter above can touch. */
static sp_status audit_missing(const sp_packing *p, double slack, sp_audit *a, sp_error *err) {
    const size_t n = (size_t)p->n;
    const int up = p->dim - 1;
    by_height *order = sp_alloc(n, sizeof *order);
    if (!order)
        return sp_fail_memory(err, n * sizeof *order);
    double r_max = 0;
    for (size_t i = 0; i < n; i++) {
        order[i] = (by_height){p->x[3 * i + (size_t)up], (int32_t)i};
        r_max = fmax(r_max, p->r[i]);
    }
    qsort(order, n, sizeof *order, compare_heights);
    for (size_t k = 0; k < n; k++)
        for (size_t m = k + 1; m < n && order[m].y - order[k].y < 2 * r_max; m++) {
            int32_t i = order[k].i < order[m].i ? order[k].i : order[m].i;
            int32_t j = order[k].i < order[m].i ? order[m].i : order[k].i;
            double d[3], reach = p->r[i] + p->r[j] - slack;
            image(p, i, j, d);
            if (length(d) < reach && !listed(p, i, j))
                a->missing++;
        }
    sp_free(order);
    return SP_OK;
}

sp_status sp_packing_audit(const sp_packing *p, double threshold, sp_audit *out, sp_error *err) {
    sp_audit a = {0};
    double diameter = 0, deepest = 0;
    for (int32_t i = 0; i < p->n; i++)
        diameter += 2 * p->r[i] / p->n;
    for (int32_t c = 0; c < p->n_contacts; c++)
        deepest = fmax(deepest, p->contacts[c].overlap);
    const double unit = p->pressure * diameter * diameter;
    uint8_t *rattler = sp_alloc((size_t)p->n, 1), *carrying = sp_alloc((size_t)p->n_contacts, 1);
    sp_status status = rattler && carrying ? SP_OK : sp_fail_memory(err, (size_t)p->n + (size_t)p->n_contacts);
    if (status == SP_OK)
        status = sp_packing_rattlers(p, threshold, rattler, carrying, &a.rattlers, err);
    if (status != SP_OK)
        goto out;
    for (int32_t c = 0; c < p->n_contacts; c++)
        a.carrying += carrying[c];
    audit_contacts(p, threshold * unit, &a);
    status = audit_balance(p, rattler, unit, &a, err);
    if (status == SP_OK)
        status = audit_missing(p, 1e-6 * deepest + 1e-12 * diameter, &a, err);
    if (status == SP_OK)
        *out = a;
out:
    sp_free(carrying);
    sp_free(rattler);
    return status;
}
