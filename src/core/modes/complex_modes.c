/* Modes of a network with prestress and friction. Its A = M^-1/2 J M^-1/2 is not symmetric, so that omega^2 may be
 * complex: the motions of such a pair oscillate and grow, or oscillate and decay. */
#include "base/base.h"
#include "linalg/arrays.h"
#include "modes/count.h"
#include "modes/mode_table.h"

#include <complex.h>
#undef I
#include <math.h>
#include <sonopack/modes.h>

typedef double complex number;

static number number_of(double re, double im) { return re + im * _Complex_I; }

/* How far omega^2 = z may be from a centre. The eigenvalues of discs that touch may be anywhere in them: within the sum
 * of their diameters. */
static sp_status find_reach(const sp_discs *d, double *reach, sp_error *err) {
    int64_t *owner = sp_alloc((size_t)d->n, sizeof *owner);
    double *sum = sp_alloc((size_t)d->n, sizeof *sum);
    sp_status status = owner && sum ? sp_discs_connect(d, owner, err)
                                    : sp_fail_memory(err, (size_t)d->n * (sizeof *owner + sizeof *sum));
    for (int64_t k = 0; k < d->n && status == SP_OK; k++)
        sum[owner[k]] += 2 * d->radius[k];
    for (int64_t k = 0; k < d->n && status == SP_OK; k++) {
        const bool alone = sum[owner[k]] == 2 * d->radius[k];
        reach[k] = alone ? d->radius[k] : sum[owner[k]];
    }
    sp_free(owner);
    sp_free(sum);
    return status;
}

/* Bound of the error of s = sqrt(z): |s - s'| |s + s'| = |z - z'|. */
static double root_error(double size, double reach) {
    return reach < size ? sqrt(size) - sqrt(size - reach) : sqrt(reach);
}

static void add_row(sp_complex_modes *m, number exponent, double error, double cosine, double sine) {
    m->omega[m->n] = cimag(exponent);
    m->growth[m->n] = creal(exponent);
    m->error[m->n] = error;
    m->cosine[m->n] = cosine;
    m->sine[m->n++] = sine;
}

/* Of a real eigenvalue the signal is weight sin(omega t)/omega, or weight cos(omega t) for displacements. */
static void add_real(const sp_discs *d, int64_t k, bool moved, double reach, sp_complex_modes *m) {
    const double z = d->re[k], s = sqrt(fabs(z)), weight = d->to[k] * d->from[k], error = root_error(fabs(z), reach);
    if (z >= 0) {
        add_row(m, number_of(0, s), error, moved ? weight : 0, moved || s == 0 ? 0 : weight / s);
        return;
    }
    add_row(m, -s, error, moved ? 0.5 * weight : -0.5 * weight / s, 0);
    add_row(m, s, error, moved ? 0.5 * weight : 0.5 * weight / s, 0);
}

/* Of a pair k, k + 1 it is Re(weight f(z)), f = sin(s t)/s or cos(s t), s = sqrt(z) = omega + i growth. */
static void add_pair(const sp_discs *d, int64_t k, bool moved, double reach, sp_complex_modes *m) {
    const double *to = d->to + k, *from = d->from + k;
    const number z = number_of(d->re[k], d->im[k]), s = csqrt(z);
    const number weight = number_of(to[0] * from[0] + to[1] * from[1], to[1] * from[0] - to[0] * from[1]);
    const number g = moved ? 0.5 * weight : weight / (2 * _Complex_I * s);
    const double sign = moved ? 1 : -1, error = root_error(cabs(z), reach);
    add_row(m, number_of(-cimag(s), creal(s)), error, creal(g), -cimag(g));
    add_row(m, number_of(cimag(s), creal(s)), error, sign * creal(g), sign * cimag(g));
    m->pairs++;
}

static sp_status collect(const sp_network *net, const sp_discs *d, sp_source source, sp_complex_modes *m,
                         sp_error *err) {
    const bool moved = source == SP_SOURCE_DISPLACEMENT;
    double *reach = sp_alloc((size_t)d->n, sizeof *reach);
    sp_status status = reach ? find_reach(d, reach, err) : sp_fail_memory(err, (size_t)d->n * sizeof *reach);
    m->rattlers = (int64_t)net->rattlers * net->dof;
    for (int64_t k = 0; k < m->rattlers && status == SP_OK; k++)
        add_row(m, 0, 0, 0, 0);
    for (int64_t k = 0; k < d->n && status == SP_OK; k++) {
        if (d->im[k] == 0)
            add_real(d, k, moved, reach[k], m);
        else if (d->im[k] > 0)
            add_pair(d, k, moved, reach[k], m);
    }
    sp_free(reach);
    return status;
}

/* By omega and then growth; rattlers stay first. */
static sp_status sort_modes(const sp_complex_modes *m, sp_error *err) {
    const int64_t first = m->rattlers;
    double *const columns[] = {m->omega + first,  m->growth + first, m->error + first,
                               m->cosine + first, m->sine + first,   NULL};
    return sp_arrays_sort(m->n - first, columns, err);
}

static sp_status find_discs(const sp_network *net, sp_source source, sp_discs *d, sp_error *err) {
    const size_t n = (size_t)sp_network_dofs(net);
    double *from = sp_alloc(n, sizeof *from), *to = sp_alloc(n, sizeof *to);
    sp_status status =
        from && to ? sp_modes_walls(net, source, from, to, err) : sp_fail_memory(err, 2 * n * sizeof *to);
    if (status == SP_OK)
        status = sp_network_discs(net, from, to, d, err);
    sp_free(from);
    sp_free(to);
    return status;
}

sp_complex_modes sp_complex_modes_none(void) { return (sp_complex_modes){0}; }

void sp_complex_modes_free(sp_complex_modes *m) {
    sp_free(m->omega); /* all arrays are one block */
    *m = sp_complex_modes_none();
}

sp_status sp_complex_modes_make(const sp_network *net, sp_source source, sp_complex_modes *out, sp_error *err) {
    sp_complex_modes m = sp_complex_modes_none();
    sp_discs d = {0};
    const int64_t n = sp_network_dofs(net);
    if (n > SP_STABILITY_MAX)
        return sp_fail(err, SP_EREFUSED, "%lld degrees of freedom, must be at most %d for modes of a nonsymmetric K",
                       (long long)n, SP_STABILITY_MAX);
    const size_t rows = 2 * (size_t)n + (size_t)net->rattlers * (size_t)net->dof; /* if all are negative */
    const sp_array arrays[] = {{&m.omega, rows},  {&m.growth, rows}, {&m.error, rows},
                               {&m.cosine, rows}, {&m.sine, rows},   {0}};
    double *block;
    sp_status status = sp_arrays_make(arrays, &block, err);
    if (status == SP_OK)
        status = find_discs(net, source, &d, err);
    if (status == SP_OK)
        status = collect(net, &d, source, &m, err);
    if (status == SP_OK)
        status = sort_modes(&m, err);
    sp_discs_free(&d);
    if (status == SP_OK)
        *out = m;
    else
        sp_complex_modes_free(&m);
    return status;
}
