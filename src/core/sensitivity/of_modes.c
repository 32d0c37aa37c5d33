/* Gradients of frequencies. With the modes e of a group and u = M^-1/2 e, the mean of omega^2 has the derivative
 * mean of u.dK u - omega^2 u.dM u: it does not depend on which basis of the group's space the modes are. */
#include "base/base.h"
#include "modes/mode_table.h"
#include "sensitivity/gradient.h"

#include <float.h>
#include <math.h>

/* Largest angle between the space of the modes and that of the exact ones. */
#define ANGLE_MAX 1e-3

static double square(double x) { return x * x; }

static sp_status check(const sp_network *net, const sp_modes *m, int64_t first, int64_t count, sp_error *err) {
    if (!m->vectors || m->dofs != sp_network_dofs(net))
        return sp_fail(err, SP_EINVAL, "modes without vectors, or of another network");
    if (first < m->n_zero || count < 1 || first + count > m->n)
        return sp_fail(err, SP_EINVAL, "modes %lld .. %lld, must be among %lld .. %lld, which are no zero modes",
                       (long long)first, (long long)(first + count - 1), (long long)m->n_zero, (long long)m->n - 1);
    return SP_OK;
}

/* The angle between the spaces, by Davis and Kahan. */
static sp_status find_angle(const sp_network *net, const sp_modes *m, int64_t first, int64_t count, double *angle,
                            sp_error *err) {
    const double top = square(sp_network_omega_bound(net)), gap = sp_modes_gap(m, first, first + count - 1);
    const double residual = (m->residual + 8 * DBL_EPSILON) * top * sqrt((double)count);
    *angle = gap > 0 ? residual / gap : HUGE_VAL;
    if (*angle <= ANGLE_MAX)
        return SP_OK;
    return sp_fail(err, SP_EREFUSED,
                   "another mode is so close to omega = %.10g .. %.10g that their derivatives cannot be told apart: "
                   "take it into the group",
                   m->omega[first], m->omega[first + count - 1]);
}

static const double *mode_of(const sp_modes *m, int64_t row) { return m->vectors + (row - m->n_rattler) * m->dofs; }

/* Displacements of a mode, M^-1/2 e. */
static void displace(const sp_network *net, const double *e, double *u) {
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        u[k] = e[k] / sqrt(net->mass[k]);
}

static void add_mode(const sp_network *net, const sp_modes *m, int64_t row, double share, const double *u,
                     sp_products *p) {
    const double *e = mode_of(m, row);
    for (int32_t k = 0; k < net->n_springs; k++) {
        double x[SP_LOCAL_MAX];
        sp_products_local(net, &net->springs[k], u, x);
        sp_products_add(p, k, share, x, x);
    }
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        p->mass[k / net->dof] -= share * square(m->omega[row]) * square(e[k]);
}

/* The space is off by an angle, the vectors by that and by rounding. */
static void set_errors(const sp_network *net, double angle, double value, double value_error, sp_products *p) {
    const double off = 2 * angle + angle * angle + 1e-13;
    for (int32_t k = 0; k < net->n_springs; k++)
        for (int t = 0; t < 2; t++)
            p->error[2 * (int64_t)k + t] = off * sp_products_mobility(net, &net->springs[k], t == 1);
    for (int32_t k = 0; k < net->n; k++)
        p->mass_error[k] = off * value + value_error;
}

sp_status sp_sensitivity_modes(const sp_network *net, const sp_modes *modes, int64_t first, int64_t count,
                               unsigned parameters, const sp_packing *packing, sp_gradient *out, sp_error *err) {
    sp_products p = {0};
    sp_gradient g = sp_gradient_none();
    double angle = 0, value = 0, error = 0, *u = NULL;
    sp_status status = sp_gradient_check(net, parameters, packing, err);
    if (status == SP_OK)
        status = check(net, modes, first, count, err);
    if (status == SP_OK)
        status = find_angle(net, modes, first, count, &angle, err);
    if (status == SP_OK)
        status = sp_products_make(net, sp_gradient_whole(net, parameters), &p, err);
    if (status != SP_OK)
        return status;
    u = sp_alloc((size_t)modes->dofs, sizeof *u);
    if (!u)
        status = sp_fail_memory(err, (size_t)modes->dofs * sizeof *u);
    for (int64_t row = first; row < first + count && status == SP_OK; row++) {
        displace(net, mode_of(modes, row), u);
        add_mode(net, modes, row, 1 / (double)count, u, &p);
        value += square(modes->omega[row]) / (double)count;
        error += (2 * modes->omega[row] + modes->error[row]) * modes->error[row] / (double)count;
    }
    if (status == SP_OK) {
        set_errors(net, angle, value, error, &p);
        status = sp_gradient_make(&p, parameters, packing, value, &g, err);
    }
    sp_free(u);
    sp_products_free(&p);
    if (status == SP_OK) {
        *out = g;
        out->value = value;
        out->error = error;
    }
    return status;
}
