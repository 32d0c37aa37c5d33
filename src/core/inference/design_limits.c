/* The factors that a design may have: a box, cut by the plane of equal totals. */
#include "inference/design.h"

#include <math.h>

static double clamp(const sp_design_problem *d, double x) { return fmin(fmax(x, d->opt->low), d->opt->high); }

/* Sum of the weights times the factors, shifted along the weights by -shift and clamped. */
static double shifted_total(const sp_design_problem *d, const double *factor, double shift) {
    double sum = 0;
    for (int32_t i = 0; i < d->p->n; i++)
        if (d->weight[i] > 0)
            sum += d->weight[i] * clamp(d, factor[i] - shift * d->weight[i]);
    return sum;
}

/* The nearest point: factors shifted along the weights, clamped. The total falls with the shift, so that bisection
 * finds it. */
void sp_design_project(const sp_design_problem *d, double *factor) {
    double low = 0, high = 0, largest = 0, least = INFINITY;
    for (int32_t i = 0; i < d->p->n; i++)
        if (d->weight[i] > 0) {
            largest = fmax(largest, fabs(factor[i]) + d->opt->high);
            least = fmin(least, d->weight[i]);
        }
    if (!d->opt->free) {
        low = -largest / least;
        high = -low;
    }
    for (int k = 0; k < 200 && low < high; k++) {
        const double middle = 0.5 * (low + high);
        if (middle <= low || middle >= high)
            break;
        if (shifted_total(d, factor, middle) > d->total)
            low = middle;
        else
            high = middle;
    }
    for (int32_t i = 0; i < d->p->n; i++)
        factor[i] = d->weight[i] > 0 ? clamp(d, factor[i] - 0.5 * (low + high) * d->weight[i]) : 1;
}

/* Total with the upper limit where the gain per weight is above a level, else the lower one. */
static double total_above(const sp_design_problem *d, const double *g, double level) {
    double sum = 0;
    for (int32_t i = 0; i < d->p->n; i++)
        sum += d->weight[i] * (g[i] > level * d->weight[i] ? d->opt->high : d->opt->low);
    return sum;
}

/* A linear programme with one constraint: the grains of the largest gain per weight are at the upper limit, the others
 * at the lower one, and those at the level share the rest. */
double sp_design_extreme(const sp_design_problem *d, const double *g, double *factor) {
    double low = 0, high = 0, rest = 0, at_level = 0;
    for (int32_t i = 0; i < d->p->n && !d->opt->free; i++)
        if (d->weight[i] > 0)
            high = fmax(high, fabs(g[i]) / d->weight[i]);
    low = -2 * high;
    high = 2 * high;
    for (int k = 0; k < 200 && low < high; k++) {
        const double middle = 0.5 * (low + high);
        if (middle <= low || middle >= high)
            break;
        if (total_above(d, g, middle) > d->total)
            low = middle;
        else
            high = middle;
    }
    for (int32_t i = 0; i < d->p->n; i++) {
        const double level = d->weight[i] > 0 ? g[i] / d->weight[i] : 0;
        const bool between = !d->opt->free && level > low && level <= high;
        factor[i] = d->weight[i] == 0                             ? 1
                    : between                                     ? NAN
                    : level > high || (d->opt->free && level > 0) ? d->opt->high
                                                                  : d->opt->low;
        rest += between ? 0 : d->weight[i] * factor[i];
        at_level += between ? d->weight[i] : 0;
    }
    for (int32_t i = 0; i < d->p->n; i++)
        if (isnan(factor[i]))
            factor[i] = clamp(d, (d->total - rest) / at_level);
    return 0.5 * (low + high);
}
