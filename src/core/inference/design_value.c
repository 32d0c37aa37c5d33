/* What a design makes as large as possible, and its gradient. */
#include "base/base.h"
#include "base/vector.h"
#include "elastic/equilibrium.h"
#include "inference/design_problem.h"
#include "inference/uncertain.h"
#include "packing/contact.h"

#include <math.h>
#include <string.h>

/* ---- the packing of changed grains ------------------------------------------------------------------------------- */

static sp_status copy_all(const sp_packing *p, sp_packing *out, sp_error *err) {
    sp_status status = sp_drawing_copy(p, p->n_contacts, out, err);
    if (status != SP_OK)
        return status;
    memcpy(out->contacts, p->contacts, (size_t)p->n_contacts * sizeof *p->contacts);
    out->n_contacts = p->n_contacts;
    return SP_OK;
}

static sp_status apply_masses(const double *factor, sp_packing *q, sp_error *err) {
    if (!q->mass) {
        sp_status status = sp_packing_alloc_masses(q, err);
        if (status != SP_OK)
            return status;
    }
    for (int32_t i = 0; i < q->n; i++) {
        q->mass[i] *= factor[i];
        q->inertia[i] *= factor[i];
    }
    return SP_OK;
}

/* E12 of two grains over that without factors; a rigid wall adds nothing, and other walls are as their grain. */
static double softness(const double *factor, const sp_contact *c) {
    const double a = factor[c->i];
    return c->j < 0 ? a : 2 * a * factor[c->j] / (a + factor[c->j]);
}

static void apply_moduli(const double *factor, sp_packing *q) {
    for (int32_t k = 0; k < q->n_contacts; k++) {
        sp_contact *c = &q->contacts[k];
        const bool own = c->kn > 0;
        const double kn = contact_kn(q, c), times = pow(softness(factor, c), 2.0 / 3);
        c->kt = times * (own ? c->kt : contact_eta(q->poisson) * kn);
        c->kn = times * kn;
    }
}

/* Compresses the packing of larger and smaller grains again, from the places that they had in the best packing so far:
 * contacts then change as little as they can. */
static sp_status compress(const sp_design_problem *d, const double *factor, sp_packing *out, sp_error *err) {
    const sp_packing *p = d->p;
    sp_packing from;
    sp_pack_spec spec = sp_pack_spec_default();
    sp_status status = copy_all(d->from ? d->from : p, &from, err);
    if (status != SP_OK)
        return status;
    for (int32_t i = 0; i < p->n; i++)
        from.r[i] = p->r[i] * factor[i];
    spec.kind = SP_PACK_FILE;
    spec.pressure = p->pressure;
    spec.friction = p->friction;
    spec.poisson = p->poisson;
    status = sp_pack_spec_from(&spec, &from, err);
    const sp_pack_hooks hooks = {.threads = d->opt->threads, .from = &from};
    if (status == SP_OK)
        status = sp_packing_make_with(&spec, &hooks, out, err);
    sp_packing_free(&from);
    return status;
}

/* The packing of these factors [n]. Free it. */
static sp_status apply_factors(const sp_design_problem *d, const double *factor, sp_packing *out, sp_error *err) {
    if (d->opt->vary == SP_DESIGN_RADIUS)
        return compress(d, factor, out, err);
    sp_packing q;
    sp_status status = copy_all(d->p, &q, err);
    if (status != SP_OK)
        return status;
    if (d->opt->vary == SP_DESIGN_MASS)
        status = apply_masses(factor, &q, err);
    else
        apply_moduli(factor, &q);
    if (status == SP_OK)
        *out = q;
    else
        sp_packing_free(&q);
    return status;
}

/* ---- the energy of a signal between two frequencies -------------------------------------------------------------- */

/* The end of the record fades by the second half of a Hann window over its last third, lest its cut spreads over all
 * frequencies. */
static double fade(int32_t n, int32_t l) {
    const double from = 2.0 / 3 * (n - 1), x = (l - from) / (n - 1 - from);
    return x > 0 ? 0.5 * (1 + cos(M_PI * x)) : 1;
}

/* The integral of |F(omega)|^2 over the band is a double sum of F_l F_m times the kernel sin(w t)/t of the differences
 * of times, at both edges of the band. */
static double lag_kernel(double t, double low, double high) {
    return t == 0 ? high - low : (sin(high * t) - sin(low * t)) / t;
}

double sp_design_band(int32_t n, double spacing, const double *f, double low, double high, double *scratch,
                      double *weight) {
    double energy = 0;
    for (int32_t l = 0; l < n; l++) {
        scratch[l] = fade(n, l) * f[l];
        weight[l] = 0;
    }
    for (int32_t lag = 0; lag < n; lag++) {
        const double scale = spacing * spacing * lag_kernel(lag * spacing, low, high) / M_PI * (lag == 0 ? 1 : 2);
        double sum = 0;
        for (int32_t l = 0; l + lag < n; l++) {
            sum += scratch[l] * scratch[l + lag];
            weight[l] += scale * scratch[l + lag];
            weight[l + lag] += scale * scratch[l];
        }
        energy += scale * sum;
    }
    for (int32_t l = 0; l < n; l++)
        weight[l] *= fade(n, l);
    return energy;
}

/* ---- how a packing at rest follows a change of its radii --------------------------------------------------------- */

/* The top wall carries its load: it follows its contacts, whose stiffnesses add up. */
typedef struct wall {
    double stiffness; /* sum of k_n of its contacts */
    double slope;     /* derivative of Q by its height: its contacts lose overlap, and stiffness with it */
} wall;

static wall top_wall(const sp_packing *p, const sp_network *net, const sp_gradient *g) {
    wall w = {0};
    for (int32_t k = net->n_bulk; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        if (s->j != SP_TOP)
            continue;
        const double by_stiffness = s->kn * g->kn.d[k] + (g->kt.n > 0 ? s->kt * g->kt.d[k] : 0);
        w.stiffness += s->kn;
        w.slope -= by_stiffness / (2 * p->contacts[s->contact].overlap);
    }
    return w;
}

static double along(const sp_network *net, const sp_spring *s, const double *u) {
    double sum = 0;
    for (int a = 0; a < net->dim; a++) {
        const double there = s->j >= 0 ? u[(size_t)s->j * (size_t)net->dof + (size_t)a] : 0;
        sum += s->n[a] * (there - u[(size_t)s->i * (size_t)net->dof + (size_t)a]);
    }
    return sum;
}

/* A larger radius pushes both grains of each contact apart; weight [dofs] is the change of Q for a unit force. */
static void add_pushes(const sp_network *net, const wall *w, double wall_weight, const double *weight,
                       double *by_radius) {
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        double push = s->kn * along(net, s, weight);
        if (s->j == SP_TOP)
            push += wall_weight * s->kn / w->stiffness;
        by_radius[s->i] += push;
        if (s->j >= 0)
            by_radius[s->j] += push;
    }
}

/* The wall's height h = d.u/k + ... turns K into K - d d^T/k, d: the detector. By Sherman and Morrison two solves with
 * K give one with that. weight enters as K^-1 of the right-hand side, z = K^-1 d. */
static void free_wall(int64_t dofs, double stiffness, const double *d, const double *z, double *weight) {
    const double scale = sp_dot(dofs, d, weight) / (stiffness - sp_dot(dofs, d, z));
    for (int64_t k = 0; k < dofs; k++)
        weight[k] += scale * z[k];
}

/* Adds to by_radius [grains of the network] what a packing at rest does when radii change: grains move by the springs'
 * linear response until forces balance again, and the top wall follows under its load. g: with KN, KT and POSITION. */
static sp_status respond(const sp_packing *p, const sp_network *net, const sp_gradient *g, double *by_radius,
                         sp_error *err) {
    const int64_t dofs = sp_network_dofs(net);
    const size_t size = (size_t)dofs;
    sp_equilibrium e = sp_equilibrium_none();
    double *work = sp_alloc(4 * size, sizeof *work), residual;
    double *d = work, *z = work + size, *right = work + 2 * size, *weight = work + 3 * size;
    const wall w = top_wall(p, net, g);
    sp_status status = work ? SP_OK : sp_fail_memory(err, 4 * size * sizeof *work);
    if (status == SP_OK)
        status = sp_network_detector(net, d, err);
    if (status == SP_OK)
        status = sp_equilibrium_make(net, &e, err);
    for (int32_t i = 0; i < net->n && status == SP_OK; i++)
        for (int a = 0; a < net->dim; a++) {
            const size_t k = (size_t)i * (size_t)net->dof + (size_t)a;
            right[k] = g->position.d[3 * (size_t)i + (size_t)a];
        }
    for (size_t k = 0; k < size && status == SP_OK; k++)
        right[k] += w.slope * d[k] / w.stiffness;
    if (status == SP_OK)
        status = sp_equilibrium_solve(&e, d, 0, z, &residual, err);
    if (status == SP_OK)
        status = sp_equilibrium_solve(&e, right, 0, weight, &residual, err);
    if (status == SP_OK) {
        free_wall(dofs, w.stiffness, d, z, weight);
        add_pushes(net, &w, sp_dot(dofs, weight, d) + w.slope, weight, by_radius);
    }
    sp_equilibrium_free(&e);
    sp_free(work);
    return status;
}

/* ---- the value --------------------------------------------------------------------------------------------------- */

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
                       "the first peak is not distinct: one at t = %.6g has between %.2g and %.2g of the largest force",
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
    sp_status status = respond(made, net, g, radius, err);
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
    sp_status status = apply_factors(d, factor, &q, err);
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
