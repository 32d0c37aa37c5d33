/* The Chebyshev expansion of signals: its terms, the moments of one pass, their sum and its error. */
#include "signal/pass.h"
#include "base/base.h"
#include "numeric/bessel.h"

#include <float.h>
#include <math.h>

/* J_(2k+1)(x) or J_2k(x) for k < *n: all that are not negligible at x. Free *j with sp_free. Above x they decrease with
 * the order and increase with x, so the last time has the largest tail. */
static sp_status bessel_at(double x, bool velocity, int64_t *n, double **j, sp_error *err) {
    const int64_t orders = sp_bessel_orders(x);
    double *all = sp_alloc((size_t)orders, sizeof *all);
    if (!all)
        return sp_fail_memory(err, (size_t)orders * sizeof *all);
    sp_bessel_j(x, orders, all);
    *n = orders / 2;
    for (int64_t k = 0; k < *n; k++)
        all[k] = all[2 * k + velocity];
    *j = all;
    return SP_OK;
}

/* With lambda = Omega^2 sin^2(theta) and X = cos(2 theta), |W_k| = |sin((2k+1) theta)/sin(theta)| is at most (2k+1)
 * exp(2k |Im theta|). cosh(2 Im theta) = (|X + 1| + |X - 1|)/2 is convex in X and therefore largest at a corner of the
 * rectangle, beyond lambda = 0 or at Omega^2. */
double sp_expansion_spread(const sp_network *net) {
    const double square = sp_network_omega_bound(net) * sp_network_omega_bound(net);
    if (!net->carried || !(square > 0))
        return 0;
    const double down = sp_network_soft(net) / square, side = sp_network_skew(net) / square;
    return acosh(fmax(hypot(1 + down, side) + hypot(down, side), hypot(1, side) + side));
}

double sp_expansion_growth(double spread) { return spread > 0 ? 10 : 1.0001; }

/* Logarithm of a bound of |J_m(x)| by Kapteyn's inequality [DLMF 10.14.8]. */
static double log_bessel(double m, double x) {
    if (m <= x || m == 0)
        return 0;
    const double z = x / m, root = sqrt(1 - z * z);
    return z > 0 ? m * (log(z) + root - log1p(root)) : -HUGE_VAL;
}

double sp_expansion_tail(double x, bool velocity, double spread, int64_t first) {
    const double factor = 1 + sqrt(2.0);
    double sum = 0, before = HUGE_VAL;
    /* once each term is less than half the one before, the remainder is less than the last term */
    for (int64_t k = first;; k++) {
        const double term =
            sp_expansion_weight(velocity, k) * exp((double)k * spread + log_bessel(2 * (double)k + velocity, x));
        sum += term;
        if (!isfinite(sum) || (term <= 0.5 * before && 2 * (double)k > x && term <= 1e-3 * sum))
            return factor * (sum + term);
        before = term;
    }
}

/* Finds the first k with a small enough tail, by bracketing and bisection. */
static int64_t terms_of_spread(double x, bool velocity, double spread, double tail) {
    int64_t low = 0, high = 8 + (int64_t)(0.5 * x);
    while (!(sp_expansion_tail(x, velocity, spread, high) <= tail)) {
        low = high;
        high += high / 4 + 8;
    }
    while (high - low > 1) {
        const int64_t middle = low + (high - low) / 2;
        if (sp_expansion_tail(x, velocity, spread, middle) <= tail)
            high = middle;
        else
            low = middle;
    }
    return high;
}

sp_status sp_expansion_terms(const sp_network *net, double until, bool velocity, double tail, int64_t *terms,
                             sp_error *err) {
    const double omega = sp_network_omega_bound(net), spread = sp_expansion_spread(net);
    double *j = NULL, sum = 0;
    int64_t n = 0;
    if (spread > 0) {
        *terms = terms_of_spread(omega * until, velocity, spread, tail);
        return SP_OK;
    }
    sp_status status = bessel_at(omega * until, velocity, &n, &j, err);
    if (status != SP_OK)
        return status;
    while (n > 1) {
        sum += sp_expansion_weight(velocity, n - 1) * fabs(j[n - 1]);
        if (sum > tail)
            break;
        n--;
    }
    sp_free(j);
    *terms = n;
    return SP_OK;
}

/* ---- moments ----------------------------------------------------------------------------------------------------- */

void sp_pass_free(pass *p) {
    sp_recurrence_free(&p->r);
    sp_free(p->mu);
    sp_free(p->size);
    sp_free(p->norms);
    *p = (pass){0};
}

/* Moment 0, and norms. */
static void begin(const pass_plan *plan, pass *p) {
    pair size;
    sp_recurrence_start(&p->r, 0, plan->velocity, &plan->propagated[0]);
    if (plan->doubled)
        sp_recurrence_start(&p->r, 1, false, &plan->observers[0]);
    else if (plan->lanes == 2)
        sp_recurrence_start(&p->r, 1, plan->velocity, &plan->propagated[1]);
    for (int32_t q = 0; q < p->observer_count; q++) {
        const pair mu = sp_recurrence_product(&p->r, &p->observers[q], &size);
        for (int32_t lane = 0; lane < p->lanes; lane++) {
            p->mu[lane * p->observer_count + q] = p->velocity ? mu[lane] : 0.5 * mu[lane];
            p->size[lane * p->observer_count + q] = size[lane];
            p->norms[lane * p->observer_count + q] =
                sqrt(p->r.start[lane]) * sp_recurrence_norm(&p->r, &p->observers[q]);
        }
        p->first = mu[0];
    }
    p->n = 1;
}

sp_status sp_pass_make(const pass_plan *plan, pass *out, sp_error *err) {
    pass p = {.doubled = plan->doubled,
              .velocity = plan->velocity,
              .lanes = plan->doubled ? 1 : plan->lanes,
              .observer_count = plan->observer_count,
              .spread = plan->spread,
              .observers = plan->observers,
              .capacity = plan->terms + 2};
    p.columns = (int64_t)p.lanes * p.observer_count;
    const size_t count = (size_t)p.columns;
    sp_status status = sp_recurrence_make(plan->op, plan->mass, plan->omega, plan->threads, &p.r, err);
    if (status == SP_OK) {
        p.mu = sp_alloc((size_t)p.capacity, count * sizeof *p.mu);
        p.size = sp_alloc((size_t)p.capacity, count * sizeof *p.size);
        p.norms = sp_alloc(count, sizeof *p.norms);
        if (!p.mu || !p.size || !p.norms)
            status = sp_fail_memory(err, 2 * (size_t)p.capacity * count * sizeof *p.mu);
    }
    if (status != SP_OK) {
        sp_pass_free(&p);
        return status;
    }
    begin(plan, &p);
    p.r.doubled = p.doubled;
    *out = p;
    return SP_OK;
}

static int64_t dofs_of(const pass *p) { return (int64_t)p->r.op->n * p->r.op->dof; }

/* Of both lanes, where signal_size asks for them. */
static pair squares_of(const pass *p) {
    return dofs_of(p) <= SIGNAL_FEW_DOFS ? sp_recurrence_squares(&p->r) : (pair){0, 0};
}

/* b^T T_m W_k a = b^T (W_(k+m) + W_(k-m)) a/2, W_(-k-1) = -W_k, and T_m T_k = (T_(k+m) + T_|m-k|)/2, for m = k + 1 and
 * for both at k + 1. */
static void extend_doubled(pass *p) {
    const int64_t k = p->r.step;
    const recurrence_products of = sp_recurrence_step(&p->r);
    double back = p->velocity ? p->first : -p->mu[1];
    if (k == 0 && !p->velocity)
        back = -of.dot[0];
    const pair squares = squares_of(p);
    const double norms = sqrt(squares[0]) * sqrt(squares[1]);
    p->mu[2 * k + 1] = 2 * of.dot[0] + back;
    p->size[2 * k + 1] = 2 * signal_size(dofs_of(p), of.size[0], norms);
    p->mu[2 * k + 2] = 2 * of.dot[1] - p->first;
    p->size[2 * k + 2] = 2 * signal_size(dofs_of(p), of.size[1], norms);
    p->n += 2;
}

static void extend_plainly(pass *p) {
    sp_recurrence_step(&p->r);
    const pair squares = squares_of(p);
    double *mu = p->mu + p->n * p->columns, *size = p->size + p->n * p->columns;
    for (int32_t q = 0; q < p->observer_count; q++) {
        pair magnitude;
        const pair sum = sp_recurrence_product(&p->r, &p->observers[q], &magnitude);
        for (int32_t lane = 0; lane < p->lanes; lane++) {
            mu[lane * p->observer_count + q] = sum[lane];
            const double seen = p->norms[lane * p->observer_count + q] / sqrt(p->r.start[lane]);
            size[lane * p->observer_count + q] = signal_size(dofs_of(p), magnitude[lane], seen * sqrt(squares[lane]));
        }
    }
    p->n++;
}

void sp_pass_extend(pass *p, int64_t n) {
    while (p->n < n && p->n + 2 <= p->capacity) {
        if (p->doubled)
            extend_doubled(p);
        else
            extend_plainly(p);
    }
}

bool sp_pass_bounded(const pass *p) {
    const pair now = sp_recurrence_squares(&p->r);
    bool bounded = true;
    for (int lane = 0; lane < 2; lane++) {
        const double growth = (p->r.second[lane] ? 2 * (double)p->r.step + 1 : 1) * sp_expansion_growth(p->spread);
        bounded = bounded && now[lane] <= growth * growth * p->r.start[lane];
    }
    return bounded;
}

/* ---- sums -------------------------------------------------------------------------------------------------------- */

/* Factors of rounding(). */
#define MOMENT_ROUNDING 5.0
#define PHASE_ROUNDING  5.0

/* Accumulated rounding. Moment k carries the independent errors of about k/2 steps (k without doubling), each a few
 * DBL_EPSILON of its terms. Omega t has the relative error DBL_EPSILON. The factors are 5 times the errors observed. */
static double rounding(const pass *p, int64_t column, double x, int64_t n, const double *j) {
    double moments = 0, signal = 0;
    for (int64_t k = 0; k < n && k < p->n; k++) {
        const double size = p->size[k * p->columns + column], mu = p->mu[k * p->columns + column];
        const double own = j[k] * size * sqrt(1 + (double)k), term = j[k] * mu;
        moments += own * own;
        signal += term * term;
    }
    return DBL_EPSILON * (MOMENT_ROUNDING * sqrt(moments) + PHASE_ROUNDING * (1 + x) * sqrt(signal));
}

static sp_status find_errors(const pass *p, double omega, double last, double *errors, sp_error *err) {
    const double scale = p->velocity ? 2 / omega : 2, x = omega * last;
    double *j = NULL, tail = 0, sum = 0;
    int64_t terms = 0;
    sp_status status = bessel_at(x, p->velocity, &terms, &j, err);
    if (status != SP_OK)
        return status;
    for (int64_t k = p->n; k < terms && !(p->spread > 0); k++)
        tail += sp_expansion_weight(p->velocity, k) * fabs(j[k]);
    if (p->spread > 0)
        tail = sp_expansion_tail(x, p->velocity, p->spread, p->n);
    else
        tail += 2 * sp_expansion_weight(p->velocity, terms) * fabs(j[terms - 1]); /* those omitted as negligible */
    for (int64_t k = 0; k < terms && k < p->n; k++)
        sum += fabs(j[k]);
    tail += sum * sp_recurrence_dropped(&p->r, p->n);
    for (int64_t c = 0; c < p->columns; c++) {
        double low =
            0; /* moments whose Bessel functions were set to 0; for a spread above 0 these moments may be large */
        for (int64_t k = terms; k < p->n && p->spread > 0; k++)
            low += 1e-20 * fabs(p->mu[k * p->columns + c]);
        errors[c] = scale * (p->norms[c] * tail + low + rounding(p, c, x, terms, j));
    }
    sp_free(j);
    return SP_OK;
}

sp_status sp_pass_sum(const pass *p, double omega, int64_t n, const double *t, int64_t stride, double *f,
                      double *errors, sp_error *err) {
    const double scale = p->velocity ? 2 / omega : 2;
    double *x = sp_alloc((size_t)n, sizeof *x), *work = NULL;
    sp_status status = SP_OK;
    if (p->columns > 1)
        work = sp_alloc((size_t)sp_bessel_scratch(p->n, p->columns), sizeof *work);
    if (!x || (p->columns > 1 && !work)) {
        status = sp_fail_memory(err, ((size_t)n + (size_t)sp_bessel_scratch(p->n, p->columns)) * sizeof *x);
        goto out;
    }
    for (int64_t l = 0; l < n; l++)
        x[l] = omega * t[l];
    if (p->columns == 1)
        sp_bessel_series(p->n, p->mu, p->velocity, n, x, f);
    else
        sp_bessel_series_many(p->n, p->columns, p->mu, p->velocity, n, x, f, stride, work);
    for (int64_t c = 0; c < p->columns; c++)
        for (int64_t l = 0; l < n; l++)
            f[c * stride + l] *= scale;
    status = find_errors(p, omega, t[n - 1], errors, err);
out:
    sp_free(x);
    sp_free(work);
    return status;
}
