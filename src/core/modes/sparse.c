/* Modes in a range of frequencies, by the sparse or the dense solver. */
#include "base/base.h"
#include "modes/pieces.h"
#include "modes/slices.h"
#include "modes/table.h"

#include <math.h>
#include <string.h>

enum { SMALL = 400 }; /* degrees of freedom up to which the dense solver is always faster */

static sp_status check(const sp_network *net, const sp_modes_range *r, sp_error *err) {
    const int64_t n = sp_network_dofs(net);
    if (r->lowest < 0 || r->lowest > n)
        return sp_fail(err, SP_EINVAL, "%lld lowest modes, must be 1 .. %lld, the degrees of freedom of the network",
                       (long long)r->lowest, (long long)n);
    if (r->lowest == 0 && !(r->from >= 0 && r->to > r->from))
        return sp_fail(err, SP_EINVAL, "band of omega = %g .. %g, must be 0 or above, and ascending", r->from, r->to);
    return sp_network_need_symmetry(net, "a table of modes", err);
}

static bool is_all(const sp_network *net, const sp_modes_range *r) {
    return r->lowest == sp_network_dofs(net) || (r->lowest == 0 && r->from == 0 && isinf(r->to));
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

/* Keeps only the rows in the range. */
static void cut(sp_modes *m, const sp_modes_range *r) {
    int64_t first = 0, last = m->n, edge = 0;
    if (r->lowest > 0)
        last = m->n_rattler + r->lowest;
    else {
        while (first < last &&
               place(m->omega[first] - m->error[first], m->omega[first] + m->error[first], r, &edge) < 0)
            first++;
        for (last = first, edge = 0; last < m->n; last++)
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
    m->n_zero = 0;
    while (m->n_zero < count && m->omega[m->n_zero] == 0)
        m->n_zero++;
    m->first = first;
    m->on_edge = edge;
}

static sp_status dense(const sp_network *net, const sp_modes_options *opt, const sp_modes_range *range, sp_modes *out,
                       sp_error *err) {
    sp_status status = sp_modes_dense(net, opt, out, err);
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

/* Makes the table of the modes in the range. */
static sp_status make_table(const slicer *z, const sp_modes_options *opt, const sp_modes_range *r, slice_edge a,
                            slice_edge b, sp_modes *out, sp_error *err) {
    const int64_t rattlers = (int64_t)z->net->rattlers * z->net->dof;
    int64_t first = 0, last, edge = 0;
    double to = sqrt(fmax(b.sigma - b.error, 0));
    if (r->lowest > 0) {
        last = r->lowest;
        if (last < z->found)
            to = sqrt(fmax(z->ritz[last].lambda - z->ritz[last].error, 0));
    } else {
        int64_t inside = 0;
        first = -1;
        for (int64_t k = 0; k < z->found; k++) {
            const double low = sqrt(fmax(z->ritz[k].lambda - z->ritz[k].error, 0)),
                         high = sqrt(fmax(z->ritz[k].lambda + z->ritz[k].error, 0));
            if (place(low, high, r, &edge) != 0)
                continue;
            first = first < 0 ? k : first;
            inside = k + 1 - first;
        }
        if (first < 0) { /* an empty band still has a position in the spectrum */
            for (first = 0; first < z->found && z->ritz[first].lambda < r->from * r->from;)
                first++;
        }
        last = first + inside;
    }
    const bool whole = r->from == 0;
    const sp_mode_pairs set = {.count = last - first,
                               .ritz = z->ritz + first,
                               .vectors = opt->vectors ? z->vector + first * z->n : NULL,
                               .rattlers = whole ? rattlers : 0,
                               .first = whole ? 0 : rattlers + a.below + first};
    sp_status status = sp_modes_tabulate(z->net, opt->source, &set, out, err);
    if (status != SP_OK)
        return status;
    out->solver = z->solver;
    out->certified_from = sqrt(fmax(a.sigma + a.error, 0));
    out->certified_to = b.below == z->n ? HUGE_VAL : to;
    out->on_edge = edge;
    out->factors = z->factors;
    out->solves = z->solves;
    return SP_OK;
}

static bool in_pieces(const sp_network *net, const sp_modes_options *opt, const sp_modes_range *range) {
    return is_all(net, range) && range->lowest == 0 && !opt->vectors && opt->solver != SP_SOLVER_ARPACK &&
           sp_modes_is_large(net);
}

sp_status sp_modes_sparse(const sp_network *net, const sp_modes_options *opt, const sp_modes_range *range,
                          sp_modes *out, sp_error *err) {
    slicer z = {0};
    slice_edge a = {0}, b = {0};
    sp_status status = check(net, range, err);
    if (status != SP_OK)
        return status;
    if (opt->solver == SP_SOLVER_DENSE)
        return sp_fail(err, SP_EINVAL, "the solver of a part of the modes is dense, must be lanczos or arpack");
    if (sp_network_dofs(net) <= SMALL && opt->solver == SP_SOLVER_AUTO)
        return dense(net, opt, range, out, err);
    if (in_pieces(net, opt, range)) {
        status = sp_modes_in_pieces(net, opt, out, err);
        if (status != SP_EREFUSED)
            return status;
    }
    status = sp_slicer_make(net, opt->vectors, &z, err);
    if (status != SP_OK)
        return status;
    z.solver = opt->solver == SP_SOLVER_AUTO ? SP_SOLVER_LANCZOS : opt->solver;
    if (range->lowest > 0)
        status = sp_slicer_lowest(&z, range->lowest, &b, err);
    else
        status = band(&z, range, &a, &b, err);
    if (status == SP_OK)
        status = make_table(&z, opt, range, a, b, out, err);
    sp_slicer_free(&z);
    return status;
}

sp_status sp_modes_make(const sp_network *net, const sp_modes_options *opt, const sp_modes_range *range, sp_modes *out,
                        sp_error *err) {
    const int64_t n = sp_network_dofs(net);
    sp_status status = check(net, range, err);
    if (status != SP_OK)
        return status;
    const bool small = n <= SMALL || (n <= SP_MODES_DENSE_MAX && (is_all(net, range) || range->lowest > n / 4));
    if (opt->solver == SP_SOLVER_AUTO && small && in_pieces(net, opt, range)) {
        status = sp_modes_in_pieces(net, opt, out, err);
        if (status != SP_EREFUSED)
            return status;
    }
    if (opt->solver == SP_SOLVER_DENSE || (opt->solver == SP_SOLVER_AUTO && small))
        return dense(net, opt, range, out, err);
    return sp_modes_sparse(net, opt, range, out, err);
}
