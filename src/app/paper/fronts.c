/* Averages fronts over samples by distance, and fits lines to them. */
#include "paper/fronts.h"

#include "base/base.h"

#include <math.h>

static double height(const sp_sample *s) { return s->height; }
static double t10(const sp_sample *s) { return s->front.t10; }
static double t_peak(const sp_sample *s) { return s->front.t_peak; }
static double t_zero(const sp_sample *s) { return s->front.t_zero; }
static double amplitude(const sp_sample *s) { return s->front.amplitude; }
static double width(const sp_sample *s) { return s->front.width; }

static sp_status mean_of(const paper *p, const paper_distance *d, double (*of)(const sp_sample *s), int64_t *n,
                         paper_mean *out, sp_error *err) {
    double *values = NULL;
    paper_row row = {0};
    sp_status status = sp_paper_values(p, d->ensemble, 1e-4, d->grains, SP_WANT_CTOF, of, n, &values, err);
    if (status != SP_OK)
        return status;
    sp_paper_row_mean(&row, *n, values);
    sp_free(values);
    *out = (paper_mean){row.ours, row.ours_sd, row.err};
    return SP_OK;
}

static sp_status fill(const paper *p, paper_distance *d, sp_error *err) {
    const struct {
        double (*of)(const sp_sample *s);
        paper_mean *mean;
    } part[] = {
        {t10, &d->t10}, {t_peak, &d->t_peak}, {t_zero, &d->t_zero}, {amplitude, &d->amplitude}, {width, &d->width}};
    paper_mean distance = {0};
    sp_status status = mean_of(p, d, height, &d->n, &distance, err);
    d->distance = distance.mean;
    for (size_t k = 0; k < sizeof part / sizeof *part && status == SP_OK; k++)
        status = mean_of(p, d, part[k].of, &d->n, part[k].mean, err);
    return status;
}

static sp_status fill_all(const paper *p, const paper_distance all[PAPER_DISTANCES], int *n,
                          paper_distance out[PAPER_DISTANCES], sp_error *err) {
    int count = 0;
    for (int k = 0; k < PAPER_DISTANCES; k++) {
        paper_distance d = all[k];
        sp_status status = fill(p, &d, err);
        if (status != SP_OK)
            return status;
        if (d.n > 0)
            out[count++] = d;
    }
    *n = count;
    return SP_OK;
}

sp_status sp_paper_heights(const paper *p, int *n, paper_distance out[PAPER_DISTANCES], sp_error *err) {
    static const paper_distance all[PAPER_DISTANCES] = {
        {.ensemble = PAPER_SHORT, .grains = 100}, {.ensemble = PAPER_LOW, .grains = 200},
        {.ensemble = PAPER_SHORT, .grains = 400}, {.ensemble = PAPER_SQUARE, .grains = 600},
        {.ensemble = PAPER_TALL, .grains = 1200}, {.ensemble = PAPER_TALLEST, .grains = 2400}};
    return fill_all(p, all, n, out, err);
}

paper_range sp_paper_fitted(int n, const paper_distance *d, bool all) {
    paper_range r = {0, n};
    while (r.first < n && d[r.first].distance < 6)
        r.first++;
    while (!all && r.end > r.first && d[r.end - 1].distance > 60)
        r.end--;
    return r;
}

sp_status sp_paper_chains(const paper *p, paper_ensemble e, int *n, paper_distance out[PAPER_DISTANCES],
                          sp_error *err) {
    paper_distance all[PAPER_DISTANCES];
    for (int k = 0; k < PAPER_DISTANCES; k++)
        all[k] = (paper_distance){.ensemble = e, .grains = 25 << k};
    return fill_all(p, all, n, out, err);
}

paper_line sp_paper_line_fit(int n, const double *x, const double *y, const double *y_err) {
    double x_mean = 0, y_mean = 0, xx = 0, xy = 0, variance = 0;
    for (int k = 0; k < n; k++) {
        x_mean += x[k] / n;
        y_mean += y[k] / n;
    }
    for (int k = 0; k < n; k++) {
        xx += (x[k] - x_mean) * (x[k] - x_mean);
        xy += (x[k] - x_mean) * (y[k] - y_mean);
        variance += pow((x[k] - x_mean) * (isfinite(y_err[k]) ? y_err[k] : NAN), 2);
    }
    if (n < 2 || !(xx > 0))
        return (paper_line){NAN, NAN, NAN};
    return (paper_line){xy / xx, y_mean - xy / xx * x_mean, sqrt(variance) / xx};
}

const paper_mean *sp_paper_amplitude(const paper_distance *d) { return &d->amplitude; }
const paper_mean *sp_paper_width(const paper_distance *d) { return &d->width; }

paper_line sp_paper_power(int n, const paper_distance *d, const paper_mean *(*of)(const paper_distance *d)) {
    double x[PAPER_DISTANCES], y[PAPER_DISTANCES], y_err[PAPER_DISTANCES];
    for (int k = 0; k < n; k++) {
        const paper_mean *m = of(&d[k]);
        x[k] = log(d[k].distance);
        y[k] = log(m->mean);
        y_err[k] = m->err / m->mean;
    }
    return sp_paper_line_fit(n, x, y, y_err);
}
