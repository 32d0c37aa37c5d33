/* Estimates remaining times. */
#include "cost/remaining.h"

#include <math.h>

sp_remaining sp_remaining_begin(double work, double before, double seconds) {
    return (sp_remaining){.work = fmax(work, 1), .before = before, .seconds = seconds, .shown = -1};
}

/* Share of the expected work that is left at the share x. From 0.8 on it tends to 0 slowly: work that has lasted as
 * long as expected is not done for that. */
static double share_left(double x) {
    const double end = 0.2;
    return x < 1 - end ? 1 - x : end / (1 + (x - (1 - end)) / end);
}

double sp_remaining_fraction(const sp_remaining *r, double done) { return 1 - share_left(fmax(0, done) / r->work); }

double sp_remaining_fall(sp_remaining *r, double elapsed, double left) {
    if (r->shown >= 0 && left > r->shown) /* so fast that it ends when the estimate does */
        left = r->shown * exp(-(elapsed - r->shown_at) / left);
    r->shown = left;
    r->shown_at = elapsed;
    return left;
}

/* The pace counts as if a twentieth of the work had been done at the expected one. */
sp_time_left sp_remaining_next(sp_remaining *r, double elapsed, double done) {
    const double known = 0.05 * r->work, now = fmax(0, done - r->before);
    const double pace = (known * r->seconds + elapsed) / (known + now);
    const double left = sp_remaining_fall(r, elapsed, r->work * share_left(fmax(0, done) / r->work) * pace);
    /* a factor of 2 at first, none from a half on */
    const double doubt = fmax(1, 2 - 2 * fmax(0, done) / r->work);
    return (sp_time_left){left / doubt, left};
}
