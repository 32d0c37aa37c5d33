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
#include "tapped/springs.h"

enum { STEPS_PER_CONTACT = 200 };

typedef struct solver {
    sp_tapped_springs springs;
    double max_step, tolerance;
    double *scale; /* [size]: unit of the error of each component */
} solver;

static double max_step(void *model, double s, const double *state) {
    (void)s, (void)state;
    return ((solver *)model)->max_step;
}

static double fixed_step(void *model, double s, double h, const double *from, double *to) {
    sp_ode_step4(&((solver *)model)->springs.ode, s, h, from, to);
    return 0;
}

static double adaptive_step(void *model, double s, double h, const double *from, double *to) {
    solver *m = model;
    return sp_ode_step5(&m->springs.ode, s, h, from, m->scale, to) / m->tolerance;
}

/* The step is at most half a radian of the fastest mode. A longer one could jump into a contact that none of its stages
 * sees. */
static void adapt(void *model, double h, double error) {
    solver *m = model;
    m->max_step = fmin(h * sp_ode_factor(error), 0.5 / sp_tapped_springs_frequency(&m->springs));
}

static void positions(void *model, const double *state, double *y, double *v) {
    sp_tapped_springs_positions(&((solver *)model)->springs, state, y, v);
}

static double energy(void *model, double floor, const double *state) {
    return sp_tapped_springs_energy(&((solver *)model)->springs, floor, state);
}

/* The classical scheme is stable on the imaginary axis up to 2 sqrt(2). */
static sp_status choose_fixed_step(const sp_tapped_spec *c, solver *m, sp_error *err) {
    double frequency = sp_tapped_springs_frequency(&m->springs), bound = 2 * sqrt(2) / frequency;
    m->max_step = c->time_step > 0 ? c->time_step : 2 * sp_tapped_pi / frequency / STEPS_PER_CONTACT;
    if (m->max_step > bound)
        return sp_fail_key(err, SP_EINVAL, "column.time_step",
                           " = %.17g s: the Runge-Kutta scheme is stable up to %.6g s, sqrt(2 m/(K (1 + "
                           "e))) of the lightest particle; 0 chooses %d steps per contact",
                           m->max_step, bound, STEPS_PER_CONTACT);
    return SP_OK;
}

/* Units of the error: for heights the smallest distance of two particles, for velocities that of a fall through this
 * distance, for energies the weight of the column times it. */
static void set_scales(const sp_tapped_springs *s, double *scale) {
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
    m->max_step = 0.01 / sp_tapped_springs_frequency(&m->springs);
    set_scales(&m->springs, m->scale);
    return SP_OK;
}

sp_status sp_tapped_run_ode(const sp_tapped_spec *c, const sp_tapped_rows *rows, sp_tapped_report *report,
                            sp_error *err) {
    const bool fixed = c->method == SP_TAPPED_RK4;
    const double alpha_v = fixed ? INFINITY : c->alpha_v, alpha_x = fixed || !(c->alpha_x > 0) ? INFINITY : c->alpha_x;
    solver m = {0};
    sp_status status = sp_tapped_springs_make(c, alpha_v, alpha_x, &m.springs, err);
    if (status != SP_OK)
        return status;
    sp_tapped_stepper stepper = {.model = &m,
                                 .size = 2 * (int64_t)c->particles + 2,
                                 .phase = &m.springs.phase,
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
        sp_tapped_springs_start(c, &m.springs, state);
        status = sp_tapped_integrate(c, &stepper, state, rows, report, err);
        report->error = fixed ? NAN : c->tolerance; /* NAN: no bound is known */
        report->time_step = fixed ? report->time_step : 0;
    }
    sp_free(state);
    sp_tapped_springs_free(&m.springs);
    return status;
}
