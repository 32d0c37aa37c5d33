/* The shortest path through a tube, by one pass over its nodes. */
#include "tapped/taut_string.h"

#include <math.h>

static void fill(const taut_ends *from, int32_t begin, int32_t end, double slope, const double *x, double *f) {
    for (int32_t k = begin; k < end; k++)
        f[k] = from->f0 + slope * (x[k] - from->x0);
}

void sp_taut_string(int32_t n, const double *x, const double *lo, const double *hi, const taut_ends *ends, double *f,
                    double *bend) {
    taut_ends knot = *ends; /* the string is final up to here */
    int32_t done = 0, turning = -1;
    double last = 0; /* slope of the last straight piece */
    for (int32_t k = 0; k < n; k++)
        bend[k] = 0;
    for (;;) {
        double most = INFINITY, least = -INFINITY, slope;
        int32_t at_most = -1, at_least = -1, k = done;
        bool over = false, under = false; /* the tube rises, or falls, more steeply than the string can follow */
        for (; k <= n; k++) {
            bool end = k == n, past = end && ends->free;
            double width = (end ? ends->x_end : x[k]) - knot.x0;
            double upper = past ? ends->slope_end : ((end ? ends->f_end : hi[k]) - knot.f0) / width;
            double lower = past ? ends->slope_end : ((end ? ends->f_end : lo[k]) - knot.f0) / width;
            over = lower > most;
            under = upper < least;
            if (over || under)
                break;
            if (upper <= most)
                most = upper, at_most = k;
            if (lower >= least)
                least = lower, at_least = k;
        }
        int32_t next = over ? at_most : under ? at_least : n;
        slope = under ? least : most;
        if (turning >= 0)
            bend[turning] = last - slope;
        fill(&knot, done, next, slope, x, f);
        if (next == n)
            return;
        f[next] = over ? hi[next] : lo[next];
        knot.x0 = x[next], knot.f0 = f[next];
        turning = next, last = slope, done = next + 1;
    }
}
