/* The largest eigenfrequency by the Lanczos recursion. */
#include "network/largest.h"

#include "base/base.h"
#include "linalg/vector.h"
#include "numeric/random.h"

#include <math.h>
#include <string.h>

enum { STEPS = 200 };

/* Whether the symmetric tridiagonal matrix T has an eigenvalue above x: some pivot of T - x is positive (Sylvester). */
static bool exceeds(int n, const double *diagonal, const double *off_diagonal, double x) {
    double pivot = diagonal[0] - x;
    for (int k = 1; k < n && pivot < 0; k++)
        pivot = diagonal[k] - x - off_diagonal[k - 1] * off_diagonal[k - 1] / pivot;
    return pivot >= 0;
}

static double largest_of(int n, const double *diagonal, const double *off_diagonal) {
    double low = 0, high = 0;
    for (int k = 0; k < n; k++)
        high =
            fmax(high, diagonal[k] + (k > 0 ? fabs(off_diagonal[k - 1]) : 0) + (k + 1 < n ? fabs(off_diagonal[k]) : 0));
    while (high - low > 1e-12 * high) {
        const double middle = 0.5 * (low + high);
        if (exceeds(n, diagonal, off_diagonal, middle))
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* out = A x, where A is the symmetric part of M^-1/2 K M^-1/2. */
static void apply(const sp_network *net, const double *x, double *out, double *work) {
    const int64_t n = sp_network_dofs(net);
    double *scaled = work, *other = work + n;
    for (int64_t k = 0; k < n; k++)
        scaled[k] = x[k] / sqrt(net->mass[k]);
    sp_network_apply(net, scaled, out);
    if (net->carried) {
        sp_network_apply_transposed(net, scaled, other);
        for (int64_t k = 0; k < n; k++)
            out[k] = 0.5 * (out[k] + other[k]);
    }
    for (int64_t k = 0; k < n; k++)
        out[k] /= sqrt(net->mass[k]);
}

/* The vectors are not reorthogonalized: the resulting copies of eigenvalues do not affect the largest one. */
static double recur(const sp_network *net, double *work) {
    const int64_t n = sp_network_dofs(net);
    double *x = work, *before = work + n, *next = work + 2 * n, diagonal[STEPS], off_diagonal[STEPS], beta = 0;
    sp_random stream = sp_random_make(1, SP_STREAM_LARGEST);
    int steps = 0;
    for (int64_t k = 0; k < n; k++)
        x[k] = sp_random_uniform(&stream) - 0.5;
    const double size = sqrt(sp_dot(n, x, x));
    for (int64_t k = 0; k < n; k++)
        x[k] /= size;
    while (steps < STEPS && steps < n) {
        apply(net, x, next, work + 3 * n);
        const double alpha = sp_dot(n, x, next);
        for (int64_t k = 0; k < n; k++)
            next[k] -= alpha * x[k] + beta * before[k];
        beta = sqrt(sp_dot(n, next, next));
        diagonal[steps] = alpha;
        off_diagonal[steps++] = beta;
        if (!(beta > 1e-12 * fabs(alpha)))
            break;
        for (int64_t k = 0; k < n; k++)
            next[k] /= beta;
        double *oldest = before;
        before = x;
        x = next;
        next = oldest;
    }
    return sqrt(largest_of(steps, diagonal, off_diagonal));
}

sp_status sp_network_find_largest(const sp_network *net, double *omega, sp_error *err) {
    const size_t n = (size_t)sp_network_dofs(net);
    double *work = sp_alloc(5 * n, sizeof *work);
    if (!work)
        return sp_fail_memory(err, 5 * n * sizeof *work);
    *omega = recur(net, work);
    sp_free(work);
    return SP_OK;
}
