/* What the contact law makes of radii and positions: overlaps, stiffnesses and forces at rest. */
#include "sensitivity/gradient.h"

#include "base/base.h"
#include "base/vector.h"
#include "packing/contact.h"

#include <float.h>
#include <math.h>

/* How the stiffnesses of a spring change with the overlap (at fixed radii), and with each radius at fixed overlap. */
typedef struct law {
    double kn, kt, kp;   /* with the overlap */
    double kn_radius[2]; /* with the radii of i and j, at fixed overlap */
    double kt_radius[2], kp_radius[2];
    double length_kp; /* of k_p = -F_n/length with the length, at a fixed force */
} law;

/* d ln e/dr of e = E12 sqrt(R12) with the radius r and the other one; other <= 0: a wall, where e is as sqrt(r). */
static double stiffness_slope(double r, double other) { return other > 0 ? 0.5 * other / (r * (r + other)) : 0.5 / r; }

static law law_of(const sp_network *net, const sp_packing *p, int32_t k) {
    const sp_spring *s = &net->springs[k];
    const sp_contact *c = &p->contacts[s->contact];
    const bool own = c->kn > 0, turns = s->kp != 0;
    const double ratio = s->kt / s->kn, r[2] = {p->r[c->i], c->j < 0 ? 0 : p->r[c->j]};
    law d = {0};
    if (!own) {
        d.kn = 0.5 * s->kn / c->overlap;
        d.kt = ratio * d.kn;
    }
    for (int end = 0; end < (c->j < 0 ? 1 : 2); end++) {
        const double slope = own ? 0 : stiffness_slope(r[end], r[1 - end]);
        d.kn_radius[end] = slope * s->kn;
        d.kt_radius[end] = slope * s->kt;
        d.kp_radius[end] = turns ? slope * s->kp : 0;
    }
    if (turns) {
        d.kp = -s->kn / net->length[k];
        d.length_kp = -s->kp / net->length[k];
    }
    return d;
}

static sp_status need_overlaps(const sp_network *net, const sp_packing *p, sp_error *err) {
    for (int32_t k = 0; k < net->n_springs; k++) {
        const int32_t at = net->springs[k].contact;
        if (at >= p->n_contacts)
            return sp_fail(err, SP_EINVAL, "contact %d of %d: the network is not that of this packing", at,
                           p->n_contacts);
        if (!(p->contacts[at].kn > 0) && !(p->contacts[at].overlap > 0))
            return sp_fail(err, SP_EREFUSED, "contact %d has the overlap %g: its stiffness has no derivative there", at,
                           p->contacts[at].overlap);
    }
    return SP_OK;
}

/* Error of a derivative by an overlap, from those by k_n and k_t. That by k_p is as the one by k_t at most: it has no
 * lever arms. */
static double error_of(const sp_products *p, int32_t k, double kn, double kt, double kp) {
    const double *e = p->error + 2 * (int64_t)k;
    return fabs(kn) * e[0] + (fabs(kt) + fabs(kp)) * (e[1] > e[0] ? e[1] : e[0]);
}

/* The separation is the length times the normal. A wall's normal is fixed. */
static void separate(const sp_products *p, const sp_packing *packing, int32_t k, double out[3], double *error) {
    const sp_network *net = p->net;
    const sp_spring *s = &net->springs[k];
    const law d = law_of(net, packing, k);
    const sp_stiffness_partials q = sp_products_stiffness(p, k);
    const double length = net->length[k];
    const double along = -(d.kn * q.kn + d.kt * q.kt + d.kp * q.kp) + d.length_kp * q.kp;
    const double *pull = p->pull + 3 * (int64_t)k, pulled = dot3(pull, s->n);
    double turn[3] = {0, 0, 0};
    if (s->j >= 0)
        sp_products_turn(p, k, turn);
    const double off = dot3(turn, s->n);
    for (int a = 0; a < 3; a++)
        out[a] = along * s->n[a] + (turn[a] - off * s->n[a]) / length + (s->j < 0 ? pulled * s->n[a] : pull[a]);
    const double stiff = 2 * (s->kn + s->kt + fabs(s->kp)) / length;
    *error = error_of(p, k, fabs(d.kn) + stiff, fabs(d.kt) + stiff, fabs(d.kp) + fabs(d.length_kp) + stiff);
}

sp_status sp_gradient_separations(const sp_products *p, const sp_packing *packing, double **separation, double **error,
                                  sp_error *err) {
    const size_t springs = (size_t)p->net->n_springs;
    sp_status status = need_overlaps(p->net, packing, err);
    if (status != SP_OK)
        return status;
    *separation = sp_alloc(springs, 3 * sizeof **separation);
    *error = sp_alloc(springs, sizeof **error);
    if (!*separation || !*error)
        return sp_fail_memory(err, 4 * springs * sizeof(double));
    for (int32_t k = 0; k < p->net->n_springs; k++)
        separate(p, packing, k, *separation + 3 * (int64_t)k, *error + k);
    return SP_OK;
}

/* The mass of a sphere of unit density is as r^3. With masses of their own nothing of it changes: moments of inertia as
 * r^2, with rotations times the radius as displacements. */
static void add_mass(const sp_products *p, const sp_packing *packing, int32_t grain, sp_partials *out) {
    if (packing->mass)
        return;
    out->d[grain] += 3 * p->mass[grain] / p->net->r[grain];
    out->error[grain] += 3 * p->mass_error[grain] / p->net->r[grain];
}

sp_status sp_gradient_radii(const sp_products *p, const sp_packing *packing, sp_partials *out, sp_error *err) {
    const sp_network *net = p->net;
    sp_status status = need_overlaps(net, packing, err);
    if (status == SP_OK)
        status = sp_partials_make(net->n, out, err);
    if (status != SP_OK)
        return status;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        const law d = law_of(net, packing, k);
        const sp_stiffness_partials q = sp_products_stiffness(p, k);
        for (int end = 0; end < (s->j < 0 ? 1 : 2); end++) {
            const int32_t grain = end == 0 ? s->i : s->j;
            const double kn = d.kn + d.kn_radius[end], kt = d.kt + d.kt_radius[end], kp = d.kp + d.kp_radius[end];
            out->d[grain] += kn * q.kn + kt * q.kt + kp * q.kp;
            out->error[grain] += error_of(p, k, kn, kt, kp);
        }
    }
    for (int32_t k = 0; k < net->n; k++)
        add_mass(p, packing, k, out);
    return SP_OK;
}
