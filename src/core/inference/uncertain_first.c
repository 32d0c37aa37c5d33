/* Errors of a packing's sound to first order, from exact derivatives. All kinds of errors are independent, so that the
 * variance is a sum of squares. */
#include "inference/uncertain.h"

#include "base/base.h"
#include "packing/bulk.h"
#include "packing/contact.h"

#include <math.h>
#include <sonopack/sensitivity.h>
#include <string.h>

/* What the gradients refer to. Where forces were measured, each contact of the packing has a stiffness of its own,
 * which neither positions nor radii change: what radii do to it is added here. */
typedef struct first_order {
    const sp_quantities *q;
    const sp_errors *errors;
    const sp_packing *packing;
    sp_network net;
    double density;
    double *density_slope; /* [n of the packing][4] derivatives of the density by the radius and the centre */
    sp_uncertainty *out;
} first_order;

static const unsigned PARAMETERS = SP_BY_KN | SP_BY_KT | SP_BY_RADIUS | SP_BY_POSITION;

/* ---- what the derivatives are multiplied by --------------------------------------------------------------------- */

/* d ln(k_n)/d ln(R) at a fixed force, for the grain of radius r: k_n ~ (R12 F)^(1/3), where R12 is the radius at a
 * wall. */
static double by_own_radius(double r, double other) { return (1 - (other > 0 ? r / (r + other) : 0)) / (3 * r); }

/* Derivative of Q with respect to the logarithm of the stiffness of a spring. */
static double by_log_stiffness(const sp_network *net, const sp_gradient *g, int32_t k) {
    const sp_spring *s = &net->springs[k];
    return s->kn * g->kn.d[k] + (g->kt.n > 0 ? s->kt * g->kt.d[k] : 0);
}

/* Whether the stiffness of a contact follows from its force. */
static bool follows_force(const first_order *f, const sp_packing *measured, int32_t contact) {
    return f->errors->measured == SP_MEASURED_FORCES && !(measured->contacts[contact].kn > 0);
}

/* Adds to by_radius [grains of the network] what radii do to stiffnesses that follow from forces. */
static void add_curvatures(const first_order *f, const sp_packing *measured, const sp_gradient *g, double *by_radius) {
    for (int32_t k = 0; k < f->net.n_springs; k++) {
        const sp_spring *s = &f->net.springs[k];
        if (!follows_force(f, measured, s->contact))
            continue;
        const double slope = by_log_stiffness(&f->net, g, k), ri = f->net.r[s->i];
        const double rj = s->j >= 0 ? f->net.r[s->j] : 0;
        by_radius[s->i] += slope * by_own_radius(ri, rj);
        if (s->j >= 0)
            by_radius[s->j] += slope * by_own_radius(rj, ri);
    }
}

/* ---- one quantity ----------------------------------------------------------------------------------------------- */

/* Adds the squares of the standard deviations by position and radius, and gives each grain its part. density_part:
 * dQ/d(density), for speeds; else 0. */
static void add_grains(const first_order *f, const sp_gradient *g, double density_part, const double *by_radius,
                       double v[SP_ERROR_KINDS], double *part) {
    const sp_errors *e = f->errors;
    for (int32_t i = 0; i < f->net.n; i++) {
        const double *slope = f->density_slope + 4 * (size_t)f->net.grain[i];
        const double radius = by_radius[i] + density_part * slope[0], grown = radius * radius * e->radius * e->radius;
        double moved = 0;
        for (int a = 0; a < f->net.dim; a++) {
            const double x = g->position.d[3 * (size_t)i + (size_t)a] + density_part * slope[1 + a];
            const double square = x * x * e->position * e->position;
            v[SP_ERROR_POSITION] += square;
            moved += square;
        }
        v[SP_ERROR_RADIUS] += grown;
        if (part)
            part[i] = grown + moved;
    }
}

/* The same of the springs. Returns the derivative by the logarithm of all stiffnesses. */
static double add_springs(const first_order *f, const sp_packing *measured, const sp_gradient *g,
                          double v[SP_ERROR_KINDS], double *part) {
    const sp_errors *e = f->errors;
    double whole = 0;
    for (int32_t k = 0; k < f->net.n_springs; k++) {
        const double slope = by_log_stiffness(&f->net, g, k), square = slope * slope;
        const bool follows = follows_force(f, measured, f->net.springs[k].contact);
        const double force = follows ? square / 9 * e->force * e->force : 0;
        const double stiffness = square * e->stiffness * e->stiffness;
        const double absent = square * e->false_part * (1 - e->false_part);
        v[SP_ERROR_FORCE] += force;
        v[SP_ERROR_STIFFNESS] += stiffness;
        v[SP_ERROR_FALSE] += absent;
        whole += slope;
        if (part)
            part[k] = force + stiffness + absent;
    }
    return whole;
}

static void divide(double *part, int32_t n, double sum) {
    for (int32_t k = 0; part && k < n; k++)
        part[k] = sum > 0 ? part[k] / sum : NAN;
}

static void variances(const first_order *f, const sp_packing *measured, const sp_gradient *g, double density_part,
                      double *by_radius, sp_uncertain *out) {
    const sp_network *net = &f->net;
    const size_t q = (size_t)(out - f->out->quantity);
    double *grains = f->out->by_grain ? f->out->by_grain + q * (size_t)net->n : NULL;
    double *springs = f->out->by_contact ? f->out->by_contact + q * (size_t)net->n_springs : NULL;
    double v[SP_ERROR_KINDS] = {0}, sum = 0;
    for (int32_t i = 0; i < net->n; i++)
        by_radius[i] = g->radius.d[i];
    add_curvatures(f, measured, g, by_radius);
    add_grains(f, g, density_part, by_radius, v, grains);
    const double whole = add_springs(f, measured, g, v, springs);
    v[SP_ERROR_CALIBRATION] = whole * whole * f->errors->calibration * f->errors->calibration;
    out->shift = -f->errors->false_part * whole;
    for (int k = 0; k < SP_ERROR_KINDS; k++)
        sum += v[k];
    out->first_order = sqrt(sum);
    for (int k = 0; k < SP_ERROR_KINDS; k++)
        out->share[k] = sum > 0 ? v[k] / sum : NAN;
    divide(grains, net->n, sum);
    divide(springs, net->n_springs, sum);
}

/* Where the derivatives of a quantity are the gradient g times `scale`. */
static sp_status add_quantity(const first_order *f, const sp_packing *measured, const sp_gradient *g, double scale,
                              double density_part, sp_uncertain *out, sp_error *err) {
    double *by_radius = sp_alloc((size_t)f->net.n, sizeof *by_radius);
    if (!by_radius)
        return sp_fail_memory(err, (size_t)f->net.n * sizeof *by_radius);
    variances(f, measured, g, density_part / scale, by_radius, out);
    out->first_order *= fabs(scale);
    out->shift = out->shift * scale + 0; /* no -0 */
    sp_free(by_radius);
    return SP_OK;
}

/* A quantity without derivatives stays NAN; only memory that is missing ends all. */
static sp_status forgive(sp_status status, const sp_error *reason, sp_error *err) {
    if (status != SP_ENOMEM)
        return SP_OK;
    return sp_fail(err, SP_ENOMEM, "%s", reason->text);
}

/* t10, t_peak, peak, width and c = H/t10. */
static sp_status add_front(const first_order *f, const sp_packing *measured, sp_uncertain *out, sp_error *err) {
    sp_sensitivity_options o = sp_sensitivity_options_default();
    sp_front_gradient g;
    sp_error reason = {0};
    o.parameters = PARAMETERS;
    o.source = f->q->opt->source;
    o.until = f->q->window;
    o.points = (int32_t)fmax(ceil(f->q->window / sp_inference_spacing(f->net.pressure)) + 1, 3);
    o.packing = f->packing;
    o.threads = f->q->opt->threads;
    sp_status status =
        sp_sensitivity_front(&f->net, &o, SP_FRONT_T10 | SP_FRONT_T_PEAK | SP_FRONT_PEAK | SP_FRONT_WIDTH, &g, &reason);
    if (status != SP_OK)
        return forgive(status, &reason, err);
    const sp_gradient *const each[SP_FRONT_MARKS] = {&g.t10, &g.t_peak, &g.peak, &g.width, &g.t10};
    for (int k = 0; k < SP_FRONT_MARKS && status == SP_OK; k++) {
        const double scale = k == SP_FRONT_MARKS - 1 ? -out[k].value / g.found.t10 : 1;
        status = add_quantity(f, measured, each[k], scale, 0, &out[k], err);
    }
    sp_front_gradient_free(&g);
    return status;
}

/* Moduli and speeds. Those that the packing does not have are left out. */
static sp_status add_moduli(const first_order *f, const sp_packing *measured, sp_uncertain *out, sp_error *err) {
    sp_modulus of[SP_MODULUS_COUNT];
    sp_gradient g[SP_MODULUS_COUNT];
    sp_uncertain *to[SP_MODULUS_COUNT];
    sp_error reason = {0};
    int n = 0;
    for (int k = 0; k < f->q->moduli; k++)
        if (isfinite(out[k].value)) {
            of[n] = f->q->modulus[k];
            to[n++] = &out[k];
        }
    if (n == 0)
        return SP_OK;
    sp_status status = sp_sensitivity_moduli(&f->net, f->density, n, of, PARAMETERS, f->packing, g, &reason);
    if (status != SP_OK)
        return forgive(status, &reason, err);
    for (int k = 0; k < n; k++) {
        const bool speed = of[k] == SP_MODULUS_CL || of[k] == SP_MODULUS_CT;
        const double density_part = speed ? -0.5 * to[k]->value / f->density : 0;
        if (status == SP_OK)
            status = add_quantity(f, measured, &g[k], 1, density_part, to[k], err);
        sp_gradient_free(&g[k]);
    }
    return status;
}

/* Modes that coincide have no derivatives of their own, and stay NAN. */
static sp_status add_modes(const first_order *f, const sp_packing *measured, sp_uncertain *out, sp_error *err) {
    sp_modes_options o = sp_modes_options_default();
    const sp_modes_range range = sp_modes_range_lowest(f->q->modes);
    sp_modes m = sp_modes_none();
    sp_error reason = {0};
    o.vectors = true;
    sp_status status = sp_modes_make(&f->net, &o, &range, &m, &reason);
    if (status != SP_OK)
        return forgive(status, &reason, err);
    for (int32_t k = 0; k < f->q->modes && status == SP_OK; k++) {
        sp_gradient g;
        status = sp_sensitivity_modes(&f->net, &m, k, 1, PARAMETERS, f->packing, &g, &reason);
        if (status != SP_OK) {
            status = forgive(status, &reason, err);
            continue;
        }
        status = add_quantity(f, measured, &g, 0.5 / m.omega[k], 0, &out[k], err);
        sp_gradient_free(&g);
    }
    sp_modes_free(&m);
    return status;
}

/* ---- the packing that is differentiated ------------------------------------------------------------------------- */

/* Mass of a grain in the bulk. */
static double bulk_mass(const sp_packing *p, const bulk *b, int32_t i, const double x[3], double r) {
    return (p->mass ? p->mass[i] : grain_mass(r)) * sp_bulk_ball(b, x, r);
}

/* Derivatives of the density that a grain contributes to, by central differences: only grains that a layer at a wall
 * cuts have any by their position. */
static void density_slopes(first_order *f, const sp_packing *p) {
    const bulk b = sp_bulk_of(p, f->q->opt->margin);
    const double h = 1e-5;
    for (int32_t k = 0; k < f->net.n && b.volume > 0; k++) {
        const int32_t i = f->net.grain[k];
        double *slope = f->density_slope + 4 * (size_t)i, x[3];
        memcpy(x, p->x + 3 * (size_t)i, sizeof x);
        slope[0] = (bulk_mass(p, &b, i, x, p->r[i] + h) - bulk_mass(p, &b, i, x, p->r[i] - h)) / (2 * h * b.volume);
        for (int a = 0; a < p->dim; a++) {
            const double at = x[a];
            x[a] = at + h;
            slope[1 + a] = bulk_mass(p, &b, i, x, p->r[i]);
            x[a] = at - h;
            slope[1 + a] = (slope[1 + a] - bulk_mass(p, &b, i, x, p->r[i])) / (2 * h * b.volume);
            x[a] = at;
        }
    }
}

static sp_status prepare(first_order *f, const sp_packing *p, sp_error *err) {
    const sp_uncertainty_options *o = f->q->opt;
    f->packing = p;
    f->density_slope = sp_alloc(4 * (size_t)p->n, sizeof *f->density_slope);
    if (!f->density_slope)
        return sp_fail_memory(err, 4 * (size_t)p->n * sizeof *f->density_slope);
    sp_status status = sp_packing_density(p, o->network.threshold, o->margin, &f->density, err);
    return status == SP_OK ? sp_network_make(p, &o->network, &f->net, err) : status;
}

/* Who has parts; all of them NAN until they are known. */
static sp_status list_parts(const sp_network *net, sp_uncertainty *out, sp_error *err) {
    const size_t grains = (size_t)net->n, springs = (size_t)net->n_springs, n = (size_t)out->n;
    out->grain = sp_alloc(grains, sizeof *out->grain);
    out->pair = sp_alloc(2 * springs, sizeof *out->pair);
    out->by_grain = sp_alloc(n * grains, sizeof *out->by_grain);
    out->by_contact = sp_alloc(n * springs, sizeof *out->by_contact);
    if (!out->grain || !out->pair || !out->by_grain || !out->by_contact)
        return sp_fail_memory(err, (n * (grains + springs)) * sizeof *out->by_grain);
    out->grains = net->n;
    out->springs = net->n_springs;
    memcpy(out->grain, net->grain, grains * sizeof *out->grain);
    for (size_t k = 0; k < springs; k++) {
        const sp_spring *s = &net->springs[k];
        out->pair[2 * k] = net->grain[s->i];
        out->pair[2 * k + 1] = s->j < 0 ? s->j : net->grain[s->j];
    }
    for (size_t k = 0; k < n * grains; k++)
        out->by_grain[k] = NAN;
    for (size_t k = 0; k < n * springs; k++)
        out->by_contact[k] = NAN;
    return SP_OK;
}

/* A missing contact has no stiffness from which to differentiate, prestress adds forces that are held here, and a
 * normal of a ring turns with the place of its grain. */
static bool differentiable(const sp_errors *e, const sp_uncertainty_options *o, const sp_packing *p) {
    return e->missing == 0 && !o->network.prestress && p->cell != SP_CELL_RING;
}

sp_status sp_uncertain_first_order(const sp_quantities *q, const sp_drawing *d, const sp_packing *p,
                                   sp_uncertainty *out, sp_error *err) {
    first_order f = {.q = q, .errors = d->errors, .out = out};
    if (!differentiable(d->errors, q->opt, p))
        return SP_OK;
    sp_status status = prepare(&f, p, err);
    if (status == SP_OK && q->opt->parts)
        status = list_parts(&f.net, out, err);
    if (status == SP_OK) {
        density_slopes(&f, p);
        if (q->fronts > 0)
            status = add_front(&f, d->p, out->quantity, err);
    }
    if (status == SP_OK && q->moduli > 0)
        status = add_moduli(&f, d->p, out->quantity + q->fronts, err);
    if (status == SP_OK && q->modes > 0)
        status = add_modes(&f, d->p, out->quantity + q->fronts + q->moduli, err);
    sp_network_free(&f.net);
    sp_free(f.density_slope);
    return status;
}
