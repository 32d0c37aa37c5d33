#ifndef SP_TAPPED_TAUT_STRING_H
#define SP_TAPPED_TAUT_STRING_H
/* The taut-string problem, to which the sticking of a column reduces. */

#include <stdbool.h>
#include <stdint.h>

/* Finds the shortest path through a tube of n nodes at x (ascending) between lo and hi. It starts at
 * (x0, f0) and ends at (x_end, f_end) or, if free, with slope_end. f [n] receives its heights, bend [n] the decrease of
 * its slope at each node, exactly 0 where it is straight. */
typedef struct taut_ends {
    double x0, f0;
    bool free;
    double x_end, f_end, slope_end;
} taut_ends;
void sp_taut_string(int32_t n, const double *x, const double *lo, const double *hi, const taut_ends *ends, double *f,
                    double *bend);

#endif
