/* The long-wave limit of the lattice in a well-posed form. With the label z of a particle in [0, 2 N r] and h = 2 r,
 *
 *     (1 - (h^2/12) d_zz) y_tt = -g - (h/m) d_z F,   F = K (1 - e tanh(alpha_v h y_tz)) h (1 - y_z)_+.
 *
 * The dispersion of the lattice, to the order in k h that (35) and (37) aim at, appears in the inertia. Hence omega^2 =
 * c^2 k^2/(1 + h^2 k^2/12) with c^2 = K h^2/m is positive for all k and never above 12 K/m.
 *
 * Space is discretised by linear elements. The inertia is the lumped mass m/h per length plus m h/12 times the
 * stiffness matrix of the elements: tridiagonal, constant, and factored once. The free top needs no condition other
 * than zero force. The floor pushes with
 *
 *     F(0) = 2 K (1 - e tanh(alpha_v (y_t(0) - y0'))) (y0 - y(0))_+,
 *
 * half a contact, in series with half a cell of the continuum. Time is integrated by the classical Runge-Kutta scheme,
 * which is stable for
 *
 *     dt <= min(sqrt(8/((6 + 2 sqrt(21)) (1 + e) K/m)), 2.5 m/(12 K e alpha_v delta)),
 *
 * where delta is the largest overlap, h (1 - y_z) or 2 (y0 - y(0)). The stability limits of the scheme are 2 sqrt(2) on
 * the imaginary axis and 2.785 on the real axis. The factor 6 + 2 sqrt(21) is the maximum of (4 x + x^2)/(1 + x^2/12),
 * for modes y = exp(-x z/h) next to the floor, whose spring raises it above the 12 of the bulk. (The bound
 * 0.8/sqrt(K/m) of the bulk is unstable from 8 cells per particle on.) The damping of these modes has the factor 6 + 4
 * sqrt(3), which the constant 2.5 allows for.
 *
 * The profile at rest, (27), is the parabola y = z - (M/h)(N z - z^2/2h) - N M/2 with M = m g/K. Its slope at the
 * middle of an element equals its difference quotient, so that the elements are at rest in it, too. At the particles'
 * labels it lies M/8 above the lattice. */
#include "base/base.h"
#include "numeric/ode.h"
#include "tapped/integrate.h"

typedef struct longwave {
    int32_t particles, cells;
    int64_t nodes;
    double stiffness, e, gravity, alpha, h, dz, mass;
    double time_step;       /* as given, or short enough to resolve the waves */
    double *factor, *pivot; /* factorisation of the inertia matrix */
    double off_diagonal;    /* off-diagonal element of the inertia matrix */
    sp_tapped_phase phase;
    sp_ode ode;
} longwave;

static double lumped(const longwave *p, int64_t j) {
    return p->mass / p->h * p->dz * (j == 0 || j == p->nodes - 1 ? 0.5 : 1);
}

static sp_status make_inertia(longwave *p, sp_error *err) {
    const size_t n = (size_t)p->nodes;
    p->factor = sp_alloc(2 * n, sizeof *p->factor);
    if (!p->factor)
        return sp_fail_memory(err, 2 * n * sizeof *p->factor);
    p->pivot = p->factor + n;
    const double link = p->mass * p->h / (12 * p->dz);
    p->off_diagonal = -link;
    for (int64_t j = 0; j < p->nodes; j++) {
        double diagonal = lumped(p, j) + link * (j == 0 || j == p->nodes - 1 ? 1 : 2);
        p->pivot[j] = 1 / (diagonal - (j > 0 ? p->off_diagonal * p->factor[j - 1] : 0));
        p->factor[j] = p->off_diagonal * p->pivot[j];
    }
    return SP_OK;
}

/* Solves for the accelerations, in place of the forces on the nodes. */
static void solve_inertia(const longwave *p, double *f) {
    f[0] *= p->pivot[0];
    for (int64_t j = 1; j < p->nodes; j++)
        f[j] = (f[j] - p->off_diagonal * f[j - 1]) * p->pivot[j];
    for (int64_t j = p->nodes - 2; j >= 0; j--)
        f[j] -= p->factor[j] * f[j + 1];
}

static void slope(double s, const double *state, double *out, void *user) {
    const longwave *p = user;
    const int64_t n = p->nodes;
    const double *y = state, *v = state + n, per = 1 / p->dz;
    double *f = out + n, *energies = out + 2 * n;
    const double velocity = sp_tapped_phase_velocity(&p->phase, s), w0 = v[0] - velocity;
    double below = 2 * p->stiffness * fmax(0, sp_tapped_phase_floor(&p->phase, s) - y[0]);
    double lost = below * p->e * tanh(p->alpha * w0);
    below -= lost;
    energies[0] = below * velocity;
    energies[1] = lost * w0;
    for (int64_t j = 0; j < n; j++) {
        double above = 0;
        out[j] = v[j];
        if (j < n - 1) {
            double delta = p->h * (1 - (y[j + 1] - y[j]) * per);
            if (delta > 0) {
                double w = p->h * (v[j + 1] - v[j]) * per;
                above = p->stiffness * delta;
                lost = above * p->e * tanh(p->alpha * w);
                above -= lost;
                energies[1] += lost * w * p->dz / p->h;
            }
        }
        f[j] = below - above - lumped(p, j) * p->gravity;
        below = above;
    }
    solve_inertia(p, f);
}

static double elastic_bound(const longwave *p) {
    return sqrt(8 * p->mass / ((6 + 2 * sqrt(21)) * (1 + p->e) * p->stiffness));
}

static double stable_step(const longwave *p, double overlap) {
    double rate = 12 * p->stiffness * p->e * p->alpha * overlap / p->mass;
    return fmin(elastic_bound(p), rate > 0 ? 2.5 / rate : INFINITY);
}

/* Longest t for which the damping is stable while the overlap grows to delta + w t: b (delta + w t) t = 2.5. Delta
 * is increased by a tenth for changes that w does not predict. */
static double damped_step(double b, double delta, double w) {
    double now = b * (delta > 0 ? 1.1 * delta : delta);
    double denominator = w > 0 ? now + sqrt(now * now + 10 * b * w) : 2 * now;
    return denominator > 0 ? 5 / denominator : INFINITY;
}

static double max_step(void *model, double s, const double *state) {
    const longwave *p = model;
    const double *y = state, *v = state + p->nodes, per = p->h / p->dz;
    const double b = 12 * p->stiffness * p->e * p->alpha / p->mass;
    double least = damped_step(b, 2 * (sp_tapped_phase_floor(&p->phase, s) - y[0]),
                               2 * (sp_tapped_phase_velocity(&p->phase, s) - v[0]));
    for (int64_t j = 0; j + 1 < p->nodes; j++)
        least = fmin(least, damped_step(b, p->h - per * (y[j + 1] - y[j]), per * (v[j] - v[j + 1])));
    return fmin(least, fmin(p->time_step, elastic_bound(p)));
}

static double step(void *model, double s, double h, const double *from, double *to) {
    sp_ode_step4(&((longwave *)model)->ode, s, h, from, to);
    return 0;
}

/* Value half way between nodes j and j + 1: their mean less an eighth of the second difference, averaged over the inner
 * nodes of the two. The parabola at rest is reproduced exactly. */
static double half_way(const longwave *p, const double *y, int64_t j) {
    double sum = 0, count = 0;
    for (int64_t i = j; i <= j + 1; i++)
        if (i > 0 && i < p->nodes - 1) {
            sum += y[i - 1] - 2 * y[i] + y[i + 1];
            count++;
        }
    return 0.5 * (y[j] + y[j + 1]) - (count > 0 ? sum / (8 * count) : 0);
}

/* The labels (2 i - 1) r lie on nodes or half way between two. */
static void positions(void *model, const double *state, double *y, double *v) {
    const longwave *p = model;
    for (int32_t i = 1; i <= p->particles; i++) {
        int64_t twice = (2 * (int64_t)i - 1) * p->cells, j = twice / 2;
        y[i] = twice % 2 ? half_way(p, state, j) : state[j];
        v[i] = twice % 2 ? half_way(p, state + p->nodes, j) : state[p->nodes + j];
    }
}

static double energy(void *model, double floor, const double *state) {
    const longwave *p = model;
    const double *y = state, *v = state + p->nodes, touching = fmax(0, floor - y[0]);
    double sum = p->stiffness * touching * touching;
    for (int64_t j = 0; j < p->nodes; j++) {
        sum += lumped(p, j) * (0.5 * v[j] * v[j] + p->gravity * y[j]);
        if (j + 1 < p->nodes) {
            double delta = fmax(0, p->h * (1 - (y[j + 1] - y[j]) / p->dz)), w = v[j + 1] - v[j];
            sum += 0.5 * p->stiffness * delta * delta * p->dz / p->h - 0.5 * p->off_diagonal * w * w;
        }
    }
    return sum;
}

static void start(const sp_tapped_spec *c, const longwave *p, double *state) {
    const double unit = p->mass * p->gravity / p->stiffness, number = p->particles;
    for (int64_t j = 0; j < p->nodes; j++) {
        double label = (double)j / p->cells; /* z/h */
        state[j] = p->h * label;
        if (c->drop < 0)
            state[j] -= unit * (number * label - 0.5 * label * label + 0.5 * number);
        else
            state[j] += c->drop;
    }
}

static sp_status check(const sp_tapped_spec *c, sp_error *err) {
    for (int32_t i = 2; i <= c->particles; i++)
        if (sp_tapped_mass(c, i) != sp_tapped_mass(c, 1) || sp_tapped_radius(c, i) != sp_tapped_radius(c, 1))
            return sp_fail_key(err, SP_EINVAL, "column.model",
                               " = \"longwave\": particle %d differs from particle 1 in mass or radius; the "
                               "long-wave expansion requires equal particles",
                               i);
    return SP_OK;
}

/* Estimates the largest overlap of the run: the one at rest at the bottom, plus the wave v/sqrt(K/m) that starts with
 * the floor's first velocity or the velocity of the fall. A given time step must be stable there; the steps then
 * adapt to the state. */
static sp_status choose_time_step(const sp_tapped_spec *c, longwave *p, sp_error *err) {
    double speed = c->drop < 0 ? 2 * M_PI * c->frequency * c->amplitude : sqrt(2 * c->gravity * c->drop);
    double overlap = speed / sqrt(p->stiffness / p->mass);
    if (c->drop < 0)
        overlap += p->particles * p->mass * p->gravity / p->stiffness;
    double bound = stable_step(p, overlap);
    if (c->time_step > bound * (1 + 1e-9))
        return sp_fail_key(
            err, SP_EINVAL, "column.time_step",
            " = %.17g s: the long wave is stable up to %.6g s, the smaller of %.3g s, for its elastic waves, and 2.5 "
            "m/(12 K e alpha_v delta), for their damping at an overlap delta = %.3g cm; 0 chooses a stable one",
            c->time_step, bound, elastic_bound(p), overlap);
    p->time_step = c->time_step > 0 ? c->time_step : 0.05 / sqrt(p->stiffness / p->mass);
    return SP_OK;
}

sp_status sp_tapped_run_longwave(const sp_tapped_spec *c, const sp_tapped_rows *rows, sp_tapped_report *report,
                                 sp_error *err) {
    longwave p = {.particles = c->particles,
                  .cells = c->cells,
                  .nodes = (int64_t)c->particles * c->cells + 1,
                  .stiffness = sp_tapped_stiffness(c),
                  .e = c->e,
                  .gravity = c->gravity,
                  .alpha = c->alpha_v,
                  .h = 2 * sp_tapped_radius(c, 1),
                  .mass = sp_tapped_mass(c, 1)};
    p.dz = p.h / c->cells;
    sp_tapped_stepper m = {.model = &p,
                           .size = 2 * p.nodes + 2,
                           .phase = &p.phase,
                           .max_step = max_step,
                           .step = step,
                           .positions = positions,
                           .energy = energy,
                           .cause = "a large column.alpha_v (or a small column.time_step)"};
    double *state = NULL;
    sp_status status = check(c, err);
    if (status == SP_OK)
        status = choose_time_step(c, &p, err);
    if (status == SP_OK)
        status = make_inertia(&p, err);
    if (status == SP_OK)
        status = sp_ode_make(m.size, slope, &p, &p.ode, err);
    if (status == SP_OK && !(state = sp_alloc((size_t)m.size, sizeof *state)))
        status = sp_fail_memory(err, (size_t)m.size * sizeof *state);
    if (status == SP_OK) {
        start(c, &p, state);
        status = sp_tapped_integrate(c, &m, state, rows, report, err);
        report->error = NAN; /* no bound is known */
    }
    sp_free(state);
    sp_ode_free(&p.ode);
    sp_free(p.factor);
    return status;
}
