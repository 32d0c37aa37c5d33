/* Gradients from products: stiffnesses, masses, and the check by Euler's theorem. */
#include "sensitivity/gradient.h"

#include "base/base.h"

#include <float.h>
#include <math.h>

static const unsigned GEOMETRY = SP_BY_RADIUS | SP_BY_POSITION | SP_BY_PRESSURE;
static const unsigned ALL = 2 * SP_BY_PRESSURE - 1;

sp_gradient sp_gradient_none(void) { return (sp_gradient){.homogeneity = NAN, .homogeneity_size = NAN}; }

void sp_gradient_free(sp_gradient *g) {
    sp_partials *all[] = {&g->kn, &g->kt, &g->mass, &g->radius, &g->position, &g->pressure};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        sp_partials_free(all[k]);
    *g = sp_gradient_none();
}

sp_status sp_gradient_check(const sp_network *net, unsigned parameters, const sp_packing *packing, sp_error *err) {
    if (parameters == 0 || parameters & ~ALL)
        return sp_fail(err, SP_EINVAL, "parameters %u, must be a sum of 1 .. %u", parameters, (unsigned)SP_BY_PRESSURE);
    if ((parameters & GEOMETRY) && !packing)
        return sp_fail(err, SP_EINVAL, "radii, positions and the pressure need the packing of the network");
    return sp_network_need_symmetry(net, "a sensitivity", err);
}

/* With prestress the products of transverse displacements are needed too. */
bool sp_gradient_whole(const sp_network *net, unsigned parameters) {
    return (parameters & GEOMETRY) || (net->prestress && (parameters & (SP_BY_KN | SP_BY_KT)));
}

bool sp_gradient_masses(unsigned parameters) { return parameters & (SP_BY_MASS | SP_BY_RADIUS); }

/* The derivatives by k_n and k_t, and Euler's sum over k_n, k_t and k_p. */
static sp_status set_stiffnesses(const sp_products *p, unsigned parameters, double law, sp_gradient *g, sp_error *err) {
    const sp_network *net = p->net;
    const bool normal = parameters & SP_BY_KN, tangential = (parameters & SP_BY_KT) && net->dof > net->dim;
    sp_status status = normal ? sp_partials_make(net->n_springs, &g->kn, err) : SP_OK;
    if (status == SP_OK && tangential)
        status = sp_partials_make(net->n_springs, &g->kt, err);
    if (status != SP_OK)
        return status;
    double sum = 0, size = 0;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_stiffness_partials d = sp_products_stiffness(p, k);
        const sp_spring *s = &net->springs[k];
        sum += s->kn * d.kn + s->kt * d.kt + s->kp * d.kp;
        size += fabs(s->kn * d.kn) + fabs(s->kt * d.kt) + fabs(s->kp * d.kp);
        if (normal) {
            g->kn.d[k] = d.kn;
            g->kn.error[k] = p->error[2 * (int64_t)k];
        }
        if (tangential) {
            g->kt.d[k] = d.kt;
            g->kt.error[k] = p->error[2 * (int64_t)k + 1];
        }
    }
    if (normal && (tangential || net->dof == net->dim)) {
        g->homogeneity = sum - law;
        g->homogeneity_size = size + fabs(law);
    }
    return SP_OK;
}

static sp_status set_masses(const sp_products *p, sp_gradient *g, sp_error *err) {
    const sp_network *net = p->net;
    sp_status status = sp_partials_make(net->n, &g->mass, err);
    for (int32_t k = 0; k < net->n && status == SP_OK; k++) {
        const double mass = net->mass[(int64_t)k * net->dof];
        g->mass.d[k] = p->mass[k] / mass;
        g->mass.error[k] = p->mass_error[k] / mass;
    }
    return status;
}

/* ---- geometry ------------------------------------------------------------------------------------------------- */

static sp_status set_positions(const sp_products *p, const double *separation, const double *error, sp_gradient *g,
                               sp_error *err) {
    const sp_network *net = p->net;
    sp_status status = sp_partials_make(3 * (int64_t)net->n, &g->position, err);
    for (int32_t k = 0; k < net->n_springs && status == SP_OK; k++)
        for (int a = 0; a < net->dim; a++) {
            const sp_spring *s = &net->springs[k];
            const int64_t i = 3 * (int64_t)s->i + a, j = 3 * (int64_t)s->j + a;
            g->position.d[i] -= separation[3 * (int64_t)k + a];
            g->position.error[i] += error[k];
            if (s->j >= 0) {
                g->position.d[j] += separation[3 * (int64_t)k + a];
                g->position.error[j] += error[k];
            }
        }
    return status;
}

static sp_status set_pressure(const sp_products *p, const double *separation, const double *error, sp_gradient *g,
                              sp_error *err) {
    const int64_t n = 3 * (int64_t)p->net->n_springs;
    sp_compression_response r = {0};
    double size = 0;
    sp_status status = sp_partials_make(1, &g->pressure, err);
    if (status == SP_OK)
        status = sp_gradient_compress(p->net, &r, err);
    for (int64_t k = 0; k < n && status == SP_OK; k++) {
        g->pressure.d[0] += separation[k] * r.separation[k];
        g->pressure.error[0] += error[k / 3] * fabs(r.separation[k]);
        size += fabs(separation[k] * r.separation[k]);
    }
    if (status == SP_OK) {
        g->pressure.d[0] += p->by_volume * r.volume;
        g->pressure.error[0] += r.error * (size + fabs(p->by_volume * r.volume));
    }
    sp_free(r.separation);
    return status;
}

static sp_status set_geometry(const sp_products *p, unsigned parameters, const sp_packing *packing, sp_gradient *g,
                              sp_error *err) {
    double *separation = NULL, *error = NULL;
    sp_status status = SP_OK;
    if (parameters & (SP_BY_POSITION | SP_BY_PRESSURE))
        status = sp_gradient_separations(p, packing, &separation, &error, err);
    if (status == SP_OK && separation && (parameters & SP_BY_POSITION))
        status = set_positions(p, separation, error, g, err);
    if (status == SP_OK && separation && (parameters & SP_BY_PRESSURE))
        status = set_pressure(p, separation, error, g, err);
    if (status == SP_OK && (parameters & SP_BY_RADIUS))
        status = sp_gradient_radii(p, packing, &g->radius, err);
    sp_free(separation);
    sp_free(error);
    return status;
}

sp_status sp_gradient_make(const sp_products *p, unsigned parameters, const sp_packing *packing, double law,
                           sp_gradient *out, sp_error *err) {
    sp_gradient g = sp_gradient_none();
    sp_status status = set_stiffnesses(p, parameters, law, &g, err);
    if (status == SP_OK && (parameters & SP_BY_MASS))
        status = set_masses(p, &g, err);
    if (status == SP_OK && (parameters & GEOMETRY))
        status = set_geometry(p, parameters, packing, &g, err);
    if (status == SP_OK)
        *out = g;
    else
        sp_gradient_free(&g);
    return status;
}
