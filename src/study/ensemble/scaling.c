/* Makes the tables scaling and planes: fronts over distance, from wall to wall in boxes of several heights, or at
 * planes inside tall boxes. */
#include "base/base.h"
#include "base/text.h"
#include "ensemble/groups.h"
#include "ensemble/speed.h"

#include <math.h>
#include <sonopack/scaling.h>
#include <stdio.h>
#include <string.h>

/* The fronts of a group of samples, as input of sp_scaling_make. */
typedef struct fronts {
    sp_scaling_input in;
    int64_t *samples;
    const double **distance;
    const sp_front **front;
    double *memory; /* distances */
    sp_front *fronts;
    const sp_sample *const *first; /* sample of the group */
    int64_t *begin;                /* from wall to wall: row r has the samples from begin[r] on. Not used for planes */
    int64_t n;
} fronts;

static void fronts_free(fronts *f) {
    sp_free(f->samples);
    sp_free(f->distance);
    sp_free(f->front);
    sp_free(f->memory);
    sp_free(f->fronts);
    sp_free(f->begin);
}

static sp_status fronts_make(int64_t rows, int64_t numbers, const sp_sample *const *s, int64_t n, fronts *out,
                             sp_error *err) {
    const size_t r = (size_t)rows + 1, m = (size_t)numbers;
    fronts f = {.first = s, .n = n};
    f.samples = sp_alloc(r, sizeof *f.samples);
    f.distance = sp_alloc(r, sizeof(const double *));
    f.front = sp_alloc(r, sizeof(const sp_front *));
    f.memory = sp_alloc(m, sizeof *f.memory);
    f.fronts = sp_alloc(m, sizeof *f.fronts);
    f.begin = sp_alloc(r, sizeof *f.begin);
    f.in = (sp_scaling_input){.samples = f.samples, .distance = f.distance, .front = f.front};
    *out = f;
    if (!f.samples || !f.distance || !f.front || !f.memory || !f.fronts || !f.begin)
        return sp_fail_memory(err, m * (sizeof *f.memory + sizeof *f.fronts));
    return SP_OK;
}

/* Collects the fronts from wall to wall, a row for each height. */
static sp_status of_walls(int64_t n, const sp_sample *const *s, fronts *f, sp_error *err) {
    sp_status status = fronts_make(n, n, s, n, f, err);
    int64_t used = 0;
    int rows = 0;
    for (int64_t begin = 0, end; status == SP_OK && begin < n; begin = end) {
        end = sp_height_end(n, s, begin);
        const int64_t first = used;
        for (int64_t k = begin; k < end; k++) {
            if (!(s[k]->have & SP_WANT_CTOF) || !(s[k]->height > 0) || !isfinite(s[k]->front.t10))
                continue;
            f->memory[used] = s[k]->height;
            f->fronts[used++] = s[k]->front;
        }
        if (used == first)
            continue;
        f->samples[rows] = used - first;
        f->distance[rows] = f->memory + first;
        f->front[rows] = f->fronts + first;
        f->begin[rows++] = begin;
    }
    f->in.rows = rows;
    return status;
}

/* Collects the heights of all planes at which any sample of the group has a front, ascending. */
static int planes_of(int64_t n, const sp_sample *const *s, int64_t capacity, double *plane) {
    int count = 0;
    for (int64_t k = 0; k < n; k++)
        for (int32_t i = 0; s[k]->have & SP_WANT_PLANES && i < s[k]->planes; i++) {
            int at = 0;
            while (at < count && plane[at] < s[k]->plane[i])
                at++;
            if (!isfinite(s[k]->plane_front[i].t10) || (at < count && plane[at] == s[k]->plane[i]) || count == capacity)
                continue;
            memmove(plane + at + 1, plane + at, (size_t)(count - at) * sizeof *plane);
            plane[at] = s[k]->plane[i];
            count++;
        }
    return count;
}

static sp_front front_at(const sp_sample *s, double plane) {
    for (int32_t i = 0; s->have & SP_WANT_PLANES && i < s->planes; i++)
        if (s->plane[i] == plane)
            return s->plane_front[i];
    return (sp_front){NAN, NAN, NAN, NAN, NAN, 0};
}

/* Collects the fronts at planes, for samples of one size. A sample without a front at a plane has NAN there. */
static sp_status of_planes(int64_t n, const sp_sample *const *s, fronts *f, sp_error *err) {
    const int64_t most = 8 * SP_PLANES_MAX; /* enough for several scenes together */
    double *plane = sp_alloc((size_t)most, sizeof *plane);
    if (!plane)
        return sp_fail_memory(err, (size_t)most * sizeof *plane);
    const int rows = planes_of(n, s, most, plane);
    sp_status status = fronts_make(rows, n * rows, s, n, f, err);
    for (int r = 0; status == SP_OK && r < rows; r++) {
        f->samples[r] = n;
        f->distance[r] = f->memory + r * n;
        f->front[r] = f->fronts + r * n;
        for (int64_t k = 0; k < n; k++) {
            f->memory[r * n + k] = plane[r];
            f->fronts[r * n + k] = front_at(s[k], plane[r]);
        }
    }
    f->in.rows = rows;
    f->in.joint = true;
    sp_free(plane);
    return status;
}

/* ---- the table ------------------------------------------------------------------------------------------------- */

#define TIME  "d/sqrt(E* / rho)"
#define SPEED "sqrt(E* / rho)"

/* Each has a column of its error after it. */
static const struct estimate_column {
    const char *name, *unit;
    size_t offset; /* in sp_scaling_row */
} estimates[] = {{"t10", TIME, offsetof(sp_scaling_row, t10)},
                 {"t_peak", TIME, offsetof(sp_scaling_row, t_peak)},
                 {"t_zero", TIME, offsetof(sp_scaling_row, t_zero)},
                 {"amplitude", "E* d^2", offsetof(sp_scaling_row, amplitude)},
                 {"width10", TIME, offsetof(sp_scaling_row, width)},
                 {"width_peak", TIME, offsetof(sp_scaling_row, width_peak)},
                 {"speed", SPEED, offsetof(sp_scaling_row, speed)},
                 {"speed_peak", SPEED, offsetof(sp_scaling_row, speed_peak)},
                 {"speed_zero", SPEED, offsetof(sp_scaling_row, speed_zero)},
                 {"gamma", "", offsetof(sp_scaling_row, gamma)},
                 {"alpha", "", offsetof(sp_scaling_row, alpha)},
                 {"alpha_peak", "", offsetof(sp_scaling_row, alpha_peak)}};
static const sp_column first[] = {{"p", "E*", SP_COLUMN_NUMBER},
                                  {"width", "d", SP_COLUMN_NUMBER},
                                  {"distance", "d", SP_COLUMN_NUMBER},
                                  {"distance_err", "d", SP_COLUMN_NUMBER},
                                  {"samples", "", SP_COLUMN_INTEGER}},
                       last[] = {{"c_l", SPEED, SP_COLUMN_NUMBER},         {"c_l_err", SPEED, SP_COLUMN_NUMBER},
                                 {"c_t", SPEED, SP_COLUMN_NUMBER},         {"c_t_err", SPEED, SP_COLUMN_NUMBER},
                                 {"speed_over_c_l", "", SP_COLUMN_NUMBER}, {"between", "d", SP_COLUMN_NUMBER},
                                 {"friction", "", SP_COLUMN_NUMBER},       {"dimension", "", SP_COLUMN_INTEGER},
                                 {"grains", "", SP_COLUMN_INTEGER},        {"speed_low", SPEED, SP_COLUMN_NUMBER},
                                 {"speed_high", SPEED, SP_COLUMN_NUMBER}};
enum {
    FIRST = sizeof first / sizeof *first,
    ESTIMATES = sizeof estimates / sizeof *estimates,
    LAST = sizeof last / sizeof *last,
    COLUMNS = FIRST + 2 * ESTIMATES + LAST + SP_STATE_COLUMNS
};

static sp_status add_columns(int64_t n, const sp_sample *const *s, sp_table *t, sp_error *err) {
    sp_status status = sp_columns_add(t, FIRST, first, err);
    for (int k = 0; k < 2 * ESTIMATES && status == SP_OK; k++) {
        char name[40];
        snprintf(name, sizeof name, "%s%s", estimates[k / 2].name, k % 2 ? "_err" : "");
        status = sp_table_add_column(t, name, estimates[k / 2].unit, SP_COLUMN_NUMBER, err);
    }
    if (status == SP_OK)
        status = sp_columns_add(t, LAST, last, err);
    return status == SP_OK ? sp_state_columns(n, s, true, t, err) : status;
}

/* The samples of a row; for planes, all samples of the group. */
static int64_t row_samples(const fronts *f, int r, const sp_sample *const **s) {
    if (f->in.joint) {
        *s = f->first;
        return f->n;
    }
    *s = f->first + f->begin[r];
    return sp_height_end(f->n, f->first, f->begin[r]) - f->begin[r];
}

static sp_arrivals arrivals(const fronts *f, int r, double *time) {
    const sp_arrivals a = {f->samples[r], f->distance[r], time};
    for (int64_t k = 0; k < a.n; k++)
        time[k] = isfinite(f->front[r][k].t10) ? f->front[r][k].t10 : NAN;
    return a;
}

/* Interval of the speed to the next row; NAN in the last row. scratch has space for the samples of both rows. */
static sp_status speed_interval(const fronts *f, int r, double level, double *scratch, sp_interval *out,
                                sp_error *err) {
    if (r + 1 >= f->in.rows) {
        *out = (sp_interval){NAN, NAN};
        return SP_OK;
    }
    const sp_arrivals near = arrivals(f, r, scratch), far = arrivals(f, r + 1, scratch + near.n);
    return sp_speed_interval(&near, &far, f->in.joint, level, out, err);
}

static sp_status add_row(const fronts *f, const sp_scaling *scaling, int r, double level, double *scratch, sp_table *t,
                         sp_error *err) {
    const sp_sample *const *s, *const *next;
    const int64_t n = row_samples(f, r, &s);
    const sp_scaling_row *row = &scaling->row[r];
    const sp_estimate c_l = sp_wave_speed(n, s, false, scratch), c_t = sp_wave_speed(n, s, true, scratch);
    double over = NAN, pressure_error;
    if (r + 1 < scaling->rows) {
        const int64_t above = row_samples(f, r + 1, &next);
        over = row->speed.value / (0.5 * (c_l.value + sp_wave_speed(above, next, false, scratch).value));
    }
    sp_interval interval;
    const sp_status status = speed_interval(f, r, level, scratch, &interval, err);
    if (status != SP_OK)
        return status;
    const double begin[FIRST] = {sp_state_pressure(n, s, &pressure_error), s[0]->width, row->distance.value,
                                 row->distance.error, (double)row->samples},
                 end[LAST] = {c_l.value,      c_l.error, c_t.value,    c_t.error,    over,         row->between,
                              s[0]->friction, s[0]->dim, s[0]->grains, interval.low, interval.high};
    double v[COLUMNS];
    memcpy(v, begin, sizeof begin);
    for (int k = 0; k < ESTIMATES; k++) {
        sp_estimate one;
        memcpy(&one, (const char *)row + estimates[k].offset, sizeof one);
        v[FIRST + 2 * k] = one.value;
        v[FIRST + 2 * k + 1] = one.error;
    }
    memcpy(v + FIRST + 2 * ESTIMATES, end, sizeof end);
    sp_state_put(n, s, t, v + FIRST + 2 * ESTIMATES + LAST);
    return sp_table_add_numbers(t, v, err);
}

/* Adds a comment "gamma(p=0.0001, width=24) = 1.5, error 0.02, ..." for each fit. */
static sp_status add_fits(const fronts *f, const sp_scaling *s, sp_table *t, sp_error *err) {
    const struct {
        const char *name;
        const sp_scaling_fit *fit;
    } fits[] = {{"gamma", &s->gamma},
                {"gamma_log", &s->gamma_log},
                {"alpha", &s->alpha},
                {"alpha_peak", &s->alpha_peak},
                {"speed", &s->speed}};
    const sp_sample *one = f->first[0];
    char where[160], chi2[80];
    sp_locale locale = sp_locale_enter(); /* for the comments */
    int length =
        snprintf(where, sizeof where, "p=%.6g, width=%.6g, friction=%.6g", one->pressure, one->width, one->friction);
    if (one->kind == SP_PACK_TRIANGULAR || one->kind == SP_PACK_CHAIN)
        length += snprintf(where + length, sizeof where - (size_t)length, ", %s",
                           one->kind == SP_PACK_CHAIN ? "chain" : "triangular");
    if (one->stage > 0)
        length += snprintf(where + length, sizeof where - (size_t)length, ", strain=%.6g", one->strain);
    if (f->in.joint)
        snprintf(where + length, sizeof where - (size_t)length, ", grains=%d", one->grains);
    sp_status status = SP_OK;
    for (size_t k = 0; k < sizeof fits / sizeof *fits && status == SP_OK; k++) {
        const sp_scaling_fit *fit = fits[k].fit;
        if (!isfinite(fit->value.value))
            continue;
        snprintf(chi2, sizeof chi2, "equal weights, no chi2");
        if (isfinite(fit->chi2) && fit->freedom < 1)
            snprintf(chi2, sizeof chi2, "through all of its points, no chi2");
        else if (isfinite(fit->chi2))
            snprintf(chi2, sizeof chi2, "chi2 %.3g for %lld degrees of freedom", fit->chi2, (long long)fit->freedom);
        status = sp_table_add_comment(t, err, "%s(%s) = %.6g, error %.2g, %s", fits[k].name, where, fit->value.value,
                                      fit->value.error, chi2);
    }
    sp_locale_leave(&locale);
    return status;
}

static sp_status add_group(int64_t n, const sp_sample *const *s, bool planes, double level, sp_table *t,
                           sp_error *err) {
    fronts f = {0};
    sp_scaling scaling = {0};
    double *scratch = sp_alloc((size_t)n, 2 * sizeof *scratch);
    sp_status status = scratch ? SP_OK : sp_fail_memory(err, (size_t)n * 2 * sizeof *scratch);
    if (status == SP_OK)
        status = planes ? of_planes(n, s, &f, err) : of_walls(n, s, &f, err);
    if (status == SP_OK && f.in.rows > 0)
        status = sp_scaling_make(&f.in, &scaling, err);
    for (int r = 0; r < scaling.rows && status == SP_OK; r++)
        status = add_row(&f, &scaling, r, level, scratch, t, err);
    if (status == SP_OK && scaling.rows > 1)
        status = add_fits(&f, &scaling, t, err);
    sp_scaling_free(&scaling);
    fronts_free(&f);
    sp_free(scratch);
    return status;
}

static sp_status explain(bool planes, double level, sp_table *t, sp_error *err) {
    sp_status status = sp_table_add_comment(
        t, err,
        planes
            ? "fronts of the momentum flux through planes at `distance' above the bottom wall, inside of packings of "
              "so many grains; the marks of one packing belong together, and errors are by bootstrap over packings; "
              "the rows are correlated, chi2 is only a hint"
            : "fronts from wall to wall in boxes of several heights; errors by bootstrap over samples");
    if (status == SP_OK)
        status = sp_table_add_comment(
            t, err,
            "arithmetic means and their standard errors; width10 = t_zero - t10, width_peak = t_zero - t_peak; speeds "
            "and exponents are of the interval to the next row: amplitude ~ L^-gamma, width10 ~ L^alpha, at the "
            "distance `between'; speed_over_c_l: over the mean c_l of the two rows; fits below: of all rows, gamma_log "
            "of exp<ln amplitude>, speed of t10 over L");
    return status == SP_OK ? sp_interval_comment(t, level, "the speed", err) : status;
}

sp_status sp_scaling_fill(int64_t n, const sp_sample *const *s, bool planes, double level, sp_table *t, sp_error *err) {
    sp_status status = add_columns(n, s, t, err);
    if (status == SP_OK)
        status = explain(planes, level, t, err);
    for (int64_t begin = 0, end; begin < n && status == SP_OK; begin = end) {
        end = planes ? sp_height_end(n, s, begin) : sp_material_end(n, s, begin);
        status = add_group(end - begin, s + begin, planes, level, t, err);
    }
    return status;
}
