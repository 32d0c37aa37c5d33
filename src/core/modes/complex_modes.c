/* Modes of a network with prestress and friction. Its A = M^-1/2 J M^-1/2 is not symmetric, so that omega^2 may be
 * complex: the motions of such a pair oscillate and grow, or oscillate and decay. */
#include "base/base.h"
#include "base/vector.h"
#include "linalg/arrays.h"
#include "linalg/two_sided.h"
#include "modes/count.h"
#include "modes/mode_table.h"
#include "network/null_motions.h"
#include "network/spins.h"

#include <complex.h>
#undef I
#include <math.h>
#include <sonopack/modes.h>
#include <string.h>

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

/* Discs of eigenvalues, of which all below `limit` are known, and of those that count as zero. */
typedef struct spectrum {
    sp_discs d;
    double *reach;  /* [d.n] as find_reach has it; negative: not listed */
    double limit;   /* of the real part; discs that reach it say nothing */
    sp_two_sided t; /* vectors, if there are any */
} spectrum;

static void add_rows(const spectrum *s, sp_source source, sp_complex_modes *m) {
    const bool moved = source == SP_SOURCE_DISPLACEMENT;
    const sp_discs *d = &s->d;
    for (int64_t k = 0; k < d->n; k++) {
        if (s->reach[k] >= 0 && d->im[k] == 0)
            add_real(d, k, moved, s->reach[k], m);
        else if (s->reach[k] >= 0 && d->im[k] > 0)
            add_pair(d, k, moved, s->reach[k], m);
    }
}

/* By omega and then growth; rattlers stay first. */
static sp_status sort_modes(const sp_complex_modes *m, sp_error *err) {
    const int64_t first = m->rattlers;
    double *const columns[] = {m->omega + first,  m->growth + first, m->error + first,
                               m->cosine + first, m->sine + first,   NULL};
    return sp_arrays_sort(m->n - first, columns, err);
}

/* A is scaled by the masses, and its symmetric part factored below the lowest eigenvalues that are expected. */
static sp_status find_some(const sp_network *net, int64_t wanted, int threads, spectrum *s, sp_error *err) {
    const double n = (double)sp_network_dofs(net);
    counter c = {0};
    sp_sparse a = {0};
    sp_status status = sp_counter_make(net, &c, err);
    sp_two_sided_spec spec = {.wanted = wanted, .more = 8 + wanted / 4, .goal = 1e-11 * c.top, .noise = c.noise};
    if (status == SP_OK && threads > 1)
        status = sp_ldl_share(c.ldl, threads, err);
    if (status == SP_OK)
        status = sp_network_assemble_whole(net, &a, err);
    if (status == SP_OK) {
        sp_scale_by_masses(net, &a);
        status = SP_EREFUSED;
    }
    double sigma = -1e-3 * c.top * pow((double)wanted / n, 2.0 / net->dim);
    for (int k = 0; k < 16 && status == SP_EREFUSED; k++, sigma *= 1.9) { /* pivots may vanish, values be negative */
        status = sp_ldl_factor(c.ldl, sigma, err);
        if (status == SP_OK && sp_ldl_negative(c.ldl) > 0)
            status = sp_fail(err, SP_EREFUSED, "the network is unstable: symmetric part below %.3g", sigma);
    }
    if (status == SP_OK)
        status = sp_two_sided_make(c.ldl, &a, &spec, &s->t, err);
    if (status == SP_OK)
        status = sp_two_sided_enclose(&s->t, c.ldl, &a, &spec, &s->limit, &s->d, err);
    sp_counter_free(&c);
    sp_sparse_free(&a);
    return status;
}

/* All eigenvalues, or the `some` lowest ones and more. */
static sp_status spectrum_make(const sp_network *net, const sp_modes_options *opt, int64_t some, spectrum *s,
                               sp_error *err) {
    const size_t n = (size_t)sp_network_dofs(net);
    double *from = sp_alloc(n, sizeof *from), *to = sp_alloc(n, sizeof *to);
    sp_status status =
        from && to ? sp_modes_walls(net, opt->source, from, to, err) : sp_fail_memory(err, 2 * n * sizeof *to);
    *s = (spectrum){.limit = HUGE_VAL};
    if (status == SP_OK)
        status = some ? find_some(net, some, opt->threads, s, err) : sp_network_discs(net, from, to, &s->d, err);
    for (int64_t k = 0; k < s->t.count && status == SP_OK; k++) {
        s->d.from[k] = sp_dot((int64_t)n, s->t.left + k * (int64_t)n, from);
        s->d.to[k] = sp_dot((int64_t)n, s->t.right + k * (int64_t)n, to);
    }
    sp_free(from);
    sp_free(to);
    if (status == SP_OK && !(s->reach = sp_alloc((size_t)s->d.n, sizeof *s->reach)))
        status = sp_fail_memory(err, (size_t)s->d.n * sizeof *s->reach);
    return status == SP_OK ? find_reach(&s->d, s->reach, err) : status;
}

static void spectrum_free(spectrum *s) {
    sp_two_sided_free(&s->t);
    sp_discs_free(&s->d);
    sp_free(s->reach);
}

/* Discs that reach the limit may hold other eigenvalues than their own. */
static void drop_beyond(spectrum *s) {
    const double limit = s->limit;
    for (int64_t k = 0; k < s->d.n; k++)
        if (!(s->d.re[k] + s->reach[k] < limit)) {
            s->limit = fmin(s->limit, s->d.re[k] - s->reach[k]);
            s->reach[k] = -1;
        }
}

/* Spins whose forces balance have less than this fraction of the largest eigenvalue; others are motions like all. */
static const double BALANCED = 1e-6;
static const double APART = 10; /* ratio of other eigenvalues to those of zero motions, at least */

/* Zero motions: the `known` eigenvalues nearest to 0 if they are below `small`, and those whose discs contain 0. */
static sp_status drop_zeros(spectrum *s, int64_t known, double small, int64_t *zeros, sp_error *err) {
    const sp_discs *d = &s->d;
    double past = 0;
    for (; *zeros < known; ++*zeros) {
        int64_t best = -1;
        for (int64_t k = 0; k < d->n; k++)
            if (s->reach[k] >= 0 && (best < 0 || hypot(d->re[k], d->im[k]) < hypot(d->re[best], d->im[best])))
                best = k;
        const double size = best < 0 ? HUGE_VAL : hypot(d->re[best], d->im[best]) + s->reach[best];
        if (size > small)
            break;
        past = fmax(past, size);
        s->reach[best] = -1;
    }
    for (int64_t k = 0; k < d->n; k++) {
        const double size = hypot(d->re[k], d->im[k]);
        if (s->reach[k] >= 0 && size <= s->reach[k]) {
            s->reach[k] = -1;
            ++*zeros;
        } else if (s->reach[k] >= 0 && size - s->reach[k] <= APART * past)
            return sp_fail(err, SP_EREFUSED, "the %lld zero motions cannot be told from one with omega^2 = %.3g",
                           (long long)known, size);
    }
    return SP_OK;
}

/* Keeps the rows of the lowest motions, and of all that share the last omega: the other one of a pair. */
static sp_status cut(sp_complex_modes *m, int64_t lowest, double limit, sp_error *err) {
    int64_t n = lowest;
    m->complete = sqrt(fmax(limit, 0));
    if (m->n < lowest && isinf(limit))
        return sp_fail(err, SP_EINVAL, "%lld lowest motions, must be 1 .. %lld besides zero motions", (long long)lowest,
                       (long long)m->n);
    if (m->complete == 0)
        return sp_fail(err, SP_EREFUSED, "more than %lld motions diverge (omega^2 < 0); ask for more of the lowest",
                       (long long)lowest);
    if (m->n < lowest || !(m->omega[lowest - 1] + m->error[lowest - 1] < m->complete))
        return sp_fail(err, SP_EREFUSED,
                       "%lld motions cannot be proved to be the lowest: only those below omega = %.6g",
                       (long long)lowest, m->complete);
    while (n < m->n && m->omega[n] == m->omega[n - 1])
        n++;
    if (n < m->n)
        m->complete = fmin(m->complete, m->omega[n] - m->error[n]);
    m->n = n;
    m->pairs = 0;
    for (int64_t k = 0; k < n; k++)
        m->pairs += m->growth[k] > 0 && m->omega[k] > 0;
    return SP_OK;
}

sp_complex_modes sp_complex_modes_none(void) { return (sp_complex_modes){0}; }

void sp_complex_modes_free(sp_complex_modes *m) {
    sp_free(m->omega); /* all arrays are one block */
    *m = sp_complex_modes_none();
}

static sp_status too_large(const sp_network *net, sp_error *err) {
    const int64_t n = sp_network_dofs(net);
    return n <= SP_STABILITY_MAX
               ? SP_OK
               : sp_fail(
                     err, SP_EREFUSED,
                     "%lld degrees of freedom, must be at most %d for all modes of a nonsymmetric K, or few of them "
                     "must be wanted (--lowest)",
                     (long long)n, SP_STABILITY_MAX);
}

static sp_status tabulate(const sp_network *net, sp_source source, const spectrum *s, bool rattlers,
                          sp_complex_modes *m, sp_error *err) {
    m->rattlers = rattlers ? (int64_t)net->rattlers * net->dof : 0;
    const size_t rows = 2 * (size_t)s->d.n + (size_t)m->rattlers; /* if all are negative */
    const sp_array arrays[] = {{&m->omega, rows},  {&m->growth, rows}, {&m->error, rows},
                               {&m->cosine, rows}, {&m->sine, rows},   {0}};
    double *block;
    const sp_status status = sp_arrays_make(arrays, &block, err);
    if (status != SP_OK)
        return status;
    m->n = m->rattlers; /* rows of zeros */
    add_rows(s, source, m);
    return sort_modes(m, err);
}

/* The dense solver, where its n^3 is less than the rounds of the other one, whose basis must fit. */
static bool is_dense(const sp_network *net, const sp_modes_options *opt, int64_t wanted) {
    const int64_t n = sp_network_dofs(net);
    const bool small = n <= 400 || 20 * wanted > n;
    return opt->solver == SP_SOLVER_DENSE || 11 * wanted + 100 > n || (opt->solver == SP_SOLVER_AUTO && small);
}

/* The number of motions whose omega^2 is 0 as far as the forces at rest balance: spins of spheres with two contacts,
 * and those of rigid parts. */
static sp_status count_zeros(const sp_network *net, int64_t *count, sp_error *err) {
    sp_null_motions null = {0};
    sp_spin *spin = NULL;
    double axis[3];
    sp_status status = sp_null_motions_make(net, &null, err);
    if (status == SP_OK)
        status = sp_spins_make(net, &spin, err);
    *count = null.rigid;
    for (int32_t i = 0; i < net->n && spin && status == SP_OK; i++)
        *count += sp_spin_axis(&spin[i], axis);
    sp_free(spin);
    sp_null_motions_free(&null);
    return status;
}

/* lowest = 0: all. */
static sp_status make(const sp_network *net, const sp_modes_options *opt, int64_t lowest, sp_complex_modes *out,
                      sp_error *err) {
    sp_complex_modes m = {.complete = HUGE_VAL};
    const double top = sp_network_omega_bound(net);
    spectrum s = {0};
    int64_t known = 0;
    sp_status status = lowest > 0 ? count_zeros(net, &known, err) : SP_OK;
    m.sparse = lowest > 0 && !is_dense(net, opt, lowest + known);
    if (status == SP_OK && !m.sparse)
        status = too_large(net, err);
    if (status == SP_OK)
        status = spectrum_make(net, opt, m.sparse ? lowest + known : 0, &s, err);
    if (status == SP_OK && lowest > 0) {
        drop_beyond(&s);
        status = drop_zeros(&s, known, BALANCED * top * top, &m.zero, err);
    }
    if (status == SP_OK)
        status = tabulate(net, opt->source, &s, lowest == 0, &m, err);
    if (status == SP_OK && lowest > 0)
        status = cut(&m, lowest, s.limit, err);
    m.first = (int64_t)net->rattlers * net->dof - m.rattlers + m.zero;
    spectrum_free(&s);
    if (status == SP_OK)
        *out = m;
    else
        sp_complex_modes_free(&m);
    return status;
}

sp_status sp_complex_modes_make(const sp_network *net, sp_source source, sp_complex_modes *out, sp_error *err) {
    const sp_modes_options opt = {.source = source};
    return make(net, &opt, 0, out, err);
}

sp_status sp_complex_modes_lowest(const sp_network *net, const sp_modes_options *opt, int64_t lowest,
                                  sp_complex_modes *out, sp_error *err) {
    const int64_t n = sp_network_dofs(net);
    if (lowest < 1 || lowest > n)
        return sp_fail(err, SP_EINVAL, "%lld lowest modes, must be 1 .. %lld, the degrees of freedom of the network",
                       (long long)lowest, (long long)n);
    return make(net, opt, lowest, out, err);
}
