/* Bounds the errors of eigenvectors. */
#include "modes/rows.h"

#include <float.h>
#include <math.h>

static double square(double x) { return x * x; }

double sp_modes_gap(const sp_modes *m, int64_t first, int64_t last) {
    const double low = square(fmax(0, m->omega[first] - m->error[first]));
    const double high = square(m->omega[last] + m->error[last]);
    double below = -HUGE_VAL, above = HUGE_VAL;
    if (first > m->n_rattler)
        below = square(m->omega[first - 1] + m->error[first - 1]);
    else if (m->certified_from > 0)
        below = square(m->certified_from);
    else if (m->first > 0) /* zero modes, which are not listed */
        below = square(m->zero.below);
    if (last + 1 < m->n)
        above = square(fmax(0, m->omega[last + 1] - m->error[last + 1]));
    else if (isfinite(m->certified_to))
        above = square(m->certified_to);
    return fmin(low - below, above - high);
}

double sp_modes_vector_error(const sp_modes *m, const sp_network *net, int64_t row) {
    const double top = square(sp_network_omega_bound(net)), gap = sp_modes_gap(m, row, row);
    const double residual = (m->residual + 8 * DBL_EPSILON) * top; /* with the rounding of its computation */
    /* Davis and Kahan: the sine of the angle is at most |R|/gap, and |e - f| at most sqrt(2) times that */
    return M_SQRT2 * (gap > residual ? residual / gap : 1);
}
