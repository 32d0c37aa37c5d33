/* Limits on a run: the times of its rows, the number of its steps, and cancellation by the user. */
#include "base/base.h"
#include "tapped/column.h"

sp_status sp_tapped_check_times(const sp_tapped_spec *c, int64_t n, const double *t, sp_error *err) {
    double last = sp_tapped_taps(c) * c->period, end = last * (1 + 1e-12);
    for (int64_t i = 0; i < n; i++)
        if (!(t[i] >= (i > 0 ? t[i - 1] : 0) && t[i] <= end))
            return sp_fail(err, SP_EINVAL, "time %lld, %.17g s: must be ascending, from 0 to %.17g s", (long long)i + 1,
                           t[i], last);
    return SP_OK;
}

sp_status sp_tapped_check_steps(const sp_tapped_spec *c, int64_t steps, int64_t most, double t, sp_error *err) {
    enum { INTERVAL = 256 }; /* steps between two calls of the user */
    if (steps % INTERVAL != 0)
        return SP_OK;
    if (c->stopped && c->stopped(c->user))
        return sp_fail(err, SP_EINTERRUPTED, "stopped at t = %.6g s: nothing is written", t);
    if (most > 0 && steps > most)
        return sp_fail(err, SP_EFAILED,
                       "t = %.6g s: more than %lld steps per tap; change column.time_step, column.stiffness or "
                       "column.amplitude to allow longer steps",
                       t, (long long)(most / sp_tapped_taps(c)));
    return SP_OK;
}
