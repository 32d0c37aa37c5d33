#ifndef SP_REMAINING_H
#define SP_REMAINING_H
/* The time that work under way will still take: from what was expected of it, and from how fast it goes. */

#include <sonopack/status.h>

/* Work of an expected amount, in a unit that takes about the same time each, such as steps. */
typedef struct sp_remaining {
    double work;    /* expected, in all */
    double before;  /* done before the clock began */
    double seconds; /* expected for each unit */
    double shown;   /* what was last said; below 0: nothing yet */
    double shown_at;
} sp_remaining;
SP_SHARED sp_remaining sp_remaining_begin(double work, double before, double seconds);

/* Between these many seconds are left. They are equal once the pace is known. */
typedef struct sp_time_left {
    double low, high;
} sp_time_left;

/* Fraction of the work that is done: never 1, for the expectation may be too low. */
SP_SHARED double sp_remaining_fraction(const sp_remaining *r, double done);
/* elapsed: seconds since the clock began; done: work, with that before. What is said never grows: where work turns out
 * to be more than expected, it falls more slowly. */
SP_SHARED sp_time_left sp_remaining_next(sp_remaining *r, double elapsed, double done);
/* The same rule for an estimate of one's own. */
SP_SHARED double sp_remaining_fall(sp_remaining *r, double elapsed, double left);

#endif
