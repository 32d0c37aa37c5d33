/* Gradients of moduli. The stress a of strain b is the sum of E_c(x_a, x_b) over the volume, where x_a is the affine
 * displacement of strain a at a spring with what the grains add at equilibrium. These are stationary, so that dC_ab is
 * the sum of dE_c(x_a, x_b), and of the change of the affine displacements. */
#include "base/base.h"
#include "base/vector.h"
#include "elastic/moduli.h"
#include "elastic/strain.h"
#include "sensitivity/gradient.h"
#include "table/quantity.h"

#include <math.h>

typedef struct responses {
    sp_equilibrium e;
    const sp_network *net;
    double *u[STRAINS_3D];  /* what the grains add, [dofs]; NULL: not computed */
    double off[STRAINS_3D]; /* energy norm of the error of u */
} responses;

static void responses_free(responses *r) {
    for (int a = 0; a < STRAINS_3D; a++)
        sp_free(r->u[a]);
    sp_equilibrium_free(&r->e);
}

/* The energy norm of the error: that of K^-1 r for the residual r and rounding errors of changing signs. A factor 4 for
 * what signs may do. */
static void find_error(responses *r, int strain, const double *f, double *work) {
    const int64_t n = sp_network_dofs(r->net);
    double *rest = work, *size = work + n, *x = work + 2 * n;
    const double noise = sp_strain_noise(r->net);
    sp_equilibrium_residual(&r->e, f, r->u[strain], rest);
    sp_strain_rounding(r->net, strain, r->u[strain], size, NULL);
    for (int64_t k = 0; k < n; k++)
        rest[k] += (k * 2654435761 >> 7 & 1 ? 1 : -1) * noise * size[k];
    sp_equilibrium_apply(&r->e, rest, x);
    r->off[strain] = 4 * sqrt(fmax(sp_dot(n, rest, x), 0));
}

static sp_status respond(responses *r, int strain, sp_error *err) {
    const int64_t n = sp_network_dofs(r->net);
    double residual = 0, *work = sp_alloc((size_t)n, 4 * sizeof *work), *f = work + 3 * n;
    if (r->u[strain]) {
        sp_free(work);
        return SP_OK;
    }
    r->u[strain] = sp_alloc((size_t)n, sizeof(double));
    if (!work || !r->u[strain]) {
        sp_free(work);
        return sp_fail_memory(err, 5 * (size_t)n * sizeof *work);
    }
    const double scale = sp_strain_load(r->net, strain, f);
    sp_status status = sp_equilibrium_solve(&r->e, f, scale, r->u[strain], &residual, err);
    if (status == SP_OK)
        find_error(r, strain, f, work);
    sp_free(work);
    return status;
}

/* Displacements of a spring in strain a. */
static void displace(const responses *r, int strain, const sp_spring *s, int32_t k, double x[SP_LOCAL_MAX]) {
    double gap[3];
    for (int a = 0; a < SP_LOCAL_MAX; a++)
        x[a] = 0;
    sp_products_local(r->net, s, r->u[strain], x);
    sp_strain_displacement(r->net, strain, s->n, r->net->length[k], gap);
    for (int a = 0; a < r->net->dim; a++)
        x[a] += gap[a];
}

/* Force of a spring on its far end. */
static void force_of(const sp_network *net, const sp_spring *s, const double x[SP_LOCAL_MAX], double out[3]) {
    double across[3];
    const double along = sp_products_along(net, s->n, x);
    sp_products_across(net, s->n, x, across);
    for (int a = 0; a < 3; a++) {
        const double tangent = net->dim == 2 ? across[0] * (a == 0 ? -s->n[1] : a == 1 ? s->n[0] : 0) : across[a];
        const double transverse = a < net->dim ? x[a] - along * s->n[a] : 0;
        out[a] = s->kn * along * s->n[a] + s->kt * tangent + s->kp * transverse;
    }
}

/* The affine displacement of strain a is linear in the separation: its change does the work of the force of b. */
static void add_pull(const sp_network *net, int strain, double weight, const double force[3], double out[3]) {
    for (int axis = 0; axis < net->dim; axis++) {
        const double unit[3] = {axis == 0, axis == 1, axis == 2};
        double moved[3];
        sp_strain_displacement(net, strain, unit, 1, moved);
        out[axis] += weight * (moved[0] * force[0] + moved[1] * force[1] + moved[2] * force[2]);
    }
}

/* Adds weight x the products of C_ab. */
static void add_component(const responses *r, int a, int b, double weight, sp_products *p) {
    const sp_network *net = r->net;
    const double share = weight / sp_strain_volume(net);
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        double x[SP_LOCAL_MAX], y[SP_LOCAL_MAX], force[3];
        displace(r, a, s, k, x);
        displace(r, b, s, k, y);
        sp_products_add(p, k, share, x, y);
        if (p->pull) {
            force_of(net, s, y, force);
            add_pull(net, a, share, force, p->pull + 3 * (int64_t)k);
            force_of(net, s, x, force);
            add_pull(net, b, share, force, p->pull + 3 * (int64_t)k);
        }
        /* a stretch is off by at most the energy norm over the root of its stiffness */
        for (int t = 0; t < 2; t++) {
            const double stiffness = t == 0 ? s->kn : s->kt;
            double tx[3] = {sp_products_along(net, s->n, x)}, ty[3] = {sp_products_along(net, s->n, y)};
            if (stiffness == 0)
                continue;
            if (t == 1) {
                sp_products_across(net, s->n, x, tx);
                sp_products_across(net, s->n, y, ty);
            }
            const double root = sqrt(stiffness), one = sp_norm(t == 0 ? 1 : 3, tx), two = sp_norm(t == 0 ? 1 : 3, ty);
            p->error[2 * (int64_t)k + t] += fabs(share) * ((one * r->off[b] + two * r->off[a]) / root +
                                                           r->off[a] * r->off[b] / stiffness + 1e-14 * one * two);
        }
    }
}

/* ---- which component ------------------------------------------------------------------------------------------ */

typedef struct component {
    int a, b, other; /* C_ab; other >= 0: half of it and of C_other,other */
} component;

static bool component_of(int dim, sp_modulus which, component *out) {
    const int up = dim == 3 ? STRAIN_33_3D : STRAIN_22;
    const component space[] = {{STRAIN_11, STRAIN_11, -1},
                               {STRAIN_11, STRAIN_22, -1},
                               {STRAIN_22, STRAIN_22, -1},
                               {STRAIN_33_3D, STRAIN_33_3D, -1},
                               {STRAIN_11, STRAIN_33_3D, -1},
                               {STRAIN_22, STRAIN_33_3D, -1},
                               {STRAIN_23_3D, STRAIN_23_3D, -1},
                               {STRAIN_13_3D, STRAIN_13_3D, -1},
                               {STRAIN_12_3D, STRAIN_12_3D, -1},
                               {up, up, -1},
                               {STRAIN_23_3D, STRAIN_23_3D, STRAIN_13_3D}};
    if ((int)which < 0 || (int)which >= SP_MODULUS_COUNT)
        return false;
    *out = space[which];
    if (dim == 3)
        return true;
    if (which == SP_MODULUS_C33 || which == SP_MODULUS_CT)
        *out = (component){STRAIN_SHEAR, STRAIN_SHEAR, -1};
    const bool chain = which == SP_MODULUS_C22 || which == SP_MODULUS_CL;
    return dim == 1 ? chain : which <= SP_MODULUS_C33 || which >= SP_MODULUS_CL;
}

bool sp_modulus_exists(int dim, sp_modulus which) {
    component of;
    return component_of(dim, which, &of);
}

const char *sp_modulus_name(sp_modulus which) {
    static const char *const names[] = {"C11", "C12", "C22", "C33", "C13", "C23", "C44", "C55", "C66", "c_l", "c_t"};
    return names[which];
}

double sp_modulus_value(const sp_moduli *m, sp_modulus which) {
    const char *symbol = sp_modulus_name(which);
    return sp_quantity_value(sp_quantity_next(sp_moduli_quantities, &symbol), m);
}

static double error_of(const sp_moduli *m, sp_modulus which, double density) {
    const double errors[] = {m->error11, m->error12, m->error22, m->error33, m->error13,
                             m->error23, m->error44, m->error55, m->error66};
    if (which < SP_MODULUS_CL)
        return errors[which];
    const bool space = isfinite(m->c44);
    const double shear = space ? 0.5 * (m->error44 + m->error55) : m->error33;
    const double off = which == SP_MODULUS_CT ? shear : space ? m->error33 : m->error22;
    return off / (2 * density * sp_modulus_value(m, which));
}

static sp_status differentiate(responses *r, const sp_moduli *m, double density, sp_modulus which, unsigned parameters,
                               const sp_packing *packing, sp_gradient *out, sp_error *err) {
    component of;
    sp_products p = {0};
    if (!component_of(r->net->dim, which, &of))
        return sp_fail(err, SP_EINVAL, "%s does not exist in %d dimensions", sp_modulus_name(which), r->net->dim);
    const double value = sp_modulus_value(m, which), error = error_of(m, which, density);
    const bool speed = which >= SP_MODULUS_CL;
    if (!isfinite(value) || (speed && !(value > 0)))
        return sp_fail(err, SP_EREFUSED, "%s is %g for this packing: it has no derivative%s", sp_modulus_name(which),
                       value,
                       speed && !isfinite(density) ? "; the margin leaves nothing of the box for its density" : "");
    const double weight = (speed ? 1 / (2 * density * value) : 1) * (of.other < 0 ? 1 : 0.5);
    sp_status status = respond(r, of.a, err);
    if (status == SP_OK)
        status = respond(r, of.b, err);
    if (status == SP_OK && of.other >= 0)
        status = respond(r, of.other, err);
    if (status == SP_OK)
        status = sp_products_make(r->net, sp_gradient_whole(r->net, parameters), &p, err);
    if (status == SP_OK) {
        add_component(r, of.a, of.b, weight, &p);
        if (of.other >= 0)
            add_component(r, of.other, of.other, weight, &p);
        p.by_volume = speed ? -0.5 * value : -value;
        status = sp_gradient_make(&p, parameters, packing, speed ? 0.5 * value : value, out, err);
    }
    if (status == SP_OK) {
        out->value = value;
        out->error = error;
    }
    sp_products_free(&p);
    return status;
}

sp_status sp_sensitivity_moduli(const sp_network *net, double density, int32_t count, const sp_modulus *of,
                                unsigned parameters, const sp_packing *packing, sp_gradient *out, sp_error *err) {
    responses r = {.e = sp_equilibrium_none(), .net = net};
    sp_moduli m;
    sp_status status = sp_gradient_check(net, parameters, packing, err);
    if (status == SP_OK && count < 1)
        status = sp_fail(err, SP_EINVAL, "%d moduli, must be 1 or more", count);
    sp_gradient *g = status == SP_OK ? sp_alloc((size_t)count, sizeof *g) : NULL;
    if (status == SP_OK && !g)
        status = sp_fail_memory(err, (size_t)count * sizeof *g);
    if (status == SP_OK)
        status = sp_equilibrium_make(net, &r.e, err);
    if (status == SP_OK)
        status = sp_moduli_of(&r.e, density, &m, err);
    for (int32_t k = 0; k < count && status == SP_OK; k++)
        status = differentiate(&r, &m, density, of[k], parameters, packing, &g[k], err);
    for (int32_t k = 0; k < count && g; k++) {
        if (status == SP_OK)
            out[k] = g[k];
        else
            sp_gradient_free(&g[k]);
    }
    sp_free(g);
    responses_free(&r);
    return status;
}
