/* Errors of the sound of a measured packing: the packing without errors, and packings drawn with errors (Monte Carlo).
 */
#include "inference/uncertain.h"
#include "base/base.h"
#include "base/pool.h"

#include <math.h>
#include <string.h>

/* ---- Monte Carlo ------------------------------------------------------------------------------------------------- */

typedef struct sampling {
    const sp_quantities *q;
    const sp_drawing *d;
    double *value;    /* [samples][n]; NAN where there is none */
    double *contacts; /* [samples] */
    sp_error *reason; /* [samples] status SP_OK, or why a sample has no values */
} sampling;

static void draw_one(const sampling *s, int32_t k) {
    const sp_uncertainty_options *o = s->q->opt;
    double *value = s->value + (size_t)k * (size_t)s->q->n;
    sp_packing p = sp_packing_none();
    int32_t contacts = 0;
    for (int32_t v = 0; v < s->q->n; v++)
        value[v] = NAN;
    sp_status status = sp_drawing_draw(s->d, o->seed, k, &p, &s->reason[k]);
    if (status == SP_OK)
        status = sp_quantities_measure(s->q, &p, value, &contacts, &s->reason[k]);
    for (int32_t v = 0; v < s->q->n && status != SP_OK; v++)
        value[v] = NAN; /* of a sample that fails in one part none counts: all quantities have the same samples */
    s->reason[k].status = status;
    s->contacts[k] = contacts;
    sp_packing_free(&p);
}

static void draw_part(void *data, int part, int parts) {
    const sampling *s = data;
    for (int32_t k = part; k < s->q->opt->samples; k += parts)
        draw_one(s, k);
}

/* Mean, standard deviation and the fourth moment of deviations, of the finite ones. */
typedef struct moments {
    int32_t n;
    double mean, variance, fourth;
} moments;

static moments moments_of(int32_t n, const double *value, size_t stride) {
    moments m = {0};
    for (int32_t k = 0; k < n; k++)
        if (isfinite(value[(size_t)k * stride])) {
            m.mean += value[(size_t)k * stride];
            m.n++;
        }
    m.mean = m.n > 0 ? m.mean / m.n : NAN;
    for (int32_t k = 0; k < n; k++) {
        const double off = value[(size_t)k * stride] - m.mean;
        if (isfinite(off)) {
            m.variance += off * off;
            m.fourth += off * off * off * off;
        }
    }
    m.variance = m.n > 1 ? m.variance / (m.n - 1) : NAN;
    m.fourth = m.n > 1 ? m.fourth / m.n : NAN;
    return m;
}

/* The error of a standard deviation s of n samples, from the fourth moment m: var(s^2) = (m - s^4 (n - 3)/(n - 1))/n,
 * which matters where most samples have no sound and few are left. */
static double error_of_sd(const moments *m) {
    if (m->n < 2)
        return NAN;
    const double few = (m->n - 3.0) / (m->n - 1);
    const double spread = fmax(m->fourth - few * m->variance * m->variance, 0);
    return m->variance > 0 ? 0.5 * sqrt(spread / m->n / m->variance) : 0;
}

/* What rounding and the tolerances of solvers may do to a quantity: to moduli, by the largest of them. */
static double rounding_of(const sp_uncertainty *u, const sp_uncertain *v) {
    double scale = fabs(v->value);
    for (int32_t k = 0; k < u->n && v->name[0] == 'C'; k++)
        if (u->quantity[k].name[0] == 'C')
            scale = fmax(scale, fabs(u->quantity[k].value));
    return 1e-9 * scale;
}

static void judge(const sp_uncertainty *u, sp_uncertain *v) {
    const double off = fabs(v->sd - v->first_order), shift = fabs(v->bias - v->shift), rounding = rounding_of(u, v);
    if (!isfinite(v->first_order) || !isfinite(v->sd))
        return;
    const bool spread = off > 3 * v->sd_error && off > fmax(0.05 * v->first_order, rounding);
    const bool moved = shift > 3 * v->bias_error && shift > fmax(0.5 * v->first_order, rounding);
    v->linear = spread || moved || 100 * u->loose > u->samples ? SP_LINEAR_NO : SP_LINEAR_YES;
}

static void summarise(const sampling *s, int32_t contacts, sp_uncertainty *out) {
    const int32_t samples = s->q->opt->samples;
    for (int32_t k = samples - 1; k >= 0; k--)
        if (s->reason[k].status != SP_OK) {
            out->loose++;
            memcpy(out->why, s->reason[k].text, sizeof out->why);
        }
    out->samples = samples;
    for (int32_t v = 0; v < s->q->n; v++) {
        sp_uncertain *one = &out->quantity[v];
        const moments m = moments_of(samples, s->value + v, (size_t)s->q->n);
        one->samples = m.n;
        one->sd = sqrt(m.variance);
        one->sd_error = error_of_sd(&m);
        one->bias = m.mean - one->value;
        one->bias_error = one->sd / sqrt(m.n);
        judge(out, one);
    }
    const moments m = moments_of(samples, s->contacts, 1);
    out->contacts = m.mean / contacts;
    out->contacts_error = sqrt(m.variance / m.n) / contacts;
}

/* A sample without sound is a result; without memory there is none. */
static sp_status check_memory(const sampling *s, sp_error *err) {
    for (int32_t k = 0; k < s->q->opt->samples; k++)
        if (s->reason[k].status == SP_ENOMEM)
            return sp_fail(err, SP_ENOMEM, "%s", s->reason[k].text);
    return SP_OK;
}

/* Monte Carlo: fills in sd, bias, their errors and samples, and the counts of out. contacts: of p. */
static sp_status sample_packings(const sp_quantities *q, const sp_drawing *d, int32_t contacts, sp_uncertainty *out,
                                 sp_error *err) {
    const size_t samples = (size_t)q->opt->samples, n = (size_t)q->n;
    sampling s = {.q = q, .d = d};
    sp_pool *pool = NULL;
    sp_status status = SP_OK;
    s.value = sp_alloc(samples * n, sizeof *s.value);
    s.contacts = sp_alloc(samples, sizeof *s.contacts);
    s.reason = sp_alloc(samples, sizeof *s.reason);
    if (!s.value || !s.contacts || !s.reason)
        status = sp_fail_memory(err, samples * (n * sizeof *s.value + sizeof *s.reason));
    if (status == SP_OK)
        status = sp_pool_make(q->opt->threads > 1 ? q->opt->threads : 1, &pool, err);
    if (status == SP_OK) {
        sp_pool_run(pool, draw_part, &s);
        status = check_memory(&s, err);
    }
    if (status == SP_OK)
        summarise(&s, contacts, out);
    sp_pool_free(pool);
    sp_free(s.reason);
    sp_free(s.contacts);
    sp_free(s.value);
    return status;
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

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
    sp_free(u->grain);
    sp_free(u->pair);
    sp_free(u->by_grain);
    sp_free(u->by_contact);
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
    if (o->parts && !o->first_order)
        return sp_fail_key(err, SP_EINVAL, "parts", ": must be with first order, which knows them");
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
        status = sample_packings(&q, d, contacts, out, err);
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
