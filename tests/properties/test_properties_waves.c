/* Random networks of more degrees of freedom, with several sources and detectors: signals against the motion in
 * extended precision, chains against Sturm's count, derivatives against differences, spectra of mirrored packings. */
#include "network/bound.h"
#include "properties/changes.h"
#include "properties/exact_motion.h"
#include "properties/scenes.h"

#include <float.h>
#include <sonopack/modes.h>
#include <sonopack/sensitivity.h>
#include <sonopack/signal.h>
#include <sonopack/spectrum.h>

enum { POINTS = 5, PLACES = 4 };

#ifndef SCENES
#define SCENES 40
#endif

/* ---- signals ---------------------------------------------------------------------------------------------------- */

/* Places that the network has: as many as asked for, or fewer. */
static int some_spots(claims *c, const sp_network *net, sp_random *draw, bool source, int count, sp_place *out,
                      double *vectors) {
    sp_error why = {0};
    int n = 0;
    for (int trial = 0; trial < 4 * count && n < count; trial++) {
        out[n] = scene_spot(net, draw);
        double *v = vectors + n * sp_network_dofs(net);
        const sp_status status = source ? sp_network_source_at(net, SP_SOURCE_IMPULSE, &out[n], v, &why)
                                        : sp_network_detector_at(net, &out[n], v, &why);
        n += claims_served(c, "a place", status, &why);
    }
    return n;
}

static void check_pairs(claims *c, const sp_network *net, const sp_signal_options *o, const sp_signal *s,
                        const double *sent, const double *seen, const char *name) {
    const int64_t n = sp_network_dofs(net);
    for (int a = 0; a < o->sources; a++) {
        motion m = motion_begin(net, NULL, sent + a * n, true);
        for (int q = 0; q < s->n; q++) {
            motion_advance(&m, (extended)s->t[q] - (q ? s->t[q - 1] : 0));
            for (int b = 0; b < o->detectors; b++) {
                const double exactly = (double)motion_seen(&m, net, seen + b * n, NULL);
                claims_check(c, name, fabs(s->f[(a * o->detectors + b) * s->n + q] - exactly),
                             s->errors[a * o->detectors + b]);
            }
        }
        motion_end(&m);
    }
}

static void check_signals(claims *c, const sp_network *net, sp_random *draw) {
    static const double lengths[] = {3, 10, 30, 100, 200};
    static const sp_signal_method methods[] = {SP_SIGNAL_CHEBYSHEV, SP_SIGNAL_FABER, SP_SIGNAL_DENSE};
    const size_t n = (size_t)sp_network_dofs(net);
    double *sent = calloc(2 * PLACES * n, sizeof *sent), *seen = sent + PLACES * n;
    sp_place from[PLACES], to[PLACES];
    sp_signal_options o = sp_signal_options_default();
    sp_error why = {0};
    o.sources = some_spots(c, net, draw, true, whole(draw, 1, 3), from, sent);
    o.detectors = some_spots(c, net, draw, false, whole(draw, 1, PLACES), to, seen);
    o.from = from;
    o.to = to;
    o.points = POINTS;
    o.tolerance = 1e-3;
    o.until = one_of(draw, 5, lengths) / net->omega_bound;
    for (int k = 0; k < 3 && o.sources > 0 && o.detectors > 0; k++) {
        FREED(sp_signal) s = sp_signal_none();
        o.method = methods[k];
        if (k == 2 && n > 120 && !chance(draw, 0.2))
            continue;
        if (claims_served(c, sp_signal_method_name(o.method), sp_signal_make(net, &o, &s, &why), &why))
            check_pairs(c, net, &o, &s, sent, seen, sp_signal_method_name(o.method));
    }
    free(sent);
}

/* The displacements of all grains, and the signal that is differentiated. */
static void check_field(claims *c, const sp_network *net, sp_random *draw) {
    const int64_t n = sp_network_dofs(net);
    const double t = between(draw, 1, 200) / net->omega_bound, w = 1;
    const sp_functional f = {.n = 1, .t = &t, .weight = &w};
    sp_field_options o = {.source = SP_SOURCE_IMPULSE, .times = 1, .t = &t, .threads = 1};
    sp_sensitivity_options so = sp_sensitivity_options_default();
    FREED(sp_gradient) g = sp_gradient_none();
    double *u = calloc((size_t)(3 * n), sizeof *u), *sent = u + n, *seen = sent + n, error = 0;
    sp_error why = {0};
    assert_ok(sp_network_source(net, SP_SOURCE_IMPULSE, sent, &err));
    assert_ok(sp_network_detector(net, seen, &err));
    motion m = motion_begin(net, NULL, sent, true);
    motion_advance(&m, t);
    if (claims_served(c, "field", sp_signal_field(net, &o, u, &error, &why), &why))
        for (int64_t k = 0; k < n; k++)
            claims_check(c, "field", fabs(u[k] - (double)(m.y[k] / sqrtl((extended)net->mass[k]))), error);
    if (claims_served(c, "value", sp_sensitivity_signal(net, &so, 1, &f, &g, &why), &why))
        claims_check(c, "value", fabs(g.value - (double)motion_seen(&m, net, seen, NULL)), g.error);
    motion_end(&m);
    free(u);
}

/* ---- derivatives ------------------------------------------------------------------------------------------------ */

static double *directions(const sp_network *net, sp_random *draw) {
    double *by = calloc(2 * (size_t)net->n_springs + 1, sizeof *by);
    for (int32_t k = 0; k < 2 * net->n_springs; k++)
        by[k] = between(draw, -1, 1);
    return by;
}

/* The change of F by all springs at once, over 2 h; its error by those of the two signals. */
static bool difference(const sp_network *net, const sp_sensitivity_options *o, const sp_functional *f, const double *by,
                       double h, double *out, double *error) {
    sp_network at = *net;
    sp_gradient g[2] = {sp_gradient_none(), sp_gradient_none()};
    sp_error why = {0};
    bool good = true;
    at.springs = calloc((size_t)net->n_springs + 1, sizeof *at.springs);
    for (int side = 0; side < 2; side++) {
        for (int32_t k = 0; k < net->n_springs; k++) {
            at.springs[k] = net->springs[k];
            at.springs[k].kn *= 1 + (side ? h : -h) * by[2 * k];
            at.springs[k].kt *= 1 + (side ? h : -h) * by[2 * k + 1];
        }
        assert_ok(sp_network_find_bounds(&at, &err));
        good = good && sp_sensitivity_signal(&at, o, 1, f, &g[side], &why) == SP_OK;
    }
    *out = (g[1].value - g[0].value) / (2 * h);
    *error = (g[1].error + g[0].error) / (2 * h);
    free(at.springs);
    sp_gradient_free(&g[0]);
    sp_gradient_free(&g[1]);
    return good;
}

/* Differences of two steps: what they disagree by is more than the error of the smaller one. */
static void check_derivatives(claims *c, const sp_network *net, sp_random *draw) {
    const double t = between(draw, 1, 20) / net->omega_bound, w = 1;
    const sp_functional f = {.n = 1, .t = &t, .weight = &w};
    sp_sensitivity_options o = sp_sensitivity_options_default();
    FREED(sp_gradient) g = sp_gradient_none();
    sp_error why = {0};
    double *by = directions(net, draw), sum = 0, slack = 0, one, two, e1, e2;
    const sp_place from = scene_spot(net, draw), to = scene_spot(net, draw);
    o.from = &from;
    o.to = &to;
    if (!net->prestress && claims_served(c, "derivatives", sp_sensitivity_signal(net, &o, 1, &f, &g, &why), &why) &&
        difference(net, &o, &f, by, 1e-3, &one, &e1) && difference(net, &o, &f, by, 5e-4, &two, &e2)) {
        for (int32_t k = 0; k < net->n_springs; k++) {
            sum += by[2 * k] * net->springs[k].kn * g.kn.d[k];
            slack += fabs(by[2 * k]) * net->springs[k].kn * g.kn.error[k];
            if (g.kt.n > 0) {
                sum += by[2 * k + 1] * net->springs[k].kt * g.kt.d[k];
                slack += fabs(by[2 * k + 1]) * net->springs[k].kt * g.kt.error[k];
            }
        }
        /* the smaller step has a third of the disagreement, the extrapolation much less */
        claims_check(c, "derivatives by differences", fabs(sum - (4 * two - one) / 3),
                     slack + 2 * (e1 + e2) + 0.01 * fabs(two - one));
    }
    free(by);
}

/* ---- chains ----------------------------------------------------------------------------------------------------- */

/* Number of eigenvalues of a tridiagonal A below x: negative pivots. */
static int below(int n, const extended *k, extended x) {
    int count = 0;
    extended pivot = 1;
    for (int a = 0; a < n; a++) {
        const extended side = a ? k[a * n + a - 1] : 0;
        pivot = k[a * n + a] - x - (a ? side * side / pivot : 0);
        pivot = pivot == 0 ? 1e-300L : pivot;
        count += pivot < 0;
    }
    return count;
}

/* A chain of the network lists its balls from one wall to the other, where no contact closes it to a ring. */
static bool tridiagonal(int n, const extended *k) {
    bool only = true;
    for (int a = 0; a < n; a++)
        for (int b = 0; b < n; b++)
            only = only && (abs(a - b) < 2 || k[a * n + b] == 0);
    return only;
}

static void check_chain(claims *c, const sp_network *net) {
    const int n = (int)sp_network_dofs(net);
    sp_modes_options o = sp_modes_options_default();
    FREED(sp_modes) m = sp_modes_none();
    sp_error why = {0};
    RELEASED extended *k = motion_matrix(net);
    if (tridiagonal(n, k) && claims_served(c, "modes of a chain", sp_modes_dense(net, &o, &m, &why), &why))
        for (int64_t q = 0; q < n && m.n - m.n_rattler == n; q++) {
            const extended w = m.omega[m.n_rattler + q], e = m.error[m.n_rattler + q];
            const extended low = w - e, high = w + e, slack = 40 * LDBL_EPSILON * net->omega_bound * net->omega_bound;
            claims_true(c, "modes of a chain",
                        (low <= 0 || below(n, k, low * low - slack) <= q) && below(n, k, high * high + slack) > q);
        }
}

/* ---- spectra ---------------------------------------------------------------------------------------------------- */

/* From wall to wall and back: the same spectrum, where source and detector have changed their places. */
static void check_back(claims *c, const scene *s, const sp_network *net) {
    FREED(sp_packing) turned = mirrored(&s->p, s->p.dim - 1);
    FREED(sp_network) back = sp_network_none();
    sp_transmission_options o = sp_transmission_options_default();
    FREED(sp_transmission) one = {0}, two = {0};
    sp_error why = {0};
    o.points = 20;
    assert_ok(sp_network_make(&turned, &s->how, &back, &err));
    back.omega_bound = net->omega_bound; /* the same lines */
    if (!net->carried && s->p.cell != SP_CELL_PERIODIC &&
        claims_served(c, "transmission", sp_transmission_make(net, &o, &one, &why), &why) &&
        claims_served(c, "transmission", sp_transmission_make(&back, &o, &two, &why), &why))
        for (int k = 0; k < one.n; k++) {
            claims_check(c, "transmission there and back", fabs(one.re[k] - two.re[k]), one.error[k] + two.error[k]);
            claims_check(c, "transmission there and back", fabs(one.im[k] - two.im[k]), one.error[k] + two.error[k]);
        }
}

/* ---- scenes ----------------------------------------------------------------------------------------------------- */

/* Many degrees of freedom in half of the scenes. */
static scene some_scene(sp_random *draw) {
    static const int few[4] = {0, 12, 5, 3}, many[4] = {0, 60, 12, 5};
    return chance(draw, 0.5) ? scene_draw_of(draw, 12, few) : scene_draw_of(draw, 110, many);
}

static void run(claims *c, sp_random *draw) {
    scene s = some_scene(draw);
    FREED(sp_network) net = sp_network_none();
    sp_error why = {0};
    c->words = s.words;
    if (sp_packing_check(&s.p, &why) == SP_OK &&
        claims_served(c, "network", sp_network_make(&s.p, &s.how, &net, &why), &why)) {
        check_signals(c, &net, draw);
        check_derivatives(c, &net, draw);
        check_back(c, &s, &net);
        if (net.dim == 1)
            check_chain(c, &net);
    }
    sp_packing_free(&s.p);
}

TEST(test_waves) {
    claims c = {0};
    claims_scenes(&c, SCENES, run);
    claims_close(&c);
}

/* A column of smooth grains under load, rhombs one upon the other, which buckles to one side. It is as good as
 * symmetric: the pulse hardly pushes it aside, and nothing of that shows in the motion, but rounding errors grow. */
static void buckle(claims *c, sp_random *draw) {
    const int rhombs = whole(draw, 2, 6), n = 3 * rhombs + 1;
    const double aside = pow(10, between(draw, -14, -6)), apart = between(draw, 0.9, 0.97), half = sqrt(0.75) * apart;
    scene s = {.p = sp_packing_none(), .how = sp_network_options_default()};
    FREED(sp_network) net = sp_network_none();
    sp_error why = {0};
    assert_ok(sp_packing_alloc(&s.p, 2, n, 0, &err));
    s.p.box[0] = 4;
    s.p.box[1] = 2 * half * rhombs + apart;
    s.p.box[2] = 1;
    for (int i = 0; i < n; i++) {
        const double across = i % 3 == 0 ? 0 : i % 3 == 1 ? -0.5 : 0.5;
        s.p.x[3 * i] = 2 + across * apart + aside * between(draw, -1, 1);
        s.p.x[3 * i + 1] = 0.5 * apart + half * (2 * (i / 3) + (i % 3 > 0));
        s.p.r[i] = 0.5;
    }
    add_contacts(&s.p);
    s.p.gravity = 1e-9; /* two contacts hold a grain */
    s.how.prestress = true;
    snprintf(s.words, sizeof s.words, "a column of %d, %g aside, %g apart", n, aside, apart);
    c->words = s.words;
    const sp_status status = sp_network_make(&s.p, &s.how, &net, &why);
    if (claims_served(c, "network", status, &why))
        for (int k = 0; k < 4; k++) {
            check_signals(c, &net, draw);
            check_field(c, &net, draw);
        }
    sp_packing_free(&s.p);
}

TEST(test_columns) {
    claims c = {0};
    claims_scenes(&c, SCENES, buckle);
    claims_close(&c);
}

RUN_TESTS(NULL, NULL)
