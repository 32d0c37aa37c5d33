/* Modes of a network with prestress and friction. Its A = M^-1/2 J M^-1/2 is not symmetric, so that omega^2 may be
 * complex: the motions of such a pair oscillate and grow, or oscillate and decay. */
#include "base/base.h"
#include "base/vector.h"
#include "linalg/arrays.h"
#include "linalg/two_sided.h"
#include "modes/complex_vectors.h"
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

/* The rows of the eigenvalues, and from which each row comes. */
typedef struct rows {
    sp_complex_modes m;
    double *origin; /* [m.n] */
    int64_t k;      /* the eigenvalue that is added */
} rows;

static void add_row(rows *t, number exponent, double error, double cosine, double sine) {
    sp_complex_modes *m = &t->m;
    t->origin[m->n] = (double)t->k;
    m->omega[m->n] = cimag(exponent);
    m->growth[m->n] = creal(exponent);
    m->error[m->n] = error;
    m->cosine[m->n] = cosine;
    m->sine[m->n++] = sine;
}

/* Of a real eigenvalue the signal is weight sin(omega t)/omega, or weight cos(omega t) for displacements. */
static void add_real(const sp_discs *d, bool moved, double reach, rows *t) {
    const int64_t k = t->k;
    const double z = d->re[k], s = sqrt(fabs(z)), weight = d->to[k] * d->from[k], error = root_error(fabs(z), reach);
    if (z >= 0) {
        add_row(t, number_of(0, s), error, moved ? weight : 0, moved || s == 0 ? 0 : weight / s);
        return;
    }
    add_row(t, -s, error, moved ? 0.5 * weight : -0.5 * weight / s, 0);
    add_row(t, s, error, moved ? 0.5 * weight : 0.5 * weight / s, 0);
}

/* Of a pair k, k + 1 it is Re(weight f(z)), f = sin(s t)/s or cos(s t), s = sqrt(z) = omega + i growth. */
static void add_pair(const sp_discs *d, bool moved, double reach, rows *t) {
    const int64_t k = t->k;
    const double *to = d->to + k, *from = d->from + k;
    const number z = number_of(d->re[k], d->im[k]), s = csqrt(z);
    const number weight = number_of(to[0] * from[0] + to[1] * from[1], to[1] * from[0] - to[0] * from[1]);
    const number g = moved ? 0.5 * weight : weight / (2 * _Complex_I * s);
    const double sign = moved ? 1 : -1, error = root_error(cabs(z), reach);
    add_row(t, number_of(-cimag(s), creal(s)), error, creal(g), -cimag(g));
    add_row(t, number_of(cimag(s), creal(s)), error, sign * creal(g), sign * cimag(g));
    t->m.pairs++;
}

/* Discs of eigenvalues, of which all below `limit` are known, and of those that count as zero. */
typedef struct spectrum {
    sp_discs d;
    double *reach;  /* [d.n] as find_reach has it; negative: not listed */
    double limit;   /* of the real part; discs that reach it say nothing */
    sp_two_sided t; /* vectors, if there are any */
} spectrum;

static void add_rows(const spectrum *s, sp_source source, rows *t) {
    const bool moved = source == SP_SOURCE_DISPLACEMENT;
    const sp_discs *d = &s->d;
    for (t->k = 0; t->k < d->n; t->k++) {
        const double reach = s->reach[t->k], im = d->im[t->k];
        if (reach >= 0 && im == 0)
            add_real(d, moved, reach, t);
        else if (reach >= 0 && im > 0)
            add_pair(d, moved, reach, t);
    }
}

enum { COLUMNS = 6 };

/* The columns from a row on, and NULL. */
static void columns_from(const rows *t, int64_t row, double *columns[COLUMNS + 1]) {
    double *const all[COLUMNS] = {t->m.omega, t->m.growth, t->m.error, t->m.cosine, t->m.sine, t->origin};
    for (int c = 0; c < COLUMNS; c++)
        columns[c] = all[c] + row;
    columns[COLUMNS] = NULL;
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

/* All eigenvalues, or the `some` lowest ones and more. Vectors of all only if they are wanted. */
static sp_status spectrum_make(const sp_network *net, const sp_modes_options *opt, int64_t some, spectrum *s,
                               sp_error *err) {
    const size_t n = (size_t)sp_network_dofs(net);
    double *from = sp_alloc(n, sizeof *from), *to = sp_alloc(n, sizeof *to);
    sp_status status =
        from && to ? sp_modes_walls(net, opt->source, from, to, err) : sp_fail_memory(err, 2 * n * sizeof *to);
    *s = (spectrum){.limit = HUGE_VAL};
    if (status == SP_OK)
        status = some ? find_some(net, some, opt->threads, s, err)
                      : sp_network_discs(net, from, to, opt->vectors, &s->d, err);
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

static void keep(rows *t, int64_t first, int64_t end) {
    sp_complex_modes *m = &t->m;
    double *from[COLUMNS + 1], *to[COLUMNS + 1];
    columns_from(t, first, from);
    columns_from(t, 0, to);
    for (int c = 0; c < COLUMNS; c++)
        memmove(to[c], from[c], (size_t)(end - first) * sizeof *to[c]);
    m->first += first;
    m->n = end - first;
    m->pairs = 0;
    for (int64_t k = 0; k < m->n; k++)
        m->pairs += m->growth[k] > 0 && m->omega[k] > 0;
}

/* Keeps the rows of the lowest motions, and of all that share the last omega: the other one of a pair. */
static sp_status cut(rows *t, int64_t lowest, double limit, sp_error *err) {
    sp_complex_modes *m = &t->m;
    int64_t n = lowest;
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
    keep(t, 0, n);
    return SP_OK;
}

/* Keeps the rows of a band, and of motions that may be in it. */
static sp_status cut_band(rows *t, const sp_modes_range *r, sp_error *err) {
    sp_complex_modes *m = &t->m;
    int64_t first = 0, end = m->n;
    if (isfinite(m->complete) && !(r->to < m->complete))
        return sp_fail(err, SP_EREFUSED, "band up to omega = %.6g: only the motions below %.6g are proved to be all",
                       r->to, m->complete);
    while (first < end && m->omega[first] + m->error[first] < r->from)
        first++;
    while (end > first && m->omega[end - 1] - m->error[end - 1] > r->to)
        end--;
    for (int64_t k = first; k < end; k++)
        m->on_edge += m->omega[k] - m->error[k] < r->from || m->omega[k] + m->error[k] > r->to;
    keep(t, first, end);
    return SP_OK;
}

sp_complex_modes sp_complex_modes_none(void) { return (sp_complex_modes){0}; }

void sp_complex_modes_free(sp_complex_modes *m) {
    sp_free(m->omega); /* a block with the other columns */
    sp_free(m->right); /* and one with all vectors */
    *m = sp_complex_modes_none();
}

static sp_status too_large(const sp_network *net, sp_error *err) {
    const int64_t n = sp_network_dofs(net);
    return n <= SP_STABILITY_MAX
               ? SP_OK
               : sp_fail(
                     err, SP_EREFUSED,
                     "%lld degrees of freedom, must be at most %d for all modes of a nonsymmetric K, or few of them "
                     "must be wanted (--lowest, --band)",
                     (long long)n, SP_STABILITY_MAX);
}

static sp_status tabulate(sp_source source, const spectrum *s, rows *t, sp_error *err) {
    sp_complex_modes *m = &t->m;
    const size_t n = 2 * (size_t)s->d.n + (size_t)m->rattlers; /* if all are negative */
    const sp_array arrays[] = {{&m->omega, n}, {&m->growth, n}, {&m->error, n}, {&m->cosine, n}, {&m->sine, n}, {0}};
    double *block, *columns[COLUMNS + 1];
    const sp_status status = sp_arrays_make(arrays, &block, err);
    if (status != SP_OK)
        return status;
    if (!(t->origin = sp_alloc(n, sizeof *t->origin)))
        return sp_fail_memory(err, n * sizeof *t->origin);
    m->n = m->rattlers; /* rows of zeros */
    add_rows(s, source, t);
    columns_from(t, m->rattlers, columns); /* by omega and then growth */
    return sp_arrays_sort(m->n - m->rattlers, columns, err);
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

/* How many of the lowest eigenvalues the band needs: about as many as of the symmetric part lie below its end. */
static sp_status count_band(const sp_network *net, const sp_modes_options *opt, const sp_modes_range *r,
                            int64_t *wanted, sp_error *err) {
    int64_t least, most = 0;
    counter c = {0};
    *wanted = sp_network_dofs(net);
    if (isinf(r->to) || is_dense(net, opt, 1))
        return SP_OK;
    sp_status status = sp_counter_make(net, &c, err);
    if (status == SP_OK)
        status = sp_counter_below(&c, r->to * r->to, &least, &most, err);
    *wanted = most + 2 + most / 20;
    sp_counter_free(&c);
    return status;
}

static sp_status make_rows(const sp_network *net, const sp_modes_options *opt, const sp_modes_range *r, spectrum *s,
                           rows *t, sp_error *err) {
    const double top = sp_network_omega_bound(net);
    const bool part = !sp_modes_range_is_whole(r);
    const int64_t rattlers = (int64_t)net->rattlers * net->dof;
    sp_complex_modes *m = &t->m;
    int64_t wanted = 0, known = 0;
    sp_status status = part ? count_zeros(net, &known, err) : SP_OK;
    wanted = r->lowest + known;
    if (status == SP_OK && part && r->lowest == 0)
        status = count_band(net, opt, r, &wanted, err);
    m->sparse = part && !is_dense(net, opt, wanted);
    if (status == SP_OK && !m->sparse)
        status = too_large(net, err);
    if (status == SP_OK)
        status = spectrum_make(net, opt, m->sparse ? wanted : 0, s, err);
    if (status == SP_OK && part) {
        drop_beyond(s);
        status = drop_zeros(s, known, BALANCED * top * top, &m->zero, err);
    }
    m->complete = sqrt(fmax(s->limit, 0));
    m->rattlers = part ? 0 : rattlers;
    m->first = rattlers - m->rattlers + m->zero;
    if (status == SP_OK)
        status = tabulate(opt->source, s, t, err);
    if (status == SP_OK && part)
        status = r->lowest > 0 ? cut(t, r->lowest, s->limit, err) : cut_band(t, r, err);
    return status;
}

static sp_status check(const sp_network *net, const sp_modes_options *opt, const sp_modes_range *r, sp_error *err) {
    const char *const what = "modes with prestress and friction";
    if (opt->solver == SP_SOLVER_ARPACK)
        return sp_fail(err, SP_EINVAL, "%s: the solver is arpack, must be lanczos, dense or auto", what);
    if (r->zero)
        return sp_fail(err, SP_EINVAL,
                       "%s: zero motions have no rows beside the lowest: their vectors are not definite", what);
    return sp_modes_check_range(net, r, err);
}

sp_status sp_complex_modes_make(const sp_network *net, const sp_modes_options *opt, const sp_modes_range *range,
                                sp_complex_modes *out, sp_error *err) {
    spectrum s = {0};
    rows t = {.m = {.dofs = sp_network_dofs(net), .residual = NAN, .orthogonality = NAN}};
    sp_status status = check(net, opt, range, err);
    if (status == SP_OK)
        status = make_rows(net, opt, range, &s, &t, err);
    if (status == SP_OK && opt->vectors) {
        const bool few = s.t.right != NULL;
        const sp_vector_pairs pairs = {s.d.im, few ? s.t.right : s.d.right, few ? s.t.left : s.d.left, t.origin};
        status = sp_complex_vectors_make(net, &pairs, &t.m, err);
    }
    spectrum_free(&s);
    sp_free(t.origin);
    if (status == SP_OK)
        *out = t.m;
    else
        sp_complex_modes_free(&t.m);
    return status;
}
