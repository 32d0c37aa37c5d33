/* Solves the lattice as an ordinary differential equation by Runge-Kutta schemes, in two ways.
 *
 * rk4: as [B] does, with the classical scheme, fixed steps and the sign function of (9). The forces are those of (19),
 * because (24) lacks a minus sign. The method is offered for comparison only. A step across a turning point of a
 * contact is of first order. Where Filippov's solution sticks, rounding decides the sign, so that a force of up to
 * e K delta acts either way and moves particles that should be at rest.
 *
 * smooth: with the smooth sigma and chi of (30), by an adaptive scheme of order 5. One alpha cannot serve both a
 * velocity and a length, hence alpha_v [s/cm] and alpha_x [1/cm]. With tanh no contact sticks: (27) is the only state
 * of rest (apart from the effect of a finite alpha_x), and whatever the sharp law holds in place creeps towards it. */
#include "base/base.h"
#include "numeric/ode.h"
#include "tapped/integrate.h"

/* The lattice (19) as a system y' = v, v' = acceleration for explicit steps. sigma and chi are sharp as in (9) or
 * smooth as in (30). The state holds y [N], v [N], the work of the floor and the dissipated energy. */
typedef struct springs {
    int32_t n;
    double stiffness, e, gravity;
    double alpha_v, alpha_x; /* INFINITY: the sharp functions */
    double *mass, *distance; /* [n] */
    sp_tapped_phase phase;
    sp_ode ode;
} springs;

static double sigma(double alpha, double w) {
    if (!isinf(alpha))
        return tanh(alpha * w);
    return (double)((w > 0) - (w < 0));
}

static double overlapping(double alpha, double delta) {
    if (!isinf(alpha))
        return 0.5 * delta * (1 + tanh(alpha * delta));
    return delta > 0 ? delta : 0;
}

/* Right-hand side of the system. Contact i pushes the particle above with f and the one below with -f. The floor does
 * work at the rate f_0 y0'; each contact dissipates e K delta chi sigma(w) w. */
static void slope(double s, const double *state, double *out, void *user) {
    const springs *p = user;
    const double *y = state, *v = state + p->n;
    double *dy = out, *dv = out + p->n, *energies = out + 2 * (int64_t)p->n;
    double below = sp_tapped_phase_floor(&p->phase, s), velocity = sp_tapped_phase_velocity(&p->phase, s);
    energies[0] = energies[1] = 0;
    for (int32_t i = 0; i < p->n; i++) {
        double w = v[i] - velocity, delta = p->distance[i] - (y[i] - below);
        double f = p->stiffness * overlapping(p->alpha_x, delta), lost = p->e * sigma(p->alpha_v, w) * f;
        f -= lost;
        energies[1] += lost * w;
        if (i > 0)
            dv[i - 1] -= f / p->mass[i - 1];
        else
            energies[0] = f * velocity;
        dy[i] = v[i];
        dv[i] = f / p->mass[i] - p->gravity;
        below = y[i];
        velocity = v[i];
    }
}

static sp_status springs_make(const sp_tapped_spec *c, double alpha_v, double alpha_x, springs *out, sp_error *err) {
    springs made = {.n = c->particles,
                    .stiffness = sp_tapped_stiffness(c),
                    .e = c->e,
                    .gravity = c->gravity,
                    .alpha_v = alpha_v,
                    .alpha_x = alpha_x};
    const size_t n = (size_t)c->particles;
    made.mass = sp_alloc(2 * n, sizeof *made.mass);
    if (!made.mass)
        return sp_fail_memory(err, 2 * n * sizeof *made.mass);
    made.distance = made.mass + n;
    for (int32_t i = 0; i < c->particles; i++) {
        made.mass[i] = sp_tapped_mass(c, i + 1);
        made.distance[i] = sp_tapped_distance(c, i);
    }
    sp_status status = sp_ode_make(2 * (int64_t)n + 2, slope, out, &made.ode, err);
    if (status == SP_OK)
        *out = made;
    else
        sp_free(made.mass);
    return status;
}

static void springs_free(springs *s) {
    sp_ode_free(&s->ode);
    sp_free(s->mass);
    *s = (springs){0};
}

static void springs_start(const sp_tapped_spec *c, const springs *s, double *state) {
    if (c->drop < 0) {
        sp_tapped_rest(c, state);
        return;
    }
    double height = c->drop;
    for (int32_t i = 0; i < s->n; i++)
        state[i] = height += s->distance[i];
}

static void springs_positions(const springs *s, const double *state, double *y, double *v) {
    for (int32_t i = 0; i < s->n; i++) {
        y[i + 1] = state[i];
        v[i + 1] = state[s->n + i];
    }
}

/* Integral of x/(1 + exp(2 alpha x)) from a >= 0 to infinity: a ln(1 + u)/(2 alpha) - Li2(-u)/(4 alpha^2), u = exp(-2
 * alpha a). Landen's identity, -Li2(-u) = Li2(u/(1 + u)) + ln(1 + u)^2/2, gives a series whose terms at least halve. */
static double beyond(double alpha, double a) {
    double u = exp(-2 * alpha * a), x = u / (1 + u), power = 1, sum = 0, log1 = log1p(u);
    for (int k = 1; k < 60; k++) {
        power *= x;
        sum += power / k / k;
    }
    return a * log1 / (2 * alpha) + (sum + 0.5 * log1 * log1) / (4 * alpha * alpha);
}

/* Integral of x chi(x) from -infinity to delta, chi = 1/(1 + exp(-2 alpha x)): the elastic energy over K. */
static double stored(double alpha, double delta) {
    if (isinf(alpha))
        return delta > 0 ? 0.5 * delta * delta : 0;
    return delta < 0 ? -beyond(alpha, -delta) : 0.5 * delta * delta - 2 * beyond(alpha, 0) + beyond(alpha, delta);
}

static double springs_energy(const springs *s, double floor, const double *state) {
    const double *y = state, *v = state + s->n;
    double sum = 0, below = floor;
    for (int32_t i = 0; i < s->n; i++) {
        sum += s->mass[i] * (0.5 * v[i] * v[i] + s->gravity * y[i]) +
               s->stiffness * stored(s->alpha_x, s->distance[i] - (y[i] - below));
        below = y[i];
    }
    return sum;
}

static double springs_frequency(const springs *s) {
    double lightest = INFINITY;
    for (int32_t i = 0; i < s->n; i++)
        lightest = fmin(lightest, s->mass[i]);
    return 2 * sqrt(s->stiffness * (1 + s->e) / lightest);
}

/* ---- the two schemes -------------------------------------------------------------------------------------------- */

enum { STEPS_PER_CONTACT = 200 };

typedef struct solver {
    springs lattice;
    double max_step, tolerance;
    double *scale; /* [size]: unit of the error of each component */
} solver;

static double max_step(void *model, double s, const double *state) {
    (void)s, (void)state;
    return ((solver *)model)->max_step;
}

static double fixed_step(void *model, double s, double h, const double *from, double *to) {
    sp_ode_step4(&((solver *)model)->lattice.ode, s, h, from, to);
    return 0;
}

static double adaptive_step(void *model, double s, double h, const double *from, double *to) {
    solver *m = model;
    return sp_ode_step5(&m->lattice.ode, s, h, from, m->scale, to) / m->tolerance;
}

/* The step is at most half a radian of the fastest mode. A longer one could jump into a contact that none of its stages
 * sees. */
static void adapt(void *model, double h, double error) {
    solver *m = model;
    m->max_step = fmin(h * sp_ode_factor(error), 0.5 / springs_frequency(&m->lattice));
}

static void positions(void *model, const double *state, double *y, double *v) {
    springs_positions(&((solver *)model)->lattice, state, y, v);
}

static double energy(void *model, double floor, const double *state) {
    return springs_energy(&((solver *)model)->lattice, floor, state);
}

/* The classical scheme is stable on the imaginary axis up to 2 sqrt(2). */
static sp_status choose_fixed_step(const sp_tapped_spec *c, solver *m, sp_error *err) {
    double frequency = springs_frequency(&m->lattice), bound = 2 * sqrt(2) / frequency;
    m->max_step = c->time_step > 0 ? c->time_step : 2 * M_PI / frequency / STEPS_PER_CONTACT;
    if (m->max_step > bound)
        return sp_fail_key(err, SP_EINVAL, "column.time_step",
                           " = %.17g s: the Runge-Kutta scheme is stable up to %.6g s, sqrt(2 m/(K (1 + "
                           "e))) of the lightest particle; 0 chooses %d steps per contact",
                           m->max_step, bound, STEPS_PER_CONTACT);
    return SP_OK;
}

/* Units of the error: for heights the smallest distance of two particles, for velocities that of a fall through this
 * distance, for energies the weight of the column times it. */
static void set_scales(const springs *s, double *scale) {
    double distance = INFINITY, mass = 0;
    for (int32_t i = 0; i < s->n; i++) {
        distance = fmin(distance, s->distance[i]);
        mass += s->mass[i];
    }
    for (int32_t i = 0; i < s->n; i++) {
        scale[i] = distance;
        scale[s->n + i] = sqrt(s->gravity * distance);
    }
    scale[2 * s->n] = scale[2 * s->n + 1] = mass * s->gravity * distance;
}

static sp_status prepare(const sp_tapped_spec *c, solver *m, sp_error *err) {
    if (c->method == SP_TAPPED_RK4)
        return choose_fixed_step(c, m, err);
    m->tolerance = c->tolerance;
    m->max_step = 0.01 / springs_frequency(&m->lattice);
    set_scales(&m->lattice, m->scale);
    return SP_OK;
}

sp_status sp_tapped_run_ode(const sp_tapped_spec *c, const sp_tapped_rows *rows, sp_tapped_report *report,
                            sp_error *err) {
    const bool fixed = c->method == SP_TAPPED_RK4;
    const double alpha_v = fixed ? INFINITY : c->alpha_v, alpha_x = fixed || !(c->alpha_x > 0) ? INFINITY : c->alpha_x;
    solver m = {0};
    sp_status status = springs_make(c, alpha_v, alpha_x, &m.lattice, err);
    if (status != SP_OK)
        return status;
    sp_tapped_stepper stepper = {.model = &m,
                                 .size = 2 * (int64_t)c->particles + 2,
                                 .phase = &m.lattice.phase,
                                 .max_step = max_step,
                                 .step = fixed ? fixed_step : adaptive_step,
                                 .adapt = fixed ? NULL : adapt,
                                 .positions = positions,
                                 .energy = energy,
                                 .cause = fixed ? "a small column.time_step (or a long column.period)"
                                                : "a large column.alpha_v (or a small column.tolerance)"};
    double *state = sp_alloc(2 * (size_t)stepper.size, sizeof *state);
    m.scale = state ? state + stepper.size : NULL;
    status = state ? prepare(c, &m, err) : sp_fail_memory(err, 2 * (size_t)stepper.size * sizeof *state);
    if (status == SP_OK) {
        springs_start(c, &m.lattice, state);
        status = sp_tapped_integrate(c, &stepper, state, rows, report, err);
        report->error = fixed ? NAN : c->tolerance; /* NAN: no bound is known */
        report->time_step = fixed ? report->time_step : 0;
    }
    sp_free(state);
    springs_free(&m.lattice);
    return status;
}
