/* Modes in a range of frequencies, by the sparse or the dense solver. */
#include "base/base.h"
#include "modes/mode_table.h"
#include "modes/slices.h"

#include <math.h>
#include <string.h>

/* Whether the sparse solver finds all frequencies faster than LAPACK, on one thread. */
static bool is_large(const sp_network *net) {
    enum { FLAT = 5000, SOLID = 8000 }; /* degrees of freedom; factors fill faster in three dimensions */
    return sp_network_dofs(net) > (net->dim > 2 ? SOLID : FLAT);
}

enum { SMALL = 400 }; /* degrees of freedom up to which the dense solver is always faster */

static sp_status too_many(int64_t lowest, int64_t most, sp_error *err) {
    return sp_fail(err, SP_EINVAL, "%lld lowest modes, must be 1 .. %lld, the degrees of freedom less the zero modes",
                   (long long)lowest, (long long)most);
}

sp_status sp_modes_check_range(const sp_network *net, const sp_modes_range *r, sp_error *err) {
    const int64_t n = sp_network_dofs(net);
    if (r->lowest < 0 || r->lowest > n)
        return sp_fail(err, SP_EINVAL, "%lld lowest modes, must be 1 .. %lld, the degrees of freedom of the network",
                       (long long)r->lowest, (long long)n);
    if (r->lowest == 0 && !(r->from >= 0 && r->to > r->from))
        return sp_fail(err, SP_EINVAL, "band of omega = %g .. %g, must be 0 or above, and ascending", r->from, r->to);
    if (r->lowest == 0 && r->zero)
        return sp_fail(err, SP_EINVAL,
                       "zero modes are an option of the lowest modes: a band from 0 has all of them, any "
                       "other band none");
    return SP_OK;
}

static sp_status check(const sp_network *net, const sp_modes_range *r, sp_error *err) {
    const sp_status status = sp_modes_check_range(net, r, err);
    return status == SP_OK ? sp_network_need_symmetry(net, "a table of modes", err) : status;
}

bool sp_modes_range_is_whole(const sp_modes_range *r) { return r->lowest == 0 && r->from == 0 && isinf(r->to); }

static bool is_all(const sp_network *net, const sp_modes_range *r) {
    return r->lowest == sp_network_dofs(net) || sp_modes_range_is_whole(r);
}

/* -1 below the band, 1 above, 0 inside or possibly inside; *edge counts the doubtful cases. */
static int place(double low, double high, const sp_modes_range *r, int64_t *edge) {
    if (high < r->from)
        return -1;
    if (low > r->to)
        return 1;
    *edge += low < r->from || high > r->to;
    return 0;
}

/* Keeps only the rows in the range, of all modes. */
static void cut(sp_modes *m, const sp_modes_range *r) {
    int64_t first = r->from > 0 ? m->n_zero : 0, last = m->n, edge = 0;
    if (r->lowest > 0) {
        first = r->zero ? 0 : m->n_zero;
        last = m->n_zero + r->lowest;
    } else {
        while (first < last && first >= m->n_zero &&
               place(m->omega[first] - m->error[first], m->omega[first] + m->error[first], r, &edge) < 0)
            first++;
        for (last = first > m->n_zero ? first : m->n_zero, edge = 0; last < m->n; last++)
            if (place(m->omega[last] - m->error[last], m->omega[last] + m->error[last], r, &edge) != 0)
                break;
    }
    const int64_t rattlers = first < m->n_rattler ? m->n_rattler - first : 0, count = last - first;
    double *const columns[] = {m->omega, m->error, m->a, m->b, m->participation};
    for (size_t c = 0; c < sizeof columns / sizeof *columns; c++)
        if (columns[c])
            memmove(columns[c], columns[c] + first, (size_t)count * sizeof(double));
    if (m->vectors && first > m->n_rattler)
        memmove(m->vectors, m->vectors + (first - m->n_rattler) * m->dofs, (size_t)(count * m->dofs) * sizeof(double));
    m->n = count;
    m->n_rattler = rattlers;
    m->n_zero = first < m->n_zero ? m->n_zero - first : 0;
    m->first = first;
    m->on_edge = edge;
}

static sp_status dense(const sp_network *net, const sp_modes_options *opt, const sp_modes_range *range, sp_modes *out,
                       sp_error *err) {
    sp_status status = sp_modes_dense(net, opt, out, err);
    if (status == SP_OK && range->lowest > out->n - out->n_zero) {
        status = too_many(range->lowest, out->n - out->n_zero, err);
        sp_modes_free(out);
    }
    if (status == SP_OK)
        cut(out, range);
    return status;
}

/* Chooses edges slightly outside the band, by the fraction pad; none within rounding errors of zero. */
static sp_status band_edges(slicer *z, const sp_modes_range *r, double pad, slice_edge *a, slice_edge *b,
                            sp_error *err) {
    const double low = r->from * r->from, high = r->to * r->to;
    sp_status status = SP_OK;
    if (low * (1 - 2 * pad) <= 1e-11 * z->top)
        status = sp_slicer_bottom(z, fmin(1e-3 * sp_slicer_guess(z, 100), high), a, err);
    else if (low >= z->top)
        *a = sp_slicer_top(z);
    else
        status = sp_slicer_edge(z, low * (1 - 2 * pad), low * (1 - pad), a, err);
    if (status != SP_OK)
        return status;
    const double floor = fmax(high, 1e-10 * z->top);
    if (floor * (1 + pad) >= z->top) {
        *b = sp_slicer_top(z);
        return SP_OK;
    }
    return sp_slicer_edge(z, floor * (1 + pad), floor * (1 + 2 * pad), b, err);
}

static sp_status band(slicer *z, const sp_modes_range *r, slice_edge *a, slice_edge *b, sp_error *err) {
    bool certain = false;
    sp_status status = SP_OK;
    for (double pad = 1e-4; pad < 0.2 && status == SP_OK && !certain; pad *= 10) {
        status = band_edges(z, r, pad, a, b, err);
        if (status == SP_EREFUSED && pad < 1e-2) { /* limits too close for a count */
            status = SP_OK;
            continue;
        }
        if (status == SP_OK && b->sigma <= a->sigma)
            certain = true; /* the band lies above the spectrum */
        else if (status == SP_OK)
            status = sp_slicer_between(z, *a, *b, &certain, err);
    }
    if (status == SP_OK && !certain)
        status = sp_fail(err, SP_EREFUSED,
                         "band of omega = %.17g .. %.17g: modes lie too near its limits to be counted; move them",
                         r->from, r->to);
    return status;
}

/* Rows first .. last - 1 of the modes found lie in the band, *edge of them possibly not. */
static void find_band(const slicer *z, const sp_modes_range *r, int64_t zeros, int64_t *first, int64_t *last,
                      int64_t *edge) {
    const sp_ritz *ritz = z->ritz + z->front;
    int64_t begin = -1, end = 0;
    for (int64_t k = 0; k < z->found; k++) {
        const double low = k < zeros ? 0 : sqrt(fmax(ritz[k].lambda - ritz[k].error, 0)),
                     high = k < zeros ? 0 : sqrt(fmax(ritz[k].lambda + ritz[k].error, 0));
        if (place(low, high, r, edge) != 0)
            continue;
        begin = begin < 0 ? k : begin;
        end = k + 1;
    }
    if (begin < 0) { /* an empty band still has a position in the spectrum */
        for (begin = 0; begin < z->found && ritz[begin].lambda < r->from * r->from;)
            begin++;
        end = begin;
    }
    *first = begin;
    *last = end;
}

/* Makes the table of the modes in the range, of which `zeros` found ones are zero modes. */
static sp_status make_table(slicer *z, const sp_modes_options *opt, const sp_modes_range *r, slice_edge a, slice_edge b,
                            int64_t zeros, sp_modes *out, sp_error *err) {
    const sp_ritz *ritz = z->ritz + z->front;
    const sp_zero_modes zero = sp_zeros_sum(z->net, &z->null, zeros);
    const int64_t others = zero.total - zero.mechanisms;
    int64_t first = r->zero ? 0 : zeros, last = zeros + r->lowest, edge = 0;
    double to = sqrt(fmax(b.sigma - b.error, 0));
    if (r->lowest > 0 && last < z->found)
        to = sqrt(fmax(ritz[last].lambda - ritz[last].error, 0));
    if (r->lowest == 0)
        find_band(z, r, zeros, &first, &last, &edge);
    /* null motions, if they are rows, come before row 0 of the modes found: then first = 0 */
    const sp_mode_pairs set = {.count = z->front + last - first,
                               .ritz = z->ritz + first,
                               .vectors = z->vector ? &z->vector : NULL,
                               .row = first,
                               .zeros = z->front + (first < zeros ? zeros - first : 0),
                               .zero = zero,
                               .rattlers = z->null_rows ? zero.rattlers : 0,
                               .first = z->null_rows ? 0 : others + a.below + first};
    sp_status status = sp_modes_tabulate(z->net, opt->source, &set, out, err);
    if (status != SP_OK)
        return status;
    out->solver = z->solver;
    out->certified_from = sqrt(fmax(a.sigma + a.error, 0));
    out->certified_to = b.below == z->modes ? HUGE_VAL : to;
    out->on_edge = edge;
    out->factors = z->factors;
    out->solves = z->solves;
    return SP_OK;
}

/* Number of zero modes that are no null motions, whichever modes were found before, which are lost. */
static sp_status count_mechanisms(slicer *z, int64_t *zeros, sp_error *err) {
    slice_edge soft;
    sp_status status = SP_OK;
    if (z->net->prestress) /* no mode may be negative */
        status = sp_slicer_bottom(z, 5e-11 * z->top, &soft, err);
    if (status == SP_OK)
        status = sp_slicer_soft(z, &soft, err);
    *zeros = 0;
    if (status != SP_OK || soft.below == 0)
        return status;
    /* with more of their neighbours the softest modes are known better */
    for (int64_t wanted = soft.below, more = 16;; wanted += more, more *= 4) {
        wanted = wanted < z->modes ? wanted : z->modes;
        status = sp_slicer_softest(z, wanted, &soft, err);
        if (status == SP_OK)
            status = sp_slicer_zeros(z, zeros, err);
        if (status != SP_EREFUSED || wanted == z->modes || more > 64)
            return status;
    }
}

/* Modes in a band, and the numbers of all zero modes, which may lie below it. */
static sp_status band_table(slicer *z, const sp_modes_options *opt, const sp_modes_range *r, sp_modes *out,
                            sp_error *err) {
    slice_edge a = {0}, b = {0};
    int64_t zeros = 0;
    sp_status status = band(z, r, &a, &b, err);
    if (status == SP_OK && a.sigma < 0)
        status = sp_slicer_zeros(z, &zeros, err);
    if (status == SP_OK)
        status = make_table(z, opt, r, a, b, zeros, out, err);
    if (status != SP_OK || a.below == 0)
        return status;
    status = count_mechanisms(z, &zeros, err);
    if (status != SP_OK) {
        sp_modes_free(out);
        return status;
    }
    out->zero = sp_zeros_sum(z->net, &z->null, zeros);
    out->factors = z->factors;
    out->solves = z->solves;
    return SP_OK;
}

static sp_status lowest_table(slicer *z, const sp_modes_options *opt, const sp_modes_range *r, sp_modes *out,
                              sp_error *err) {
    slice_edge a = {0}, b = {0};
    int64_t zeros = 0;
    if (r->lowest > z->modes)
        return too_many(r->lowest, z->modes, err);
    sp_status status = sp_slicer_lowest(z, r->lowest, &b, err);
    if (status == SP_OK)
        status = sp_slicer_zeros(z, &zeros, err);
    return status == SP_OK ? make_table(z, opt, r, a, b, zeros, out, err) : status;
}

sp_status sp_modes_sparse(const sp_network *net, const sp_modes_options *opt, const sp_modes_range *range,
                          sp_modes *out, sp_error *err) {
    slicer z = {0};
    sp_status status = check(net, range, err);
    if (status != SP_OK)
        return status;
    if (opt->solver == SP_SOLVER_DENSE)
        return sp_fail(err, SP_EINVAL, "the solver of a part of the modes is dense, must be lanczos or arpack");
    if (sp_network_dofs(net) <= SMALL && opt->solver == SP_SOLVER_AUTO)
        return dense(net, opt, range, out, err);
    status = sp_slicer_make(net, opt->vectors, &z, err);
    if (status == SP_OK && opt->threads > 1)
        status = sp_ldl_share(z.ldl, opt->threads, err);
    if (status != SP_OK) {
        sp_slicer_free(&z);
        return status;
    }
    z.solver = opt->solver == SP_SOLVER_AUTO ? SP_SOLVER_LANCZOS : opt->solver;
    z.threads = opt->threads > 1 ? opt->threads : 1;
    z.divide = z.solver == SP_SOLVER_ARPACK ? NULL : sp_slicer_pieces; /* ARPACK runs once in a process */
    z.null_rows = range->zero || (range->lowest == 0 && range->from == 0);
    status = range->lowest > 0 ? lowest_table(&z, opt, range, out, err) : band_table(&z, opt, range, out, err);
    sp_slicer_free(&z);
    if (status == SP_EREFUSED && sp_network_dofs(net) <= SMALL)
        sp_fail_prefix(err, "%lld degrees of freedom are few for this solver, the solver dense finds all modes",
                       (long long)sp_network_dofs(net));
    return status;
}

/* The cost of LAPACK grows as n^3, that of slices as the number of modes times n, or somewhat faster: they meet where
 * modes n = n^3/REACH, measured with 411 to 2832 degrees of freedom. Without vectors LAPACK takes 2/5 of the time. All
 * vectors come from LAPACK somewhat longer: they are orthogonal to rounding, those of many slices to 1e-10. */
static bool dense_is_faster(const sp_network *net, const sp_modes_options *opt, const sp_modes_range *r) {
    const double n = (double)sp_network_dofs(net), reach = opt->vectors ? 2200 : 5500;
    if (is_all(net, r) && !opt->vectors)
        return !is_large(net);
    if (is_all(net, r))
        return n <= 5000;
    return (double)r->lowest * reach > n * n;
}

sp_status sp_modes_make(const sp_network *net, const sp_modes_options *opt, const sp_modes_range *range, sp_modes *out,
                        sp_error *err) {
    const int64_t n = sp_network_dofs(net);
    sp_status status = check(net, range, err);
    if (status != SP_OK)
        return status;
    const bool small = n <= SMALL || (n <= SP_MODES_DENSE_MAX && dense_is_faster(net, opt, range));
    if (opt->solver == SP_SOLVER_DENSE || (opt->solver == SP_SOLVER_AUTO && small))
        return dense(net, opt, range, out, err);
    status = sp_modes_sparse(net, opt, range, out, err);
    if (status == SP_EREFUSED && opt->solver == SP_SOLVER_AUTO && is_all(net, range) && n <= SP_MODES_DENSE_MAX)
        status = dense(net, opt, range, out, err); /* pivots vanish at any shift, as in perfect lattices */
    return status;
}

sp_status sp_zero_modes_count(const sp_network *net, sp_zero_modes *out, sp_error *err) {
    const sp_modes_options how = {.vectors = false};
    sp_modes m = sp_modes_none();
    slicer z = {0};
    int64_t zeros = 0;
    sp_status status = sp_network_need_symmetry(net, "the number of zero modes", err);
    if (status != SP_OK)
        return status;
    if (sp_network_dofs(net) <= SMALL) {
        status = sp_modes_dense(net, &how, &m, err);
        if (status == SP_OK)
            *out = m.zero;
        sp_modes_free(&m);
        return status;
    }
    status = sp_slicer_make(net, false, &z, err);
    if (status == SP_OK)
        status = count_mechanisms(&z, &zeros, err);
    if (status == SP_OK)
        *out = sp_zeros_sum(net, &z.null, zeros);
    sp_slicer_free(&z);
    return status;
}
