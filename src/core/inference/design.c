/* Design by projected gradients. */
#include "base/base.h"
#include "inference/design_problem.h"
#include "packing/contact.h"

#include <math.h>
#include <string.h>

/* ---- the factors that are allowed: a box cut by the plane of equal totals ---------------------------------------- */

static double clamp(const sp_design_problem *d, double x) { return fmin(fmax(x, d->opt->low), d->opt->high); }

/* Sum of the weights times the factors, shifted along the weights by -shift and clamped. */
static double shifted_total(const sp_design_problem *d, const double *factor, double shift) {
    double sum = 0;
    for (int32_t i = 0; i < d->p->n; i++)
        if (d->weight[i] > 0)
            sum += d->weight[i] * clamp(d, factor[i] - shift * d->weight[i]);
    return sum;
}

/* The nearest point: factors shifted along the weights, clamped. The total falls with the shift, so that bisection
 * finds it. */
void sp_design_project(const sp_design_problem *d, double *factor) {
    double low = 0, high = 0, largest = 0, least = INFINITY;
    for (int32_t i = 0; i < d->p->n; i++)
        if (d->weight[i] > 0) {
            largest = fmax(largest, fabs(factor[i]) + d->opt->high);
            least = fmin(least, d->weight[i]);
        }
    if (!d->opt->free) {
        low = -largest / least;
        high = -low;
    }
    for (int k = 0; k < 200 && low < high; k++) {
        const double middle = 0.5 * (low + high);
        if (middle <= low || middle >= high)
            break;
        if (shifted_total(d, factor, middle) > d->total)
            low = middle;
        else
            high = middle;
    }
    for (int32_t i = 0; i < d->p->n; i++)
        factor[i] = d->weight[i] > 0 ? clamp(d, factor[i] - 0.5 * (low + high) * d->weight[i]) : 1;
}

/* Total with the upper limit where the gain per weight is above a level, else the lower one. */
static double total_above(const sp_design_problem *d, const double *g, double level) {
    double sum = 0;
    for (int32_t i = 0; i < d->p->n; i++)
        sum += d->weight[i] * (g[i] > level * d->weight[i] ? d->opt->high : d->opt->low);
    return sum;
}

/* A linear programme with one constraint: the grains of the largest gain per weight are at the upper limit, the others
 * at the lower one, and those at the level share the rest. */
double sp_design_extreme(const sp_design_problem *d, const double *g, double *factor) {
    double low = 0, high = 0, rest = 0, at_level = 0;
    for (int32_t i = 0; i < d->p->n && !d->opt->free; i++)
        if (d->weight[i] > 0)
            high = fmax(high, fabs(g[i]) / d->weight[i]);
    low = -2 * high;
    high = 2 * high;
    for (int k = 0; k < 200 && low < high; k++) {
        const double middle = 0.5 * (low + high);
        if (middle <= low || middle >= high)
            break;
        if (total_above(d, g, middle) > d->total)
            low = middle;
        else
            high = middle;
    }
    for (int32_t i = 0; i < d->p->n; i++) {
        const double level = d->weight[i] > 0 ? g[i] / d->weight[i] : 0;
        const bool between = !d->opt->free && level > low && level <= high;
        factor[i] = d->weight[i] == 0                             ? 1
                    : between                                     ? NAN
                    : level > high || (d->opt->free && level > 0) ? d->opt->high
                                                                  : d->opt->low;
        rest += between ? 0 : d->weight[i] * factor[i];
        at_level += between ? d->weight[i] : 0;
    }
    for (int32_t i = 0; i < d->p->n; i++)
        if (isnan(factor[i]))
            factor[i] = clamp(d, (d->total - rest) / at_level);
    return 0.5 * (low + high);
}

/* ---- the search -------------------------------------------------------------------------------------------------- */

enum { ITERATIONS_MOST = 100000, HALVINGS = 12 };

sp_design_options sp_design_options_default(void) {
    return (sp_design_options){.low = 0.5,
                               .high = 2,
                               .network = sp_network_options_default(),
                               .iterations = 50,
                               .tolerance = 1e-3,
                               .threads = 1};
}

sp_design sp_design_none(void) { return (sp_design){.packing = sp_packing_none()}; }

void sp_design_free(sp_design *d) {
    sp_free(d->factor);
    sp_free(d->step);
    sp_packing_free(&d->packing);
    *d = sp_design_none();
}

static sp_status check_options(const sp_packing *p, const sp_design_options *o, sp_error *err) {
    if (!(o->low > 0 && o->low <= 1 && o->high >= 1 && o->high <= 1e3 && o->low >= 1e-3 && o->low < o->high))
        return sp_fail_key(err, SP_EINVAL, "limits",
                           " = %g:%g: must be LOW:HIGH with 0.001 <= LOW <= 1 <= HIGH <= 1000", o->low, o->high);
    if (!o->free && (o->low == 1 || o->high == 1))
        return sp_fail_key(err, SP_EINVAL, "limits", " = %g:%g: no grain can change while the total is kept", o->low,
                           o->high);
    if (o->goal == SP_DESIGN_BAND && !(o->band_low >= 0 && o->band_low < o->band_high && isfinite(o->band_high)))
        return sp_fail_key(err, SP_EINVAL, "goal", " = band:%g:%g: must be band:W1:W2 with 0 <= W1 < W2", o->band_low,
                           o->band_high);
    if (!(o->iterations >= 0 && o->iterations <= ITERATIONS_MOST))
        return sp_fail_key(err, SP_EINVAL, "iterations", " = %d: must be 0 .. %d", o->iterations, ITERATIONS_MOST);
    if (!(o->tolerance >= 0 && o->tolerance < 1))
        return sp_fail_key(err, SP_EINVAL, "tolerance", " = %g: must be 0 .. 1", o->tolerance);
    if (o->vary == SP_DESIGN_RADIUS && p->cell != SP_CELL_PISTON)
        return sp_fail(err, SP_EREFUSED, "radii are designed under a piston only, whose load is known");
    return o->vary == SP_DESIGN_RADIUS ? sp_packing_need_law(p, "a design of radii", err) : SP_OK;
}

/* Mass, 1, or volume of the grains that carry force. */
static sp_status set_weights(sp_design_problem *d, sp_error *err) {
    const sp_packing *p = d->p;
    uint8_t *rattler = sp_alloc((size_t)p->n, 1);
    d->weight = sp_alloc((size_t)p->n, sizeof *d->weight);
    sp_status status = rattler && d->weight ? SP_OK : sp_fail_memory(err, 9 * (size_t)p->n);
    if (status == SP_OK)
        status = sp_packing_rattlers(p, d->opt->network.threshold, rattler, NULL, NULL, err);
    for (int32_t i = 0; i < p->n && status == SP_OK; i++) {
        const double mass = p->mass && d->opt->vary == SP_DESIGN_MASS ? p->mass[i] : grain_mass(p->r[i]);
        d->weight[i] = rattler[i] ? 0 : d->opt->vary == SP_DESIGN_MODULUS ? 1 : mass;
        d->total += d->weight[i];
    }
    sp_free(rattler);
    return status;
}

/* ---- the way ---------------------------------------------------------------------------------------------------- */

/* A point with its gradient. */
typedef struct point {
    double *factor, *gradient; /* [n] */
    sp_design_value at;
    sp_packing made;
} point;

static sp_status new_point(int32_t n, point *out, sp_error *err) {
    *out = (point){.made = sp_packing_none()};
    out->factor = sp_alloc(2 * (size_t)n, sizeof *out->factor);
    out->gradient = out->factor ? out->factor + n : NULL;
    return out->factor ? SP_OK : sp_fail_memory(err, 2 * (size_t)n * sizeof *out->factor);
}

static void free_point(point *p) {
    sp_free(p->factor);
    sp_packing_free(&p->made);
    *p = (point){.made = sp_packing_none()};
}

static void exchange(point *a, point *b) {
    const point other = *a;
    *a = *b;
    *b = other;
}

static sp_status evaluate(const sp_design_problem *d, point *p, sp_error *err) {
    sp_packing_free(&p->made);
    return sp_design_evaluate(d, p->factor, p->gradient, &p->at, &p->made, err);
}

static double gain_to(const sp_design_problem *d, const point *a, const point *b) {
    double sum = 0;
    for (int32_t i = 0; i < d->p->n; i++)
        sum += a->gradient[i] * (b->factor[i] - a->factor[i]);
    return sum;
}

/* The value that the objective of a, increased by a gain, stands for. */
static double promised(const sp_design_problem *d, const point *a, double gain) {
    return a->at.value * exp(d->opt->goal == SP_DESIGN_DELAY ? gain : -gain);
}

static sp_status add_step(const sp_design_problem *d, const point *p, double predicted, sp_design *out, sp_error *err) {
    size_t capacity = (size_t)out->steps;
    sp_design_step *more = sp_grow(out->step, (size_t)out->steps + 1, &capacity, sizeof *more);
    if (!more)
        return sp_fail_memory(err, capacity * sizeof *more);
    out->step = more;
    sp_design_step *s = &out->step[out->steps++];
    *s = (sp_design_step){.value = p->at.value, .error = p->at.error, .predicted = predicted};
    for (int32_t i = 0; i < d->p->n; i++)
        s->bound += d->weight[i] > 0 && (p->factor[i] <= d->opt->low || p->factor[i] >= d->opt->high);
    return SP_OK;
}

/* A step that no signal follows ends the search in this direction, and is no failure. */
static bool is_fatal(sp_status status) { return status == SP_ENOMEM || status == SP_EINTERRUPTED; }

/* Tries shorter and shorter steps along the gradient until one gains a fair part of what it promised. *better tells. */
static sp_status search(sp_design_problem *d, const point *now, double step, point *next, bool *better, sp_error *err) {
    *better = false;
    d->from = &now->made;
    for (int k = 0; k < HALVINGS && !*better; k++, step *= 0.5) {
        sp_error reason = {0};
        for (int32_t i = 0; i < d->p->n; i++)
            next->factor[i] = now->factor[i] + step * now->gradient[i];
        sp_design_project(d, next->factor);
        const double gain = gain_to(d, now, next);
        if (!(gain > 0))
            return SP_OK;
        const sp_status status = evaluate(d, next, &reason);
        if (is_fatal(status))
            return sp_fail(err, status, "%s", reason.text);
        *better = status == SP_OK && next->at.objective >= now->at.objective + 0.1 * gain;
    }
    return SP_OK;
}

/* Barzilai and Borwein's step: the inverse curvature along the last one. */
static double next_step(const sp_design_problem *d, const point *a, const point *b, double step) {
    double ss = 0, sy = 0;
    for (int32_t i = 0; i < d->p->n; i++) {
        const double s = b->factor[i] - a->factor[i];
        ss += s * s;
        sy += s * (b->gradient[i] - a->gradient[i]);
    }
    return sy < 0 ? fmin(-ss / sy, 100 * step) : 2 * step;
}

/* A fifth of the range. Radii begin with changes below the overlaps: beyond, other contacts decide than those that the
 * gradient knows. */
static double first_step(const sp_design_problem *d, const point *p) {
    const double overlap = 2e-3, fifth = 0.2 * (d->opt->high - d->opt->low);
    double largest = 0;
    for (int32_t i = 0; i < d->p->n; i++)
        largest = fmax(largest, fabs(p->gradient[i]));
    return largest > 0 ? (d->opt->vary == SP_DESIGN_RADIUS ? fmin(fifth, overlap) : fifth) / largest : 0;
}

static sp_status climb(sp_design_problem *d, double start, point *now, point *next, sp_design *out, sp_error *err) {
    double step = first_step(d, now);
    for (int32_t k = 0; k < d->opt->iterations && step > 0; k++) {
        bool better;
        sp_status status = search(d, now, step, next, &better, err);
        if (status == SP_OK && better)
            status = add_step(d, next, promised(d, now, gain_to(d, now, next)), out, err);
        if (status != SP_OK)
            return status;
        if (!better)
            return SP_OK;
        const double gain = next->at.objective - now->at.objective;
        step = next_step(d, now, next, step);
        exchange(now, next);
        if (gain < d->opt->tolerance * (now->at.objective - start))
            return SP_OK;
    }
    return SP_OK;
}

/* The factors that the first gradient makes largest within the limits, and what comes of them. *better: than the start;
 * then they are `now`. */
static sp_status try_extreme(const sp_design_problem *d, point *now, point *next, sp_design *out, bool *better,
                             sp_error *err) {
    sp_error reason = {0};
    double first = 0, second = 0;
    const double multiplier = sp_design_extreme(d, now->gradient, next->factor), gain = gain_to(d, now, next);
    for (int32_t i = 0; i < d->p->n; i++) {
        const double g = d->weight[i] > 0 ? now->gradient[i] - multiplier * d->weight[i] : 0;
        first += fabs(g);
        second += g * g;
    }
    out->effective = first * first / second;
    out->linear_predicted = promised(d, now, gain);
    out->linear = out->linear_error = NAN;
    const sp_status status = evaluate(d, next, &reason);
    *better = status == SP_OK && next->at.objective > now->at.objective;
    if (is_fatal(status))
        return sp_fail(err, status, "%s", reason.text);
    if (status == SP_OK) {
        out->linear = next->at.value;
        out->linear_error = next->at.error;
    }
    if (*better)
        exchange(now, next);
    return SP_OK;
}

/* One way: from the packing, or with a first step to the limits. Without a gain by that step it ends there. */
static sp_status walk(sp_design_problem *d, bool to_limits, point *now, point *next, sp_design *out, sp_error *err) {
    bool better = true;
    d->from = NULL;
    for (int32_t i = 0; i < d->p->n; i++)
        now->factor[i] = 1;
    sp_status status = evaluate(d, now, err);
    if (status == SP_OK && d->opt->goal == SP_DESIGN_BAND && d->scale == 1) { /* values are relative to the start's */
        d->scale = now->at.value;
        now->at = (sp_design_value){0, 1, now->at.error / d->scale};
    }
    if (status != SP_OK)
        return status;
    const double start = now->at.objective;
    status = add_step(d, now, NAN, out, err);
    if (status == SP_OK && to_limits)
        status = try_extreme(d, now, next, out, &better, err);
    if (status == SP_OK && to_limits && better)
        status = add_step(d, now, out->linear_predicted, out, err);
    return status == SP_OK && better ? climb(d, start, now, next, out, err) : status;
}

/* The way, with its own points. */
static sp_status make_way(sp_design_problem *d, bool to_limits, sp_design *out, double *objective, sp_error *err) {
    const size_t n = (size_t)d->p->n;
    point now = {.made = sp_packing_none()}, next = now;
    sp_status status = new_point(d->p->n, &now, err);
    if (status == SP_OK)
        status = new_point(d->p->n, &next, err);
    out->factor = status == SP_OK ? sp_alloc(n, sizeof *out->factor) : NULL;
    if (status == SP_OK && !out->factor)
        status = sp_fail_memory(err, n * sizeof *out->factor);
    if (status == SP_OK)
        status = walk(d, to_limits, &now, &next, out, err);
    if (status == SP_OK) {
        out->n = d->p->n;
        memcpy(out->factor, now.factor, n * sizeof *out->factor);
        out->packing = now.made;
        now.made = sp_packing_none();
        *objective = now.at.objective;
    }
    free_point(&now);
    free_point(&next);
    return status;
}

/* What the first gradient tells belongs to both ways. */
static void keep_better(sp_design *direct, sp_design *limits, bool first, sp_design *out) {
    *out = first ? *direct : *limits;
    out->linear_predicted = limits->linear_predicted;
    out->linear = limits->linear;
    out->linear_error = limits->linear_error;
    out->effective = limits->effective;
    sp_design_free(first ? limits : direct);
}

sp_status sp_design_make(const sp_packing *p, const sp_design_options *opt, sp_design *out, sp_error *err) {
    sp_design_problem d = {.p = p, .opt = opt, .scale = 1};
    sp_design direct = sp_design_none(), limits = sp_design_none();
    double objective[2];
    sp_status status = check_options(p, opt, err);
    if (status == SP_OK)
        status = set_weights(&d, err);
    if (status == SP_OK)
        status = make_way(&d, false, &direct, &objective[0], err);
    if (status == SP_OK)
        status = make_way(&d, true, &limits, &objective[1], err);
    if (status == SP_OK) {
        keep_better(&direct, &limits, objective[0] >= objective[1], out);
    } else {
        sp_design_free(&direct);
        sp_design_free(&limits);
    }
    sp_free(d.weight);
    return status;
}
