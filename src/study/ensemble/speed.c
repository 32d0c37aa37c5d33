/* Confidence intervals of speeds, and long-wave speeds. */
#include "ensemble/speed.h"

#include "numeric/statistics.h"

#include <math.h>

typedef struct arrival_pair {
    const sp_arrivals *end[2]; /* near, far */
    bool joint;
} arrival_pair;

/* Means over the picked samples that have an arrival. */
typedef struct means {
    double distance, time, arrived;
} means;

static means means_of(const sp_arrivals *a, int64_t n, const int64_t *pick) {
    means m = {0, 0, 0};
    for (int64_t k = 0; k < n; k++) {
        const int64_t i = pick[k];
        if (isnan(a->time[i]))
            continue;
        m.distance += a->distance[i];
        m.time += a->time[i];
        m.arrived += 1;
    }
    m.distance /= m.arrived;
    m.time /= m.arrived;
    return m;
}

/* Contribution of sample i to ln speed, to first order and up to its sign. */
static double deviation(const sp_arrivals *a, const means *m, int64_t i, double rise, double time) {
    return isnan(a->time[i]) ? 0 : ((a->distance[i] - m->distance) / rise - (a->time[i] - m->time) / time) / m->arrived;
}

static void measure(const int64_t *size, const int64_t *const *pick, double *value, double *error, void *user) {
    const arrival_pair *f = user;
    const int far = f->joint ? 0 : 1;
    const means m[2] = {means_of(f->end[0], size[0], pick[0]), means_of(f->end[1], size[far], pick[far])};
    const double rise = m[1].distance - m[0].distance, time = m[1].time - m[0].time;
    *value = *error = NAN;
    if (!(rise > 0 && time > 0))
        return;
    double variance = 0;
    for (int g = 0; g <= far; g++) {
        double squares = 0;
        for (int64_t k = 0; k < size[g]; k++) {
            const int64_t i = pick[g][k];
            const double own = deviation(f->end[g], &m[g], i, rise, time);
            const double change = f->joint ? deviation(f->end[1], &m[1], i, rise, time) - own : own;
            squares += change * change;
        }
        variance += squares * (double)size[g] / (double)(size[g] - 1);
    }
    *value = rise / time;
    *error = *value * sqrt(variance);
}

sp_status sp_speed_interval(const sp_arrivals *near, const sp_arrivals *far, bool joint, double level, sp_interval *out,
                            sp_error *err) {
    arrival_pair f = {{near, far}, joint};
    const int64_t size[2] = {near->n, far->n};
    const sp_interval_problem problem = {joint ? 1 : 2, size, 1, measure, &f};
    sp_interval_options options = sp_interval_options_default();
    options.level = level;
    return sp_intervals(&problem, &options, out, err);
}

sp_status sp_interval_comment(sp_table *t, double level, const char *what, sp_error *err) {
    return sp_table_add_comment(t, err,
                                "_low, _high: interval of %s at level %.15g, by studentised bootstrap (%d resamples)",
                                what, level, sp_interval_resamples(level));
}

sp_estimate sp_wave_speed(int64_t n, const sp_sample *const *s, bool transverse, double *scratch) {
    int64_t count = 0;
    for (int64_t k = 0; k < n; k++)
        if (s[k]->have & SP_WANT_MODULI)
            scratch[count++] = transverse ? s[k]->moduli.c_t : s[k]->moduli.c_l;
    return (sp_estimate){sp_mean(count, scratch), sp_standard_error(count, scratch)};
}
