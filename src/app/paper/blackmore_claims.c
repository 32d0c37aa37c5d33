/* Claims in words and theorems, tested by computation: integrability, long cycles, parameters, and long-term trends. */
#include "base/base.h"
#include "paper/blackmore.h"

#include <sonopack/chain.h>
#include <stdio.h>
#include <string.h>

static blackmore_row claim(const char *where, const char *unit, blackmore_relation relation, double paper, double ours,
                           double err) {
    return (blackmore_row){.item = BLACKMORE_CLAIMS,
                           .equation = where,
                           .unit = unit,
                           .relation = relation,
                           .paper = paper,
                           .ours = ours,
                           .err = err,
                           .claim = true};
}

/* ---- (22) ------------------------------------------------------------------------------------------------------- */

/* Without taps and dissipation (22) is a Hamiltonian system. If it were integrable, no exponent would be positive. */
static sp_status add_integrability(blackmore *p, sp_error *err) {
    static const int32_t particles[] = {1, 2, 3, 5};
    sp_status status = SP_OK;
    for (size_t k = 0; k < sizeof particles / sizeof *particles && status == SP_OK; k++) {
        sp_tapped_spec c = sp_blackmore_column(particles[k]);
        sp_tapped_exponent exponent;
        c.e = c.amplitude = 0;
        c.drop = 0.1;
        c.period = 0.2;
        c.stiffness = 100 * particles[k] * sp_tapped_mass(&c, 1) * c.gravity / sp_tapped_radius(&c, 1);
        c.taps = 1000;
        status = sp_tapped_lyapunov(&c, &exponent, err);
        if (status != SP_OK)
            return status;
        blackmore_row row =
            claim("(22), Sect. 2", "1/s", BLACKMORE_EQUAL, 0, exponent.lambda / c.period, exponent.error / c.period);
        row.precision = 0.01;
        sp_blackmore_note(
            &row,
            "completely integrable with e = a = 0: then no exponent is above 0. Dropped by 0.1 cm, K = 100 N m g/r, "
            "200 s%s; err: an estimate",
            exponent.violated ? ", (1) violated" : ", (1) holds");
        sp_blackmore_add(p, row, "Lyapunov exponent without taps and loss, N = %d", particles[k]);
    }
    sp_blackmore_say(
        p, BLACKMORE_CLAIMS,
        "A single elastic particle is integrable, as every system of one degree of freedom. Two and more are "
        "chaotic: their contacts open and close, and (22) is not integrable.");
    return status;
}

/* ---- (35), (37), (45) ------------------------------------------------------------------------------------------- */

static sp_status largest_growth(const sp_tapped_spec *c, sp_tapped_model model, double *growth, sp_error *err) {
    const double h = 2 * sp_tapped_radius(c, 1), shortest = blackmore_pi / 0.01;
    sp_status status = SP_OK;
    *growth = 0;
    for (double k = 0.01; k <= shortest && status == SP_OK; k *= 1.01) {
        sp_tapped_symbol at;
        status = sp_tapped_symbol_at(c, model, 1 / h, 1, k, &at, err);
        *growth = status == SP_OK ? fmax(*growth, at.growth) : *growth;
    }
    return status;
}

/* With e = 0, w = y_z obeys w_tt = (a w + b w^2 + d w^3/3)_zz + f w_zzzz. About a singularity w = alpha/phi with
 * alpha^2 = -6 f/d, an arbitrary function enters with phi^(r - 1) at each resonance r; here (r - 3)(r - 4)(f (r - 1)(r
 * - 2) + d alpha^2) = 0. Two equal resonances bring in a logarithm, so that the equation fails Painleve's test, which
 * integrable equations pass. (37) has the same d and f with the other sign. */
static void add_painleve(blackmore *p) {
    const sp_tapped_spec c = sp_blackmore_column(10);
    const double r = sp_tapped_radius(&c, 1), h = 2 * r, slope = 1 / h;
    const double minus = sp_blackmore_coefficients(r, slope).minus;
    const double unit = sp_tapped_stiffness(&c) * pow(h, 4) / sp_tapped_mass(&c, 1);
    const double f = unit * minus / 36, d = unit * 2 * r * slope, alpha2 = -6 * f / d,
                 root = sqrt(9 - 4 * (2 + d * alpha2 / f));
    const double resonance[] = {3, 4, 0.5 * (3 - root), 0.5 * (3 + root)};
    int equal = 0;
    for (int k = 0; k < 4; k++)
        for (int l = 0; l < k; l++)
            equal += fabs(resonance[k] - resonance[l]) < 1e-12;
    blackmore_row row = claim("Theorem 2", "", BLACKMORE_EQUAL, 0, equal, 0);
    sp_blackmore_note(
        &row,
        "(35) and (37) are integrable with e = 0. Painleve's test of w = y_z has the resonances %g, %g, %g, %g: an "
        "equal pair brings a logarithm, by which integrability fails",
        resonance[2], resonance[0], resonance[1], resonance[3]);
    sp_blackmore_add(p, row, "equal resonances of (35) and (37), e = 0");
}

static sp_status add_solitons(blackmore *p, sp_error *err) {
    static const struct {
        sp_tapped_model model;
        const char *name;
    } equation[] = {{SP_TAPPED_EQ35, "(35)"}, {SP_TAPPED_EQ37, "(37)"}};
    sp_tapped_spec c = sp_blackmore_column(10);
    sp_status status = SP_OK;
    c.e = 0;
    for (int k = 0; k < 2 && status == SP_OK; k++) {
        double growth;
        status = largest_growth(&c, equation[k].model, &growth, err);
        if (status != SP_OK)
            return status;
        blackmore_row row = claim("Sect. 6", "1/s", BLACKMORE_EQUAL, 0, growth, 0);
        sp_blackmore_note(
            &row,
            "solitons as persistent stable waves need a background that is stable. Largest growth of waves about y = "
            "z longer than two of the paper's cells, N = 10");
        sp_blackmore_add(p, row, "growth rate of %s, e = 0", equation[k].name);
    }
    sp_front half, whole;
    status = sp_chain_front(5000, SP_CHAIN_VELOCITY, &half, err);
    if (status == SP_OK)
        status = sp_chain_front(10000, SP_CHAIN_VELOCITY, &whole, err);
    if (status != SP_OK)
        return status;
    blackmore_row row =
        claim("Sect. 6", "", BLACKMORE_EQUAL, 0, log(half.amplitude / whole.amplitude) / log(2.0), 1e-9);
    row.precision = 0.01;
    sp_blackmore_note(
        &row,
        "solitons keep their height. Elastic contacts that stay closed are linear: a pulse spreads, its force falls "
        "as N^-gamma, gamma = 2/3; exact, 5000 to 10000 particles");
    sp_blackmore_add(p, row, "decay exponent gamma of a pulse, closed contacts, e = 0");
    return SP_OK;
}

/* With e = 0 the force of (45) depends on z alone, and (45) is u_t + u u_z = f(z): each point moves in the field f like
 * a particle. Where f falls with height, neighbours meet and the smooth solution ends. f is computed by Simpson's rule.
 */
static double field_of(const sp_tapped_spec *c, double z) {
    enum { CELLS = 64 };
    const double h = 2 * sp_tapped_radius(c, 1), b = 7 * h, width = 3 * h;
    double sum = 0;
    for (int k = 0; k <= CELLS; k++) {
        const double y = -h + 2 * h * k / CELLS, off = (z + y - b) / width;
        const double weight = k == 0 || k == CELLS ? 1 : k % 2 ? 4 : 2;
        sum += weight * exp(-0.5 * off * off) * (h - fabs(y));
    }
    const double integral = sum * 2 * h / CELLS / 3 / (b * sqrt(2 * blackmore_pi));
    return -c->gravity - sp_tapped_stiffness(c) / sp_tapped_mass(c, 1) * integral;
}

/* Time at which two points 1e-4 cm apart, at rest at z, meet; at most `until`. */
static double meeting(const sp_tapped_spec *c, double z, double until) {
    const double apart = 1e-4, step = 1e-4;
    double x[2] = {z, z + apart}, v[2] = {0, 0};
    for (double t = 0; t < until; t += step) {
        for (int k = 0; k < 2; k++) { /* leapfrog */
            const double half = v[k] + 0.5 * step * field_of(c, x[k]);
            x[k] += step * half;
            v[k] = half + 0.5 * step * field_of(c, x[k]);
        }
        if (x[1] <= x[0])
            return t + step;
    }
    return until;
}

static sp_status add_burgers(blackmore *p, sp_error *err) {
    sp_tapped_spec c = sp_blackmore_column(10);
    sp_tapped_report report = {0};
    c.e = 0;
    c.model = SP_TAPPED_BSR;
    c.bsr = SP_TAPPED_BSR_LITERAL;
    sp_status status = sp_tapped_run(&c, 0, NULL, NULL, NULL, &report, err);
    if (status != SP_OK)
        return status;
    blackmore_row row = claim("Sect. 7", "s", BLACKMORE_ABOVE, 4, report.violated_at, report.time_step);
    sp_blackmore_note(
        &row,
        "(45) describes the column over the taps of Fig. 1. When (1) is first violated, as printed, N = 10; err: the "
        "step");
    sp_tapped_report_free(&report);
    sp_blackmore_add(p, row, "(45) as printed, e = 0: order of the particles lost at");
    double first = 4;
    const double height = 2 * c.particles * sp_tapped_radius(&c, 1);
    for (double z = 0; z < height; z += 0.25)
        first = fmin(first, meeting(&c, z, first));
    row = claim("Sect. 6", "s", BLACKMORE_ABOVE, 4, first, 1e-3);
    sp_blackmore_note(
        &row, "persistent waves, over four taps. With e = 0 the force of (45) is one of z alone, points of the column "
              "move in "
              "it freely, and meet: no smooth solution beyond, whatever Theorem 3 says of before. 80 points");
    sp_blackmore_add(p, row, "(45), e = 0: smooth solution ends at");
    return SP_OK;
}

/* ---- Theorem 1 -------------------------------------------------------------------------------------------------- */

enum { LONGEST = 12, STARTS = 60, ROUNDS = 40 };

/* Newton's method for a fixed point of `period` taps, N = 1. Returns the final residual, or INFINITY after a failure.
 */
static double newton(const sp_tapped_spec *c, int32_t period, double x[2]) {
    double residual = INFINITY;
    sp_error err;
    for (int round = 0; round < ROUNDS; round++) {
        double overlap = x[0], opening = x[1], d[4];
        sp_tapped_state s = {&overlap, &opening};
        if (sp_tapped_map(c, &s, period, d, &err) != SP_OK || !isfinite(overlap) || !isfinite(opening))
            return INFINITY;
        const double r0 = overlap - x[0], r1 = opening - x[1], a = d[0] - 1, b = d[1], e = d[2], f = d[3] - 1,
                     det = a * f - b * e;
        residual = fabs(r0) + fabs(r1);
        if (residual < 1e-9 || !isfinite(det) || !(fabs(det) > 0))
            break;
        x[0] -= (f * r0 - b * r1) / det;
        x[1] -= (a * r1 - e * r0) / det;
        if (!(fabs(x[0]) < 1e3 && fabs(x[1]) < 1e4))
            return INFINITY;
    }
    return residual;
}

/* Whether the orbit returns to x after fewer than `period` taps. */
static bool is_shorter(const sp_tapped_spec *c, int32_t period, const double x[2]) {
    double overlap = x[0], opening = x[1];
    sp_tapped_state s = {&overlap, &opening};
    sp_error err;
    for (int32_t k = 1; k < period; k++) {
        if (sp_tapped_map(c, &s, 1, NULL, &err) != SP_OK)
            return true;
        if (period % k == 0 && fabs(overlap - x[0]) + fabs(opening - x[1]) < 1e-6)
            return true;
    }
    return false;
}

static sp_status find_cycles(const sp_tapped_spec *c, bool found[LONGEST + 1], sp_error *err) {
    sp_tapped_state orbit;
    sp_status status = sp_tapped_state_make(c, &orbit, err);
    if (status != SP_OK)
        return status;
    status = sp_tapped_map(c, &orbit, 200, NULL, err);
    for (int k = 0; k < STARTS && status == SP_OK; k++) {
        status = sp_tapped_map(c, &orbit, 1, NULL, err);
        for (int32_t period = 1; period <= LONGEST && status == SP_OK; period++) {
            double x[2] = {orbit.overlap[0], orbit.opening[0]};
            if (!found[period] && newton(c, period, x) < 1e-9)
                found[period] = !is_shorter(c, period, x);
        }
    }
    sp_tapped_state_free(&orbit);
    return status;
}

static sp_status add_periods(blackmore *p, sp_error *err) {
    sp_tapped_spec c = sp_blackmore_column(1);
    bool found[LONGEST + 1] = {false};
    c.stiffness = 100 * sp_tapped_mass(&c, 1) * c.gravity / sp_tapped_radius(&c, 1);
    c.amplitude = 0.584; /* chaotic, see the item chaos */
    sp_status status = find_cycles(&c, found, err);
    if (status != SP_OK)
        return status;
    int32_t longest = 0;
    char list[64] = "";
    for (int32_t k = 1; k <= LONGEST; k++)
        if (found[k]) {
            longest = k;
            snprintf(list + strlen(list), sizeof list - strlen(list), "%s%d", *list ? ", " : "", k);
        }
    blackmore_row row = claim("Theorem 1", "taps", BLACKMORE_ABOVE, 8, longest, 0);
    sp_blackmore_note(
        &row,
        "periodic solutions of arbitrarily large period for large a: cycles of %s taps, by Newton's method to 1e-9, of "
        "%d tried; a = 0.584 cm, K = 100 m g/r. Evidence, no proof",
        list, LONGEST);
    sp_blackmore_add(p, row, "longest cycle found, N = 1");
    return SP_OK;
}

/* ---- Section 2 -------------------------------------------------------------------------------------------------- */

/* The paper's choice N >= 20, T = 1, pi/omega < 1/10, a <= 1/50, r < 1/100, m < 1/20, read in m, kg and s; these are
 * values at its edge. */
static sp_status add_choice(blackmore *p, double amplitude, double frequency, sp_error *err) {
    static const double mass = 40, radius = 0.9;
    sp_tapped_spec c = sp_blackmore_column(20);
    sp_tapped_report report = {0};
    c.mass = &mass;
    c.radius = &radius;
    c.masses = c.radii = 1;
    c.amplitude = amplitude;
    c.frequency = frequency;
    c.taps = 10;
    sp_status status = sp_tapped_run(&c, 0, NULL, NULL, NULL, &report, err);
    if (status != SP_OK)
        return status;
    double rest = 0;
    for (int32_t k = 0; k < report.taps; k++)
        rest = isfinite(report.tap[k].rest) ? fmax(rest, report.tap[k].rest) : INFINITY;
    blackmore_row row = claim("Sect. 2", "cm", BLACKMORE_ABOVE, 0, sp_blackmore_separation(&report), 1e-6);
    sp_tapped_report_free(&report);
    sp_blackmore_note(
        &row, "good choices, read in m, kg, s: (1) must hold. N = 20, r = 0.9 cm, m = 40 g, T = 1 s, K = 2 N m g/r; "
              "smallest separation in ten taps");
    sp_blackmore_add(p, row, "good choice a = %g cm, f = %g Hz: separation", amplitude, frequency);
    row = claim("Sect. 2", "s", BLACKMORE_BELOW, 0.99, rest, 1e-9);
    sp_blackmore_note(&row,
                      "at .99T the particles have settled: the latest time of rest after a tap, the same ten taps");
    sp_blackmore_add(p, row, "good choice a = %g cm, f = %g Hz: rest", amplitude, frequency);
    return SP_OK;
}

/* Densities at .99T of many taps. */
enum { TAPS = 200 };

typedef struct densities {
    const sp_tapped_spec *c;
    int n;
    double rho[TAPS];
} densities;

static sp_status keep_density(double t, const double *y, const double *v, void *user, sp_error *err) {
    (void)t, (void)v, (void)err;
    densities *d = user;
    d->rho[d->n++] = sp_tapped_density(d->c, y);
    return SP_OK;
}

static sp_status add_trend(blackmore *p, int32_t particles, sp_error *err) {
    sp_tapped_spec c = sp_blackmore_column(particles);
    c.taps = TAPS;
    densities d = {.c = &c};
    double t[TAPS], y[11] = {0};
    for (int k = 0; k < TAPS; k++)
        t[k] = (k + 0.99) * c.period;
    sp_status status = sp_tapped_run(&c, TAPS, t, keep_density, &d, NULL, err);
    if (status != SP_OK)
        return status;
    sp_tapped_rest(&c, y + 1);
    const double before = sp_tapped_density(&c, y), late = d.rho[TAPS - 1];
    blackmore_row row = claim("Sects. 2, 8", "g/cm", BLACKMORE_ABOVE, 0, late - before, 1e-9);
    sp_blackmore_note(
        &row,
        "trends after many taps; tapping increases the bulk density. Settings of Fig. 1, density at .99T of tap %d "
        "less that before the first",
        TAPS);
    sp_blackmore_add(p, row, "change of density over %d taps, N = %d", TAPS, particles);
    row = claim("Sect. 2", "g/cm", BLACKMORE_EQUAL, NAN, late - d.rho[TAPS / 4 - 1], 1e-9);
    sp_blackmore_note(&row, "there is no long trend: the column has come to a cycle of one tap long before");
    sp_blackmore_add(p, row, "change of density from tap %d to %d, N = %d", TAPS / 4, TAPS, particles);
    return SP_OK;
}

/* ---- Section 4 -------------------------------------------------------------------------------------------------- */

/* A grid for the ten particles of Fig. 1, 20 cm high. */
typedef struct grid {
    int cells;
    double dz, dt;
    int64_t steps;
} grid;

/* Heights of the top of the lattice, above which the force of (37) is zero. */
typedef struct top {
    int64_t n;
    double *height;
} top;

static sp_status keep_top(double t, const double *y, const double *v, void *user, sp_error *err) {
    (void)t, (void)v, (void)err;
    top *s = user;
    s->height[s->n++] = y[10] + 1;
    return SP_OK;
}

/* Right-hand side of (37) with (38), by central differences at node j; v: velocities. */
static double rate(const sp_tapped_spec *c, double dz, const double *y, const double *v, int j) {
    const double r = sp_tapped_radius(c, 1), h = 2 * r, alpha = 1 / h, e = c->e;
    const blackmore_coefficients a = sp_blackmore_coefficients(r, alpha);
    const double z = (y[j + 1] - y[j - 1]) / (2 * dz), zz = (y[j + 1] - 2 * y[j] + y[j - 1]) / (dz * dz),
                 zzzz = (y[j + 2] - 4 * y[j + 1] + 6 * y[j] - 4 * y[j - 1] + y[j - 2]) / pow(dz, 4),
                 tz = (v[j + 1] - v[j - 1]) / (2 * dz), tzz = (v[j + 1] - 2 * v[j] + v[j - 1]) / (dz * dz);
    const double bracket =
        a.plus * zz / 3 - h / 3 * (a.b * z + e * alpha * a.plus * tz) * zz +
        h * h *
            (a.minus * zzzz / 36 + alpha * (2 * r * z * z * zz + e * a.b * z * zz * tz + e * a.plus * zz * tzz / 6));
    return -c->gravity - sp_blackmore_speed2(c) * bracket;
}

/* Integrates from (39) on. Returns the time at which a point is farther away than 1e3 cm, or the end. memory: [4][cells
 * + 1]. */
static double integrate(const sp_tapped_spec *c, const grid *g, const double *height, double *memory) {
    const int n = g->cells;
    double *y = memory, *old = y + n + 1, *v = old + n + 1, *next = v + n + 1;
    for (int j = 0; j <= n; j++) {
        y[j] = old[j] = g->dz * j;
        v[j] = 0;
    }
    for (int64_t k = 0; k < g->steps; k++) {
        const double t = (double)(k + 1) * g->dt;
        for (int j = 2; j <= n; j++) {
            const bool inside = j <= n - 2 && g->dz * j < height[k];
            next[j] = 2 * y[j] - old[j] + g->dt * g->dt * (inside ? rate(c, g->dz, y, v, j) : -c->gravity);
        }
        next[0] = sp_tapped_floor(c, t);
        next[1] = next[0] + g->dz; /* no gravity at the floor, which moves this node */
        for (int j = 0; j <= n; j++) {
            if (!(fabs(next[j]) < 1e3))
                return t;
            v[j] = (next[j] - y[j]) / g->dt;
            old[j] = y[j];
            y[j] = next[j];
        }
    }
    return (double)g->steps * g->dt;
}

/* Finds the time at which the scheme with dissipation e in (37) breaks down. */
static sp_status breakdown(const grid *g, double e, double *time, sp_error *err) {
    const sp_tapped_spec lattice = sp_blackmore_column(10);
    sp_tapped_spec c = lattice;
    const size_t size = 2 * (size_t)g->steps + 4 * (size_t)(g->cells + 1);
    double *t = sp_alloc(size, sizeof *t);
    if (!t)
        return sp_fail_memory(err, size * sizeof *t);
    top tops = {.height = t + g->steps};
    c.e = e;
    for (int64_t k = 0; k < g->steps; k++)
        t[k] = (double)k * g->dt;
    sp_status status = sp_tapped_run(&lattice, g->steps, t, keep_top, &tops, NULL, err);
    if (status == SP_OK)
        *time = integrate(&c, g, tops.height, t + 2 * g->steps);
    sp_free(t);
    return status;
}

static void add_hybrid(blackmore *p, double time, double error, const char *quantity, const char *why) {
    blackmore_row row = claim("Sect. 4", "s", BLACKMORE_ABOVE, 4, time, error);
    sp_blackmore_note(
        &row,
        "(37) from (39) on by central differences, its top that of the lattice, N = 10, over four taps: when a point "
        "is farther than 10 m away. %s",
        why);
    sp_blackmore_add(p, row, "%s", quantity);
}

/* Adds the breakdown with the paper's steps, and with stable steps. In the latter case the time does not depend on the
 * grid, so it is the equation that breaks down. (With dissipation it does so earlier on finer grids.) */
static sp_status add_hybrids(blackmore *p, sp_error *err) {
    const grid printed = {2000, 0.01, 0.01, 400}, coarse = {100, 0.2, 1e-5, 2000}, fine = {200, 0.1, 1e-5, 2000};
    double at_printed, at_coarse, at_fine;
    sp_status status = breakdown(&printed, sp_blackmore_column(10).e, &at_printed, err);
    if (status == SP_OK)
        status = breakdown(&coarse, 0, &at_coarse, err);
    if (status == SP_OK)
        status = breakdown(&fine, 0, &at_fine, err);
    if (status != SP_OK)
        return status;
    add_hybrid(p, at_printed, printed.dt, "hybrid scheme, the paper's steps: breaks down at",
               "0.01 s and 0.01 cm, e = 0.09; err: a step");
    add_hybrid(p, at_fine, fabs(at_fine - at_coarse) + fine.dt, "hybrid scheme, stable steps, e = 0: breaks down at",
               "1e-5 s and 0.1 cm; err: a step, and the difference from 0.2 cm");
    return SP_OK;
}

/* ---- all of them ------------------------------------------------------------------------------------------------ */

sp_status sp_blackmore_make_claims(blackmore *p, sp_error *err) {
    static const double frequency[] = {5.5, 7.5, 10};
    sp_status status = add_integrability(p, err);
    add_painleve(p);
    if (status == SP_OK)
        status = add_solitons(p, err);
    if (status == SP_OK)
        status = add_burgers(p, err);
    if (status == SP_OK)
        status = sp_blackmore_progress(p, 0.5, err);
    if (status == SP_OK)
        status = add_periods(p, err);
    for (size_t k = 0; k < sizeof frequency / sizeof *frequency && status == SP_OK; k++)
        status = add_choice(p, 2, frequency[k], err);
    if (status == SP_OK)
        status = add_choice(p, 1, 7.5, err);
    for (int32_t n = 5; n <= 10 && status == SP_OK; n += 5)
        status = add_trend(p, n, err);
    if (status == SP_OK)
        status = add_hybrids(p, err);
    return status;
}
