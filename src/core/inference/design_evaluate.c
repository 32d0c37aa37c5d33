/* What a design makes as large as possible, and its gradient. */
#include "inference/design.h"

#include "base/base.h"
#include "inference/quantities.h"

#include <math.h>

static unsigned parameters_of(sp_design_variable vary) {
    static const unsigned each[] = {[SP_DESIGN_MASS] = SP_BY_MASS,
                                    [SP_DESIGN_MODULUS] = SP_BY_KN | SP_BY_KT,
                                    [SP_DESIGN_RADIUS] = SP_BY_KN | SP_BY_KT | SP_BY_RADIUS | SP_BY_POSITION};
    return each[vary];
}

static sp_sensitivity_options options_of(const sp_design_problem *d, const sp_packing *made, const sp_network *net) {
    sp_sensitivity_options o = sp_sensitivity_options_default();
    o.parameters = parameters_of(d->opt->vary);
    o.source = d->opt->source;
    o.until = sp_signal_window(net->box[net->dim - 1], net->pressure);
    o.points = (int32_t)fmax(ceil(o.until / sp_inference_spacing(net->pressure)) + 1, 3);
    o.threads = d->opt->threads;
    o.packing = made;
    return o;
}

/* ---- t_10 ------------------------------------------------------------------------------------------------------- */

/* The first peak must be the first one by a third less and half as much again of its usual prominence, too: else a
 * design would win by a precursor that just passes for a front. */
static sp_status check_distinct(const sp_design_problem *d, const sp_network *net, double window, sp_error *err) {
    const double factor[2] = {1 / 1.5, 1.5};
    sp_signal s = sp_signal_none();
    sp_front found[2];
    sp_status status = sp_inference_signal(net, d->opt->source, window, &s, err);
    for (int k = 0; k < 2 && status == SP_OK; k++) {
        sp_front_options rule = sp_front_options_default();
        rule.prominence *= factor[k];
        status = sp_front_find(s.n, s.t, s.f, &rule, &found[k], err);
    }
    sp_signal_free(&s);
    if (status == SP_OK && found[0].t_peak != found[1].t_peak)
        return sp_fail(err, SP_EREFUSED,
                       "the first peak is not distinct: one at t = %.6g has between %.2g and %.2g of "
                       "the largest force",
                       found[0].t_peak, 0.2 / 1.5, 0.2 * 1.5);
    return status;
}

static sp_status front_value(const sp_design_problem *d, const sp_packing *made, const sp_network *net, bool slopes,
                             sp_gradient *g, sp_design_value *out, sp_error *err) {
    const sp_sensitivity_options o = options_of(d, made, net);
    sp_front_gradient found;
    sp_status status = check_distinct(d, net, o.until, err);
    if (status == SP_OK)
        status = sp_sensitivity_front(net, &o, SP_FRONT_T10, &found, err);
    if (status != SP_OK)
        return status;
    out->value = found.found.t10;
    out->error = found.t10_error;
    out->objective = (d->opt->goal == SP_DESIGN_DELAY ? 1 : -1) * log(out->value);
    if (slopes) {
        *g = found.t10;
        found.t10 = sp_gradient_none();
    }
    sp_front_gradient_free(&found);
    return SP_OK;
}

/* ---- the energy in a band --------------------------------------------------------------------------------------- */

static sp_status band_gradient(const sp_design_problem *d, const sp_packing *made, const sp_network *net,
                               const sp_signal *s, const double *weight, sp_gradient *g, sp_error *err) {
    const sp_sensitivity_options o = options_of(d, made, net);
    const sp_functional one = {.n = s->n, .t = s->t, .weight = weight};
    return sp_sensitivity_signal(net, &o, 1, &one, g, err);
}

/* No frequency of the network is above its bound: what a record has there comes from its end and from rounding. */
static sp_status check_band(const sp_design_options *o, const sp_network *net, sp_error *err) {
    const double most = sp_network_omega_bound(net);
    return o->band_low < most
               ? SP_OK
               : sp_fail(err, SP_EREFUSED, "nothing passes from %g to %g: all frequencies are below %.4g", o->band_low,
                         o->band_high, most);
}

static sp_status band_value(const sp_design_problem *d, const sp_packing *made, const sp_network *net, bool slopes,
                            sp_gradient *g, sp_design_value *out, sp_error *err) {
    const sp_design_options *o = d->opt;
    const double window = o->until > 0 ? o->until : sp_signal_window(net->box[net->dim - 1], net->pressure);
    sp_signal s = sp_signal_none();
    double *work = NULL, off = 0;
    sp_status status = check_band(o, net, err);
    if (status == SP_OK)
        status = sp_inference_signal(net, o->source, window, &s, err);
    if (status == SP_OK)
        work = sp_alloc(2 * (size_t)s.n, sizeof *work);
    if (status == SP_OK && !work)
        status = sp_fail_memory(err, 2 * (size_t)s.n * sizeof *work);
    if (status == SP_OK) {
        double *weight = work + s.n;
        const double spacing = s.t[1] - s.t[0], high = fmin(o->band_high, M_PI / spacing); /* points know no more */
        const double energy = sp_design_band(s.n, spacing, s.f, o->band_low, high, work, weight);
        for (int32_t l = 0; l < s.n; l++)
            off += fabs(weight[l]);
        out->value = energy / d->scale;
        out->error = off * s.error / d->scale;
        out->objective = -log(out->value);
        if (!(out->value > out->error))
            status =
                sp_fail(err, SP_EREFUSED, "the energy from %g to %g is not above its error in a signal up to t = %g",
                        o->band_low, o->band_high, window);
        if (status == SP_OK && slopes)
            status = band_gradient(d, made, net, &s, weight, g, err);
    }
    sp_free(work);
    sp_signal_free(&s);
    return status;
}

/* ---- the gradient by factors ------------------------------------------------------------------------------------ */

/* k_n ~ E12^(2/3), and 1/E12 is the sum of both grains' 1/E. */
static void by_modulus(const sp_network *net, const double *factor, const sp_gradient *g, double *gradient) {
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        const double slope = s->kn * g->kn.d[k] + (g->kt.n > 0 ? s->kt * g->kt.d[k] : 0);
        const int32_t i = net->grain[s->i], j = s->j >= 0 ? net->grain[s->j] : -1;
        if (j < 0) {
            gradient[i] += 2.0 / 3 * slope / factor[i];
            continue;
        }
        const double sum = factor[i] + factor[j];
        gradient[i] += 2.0 / 3 * slope * factor[j] / sum / factor[i];
        gradient[j] += 2.0 / 3 * slope * factor[i] / sum / factor[j];
    }
}

static sp_status by_radius(const sp_design_problem *d, const sp_packing *made, const sp_network *net,
                           const sp_gradient *g, double *gradient, sp_error *err) {
    double *radius = sp_alloc((size_t)net->n, sizeof *radius);
    if (!radius)
        return sp_fail_memory(err, (size_t)net->n * sizeof *radius);
    for (int32_t i = 0; i < net->n; i++)
        radius[i] = g->radius.d[i];
    sp_status status = sp_design_respond(made, net, g, radius, err);
    for (int32_t i = 0; i < net->n; i++)
        gradient[net->grain[i]] = radius[i] * d->p->r[net->grain[i]];
    sp_free(radius);
    return status;
}

/* d(objective)/d(factor) from dQ/d(parameters). */
static sp_status by_factors(const sp_design_problem *d, const double *factor, const sp_packing *made,
                            const sp_network *net, const sp_gradient *g, double scale, double *gradient,
                            sp_error *err) {
    sp_status status = SP_OK;
    for (int32_t i = 0; i < d->p->n; i++)
        gradient[i] = 0;
    if (d->opt->vary == SP_DESIGN_MODULUS)
        by_modulus(net, factor, g, gradient);
    else if (d->opt->vary == SP_DESIGN_RADIUS)
        status = by_radius(d, made, net, g, gradient, err);
    else
        for (int32_t i = 0; i < net->n; i++)
            gradient[net->grain[i]] = g->mass.d[i] * net->mass[(size_t)i * (size_t)net->dof] / factor[net->grain[i]];
    for (int32_t i = 0; i < d->p->n; i++)
        gradient[i] *= d->weight[i] > 0 ? scale : 0;
    return status;
}

sp_status sp_design_evaluate(const sp_design_problem *d, const double *factor, double *gradient, sp_design_value *out,
                             sp_packing *made, sp_error *err) {
    const bool band = d->opt->goal == SP_DESIGN_BAND;
    sp_packing q = sp_packing_none();
    sp_network net = sp_network_none();
    sp_gradient g = sp_gradient_none();
    sp_design_value value;
    sp_status status = sp_design_apply(d, factor, &q, err);
    if (status == SP_OK)
        status = sp_network_make(&q, &d->opt->network, &net, err);
    if (status == SP_OK)
        status = (band ? band_value : front_value)(d, &q, &net, gradient != NULL, &g, &value, err);
    if (status == SP_OK && gradient) {
        const double sign = d->opt->goal == SP_DESIGN_DELAY ? 1 : -1, times = band ? d->scale : 1;
        status = by_factors(d, factor, &q, &net, &g, sign / (value.value * times), gradient, err);
    }
    if (status == SP_OK)
        *out = value;
    if (status == SP_OK && made)
        *made = q;
    else
        sp_packing_free(&q);
    sp_gradient_free(&g);
    sp_network_free(&net);
    return status;
}
