/* Averages the signals of an ensemble. */
#include "paper/signals.h"

#include "base/base.h"

#include <math.h>
#include <string.h>

typedef struct sums {
    paper_signals *s;
    sp_signals all;
    double until;
} sums;

static sp_status add_signal(const sp_sample *sample, const sp_packing *packing, const sp_network *net, void *user,
                            sp_error *err) {
    (void)packing;
    sums *sum = user;
    paper_signals *s = sum->s;
    sp_signal_options options = sp_signal_options_default();
    options.method = SP_SIGNAL_CHEBYSHEV;
    options.until = sum->until;
    options.points = s->points;
    sp_signal signal = sp_signal_none();
    sp_status status = sp_signal_make(net, &options, &signal, err);
    if (status == SP_OK)
        status = sp_signals_add(&sum->all, signal.n, signal.t, signal.f, err);
    if (status == SP_OK) {
        if (s->n < PAPER_SINGLES)
            memcpy(s->single + s->n * s->points, signal.f, (size_t)s->points * sizeof *s->single);
        s->height += sample->height;
        s->n++;
    }
    sp_signal_free(&signal);
    return status;
}

sp_status sp_paper_signals_make(paper *p, paper_ensemble e, int32_t grains, double until, int32_t points,
                                paper_signals *out, sp_error *err) {
    const size_t n = (size_t)points;
    paper_signals s = {.points = points, .t = sp_alloc((3 + PAPER_SINGLES) * n, sizeof *s.t)};
    if (!s.t)
        return sp_fail_memory(err, (3 + PAPER_SINGLES) * n * sizeof *s.t);
    s.mean = s.t + n;
    s.rms = s.t + 2 * n;
    s.single = s.t + 3 * n;
    for (size_t k = 0; k < PAPER_SINGLES * n; k++)
        s.single[k] = NAN;
    sums sum = {.s = &s, .all = sp_signals_none(), .until = until};
    sp_status status = sp_paper_walk(p, e, 1e-4, grains, 0, add_signal, &sum, err);
    for (size_t k = 0; k < n && status == SP_OK; k++) {
        s.t[k] = sum.all.t[k];
        s.mean[k] = sum.all.mean[k];
        s.rms[k] = sp_signals_rms(&sum.all, (int32_t)k);
    }
    sp_signals_free(&sum.all);
    if (status != SP_OK) {
        sp_paper_signals_free(&s);
        return status;
    }
    s.height /= (double)s.n;
    *out = s;
    return SP_OK;
}

void sp_paper_signals_free(paper_signals *s) {
    sp_free(s->t);
    *s = (paper_signals){0};
}

void sp_paper_signals_over(paper_signals *s, double by) {
    for (int32_t k = 0; k < s->points; k++) {
        s->mean[k] /= by;
        s->rms[k] /= by;
        for (int one = 0; one < PAPER_SINGLES; one++)
            s->single[(size_t)one * (size_t)s->points + (size_t)k] /= by;
    }
}

double sp_paper_signals_peak(const paper_signals *s) {
    sp_front front;
    const sp_front_options rule = sp_front_options_default();
    if (sp_front_find(s->points, s->t, s->mean, &rule, &front, NULL) == SP_OK)
        return front.amplitude;
    double largest = 0;
    for (int32_t k = 0; k < s->points; k++)
        largest = fmax(largest, s->mean[k]);
    return largest > 0 ? largest : 1;
}

sp_status sp_paper_damped_signal(const sp_network *net, double damping, double until, int32_t points, sp_signal *out,
                                 sp_error *err) {
    sp_signal_options options = sp_signal_options_default();
    options.until = until;
    options.points = points;
    options.damping = damping;
    options.tolerance = 1e-6;
    return sp_signal_make(net, &options, out, err);
}

double sp_paper_rms_after(const sp_signal *s, double time) {
    double sum = 0, n = 0;
    for (int32_t k = 0; k < s->n; k++)
        if (s->t[k] > time) {
            sum += s->f[k] * s->f[k];
            n++;
        }
    return sqrt(sum / n);
}
