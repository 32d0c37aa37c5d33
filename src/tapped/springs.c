/* Forces and energies of the lattice as an ordinary differential equation. */
#include "tapped/springs.h"

#include "base/base.h"

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
    const sp_tapped_springs *p = user;
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

sp_status sp_tapped_springs_make(const sp_tapped_spec *c, double alpha_v, double alpha_x, sp_tapped_springs *out,
                                 sp_error *err) {
    sp_tapped_springs made = {.n = c->particles,
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

void sp_tapped_springs_free(sp_tapped_springs *s) {
    sp_ode_free(&s->ode);
    sp_free(s->mass);
    *s = (sp_tapped_springs){0};
}

void sp_tapped_springs_start(const sp_tapped_spec *c, const sp_tapped_springs *s, double *state) {
    if (c->drop < 0) {
        sp_tapped_rest(c, state);
        return;
    }
    double height = c->drop;
    for (int32_t i = 0; i < s->n; i++)
        state[i] = height += s->distance[i];
}

void sp_tapped_springs_positions(const sp_tapped_springs *s, const double *state, double *y, double *v) {
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

double sp_tapped_springs_energy(const sp_tapped_springs *s, double floor, const double *state) {
    const double *y = state, *v = state + s->n;
    double sum = 0, below = floor;
    for (int32_t i = 0; i < s->n; i++) {
        sum += s->mass[i] * (0.5 * v[i] * v[i] + s->gravity * y[i]) +
               s->stiffness * stored(s->alpha_x, s->distance[i] - (y[i] - below));
        below = y[i];
    }
    return sum;
}

double sp_tapped_springs_frequency(const sp_tapped_springs *s) {
    double lightest = INFINITY;
    for (int32_t i = 0; i < s->n; i++)
        lightest = fmin(lightest, s->mass[i]);
    return 2 * sqrt(s->stiffness * (1 + s->e) / lightest);
}
