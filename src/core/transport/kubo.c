/* The diffusivity of energy from eigenmodes and the operator of its current. */
#include "base/base.h"
#include "network/network_cell.h"
#include "numeric/statistics.h"
#include "transport/across.h"

#include <math.h>
#include <sonopack/transport.h>
#include <string.h>

static const double REACH = 4.5; /* standard deviations at which the Gaussians end */
static const double MODES_LEAST = 10, LEVELS_LEAST = 3;
static const double SHIFT_MOST = 1 / 3.0; /* of d */
static const double BRIEF = 0.3;          /* of omega: width of delta for the speed, about a period */
static const int MODES_FOR_SPEED = 48;    /* modes n of the sum for the speed */

sp_kubo_options sp_kubo_options_default(void) { return (sp_kubo_options){.axis = -1, .width = 0.1, .smear = 0.1}; }

enum { DOF_MAX = 6, GROUPS = 8 };

/* C = [A, x]: an antisymmetric matrix with the blocks A_ij (x_j - x_i) of the springs, where j is the image that
 * touches i. */
typedef struct current {
    const sp_network *net;
    double *block; /* [n_bulk][dof][dof] rows of the first grain, columns of the second */
    double *along; /* [dofs] C e */
} current;

static void current_free(current *c) {
    sp_free(c->block);
    sp_free(c->along);
}

/* A_ij of one spring: its stiffness times the stretches by unit displacements of i and of j. */
static void make_block(const sp_network *net, const sp_spring *c, double distance, double *block) {
    const shape s = sp_shape_of(net);
    const double nothing[DOF_MAX] = {0}, *mi = net->mass + (int64_t)c->i * net->dof,
                 *mj = net->mass + (int64_t)c->j * net->dof;
    for (int a = 0; a < net->dof; a++)
        for (int b = 0; b < net->dof; b++) {
            double one[DOF_MAX] = {0}, other[DOF_MAX] = {0};
            one[a] = other[b] = 1;
            const stretch e = stretch_of(s, c, one, NULL), f = stretch_of(s, c, nothing, other);
            const double k = c->kn * e.normal[0] * f.normal[0] + sp_across(&s, c, &e, &f);
            block[a * net->dof + b] = k * distance / sqrt(mi[a] * mj[b]);
        }
}

static sp_status current_make(const sp_network *net, int axis, current *out, sp_error *err) {
    const size_t size = (size_t)net->dof * (size_t)net->dof;
    current c = {.net = net};
    c.block = sp_alloc((size_t)net->n_bulk, size * sizeof *c.block);
    c.along = sp_alloc((size_t)sp_network_dofs(net), sizeof *c.along);
    if (!c.block || !c.along) {
        current_free(&c);
        return sp_fail_memory(err, (size_t)net->n_bulk * size * sizeof *c.block);
    }
    for (int32_t k = 0; k < net->n_bulk; k++)
        make_block(net, &net->springs[k], net->length[k] * net->springs[k].n[axis], c.block + (size_t)k * size);
    *out = c;
    return SP_OK;
}

/* c->along = C e */
static void current_apply(const current *c, const double *e) {
    const sp_network *net = c->net;
    const int dof = net->dof;
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        c->along[k] = 0;
    for (int32_t k = 0; k < net->n_bulk; k++) {
        const double *block = c->block + (int64_t)k * dof * dof;
        const int64_t i = (int64_t)net->springs[k].i * dof, j = (int64_t)net->springs[k].j * dof;
        for (int a = 0; a < dof; a++)
            for (int b = 0; b < dof; b++) {
                c->along[i + a] += block[a * dof + b] * e[j + b];
                c->along[j + b] -= block[a * dof + b] * e[i + a];
            }
    }
}

static double gauss(double x, double width) { return exp(-0.5 * x * x / (width * width)) / (sqrt(2 * M_PI) * width); }

/* Sums of g_n, and of g_n times the sum over m for three widths of delta; those of the widest have fewer modes n. */
typedef struct sums {
    double modes, wide, narrow, brief_modes, brief;
} sums;

static const double *vector_of(const sp_modes *modes, int64_t n) {
    return modes->vectors + (n - modes->n_rattler) * modes->dofs;
}

/* Eight sums side by side: one after the other they would wait for each other. */
static double product(int64_t n, const double *restrict a, const double *restrict b) {
    enum { LANES = 8 };
    double sum[LANES] = {0}, rest = 0;
    int64_t k = 0;
    for (; k + LANES <= n; k += LANES)
        for (int q = 0; q < LANES; q++)
            sum[q] += a[k + q] * b[k + q];
    for (; k < n; k++)
        rest += a[k] * b[k];
    for (int q = 0; q < LANES; q++)
        rest += sum[q];
    return rest;
}

/* pi |C_nm|^2/(omega_n + omega_m)^2, with C e_n in c->along. */
static double weight_of(const current *c, const sp_modes *modes, int64_t n, int64_t m) {
    const double both = modes->omega[m] + modes->omega[n];
    const double element = product(modes->dofs, vector_of(modes, m), c->along);
    return M_PI * element * element / (both * both);
}

/* Adds mode n: its matrix elements with all modes m in reach. */
static void add_mode(const current *c, const sp_modes *modes, int64_t n, double g, double smear, double brief,
                     sums *out) {
    const double reach = REACH * fmax(smear, brief);
    double once = 0;
    current_apply(c, vector_of(modes, n));
    for (int64_t m = modes->n_zero; m < modes->n; m++) {
        const double gap = modes->omega[m] - modes->omega[n];
        if (m == n || fabs(gap) > reach)
            continue;
        const double weight = weight_of(c, modes, n, m);
        out->wide += g * weight * gauss(gap, smear);
        out->narrow += g * weight * gauss(gap, 0.5 * smear);
        once += brief > 0 ? weight * gauss(gap, brief) : 0;
    }
    out->modes += g;
    out->brief += g * once;
    out->brief_modes += brief > 0 ? g : 0;
}

/* Sums over the modes of the band about a frequency, in groups of every GROUPS-th mode. */
static void sum_groups(const current *c, const sp_modes *modes, double omega, const sp_kubo_options *opt,
                       sums out[GROUPS]) {
    const double width = opt->width * omega;
    int64_t first = modes->n_zero, end = modes->n;
    while (first < end && modes->omega[first] <= omega - REACH * width)
        first++;
    while (end > first && modes->omega[end - 1] >= omega + REACH * width)
        end--;
    const int64_t stride = (end - first) / MODES_FOR_SPEED + 1;
    memset(out, 0, GROUPS * sizeof *out);
    for (int64_t n = first; n < end; n++) {
        const double x = (modes->omega[n] - omega) / width;
        const bool brief = (n - first) % stride == stride / 2;
        add_mode(c, modes, n, exp(-0.5 * x * x), opt->smear * omega, brief ? BRIEF * omega : 0,
                 &out[(brief ? n / stride : n) % GROUPS]);
    }
}

static sp_status check(const sp_network *net, const sp_modes *modes, int32_t n, const double *omega,
                       const sp_kubo_options *opt, sp_error *err) {
    if (!modes->vectors || modes->first > 0 || modes->dofs != sp_network_dofs(net) ||
        modes->n - modes->n_rattler != modes->dofs)
        return sp_fail(err, SP_EINVAL, "kubo: all modes of the network are needed, with vectors");
    for (int32_t l = 0; l < n; l++)
        if (!(omega[l] > 0 && isfinite(omega[l])))
            return sp_fail(err, SP_EINVAL, "kubo: frequency %g, must be above 0", omega[l]);
    if (!(opt->width >= 1e-3 && opt->width <= 0.2) || !(opt->smear >= 1e-3 && opt->smear <= 0.2))
        return sp_fail(err, SP_EINVAL, "kubo: width %g and smear %g, must be 0.001 .. 0.2", opt->width, opt->smear);
    if (opt->axis < -1 || opt->axis >= net->dim)
        return sp_fail(err, SP_EINVAL, "kubo: axis %d, must be 0 .. %d", opt->axis, net->dim - 1);
    if (opt->axis >= 0 && !sp_network_periodic(net, opt->axis))
        return sp_fail(err, SP_EREFUSED, "kubo: walls across axis %d stop the energy: only axes with a period",
                       opt->axis);
    return sp_network_need_symmetry(net, "the formula of Kubo", err);
}

/* Sums of all groups, or of all but one. */
static sums total(const sums group[GROUPS], int without) {
    sums all = {0};
    for (int g = 0; g < GROUPS; g++) {
        if (g == without)
            continue;
        all.modes += group[g].modes;
        all.wide += group[g].wide;
        all.narrow += group[g].narrow;
        all.brief += group[g].brief;
        all.brief_modes += group[g].brief_modes;
    }
    return all;
}

static double d_of(const sums *s) { return s->wide / s->modes; }

/* Mean square of the speed along the axis: without scattering D = v^2 sqrt(pi/2) over the width of delta. */
static double square_of(const sums *s, double omega) {
    return s->brief / s->brief_modes * BRIEF * omega / sqrt(M_PI_2);
}

/* Adds one axis. `speed` collects squares, and errors are added up: those of two axes need not be independent. */
static void add_sums(const sums group[GROUPS], const sp_kubo_options *opt, double omega, sp_kubo *out) {
    const sums s = total(group, -1);
    double d[GROUPS], square[GROUPS];
    /* levels within the full width of the narrower delta, 2.5 standard deviations */
    const double levels = s.modes / (sqrt(2 * M_PI) * opt->width) * 2.5 * 0.5 * opt->smear;
    const double enough = s.modes >= MODES_LEAST && levels >= LEVELS_LEAST ? 1 : NAN;
    for (int g = 0; g < GROUPS; g++) {
        const sums rest = total(group, g);
        d[g] = d_of(&rest);
        square[g] = square_of(&rest, omega);
    }
    out->omega = omega;
    out->modes = s.modes;
    out->d += enough * d_of(&s);
    out->d_err += enough * (GROUPS - 1) * sp_standard_error(GROUPS, d);
    out->d_shift += enough * (s.narrow - s.wide) / s.modes;
    out->speed += enough * square_of(&s, omega);
    out->speed_err += enough * (GROUPS - 1) * sp_standard_error(GROUPS, square);
}

static sp_status add_axis(const sp_network *net, const sp_modes *modes, int32_t n, const double *omega, int axis,
                          const sp_kubo_options *opt, sp_kubo *out, sp_error *err) {
    current c = {0};
    sums group[GROUPS];
    const sp_status status = current_make(net, axis, &c, err);
    for (int32_t l = 0; l < n && status == SP_OK; l++) {
        sum_groups(&c, modes, omega[l], opt, group);
        add_sums(group, opt, omega[l], &out[l]);
    }
    current_free(&c);
    return status;
}

static void finish(const sp_network *net, int axes, sp_kubo *out) {
    out->d /= axes;
    out->d_shift /= axes;
    out->d_err = hypot(out->d_err / axes, SP_KUBO_SHIFTS * out->d_shift);
    out->speed = sqrt(net->dim * out->speed / axes);
    out->speed_err *= 0.5 * net->dim / axes / out->speed;
    if (!(fabs(out->d_shift) <= SHIFT_MOST * out->d))
        out->d = out->d_err = out->d_shift = NAN;
}

sp_status sp_kubo_make(const sp_network *net, const sp_modes *modes, int32_t n, const double *omega,
                       const sp_kubo_options *opt, sp_kubo *out, sp_error *err) {
    int axes = 0;
    sp_status status = check(net, modes, n, omega, opt, err);
    for (int32_t l = 0; l < n && status == SP_OK; l++)
        out[l] = (sp_kubo){0};
    for (int axis = 0; axis < net->dim && status == SP_OK; axis++)
        if (opt->axis == axis || (opt->axis < 0 && sp_network_periodic(net, axis))) {
            status = add_axis(net, modes, n, omega, axis, opt, out, err);
            axes++;
        }
    if (status == SP_OK && axes == 0)
        return sp_fail(err, SP_EREFUSED, "kubo: there are walls across every axis");
    for (int32_t l = 0; l < n && status == SP_OK; l++)
        finish(net, axes, &out[l]);
    return status;
}
