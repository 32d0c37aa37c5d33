/* The largest Lyapunov exponent: from the multipliers of a cycle where there is one, else from the growth of a tangent.
 */
#include "base/base.h"
#include "linalg/eigen.h"
#include "tapped/events.h"

enum {
    CYCLE_MAX = 32,       /* longest cycle that is searched for, in taps */
    CYCLE_PARTICLES = 64, /* for more particles the matrix costs more than the average */
    BLOCKS = 16,
    LEAST_TAPS = 10
};

static const double return_tolerance = 1e-9; /* tolerance for the return to a state, relative to its size */

static sp_status make_orbit(const sp_tapped_spec *c, int tangents, sp_event_run *o, sp_error *err) {
    sp_status status = sp_event_run_make(c, tangents, NULL, o, err);
    if (status == SP_OK)
        sp_lattice_start(&o->l);
    return status;
}

static double distance_of(const sp_lattice *l, const double *delta, const double *w) {
    double most = 0;
    for (int32_t i = 0; i < l->n; i++) {
        most = fmax(most, fabs(l->delta[i] - delta[i]) / l->distance[i]);
        most = fmax(most, fabs(l->w[i] - w[i]) / (l->a * l->omega + l->distance[i] * l->fastest));
    }
    return most;
}

/* Finds the number of taps after which the orbit returns to state s; 0 if it is above CYCLE_MAX. */
static sp_status find_cycle(sp_event_run *o, sp_tapped_state *s, int32_t *cycle, sp_error *err) {
    sp_status status = SP_OK;
    *cycle = 0;
    sp_lattice_get(&o->l, s->overlap, s->opening);
    for (int32_t k = 1; status == SP_OK && k <= CYCLE_MAX && *cycle == 0; k++) {
        status = sp_event_run_tap(o, 0, err);
        if (status == SP_OK && distance_of(&o->l, s->overlap, s->opening) < return_tolerance)
            *cycle = k;
    }
    return status;
}

/* Largest modulus of the multipliers over one cycle, after which s has moved on by the cycle. */
static sp_status find_multiplier(const sp_tapped_spec *c, sp_tapped_state *s, int32_t cycle, double *most,
                                 sp_error *err) {
    const size_t n = 2 * (size_t)c->particles, size = 2 * n * (n + 1);
    double *matrix = sp_alloc(size, sizeof *matrix);
    if (!matrix)
        return sp_fail_memory(err, size * sizeof *matrix);
    double *vectors = matrix + n * n, *re = vectors + n * n, *im = re + n;
    sp_status status = sp_tapped_map(c, s, cycle, matrix, err);
    if (status == SP_OK) /* the transpose has the same eigenvalues */
        status = sp_eigen_general((int64_t)n, matrix, re, im, vectors, err);
    *most = 0;
    for (size_t k = 0; status == SP_OK && k < n; k++)
        *most = fmax(*most, hypot(re[k], im[k]));
    sp_free(matrix);
    return status;
}

/* Two rounds may agree by chance: the least error of an exponent, some hundred roundings of each tap. */
static const double rounding = 1e-13;

static sp_status exponent_of_cycle(const sp_tapped_spec *c, sp_tapped_state *s, int32_t cycle, sp_tapped_exponent *out,
                                   sp_error *err) {
    double first, second;
    sp_status status = find_multiplier(c, s, cycle, &first, err);
    if (status == SP_OK)
        status = find_multiplier(c, s, cycle, &second, err);
    if (status != SP_OK)
        return status;
    out->lambda = log(second) / cycle;
    out->error = first > 0 && second > 0 ? fmax(fabs(log(first / second)) / cycle, rounding) : 0;
    out->cycle = cycle;
    return SP_OK;
}

/* Average with the weights exp(-1/(x (1 - x))), which converges faster than any power where the orbit is quasiperiodic
 * (S. Das, Y. Saiki, E. Sander, J. A. Yorke, Nonlinearity 30, 4111, 2017). */
static double smooth_mean(const double *value, int32_t n) {
    double sum = 0, weights = 0;
    for (int32_t k = 0; k < n; k++) {
        double x = (k + 1.0) / (n + 1.0), weight = exp(-1 / (x * (1 - x)));
        sum += weight * value[k];
        weights += weight;
    }
    return sum / weights;
}

/* Standard error of the mean of weakly correlated values, from BLOCKS block means. */
static double block_error(const double *value, int32_t n) {
    double sum = 0, squares = 0;
    int32_t length = n / BLOCKS;
    for (int32_t b = 0; b < BLOCKS; b++) {
        double mean = 0;
        for (int32_t k = b * length; k < (b + 1) * length; k++)
            mean += value[k] / length;
        sum += mean;
        squares += mean * mean;
    }
    return sqrt(fmax(0, squares / BLOCKS - sum * sum / (BLOCKS * BLOCKS)) / (BLOCKS - 1));
}

/* Regular orbits: the change since half of the taps. Chaotic orbits also have a statistical error; the smooth weights
 * enlarge it by a third over equal weights. */
static double error_of(const double *growth, int32_t n, double lambda) {
    if (n < 2)
        return NAN;
    double change = fabs(lambda - smooth_mean(growth, n / 2));
    return lambda > 0 && n >= 2 * BLOCKS ? fmax(change, 1.3 * block_error(growth, n)) : change;
}

static double scale_tangent(sp_lattice *l) {
    double sum = 0;
    for (int32_t i = 0; i < l->n; i++)
        sum += l->t_delta[i] * l->fastest * l->t_delta[i] * l->fastest + l->t_w[i] * l->t_w[i];
    double size = sqrt(sum);
    for (int32_t i = 0; size > 0 && i < l->n; i++) {
        l->t_delta[i] /= size;
        l->t_w[i] /= size;
    }
    return size;
}

static void start_tangent(sp_lattice *l) {
    for (int32_t i = 0; i < l->n; i++) {
        l->t_delta[i] = (1 + sin(1.0 + i)) / l->fastest; /* a direction without symmetry */
        l->t_w[i] = l->state[i] == CONTACT_STUCK ? 0 : 1 - cos(2.0 + i);
    }
    scale_tangent(l);
}

/* Follows one tangent along the orbit. The first tenth of the taps lets it align with the direction of growth. */
static sp_status exponent_by_average(sp_event_run *o, int32_t taps, sp_tapped_exponent *out, sp_error *err) {
    sp_lattice *l = &o->l;
    double *growth = sp_alloc((size_t)taps, sizeof *growth);
    if (!growth)
        return sp_fail_memory(err, (size_t)taps * sizeof *growth);
    sp_status status = SP_OK;
    bool vanished = false;
    start_tangent(l);
    for (int32_t k = -taps / 10; status == SP_OK && k < taps && !vanished; k++) {
        status = sp_event_run_tap(o, 0, err);
        double size = scale_tangent(l);
        vanished = !(size > 0);
        if (k >= 0)
            growth[k] = log(size);
    }
    if (status == SP_OK) {
        out->lambda = vanished ? -INFINITY : smooth_mean(growth, taps);
        out->error = vanished ? 0 : error_of(growth, taps, out->lambda);
        out->cycle = 0;
    }
    sp_free(growth);
    return status;
}

static sp_status find_exponent(const sp_tapped_spec *c, sp_event_run *o, sp_tapped_state *s, sp_tapped_exponent *out,
                               sp_error *err) {
    sp_status status = SP_OK;
    int32_t cycle = 0;
    for (int32_t k = 0; status == SP_OK && k < c->transient; k++)
        status = sp_event_run_tap(o, 0, err);
    if (status == SP_OK && c->particles <= CYCLE_PARTICLES)
        status = find_cycle(o, s, &cycle, err);
    if (status == SP_OK && cycle > 0)
        status = exponent_of_cycle(c, s, cycle, out, err);
    if (status != SP_OK || (cycle > 0 && out->lambda <= 0)) /* an orbit does not stay on a repelling cycle */
        return status;
    sp_event_run tangent = {0};
    status = make_orbit(c, 1, &tangent, err);
    if (status == SP_OK) {
        sp_lattice_get(&o->l, s->overlap, s->opening);
        sp_lattice_set(&tangent.l, s->overlap, s->opening);
        status = exponent_by_average(&tangent, c->taps, out, err);
    }
    sp_event_run_free(&tangent);
    return status;
}

sp_status sp_tapped_lyapunov(const sp_tapped_spec *spec, sp_tapped_exponent *out, sp_error *err) {
    sp_tapped_spec c = *spec;
    c.output = SP_TAPPED_LYAPUNOV;
    c.taps = sp_tapped_taps(&c);
    sp_event_run o = {0};
    sp_tapped_state s = {0};
    sp_tapped_exponent found = {0};
    sp_status status = sp_tapped_state_make(&c, &s, err);
    if (status == SP_OK && c.taps < LEAST_TAPS)
        status = sp_fail_key(err, SP_EINVAL, "column.taps", " = %d: must be at least %d for an exponent, or 0 for 1000",
                             c.taps, LEAST_TAPS);
    if (status == SP_OK)
        status = make_orbit(&c, 0, &o, err);
    if (status == SP_OK)
        status = find_exponent(&c, &o, &s, &found, err);
    if (status == SP_OK) {
        *out = found;
        out->violated = o.report->violated >= 0;
    }
    sp_event_run_free(&o);
    sp_tapped_state_free(&s);
    return status;
}
