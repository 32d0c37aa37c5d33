/* Solves the lattice with the smooth sigma and chi of (30) by an adaptive Runge-Kutta scheme of order 5. One alpha
 * cannot serve both a velocity and a length, hence alpha_v [s/cm] and alpha_x [1/cm]. With tanh no contact sticks: (27)
 * is the only state of rest (apart from the effect of a finite alpha_x), and whatever the sharp law holds in place
 * creeps towards it. */
#include "base/base.h"
#include "tapped/springs.h"

typedef struct smooth {
    sp_tapped_springs springs;
    double tolerance, longest;
    double *scale; /* [size]: unit of the error of each component */
} smooth;

static double longest(void *model, double s, const double *state) {
    (void)s;
    (void)state;
    return ((smooth *)model)->longest;
}

static double step(void *model, double s, double h, const double *from, double *to) {
    smooth *m = model;
    return sp_ode_step5(&m->springs.ode, s, h, from, m->scale, to) / m->tolerance;
}

/* The step is at most half a radian of the fastest mode. A longer one could jump into a contact that none of its stages
 * sees. */
static void judge(void *model, double h, double error) {
    smooth *m = model;
    m->longest = fmin(h * sp_ode_factor(error), 0.5 / sp_tapped_springs_frequency(&m->springs));
}

static void particles(void *model, const double *state, double *y, double *v) {
    sp_tapped_springs_particles(&((smooth *)model)->springs, state, y, v);
}

static double energy(void *model, double floor, const double *state) {
    return sp_tapped_springs_energy(&((smooth *)model)->springs, floor, state);
}

/* Units of the error: for heights the smallest distance of two particles, for velocities that of a fall through this
 * distance, for energies the weight of the column times it. */
static void scales(const sp_tapped_springs *s, double *scale) {
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

sp_status sp_tapped_run_smooth(const sp_tapped_spec *c, int64_t n, const double *t, sp_tapped_row row, void *user,
                               sp_tapped_report *report, sp_error *err) {
    smooth m = {.tolerance = c->tolerance};
    sp_status status = sp_tapped_springs_make(c, c->alpha_v, c->alpha_x > 0 ? c->alpha_x : INFINITY, &m.springs, err);
    if (status != SP_OK)
        return status;
    sp_tapped_marcher marcher = {.model = &m,
                                 .size = 2 * (int64_t)c->particles + 2,
                                 .phase = &m.springs.phase,
                                 .longest = longest,
                                 .step = step,
                                 .judge = judge,
                                 .particles = particles,
                                 .energy = energy,
                                 .stiff = "a large column.alpha_v (or a small column.tolerance)"};
    double *state = sp_alloc(2 * (size_t)marcher.size, sizeof *state);
    if (state) {
        m.scale = state + marcher.size;
        m.longest = 0.01 / sp_tapped_springs_frequency(&m.springs);
        scales(&m.springs, m.scale);
        sp_tapped_springs_start(c, &m.springs, state);
        status = sp_tapped_march(c, &marcher, state, &(sp_tapped_rows){n, t, row, user}, report, err);
        report->time_step = 0;
        report->error = c->tolerance;
    } else {
        status = sp_fail_memory(err, 2 * (size_t)marcher.size * sizeof *state);
    }
    sp_free(state);
    sp_tapped_springs_free(&m.springs);
    return status;
}
