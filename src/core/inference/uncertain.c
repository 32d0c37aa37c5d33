/* Errors of the sound of a measured packing. */
#include "inference/uncertain.h"

#include "base/base.h"

#include <math.h>

enum { SAMPLES_LEAST = 10, SAMPLES_MOST = 10000000, MODES_MOST = 10000 };

sp_uncertainty_options sp_uncertainty_options_default(void) {
    return (sp_uncertainty_options){.errors = sp_errors_default(),
                                    .network = sp_network_options_default(),
                                    .margin = 3,
                                    .moduli = true,
                                    .first_order = true,
                                    .samples = 200,
                                    .seed = 1,
                                    .threads = 1};
}

sp_uncertainty sp_uncertainty_none(void) { return (sp_uncertainty){0}; }

void sp_uncertainty_free(sp_uncertainty *u) {
    sp_free(u->quantity);
    *u = sp_uncertainty_none();
}

static bool has_errors(const sp_errors *e) {
    return e->position > 0 || e->radius > 0 || e->force > 0 || e->stiffness > 0 || e->calibration > 0 ||
           e->false_part > 0 || e->missing > 0;
}

static sp_status check_options(const sp_uncertainty_options *o, sp_error *err) {
    if (o->samples != 0 && !(o->samples >= SAMPLES_LEAST && o->samples <= SAMPLES_MOST))
        return sp_fail_key(err, SP_EINVAL, "samples", " = %d: must be 0, or %d .. %d", o->samples, SAMPLES_LEAST,
                           SAMPLES_MOST);
    if (!(o->modes >= 0 && o->modes <= MODES_MOST))
        return sp_fail_key(err, SP_EINVAL, "modes", " = %d: must be 0 .. %d", o->modes, MODES_MOST);
    if (!(o->margin >= 0 && isfinite(o->margin)))
        return sp_fail_key(err, SP_EINVAL, "margin", " = %g: must be 0 or more", o->margin);
    if (o->samples == 0 && !o->first_order)
        return sp_fail_key(err, SP_EINVAL, "samples", " = 0: without first order there must be samples");
    const sp_status status = sp_errors_check(&o->errors, err);
    if (status == SP_OK && !has_errors(&o->errors))
        return sp_fail(err, SP_EINVAL, "no error of the packing is given: position, radius, force, ... are all 0");
    return status;
}

static double mean_overlap(const sp_packing *p, const sp_network *net) {
    double sum = 0;
    for (int32_t k = 0; k < net->n_springs; k++)
        sum += p->contacts[net->springs[k].contact].overlap;
    return sum / net->n_springs;
}

/* All that is not known yet is NAN. */
static sp_status name_quantities(const sp_quantities *q, const double *value, sp_uncertainty *out, sp_error *err) {
    out->quantity = sp_alloc((size_t)q->n, sizeof *out->quantity);
    if (!out->quantity)
        return sp_fail_memory(err, (size_t)q->n * sizeof *out->quantity);
    out->n = q->n;
    for (int32_t k = 0; k < q->n; k++) {
        sp_uncertain *v = &out->quantity[k];
        sp_quantity_name(q, k, v->name, v->unit);
        v->value = value[k];
        v->first_order = v->shift = v->sd = v->sd_error = v->bias = v->bias_error = NAN;
        for (int e = 0; e < SP_ERROR_KINDS; e++)
            v->share[e] = NAN;
    }
    out->contacts = out->contacts_error = NAN;
    return SP_OK;
}

/* The packing without errors: its sound, and the two ways. */
static sp_status estimate(const sp_drawing *d, const sp_packing *p, const sp_uncertainty_options *opt,
                          sp_uncertainty *out, sp_error *err) {
    sp_network net = sp_network_none();
    double *value = NULL;
    int32_t contacts;
    sp_status status = sp_network_make(p, &opt->network, &net, err);
    if (status != SP_OK)
        return status;
    const sp_quantities q = sp_quantities_of(&net, opt);
    out->overlap = mean_overlap(p, &net);
    out->candidates = d->candidates;
    sp_network_free(&net);
    if (q.n == 0)
        return sp_fail(err, SP_EREFUSED,
                       "no quantity is asked for: without contacts at both walls there is no front; ask for moduli or "
                       "frequencies");
    value = sp_alloc((size_t)q.n, sizeof *value);
    status =
        value ? sp_quantities_measure(&q, p, value, &contacts, err) : sp_fail_memory(err, (size_t)q.n * sizeof *value);
    if (status == SP_OK)
        status = name_quantities(&q, value, out, err);
    if (status == SP_OK && opt->first_order)
        status = sp_uncertain_first_order(&q, d, p, out, err);
    if (status == SP_OK && opt->samples > 0)
        status = sp_uncertain_sample(&q, d, contacts, out, err);
    sp_free(value);
    return status;
}

sp_status sp_uncertainty_make(const sp_packing *p, const sp_uncertainty_options *opt, sp_uncertainty *out,
                              sp_error *err) {
    sp_uncertainty made = sp_uncertainty_none();
    sp_packing exact = sp_packing_none();
    sp_drawing d;
    sp_status status = check_options(opt, err);
    if (status == SP_OK)
        status = sp_drawing_make(p, &opt->errors, &d, err);
    if (status != SP_OK)
        return status;
    status = sp_drawing_draw(&d, opt->seed, -1, &exact, err);
    if (status == SP_OK)
        status = estimate(&d, &exact, opt, &made, err);
    if (status == SP_OK)
        *out = made;
    else
        sp_uncertainty_free(&made);
    sp_packing_free(&exact);
    sp_drawing_free(&d);
    return status;
}
