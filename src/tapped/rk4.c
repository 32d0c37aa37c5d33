/* Solves the lattice as [B] does: classical Runge-Kutta with fixed steps and the sign function of (9). The forces are
 * those of (19), because (24) lacks a minus sign. The method is offered for comparison only. A step across a turning
 * point of a contact is of first order. Where Filippov's solution sticks, rounding decides the sign, so that a force of
 * up to e K delta acts either way and moves particles that should be at rest. */
#include "base/base.h"
#include "tapped/springs.h"

enum { STEPS_A_CONTACT = 200 };

typedef struct fixed {
    sp_tapped_springs springs;
    double time_step;
} fixed;

static double longest(void *model, double s, const double *state) {
    (void)s;
    (void)state;
    return ((fixed *)model)->time_step;
}

static double step(void *model, double s, double h, const double *from, double *to) {
    sp_ode_step4(&((fixed *)model)->springs.ode, s, h, from, to);
    return 0;
}

static void particles(void *model, const double *state, double *y, double *v) {
    sp_tapped_springs_particles(&((fixed *)model)->springs, state, y, v);
}

static double energy(void *model, double floor, const double *state) {
    return sp_tapped_springs_energy(&((fixed *)model)->springs, floor, state);
}

/* The scheme is stable on the imaginary axis up to 2 sqrt(2). */
static sp_status choose(const sp_tapped_spec *c, fixed *m, sp_error *err) {
    double frequency = sp_tapped_springs_frequency(&m->springs), bound = 2 * sqrt(2) / frequency;
    m->time_step = c->time_step > 0 ? c->time_step : 2 * sp_tapped_pi / frequency / STEPS_A_CONTACT;
    if (m->time_step > bound)
        return sp_fail(
            err, SP_EINVAL,
            "column.time_step = %.17g s: the Runge-Kutta scheme is stable up to %.6g s, sqrt(2 m/(K (1 + e))) "
            "of the lightest particle; 0 chooses %d steps per contact",
            m->time_step, bound, STEPS_A_CONTACT);
    return SP_OK;
}

sp_status sp_tapped_run_rk4(const sp_tapped_spec *c, int64_t n, const double *t, sp_tapped_row row, void *user,
                            sp_tapped_report *report, sp_error *err) {
    fixed m = {0};
    sp_status status = sp_tapped_springs_make(c, INFINITY, INFINITY, &m.springs, err);
    if (status != SP_OK)
        return status;
    sp_tapped_marcher marcher = {.model = &m,
                                 .size = 2 * (int64_t)c->particles + 2,
                                 .phase = &m.springs.phase,
                                 .longest = longest,
                                 .step = step,
                                 .particles = particles,
                                 .energy = energy,
                                 .stiff = "a small column.time_step (or a long column.period)"};
    double *state = sp_alloc((size_t)marcher.size, sizeof *state);
    status = state ? choose(c, &m, err) : sp_fail_memory(err, (size_t)marcher.size * sizeof *state);
    if (status == SP_OK) {
        sp_tapped_springs_start(c, &m.springs, state);
        status = sp_tapped_march(c, &marcher, state, &(sp_tapped_rows){n, t, row, user}, report, err);
        report->error = NAN; /* no bound is known */
    }
    sp_free(state);
    sp_tapped_springs_free(&m.springs);
    return status;
}
