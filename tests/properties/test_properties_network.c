/* Random networks: what linear sound has to fulfil, whatever the packing. Bounds are the errors that the program
 * reports, or follow from the number of roundings. */
#include "network/bound.h"
#include "properties/exact_motion.h"
#include "properties/scenes.h"
#include "stress/exact.h"

#include <complex.h>
#include <float.h>
#include <sonopack/elastic.h>
#include <sonopack/modes.h>
#include <sonopack/sensitivity.h>
#include <sonopack/signal.h>
#include <sonopack/spectrum.h>
#include <sonopack/transport.h>

enum { GRAINS = 12, POINTS = 9, EXACT_MOST = 30 };

#ifndef SCENES
#define SCENES 200
#endif

/* ---- the stiffness ---------------------------------------------------------------------------------------------- */

static double *random_vector(sp_random *draw, size_t n) {
    double *v = calloc(n, sizeof *v);
    for (size_t k = 0; k < n; k++)
        v[k] = between(draw, -1, 1);
    return v;
}

static double dot(size_t n, const double *u, const double *v) {
    double sum = 0;
    for (size_t k = 0; k < n; k++)
        sum += u[k] * v[k];
    return sum;
}

/* |u| in the metric of the masses. */
static double weight(const sp_network *net, const double *u) {
    double sum = 0;
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        sum += net->mass[k] * u[k] * u[k];
    return sqrt(sum);
}

/* |u| |K| |v| is at most Omega^2 |u||v| in the metric of the masses, skew part included, since Omega comes from the
 * absolute values; every term is rounded as often as there are terms in a sum. */
static double rounding(const sp_network *net, const double *u, const double *v) {
    const double omega2 = net->omega_bound * net->omega_bound + net->skew;
    return (double)(sp_network_dofs(net) + net->n_springs + 40) * DBL_EPSILON * omega2 * weight(net, u) *
           weight(net, v);
}

static void check_stiffness(claims *c, const sp_network *net, sp_random *draw) {
    const size_t n = (size_t)sp_network_dofs(net);
    double *u = random_vector(draw, n), *v = random_vector(draw, n), *ku = calloc(2 * n, sizeof *ku), *kv = ku + n;
    sp_network_apply(net, u, ku);
    sp_network_apply_transposed(net, v, kv);
    claims_check(c, "v K u = u K^T v", fabs(dot(n, v, ku) - dot(n, u, kv)), rounding(net, u, v));
    claims_check(c, "u K u is the energy", fabs(dot(n, u, ku) - sp_network_energy2(net, u)), rounding(net, u, u));
    claims_check(c, "u K u <= Omega^2 u M u", sp_network_energy2(net, u),
                 pow(net->omega_bound * weight(net, u), 2) * (1 + 1e-13));
    sp_network loose = *net;
    loose.n_springs = net->n_bulk;
    sp_network_apply(&loose, u, ku);
    for (int a = 0; a < net->dim; a++) {
        double sum = 0, *one = v;
        for (size_t k = 0; k < n; k++)
            one[k] = k % (size_t)net->dof == (size_t)a;
        for (size_t k = 0; k < n; k++)
            sum += one[k] * ku[k];
        claims_check(c, "forces of grains sum to 0", fabs(sum), rounding(net, u, one));
    }
    free(ku);
    free(v);
    free(u);
}

/* ---- modes ------------------------------------------------------------------------------------------------------ */

static void check_frequencies(claims *c, const char *name, const sp_modes *m, const exact *x) {
    for (int k = 0; k < x->n; k++) {
        const double omega = (double)quad_sqrt(quad_abs(x->lambda[k]));
        claims_check(c, name, fabs(m->omega[m->n_rattler + k] - omega), m->error[m->n_rattler + k]);
    }
}

static void check_agree(claims *c, const char *name, const sp_modes *m, const sp_modes *d) {
    claims_true(c, "all solvers find as many modes", m->n == d->n);
    for (int64_t k = 0; k < m->n && m->n == d->n; k++)
        claims_check(c, name, fabs(m->omega[k] - d->omega[k]), m->error[k] + d->error[k]);
}

/* Sum of omega^2 is the trace, sum of omega^4 the squares of all entries of A. */
static void check_traces(claims *c, const sp_network *net, const sp_modes *m) {
    const int n = (int)sp_network_dofs(net);
    extended *a = motion_matrix(net), trace = 0, squares = 0, two = 0, four = 0, slack2 = 0, slack4 = 0;
    for (int k = 0; k < n; k++)
        trace += a[k * n + k];
    for (int k = 0; k < n * n; k++)
        squares += a[k] * a[k];
    for (int64_t k = m->n_rattler; k < m->n; k++) {
        const extended w = m->omega[k], e = m->error[k];
        two += w * w;
        four += w * w * w * w;
        slack2 += 2 * w * e + e * e;
        slack4 += 4 * w * w * w * e + 7 * w * w * e * e;
    }
    claims_check(c, "sum of omega^2 is the trace", (double)fabsl(two - trace), (double)(slack2 + 1e-17L * trace));
    claims_check(c, "sum of omega^4", (double)fabsl(four - squares), (double)(slack4 + 1e-17L * squares));
    free(a);
}

/* Whether there are modes: not in unstable networks. */
static bool check_modes(claims *c, const sp_network *net, const exact *x) {
    sp_modes_options o = sp_modes_options_default();
    FREED(sp_modes) dense = sp_modes_none();
    sp_zero_modes zero;
    sp_error why = {0};
    o.vectors = false;
    if (!claims_served(c, "modes, dense", sp_modes_dense(net, &o, &dense, &why), &why))
        return false;
    check_traces(c, net, &dense);
    claims_true(c, "no frequency below 0", dense.n == 0 || dense.omega[0] >= 0);
    if (x)
        check_frequencies(c, "frequencies, exact", &dense, x);
    for (int solver = SP_SOLVER_LANCZOS; solver <= SP_SOLVER_ARPACK; solver++) {
        const sp_modes_range all = sp_modes_range_all();
        FREED(sp_modes) m = sp_modes_none();
        o.solver = (sp_modes_solver)solver;
        o.vectors = solver == SP_SOLVER_LANCZOS;
        if (claims_served(c, "modes, sparse", sp_modes_sparse(net, &o, &all, &m, &why), &why))
            check_agree(c, "frequencies of two solvers", &m, &dense);
    }
    if (claims_served(c, "zero modes", sp_zero_modes_count(net, &zero, &why), &why)) {
        claims_true(c, "zero modes are counted", zero.total == dense.n_zero);
        int64_t exactly = zero.rattlers;
        for (int k = 0; x && k < x->n; k++)
            exactly += quad_abs(x->lambda[k]) < (quad)zero.below * zero.below;
        claims_true(c, "zero modes, exact", !x || exactly == zero.total);
    }
    return true;
}

/* Integrates to the number of modes. */
static void check_density(claims *c, const sp_network *net) {
    static const sp_dos_method methods[] = {SP_DOS_EXACT, SP_DOS_COUNT};
    for (int k = 0; k < 2; k++) {
        sp_dos_options o = sp_dos_options_default();
        FREED(sp_dos) d = sp_dos_none();
        sp_error why = {0};
        o.method = methods[k];
        o.norm = SP_DOS_MODES;
        o.bins = 7;
        if (claims_served(c, "density of states", sp_dos_make(net, &o, &d, &why), &why)) {
            const double modes = (double)(d.modes - (d.zero.total - d.zero.rattlers));
            claims_check(c, "density integrates to the modes", fabs(d.cumulative[6] - modes),
                         d.cumulative_error[6] + 1e-14 * (double)d.modes);
        }
    }
}

/* ---- signals ---------------------------------------------------------------------------------------------------- */

typedef struct ends {
    sp_place from, to;
    double *sent, *seen; /* [dofs] */
} ends;

/* A source and a detector that the network has, or false. */
static bool some_ends(claims *c, const sp_network *net, sp_random *draw, sp_source source, ends *e) {
    const size_t n = (size_t)sp_network_dofs(net);
    sp_error why = {0};
    e->sent = calloc(2 * n, sizeof *e->sent);
    e->seen = e->sent + n;
    for (int trial = 0; trial < 8; trial++) {
        e->from = scene_spot(net, draw);
        e->to = scene_spot(net, draw);
        if (claims_served(c, "source", sp_network_source_at(net, source, &e->from, e->sent, &why), &why) &&
            claims_served(c, "detector", sp_network_detector_at(net, &e->to, e->seen, &why), &why))
            return true;
    }
    free(e->sent);
    return false;
}

/* As signals have their times. */
static double time_of(const sp_signal_options *o, int k) {
    return k < o->points - 1 ? o->until * k / (o->points - 1) : o->until;
}

static void check_methods(claims *c, const sp_network *net, const ends *e, sp_signal_options o) {
    static const sp_signal_method methods[] = {SP_SIGNAL_CHEBYSHEV,    SP_SIGNAL_DENSE, SP_SIGNAL_VERLET,
                                               SP_SIGNAL_LAX_WENDROFF, SP_SIGNAL_FABER, SP_SIGNAL_SPARSE};
    FREED(sp_network) dashpots = sp_network_none();
    double *dash = NULL, exactly[POINTS], before = 0;
    sp_error why = {0};
    const size_t n = (size_t)sp_network_dofs(net);
    if (o.damping > 0) {
        const sp_damping law = sp_signal_damping(&o);
        dash = calloc(n, sizeof *dash);
        assert_ok(sp_network_dashpots(net, &law, &dashpots, &err));
        const sp_status status = sp_network_detector_at(&dashpots, &e->to, dash, &why);
        assert_int_equal(status, SP_OK);
    }
    motion m = motion_begin(net, dash ? &dashpots : NULL, e->sent, o.source != SP_SOURCE_DISPLACEMENT);
    for (int k = 0; k < POINTS; k++) {
        const double now = time_of(&o, k);
        motion_advance(&m, (extended)now - before);
        before = now;
        exactly[k] = (double)motion_seen(&m, net, e->seen, dash);
    }
    motion_end(&m);
    for (int k = 0; k < 6; k++) {
        FREED(sp_signal) s = sp_signal_none();
        o.method = methods[k];
        o.step = k == 2 || k == 3 ? 0.05 / net->omega_bound : 0; /* its bound is told, whatever the tolerance */
        if ((o.damping > 0 && o.method != SP_SIGNAL_FABER) ||
            !claims_served(c, sp_signal_method_name(o.method), sp_signal_make(net, &o, &s, &why), &why))
            continue;
        for (int q = 0; q < POINTS; q++)
            claims_check(c, sp_signal_method_name(o.method), s.t[q] == time_of(&o, q) ? fabs(s.f[q] - exactly[q]) : NAN,
                         s.errors[0]);
    }
    free(dash);
}

/* Nothing is seen before terms of the order of the distance in contacts: b A^j a = 0 up to there. */
static void check_causality(claims *c, const sp_network *net, const ends *e, const sp_signal_options *o,
                            const sp_signal *s) {
    const size_t n = (size_t)sp_network_dofs(net);
    extended *k = motion_matrix(net), *a = calloc(2 * n, sizeof *a), *b = a + n, one = 0, two = 0;
    const bool velocity = o->source != SP_SOURCE_DISPLACEMENT;
    int silent = 0;
    for (size_t q = 0; q < n; q++) {
        const extended root = sqrtl((extended)net->mass[q]);
        a[q] = velocity ? e->sent[q] / root : e->sent[q] * root;
        one += a[q] * a[q];
        two += e->seen[q] / root * (e->seen[q] / root);
    }
    for (bool seen = false; silent < 12; silent++) {
        for (size_t q = 0; q < n; q++)
            seen = seen || (a[q] != 0 && e->seen[q] != 0);
        if (seen)
            break;
        for (size_t q = 0; q < n; q++) {
            b[q] = 0;
            for (size_t r = 0; r < n; r++)
                b[q] += k[q * n + r] * a[r];
        }
        memcpy(a, b, n * sizeof *a);
    }
    for (int q = 0; q < s->n && silent > 0; q++) {
        const extended x = motion_norm((int)n, k) * s->t[q] * s->t[q];
        extended term = sqrtl(one * two) * (velocity ? s->t[q] : 1), bound = 0;
        for (int j = 0; j < 400; j++) {
            bound += j >= silent ? term : 0;
            term *= x / ((2 * j + 2 - !velocity) * (2 * j + 2 + velocity));
        }
        claims_check(c, "causality", fabs(s->f[q]), (double)bound + s->errors[0]);
    }
    free(a);
    free(k);
}

/* Sources and detectors add up: grain by grain to the whole walls. */
static void check_walls(claims *c, const sp_network *net, sp_signal_options o) {
    const int32_t n = net->n;
    RELEASED sp_place *grain = calloc((size_t)n + 1, sizeof *grain);
    FREED(sp_signal) all = sp_signal_none(), each = sp_signal_none();
    sp_error why = {0};
    int32_t count = 0;
    const sp_place wall = sp_place_wall();
    for (int32_t k = 0; k < net->n_springs; k++)
        if (net->springs[k].j == SP_BOTTOM)
            grain[count++] = (sp_place){.kind = SP_PLACE_GRAIN, .grain = net->grain[net->springs[k].i]};
    o.from = o.to = &wall;
    o.sources = o.detectors = 1;
    o.method = SP_SIGNAL_CHEBYSHEV;
    o.damping = 0;
    o.tolerance = 1e-10;
    if (count > 0 && claims_served(c, "walls", sp_signal_make(net, &o, &all, &why), &why)) {
        o.from = grain;
        o.sources = count;
        o.tolerance = 1e-6;
        if (claims_served(c, "walls by grains", sp_signal_make(net, &o, &each, &why), &why))
            for (int q = 0; q < all.n; q++) {
                double sum = 0, slack = all.errors[0];
                for (int32_t k = 0; k < count; k++) {
                    sum += each.f[k * all.n + q];
                    slack += each.errors[k];
                }
                claims_check(c, "superposition", fabs(sum - all.f[q]), slack * (1 + count * DBL_EPSILON));
            }
    }
}

/* Bound of the rate at which dashpots of the value 1 act. */
static double decay_of(const sp_network *net, sp_damping_kind kind, double ratio) {
    const sp_damping law = {.kind = kind, .value = 1, .ratio = ratio};
    FREED(sp_network) dashpots = sp_network_none();
    assert_ok(sp_network_dashpots(net, &law, &dashpots, &err));
    const double rate = pow(sp_network_omega_bound(&dashpots), 2);
    return rate;
}

static void check_signals(claims *c, const sp_network *net, sp_random *draw) {
    static const double lengths[] = {1, 3, 10, 30, 100, 300};
    sp_signal_options o = sp_signal_options_default();
    FREED(sp_signal) s = sp_signal_none();
    sp_error why = {0};
    ends e;
    o.source = (sp_source)whole(draw, 0, 2);
    o.until = one_of(draw, 6, lengths) / net->omega_bound;
    o.points = POINTS;
    if (chance(draw, 0.3) && !net->carried) {
        o.damping = pow(10, between(draw, -4, 0.5));
        o.damping_kind = (sp_damping_kind)whole(draw, 0, 2);
        o.damping_ratio = between(draw, 0, 2);
        if (o.damping_kind != SP_DAMPING_ZETA) /* fastest decay over the highest frequency */
            o.damping *= net->omega_bound / decay_of(net, o.damping_kind, o.damping_ratio);
    }
    check_walls(c, net, o);
    if (!some_ends(c, net, draw, o.source, &e))
        return;
    o.from = &e.from;
    o.to = &e.to;
    o.sources = o.detectors = 1;
    check_methods(c, net, &e, o);
    o.damping = 0;
    if (claims_served(c, "signal", sp_signal_make(net, &o, &s, &why), &why))
        check_causality(c, net, &e, &o, &s);
    free(e.sent);
}

/* ---- steady driving, and fields --------------------------------------------------------------------------------- */

/* F = (d + i omega c) . (K - omega^2 M + i omega C)^-1 p by elimination in extended precision; dash, c: NULL for none.
 */
static complex long double driven(const sp_network *net, const sp_network *dash, const double *det,
                                  const double *dot_det, const double *push, double omega) {
    const int n = (int)sp_network_dofs(net);
    RELEASED extended *k = motion_matrix(net), *c = dash ? motion_matrix(dash) : NULL;
    complex long double *a = calloc((size_t)(n * (n + 1)), sizeof *a), sum = 0;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++)
            a[i * (n + 1) + j] = k[i * n + j] + (c ? I * omega * c[i * n + j] : 0);
        a[i * (n + 1) + i] -= (extended)omega * omega;
        a[i * (n + 1) + n] = push[i] / sqrtl((extended)net->mass[i]);
    }
    for (int p = 0; p < n; p++) {
        int best = p;
        for (int i = p + 1; i < n; i++)
            best = cabsl(a[i * (n + 1) + p]) > cabsl(a[best * (n + 1) + p]) ? i : best;
        for (int j = p; j <= n && best != p; j++) {
            const complex long double kept = a[p * (n + 1) + j];
            a[p * (n + 1) + j] = a[best * (n + 1) + j];
            a[best * (n + 1) + j] = kept;
        }
        for (int i = 0; i < n; i++) {
            const complex long double part = i == p ? 0 : a[i * (n + 1) + p] / a[p * (n + 1) + p];
            for (int j = p; j <= n && part != 0; j++)
                a[i * (n + 1) + j] -= part * a[p * (n + 1) + j];
        }
    }
    for (int i = 0; i < n; i++)
        sum += (det[i] + (dot_det ? I * omega * dot_det[i] : 0)) / sqrtl((extended)net->mass[i]) * a[i * (n + 1) + n] /
               a[i * (n + 1) + i];
    free(a);
    return sum;
}

static void check_driven(claims *c, const sp_network *net, sp_random *draw) {
    const double omega[3] = {net->omega_bound * between(draw, 0.01, 0.2), net->omega_bound * between(draw, 0.2, 0.9),
                             net->omega_bound * between(draw, 1, 2)};
    sp_harmonic_options o = sp_harmonic_options_default();
    FREED(sp_harmonic) h = sp_harmonic_none();
    FREED(sp_network) dashpots = sp_network_none();
    RELEASED double *dash = NULL;
    sp_error why = {0};
    ends e;
    if (net->carried || !some_ends(c, net, draw, SP_SOURCE_IMPULSE, &e))
        return;
    o.from = e.from;
    o.to = e.to;
    o.n = 3;
    o.omega = omega;
    o.planes = 1;
    o.keep = true;
    if (chance(draw, 0.6)) {
        const sp_damping law = {SP_DAMPING_ZETA, o.damping = pow(10, between(draw, -3, 0)), 1};
        dash = calloc((size_t)sp_network_dofs(net), sizeof *dash);
        assert_ok(sp_network_dashpots(net, &law, &dashpots, &err));
        assert_ok(sp_network_detector_at(&dashpots, &e.to, dash, &err));
    }
    if (claims_served(c, "driven", sp_harmonic_make(net, &o, &h, &why), &why))
        for (int k = 0; k < 3; k++) {
            const complex long double f = driven(net, dash ? &dashpots : NULL, e.seen, dash, e.sent, omega[k]);
            if (!isnan(h.f[2 * k]))
                claims_check(c, "driven", (double)cabsl(h.f[2 * k] + I * h.f[2 * k + 1] - f), h.error[k]);
        }
    free(e.sent);
}

static void check_field(claims *c, const sp_network *net, sp_random *draw) {
    const size_t n = (size_t)sp_network_dofs(net);
    const double t = between(draw, 0.1, 60) / net->omega_bound;
    double *u = calloc(n, sizeof *u), error = 0, worst = 0;
    sp_error why = {0};
    ends e;
    const sp_source source = (sp_source)whole(draw, 0, 2);
    if (some_ends(c, net, draw, source, &e)) {
        const sp_field_options o = {.source = source, .from = &e.from, .times = 1, .t = &t, .threads = 1};
        if (claims_served(c, "field", sp_signal_field(net, &o, u, &error, &why), &why)) {
            motion m = motion_begin(net, NULL, e.sent, source != SP_SOURCE_DISPLACEMENT);
            motion_advance(&m, t);
            for (size_t k = 0; k < n; k++)
                worst = fmax(worst, (double)fabsl(u[k] - m.y[k] / sqrtl((extended)net->mass[k])));
            motion_end(&m);
            claims_check(c, "field", worst, error);
        }
        free(e.sent);
    }
    free(u);
}

/* ---- motion: there and back, and the energy --------------------------------------------------------------------- */

static void check_motion(claims *c, const sp_network *net, bool stable, sp_random *draw) {
    const size_t n = (size_t)sp_network_dofs(net);
    if (!stable) /* small errors grow, too */
        return;
    double *u = random_vector(draw, n), *v = random_vector(draw, n), *start = calloc(2 * n, sizeof *start), drift = 0;
    sp_error why = {0};
    memcpy(start, u, n * sizeof *u);
    memcpy(start + n, v, n * sizeof *v);
    const double t = between(draw, 0, 50) / net->omega_bound,
                 energy = sp_network_energy2(net, u) + pow(weight(net, v), 2);
    if (claims_served(c, "advance", sp_transport_advance(net, t, u, v, &drift, &why), &why)) {
        const double after = sp_network_energy2(net, u) + pow(weight(net, v), 2);
        claims_check(c, "energy of the motion", fabs(after - energy), (drift + 1e-14 * (double)n) * energy);
        for (size_t k = 0; k < n; k++)
            v[k] = -v[k];
        if (!claims_served(c, "advance", sp_transport_advance(net, t, u, v, NULL, &why), &why))
            goto out;
        for (size_t k = 0; k < n; k++) {
            u[k] -= start[k];
            v[k] += start[n + k];
        }
        claims_check(c, "time reversal", net->omega_bound * weight(net, u) + weight(net, v),
                     1e-12 * (net->omega_bound * weight(net, start) + weight(net, start + n)));
    }
out:
    free(start);
    free(v);
    free(u);
}

/* ---- moduli ----------------------------------------------------------------------------------------------------- */

/* Cholesky of C + its errors, for C >= 0: no pivot may be negative. */
static bool positive(const sp_elasticity *e) {
    double c[SP_STRAINS_MAX][SP_STRAINS_MAX], slack = 0;
    for (int a = 0; a < e->strains; a++)
        for (int b = 0; b < e->strains; b++) {
            if (isnan(e->c[a][b]))
                return true;
            c[a][b] = 0.5 * (e->c[a][b] + e->c[b][a]);
            slack += e->error[a][b] + 4 * DBL_EPSILON * fabs(e->c[a][b]);
        }
    for (int a = 0; a < e->strains; a++) {
        c[a][a] += slack;
        if (c[a][a] < 0)
            return false;
        for (int b = a + 1; b < e->strains; b++)
            for (int d = b; d < e->strains; d++)
                c[d][b] = c[b][d] -= c[a][a] > 0 ? c[a][b] * c[a][d] / c[a][a] : 0;
    }
    return true;
}

/* Voigt's bound: the strain of all grains without relaxation. */
static double affine(const sp_network *net, int strain) {
    static const int plane[3][2] = {{0, 0}, {1, 1}, {0, 1}},
                     space[6][2] = {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};
    const int *f = net->dim == 3 ? space[strain] : plane[strain];
    double sum = 0, volume = 1;
    for (int a = 0; a < net->dim; a++)
        volume *= net->box[a];
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        const double gap = net->length[k] * s->n[f[1]], along = gap * s->n[f[0]];
        sum += s->kn * along * along + fmax(s->kt, 0) * (gap * gap - along * along);
    }
    return sum / volume;
}

static void check_moduli(claims *c, const sp_network *net) {
    sp_elasticity e;
    sp_moduli m;
    sp_error why = {0};
    if (!claims_served(c, "moduli", sp_elasticity_make(net, NAN, &m, &e, &why), &why))
        return;
    for (int a = 0; a < e.strains; a++) {
        for (int b = 0; b < a && !net->carried; b++)
            if (!isnan(e.c[a][b]))
                claims_check(c, "moduli are symmetric", fabs(e.c[a][b] - e.c[b][a]), e.error[a][b] + e.error[b][a]);
        if (!isnan(e.c[a][a]) && !net->prestress)
            claims_check(c, "Voigt's bound", e.c[a][a] - affine(net, a), e.error[a][a] + 1e-14 * affine(net, a));
    }
    if (!net->prestress)
        claims_true(c, "moduli are positive", positive(&e));
}

/* ---- sensitivities ---------------------------------------------------------------------------------------------- */

static void check_homogeneity(claims *c, const sp_network *net, const sp_gradient *g) {
    double slack = 0;
    for (int32_t k = 0; k < net->n_springs; k++) {
        slack += fabs(net->springs[k].kn) * (g->kn.n ? g->kn.error[k] : 0);
        slack += fabs(net->springs[k].kt) * (g->kt.n ? g->kt.error[k] : 0);
    }
    if (!net->prestress) /* k_p is not among the parameters */
        claims_check(c, "Euler's theorem", fabs(g->homogeneity),
                     slack + fabs(g->error) * 3 + 1e-15 * (net->n_springs + 9) * g->homogeneity_size);
}

static void check_sensitivity(claims *c, const sp_network *net, sp_random *draw) {
    sp_sensitivity_options o = sp_sensitivity_options_default();
    const double t = between(draw, 0.1, 20) / net->omega_bound, w = 1;
    const sp_functional f = {.n = 1, .t = &t, .weight = &w};
    FREED(sp_gradient) g = sp_gradient_none();
    sp_error why = {0};
    ends e;
    o.source = (sp_source)whole(draw, 0, 2);
    if (!some_ends(c, net, draw, o.source, &e))
        return;
    o.from = &e.from;
    o.to = &e.to;
    if (claims_served(c, "sensitivity", sp_sensitivity_signal(net, &o, 1, &f, &g, &why), &why))
        check_homogeneity(c, net, &g);
    free(e.sent);
}

/* ---- scenes ----------------------------------------------------------------------------------------------------- */

/* Springs and masses that no packing has. */
static void disturb(sp_network *net, sp_random *draw) {
    static const double decades[] = {1, 3, 6};
    const double stiff = one_of(draw, 3, decades), heavy = one_of(draw, 3, decades);
    for (int32_t k = 0; k < net->n_springs; k++) {
        net->springs[k].kn *= pow(10, stiff * between(draw, -0.5, 0.5));
        net->springs[k].kt *= chance(draw, 0.2) ? 0 : pow(10, stiff * between(draw, -0.5, 0.5));
    }
    for (int32_t i = 0; i < net->n; i++) {
        const double factor = pow(10, heavy * between(draw, -0.5, 0.5));
        for (int d = 0; d < net->dof; d++)
            net->mass[i * net->dof + d] *= factor;
    }
    assert_ok(sp_network_find_bounds(net, &err));
}

static void run(claims *c, sp_random *draw) {
    scene s = scene_draw(draw, GRAINS);
    FREED(sp_network) net = sp_network_none();
    sp_error why = {0};
    c->words = s.words;
    if (sp_packing_check(&s.p, &why) == SP_OK &&
        claims_served(c, "network", sp_network_make(&s.p, &s.how, &net, &why), &why)) {
        if (chance(draw, 0.3) && !net.prestress)
            disturb(&net, draw);
        const bool small = sp_network_dofs(&net) <= EXACT_MOST && !net.carried && STRESS_QUAD;
        FREED(exact) x = {0};
        if (small)
            x = exact_solve(&net);
        check_stiffness(c, &net, draw);
        const bool stable = check_modes(c, &net, small ? &x : NULL);
        check_density(c, &net);
        check_signals(c, &net, draw);
        check_motion(c, &net, stable, draw);
        if (stable) {
            check_driven(c, &net, draw);
            check_field(c, &net, draw);
        }
        check_moduli(c, &net);
        check_sensitivity(c, &net, draw);
        if (!stable)
            check_field(c, &net, draw);
    }
    sp_packing_free(&s.p);
}

TEST(test_networks) {
    claims c = {0};
    claims_scenes(&c, SCENES, run);
    claims_close(&c);
}

/* Moduli of an unstable spin, the error nan of a signal that is 0, chebyshev where a free grain or the whole cell
 * drifts, dense where a zero mode is left out, time steps and faber where a motion grows, chebyshev with unequal
 * masses. */
TEST(test_known) {
    static const uint64_t known[] = {25, 115, 31, 80, 1148, 1418, 621, 1915, 612, 10362, 10527, 22311};
    claims c = {0};
    claims_known(&c, sizeof known / sizeof *known, known, run);
    claims_close(&c);
}

RUN_TESTS(NULL, NULL)
