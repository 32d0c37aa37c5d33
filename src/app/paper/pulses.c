/* Makes Figs. 4 to 6: signals, their coherent parts in boxes of several heights, and arrival times. */
#include "paper/fronts.h"
#include "paper/signals.h"

#include "base/base.h"

#include <math.h>
#include <stdio.h>

/* ---- Fig. 4 ----------------------------------------------------------------------------------------------------- */

enum { PANELS = 4, PANEL_CURVES = PAPER_SINGLES };

static sp_curve plain_curve(const char *label, const paper_signals *s, const double *y, int ink, sp_dash dash) {
    return (sp_curve){.label = label, .n = s->points, .x = s->t, .y = y, .ink = ink, .dash = dash, .width = 0.8};
}

/* Curves of one panel: single packings in (a), mean and scatter beside one of them otherwise. */
static int fill_panel(int which, const paper_signals *s, sp_curve curve[PANEL_CURVES]) {
    static const char *const names[PAPER_SINGLES] = {"packing 1 (Fig. 1)", "packing 2", "packing 3", "packing 4"};
    static const int inks[PAPER_SINGLES] = {2, 1, 3, 0};
    int n = 0;
    if (which == 0) {
        for (int k = 0; k < PAPER_SINGLES && k < s->n; k++)
            curve[n++] = plain_curve(names[k], s, s->single + (size_t)k * (size_t)s->points, inks[k], SP_DASH_SOLID);
        return n;
    }
    if (which > 1)
        curve[n++] = plain_curve("one packing", s, s->single, -1, SP_DASH_SOLID);
    curve[n++] = plain_curve("mean", s, s->mean, 0, SP_DASH_SOLID);
    if (s->n > 1)
        curve[n++] = plain_curve("rms deviation", s, s->rms, 2, SP_DASH_DASHED);
    return n;
}

/* Reports the scatter relative to the peak of the mean: at the peak, and the largest after the first zero crossing. */
static void say_scatter(paper *p, int item, const char *what, const paper_signals *s) {
    sp_front front;
    const sp_front_options rule = sp_front_options_default();
    if (s->n < 2 || sp_front_find(s->points, s->t, s->mean, &rule, &front, NULL) != SP_OK)
        return;
    double at_peak = NAN, later = 0;
    for (int32_t k = 0; k < s->points; k++) {
        if (s->t[k] <= front.t_peak)
            at_peak = s->rms[k];
        if (s->t[k] > front.t_zero)
            later = fmax(later, s->rms[k]);
    }
    sp_paper_say(
        p, item,
        "%s, %lld packings: the rms deviation between packings is %.0f%% of the mean's first peak at that peak, and "
        "reaches %.0f%% after the first zero crossing.",
        what, (long long)s->n, 100 * at_peak / front.amplitude, 100 * later / front.amplitude);
}

sp_status sp_paper_make_fig4(paper *p, int item, sp_error *err) {
    static const char *const tags[PANELS] = {"(a) 2D, |μ| = 0.5", "(b) 2D, |μ| = 0.5", "(c) 2D, |μ| = 0",
                                             "(d) 3D, |μ| = 0"};
    static const char *const names[PANELS] = {"", "2D with friction", "2D without friction", "3D without friction"};
    static const paper_ensemble ensembles[PANELS] = {PAPER_SQUARE, PAPER_SQUARE, PAPER_SMOOTH, PAPER_SPHERES};
    paper_signals s[PANELS] = {0};
    sp_curve curve[PANELS][PANEL_CURVES];
    sp_panel panel[PANELS];
    sp_status status = SP_OK;
    for (int k = 0; k < PANELS && status == SP_OK; k++) {
        status = sp_paper_signals_make(p, ensembles[k], 0, 400, 1601, &s[k], err);
        if (status != SP_OK)
            break;
        sp_paper_signals_over(&s[k], sp_paper_signals_peak(&s[k]));
        panel[k] = (sp_panel){.tag = tags[k],
                              .x = {PAPER_TIME_AXIS, false, 0, 400},
                              .y = {"|F|_{sig} / first peak of the mean", false, NAN, NAN},
                              .curves = fill_panel(k, &s[k], curve[k]),
                              .curve = curve[k],
                              .zero_line = true};
        if (k > 0)
            say_scatter(p, item, names[k], &s[k]);
    }
    const sp_sheet sheet = {.title = "Signals", .rows = 2, .columns = 2, .panel = panel};
    if (status == SP_OK)
        status =
            sp_paper_draw(p, item, "fig4", &sheet,
                          "Force on the top wall at p = 1e-4 over the first peak of the ensemble's mean: (a) single "
                          "packings with friction, (b) their ensemble, (c) 2D and (d) 3D without friction.",
                          err);
    for (int k = 0; k < PANELS; k++)
        sp_paper_signals_free(&s[k]);
    return status;
}

/* ---- Fig. 5 ----------------------------------------------------------------------------------------------------- */

static sp_status coherent_curve(paper *p, const paper_distance *d, int ink, paper_signals *s, sp_curve *out,
                                sp_error *err) {
    static const sp_dash dashes[] = {SP_DASH_SOLID, SP_DASH_DASHED, SP_DASH_DASH_DOT};
    sp_status status = sp_paper_signals_make(p, d->ensemble, d->grains, 1.15 * d->t_zero.mean, 400, s, err);
    if (status != SP_OK)
        return status;
    int32_t from = 0; /* nothing happens before the front arrives */
    while (from < s->points && s->t[from] < 0.75 * d->t10.mean)
        from++;
    *out = (sp_curve){.n = s->points - from,
                      .x = s->t + from,
                      .y = s->mean + from,
                      .ink = ink % 4,
                      .dash = dashes[ink % 3],
                      .width = 1};
    return SP_OK;
}

sp_status sp_paper_make_fig5(paper *p, int item, sp_error *err) {
    paper_distance d[PAPER_DISTANCES];
    paper_signals s[PAPER_DISTANCES] = {0};
    sp_curve curve[PAPER_DISTANCES];
    char label[PAPER_DISTANCES][40];
    int n = 0, curves = 0;
    sp_status status = sp_paper_heights(p, &n, d, err);
    const int first = n > 1 && d[0].grains == 100; /* its amplitude would dwarf the others */
    for (int k = first; k < n && status == SP_OK; k++) {
        status = coherent_curve(p, &d[k], curves, &s[k], &curve[curves], err);
        snprintf(label[k], sizeof label[k], "|L| = %.1f |d|", d[k].distance);
        curve[curves++].label = label[k];
    }
    double peak = 1;
    if (status == SP_OK && n > first)
        peak = sp_paper_signals_peak(&s[first]);
    for (int k = first; k < n; k++)
        if (s[k].t)
            sp_paper_signals_over(&s[k], peak);
    const sp_panel panel = {.x = {PAPER_TIME_AXIS, false, 0, NAN},
                            .y = {"mean |F|_{sig} / peak of the lowest box", false, NAN, NAN},
                            .curves = curves,
                            .curve = curve,
                            .zero_line = true};
    const sp_sheet sheet = {.title = "Coherent parts", .rows = 1, .columns = 1, .panel = &panel};
    if (status == SP_OK && curves > 0)
        status = sp_paper_draw(p, item, "fig5", &sheet,
                               "Mean signals of boxes 24 wide and L high at p = 1e-4, until shortly after their zero "
                               "crossings, over the first peak of the lowest box.",
                               err);
    if (status == SP_OK && n > first + 1)
        sp_paper_say(
            p, item,
            "From L = %.3g to %.3g the first peak falls by a factor %.3g and its width (t_zero - t10) grows by %.3g.",
            d[first].distance, d[n - 1].distance, d[first].amplitude.mean / d[n - 1].amplitude.mean,
            d[n - 1].width.mean / d[first].width.mean);
    for (int k = 0; k < PAPER_DISTANCES; k++)
        sp_paper_signals_free(&s[k]);
    return status;
}

/* ---- Fig. 6 ----------------------------------------------------------------------------------------------------- */

enum { MARKS = 3, FITS = 2 }; /* FITS: lines through boxes up to L = 60, and through all */

static const sp_mark shapes[MARKS] = {SP_MARK_TRIANGLE, SP_MARK_CIRCLE, SP_MARK_SQUARE};

typedef struct arrivals {
    int n;
    double distance[PAPER_DISTANCES], time[MARKS][PAPER_DISTANCES], time_err[MARKS][PAPER_DISTANCES];
    paper_line line[FITS]; /* fits of arrival times */
    double line_x[FITS][2], line_y[FITS][2];
} arrivals;

static void arrivals_fill(int n, const paper_distance *d, arrivals *out) {
    out->n = n;
    for (int k = 0; k < n; k++) {
        const paper_mean *const mean[MARKS] = {&d[k].t10, &d[k].t_peak, &d[k].t_zero};
        out->distance[k] = d[k].distance;
        for (int m = 0; m < MARKS; m++) {
            out->time[m][k] = mean[m]->mean;
            out->time_err[m][k] = mean[m]->err;
        }
    }
    for (int fit = 0; fit < FITS; fit++) {
        const paper_range r = sp_paper_fitted(n, d, fit == 1);
        out->line[fit] = sp_paper_line_fit(r.end - r.first, out->distance + r.first, out->time[0] + r.first,
                                           out->time_err[0] + r.first);
        out->line_x[fit][0] = 0;
        out->line_x[fit][1] = r.end > 0 ? 1.05 * out->distance[r.end - 1] : 1;
        for (int k = 0; k < 2; k++)
            out->line_y[fit][k] = out->line[fit].intercept + out->line[fit].slope * out->line_x[fit][k];
    }
}

static sp_status add_slope(paper *p, int item, const arrivals *a, int fit, sp_error *err) {
    const paper_line *line = &a->line[fit];
    const double value[2] = {0.25, 0.005}, ours[2] = {1 / line->slope, line->err / (line->slope * line->slope)};
    return sp_paper_add_stated(p, item, 1e-4, PAPER_SCATTER_STATED, value, ours, err, "c_tof, slope of t10 over %s",
                               fit == 0 ? "L 8 to 50" : "L 8 to 100");
}

static void say_steps(paper *p, int item, const arrivals *a) {
    for (int k = 0; k + 1 < a->n; k++) {
        const double rise = a->distance[k + 1] - a->distance[k], time = a->time[0][k + 1] - a->time[0][k];
        sp_paper_say(p, item, "Between L = %.3g and %.3g the arrival moves with %.3f +- %.3f.", a->distance[k],
                     a->distance[k + 1], rise / time,
                     rise / (time * time) * hypot(a->time_err[0][k], a->time_err[0][k + 1]));
    }
    sp_paper_say(
        p, item,
        "The paper does not say how tall its tallest boxes were; the speed falls with the distance, so that the slope "
        "depends on that.");
}

/* Curves of the inset: the signal of the packing of Fig. 1 and its three marks. */
static void inset_curves(const paper_signals *s, const sp_front *front, double mark[MARKS][2],
                         sp_curve out[1 + MARKS]) {
    const double time[MARKS] = {front->t10, front->t_peak, front->t_zero},
                 force[MARKS] = {0.1 * front->amplitude, front->amplitude, 0};
    out[0] = (sp_curve){.n = s->points, .x = s->t, .y = s->single, .width = 0.7};
    for (int m = 0; m < MARKS; m++) {
        mark[m][0] = time[m];
        mark[m][1] = force[m];
        out[1 + m] = (sp_curve){.n = 1,
                                .x = &mark[m][0],
                                .y = &mark[m][1],
                                .ink = m + 1,
                                .dash = SP_DASH_NONE,
                                .mark = shapes[m],
                                .open = true};
    }
}

static sp_status draw_arrivals(paper *p, int item, const arrivals *a, sp_error *err) {
    static const char *const labels[MARKS] = {"arrival (10% of the peak)", "peak", "zero crossing"};
    sp_curve curve[MARKS + FITS], small[MARKS + 1];
    double mark[MARKS][2];
    char label[FITS][64];
    paper_signals s = {0};
    sp_front front;
    const sp_front_options rule = sp_front_options_default();
    for (int m = 0; m < MARKS; m++)
        curve[m] = (sp_curve){.label = labels[m],
                              .n = a->n,
                              .x = a->distance,
                              .y = a->time[m],
                              .error = a->time_err[m],
                              .ink = m + 1,
                              .dash = SP_DASH_NONE,
                              .mark = shapes[m],
                              .open = true};
    int curves = MARKS;
    for (int fit = 0; fit < FITS; fit++) {
        snprintf(label[fit], sizeof label[fit], "slope 1/%.3f, |L| to %s", 1 / a->line[fit].slope,
                 fit == 0 ? "50" : "100");
        if (isfinite(a->line[fit].slope))
            curve[curves++] = (sp_curve){.label = label[fit],
                                         .n = 2,
                                         .x = a->line_x[fit],
                                         .y = a->line_y[fit],
                                         .dash = fit == 0 ? SP_DASH_SOLID : SP_DASH_DASHED,
                                         .width = 0.7};
    }
    sp_status status = sp_paper_signals_make(p, PAPER_SQUARE, 0, 180, 721, &s, err);
    if (status != SP_OK)
        return status;
    sp_panel inset = {.x = {"|t|  [|d| (|ρ|/|E|*)^{1/2}]", false, 0, 180},
                      .y = {"|F|_{sig} / peak", false, NAN, NAN},
                      .curve = small,
                      .zero_line = true};
    if (sp_front_find(s.points, s.t, s.single, &rule, &front, NULL) == SP_OK) {
        for (int32_t k = 0; k < s.points; k++)
            s.single[k] /= front.amplitude;
        front.amplitude = 1;
        inset_curves(&s, &front, mark, small);
        inset.curves = MARKS + 1;
    }
    const sp_panel panel = {.x = {"distance |L| [|d|]", false, 0, NAN},
                            .y = {PAPER_TIME_AXIS, false, NAN, NAN},
                            .curves = curves,
                            .curve = curve,
                            .inset = inset.curves > 0 ? &inset : NULL};
    const sp_sheet sheet = {.title = "Arrival times", .rows = 1, .columns = 1, .panel = &panel, .aspect = 0.9};
    status =
        sp_paper_draw(p, item, "fig6", &sheet,
                      "Times of arrival, peak and zero crossing against the distance, means of boxes 24 wide at p = "
                      "1e-4; inset: the three marks on the signal of the packing of Fig. 1.",
                      err);
    sp_paper_signals_free(&s);
    return status;
}

sp_status sp_paper_make_fig6(paper *p, int item, sp_error *err) {
    paper_distance d[PAPER_DISTANCES];
    arrivals a;
    int n = 0;
    sp_status status = sp_paper_heights(p, &n, d, err);
    if (status != SP_OK)
        return status;
    arrivals_fill(n, d, &a);
    for (int fit = 0; fit < FITS && status == SP_OK; fit++)
        status = add_slope(p, item, &a, fit, err);
    say_steps(p, item, &a);
    return status == SP_OK && p->opt->folder ? draw_arrivals(p, item, &a, err) : status;
}
