/* Makes the table ctof: speed of the front from the difference of arrival times at two heights (Fig. 6 of Somfai et al.
 * 2005). Height over time would be wrong, because the front is slower near the source. */
#include "base/base.h"
#include "ensemble/groups.h"
#include "ensemble/speed.h"
#include "numeric/statistics.h"

#include <math.h>

typedef enum mark { T10 = 0, T_PEAK, T_ZERO, MARKS } mark;
enum { COLUMNS = 14 }; /* of p, samples and the speeds */

/* Fronts of the samples of one pressure and size. */
typedef struct arrivals {
    int64_t n[MARKS]; /* samples with this mark */
    double *height[MARKS], *time[MARKS];
    double *memory;
    int32_t grains;
} arrivals;

/* Two heights and one mark, for sp_bootstrap. */
typedef struct height_pair {
    const arrivals *low, *high;
    mark mark;
} height_pair;

static double mean_of(const double *x, int64_t n, const int64_t *pick) {
    double sum = 0;
    for (int64_t k = 0; k < n; k++)
        sum += x[pick ? pick[k] : k];
    return sum / (double)n;
}

/* (<H2> - <H1>) / (<t>_2 - <t>_1); NAN unless both differences are positive. */
static double speed(const int64_t *size, const int64_t *const *pick, void *user) {
    const height_pair *f = user;
    mark m = f->mark;
    double rise = mean_of(f->high->height[m], size[1], pick[1]) - mean_of(f->low->height[m], size[0], pick[0]);
    double time = mean_of(f->high->time[m], size[1], pick[1]) - mean_of(f->low->time[m], size[0], pick[0]);
    return rise > 0 && time > 0 ? rise / time : NAN;
}

static double plain_speed(const arrivals *low, const arrivals *high, mark m) {
    height_pair f = {low, high, m};
    const int64_t size[2] = {low->n[m], high->n[m]};
    const int64_t *const pick[2] = {NULL, NULL};
    return size[0] > 0 && size[1] > 0 ? speed(size, pick, &f) : NAN;
}

static sp_status arrivals_make(int64_t n, const sp_sample *const *s, arrivals *out, sp_error *err) {
    arrivals a = {.grains = s[0]->grains};
    a.memory = sp_alloc((size_t)n, 2 * MARKS * sizeof *a.memory);
    if (!a.memory)
        return sp_fail_memory(err, (size_t)n * 2 * MARKS * sizeof *a.memory);
    for (int m = 0; m < MARKS; m++) {
        a.height[m] = a.memory + n * 2 * m;
        a.time[m] = a.height[m] + n;
        for (int64_t k = 0; k < n; k++) {
            const double time[MARKS] = {s[k]->front.t10, s[k]->front.t_peak, s[k]->front.t_zero};
            if (!(s[k]->have & SP_WANT_CTOF) || !isfinite(time[m]) || !isfinite(s[k]->height))
                continue;
            a.height[m][a.n[m]] = s[k]->height;
            a.time[m][a.n[m]++] = time[m];
        }
    }
    *out = a;
    return SP_OK;
}

/* The smallest and the largest size of one pressure that have fronts: s[low_begin .. low_end) and s[high_begin ..
 * high_end). Without any front, both are the largest size. */
typedef struct ends {
    int64_t low_begin, low_end, high_begin, high_end;
} ends;

static ends find_ends(int64_t n, const sp_sample *const *s) {
    ends e = {.low_begin = -1};
    for (int64_t begin = 0, end; begin < n; begin = end) {
        bool front = false;
        end = sp_size_end(n, s, begin);
        for (int64_t k = begin; k < end; k++)
            front = front || s[k]->have & SP_WANT_CTOF;
        if (!front && e.low_begin >= 0)
            continue;
        e.high_begin = begin;
        e.high_end = end;
        if (front && e.low_begin < 0) {
            e.low_begin = begin;
            e.low_end = end;
        }
    }
    if (e.low_begin < 0) {
        e.low_begin = e.high_begin;
        e.low_end = e.high_end;
    }
    return e;
}

/* Speeds between two heights; NAN where there is none. */
typedef struct speeds {
    double c[MARKS], error[MARKS];
    sp_interval interval; /* of c[T10] */
} speeds;

static sp_status measure_speeds(const arrivals *low, const arrivals *high, double level, speeds *out, sp_error *err) {
    const sp_bootstrap_options options = sp_bootstrap_options_default();
    sp_status status = SP_OK;
    for (int m = 0; m < MARKS && status == SP_OK; m++) {
        height_pair f = {low, high, (mark)m};
        const int64_t size[2] = {low->n[m], high->n[m]};
        out->c[m] = plain_speed(low, high, (mark)m);
        status = sp_bootstrap(2, size, speed, &f, &options, &out->error[m], err);
    }
    const sp_arrivals near = {low->n[T10], low->height[T10], low->time[T10]},
                      far = {high->n[T10], high->height[T10], high->time[T10]};
    return status == SP_OK ? sp_speed_interval(&near, &far, false, level, &out->interval, err) : status;
}

/* Adds the row of one pressure. */
static sp_status add_pressure(int64_t n, const sp_sample *const *s, double level, sp_table *t, sp_error *err) {
    const ends e = find_ends(n, s);
    const int64_t high_n = e.high_end - e.high_begin;
    arrivals low = {0}, high = {0};
    speeds v = {{NAN, NAN, NAN}, {NAN, NAN, NAN}, {NAN, NAN}};
    sp_estimate c_l, c_t;
    double p_error;
    const double p = sp_state_pressure(n, s, &p_error);
    sp_status status = arrivals_make(e.low_end - e.low_begin, s + e.low_begin, &low, err);
    if (status == SP_OK)
        status = arrivals_make(high_n, s + e.high_begin, &high, err);
    double *scratch = sp_alloc((size_t)high_n, sizeof *scratch);
    if (status == SP_OK && !scratch)
        status = sp_fail_memory(err, (size_t)high_n * sizeof *scratch);
    if (status != SP_OK)
        goto out;
    c_l = sp_wave_speed(high_n, s + e.high_begin, false, scratch);
    c_t = sp_wave_speed(high_n, s + e.high_begin, true, scratch);
    if (e.low_begin < e.high_begin) {
        status = measure_speeds(&low, &high, level, &v, err);
        if (status == SP_OK)
            status = sp_table_add_comment(t, err, "p = %.6g: grains %d and %d, heights %.6g and %.6g", p, low.grains,
                                          high.grains, sp_mean(low.n[T10], low.height[T10]),
                                          sp_mean(high.n[T10], high.height[T10]));
    } else {
        status =
            sp_table_add_comment(t, err, "p = %.6g: c_tof, c_peak and c_zero need two heights with fronts; here is %s",
                                 p, high.n[T10] > 0 ? "one" : "none");
    }
    int64_t samples = low.n[T10] < high.n[T10] ? low.n[T10] : high.n[T10];
    double row[COLUMNS + SP_STATE_COLUMNS] = {
        p,         (double)samples, v.c[T10],        v.error[T10],    v.c[T_PEAK],     v.c[T_ZERO], c_l.value,
        c_t.value, v.interval.low,  v.interval.high, v.error[T_PEAK], v.error[T_ZERO], c_l.error,   c_t.error};
    sp_state_put(n, s, t, row + COLUMNS);
    if (status == SP_OK)
        status = sp_table_add_numbers(t, row, err);
out:
    sp_free(scratch);
    sp_free(low.memory);
    sp_free(high.memory);
    return status;
}

sp_status sp_fit_power(int64_t n, const double *x, const double *y, const double *y_err, double *exponent,
                       double *exponent_err, double *prefactor, sp_error *err) {
    if (n < 3)
        return sp_fail(err, SP_EINVAL, "power law: %lld points, at least 3 are needed", (long long)n);
    sp_status status = SP_OK;
    double *memory = sp_alloc((size_t)n, 3 * sizeof *memory);
    if (!memory)
        return sp_fail_memory(err, (size_t)n * 3 * sizeof *memory);
    double *lx = memory, *ly = memory + n, *le = memory + 2 * n;
    for (int64_t k = 0; k < n; k++) {
        if (!(x[k] > 0 && isfinite(x[k])) || !(y[k] > 0 && isfinite(y[k])) || (y_err && !(y_err[k] > 0))) {
            status = sp_fail(err, SP_EINVAL, "power law: point %lld is (%g, %g) with error %g; positive numbers needed",
                             (long long)k, x[k], y[k], y_err ? y_err[k] : NAN);
            goto out;
        }
        lx[k] = log(x[k]);
        ly[k] = log(y[k]);
        le[k] = y_err ? y_err[k] / y[k] : 1;
    }
    sp_line line;
    status = sp_fit_line(n, lx, ly, y_err ? le : NULL, &line, err);
    if (status != SP_OK)
        goto out;
    /* scatter beyond the given errors increases the error of the exponent; smaller scatter does not decrease it */
    double scatter = y_err ? fmax(1, sqrt(line.chi2 / (double)line.freedom)) : 1;
    *exponent = line.slope;
    *exponent_err = line.slope_err * scatter;
    *prefactor = exp(line.intercept);
out:
    sp_free(memory);
    return status;
}

/* Adds comments with the exponent of c_tof in p. */
static sp_status add_exponent(sp_table *t, sp_error *err) {
    size_t rows = (size_t)t->rows;
    double *memory = sp_alloc(rows, 3 * sizeof *memory);
    if (!memory)
        return sp_fail_memory(err, rows * 3 * sizeof *memory);
    double *p = memory, *c = memory + rows, *c_err = memory + 2 * rows;
    int64_t n = 0;
    bool errors = true;
    const bool strained = sp_table_find_column(t, "strain") >= 0; /* then the pressure is not all that changes */
    for (int64_t k = 0; k < t->rows; k++) {
        p[n] = sp_table_number(t, k, 0);
        c[n] = sp_table_number(t, k, 2);
        c_err[n] = sp_table_number(t, k, 3);
        if (!isfinite(c[n]) || strained)
            continue;
        errors = errors && c_err[n] > 0;
        n++;
    }
    sp_status status;
    double exponent, exponent_err, prefactor;
    if (n >= 3 && sp_fit_power(n, p, c, errors ? c_err : NULL, &exponent, &exponent_err, &prefactor, NULL) == SP_OK) {
        status = sp_table_add_comment(t, err, "exponent = %.6f", exponent);
        if (status == SP_OK)
            status = sp_table_add_comment(t, err, "exponent_err = %.6f", exponent_err);
        if (status == SP_OK)
            status = sp_table_add_comment(t, err, "exponent and its error: c_tof ~ p^exponent, %s",
                                          errors ? "weighted by c_tof_err" : "equal weights, error from the scatter");
    } else {
        status = sp_table_add_comment(t, err, "exponent = nan (it needs 3 pressures with c_tof%s)",
                                      strained ? ", without a path of strain" : "");
    }
    sp_free(memory);
    return status;
}

sp_status sp_ctof_fill(int64_t n, const sp_sample *const *s, double level, sp_table *t, sp_error *err) {
    static const char *const names[] = {"c_tof",     "c_tof_err",  "c_peak",     "c_zero",     "c_l",     "c_t",
                                        "c_tof_low", "c_tof_high", "c_peak_err", "c_zero_err", "c_l_err", "c_t_err"};
    static const sp_column first[] = {{"p", "E*", SP_COLUMN_NUMBER}, {"samples", "", SP_COLUMN_INTEGER}};
    sp_status status = sp_columns_add(t, 2, first, err);
    for (size_t k = 0; k < sizeof names / sizeof *names && status == SP_OK; k++)
        status = sp_table_add_column(t, names[k], "sqrt(E* / rho)", SP_COLUMN_NUMBER, err);
    if (status == SP_OK)
        status = sp_state_columns(n, s, true, t, err);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err,
                                      "c_tof = (<H2> - <H1>)/(<t10>_2 - <t10>_1) between the lowest and the "
                                      "highest boxes of a pressure; c_peak, c_zero likewise with t_peak, "
                                      "t_zero; samples: with a front, of each of the two (the smaller "
                                      "number); c_l, c_t: means over the highest boxes");
    for (int64_t begin = 0, end; begin < n && status == SP_OK; begin = end) {
        end = sp_pressure_end(n, s, begin);
        status = add_pressure(end - begin, s + begin, level, t, err);
    }
    if (status == SP_OK)
        status = sp_table_add_comment(t, err,
                                      "_err: standard errors, of speeds of the front by bootstrap over samples, of the "
                                      "means c_l and c_t their standard deviation over sqrt(n)");
    if (status == SP_OK)
        status = sp_interval_comment(t, level, "c_tof", err);
    if (status == SP_OK)
        status = add_exponent(t, err);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err,
                                      "published%s: c_tof ~ p^0.166 (1/6), c_tof(1e-4) = 0.25..0.26 (Somfai et "
                                      "al., Phys. Rev. E 72, 021301, 2005)",
                                      n > 0 && s[0]->dim != 2 ? " for two dimensions" : "");
    if (status == SP_OK && n > 0) /* what figures of several tables tell them apart by */
        status = sp_table_add_comment(t, err, "dimension = %d, friction = %.15g, width = %.15g", s[0]->dim,
                                      s[0]->friction, s[0]->width);
    return status;
}
