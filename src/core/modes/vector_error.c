/* Bounds the errors of eigenvectors. */
#include <sonopack/modes.h>

#include <float.h>
#include <math.h>

static double square(double x) { return x * x; }

/* Distance in omega^2 between a mode and all other eigenvalues: those listed beside it, and those that may lie beyond
 * the certified ends of the list. Negative or 0 if they may coincide. */
static double gap_of(const sp_modes *m, int64_t row) {
    const double low = square(fmax(0, m->omega[row] - m->error[row])), high = square(m->omega[row] + m->error[row]);
    double below = -HUGE_VAL, above = HUGE_VAL;
    if (row > m->n_rattler)
        below = square(m->omega[row - 1] + m->error[row - 1]);
    else if (m->certified_from > 0)
        below = square(m->certified_from);
    if (row + 1 < m->n)
        above = square(fmax(0, m->omega[row + 1] - m->error[row + 1]));
    else if (isfinite(m->certified_to))
        above = square(m->certified_to);
    return fmin(low - below, above - high);
}

double sp_modes_vector_error(const sp_modes *m, const sp_network *net, int64_t row) {
    const double top = square(sp_network_omega_bound(net)), gap = gap_of(m, row);
    const double residual = (m->residual + 8 * DBL_EPSILON) * top; /* with the rounding of its computation */
    /* Davis and Kahan: the sine of the angle is at most |R|/gap, and |e - f| at most sqrt(2) times that */
    return M_SQRT2 * (gap > residual ? residual / gap : 1);
}
