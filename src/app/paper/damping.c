/* Makes Fig. 11: damped signals. */
#include "paper/signals.h"

#include <math.h>
#include <stdio.h>

enum { LEVELS = 4, CURVES = 2, POINTS = 601 };
static const double zeta[LEVELS] = {0, 0.02, 0.1, 0.5};
static const double until = 300;

typedef struct damped {
    paper *p;
    int item;
    sp_signal linear[LEVELS], full[LEVELS]; /* full: nonlinear dynamics of the packing */
} damped;

static sp_status make_signals(const sp_sample *s, const sp_packing *packing, const sp_network *net, void *user,
                              sp_error *err) {
    (void)s;
    damped *d = user;
    sp_status status = SP_OK;
    for (int k = 0; k < LEVELS && status == SP_OK; k++) {
        sp_signal_options options = sp_signal_options_default();
        options.until = until;
        options.points = POINTS;
        options.damping = zeta[k];
        options.method = SP_SIGNAL_DYNAMICS;
        options.tolerance = 1e-2;
        options.amplitude = 1e-4;
        status = sp_paper_damped_signal(net, zeta[k], until, POINTS, &d->linear[k], err);
        if (status == SP_OK)
            status = sp_signal_compute(packing, net, &options, &d->full[k], err);
        if (status == SP_OK)
            status = sp_paper_tell(d->p, "fig11", 0.95, err);
    }
    return status;
}

static sp_status draw(damped *d, sp_error *err) {
    static const char *const tags[LEVELS] = {"(a)", "(b)", "(c)", "(d)"};
    sp_curve curve[LEVELS][CURVES];
    sp_panel panel[LEVELS];
    char label[LEVELS][40];
    for (int k = 0; k < LEVELS; k++) {
        snprintf(label[k], sizeof label[k], "linear, |ζ| = %g", zeta[k]);
        curve[k][0] =
            (sp_curve){.label = label[k], .n = POINTS, .x = d->linear[k].t, .y = d->linear[k].f, .width = 0.9};
        curve[k][1] = (sp_curve){.label = "nonlinear",
                                 .n = POINTS,
                                 .x = d->full[k].t,
                                 .y = d->full[k].f,
                                 .ink = 1,
                                 .dash = SP_DASH_DASHED,
                                 .width = 0.9};
        panel[k] = (sp_panel){.tag = tags[k],
                              .x = {PAPER_TIME_AXIS, false, 0, until},
                              .y = {"|F|_{sig} / first peak", false, NAN, NAN},
                              .curves = CURVES,
                              .curve = curve[k],
                              .zero_line = true};
    }
    const sp_sheet sheet = {.title = "Damped signals", .rows = LEVELS, .columns = 1, .panel = panel, .aspect = 0.42};
    return sp_paper_draw(
        d->p, d->item, "fig11", &sheet,
        "Signal of the packing of Fig. 1 with contacts damped by a fraction zeta of critical, over the "
        "first peak without damping: the linear network, and the packing's own nonlinear motion after a pulse of "
        "1e-4 of the mean overlap.",
        err);
}

static double first_peak(const sp_signal *s) {
    sp_front front;
    const sp_front_options rule = sp_front_options_default();
    return sp_front_find(s->n, s->t, s->f, &rule, &front, NULL) == SP_OK ? front.amplitude : NAN;
}

static void say_damping(damped *d, double zero) {
    const double peak0 = first_peak(&d->linear[0]), rest0 = sp_paper_rms_after(&d->linear[0], zero);
    for (int k = 1; k < LEVELS; k++) {
        const double peak = first_peak(&d->linear[k]), rest = sp_paper_rms_after(&d->linear[k], zero);
        double apart = 0;
        for (int32_t i = 0; i < POINTS; i++)
            apart = fmax(apart, fabs(d->linear[k].f[i] - d->full[k].f[i]));
        sp_paper_say(
            d->p, d->item,
            "zeta = %g: the first peak keeps %.0f%% of its height, what follows %.0f%% of its root mean square; "
            "linear and nonlinear motion differ by %.1f%% of the first peak without damping at the most.",
            zeta[k], 100 * peak / peak0, 100 * rest / rest0, 100 * apart);
    }
}

sp_status sp_paper_make_fig11(paper *p, int item, sp_error *err) {
    damped d = {.p = p, .item = item};
    for (int k = 0; k < LEVELS; k++)
        d.linear[k] = d.full[k] = sp_signal_none();
    sp_front front;
    const sp_front_options rule = sp_front_options_default();
    sp_status status = sp_paper_walk(p, PAPER_SQUARE, 1e-4, 0, 1, make_signals, &d, err);
    if (status == SP_OK)
        status = sp_front_find(POINTS, d.linear[0].t, d.linear[0].f, &rule, &front, err);
    for (int k = 0; k < LEVELS && status == SP_OK; k++)
        for (int32_t i = 0; i < POINTS; i++) {
            d.linear[k].f[i] /= front.amplitude;
            d.full[k].f[i] /= front.amplitude;
        }
    if (status == SP_OK)
        status = draw(&d, err);
    if (status == SP_OK)
        say_damping(&d, front.t_zero);
    for (int k = 0; k < LEVELS; k++) {
        sp_signal_free(&d.linear[k]);
        sp_signal_free(&d.full[k]);
    }
    return status;
}
