/* Mean and scatter of many signals, which are added one by one. */
#include "base/base.h"

#include <math.h>
#include <sonopack/study/study.h>
#include <string.h>

/* Times of the same grid differ by rounding only: at most this, relative to the last time. */
static const double same_time = 1e-12;

sp_signal_average sp_signal_average_none(void) { return (sp_signal_average){0}; }

void sp_signal_average_free(sp_signal_average *s) {
    sp_free(s->t);
    *s = sp_signal_average_none();
}

static sp_status start(sp_signal_average *s, int32_t points, const double *t, sp_error *err) {
    if (points < 1)
        return sp_fail(err, SP_EINVAL, "a signal of %d points: must be 1 or more", points);
    const size_t n = (size_t)points;
    double *memory = sp_alloc(3 * n, sizeof *memory); /* zeros */
    if (!memory)
        return sp_fail_memory(err, 3 * n * sizeof *memory);
    memcpy(memory, t, n * sizeof *memory);
    *s = (sp_signal_average){.points = points, .t = memory, .mean = memory + n, .squares = memory + 2 * n};
    return SP_OK;
}

static sp_status check_times(const sp_signal_average *s, int32_t points, const double *t, sp_error *err) {
    if (points != s->points)
        return sp_fail(err, SP_EREFUSED, "a signal of %d points: must be %d as those before", points, s->points);
    const double most = same_time * fabs(s->t[points - 1]);
    for (int32_t k = 0; k < points; k++)
        if (!(fabs(t[k] - s->t[k]) <= most))
            return sp_fail(err, SP_EREFUSED, "time %d of a signal to %.15g is %.15g: must be %.15g as in those before",
                           k + 1, t[points - 1], t[k], s->t[k]);
    return SP_OK;
}

sp_status sp_signal_average_add(sp_signal_average *s, int32_t points, const double *t, const double *f, sp_error *err) {
    sp_status status = s->count == 0 ? start(s, points, t, err) : check_times(s, points, t, err);
    if (status != SP_OK)
        return status;
    s->count++;
    for (int32_t k = 0; k < points; k++) {
        const double deviation = f[k] - s->mean[k];
        s->mean[k] += deviation / (double)s->count;
        s->squares[k] += deviation * (f[k] - s->mean[k]);
    }
    return SP_OK;
}

double sp_signal_average_rms(const sp_signal_average *s, int32_t k) {
    return s->count > 1 ? sqrt(s->squares[k] / (double)s->count) : NAN;
}

double sp_signal_average_mean_err(const sp_signal_average *s, int32_t k) {
    return s->count > 1 ? sqrt(s->squares[k] / ((double)(s->count - 1) * (double)s->count)) : NAN;
}
